// The buttons' signs as lines of SVG, so that they look alike on every machine.

const PATHS = {
  add: "M12 5v14M5 12h14",
  walk: "M4 19c2-6 5-3 7-7s1-6 5-7M16 5l4-1M16 5l1.5 3.6M4 19l-1.5-3",
  act: "M12 3.6a2 2 0 1 1 0 .01M12 8v6M5 9l7-1 7-4M12 14l-4 7M12 14l5 6",
  pose: "M10 5a2 2 0 1 1 0 .01M10 8v6M10 9L5 13M10 14l-3 7M10 14l3 7M10 9l5-2M17 6.5a2 2 0 1 0 4 0 2 2 0 1 0-4 0",
  key: "M12 4l8 8-8 8-8-8z",
  axes: "M12 13V3M9 6l3-3 3 3M12 13l8 5M20 14v4h-4M12 13l-8 5M8 18H4v-4",
  numbers: "M9 4L7 20M17 4l-2 16M4 9h17M3 15h17",
  copy: "M9 9h11v11H9zM5 15H4V4h11v1",
  more: "M4 12h2M11 12h2M18 12h2",
  remove: "M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v5M14 11v5",
  play: "M8 5l11 7-11 7z",
  pause: "M8 5v14M16 5v14",
  undo: "M8 5L4 9l4 4M4 9h9a6 6 0 0 1 0 12h-3",
  redo: "M16 5l4 4-4 4M20 9h-9a6 6 0 0 0 0 12h3",
  back: "M15 5l-7 7 7 7",
  close: "M6 6l12 12M18 6L6 18",
  person: "M12 3.6a2.2 2.2 0 1 1 0 .01M6 12c0-3 2-4 6-4s6 1 6 4M9 9v12M15 9v12M12 15v6",
  thing: "M4 8l8-4 8 4v8l-8 4-8-4zM4 8l8 4 8-4M12 12v8",
};
const FILLED = new Set(["play"]);
const SVG = "http://www.w3.org/2000/svg";

/** @typedef {keyof typeof PATHS} Sign */

/** @param {Sign} name @returns {SVGElement} */
export function icon(name) {
  const sign = document.createElementNS(SVG, "svg");
  sign.setAttribute("viewBox", "0 0 24 24");
  sign.setAttribute("class", FILLED.has(name) ? "icon filled" : "icon");
  sign.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", PATHS[name]);
  sign.append(path);
  return sign;
}
