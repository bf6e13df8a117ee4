// Fingers on live images: a tap stands the figure or lets it walk there, a drag moves it, two
// fingers turn and scale it; a mouse's wheel scales, and with Shift it turns.

const TAP_MS = 350;
const TAP_PX = 9;
const NEAR_PX = 28;

/**
 * @typedef {object} Touched what is told of fingers
 * @property {(clientX: number, clientY: number) => void} tap
 * @property {(clientX: number, clientY: number) => void} drag
 * @property {(factor: number) => void} resize
 * @property {(radians: number) => void} turn
 * @property {() => [[number, number], [number, number]]|null} ends of the figure, on the page
 */

export class LiveTouch {
  /** @param {HTMLElement} element @param {Touched} touched */
  constructor(element, touched) {
    this.touched = touched;
    /** @type {Map<number, {at: [number, number], from: [number, number], since: number}>} */
    this.fingers = new Map();
    this.dragging = false;
    element.addEventListener("pointerdown", (event) => this.#down(event));
    element.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      element.addEventListener(end, (event) => this.#up(event));
    }
    element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  #down(event) {
    event.currentTarget.setPointerCapture(event.pointerId);
    /** @type {[number, number]} */
    const at = [event.clientX, event.clientY];
    this.fingers.set(event.pointerId, { at, from: at, since: event.timeStamp });
    this.dragging = this.fingers.size === 1 && this.#onFigure(at);
    this.spread = this.#spread();
  }

  /** @param {[number, number]} at */
  #onFigure([x, y]) {
    const ends = this.touched.ends();
    if (!ends) return false;
    const [[ax, ay], [bx, by]] = ends;
    const length = Math.hypot(bx - ax, by - ay) || 1;
    const along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length;
    const beside = Math.abs((x - ax) * (by - ay) - (y - ay) * (bx - ax)) / length;
    return along > -NEAR_PX && along < length + NEAR_PX && beside < Math.max(NEAR_PX, length / 3);
  }

  /** Distance and direction of two fingers. */
  #spread() {
    if (this.fingers.size !== 2) return null;
    const [one, other] = [...this.fingers.values()].map((finger) => finger.at);
    const [dx, dy] = [other[0] - one[0], other[1] - one[1]];
    return { length: Math.max(Math.hypot(dx, dy), 1), angle: Math.atan2(dy, dx) };
  }

  #move(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    finger.at = [event.clientX, event.clientY];
    const spread = this.#spread();
    if (spread && this.spread) {
      const angle = this.spread.angle - spread.angle;
      this.touched.resize(spread.length / this.spread.length);
      this.touched.turn(Math.atan2(Math.sin(angle), Math.cos(angle)));
      this.spread = spread;
      finger.since = -Infinity;
    } else if (this.dragging && this.#far(finger)) {
      this.touched.drag(...finger.at);
    }
  }

  #far({ at, from }) {
    return Math.hypot(at[0] - from[0], at[1] - from[1]) > TAP_PX;
  }

  #up(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    this.fingers.delete(event.pointerId);
    const short = event.timeStamp - finger.since < TAP_MS && !this.#far(finger);
    if (event.type === "pointerup" && short && !this.fingers.size) this.touched.tap(...finger.at);
    this.spread = this.#spread();
    this.dragging = false;
  }

  #wheel(event) {
    event.preventDefault();
    const by = -0.001 * (event.deltaY || event.deltaX);
    if (event.shiftKey) this.touched.turn(2 * by);
    else this.touched.resize(Math.exp(by));
  }
}
