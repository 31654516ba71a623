"use strict";
// Opens pages one after the other in a frame, lets each test itself, and writes down what was seen.
(async () => {
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const { names, axe, modes } = read("asked");
  const seen = {};
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const frame = async (address, sandbox) => {
    const f = document.createElement("iframe");
    f.width = 1320;
    f.height = 1000;
    if (sandbox) f.setAttribute("sandbox", "allow-same-origin");
    const loaded = new Promise((done) => f.addEventListener("load", done));
    f.src = address;
    document.body.append(f);
    await loaded;
    return f;
  };
  const root = (f) => f.contentDocument.documentElement;

  /** The rules of axe over the page as it stands, every fold open. */
  const judge = async (f, theme) => {
    const d = f.contentDocument;
    root(f).dataset.theme = theme;
    d.querySelectorAll("details").forEach((e) => { e.open = true; });
    if (!f.contentWindow.axe) {
      const s = d.createElement("script");
      s.textContent = axe;
      d.head.append(s);
    }
    const r = await f.contentWindow.axe.run(d, { resultTypes: ["violations"] });
    const said = (v) => `${theme}: ${v.id}, ${v.nodes.length} times, first ${v.nodes[0].html.slice(0, 200)}`;
    return { violations: r.violations.map(said), passes: r.passes.length };
  };

  /** Fingers on the view: one that moves turns the part, two that draw apart bring it nearer. */
  const touch = async (f) => {
    const { contentWindow: w, contentDocument: d } = f;
    const canvas = d.querySelector("#viewer canvas");
    // A finger that no screen felt cannot be captured.
    canvas.setPointerCapture = canvas.releasePointerCapture = () => {};
    const c = canvas.getBoundingClientRect();
    const finger = (type, id, dx, dy) => canvas.dispatchEvent(new w.PointerEvent(type, {
      pointerId: id, pointerType: "touch", isPrimary: id === 71, bubbles: true, cancelable: true, button: 0,
      buttons: type === "pointerup" ? 0 : 1, clientX: c.left + c.width / 2 + dx, clientY: c.top + c.height / 2 + dy,
    }));
    const pins = () => [...d.querySelectorAll(".pins .pin")].map((p) => p.style.transform).join();
    const pixels = () => parseFloat(d.querySelector(".scale i").style.width) / parseFloat(d.querySelector(".scale span").textContent);
    const first = [pins(), pixels()];
    finger("pointerdown", 71, 0, 0);
    for (let i = 1; i <= 6; i++) finger("pointermove", 71, 20 * i, 5 * i);
    finger("pointerup", 71, 120, 30);
    await wait(300);
    const turned = [pins(), pixels()];
    finger("pointerdown", 71, -30, 0);
    finger("pointerdown", 72, 30, 0);
    for (let i = 1; i <= 6; i++) { finger("pointermove", 71, -30 - 10 * i, 0); finger("pointermove", 72, 30 + 10 * i, 0); }
    finger("pointerup", 71, -90, 0);
    finger("pointerup", 72, 90, 0);
    await wait(300);
    return { turned: turned[0] !== first[0], kept: turned[1] / first[1], nearer: pixels() / turned[1] };
  };

  const look = async (name) => {
    const out = {};
    const f = await frame(name + "#selftest");
    for (let i = 0; i < 600 && !root(f).dataset.ready; i++) await wait(50);
    out.ready = root(f).dataset.ready ?? null;
    out.note = f.contentDocument.getElementById("viewer-note")?.textContent ?? "";
    out.itself = JSON.parse(f.contentDocument.getElementById("selftest")?.textContent ?? "null");
    out.fetched = f.contentWindow.performance.getEntriesByType("resource").map((e) => e.name).filter((n) => !/^(file|data|blob):/.test(n));
    const link = f.contentDocument.querySelector("[data-finding]")?.id;
    if (modes.includes("touch")) out.touch = await touch(f);
    if (axe) out.axe = [await judge(f, "light"), await judge(f, "dark")];
    f.remove();
    if (modes.includes("link") && link) {
      const g = await frame(name + "#" + link);
      for (let i = 0; i < 600 && !root(g).dataset.ready; i++) await wait(50);
      out.link = [link, g.contentDocument.querySelector(".finding.current")?.id ?? null];
      g.remove();
    }
    if (modes.includes("scriptless")) {
      const g = await frame(name, true);
      const d = g.contentDocument;
      out.scriptless = {
        ready: root(g).dataset.ready ?? null, findings: d.querySelectorAll("li.finding").length, headline: d.querySelector("h1").textContent,
        pictures: [...d.images].filter((i) => i.complete && i.naturalWidth > 0).length, broken: [...d.images].filter((i) => !i.naturalWidth).length,
        shown: [...d.querySelectorAll(".view")].filter((v) => getComputedStyle(v).display !== "none").length, rows: d.querySelectorAll("table.checks tbody tr").length,
      };
      g.remove();
    }
    return out;
  };

  for (const name of names) {
    try { seen[name] = await look(name); } catch (e) { seen[name] = { broken: String(e?.stack ?? e) }; }
  }
  const pre = document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  document.body.append(pre);
})();
