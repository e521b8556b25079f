/** Mouse, fingers and keys on the picture: pull the cloth, move pins, turn the view. */

import { meetPlane } from "./camera.js";
import { project, sub, add } from "./math.js";

/** Pixels around a pin or a knot in which it is meant, for a mouse and for a finger. */
const NEAR = { mouse: 9, touch: 22, pen: 14 };

export class Pointer {
  /** `viewer` has camera, views(), live, send(), redraw(); `hands` are drawn by it. */
  constructor(canvas, viewer) {
    this.canvas = canvas;
    this.viewer = viewer;
    this.down = new Map();
    this.drag = null;
    this.hovered = null;
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, (event) => this.lift(event));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** The view under a point of the window, and where it is in it: x and y from -1 to 1. */
  locate(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    const views = this.viewer.views();
    const inside = ({ css }) => x >= css.x && x < css.x + css.width && y >= css.y && y < css.y + css.height;
    const view = this.drag?.view ?? views.find(inside) ?? views[0];
    const { css } = view;
    return { view, x: (2 * (x - css.x)) / css.width - 1, y: 1 - (2 * (y - css.y)) / css.height };
  }

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
    const pin = turning ? null : this.pinAt(place, event.pointerType);
    const vertex = turning || pin !== null ? pin : this.vertexAt(place, event.pointerType);
    if (this.viewer.live && vertex !== null) {
      const cloth = place.view.cloth;
      const group = cloth.mesh.pinned.get(vertex);
      const normal = this.viewer.camera.axes().forward;
      const anchor = cloth.at(vertex);
      // The pointer met the triangle, not its corner: keep that distance.
      const offset = sub(anchor, meetPlane(this.ray(place), anchor, normal));
      const lead = group === undefined ? [0, 0, 0] : sub(cloth.at(cloth.mesh.pins[group][0]), anchor);
      this.drag = { view: place.view, vertex, group, normal, anchor, offset, lead, target: anchor };
      this.canvas.classList.add("busy");
      this.pull(place);
    } else {
      this.drag = null;
      this.canvas.classList.add("busy");
    }
  }

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

  /** Turn, move or come closer, with one finger or two. */
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
    const apart = (a) => Math.hypot(a.x - other.x, a.y - other.y);
    camera.zoom(apart(before) / Math.max(1, apart(now)));
    camera.pan(dx / (2 * height), dy / (2 * height));
  }

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

  wheel(event) {
    event.preventDefault();
    this.viewer.touched();
    this.viewer.camera.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, event.deltaY))));
    this.viewer.redraw();
  }

  /** Lead what is held to where the pointer is, in the plane across the view through where it was taken. */
  pull(place) {
    const { drag } = this;
    drag.target = add(meetPlane(this.ray(place), drag.anchor, drag.normal), drag.offset);
    this.viewer.later(() => {
      if (this.drag !== drag) return;
      const { mesh } = drag.view.cloth;
      if (drag.group === undefined) {
        this.viewer.send("grab", { vertex: drag.vertex, target: mesh.asInScene(drag.target) });
      } else {
        this.viewer.send("pin", { group: drag.group, target: mesh.asInScene(add(drag.target, drag.lead)) });
      }
    });
  }

  hover(event) {
    if (event.pointerType === "touch" || !this.viewer.views().length) return;
    const place = this.locate(event);
    const pin = this.pinAt(place, event.pointerType);
    const hovered = pin === null ? null : place.view.cloth.mesh.pinned.get(pin);
    if (hovered !== this.hovered) {
      this.hovered = hovered;
      this.viewer.redraw();
    }
    const over = this.viewer.live && (pin !== null || this.vertexAt(place, event.pointerType) !== null);
    this.canvas.classList.toggle("over", over);
  }

  ray({ view, x, y }) {
    return this.viewer.camera.ray(x, y, view.css.width / view.css.height);
  }

  /** The pinned vertex near a point of the picture, or nothing. */
  pinAt(place, kind) {
    return this.viewer.live ? this.near(place, place.view.cloth.mesh.pinned.keys(), kind) : null;
  }

  /** The vertex of the cloth at a point of the picture, or of a net near it, or nothing. */
  vertexAt(place, kind) {
    return place.view.cloth.pick(this.ray(place)) ?? this.near(place, place.view.cloth.mesh.knots, kind);
  }

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
