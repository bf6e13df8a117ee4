// Fingers, mouse and wheel on the scene: what they mean, told to the server as they go.
//
// One finger on something drags it over its plane, two turn it, grow it and carry it; the handles
// of what is chosen move it along a line or turn it about one. Geometry is the server's: pixels go
// there and poses come back.

const BEGINS_PX = { mouse: 3, touch: 7, pen: 4 };
const WHEEL_ENDS_MS = 350;
const WHEEL_STEP = 1.0015;

export class Gestures {
  /**
   * @param {HTMLElement} element the scene's
   * @param {object} editor what it acts on: `pick`, `choose`, `pixelAt`, `begin`, `drag`, `end`,
   *   `cancel`, `draws`, `drawn`, `chosen`
   */
  constructor(element, editor) {
    this.element = element;
    this.editor = editor;
    /** @type {Map<number, {x: number, y: number, from: [number, number], kind: string}>} */
    this.fingers = new Map();
    this.going = null;
    this.grabbed = null;
    const on = (name, act) => element.addEventListener(name, act.bind(this), { passive: false });
    on("pointerdown", this.#down);
    on("pointermove", this.#move);
    on("pointerup", this.#up);
    on("pointercancel", this.#lost);
    on("wheel", this.#wheel);
    on("contextmenu", (event) => event.preventDefault());
  }

  #down(event) {
    if (event.target.closest("button, input, select, a")) return;
    event.preventDefault();
    this.#endWheel();
    if (this.fingers.size >= 2 || this.editor.posing.held) return;
    this.element.setPointerCapture(event.pointerId);
    const { clientX: x, clientY: y, pointerType: kind } = event;
    this.fingers.set(event.pointerId, { x, y, from: [x, y], kind });
    if (this.editor.draws) {
      if (this.fingers.size === 1) this.way = [[x, y]];
      return;
    }
    if (this.fingers.size === 1) {
      this.grabbed = this.editor.pick(x, y, kind !== "mouse");
      this.turning = event.button === 2 || event.shiftKey;
      if (this.grabbed?.handle) this.#begin(this.grabbed.handle);
    } else {
      this.#pinch();
    }
  }

  /** Two fingers take hold of what the first one touched, else of what is chosen. */
  #pinch() {
    const name = this.grabbed?.name ?? this.editor.chosen;
    if (!name) return;
    if (this.grabbed?.handle && this.going) this.editor.cancel();
    this.editor.choose(name);
    this.grabbed = { name, point: this.grabbed?.handle ? null : this.grabbed?.point };
    this.#begin({ gesture: "pinch" });
  }

  #begin(how) {
    const pixels = [...this.fingers.values()].map((one) => this.editor.pixelAt(one.x, one.y));
    const point = this.grabbed?.point?.toArray();
    this.going = how.gesture;
    this.editor.begin({ object: this.grabbed.name, pixels, ...(point && { point }), ...how });
  }

  #move(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    event.preventDefault();
    [finger.x, finger.y] = [event.clientX, event.clientY];
    if (this.way) {
      this.way.push([finger.x, finger.y]);
      this.editor.drawing(this.way);
      return;
    }
    if (!this.going) {
      const [x, y] = finger.from;
      const far = Math.hypot(finger.x - x, finger.y - y) >= (BEGINS_PX[finger.kind] ?? 4);
      if (!far || !this.grabbed?.name || this.fingers.size !== 1) return;
      this.editor.choose(this.grabbed.name);
      this.#beginAt(finger, this.turning ? { gesture: "turn" } : { gesture: "move" });
    }
    const pixels = [...this.fingers.values()].map((one) => this.editor.pixelAt(one.x, one.y));
    this.editor.drag(pixels);
  }

  /** Begin where the finger came down, so that what it grabbed stays below it. */
  #beginAt(finger, how) {
    const now = [finger.x, finger.y];
    [finger.x, finger.y] = finger.from;
    this.#begin(how);
    [finger.x, finger.y] = now;
  }

  #up(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!this.fingers.delete(event.pointerId)) return;
    if (this.way) {
      if (this.fingers.size) return;
      const { way } = this;
      this.way = null;
      this.editor.drawn(way);
      return;
    }
    if (!this.going) {
      if (!this.fingers.size && finger) this.editor.choose(this.grabbed?.name ?? null);
      return;
    }
    if (this.fingers.size && this.going === "pinch") {
      this.grabbed = { name: this.grabbed.name };
      this.#begin({ gesture: "move" });
    } else if (!this.fingers.size) {
      this.going = null;
      this.editor.end();
    }
  }

  /** The system took the fingers away: nothing of it was meant. */
  #lost(event) {
    if (!this.fingers.delete(event.pointerId)) return;
    this.way = null;
    this.cancel();
  }

  cancel() {
    this.fingers.clear();
    if (this.going) this.editor.cancel();
    this.going = null;
    this.editor.drawing(null);
  }

  #wheel(event) {
    event.preventDefault();
    const name = this.editor.chosen;
    if (!name || this.fingers.size) return;
    const gesture = event.shiftKey ? "turn" : "scale";
    if (this.wheeling !== gesture) {
      this.#endWheel();
      this.wheeling = gesture;
      this.amount = gesture === "scale" ? 1 : 0;
      this.editor.begin({ object: name, gesture, pixels: [this.editor.pixelAt(event.clientX, event.clientY)] });
    }
    const turned = -(event.deltaY || event.deltaX);
    if (gesture === "scale") this.amount *= WHEEL_STEP ** turned;
    else this.amount += 0.002 * turned;
    this.editor.drag(null, this.amount);
    clearTimeout(this.stops);
    this.stops = setTimeout(() => this.#endWheel(), WHEEL_ENDS_MS);
  }

  #endWheel() {
    if (!this.wheeling) return;
    clearTimeout(this.stops);
    this.wheeling = null;
    this.editor.end();
  }
}
