/** An eye that turns round a point. The z axis points up. */

import { add, cross, dot, lookAt, multiply, perspective, scale, sub, unit } from "./math.js";

const ANGLE = (36 * Math.PI) / 180;

export class Camera {
  constructor() {
    this.ball = { centre: /** @type {Vec3} */ ([0, 0, 0]), radius: 1 };
    this.target = this.ball.centre;
    this.aspect = this.closeness = 1;
    this.turn = this.tilt = 0;
    this.home([0, 0, 0], 1);
  }

  /**
   * Look at a ball, a little from above.
   * @param {Vec3} centre
   * @param {number} radius
   */
  home(centre, radius) {
    this.ball = { centre, radius };
    this.target = centre;
    this.aspect = 1;
    /** 1: the ball fills the picture. */
    this.closeness = 1;
    this.turn = -1.12;
    this.tilt = 0.2;
  }

  get distance() {
    return (1.06 * this.ball.radius) / Math.sin(ANGLE / 2) / Math.min(1, this.aspect) / this.closeness;
  }

  /** Height of the picture where it looks [m]. */
  get height() {
    return 2 * Math.tan(ANGLE / 2) * this.distance;
  }

  get eye() {
    const across = Math.cos(this.tilt);
    const way = [across * Math.cos(this.turn), across * Math.sin(this.turn), Math.sin(this.tilt)];
    return add(this.target, scale(way, this.distance));
  }

  /**
   * World to clip coordinates for a picture of this width over height.
   * @param {number} aspect
   */
  matrix(aspect) {
    this.aspect = aspect;
    const near = 0.02 * this.distance;
    const projection = perspective(ANGLE, aspect, near, near + 60 * Math.max(this.distance, this.ball.radius));
    return multiply(projection, lookAt(this.eye, this.target, [0, 0, 1]));
  }

  /** Right, up and forward as the eye sees them. */
  axes() {
    const forward = unit(sub(this.target, this.eye));
    const right = unit(cross(forward, [0, 0, 1]));
    return { right, up: cross(right, forward), forward };
  }

  /**
   * The ray through a point of the picture, x and y from -1 to 1.
   * @param {number} x
   * @param {number} y
   * @param {number} aspect
   * @returns {Ray}
   */
  ray(x, y, aspect) {
    const { right, up, forward } = this.axes();
    const half = Math.tan(ANGLE / 2);
    return { from: this.eye, way: unit(add(forward, add(scale(right, x * half * aspect), scale(up, y * half)))) };
  }

  /**
   * @param {number} dx
   * @param {number} dy
   */
  orbit(dx, dy) {
    this.turn -= 0.008 * dx;
    this.tilt = Math.min(1.5, Math.max(-1.2, this.tilt + 0.008 * dy));
  }

  /**
   * Move sideways by so many pictures' heights.
   * @param {number} dx
   * @param {number} dy
   */
  pan(dx, dy) {
    const { right, up } = this.axes();
    this.target = add(this.target, add(scale(right, -dx * this.height), scale(up, dy * this.height)));
  }

  /** @param {number} factor */
  zoom(factor) {
    this.closeness = Math.min(25, Math.max(0.1, this.closeness / factor));
  }
}

/**
 * Where a ray meets the plane through a point and across the way in which the eye looks.
 * @param {Ray} ray
 * @param {Vector} point
 * @param {Vector} normal
 */
export function meetPlane(ray, point, normal) {
  const along = dot(ray.way, normal);
  return add(ray.from, scale(ray.way, dot(sub(point, ray.from), normal) / along));
}

