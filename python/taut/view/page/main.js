/** Puts the page together: what comes from the socket is drawn, what people do is sent back. */

import { Camera } from "./camera.js";
import { Cloth, Mesh } from "./cloth.js";
import { Drawing } from "./draw.js";
import { length, project, scale, add, sub } from "./math.js";
import { Controls } from "./panel.js";
import { Plot } from "./plots.js";
import { Pointer } from "./pointer.js";
import { Film, saveStill } from "./save.js";
import { drawLegend } from "./scale.js";
import { Solids } from "./solids.js";
import { Wire } from "./wire.js";

/** @type {<Id extends keyof Elements>(id: Id) => Elements[Id]} */
const $ = (id) => /** @type {any} */ (document.getElementById(id));
/** @type {(value: number | null) => string} */
const percent = (value) => (value === null ? "–" : `${(100 * value).toFixed(value < 0.2 ? 2 : 1)} %`);

/** @typedef {"play" | "step" | "reset" | "limit" | "compare" | "throw" | "touches"} Action */

/** Buttons that choose how cloth is coloured. */
const colours = () => /** @type {NodeListOf<HTMLButtonElement>} */ ($("colour").querySelectorAll("button"));

/**
 * Figures in the colours of their curves.
 * @param {string[]} texts
 * @returns {(Node | string)[]}
 */
function figures(texts) {
  return texts.flatMap((text, index) => {
    const figure = Object.assign(document.createElement("b"), { textContent: text, className: `curve-${index % 3}` });
    return [figure, " "];
  });
}

export class Viewer {
  constructor() {
    this.canvas = $("picture");
    this.drawing = new Drawing(this.canvas);
    this.camera = new Camera();
    /** @type {Layout | null} */
    this.layout = null;
    /** @type {Mesh[]} */
    this.meshes = [];
    /** @type {Cloth[]} */
    this.cloths = [];
    /** @type {Picture | null} */
    this.picture = null;
    /** @type {Partial<Status>} */
    this.status = {};
    this.live = true;
    /** @type {Look} */
    this.look = { colour: "fabric", marks: true, limit: null, floor: 0, radius: 1, centre: [0, 0, 0], cell: 0.1 };
    this.legendDrawn = false;
    /** @type {string | undefined} */
    this.namesShown = undefined;
    /**
     * The strain limit that is switched on again.
     * @type {number | string}
     */
    this.filter = "coarse_to_fine";
    /** @type {Film | null} */
    this.film = null;
    /** @type {number | undefined} */
    this.noteTimer = undefined;
    /** @type {Picture | null} */
    this.waiting = null;
    this.stale = false;
    this.plots = {
      stretch: new Plot($("plot-stretch"), () => this.look.limit),
      energy: new Plot($("plot-energy")),
      cost: new Plot($("plot-cost"), () => (this.live ? 1000 / 60 : null)),
    };
    /** Whether contacts are shown. */
    this.touching = false;
    this.pointer = new Pointer(this.canvas, this);
    this.controls = new Controls($("controls"), (control, value) => this.later(() => this.send("set", { control, value }), control));
    /** @type {Map<string, () => void>} */
    this.orders = new Map();
    this.bindButtons();
    new ResizeObserver(() => this.redraw()).observe($("stage"));
    this.wire = new Wire({
      layout: (message) => this.takeLayout(message),
      picture: (message) => this.takePicture(message),
      status: (message) => this.takeStatus(message),
      refused: ({ text }) => this.note(text),
      lost: () => ($("lost").hidden = false),
    });
  }

  /**
   * @param {string} type
   * @param {object | undefined} fields
   */
  send(type, fields = undefined) {
    this.wire.send(type, fields);
  }

  /**
   * Send with the next picture at the latest; of several orders for one thing only the last.
   * @param {() => void} order
   * @param {string} subject
   */
  later(order, subject = "pointer") {
    this.orders.set(subject, order);
    this.redraw();
  }

  touched() {
    $("hint").classList.add("gone");
  }

  // What comes from the server.

  /** @param {Layout} layout */
  takeLayout(layout) {
    $("lost").hidden = true;
    this.live = layout.live;
    for (const old of [...this.cloths, ...this.cloths.flatMap(({ solids }) => solids.all), ...this.meshes]) this.drawing.forget(old);
    this.layout = layout;
    this.meshes = layout.meshes.map((_, index) => new Mesh(layout, index));
    this.cloths = [];
    this.picture = this.waiting = null;
    const { low, high } = new Solids(layout, 0, this.meshes[0]).widened(this.meshes[0].box());
    this.look.radius = Math.max(0.05, 0.5 * length(sub(high, low)));
    this.look.centre = scale(add(low, high), 0.5);
    this.look.cell = 10 ** Math.round(Math.log10(this.look.radius / 8));
    this.look.floor = Math.min(0, low[2]);
    if (low[2] > 3 * this.look.radius) this.look.floor = low[2] - this.look.radius;
    const { floor } = this.meshes[0];
    if (floor !== null) this.look.floor = floor;
    this.goHome();
    for (const id of /** @type {const} */ (["seek", "looping"])) $(id).hidden = this.live;
    for (const id of /** @type {const} */ (["limiting", "touching", "controls"])) $(id).hidden = !this.live;
    if (this.touching) this.send("contacts", { on: true });
    if (!this.live) $("hint").textContent = "Drag to turn the view; the wheel or two fingers come closer.";
  }

  goHome() {
    this.camera.home(this.look.centre, 1.12 * this.look.radius);
    this.redraw();
  }

  /** @param {Picture} picture */
  takePicture(picture) {
    this.waiting = picture;
    this.redraw();
  }

  /** @param {Status} status */
  takeStatus(status) {
    const before = this.status;
    this.status = status;
    $("title").textContent = status.title || "taut";
    document.title = status.title ? `${status.title} – taut` : "taut";
    $("play").classList.toggle("on", status.playing);
    $("speed").value = String(status.speed);
    if (this.live) {
      this.controls.update(status.controls);
      const filter = status.controls.find(({ name }) => name === "filter")?.value ?? "none";
      if (filter !== "none") this.filter = filter;
      $("limit").setAttribute("aria-pressed", String(filter !== "none"));
      /** @type {Element} */ ($("limit").firstElementChild).textContent = filter === "none" ? "Limit off" : "Limit on";
      $("compare").setAttribute("aria-pressed", String(status.compare));
    } else {
      $("seek").max = String(status.frames - 1);
      $("loop").checked = status.loop;
    }
    if (status.note[1] && status.note[0] !== before.note?.[0]) this.note(status.note[1]);
  }

  /** @param {string} text */
  note(text) {
    $("note").textContent = text;
    $("note").hidden = false;
    clearTimeout(this.noteTimer);
    this.noteTimer = setTimeout(() => ($("note").hidden = true), 7000);
  }

  // Drawing.

  redraw() {
    if (this.stale) return;
    this.stale = true;
    requestAnimationFrame(() => {
      this.stale = false;
      this.update();
    });
  }

  update() {
    const orders = [...this.orders.values()];
    this.orders.clear();
    for (const order of orders) order();
    if (this.waiting) this.show(this.waiting);
    if (this.picture) this.paint();
  }

  /**
   * Take a picture over: positions, numbers, curves.
   * @param {Picture} picture
   */
  show(picture) {
    const { layout } = this;
    if (!layout) return;
    this.waiting = null;
    this.picture = picture;
    while (this.cloths.length < picture.panels.length) {
      const index = picture.panels[this.cloths.length].mesh;
      this.cloths.push(new Cloth(this.meshes[index], new Solids(layout, index, this.meshes[index])));
    }
    for (const cloth of this.cloths.splice(picture.panels.length)) for (const one of [cloth, ...cloth.solids.all]) this.drawing.forget(one);
    picture.panels.forEach((panel, index) => {
      const cloth = this.cloths[index];
      cloth.update(picture.arrays[`positions${index}`], panel.limits);
      cloth.solids.update(picture, index);
      this.drawing.upload(cloth);
      if (this.meshes[0].floor !== null) return;
      for (let i = 2; i < cloth.positions.length; i += 3) {
        if (cloth.positions[i] < this.look.floor) this.look.floor = cloth.positions[i];
      }
    });
    this.showNumbers(picture);
    this.send("seen", { number: picture.number });
  }

  /** @param {Picture} picture */
  showNumbers({ panels, time, frame, factor }) {
    const limits = panels.flatMap((panel) => panel.limits.flatMap((limit) => limit ?? []));
    const limit = limits.length ? Math.max(...limits) : null;
    if (limit !== this.look.limit || !this.legendDrawn) {
      this.legendDrawn = true;
      this.look.limit = limit;
      drawLegend($("ramp"), $("ticks"), limit);
    }
    const now = performance.now() / 1000;
    this.plots.stretch.push(now, panels.map((panel) => panel.worst));
    this.plots.energy.push(now, panels[0].energies);
    this.plots.cost.push(now, panels.map((panel) => panel.ms));
    const allowed = limit === null ? "" : `λ ${+(100 * limit).toFixed(1)} %`;
    $("worst").replaceChildren(...figures(panels.map((panel) => percent(panel.worst))), allowed);
    $("energy").replaceChildren(...figures(panels[0].energies.map((energy) => (energy ?? NaN).toFixed(2))), "J");
    $("cost").replaceChildren(...figures(panels.map((panel) => (panel.ms ?? NaN).toFixed(1))), "ms");
    this.showContacts(panels);
    $("over").textContent = this.cloths.map((cloth) => cloth.overCount).join(" | ");
    $("clock").textContent = `${time.toFixed(2)} s`;
    $("rate").textContent = factor > 0 ? `${factor.toFixed(2)}×` : "paused";
    if (!this.live && document.activeElement !== $("seek")) $("seek").value = String(frame);
    this.showNames(panels);
  }

  /**
   * The least distance and how many pairs were near, where anything ever was.
   * @param {Panel[]} panels
   */
  showContacts(panels) {
    if (panels.some(({ contacts, closest }) => (contacts ?? 0) > 0 || closest !== null)) $("nearness").hidden = false;
    $("closest").replaceChildren(...figures(panels.map(({ closest }) => (closest === null ? "–" : (1e3 * closest).toFixed(2)))), "mm");
    $("contacts").replaceChildren(...figures(panels.map(({ contacts }) => (contacts ?? NaN).toFixed(0))));
  }

  /** @param {Panel[]} panels */
  showNames(panels) {
    const names = panels.length > 1 ? panels.map(({ name, limited }) => (this.live && !limited ? "without limit" : name.replaceAll("_", " "))) : [];
    const key = names.join("|") + this.canvas.clientWidth;
    if (key === this.namesShown) return;
    this.namesShown = key;
    const views = names.length ? this.views() : [];
    $("names").replaceChildren(...names.map((name, index) => {
      const span = Object.assign(document.createElement("span"), { textContent: name, className: `curve-${index % 3}` });
      const { x, y, width } = views[index].css;
      span.style.left = `${x + width / 2}px`;
      span.style.top = `${y + 10}px`;
      return span;
    }));
  }

  /**
   * The parts of the canvas, one for each cloth: in pixels of the page (css) and of the canvas (part).
   * @returns {View[]}
   */
  views() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const count = this.cloths.length, wide = width >= height;
    return this.cloths.map((cloth, index) => {
      const css = wide
        ? { x: (index * width) / count, y: 0, width: width / count, height }
        : { x: 0, y: (index * height) / count, width, height: height / count };
      const d = this.canvas.width / Math.max(1, width);
      const part = { x: css.x * d, y: (height - css.y - css.height) * d, width: css.width * d, height: css.height * d };
      const hands = this.handsOn(cloth);
      return { cloth, css, part, camera: this.camera.matrix(css.width / css.height), hands, hovered: this.pointer.hovered };
    });
  }

  /**
   * What this page and others hold.
   * @param {Cloth} cloth
   * @returns {Hand[]}
   */
  handsOn(cloth) {
    const { drag } = this.pointer;
    /** @type {Hand[]} */
    const own = [];
    if (drag?.body !== undefined) own.push({ from: sub(cloth.solids.middle(drag.body), drag.lead), target: drag.target });
    else if (drag?.vertex !== undefined && drag.group === undefined) own.push({ from: cloth.at(drag.vertex), target: drag.target });
    const others = (this.picture?.held ?? []).filter((vertex) => vertex !== drag?.vertex);
    return [...own, ...others.map((vertex) => ({ from: cloth.at(vertex), target: cloth.at(vertex) }))];
  }

  paint() {
    if (!this.picture) return;
    const density = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.round(this.canvas.clientWidth * density), height = Math.round(this.canvas.clientHeight * density);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const wind = this.meshes[0].fromScene(this.picture.wind);
    const views = this.views();
    this.drawing.draw(views, { ...this.look, wind, eye: this.camera.eye, height: this.camera.height, density });
    $("legend").hidden = this.look.colour !== "strain";
    for (const plot of Object.values(this.plots)) plot.draw();
  }

  /**
   * Where a vertex is on the page [css pixels]; for tests and the console.
   * @param {number} vertex
   * @param {number} panel
   */
  where(vertex, panel = 0) {
    const { css, camera, cloth } = this.views()[panel];
    const [x, y] = project(camera, cloth.at(vertex));
    return [css.x + ((x + 1) * css.width) / 2, css.y + ((1 - y) * css.height) / 2];
  }

  // What people do beside the picture.

  bindButtons() {
    $("play").onclick = () => this.send("play", { on: !this.status.playing });
    $("step").onclick = () => this.send("step");
    $("reset").onclick = () => this.send("reset");
    $("speed").onchange = () => this.send("speed", { value: Number($("speed").value) });
    $("limit").onclick = () => this.switchLimit();
    $("compare").onclick = () => this.send("compare", { on: !this.status.compare });
    $("throw").onclick = () => this.throwBall();
    $("touches").onclick = () => this.showTouches(!this.touching);
    $("seek").oninput = () => this.later(() => this.send("seek", { frame: Number($("seek").value) }), "seek");
    $("seek").onchange = () => $("seek").blur();
    $("loop").onchange = () => this.send("loop", { on: $("loop").checked });
    $("home").onclick = () => this.goHome();
    $("marks").onchange = () => {
      this.look.marks = $("marks").checked;
      this.redraw();
    };
    for (const button of colours()) button.onclick = () => this.colour(/** @type {Colouring} */ (button.dataset.colour));
    $("still").onclick = () => {
      this.paint();
      saveStill(this.canvas);
    };
    $("film").onclick = () => this.takeFilm();
    document.addEventListener("keydown", (event) => this.key(event));
  }

  switchLimit() {
    const off = $("limit").getAttribute("aria-pressed") === "false";
    this.send("set", { control: "filter", value: off ? this.filter : "none" });
  }

  /** Throw a ball from below the eye to where the pointer is. */
  throwBall() {
    if (!this.picture) return;
    this.touched();
    const { eye } = this.camera;
    const { mesh, target } = this.pointer.aim();
    const { right, up } = this.camera.axes();
    const way = sub(target, eye), far = length(way);
    const start = add(add(eye, scale(way, 0.12)), add(scale(up, -0.08 * far), scale(right, 0.05 * far)));
    this.send("throw", { start: mesh.asInScene(start), target: mesh.asInScene(target) });
  }

  /** @param {boolean} on */
  showTouches(on) {
    this.touching = on;
    $("touches").setAttribute("aria-pressed", String(on));
    this.send("contacts", { on });
  }

  /** @param {Colouring} name */
  colour(name) {
    this.look.colour = name;
    for (const button of colours()) button.setAttribute("aria-pressed", String(button.dataset.colour === name));
    this.redraw();
  }

  takeFilm() {
    try {
      if (this.film) this.film.stop();
      this.film = this.film ? null : new Film(this.canvas);
    } catch (error) {
      this.note(/** @type {Error} */ (error).message);
    }
    $("film").setAttribute("aria-pressed", String(Boolean(this.film)));
    $("film").textContent = this.film ? "Save film" : "Film";
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    // Buttons answer to the space bar themselves.
    const own = event.key === " " ? ["INPUT", "SELECT", "BUTTON", "SUMMARY"] : ["INPUT", "SELECT"];
    if (own.includes(/** @type {Element} */ (event.target).tagName) || event.ctrlKey || event.metaKey) return;
    /** @type {Record<string, Action>} */
    const actions = { " ": "play", ArrowRight: "step", r: "reset", l: "limit", c: "compare", b: "throw", k: "touches" };
    const button = actions[event.key.length > 1 ? event.key : event.key.toLowerCase()];
    if (!button || (!this.live && ["limit", "compare", "throw", "touches"].includes(button))) return;
    event.preventDefault();
    $(button).click();
  }
}

try {
  window.viewer = new Viewer();
} catch (error) {
  $("hint").textContent = /** @type {Error} */ (error).message;
}
