// The scene on the footage: the image below, characters and props above it, and what is touched.

import {
  DirectionalLight,
  Group,
  HemisphereLight,
  Matrix4,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Vector3,
  WebGLRenderer,
} from "studio/vendor.js";
import { project, projectionMatrix, unproject } from "studio/camera.js";
import { drawGrey, setPose } from "studio/figure.js";
import { lookThrough } from "studio/lens.js";
import { row } from "studio/look.js";
import { drawnBy } from "studio/panes.js";

// From three.js's camera axes to OpenCV's, and back.
const TURNED = new Matrix4().makeScale(1, -1, -1);
// Where a finger is taken to have meant something beside it, CSS pixels.
const SLACK_PX = [0, 10, 20];
const AROUND = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [0.7, 0.7], [-0.7, 0.7], [0.7, -0.7], [-0.7, -0.7]];

export class EditorStage {
  /**
   * @param {HTMLElement} element that it fills
   * @param {object} about the run, as the server tells it
   */
  constructor(element, about) {
    this.element = element;
    this.about = about;
    this.ground = document.createElement("canvas");
    this.ground.className = "ground";
    [this.ground.width, this.ground.height] = [about.camera.width, about.camera.height];
    this.renderer = new WebGLRenderer({ antialias: drawnBy() === "card", alpha: true });
    this.canvas = this.renderer.domElement;
    this.canvas.className = "drawn";
    this.sketched = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.sketched.setAttribute("class", "sketch");
    element.prepend(this.ground, this.canvas, this.sketched);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera();
    this.camera.matrixAutoUpdate = false;
    this.world_T_camera = new Matrix4();
    this.figures = new Group();
    this.signs = new Group();
    this.scene.add(this.figures, this.signs);
    this.#light();
    this.raycaster = new Raycaster();
    this.frame = 0;
    /** The frame whose image lies below the drawing; none at first. */
    this.shown = -1;
    this.hasPose = false;
    this.box = { x: 0, y: 0, width: 1, height: 1 };
    lookThrough(about.camera);
    drawGrey(about.grey);
  }

  #light() {
    const up = new Vector3(...this.about.up);
    const sky = new HemisphereLight(0xffffff, 0x9a9488, 1.7);
    sky.position.copy(up);
    const sun = new DirectionalLight(0xffffff, 1.9);
    sun.position.copy(up).multiplyScalar(1.2).add(new Vector3(0.45, -0.6, 0.2));
    this.scene.add(sky, sun);
  }

  /** Follow the size of the page: the image whole, in the middle. */
  fit() {
    const { clientWidth: wide, clientHeight: high } = this.element;
    const { width, height } = this.about.camera;
    const scale = Math.min(wide / width, high / height);
    const size = { width: Math.round(scale * width), height: Math.round(scale * height) };
    this.box = { x: (wide - size.width) >> 1, y: (high - size.height) >> 1, ...size };
    for (const one of [this.ground, this.canvas]) {
      one.style.left = `${this.box.x}px`;
      one.style.top = `${this.box.y}px`;
      one.style.width = `${size.width}px`;
      one.style.height = `${size.height}px`;
    }
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(Math.max(1, size.width), Math.max(1, size.height), false);
  }

  /** The image's pixel below a place of the page; (0, 0) is the middle of the top left one. */
  pixelAt(clientX, clientY) {
    const corner = this.ground.getBoundingClientRect();
    const { width, height } = this.about.camera;
    return [
      ((clientX - corner.left) * width) / corner.width - 0.5,
      ((clientY - corner.top) * height) / corner.height - 0.5,
    ];
  }

  /**
   * The place of the page, CSS pixels, of a point of the world; null where it is not seen.
   *
   * @param {import("studio/vendor.js").Vector3} point
   * @returns {[number, number]|null}
   */
  placeOf(point) {
    const seen = point.clone().applyMatrix4(new Matrix4().copy(this.world_T_camera).invert());
    const pixel = project(this.about.camera, seen.toArray());
    if (!pixel) return null;
    const corner = this.ground.getBoundingClientRect();
    const { width, height } = this.about.camera;
    return [
      corner.left + ((pixel[0] + 0.5) * corner.width) / width,
      corner.top + ((pixel[1] + 0.5) * corner.height) / height,
    ];
  }

  /** How many metres a CSS pixel is at a point. */
  metresAPixel(point) {
    const seen = point.clone().applyMatrix4(new Matrix4().copy(this.world_T_camera).invert());
    const { fx, width } = this.about.camera;
    return (Math.max(seen.z, 1e-6) / fx) * (width / this.box.width);
  }

  /** Point the raycaster along the ray of a pixel. @returns {boolean} whether there is one */
  #aim(pixel) {
    const ray = unproject(this.about.camera, pixel);
    if (!ray) return false;
    const { origin, direction } = this.raycaster.ray;
    origin.setFromMatrixPosition(this.world_T_camera);
    direction.set(...ray).transformDirection(this.world_T_camera);
    return true;
  }

  /**
   * What is under a finger: of the objects given, else near it.
   *
   * @param {number} clientX @param {number} clientY
   * @param {Iterable<import("./editor_actors.js").Actor>} actors
   * @param {boolean} coarse whether it is a finger
   * @returns {{name: string, point: Vector3}|null}
   */
  hit(clientX, clientY, actors, coarse) {
    const shown = [...actors].filter((one) => one.object.visible);
    for (const slack of coarse ? SLACK_PX : SLACK_PX.slice(0, 1)) {
      for (const [dx, dy] of slack ? AROUND.slice(1) : AROUND.slice(0, 1)) {
        if (!this.#aim(this.pixelAt(clientX + slack * dx, clientY + slack * dy))) continue;
        const found = shown.map((one) => one.hitBy(this.raycaster)).filter(Boolean);
        found.sort((a, b) => a.distance - b.distance);
        if (found.length) return found[0];
      }
    }
    return null;
  }

  /** The handle under a finger. @returns {object|null} what it does */
  handleAt(clientX, clientY, handles) {
    return this.#aim(this.pixelAt(clientX, clientY)) ? handles.hitBy(this.raycaster) : null;
  }

  /** Show the line that is being drawn. @param {[number, number][]|null} places of the page */
  sketch(places) {
    this.sketched.replaceChildren();
    if (!places) return;
    const corner = this.element.getBoundingClientRect();
    const line = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
    const points = places.map(([x, y]) => `${x - corner.left},${y - corner.top}`);
    line.setAttribute("points", points.join(" "));
    this.sketched.append(line);
  }

  /** Show a frame: its image, once it is there, and the view of its camera. */
  show(frame, image) {
    this.frame = frame;
    if (image) {
      const { width, height } = this.ground;
      this.ground.getContext("2d").drawImage(image, 0, 0, width, height);
    }
    const pose = row(this.about.world_T_camera, frame);
    this.hasPose = !Number.isNaN(pose[0]);
    if (!this.hasPose) return;
    setPose(this.world_T_camera, pose);
    this.camera.matrix.copy(this.world_T_camera).multiply(TURNED);
    this.camera.matrix.decompose(this.camera.position, this.camera.quaternion, this.camera.scale);
    this.camera.matrixWorldNeedsUpdate = true;
    const [near, far] = this.about.depth_m;
    this.camera.projectionMatrix.fromArray(projectionMatrix(this.about.camera, near, far));
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
  }

  draw() {
    this.figures.visible = this.hasPose;
    this.signs.visible = this.hasPose;
    this.renderer.render(this.scene, this.camera);
  }
}
