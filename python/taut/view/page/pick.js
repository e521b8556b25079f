/** Where a ray first meets triangles. */

/**
 * How far along the ray that is, which triangle it is and the weights of its corners; or nothing. With `fronts` triangles are
 * met from the side alone to which they face.
 * @param {Uint32Array} faces
 * @param {Numbers} p
 * @param {Ray} ray
 * @param {boolean} fronts
 * @returns {Met | null}
 */
export function firstMet(faces, p, { from, way }, fronts = false) {
  /** @type {Met | null} */
  let found = null;
  for (let i = 0; i < faces.length; i += 3) {
    const a = 3 * faces[i], b = 3 * faces[i + 1], c = 3 * faces[i + 2];
    const e1x = p[b] - p[a], e1y = p[b + 1] - p[a + 1], e1z = p[b + 2] - p[a + 2];
    const e2x = p[c] - p[a], e2y = p[c + 1] - p[a + 1], e2z = p[c + 2] - p[a + 2];
    const hx = way[1] * e2z - way[2] * e2y, hy = way[2] * e2x - way[0] * e2z, hz = way[0] * e2y - way[1] * e2x;
    const det = e1x * hx + e1y * hy + e1z * hz;
    if (Math.abs(det) < 1e-14 || (fronts && det < 0)) continue;
    const sx = from[0] - p[a], sy = from[1] - p[a + 1], sz = from[2] - p[a + 2];
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (u < 0 || u > 1) continue;
    const qx = sy * e1z - sz * e1y, qy = sz * e1x - sx * e1z, qz = sx * e1y - sy * e1x;
    const v = (way[0] * qx + way[1] * qy + way[2] * qz) / det;
    if (v < 0 || u + v > 1) continue;
    const far = (e2x * qx + e2y * qy + e2z * qz) / det;
    if (far > 0 && (!found || far < found.far)) found = { far, face: i / 3, weights: [1 - u - v, u, v] };
  }
  return found;
}
