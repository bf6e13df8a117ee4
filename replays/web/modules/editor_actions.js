// What the panel's buttons do, as edits of the scene.

import { marksOf } from "studio/editor_lanes.js";

/** @param {import("./editor.js").Editor} editor */
export function actions(editor) {
  const edit = (what) => editor.ask({ do: "edit", frame: editor.frame, edit: what });
  const named = (what) => edit({ object: editor.chosen, ...what });
  return {
    choose: (name) => editor.choose(name),
    snaps: () => editor.snapping,
    snap: (on) => (editor.snapping = on),
    draw: () => editor.sketchWalk(),
    draws: () => editor.draws,
    ...posing(editor, named),
    ...marking(editor, named),
    async add(one) {
      const answer = await editor.ask({ do: "place", file: one.file, kind: one.kind, frame: editor.frame });
      if (answer.ok) editor.choose(answer.object);
    },
    async copy() {
      const answer = await editor.ask({ do: "copy", object: editor.chosen, frame: editor.frame });
      if (answer.ok) editor.choose(answer.object);
    },
    remove: () => named({ do: "remove" }),
    clip: (clip) => named({ do: "set", clip, ...(editor.one.walk && { walk: null }) }),
    pace: (what) => editor.ask({ do: "walk", object: editor.chosen, frame: editor.frame, ...what }),
    stay: () => named({ do: "set", walk: null }),
    key: () => named({ do: "keyframe", time_s: editor.seconds }),
    unkey: () => named({ do: "set", keyframes: [] }),
    async tell() {
      return editor.link.send({ do: "numbers", object: editor.chosen, frame: editor.frame });
    },
    number: (field, value) => named({ do: "set", [field]: value, time_s: editor.seconds }),
    async rename(name) {
      const answer = await named({ do: "rename", name });
      if (answer.ok) editor.choose(name);
    },
    hang: (on) => editor.ask({ do: "hang", object: editor.chosen, on, frame: editor.frame }),
    join: (interpolation) => named({ do: "set", interpolation }),
    appear: (from, to) => named({ do: "set", visible: from === null ? null : [from, to] }),
    appears: () => named({ do: "set", visible: [editor.seconds, Math.max(editor.one.visible_s?.[1] ?? 0, editor.length + 1)] }),
    vanishes: () => named({ do: "set", visible: [Math.min(editor.one.visible_s?.[0] ?? 0, editor.seconds), editor.seconds + 1e-3] }),
    group: (other) =>
      edit({ do: "group", objects: [editor.chosen, other], name: unused(editor, "Group"), time_s: editor.seconds }),
    ungroup: () => named({ do: "ungroup", time_s: editor.seconds }),
    ...handling(editor),
  };
}

/** Which handles there are, and along whose axes. */
function handling(editor) {
  return {
    axes() {
      editor.handles.kind = editor.handles.kind === "few" ? "all" : "few";
      editor.redraw();
    },
    axesNow: () => editor.handles.axes,
    along(axes) {
      editor.handles.axes = axes;
      editor.redraw();
    },
  };
}

/** What is done with poses of joints. */
function posing(editor, named) {
  return {
    pose: () => editor.posing.toggle(),
    poses: () => editor.posing.on,
    unpose: () => named({ do: "set", joint_keyframes: [] }),
  };
}

const UNMARKED = { key: "remove_keyframe", pose: "remove_joints" };

/** What is done with keyframes, poses and layers on the timeline. */
function marking(editor, named) {
  const layer = (number, what) => named({ do: "layer", layer: what, ...(number !== null && { number }) });
  return {
    marks: () => marksOf(editor.one, editor.length).flat(),
    layer,
    addLayer() {
      const { clips } = editor.one;
      const clip = clips.find((name) => /wave/i.test(name)) ?? clips.at(-1);
      const start_s = editor.frame ? editor.seconds : 0;
      return layer(null, { clip, joints: "right_arm", weight: 1, start_s, end_s: null });
    },
    unmark({ kind, number, start_s }) {
      return kind === "layer" ? layer(number, null) : named({ do: UNMARKED[kind], time_s: start_s });
    },
    /** A mark from and until other times; what is not said stays. */
    async mark({ kind, number, start_s, layer: was }, to) {
      if (kind === "walk") return renewed(editor, "walk", to.start_s, await editor.ask({ do: "walk", object: editor.chosen, frame: editor.frame, start_s: to.start_s }));
      if (kind === "layer") return layer(number, { ...was, ...to });
      if (kind === "key") return renewed(editor, "key", to.start_s, await named({ do: "move_keyframe", time_s: start_s, to_s: to.start_s }));
      if (!("start_s" in to)) return named({ do: "end_joints", time_s: start_s, end_s: to.end_s });
      return renewed(editor, "pose", to.start_s, await named({ do: "move_joints", time_s: start_s, to_s: to.start_s }));
    },
  };
}

/** The form of a mark follows it to its new time. */
function renewed(editor, kind, start_s, answer) {
  if (answer.ok && editor.panel.open === "mark") editor.panel.mark({ kind, start_s });
  return answer;
}

/** A name that nothing in the scene has. */
function unused(editor, name) {
  let number = 1;
  while (editor.actors.has(number === 1 ? name : `${name} ${number}`)) number++;
  return number === 1 ? name : `${name} ${number}`;
}
