// The painted section: along the outline of a cut, the map's colour fills each wall (or gap) to its middle.
import { BufferAttribute, BufferGeometry, EqualStencilFunc, AlwaysStencilFunc, GLSL3, LineSegments, Mesh, ShaderMaterial, Vector4, DoubleSide } from "three";
import { FRAGMENT, INK, LINES, VERTEX } from "./shader.js";

/** Least share of a facet's normal that lies in the plane; below it a facet runs along the cut and its depth means little. */
const STEEP = 0.35;

/**
 * Outline of a cut and the strips beside it: a strip is as deep as half the map's value, so that the strips of a wall's
 * two sides meet in its middle and fill it; an open mesh has no inside to be filled. Maps that fill nothing get strips of `thin`.
 */
export function strips({ positions: p, indices: t }, map, axis, at, thin, capped) {
  const [u, v] = [[1, 2], [0, 2], [0, 1]][axis], outline = [], quads = [];
  const sign = map?.fills === "void" ? 1 : -1;
  const cross = (a, b) => {
    const s = (at - p[3 * a + axis]) / (p[3 * b + axis] - p[3 * a + axis]), q = [0, 0, 0];
    for (let k = 0; k < 3; k++) q[k] = k === axis ? at : p[3 * a + k] + s * (p[3 * b + k] - p[3 * a + k]);
    q.value = map ? map.values[a] + s * (map.values[b] - map.values[a]) : NaN;
    return q;
  };
  for (let k = 0; k < t.length; k += 3) {
    const [a, b, c] = [t[k], t[k + 1], t[k + 2]];
    const sides = [a, b, c].map((i) => p[3 * i + axis] > at);
    if (sides[0] === sides[1] && sides[1] === sides[2]) continue;
    const ends = [];
    for (const [i, j, m, n] of [[a, b, 0, 1], [b, c, 1, 2], [c, a, 2, 0]]) if (sides[m] !== sides[n]) ends.push(cross(i, j));
    const [from, to] = ends;
    outline.push(...from, ...to);
    if (!map || (!capped && map.fills !== "void") || !(from.value === from.value && to.value === to.value)) continue;
    // Beyond the scale's end nothing is known of the depth: hatching stays.
    if (map.fills && from.value >= map.high && to.value >= map.high) continue;
    const e = [0, 1, 2].map((x) => p[3 * b + x] - p[3 * a + x]), f = [0, 1, 2].map((x) => p[3 * c + x] - p[3 * a + x]);
    const n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    const length = Math.hypot(...n), within = Math.hypot(n[u], n[v]) / length;
    if (!(within > 1e-3)) continue;
    const depth = (value) => (map.fills ? Math.min(value, map.high) / 2 / Math.max(within, STEEP) : thin);
    const inner = (q) => {
      const r = [...q], d = sign * depth(q.value) / (within * length);
      r[u] += d * n[u];
      r[v] += d * n[v];
      return r;
    };
    quads.push({ worst: (map.sense === "max" ? -1 : 1) * Math.min(from.value, to.value), corners: [from, to, inner(to), inner(from)] });
  }
  // What is worst is drawn last, over all else.
  quads.sort((a, b) => b.worst - a.worst);
  return { outline, quads };
}

/** Draws the section of a cut; `update` follows the cut and the map. */
export function makeSection(view) {
  const u = view.material.uniforms;
  const paint = new ShaderMaterial({
    glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, side: DoubleSide, defines: { FLAT: 1 }, depthWrite: false,
    stencilWrite: true, stencilRef: 1, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1,
    uniforms: { ...u, plane: { value: new Vector4(0, 0, 0, 0) } },
  });
  const ink = new ShaderMaterial({
    glslVersion: GLSL3, vertexShader: LINES, fragmentShader: INK, transparent: true, uniforms: { plane: { value: new Vector4(0, 0, 0, 0) } },
  });
  const band = new Mesh(new BufferGeometry(), paint), line = new LineSegments(new BufferGeometry(), ink);
  for (const [o, order] of [[band, 1], [line, 3]]) {
    o.frustumCulled = false;
    o.renderOrder = order;
    o.visible = false;
    view.scene.add(o);
  }
  return {
    update() {
      const { axis, at } = view.cut, on = axis >= 0;
      band.visible = line.visible = on;
      view.sectioned = 0;
      if (!on) return;
      const lo = view.box.min.getComponent(axis), hi = view.box.max.getComponent(axis);
      const map = view.model.maps[view.map];
      const { outline, quads } = strips(view.model, map, axis, lo + (hi - lo) * at, 0.012 * view.ball.radius, view.capped);
      const places = new Float32Array(12 * quads.length), values = new Float32Array(4 * quads.length);
      const order = new Uint32Array(6 * quads.length);
      quads.forEach(({ corners: [a, b, c, d] }, i) => {
        places.set([...a, ...b, ...c, ...d], 12 * i);
        values.set([a.value, b.value, b.value, a.value], 4 * i);
        order.set([0, 1, 2, 0, 2, 3].map((k) => 4 * i + k), 6 * i);
      });
      const fresh = (mesh, parts) => { mesh.geometry.dispose(); mesh.geometry = new BufferGeometry(); for (const [n, x, w] of parts) mesh.geometry.setAttribute(n, new BufferAttribute(x, w)); };
      fresh(band, [["position", places, 3], ["value", values, 1]]);
      band.geometry.setIndex(new BufferAttribute(order, 1));
      fresh(line, [["position", new Float32Array(outline), 3]]);
      // Strips of material only where the cut shows material; strips of a gap only beside it.
      paint.stencilFunc = view.capped && map?.fills !== "void" ? EqualStencilFunc : AlwaysStencilFunc;
      view.sectioned = quads.length;
    },
  };
}
