// The browser's motion sensors: angular rates and forces since the frame before, in screen axes.

export const READING_BYTES = 28;
const MOST = 256;

/**
 * @typedef {object} Reading
 * @property {number} at ms, on the clock of `performance.now`
 * @property {number[]} values angular rate x y z (°/s), specific force x y z (m/s²)
 */

/** Keeps what the sensors say until it is taken. */
export class LiveMotion {
  constructor() {
    /** @type {Reading[]} */
    this.kept = [];
    const { requestPermission } = /** @type {any} not everywhere */ (window.DeviceMotionEvent ?? {});
    this.asks = typeof requestPermission === "function";
    this.sign = this.asks ? -1 : 1; // WebKit on iOS alone asks, and there forces point down at rest
    addEventListener("devicemotion", (event) => this.#put(event));
    if (this.asks) addEventListener("click", () => this.#ask());
  }

  /** Leave is given in a tap alone, and asked for until somebody answers. */
  async #ask() {
    if (!this.asks) return;
    this.asks = false;
    try {
      await /** @type {any} */ (window.DeviceMotionEvent).requestPermission();
    } catch {
      this.asks = true; // that tap was none for the browser
    }
  }

  #put({ timeStamp, rotationRate: rate, accelerationIncludingGravity: force }) {
    const felt = [rate?.alpha, rate?.beta, rate?.gamma, force?.x, force?.y, force?.z];
    if (!felt.every(Number.isFinite)) return; // a sensor that is lacking
    const angle = ((screen.orientation?.angle ?? 0) * Math.PI) / 180;
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const onScreen = (x, y, z, sign) => [cos * x - sin * y, sin * x + cos * y, z].map((v) => sign * v);
    const turns = onScreen(rate.alpha, rate.beta, rate.gamma, 1);
    const values = [...turns, ...onScreen(force.x, force.y, force.z, this.sign)];
    this.kept.push({ at: timeStamp, values });
    if (this.kept.length > MOST) this.kept.shift();
  }

  /** What came since it was taken last, in order. @returns {Reading[]} */
  take() {
    const { kept } = this;
    this.kept = [];
    return kept;
  }
}
