/** Curves that run along with the time of the wall clock. */

const SECONDS = 12;
const COLOURS = ["#b23c26", "#2b6ca8", "#5d6b78"];

/** @type {(value: number | null) => value is number} */
const isFiniteNumber = (value) => Number.isFinite(value);

export class Plot {
  /**
   * `level`: draws a line where something shall be, if it says where.
   * @param {HTMLCanvasElement} canvas
   * @param {() => number | null} level
   */
  constructor(canvas, level = () => null) {
    this.canvas = canvas;
    this.level = level;
    /** @type {{ now: number, values: (number | null)[] }[]} */
    this.points = [];
  }

  clear() {
    this.points = [];
  }

  /**
   * Values of now, one for each curve.
   * @param {number} now
   * @param {(number | null)[]} values
   */
  push(now, values) {
    this.points.push({ now, values });
    while (this.points[0].now < now - SECONDS) this.points.shift();
  }

  draw() {
    const { canvas } = this;
    const density = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * density)) {
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
    }
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width, height);
    const finite = this.points.flatMap(({ values }) => values.filter(isFiniteNumber));
    const level = this.level();
    const high = 1.12 * Math.max(1e-9, ...finite, level ?? 0), low = Math.min(0, ...finite);
    const last = this.points.at(-1)?.now ?? 0;
    /** @param {number} now */
    const x = (now) => width - 2 - ((last - now) / SECONDS) * (width - 4);
    /** @param {number} value */
    const y = (value) => height - 3 - ((value - low) / (high - low)) * (height - 6);
    if (level !== null) {
      context.strokeStyle = "#1d2730";
      context.setLineDash([4, 4]);
      context.beginPath();
      context.moveTo(0, y(level));
      context.lineTo(width, y(level));
      context.stroke();
      context.setLineDash([]);
    }
    const curves = Math.max(0, ...this.points.map(({ values }) => values.length));
    for (let curve = 0; curve < curves; curve++) {
      context.strokeStyle = COLOURS[curve % COLOURS.length];
      context.lineWidth = 1.5;
      context.beginPath();
      let drawing = false;
      for (const { now, values } of this.points) {
        const value = values[curve];
        if (!isFiniteNumber(value)) {
          drawing = false;
          continue;
        }
        if (drawing) context.lineTo(x(now), y(value));
        else context.moveTo(x(now), y(value));
        drawing = true;
      }
      context.stroke();
    }
  }
}
