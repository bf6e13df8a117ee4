// The keyboard: as quick as buttons for those who have one.

/** @param {import("./editor.js").Editor} editor */
export function keyboard(editor) {
  const buttons = editor.panel.act;
  const acts = {
    " ": () => editor.timeline.toggle(),
    ArrowLeft: () => editor.timeline.step(-1),
    ArrowRight: () => editor.timeline.step(1),
    Delete: () => remove(editor),
    Backspace: () => remove(editor),
    k: () => editor.chosen && buttons.key(),
    p: () => editor.one?.kind === "character" && buttons.pose(),
    w: () => editor.one?.kind === "character" && buttons.draw(),
  };
  const withControl = {
    z: () => editor.ask({ do: "undo" }),
    Z: () => editor.ask({ do: "redo" }),
    y: () => editor.ask({ do: "redo" }),
    d: () => editor.chosen && buttons.copy(),
  };
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      escape(editor);
      return;
    }
    const on = event.target instanceof Element ? event.target : document.body;
    if (on.closest("input, select, textarea")) return;
    if (event.key === " " && on.closest("button, a")) return;
    const act = (event.ctrlKey || event.metaKey ? withControl : acts)[event.key];
    if (!act || event.altKey) return;
    event.preventDefault();
    act();
  });
}

/** The mark on the timeline that is looked at, else what is chosen. */
function remove(editor) {
  const { panel } = editor;
  if (panel.open === "mark") panel.act.unmark(panel.marked);
  else if (editor.chosen) panel.act.remove();
}

function escape(editor) {
  if (editor.draws) editor.sketchWalk();
  else if (editor.posing.held) editor.posing.cancel();
  else if (editor.posing.on) editor.posing.toggle();
  else if (editor.gestures.going) editor.gestures.cancel();
  else if (editor.panel.open) editor.panel.close();
  else editor.choose(null);
}
