// The world of a run as three.js draws it: paths, camera, boards, markers, points, characters.

import {
  BufferGeometry,
  CanvasTexture,
  DirectionalLight,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  HemisphereLight,
  Line,
  Line2,
  LineBasicMaterial,
  LineGeometry,
  LineMaterial,
  LineSegments2,
  LineSegmentsGeometry,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  Points,
  PointsMaterial,
  SRGBColorSpace,
  Scene,
  Vector3,
} from "studio/vendor.js";
import { Hiding, behindThings } from "studio/hiding.js";
import { behindLens } from "studio/lens.js";
import { css, variableOf } from "studio/scheme.js";
import { Figure, setPose } from "studio/figure.js";
import { pathNamed, poseAt } from "studio/look.js";
import { CameraSign, groundGrid, nearSphere } from "studio/signs.js";

/** Parts that can be shown or hidden, as people call them. */
export const PARTS = {
  camera: "Camera",
  characters: "Characters",
  boards: "Board",
  markers: "Markers",
  points: "Map points",
  ground: "Ground",
};

const SHADOW = 0.34;
// Width of the image that hangs in the camera's sign, pixels.
const SMALL = 256;
// Milliseconds between two of them at least: a copy waits for all that is being drawn.
const COPY_EVERY_MS = 120;

export class World {
  /** @param {import("./look.js").Look} look @param {HTMLCanvasElement} image of its film */
  constructor(look, image) {
    this.look = look;
    this.scene = new Scene();
    this.up = new Vector3(...look.up).normalize();
    /** @type {Record<string, Group>} */
    this.parts = {};
    for (const name of Object.keys(PARTS)) this.#add(name);
    this.bounds = nearSphere(look);
    this.lines = new Map(look.paths.map((path) => [path.name, this.#path(path)]));
    this.image = image;
    this.small = document.createElement("canvas");
    this.small.width = SMALL;
    this.small.height = Math.round((SMALL * look.camera.height) / look.camera.width);
    this.texture = new CanvasTexture(this.small);
    this.texture.colorSpace = SRGBColorSpace;
    this.texture.anisotropy = 4;
    this.sign = new CameraSign(look.camera, this.texture, this.bounds.radius);
    this.parts.camera.add(this.sign.object);
    this.#surround();
    this.#light();
    this.hiding = new Hiding(look.hiding);
    if (this.hiding.sheets) this.scene.add(this.hiding.sheets);
    this.figures = [];
    this.shadows = [];
    /** @type {Set<string>} paths and parts that nobody wants to see */
    this.hidden = new Set();
    this.recolour();
  }

  /** Characters, and what hides them, come after the rest is on show. */
  async loadFigures() {
    await this.hiding.load();
    this.figures = await Promise.all(this.look.characters.map((one) => Figure.load(one)));
    for (const figure of this.figures) {
      const shadow = softDisc(figure.character.height_m);
      this.shadows.push(shadow);
      this.parts.characters.add(shadow, figure.object);
    }
  }

  #add(name) {
    this.parts[name] = new Group();
    this.parts[name].name = name;
    this.scene.add(this.parts[name]);
  }

  #light() {
    const sky = new HemisphereLight(0xffffff, 0x9a9488, 1.7);
    sky.position.copy(this.up);
    const sun = new DirectionalLight(0xffffff, 1.9);
    const aside = new Vector3(0.45, -0.6, 0.2);
    sun.position.copy(this.up).multiplyScalar(1.2).add(aside);
    this.scene.add(sky, sun);
  }

  /** The drawn path wide, the others as thin as lines are, which costs a tenth. */
  #path(path) {
    const places = path.line_m.data;
    let line;
    if (path.name === this.look.drawn && path.line_m.shape[0] > 1) {
      const geometry = new LineGeometry().setPositions(places);
      line = new Line2(geometry, new LineMaterial({ linewidth: 2.5 }));
    } else {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
      line = new Line(geometry, new LineBasicMaterial());
    }
    line.frustumCulled = false;
    this.scene.add(line);
    return line;
  }

  #surround() {
    const { boards, markers, planes, points_m: points } = this.look;
    for (const board of boards) this.parts.boards.add(sheet(board));
    if (markers.length) this.parts.markers.add(outlines(markers));
    if (points.shape[0]) this.parts.points.add(cloud(points.data));
    for (const plane of planes) {
      this.grid = groundGrid(plane.corners_m.data, this.bounds.radius);
      this.parts.ground.add(this.grid);
    }
  }

  /** Which parts this run has anything of. */
  get present() {
    const empty = { boards: this.look.boards, markers: this.look.markers };
    return Object.keys(PARTS).filter((name) => {
      if (name === "points") return this.look.points_m.shape[0] > 0;
      return empty[name] ? empty[name].length > 0 : true;
    });
  }

  /** Take the colours that the page now has. */
  recolour() {
    for (const [name, line] of this.lines) line.material.color.set(css(variableOf(name)));
    const [ink, soft, grid, sky] = ["--ink", "--soft", "--grid", "--line-sky"].map(css);
    this.sign.colour(ink);
    this.grid?.material.color.set(grid);
    paint(this.parts.markers, sky);
    paint(this.parts.points, soft);
  }

  /** The pose `world_T_camera` of a path at a frame. @returns {Matrix4|null} */
  cameraAt(frame, pathName, into) {
    const pose = poseAt(pathNamed(this.look, pathName), frame);
    return pose && setPose(into, pose);
  }

  /** Whether the sign's image is to be copied later, as frames go by too quickly. */
  #waits() {
    const wait = (this.copied ?? -Infinity) + COPY_EVERY_MS - performance.now();
    if (wait <= 0) {
      this.copied = performance.now();
      return false;
    }
    this.later ??= setTimeout(() => {
      this.later = null;
      dispatchEvent(new Event("studio-changed"));
    }, wait);
    return true;
  }

  /** A small copy for the camera's sign; browsers keep films beside a local page from WebGL. */
  #copyImage() {
    const { width, height } = this.small;
    const brush = this.small.getContext("2d", { willReadFrequently: true });
    brush.drawImage(this.image, 0, 0, width, height);
    try {
      return brush.getImageData(0, 0, 1, 1).data.length > 0;
    } catch {
      return false;
    }
  }

  /**
   * Get ready to be drawn from outside or through the camera.
   *
   * @param {number} frame
   * @param {string} pathName whose camera is shown
   * @param {boolean} outside false where the footage is the ground
   */
  prepare(frame, pathName, outside) {
    const seconds = this.look.film.time_s.data[frame];
    for (const [k, figure] of this.figures.entries()) {
      const [from, to] = figure.character.visible_s ?? [-Infinity, Infinity];
      figure.object.visible = this.shadows[k].visible = seconds >= from && seconds <= to;
      figure.show(frame);
      figure.footing(this.shadows[k].position);
      this.shadows[k].up.copy(this.up);
      this.shadows[k].quaternion.setFromUnitVectors(new Vector3(0, 0, 1), this.up);
    }
    this.sign.place(outside ? this.cameraAt(frame, pathName, new Matrix4()) : null);
    if (!outside || this.held === frame || this.#waits()) return;
    this.held = frame;
    this.texture.needsUpdate = this.sign.image.visible = this.#copyImage();
  }
}

/** Colour what is drawn of a part. @param {Group} part @param {string} colour */
function paint(part, colour) {
  part.traverse((/** @type {any} what is drawn has a material */ one) => one.material?.color.set(colour));
}

/** A printed sheet with its image on it. */
function sheet(board) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(board.corners_m.data, 3));
  geometry.setAttribute("uv", new Float32BufferAttribute([0, 1, 1, 1, 1, 0, 0, 0], 2));
  geometry.setIndex([0, 2, 1, 0, 3, 2]);
  const image = new Image();
  const canvas = document.createElement("canvas");
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  image.onload = () => {
    [canvas.width, canvas.height] = [image.width, image.height];
    canvas.getContext("2d").drawImage(image, 0, 0);
    texture.dispose();
    texture.needsUpdate = true;
    dispatchEvent(new Event("studio-changed"));
  };
  image.src = board.image;
  // Behind everything that stands on it: the two lie in one plane.
  const material = new MeshBasicMaterial({
    map: texture,
    side: DoubleSide,
    polygonOffset: true,
    polygonOffsetFactor: 2,
    polygonOffsetUnits: 4,
  });
  return new Mesh(geometry, material);
}

function outlines(markers) {
  const edges = markers.flatMap(({ corners_m: { data } }) =>
    [0, 1, 2, 3].flatMap((k) => [0, 1].flatMap((end) => {
      const at = 3 * ((k + end) % 4);
      return Array.from(data.subarray(at, at + 3));
    })),
  );
  const geometry = new LineSegmentsGeometry().setPositions(edges);
  return new LineSegments2(geometry, behindLens(new LineMaterial({ linewidth: 1.5 })));
}

function cloud(places) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
  const look = { size: 2, sizeAttenuation: false };
  return new Points(geometry, behindLens(new PointsMaterial(look)));
}

/** A soft dark disc where a character stands: it says where its feet are. */
export function softDisc(height) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const brush = canvas.getContext("2d");
  const fade = brush.createRadialGradient(32, 32, 0, 32, 32, 32);
  fade.addColorStop(0, `rgba(0,0,0,${SHADOW})`);
  fade.addColorStop(0.55, `rgba(0,0,0,${0.45 * SHADOW})`);
  fade.addColorStop(1, "rgba(0,0,0,0)");
  brush.fillStyle = fade;
  brush.fillRect(0, 0, 64, 64);
  const look = { transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: 1 };
  const painted = new MeshBasicMaterial({ map: new CanvasTexture(canvas), ...look });
  const material = behindThings(behindLens(painted));
  return new Mesh(new PlaneGeometry(0.46 * height, 0.46 * height, 6, 6), material);
}

