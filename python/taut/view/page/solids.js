/** The bodies of one panel: triangles with normals. The z axis points up here, whatever the scene's does. */

import { normalsOf } from "./cloth.js";
import { firstMet } from "./pick.js";

/**
 * The body whose triangle was met, of those that have so many triangles each.
 * @param {Met | null} met
 * @param {[number, number][]} parts
 * @returns {{ far: number, body: number } | null}
 */
function owned(met, parts) {
  if (!met) return null;
  let last = 0;
  for (const [body, faces] of parts) {
    last += faces;
    if (met.face < last) return { far: met.far, body };
  }
  return null;
}

/** @typedef {Record<"faces" | "positions" | "normals", WebGLBuffer>} SolidOnCard */

/** Triangles that may move. */
export class Triangles {
  /**
   * @param {Vector} faces
   * @param {Float32Array} positions
   */
  constructor(faces, positions) {
    this.faces = new Uint32Array(faces);
    this.normals = new Float32Array(positions.length);
    this.positions = positions;
    this.hasNewFaces = this.isNew = true;
    /** @type {SolidOnCard | undefined} */
    this.onCard = undefined;
    this.move(positions);
  }

  /**
   * Take other triangles, if they are.
   * @param {Vector} faces
   * @param {Float32Array} positions
   */
  take(faces, positions) {
    if (this.faces.length !== faces.length) {
      this.faces = new Uint32Array(faces);
      this.normals = new Float32Array(positions.length);
      this.hasNewFaces = true;
    }
    this.move(positions);
  }

  clear() {
    if (this.faces.length) this.take([], new Float32Array());
  }

  /** @param {Float32Array} positions */
  move(positions) {
    this.positions = positions;
    normalsOf(this.faces, positions, this.normals);
    this.isNew = true;
  }
}

export class Solids {
  /**
   * `mesh` is that of the cloth beside them, which knows the way up.
   * @param {Layout} layout
   * @param {number} index
   * @param {import("./cloth.js").Mesh} mesh
   */
  constructor(layout, index, mesh) {
    const { arrays } = layout;
    this.mesh = mesh;
    /** Spheres, capsules, boxes and meshes. */
    this.bodies = new Triangles(arrays[`solid_faces${index}`], mesh.turned(arrays[`solids${index}`]));
    /** Planes, which are seen from the side to which they face. */
    this.squares = new Triangles(arrays[`square_faces${index}`], mesh.turned(arrays[`squares${index}`]));
    /** A ball that was thrown; without faces while there is none. */
    this.ball = new Triangles([], new Float32Array());
    this.ballFaces = arrays[`ball_faces${index}`];
    this.parts = layout.meshes[index].parts;
    this.squareParts = layout.meshes[index].square_parts;
    this.middles = mesh.turned(arrays[`middles${index}`]);
    /** Where cloth touches something: x, y, z and how hard. */
    /** @type {{ place: Vec3, force: number }[]} */
    this.touches = [];
  }

  get all() {
    return [this.bodies, this.squares, this.ball];
  }

  /**
   * Take what a picture has of places and contacts.
   * @param {Picture} picture
   * @param {number} index
   */
  update({ arrays }, index) {
    const [bodies, squares, middles, ball] = ["solids", "squares", "middles", "ball"].map((name) => /** @type {Numbers | undefined} */ (arrays[`${name}${index}`]));
    if (bodies) this.bodies.move(this.mesh.turned(bodies));
    if (squares) this.squares.move(this.mesh.turned(squares));
    if (middles) this.middles = this.mesh.turned(middles);
    if (ball) this.ball.take(this.ballFaces, this.mesh.turned(ball));
    else this.ball.clear();
    const touches = arrays[`touches${index}`] ?? new Float32Array();
    this.touches = Array.from({ length: touches.length / 4 }, (_, row) => {
      const [x, y, z, force] = touches.subarray(4 * row, 4 * row + 4);
      return { place: this.mesh.fromScene([x, y, z]), force };
    });
  }

  /**
   * How far a ray goes until it first meets a body, and the number of that; or nothing.
   * @param {Ray} ray
   */
  pick(ray) {
    const met = [
      owned(firstMet(this.bodies.faces, this.bodies.positions, ray), this.parts),
      owned(firstMet(this.squares.faces, this.squares.positions, ray, true), this.squareParts),
      // The ball is the last of all.
      owned(firstMet(this.ball.faces, this.ball.positions, ray), [[this.middles.length / 3 - 1, Infinity]]),
    ];
    return met.flatMap((one) => one ?? []).sort((a, b) => a.far - b.far)[0] ?? null;
  }

  /**
   * The mean of a body's vertices.
   * @param {number} body
   * @returns {Vec3}
   */
  middle(body) {
    const [x, y, z] = this.middles.subarray(3 * body, 3 * body + 3);
    return [x, y, z];
  }

  /**
   * The box round a box and what is near it: bodies at the other end of the world need not be seen.
   * @param {Box} box
   */
  widened({ low, high }) {
    const reach = 1.5 * Math.hypot(...high.map((part, axis) => part - low[axis]));
    const middle = high.map((part, axis) => 0.5 * (part + low[axis]));
    const wide = { low: [...low], high: [...high] };
    const { positions } = this.bodies;
    for (let i = 0; i < positions.length; i += 3) {
      const place = positions.subarray(i, i + 3);
      if (Math.hypot(place[0] - middle[0], place[1] - middle[1], place[2] - middle[2]) > reach) continue;
      place.forEach((part, axis) => {
        wide.low[axis] = Math.min(wide.low[axis], part);
        wide.high[axis] = Math.max(wide.high[axis], part);
      });
    }
    return wide;
  }
}
