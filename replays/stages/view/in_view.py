"""Where on a plane a character finds room and is seen well: whole, for long, not tiny."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera

_CAMERAS, _STEPS, _INSIDE = 40, 15, 0.8
# Of the character's height: what is higher than this, and nearer than this, is in its way; so many
# points of a sensor may be wrong.
_STEP, _ROOM, _STRAYS = 0.05, 0.2, 3
_MARGIN, _LARGE_ENOUGH, _HEADLESS, _FROM_MIDDLE = 0.03, 0.2, 0.3, 0.05
# Seen from straight above, what a character is worth beside one seen from the side.
_FORESHORTENED = 0.5
# Half of a character's width, what is nearer than it by this factor hides it, of so many points.
_HALF_WIDE, _NEARER, _HIDING = 0.15, 0.95, 1000


def best_place(
    outline_m: FloatArray,
    height_m: float,
    camera: Camera,
    plane_T_camera: Motor,
    points_m: FloatArray,
    noise_m: float,
) -> tuple[float, float]:
    """The place on a plane where the character is in view best, taken over the camera's path.

    A frame counts fully where it shows the character whole and at least a fifth as tall as the
    image, less where it is smaller, only its feet are shown, or points lie before it. Of places
    that are seen alike the one nearest the plane's middle is taken. Places where something stands
    are skipped, unless there are no others.

    Args:
        outline_m: ``(k, 2)`` convex, anticlockwise, about the origin of the plane's frame.
        height_m: of the character.
        camera: that takes the images; its distortion is left aside.
        plane_T_camera: Motor ``(N,)``, its poses in the plane's frame.
        points_m: ``(p, 3)`` seen or mapped, in the plane's frame.
        noise_m: of these.

    Returns:
        x and y in the plane's frame; its origin where no place is in view.
    """
    places = _places(outline_m)
    score = share_seen(places, height_m, camera, plane_T_camera, points_m)
    if not score.any():
        return 0.0, 0.0
    free = _free(places, height_m, points_m, noise_m)
    if np.any(score[free] > 0.0):
        score = np.where(free, score, -np.inf)
    reach = np.linalg.norm(outline_m, axis=1).max()
    score = score - _FROM_MIDDLE * np.linalg.norm(places, axis=1) / reach
    x, y = places[int(np.argmax(score))]
    return float(x), float(y)


def share_seen(
    places_m: FloatArray,
    height_m: float,
    camera: Camera,
    plane_T_camera: Motor,
    points_m: FloatArray,
) -> FloatArray:
    """How well ``(n,)`` a character on places ``(n, 2)`` is seen over the path: 1 in all frames.

    Arguments as of `best_place`.
    """
    poses, pinhole = _some(plane_T_camera).inverse(), camera.undistorted()
    ends = np.stack(
        [np.pad(places_m, ((0, 0), (0, 1)), constant_values=z) for z in (0.0, height_m)]
    )
    seen = poses.reshape(-1, 1, 1).apply(ends[None])
    ahead = np.all(seen[..., 2] > 0.25 * height_m, axis=1)
    pixels = pinhole.project(np.where(ahead[:, None, :, None], seen, [0.0, 0.0, 1.0]))
    inside = _inside(pixels, pinhole) & ahead[:, None]
    tall = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=-1)
    # From above a character is short, and as near as it is.
    wide = height_m * pinhole.fy / np.maximum(seen[:, 0, :, 2], 0.25 * height_m)
    share = np.maximum(tall, _FORESHORTENED * wide) / pinhole.height
    worth = np.minimum(share / _LARGE_ENOUGH, 1.0) * inside[:, 0]
    worth = np.where(inside[:, 1], worth, _HEADLESS * worth)
    near = poses.reshape(-1, 1).apply(points_m[None, :: 1 + len(points_m) // _HIDING])
    for k, points in enumerate(near):
        points = points[points[:, 2] > 0.0]
        worth[k] *= _unhidden(pinhole.project(points), points[:, 2], pixels[k], seen[k, ..., 2])
    return np.asarray(worth.mean(axis=0))


def tall_at(place: tuple[float, float], camera: Camera, plane_T_camera: Motor) -> float:
    """The height of a character that reaches over a fifth of the image, upwards or aside.

    From above it looks short: there it is taller, but by no more than twice.
    """
    camera_T_plane = _some(plane_T_camera).inverse()
    feet, up = camera_T_plane.apply([*place, 0.0]), camera_T_plane.rotor.apply([0.0, 0.0, 1.0])
    feet, up = feet[feet[:, 2] > 0.0], up[feet[:, 2] > 0.0]
    if not len(feet):
        return 0.0
    # How the image of one with its height grows, in images, if it were as far as its feet.
    size = np.array([camera.width / camera.fx, camera.height / camera.fy])
    reach = np.abs(up[:, :2] - up[:, 2:] * feet[:, :2] / feet[:, 2:]) / size
    reach = np.maximum(reach.max(axis=1), _FORESHORTENED / size.min())
    return float(_LARGE_ENOUGH * np.median(feet[:, 2] / reach))


def _some(plane_T_camera: Motor) -> Motor:
    """A few poses, evenly over the path."""
    last = len(plane_T_camera) - 1
    return plane_T_camera[np.unique(np.linspace(0, last, _CAMERAS).round().astype(int))]


def _unhidden(
    px: FloatArray, depth_m: FloatArray, ends_px: FloatArray, ends_m: FloatArray
) -> FloatArray:
    """1 for each place ``(n,)`` that hardly any point is before, less where things hide it.

    Pixels ``(p, 2)`` and depths ``(p,)`` are of points ahead, ``(2, n, 2)`` and ``(2, n)`` of feet
    and heads.
    """
    low, high = ends_px.min(axis=0), ends_px.max(axis=0)
    aside = _HALF_WIDE * (high[:, 1] - low[:, 1])
    nearer = depth_m[:, None] < _NEARER * ends_m.min(axis=0)
    nearer &= (px[:, 1, None] > low[:, 1]) & (px[:, 1, None] < high[:, 1])
    nearer &= np.abs(px[:, 0, None] - ends_px[0, :, 0]) < aside
    return np.where(np.count_nonzero(nearer, axis=0) > _STRAYS, _HEADLESS, 1.0)


def _places(outline_m: FloatArray) -> FloatArray:
    """A grid over the plane, the origin and what lies well within its outline."""
    low, high = outline_m.min(axis=0), outline_m.max(axis=0)
    grid = np.stack(np.meshgrid(*np.linspace(low, high, _STEPS).T), axis=-1).reshape(-1, 2)
    corner, along = _INSIDE * outline_m, np.roll(outline_m, -1, axis=0) - outline_m
    away = grid[:, None] - corner
    within = np.all(along[:, 0] * away[..., 1] - along[:, 1] * away[..., 0] >= 0.0, axis=1)
    return np.concatenate([np.zeros((1, 2)), grid[within]])


def _free(
    places: FloatArray, height_m: float, points_m: FloatArray, noise_m: float
) -> NDArray[np.bool_]:
    """Whether hardly a point stands up from the plane where the character would."""
    lowest = max(_STEP * height_m, 4.0 * noise_m)
    up = points_m[(points_m[:, 2] > lowest) & (points_m[:, 2] < height_m)]
    near = np.array(
        [np.count_nonzero(np.hypot(*(up[:, :2] - one).T) < _ROOM * height_m) for one in places]
    )
    return near <= _STRAYS


def _inside(pixels: FloatArray, camera: Camera) -> NDArray[np.bool_]:
    size = np.array([camera.width, camera.height])
    edge = _MARGIN * size
    return np.asarray(np.all((pixels > edge) & (pixels < size - edge), axis=-1))
