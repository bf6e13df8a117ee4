// Below the time bar: when what is chosen walks, and its keyframes, poses and layers. Dragged, they come at
// another time or last longer; touched, they tell what can be done with them.

import { spoken } from "studio/editor_fields.js";
import { icon } from "studio/editor_icons.js";
import { made } from "studio/editor_timeline.js";

const SLIPS_PX = 4;

/**
 * @typedef {object} Mark
 * @property {"walk"|"key"|"pose"|"layer"} kind
 * @property {number} number of its kind
 * @property {number} start_s
 * @property {number|null} end_s null where it is held for ever
 * @property {number} until_s where it ends as it is drawn
 * @property {string} label
 * @property {object} [layer]
 */

/** What stands on the timeline of an object, one list a lane. @returns {Mark[][]} */
export function marksOf(one, length) {
  if (!one) return [];
  const keys = one.keys.map((time, number) => ({ kind: "key", number, start_s: time, end_s: null, until_s: time, label: "Keyframe" }));
  const poses = one.turns.map(([start_s, end_s], number) => {
    const next = one.turns[number + 1]?.[0] ?? Infinity;
    const until_s = Math.min(end_s ?? Infinity, next, Math.max(length, start_s));
    return { kind: "pose", number, start_s, end_s, until_s, label: "Pose" };
  });
  const layers = (one.layers ?? []).map((layer, number) => {
    const [start_s, end_s] = [layer.start_s ?? 0, layer.end_s ?? null];
    const until_s = Math.min(end_s ?? Infinity, Math.max(length, start_s));
    return [{ kind: "layer", number, start_s, end_s, until_s, label: spoken(layer.clip), layer }];
  });
  const walks = (one.walks ? [one.walks] : []).map(({ start_s, end_s }) => {
    return { kind: "walk", number: 0, start_s, end_s, until_s: Math.min(end_s, Math.max(length, start_s)), label: "Walk" };
  });
  return [walks, keys, poses, ...layers].filter((lane) => lane.length);
}

/** A mark with one of its times dragged elsewhere. @returns {{start_s?: number, end_s?: number|null}} */
export function draggedTo(mark, side, seconds, length) {
  if (side === "end") return { end_s: seconds >= length - 1e-6 ? null : Math.max(seconds, mark.start_s + 0.02) };
  if (side === "start") {
    const start_s = Math.max(0, Math.min(seconds, mark.until_s - 0.02));
    return { start_s, end_s: mark.end_s };
  }
  const by = Math.max(seconds, 0) - mark.start_s;
  return { start_s: mark.start_s + by, end_s: mark.end_s === null ? null : mark.end_s + by };
}

export class Lanes {
  /**
   * @param {number} length of the footage, s
   * @param {{snapped: (seconds: number) => number, pick: (mark: Mark) => void, seek: (seconds: number) => void,
   *   change: (mark: Mark, to: object) => void}} told
   */
  constructor(length, told) {
    this.length = length;
    this.told = told;
    this.held = null;
    this.one = null;
    this.waits = false;
    this.element = made("div", "lanes");
  }

  /** Follow what is chosen. */
  show(one) {
    this.one = one;
    if (this.held) {
      this.waits = true;
      return;
    }
    this.waits = false;
    const lanes = marksOf(one, this.length);
    const rows = lanes.map((lane) => made("div", "lane", ...lane.map((mark) => this.#made(mark))));
    this.element.replaceChildren(...rows);
  }

  #made(mark) {
    const still = mark.kind === "key";
    const element = made("button", `mark ${mark.kind}`, ...(still ? [icon("key")] : [made("span", "word", mark.label)]));
    element.type = "button";
    const until = mark.end_s === null ? "" : ` to ${mark.end_s.toFixed(1)} s`;
    const when = `${still ? "at" : "from"} ${mark.start_s.toFixed(1)} s${until}`;
    element.title = element.ariaLabel = `${mark.label} ${when}: drag it, or press for more`;
    element.classList.toggle("open", mark.end_s === null);
    if (mark.kind === "layer") element.prepend(this.#weight(mark));
    if (mark.kind === "layer") element.append(made("i", "grip start"));
    if (!still && mark.kind !== "walk") element.append(made("i", "grip end"));
    this.#put(element, mark);
    element.addEventListener("pointerdown", (event) => this.#down(event, element, mark));
    element.addEventListener("pointermove", (event) => this.#move(event));
    element.addEventListener("pointerup", (event) => this.#up(event));
    element.addEventListener("pointercancel", () => this.#drop());
    element.addEventListener("click", () => this.slid || this.told.pick(mark));
    return element;
  }

  /** How a layer's weight rises and falls. */
  #weight({ start_s, until_s, end_s, layer }) {
    const lasts = Math.max(until_s - start_s, 1e-6);
    const fade = 100 * Math.min((layer.fade_s ?? 0.3) / lasts, 0.5);
    const [top, falls] = [100 - 100 * layer.weight, end_s === null ? 100 : 100 - fade];
    const shape = made("i", "weight");
    shape.style.clipPath = `polygon(0 100%, ${fade}% ${top}%, ${falls}% ${top}%, 100% ${end_s === null ? top : 100}%, 100% 100%)`;
    return shape;
  }

  #put(element, { start_s, until_s }) {
    const share = (seconds) => 100 * Math.min(Math.max(seconds / Math.max(this.length, 1e-9), 0), 1);
    element.style.left = `${share(start_s)}%`;
    element.style.width = `${share(until_s) - share(start_s)}%`;
  }

  #down(event, element, mark) {
    if (event.button > 0 || this.held) return;
    event.stopPropagation();
    element.setPointerCapture(event.pointerId);
    const grip = event.target.closest(".grip");
    const side = grip ? (grip.classList.contains("start") ? "start" : "end") : "body";
    this.slid = false;
    this.held = { element, mark, side, pointer: event.pointerId, x: event.clientX, to: null };
  }

  #move(event) {
    const { held } = this;
    if (!held || event.pointerId !== held.pointer) return;
    if (!this.slid && Math.abs(event.clientX - held.x) < SLIPS_PX) return;
    this.slid = true;
    const wide = held.element.parentElement.getBoundingClientRect().width;
    const from = held.side === "end" ? held.mark.until_s : held.mark.start_s;
    const seconds = this.told.snapped(from + ((event.clientX - held.x) / wide) * this.length);
    held.to = draggedTo(held.mark, held.side, seconds, this.length);
    const start_s = held.to.start_s ?? held.mark.start_s;
    const lasts = held.mark.until_s - held.mark.start_s;
    const until_s = held.to.end_s ?? (held.side === "body" && held.mark.kind === "key" ? start_s + lasts : this.length);
    this.#put(held.element, { start_s, until_s });
    this.told.seek(seconds);
  }

  #up(event) {
    const { held } = this;
    if (!held || event.pointerId !== held.pointer) return;
    this.#drop();
    if (held.to) this.told.change(held.mark, held.to);
  }

  #drop() {
    this.held = null;
    if (this.waits) this.show(this.one);
  }
}
