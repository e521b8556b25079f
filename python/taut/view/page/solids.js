/** The bodies of one panel: triangles with normals. The z axis points up here, whatever the scene's does. */

import { normalsOf } from "./cloth.js";

/** Triangles that may move. */
class Triangles {
  constructor(faces, positions) {
    this.faces = new Uint32Array(faces);
    this.normals = new Float32Array(positions.length);
    this.move(positions);
  }

  move(positions) {
    this.positions = positions;
    normalsOf(this.faces, positions, this.normals);
    this.isNew = true;
  }
}

export class Solids {
  /** `mesh` is that of the cloth beside them, which knows the way up. */
  constructor(layout, index, mesh) {
    const { arrays } = layout;
    this.mesh = mesh;
    /** Spheres, capsules, boxes and meshes. */
    this.bodies = new Triangles(arrays[`solid_faces${index}`], mesh.turned(arrays[`solids${index}`]));
    /** Planes, which are seen from the side to which they face. */
    this.squares = new Triangles(arrays[`square_faces${index}`], mesh.turned(arrays[`squares${index}`]));
  }

  get all() {
    return [this.bodies, this.squares];
  }

  /** Take new places, if a picture has some. */
  update(bodies, squares) {
    if (bodies) this.bodies.move(this.mesh.turned(bodies));
    if (squares) this.squares.move(this.mesh.turned(squares));
  }

  /** The box round a box and what is near it: bodies at the other end of the world need not be seen. */
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
