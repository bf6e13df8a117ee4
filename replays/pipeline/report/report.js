// Films inside the page become addresses; the viewer is unpacked when it is asked for.
const bytesOf = text => {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
};
const films = {};
const filmAddress = id => {
  const holder = document.getElementById(id);
  if (!holder) return "";
  films[id] ??= holder.dataset.beside
    || URL.createObjectURL(new Blob([bytesOf(holder.textContent)], { type: "video/mp4" }));
  return films[id];
};
const film = document.getElementById("film");
if (film) {
  film.addEventListener("error", () => { document.getElementById("no-film").hidden = false; });
  film.autoplay = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  film.src = filmAddress("film-overlay");
}
for (const wipe of document.querySelectorAll(".wipe")) {
  const range = wipe.querySelector("input");
  range.addEventListener("input", () => wipe.style.setProperty("--at", `${range.value}%`));
}
// On phones the viewer is as high as what it holds, so that there is one thing to scroll.
const fit = frame => {
  const inside = frame.contentDocument?.documentElement;
  if (!inside) return;
  const resize = () => {
    frame.style.height = innerWidth < 720 ? `${inside.querySelector("body").scrollHeight}px` : "";
  };
  new ResizeObserver(resize).observe(inside.querySelector("body"));
  resize();
};
const viewerText = async () => {
  const packed = new Blob([bytesOf(document.getElementById("viewer-page").textContent)]);
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  const text = await new Response(stream).text();
  return text.replace(/"#(film-\w+)"/g, (_all, id) => JSON.stringify(filmAddress(id)));
};
const openViewer = async holder => {
  const frame = document.createElement("iframe");
  Object.assign(frame, { title: "Viewer", allow: "fullscreen" });
  if (holder.dataset.beside) frame.src = holder.dataset.beside;
  else frame.srcdoc = await viewerText();
  frame.addEventListener("load", () => fit(frame));
  holder.replaceChildren(frame);
  film?.pause();
  if (!document.fullscreenEnabled) return;
  const whole = document.createElement("button");
  Object.assign(whole, { type: "button", textContent: "Full screen" });
  whole.addEventListener("click", () => frame.requestFullscreen());
  holder.append(whole);
};
const opener = document.getElementById("open-viewer");
opener?.addEventListener("click", async () => {
  opener.disabled = true;
  opener.textContent = "Opening…";
  try { await openViewer(opener.parentElement); }
  catch (problem) {
    opener.textContent = `This browser cannot open the viewer (${problem.message}); motorcade view makes it a page of its own`;
  }
});
