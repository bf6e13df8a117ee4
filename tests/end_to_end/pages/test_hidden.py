"""What hides characters in the page's view through the camera: depth, prints and the ground."""

import base64
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.render.light import Prints
from motorcade.replays.pipeline.look import shown_hiding
from motorcade.replays.pipeline.packing import rows_at
from tests.end_to_end.pages.drawn_where import Standing, as_written
from tests.end_to_end.pages.made_looks import MadeLook
from tests.end_to_end.pages.test_view import CAMERAS, READY, made

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]

# Whether anything is drawn at the middle of each pixel of the footage, as bytes.
DRAWN = """(() => {
  const pane = viewer.stage.panes[0];
  const { renderer, element } = viewer.stage;
  for (const shadow of pane.world.shadows) shadow.material.opacity = 0;
  pane.world.hiding.enabled = ENABLED;
  viewer.timeline.go(FRAME);
  pane.draw(renderer, element);
  const gl = renderer.getContext(), { width: wide, height: high } = pane.box;
  const all = new Uint8Array(4 * wide * high);
  const corner = pane.element.getBoundingClientRect(), whole = element.getBoundingClientRect();
  const left = corner.left - whole.left + pane.box.x;
  const below = whole.height - (corner.top - whole.top + pane.box.y) - high;
  gl.readPixels(left, below, wide, high, gl.RGBA, gl.UNSIGNED_BYTE, all);
  const { width, height } = pane.world.look.camera;
  let text = "";
  for (let row = 0; row < height; row++) {
    const y = high - 1 - Math.floor(((row + 0.5) * high) / height);
    for (let column = 0; column < width; column++) {
      const x = Math.floor(((column + 0.5) * wide) / width);
      text += String.fromCharCode(all[4 * (y * wide + x) + 3]);
    }
  }
  return btoa(text);
})()"""


def drawn(page: Any, look: MadeLook, frame: int, enabled: bool = True) -> np.ndarray:
    """Pixels ``(height, width)`` of the footage that the page draws a figure over."""
    asked = DRAWN.replace("FRAME", str(frame)).replace("ENABLED", str(enabled).lower())
    alpha = np.frombuffer(base64.b64decode(page.evaluate(asked)), np.uint8)
    return np.asarray(alpha.reshape(look.camera.height, look.camera.width) > 127)


def hiding(look: MadeLook, depth_m: np.ndarray | None, prints: Prints | None) -> dict[str, Any]:
    """Of a recording with one image of depth for all frames, or with none."""
    frames = [SimpleNamespace(depth_m=lambda: depth_m) for _ in look.time_ns]
    recording: Any = SimpleNamespace(camera=look.camera, frames=_Frames(frames, look.time_ns))
    path = Trajectory(look.time_ns, look.world_T_camera, "world", "camera")
    return shown_hiding(recording, [look.figure], prints, rows_at(path, look.time_ns))


class _Frames(list[Any]):
    def __init__(self, frames: list[Any], time_ns: np.ndarray) -> None:
        super().__init__(frames)
        self.time_ns = time_ns


def opened_on(look: MadeLook, folder: Path, opened: Callable[..., Any]) -> Any:
    page = opened(look.write(folder / "figure.html", film=False))
    assert page.evaluate(READY)
    page.evaluate("viewer.view = 1, viewer.arrange()")
    return page


def test_nearer_depth_hides_and_farther_depth_does_not(
    tmp_path: Path, opened: Callable[..., Any]
) -> None:
    """A wall before one half of the image, one behind the other."""
    look = made(CAMERAS["radtan"], 3)
    depth_m = np.full((look.camera.height, look.camera.width), 9.0, np.float32)
    middle = look.camera.width // 2
    depth_m[:, :middle] = 0.3
    depth_m[: look.camera.height // 3, :middle] = np.nan
    look = replace(look, hiding=hiding(look, depth_m, None))
    page = opened_on(look, tmp_path, opened)
    whole, seen = drawn(page, look, 1, enabled=False), drawn(page, look, 1)
    walled = depth_m == np.float32(0.3)
    edge = cv2.dilate(walled.astype(np.uint8), np.ones((9, 9))) > cv2.erode(
        walled.astype(np.uint8), np.ones((9, 9))
    )
    assert whole[walled & ~edge].any()
    assert not seen[walled & ~edge].any()
    assert np.array_equal(seen[~walled & ~edge], whole[~walled & ~edge])
    assert page.complaints() == []


@pytest.mark.parametrize("by", ["ground", "print"])
def test_what_lies_beneath_the_ground_or_behind_a_print_is_hidden(
    by: str, tmp_path: Path, opened: Callable[..., Any]
) -> None:
    """A figure that stands in the ground to its hips, or behind a board that stands upright."""
    look = made(CAMERAS["pinhole"], 3)
    who = look.figure.character
    level = 0.25 * who.height_m
    stand = look.figure.placement.world_T_character
    sheet = None
    if by == "ground":  # the ground where it was, the figure deeper
        deeper = Motor.from_translation([0.0, 0.0, -level / look.figure.placement.scale])
        motion = Trajectory(look.time_ns[:1], deeper.reshape(1), "placement", "character")
        look = replace(look, figure=replace(look.figure, motion=motion))
    else:
        eye = look.world_T_camera[1].translation_m
        ahead = stand.apply([0.0, 0.0, level]) - eye
        at = eye + 0.5 * ahead
        upright = look.world_T_camera[1].rotor
        low = np.array([[-0.4, 0.0]])
        sheet = Prints(
            Motor.from_rotor_translation(upright, at).reshape(1), low, np.array([[0.4, 0.3]])
        )
    look = replace(look, hiding=hiding(look, None, sheet))
    page = opened_on(look, tmp_path, opened)
    whole, seen = drawn(page, look, 1, enabled=False), drawn(page, look, 1)
    standing = Standing(look.camera, look.world_T_camera, look.time_ns, [look.figure])
    pixels = standing.pixels(as_written(look.figure), look.figure, 1)
    expected = np.zeros(whole.shape, np.uint8)
    if by == "ground":
        written = as_written(look.figure)
        high = standing.world_m(written, look.figure, 1) - stand.translation_m
        above = np.all(high[written.triangles][..., 2] > 0.0, axis=1)
        for triangle in pixels[written.triangles[above]]:
            cv2.fillConvexPoly(expected, np.rint(triangle).astype(np.int32), 1)
        shown = expected > 0
    else:
        camera_T_print = look.world_T_camera[1].inverse() @ sheet.world_T_print[0]
        corners = [[-0.4, 0, 0], [0.4, 0, 0], [0.4, 0.3, 0], [-0.4, 0.3, 0]]
        around = look.camera.project(camera_T_print.apply(corners))
        cv2.fillConvexPoly(expected, np.rint(around).astype(np.int32), 1)
        shown = whole & (expected == 0)
    assert np.count_nonzero(whole & ~shown) > 500
    # Triangles through the ground, and what a sensor would not tell from it.
    off = cv2.erode((seen != shown).astype(np.uint8), np.ones((5, 5)))
    assert np.count_nonzero(off) < 0.01 * np.count_nonzero(shown)
    assert page.complaints() == []
