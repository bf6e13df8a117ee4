// Cameras as `motorcade.tracking.Camera` has them: points to pixels, pixels to rays.
//
// OpenCV's camera axes (x right, y down, z forward); pixel (0, 0) is the centre of the top-left
// pixel. The formulas are those of tracking/cameras/lenses.py, and tests compare the two.

/**
 * @typedef {object} Camera
 * @property {number} width pixels
 * @property {number} height pixels
 * @property {number} fx pixels
 * @property {number} fy pixels
 * @property {number} cx pixels
 * @property {number} cy pixels
 * @property {"pinhole"|"radtan"|"equidistant"} model
 * @property {number[]} coefficients k1 k2 p1 p2 k3 k4 k5 k6, fewer or none; or four of equidistant
 */

/** @typedef {[number, number]} Pair */

const ITERATIONS = 30;
const CONVERGED = 1e-12;

/** @typedef {[number, number, number, number, number, number, number, number]} Eight */

/** @param {Camera} camera @returns {Eight} its coefficients, those that its model has not as 0 */
export function coefficientsOf(camera) {
  const [k1 = 0, k2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0, k7 = 0, k8 = 0] = camera.coefficients;
  return [k1, k2, k3, k4, k5, k6, k7, k8];
}

/** @param {number[]} k @param {number} x @param {number} y @returns {Pair} */
function radtan(k, x, y) {
  const [k1, k2, p1, p2, k3, k4, k5, k6] = k;
  const r2 = x * x + y * y;
  const radial =
    (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  return [
    x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
    y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
  ];
}

/** The derivative of `radtan`, symmetric: [by x of x, mixed, by y of y]. */
function radtanSlopes(k, x, y) {
  const [k1, k2, p1, p2, k3, k4, k5, k6] = k;
  const r2 = x * x + y * y;
  const below = 1 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / below;
  const rise = k1 + r2 * (2 * k2 + r2 * 3 * k3);
  const slope = (2 * (rise - radial * (k4 + r2 * (2 * k5 + r2 * 3 * k6)))) / below;
  return [
    radial + slope * x * x + 2 * p1 * y + 6 * p2 * x,
    slope * x * y + 2 * p1 * x + 2 * p2 * y,
    radial + slope * y * y + 6 * p1 * y + 2 * p2 * x,
  ];
}

/** @param {Eight} k @param {number} angle */
function distortedAngle([k1, k2, k3, k4], angle) {
  const a2 = angle * angle;
  return angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))));
}

/** @param {Eight} k @param {number} angle */
function angleSlope([k1, k2, k3, k4], angle) {
  const a2 = angle * angle;
  return 1 + a2 * (3 * k1 + a2 * (5 * k2 + a2 * (7 * k3 + a2 * 9 * k4)));
}

/**
 * A point of the camera's frame, metres, to its pixel.
 *
 * @param {Camera} camera
 * @param {ArrayLike<number>} point three numbers
 * @returns {Pair|null} null where the lens gives it no image
 */
export function project(camera, point) {
  const [x, y, z] = [point[0], point[1], point[2]];
  const k = coefficientsOf(camera);
  let plane;
  if (camera.model === "equidistant") {
    const radius = Math.hypot(x, y);
    if (radius === 0 && z <= 0) return null;
    const scale = radius > 0 ? distortedAngle(k, Math.atan2(radius, z)) / radius : 1 / z;
    plane = [x * scale, y * scale];
  } else {
    if (z <= 0) return null;
    plane = camera.model === "radtan" ? radtan(k, x / z, y / z) : [x / z, y / z];
  }
  return [plane[0] * camera.fx + camera.cx, plane[1] * camera.fy + camera.cy];
}

/** Newton's method from the distorted point, on the branch that holds the axis. */
function withoutRadtan(k, u, v) {
  let [x, y] = [u, v];
  for (let step = 0; step < ITERATIONS; step++) {
    const [a, b, d] = radtanSlopes(k, x, y);
    const [du, dv] = radtan(k, x, y).map((one, axis) => one - [u, v][axis]);
    const determinant = a * d - b * b;
    const [dx, dy] = [(d * du - b * dv) / determinant, (a * dv - b * du) / determinant];
    [x, y] = [x - dx, y - dy];
    if (Math.abs(dx) <= CONVERGED && Math.abs(dy) <= CONVERGED) break;
  }
  const [a, b, d] = radtanSlopes(k, x, y);
  const [fu, fv] = radtan(k, x, y);
  const error = Math.max(Math.abs(fu - u), Math.abs(fv - v));
  const close = error < 1e-9 * (1 + Math.max(Math.abs(u), Math.abs(v)));
  return a > 0 && a * d - b * b > 0 && close ? [x, y] : null;
}

function undistortedAngle(k, radius) {
  const most = 0.5 * Math.PI;
  let angle = Math.min(radius, most);
  for (let step = 0; step < ITERATIONS; step++) {
    const change = (distortedAngle(k, angle) - radius) / angleSlope(k, angle);
    angle = Math.min(Math.max(angle - change, 0), most);
    if (Math.abs(change) <= CONVERGED) break;
  }
  const error = Math.abs(distortedAngle(k, angle) - radius);
  return error < 1e-9 && angle < most && angleSlope(k, angle) > 0 ? angle : null;
}

/**
 * A pixel to its ray of unit depth (z = 1) in the camera's frame.
 *
 * @param {Camera} camera
 * @param {Pair} pixel
 * @returns {[number, number, number]|null} null where no ray goes there
 */
export function unproject(camera, pixel) {
  const u = (pixel[0] - camera.cx) / camera.fx;
  const v = (pixel[1] - camera.cy) / camera.fy;
  if (camera.model === "pinhole") return [u, v, 1];
  const k = coefficientsOf(camera);
  if (camera.model === "radtan") {
    const ideal = withoutRadtan(k, u, v);
    return ideal && [ideal[0], ideal[1], 1];
  }
  const radius = Math.hypot(u, v);
  if (radius === 0) return [0, 0, 1];
  const angle = undistortedAngle(k, radius);
  if (angle === null) return null;
  const scale = Math.tan(angle) / radius;
  return [u * scale, v * scale, 1];
}

/**
 * What WebGL needs of the matrix of intrinsics: from view space (x right, y up, z back) to clip
 * space, by columns. A pixel's centre lands half a pixel from its edge.
 *
 * @param {Camera} camera
 * @param {number} near metres
 * @param {number} far metres
 * @returns {number[]} 16 numbers
 */
export function projectionMatrix(camera, near, far) {
  const { width, height, fx, fy, cx, cy } = camera;
  const depth = far - near;
  return [
    ...[(2 * fx) / width, 0, 0, 0],
    ...[0, (2 * fy) / height, 0, 0],
    ...[1 - (2 * cx + 1) / width, (2 * cy + 1) / height - 1, -(far + near) / depth, -1],
    ...[0, 0, (-2 * far * near) / depth, 0],
  ];
}

/**
 * How far from the axis the lens's formula holds: r² of the ideal plane (radtan), or an angle
 * (equidistant), up to where the image would fold back.
 *
 * @param {Camera} camera
 * @returns {number} infinite where it never does
 */
export function reach(camera) {
  const k = coefficientsOf(camera);
  if (camera.model === "equidistant") {
    for (let angle = 0.01; angle < Math.PI; angle += 0.01) {
      if (angleSlope(k, angle) <= 0) return angle - 0.01;
    }
    return Math.PI;
  }
  if (camera.model === "radtan") {
    const radial = [k[0], k[1], 0, 0, ...k.slice(4)];
    for (let radius = 0.01; radius < 20; radius += 0.01) {
      if (!(radtanSlopes(radial, radius, 0)[0] > 0)) return (radius - 0.01) ** 2;
    }
  }
  return Infinity;
}
