// What the panel's buttons do, as edits of the scene.

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

/** A name that nothing in the scene has. */
function unused(editor, name) {
  let number = 1;
  while (editor.actors.has(number === 1 ? name : `${name} ${number}`)) number++;
  return number === 1 ? name : `${name} ${number}`;
}
