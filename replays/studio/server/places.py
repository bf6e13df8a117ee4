"""Where on an anchor there is room for one more."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.authoring import Scene, SceneAnchor
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.replays.studio.server.filmed import Filmed

MOST_PLACES = 400
"""That are looked at; where all are taken, the one that is farthest from others is given."""


def free_place_m(
    scene: Scene,
    on: str,
    anchor: SceneAnchor,
    middle_m: ArrayLike,
    height_m: float,
    filmed: Filmed,
    frame: int,
    beside: str | None = None,
) -> FloatArray:
    """A place ``(2,)`` of an anchor's plane where nothing stands, near a middle.

    One that is in view at a frame comes first.

    Args:
        scene: that there is so far.
        on: the anchor's name in it, if it is there already.
        anchor: what it is.
        middle_m: ``(2,)`` the first choice.
        height_m: of who will stand there; as wide as that is the room.
        filmed: the footage.
        frame: on show.
        beside: an object that is not in its own way.

    Raises:
        ValueError: an anchor that is not in this recording.
    """
    poses = filmed.world_T_anchor(anchor)
    world_T_plane = poses[min(frame, poses.shape[0] - 1)]
    places: FloatArray = np.asarray(middle_m) + 0.45 * height_m * _spiral(MOST_PLACES)
    apart = np.minimum(_apart(places, _taken_m(scene, on, beside)), 0.4 * height_m)
    seen = _in_view(places, height_m, world_T_plane, filmed, frame)
    found: FloatArray = places[np.lexsort((np.arange(MOST_PLACES), ~seen, -apart))[0]]
    return found


def room_m(
    scene: Scene, name: str, on: str, anchor: SceneAnchor, filmed: Filmed, frame: int
) -> FloatArray:
    """A free place ``(2,)`` of an anchor for an object that is in the scene; as `free_place_m`."""
    ground = filmed.ground(anchor)
    tall = scene.part(name).height_m or ground.height_m
    return free_place_m(scene, on, anchor, ground.position_m, tall, filmed, frame, name)


def _taken_m(scene: Scene, on: str, beside: str | None) -> FloatArray:
    """Where things stand on an anchor, ``(N, 2)`` in its plane: all along a walk and keyframes."""
    taken = [np.zeros((0, 2))]
    for name, parent in scene.parents.items():
        if parent == on and name != beside:
            part = scene.part(name)
            times = [0.0, *(one.time_s for one in part.keyframes)]
            poses = [scene.pose_at(name, one).as_motor_scale()[0].translation_m for one in times]
            taken.append(np.array(poses)[:, :2])
            if part.walk is not None:
                taken.append(np.asarray(part.walk.path_m, dtype=np.float64).reshape(-1, 2))
    return np.concatenate(taken)


def _spiral(count: int) -> FloatArray:
    """Places ``(count, 2)`` for one after another, so that none stands in another."""
    number = np.arange(count)
    made: FloatArray = np.sqrt(number)[:, None] * np.exp(2.4j * number)[:, None].view(np.float64)
    return made


def _apart(places: FloatArray, taken: FloatArray) -> FloatArray:
    """How far each place is from the nearest that is taken."""
    ways = np.linalg.norm(places[:, None] - taken[None], axis=-1)
    found: FloatArray = ways.min(axis=1, initial=np.inf)
    return found


def _in_view(
    places: FloatArray, height_m: float, world_T_plane: Similarity, filmed: Filmed, frame: int
) -> np.ndarray:
    """Whether one of a height that stands there is in the picture from head to foot."""
    camera = filmed.camera
    world_T_camera: Motor = filmed.world_T_camera[frame]
    seen = np.ones(len(places), dtype=bool)
    for up_m in (0.0, height_m):
        points = world_T_plane.apply(np.insert(places, 2, up_m, axis=1))
        points = world_T_camera.inverse().apply(points)
        pixels = camera.project(points)
        inside = (pixels > 0.0) & (pixels < [camera.width - 1, camera.height - 1])
        seen &= inside.all(axis=-1) & (points[:, 2] > 0.0)
    return seen
