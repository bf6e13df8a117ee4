// The look of a run, as `studio/look/document.py` writes it into a page: decoding, and looking up.

/**
 * @typedef {{data: Float32Array|Float64Array|Uint32Array, shape: number[]}} Packed
 * @typedef {{name: string, label: string, line_s: Packed, line_m: Packed, at_frames: Packed}} Path
 * @typedef {{from_s: number, to_s: number, state: string, why: string}} State
 * @typedef {{depth: {deflated: string, shape: number[], near_m: number, far_m: number}|null,
 *   prints: Packed, ground: Packed|null}} Hiding what hides characters
 * @typedef {object} Look
 * @property {string} name
 * @property {string} headline
 * @property {string} unit of lengths: "m", or "units" where the scale is free
 * @property {number[]} up
 * @property {{width: number, height: number, rate_hz: number, time_s: Packed,
 *   clips: {name: string, src: string, size?: number[], time_s?: Packed}[]}} film
 * @property {import("./camera.js").Camera} camera
 * @property {string} drawn name of the path that the film is drawn along
 * @property {Path[]} paths
 * @property {object[]} boards
 * @property {object[]} markers
 * @property {object[]} planes
 * @property {Packed} points_m
 * @property {object[]} characters
 * @property {boolean} [grey] whether the footage has no colour
 * @property {Hiding} hiding
 * @property {object[]} plots
 * @property {State[]} states
 */

const KINDS = { f32: Float32Array, f64: Float64Array, u32: Uint32Array };
const FORMAT = "motorcade-look";

/** @param {string} text base64 @returns {Uint8Array<ArrayBuffer>} */
export function bytesOf(text) {
  const Bytes = /** @type {any} newer browsers have it */ (Uint8Array);
  if (Bytes.fromBase64) return Bytes.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

/** Columns in 16 bits, told as second differences: see `packed_smooth`. */
function summed({ i16, step, shape }) {
  const told = new Int16Array(bytesOf(i16).buffer);
  const [rows, columns] = [shape[0], step.data.length];
  const data = new Float32Array(told.length);
  const wrap = (number) => (number << 16) >> 16;
  for (let column = 0; column < columns; column++) {
    let [value, rise] = [0, 0];
    for (let k = 0; k < rows; k++) {
      rise = wrap(rise + told[column * rows + k]);
      value = wrap(value + rise);
      data[k * columns + column] = value * step.data[column];
    }
  }
  return { data, shape };
}

function unpacked(key, value) {
  if (value === null || typeof value !== "object" || !("shape" in value)) return value;
  if ("i16" in value) return summed(value);
  for (const [kind, Kind] of Object.entries(KINDS)) {
    if (kind in value) return { data: new Kind(bytesOf(value[kind]).buffer), shape: value.shape };
  }
  return value;
}

/** @param {string} text JSON @returns {any} what it says, its packed arrays unpacked */
export function decoded(text) {
  return JSON.parse(text, unpacked);
}

/** @param {string} text @returns {Look} */
export function decode(text) {
  const look = decoded(text);
  if (look.format !== FORMAT || look.version !== 1) {
    throw new Error(`expected ${FORMAT} version 1, got ${look.format} ${look.version}`);
  }
  return look;
}

/**
 * The number of the last stamp at or before a time; the first where there is none.
 *
 * @param {ArrayLike<number>} times rising
 * @param {number} seconds
 */
export function indexAt(times, seconds) {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= seconds) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** The number of the stamp nearest to a time. */
export function nearest(times, seconds) {
  const before = indexAt(times, seconds);
  const after = Math.min(before + 1, times.length - 1);
  return Math.abs(times[after] - seconds) < Math.abs(times[before] - seconds) ? after : before;
}

/**
 * The frame of a film that a browser tells by a time: Chromium tells when the frame begins, Firefox
 * the time that was sought, so anything from its beginning to its end, rounded.
 *
 * @param {number} seconds of the film
 * @param {number} rate frames a second
 * @param {ArrayLike<number>} [times] when frames begin, s, where its clock is uneven
 */
export function frameAt(seconds, rate, times) {
  if (!times) return Math.floor(seconds * rate + 0.25);
  const before = indexAt(times, seconds);
  const length = (times[before + 1] ?? Infinity) - times[before];
  return seconds - times[before] > 0.75 * length ? before + 1 : before;
}

/** @param {Look} look @param {string} name @returns {Path} the path, or the drawn one */
export function pathNamed(look, name) {
  const named = (wanted) => look.paths.find((one) => one.name === wanted);
  return named(name) ?? named(look.drawn) ?? look.paths[0];
}

/** A row of a packed array. */
export function row(packed, index) {
  const width = packed.shape.slice(1).reduce((all, one) => all * one, 1);
  const at = Math.min(index, packed.shape[0] - 1) * width;
  return packed.data.subarray(at, at + width);
}

/** @returns {Float64Array|null} x y z, w x y z of `world_T_camera`; null where the path has none */
export function poseAt(path, frame) {
  const pose = row(path.at_frames, frame);
  return Number.isNaN(pose[0]) ? null : pose;
}

/** @param {Look} look @param {number} seconds @returns {State|undefined} what tracking was then */
export function stateAt(look, seconds, slack = 0) {
  return look.states.find((one) => seconds >= one.from_s - slack && seconds <= one.to_s + slack);
}
