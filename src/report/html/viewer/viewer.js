// The 3-D view: a part painted by its maps, a cut, pins. Adds to the page; nothing depends on it.
import {
  BackSide, BufferAttribute, BufferGeometry, EqualStencilFunc, FrontSide, GLSL3, LineSegments, Mesh, OrthographicCamera,
  ReplaceStencilOp, Scene, ShaderMaterial, Sphere, Vector3, Vector4, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { creases } from "./edges.js";
import { collect, direction } from "./findings.js";
import { readGlb } from "./glb.js";
import { FRAGMENT, INK, LINES, VERTEX } from "./shader.js";
import { firstHit } from "./ray.js";
import { makeLegend, makePanel } from "./panel.js";
import { makePins, mark, placePins } from "./pins.js";
import { makeSection } from "./section.js";
import { selfTest } from "./selftest.js";

const SIDES = [[-58, 28], [-122, 28], [32, 28], [148, 28], [-58, -24], [-122, -24], [32, -24], [148, -24]];
const still = matchMedia("(prefers-reduced-motion: reduce)");

/** Starts the view in `host`; `bytes` is a GLB, `report` the report's JSON. Throws where WebGL is missing. */
export function start(host, bytes, report) {
  const model = readGlb(bytes);
  const view = new View(host, model, report);
  view.choose(view.mapOf(view.findings[0]) ?? 0);
  view.home();
  view.fromHash();
  view.draw();
  return view;
}

class View {
  constructor(host, model, report) {
    this.host = host;
    this.model = model;
    this.report = report;
    this.cut = { axis: -1, at: 0.5 };
    // A back face marks material only where the surface is closed.
    this.capped = report.part.watertight;
    this.current = -1;
    this.map = 0;
    this.findings = collect(report);
    this.makeScene();
    this.section = makeSection(this);
    this.pins = makePins(this);
    this.panel = makePanel(this);
    this.legend = makeLegend(this);
    this.listen();
  }

  makeScene() {
    // Software renderers spend most of their time on multisampling: ask first, then choose.
    const probe = document.createElement("canvas").getContext("webgl2");
    if (!probe) throw new Error("WebGL 2 is not available");
    const info = probe.getExtension("WEBGL_debug_renderer_info");
    this.renderer = String(probe.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : probe.RENDERER));
    probe.getExtension("WEBGL_lose_context")?.loseContext();
    const soft = /swiftshader|llvmpipe|basic render/i.test(this.renderer);
    this.gl = new WebGLRenderer({ antialias: !soft, alpha: true, stencil: true });
    this.gl.setPixelRatio(soft ? 1 : Math.min(2, devicePixelRatio));
    this.canvas = this.gl.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-label",
      "3-D view of the part. Arrows turn, plus and minus zoom, n and p go to the next and previous finding, 1 to 9 and 0 choose a map, x, y and z cut, h goes home.");
    this.host.append(this.canvas);
    const g = new BufferGeometry();
    g.setAttribute("position", new BufferAttribute(this.model.positions, 3));
    g.setIndex(new BufferAttribute(this.model.indices, 1));
    g.computeBoundingBox();
    this.box = g.boundingBox;
    this.ball = this.box.getBoundingSphere(new Sphere());
    this.material = new ShaderMaterial({
      glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, side: FrontSide,
      stencilWrite: true, stencilRef: 0, stencilZPass: ReplaceStencilOp,
      uniforms: {
        low: { value: 0 }, high: { value: 1 }, fail: { value: 0 }, warn: { value: 0 }, kind: { value: 0 },
        sense: { value: 1 }, tie: { value: 0 }, plane: { value: new Vector4(0, 0, 0, 0) }, lamp: { value: new Vector3(0, 0, 1) },
        dot_size: { value: this.gl.getPixelRatio() }, capped: { value: this.capped ? 1 : 0 },
      },
    });
    this.scene = new Scene();
    // Where a back face is seen, the cut runs through material: the stencil keeps creases off its cap.
    const back = this.material.clone();
    Object.assign(back, { side: BackSide, stencilRef: 1, defines: { BACK: 1 }, uniforms: this.material.uniforms });
    this.scene.add(new Mesh(g, this.material), new Mesh(g, back));
    if (!this.model.coarse) setTimeout(() => this.makeLines(), 0); // Corners moved onto steps make false creases.
    this.camera = new OrthographicCamera(-1, 1, 1, -1, -1e4, 1e4);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.enableZoom = false;
    this.controls.zoomToCursor = true;
    this.size();
  }

  /** Adds the creases; they come after the first picture, because they take as long as it. */
  makeLines() {
    const g = new BufferGeometry();
    g.setAttribute("position", new BufferAttribute(creases(this.model), 3));
    const material = new ShaderMaterial({
      glslVersion: GLSL3, vertexShader: LINES, fragmentShader: INK, transparent: true,
      stencilWrite: true, stencilRef: 0, stencilFunc: EqualStencilFunc,
      uniforms: { plane: this.material.uniforms.plane },
    });
    this.scene.add(new LineSegments(g, material));
    this.draw();
  }

  /** Fits the canvas to its place on the page. */
  size() {
    const w = Math.max(200, this.host.clientWidth), h = Math.max(200, this.host.clientHeight);
    this.gl.setSize(w, h, false);
    const k = w / h, r = (this.ball.radius * 0.98) / Math.min(1, k);
    Object.assign(this.camera, { left: -r * k, right: r * k, top: r, bottom: -r });
    this.camera.near = -20 * this.ball.radius;
    this.camera.far = 40 * this.ball.radius;
    this.camera.updateProjectionMatrix();
  }

  listen() {
    this.controls.addEventListener("change", () => this.draw());
    this.controls.addEventListener("start", () => { this.fitted = null; });
    this.controls.addEventListener("end", () => this.settle());
    this.canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    this.canvas.addEventListener("blur", () => { this.controls.enableZoom = false; });
    this.host.addEventListener("keydown", (e) => { if (!/range|checkbox/.test(e.target.type)) this.key(e); });
    // Next and previous work wherever nothing else waits for letters.
    document.addEventListener("keydown", (e) => {
      const idle = !this.host.contains(e.target) && !/^(INPUT|TEXTAREA|SELECT)$/.test(e.target.tagName);
      if (idle && (e.key === "n" || e.key === "p")) this.key(e);
    });
    document.querySelectorAll("[data-step]").forEach((b) => b.addEventListener("click", () => this.step(+b.dataset.step)));
    let down = null;
    this.canvas.addEventListener("pointerdown", (e) => { down = [e.clientX, e.clientY]; this.canvas.focus({ preventScroll: true }); });
    this.canvas.addEventListener("pointerup", (e) => {
      if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < 4) this.read(e.clientX, e.clientY);
    });
    // A canvas that changes its size is cleared: what is drawn at the next frame comes too late for this one.
    new ResizeObserver(() => { this.size(); if (this.fitted) this.fit(this.fitted); this.render(); }).observe(this.host);
    document.documentElement.addEventListener("theme", () => this.draw());
    addEventListener("hashchange", () => this.fromHash());
    document.querySelectorAll("input.choice").forEach((input, i) => {
      input.addEventListener("change", () => { if (input.checked) this.choose(i); });
    });
    document.querySelectorAll("a.pinned, td a.pin").forEach((a) => {
      a.addEventListener("click", (e) => {
        const at = this.findings.findIndex((f) => "#" + f.anchor === a.getAttribute("href"));
        if (at < 0) return;
        e.preventDefault();
        this.fly(at);
      });
    });
  }

  key(e) {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const turn = (a, b) => this.turn(a, b);
    const does = {
      ArrowLeft: () => turn(-10, 0), ArrowRight: () => turn(10, 0), ArrowUp: () => turn(0, 10), ArrowDown: () => turn(0, -10),
      "+": () => this.zoom(1.2), "=": () => this.zoom(1.2), "-": () => this.zoom(1 / 1.2),
      n: () => this.step(1), p: () => this.step(-1),
      x: () => this.panel.toggle(0), y: () => this.panel.toggle(1), z: () => this.panel.toggle(2),
      h: () => { this.home(); this.draw(); },
    }[e.key];
    const digit = /^[0-9]$/.test(e.key) ? (+e.key + 9) % 10 : -1;
    if (this.model.maps[digit]) this.choose(digit);
    else if (does && (this.findings.length || !/[np]/.test(e.key))) does();
    else return;
    e.preventDefault();
  }

  /** Goes on to the next finding or back to the one before. */
  step(by) {
    const n = this.findings.length;
    if (n) this.fly(((this.current < 0 && by < 0 ? 0 : this.current) + by + n) % n);
  }

  turn(azimuth, elevation) {
    this.fitted = null;
    const d = this.camera.position.clone().sub(this.controls.target);
    const r = d.length(), a = Math.atan2(d.y, d.x) + (azimuth * Math.PI) / 180;
    const e = Math.min(1.55, Math.max(-1.55, Math.asin(d.z / r) + (elevation * Math.PI) / 180));
    this.look(this.controls.target, direction((a * 180) / Math.PI, (e * 180) / Math.PI), this.camera.zoom);
    this.draw();
    this.settle();
  }

  zoom(by) {
    this.fitted = null;
    this.camera.zoom *= by;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Looks at a point from a direction. */
  look(target, from, zoom) {
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(from, 4 * this.ball.radius);
    this.camera.zoom = zoom;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(target);
    this.camera.updateMatrixWorld();
    this.controls.update();
  }

  home() {
    this.current = -1;
    mark(this);
    const best = this.findings[0] && new Vector3(...this.posed(this.findings[0].at_mm));
    const shows = (side) => !best || !this.hidden(best, direction(...side), this.findings[0]);
    this.fit(direction(...(SIDES.find(shows) ?? SIDES[0])));
    this.settle();
  }

  /** Looks from a direction so that the part fills the view, with room for what stands over it, until somebody looks elsewhere. */
  fit(from) {
    this.fitted = from;
    this.look(this.ball.center, from, 1);
    const c = this.camera, p = this.model.positions, m = c.matrixWorldInverse.elements;
    let [l, r, b, t] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let i = 0; i < p.length; i += 3) {
      const x = m[0] * p[i] + m[4] * p[i + 1] + m[8] * p[i + 2] + m[12];
      const y = m[1] * p[i] + m[5] * p[i + 1] + m[9] * p[i + 2] + m[13];
      l = Math.min(l, x); r = Math.max(r, x); b = Math.min(b, y); t = Math.max(t, y);
    }
    if (!(r > l && t > b)) return;
    // What stands over the view takes 58 pixels above and, beside the legend, 40 below.
    const h = Math.max(1, this.canvas.clientHeight), above = Math.min(0.3, 58 / h), below = Math.min(0.3, 40 / h);
    const zoom = Math.min((1.86 * c.right) / (r - l), (2 * c.top * (1 - above - below)) / (t - b));
    const right = new Vector3().setFromMatrixColumn(c.matrixWorld, 0), up = new Vector3().setFromMatrixColumn(c.matrixWorld, 1);
    const shift = (c.top * (above - below)) / zoom;
    const target = this.ball.center.clone().addScaledVector(right, (l + r) / 2).addScaledVector(up, (b + t) / 2 + shift);
    this.look(target, from, zoom);
  }

  /** The map of a finding's check. */
  mapOf(finding) {
    const at = finding ? this.model.maps.findIndex((m) => m.check === finding.check) : -1;
    return at < 0 ? undefined : at;
  }

  /** Paints another map. */
  choose(at) {
    const map = this.model.maps[at];
    this.map = at;
    const u = this.material.uniforms, g = this.scene.children[0].geometry;
    if (map) {
      g.setAttribute("value", new BufferAttribute(map.values, 1));
      u.low.value = map.low;
      u.high.value = map.high;
      u.fail.value = map.fail ?? 0;
      u.warn.value = map.warn ?? 0;
      u.kind.value = (map.fail == null ? 0 : 1) + (map.warn == null ? 0 : 2);
      u.sense.value = map.sense === "max" ? -1 : 1;
      u.tie.value = (0.75 * (map.high - map.low)) / 65534; // Equal to a limit, but for the copy's own step, is good.
    } else {
      g.setAttribute("value", new BufferAttribute(new Float32Array(this.model.positions.length / 3).fill(NaN), 1));
    }
    const input = document.querySelectorAll("input.choice")[at];
    if (input) input.checked = true;
    this.legend?.(map);
    this.section?.update();
    this.draw();
  }

  /** Moves the cut; the half towards the eye is taken away. */
  setCut(axis, at) {
    this.cut = { axis, at };
    const plane = this.material.uniforms.plane.value;
    if (axis < 0) plane.set(0, 0, 0, 0);
    else {
      const lo = this.box.min.getComponent(axis), hi = this.box.max.getComponent(axis);
      const d = this.camera.position.clone().sub(this.controls.target).getComponent(axis) >= 0 ? 1 : -1;
      const n = [0, 0, 0];
      n[axis] = d;
      plane.set(n[0], n[1], n[2], -d * (lo + (hi - lo) * at));
    }
    this.section.update();
    this.draw();
  }

  /** Whether the cut takes a place away, by more than `by`. */
  cutAway(x, y, z, by = 1e-6) {
    const p = this.material.uniforms.plane.value;
    return p.x * x + p.y * y + p.z * z + p.w > by;
  }

  /** Flies to a finding, from a side that shows it. */
  fly(at) {
    const f = this.findings[at];
    if (!f) return;
    this.current = at;
    const own = this.mapOf(f);
    if (own !== undefined && own !== this.map) this.choose(own);
    const target = new Vector3(...this.posed(f.at_mm));
    const now = this.camera.position.clone().sub(this.controls.target).normalize();
    const sides = [now, ...SIDES.map((s) => direction(...s))];
    if (this.opened) this.panel.place(-1); // The last finding's own cut goes with it.
    this.opened = false;
    const seen = sides.findIndex((d) => !this.hidden(target, d, f));
    const from = sides[Math.max(0, seen)];
    if (seen < 0) this.open(target, from, f);
    const span = Math.max(...[0, 1, 2].map((a) => f.box_mm[1][a] - f.box_mm[0][a]), 0.12 * this.ball.radius);
    const zoom = Math.min(12, Math.max(1.1, (1.1 * this.ball.radius) / span));
    mark(this);
    history.replaceState(null, "", "#" + f.anchor);
    this.show(still.matches ? "auto" : "smooth");
    this.glide(target, from, zoom);
  }

  /** Cuts through a place that no side shows, but not across the thin direction: that would show a cap or a gap alone. */
  open(target, from, f) {
    const { box_mm: box, witness: w } = f, sides = [0, 1, 2].map((a) => box[1][a] - box[0][a]);
    // The contacts of a medial ball tell the thin direction; a box tells it where its sides differ.
    const ends = w && w.points_mm.length >= 2 ? w.points_mm.slice(-2).map((p) => this.posed(p)) : null;
    const across = ends ? [0, 1, 2].map((a) => Math.abs(ends[1][a] - ends[0][a])) : sides.map((s) => (s === Math.min(...sides) ? 1 : 0));
    const most = Math.max(...across) || 1;
    const lean = (a) => Math.abs(from.getComponent(a)) - (1.5 * across[a]) / most;
    const axis = [0, 1, 2].reduce((a, b) => (lean(b) > lean(a) ? b : a));
    const lo = this.box.min.getComponent(axis), hi = this.box.max.getComponent(axis);
    this.panel.place(axis, (target.getComponent(axis) - lo) / (hi - lo));
    this.opened = true;
  }

  glide(target, from, zoom) {
    this.fitted = null;
    const t0 = this.controls.target.clone(), z0 = this.camera.zoom;
    const d0 = this.camera.position.clone().sub(t0).normalize();
    const begun = performance.now(), length = still.matches ? 0 : 420;
    this.gliding = { target, from, zoom };
    const step = (now) => {
      if (this.gliding?.target !== target) return;
      const t = length ? Math.min(1, (now - begun) / length) : 1, s = t * t * (3 - 2 * t);
      const d = d0.clone().lerp(from, s);
      if (d.length() < 1e-3) d.copy(from);
      this.look(t0.clone().lerp(target, s), d.normalize(), z0 * Math.pow(zoom / z0, s));
      this.draw();
      if (t < 1) requestAnimationFrame(step);
      else { this.gliding = null; this.settle(); }
    };
    if (length) requestAnimationFrame(step);
    else step(begun);
  }

  /** Goes to the finding that the address names. */
  fromHash() {
    const at = this.findings.findIndex((f) => "#" + f.anchor === location.hash);
    if (at < 0 || at === this.current) return;
    this.fly(at);
    setTimeout(() => this.show("auto"), 60); // After the browser's own way to the anchor.
  }

  /** Brings the view onto the screen. */
  show(behavior) {
    this.host.scrollIntoView({ block: "nearest", behavior });
  }

  /** A place of the file in the frame of the build. */
  posed(p) {
    return this.report.part.pose.slice(0, 3).map((r) => r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
  }

  /** A place of the build in the frame of the file. */
  unposed(q) {
    const m = this.report.part.pose, d = [0, 1, 2].map((r) => q[r] - m[r][3]);
    return [0, 1, 2].map((c) => m[0][c] * d[0] + m[1][c] * d[1] + m[2][c] * d[2]);
  }

  /** Whether more than a finding's own skin stands between its place and the eye. */
  hidden(place, toward, f) {
    const own = f.unit === "mm" ? 0.6 * f.high : 0;
    const skin = Math.min(own, 0.1 * this.ball.radius) + 0.012 * this.ball.radius;
    const origin = place.clone().addScaledVector(toward, skin);
    return firstHit(this.model, origin, toward, (x, y, z) => this.cutAway(x, y, z)) !== null;
  }

  /** What is done when the view comes to rest: the cut's side, and which pins are hidden. */
  settle() {
    if (this.cut.axis >= 0) this.setCut(this.cut.axis, this.cut.at);
    const toward = this.camera.position.clone().sub(this.controls.target).normalize();
    for (const p of this.pins) p.b.classList.toggle("hidden", this.hidden(p.place, toward, p.f));
    this.draw(); // Which pins keep their numbers depends on which are in sight.
  }

  /** Reads the value under a point of the page. */
  read(x, y) {
    const r = this.canvas.getBoundingClientRect();
    const p = new Vector3(((x - r.left) / r.width) * 2 - 1, 1 - ((y - r.top) / r.height) * 2, -1).unproject(this.camera);
    const toward = this.camera.position.clone().sub(this.controls.target).normalize();
    p.addScaledVector(toward, 12 * this.ball.radius);
    const hit = firstHit(this.model, p, toward.clone().negate(), (a, b, c) => this.cutAway(a, b, c));
    this.panel.say(hit, this.model.maps[this.map]);
    return hit;
  }

  /** Draws once, at the next frame. */
  draw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => { this.asked = false; this.render(); });
  }

  render() {
    const c = this.camera;
    c.updateMatrixWorld();
    const right = new Vector3(), up = new Vector3(), toward = new Vector3();
    c.matrixWorld.extractBasis(right, up, toward);
    this.material.uniforms.lamp.value.copy(toward).addScaledVector(right, -0.55).addScaledVector(up, 0.75).normalize();
    this.gl.render(this.scene, c);
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight, v = new Vector3();
    placePins(this.pins, this.current, (p) => {
      v.copy(p.place).project(c);
      const out = Math.abs(v.x) > 1 || Math.abs(v.y) > 1 || this.cutAway(p.place.x, p.place.y, p.place.z, 0.01 * this.ball.radius);
      return out ? null : [((v.x + 1) / 2) * w, ((1 - v.y) / 2) * h];
    });
    this.panel.scale((w * c.zoom) / (c.right - c.left));
    this.frames = (this.frames ?? 0) + 1;
  }

  selfTest() {
    return selfTest(this);
  }
}
