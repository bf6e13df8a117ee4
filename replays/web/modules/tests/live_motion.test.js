// Readings come in screen axes with the sign of a force, are bounded, and nothing lacking is sent.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

let listeners, vendor;
Object.defineProperty(globalThis, "navigator", { value: { get vendor() { return vendor; } } });
globalThis.window = globalThis;
globalThis.addEventListener = (kind, act) => listeners.set(kind, act);
const { LiveMotion } = await import("studio/live_motion.js");

beforeEach(() => {
  listeners = new Map();
  globalThis.DeviceMotionEvent = class {};
  vendor = "Google Inc.";
  globalThis.screen = { orientation: { angle: 0 } };
});

const event = (more = {}) => ({
  timeStamp: 7,
  rotationRate: { alpha: 1, beta: 2, gamma: 3 },
  accelerationIncludingGravity: { x: 4, y: 5, z: 6 },
  ...more,
});
const rounded = ({ at, values }) => [at, ...values.map((value) => Math.round(value))];

test("axes are the screen's, however the phone is held", () => {
  const motion = new LiveMotion();
  listeners.get("devicemotion")(event());
  globalThis.screen.orientation.angle = 90; // its top points left
  listeners.get("devicemotion")(event({ timeStamp: 9 }));
  assert.deepEqual(motion.take().map(rounded), [
    [7, 1, 2, 3, 4, 5, 6],
    [9, -2, 1, 3, -5, 4, 6],
  ]);
  assert.deepEqual(motion.take(), []);
});

test("a tap asks for leave until somebody answers, and WebKit's forces are turned round", async () => {
  let asked = 0;
  vendor = "Apple Computer, Inc.";
  globalThis.DeviceMotionEvent.requestPermission = async () => {
    if (asked++ < 2) throw new Error("no tap");
    return "denied";
  };
  const motion = new LiveMotion();
  for (const expected of [true, true, false, false]) {
    await new Promise(setImmediate);
    assert.equal(motion.asks, expected);
    listeners.get("click")();
  }
  assert.equal(asked, 3);
  listeners.get("devicemotion")(event());
  assert.deepEqual(motion.take().map(rounded), [[7, 1, 2, 3, -4, -5, -6]]);
});

test("where leave is given at once, nothing is asked", async () => {
  globalThis.DeviceMotionEvent.requestPermission = async () => "granted";
  const motion = new LiveMotion();
  await new Promise(setImmediate);
  assert.equal(motion.asks, false);
});

test("what a sensor lacks is not sent, and what nobody takes is forgotten", () => {
  const motion = new LiveMotion();
  for (const lacking of [
    { rotationRate: null },
    { accelerationIncludingGravity: { x: 1, y: null, z: 2 } },
    { accelerationIncludingGravity: { x: 1, y: 2, z: undefined } },
    { rotationRate: { alpha: NaN, beta: 0, gamma: 0 } },
    { accelerationIncludingGravity: { x: "9", y: 0, z: 0 } },
  ]) listeners.get("devicemotion")(event(lacking));
  assert.deepEqual(motion.take(), []);
  for (let k = 0; k < 1000; k++) listeners.get("devicemotion")(event({ timeStamp: k }));
  const kept = motion.take();
  assert.equal(kept.length, 256);
  assert.equal(kept.at(-1).at, 999);
});
