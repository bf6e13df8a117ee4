// A film that is sought frame by frame; its image and the number of that frame go together.
//
// The image is copied off a hidden video whenever a frame was presented, so whoever draws over it
// draws over the frame whose number is told, also while the film plays.

import { frameAt } from "studio/look.js";

const PATIENCE_MS = 250;

export class Film {
  /**
   * @param {string} source address of an H.264 file
   * @param {{width: number, height: number, rate_hz: number, frames: number}} about the images
   * @param {{size?: [number, number], time_s?: import("./look.js").Packed}} own how large the film has them,
   *   and its stamps where its clock is uneven
   */
  constructor(source, about, own = {}) {
    this.frames = about.frames;
    this.rate = about.rate_hz;
    /** @type {[number, number]} */
    this.size = own.size ?? [about.width, about.height];
    this.times = own.time_s?.data;
    /** @type {number} the frame that `image` holds; -1 before the first */
    this.shown = -1;
    this.playing = false;
    /** @type {(frame: number) => void} */
    this.onshown = () => {};
    /** @type {(problem: string) => void} */
    this.onproblem = () => {};
    this.image = document.createElement("canvas");
    [this.image.width, this.image.height] = [about.width, about.height];
    this.brush = this.image.getContext("2d", { alpha: false });
    this.wanted = 0;
    this.target = -1;
    this.asked = 0;
    this.video = document.createElement("video");
    Object.assign(this.video, { muted: true, playsInline: true, preload: "auto", src: source });
    this.video.addEventListener("loadeddata", () => this.#presented(0));
    this.video.addEventListener("error", () => this.onproblem(problemOf(this.video)));
    this.video.addEventListener("ended", () => this.#ended());
    this.video.addEventListener("seeked", () => this.#seeked());
    this.#listen();
  }

  /** Show a frame; of several that are asked for while one is under way, the newest. */
  seek(frame) {
    this.wanted = Math.min(Math.max(Math.round(frame), 0), this.frames - 1);
    if (this.playing) this.pause();
    if (this.target < 0) this.#start();
  }

  /** @param {number} speed 1 for as it was taken */
  play(speed = 1) {
    if (this.shown >= this.frames - 1) {
      this.seek(0);
      return void setTimeout(() => this.play(speed), 60);
    }
    this.video.playbackRate = speed;
    this.playing = true;
    this.target = -1;
    this.video.play().catch(() => this.pause());
  }

  pause() {
    this.playing = false;
    this.video.pause();
    this.wanted = Math.max(this.shown, 0);
  }

  #start() {
    if (this.wanted === this.shown || this.video.readyState < 1) return;
    this.target = this.wanted;
    this.asked += 1;
    this.video.currentTime = this.#middle(this.target);
  }

  /** The middle of a frame's time, in seconds of the film. */
  #middle(frame) {
    if (!this.times) return (frame + 0.5) / this.rate;
    const begun = this.times[frame];
    return (begun + (this.times[frame + 1] ?? begun + 1 / this.rate)) / 2;
  }

  #listen() {
    if (!this.video.requestVideoFrameCallback) return;
    const told = (_now, about) => {
      this.#presented(frameAt(about.mediaTime, this.rate, this.times));
      this.video.requestVideoFrameCallback(told);
    };
    this.video.requestVideoFrameCallback(told);
  }

  /** Browsers that tell no presented frames show what was sought; so do those that tell it late. */
  #seeked() {
    const { target, asked } = this;
    const late = this.video.requestVideoFrameCallback ? PATIENCE_MS : 0;
    setTimeout(() => {
      if (target >= 0 && this.asked === asked && this.target === target) this.#presented(target);
    }, late);
  }

  #presented(frame) {
    const { width, height } = this.image;
    this.shown = Math.min(Math.max(frame, 0), this.frames - 1);
    this.brush.drawImage(this.video, 0, 0, ...this.size, 0, 0, width, height);
    if (this.shown === this.target) this.target = -1;
    this.onshown(this.shown);
    if (!this.playing && this.target < 0) this.#start();
  }

  #ended() {
    this.playing = false;
    this.onshown(this.shown);
  }
}

/** @param {HTMLVideoElement} video */
function problemOf(video) {
  const absent = video.error?.code === 4 && !video.src.startsWith("blob:");
  return absent
    ? "The film that belongs beside this page is not there."
    : "This browser cannot play the film: it needs H.264.";
}
