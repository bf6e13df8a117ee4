"""Where a page draws its characters, in pixels of the footage, beside where Python has them.

Vertices are taken as the page poses and skins them; triangles as its graphics draw them, each
alone, white, and so near that it fills the view.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, read_character
from motorcade.animation.skin import Skinner
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render import Performer
from motorcade.replays.pipeline.look import gltf_bytes
from motorcade.tracking import Camera

TRIANGLES, LEAST_PX2 = 6, 0.2
"""That are looked at of a figure in a frame, and their least area."""

VERTICES = """(async () => {
  const { project } = await import("studio/camera.js");
  const pane = viewer.stage.panes[0];
  const { renderer, element } = viewer.stage;
  viewer.timeline.go(FRAME);
  pane.draw(renderer, element);
  const view = pane.camera.matrixWorld.clone().invert();
  return pane.world.figures.map((figure) => figure.vertices().map((at) => {
    const { x, y, z } = at.applyMatrix4(view);
    return project(pane.world.look.camera, [x, -y, -z]) ?? [null, null];
  }));
})()"""

MIDDLES = """(async () => {
  const pane = viewer.stage.panes[0];
  const { renderer, element } = viewer.stage;
  const { scene, figures, shadows, look } = pane.world;
  const { width, height } = look.camera;
  const gl = renderer.getContext();
  for (const shadow of shadows) shadow.material.opacity = 0;
  pane.world.hidden.add("markers");
  pane.world.hiding.enabled = false;
  const meshes = figures.flatMap((figure) => figure.meshes);
  for (const one of meshes) {
    one.material.emissive.setScalar(1);
    one.material.side = 2;
    one.visible = false;
  }
  const middles = [];
  for (const { frame, figure, triangle, at, zoom } of ASKED) {
    const [mesh] = figures[figure].meshes;
    mesh.visible = true;
    viewer.timeline.go(frame);
    mesh.geometry.setDrawRange(3 * triangle, 3);
    pane.draw(renderer, element);
    const x = (2 * (at[0] + 0.5)) / width - 1, y = 1 - (2 * (at[1] + 0.5)) / height;
    const nearer = pane.camera.projectionMatrix.clone().set(
      zoom, 0, 0, -zoom * x, 0, zoom, 0, -zoom * y, 0, 0, 1, 0, 0, 0, 0, 1);
    pane.camera.projectionMatrix.premultiply(nearer);
    renderer.clear();
    renderer.render(scene, pane.camera);
    const [wide, high] = [pane.box.width, pane.box.height];
    const pixels = new Uint8Array(4 * wide * high);
    const corner = pane.element.getBoundingClientRect(), whole = element.getBoundingClientRect();
    const left = corner.left - whole.left + pane.box.x;
    const below = whole.height - (corner.top - whole.top + pane.box.y) - high;
    gl.readPixels(left, below, wide, high, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    mesh.visible = false;
    let [sum, u, v] = [0, 0, 0];
    for (let k = 0; k < wide * high; k++) {
      const cover = pixels[4 * k + 3];
      sum += cover;
      u += cover * ((k % wide) + 0.5);
      v += cover * (Math.floor(k / wide) + 0.5);
    }
    const ndc = [(2 * u) / sum / wide - 1, (2 * v) / sum / high - 1];
    middles.push([
      ((ndc[0] / zoom + x + 1) * width) / 2 - 0.5,
      ((1 - (ndc[1] / zoom + y)) * height) / 2 - 0.5,
      sum,
    ]);
  }
  return middles;
})()"""


@dataclass(frozen=True)
class Standing:
    """Who stands before which camera: its poses ``(F,)`` along the path on show, at stamps."""

    camera: Camera
    world_T_camera: Motor
    time_ns: np.ndarray
    figures: Sequence[Performer]

    def world_m(self, who: Character, figure: Performer, frame: int) -> FloatArray:
        """Vertices of a figure in the world, by Python."""
        stamp = self.time_ns[frame]
        since_s = 1e-9 * float(stamp - self.time_ns[0])
        clip = figure.clip
        skinner, weights = Skinner(who, "linear"), clip.morph_weights(since_s)
        vertices, _ = skinner.skin(clip.at(since_s), weights)
        return figure.world_T_character(stamp).apply(vertices)

    def pixels(self, who: Character, figure: Performer, frame: int) -> FloatArray:
        """The same in the image; NaN where the lens shows none."""
        own_m = self.world_T_camera[frame].inverse().apply(self.world_m(who, figure, frame))
        return self.camera.project(own_m)

    def inside(self, pixels: FloatArray) -> np.ndarray:
        """Which ``(..., 2)`` lie in the image."""
        size = np.array([self.camera.width, self.camera.height])
        with np.errstate(invalid="ignore"):
            return np.asarray(np.all((pixels > -0.5) & (pixels < size - 0.5), axis=-1))


@dataclass(frozen=True)
class Apart:
    """How far the page is from Python, pixels, at most, and of how many in the image."""

    vertices_px: float
    vertices: int
    triangles_px: float
    triangles: int


def as_written(figure: Performer) -> Character:
    """The character with its vertices in the order of the page's file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "figure.glb")
        path.write_bytes(gltf_bytes(figure.character))
        return read_character(path)


def apart(page: Any, at: Standing, frames: Sequence[int], rng: np.random.Generator) -> Apart:
    """Compare a page, which shows the view through the camera alone, with Python."""
    written = [as_written(one) for one in at.figures]
    worst, count = 0.0, 0
    asked, wanted = [], []
    for frame in frames:
        told = page.evaluate(VERTICES.replace("FRAME", str(frame)))
        for number, (who, figure) in enumerate(zip(written, at.figures, strict=True)):
            pixels = at.pixels(who, figure, frame)
            others = np.array(told[number], dtype=np.float64)
            seen = at.inside(pixels)
            if seen.any():
                # Not `nanmax`: a vertex that the page has nowhere is wrong.
                worst = max(worst, float(np.abs(pixels - others)[seen].max()))
            count += int(seen.sum())
            for triangle, corners in _clear(at, who, pixels, rng):
                asked.append(_close_up(at.camera, corners) | {"figure": number, "frame": frame})
                asked[-1]["triangle"] = triangle
                wanted.append(corners.mean(axis=0))
    if not asked:
        return Apart(worst, count, 0.0, 0)
    found = np.array(page.evaluate(MIDDLES.replace("ASKED", str(asked))))
    assert np.all(found[:, 2] > 0.0), "a triangle is not drawn"
    off = float(np.abs(found[:, :2] - np.array(wanted)).max())
    return Apart(worst, count, off, len(asked))


def _clear(
    at: Standing, who: Character, pixels: FloatArray, rng: np.random.Generator
) -> list[tuple[int, FloatArray]]:
    """Some triangles of the page's first mesh that lie in the image, and are not too small."""
    corners = pixels[who.triangles]
    edges = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    with np.errstate(invalid="ignore"):
        clear = np.flatnonzero(np.all(at.inside(corners), axis=1) & (area > LEAST_PX2))
    some = rng.choice(clear, min(TRIANGLES, len(clear)), replace=False)
    return [(int(one), corners[one]) for one in some]


def _close_up(camera: Camera, corners: FloatArray) -> dict[str, Any]:
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = np.array([camera.width, camera.height])
    return {"at": (0.5 * (low + high)).tolist(), "zoom": float(0.7 * np.min(size / (high - low)))}
