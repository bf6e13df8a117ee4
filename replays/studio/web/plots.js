// Plots over time with one cursor: a click or a drag goes there.

import { uPlot } from "studio/vendor.js";
import { css, variableOf } from "studio/scheme.js";

const HEIGHT = 150;
const DASH = { truth: [4, 3] };

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

function lineOf(one, plot) {
  const colour = () => css(variableOf(one.name));
  return {
    label: one.label,
    stroke: colour,
    width: one.name === "measured" ? 1 : 1.6,
    dash: DASH[one.name],
    spanGaps: true,
    points: { show: Boolean(plot.dots), size: 3, fill: colour, stroke: colour },
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
   * @param {import("./look.js").Look} look
   * @param {import("./timeline.js").Timeline} timeline
   */
  constructor(holder, look, timeline) {
    this.timeline = timeline;
    this.charts = look.plots.map((plot) => {
      return this.#made(holder, { ...plot, series: inOrder(plot.series, look.drawn) });
    });
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
    for (const { chart, plot } of this.charts) {
      plot.series.forEach((one, number) => {
        if (one.name === name) chart.setSeries(number + 1, { show: visible });
      });
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
      // Of what is on top: the drawn path, unless it is hidden.
      const shown = plot.series.findLastIndex((_one, k) => chart.series[k + 1].show);
      value.textContent = plainly(shown < 0 ? null : chart.data[shown + 1][index]);
      value.title = shown < 0 ? "" : plot.series[shown].label;
    }
  }
}
