document.documentElement.classList.add("js");
// One of several tables at a time.
for (const picker of document.querySelectorAll(".picker")) {
  const choices = [...picker.querySelectorAll(".choice")];
  const select = picker.querySelector("select");
  const show = () => choices.forEach(one => { one.hidden = one.id !== select.value; });
  select.addEventListener("change", show);
  show();
}
// A click on a heading sorts; a second one turns the order round.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.querySelector("button")?.addEventListener("click", () => {
    const falling = head.getAttribute("aria-sort") === "ascending";
    heads.forEach(one => one.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", falling ? "descending" : "ascending");
    const value = row => {
      const told = row.cells[column].querySelector("data");
      return told ? Number(told.value) : null;
    };
    const order = (a, b) => {
      const [x, y] = [value(a), value(b)];
      if (x === null && y === null)
        return a.cells[column].textContent.localeCompare(b.cells[column].textContent) * (falling ? -1 : 1);
      if (x === null || y === null) return x === null ? 1 : -1;
      return falling ? y - x : x - y;
    };
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort(order));
  }));
}
// The passage through gimbal lock: recorded frames, one after another.
const recorded = document.getElementById("crossing-data");
if (recorded) {
  const data = JSON.parse(recorded.textContent);
  const names = Object.keys(data.points);
  const slider = document.getElementById("crossing-time");
  const button = document.getElementById("crossing-play");
  const speed = document.getElementById("crossing-speed");
  const clock = document.getElementById("crossing-clock");
  const cursor = document.getElementById("crossing-cursor");
  const last = data.ms.length - 1;
  const outline = p => {
    const at = i => p[2 * i] + " " + p[2 * i + 1];
    return [0, 1, 2, 3].map(i => "M0 0L" + at(i)).join("") +
      "M" + at(0) + "L" + at(1) + "L" + at(2) + "L" + at(3) + "ZM" + at(0) + "L" + at(4) + "L" + at(1);
  };
  const draw = frame => {
    for (const name of names) {
      const part = kind => document.getElementById("crossing-" + kind + "-" + name);
      part("camera").setAttribute("d", outline(data.points[name][frame]));
      const trail = data.points[name].slice(Math.max(0, frame - 24), frame + 1);
      part("trail").setAttribute("points", trail.map(p => p[10] + "," + p[11]).join(" "));
      if (name === "truth") continue;
      part("ghost").setAttribute("d", outline(data.points.truth[frame]));
      const error = data.errors[name][frame];
      part("error").textContent = error.toFixed(error < 10 ? 1 : 0) + "°";
      part("error").style.color = error > 5 ? "var(--wrong)" : "";
    }
    slider.value = frame;
    clock.textContent = (data.ms[frame] / 1000).toFixed(2) + " s";
    const share = (data.ms[frame] - data.ms[0]) / (data.ms[last] - data.ms[0]);
    cursor.setAttribute("x1", 900 * share);
    cursor.setAttribute("x2", 900 * share);
  };
  let playing = false, now = data.ms[data.start], before = null;
  const step = time => {
    if (!playing) return;
    if (before !== null) now += (time - before) * Number(speed.value);
    before = time;
    if (now > data.ms[last]) now = data.ms[0];
    let frame = data.ms.findIndex(one => one > now) - 1;
    draw(frame < 0 ? last : frame);
    requestAnimationFrame(step);
  };
  const play = on => {
    playing = on;
    before = null;
    button.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(step);
  };
  button.addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => {
    play(false);
    now = data.ms[Number(slider.value)];
    draw(Number(slider.value));
  });
  draw(data.start);
  play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
}
