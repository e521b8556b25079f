/** Small solid things: a ball and an arrow of length 1 along z. Triangles as positions and normals. */

/** @typedef {{ positions: number[], normals: number[] }} Shape */

export function ball() {
  /** @type {Shape} */
  const out = { positions: [], normals: [] };
  const rings = 8, parts = 12;
  /** @type {(ring: number, part: number) => Vec3} */
  const at = (ring, part) => {
    const a = (Math.PI * ring) / rings, b = (2 * Math.PI * part) / parts;
    return [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)];
  };
  for (let ring = 0; ring < rings; ring++) {
    for (let part = 0; part < parts; part++) {
      const [a, b, c, d] = [at(ring, part), at(ring + 1, part), at(ring + 1, part + 1), at(ring, part + 1)];
      for (const corner of [a, b, c, a, c, d]) {
        out.positions.push(...corner);
        out.normals.push(...corner);
      }
    }
  }
  return out;
}

export function arrow() {
  /** @type {Shape} */
  const out = { positions: [], normals: [] };
  // Radius and height along the outline; the normals' slope of each piece.
  turn(out, [[0.018, 0], [0.018, 0.72]], 0);
  turn(out, [[0.055, 0.72], [0, 1]], 0.2);
  turn(out, [[0, 0.72], [0.055, 0.72]], -1e6);
  turn(out, [[0, 0], [0.018, 0]], -1e6);
  return out;
}

/**
 * @param {Shape} out
 * @param {[[number, number], [number, number]]} ends
 * @param {number} slope
 */
function turn({ positions, normals }, [[r0, z0], [r1, z1]], slope) {
  const parts = 20;
  /** @type {(radius: number, z: number, part: number) => { place: Vec3, normal: Vec3 }} */
  const at = (radius, z, part) => {
    const angle = (2 * Math.PI * part) / parts;
    const size = Math.hypot(1, slope);
    return {
      place: [radius * Math.cos(angle), radius * Math.sin(angle), z],
      normal: [Math.cos(angle) / size, Math.sin(angle) / size, slope / size],
    };
  };
  for (let part = 0; part < parts; part++) {
    const [a, b, c, d] = [at(r0, z0, part), at(r0, z0, part + 1), at(r1, z1, part + 1), at(r1, z1, part)];
    for (const corner of [a, b, c, a, c, d]) {
      positions.push(...corner.place);
      normals.push(...corner.normal);
    }
  }
}
