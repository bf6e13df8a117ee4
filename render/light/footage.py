"""The light of a recording, from a few of its frames."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motorcade.animation import Placement
from motorcade.ga import Trajectory
from motorcade.render.composite import as_rgb
from motorcade.render.light.estimate import ShadedPoints, estimate_light, shaded_points
from motorcade.render.light.lamps import certainty, estimated_lighting, sunlight_direction
from motorcade.render.scene import DepthArray, ImageArray, Lighting
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
        frames: stamp in ns, picture, and depth in metres or None.
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
    for time_ns, picture, depth_m in frames:
        if depth_m is None:
            continue
        if world_T_camera.time_ns[0] <= time_ns <= world_T_camera.time_ns[-1]:
            pose = world_T_camera.motors_at(np.int64(time_ns))
            parts.append(shaded_points(as_rgb(picture), depth_m, camera, pose))
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
