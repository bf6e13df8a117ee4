// The lens in the vertex stage: what three.js draws lies where the camera's lens shows it.
//
// Points of view space are moved so that the pinhole projection that follows gives the distorted
// pixel. Triangles stay straight between their corners, so long edges are to be divided.

import { coefficientsOf, reach } from "studio/camera.js";
import { ShaderChunk } from "studio/vendor.js";

const MODELS = { pinhole: 0, radtan: 1, equidistant: 2 };

// One lens for all materials, as one view is drawn at a time.
const lens = {
  lensModel: { value: 0 },
  lensRadial: { value: [0, 0, 0, 0, 0, 0] },
  lensTangential: { value: [0, 0] },
  lensReach: { value: 1e30 },
};

const GLSL = `
uniform int lensModel;
uniform float lensRadial[6];
uniform float lensTangential[2];
uniform float lensReach;

vec4 throughLens(vec4 view) {
  if (lensModel == 0) return view;
  vec3 p = vec3(view.x, -view.y, -view.z);
  float k1 = lensRadial[0], k2 = lensRadial[1], k3 = lensRadial[2], k4 = lensRadial[3];
  if (lensModel == 1) {
    if (p.z <= 0.0) return view;
    vec2 ideal = p.xy / p.z;
    // Beyond its reach the formula folds back: go on outwards, evenly.
    float beyond = sqrt(max(1.0, dot(ideal, ideal) / lensReach));
    ideal /= beyond;
    float k5 = lensRadial[4], k6 = lensRadial[5], p1 = lensTangential[0], p2 = lensTangential[1];
    float x = ideal.x, y = ideal.y, r2 = x * x + y * y;
    float radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    vec2 moved = ideal * radial
      + vec2(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
    moved *= beyond * p.z;
    return vec4(moved.x, -moved.y, view.z, view.w);
  }
  float radius = length(p.xy), angle = atan(radius, p.z);
  float within = min(angle, lensReach), a2 = within * within;
  float seen = within * (1.0 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4)))) + angle - within;
  // What lies behind keeps its distance as depth; what the lens never shows is cut off.
  float depth = angle < min(lensReach, 2.6) ? length(p) : -length(p);
  vec2 moved = radius > 0.0 ? p.xy * (seen / radius * depth) : vec2(0.0);
  return vec4(moved.x, -moved.y, -depth, view.w);
}
`;

const PLAIN = "gl_Position = projectionMatrix * mvPosition;";
const SEGMENTS = [
  ["projectionMatrix * start", "projectionMatrix * throughLens( start )"],
  ["projectionMatrix * end", "projectionMatrix * throughLens( end )"],
];

/**
 * Let a material be drawn through the lens of `lookThrough`.
 *
 * @template {import("three").Material & {isLineMaterial?: boolean}} M
 * @param {M} material of three.js: of meshes, points or lines
 * @returns {M} the same
 */
export function behindLens(material) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, lens);
    let text = shader.vertexShader;
    if (material.isLineMaterial) {
      for (const [old, now] of SEGMENTS) text = text.replaceAll(old, now);
    } else {
      const chunk = ShaderChunk.project_vertex.replace(PLAIN, PLAIN.replace("mvPosition", "throughLens(mvPosition)"));
      text = text.replace("#include <project_vertex>", chunk);
    }
    shader.vertexShader = GLSL + text;
  };
  material.customProgramCacheKey = () => "lens";
  return material;
}

/**
 * Draw from now on as a camera's lens shows it, or without a lens.
 *
 * @param {import("./camera.js").Camera|null} camera
 */
export function lookThrough(camera) {
  lens.lensModel.value = camera ? MODELS[camera.model] : 0;
  if (!camera) return;
  const k = coefficientsOf(camera);
  const equidistant = camera.model === "equidistant";
  lens.lensRadial.value = equidistant ? [...k.slice(0, 4), 0, 0] : [k[0], k[1], ...k.slice(4, 8)];
  lens.lensTangential.value = equidistant ? [0, 0] : [k[2], k[3]];
  lens.lensReach.value = Math.min(reach(camera), 1e30);
}
