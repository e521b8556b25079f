/** Mouse, fingers and keys on the picture: pull the cloth, move pins and bodies, turn the view. */

import { meetPlane } from "./camera.js";
import { add, project, scale, sub } from "./math.js";

/** Pixels around a pin or a knot in which it is meant, for a mouse and for a finger. */
const NEAR = /** @type {Record<string, number>} */ ({ mouse: 9, touch: 22, pen: 14 });

/** @typedef {{ x: number, y: number }} Spot */
/** @typedef {{ vertex?: number, body?: number, met?: Vec3 }} Thing */
/**
 * What is held: a vertex, with its pin if it has one, or a body; `lead` goes from where it was taken to what is told where to go.
 *
 * @typedef {{
 *   view: View, vertex?: number, body?: number, group?: number, normal: Vec3, anchor: Vec3, offset: Vec3, lead: Vec3, target: Vec3,
 * }} Held
 */

export class Pointer {
  /**
   * `viewer` has camera, views(), live, send(), redraw(); `hands` are drawn by it.
   * @param {HTMLCanvasElement} canvas
   * @param {import("./main.js").Viewer} viewer
   */
  constructor(canvas, viewer) {
    this.canvas = canvas;
    this.viewer = viewer;
    /** @type {Map<number, Spot>} */
    this.down = new Map();
    /** @type {Held | null} */
    this.drag = null;
    /** @type {number | null} */
    this.hovered = null;
    /**
     * Where the pointer was last, over the picture.
     * @type {Place | null}
     */
    this.last = null;
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerleave", () => (this.last = null));
    for (const name of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      canvas.addEventListener(name, (event) => this.lift(event));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /**
   * The view under a point of the window, and where it is in it: x and y from -1 to 1.
   * @param {MouseEvent} event
   * @returns {Place}
   */
  locate(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    const views = this.viewer.views();
    /** @param {View} view */
    const inside = ({ css }) => x >= css.x && x < css.x + css.width && y >= css.y && y < css.y + css.height;
    const view = this.drag?.view ?? views.find(inside) ?? views[0];
    const { css } = view;
    return { view, x: (2 * (x - css.x)) / css.width - 1, y: 1 - (2 * (y - css.y)) / css.height };
  }

  /** @param {PointerEvent} event */
  press(event) {
    this.viewer.touched();
    this.canvas.setPointerCapture(event.pointerId);
    this.down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.down.size > 1) {
      this.letGo();
      return;
    }
    const place = this.locate(event);
    const turning = event.button === 1 || event.button === 2 || event.shiftKey || event.ctrlKey;
    /** @type {Thing} */
    const { vertex, body, met } = turning || !this.viewer.live ? {} : this.thingAt(place, event.pointerType);
    const { cloth } = place.view;
    const anchor = met ?? (vertex === undefined ? null : cloth.at(vertex));
    if (anchor) {
      const group = vertex === undefined ? undefined : cloth.mesh.pinned.get(vertex);
      const normal = this.viewer.camera.axes().forward;
      // The pointer met the triangle, not its corner: keep that distance.
      const offset = sub(anchor, meetPlane(this.ray(place), anchor, normal));
      // From there to what is told where to go: the first vertex of a pin, the middle of a body.
      const told = body !== undefined ? cloth.solids.middle(body) : group !== undefined ? cloth.at(cloth.mesh.pins[group][0]) : anchor;
      this.drag = { view: place.view, vertex, body, group, normal, anchor, offset, lead: sub(told, anchor), target: anchor };
      this.canvas.classList.add("busy");
      this.pull(place);
    } else {
      this.drag = null;
      this.canvas.classList.add("busy");
    }
  }

  /** @param {PointerEvent} event */
  move(event) {
    const before = this.down.get(event.pointerId);
    if (!before) {
      this.hover(event);
      return;
    }
    const now = { x: event.clientX, y: event.clientY };
    if (this.drag) this.pull(this.locate(event));
    else this.steer(event, before, now);
    this.down.set(event.pointerId, now);
    this.viewer.redraw();
  }

  /**
   * Turn, move or come closer, with one finger or two.
   * @param {PointerEvent} event
   * @param {Spot} before
   * @param {Spot} now
   */
  steer(event, before, now) {
    const { camera } = this.viewer;
    const height = this.canvas.clientHeight;
    const dx = now.x - before.x, dy = now.y - before.y;
    if (this.down.size === 1) {
      if (event.buttons & 6 || event.shiftKey || event.ctrlKey) camera.pan(dx / height, dy / height);
      else camera.orbit(dx, dy);
      return;
    }
    const other = [...this.down].find(([id]) => id !== event.pointerId)?.[1];
    if (!other) return;
    /** @param {Spot} a */
    const apart = (a) => Math.hypot(a.x - other.x, a.y - other.y);
    camera.zoom(apart(before) / Math.max(1, apart(now)));
    camera.pan(dx / (2 * height), dy / (2 * height));
  }

  /** @param {PointerEvent} event */
  lift(event) {
    if (!this.down.delete(event.pointerId)) return;
    this.letGo();
    this.canvas.classList.remove("busy");
    this.viewer.redraw();
  }

  letGo() {
    if (this.drag && this.drag.group === undefined) this.viewer.send("release");
    this.drag = null;
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    event.preventDefault();
    this.viewer.touched();
    this.viewer.camera.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, event.deltaY))));
    this.viewer.redraw();
  }

  /**
   * Lead what is held to where the pointer is, in the plane across the view through where it was taken.
   * @param {Place} place
   */
  pull(place) {
    const { drag } = this;
    if (!drag) return;
    drag.target = add(meetPlane(this.ray(place), drag.anchor, drag.normal), drag.offset);
    this.viewer.later(() => {
      if (this.drag !== drag) return;
      const { mesh } = drag.view.cloth;
      const target = mesh.asInScene(add(drag.target, drag.lead));
      if (drag.body !== undefined) this.viewer.send("drag", { body: drag.body, target });
      else if (drag.group !== undefined) this.viewer.send("pin", { group: drag.group, target });
      else this.viewer.send("grab", { vertex: drag.vertex, target });
    });
  }

  /** @param {PointerEvent} event */
  hover(event) {
    if (event.pointerType === "touch" || !this.viewer.views().length) return;
    const place = this.locate(event);
    this.last = place;
    /** @type {Thing} */
    const { vertex, body } = this.viewer.live ? this.thingAt(place, event.pointerType) : {};
    const hovered = vertex === undefined ? null : (place.view.cloth.mesh.pinned.get(vertex) ?? null);
    if (hovered !== this.hovered) {
      this.hovered = hovered;
      this.viewer.redraw();
    }
    this.canvas.classList.toggle("over", vertex !== undefined || body !== undefined);
  }

  /** @param {Place} place */
  ray({ view, x, y }) {
    return this.viewer.camera.ray(x, y, view.css.width / view.css.height);
  }

  /**
   * What can be pulled at a point of the picture: a pin near it, what is seen there, or a knot of a net near it.
   * @param {Place} place
   * @param {string} kind
   * @returns {Thing}
   */
  thingAt(place, kind) {
    const { cloth } = place.view;
    const pin = this.near(place, cloth.mesh.pinned.keys(), kind);
    if (pin !== null) return { vertex: pin };
    const ray = this.ray(place);
    const seen = cloth.pick(ray), solid = cloth.solids.pick(ray);
    if (solid && !(seen && seen.far <= solid.far)) return { body: solid.body, met: add(ray.from, scale(ray.way, solid.far)) };
    const vertex = seen?.vertex ?? this.near(place, cloth.mesh.knots, kind);
    return vertex === null ? {} : { vertex };
  }

  /** Where the pointer is, or the middle of the picture, and what is seen there: both in the world. */
  aim() {
    const { last, viewer } = this;
    const place = last ?? { view: viewer.views()[0], x: 0, y: 0 };
    const ray = this.ray(place);
    const { cloth } = place.view;
    const seen = [cloth.pick(ray), cloth.solids.pick(ray)].flatMap((met) => met?.far ?? []);
    const { forward } = viewer.camera.axes();
    const target = seen.length ? add(ray.from, scale(ray.way, Math.min(...seen))) : meetPlane(ray, viewer.look.centre, forward);
    return { mesh: cloth.mesh, target };
  }

  /**
   * @param {Place} place
   * @param {Iterable<number>} vertices
   * @param {string} kind
   * @returns {number | null}
   */
  near({ view, x, y }, vertices, kind) {
    let best = NEAR[kind] ?? NEAR.mouse, found = null;
    for (const vertex of vertices) {
      const [px, py, w] = project(view.camera, view.cloth.at(vertex));
      if (w <= 0) continue;
      const away = Math.hypot(((px - x) * view.css.width) / 2, ((py - y) * view.css.height) / 2);
      if (away < best) [best, found] = [away, vertex];
    }
    return found;
  }
}
