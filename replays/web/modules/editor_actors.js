// Characters and props of the scene: their meshes, their poses frame by frame, and their ways.

import {
  GLTFLoader,
  Group,
  Line2,
  LineGeometry,
  LineMaterial,
  Matrix4,
  Sphere,
  Vector3,
} from "studio/vendor.js";
import { Figure, setPose } from "studio/figure.js";
import { behindLens } from "studio/lens.js";
import { decoded, row } from "studio/look.js";
import { softDisc } from "studio/world.js";

/** Something of the scene that can be seen or stood at. */
export class Actor {
  /** @param {string} name */
  constructor(name) {
    this.name = name;
    this.object = new Group();
    this.object.matrixAutoUpdate = false;
    this.figure = null;
    this.matrix = new Matrix4();
    this.held = null;
    /** @type {Float32Array|null} joints as they are dragged, until the scene has them so */
    this.pose = null;
    this.about = null;
    this.shadow = softDisc(1);
    this.shadow.visible = false;
  }

  /** Take what the server says of it; tracks that did not change are not told again. */
  tell(about) {
    const { track, ground } = this.about ?? {};
    this.about = { ...about, track: about.track ?? track, ground: about.ground ?? ground };
  }

  /** The frame of its own axes, its parent's, or the world's. @returns {Matrix4} */
  axes(whose, frame) {
    if (whose === "local") return this.matrix;
    const pose = row(this.about.ground, frame);
    return whose === "parent" ? setPose(new Matrix4(), pose, pose[7]) : new Matrix4();
  }

  /** Stand as at a frame, or as it is being dragged. */
  show(frame, seconds) {
    const pose = this.held ?? row(this.about.track, frame);
    setPose(this.matrix, pose, pose[7]);
    const span = this.about.visible_s;
    this.object.visible = !span || (span[0] <= seconds && seconds <= span[1]);
    this.object.matrix.copy(this.matrix);
    this.object.matrixWorldNeedsUpdate = true;
    if (this.figure) this.figure.show(frame, this.pose);
    this.object.updateMatrixWorld(true);
    this.#shade(frame);
  }

  /** A soft shadow on the ground below it. */
  #shade(frame) {
    this.shadow.visible = this.object.visible && this.figure !== null;
    if (!this.shadow.visible) return;
    const ground = this.axes("parent", frame);
    const foot = this.figure.footing(new Vector3()).applyMatrix4(this.matrix);
    foot.applyMatrix4(ground.clone().invert()).setZ(0).applyMatrix4(ground);
    const wide = this.height * 0.6;
    ground.decompose(new Vector3(), this.shadow.quaternion, new Vector3());
    this.shadow.position.copy(foot);
    this.shadow.scale.setScalar(wide);
  }

  /** How tall it is, metres. */
  get height() {
    return (this.figure?.character.height_m ?? 0) * this.matrix.getMaxScaleOnAxis();
  }

  /** Where a joint is, in the world. @returns {Vector3} */
  joint(number) {
    return this.figure.joint(number).applyMatrix4(this.matrix);
  }

  /** Where it stands. @returns {Vector3} */
  get place() {
    return new Vector3().setFromMatrixPosition(this.matrix);
  }

  /** @returns {{name: string, point: Vector3, distance: number}|null} */
  hitBy(raycaster) {
    const [found] = raycaster.intersectObject(this.object, true);
    return found ? { name: this.name, point: found.point, distance: found.distance } : null;
  }
}

/** Meshes and motions, each fetched once. */
export class Wardrobe {
  /** @param {string} base address of the run */
  constructor(base) {
    this.base = base;
    this.loader = new GLTFLoader();
    this.meshes = new Map();
    this.motions = new Map();
  }

  /** Dress an actor as its `figure` and `motion` say. */
  async dress(actor) {
    const { figure, motion } = actor.about;
    const worn = `${figure} ${motion}`;
    if (actor.worn === worn) actor.pose = null;
    if (figure === null || (actor.figure && actor.worn === worn)) return;
    actor.wanted = worn;
    const [file, moves] = await Promise.all([this.#mesh(figure), this.#motion(motion)]);
    if (actor.wanted !== worn) return;
    const loaded = await this.loader.parseAsync(file.slice(0), "");
    if (actor.wanted !== worn) return;
    const made = new Figure({ name: actor.name, ...moves, ...unmoved(moves.size) }, loaded.scene);
    for (const mesh of made.meshes) mesh.boundingSphere = new Sphere(new Vector3(), Infinity);
    if (actor.figure) actor.object.remove(actor.figure.object);
    actor.figure = made;
    actor.worn = worn;
    actor.pose = null;
    actor.object.add(made.object);
  }

  #mesh(number) {
    if (!this.meshes.has(number)) {
      const get = fetch(`${this.base}figure/${number}.glb`).then((one) => one.arrayBuffer());
      this.meshes.set(number, get);
    }
    return this.meshes.get(number);
  }

  #motion(number) {
    if (!this.motions.has(number)) {
      const get = fetch(`${this.base}motion/${number}.json`).then((one) => one.text());
      this.motions.set(number, get.then(decoded));
    }
    return this.motions.get(number);
  }
}

/** The actor's own matrix places it; the figure is as large as its file was made to be. */
function unmoved(size) {
  const pose = new Float64Array([0, 0, 0, 1, 0, 0, 0, size]);
  return { world_T_character: { data: pose, shape: [1, 8] }, visible_s: null };
}

/** A line through places of the world, such as a way or the path between keyframes. */
export function wayLine(places, colour) {
  const geometry = new LineGeometry();
  geometry.setPositions(places.length > 3 ? places : [...places, ...places]);
  const line = new Line2(geometry, behindLens(new LineMaterial({ linewidth: 3, color: colour })));
  line.frustumCulled = false;
  line.renderOrder = 1;
  line.material.depthTest = false;
  line.material.transparent = true;
  return line;
}
