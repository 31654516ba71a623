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
