// Buttons and forms round the scene: what can be added, what the chosen one does, its numbers.

import { button, made } from "studio/editor_timeline.js";

const NUMBERS = [
  ["x", "position_m", 0, "m"],
  ["y", "position_m", 1, "m"],
  ["z", "position_m", 2, "m"],
  ["turn x", "euler_deg", 0, "°"],
  ["turn y", "euler_deg", 1, "°"],
  ["turn z", "euler_deg", 2, "°"],
  ["size", "scale", null, "×"],
];
const AXES = { parent: "Ground's axes", local: "Own axes", global: "World's axes" };

/** The row of tools below the timeline; what it offers follows what is chosen. */
export class Panel {
  /** @param {object} about the run @param {object} act what the buttons do */
  constructor(about, act) {
    Object.assign(this, { about, act });
    this.names = made("div", "names");
    this.names.setAttribute("role", "group");
    this.names.ariaLabel = "What is in the scene";
    this.tools = made("div", "tools");
    this.sheet = made("div", "sheet");
    this.sheet.hidden = true;
    this.element = made("div", "panel", this.sheet, this.names, this.tools);
    this.open = null;
  }

  /** Follow the scene. */
  show(objects, chosen) {
    this.chosen = objects.find((one) => one.name === chosen) ?? null;
    this.objects = objects;
    this.names.replaceChildren(
      ...objects.map((one) => {
        const chip = button(one.name, () => this.act.choose(one.name), { className: "chip" });
        chip.ariaPressed = String(one.name === chosen);
        if (one.held) chip.classList.add("held");
        return chip;
      }),
    );
    this.names.hidden = objects.length < 2;
    this.tools.replaceChildren(...this.#tools());
    if (this.open) this.#fill(this.open);
  }

  #tools() {
    const add = button("Add", () => this.#toggle("add"), { sign: "add", className: "main" });
    if (!this.chosen) return [add];
    const { act, chosen } = this;
    const walks = chosen.kind === "character";
    const all = [
      walks && button("Walk", () => act.draw(), { sign: "walk", title: "Draw where it walks", className: act.draws() ? "main" : "" }),
      walks && button("Do", () => this.#toggle("clips"), { sign: "act", title: "What it does" }),
      Object.keys(chosen.held_by ?? {}).length > 0 && button("Pose", () => act.pose(), { sign: "pose", title: "Drag hands, feet and head", className: act.poses() ? "main" : "" }),
      !chosen.walk && button("Key", () => act.key(), { sign: "key", title: "Keep where it is at this moment" }),
      button("Axes", () => act.axes(), { sign: "axes", title: "Handles: few or all" }),
      button("Numbers", () => this.#toggle("numbers"), { sign: "numbers" }),
      button("Copy", () => act.copy(), { sign: "copy" }),
      button("More", () => this.#toggle("more"), { sign: "more" }),
      button("Delete", () => act.remove(), { sign: "remove" }),
    ];
    return [add, ...all.filter(Boolean)];
  }

  /** How the film is drawn, or no longer that. */
  film() {
    this.#toggle("film");
  }

  #toggle(what) {
    this.open = this.open === what ? null : what;
    this.#fill(this.open);
  }

  close() {
    this.open = null;
    this.sheet.hidden = true;
  }

  #fill(what) {
    const need = what && what !== "add" && what !== "film";
    if (!what || (need && !this.chosen)) {
      this.close();
      return;
    }
    this.sheet.hidden = false;
    const typing = this.sheet.contains(document.activeElement) && document.activeElement.matches("input");
    if (what !== "add" && typing) return;
    const parts = { add: () => this.#add(), film: () => this.#film(), clips: () => this.#clips(), numbers: () => this.#numbers(), more: () => this.#more() };
    this.sheet.replaceChildren(button("Close", () => this.close(), { sign: "close", className: "close" }), ...parts[what]());
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
    const command = made("code", "command", this.about.film);
    return [
      made("h2", "", "Draw the film"),
      made("p", "", "The scene is kept as you go. To draw it into the footage, type this into another terminal of the computer that serves this page; the film is overlay.mp4 in the last folder it names."),
      command,
    ];
  }

  #clips() {
    const { chosen, act } = this;
    const clips = chosen.clips.map((name) => {
      const one = button(spoken(name), () => act.clip(name), { className: "choice" });
      one.ariaPressed = String(chosen.clip === name);
      return one;
    });
    const halt = chosen.walk
      ? [button("Stop walking", () => act.stay(), { className: "choice" })]
      : [];
    return [made("h2", "", `What ${chosen.name} does`), made("div", "choices", ...clips, ...halt)];
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
      const input = made("input");
      const now = at === null ? numbers[key] : numbers[key][at];
      Object.assign(input, { type: "text", inputMode: "decimal", value: tidy(now), ariaLabel: label });
      input.addEventListener("change", () => {
        const value = Number(input.value.replace(",", "."));
        if (!Number.isFinite(value) || input.value.trim() === "") {
          input.value = tidy(now);
          return;
        }
        if (at === null) numbers[key] = value;
        else numbers[key][at] = value;
        this.act.number(key, numbers[key]);
      });
      return made("label", "number", made("span", "", label), input, made("span", "unit", unit));
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

function labelled(text, control) {
  return made("label", "pick", made("span", "", text), control);
}

function choice(options, value, told) {
  const select = made("select");
  for (const [key, text] of options) select.append(new Option(text, key, false, key === value));
  select.addEventListener("change", () => told(select.value));
  return select;
}

function tick(on, told) {
  const box = made("input");
  Object.assign(box, { type: "checkbox", checked: on });
  box.addEventListener("change", () => told(box.checked));
  return box;
}

/** @param {number} value */
function tidy(value) {
  return String(Number(value.toFixed(3)));
}

/** A clip's name as people say it. */
export function spoken(name) {
  const words = name.replaceAll(/[_|.]+/g, " ").replaceAll(/([a-z])([A-Z])/g, "$1 $2").trim();
  return words.charAt(0).toUpperCase() + words.slice(1);
}
