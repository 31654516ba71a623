// What stands over the view: cut, scale bar, the value that was clicked, the legend.

import { addLayers } from "./layers.js";

const sign = (unit) => ({ deg: "°", mm2: " mm²", mm3: " mm³", 1: "" })[unit] ?? " " + unit;
/** Whether nothing lies beyond the scale's end: an angle of a downward surface has no more than 90°. */
const closed = (map) => map.unit === "deg" && map.high >= 90;
/** A number at the digits that the report tells; what lies in the middle goes away from zero. */
const short = (x) => {
  const far = Math.abs(x), scale = far >= 1000 ? 10 : far >= 100 ? 100 : far >= 10 ? 1000 : 1e4;
  return String((Math.sign(x) * Math.round(far * scale)) / scale);
};

function element(tag, parts = {}, ...children) {
  const e = Object.assign(document.createElement(tag), parts);
  e.append(...children);
  return e;
}

/** The controls of the cut, the scale bar and the place where values are said. */
export function makePanel(view) {
  const buttons = ["x", "y", "z"].map((name, axis) =>
    element("button", { type: "button", textContent: name.toUpperCase(), ariaPressed: "false" }));
  const slider = element("input", { type: "range", min: 0, max: 1000, value: 500, ariaLabel: "Place of the cut", disabled: true });
  const set = (axis) => {
    buttons.forEach((b, i) => { b.ariaPressed = String(i === axis); });
    slider.disabled = axis < 0;
    open.hidden = axis < 0 || view.capped;
    view.setCut(axis, slider.value / 1000);
    view.settle();
  };
  const toggle = (axis) => set(view.cut.axis === axis ? -1 : axis);
  buttons.forEach((b, i) => b.addEventListener("click", () => toggle(i)));
  slider.addEventListener("input", () => view.setCut(view.cut.axis, slider.value / 1000));
  slider.addEventListener("change", () => view.settle());
  const home = element("button", { type: "button", textContent: "Home" });
  home.addEventListener("click", () => { view.home(); view.draw(); });
  const label = element("span", { textContent: "Cut" });
  const open = element("span", { className: "open", textContent: "open mesh: no cap" });
  open.hidden = true;
  const group = element("div", { className: "cut", role: "group", ariaLabel: "Cut" }, label, ...buttons, slider, open, home);
  const bar = element("div", { className: "scale" }, element("span"), element("i"));
  const value = element("p", { className: "value", role: "status" });
  value.textContent = "Click the part to read a value.";
  const layers = element("div", { className: "layers", role: "group", ariaLabel: "Layers" });
  layers.hidden = view.model.layers.length === 0;
  addLayers(view, layers);
  view.host.append(group, layers, bar, value);
  return {
    set,
    toggle,
    /** Sets the cut and its controls; a negative axis takes it away. */
    place(axis, at) {
      if (axis >= 0) slider.value = Math.round(1000 * at);
      set(axis);
    },
    /** Sets the scale bar for so many pixels a millimetre. */
    scale(pixels) {
      const room = 130 / pixels, decade = 10 ** Math.floor(Math.log10(room));
      const length = [5, 2, 1].map((k) => k * decade).find((l) => l <= room) ?? decade;
      bar.firstChild.textContent = short(length) + " mm";
      bar.lastChild.style.width = length * pixels + "px";
    },
    /** Says what stands at a place of the surface. */
    say(hit, map) {
      if (!hit) { value.textContent = "Click the part to read a value."; return; }
      const at = view.unposed(hit.place).map((x) => short(Math.round(x * 100) / 100)).join(", ");
      const v = map ? hit.corners.reduce((s, c, i) => s + map.values[c] * hit.weights[i], 0) : NaN;
      if (!(v === v)) { value.textContent = `${map ? map.title : "Surface"}: not measured here · ${at} mm`; return; }
      const step = (map.high - map.low) / 65534;
      const beyond = !closed(map) && v >= map.high - step ? "≥ " : "";
      const around = hit.corners.map((c) => map.values[c]), low = Math.min(...around) - step / 2, high = Math.max(...around) + step / 2;
      const digits = (x) => short(Math.round(x * 1e3) / 1e3);
      const range = beyond && low >= map.high - 2 * step ? "" : digits(low) === digits(high) ? "" : ` (${digits(Math.max(low, map.low))}–${digits(high)} on this piece)`;
      const f = view.findings.find((f) => f.check === map.check &&
        view.unposed(hit.place).every((x, a) => x >= f.box_mm[0][a] - 0.05 && x <= f.box_mm[1][a] + 0.05));
      const found = f ? ` · in finding ${view.findings.indexOf(f) + 1}: ${short(f.value)} (${short(f.low)}–${short(f.high)})` : "";
      value.textContent = `${map.title} ${beyond}${digits(v)}${sign(map.unit)}${range}${found} · at ${at} mm`;
      value.title = `Read between the corners of the display copy, whose steps are ${step.toPrecision(1)}${sign(map.unit)}; findings are measured on the part`;
    },
  };
}

/** The legend of a map: name and unit, hard steps, a tick at each limit, an open end. */
export function makeLegend(view) {
  const box = element("div", { className: "legend" });
  view.host.append(box);
  return (map) => {
    box.replaceChildren();
    box.hidden = !map;
    if (!map) return;
    const across = (v) => Math.min(100, Math.max(0, (100 * (v - map.low)) / (map.high - map.low)));
    const relation = map.sense === "max" ? "≤" : "≥";
    const limits = [["must", map.fail], ["should", map.warn]].filter(([, l]) => l != null).sort((a, b) => a[1] - b[1]);
    const stops = gradient(map, across).map(([c, at]) => `${c} ${at}%`).join(",");
    const bar = element("div", { className: "bar" });
    bar.style.background = `linear-gradient(90deg,${stops})`;
    if (map.fail != null) {
      const hatch = element("u");
      const at = across(map.fail);
      Object.assign(hatch.style, map.sense === "max" ? { left: at + "%", right: 0 } : { left: 0, width: at + "%" });
      bar.append(hatch);
    }
    for (const [, l] of limits) {
      const tick = element("i");
      tick.style.left = across(l) + "%";
      bar.append(tick);
    }
    const words = limits.map(([word, l]) => `${word} ${relation} ${short(l)}${sign(map.unit)}`).join("   ");
    box.append(element("b", { textContent: map.title + (sign(map.unit) ? ` (${sign(map.unit).trim()})` : "") }),
      element("span", { className: "words", textContent: words }), bar,
      element("span", { className: "ends" }, element("span", { textContent: short(map.low) }), element("span", { textContent: (closed(map) ? "" : "≥ ") + short(map.high) })));
  };
}

/** Colours and places of the bar, from low to high. */
function gradient(map, across) {
  const FAIL = ["#8c082c", "#ba1a2a", "#de4a1e", "#f07c24"], WARN = ["#f7c434", "#fbe074"], GOOD = ["#acc0cf", "#dee7ed"];
  const max = map.sense === "max";
  const cuts = [map.fail, map.warn].filter((l) => l != null).map(across).sort((a, b) => a - b);
  const kinds = [];
  if (map.fail != null) kinds.push(FAIL);
  if (map.warn != null) kinds.push(WARN);
  kinds.push(GOOD);
  if (max) kinds.reverse();
  const ends = [0, ...cuts, 100];
  return kinds.flatMap((colours, i) => {
    const row = max ? [...colours].reverse() : colours;
    return row.map((c, k) => [c, ends[i] + ((ends[i + 1] - ends[i]) * k) / (row.length - 1)]);
  });
}
