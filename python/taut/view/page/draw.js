/** Draws cloths side by side: floor, shadows, cloth, bodies, pins, wind, springs over their limit. */

import { along, add, length, lookAt, multiply, orthographic, scale, unit } from "./math.js";
import { LEVELS, ramp, topOf } from "./scale.js";
import { SHADERS, compile } from "./shaders.js";
import { arrow, ball } from "./shapes.js";

/** @type {Vec3} */
const BACKGROUND = [0.902, 0.918, 0.933];
const SUN = unit([-0.35, -0.62, 0.95]);
const SHADOW_SIZE = 1024;
const IDENTITY = along([0, 0, 1], 1, [0, 0, 0]);
const STONE = [0.55, 0.62, 0.69];
const PLANE = [0.78, 0.82, 0.86];
const THROWN = [0.2, 0.46, 0.45];
/** Where cloth touches something. */
const TOUCHING = [0.13, 0.2, 0.86];
const COLOURINGS = { fabric: 0, grid: 1, strain: 2 };

/** @typedef {import("./cloth.js").Cloth} Cloth */
/** @typedef {import("./solids.js").Solids} Solids */
/** @typedef {import("./solids.js").Triangles} Triangles */

/**
 * What something has on the card, to which it was sent before it is drawn.
 * @template Buffers
 * @param {{ onCard?: Buffers }} one
 * @returns {Buffers}
 */
function cardOf({ onCard }) {
  if (!onCard) throw new Error("this was not sent to the graphics card");
  return onCard;
}

export class Drawing {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser has no WebGL 2, which the picture needs");
    this.gl = gl;
    this.programs = Object.fromEntries(Object.entries(SHADERS).map(([name, pair]) => [name, compile(gl, pair)]));
    this.ball = this.shape(ball());
    this.arrow = this.shape(arrow());
    this.quad = this.buffer(new Float32Array([-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0]));
    this.ribbon = this.buffer(new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]));
    this.segments = gl.createBuffer();
    this.instances = gl.createBuffer();
    this.arrays = gl.createVertexArray();
    this.shadows = gl.createTexture();
    this.frame = gl.createFramebuffer();
    this.makeShadows();
    this.ramp = gl.createTexture();
    /** @type {number | null | undefined} */
    this.rampLimit = undefined;
  }

  /**
   * @param {Numbers} data
   * @param {number} target
   */
  buffer(data, target = this.gl.ARRAY_BUFFER) {
    const buffer = this.gl.createBuffer();
    this.gl.bindBuffer(target, buffer);
    this.gl.bufferData(target, data, this.gl.STATIC_DRAW);
    return buffer;
  }

  /** @param {import("./shapes.js").Shape} shape */
  shape({ positions, normals }) {
    const count = positions.length / 3;
    return { count, positions: this.buffer(new Float32Array(positions)), normals: this.buffer(new Float32Array(normals)) };
  }

  makeShadows() {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.shadows);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadows, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /**
   * Send what changed in a cloth, and what never does the first time.
   * @param {Cloth} cloth
   */
  upload(cloth) {
    const { gl } = this;
    const { mesh } = cloth;
    gl.bindVertexArray(null);
    mesh.onCard ??= { faces: this.buffer(mesh.faces, gl.ELEMENT_ARRAY_BUFFER), texture: this.buffer(mesh.texture) };
    cloth.onCard ??= { positions: gl.createBuffer(), normals: gl.createBuffer(), stretch: gl.createBuffer() };
    for (const name of /** @type {const} */ (["positions", "normals", "stretch"])) {
      gl.bindBuffer(gl.ARRAY_BUFFER, cloth.onCard[name]);
      gl.bufferData(gl.ARRAY_BUFFER, cloth[name], gl.DYNAMIC_DRAW);
    }
    for (const solid of cloth.solids.all) this.uploadSolid(solid);
  }

  /**
   * Send the triangles of bodies, if they moved.
   * @param {Triangles} solid
   */
  uploadSolid(solid) {
    const { gl } = this;
    solid.onCard ??= { faces: gl.createBuffer(), positions: gl.createBuffer(), normals: gl.createBuffer() };
    if (solid.hasNewFaces) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, solid.onCard.faces);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, solid.faces, gl.STATIC_DRAW);
    }
    solid.hasNewFaces = false;
    if (!solid.isNew) return;
    solid.isNew = false;
    for (const name of /** @type {const} */ (["positions", "normals"])) {
      gl.bindBuffer(gl.ARRAY_BUFFER, solid.onCard[name]);
      gl.bufferData(gl.ARRAY_BUFFER, solid[name], gl.DYNAMIC_DRAW);
    }
  }

  /**
   * Free what a cloth has on the card.
   * @param {{ onCard?: Record<string, WebGLBuffer> }} one
   */
  forget(one) {
    for (const buffer of Object.values(one.onCard ?? {})) this.gl.deleteBuffer(buffer);
  }

  /**
   * Draw a picture: `views` have a cloth and their part of the canvas in pixels; see main.js for `look`.
   * @param {View[]} views
   * @param {LookNow} look
   */
  draw(views, look) {
    const { gl } = this;
    gl.bindVertexArray(this.arrays);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(...BACKGROUND, 1);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.setRamp(look.limit);
    for (const view of views) {
      const sun = this.drawShadows(view.cloth, look);
      const { x, y, width, height } = view.part;
      gl.viewport(x, y, width, height);
      const light = { sun: SUN, eye: look.eye, sunMatrix: sun, camera: view.camera };
      // From below the floor would hide what lies on it.
      if (look.eye[2] > look.floor) this.drawFloor(light, look);
      this.drawCloth(view.cloth, light, look);
      this.drawBodies(view.cloth.solids, light);
      this.drawLines(view, look);
      this.drawSolids(view, light, look);
    }
  }

  /** @param {number | null} limit */
  setRamp(limit) {
    const { gl } = this;
    if (limit === this.rampLimit) return;
    this.rampLimit = limit;
    gl.bindTexture(gl.TEXTURE_2D, this.ramp);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, LEVELS, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, ramp(limit));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  }

  /**
   * @param {Cloth} cloth
   * @param {LookNow} look
   */
  drawShadows(cloth, look) {
    const { gl } = this;
    const half = 1.9 * look.radius;
    const eye = add(look.centre, scale(SUN, 4 * look.radius));
    const camera = multiply(orthographic(half, 0.5 * look.radius, 9 * look.radius), lookAt(eye, look.centre, [0, 0, 1]));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.use("depth", { camera });
    this.triangles(cardOf(cloth).positions, cardOf(cloth.mesh).faces, cloth.mesh.faces.length);
    for (const solid of [cloth.solids.bodies, cloth.solids.ball]) {
      if (solid.faces.length) this.triangles(cardOf(solid).positions, cardOf(solid).faces, solid.faces.length);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return camera;
  }

  /**
   * @param {Light} light
   * @param {LookNow} look
   */
  drawFloor(light, look) {
    const { gl } = this;
    const centre = [look.centre[0], look.centre[1], look.floor];
    const values = { ...light, centre, reach: 14 * look.radius, background: BACKGROUND, cell: look.cell * 2.5 };
    this.use("floor", values);
    this.attribute(0, this.quad, 3);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    this.clean(1);
  }

  /**
   * @param {Cloth} cloth
   * @param {Light} light
   * @param {LookNow} look
   */
  drawCloth(cloth, light, look) {
    const { gl } = this;
    const top = topOf(look.limit);
    this.use("cloth", { ...light, colouring: COLOURINGS[look.colour], top, cell: look.cell });
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.ramp);
    gl.activeTexture(gl.TEXTURE0);
    const { positions, normals, stretch } = cardOf(cloth), { faces, texture } = cardOf(cloth.mesh);
    this.attribute(1, normals, 3);
    this.attribute(2, stretch, 1);
    this.attribute(3, texture, 2);
    this.triangles(positions, faces, cloth.mesh.faces.length);
    this.clean(4);
  }

  /**
   * @param {Solids} solids
   * @param {Light} light
   */
  drawBodies({ bodies, squares, ball }, light) {
    const { gl } = this;
    this.body(bodies, STONE, light);
    this.body(ball, THROWN, light);
    // From behind a plane would hide what it holds up.
    gl.enable(gl.CULL_FACE);
    this.body(squares, PLANE, light);
    gl.disable(gl.CULL_FACE);
  }

  /**
   * @param {Triangles} triangles
   * @param {number[]} paint
   * @param {Light} light
   */
  body(triangles, paint, light) {
    const { faces } = triangles;
    if (!faces.length) return;
    const onCard = cardOf(triangles);
    this.use("body", { ...light, paint });
    this.attribute(1, onCard.normals, 3);
    this.triangles(onCard.positions, onCard.faces, faces.length);
    this.clean(2);
  }

  /**
   * @param {WebGLBuffer} positions
   * @param {WebGLBuffer} faces
   * @param {number} count
   */
  triangles(positions, faces, count) {
    const { gl } = this;
    this.attribute(0, positions, 3);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, faces);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }

  /**
   * @param {View} view
   * @param {LookNow} look
   */
  drawLines(view, look) {
    const { cloth } = view;
    const bare = cloth.mesh.bare;
    if (bare.length) this.ribbons(view, cloth.segments(bare), [0.55, 0.2, 0.14], 2.2 * look.density, 0);
    // The colours of the stretch say it already.
    if (look.marks && look.colour !== "strain" && cloth.overCount) {
      // Thin enough to leave most of the cloth to be seen where all springs are marked.
      const long = (0.5 * cloth.mesh.meanLength * view.part.height) / look.height;
      this.ribbons(view, cloth.over, [1, 0.84, 0.2], Math.min(1.5 * look.density, Math.max(0.25, 0.2 * long)), 6e-4);
    }
    const threads = view.hands.flatMap(({ from, target }) => [...from, ...target]);
    if (threads.length) this.ribbons(view, new Float32Array(threads), [0.1, 0.13, 0.16], 2 * look.density, 2e-3);
  }

  /**
   * @param {View} view
   * @param {Float32Array} segments
   * @param {number[]} paint
   * @param {number} width
   * @param {number} nearer
   */
  ribbons({ camera, part }, segments, paint, width, nearer) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.segments);
    gl.bufferData(gl.ARRAY_BUFFER, segments, gl.DYNAMIC_DRAW);
    // A ribbon of less than a pixel is drawn as one that lets the cloth through.
    const [red, green, blue] = paint, seen = Math.min(1, width);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.use("lines", { camera, size: [part.width, part.height], width: Math.max(1, width), nearer, paint: [red, green, blue, seen] });
    this.attribute(0, this.ribbon, 2);
    this.attribute(1, this.segments, 3, 24, 0, 1);
    this.attribute(2, this.segments, 3, 24, 12, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, segments.length / 6);
    gl.disable(gl.BLEND);
    this.clean(3);
  }

  /**
   * @param {View} view
   * @param {Light} light
   * @param {LookNow} look
   */
  drawSolids({ cloth, hands, hovered }, light, look) {
    /** @type {number[]} */
    const pins = [];
    /** @type {number[]} */
    const chosen = [];
    cloth.mesh.pins.forEach((group, number) => {
      // A few pins are large, a row of them makes a line.
      const size = look.radius * (group.length > 6 ? 0.0065 : 0.014) * (number === hovered ? 1.4 : 1);
      for (const vertex of group) (number === hovered ? chosen : pins).push(...cloth.at(vertex), size);
    });
    this.solids(this.ball, pins, [0.16, 0.2, 0.24], IDENTITY, light);
    this.solids(this.ball, chosen, [0.95, 0.62, 0.1], IDENTITY, light);
    const held = hands.flatMap(({ target }) => [...target, 0.014 * look.radius]);
    this.solids(this.ball, held, [0.12, 0.15, 0.18], IDENTITY, light);
    this.drawTouches(cloth, light, look);
    const speed = length(look.wind);
    if (speed > 0.05) {
      const long = look.radius * Math.min(0.5, 0.12 + 0.035 * speed);
      const way = unit(look.wind);
      // Against the wind from the middle of the cloth, near its top.
      const place = add(look.centre, add(scale(way, -0.68 * look.radius - long), [0, 0, 0.66 * look.radius]));
      const model = along(way, long, [0, 0, 0]);
      this.solids(this.arrow, [...place, 1], [0.17, 0.42, 0.66], model, light);
    }
  }

  /**
   * Mark where cloth touches something: larger where it is pushed harder, faint where something is before it.
   * @param {Cloth} cloth
   * @param {Light} light
   * @param {LookNow} look
   */
  drawTouches({ mesh, solids: { touches } }, light, look) {
    const { gl } = this;
    const size = Math.min(0.3 * mesh.meanLength, 0.01 * look.radius);
    const strongest = Math.max(0, ...touches.map(({ force }) => force));
    const marks = touches.flatMap(({ place, force }) => [...place, size * (0.5 + Math.sqrt(force / strongest))]);
    gl.enable(gl.BLEND);
    gl.blendColor(0, 0, 0, 0.3);
    gl.blendFunc(gl.CONSTANT_ALPHA, gl.ONE_MINUS_CONSTANT_ALPHA);
    gl.depthFunc(gl.GREATER);
    gl.depthMask(false);
    this.solids(this.ball, marks, TOUCHING, IDENTITY, light);
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
    gl.disable(gl.BLEND);
    this.solids(this.ball, marks, TOUCHING, IDENTITY, light);
  }

  /**
   * @param {{ count: number, positions: WebGLBuffer, normals: WebGLBuffer }} shape
   * @param {number[]} instances
   * @param {number[]} paint
   * @param {Float32Array} model
   * @param {Light} light
   */
  solids(shape, instances, paint, model, light) {
    const { gl } = this;
    if (!instances.length) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.instances);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(instances), gl.DYNAMIC_DRAW);
    this.use("solid", { ...light, paint, model });
    this.attribute(0, shape.positions, 3);
    this.attribute(1, shape.normals, 3);
    this.attribute(2, this.instances, 4, 0, 0, 1);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, shape.count, instances.length / 4);
    this.clean(3);
  }

  /**
   * @param {number} place
   * @param {WebGLBuffer} buffer
   * @param {number} size
   * @param {number} stride
   * @param {number} offset
   * @param {number} divisor
   */
  attribute(place, buffer, size, stride = 0, offset = 0, divisor = 0) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(place, divisor);
  }

  /** @param {number} count */
  clean(count) {
    for (let place = 0; place < count; place++) this.gl.disableVertexAttribArray(place);
  }

  /**
   * Choose a program and give it values; those that it does not have are left out.
   * @param {keyof typeof SHADERS} name
   * @param {Record<string, Uniform>} values
   */
  use(name, values) {
    const { gl } = this;
    const { program, uniforms } = this.programs[name];
    gl.useProgram(program);
    if (uniforms.shadows !== undefined) {
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, this.shadows);
      gl.uniform1i(uniforms.shadows, 0);
    }
    if (uniforms.ramp !== undefined) gl.uniform1i(uniforms.ramp, 1);
    for (const [key, value] of Object.entries(values)) {
      const place = uniforms[key];
      if (place === undefined) continue;
      if (typeof value === "number") {
        if (key === "colouring") gl.uniform1i(place, value);
        else gl.uniform1f(place, value);
      } else if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
      else if (value.length === 2) gl.uniform2fv(place, value);
      else if (value.length === 3) gl.uniform3fv(place, value);
      else gl.uniform4fv(place, value);
    }
  }
}
