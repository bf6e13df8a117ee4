"""What other images of a still scene show before a figure, where no depth was measured."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.lens import as_pinhole
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Recording
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.sweep import MOST_VIEWS, SceneViews

# Half of a character's width in heights, and from so many views it is looked at.
_HALF_WIDE, _LOOKS = 0.15, 5


def scene_views(recording: Recording, path: Trajectory, pinhole: Camera) -> SceneViews | None:
    """Images spread over a path, as a pinhole camera takes them.

    Args:
        recording: with the camera that took it.
        path: `world_T_camera`.
        pinhole: at the same place as that camera.

    Returns:
        None where depth was measured, which tells more, or there are too few images.
    """
    frames, camera = recording.frames, recording.camera
    inside = np.flatnonzero(
        (frames.time_ns >= path.time_ns[0]) & (frames.time_ns <= path.time_ns[-1])
    )
    if camera is None or isinstance(frames, CornerFrames) or len(inside) < 3:
        return None
    if frames[int(inside[0])].read_depth is not None:
        return None
    rows = inside[np.unique(np.linspace(0, len(inside) - 1, MOST_VIEWS).round().astype(int))]
    scale = SceneViews.scale_of(pinhole)
    images = [as_pinhole(frames[int(k)].gray(), camera, pinhole, scale) for k in rows]
    stamps = frames.time_ns[rows]
    return SceneViews(pinhole, images, path.motors_at(stamps), stamps)


def share_unhidden(
    views: SceneViews, place: FloatArray, height_m: float, world_T_plane: Motor
) -> float:
    """How much of a character on a place ``(2,)`` of a plane nothing hides, over some views.

    1 where no view can tell.
    """
    ends = [-_HALF_WIDE * height_m, _HALF_WIDE * height_m]
    box = [[place[0] + x, place[1] + y, z] for x in ends for y in ends for z in (0.0, height_m)]
    hull_m = world_T_plane.apply(np.array(box))
    last = len(views.images) - 1
    hidden = []
    for k in np.unique(np.linspace(0, last, _LOOKS).round().astype(int)):
        nearer = views.nearer(views.images[k], views.world_T_camera[k], hull_m, world_T_plane)
        hidden.append(0.0 if nearer is None else nearer.hidden)
    return 1.0 - float(np.mean(hidden))
