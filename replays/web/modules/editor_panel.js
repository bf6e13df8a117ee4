// Buttons and forms round the scene: what can be added, what the chosen one does, its numbers.

import { choice, labelled, numberField, spoken, tick } from "studio/editor_fields.js";
import { layerForms, markForm } from "studio/editor_marks.js";
import { button, made } from "studio/editor_timeline.js";

/** @type {[string, string, number|null, string][]} */
const NUMBERS = [
  ["x", "position_m", 0, "m"],
  ["y", "position_m", 1, "m"],
  ["z", "position_m", 2, "m"],
  ["turn x", "euler_deg", 0, "°"],
  ["turn y", "euler_deg", 1, "°"],
  ["turn z", "euler_deg", 2, "°"],
  ["size", "scale", null, "×"],
];
// Of an object, what no form tells: where it is at every frame.
const UNSEEN = new Set(["track", "ground", "way", "held"]);
const AXES = { parent: "Ground's axes", local: "Own axes", global: "World's axes" };

/** The row of tools below the timeline; what it offers follows what is chosen. */
export class Panel {
  /**
   * @param {object} about the run
   * @param {object} act what the buttons do
   * @param {import("./editor_film.js").Film} drawn its film
   */
  constructor(about, act, drawn) {
    this.about = about;
    this.drawn = drawn;
    this.act = act;
    this.names = made("div", "names");
    this.names.setAttribute("role", "group");
    this.names.ariaLabel = "What is in the scene";
    this.tools = made("div", "tools");
    this.sheet = made("div", "sheet");
    this.sheet.hidden = true;
    this.element = made("div", "panel", this.sheet, this.names, this.tools);
    this.open = null;
    /** What stands in the rows of buttons. */
    this.stands = new Map();
  }

  /** Follow the scene. */
  show(objects, chosen) {
    this.chosen = objects.find((one) => one.name === chosen) ?? null;
    this.objects = objects;
    this.#renew(this.names, [objects.map((one) => [one.name, one.held]), chosen], () => objects.map((one) => this.#chip(one)));
    this.names.hidden = objects.length < 2;
    const { kind, walk, held_by } = this.chosen ?? {};
    const offered = [objects.length > 0, kind, walk, Object.keys(held_by ?? {}), this.act.draws(), this.act.poses()];
    this.#renew(this.tools, offered, () => this.#tools());
    if (this.open) this.#fill(this.open);
  }

  /** Buttons anew where they changed only: one that goes while a finger is on it hears no click. */
  #renew(element, what, make) {
    const now = JSON.stringify(what);
    if (this.stands.get(element) === now) return;
    this.stands.set(element, now);
    element.replaceChildren(...make());
  }

  #chip(one) {
    const chip = button(one.name, () => this.act.choose(one.name), { className: "chip" });
    chip.ariaPressed = String(one === this.chosen);
    if (one.held) chip.classList.add("held");
    return chip;
  }

  #tools() {
    const add = button("Add", () => this.#toggle("add"), { sign: "add", className: this.objects.length ? "" : "main" });
    if (!this.chosen) return [add];
    const { act, chosen } = this;
    const walks = chosen.kind === "character";
    const all = [
      walks && button("Walk", () => this.#bare(act.draw), { sign: "walk", title: "Draw where it walks", className: act.draws() ? "main" : "" }),
      walks && button("Do", () => this.#toggle("clips"), { sign: "act", title: "What it does" }),
      Object.keys(chosen.held_by ?? {}).length > 0 && button("Pose", () => this.#bare(act.pose), { sign: "pose", title: "Drag hands, feet and head", className: act.poses() ? "main" : "" }),
      !chosen.walk && button("Key", () => act.key(), { sign: "key", title: "Keep where it is at this moment" }),
      button("Axes", () => act.axes(), { sign: "axes", title: "Handles: few or all" }),
      button("Numbers", () => this.#toggle("numbers"), { sign: "numbers" }),
      button("Copy", () => act.copy(), { sign: "copy" }),
      button("More", () => this.#toggle("more"), { sign: "more" }),
      button("Delete", () => act.remove(), { sign: "remove" }),
    ];
    return [add, ...all.filter(Boolean)];
  }

  /** The film and how it is drawn, or no longer that. */
  film() {
    this.#toggle("film");
  }

  /** What can be done with something on the timeline. @param {import("./editor_lanes.js").Mark} mark */
  mark(mark) {
    this.marked = mark;
    this.open = "mark";
    this.#fill("mark");
  }

  #mark() {
    const { kind, start_s, number } = this.marked;
    const same = (one) => one.kind === kind && (kind === "walk" || kind === "layer" ? one.number === number : Math.abs(one.start_s - start_s) < 1e-6);
    const now = this.act.marks().find(same);
    return now ? markForm(now, this.chosen, this.act) : null;
  }

  /** Do what needs the whole scene to be seen. */
  #bare(act) {
    this.close();
    act();
  }

  #toggle(what) {
    this.open = this.open === what ? null : what;
    this.#fill(this.open);
  }

  close() {
    this.open = null;
    this.stands.delete(this.sheet);
    this.sheet.hidden = true;
  }

  #fill(what) {
    const need = what && what !== "add" && what !== "film";
    if (!what || (need && !this.chosen)) {
      this.close();
      return;
    }
    this.sheet.hidden = false;
    const { activeElement } = document;
    const at = activeElement instanceof HTMLElement && this.sheet.contains(activeElement) ? activeElement : null;
    const typing = at instanceof HTMLInputElement && at.type === "text" && at.value !== at.defaultValue;
    if (what !== "add" && typing) return;
    const told = JSON.stringify([what, this.marked, this.chosen, this.objects?.map((one) => one.name)], (key, one) => (UNSEEN.has(key) ? null : one));
    if (what !== "numbers" && this.stands.get(this.sheet) === told) return;
    this.stands.set(this.sheet, told);
    const parts = { add: () => this.#add(), film: () => this.#film(), clips: () => this.#clips(), numbers: () => this.#numbers(), more: () => this.#more(), mark: () => this.#mark() };
    const inside = parts[what]();
    if (!inside) {
      this.close();
      return;
    }
    this.sheet.replaceChildren(button("Close", () => this.close(), { sign: "close", className: "close" }), ...inside);
    const again = at?.dataset.field && this.sheet.querySelector(`[data-field="${at.dataset.field}"]`);
    if (again instanceof HTMLElement) again.focus();
  }

  #add() {
    const choices = this.about.wardrobe.map((one) =>
      button(one.label, () => {
        this.close();
        this.act.add(one);
      }, { sign: one.kind === "character" ? "person" : "thing", className: "choice" }),
    );
    return [made("h2", "", "Put into the scene"), made("div", "choices", ...choices)];
  }

  #film() {
    this.drawn.look();
    return [made("h2", "", "The film"), this.drawn.element];
  }

  #clips() {
    const { chosen, act } = this;
    const clips = chosen.clips.map((name) => {
      const one = button(onTheSpot(name), () => act.clip(name), { className: "choice" });
      one.ariaPressed = String(!chosen.walk && (chosen.clip ?? "idle") === name);
      return one;
    });
    if (chosen.kind !== "character") return [made("h2", "", `What ${chosen.name} does`), made("div", "choices", ...clips)];
    const way = button("Walk along a way", () => this.#bare(act.draw), { sign: "walk", className: "choice" });
    way.ariaPressed = String(chosen.walk);
    const halt = chosen.walk ? [button("Stop walking", () => act.stay(), { className: "choice" })] : [];
    return [made("h2", "", `What ${chosen.name} does`), made("div", "choices", way, ...halt, ...clips), ...layerForms(chosen, act)];
  }

  #numbers() {
    const { chosen } = this;
    const place = made("div", "numbers");
    this.act.tell().then((answer) => {
      if (answer.ok && this.chosen === chosen) place.replaceChildren(...this.#fields(answer.numbers));
    });
    return [made("h2", "", `${chosen.name} on ${chosen.on}`), place];
  }

  #fields(numbers) {
    return NUMBERS.map(([label, key, at, unit]) => {
      const now = at === null ? numbers[key] : numbers[key][at];
      return numberField(label, now, unit, (value) => {
        if (at === null) numbers[key] = value;
        else numbers[key][at] = value;
        this.act.number(key, numbers[key]);
      });
    });
  }

  #more() {
    const { act, about, chosen, objects } = this;
    const others = objects.filter((one) => one.name !== chosen.name);
    const stands = [
      ["", "Nothing"],
      ...Object.entries(about.anchors),
      ...others.map((one) => [one.name, one.name]),
    ];
    const name = made("input");
    Object.assign(name, { type: "text", value: chosen.name, maxLength: 60 });
    name.addEventListener("change", () => act.rename(name.value.trim()));
    /** @type {[string, string][]} */
    const joins = [["motor", "Along a screw"], ["quaternion", "Straight"], ["euler", "Angle by angle"]];
    const wide = (text, does) => button(text, does, { className: "choice" });
    return [
      made("h2", "", chosen.name),
      labelled("Name", name),
      labelled("Stands on", choice(stands, chosen.parent ?? "", (value) => act.hang(value || null))),
      labelled("Handles along", choice(Object.entries(AXES), act.axesNow(), (value) => act.along(value))),
      ...(chosen.keys.length > 1 ? [labelled("Between keyframes", choice(joins, chosen.interpolation, (value) => act.join(value)))] : []),
      labelled("Snap to steps", tick(act.snaps(), (on) => act.snap(on))),
      ...(others.length ? [labelled("Group with", choice([["", "…"], ...others.map((one) => [one.name, one.name])], "", (value) => value && act.group(value)))] : []),
      ...(chosen.kind === "group" ? [wide("Ungroup", () => act.ungroup())] : []),
      ...(chosen.kind !== "group" ? [wide("Appear at this moment", () => act.appears()), wide("Vanish at this moment", () => act.vanishes())] : []),
      ...(chosen.visible_s ? [wide("Always be there", () => act.appear(null))] : []),
      ...(chosen.turns.length ? [wide("Forget its poses", () => act.unpose())] : []),
      ...(chosen.keys.length ? [wide("Forget its keyframes", () => act.unkey())] : []),
    ];
  }
}

/** A clip as a choice: those of walking are told apart from a walk that leads somewhere. */
function onTheSpot(name) {
  return spoken(name) + (/^(walk|jog|run)$/i.test(name) ? " on the spot" : "");
}
