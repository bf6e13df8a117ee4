// The browser's camera: its newest frame, and the bytes that are sent of it and of motion sensors.

import { READING_BYTES } from "studio/live_motion.js";

const HEADER_BYTES = 28;
const CLOCKED_FRAMES = 30;
const WIDEST = 1280;
const WANTED = { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 30 } };
const PLANAR = new Set(["I420", "I420A", "I422", "I444", "NV12"]);

/**
 * @typedef {object} Shot a frame and when it was taken
 * @property {VideoFrame} frame whoever takes it closes it
 * @property {number} captured_ms on the clock of `performance.now`
 */

/** A camera whose newest frame can be taken. */
export class LiveCamera {
  /** Ask for a camera, the one at the back where there are two. @returns {Promise<LiveCamera>} */
  static async open() {
    if (!navigator.mediaDevices) throw new Error("this address gives no camera; https does");
    const video = { ...WANTED, facingMode: { ideal: "environment" } };
    return new LiveCamera(await navigator.mediaDevices.getUserMedia({ video, audio: false }));
  }

  /** @param {MediaStream} stream */
  constructor(stream) {
    this.stream = stream;
    this.track = stream.getVideoTracks()[0];
    /** @type {Shot|null} */
    this.newest = null;
    /** @type {((shot: Shot) => void)|null} */
    this.wanted = null;
    this.scratch = new Uint8Array(HEADER_BYTES);
    this.count = 0;
    this.behind = Infinity; // how far the clock of frames is behind that of events, ms
    this.canvas = document.createElement("canvas");
    const Processor = /** @type {any} not in every browser */ (window).MediaStreamTrackProcessor;
    if (Processor) this.#read(new Processor({ track: this.track, maxBufferSize: 1 }));
    else this.#watch();
  }

  /** The newest frame that nobody took yet, or the next one. @returns {Promise<Shot>} */
  take() {
    const shot = this.newest;
    this.newest = null;
    if (shot) return Promise.resolve(shot);
    return new Promise((done) => {
      this.wanted = done;
    });
  }

  #put(frame, captured) {
    const shot = { frame, captured_ms: captured };
    if (this.count++ < CLOCKED_FRAMES) {
      this.behind = Math.min(this.behind, captured - frame.timestamp / 1000);
    }
    if (this.wanted) {
      const done = this.wanted;
      this.wanted = null;
      done(shot);
      return;
    }
    this.newest?.frame.close();
    this.newest = shot;
  }

  async #read(processor) {
    const reader = processor.readable.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      this.#put(value, performance.now());
    }
  }

  #watch() {
    const video = document.createElement("video");
    [video.muted, video.playsInline, video.srcObject] = [true, true, this.stream];
    const shown = (now, about) => {
      this.#put(new VideoFrame(video), about.captureTime ?? now);
      video.requestVideoFrameCallback(shown);
    };
    video.requestVideoFrameCallback(shown);
    video.play();
  }

  /** How large what is sent of a frame is. @returns {[number, number]} */
  static sizeOf(frame) {
    const scale = Math.min(1, WIDEST / Math.max(frame.displayWidth, frame.displayHeight));
    return [Math.round(scale * frame.displayWidth), Math.round(scale * frame.displayHeight)];
  }

  /**
   * A frame as it is sent: see `replays/live/app.py`.
   *
   * @param {Shot} shot
   * @param {number} number
   * @param {number} latency of the frame before, ms; NaN for none
   * @param {import("./live_motion.js").Reading[]} readings since the frame before
   */
  async message({ frame }, number, latency, readings) {
    const [width, height] = LiveCamera.sizeOf(frame);
    const { visibleRect: seen } = frame;
    const upright = seen && seen.width === width && seen.height === height;
    const felt = this.count < CLOCKED_FRAMES ? [] : readings; // before, no clock is theirs
    const luma = HEADER_BYTES + width * height;
    const bytes = HEADER_BYTES + (frame.format ? frame.allocationSize() : 0);
    const least = Math.max(bytes, luma + READING_BYTES * felt.length);
    if (this.scratch.length < least) this.scratch = new Uint8Array(least);
    if (upright && PLANAR.has(frame.format)) {
      await frame.copyTo(this.scratch.subarray(HEADER_BYTES, bytes));
    } else {
      this.#byCanvas(frame, width, height);
    }
    const head = new DataView(this.scratch.buffer);
    this.scratch.set([77, 76, 89, 50]); // MLY2
    head.setUint32(4, number, true);
    head.setFloat64(8, frame.timestamp / 1000, true);
    head.setUint16(16, width, true);
    head.setUint16(18, height, true);
    head.setFloat32(20, latency, true);
    head.setUint32(24, felt.length, true);
    for (const [k, { at, values }] of felt.entries()) {
      const row = [at - this.behind - frame.timestamp / 1000, ...values];
      row.forEach((value, j) => head.setFloat32(luma + READING_BYTES * k + 4 * j, value, true));
    }
    return this.scratch.subarray(0, luma + READING_BYTES * felt.length);
  }

  #byCanvas(frame, width, height) {
    [this.canvas.width, this.canvas.height] = [width, height];
    const brush = this.canvas.getContext("2d", { willReadFrequently: true });
    brush.drawImage(frame, 0, 0, width, height);
    const { data } = brush.getImageData(0, 0, width, height);
    const bytes = HEADER_BYTES + width * height;
    for (let k = 0, at = HEADER_BYTES; at < bytes; k += 4, at++) {
      this.scratch[at] = 0.299 * data[k] + 0.587 * data[k + 1] + 0.114 * data[k + 2] + 0.5;
    }
  }
}
