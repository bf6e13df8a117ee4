"""The light of a recording, from a few of its frames.

How the exposure of footage changes, told by ground that several of its images show.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motorcade.animation import Placement
from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor, Trajectory
from motorcade.render.composite import as_rgb
from motorcade.render.light.estimate import ShadedPoints, estimate_light, shaded_points
from motorcade.render.light.ground import GroundMap
from motorcade.render.light.lamps import certainty, estimated_lighting, sunlight_direction
from motorcade.render.scene import BRIGHTEST, DepthArray, ImageArray, Lighting
from motorcade.tracking.cameras.camera import Camera

ENOUGH = 500
"""Points; fewer say more about the sensor than about the light."""


def lighting_of_footage(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    height_m: float,
) -> tuple[Lighting, str] | None:
    """The light that falls on a placed character, estimated from frames with depth.

    About eight frames, spread over the recording, are enough; every one that is given is used.

    Args:
        frames: stamp in ns, image, and depth in metres or None.
        camera: pinhole, of the frames' size.
        world_T_camera: its path; frames outside its span are passed over.
        placement: of the character.
        height_m: of the placed character; surfaces two heights away count half.

    Returns:
        sun and ambient light, and what of them was assumed; or None where too few points with depth
        were seen: without depth there are no surfaces to tell light from paint by. Where surfaces
        hardly tell where light comes from, it comes from where the fixed light does.

    Raises:
        ValueError: sizes that differ, or a camera with distortion.
    """
    parts = []
    for time_ns, image, depth_m in frames:
        if depth_m is None:
            continue
        if world_T_camera.time_ns[0] <= time_ns <= world_T_camera.time_ns[-1]:
            pose = world_T_camera.motors_at(np.int64(time_ns))
            parts.append(shaded_points(as_rgb(image), depth_m, camera, pose))
    if sum(len(part.points_m) for part in parts) < ENOUGH:
        return None
    stand = placement.world_T_character
    middle = stand.apply(np.array([0.0, 0.0, 0.5 * height_m]))
    estimate = estimate_light(ShadedPoints.joined(parts), middle, 2.0 * height_m)
    assumed = sunlight_direction(placement, world_T_camera.motors)
    sure = certainty(estimate)
    summary = "light estimated from surfaces with depth"
    if sure < 1.0:
        summary += ", its direction assumed" if sure == 0.0 else ", its direction in part assumed"
    return estimated_lighting(placement, height_m, estimate, assumed), summary


POINTS, FEWEST = 400, 40
LEAST_LIGHT = 0.03
MOST = 4.0
"""A camera's exposure changes by no more than this in footage that shows the same ground."""


class ExposureMeter:
    """Exposure of one image after another, 1 for the usual one of a ground's images.

    Where an image shows too little of the ground that is flat and not overexposed, the exposure is
    held to be that of the image before.

    Args:
        ground: whose light is compared with.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.render.light import ExposureMeter
    >>> from motorcade.render.light.ground import GroundMap
    >>> none, light = np.zeros((8, 8), bool), np.full((8, 8), 0.5)
    >>> lawn = GroundMap(Motor.identity(), 0.1, light, 0 * light, none, none, 0.1, np.zeros(2))
    >>> len(ExposureMeter(lawn).points_m)
    64
    """

    def __init__(self, ground: GroundMap) -> None:
        rows, columns = np.nonzero(ground.flat & ~ground.full & (ground.light > LEAST_LIGHT))
        some = np.unique(np.linspace(0, max(len(rows) - 1, 0), POINTS).astype(int))
        some = some[: len(rows)]
        self.points_m = ground.points_m()[rows[some], columns[some]]
        self._light = ground.light[rows[some], columns[some]]
        self._last = 1.0

    def gain(self, image: ImageArray, camera: Camera, world_T_camera: Motor) -> float:
        """Light of an image (h, w) or (h, w, 3) over what it usually is, vignetting aside."""
        if not len(self.points_m):
            return self._last
        own = world_T_camera.inverse().apply(self.points_m)
        ahead = own[:, 2] > 1e-3
        if not ahead.any():
            return self._last
        x, y = np.rint(camera.project(own[ahead])).astype(np.int64).T
        inside = (x >= 0) & (y >= 0) & (x < camera.width) & (y < camera.height)
        shown = image[y[inside], x[inside]]
        grey = shown.mean(axis=1) if shown.ndim == 2 else shown
        fit = grey < BRIGHTEST
        if np.count_nonzero(fit) >= FEWEST:
            ratio = to_linear(grey[fit] / 255.0) / self._light[ahead][inside][fit]
            self._last = float(np.clip(np.median(ratio), 1.0 / MOST, MOST))
        return self._last
