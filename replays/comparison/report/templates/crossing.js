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
