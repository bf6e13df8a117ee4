"""Starting a map from two views: which model explains them, and whether it is reliable.

A scene with depth fits an essential matrix, a flat one a homography; both are fitted (MAGSAC) and
scored alike. Where a rotation alone explains the motion of the corners there is no parallax, and
nothing is started: the scale-free map that would follow is arbitrary.

Sources: Hartley & Zisserman 2003, ch. 9 and 13; scores: Mur-Artal et al. 2015; MAGSAC++: Barath
et al. 2020.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera, project
from motorcade.tracking.images import track_corners
from motorcade.tracking.slam.features import Corners, SlamImage, find_corners
from motorcade.tracking.slam.geometry import (
    BoolArray,
    flattened,
    parallax_rad,
    pose_from_opencv,
    triangulate,
)

FEWEST_CORNERS = 80
_FEWEST_POINTS = 50
_LEAST_FLOW_PX = 4.0  # what must remain of the motion when the rotation is taken out
_PARALLAX_RAD = np.deg2rad(1.0)
_THRESHOLD_PX = 1.0
_HOMOGRAPHY_SHARE = 0.45
_CHI2_POINT, _CHI2_LINE = 5.99, 3.84
_GOOD_PX = 2.0
_RIVAL = 0.8  # a second solution with so much of the best one's support leaves it undecided
_KEPT_SHARE = 0.25
_MOST_PENDING = 600


@dataclass(frozen=True, eq=False)
class TwoViews:
    """The second view from the first, for a baseline of length 1.

    Args:
        first_T_second: where the second camera stands.
        good: ``(n,)`` inliers that have parallax.
        model: "essential" or "homography".
    """

    first_T_second: Motor
    good: BoolArray
    model: str


@dataclass(frozen=True, eq=False)
class TwoViewStart:
    """Two images from which a map can start, and the corners tracked between them.

    Args:
        first, second: the images; corners: those of the first that were tracked to the second.
        second_px: ``(n, 2)`` where they are there; views: the geometry.
        between: of each image in between its stamp, rows of `corners` and pixels.
    """

    first: SlamImage
    second: SlamImage
    corners: Corners
    second_px: FloatArray
    views: TwoViews
    between: tuple[tuple[int, BoolArray, FloatArray], ...]


def flow_beyond_rotation_px(first_px: FloatArray, px: FloatArray, camera: Camera) -> float:
    """Median motion of corners that the best rotation leaves over, pixels.

    Rotation by Kabsch's method, reweighted so that a minority of corners cannot turn it.
    """
    rays = []
    for pixels in (first_px, px):
        rays.append(camera.bearings(pixels))
    weight = np.ones(len(px))
    left = np.zeros(len(px))
    for _ in range(8):
        u, _, vt = np.linalg.svd((rays[1] * weight[:, None]).T @ rays[0])
        turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
        seen = camera.project(rays[0] @ turn.T)
        left = np.nan_to_num(np.linalg.norm(seen - px, axis=1), nan=np.inf)
        weight = 1.0 / (1.0 + left**2)
    return float(np.median(left))


def two_views(first_px: FloatArray, px: FloatArray, camera: Camera) -> TwoViews | None:
    """Relative pose of two views from corners ``(n, 2)`` in both; None where it is undecided.

    Refused: a flow that rotation explains, too few inliers, too little parallax, or two
    solutions that explain the views almost equally well.
    """
    flat_first, flat = flattened(camera, first_px), flattened(camera, px)
    near = np.isfinite(flat_first[:, 0]) & np.isfinite(flat[:, 0])
    if np.count_nonzero(near) < FEWEST_CORNERS:
        return None
    flat_first, flat = flat_first[near], flat[near]
    essential, _ = cv2.findEssentialMat(
        flat_first,
        flat,
        np.array(camera.matrix),
        method=cv2.USAC_MAGSAC,
        prob=0.9999,
        threshold=_THRESHOLD_PX,
    )
    homography, _ = cv2.findHomography(flat_first, flat, cv2.USAC_MAGSAC, 2.0 * _THRESHOLD_PX)
    plane, deep = 0.0, 0.0
    if homography is not None:
        plane = _homography_score(homography, flat_first, flat)
    if essential is not None and essential.shape == (3, 3):
        deep = _essential_score(essential, flat_first, flat, camera.matrix)
    if plane + deep <= 0.0:
        return None
    model = "homography" if plane / (plane + deep) > _HOMOGRAPHY_SHARE else "essential"
    poses = _from_homography if model == "homography" else _from_essential
    matrix = homography if model == "homography" else essential
    supported = [
        (_support(pose, first_px, px, camera), pose) for pose in poses(matrix, camera.matrix)
    ]
    if not supported:  # a homography of nothing but a turn
        return None
    supported.sort(key=lambda support: -int(np.count_nonzero(support[0])))
    good, pose = supported[0]
    count = int(np.count_nonzero(good))
    rival = int(np.count_nonzero(supported[1][0])) if len(supported) > 1 else 0
    if count < max(_FEWEST_POINTS, 0.5 * len(px)) or rival > _RIVAL * count:
        return None
    return TwoViews(pose, good, model)


def _homography_score(homography: FloatArray, first_px: FloatArray, px: FloatArray) -> float:
    forth = _squared(_mapped(homography, first_px), px)
    back = _squared(_mapped(np.linalg.inv(homography).astype(np.float64), px), first_px)
    return sum(float(np.maximum(_CHI2_POINT - d, 0.0).sum()) for d in (forth, back))


def _essential_score(
    essential: FloatArray, first_px: FloatArray, px: FloatArray, matrix: FloatArray
) -> float:
    to_plane = np.linalg.inv(matrix)
    fundamental = to_plane.T @ essential @ to_plane
    a, b = (np.concatenate([pixels, np.ones((len(px), 1))], axis=1) for pixels in (first_px, px))
    score = 0.0
    for lines, points in ((a @ fundamental.T, b), (b @ fundamental, a)):
        squared = np.sum(lines * points, axis=1) ** 2 / np.sum(lines[:, :2] ** 2, axis=1)
        score += float(np.where(squared < _CHI2_LINE, _CHI2_POINT - squared, 0.0).sum())
    return score


def _mapped(homography: FloatArray, px: FloatArray) -> FloatArray:
    there = px @ homography[:, :2].T + homography[:, 2]
    mapped: FloatArray = there[:, :2] / there[:, 2:]
    return mapped


def _squared(a: FloatArray, b: FloatArray) -> FloatArray:
    squared: FloatArray = np.sum((a - b) ** 2, axis=1)
    return squared


def _from_essential(essential: FloatArray, _: FloatArray) -> Iterator[Motor]:
    turned, other, shift = cv2.decomposeEssentialMat(essential)
    for turn in (turned, other):
        for sign in (1.0, -1.0):
            yield pose_from_opencv(turn, sign * np.ravel(shift)).inverse()


def _from_homography(homography: FloatArray, matrix: FloatArray) -> Iterator[Motor]:
    _, turns, shifts, _ = cv2.decomposeHomographyMat(homography, np.array(matrix))
    for turn, shift in zip(turns, shifts, strict=True):
        length = float(np.linalg.norm(shift))
        if length > 1e-6:
            yield pose_from_opencv(turn, np.ravel(shift) / length).inverse()


def _support(pose: Motor, first_px: FloatArray, px: FloatArray, camera: Camera) -> BoolArray:
    """Corners whose point lies before both cameras, reprojects well and has parallax."""
    first = Motor.identity()
    points = triangulate(first, pose, first_px, px, camera)
    near, _ = project(camera, first, points)  # behind a camera none is seen
    other, _ = project(camera, pose, points)
    error = np.sqrt(np.maximum(_squared(near, first_px), _squared(other, px)))
    good = np.nan_to_num(error, nan=np.inf) < _GOOD_PX
    parallax = parallax_rad(first, pose, points)
    wide = good & (parallax > _PARALLAX_RAD)
    if np.count_nonzero(wide) < _FEWEST_POINTS:
        return np.zeros(len(px), dtype=np.bool_)
    return good


class TwoViewInitialiser:
    """Tracks the corners of a first image until a later one gives a map.

    Args:
        camera: the pinhole; features: corners to track.
    """

    def __init__(self, camera: Camera, features: int) -> None:
        self._camera = camera
        self._features = features
        self._first: SlamImage | None = None

    def feed(self, image: SlamImage) -> TwoViewStart | None:
        """Take the next image; a `TwoViewStart` once one is found."""
        if self._first is None or not self._tracked(image):
            self._restart(image)
            return None
        rows = self._rows
        first_px = self._corners.px[rows]
        flow = flow_beyond_rotation_px(first_px, self._px, self._camera)
        views = None
        if flow >= _LEAST_FLOW_PX:
            views = two_views(first_px, self._px, self._camera)
        if views is None:
            kept = np.zeros(len(self._corners), dtype=np.bool_)
            kept[rows] = True
            self._between.append((image.time_ns, kept, self._px))
            del self._between[:-_MOST_PENDING]
            return None
        corners = Corners(first_px, self._corners.descriptors[rows])
        position = np.cumsum(np.isin(np.arange(len(self._corners)), rows)) - 1
        between = []
        for stamp, kept, px in self._between:
            still = np.isin(np.flatnonzero(kept), rows)
            mask = np.zeros(len(rows), dtype=np.bool_)
            mask[position[np.flatnonzero(kept)[still]]] = True
            between.append((stamp, mask, px[still]))
        return TwoViewStart(self._first, image, corners, self._px, views, tuple(between))

    def _restart(self, image: SlamImage) -> None:
        self._corners = find_corners(image.gray, self._features)
        self._first = image if len(self._corners) >= FEWEST_CORNERS else None
        self._last, self._px = image, self._corners.px
        self._rows = np.arange(len(self._corners))
        self._motion = np.zeros_like(self._px)
        self._between: list[tuple[int, BoolArray, FloatArray]] = []

    def _tracked(self, image: SlamImage) -> bool:
        """Track the corners one image on; False where too few remain."""
        guess = self._px + self._motion
        px, tracked = track_corners(self._last.pyramid, image.pyramid, self._px, guess)
        self._motion = (px - self._px)[tracked]
        self._rows, self._px, self._last = self._rows[tracked], px[tracked], image
        return len(self._rows) >= max(FEWEST_CORNERS, _KEPT_SHARE * len(self._corners))
