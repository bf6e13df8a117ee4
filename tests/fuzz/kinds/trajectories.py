"""Trajectories of every format: read, written, resampled, smoothed, evaluated, simulated along.

Paths are smooth, still, spinning or wild, with gaps from a second to thirty years; their files are
mutated as text. What is read must come back as it was written, and all that is computed from it
must be finite or refused.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np

from motorcade.fusion import smooth
from motorcade.fusion.imu.noise import ADIS16448
from motorcade.fusion.imu.simulate import simulate_imu
from motorcade.fusion.metrics import Align, Delta, Plane, Relation, evaluate_matched, match
from motorcade.fusion.metrics.poses.pose_error import DeltaUnit
from motorcade.fusion.smoothing.methods import METHODS
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.fuzz.mutations import mutated, one_of
from tests.fuzz.own import ended
from tests.fuzz.runner import Feed

__all__ = ["STEPS_S", "prepare", "smooth_path"]

FORMATS = ("tum", "euroc", "kitti")
STEPS_S = (1.0, 60.0, 3600.0, 86_400.0, 30 * 86_400.0, 30 * 365.25 * 86_400.0)
REPRESENTATIONS = ("motor", "quaternion", "dual_quaternion", "rotor", "euler", "euler_best")
NUMBERS = [b"0", b"-0.0", b"1e308", b"nan", b"9e8", b"-1", b"1", b"0.999", b"1.01", b"5e-324"]


def smooth_path(count: int, step_s: float) -> Trajectory:
    """A path that turns and moves, from stamp 0."""
    t = step_s * np.arange(count)
    turn = np.stack([0.3 * np.sin(2 * t), 0.2 * np.cos(t), 0.4 * np.sin(t)], axis=-1)
    place = np.stack([np.sin(t), np.cos(1.5 * t), 0.2 * t], axis=-1)
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)
    return Trajectory(np.rint(1e9 * t).astype(np.int64), poses)


def prepare(folder: Path) -> Feed:
    """Files of every format, read and used."""

    def feed(rng: np.random.Generator) -> str:
        fmt = one_of(FORMATS, rng)
        path = folder / f"path.{fmt}"
        given = _path(rng)
        try:
            write_trajectory(given, path, fmt)
        except ValueError:
            return "refused"
        kind = rng.random()
        if kind < 0.7:
            path.write_bytes(_broken(path.read_bytes(), rng))
        named = None if kind > 0.95 else fmt
        rate = float(one_of([10.0, 1e-6, 1e6, 30.0], rng)) if fmt == "kitti" else None

        def used() -> None:
            read = read_trajectory(path, named, rate_hz=rate)
            _finite("poses", read.poses.coefficients)
            if kind >= 0.7 and fmt != "kitti" and not np.array_equal(read.time_ns, given.time_ns):
                raise AssertionError("stamps did not come back as they were written")
            one_of(USES, rng)(read, rng, folder)

        return ended(used)

    return feed


def _path(rng: np.random.Generator) -> Trajectory:
    """A path of any kind."""
    count = int(one_of([1, 2, 3, 5, 20, 60], rng))
    steps = np.full(count, float(one_of([1e-9, 1e-3, 0.05, 1.0], rng)))
    if rng.random() < 0.4:
        steps[rng.integers(0, count, 2)] = one_of(STEPS_S, rng)
    if rng.random() < 0.2:
        steps *= rng.uniform(0.2, 1.8, count)
    time_ns = int(one_of([0, 0, 1_403_715_273 * 10**9, -(10**17)], rng))
    stamps = time_ns + np.cumsum(np.maximum(np.rint(1e9 * steps), 1.0).astype(np.int64))
    made = smooth_path(count, 0.05).motors
    kind = rng.random()
    if kind < 0.15:
        made = Motor.random(rng, (count,))
    elif kind < 0.25:
        made = Motor.identity((count,))
    elif kind < 0.35:
        made = Motor.from_translation(rng.uniform(-1e9, 1e9, (count, 3)))
    elif kind < 0.45:
        turns = np.pi * np.arange(count)[:, None] * [0.0, 0.0, 1.0]
        made = Motor.from_rotor_translation(Rotor.from_rotation_vector(turns), np.zeros(3))
    return Trajectory(stamps, made)


def _broken(data: bytes, rng: np.random.Generator) -> bytes:
    """A file with a fault: bytes, words, or a number in place of another."""
    if rng.random() < 0.4:
        return mutated("", data, rng)
    lines = data.split(b"\n")
    at = int(rng.integers(len(lines)))
    separator = b"," if b"," in lines[at] else b" "
    words = lines[at].split(separator)
    words[int(rng.integers(len(words)))] = one_of(NUMBERS, rng)
    lines[at] = separator.join(words)
    if rng.random() < 0.2:
        lines.insert(at, lines[int(rng.integers(len(lines)))])
    return b"\n".join(lines)


def _finite(what: str, values: Any) -> None:
    if not np.isfinite(np.asarray(values, dtype=np.float64)).all():
        raise AssertionError(f"{what}: not finite")


def _written(path: Trajectory, rng: np.random.Generator, folder: Path) -> None:
    other = folder / "again.tum"
    write_trajectory(path, other)
    back = read_trajectory(other)
    if not np.array_equal(back.time_ns, path.time_ns):
        raise AssertionError("stamps changed by writing")
    there, here = back.motors.translation_m, path.motors.translation_m
    np.testing.assert_allclose(there, here, rtol=1e-9, atol=1e-15 * np.abs(here).max())


def _saved(path: Trajectory, rng: np.random.Generator, folder: Path) -> None:
    path.save(folder / "path.npz")
    back = Trajectory.load(folder / "path.npz")
    if not np.array_equal(back.poses.coefficients, path.poses.coefficients):
        raise AssertionError("poses changed by saving")


def _resampled(path: Trajectory, rng: np.random.Generator, folder: Path) -> None:
    _finite("resampled", path.at_rate(float(one_of([0.1, 10.0, 1e3], rng))).poses.coefficients)


def _smoothed(path: Trajectory, rng: np.random.Generator, folder: Path) -> None:
    made = smooth(path, one_of(["auto", *METHODS], rng), one_of(REPRESENTATIONS, rng))
    _finite("smoothed", made.poses.coefficients)


def _evaluated(path: Trajectory, rng: np.random.Generator, folder: Path) -> None:
    nudged = path.transformed_by(right=Motor.from_translation(1e-3 * rng.standard_normal(3)))
    span_s = path.time_ns[[0, -1]] * 1e-9
    matched = match(
        nudged,
        path,
        one_of(get_args(Align), rng),
        max_difference_s=float(one_of([0.0, 0.01, 1e3], rng)),
        offset_s=float(one_of([0.0, 0.0, -0.01, 1e-9, 1e9], rng)),
        start_s=one_of([None, None, float(rng.uniform(*span_s))], rng),
        end_s=one_of([None, None, float(rng.uniform(*span_s))], rng),
        interpolate=bool(rng.integers(2)),
        n_to_align=one_of([None, None, 3], rng),
        plane=one_of([None, *get_args(Plane)], rng),
    )
    delta = Delta(float(one_of([1, 3], rng)), one_of(get_args(DeltaUnit), rng), rng.random() < 0.5)
    found = evaluate_matched(
        matched,
        delta=delta,
        relations=one_of([(), get_args(Relation)], rng),
        drift_lengths_m=one_of([(), (0.5, 100.0)], rng),
    )
    for name, value in found.as_dict().items():
        if isinstance(value, float) and not np.isfinite(value):
            raise AssertionError(f"{name}: {value}")


def _simulated(path: Trajectory, rng: np.random.Generator, folder: Path) -> None:
    made = simulate_imu(path, float(one_of([50.0, 200.0], rng)), ADIS16448, rng)
    _finite("specific force", made.stream.specific_force_m_s2)


Use = Callable[[Trajectory, np.random.Generator, Path], None]
USES: list[Use] = [_written, _saved, _resampled, _smoothed, _smoothed, _evaluated, _simulated]
