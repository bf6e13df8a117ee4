import assert from "node:assert/strict";
import test from "node:test";

import { draggedTo, marksOf } from "studio/editor_lanes.js";

const ONE = {
  keys: [0.5, 2],
  turns: [[1, 1.5], [2, null]],
  layers: [{ clip: "wave", joints: "upper", weight: 0.5, start_s: 1 }],
};

test("each kind has a lane, each layer its own", () => {
  const lanes = marksOf(ONE, 4);
  assert.deepEqual(lanes.map((lane) => lane.map((mark) => [mark.kind, mark.start_s, mark.until_s])), [
    [["key", 0.5, 0.5], ["key", 2, 2]],
    [["pose", 1, 1.5], ["pose", 2, 4]],
    [["layer", 1, 4]],
  ]);
  assert.deepEqual(marksOf(null, 4), []);
});

test("a walk has a lane of its own, as long as it lasts in the film", () => {
  const walks = { start_s: 0.5, end_s: 9, speed_m_s: 0.1, gait: "walk" };
  const [[walk], keys] = marksOf({ ...ONE, walks }, 4);
  assert.deepEqual([walk.kind, walk.start_s, walk.until_s], ["walk", 0.5, 4]);
  assert.equal(keys[0].kind, "key");
  assert.equal(draggedTo(walk, "body", 1, 4).start_s, 1);
});

test("a pose that is held for ever is drawn to the next", () => {
  const [, poses] = marksOf({ ...ONE, turns: [[1, null], [2, 9]] }, 4);
  assert.deepEqual(poses.map((mark) => mark.until_s), [2, 4]);
});

test("an end is dragged no nearer than to its beginning, and past the film for ever", () => {
  const [, [pose]] = marksOf(ONE, 4);
  assert.deepEqual(draggedTo(pose, "end", 1.2, 4), { end_s: 1.2 });
  assert.deepEqual(draggedTo(pose, "end", 0, 4), { end_s: 1.02 });
  assert.deepEqual(draggedTo(pose, "end", 4, 4), { end_s: null });
});

test("a whole mark keeps its length, and begins at 0 at the earliest", () => {
  const [, [pose]] = marksOf(ONE, 4);
  assert.deepEqual(draggedTo(pose, "body", 2, 4), { start_s: 2, end_s: 2.5 });
  assert.deepEqual(draggedTo(pose, "body", -3, 4), { start_s: 0, end_s: 0.5 });
});

test("a beginning leaves the end where it is", () => {
  const [, , [layer]] = marksOf(ONE, 4);
  assert.deepEqual(draggedTo(layer, "start", 3, 4), { start_s: 3, end_s: null });
  assert.deepEqual(draggedTo(layer, "start", 9, 4), { start_s: 3.98, end_s: null });
});
