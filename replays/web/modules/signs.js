// Signs in the 3-D view: the camera with its image, the grid on the ground, how large it all is.

import {
  BufferGeometry,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LineMaterial,
  LineSegments2,
  LineSegmentsGeometry,
  Mesh,
  MeshBasicMaterial,
  Sphere,
  Vector3,
} from "studio/vendor.js";
import { unproject } from "studio/camera.js";

const SHARE = 0.2;
const [COLUMNS, ROWS] = [16, 12];
const LINES = 12;

/** A camera as an open pyramid, its image as the lens saw it at the far end. */
export class CameraSign {
  /**
   * @param {import("./camera.js").Camera} camera
   * @param {import("three").Texture} texture the image
   * @param {number} radius of the world
   */
  constructor(camera, texture, radius) {
    this.object = new Group();
    this.object.matrixAutoUpdate = false;
    const depth = SHARE * radius;
    const corner = (u, v) => rayAt(camera, u, v).map((one) => depth * one);
    this.image = new Mesh(imageGeometry(corner), imageMaterial(texture));
    this.edges = new LineSegments2(
      new LineSegmentsGeometry().setPositions(pyramid(corner)),
      new LineMaterial({ linewidth: 1.5 }),
    );
    this.object.add(this.image, this.edges);
  }

  /** @param {import("three").Matrix4|null} world_T_camera hidden where there is no pose */
  place(world_T_camera) {
    this.object.visible = world_T_camera !== null;
    if (!world_T_camera) return;
    this.object.matrix.copy(world_T_camera);
    this.object.matrixWorldNeedsUpdate = true;
  }

  colour(ink) {
    this.edges.material.color.set(ink);
  }
}

/** The ray through a share of the image's width and height; a straight lens where it has none. */
function rayAt(camera, u, v) {
  /** @type {import("./camera.js").Pair} */
  const pixel = [u * camera.width - 0.5, v * camera.height - 0.5];
  const straight = { ...camera, model: "pinhole" };
  return unproject(camera, pixel) ?? unproject(straight, pixel);
}

function imageMaterial(map) {
  return new MeshBasicMaterial({ map, side: DoubleSide, transparent: true, opacity: 0.92 });
}

function imageGeometry(corner) {
  const [places, uvs, index] = [[], [], []];
  for (let j = 0; j <= ROWS; j++) {
    for (let i = 0; i <= COLUMNS; i++) {
      places.push(...corner(i / COLUMNS, j / ROWS));
      uvs.push(i / COLUMNS, 1 - j / ROWS);
      const at = j * (COLUMNS + 1) + i;
      const [right, below] = [at + 1, at + COLUMNS + 1];
      if (i < COLUMNS && j < ROWS) index.push(at, below, right, right, below, below + 1);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
  geometry.setAttribute("uv", new Float32BufferAttribute(uvs, 2));
  return geometry.setIndex(index);
}

/** Segments from the camera's centre to the corners, and around the image. */
function pyramid(corner) {
  const around = [];
  for (const [from, to] of [[[0, 0], [1, 0]], [[1, 0], [1, 1]], [[1, 1], [0, 1]], [[0, 1], [0, 0]]]) {
    for (let k = 0; k < LINES; k++) {
      for (const share of [k / LINES, (k + 1) / LINES]) {
        around.push(...corner(...from.map((one, axis) => one + share * (to[axis] - one))));
      }
    }
  }
  const out = [[0, 0], [1, 0], [1, 1], [0, 1]].flatMap((one) => [0, 0, 0, ...corner(...one)]);
  return [...around, ...out];
}

/** Lines on the plane through four corners, about their middle, as wide as what stands there. */
export function groundGrid(corners, radius) {
  const at = (k) => new Vector3().fromArray(corners, 3 * k);
  const across = at(1).sub(at(0)).normalize();
  const down = at(3).sub(at(0)).normalize();
  const middle = at(0).add(at(2)).multiplyScalar(0.5);
  const step = roundStep((2 * radius) / LINES);
  const reach = step * Math.ceil(radius / step);
  const edges = [];
  for (let offset = -reach; offset <= reach + 1e-9 * step; offset += step) {
    for (const [along, side] of [[across, down], [down, across]]) {
      for (const end of [-reach, reach]) {
        const place = middle.clone().addScaledVector(along, end).addScaledVector(side, offset);
        edges.push(...place.toArray());
      }
    }
  }
  const geometry = new LineSegmentsGeometry().setPositions(edges);
  // Behind whatever lies on the ground: wide lines are triangles, which can be set back.
  const back = { polygonOffset: true, polygonOffsetFactor: 6, polygonOffsetUnits: 12 };
  return new LineSegments2(geometry, new LineMaterial({ linewidth: 1, ...back }));
}

/** The nearest of 1, 2 or 5 times a power of ten. */
export function roundStep(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return power * [1, 2, 5, 10].reduce((best, one) =>
    Math.abs(one * power - length) < Math.abs(best * power - length) ? one : best,
  );
}

/** A ball about the drawn path and the characters. @returns {Sphere} */
export function nearSphere(look) {
  const path = look.paths.find((one) => one.name === look.drawn) ?? look.paths[0];
  const places = [];
  for (let k = 0; k < path.line_m.data.length; k += 3) {
    places.push(new Vector3().fromArray(path.line_m.data, k));
  }
  for (const { world_T_character: stands, height_m: height } of look.characters) {
    const foot = new Vector3().fromArray(stands.data, 0);
    places.push(foot, foot.clone().addScaledVector(new Vector3(...look.up), height));
  }
  for (const board of look.boards) {
    for (let k = 0; k < 12; k += 3) places.push(new Vector3().fromArray(board.corners_m.data, k));
  }
  const sphere = new Sphere().setFromPoints(places);
  sphere.radius = Math.max(sphere.radius, 1e-3);
  return sphere;
}
