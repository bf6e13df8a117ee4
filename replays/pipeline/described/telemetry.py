"""How a GoPro's camera sits on the IMU of its telemetry, and whether the images agree.

Telemetry is named by its axes: "up/down, right/left, forward/back" are stored as z, x, y, on
cameras since HERO8 as ORIN says, and `readers.gpmf` turns both to x, y, z. The lens looks along -y,
the images' right is -x, their down is -z. (Sources: gpmf-parser's README for the order; the signs
from a HERO5's own footage, so a clip is asked whether it agrees.) The lens is taken to be where the
IMU is: they are some 3 cm apart, and no maker says how.

The gyroscope tells the focal length, too, where the camera pans: a lens twice as long sees things
move twice as far.

The check: features of neighbouring frames turn as the gyroscope says. Of all 24 ways in which two
right-handed frames can be laid on each other, none may fit clearly better than the stated one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product
from typing import Literal

import cv2
import numpy as np

from motorcade.fusion.imu import ImuStream
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import FrameSequence
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import track_corners

GOPRO_IMU_R_CAMERA = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])
_PAIRS = 24
_FEATURES, _FEWEST, _APART_PX = 200, 20, 12.0
_ROUNDS = 5
_LEAST_RATE_RAD_S = 0.02
_FEWEST_PAIRS = 6
_ALIKE, _AS_GOOD, _BETTER = 0.7, 0.05, 0.3
_LEAST_PAN_RAD_S, _FOCAL_ROUNDS = 0.05, 6
_ALIKE_FOCAL, _WORST_SIGMA = 0.9, 0.05

Verdict = Literal["agree", "contradict", "do not tell"]


@dataclass(frozen=True)
class AxesCheck:
    """Whether images and gyroscope agree on how the camera sits.

    Fields:
        verdict: what the images say of it.
        likeness: of both rates, as stated: their correlation about zero, 1 where they are alike.
        best: the same, of the best of all ways.

    >>> from motorcade.replays.pipeline.described.telemetry import AxesCheck
    >>> AxesCheck("agree", 0.97, 0.97).verdict
    'agree'
    """

    verdict: Verdict
    likeness: float
    best: float


def check_axes(turns: SeenTurns, camera: Camera, imu_R_camera: FloatArray) -> AxesCheck:
    """Ask pairs of neighbouring frames whether they turned as the gyroscope says.

    Breaks down where near things pass by: that the camera moves counts as turning here.
    """
    seen, stated_rad_s = turns.seen_rad_s(camera), turns.rate_rad_s
    known = np.isfinite(seen).all(axis=-1)
    seen, stated_rad_s = seen[known], stated_rad_s[known]
    sizes = float(np.linalg.norm(seen) * np.linalg.norm(stated_rad_s))
    if (
        len(seen) < _FEWEST_PAIRS
        or np.sqrt((stated_rad_s**2).sum(axis=-1).mean()) < _LEAST_RATE_RAD_S
    ):
        return AxesCheck("do not tell", 0.0, 0.0)
    likeness = {
        way.tobytes(): float(((seen @ way.T) * stated_rad_s).sum()) / max(sizes, 1e-12)
        for way in _ways()
    }
    stated, best = likeness[(np.rint(imu_R_camera) + 0.0).tobytes()], max(likeness.values())
    if stated >= _ALIKE and best - stated <= _AS_GOOD:
        return AxesCheck("agree", stated, best)
    against = best >= _ALIKE and best - stated >= _BETTER
    return AxesCheck("contradict" if against else "do not tell", stated, best)


def _ways() -> list[FloatArray]:
    """All rotations ``(3, 3)`` that lay axes on axes."""
    ways = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        way = np.zeros((3, 3))
        way[range(3), order] = signs
        if np.linalg.det(way) > 0.0:
            ways.append(way + 0.0)
    return ways


@dataclass(frozen=True, eq=False)
class SeenTurns:
    """Features of pairs of neighbouring frames, and how fast the IMU turned between them.

    Fields:
        before, after: px ``(n, 2)`` of each pair.
        seconds: ``(p,)`` between the two.
        rate_rad_s: ``(p, 3)`` mean angular rate, in the IMU's frame.
    """

    before: tuple[FloatArray, ...]
    after: tuple[FloatArray, ...]
    seconds: FloatArray
    rate_rad_s: FloatArray

    def seen_rad_s(self, camera: Camera) -> FloatArray:
        """Rates ``(p, 3)`` in the camera's frame, as if it only turned; NaN where none fits."""
        turns = [_turn(*pair, camera) for pair in zip(self.before, self.after, strict=True)]
        rates: FloatArray = np.array(turns).reshape(-1, 3) / self.seconds[:, None]
        return rates


def seen_turns(frames: FrameSequence, imu: ImuStream) -> SeenTurns:
    """Follow features between neighbouring frames at places that are spread over a recording."""
    stamps = frames.time_ns
    inside = (stamps[:-1] >= imu.time_ns[0]) & (stamps[1:] <= imu.time_ns[-1])
    rows = np.flatnonzero(inside)
    if len(rows):
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, _PAIRS).astype(int))]
    before, after, seconds, rates = [], [], [], []
    for row in map(int, rows):
        during = (imu.time_ns >= stamps[row]) & (imu.time_ns <= stamps[row + 1])
        px, there = _followed(frames[row].gray(), frames[row + 1].gray())
        if len(px) >= _FEWEST and during.any():
            before.append(px)
            after.append(there)
            seconds.append(1e-9 * float(stamps[row + 1] - stamps[row]))
            rates.append(imu.angular_rate_rad_s[during].mean(axis=0))
    rate = np.array(rates).reshape(-1, 3)
    return SeenTurns(tuple(before), tuple(after), np.array(seconds), rate)


def _followed(before: GrayImage, after: GrayImage) -> tuple[FloatArray, FloatArray]:
    """Features ``(n, 2)`` of one image, and where they are in the other."""
    corners = cv2.goodFeaturesToTrack(before, _FEATURES, 0.01, _APART_PX)
    if corners is None:
        return np.zeros((0, 2)), np.zeros((0, 2))
    px = corners.reshape(-1, 2).astype(np.float64)
    there, kept = track_corners(before, after, px, px)
    return px[kept], there[kept]


def _turn(before: FloatArray, after: FloatArray, camera: Camera) -> FloatArray:
    """The camera's rotation vector ``(3,)`` between two images, as if it only turned."""
    first, second = camera.bearings(before), camera.bearings(after)
    known = np.isfinite(first).all(axis=-1) & np.isfinite(second).all(axis=-1)
    if np.count_nonzero(known) < _FEWEST:
        return np.full(3, np.nan)
    middle = 0.5 * (first + second)[known]
    # A point that stands still moves by -(turn x bearing) in the camera's frame.
    rows = np.stack([np.cross(axis, middle) for axis in np.eye(3)], axis=-1)
    moved, weight, turn = (first - second)[known], np.ones(len(middle)), np.zeros(3)
    for _ in range(_ROUNDS):
        weighed = rows * weight[:, None, None]
        turn = np.linalg.lstsq(
            np.einsum("nij,nik->jk", weighed, rows), np.einsum("nij,ni->j", weighed, moved)
        )[0]
        off = np.linalg.norm(rows @ turn - moved, axis=-1)
        weight = 1.0 / np.maximum(off, np.median(off) + 1e-9)
    return np.asarray(turn)


@dataclass(frozen=True)
class TurnedFocal:
    """A focal length by what the images and the gyroscope say of the same turns.

    Fields:
        camera: square pixels, centre in the middle, no distortion.
        sigma: relative standard deviation of its focal length.
        pairs: of frames that were compared.
    """

    camera: Camera
    sigma: float
    pairs: int


def camera_by_turning(turns: SeenTurns, size: tuple[int, int]) -> TurnedFocal | None:
    """The focal length with which the images pan and tilt as fast as a GoPro's gyroscope says.

    None where the camera hardly pans, or both disagree. Near things that pass by, and a lens that
    bends, are errors here, and not told.
    """
    rates = turns.rate_rad_s @ GOPRO_IMU_R_CAMERA
    rates_seen = rates[:, :2]
    if (
        len(rates_seen) < _FEWEST_PAIRS
        or np.sqrt((rates_seen**2).sum(axis=-1).mean()) < _LEAST_PAN_RAD_S
    ):
        return None
    focal = 0.6 * max(size)
    middle = 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)
    for _ in range(_FOCAL_ROUNDS):
        camera = Camera(*size, focal, focal, *middle)
        seen = turns.seen_rad_s(camera)[:, :2]
        known = np.isfinite(seen).all(axis=-1)
        if np.count_nonzero(known) < _FEWEST_PAIRS:
            return None
        seen, truth = seen[known], rates_seen[known]
        ratio = float((seen * truth).sum() / (truth * truth).sum())
        if not 0.2 < ratio < 5.0:
            return None
        focal *= ratio
    likeness = float((seen * truth).sum() / (np.linalg.norm(seen) * np.linalg.norm(truth)))
    off = seen - ratio * truth
    sigma = float(np.sqrt((off**2).sum() / off.size / (truth**2).sum()))
    if likeness < _ALIKE_FOCAL or sigma > _WORST_SIGMA:
        return None
    return TurnedFocal(Camera(*size, focal, focal, *middle), sigma, len(truth))
