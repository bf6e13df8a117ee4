// The editor: a scene on the footage, put together by hand.

import { Vector3 } from "studio/vendor.js";
import { Actor, Wardrobe, wayLine } from "studio/editor_actors.js";
import { Film } from "studio/editor_film.js";
import { Gestures } from "studio/editor_gestures.js";
import { Handles } from "studio/editor_handles.js";
import { icon } from "studio/editor_icons.js";
import { Lanes } from "studio/editor_lanes.js";
import { Link } from "studio/editor_link.js";
import { Panel } from "studio/editor_panel.js";
import { Images } from "studio/editor_images.js";
import { Posing } from "studio/editor_posing.js";
import { EditorStage } from "studio/editor_stage.js";
import { EditorTimeline, button, made } from "studio/editor_timeline.js";
import { decoded } from "studio/look.js";
import { NO_WEBGL, drawnBy } from "studio/panes.js";
import { actions } from "studio/editor_actions.js";
import { keyboard } from "studio/editor_keys.js";

const MOUSE = matchMedia("(hover: hover) and (pointer: fine)").matches;
/** A way that is shorter is a touch, CSS pixels. */
const TOUCHED_PX = 12;
const HANDS = MOUSE
  ? "Drag to move, the ring turns, the wheel resizes."
  : "Drag to move. Two fingers turn and resize.";
const HINTS = {
  empty: `${MOUSE ? "Click" : "Tap"} Add to put somebody into the image.`,
  chosen: `${HANDS} Walk lets them go.`,
  prop: HANDS,
  none: `${MOUSE ? "Click" : "Tap"} somebody to choose them.`,
  pose: "Drag a hand, a foot or the head. Pose ends it.",
  draw: `Draw the way on the ground, or ${MOUSE ? "click" : "tap"} where to go.`,
};

export class Editor {
  constructor(body, about) {
    this.about = about;
    this.base = body.dataset.run;
    this.chosen = null;
    this.draws = false;
    /** @type {Map<string, Actor>} */
    this.actors = new Map();
    this.state = { objects: [], undo: false, redo: false };
    this.frame = 0;
    this.snapping = false;
    this.#layOut(body);
    this.wardrobe = new Wardrobe(this.base);
    this.handles = new Handles();
    this.posing = new Posing(this.stage.element, this);
    this.stage.scene.add(this.handles.object);
    this.images = new Images(this.base, about.frames, () => this.redraw());
    this.gestures = new Gestures(this.stage.element, this);
    const address = new URL(`${this.base}edit`, location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.link = new Link(address.href, {
      news: (message) => this.hear(message),
      line: (up, why) => this.#line(up, why),
    });
    new ResizeObserver(() => {
      this.stage.fit();
      this.redraw();
    }).observe(this.stage.element);
    keyboard(this);
    this.seek(0);
  }

  #layOut(body) {
    const home = made("a", "round", icon("back"));
    Object.assign(home, { href: body.dataset.home, title: "All footage", ariaLabel: "All footage", hidden: !body.dataset.home });
    this.undo = button("Undo", () => this.ask({ do: "undo" }), { sign: "undo", className: "round" });
    this.redo = button("Redo", () => this.ask({ do: "redo" }), { sign: "redo", className: "round" });
    const film = button("Film", () => this.panel.film(), { title: "Draw and play the film", className: "film" });
    this.title = made("strong", "title", this.about.name);
    const bar = made("header", "bar", home, this.title, film, this.undo, this.redo);
    const view = made("div", "stage");
    this.hint = made("p", "hint");
    this.hint.setAttribute("role", "status");
    this.note = made("p", "note");
    this.note.hidden = true;
    this.note.setAttribute("role", "alert");
    view.append(this.hint, this.note);
    this.stage = new EditorStage(view, this.about);
    this.lanes = new Lanes(this.length, {
      snapped: (seconds) => this.#timeOf(this.#frameAt(seconds)),
      seek: (seconds) => this.seekTime(seconds),
      pick: (mark) => {
        this.seekTime(mark.start_s);
        this.panel.mark(mark);
      },
      change: async (mark, to) => {
        const answer = await this.panel.act.mark(mark, to);
        if (!answer.ok) this.lanes.show(this.one);
      },
    });
    this.timeline = new EditorTimeline(this.about.time_s.data, { seek: (frame) => this.seek(frame) }, this.lanes.element);
    this.film = new Film(this.base, this.about.film, (message) => this.ask(message));
    this.panel = new Panel(this.about, actions(this), this.film);
    body.append(bar, view, made("footer", "below", this.timeline.element, this.panel.element));
  }

  #line(up, why) {
    this.lost = !up;
    document.body.classList.toggle("lost", !up);
    if (!up) {
      this.gestures?.cancel();
      this.posing?.cancel();
      this.say(why || "The server does not answer. Trying again; what you did is kept. If it was started anew, open its new link.", true);
    } else {
      this.note.hidden = true;
    }
  }

  /** Tell something, for a while or until it is over. */
  say(text, stays = false) {
    this.note.textContent = text;
    this.note.hidden = false;
    clearTimeout(this.hides);
    if (!stays) this.hides = setTimeout(() => (this.note.hidden = true), 4000);
  }

  /** Ask the server, and tell what it refuses. */
  async ask(message) {
    const answer = await this.link.send(message);
    this.hear(answer);
    if (!answer.ok && !answer.lost) this.say(answer.error);
    return answer;
  }

  /** Take what the server says: poses while something is dragged, the scene once it changed. */
  hear(message) {
    if (message.poses) {
      for (const [name, pose] of Object.entries(message.poses)) {
        const actor = this.actors.get(name);
        if (actor) actor.held = pose;
      }
    }
    for (const [name, joints] of Object.entries(message.joints ?? {})) {
      const actor = this.actors.get(name);
      if (actor) actor.pose = joints.data;
    }
    for (const name of message.free ?? []) {
      const actor = this.actors.get(name);
      if (actor) actor.held = actor.pose = null;
    }
    if (message.scene) this.#take(message.scene);
    if (message.holds) {
      for (const one of this.state.objects) one.held = message.holds.includes(one.name);
      this.panel.show(this.state.objects, this.chosen);
    }
    if (message.said !== undefined) this.hint.textContent = message.said;
    else if (!message.poses && !message.joints) this.#hints();
    this.redraw();
  }

  /** Take what changed in the scene: objects as they are now, names where others or in another order. */
  #take(scene) {
    const known = new Map(this.state.objects.map((one) => [one.name, one]));
    for (const about of scene.objects) {
      const { track, ground, way } = known.get(about.name) ?? {};
      known.set(about.name, { track, ground, way, ...about });
    }
    const order = scene.names ?? this.state.objects.map((one) => one.name);
    this.state = { ...scene, objects: order.map((name) => known.get(name)).filter(Boolean) };
    const names = new Set(order);
    for (const [name, actor] of this.actors) {
      if (names.has(name)) continue;
      this.stage.figures.remove(actor.object, actor.shadow);
      this.actors.delete(name);
    }
    for (const about of scene.objects) {
      let actor = this.actors.get(about.name);
      if (!actor) {
        actor = new Actor(about.name);
        this.actors.set(about.name, actor);
        this.stage.figures.add(actor.shadow, actor.object);
      }
      actor.tell(about);
      actor.held = null;
      this.wardrobe.dress(actor).then(
        () => this.redraw(),
        (fault) => this.say(`${about.name} cannot be shown: ${fault.message}`),
      );
    }
    if (!names.has(this.chosen)) this.chosen = null;
    this.undo.disabled = !scene.undo;
    this.redo.disabled = !scene.redo;
    this.choose(this.chosen);
  }

  /** @returns {object|null} what the server says of what is chosen */
  get one() {
    return this.state.objects.find((one) => one.name === this.chosen) ?? null;
  }

  choose(name) {
    this.chosen = this.actors.has(name) ? name : null;
    this.panel.show(this.state.objects, this.chosen);
    this.lanes.show(this.one);
    this.#ways();
    this.#hints();
    this.redraw();
  }

  #hints() {
    const { one } = this;
    const what = !this.state.objects.length ? "empty" : !one ? "none" : one.kind === "character" ? "chosen" : "prop";
    if (this.posing.on && what === "chosen") {
      this.hint.textContent = HINTS.pose;
      return;
    }
    const known = this.taught && (what === "chosen" || what === "prop");
    this.hint.textContent = this.draws || !known ? HINTS[this.draws ? "draw" : what] : "";
  }

  /** Lines of the chosen one's way and of the path between its keyframes. */
  #ways() {
    for (const line of this.ways ?? []) {
      this.stage.signs.remove(line);
      line.geometry.dispose();
      line.material.dispose();
    }
    const way = this.one?.way?.data;
    this.ways = way ? [wayLine(way, 0xffc145)] : [];
    for (const line of this.ways) this.stage.signs.add(line);
  }

  #frameAt(seconds) {
    const times = this.about.time_s.data;
    const since = seconds + times[0];
    let best = 0;
    for (let k = 0; k < times.length; k++) {
      if (Math.abs(times[k] - since) < Math.abs(times[best] - since)) best = k;
    }
    return best;
  }

  #timeOf(frame) {
    return this.about.time_s.data[frame] - this.about.time_s.data[0];
  }

  seekTime(seconds) {
    this.timeline.pause();
    this.seek(this.#frameAt(seconds));
  }

  seek(frame) {
    this.frame = frame;
    this.timeline.show(frame);
    this.redraw();
  }

  get seconds() {
    return this.#timeOf(this.frame);
  }

  /** How long the footage is, s. */
  get length() {
    return this.about.time_s.data.at(-1) - this.about.time_s.data[0];
  }

  /** Draw soon; the image on show and the drawing are always of one frame. */
  redraw() {
    if (this.drawing_soon) return;
    this.drawing_soon = true;
    requestAnimationFrame(() => {
      this.drawing_soon = false;
      this.draw();
    });
  }

  draw() {
    const image = this.images.at(this.frame);
    if (!image && this.stage.shown !== this.frame) return;
    this.stage.shown = this.frame;
    this.stage.show(this.frame, image);
    for (const actor of this.actors.values()) actor.show(this.frame, this.seconds);
    this.#placeHandles();
    this.stage.draw();
    this.drawnFrame = this.frame;
    this.drawn_at = performance.now();
    document.body.dataset.frame = String(this.frame);
  }

  #placeHandles() {
    const actor = this.actors.get(this.chosen);
    const shown = actor && actor.object.visible && !this.draws && !this.timeline.playing;
    const poses = shown && this.posing.on && this.one.kind === "character";
    this.posing.show(poses ? actor : null);
    if (!shown || poses) {
      this.handles.hide();
      return;
    }
    const place = actor.place;
    this.handles.show(actor.axes(this.handles.axes, this.frame), place, this.stage.metresAPixel(place), actor.height);
  }

  // What the gestures ask for.

  pick(x, y, coarse) {
    const handle = this.stage.handleAt(x, y, this.handles);
    const touched = this.stage.hit(x, y, this.actors.values(), coarse && !handle);
    const through = this.handles.kind === "few" && touched?.name === this.chosen;
    if (!handle || through) return touched;
    const { point, ...rest } = handle;
    return { name: this.chosen, handle: rest, point: new Vector3(...point) };
  }

  pixelAt(x, y) {
    return this.stage.pixelAt(x, y);
  }

  begin(what) {
    this.timeline.pause();
    this.ask({ do: "begin", frame: this.frame, snap: this.snapping, ...what });
  }

  drag(pixels, amount) {
    this.ask(pixels ? { do: "drag", pixels } : { do: "drag", amount });
  }

  end() {
    this.taught = true;
    this.ask({ do: "end" });
  }

  cancel() {
    this.ask({ do: "cancel" });
  }

  drawing(way) {
    this.stage.sketch(way);
  }

  async drawn(way) {
    this.draws = false;
    document.body.classList.remove("draws");
    this.stage.sketch(null);
    this.panel.show(this.state.objects, this.chosen);
    const [first] = way;
    const far = Math.max(...way.map(([x, y]) => Math.hypot(x - first[0], y - first[1])));
    const from = far < TOUCHED_PX ? this.stage.placeOf(this.actors.get(this.chosen).place) : null;
    const pixels = (from ? [from, first] : way).map(([x, y]) => this.pixelAt(x, y));
    const step = Math.max(1, Math.ceil(pixels.length / 400));
    const answer = await this.ask({
      do: "walk",
      object: this.chosen,
      frame: this.frame,
      pixels: pixels.filter((_, k) => k % step === 0 || k === pixels.length - 1),
    });
    this.#hints();
    if (answer.ok) {
      this.seek(0);
      this.timeline.start();
    }
  }

  sketchWalk() {
    this.draws = !this.draws;
    document.body.classList.toggle("draws", this.draws);
    this.timeline.pause();
    this.panel.show(this.state.objects, this.chosen);
    this.#hints();
    this.redraw();
  }
}

async function begin() {
  const { body } = document;
  const told = made("p", "loading", "Opening the footage …");
  body.append(told);
  if (drawnBy() === "nobody") {
    told.textContent = NO_WEBGL;
    return;
  }
  const answer = await fetch(`${body.dataset.run}about.json`);
  const text = await answer.text();
  if (!answer.ok) {
    told.textContent = text;
    return;
  }
  told.remove();
  Object.assign(window, { editor: new Editor(body, decoded(text)) });
}

begin();
