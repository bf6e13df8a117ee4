// Forms of what stands on the timeline: a keyframe, a pose, a layer; from when to when, and away.

import { choice, labelled, numberField, share, spoken, tick } from "studio/editor_fields.js";
import { button, made } from "studio/editor_timeline.js";

const FOR_EVER = "end";
const JOINTS = {
  whole: "The whole body",
  upper: "The upper body",
  left_arm: "The left arm",
  right_arm: "The right arm",
  head: "The head",
};

const wide = (text, act) => button(text, act, { className: "choice" });
const span = (...fields) => made("div", "numbers", ...fields);

/** @param {object} mark of `Lanes` @param {object} chosen whose it is @param {object} act */
export function markForm(mark, chosen, act) {
  if (mark.kind === "walk") {
    const { speed_m_s, gait } = chosen.walks;
    return [
      made("h2", "", `The walk of ${chosen.name}`),
      span(
        numberField("From", mark.start_s, "s", (to) => act.pace({ start_s: to })),
        ...(speed_m_s ? [numberField("Speed", speed_m_s, "m/s", (to) => act.pace({ speed_m_s: to }))] : []),
      ),
      ...(gait ? [made("p", "", `Its gait follows from its size and speed: ${spoken(gait).toLowerCase()}.`)] : []),
      wide("Stop walking", () => act.stay()),
    ];
  }
  if (mark.kind === "key") {
    return [
      made("h2", "", `A keyframe of ${chosen.name}`),
      span(numberField("At", mark.start_s, "s", (to) => act.mark(mark, { start_s: to }))),
      wide("Remove this keyframe", () => act.unmark(mark)),
    ];
  }
  if (mark.kind === "pose") {
    return [
      made("h2", "", `A pose of ${chosen.name}`),
      span(
        numberField("From", mark.start_s, "s", (to) => act.mark(mark, { start_s: to })),
        numberField("Until", mark.end_s, "s", (to) => act.mark(mark, { end_s: to }), FOR_EVER),
      ),
      ...(mark.end_s === null ? [] : [wide("Hold it for ever", () => act.mark(mark, { end_s: null }))]),
      wide("Remove this pose", () => act.unmark(mark)),
    ];
  }
  return [made("h2", "", `A layer of ${chosen.name}`), layerForm(chosen, mark.number, act)];
}

/** What is laid over the clip: each layer, and one more. */
export function layerForms(chosen, act) {
  const forms = chosen.layers.map((_, number) => layerForm(chosen, number, act));
  const told = chosen.layers.length ? [] : [made("p", "", "A wave while walking, a look aside: a second motion for some of the body.")];
  const add = async () => {
    await act.addLayer();
    document.querySelector(".sheet .layer:last-of-type")?.scrollIntoView({ block: "nearest" });
  };
  return [made("h3", "", "At the same time"), ...told, ...forms, wide("Add a layer", add)];
}

function layerForm(chosen, number, act) {
  const layer = chosen.layers[number];
  const change = (what) => act.layer(number, { ...layer, ...what });
  const clips = chosen.clips.map((name) => [name, spoken(name)]);
  return made(
    "fieldset",
    "layer",
    made("legend", "", `Layer ${number + 1}`),
    labelled("Motion", choice(clips, layer.clip, (clip) => change({ clip }))),
    labelled("Moves", choice(Object.entries(JOINTS), layer.joints, (joints) => change({ joints }))),
    labelled("Weight", share(layer.weight, (weight) => change({ weight }))),
    span(
      numberField("From", layer.start_s ?? 0, "s", (to) => change({ start_s: to })),
      numberField("Until", layer.end_s ?? null, "s", (to) => change({ end_s: to }), FOR_EVER),
      numberField("Fade", layer.fade_s ?? 0.3, "s", (to) => change({ fade_s: to })),
    ),
    labelled("Add to the motion below", tick(layer.additive ?? false, (additive) => change({ additive }))),
    wide("Remove this layer", () => act.layer(number, null)),
  );
}
