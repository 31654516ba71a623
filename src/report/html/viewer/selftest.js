// What the page says about itself to a test: every control is used once, and what came of it is written down.

/** Share of the canvas that is covered, and the mean colour there. */
function look(view) {
  view.render();
  const gl = view.gl.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
  const bytes = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let covered = 0, failing = 0, hatched = 0, inked = 0;
  const fails = (i) => bytes[i] > 1.8 * bytes[i + 1] && bytes[i] > 60;
  const sum = [0, 0, 0];
  for (let i = 0; i < bytes.length; i += 4) {
    if (bytes[i + 3] === 0) continue;
    covered++;
    for (let c = 0; c < 3; c++) sum[c] += bytes[i + c];
    if (bytes[i] + bytes[i + 1] + bytes[i + 2] < 120) inked++;
    if (!fails(i)) continue;
    failing++;
    // The next pixel is of the same colour and clearly darker: a line of the hatching begins.
    if (fails(i + 4) && bytes[i + 4] < 0.75 * bytes[i]) hatched++;
  }
  return { covered: covered / (w * h), colour: sum.map((s) => Math.round((1000 * s) / Math.max(1, covered)) / 1000), failing, hatched, inked };
}

/** The least distance between two pins that show their numbers, CSS pixels; null for fewer than two. */
function nearest(view) {
  const shown = view.pins.map((p) => p.b).filter((b) => b.style.display === "" && !b.classList.contains("dot"));
  const places = shown.map((b) => b.style.transform.match(/-?[\d.]+(?=px)/g).map(Number));
  const pairs = places.flatMap((p, i) => places.slice(0, i).map((q) => Math.hypot(p[0] - q[0], p[1] - q[1])));
  return pairs.length ? Math.min(...pairs) : null;
}

/** Uses map switch, cut, flight, keys, hash and theme; leaves the view as it was. */
export function selfTest(view) {
  const key = (name) => view.canvas.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true }));
  const out = { triangles: view.model.indices.length / 3, renderer: view.renderer, findings: view.findings.length };
  const begun = view.map;
  view.home();
  out.home = look(view);
  out.maps = view.model.maps.map((m, i) => {
    view.choose(i);
    let min = Infinity, max = -Infinity;
    for (const v of m.values) if (v === v) { min = Math.min(min, v); max = Math.max(max, v); }
    return { check: m.check, title: m.title, legend: view.host.querySelector(".legend b").textContent, min, max, ...look(view) };
  });
  key("1");
  out.keyMap = view.map;
  out.cuts = [0, 1, 2].map((axis) => { view.panel.set(axis); return { strips: view.sectioned, ...look(view) }; });
  view.panel.set(-1);
  key("x");
  out.keyCut = view.cut.axis;
  key("x");
  out.uncut = view.cut.axis;
  out.layers = [...view.host.querySelectorAll(".layers input")].map((box) => {
    const colour = look(view).colour;
    box.click();
    const changed = look(view).colour.some((c, i) => c !== colour[i]);
    box.click();
    return changed;
  });
  const before = view.camera.position.clone();
  key("ArrowLeft");
  out.turned = before.distanceTo(view.camera.position) > 1e-6;
  const zoom = view.camera.zoom;
  key("+");
  out.zoomed = view.camera.zoom > zoom;
  if (view.findings.length) {
    key("n");
    out.flight = view.gliding ? { to: view.gliding.target.toArray() } : { to: view.controls.target.toArray() };
    view.gliding = null;
    out.opened = view.cut.axis >= 0;
    view.panel.place(-1);
    view.opened = false;
    out.hash = location.hash;
    const f = view.findings[view.current];
    out.asked = view.posed(f.at_mm);
    out.marked = document.querySelectorAll(".finding.current").length;
  }
  key("h");
  const c = view.canvas.getBoundingClientRect();
  const hit = view.read(c.left + c.width / 2, c.top + c.height / 2);
  out.read = hit ? view.host.querySelector(".value").textContent : null;
  out.pins = view.pins.length;
  out.faded = view.pins.filter((p) => p.b.classList.contains("hidden")).length;
  view.render();
  out.apart = nearest(view);
  const theme = document.documentElement.dataset.theme;
  document.getElementById("theme").click();
  out.theme = document.documentElement.dataset.theme;
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  view.choose(begun);
  view.home();
  view.render();
  history.replaceState(null, "", "#selftest");
  return out;
}
