// Creases as lines: where two triangles meet at more than 25°.

const COSINE = 0.906;

/** End points of all creases, six numbers a line. `grid` are the 16-bit positions, equal where corners meet. */
export function creases({ grid, positions, indices }) {
  const count = grid.length / 3, ids = new Uint32Array(count), seen = new Map();
  for (let i = 0; i < count; i++) {
    const key = grid[3 * i] * 4294967296 + grid[3 * i + 1] * 65536 + grid[3 * i + 2];
    let id = seen.get(key);
    if (id === undefined) seen.set(key, (id = i));
    ids[i] = id;
  }
  const normals = new Float32Array(indices.length), open = new Map(), lines = [];
  for (let t = 0; t < indices.length; t += 3) {
    const [a, b, c] = [ids[indices[t]], ids[indices[t + 1]], ids[indices[t + 2]]];
    const p = (v, k) => positions[3 * v + k];
    const u = [0, 1, 2].map((k) => p(b, k) - p(a, k)), w = [0, 1, 2].map((k) => p(c, k) - p(a, k));
    const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
    const length = Math.hypot(...n) || 1;
    for (let k = 0; k < 3; k++) normals[t + k] = n[k] / length;
    for (const [i, j] of [[a, b], [b, c], [c, a]]) {
      const key = i < j ? i * 16777216 + j : j * 16777216 + i;
      const other = open.get(key);
      if (other === undefined) {
        open.set(key, t);
        continue;
      }
      const facing = normals[t] * normals[other] + normals[t + 1] * normals[other + 1] + normals[t + 2] * normals[other + 2];
      if (facing < COSINE) lines.push(p(i, 0), p(i, 1), p(i, 2), p(j, 0), p(j, 1), p(j, 2));
    }
  }
  return new Float32Array(lines);
}
