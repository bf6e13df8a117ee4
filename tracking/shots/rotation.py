"""Attitudes of a camera that stays at its place: it stands, or turns about its lens.

Corners are tracked from picture to picture and kept as directions in the world, so that nothing
drifts as long as they stay in view. Each picture's attitude is Kabsch's rotation between these
directions and where they are seen, reweighted; a corner that moves on its own loses its weight. In
pictures of a camera that is held still all are looked for from the first picture on, faint ones all
over it too, near their place: things that move before it leave that.

Source: Kabsch 1976; Holland & Welsch 1977 (reweighting, Cauchy's weight).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.native._flow import Pyramid
from motorcade.tracking.pictures import shrunk, track_corners
from motorcade.tracking.shots.linking import corners_all_over
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


def track_rotation(pictures: Iterable[GrayImage], camera: Camera, *, held: bool) -> Rotations:
    """Track the attitude of a camera that stays where it is.

    Args:
        pictures: upright grey pictures of the camera's size, in order.
        camera: that took them.
        held: it stands, on a stand or in a hand: corners that leave their place are on things that
            move, however many they are, and where it moves by less than half a pixel it rests.
    """
    tracker = _Tracker(camera, held)
    for picture in pictures:
        tracker.add(picture)
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

    def add(self, picture: GrayImage) -> None:
        small = shrunk(picture, _LONG_SIDE)
        self.scale = picture.shape[1] / small.shape[1]
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
