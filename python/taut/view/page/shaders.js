/** What the graphics card does: every program as a pair of vertex and fragment shader. */

const HEAD = "#version 300 es\nprecision highp float;\nprecision highp sampler2DShadow;\n";

/** Light of the sky, the sun and its shadow; `lit` is a colour in that light. */
const LIGHT = `
uniform vec3 sun;
uniform vec3 eye;
uniform mat4 sunMatrix;
uniform sampler2DShadow shadows;
float sunlight(vec3 place, float slope) {
  vec3 at = (sunMatrix * vec4(place, 1.0)).xyz * 0.5 + 0.5;
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  at.z -= 0.0012 + 0.004 * slope;
  float sum = 0.0;
  vec2 texel = 1.2 / vec2(textureSize(shadows, 0));
  for (int i = 0; i < 4; i++) {
    vec2 shift = vec2(float(i % 2) * 2.0 - 1.0, float(i / 2) * 2.0 - 1.0);
    sum += texture(shadows, vec3(at.xy + shift * texel, at.z));
  }
  return 0.25 * sum;
}
vec3 toScreen(vec3 light) { return pow(light / (1.0 + 0.18 * light), vec3(1.0 / 2.2)); }
vec3 fromScreen(vec3 colour) { return pow(colour, vec3(2.2)); }
const vec3 SKY = vec3(0.66, 0.74, 0.84);
const vec3 EARTH = vec3(0.42, 0.40, 0.38);
const vec3 SUN = vec3(1.0, 0.95, 0.87);
`;

const cloth = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float stretch;
layout(location = 3) in vec2 flat2;
uniform mat4 camera;
out vec3 place; out vec3 turned; out float strained; out vec2 fabric;
void main() {
  place = position; turned = normal; strained = stretch; fabric = flat2;
  gl_Position = camera * vec4(position, 1.0);
}`,
  fragment: `${HEAD}${LIGHT}
in vec3 place; in vec3 turned; in float strained; in vec2 fabric;
uniform int colouring;       // 0 fabric, 1 grid, 2 stretch
uniform sampler2D ramp;
uniform float top;           // stretch at the end of the ramp
uniform float cell;          // of the grid [m]
out vec4 colour;
float lines(vec2 at, float width) {
  vec2 away = abs(fract(at - 0.5) - 0.5);
  vec2 blur = fwidth(at);
  vec2 drawn = 1.0 - smoothstep(width - blur, width + blur, away);
  return max(drawn.x, drawn.y) * clamp(1.5 - 1.5 * max(blur.x, blur.y), 0.0, 1.0);
}
void main() {
  vec3 n = normalize(turned);
  bool front = gl_FrontFacing;
  if (!front) n = -n;
  vec3 base = fromScreen(front ? vec3(0.76, 0.27, 0.18) : vec3(0.93, 0.84, 0.66));
  if (colouring == 0) {
    vec2 thread = fabric * 420.0;
    float seen = clamp(1.2 - 1.6 * max(fwidth(thread.x), fwidth(thread.y)) / 3.14, 0.0, 1.0);
    base *= 1.0 + 0.10 * seen * sin(thread.x) * sin(thread.y);
  } else if (colouring == 1) {
    base = mix(base, fromScreen(front ? vec3(0.99, 0.93, 0.84) : vec3(0.63, 0.25, 0.17)), 0.85 * lines(fabric / cell, 0.055));
  } else {
    float share = strained / top;
    base = fromScreen(share > 1.0 ? vec3(0.404, 0.102, 0.502) : texture(ramp, vec2(clamp(share, 0.002, 0.998), 0.5)).rgb);
    if (!front) base *= 0.72;
  }
  float facing = dot(n, sun);
  float bright = sunlight(place + 0.004 * n, 1.0 - abs(facing));
  vec3 light = mix(EARTH, SKY, 0.5 + 0.5 * n.z) * 0.62;
  light += SUN * bright * (1.15 * max(facing, 0.0) + 0.22 * max(-facing, 0.0));
  vec3 halfway = normalize(sun + normalize(eye - place));
  float gloss = 0.10 * bright * pow(max(dot(n, halfway), 0.0), 24.0) * step(0.0, facing);
  colour = vec4(toScreen(base * light + gloss), 1.0);
}`,
};

const depth = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
uniform mat4 camera;
void main() { gl_Position = camera * vec4(position, 1.0); }`,
  fragment: `${HEAD}void main() {}`,
};

const floor = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
uniform mat4 camera;
uniform vec3 centre;
uniform float reach;
out vec3 place;
void main() {
  place = vec3(centre.xy + reach * position.xy, centre.z);
  gl_Position = camera * vec4(place, 1.0);
}`,
  fragment: `${HEAD}${LIGHT}
in vec3 place;
uniform vec3 centre;
uniform float reach;
uniform vec3 background;
uniform float cell;
out vec4 colour;
void main() {
  vec2 at = place.xy / cell;
  vec2 away = abs(fract(at - 0.5) - 0.5) / max(fwidth(at), vec2(1e-5));
  float grid = 0.10 * (1.0 - min(min(away.x, away.y), 1.0));
  float bright = sunlight(place, 0.0);
  vec3 ground = background * (1.0 - grid) * mix(0.74, 1.0, bright);
  float far = length(place.xy - centre.xy) / reach;
  colour = vec4(mix(ground, background, smoothstep(0.25, 0.9, far)), 1.0);
}`,
};

const solid = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 instance;   // place and size
uniform mat4 camera;
uniform mat4 model;
out vec3 place; out vec3 turned;
void main() {
  place = instance.xyz + instance.w * (model * vec4(position, 1.0)).xyz;
  turned = mat3(model) * normal;
  gl_Position = camera * vec4(place, 1.0);
}`,
  fragment: `${HEAD}${LIGHT}
in vec3 place; in vec3 turned;
uniform vec3 paint;
out vec4 colour;
void main() {
  vec3 n = normalize(turned);
  float bright = mix(0.6, 1.0, sunlight(place + 0.004 * n, 0.2));
  vec3 light = mix(EARTH, SKY, 0.5 + 0.5 * n.z) * 0.75 + SUN * bright * max(dot(n, sun), 0.0);
  colour = vec4(toScreen(fromScreen(paint) * light), 1.0);
}`,
};

const body = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 camera;
out vec3 place; out vec3 turned;
void main() {
  place = position; turned = normal;
  gl_Position = camera * vec4(position, 1.0);
}`,
  fragment: `${HEAD}${LIGHT}
in vec3 place; in vec3 turned;
uniform vec3 paint;
out vec4 colour;
void main() {
  vec3 n = normalize(turned);
  // Of meshes that are open, both sides are seen.
  if (dot(n, eye - place) < 0.0) n = -n;
  float facing = dot(n, sun);
  float bright = sunlight(place + 0.004 * n, 1.0 - abs(facing));
  vec3 light = mix(EARTH, SKY, 0.5 + 0.5 * n.z) * 0.68 + SUN * bright * max(facing, 0.0);
  vec3 halfway = normalize(sun + normalize(eye - place));
  float gloss = 0.08 * bright * pow(max(dot(n, halfway), 0.0), 24.0) * step(0.0, facing);
  colour = vec4(toScreen(fromScreen(paint) * light + gloss), 1.0);
}`,
};

/** Segments as ribbons of some pixels, a little nearer to the eye than they are. */
const lines = {
  vertex: `${HEAD}
layout(location = 0) in vec2 corner;     // 0 or 1 along, -1 or 1 across
layout(location = 1) in vec3 start;
layout(location = 2) in vec3 end;
uniform mat4 camera;
uniform vec2 size;                        // of the picture [pixels]
uniform float width;                      // [pixels]
uniform float nearer;
void main() {
  vec4 a = camera * vec4(start, 1.0), b = camera * vec4(end, 1.0);
  vec2 way = (b.xy / b.w - a.xy / a.w) * size;
  vec2 across = length(way) > 1e-4 ? normalize(vec2(-way.y, way.x)) : vec2(0.0, 1.0);
  vec4 at = corner.x < 0.5 ? a : b;
  at.xy += across * corner.y * width / size * at.w;
  at.z -= nearer * at.w;
  gl_Position = at;
}`,
  fragment: `${HEAD}
uniform vec4 paint;
out vec4 colour;
void main() { colour = paint; }`,
};

export const SHADERS = { cloth, depth, floor, body, solid, lines };

/**
 * A program with the places of its uniforms.
 * @param {WebGL2RenderingContext} gl
 * @param {{ vertex: string, fragment: string }} shaders
 */
export function compile(gl, { vertex, fragment }) {
  const program = gl.createProgram();
  for (const [kind, text] of /** @type {const} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
    const logs = (gl.getAttachedShaders(program) ?? []).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`a shader cannot be used: ${logs.join(" ")} ${gl.getProgramInfoLog(program)}`);
  }
  /** @type {Record<string, WebGLUniformLocation | null>} */
  const uniforms = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const { name } = /** @type {WebGLActiveInfo} */ (gl.getActiveUniform(program, i));
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  return { program, uniforms };
}
