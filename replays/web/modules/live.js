// The live page: images held until their pose is known, the figure drawn over them, and figures of
// how fast and how right that is.

import { EditorStage } from "studio/editor_stage.js";
import { lookThrough } from "studio/lens.js";
import { LiveCamera } from "studio/live_camera.js";
import { LiveFigure } from "studio/live_figure.js";
import { LiveFigures } from "studio/live_figures.js";
import { LiveMotion } from "studio/live_motion.js";
import { LiveTouch } from "studio/live_touch.js";
import { NO_WEBGL, drawnBy } from "studio/panes.js";

const AGAIN_MS = [300, 1000, 2000, 4000];
const ANSWER_MS = 5000;
const SAID_MS = 10000;
const WORDS = {
  searching: "Searching",
  tracking: "Tracking",
  weak: "Weak",
  lost: "Lost",
  refused: "Refused",
  relocalised: "Found again",
};
const SEEN = new Set(["tracking", "weak", "relocalised"]);
const GUESS = { width: 640, height: 480, fx: 600, fy: 600, cx: 319.5, cy: 239.5, model: "pinhole", coefficients: [] };

class LivePage {
  constructor() {
    const { base, target } = document.body.dataset;
    this.base = base;
    this.target = target;
    this.element = document.createElement("main");
    this.bar = document.createElement("header");
    this.bar.setAttribute("role", "status");
    this.state = document.createElement("strong");
    this.why = document.createElement("span");
    this.bar.append(this.state, this.why);
    this.hint = document.createElement("p");
    this.foot = document.createElement("footer");
    document.body.append(this.element, this.bar, this.hint, this.foot);
    this.figures = new LiveFigures(this.foot);
    this.note = document.createElement("p");
    this.note.className = "said";
    this.foot.append(this.note);
    const pose = { data: new Float64Array(7).fill(NaN), shape: [1, 7] };
    const about = { camera: GUESS, up: [0, 0, 1], grey: false, depth_m: [0.01, 50], world_T_camera: pose };
    this.stage = new EditorStage(this.element, about);
    this.figure = new LiveFigure(base, this.stage.figures);
    this.touch = new LiveTouch(this.element, this.#touched());
    new ResizeObserver(() => this.stage.fit()).observe(this.element);
    this.stage.fit();
    this.number = 0;
    this.latency = NaN;
    this.shots = new Map();
    this.tries = 0;
    this.drawn = 0;
    this.heard = performance.now();
    this.again = "";
    /** @type {Map<string, () => object>} what fingers did since an image was drawn */
    this.waiting = new Map();
    /** @type {LiveCamera|null} */
    this.camera = null;
    /** @type {LiveMotion|null} */
    this.motion = null;
    addEventListener("offline", () => this.#lost("no network"));
    addEventListener("online", () => {
      if (this.socket.readyState === WebSocket.OPEN) return; // a try was quicker
      this.tries = 0;
      this.#lost("the network is back");
    });
    this.#connect();
  }

  /** @returns {import("./live_touch.js").Touched} */
  #touched() {
    const at = (x, y) => ({ frame: this.shown, pixels: [this.stage.pixelAt(x, y)] });
    return {
      tap: (x, y) => this.#gesture({ do: this.figure.state ? "walk" : "stand", ...at(x, y) }),
      drag: (x, y) => this.#later("drag", () => ({ do: "drag", ...at(x, y) })),
      resize: (by) => {
        this.factor = (this.factor ?? 1) * by;
        this.#later("resize", () => {
          const message = { do: "resize", by: this.factor };
          this.factor = 1;
          return message;
        });
      },
      turn: (by) => {
        this.angle = (this.angle ?? 0) + by;
        this.#later("turn", () => {
          const message = { do: "turn", by: this.angle };
          this.angle = 0;
          return message;
        });
      },
      ends: () => {
        const [feet, head] = this.figure.ends?.map((point) => this.stage.placeOf(point)) ?? [];
        return feet && head ? [feet, head] : null;
      },
    };
  }

  /** One message a drawn frame is enough of what a finger does. */
  #later(kind, message) {
    this.waiting.set(kind, message);
  }

  #gesture(message) {
    this.#put(JSON.stringify(message));
  }

  #connect() {
    const address = new URL(`${this.base}live`, location.href);
    address.protocol = address.protocol.replace("http", "ws");
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = (event) => this.#hear(event.data);
    this.socket.onclose = (event) => this.#lost(event.reason || "no connection");
  }

  /** Without a connection: say so, and connect again. */
  #lost(why) {
    clearTimeout(this.patience);
    clearTimeout(this.retry);
    Object.assign(this.socket, { onclose: null, onmessage: null });
    this.socket.close();
    this.cut ||= this.heard;
    this.#say("lost", `${why}; trying again`);
    const pause = AGAIN_MS[Math.min(this.tries++, AGAIN_MS.length - 1)];
    this.retry = setTimeout(() => this.#connect(), pause);
  }

  #hear(data) {
    this.heard = performance.now();
    if (this.cut) {
      this.again = `connected again, after ${((this.heard - this.cut) / 1000).toFixed(1)} s`;
      setTimeout(() => (this.again = ""), SAID_MS);
      this.cut = 0;
    }
    if (typeof data !== "string") {
      this.#watched(data);
      return;
    }
    const message = JSON.parse(data);
    if (message.hello) this.#begin(message.hello);
    else if (message.ended) this.#say("lost", message.ended);
    else if (message.error) this.note.textContent = message.error;
    else this.#answered(message);
  }

  async #begin(what) {
    this.tries = 0;
    if (what !== "film") return;
    try {
      this.motion ??= new LiveMotion();
      this.camera ??= await LiveCamera.open();
      await this.#send();
    } catch (fault) {
      this.#say("searching", `no camera: ${fault.message}`);
      this.#offer();
    }
  }

  /** A button, since some browsers ask for the camera after a tap alone. */
  #offer() {
    const button = document.createElement("button");
    button.className = "offer";
    button.textContent = "Use the camera";
    button.onclick = () => {
      button.remove();
      this.#begin("film");
    };
    this.element.append(button);
  }

  /** Send the newest frame, and hold it until its pose comes. */
  async #send() {
    const { socket } = this;
    const shot = await this.camera.take();
    if (socket.readyState !== WebSocket.OPEN) {
      shot.frame.close();
      return;
    }
    const number = this.number++;
    const message = await this.camera.message(shot, number, this.latency, this.motion.take());
    this.latency = NaN;
    this.shots.set(number, shot);
    socket.send(message);
    clearTimeout(this.patience);
    const sent = performance.now();
    this.patience = setTimeout(() => {
      if (this.heard > sent) this.#send(); // it was refused, and said so
      else this.#lost("no answer");
    }, ANSWER_MS);
  }

  #answered(message) {
    const shot = this.shots.get(message.frame);
    if (!shot) return;
    clearTimeout(this.patience);
    this.#send(); // the next is tracked while this one is drawn
    for (const [number, older] of this.shots) {
      if (number > message.frame) break;
      this.shots.delete(number);
      if (number !== message.frame) older.frame.close();
    }
    this.#draw(message, shot.frame, LiveCamera.sizeOf(shot.frame));
    shot.frame.close();
    requestAnimationFrame(() => {
      this.latency = performance.now() - shot.captured_ms;
    });
  }

  /** An image from elsewhere, which came with its pose. */
  async #watched(data) {
    const length = new DataView(data).getUint32(0, true);
    const message = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const image = await createImageBitmap(new Blob([new Uint8Array(data, 4 + length)]));
    this.#draw(message, image, [image.width, image.height]);
    image.close();
    requestAnimationFrame(() => this.#put(`drew ${message.frame}`));
  }

  #put(text) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(text);
  }

  #draw(message, image, [width, height]) {
    this.#look(message.camera ?? { ...GUESS, width, height });
    const { data } = this.stage.about.world_T_camera;
    if (message.pose) data.set(message.pose);
    else data.fill(NaN);
    this.#depth(message);
    this.shown = message.frame;
    this.figure.show(message.figure);
    this.stage.show(0, image);
    this.stage.draw();
    this.drawn++;
    this.#say(message.state, message.why);
    if (message.figures) this.#tell(message.figures);
    for (const after of this.waiting.values()) this.#gesture(after());
    this.waiting.clear();
  }

  /** Near and far planes that hold the ground and the figure. */
  #depth({ pose }) {
    if (!pose) return;
    const away = Math.hypot(pose[0], pose[1], pose[2]);
    this.stage.about.depth_m = [0.01 * away, 100 * away];
  }

  #look(camera) {
    const text = JSON.stringify(camera);
    if (text === this.looked) return;
    this.looked = text;
    this.stage.about.camera = camera;
    [this.stage.ground.width, this.stage.ground.height] = [camera.width, camera.height];
    lookThrough(camera);
    this.stage.fit();
  }

  #say(state, why) {
    document.body.dataset.state = state;
    this.state.textContent = WORDS[state] ?? state;
    this.why.textContent = why ?? "";
    this.hint.textContent = this.figure.state
      ? ""
      : SEEN.has(state)
        ? "Tap where it shall stand"
        : `Point the camera at ${this.target}`;
  }

  #tell(figures) {
    this.figures.tell(figures);
    const asks = this.motion?.asks ? "tap, to let motion sensors help" : "";
    const said = [this.again, figures.camera_status, figures.recorded, asks];
    this.note.textContent = said.filter(Boolean).join(" · ");
  }
}

if (drawnBy() === "nobody") document.body.textContent = NO_WEBGL;
else Object.assign(window, { livePage: new LivePage() });
