/** What the page's scripts share: vectors, what comes over the socket (python/taut/view/wire.py, picture.py) and what is drawn. */

type Vec3 = [number, number, number];
/** Reads as a vector. */
type Vector = ArrayLike<number>;
type Numbers = Float32Array | Int32Array | Uint32Array;

interface Ray {
  from: Vec3;
  way: Vec3;
}

interface Box {
  low: number[];
  high: number[];
}

/** Arrays of a message, by name. Which ones there are depends on the scene. */
type Arrays = Record<string, Numbers>;

interface MeshFacts {
  pins: number[][];
  first_vertices: number[];
  floor: number | null;
  /** Body and its triangles. */
  parts: [number, number][];
  square_parts: [number, number][];
}

interface Layout {
  type: "layout";
  live: boolean;
  up: number;
  meshes: MeshFacts[];
  arrays: Arrays;
}

interface Panel {
  mesh: number;
  name: string;
  limits: (number | null)[];
  limited: boolean;
  worst: number | null;
  energies: (number | null)[];
  ms: number | null;
  contacts: number | null;
  closest: number | null;
}

interface Picture {
  type: "picture";
  number: number;
  time: number;
  frame: number;
  factor: number;
  wind: Vec3;
  held: number[];
  panels: Panel[];
  arrays: Arrays;
}

interface Control {
  name: string;
  group: string;
  label: string;
  value: number | string;
  choices: string[];
  low: number;
  high: number;
  step: number;
  unit: string;
}

interface Status {
  type: "status";
  title: string;
  playing: boolean;
  speed: number;
  /** Of a simulation. */
  controls: Control[];
  compare: boolean;
  /** Of a recording. */
  frames: number;
  loop: boolean;
  /** Its number and its text. */
  note: [number, string];
}

interface Refusal {
  type: "refused";
  text: string;
}

/** What each message of the server is given to; `lost` is told that the connection is. */
interface Handlers {
  layout(message: Layout): void;
  picture(message: Picture): void;
  status(message: Status): void;
  refused(message: Refusal): void;
  lost(): void;
}

interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

interface Hand {
  from: Vec3;
  target: Vec3;
}

/** The part of the canvas with one cloth: in pixels of the page (css) and of the canvas (part). */
interface View {
  cloth: import("../../python/taut/view/page/cloth.js").Cloth;
  css: Rectangle;
  part: Rectangle;
  camera: Float32Array;
  hands: Hand[];
  hovered: number | null;
}

/** A point of the picture: x and y from -1 to 1. */
interface Place {
  view: View;
  x: number;
  y: number;
}

type Colouring = "fabric" | "grid" | "strain";

/** How everything is drawn that is seen in all views alike. */
interface Look {
  colour: Colouring;
  marks: boolean;
  limit: number | null;
  floor: number;
  radius: number;
  centre: Vec3;
  cell: number;
}

interface LookNow extends Look {
  wind: Vec3;
  eye: Vec3;
  height: number;
  density: number;
}

/** A value of a shader. */
type Uniform = number | number[] | Float32Array;

interface Light extends Record<string, Uniform> {
  sun: Vec3;
  eye: Vec3;
  sunMatrix: Float32Array;
  camera: Float32Array;
}

interface Window {
  /** For tests and the console. */
  viewer: object;
}

/** Elements of index.html that scripts use, by their id. */
interface Elements {
  picture: HTMLCanvasElement;
  ramp: HTMLCanvasElement;
  "plot-stretch": HTMLCanvasElement;
  "plot-energy": HTMLCanvasElement;
  "plot-cost": HTMLCanvasElement;
  speed: HTMLSelectElement;
  seek: HTMLInputElement;
  loop: HTMLInputElement;
  marks: HTMLInputElement;
  play: HTMLButtonElement;
  step: HTMLButtonElement;
  reset: HTMLButtonElement;
  limit: HTMLButtonElement;
  compare: HTMLButtonElement;
  throw: HTMLButtonElement;
  touches: HTMLButtonElement;
  still: HTMLButtonElement;
  film: HTMLButtonElement;
  home: HTMLButtonElement;
  stage: HTMLElement;
  names: HTMLElement;
  legend: HTMLElement;
  ticks: HTMLElement;
  hint: HTMLElement;
  note: HTMLElement;
  lost: HTMLElement;
  looping: HTMLElement;
  clock: HTMLElement;
  rate: HTMLElement;
  title: HTMLElement;
  limiting: HTMLElement;
  touching: HTMLElement;
  worst: HTMLElement;
  energy: HTMLElement;
  cost: HTMLElement;
  nearness: HTMLElement;
  closest: HTMLElement;
  contacts: HTMLElement;
  colour: HTMLElement;
  over: HTMLElement;
  controls: HTMLElement;
}

/** Where a ray met a triangle: how far along it, and the weights of the triangle's corners. */
interface Met {
  far: number;
  face: number;
  weights: Vec3;
}
