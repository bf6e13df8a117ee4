// Panes of the stage: the film, the view through the camera, and the world from outside.
//
// One WebGL canvas lies over them all, and each pane is a part of it; images lie under it.

import { Matrix4, OrbitControls, PerspectiveCamera, Vector3, WebGLRenderer } from "studio/vendor.js";
import { projectionMatrix } from "studio/camera.js";
import { drawGrey } from "studio/figure.js";
import { lookThrough } from "studio/lens.js";

/** What a pane can show, as people call it. */
export const KINDS = { film: "Film", camera: "Through the camera", world: "From outside" };

// From three.js's camera axes to OpenCV's, and back.
const TURNED = new Matrix4().makeScale(1, -1, -1);
const FINEST = 2;

/** What is told where a browser draws nothing in 3-D. */
export const NO_WEBGL =
  "This browser offers no WebGL 2, so nothing can be drawn in 3-D. Switch on hardware acceleration in its settings, or open this page in another browser.";

/**
 * Who draws in 3-D; by software, smooth edges would cost a third of the time.
 *
 * @returns {"nobody"|"software"|"card"}
 */
export function drawnBy() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return "nobody";
  let name = gl.getParameter(gl.RENDERER);
  if (name === "WebKit WebGL") {
    const told = gl.getExtension("WEBGL_debug_renderer_info");
    name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  }
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name) ? "software" : "card";
}

/** The canvas that all panes share; without WebGL there is none, and films alone are shown. */
export class Stage {
  /** @param {HTMLElement} element that holds the panes */
  constructor(element) {
    this.element = element;
    /** @type {WebGLRenderer|null} */
    this.renderer = null;
    const by = drawnBy();
    if (by !== "nobody") this.#canvas(by === "card");
    /** @type {Pane[]} */
    this.panes = [];
    new ResizeObserver(() => this.fit()).observe(element);
  }

  #canvas(antialias) {
    this.renderer = new WebGLRenderer({ antialias, alpha: true });
    this.renderer.autoClear = false;
    const canvas = this.renderer.domElement;
    canvas.className = "drawn";
    canvas.ariaHidden = "true";
    this.element.append(canvas);
  }

  /** Follow the size of the page. */
  fit() {
    const { clientWidth: width, clientHeight: height } = this.element;
    this.renderer?.setPixelRatio(Math.min(devicePixelRatio, FINEST));
    this.renderer?.setSize(width, height, false);
    for (const pane of this.panes) pane.fit();
    this.draw();
  }

  draw() {
    const { renderer } = this;
    if (renderer) {
      const { width, height } = renderer.domElement;
      if (!width || !height) return;
      renderer.setScissorTest(false);
      renderer.clear();
      renderer.setScissorTest(true);
    }
    for (const pane of this.panes) pane.draw(renderer, this.element);
  }
}

export class Pane {
  /**
   * @param {HTMLElement} element
   * @param {"film"|"camera"|"world"} kind
   * @param {import("./world.js").World} world
   * @param {import("./film.js").Film|null} film what lies under the view
   * @param {() => number} frameNow the frame where there is no film
   */
  constructor(element, kind, world, film, frameNow) {
    this.element = element;
    this.kind = kind;
    this.world = world;
    this.film = film;
    this.frameNow = frameNow;
    this.path = world.look.drawn;
    this.camera = new PerspectiveCamera(40, 1, 0.01, 100);
    this.camera.up.copy(world.up);
    if (kind === "world") return;
    this.ground = document.createElement("canvas");
    const { width, height } = world.look.camera;
    [this.ground.width, this.ground.height] = [width, height];
    this.ground.className = "ground";
    this.ground.setAttribute("role", "img");
    this.ground.ariaLabel = `${KINDS[kind]}: ${world.look.name}`;
    element.prepend(this.ground);
    this.camera.matrixAutoUpdate = false;
  }

  /** Let the world be turned by hand, from where it is seen well at first. */
  orbit(changed) {
    const { center, radius } = this.world.bounds;
    const aside = sideOf(this.world);
    const back = radius / Math.sin(0.5 * (this.camera.fov * Math.PI) / 180);
    this.camera.position.copy(center).addScaledVector(aside, 0.78 * back);
    this.camera.near = 0.005 * radius;
    this.camera.far = 60 * radius;
    this.controls = new OrbitControls(this.camera, this.element);
    this.controls.target.copy(center);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", changed);
    this.controls.update();
    this.home = [this.camera.position.clone(), center.clone()];
  }

  /** Back to where the world is seen well. */
  goHome() {
    this.camera.position.copy(this.home[0]);
    this.controls.target.copy(this.home[1]);
    this.controls.update();
  }

  /** The frame that is shown: the film's, so that image and drawing never part. */
  get frame() {
    return this.film ? Math.max(this.film.shown, 0) : this.frameNow();
  }

  /** Where the view lies within the pane, CSS pixels: the image whole, in the middle. */
  fit() {
    const { clientWidth: wide, clientHeight: high } = this.element;
    if (this.kind === "world") {
      this.box = { x: 0, y: 0, width: wide, height: high };
      this.camera.aspect = wide / Math.max(1, high);
      this.camera.updateProjectionMatrix();
      return;
    }
    const { width, height } = this.world.look.camera;
    const scale = Math.min(wide / width, high / height);
    const size = { width: Math.round(scale * width), height: Math.round(scale * height) };
    this.box = { x: (wide - size.width) >> 1, y: (high - size.height) >> 1, ...size };
    const style = this.ground.style;
    style.left = `${this.box.x}px`;
    style.top = `${this.box.y}px`;
    style.width = `${size.width}px`;
    style.height = `${size.height}px`;
  }

  draw(renderer, stage) {
    if (!this.box || !this.box.width || !this.box.height) return;
    const { frame } = this;
    if (this.ground && this.film) this.ground.getContext("2d").drawImage(this.film.image, 0, 0);
    if (this.kind === "film" || !renderer) return;
    const outside = this.kind === "world";
    const posed = outside || this.#look(frame);
    const corner = this.element.getBoundingClientRect();
    const whole = stage.getBoundingClientRect();
    const left = corner.left - whole.left + this.box.x;
    const above = corner.top - whole.top + this.box.y;
    const below = whole.height - above - this.box.height;
    renderer.setViewport(left, below, this.box.width, this.box.height);
    renderer.setScissor(left, below, this.box.width, this.box.height);
    if (!posed) return;
    this.world.prepare(frame, this.path, outside);
    this.#choose(outside);
    renderer.clearDepth();
    renderer.render(this.world.scene, this.camera);
  }

  /** Through the camera only what stands in the footage is drawn. */
  #choose(outside) {
    const { parts, lines, hidden } = this.world;
    for (const [name, line] of lines) line.visible = outside && !hidden.has(name);
    for (const [name, part] of Object.entries(parts)) {
      const drawn = outside || name === "characters" || name === "markers";
      part.visible = drawn && !hidden.has(name);
    }
    lookThrough(outside ? null : this.world.look.camera);
    drawGrey(!outside && Boolean(this.world.look.grey));
    this.world.hiding.prepare(this.frame, outside ? null : this.camera);
  }

  /** Stand where the path has the camera at a frame. @returns {boolean} whether it has a pose */
  #look(frame) {
    const { camera, world } = this;
    if (!world.cameraAt(frame, this.path, camera.matrix)) return false;
    camera.matrix.multiply(TURNED);
    camera.matrix.decompose(camera.position, camera.quaternion, camera.scale);
    camera.matrixWorldNeedsUpdate = true;
    const [near, far] = [0.002 * world.bounds.radius, 40 * world.bounds.radius];
    camera.projectionMatrix.fromArray(projectionMatrix(world.look.camera, near, far));
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    return true;
  }
}

/** From beside the camera's way and above: where both it and what it looks at are seen. */
function sideOf(world) {
  const first = new Matrix4();
  const ahead = new Vector3(1, 0, 0);
  if (world.cameraAt(0, world.look.drawn, first)) {
    ahead.setFromMatrixColumn(first, 2);
  }
  ahead.addScaledVector(world.up, -ahead.dot(world.up));
  if (ahead.length() < 1e-3) ahead.set(1, 0.3, 0).addScaledVector(world.up, -world.up.x);
  const side = new Vector3().crossVectors(ahead.normalize(), world.up);
  return side.multiplyScalar(0.75).addScaledVector(ahead, -0.55).addScaledVector(world.up, 0.5).normalize();
}
