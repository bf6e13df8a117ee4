// The line to the server: messages in order, one under way at a time, of drags the newest.

import { decoded } from "studio/look.js";

const AGAIN_MS = [300, 1000, 2000, 4000];

/**
 * @typedef {object} Waiting
 * @property {object} message
 * @property {(answer: object) => void} done
 */

export class Link {
  /**
   * @param {string} address of the WebSocket
   * @param {{news: (message: object) => void, line: (up: boolean, why: string) => void}} told
   */
  constructor(address, told) {
    this.address = address;
    this.told = told;
    /** @type {Waiting[]} */
    this.queue = [];
    /** @type {Waiting|null} */
    this.under_way = null;
    this.number = 0;
    this.tries = 0;
    this.#open();
  }

  #open() {
    const socket = new WebSocket(this.address);
    this.socket = socket;
    socket.onopen = () => {
      this.tries = 0;
      this.told.line(true, "");
      this.#next();
    };
    socket.onmessage = (event) => this.#hear(decoded(event.data));
    socket.onclose = (event) => this.#lost(event.reason);
  }

  #lost(why) {
    const waiting = this.under_way ? [this.under_way, ...this.queue] : this.queue;
    this.under_way = null;
    this.queue = [];
    for (const one of waiting) one.done({ ok: false, lost: true });
    this.told.line(false, why);
    const pause = AGAIN_MS[Math.min(this.tries++, AGAIN_MS.length - 1)];
    setTimeout(() => this.#open(), pause);
  }

  #hear(message) {
    if (this.under_way && "n" in message && message.n === this.under_way.message.n) {
      const { done } = this.under_way;
      this.under_way = null;
      done(message);
      this.#next();
    } else if (!("n" in message)) {
      this.told.news(message);
    }
  }

  #next() {
    if (this.under_way || this.socket.readyState !== WebSocket.OPEN) return;
    this.under_way = this.queue.shift() ?? null;
    if (this.under_way) this.socket.send(JSON.stringify(this.under_way.message));
  }

  /**
   * Ask for something; a drag takes the place of one that still waits.
   *
   * @param {object} message without its number
   * @returns {Promise<object>} the answer; `lost` where none came, `passed` where a newer drag went
   */
  send(message) {
    return new Promise((done) => {
      const waiting = { message: { n: ++this.number, ...message }, done };
      const last = this.queue.at(-1);
      if (message.do === "drag" && last?.message.do === "drag") {
        this.queue.pop();
        last.done({ ok: true, passed: true });
      }
      this.queue.push(waiting);
      this.#next();
    });
  }
}
