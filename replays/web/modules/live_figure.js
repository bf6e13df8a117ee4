// The figure on live images: what the server says of it, with joints fetched a motion at a time.

import { GLTFLoader, Vector3 } from "studio/vendor.js";
import { Figure } from "studio/figure.js";
import { decoded } from "studio/look.js";
import { softDisc } from "studio/world.js";

const TALL_M = 1.75; // the mannequin, at a scale of 1

/** One figure, shown where the server has it. */
export class LiveFigure {
  /** @param {string} base address of the page @param {import("three").Group} group to stand in */
  constructor(base, group) {
    this.base = base;
    this.group = group;
    this.figure = null;
    this.motions = new Map();
    this.loading = false;
  }

  async #load() {
    this.loading = true;
    const [glb] = await Promise.all([
      fetch(`${this.base}figure.glb`).then((answer) => answer.arrayBuffer()),
      this.#motion(0),
    ]);
    const loaded = await new GLTFLoader().parseAsync(glb, "");
    const pose = new Float64Array([0, 0, 0, 1, 0, 0, 0, 1]);
    const { joints } = this.motions.get(0);
    const stands = { data: pose, shape: [1, 8] };
    const about = { name: "figure", joints, morphs: null, world_T_character: stands };
    this.figure = new Figure(about, loaded.scene);
    this.shadow = softDisc(1);
    this.group.add(this.shadow, this.figure.object);
  }

  async #motion(number) {
    if (this.motions.has(number)) return;
    this.motions.set(number, null);
    const answer = await fetch(`${this.base}motion/${number}.json`);
    if (answer.ok) this.motions.set(number, decoded(await answer.text()));
  }

  /** @param {{pose: number[], motion: number, at: number}|null} state as the server tells it */
  show(state) {
    this.state = state;
    this.group.visible = state !== null && this.figure !== null;
    if (!state) return;
    if (!this.figure) {
      if (!this.loading) this.#load();
      return;
    }
    this.#motion(state.motion);
    const motion = this.motions.get(state.motion) ?? this.motions.get(0);
    const [rows, joints] = motion.joints.shape;
    const at = Math.floor(state.at);
    const row = motion.loops ? at % rows : Math.min(at, rows - 1);
    this.figure.character.world_T_character.data.set(state.pose);
    this.figure.show(0, motion.joints.data.subarray(row * joints * 8, (row + 1) * joints * 8));
    this.figure.footing(this.shadow.position);
    this.shadow.scale.setScalar(this.height);
  }

  /** How tall it is, in the world's unit. */
  get height() {
    return this.state && this.figure ? this.state.pose[7] * TALL_M : 0;
  }

  /** Its feet and its head, in the world. @returns {[Vector3, Vector3]|null} */
  get ends() {
    if (!this.state || !this.figure) return null;
    const [x, y, z] = this.state.pose;
    return [new Vector3(x, y, z), new Vector3(x, y, z + this.height)];
  }
}
