// Time of a page: which frame is shown, its scrubber with the states of tracking, and the keys.

import { indexAt, stateAt } from "studio/look.js";

/** Frames, and who wants to know of them. */
export class Timeline {
  /** @param {ArrayLike<number>} times seconds of each frame */
  constructor(times) {
    this.times = times;
    this.frame = 0;
    this.heard = [];
  }

  get last() {
    return this.times.length - 1;
  }

  get seconds() {
    return this.times[this.frame];
  }

  /** @param {(frame: number, asked: boolean) => void} hears */
  listen(hears) {
    this.heard.push(hears);
  }

  /**
   * @param {number} frame
   * @param {boolean} asked whether somebody went there; false where the film came there by itself
   */
  go(frame, asked = true) {
    const next = Math.min(Math.max(Math.round(frame), 0), this.last);
    if (next === this.frame && asked === false) return;
    this.frame = next;
    for (const hears of this.heard) hears(next, asked);
  }

  goTo(seconds) {
    this.go(indexAt(this.times, seconds + 1e-9));
  }
}

/** Seconds in words: 3.27 s, or 1:03.3. */
export function clockWords(seconds) {
  if (seconds < 60) return `${seconds.toFixed(2)} s`;
  return `${Math.floor(seconds / 60)}:${(seconds % 60).toFixed(1).padStart(4, "0")}`;
}

/**
 * Wire the scrubber: a range with a band of states over it, and the words beside it.
 *
 * @param {Timeline} timeline
 * @param {import("./look.js").Look} look
 * @param {{range: HTMLInputElement, band: HTMLElement, words: HTMLElement, state: HTMLElement}} parts
 */
export function wireScrubber(timeline, look, { range, band, words, state }) {
  range.max = String(timeline.last);
  range.addEventListener("input", () => timeline.go(Number(range.value)));
  const span = timeline.times[timeline.last] || 1;
  const step = span / Math.max(1, timeline.last);
  for (const one of look.states) {
    const mark = document.createElement("i");
    mark.className = one.state.replaceAll(" ", "-");
    mark.style.left = `${(100 * one.from_s) / span}%`;
    mark.style.width = `${(100 * (one.to_s - one.from_s)) / span}%`;
    mark.title = `${one.why}, ${clockWords(one.from_s)}`;
    band.append(mark);
  }
  const tell = () => {
    range.value = String(timeline.frame);
    const told = stateAt(look, timeline.seconds, 0.5 * step);
    words.textContent = clockWords(timeline.seconds);
    words.title = `frame ${timeline.frame} of 0 to ${timeline.last}`;
    state.textContent = `frame ${timeline.frame}${told ? ` · ${told.why}` : ""}`;
    state.classList.toggle("wrong", Boolean(told));
    range.ariaValueText = `frame ${timeline.frame} of ${timeline.last}, ${words.textContent}`;
  };
  timeline.listen(tell);
  tell();
}

/**
 * Keys for all of the page, but where something is typed or chosen.
 *
 * @param {Timeline} timeline
 * @param {Record<string, () => void>} actions by key; " " plays
 */
export function wireKeys(timeline, actions) {
  const steps = { ArrowLeft: -1, ArrowRight: 1 };
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { target, key } = event;
    const writing = target instanceof HTMLInputElement && target.type === "text";
    const typing = target instanceof HTMLSelectElement || writing;
    if (typing && key !== "Escape") return;
    if (key === " " && target instanceof HTMLButtonElement) return;
    let done = true;
    if (key in steps) timeline.go(timeline.frame + steps[key] * (event.shiftKey ? 10 : 1));
    else if (key === "Home") timeline.go(0);
    else if (key === "End") timeline.go(timeline.last);
    else if (key in actions) actions[key]();
    else done = false;
    if (done) event.preventDefault();
  });
}
