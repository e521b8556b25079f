/** Vectors of three numbers, and 4 x 4 matrices in columns, as WebGL takes them. */

/** @type {(a: Vector, b: Vector) => Vec3} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @type {(a: Vector, b: Vector) => Vec3} */
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @type {(a: Vector, s: number) => Vec3} */
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
/** @type {(a: Vector, b: Vector) => number} */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @type {(a: Vector, b: Vector) => Vec3} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @type {(a: Vector) => number} */
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
/** @type {(a: Vector) => Vec3} */
export const unit = (a) => scale(a, 1 / (length(a) || 1));

/**
 * @param {Float32Array} a
 * @param {Float32Array} b
 */
export function multiply(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

/**
 * @param {number} angle
 * @param {number} aspect
 * @param {number} near
 * @param {number} far
 */
export function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  const depth = 1 / (near - far);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) * depth, -1, 0, 0, 2 * far * near * depth, 0]);
}

/**
 * @param {number} half
 * @param {number} near
 * @param {number} far
 */
export function orthographic(half, near, far) {
  const depth = 1 / (near - far);
  return new Float32Array([1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, 2 * depth, 0, 0, 0, (far + near) * depth, 1]);
}

/**
 * World to eye coordinates.
 * @param {Vector} eye
 * @param {Vector} target
 * @param {Vector} up
 */
export function lookAt(eye, target, up) {
  const back = unit(sub(eye, target));
  const right = unit(cross(up, back));
  const top = cross(back, right);
  return new Float32Array([
    right[0], top[0], back[0], 0, right[1], top[1], back[1], 0, right[2], top[2], back[2], 0,
    -dot(right, eye), -dot(top, eye), -dot(back, eye), 1,
  ]);
}

/**
 * A matrix that puts the z axis along `direction`, lengthens everything by `size` and moves it to `place`.
 * @param {Vector} direction
 * @param {number} size
 * @param {Vector} place
 */
export function along(direction, size, place) {
  const z = unit(direction);
  const x = unit(cross(Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], z));
  const y = cross(z, x);
  return new Float32Array([
    x[0] * size, x[1] * size, x[2] * size, 0, y[0] * size, y[1] * size, y[2] * size, 0,
    z[0] * size, z[1] * size, z[2] * size, 0, place[0], place[1], place[2], 1,
  ]);
}

/**
 * Clip coordinates of a point: x and y from -1 to 1, and w, which is positive before the eye.
 * @param {Float32Array} matrix
 * @param {Vec3} place
 * @returns {Vec3}
 */
export function project(matrix, place) {
  const [x, y, z] = place;
  /** @param {number} r */
  const row = (r) => matrix[r] * x + matrix[4 + r] * y + matrix[8 + r] * z + matrix[12 + r];
  const w = row(3);
  return [row(0) / w, row(1) / w, w];
}
