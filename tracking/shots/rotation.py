"""Attitudes of a camera that stays at its place: it stands, or turns about its lens.

Corners are tracked from image to image and kept as directions in the world, so that nothing
drifts as long as they stay in view. Each image's attitude is Kabsch's rotation between these
directions and where they are seen, reweighted; a corner that moves on its own loses its weight. In
images of a camera that is held still all are looked for from the first image on, faint ones all
over it too, near their place: things that move before it leave that.

Source: Kabsch 1976; Holland & Welsch 1977 (reweighting, Cauchy's weight).

Images far apart are linked: corners of one are looked for in the other, from the shift that
correlation of the whole images suggests, and count where a homography or the neighbourhood
agrees; or the images, laid on each other by that shift, correlate by themselves (blur of a fast
pan leaves no corners). Grey levels are made comparable first: a flash or a fade changes level and
contrast, not structure.

Sources: Lucas & Kanade 1981; Kuglin & Hines 1975 (phase correlation).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import shrunk, track_corners
from motorcade.tracking.native._flow import Pyramid
from motorcade.tracking.shots.camera_motion import REST_PX, Rest
from motorcade.tracking.slam.features import find_corners

_LONG_SIDE = 800
_CORNERS, _FEWEST, _KEPT = 300, 8, 0.7
_OFF_PX = 1.0
_LOST_PX = 12.0
_EVERY = 10
_HELD, _PRIOR = 0.015, 0.2
_STILL_PX = 0.5


@dataclass(frozen=True, eq=False)
class Rotations:
    """Attitudes of N frames.

    Fields:
        first_R_camera: ``(N, 3, 3)``, the first frame's axes being the world's.
        known: ``(N,)`` rows of the frames that they are of; others could not be tracked.
        frame, ray, px: corners of every tenth frame: its row, their directions ``(n, 3)`` in the
            world, and where they were seen ``(n, 2)``.
        slip_px: ``(N,)`` median distance of the corners from where the attitude has them.
    """

    first_R_camera: FloatArray
    known: IntArray
    frame: IntArray
    ray: FloatArray
    px: FloatArray
    slip_px: FloatArray


def track_rotation(images: Iterable[GrayImage], camera: Camera, *, held: bool) -> Rotations:
    """Track the attitude of a camera that stays where it is.

    Args:
        images: upright grey images of the camera's size, in order.
        camera: that took them.
        held: it stands, on a stand or in a hand: corners that leave their place are on things that
            move, however many they are, and where it moves by less than half a pixel it rests.
    """
    tracker = _Tracker(camera, held)
    for image in images:
        tracker.add(image)
    return tracker.result()


class _Tracker:
    def __init__(self, camera: Camera, held: bool) -> None:
        self.camera, self.held = camera, held
        self.count = 0
        self.scale = 1.0
        self._turn = np.eye(3)  # world_R_camera
        self._step = np.eye(3)
        self._px, self._rays = np.zeros((0, 2)), np.zeros((0, 3))
        self._before: Pyramid | None = None  # of a held camera: the first
        self._first_px, self._first_rays = self._px, self._rays
        self._known: list[int] = []
        self._turns: list[FloatArray] = []
        self._slips: list[float] = []
        self._seen: list[tuple[int, FloatArray, FloatArray]] = []

    def add(self, image: GrayImage) -> None:
        small = shrunk(image, _LONG_SIDE)
        self.scale = image.shape[1] / small.shape[1]
        pyramid = Pyramid(small)
        row, self.count = self.count, self.count + 1
        if self.held and self._before is not None:
            guess = self._expected(self._turn, self._first_px, self._first_rays)
            there, tracked = track_corners(self._before, pyramid, self._first_px, guess)
            far = np.linalg.norm(there - self._first_px, axis=-1) > _HELD * max(small.shape)
            tracked &= ~far
            self._px, self._rays = there[tracked], self._first_rays[tracked]
        elif self._before is not None and len(self._px):
            guess = self._expected(self._turn @ self._step, self._px, self._rays)
            there, tracked = track_corners(self._before, pyramid, self._px, guess, border_px=4.0)
            self._px, self._rays = there[tracked], self._rays[tracked]
        slip = self._fit() if row else 0.0
        if slip is not None:
            self._known.append(row)
            self._turns.append(self._turn)
            self._slips.append(slip)
            if row % _EVERY == 0 and len(self._px):
                left = self._left(self._turn)
                rows = left < 3.0 * _OFF_PX
                self._seen.append((row, self._rays[rows], self._full(self._px[rows])))
        if not row and self.held:
            self._first_px = corners_all_over(small)
            self._first_rays = self.camera.bearings(self._full(self._first_px))
        elif len(self._px) < _KEPT * _CORNERS and not self.held:
            self._find_more(small)
        if not (row and self.held):
            self._before = pyramid

    def _left(self, turn: FloatArray) -> FloatArray:
        """How far each corner lies from where an attitude has it ``(n,)``, small pixels."""
        apart = self._expected(turn, self._px, self._rays) - self._px
        return np.asarray(np.linalg.norm(apart, axis=-1))

    def _expected(self, turn: FloatArray, otherwise: FloatArray, rays: FloatArray) -> FloatArray:
        """Where the directions are seen in that attitude, small pixels."""
        px = self.camera.project(rays @ turn, allow_nan=True)
        small = (px + 0.5) / self.scale - 0.5
        return np.where(np.isfinite(small), small, otherwise)

    def _full(self, px: FloatArray) -> FloatArray:
        return np.asarray((px + 0.5) * self.scale - 0.5)

    def _fit(self) -> float | None:
        """The attitude by the corners; None where too few follow it."""
        if len(self._px) < _FEWEST:
            return 0.0 if self.held else None
        seen = self.camera.bearings(self._full(self._px))
        turn = self._turn if self.held else self._turn @ self._step
        left = self._left(turn)
        weight = 1.0 / (1.0 + (left / _OFF_PX) ** 2) if self.held else np.ones(len(left))
        # Where few corners tell it, a held camera rests.
        resting = _PRIOR * self._first_rays.T @ self._first_rays if self.held else np.zeros((3, 3))
        for _ in range(8):
            u, _, vt = np.linalg.svd((self._rays * weight[:, None]).T @ seen + resting)
            turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
            left = self._left(turn)
            weight = 1.0 / (1.0 + (left / _OFF_PX) ** 2)
        if np.count_nonzero(left < 3.0 * _OFF_PX) < _FEWEST:
            return 0.0 if self.held else None
        self._step = np.eye(3) if self.held else self._turn.T @ turn
        self._turn = turn
        kept = left < _LOST_PX
        self._px, self._rays = self._px[kept], self._rays[kept]
        return float(np.median(left[left < 3.0 * _OFF_PX])) * self.scale

    def _find_more(self, small: GrayImage) -> None:
        corners = find_corners(small, _CORNERS, self._px).px
        rays = self.camera.bearings(self._full(corners)) @ self._turn.T
        known = np.isfinite(rays).all(axis=-1)
        self._px = np.concatenate([self._px, corners[known]])
        self._rays = np.concatenate([self._rays, rays[known]])

    def result(self) -> Rotations:
        turns = np.array(self._turns)
        angle = np.arccos(np.clip((np.trace(turns, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
        if self.held and angle.max() * self.camera.fx < _STILL_PX * self.scale:
            turns = np.broadcast_to(np.eye(3), turns.shape).copy()
        frames = [np.full(len(px), row) for row, _, px in self._seen]
        rays = [rays for _, rays, _ in self._seen]
        pixels = [px for _, _, px in self._seen]
        return Rotations(
            turns,
            np.array(self._known),
            np.concatenate([np.zeros(0, np.int64), *frames]),
            np.concatenate([np.zeros((0, 3)), *rays]),
            np.concatenate([np.zeros((0, 2)), *pixels]),
            np.array(self._slips),
        )


MOST_CORNERS = 160
FEWEST_CORNERS = 12
_FOUND_SHARE, _AGREED_SHARE = 0.3, 0.6
_AGREES_PX = 3.0
_LEAST_OVERLAP, _LEAST_CORRELATION = 0.3, 0.55
_BLUR_PX, _DETAIL_PX = 1.5, 10.0
_LEAST_CONTRAST = 1.0
_CELLS, _HALF_PX, _REACH_PX = 14, 7, 9
_SURE, _UNLIKE, _FAINT, _BORDER = 0.8, 0.5, 2.5, 0.2
_BLOCKS, _FEWEST_BLOCKS, _TEXTURE = (16, 12), 20, 3.0
_BLOCK_ALIKE, _ALIKE_SHARE = 0.7, 0.3
"""Of blocks of two scenes one in twenty is alike by chance."""


def corners_in(preview: GrayImage) -> FloatArray:
    """Corners ``(n, 2)`` of a small image, spread over it; fewer where it is plain."""
    corners = cv2.goodFeaturesToTrack(preview, MOST_CORNERS, 0.01, 7.0, blockSize=5)
    return np.zeros((0, 2)) if corners is None else corners.reshape(-1, 2).astype(np.float64)


def levelled(preview: GrayImage) -> GrayImage:
    """The image with its levels stretched to a common mean and contrast."""
    mean, deviation = cv2.meanStdDev(preview)
    gain = 48.0 / max(float(deviation[0, 0]), _LEAST_CONTRAST)
    levels = gain * (np.arange(256) - float(mean[0, 0])) + 128.0
    return np.asarray(cv2.LUT(preview, np.clip(levels, 0, 255).astype(np.uint8)), np.uint8)


def shows_same_scene(before: GrayImage, after: GrayImage) -> bool:
    """Whether two small images ``(h, w)`` of a clip show the same scene."""
    before, after = levelled(before), levelled(after)
    details = [_details(preview) for preview in (before, after)]
    shift, correlation = _shift(*details)
    if correlation >= _LEAST_CORRELATION:
        return True
    px = corners_in(before)
    if len(px) < FEWEST_CORNERS:
        return False
    for start in (np.zeros(2), shift):
        there, tracked = track_corners(before, after, px, px + start, border_px=4.0)
        if np.count_nonzero(tracked) < max(FEWEST_CORNERS, _FOUND_SHARE * len(px)):
            continue
        _, agreed = cv2.findHomography(px[tracked], there[tracked], cv2.RANSAC, _AGREES_PX)
        if agreed is not None and np.count_nonzero(agreed) >= max(
            FEWEST_CORNERS, _AGREED_SHARE * np.count_nonzero(tracked)
        ):
            return True
    return False


def _details(preview: GrayImage) -> FloatArray:
    """Structure of middle size: what neither noise nor blur nor light changes much."""
    fine = cv2.GaussianBlur(preview.astype(np.float32), (0, 0), _BLUR_PX)
    return np.asarray(fine - cv2.GaussianBlur(fine, (0, 0), _DETAIL_PX), np.float32)


def _shift(before: FloatArray, after: FloatArray) -> tuple[FloatArray, float]:
    """By how much ``(2,)`` one image lies beside the other, and how alike they are then."""
    height, width = before.shape
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    (dx, dy), _ = cv2.phaseCorrelate(before, after, window)
    best = np.zeros(2), -1.0
    for x, y in ((0, 0), (round(dx), round(dy))):
        if (width - abs(x)) * (height - abs(y)) < _LEAST_OVERLAP * width * height:
            continue
        own = before[max(0, -y) : height - max(0, y), max(0, -x) : width - max(0, x)]
        other = after[max(0, y) : height + min(0, y), max(0, x) : width + min(0, x)]
        alike = _likeness(own, other)
        if alike > best[1]:
            best = np.array([x, y], np.float64), alike
    return best


def _likeness(own: FloatArray, other: FloatArray) -> float:
    """Share of the textured blocks that are alike in both, or the whole's correlation if more."""
    products = [
        cv2.resize(product, _BLOCKS, interpolation=cv2.INTER_AREA)
        for product in (own * other, own**2, other**2)
    ]
    whole = float(products[0].mean() / np.sqrt(products[1].mean() * products[2].mean() + 1e-6))
    textured = (products[1] > _TEXTURE**2) & (products[2] > _TEXTURE**2)
    if np.count_nonzero(textured) < _FEWEST_BLOCKS:
        return whole
    blocks = products[0][textured] / np.sqrt(products[1][textured] * products[2][textured])
    return max(whole, float(np.mean(blocks > _BLOCK_ALIKE)) / _ALIKE_SHARE * _LEAST_CORRELATION)


def corners_all_over(gray: GrayImage, cells: int = 16, border_px: int = _HALF_PX) -> FloatArray:
    """The most corner-like place ``(n, 2)`` in each cell of a grid that is not quite plain."""
    details = _details(gray)
    cornered = cv2.cornerMinEigenVal(details, 7)
    grid = (np.array_split(np.arange(border_px, n - border_px), cells) for n in gray.shape)
    corners = []
    for rows, columns in product(*grid):
        if not len(rows) or not len(columns):
            continue
        cell = cornered[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        _, _, _, (x, y) = cv2.minMaxLoc(cell)
        x, y = x + int(columns[0]), y + int(rows[0])
        patch = details[y - _HALF_PX : y + _HALF_PX + 1, x - _HALF_PX : x + _HALF_PX + 1]
        if patch.std() >= _FAINT:
            corners.append((x, y))
    return np.array(corners, np.float64).reshape(-1, 2)


def rest_of(before: GrayImage, after: GrayImage) -> Rest:
    """How much of a scene lies still between two images, faint structure included.

    The most corner-like place in each cell of a grid is looked for where it was, and around.
    """
    height, width = before.shape
    details, later = _details(before), _details(after)
    reach = _HALF_PX + _REACH_PX
    near, same = (slice(_REACH_PX - px, _REACH_PX + px + 1) for px in (int(REST_PX), 1))
    still, elsewhere, places = 0, 0, set()
    corners = corners_all_over(before, _CELLS, reach).astype(int)
    for x, y in corners.tolist():
        patch = details[y - _HALF_PX : y + _HALF_PX + 1, x - _HALF_PX : x + _HALF_PX + 1]
        around = later[y - reach : y + reach + 1, x - reach : x + reach + 1]
        alike = cv2.matchTemplate(around, patch, cv2.TM_CCOEFF_NORMED)
        best, here = float(alike.max()), float(alike[near, near].max())
        if here > _SURE and here >= best - 0.05:
            still += float(alike[same, same].max()) >= best - 0.02
            places.add((x, y))
        elif best > _SURE and here < _UNLIKE:
            elsewhere += 1
    quarters = {(2 * x > width, 2 * y > height) for x, y in places}
    beside = np.minimum(corners, [width - 1, height - 1] - corners) < _BORDER * np.array(
        [width, height]
    )
    at_border = {(x, y) for x, y in corners[beside.any(axis=-1)].tolist()}
    border = len(at_border & places) / max(len(at_border), 1)
    return Rest(still, len(places), elsewhere, len(quarters), border)
