// Plots over time with one cursor: a click or a drag goes there. Of two runs, the second is dashed.

import { uPlot } from "studio/vendor.js";
import { css, variableOf } from "studio/scheme.js";

const HEIGHT = 150;
const DASH = [undefined, [5, 4]];
const [WIDE, USUAL, THIN] = [2.4, 1.6, 1];

/** Values of several lines over one rising axis; undefined where a line has none. */
export function joined(series) {
  return uPlot.join(
    series.map((one) => [Array.from(one.time_s.data), Array.from(one.values.data, shownNumber)]),
  );
}

function shownNumber(value) {
  return Number.isFinite(value) && value > 0 ? value : null;
}

/** Numbers as people write them: 0.001, 20, 1,500. */
export function plainly(value) {
  if (value === null || value === undefined) return "";
  if (value >= 1e5 || value < 1e-4) return value.toExponential(0).replace("e+", "e");
  return String(Number(value.toPrecision(3)));
}

/** A value at an index or, where a line has none there, the nearest to it. */
export function nearestKnown(values, index) {
  for (let away = 0; away < values.length; away++) {
    const found = values[index - away] ?? values[index + away];
    if (found !== null && found !== undefined) return found;
  }
  return null;
}

function isDecade(value) {
  return Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9;
}

function axes() {
  const common = {
    stroke: () => css("--soft"),
    grid: { stroke: () => css("--grid"), width: 1 },
    ticks: { show: false },
    font: "11px system-ui, sans-serif",
    gap: 4,
  };
  const decades = (_plot, splits) => splits.map((one) => (isDecade(one) ? one : null));
  const seconds = (_plot, splits) => splits.map((one) => `${one} s`);
  const numbers = (_plot, splits) => splits.map((one) => (one === null ? "" : plainly(one)));
  return [
    { ...common, size: 24, values: seconds, space: 70 },
    { ...common, size: 42, filter: decades, values: numbers, grid: { ...common.grid, filter: decades } },
  ];
}

/** The measured path's lines first, the drawn one's last, on top of the others. */
function inOrder(series, drawn) {
  const place = (one) => (one.name === drawn ? 1 : one.name === "measured" ? -1 : 0);
  return [...series].sort((a, b) => place(a) - place(b));
}

/**
 * The plots of all runs: those of one name are one, and each line knows its run.
 *
 * @param {import("./look.js").Look[]} looks
 */
export function together(looks) {
  const plots = new Map();
  looks.forEach((look, run) => {
    for (const plot of look.plots) {
      const known = plots.get(plot.name) ?? { ...plot, series: [] };
      known.series.push(...inOrder(plot.series, look.drawn).map((one) => ({ ...one, run })));
      plots.set(plot.name, known);
    }
  });
  return [...plots.values()];
}

function lineOf(one, plot) {
  const colour = () => css(variableOf(one.name));
  return {
    label: one.label,
    stroke: colour,
    width: one.name === "measured" ? THIN : USUAL,
    dash: DASH[one.run],
    spanGaps: true,
    points: { show: Boolean(plot.dots), size: 3, fill: one.run ? "transparent" : colour, stroke: colour },
    ...(plot.dots ? { paths: () => null } : {}),
  };
}

/** The band that a quantity should lie in, behind its lines. */
function bandHook(plot) {
  if (!plot.band) return [];
  return [
    (chart) => {
      const [low, high] = plot.band.map((one) => chart.valToPos(one, "y", true));
      const { left, width, top, height } = chart.bbox;
      chart.ctx.save();
      chart.ctx.beginPath();
      chart.ctx.rect(left, top, width, height);
      chart.ctx.clip();
      chart.ctx.fillStyle = `rgba(${css("--blue")}, 0.10)`;
      chart.ctx.fillRect(left, high, width, low - high);
      chart.ctx.restore();
    },
  ];
}

export class Plots {
  /**
   * @param {HTMLElement} holder
   * @param {import("./look.js").Look[]} looks one or two runs
   * @param {import("./timeline.js").Timeline} timeline
   */
  constructor(holder, looks, timeline) {
    this.timeline = timeline;
    /** @type {Set<string>} paths whose lines nobody wants to see */
    this.hidden = new Set();
    /** @type {{run: number, path: string}[]} what the panes show */
    this.sides = [{ run: 0, path: looks[0].drawn }];
    this.charts = together(looks).map((plot) => this.#made(holder, plot));
    timeline.listen(() => this.#point());
    new ResizeObserver(() => this.#fit()).observe(holder);
    this.#fit();
    this.#point();
  }

  #made(holder, plot) {
    const figure = document.createElement("figure");
    const title = document.createElement("figcaption");
    title.textContent = plot.unit ? `${plot.title} (${plot.unit})` : plot.title;
    const value = document.createElement("output");
    title.append(value);
    const box = document.createElement("div");
    box.setAttribute("role", "img");
    box.setAttribute("aria-label", `${plot.title} over time; a click goes there`);
    figure.append(title, box);
    holder.append(figure);
    const data = joined(plot.series);
    const cursor = document.createElement("i");
    const chart = new uPlot(this.#options(plot), data, box);
    cursor.className = "now";
    chart.over.append(cursor);
    this.#wire(chart);
    return { chart, plot, box, cursor, value };
  }

  /** @returns {import("uplot").Options} */
  #options(plot) {
    const times = this.timeline.times;
    return {
      width: 300,
      height: HEIGHT,
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false }, y: false },
      scales: {
        x: { time: false, range: () => [0, times[times.length - 1] || 1] },
        y: { distr: plot.log ? 3 : 1 },
      },
      axes: axes(),
      series: [{}, ...plot.series.map((one) => lineOf(one, plot))],
      hooks: { drawClear: bandHook(plot) },
    };
  }

  #wire(chart) {
    const go = (event) => {
      const { left } = chart.over.getBoundingClientRect();
      this.timeline.goTo(Math.max(0, chart.posToVal(event.clientX - left, "x")));
    };
    chart.over.addEventListener("pointerdown", (event) => {
      chart.over.setPointerCapture(event.pointerId);
      go(event);
    });
    chart.over.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) go(event);
    });
  }

  /** Show or hide a path's lines. */
  show(name, visible) {
    this.hidden[visible ? "delete" : "add"](name);
    this.#choose();
  }

  /**
   * Set off the lines of what the panes show, and tell their values; runs on no side are left out.
   *
   * @param {{run: number, path: string}[]} sides one or two
   */
  compare(sides) {
    this.sides = sides;
    this.#choose();
  }

  #choose() {
    const runs = new Set(this.sides.map((side) => side.run));
    const several = this.sides.length > 1;
    for (const { chart, plot } of this.charts) {
      plot.series.forEach((one, number) => {
        const compared = this.sides.some(({ run, path }) => run === one.run && path === one.name);
        const line = chart.series[number + 1];
        line.width = several ? (compared ? WIDE : THIN) : one.name === "measured" ? THIN : USUAL;
        const show = runs.has(one.run) && !this.hidden.has(one.name);
        if (line.show !== show) chart.setSeries(number + 1, { show });
      });
      chart.redraw(false);
    }
    this.#point();
  }

  /** Draw again, in the colours that the page now has. */
  recolour() {
    for (const { chart } of this.charts) chart.redraw(false);
  }

  #fit() {
    for (const { chart, box } of this.charts) {
      const width = Math.max(120, box.clientWidth);
      if (width !== chart.width) chart.setSize({ width, height: HEIGHT });
    }
    this.#point();
  }

  #point() {
    const seconds = this.timeline.seconds;
    for (const { chart, cursor, value, plot } of this.charts) {
      cursor.style.transform = `translateX(${chart.valToPos(seconds, "x").toFixed(1)}px)`;
      const index = chart.valToIdx(seconds);
      const numbers = this.sides.map((side) => lineNumber(plot, chart, side));
      const told = [...new Set(numbers)].filter((number) => number >= 0);
      value.replaceChildren(...told.map((number) => {
        const mark = document.createElement("span");
        mark.title = plot.series[number].label;
        mark.textContent = plainly(nearestKnown(chart.data[number + 1], index));
        if (told.length > 1) {
          mark.style.setProperty("--line", `var(${variableOf(plot.series[number].name)})`);
          mark.className = plot.series[number].run ? "second" : "first";
        }
        return mark;
      }));
    }
  }
}

/** The line of a side; where its path has none, what is on top of its run's. -1 where none shows. */
function lineNumber(plot, chart, { run, path }) {
  const shown = (k) => plot.series[k].run === run && chart.series[k + 1].show;
  const own = plot.series.findIndex((one, k) => one.name === path && shown(k));
  return own >= 0 ? own : plot.series.findLastIndex((_one, k) => shown(k));
}
