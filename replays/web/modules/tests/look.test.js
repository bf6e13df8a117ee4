// Documents are decoded as they were packed, and moments are found among uneven stamps.

import assert from "node:assert/strict";
import { test } from "node:test";
import { decode, frameAt, indexAt, nearest, pathNamed, poseAt, row, stateAt } from "studio/look.js";
import { nearestKnown } from "studio/plots.js";
import { clockWords, Timeline } from "studio/timeline.js";

const packed = (kind, array, shape) => ({
  [kind]: Buffer.from(array.buffer).toString("base64"),
  shape,
});
const poses = new Float64Array([1, 2, 3, 1, 0, 0, 0, ...Array(7).fill(NaN)]);
const LOOK = {
  format: "motorcade-look",
  version: 1,
  drawn: "motor",
  paths: [
    { name: "measured", at_frames: packed("f64", poses, [2, 7]) },
    { name: "motor", at_frames: packed("f64", poses, [2, 7]) },
  ],
  states: [{ from_s: 1, to_s: 2, state: "lost", why: "no pose measured" }],
};

test("arrays come back with their kind and shape, wherever they stand", () => {
  const look = decode(JSON.stringify(LOOK));
  const { at_frames: rows } = look.paths[1];
  assert.deepEqual(rows.shape, [2, 7]);
  assert.deepEqual(Array.from(row(rows, 0)), [1, 2, 3, 1, 0, 0, 0]);
  assert.equal(poseAt(look.paths[1], 1), null);
  assert.equal(pathNamed(look, "nowhere").name, "motor");
  assert.equal(stateAt(look, 1.5).state, "lost");
  assert.equal(stateAt(look, 2.5), undefined);
});

test("a frame is told by when it begins, or by any time within it", () => {
  const times = [0, 0.033, 0.1, 0.134];
  for (let frame = 0; frame < 4; frame++) {
    const [begins, ends] = [times[frame], times[frame + 1] ?? 0.16];
    for (const share of [0, 0.25, 0.5]) {
      assert.equal(frameAt(begins + share * (ends - begins), 30, times), frame);
      assert.equal(frameAt((frame + share) / 30, 30), frame);
    }
    assert.equal(frameAt(Math.max(0, begins - 1e-3), 30, times), frame);
    assert.equal(frameAt(Math.max(0, frame / 30 - 1e-3), 30), frame);
  }
});

test("columns in 16 bits are summed up twice, past the ends of their range", () => {
  // 30000, then -30000, then 0 in the first column; 1, 2, 4 in the second
  const twice = new Int16Array([30000, -90000, 90000, 1, 0, 1]);
  const joints = {
    ...packed("i16", twice, [3, 2]),
    step: packed("f64", new Float64Array([1e-4, 2]), [2]),
  };
  const look = decode(JSON.stringify({ ...LOOK, joints }));
  assert.deepEqual(Array.from(look.joints.data), [3, 2, -3, 4, 0, 8].map(Math.fround));
  assert.deepEqual(look.joints.shape, [3, 2]);
});

test("a line without a value tells its nearest", () => {
  assert.equal(nearestKnown([null, 2, null, undefined, null, 7], 3), 2);
  assert.equal(nearestKnown([null, 2, null, null, null, 7], 4), 7);
  assert.equal(nearestKnown([null, undefined], 1), null);
});

test("another document is refused", () => {
  assert.throws(() => decode(JSON.stringify({ ...LOOK, version: 2 })), /version 1/);
  assert.throws(() => decode("{}"), /motorcade-look/);
});

test("frames are found among uneven stamps, before the first and after the last too", () => {
  const times = [0, 0.1, 0.15, 1, 1.01];
  assert.deepEqual([-1, 0, 0.1, 0.14, 0.99, 5].map((one) => indexAt(times, one)), [0, 0, 1, 1, 2, 4]);
  assert.deepEqual([0.04, 0.06, 0.6, 9].map((one) => nearest(times, one)), [0, 1, 3, 4]);
  for (const one of times) assert.equal(times[indexAt(times, one)], one);
});

test("a timeline stays within its frames and tells everybody once", () => {
  const timeline = new Timeline([0, 1, 2]);
  const heard = [];
  timeline.listen((frame, asked) => heard.push([frame, asked]));
  timeline.go(7);
  timeline.go(2, false);
  timeline.go(-3);
  timeline.goTo(1.999);
  assert.deepEqual(heard, [[2, true], [0, true], [1, true]]);
});

test("times are told as people read them", () => {
  assert.equal(clockWords(3.274), "3.27 s");
  assert.equal(clockWords(63.25), "1:03.3");
});
