// The page of a run: its stage of panes, one timeline for everything, plots, and what is shown.

import { Film } from "studio/film.js";
import { bytesOf, decode, nearest } from "studio/look.js";
import { KINDS, NO_WEBGL, Pane, Stage } from "studio/panes.js";
import { Plots } from "studio/plots.js";
import { onScheme, variableOf } from "studio/scheme.js";
import { Timeline, wireKeys, wireScrubber } from "studio/timeline.js";
import { PARTS, World } from "studio/world.js";

const VIEWS = [["film"], ["camera"], ["world"], ["camera", "world"]];
const SPEEDS = [1, 0.5, 0.25];
const find = (selector) => document.querySelector(selector);

function made(tag, about = {}, ...children) {
  const element = Object.assign(document.createElement(tag), about);
  element.append(...children);
  return element;
}

/** The address of a film: of bytes inside the page, or of a file beside it. */
function addressOf(source) {
  if (!source.startsWith("#")) return source;
  const holder = document.getElementById(source.slice(1));
  const address = URL.createObjectURL(new Blob([bytesOf(holder.textContent)], { type: "video/mp4" }));
  holder.remove();
  return address;
}

/** A run on the page: its document, its films and its world. */
class Shown {
  constructor(look) {
    this.look = look;
    const { width, height, rate_hz, time_s: times, clips } = look.film;
    const about = { width, height, rate_hz, frames: times.shape[0] };
    /** @type {Record<string, Film>} */
    this.films = {};
    for (const clip of clips) {
      const [wide, high] = clip.name === "small" ? clip.size : [width, height];
      const own = { ...about, width: wide, height: high };
      this.films[clip.name] = new Film(addressOf(clip.src), own, clip);
    }
    const { footage, overlay, small } = this.films;
    const film = small ?? footage ?? overlay;
    this.world = new World(look, film?.image ?? document.createElement("canvas"));
  }

  /** What lies under a kind of view. */
  filmOf(kind) {
    const { footage, overlay } = this.films;
    return kind === "film" ? (overlay ?? footage) : (footage ?? overlay);
  }
}

class Viewer {
  constructor(looks) {
    this.runs = looks.map((one) => new Shown(one));
    const [first] = this.runs;
    this.timeline = new Timeline(first.look.film.time_s.data);
    this.stage = new Stage(find("#stage"));
    const { width, height } = first.look.camera;
    this.stage.element.style.setProperty("--aspect", String(width / height));
    this.speed = 1;
    this.view = !this.stage.renderer ? 0 : innerWidth < 720 ? 1 : 3;
    if (!this.stage.renderer) this.#tell(`${NO_WEBGL} Until then: the film and the plots.`);
    this.beside = looks.length > 1;
    this.pathOf = [first.look.drawn, this.#other()];
    this.plots = new Plots(find("#plots"), looks, this.timeline);
    this.timeline.listen((frame, asked) => this.#follow(frame, asked));
    for (const run of this.runs) this.#wireFilms(run);
    wireScrubber(this.timeline, first.look, {
      range: find("#scrubber"),
      band: find("#states"),
      words: find("#clock"),
      state: find("#state"),
    });
    this.#wireButtons();
    this.#legend();
    onScheme(() => this.#recolour());
    addEventListener("studio-changed", () => this.stage.draw());
    this.arrange();
    /** @type {Promise<void>} */
    this.ready = this.#finish();
  }

  async #finish() {
    await Promise.all(this.runs.map((run) => run.world.loadFigures()));
    this.stage.draw();
    document.documentElement.dataset.ready = "true";
  }

  /** What is set beside the drawn path at first: the other run's, or one that differs. */
  #other() {
    const [first, second] = this.runs;
    if (second) return second.look.drawn;
    const names = first.look.paths.map((one) => one.name).filter((one) => one !== first.look.drawn);
    return ["euler", "measured", ...names].find((one) => names.includes(one)) ?? first.look.drawn;
  }

  get playing() {
    return Boolean(this.master?.playing || this.ticking);
  }

  /** Films that a pane shows now; the first leads while it plays. */
  get films() {
    const shown = this.stage.panes.map((pane) => pane.film);
    const outside = this.stage.panes.filter((pane) => pane.kind === "world");
    const small = this.runs.filter(({ world }) => outside.some((pane) => pane.world === world));
    return [...new Set([...shown, ...small.map((run) => run.films.small)].filter(Boolean))];
  }

  #wireFilms(run) {
    for (const film of Object.values(run.films)) {
      film.onshown = (frame) => {
        run.world.held = -1;
        if (film.playing && film === this.master) this.timeline.go(frame, false);
        this.stage.draw();
        if (film === this.master) this.#buttonState();
      };
      film.onproblem = (problem) => this.#tell(problem);
    }
  }

  #tell(problem) {
    find("#problem").textContent = problem;
    find("#problem").hidden = false;
  }

  /** Bring every film to a frame; where there is none, draw at once. */
  #follow(frame, asked) {
    if (asked) this.pause();
    const seconds = this.timeline.seconds;
    for (const run of this.runs) {
      const own = run === this.runs[0] ? frame : nearest(run.look.film.time_s.data, seconds);
      for (const film of Object.values(run.films)) {
        if (this.films.includes(film) && !(film === this.master && !asked)) film.seek(own);
      }
    }
    if (!this.films.length) this.stage.draw();
    this.#buttonState();
  }

  play() {
    this.master = this.films[0];
    if (this.master) this.master.play(this.speed);
    else this.#tick();
    this.#buttonState();
  }

  /** Without a film, frames follow the clock. */
  #tick() {
    const { timeline, speed } = this;
    if (timeline.frame === timeline.last) timeline.go(0, false);
    const [begun, from] = [performance.now(), timeline.seconds];
    const step = () => {
      if (!this.ticking) return;
      const now = from + (speed * (performance.now() - begun)) / 1000;
      timeline.go(nearest(timeline.times, now), false);
      this.ticking = timeline.frame < timeline.last && requestAnimationFrame(step);
      this.#buttonState();
    };
    this.ticking = requestAnimationFrame(step);
  }

  pause() {
    for (const film of this.films) if (film.playing) film.pause();
    this.ticking = 0;
    this.#buttonState();
  }

  #buttonState() {
    const button = find("#play");
    button.ariaLabel = this.playing ? "Pause" : "Play";
    button.classList.toggle("playing", this.playing);
  }

  /** Lay the panes out anew. */
  arrange() {
    this.pause();
    for (const pane of this.stage.panes) {
      pane.controls?.dispose();
      pane.element.remove();
    }
    this.stage.panes = [];
    const kinds = VIEWS[this.view];
    const sides = this.beside ? [0, 1] : [0];
    const holder = find("#panes");
    holder.style.setProperty("--columns", String(sides.length > 1 ? 2 : kinds.length));
    holder.dataset.panes = String(sides.length * kinds.length);
    for (const kind of kinds) for (const side of sides) this.#pane(holder, kind, side);
    for (const [k, button] of find("#views").querySelectorAll("button").entries()) {
      button.ariaPressed = String(k === this.view);
    }
    find("#beside").ariaPressed = String(this.beside);
    find("#paths").classList.toggle("two", this.beside && this.runs.length > 1);
    this.#compare();
    this.stage.fit();
    this.#follow(this.timeline.frame, true);
  }

  /** Let the plots set off what is shown here. */
  #compare() {
    const sides = this.pathOf.map((path, side) => ({ run: this.runs[side] ? side : 0, path }));
    this.plots.compare(this.beside ? sides : sides.slice(0, 1));
  }

  #pane(holder, kind, side) {
    const run = this.runs[side] ?? this.runs[0];
    const element = made("section", { className: `pane ${kind}${kind === "world" ? "" : " flat"}` });
    holder.append(element);
    const frameNow = () => nearest(run.look.film.time_s.data, this.timeline.seconds);
    const pane = new Pane(element, kind, run.world, run.filmOf(kind) ?? null, frameNow);
    element.append(this.#title(pane, run, side));
    pane.path = this.pathOf[side];
    this.stage.panes.push(pane);
    if (kind === "camera") element.append(made("small", {}, run.world.hiding.words));
    if (kind !== "world") return;
    pane.orbit(() => this.stage.draw());
    const home = made("button", { className: "quiet home", title: "Back to the first view" }, "Reset");
    home.addEventListener("click", () => pane.goHome());
    element.append(home);
  }

  /** What a pane shows, and along which path. */
  #title(pane, run, side) {
    const title = made("header", {}, made("b", {}, KINDS[pane.kind]));
    if (this.runs.length > 1) title.append(made("span", {}, run.look.name));
    if (pane.kind === "film") return title;
    const choice = made("select", { ariaLabel: "Camera path", title: "Camera path" });
    for (const { name, label } of run.look.paths) choice.append(new Option(label, name));
    choice.value = this.pathOf[side];
    choice.addEventListener("change", () => {
      this.pathOf[side] = choice.value;
      for (const one of this.stage.panes) {
        const select = one.element.querySelector("select");
        if (select?.dataset.side === String(side)) select.value = one.path = choice.value;
      }
      this.#compare();
      this.stage.draw();
    });
    choice.dataset.side = String(side);
    title.append(choice);
    return title;
  }

  #wireButtons() {
    const toggle = () => (this.playing ? this.pause() : this.play());
    const show = (view) => () => {
      this.view = view;
      this.arrange();
    };
    const beside = () => {
      this.beside = !this.beside;
      this.arrange();
    };
    const help = find("#help");
    const ask = () => (help.open ? help.close() : help.showModal());
    const actions = { " ": toggle, "?": ask, s: beside };
    for (const [k, button] of find("#views").querySelectorAll("button").entries()) {
      // Recordings of corners alone have no film.
      const film = VIEWS[k].includes("film");
      button.hidden = film ? !this.runs[0].filmOf("film") : !this.stage.renderer;
      if (!button.hidden) button.addEventListener("click", (actions[String(k + 1)] = show(k)));
    }
    find("#play").addEventListener("click", toggle);
    find("#back").addEventListener("click", () => this.timeline.go(this.timeline.frame - 1));
    find("#on").addEventListener("click", () => this.timeline.go(this.timeline.frame + 1));
    find("#beside").addEventListener("click", beside);
    find("#ask").addEventListener("click", ask);
    help.querySelector("button").addEventListener("click", () => help.close());
    const speed = find("#speed");
    for (const one of SPEEDS) speed.append(new Option(`${one}×`.replace("0.", "."), String(one)));
    speed.addEventListener("change", () => {
      this.speed = Number(speed.value);
      if (this.playing) this.play();
    });
    wireKeys(this.timeline, actions);
  }

  /** Chips that show and hide paths, in plots and in the world alike, and parts of the world. */
  #legend() {
    const [first] = this.runs;
    const chip = (name, label, colour) => {
      const button = made("button", { className: "chip", ariaPressed: "true" });
      if (colour) button.append(made("i", { style: `background:var(${colour})` }));
      button.append(label);
      button.addEventListener("click", () => this.#toggle(button, name));
      return button;
    };
    if (this.runs.length > 1) {
      for (const [k, { look }] of this.runs.entries()) {
        const dash = made("i", { className: k ? "second" : "first" });
        find("#paths").append(made("span", { className: "run" }, dash, look.name));
      }
    }
    const paths = new Map(this.runs.flatMap((run) => run.look.paths).map((one) => [one.name, one]));
    for (const { name, label } of paths.values()) {
      const short = label.replace(/^Smoothed, (.)/, (_all, letter) => letter.toUpperCase());
      find("#paths").append(chip(name, short, variableOf(name)));
    }
    for (const name of first.world.present) find("#parts").append(chip(name, PARTS[name]));
  }

  #toggle(button, name) {
    const visible = button.ariaPressed !== "true";
    button.ariaPressed = String(visible);
    for (const { world } of this.runs) world.hidden[visible ? "delete" : "add"](name);
    this.plots.show(name, visible);
    this.stage.draw();
  }

  #recolour() {
    for (const { world } of this.runs) world.recolour();
    this.plots.recolour();
    this.stage.draw();
  }
}

const looks = [...document.querySelectorAll("script.look")].map((one) => decode(one.textContent));
// For whoever looks into the page by its console, as tests do.
globalThis.viewer = new Viewer(looks);
