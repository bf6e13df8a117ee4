// The film of the scene: drawn by the server, and played here once it is there.

import { button, made } from "studio/editor_timeline.js";

const EVERY_MS = 1000;

export class Film {
  /**
   * @param {string} base address of the run
   * @param {string} command that draws it in a terminal
   * @param {(message: object) => Promise<object>} ask the server
   */
  constructor(base, command, ask) {
    this.base = base;
    this.ask = ask;
    this.state = null;
    this.told = made("p", "");
    this.told.setAttribute("role", "status");
    this.bar = made("progress", "far");
    this.bar.ariaLabel = "How much of the film is drawn";
    this.start = button("Draw the film", () => this.#do("film"), { sign: "play", className: "choice" });
    this.stop = button("Stop", () => this.#do("stop film"), { className: "choice" });
    this.video = made("video", "player");
    Object.assign(this.video, { controls: true, playsInline: true, muted: true, hidden: true });
    const typed = made("details", "", made("summary", "", "In a terminal"), made("code", "command", command));
    this.element = made("div", "drawn-film", this.told, this.bar, made("div", "choices", this.start, this.stop), this.video, typed);
    this.#show();
  }

  /** Look how far it is; again and again while it is being drawn. */
  async look() {
    clearTimeout(this.again);
    const answer = await fetch(`${this.base}film.json`).catch(() => null);
    if (answer?.ok) this.#take(await answer.json());
    if (this.state?.drawing) this.again = setTimeout(() => this.look(), EVERY_MS);
  }

  async #do(what) {
    const answer = await this.ask({ do: what });
    if (answer.ok) this.#take(answer.film);
    this.look();
  }

  #take(state) {
    this.state = state;
    this.#show();
  }

  #show() {
    const { drawing, said, share, failed, film, stale } = this.state ?? {};
    this.told.textContent = drawing
      ? said
      : (failed && `Not drawn: ${failed}`) ||
        (stale && film && "The scene has changed since this film was drawn.") ||
        (film ? "The film as it was drawn last." : "The scene is drawn into the footage, with light and shadow.");
    this.bar.hidden = this.stop.hidden = !drawing;
    this.start.hidden = Boolean(drawing);
    if (share === null || share === undefined) this.bar.removeAttribute("value");
    else this.bar.value = share;
    this.video.hidden = !film || Boolean(drawing);
    const source = film ? `${this.base}film.mp4?${film}` : "";
    if (source && !drawing && this.video.getAttribute("src") !== source) this.video.src = source;
  }
}
