// What is measured, on the page: each figure a button, and the last minute of it as a plot.

const KEPT_S = 60;
/** @type {[string, (figures: any) => string, string][]} */
const SHOWN = [
  ["frames_drawn_s", (f) => `${f.frames_drawn_s} frames/s`, "Frames drawn a second"],
  ["latency_p50_ms", (f) => `${round(f.latency_p50_ms)} ms (95 %: ${round(f.latency_p95_ms)})`, "From capture to drawn, ms, median"],
  ["registration_px", (f) => `${f.registration_px?.toFixed(2)} px off`, "Corners that had no part in the pose, px, median"],
];

const round = (/** @type {number} */ value) => Math.round(value);

/** The row of figures, and the plot of the one that is chosen. */
export class LiveFigures {
  /** @param {HTMLElement} element */
  constructor(element) {
    this.kept = [];
    this.chosen = null;
    this.row = document.createElement("div");
    this.row.className = "figures";
    this.plot = document.createElement("figure");
    this.plot.hidden = true;
    this.caption = document.createElement("figcaption");
    this.line = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.line.setAttribute("viewBox", "0 0 300 80");
    this.line.setAttribute("preserveAspectRatio", "none");
    this.plot.append(this.caption, this.line);
    this.buttons = SHOWN.map(([name]) => {
      const button = document.createElement("button");
      button.addEventListener("click", () => {
        this.chosen = this.chosen === name ? null : name;
        this.#draw();
      });
      this.row.append(button);
      return button;
    });
    element.append(this.plot, this.row);
    this.tell({});
  }

  /** @param {object} figures as `LiveMeasure.figures` has them */
  tell(figures) {
    const now = performance.now() / 1000;
    this.kept.push({ at: now, ...figures });
    while (this.kept[0].at < now - KEPT_S) this.kept.shift();
    for (const [k, [name, text, title]] of SHOWN.entries()) {
      const known = typeof figures[name] === "number";
      this.buttons[k].textContent = known ? text(figures) : "–";
      this.buttons[k].title = title;
      this.buttons[k].setAttribute("aria-label", `${title}: ${this.buttons[k].textContent}`);
    }
    this.#draw();
  }

  #draw() {
    const shown = SHOWN.find(([name]) => name === this.chosen);
    for (const [k, [name]] of SHOWN.entries()) {
      this.buttons[k].setAttribute("aria-pressed", String(name === this.chosen));
    }
    this.plot.hidden = !shown;
    if (!shown) return;
    const values = this.kept.filter((kept) => typeof kept[shown[0]] === "number");
    const most = Math.max(...values.map((kept) => kept[shown[0]]), 1e-9);
    const now = performance.now() / 1000;
    const points = values.map((kept) => {
      const x = 300 * (1 - (now - kept.at) / KEPT_S);
      return `${x.toFixed(1)},${(78 - (74 * kept[shown[0]]) / most).toFixed(1)}`;
    });
    const drawn = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
    drawn.setAttribute("points", points.join(" "));
    this.line.replaceChildren(drawn);
    this.caption.textContent = `${shown[2]}; the last minute, 0 to ${most.toPrecision(3)}`;
  }
}
