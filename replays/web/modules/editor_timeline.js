// The bar below the scene: where in the film one is, and playing.

import { icon } from "studio/editor_icons.js";

/** An element with a class and what stands in it. */
export function made(tag, className, ...inside) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  element.append(...inside);
  return element;
}

/**
 * A button that says what it does; its spoken name holds the word on it, so that voices find it.
 *
 * @param {string} text
 * @param {(event: MouseEvent) => void} act
 * @param {{sign?: import("./editor_icons.js").Sign, title?: string, className?: string}} looks
 */
export function button(text, act, { sign, title = text, className = "" } = {}) {
  const one = made("button", className);
  one.type = "button";
  if (sign) one.append(icon(sign));
  one.append(made("span", "word", text));
  one.title = title;
  one.ariaLabel = title === text ? text : `${text}: ${title}`;
  one.addEventListener("click", act);
  return one;
}

export class EditorTimeline {
  /**
   * @param {Float64Array} times of the frames, s
   * @param {{seek: (frame: number) => void}} told
   * @param {HTMLElement} lanes what stands below the bar
   */
  constructor(times, told, lanes) {
    this.times = times;
    this.told = told;
    this.frame = 0;
    this.playing = false;
    this.play = button("Play", () => this.toggle(), { sign: "play", className: "round" });
    this.range = made("input", "scrub");
    Object.assign(this.range, { type: "range", min: 0, max: times.length - 1, step: 1, value: 0 });
    this.range.ariaLabel = "Time";
    this.range.addEventListener("input", () => this.#seek(Number(this.range.value)));
    // Also where the knob is already: no input comes of that.
    this.range.addEventListener("pointerdown", () => this.pause());
    this.clock = made("output", "clock");
    this.element = made("div", "timeline", this.play, made("div", "track", this.range, lanes), this.clock);
    this.show(0);
  }

  #seek(frame) {
    this.pause();
    this.told.seek(frame);
  }

  step(by) {
    this.#seek(Math.min(Math.max(this.frame + by, 0), this.times.length - 1));
  }

  show(frame) {
    this.frame = frame;
    this.range.value = String(frame);
    this.clock.textContent = `${(this.times[frame] - this.times[0]).toFixed(1)} s`;
    this.range.ariaValueText = this.clock.textContent;
  }

  toggle() {
    if (this.playing) this.pause();
    else this.start();
  }

  start() {
    this.playing = true;
    this.#face("Pause", "pause");
    const last = this.times.length - 1;
    const from = this.frame >= last ? 0 : this.frame;
    const began = performance.now() - 1e3 * this.times[from];
    const tick = (now) => {
      if (!this.playing) return;
      const seconds = (now - began) / 1e3;
      let frame = this.frame >= last ? 0 : this.frame;
      while (frame < last && this.times[frame + 1] <= seconds) frame++;
      this.told.seek(frame);
      if (frame >= last) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.#face("Play", "play");
  }

  #face(word, sign) {
    this.play.replaceChildren(icon(sign), made("span", "word", word));
    this.play.title = this.play.ariaLabel = word;
  }
}
