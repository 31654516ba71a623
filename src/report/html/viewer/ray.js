// A ray against all triangles (Möller & Trumbore 1997); fast enough for a click, and needs no tree.

/** The first triangle a ray meets: distance, place and triangle; null for none. `skip` leaves out places. */
export function firstHit({ positions: p, indices: t }, origin, toward, skip) {
  let best = Infinity, hit = null;
  const { x: ox, y: oy, z: oz } = origin, { x: dx, y: dy, z: dz } = toward;
  for (let k = 0; k < t.length; k += 3) {
    const a = 3 * t[k], b = 3 * t[k + 1], c = 3 * t[k + 2];
    const ax = p[a], ay = p[a + 1], az = p[a + 2];
    const ux = p[b] - ax, uy = p[b + 1] - ay, uz = p[b + 2] - az;
    const vx = p[c] - ax, vy = p[c + 1] - ay, vz = p[c + 2] - az;
    const hx = dy * vz - dz * vy, hy = dz * vx - dx * vz, hz = dx * vy - dy * vx;
    const det = ux * hx + uy * hy + uz * hz;
    if (det > -1e-12 && det < 1e-12) continue;
    const sx = ox - ax, sy = oy - ay, sz = oz - az, inv = 1 / det;
    const u = (sx * hx + sy * hy + sz * hz) * inv;
    if (u < 0 || u > 1) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const v = (dx * qx + dy * qy + dz * qz) * inv;
    if (v < 0 || u + v > 1) continue;
    const d = (vx * qx + vy * qy + vz * qz) * inv;
    if (d <= 1e-5 || d >= best) continue;
    const x = ox + d * dx, y = oy + d * dy, z = oz + d * dz;
    if (skip(x, y, z)) continue;
    best = d;
    hit = { distance: d, place: [x, y, z], corners: [t[k], t[k + 1], t[k + 2]], weights: [1 - u - v, u, v] };
  }
  return hit;
}
