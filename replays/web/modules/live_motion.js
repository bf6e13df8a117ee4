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
    this.sign = /^Apple/.test(navigator.vendor) ? -1 : 1; // WebKit's forces point down at rest
    /** Whether a tap is waited for, since a browser may give leave in one alone. */
    this.asks = false;
    addEventListener("devicemotion", (event) => this.#put(event));
    const { requestPermission } = /** @type {any} not everywhere */ (window.DeviceMotionEvent ?? {});
    if (!requestPermission) return;
    const ask = () => requestPermission.call(window.DeviceMotionEvent).then(
      () => (this.asks = false),
      () => (this.asks = true), // that was no tap
    );
    ask();
    addEventListener("click", () => this.asks && ask());
  }

  #put({ timeStamp, rotationRate: rate, accelerationIncludingGravity: force }) {
    const felt = [rate?.alpha, rate?.beta, rate?.gamma, force?.x, force?.y, force?.z];
    if (!felt.every(Number.isFinite)) return; // a sensor that is lacking
    const angle = ((screen.orientation?.angle ?? 0) * Math.PI) / 180;
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const onScreen = (x, y, z, sign) => [cos * x - sin * y, sin * x + cos * y, z].map((v) => sign * v);
    const turns = onScreen(rate.alpha, rate.beta, rate.gamma, 1);
    const values = [...turns, ...onScreen(force.x, force.y, force.z, this.sign)];
    this.asks = false;
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
