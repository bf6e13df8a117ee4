// Draws the marks of an image anew as it is turned by mouse, finger or arrow keys: what view.py
// and svg.py do, number by number. The image stands before this script, with its marks between.
(() => {
  "use strict";
  const SURFACE = 0.01, MARGIN = 30, LONGEST = 40, LETTER = 7.4, WIDE = 13, LINE = 15, EDGE = 3, GAP = 6;
  const SIDES = [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1]];

  function axesOf([azimuth, elevation, , , flat]) {
    if (flat) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
    const [sa, ca, se, ce] = [Math.sin(a), Math.cos(a), Math.sin(e), Math.cos(e)];
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  }

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const turned = (axes, p) => axes.map((axis) => dot(axis, p));

  // How marks fill the image: a function from points of space to x, y and depth.
  function projectionOf(view, marks) {
    const axes = axesOf(view), low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
    const hold = (p, reach) => turned(axes, p).forEach((x, i) => {
      low[i] = Math.min(low[i], x - reach);
      high[i] = Math.max(high[i], x + reach);
    });
    for (const [kind, points, , radius] of marks)
      for (const p of points) hold(p, kind === "ball" ? radius : 0);
    const size = [view[2], view[3]];
    const room = size.map((s, i) => (s - 2 * MARGIN) / Math.max(high[i] - low[i], 1e-300));
    const scale = Math.min(...room), middle = low.map((x, i) => scale * (x + high[i]) / 2);
    const place = (p) => {
      const [x, y, z] = turned(axes, p).map((c) => scale * c);
      return [x - middle[0] + size[0] / 2, middle[1] - y + size[1] / 2, z - middle[2]];
    };
    return { scale, place };
  }

  function keyOf(points, balls) {
    const mean = [0, 1, 2].map((i) => points.reduce((sum, p) => sum + p[i], 0) / points.length);
    let low = -Infinity, high = Infinity;
    for (const { center, radius } of balls) {
      const square = radius ** 2 - (mean[0] - center[0]) ** 2 - (mean[1] - center[1]) ** 2;
      if (square <= 0) continue;
      const off = mean[2] - center[2], half = Math.sqrt(square) - SURFACE * radius;
      if (off > half) low = Math.max(low, center[2] + radius / 2);
      else if (off < -half) high = Math.min(high, center[2] - radius / 2 - 1e-6);
      else {
        low = Math.max(low, center[2] - radius / 2);
        high = Math.min(high, center[2] + radius / 2 - 1e-6);
      }
    }
    return [Math.max(Math.min(mean[2], high), low), mean[2]];
  }

  function ordered(marks, { place, scale }) {
    const balls = marks.filter((m) => m[0] === "ball" && !m[4])
      .map((m) => ({ center: place(m[1][0]), radius: m[3] * scale }));
    const made = [];
    for (const mark of marks) {
      if (mark[0] === "name") continue;
      const points = mark[1].map(place);
      if (mark[0] !== "ball") made.push({ mark, points, key: keyOf(points, balls) });
      else {
        const radius = mark[3] * scale, depth = points[0][2];
        made.push({ mark, points, radius, key: [depth - radius / 2, -1e9] });
        if (!mark[4])
          made.push({ mark, points, radius, near: true, key: [depth + radius / 2, -1e9] });
      }
    }
    return made.sort((a, b) => a.key[0] - b.key[0] || a.key[1] - b.key[1]);
  }

  function number(value) {
    const text = value.toFixed(1).replace(/\.0$/, "");
    return text === "-0" ? "0" : text;
  }

  const path = (points) => "M" + points.map(([x, y]) => `${number(x)} ${number(y)}`)
    .join(" ").replace(/^(\S+ \S+) /, "$1L");
  const short = (text) => {
    const letters = Array.from(text);
    return letters.length <= LONGEST ? letters : [...letters.slice(0, LONGEST - 1), "…"];
  };
  const ENTITIES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#x27;" };
  // eslint-disable-next-line no-control-regex
  const BAD = /[\0-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]/u;
  const escaped = (letters) => letters.map((c) => BAD.test(c) ? "\ufffd" : ENTITIES[c] || c).join("");

  // What a scene looks like, as the content of the SVG's group; `own` is the image's own name.
  function elements(scene, own) {
    const paint = (kind, color, suffix) => color in scene.paper
      ? `class="${color}${suffix}" ${kind}="${scene.paper[color]}"` : `${kind}="${scene.objects[color]}"`;
    const fill = (color) => paint("fill", color, ""), line = (color) => paint("stroke", color, "-line");
    const projection = projectionOf(scene.view, scene.marks), parts = [];

    function ball({ mark: [, , color, , imaginary], points: [[x, y]], radius, near }) {
      const circle = `<circle cx="${number(x)}" cy="${number(y)}" r="${number(radius)}"`;
      if (imaginary) return `${circle} ${line(color)} stroke-width="1.6" stroke-dasharray="5 5"/>`;
      if (near) return `${circle} fill="url(#${own}-${color})" ${line(color)} stroke-width="1.2"/>`;
      return `${circle} ${fill(color)} opacity="0.1"/>`;
    }

    function element(same) {
      const [{ mark: [kind, , color, first, second], points }] = same;
      if (kind === "stroke") {
        const faint = second < 1 ? ` opacity="${second}"` : "";
        const drawn = same.map((one) => path(one.points)).join("");
        return `<path d="${drawn}" ${line(color)} stroke-width="${first}"${faint}/>`;
      }
      if (kind === "face") {
        const drawn = same.map((one) => path(one.points) + "Z").join("");
        return `<path d="${drawn}" ${fill(color)} opacity="${first}" shape-rendering="crispEdges"/>`;
      }
      if (kind === "ball") return ball(same[0]);
      const [inside, around] = second ? [fill("paper"), line(color)] : [fill(color), line("paper")];
      const place = `cx="${number(points[0][0])}" cy="${number(points[0][1])}"`;
      return `<g ${around} stroke-width="${second ? 1.8 : 1.2}">` +
        `<circle ${place} r="${first}" ${inside}/></g>`;
    }

    const look = ({ mark: [kind, , color, first, second] }) =>
      kind === "stroke" || kind === "face" ? [kind, color, first, second].join() : null;
    let same = [];
    for (const one of ordered(scene.marks, projection)) {
      if (same.length && (look(one) === null || look(one) !== look(same[0]))) {
        parts.push(element(same));
        same = [];
      }
      same.push(one);
    }
    if (same.length) parts.push(element(same));

    const boxes = [], [, , width, height] = scene.view;
    const within = ([l, t, r, b]) => l >= EDGE && t >= EDGE && r <= width - EDGE && b <= height - EDGE;
    const clear = (box) => boxes.every((b) =>
      box[2] < b[0] || b[2] < box[0] || box[3] < b[1] || b[3] < box[1]);
    for (const [kind, places, color, text, reach] of scene.marks) {
      if (kind !== "name") continue;
      const letters = short(text), off = reach * projection.scale * 0.7071 + GAP, tried = [];
      const wide = letters.reduce((sum, c) => sum + (c.codePointAt(0) < 128 ? LETTER : WIDE), 0);
      for (const [x, y] of places.map(projection.place))
        for (const [side, up] of SIDES) {
          const left = x + side * off - (side < 0 ? wide : side > 0 ? 0 : wide / 2);
          const top = y + up * off - (up < 0 ? LINE : 0) - (side ? 0.5 * GAP * up : 0);
          tried.push([left, top, left + wide, top + LINE]);
        }
      let box = tried.find((b) => within(b) && clear(b));
      if (!box && color === "axis") continue;
      box = box || movedIn(tried[0], width, height);
      boxes.push(box);
      parts.push(`<g ${line("paper")} stroke-width="3" paint-order="stroke">` +
        `<text x="${number(box[0])}" y="${number(box[3] - 3.5)}" ${fill(color)}>` +
        `${escaped(letters)}</text></g>`);
    }
    return parts.join("");
  }

  function movedIn([l, t, r, b], width, height) {
    const right = Math.max(0, r + EDGE - width), left = Math.max(0, EDGE - l + right);
    const down = Math.max(0, b + EDGE - height), up = Math.max(0, EDGE - t + down);
    return [l - right + left, t - down + up, r - right + left, b - down + up];
  }

  // Makes one image turn; the marks stand beside it.
  function live(box) {
    const svg = box.querySelector("svg"), own = svg.getAttribute("class");
    const scene = JSON.parse(box.querySelector('script[type="application/json"]').textContent);
    if (scene.view[4]) return;
    const group = svg.querySelector("g"), first = scene.view.slice();
    let from = null, asked = false;
    const draw = () => {
      asked = false;
      group.innerHTML = elements(scene, own);
    };
    const turn = (azimuth, elevation) => {
      scene.view[0] = azimuth;
      scene.view[1] = Math.max(-90, Math.min(90, elevation));
      if (!asked) requestAnimationFrame(draw);
      asked = true;
    };
    svg.style.cursor = "grab";
    svg.style.touchAction = "none";
    svg.setAttribute("tabindex", "0");
    svg.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY, scene.view[0], scene.view[1]];
      svg.setPointerCapture(event.pointerId);
      event.preventDefault();
      svg.focus({ preventScroll: true });
    });
    svg.addEventListener("pointermove", (event) => {
      if (from) turn(from[2] - (event.clientX - from[0]) / 2, from[3] + (event.clientY - from[1]) / 2);
    });
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => { from = null; });
    svg.addEventListener("dblclick", () => turn(first[0], first[1]));
    svg.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] };
      const step = steps[event.key];
      if (!step) return;
      turn(scene.view[0] + step[0], scene.view[1] + step[1]);
      event.preventDefault();
    });
  }

  if (typeof document === "undefined") globalThis.drawnElements = elements;
  else
    for (const box of document.querySelectorAll(".motorcade-drawing:not([data-live])")) {
      box.setAttribute("data-live", "");
      live(box);
    }
})();
