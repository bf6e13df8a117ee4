// Round handles on the hands, feet and head of what is chosen: dragged, the limb goes along.

import { made } from "studio/editor_timeline.js";

const SPOKEN = {
  head: "Head",
  left_hand: "Left hand",
  right_hand: "Right hand",
  left_foot: "Left foot",
  right_foot: "Right foot",
};

export class Posing {
  /** @param {HTMLElement} element the scene's @param {object} editor what it acts on */
  constructor(element, editor) {
    this.editor = editor;
    this.on = false;
    /** The part of the body that is held, and by which pointer. */
    this.held = null;
    this.pointer = null;
    /** @type {Map<string, HTMLElement>} */
    this.handles = new Map();
    for (const [part, words] of Object.entries(SPOKEN)) {
      const one = made("div", "joint");
      Object.assign(one, { title: words, hidden: true });
      one.addEventListener("pointerdown", (event) => this.#down(event, one));
      one.addEventListener("pointermove", (event) => this.#move(event));
      one.addEventListener("pointerup", (event) => this.#up(event));
      one.addEventListener("pointercancel", (event) => event.pointerId === this.pointer && this.cancel());
      this.handles.set(part, one);
      element.append(one);
    }
  }

  toggle() {
    this.cancel();
    this.on = !this.on;
    document.body.classList.toggle("poses", this.on);
    this.editor.choose(this.editor.chosen);
  }

  /** Stand on the joints of somebody, or nowhere. @param {import("./editor_actors.js").Actor|null} actor */
  show(actor) {
    const joints = (actor?.figure && actor.about.held_by) ?? {};
    for (const [part, handle] of this.handles) {
      const place = part in joints ? this.editor.stage.placeOf(actor.joint(joints[part][0])) : null;
      handle.hidden = !place;
      if (!place) continue;
      const corner = this.editor.stage.element.getBoundingClientRect();
      handle.style.left = `${place[0] - corner.left}px`;
      handle.style.top = `${place[1] - corner.top}px`;
    }
  }

  #down(event, handle) {
    event.preventDefault();
    event.stopPropagation();
    if (this.held || this.editor.gestures.fingers.size) return;
    handle.setPointerCapture(event.pointerId);
    const [part] = this.#nearest(event.clientX, event.clientY);
    [this.held, this.pointer] = [part, event.pointerId];
    this.editor.begin({
      object: this.editor.chosen,
      gesture: "joint",
      joint: this.editor.one.held_by[part][1],
      pixels: [this.editor.pixelAt(event.clientX, event.clientY)],
    });
  }

  /** Of handles that overlap, the one whose middle is nearest to the finger. */
  #nearest(x, y) {
    const shown = [...this.handles].filter(([, one]) => !one.hidden);
    const away = ([, one]) => {
      const { left, top, width, height } = one.getBoundingClientRect();
      return Math.hypot(left + width / 2 - x, top + height / 2 - y);
    };
    return shown.reduce((best, one) => (away(one) < away(best) ? one : best));
  }

  #move(event) {
    event.stopPropagation();
    if (event.pointerId !== this.pointer) return;
    this.editor.drag([this.editor.pixelAt(event.clientX, event.clientY)]);
  }

  #up(event) {
    event.stopPropagation();
    if (event.pointerId !== this.pointer) return;
    this.held = this.pointer = null;
    this.editor.end();
  }

  /** Let go, and leave the pose as it was. */
  cancel() {
    if (!this.held) return;
    this.held = this.pointer = null;
    this.editor.cancel();
  }
}
