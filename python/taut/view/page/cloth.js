/** The cloth of one panel: what follows from its positions. The z axis points up here, whatever the scene's does. */

import { firstMet } from "./pick.js";

/** Springs at their limit are over it by rounding; that is not yet a violation. */
const ROUNDING = 1.002;

export class Mesh {
  /**
   * What never changes, from the layout.
   * @param {Layout} layout
   * @param {number} index
   */
  constructor(layout, index) {
    this.up = layout.up;
    const { arrays } = layout;
    this.rest = this.turned(arrays[`rest${index}`]);
    this.faces = new Uint32Array(arrays[`faces${index}`]);
    this.springs = arrays[`springs${index}`];
    this.lengths = /** @type {Float32Array} */ (arrays[`lengths${index}`]);
    this.pins = layout.meshes[index].pins;
    /** Height of the plane on which everything stands, or null. */
    this.floor = layout.meshes[index].floor;
    /** @type {Map<number, number>} */
    this.pinned = new Map();
    this.pins.forEach((group, number) => group.forEach((vertex) => this.pinned.set(vertex, number)));
    this.vertices = this.rest.length / 3;
    this.clothOfSpring = this.ownersOfSprings(layout.meshes[index].first_vertices);
    this.bare = this.uncovered();
    this.knots = [...new Set(this.bare.flatMap((spring) => [this.springs[2 * spring], this.springs[2 * spring + 1]]))];
    this.texture = this.flattened();
    /** @type {Record<"faces" | "texture", WebGLBuffer> | undefined} */
    this.onCard = undefined;
    this.meanLength = this.lengths.reduce((sum, length) => sum + length, 0) / Math.max(1, this.lengths.length);
  }

  /**
   * Positions with z up.
   * @param {Numbers} positions
   * @returns {Float32Array}
   */
  turned(positions) {
    if (this.up === 2) return /** @type {Float32Array} */ (positions);
    const out = new Float32Array(positions.length);
    for (let i = 0; i < out.length; i += 3) {
      out[i] = positions[i];
      out[i + 1] = -positions[i + 2];
      out[i + 2] = positions[i + 1];
    }
    return out;
  }

  /**
   * A place as the scene has it.
   * @param {Vec3} place
   * @returns {Vec3}
   */
  asInScene([x, y, z]) {
    return this.up === 2 ? [x, y, z] : [x, z, -y];
  }

  /**
   * @param {Vec3} place
   * @returns {Vec3}
   */
  fromScene([x, y, z]) {
    return this.up === 2 ? [x, y, z] : [x, -z, y];
  }

  /** @param {number[]} firsts */
  ownersOfSprings(firsts) {
    const owner = new Uint16Array(this.lengths.length);
    for (let spring = 0; spring < owner.length; spring++) {
      const vertex = this.springs[2 * spring];
      let cloth = 0;
      while (cloth + 1 < firsts.length && firsts[cloth + 1] <= vertex) cloth++;
      owner[spring] = cloth;
    }
    return owner;
  }

  /** Springs that no triangle shows: those of nets and chains. */
  uncovered() {
    const covered = new Uint8Array(this.vertices);
    for (const vertex of this.faces) covered[vertex] = 1;
    /** @type {number[]} */
    const bare = [];
    for (let spring = 0; spring < this.lengths.length; spring++) {
      if (!covered[this.springs[2 * spring]] || !covered[this.springs[2 * spring + 1]]) bare.push(spring);
    }
    return bare;
  }

  /** The box in which the cloth will mostly be: what lies flat will hang from its pins. */
  box() {
    const { low, high } = bounds(this.rest);
    /** @param {number} vertex */
    const at = (vertex) => this.rest.subarray(3 * vertex, 3 * vertex + 3);
    const pins = [...this.pinned.keys()];
    const lies = high[2] - low[2] < 0.3 * Math.hypot(high[0] - low[0], high[1] - low[1]);
    if (lies && pins.length) {
      /** @param {number} vertex */
      const away = (vertex) => Math.min(...pins.map((pin) => Math.hypot(...at(pin).map((part, axis) => part - at(vertex)[axis]))));
      let reach = 0;
      const stride = Math.max(1, Math.floor((this.vertices * pins.length) / 200_000));
      for (let vertex = 0; vertex < this.vertices; vertex += stride) reach = Math.max(reach, away(vertex));
      low[2] = Math.min(low[2], Math.max(...pins.map((pin) => at(pin)[2])) - reach);
    }
    return { low, high };
  }

  /** Places on the fabric [m]: the two longest sides of the box round the cloth at the start. */
  flattened() {
    const { low, high } = bounds(this.rest);
    const order = [0, 1, 2].sort((a, b) => high[b] - low[b] - (high[a] - low[a]));
    const [first, second] = order.slice(0, 2).sort((a, b) => a - b);
    const flat = new Float32Array(2 * this.vertices);
    for (let i = 0; i < this.vertices; i++) {
      flat[2 * i] = this.rest[3 * i + first] - low[first];
      flat[2 * i + 1] = this.rest[3 * i + second] - low[second];
    }
    return flat;
  }
}

export class Cloth {
  /**
   * `solids` are the bodies beside it.
   * @param {Mesh} mesh
   * @param {import("./solids.js").Solids} solids
   */
  constructor(mesh, solids) {
    this.mesh = mesh;
    this.solids = solids;
    this.positions = mesh.rest;
    this.normals = new Float32Array(mesh.rest.length);
    this.stretch = new Float32Array(mesh.vertices);
    /** Springs over their limit as pairs of ends, and how many they are. */
    this.over = new Float32Array(0);
    this.overCount = 0;
    /** @type {Record<"positions" | "normals" | "stretch", WebGLBuffer> | undefined} */
    this.onCard = undefined;
  }

  /**
   * Take new positions; `limits`: the largest stretch allowed in each cloth.
   * @param {Numbers} positions
   * @param {(number | null)[]} limits
   */
  update(positions, limits) {
    this.positions = this.mesh.turned(positions);
    normalsOf(this.mesh.faces, this.positions, this.normals);
    this.measure(limits);
  }

  /**
   * @param {number} vertex
   * @returns {Vec3}
   */
  at(vertex) {
    return [this.positions[3 * vertex], this.positions[3 * vertex + 1], this.positions[3 * vertex + 2]];
  }

  /**
   * Stretch of each vertex: that of its longest spring. And the springs over their limit.
   * @param {(number | null)[]} limits
   */
  measure(limits) {
    const { springs, lengths, clothOfSpring } = this.mesh;
    const { positions: p, stretch } = this;
    /** @type {number[]} */
    const over = [];
    stretch.fill(-1);
    const bound = limits.map((limit) => (limit === null ? Infinity : limit * ROUNDING + 1e-6));
    for (let spring = 0; spring < lengths.length; spring++) {
      const u = springs[2 * spring], v = springs[2 * spring + 1];
      const x = p[3 * v] - p[3 * u], y = p[3 * v + 1] - p[3 * u + 1], z = p[3 * v + 2] - p[3 * u + 2];
      const s = Math.sqrt(x * x + y * y + z * z) / lengths[spring] - 1;
      if (s > stretch[u]) stretch[u] = s;
      if (s > stretch[v]) stretch[v] = s;
      if (s > bound[clothOfSpring[spring]]) over.push(spring);
    }
    this.overCount = over.length;
    this.over = this.segments(over);
  }

  /**
   * Both ends of some springs, six numbers each.
   * @param {number[]} chosen
   */
  segments(chosen) {
    const { springs } = this.mesh;
    const out = new Float32Array(6 * chosen.length);
    chosen.forEach((spring, index) => {
      out.set(this.at(springs[2 * spring]), 6 * index);
      out.set(this.at(springs[2 * spring + 1]), 6 * index + 3);
    });
    return out;
  }

  /**
   * How far a ray goes until it first meets the cloth, and the vertex nearest to that; or nothing.
   * @param {Ray} ray
   */
  pick(ray) {
    const met = firstMet(this.mesh.faces, this.positions, ray);
    if (!met) return null;
    const corner = met.weights.indexOf(Math.max(...met.weights));
    return { far: met.far, vertex: this.mesh.faces[3 * met.face + corner] };
  }
}

/**
 * Normals at the corners of triangles, which of larger ones count more; of any length.
 * @param {Uint32Array} faces
 * @param {Numbers} p
 * @param {Float32Array} n
 */
export function normalsOf(faces, p, n) {
  n.fill(0);
  for (let i = 0; i < faces.length; i += 3) {
    const a = 3 * faces[i], b = 3 * faces[i + 1], c = 3 * faces[i + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    n[a] += x; n[a + 1] += y; n[a + 2] += z;
    n[b] += x; n[b + 1] += y; n[b + 2] += z;
    n[c] += x; n[c + 1] += y; n[c + 2] += z;
  }
}

/**
 * The box around points.
 * @param {Float32Array} positions
 */
function bounds(positions) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    const axis = i % 3, value = positions[i];
    if (value < low[axis]) low[axis] = value;
    if (value > high[axis]) high[axis] = value;
  }
  return { low, high };
}
