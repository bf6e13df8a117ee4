"""Recorded motions under sixteen kinds of noise, and what a smoother leaves of error and jitter.

A cell is a motion under a noise: 30 s of it at 20 Hz, or 240 poses of a slow robot at 1 to 8 Hz.
Errors are judged pose by pose, not at the stamps: where stamps are wrong, the pose is that of its
own image nevertheless.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.fusion.metrics.jitter import accelerations
from motorcade.fusion.motions import MOTIONS, handheld
from motorcade.fusion.motions.degradations import (
    DroppedFrames,
    Gaussian,
    Outliers,
    PlanarFlips,
    Quantised,
)
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.trajectories import read_trajectory

__all__ = [
    "FURTHER",
    "JUDGED",
    "NOISES",
    "OUTLIERS",
    "SLOW",
    "TUNED_ON",
    "Cell",
    "Left",
    "cell",
    "cells",
    "errors",
    "left",
    "motion",
]

RATE_HZ, DURATION_S = 20.0, 30.0
JUDGED = {
    "V1_03": "imu/flights/V1_03_difficult.csv",
    "V2_02": "imu/flights/V2_02_medium.csv",
    "MH_05": "imu/flights/MH_05_difficult.csv",
}
"""Flights of EuRoC that smoothers are judged on."""
TUNED_ON = ("V1_02", "handheld", "walk_and_look", "stop_and_go", "tumble")
"""Motions that constants were chosen on: a flight and synthetic ones."""
FURTHER = ("V1_01", "gimbal_hover", "screw", "distant_circle", "fast_spin")
"""A second group that no constant was chosen on: another flight and synthetic motions."""
SLOW = {f"robot at {rate_hz:g} Hz": rate_hz for rate_hz in (1.0, 2.0, 4.0, 8.0)}
"""Rates in Hz of a third group: the same robot's motion, from hardly resolved to well."""
_SLOW_POSES, _SLOW_BAND_HZ = 240, (0.01, 0.2)
_FLIGHTS = {
    **JUDGED,
    "V1_01": "replays/euroc_V1_01/V1_01_easy_original.txt",
    "V1_02": "imu/V1_02_medium.csv",
}
# Seconds after take-off begins in all of the flights.
_START_S = 30.0

Noise = Callable[[Trajectory, np.random.Generator], tuple[Trajectory, IntArray]]
"""Gives a degraded path, and the rows of the true one that are left."""


def _perturbed(true: Trajectory, shift_m: FloatArray, turn_rad: FloatArray) -> Trajectory:
    pose = true.motors
    rotor = (Motor.from_rotor_translation(pose.rotor, np.zeros(3)) @ _turns(turn_rad)).rotor
    moved = Motor.from_rotor_translation(rotor, pose.translation_m + shift_m)
    return Trajectory(true.time_ns, moved, true.parent, true.child)


def _turns(turn_rad: FloatArray) -> Motor:
    return Motor.from_twist(np.concatenate([turn_rad, np.zeros_like(turn_rad)], axis=-1))


def _all(path: Trajectory) -> tuple[Trajectory, IntArray]:
    return path, np.arange(len(path))


def _white(mm: float, deg: float) -> Noise:
    return lambda true, rng: _all(Gaussian(1e-3 * mm, np.deg2rad(deg)).apply(true, rng))


def _autoregressive(true: Trajectory, rng: np.random.Generator) -> tuple[Trajectory, IntArray]:
    """Each error keeps 0.8 of the one before; 5 mm and 0.5° an axis."""
    error = rng.standard_normal((len(true), 6))
    for k in range(1, len(true)):
        error[k] = 0.8 * error[k - 1] + 0.6 * error[k]
    return _all(_perturbed(true, 0.005 * error[:, :3], np.deg2rad(0.5) * error[:, 3:]))


def _heavy_tailed(true: Trajectory, rng: np.random.Generator) -> tuple[Trajectory, IntArray]:
    error = rng.standard_t(3.0, (len(true), 6)) / np.sqrt(3.0)
    return _all(_perturbed(true, 0.005 * error[:, :3], np.deg2rad(0.5) * error[:, 3:]))


def _over_white(wrong: Callable[..., Trajectory]) -> Noise:
    def apply(true: Trajectory, rng: np.random.Generator) -> tuple[Trajectory, IntArray]:
        noisy, _ = _white(5.0, 0.5)(true, rng)
        return _all(wrong(noisy, rng))

    return apply


def _bursts(noisy: Trajectory, rng: np.random.Generator) -> Trajectory:
    """Runs of eight poses that are off together, 5 % of all."""
    shift, turn = np.zeros((2, len(noisy), 3))
    for start in rng.choice(len(noisy) - 8, max(1, len(noisy) // 160), replace=False):
        shift[start : start + 8] = 0.2 * rng.standard_normal(3)
        turn[start : start + 8] = 0.3 * rng.standard_normal(3)
    return _perturbed(noisy, shift, turn)


def _dropped(true: Trajectory, rng: np.random.Generator) -> tuple[Trajectory, IntArray]:
    noisy, _ = _white(5.0, 0.5)(true, rng)
    left = DroppedFrames(0.3, 3.0).apply(noisy, rng)
    return left, np.searchsorted(true.time_ns, left.time_ns)


def _along_the_view(true: Trajectory, rng: np.random.Generator) -> tuple[Trajectory, IntArray]:
    """20 mm in depth, 1 mm across, 0.2°."""
    error = rng.standard_normal((len(true), 6)) * [1e-3, 1e-3, 0.02, *[np.deg2rad(0.2)] * 3]
    return _all(_perturbed(true, true.motors.rotor.apply(error[:, :3]), error[:, 3:]))


def _changing(true: Trajectory, rng: np.random.Generator) -> tuple[Trajectory, IntArray]:
    """From 1 mm and 0.1° to 20 mm and 2° and back, three times."""
    phase = np.linspace(0.0, 3.0 * 2.0 * np.pi, len(true))
    size = 20.0 ** (0.5 - 0.5 * np.cos(phase))
    error = size[:, None] * rng.standard_normal((len(true), 6))
    return _all(_perturbed(true, 0.001 * error[:, :3], np.deg2rad(0.1) * error[:, 3:]))


def _stepped(noisy: Trajectory, rng: np.random.Generator) -> Trajectory:
    """The map is corrected four times: 30 mm and 1° for good, to and fro."""
    level = np.zeros((len(noisy), 6))
    for k, start in enumerate(np.sort(rng.choice(len(noisy), 4, replace=False))):
        level[start:] = rng.standard_normal(6) if k % 2 == 0 else 0.0
    return _perturbed(noisy, 0.03 * level[:, :3], np.deg2rad(1.0) * level[:, 3:])


def _restamped(noisy: Trajectory, rng: np.random.Generator) -> Trajectory:
    """Stamps off by up to 35 % of the interval."""
    interval_ns = float(np.median(np.diff(noisy.time_ns)))
    off = (0.35 * interval_ns * rng.uniform(-1.0, 1.0, len(noisy))).astype(np.int64)
    return Trajectory(noisy.time_ns + off, noisy.poses, noisy.parent, noisy.child)


NOISES: dict[str, Noise] = {
    "white 1 mm, 0.1°": _white(1.0, 0.1),
    "white 5 mm, 0.5°": _white(5.0, 0.5),
    "white 20 mm, 2°": _white(20.0, 2.0),
    "position alone 10 mm": _white(10.0, 0.0),
    "rotation-heavy 1 mm, 2°": _white(1.0, 2.0),
    "autoregressive": _autoregressive,
    "Student's t": _heavy_tailed,
    "outliers 5 %": _over_white(Outliers(0.05, 0.3, 0.5).apply),
    "bursts of outliers": _over_white(_bursts),
    "flips": _over_white(PlanarFlips(0.05).apply),
    "dropouts": _dropped,
    "quantised 10 mm, 1°": lambda true, rng: _all(
        Quantised(0.01, float(np.deg2rad(1.0))).apply(true, rng)
    ),
    "jittered stamps": _over_white(_restamped),
    "along the view": _along_the_view,
    "changing in size": _changing,
    "steps of level": _over_white(_stepped),
}
"""By name."""

OUTLIERS = ("Student's t", "outliers 5 %", "bursts of outliers", "flips", "steps of level")
"""Noises in which some poses are farther off than the others."""


@dataclass(frozen=True, eq=False)
class Cell:
    """A measured path, and what is true of its poses at their true stamps."""

    motion: str
    noise: str
    raw: Trajectory
    true: Trajectory


def motion(name: str, folder: Path, duration_s: float = DURATION_S) -> Trajectory | None:
    """A true motion at 20 Hz, slow ones at their own rate; None where its recording is missing."""
    if name in SLOW:
        robot = handheld(np.random.default_rng(1), 1.0, 0.5, _SLOW_BAND_HZ)
        return robot.sampled(SLOW[name], (_SLOW_POSES - 1) / SLOW[name])
    count = int(RATE_HZ * duration_s)
    if name not in _FLIGHTS:
        return MOTIONS[name].sampled(RATE_HZ, (count - 1) / RATE_HZ)
    file = folder / _FLIGHTS[name]
    if not file.exists():
        return None
    flown = read_trajectory(file)
    start_ns = int(flown.time_ns[0]) + int(1e9 * _START_S)
    return flown.resampled(start_ns + np.arange(count) * int(1e9 / RATE_HZ))


def cell(name: str, noise: str, true: Trajectory, seed: int = 0) -> Cell:
    """The motion of that name under a noise; every cell draws its own numbers."""
    rng = np.random.default_rng([seed, *map(ord, name), *map(ord, noise)])
    raw, rows = NOISES[noise](true, rng)
    return Cell(name, noise, raw, true[rows])


def cells(names: Iterator[str] | tuple[str, ...], folder: Path, seed: int = 0) -> Iterator[Cell]:
    """Every noise on motions of those names, as far as their recordings are there."""
    for name in names:
        true = motion(name, folder)
        if true is not None:
            yield from (cell(name, noise, true, seed) for noise in NOISES)


@dataclass(frozen=True)
class Left:
    """What smoothing leaves, as shares of the raw path's: 1 is nothing gained.

    Fields:
        shares: of position error, rotation error, linear and angular jitter; NaN where the raw path
            has none of it.
        added_deg: RMS of the rotation error where the raw path has none, else 0.
    """

    shares: tuple[float, float, float, float]
    added_deg: float

    @property
    def e2(self) -> float:
        """Mean of both errors."""
        return float(np.nanmean(self.shares[:2]))

    @property
    def s4(self) -> float:
        """Mean of both errors and both jitters."""
        return float(np.nanmean(self.shares))


# Errors in m and rad below these are none: the recordings' own are larger.
_NONE = np.array([1e-5, np.deg2rad(1e-3)])


def errors(path: Trajectory, true: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Wrong rotation vectors in the body, and wrong positions in the world, each ``(N, 3)``."""
    turn = (true.motors.rotor.inverse() @ path.motors.rotor).as_rotation_vector()
    return turn, path.motors.translation_m - true.motors.translation_m


def left(smoothed: Trajectory, of: Cell) -> Left:
    """Errors and jitter of a smoothed path beside the raw one's."""
    ours, raw = (_figures(path, of.true) for path in (smoothed, of.raw))
    there = np.tile(raw[:2] > _NONE, 2)
    shares = np.where(there, ours / np.where(there, raw, 1.0), np.nan).tolist()
    added = 0.0 if there[1] else float(np.rad2deg(ours[1]))
    return Left((shares[0], shares[1], shares[2], shares[3]), added)


def _figures(path: Trajectory, true: Trajectory) -> FloatArray:
    """RMS errors in m and rad, RMS of wrong acceleration in m/s² and rad/s²."""
    turn, shift = errors(path, true)
    both = (accelerations(true.time_s, one) for one in (path.motors, true.motors))
    wrong = (found - expected for found, expected in zip(*both, strict=True))
    return np.array([np.sqrt(np.mean(np.sum(e**2, axis=-1))) for e in (shift, turn, *wrong)])
