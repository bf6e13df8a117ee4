// Handles of what is chosen: arrows to move it along, rings to turn it about.

import {
  ConeGeometry,
  CylinderGeometry,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  Quaternion,
  TorusGeometry,
  Vector3,
} from "studio/vendor.js";
import { behindLens } from "studio/lens.js";

const AXES = [
  { axis: [1, 0, 0], colour: 0xe2453c },
  { axis: [0, 1, 0], colour: 0x3fa34d },
  { axis: [0, 0, 1], colour: 0x3b7dd8 },
];
const UP = new Vector3(0, 1, 0);
const OUT = new Vector3(0, 0, 1);
const LENGTH_PX = 84;
const RING_PX = 62;

function part(geometry, colour, handle) {
  const material = behindLens(
    new MeshBasicMaterial({ color: colour, side: DoubleSide, depthTest: false, transparent: true }),
  );
  material.opacity = 0.9;
  const mesh = new Mesh(geometry, material);
  mesh.renderOrder = 5;
  mesh.userData.handle = handle;
  return mesh;
}

/** Seen by touch alone: a finger is wider than what is drawn. */
function wide(geometry, handle) {
  const mesh = part(geometry, 0xffffff, handle);
  mesh.material.opacity = 0;
  mesh.material.depthWrite = false;
  return mesh;
}

export class Handles {
  constructor() {
    this.object = new Group();
    this.object.matrixAutoUpdate = false;
    this.object.visible = false;
    /** "few": a ring on the ground and an arrow up; "all": three of each. */
    this.kind = "few";
    /** Whose axes: "local", "parent" or "global". */
    this.axes = "parent";
    for (const [k, { axis, colour }] of AXES.entries()) this.#axis(k, axis, colour);
  }

  #axis(k, axis, colour) {
    const along = new Quaternion().setFromUnitVectors(UP, new Vector3(...axis));
    const about = new Quaternion().setFromUnitVectors(OUT, new Vector3(...axis));
    const move = { gesture: "axis", axis };
    const turn = { gesture: "ring", axis };
    const arrow = new Group();
    const shaft = part(new CylinderGeometry(1.6, 1.6, LENGTH_PX - 14, 8, 8), colour, move);
    shaft.position.y = (LENGTH_PX - 14) / 2;
    const head = part(new ConeGeometry(7, 18, 16), colour, move);
    head.position.y = LENGTH_PX - 8;
    const reach = wide(new CylinderGeometry(15, 15, LENGTH_PX - 10, 8, 4), move);
    reach.position.y = LENGTH_PX / 2 + 18;
    arrow.add(shaft, head, reach);
    arrow.quaternion.copy(along);
    const ring = new Group();
    ring.add(part(new TorusGeometry(RING_PX, 1.8, 6, 72), colour, turn));
    ring.add(wide(new TorusGeometry(RING_PX, 13, 6, 48), turn));
    ring.quaternion.copy(about);
    for (const one of [arrow, ring]) one.userData = { k, arrow: one === arrow };
    this.object.add(arrow, ring);
  }

  hide() {
    this.object.visible = false;
  }

  /**
   * Stand at an object, as large on the screen everywhere.
   *
   * @param {import("three").Matrix4} frame the object's pose, its parent's or the world's by `axes`
   * @param {Vector3} place
   * @param {number} metresAPixel
   * @param {number} height of the object, metres: one arrow alone stands on top of it
   */
  show(frame, place, metresAPixel, height = 0) {
    this.object.visible = true;
    const turn = new Quaternion();
    frame.decompose(new Vector3(), turn, new Vector3());
    this.object.matrix.compose(place, turn, new Vector3().setScalar(metresAPixel));
    this.object.matrixWorldNeedsUpdate = true;
    for (const one of this.object.children) {
      one.visible = this.kind === "all" || one.userData.k === 2;
      const top = this.kind === "few" && one.userData.arrow ? height / metresAPixel - 34 : 0;
      one.position.set(0, 0, Math.max(0, top));
    }
    this.object.updateMatrixWorld(true);
  }

  /** @returns {object|null} what is to be done with the handle under a ray */
  hitBy(raycaster) {
    if (!this.object.visible) return null;
    const shown = this.object.children.filter((one) => one.visible);
    const [found] = raycaster.intersectObjects(shown, true);
    return found ? { ...found.object.userData.handle, in: this.axes, point: found.point.toArray() } : null;
  }
}
