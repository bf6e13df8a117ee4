// The footage, frame by frame: fetched ahead of the one on show, decoded when it is wanted.

const AHEAD = 24;
const AT_ONCE = 4;
const DECODED = 48;

export class Images {
  /**
   * @param {string} base address of the run
   * @param {number} count
   * @param {(frame: number) => void} arrived called when an image that was asked for is there
   */
  constructor(base, count, arrived) {
    this.base = base;
    this.count = count;
    this.arrived = arrived;
    /** @type {Map<number, Blob>} */
    this.fetched = new Map();
    /** @type {Map<number, ImageBitmap>} the latest used last */
    this.decoded = new Map();
    this.busy = new Set();
    this.decoding = new Set();
    this.wanted = 0;
  }

  /** The image of a frame, or null while it is on its way. @returns {ImageBitmap|null} */
  at(frame) {
    this.wanted = frame;
    this.#fetchAround();
    const found = this.decoded.get(frame);
    if (found) {
      this.decoded.delete(frame);
      this.decoded.set(frame, found);
    } else {
      this.#decode(frame);
    }
    for (let step = 1; step <= 3; step++) this.#decode((frame + step) % this.count);
    return found ?? null;
  }

  #fetchAround() {
    for (let step = 0; step < this.count && this.busy.size < AT_ONCE; step++) {
      const frame = (this.wanted + step) % this.count;
      if (step > AHEAD && this.fetched.size > 600) break;
      if (!this.fetched.has(frame) && !this.busy.has(frame)) this.#fetch(frame);
    }
  }

  async #fetch(frame) {
    this.busy.add(frame);
    try {
      const answer = await fetch(`${this.base}frame/${frame}.jpg`);
      if (answer.ok) this.fetched.set(frame, await answer.blob());
    } catch {
      await new Promise((later) => setTimeout(later, 1000));
    }
    this.busy.delete(frame);
    if (Math.abs(frame - this.wanted) <= 3) this.#decode(frame);
    if (this.fetched.size < this.count) this.#fetchAround();
  }

  async #decode(frame) {
    const blob = this.fetched.get(frame);
    if (!blob || this.decoded.has(frame) || this.decoding.has(frame)) return;
    this.decoding.add(frame);
    const image = await createImageBitmap(blob);
    this.decoding.delete(frame);
    this.decoded.set(frame, image);
    for (const [old, gone] of this.decoded) {
      if (this.decoded.size <= DECODED) break;
      this.decoded.delete(old);
      gone.close();
    }
    if (frame === this.wanted) this.arrived(frame);
  }
}
