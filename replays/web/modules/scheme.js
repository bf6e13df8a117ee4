// Colours of the page's style for what three.js and uPlot draw; light or dark as the page is.

const HUES = {
  measured: "grey",
  fused: "sky",
  motor: "green",
  similarity: "olive",
  rotor: "sky",
  dual_quaternion: "blue",
  quaternion: "orange",
  euler_unwrapped: "pink",
  euler: "vermilion",
};

/** The value of a CSS variable, such as `--ink`. */
export function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** The CSS variable of a path's colour. */
export function variableOf(path) {
  return path === "truth" ? "--ink" : `--line-${HUES[path] ?? "blue"}`;
}

/** @param {() => void} changed called when the page turns light or dark */
export function onScheme(changed) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
}
