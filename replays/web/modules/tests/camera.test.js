// Pixels to rays and back; tests/replays/studio compares the figures with Python's.

import assert from "node:assert/strict";
import { test } from "node:test";
import { project, projectionMatrix, reach, unproject } from "studio/camera.js";

const SIZE = { width: 752, height: 480, fx: 458.7, fy: 457.3, cx: 367.2, cy: 248.4 };
const CAMERAS = [
  { ...SIZE, model: "pinhole", coefficients: [] },
  { ...SIZE, model: "radtan", coefficients: [-0.283, 0.0739, 0.000193, 0.0000176] },
  { ...SIZE, model: "radtan", coefficients: [0.1, -0.02, 0, 0, 0.01, 0.05, 0.01, 0.001] },
  { ...SIZE, model: "equidistant", coefficients: [0.01, -0.004, 0.002, -0.0004] },
];

for (const camera of CAMERAS) {
  test(`pixels come back through a ${camera.model} lens of ${camera.coefficients.length}`, () => {
    for (const pixel of [[camera.cx, camera.cy], [0, 0], [751, 479], [751, 0], [100.5, 300.25]]) {
      const [u, v] = project(camera, unproject(camera, pixel).map((one) => 2.5 * one));
      assert.ok(Math.hypot(u - pixel[0], v - pixel[1]) < 1e-8, `${pixel} became ${u}, ${v}`);
    }
  });
}

test("what is behind has no pixel", () => {
  for (const camera of CAMERAS.slice(0, 3)) assert.equal(project(camera, [0.1, 0.2, -1]), null);
  assert.equal(project(CAMERAS[3], [0, 0, -1]), null);
  assert.ok(project(CAMERAS[3], [1, 0, -0.01]));
});

test("the matrix puts pixels where they are on the screen", () => {
  const m = projectionMatrix(CAMERAS[0], 0.01, 100);
  const point = [0.3, -0.2, 1.7];
  const view = [point[0], -point[1], -point[2], 1];
  const clip = [0, 1, 2, 3].map((row) => view.reduce((sum, one, k) => sum + one * m[4 * k + row], 0));
  const [u, v] = project(CAMERAS[0], point);
  assert.ok(Math.abs(((clip[0] / clip[3] + 1) / 2) * 752 - 0.5 - u) < 1e-9);
  assert.ok(Math.abs(((1 - clip[1] / clip[3]) / 2) * 480 - 0.5 - v) < 1e-9);
});

test("a barrel folds back where its radius stops growing, a cushion never", () => {
  const barrel = { ...SIZE, model: "radtan", coefficients: [-0.3, 0.0] };
  assert.ok(Math.abs(reach(barrel) - 1 / 0.9) < 0.03);
  assert.equal(reach({ ...barrel, coefficients: [0.1, 0.0] }), Infinity);
});
