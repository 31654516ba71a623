// Numbered pins over the view, and the mark on the finding that was chosen.
import { Vector3 } from "three";

/** A button for each finding, at most 40; the page's list has the others. */
export function makePins(view) {
  const box = document.createElement("div");
  box.className = "pins";
  view.host.append(box);
  return view.findings.slice(0, 40).map((f, i) => {
    const b = document.createElement("button");
    b.type = "button";
    b.className = "pin " + (f.accepted ? "accepted" : f.state);
    b.textContent = String(i + 1);
    b.setAttribute("aria-label", `${i + 1}: ${f.check}, ${f.accepted ? "accepted" : f.state}`);
    choosable(b, view, () => view.fly(i));
    box.append(b);
    return { b, f, place: new Vector3(...view.posed(f.at_mm)) };
  });
}

/** Pins nearer to each other than this would cover each other's numbers, CSS pixels. */
const APART = 24;

/** Puts the pins where `at` says, null for those that are not shown; what would cover another is a dot: the chosen one
 * and those in sight keep their numbers, worst first. */
export function placePins(pins, current, at) {
  const whole = [];
  const rank = (i) => (i === current ? 0 : pins[i].b.classList.contains("hidden") ? 2 : 1);
  const ranked = pins.map((_, i) => i).sort((a, b) => rank(a) - rank(b));
  for (const i of ranked) {
    const { b } = pins[i], to = at(pins[i]);
    b.style.display = to ? "" : "none";
    if (!to) continue;
    const near = whole.some((o) => Math.hypot(o[0] - to[0], o[1] - to[1]) < APART);
    if (!near) whole.push(to);
    b.classList.toggle("dot", near);
    b.style.transform = `translate(${to[0]}px,${to[1]}px) translate(-50%,${near ? "-50%" : "calc(-100% - 9px)"})`;
  }
}

/** A press chooses; a drag that begins on the pin turns the part, as beside it. */
function choosable(b, view, choose) {
  let from = null, dragged = false;
  b.addEventListener("pointerdown", (e) => { from = [e.clientX, e.clientY]; dragged = false; });
  b.addEventListener("pointermove", (e) => {
    if (!from || Math.hypot(e.clientX - from[0], e.clientY - from[1]) < 5) return;
    from = null;
    dragged = true;
    const { pointerId, pointerType, isPrimary, clientX, clientY } = e;
    view.canvas.dispatchEvent(new PointerEvent("pointerdown", { pointerId, pointerType, isPrimary, clientX, clientY, button: 0, buttons: 1, cancelable: true }));
  });
  b.addEventListener("pointerup", () => { from = null; });
  b.addEventListener("click", (e) => { if (!dragged || e.detail === 0) choose(); dragged = false; });
}

/** Marks the chosen finding in the list and among the pins, and brings it into the list's window. */
export function mark(view) {
  document.querySelectorAll(".finding.current").forEach((e) => e.classList.remove("current"));
  view.pins.forEach((p, i) => p.b.classList.toggle("current", i === view.current));
  const f = view.findings[view.current];
  const li = f && document.getElementById(f.anchor);
  if (!li) return;
  li.classList.add("current");
  const list = li.parentElement;
  if (list.scrollHeight > list.clientHeight) list.scrollTop = li.offsetTop - list.offsetTop - 8;
}
