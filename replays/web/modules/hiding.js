// What hides characters in the view through the camera, by the rule of the film: what was recorded
// as nearer, or else boards, markers and the ground. The world from outside hides nothing.

import {
  BufferGeometry,
  DataTexture,
  DoubleSide,
  Float32BufferAttribute,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  Plane,
  RedFormat,
  Vector3,
  Vector4,
} from "studio/vendor.js";
import { behindLens } from "studio/lens.js";
import { bytesOf } from "studio/look.js";

// Sides of a print are divided, as the lens bends them.
const PARTS = 6;

// One set for all materials, as one view is drawn at a time.
const uniforms = {
  hidBy: { value: 0 },
  hidGround: { value: new Vector4() },
  hidDepth: { value: null },
  hidRange: { value: [0, 0] },
};
const [NOTHING, GROUND, DEPTH] = [0, 1, 2];

const VERTEX = `
varying vec3 hidPlace;
varying float hidOwn;
varying float hidHigh;
uniform vec4 hidGround;
`;
const PLACED = `
hidPlace = gl_Position.xyw;
hidOwn = -mvPosition.z;
hidHigh = dot(hidGround.xyz, mvPosition.xyz) + hidGround.w;
`;
// Nearer by twice the noise of a depth camera counts, as in render/composite.py.
const FRAGMENT = `
varying vec3 hidPlace;
varying float hidOwn;
varying float hidHigh;
uniform int hidBy;
uniform vec4 hidGround;
uniform sampler2D hidDepth;
uniform vec2 hidRange;

bool isHidden() {
  float own = hidOwn, real = 0.0;
  if (hidBy == ${DEPTH}) {
    vec2 at = 0.5 + 0.5 * hidPlace.xy / hidPlace.z;
    float level = 255.0 * texture2D(hidDepth, vec2(at.x, 1.0 - at.y)).r;
    if (level > 0.5) real = exp2(hidRange.x + (level - 1.0) * hidRange.y);
  } else if (hidBy == ${GROUND} && hidGround.w > 0.0 && hidHigh < 0.0) {
    real = own * hidGround.w / (hidGround.w - hidHigh);
  }
  return real > 0.0 && real < own - 0.0028 * own * own;
}
`;

/**
 * Let things hide what a material draws.
 *
 * @template {import("three").Material} M
 * @param {M} material of three.js that is behind the lens
 * @returns {M} the same
 */
export function behindThings(material) {
  const before = material.onBeforeCompile;
  material.onBeforeCompile = (shader, renderer) => {
    before.call(material, shader, renderer);
    Object.assign(shader.uniforms, uniforms);
    const [vertex, fragment] = [shader.vertexShader, shader.fragmentShader];
    shader.vertexShader = VERTEX + vertex.replace("#include <fog_vertex>", PLACED);
    shader.fragmentShader =
      FRAGMENT + fragment.replace("#include <clipping_planes_fragment>", "if (isHidden()) discard;");
  };
  material.customProgramCacheKey = () => "behind things";
  return material;
}

/** Boards and markers that draw nothing and hide what is behind them. */
function sheets(corners) {
  const [places, index] = [[], []];
  const [from, to] = [new Vector3(), new Vector3()];
  for (let at = 0; at < corners.length; at += 12) {
    const [a, b, c, d] = [0, 3, 6, 9].map((k) => new Vector3().fromArray(corners, at + k));
    const first = places.length / 3;
    for (let j = 0; j <= PARTS; j++) {
      from.lerpVectors(a, d, j / PARTS);
      to.lerpVectors(b, c, j / PARTS);
      for (let i = 0; i <= PARTS; i++) {
        places.push(...new Vector3().lerpVectors(from, to, i / PARTS).toArray());
        const k = first + j * (PARTS + 1) + i;
        if (i < PARTS && j < PARTS) index.push(k, k + 1, k + PARTS + 2, k, k + PARTS + 2, k + PARTS + 1);
      }
    }
  }
  const geometry = new BufferGeometry().setIndex(index);
  geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
  const back = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8 };
  const unseen = { colorWrite: false, side: DoubleSide, ...back };
  const mesh = new Mesh(geometry, behindLens(new MeshBasicMaterial(unseen)));
  mesh.renderOrder = -1;
  mesh.frustumCulled = false;
  return mesh;
}

export class Hiding {
  /** @param {import("./look.js").Hiding} told */
  constructor(told) {
    this.told = told;
    this.enabled = true;
    const corners = told.prints.data;
    this.sheets = corners.length && !told.depth ? sheets(corners) : null;
    this.plane = null;
    if (told.ground) {
      const [x, y, z, w, i, j, k] = told.ground.data;
      const up = [2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j)];
      this.plane = new Plane().setFromNormalAndCoplanarPoint(new Vector3(...up), new Vector3(x, y, z));
    }
  }

  /** Which things hide characters here, in words. */
  get words() {
    if (this.told.depth) return "Hidden by whatever the recorded depth has nearer";
    const prints = this.told.prints.shape[0] ? "boards, markers and the ground hide" : "the ground hides";
    return `No depth was recorded: only ${prints} what is drawn`;
  }

  /** Unpack the images of depth. */
  async load() {
    const { depth } = this.told;
    if (!depth) return;
    const packed = new Blob([bytesOf(depth.deflated)]).stream();
    const whole = new Response(packed.pipeThrough(new DecompressionStream("deflate")));
    this.levels = new Uint8Array(await whole.arrayBuffer());
    const [, high, wide] = depth.shape;
    this.texture = new DataTexture(new Uint8Array(wide * high), wide, high, RedFormat);
    this.texture.unpackAlignment = 1;
  }

  /**
   * Hide by what there is at a frame.
   *
   * @param {number} frame
   * @param {import("three").Camera|null} camera that is looked through; null for nothing hidden
   */
  prepare(frame, camera) {
    const active = camera !== null && this.enabled;
    if (this.sheets) this.sheets.visible = active;
    uniforms.hidBy.value = NOTHING;
    if (!active) return;
    if (this.texture) this.#take(frame);
    else if (this.plane && !this.told.depth) {
      const view = new Matrix4().copy(camera.matrixWorld).invert();
      const { normal, constant } = this.plane.clone().applyMatrix4(view);
      uniforms.hidGround.value.set(normal.x, normal.y, normal.z, constant);
      uniforms.hidBy.value = GROUND;
    }
  }

  #take(frame) {
    const { near_m: near, far_m: far } = this.told.depth;
    const { data } = this.texture.image;
    if (this.held !== frame) {
      data.set(this.levels.subarray(frame * data.length, (frame + 1) * data.length));
      this.texture.needsUpdate = true;
      this.held = frame;
    }
    uniforms.hidDepth.value = this.texture;
    uniforms.hidRange.value = [Math.log2(near), Math.log2(far / near) / 254];
    uniforms.hidBy.value = DEPTH;
  }
}
