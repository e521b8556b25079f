/** Colours for stretch, the same as in taut's other pictures: cool up to the limit, warm above it. */

/** @typedef {[number, string]} Stop */

/** @type {Stop[]} */
const WITHIN = [[0, "#c3d0d8"], [0.4, "#98c3da"], [0.75, "#4f97c8"], [1, "#1d5c9c"]];
/** @type {Stop[]} */
const OVER = [[0, "#ffd75e"], [0.35, "#fb9a2b"], [0.7, "#e4432d"], [1, "#a3102e"]];
/** @type {Stop[]} */
const NO_LIMIT = [[0, "#c3d0d8"], [0.25, "#9fd0d8"], [0.5, "#f9dd7d"], [0.75, "#ef7b3a"], [1, "#a3102e"]];
const ROUNDING = 1.002;
export const LEVELS = 256;

/**
 * Where the scale ends, for a limit that may be null.
 * @type {(limit: number | null) => number}
 */
export const topOf = (limit) => (limit === null ? 0.2 : 3 * limit);

/**
 * Colours from no stretch to the top, four bytes each.
 * @param {number | null} limit
 */
export function ramp(limit) {
  const out = new Uint8Array(4 * LEVELS);
  const split = limit === null ? 2 : (limit / topOf(limit)) * ROUNDING;
  for (let i = 0; i < LEVELS; i++) {
    const share = i / (LEVELS - 1);
    let rgb;
    if (limit === null) rgb = between(NO_LIMIT, share);
    else if (share <= split) rgb = between(WITHIN, share / split);
    else rgb = between(OVER, (share - split) / (1 - split));
    out.set([...rgb, 255], 4 * i);
  }
  return out;
}

/**
 * @param {Stop[]} stops
 * @param {number} at
 */
function between(stops, at) {
  const next = Math.max(1, stops.findIndex(([place]) => place >= at));
  const [[a, from], [b, to]] = [stops[next - 1], stops[next]];
  const part = (at - a) / (b - a);
  return [1, 3, 5].map((i) => {
    const [x, y] = [from, to].map((colour) => parseInt(colour.slice(i, i + 2), 16));
    return Math.round(x + (y - x) * part);
  });
}

/**
 * Draw the bar and its figures in per cent.
 * @param {HTMLCanvasElement} bar
 * @param {HTMLElement} ticks
 * @param {number | null} limit
 */
export function drawLegend(bar, ticks, limit) {
  const colours = ramp(limit), top = topOf(limit);
  const context = /** @type {CanvasRenderingContext2D} */ (bar.getContext("2d"));
  bar.width = 1;
  bar.height = LEVELS;
  const image = context.createImageData(1, LEVELS);
  for (let i = 0; i < LEVELS; i++) image.data.set(colours.subarray(4 * i, 4 * i + 4), 4 * (LEVELS - 1 - i));
  context.putImageData(image, 0, 0);
  const marks = limit === null ? [0, 0.5, 1].map((share) => share * top) : [0, limit, 2 * limit, top];
  ticks.replaceChildren(...marks.map((value) => {
    const tick = document.createElement("span");
    tick.textContent = `${+(100 * value).toFixed(1)} %${value === limit ? " λ" : ""}`;
    tick.classList.toggle("at-limit", value === limit);
    tick.style.bottom = `${(100 * value) / top}%`;
    return tick;
  }));
}
