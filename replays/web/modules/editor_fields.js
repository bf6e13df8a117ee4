// Controls of the panel's forms: a number, a choice, a tick, each with the word for it.

import { made } from "studio/editor_timeline.js";

/** A control with a word before it. */
export function labelled(text, control) {
  control.dataset.field = text;
  return made("label", "pick", made("span", "", text), control);
}

/** @param {[string, string][]} options values and words @param {(value: string) => void} told */
export function choice(options, value, told) {
  const select = made("select");
  for (const [key, text] of options) select.append(new Option(text, key, false, key === value));
  select.addEventListener("change", () => told(select.value));
  return select;
}

/** @param {boolean} on @param {(on: boolean) => void} told */
export function tick(on, told) {
  const box = made("input");
  Object.assign(box, { type: "checkbox", checked: on });
  box.addEventListener("change", () => told(box.checked));
  return box;
}

/** A share of 0 to 1 by a slider, told once it is let go. */
export function share(value, told) {
  const slider = made("input");
  Object.assign(slider, { type: "range", min: 0, max: 100, step: 5, value: Math.round(100 * value) });
  const shown = made("output", "", `${slider.value} %`);
  slider.addEventListener("input", () => (shown.textContent = `${slider.value} %`));
  slider.addEventListener("change", () => told(Number(slider.value) / 100));
  return made("span", "share", slider, shown);
}

/**
 * A number that is typed; what is none is put back.
 *
 * @param {string} label @param {number|null} value null where there is none
 * @param {string} unit @param {(value: number|null) => void} told
 * @param {string} none what stands there where there is none; "" where there must be one
 */
export function numberField(label, value, unit, told, none = "") {
  const input = made("input");
  const now = value === null ? "" : tidy(value);
  Object.assign(input, { type: "text", inputMode: "decimal", value: now, placeholder: none, ariaLabel: label });
  input.dataset.field = label;
  input.addEventListener("change", () => {
    const typed = input.value.trim().replace(",", ".");
    const given = Number(typed);
    if (typed === "" && none) told(null);
    else if (typed === "" || !Number.isFinite(given)) input.value = now;
    else told(given);
  });
  return made("label", "number", made("span", "", label), input, made("span", "unit", unit));
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
