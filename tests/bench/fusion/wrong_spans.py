"""What a span of poses that are wrong together leaves of a flight outside it.

`python -m tests.bench.fusion.wrong_spans --draws 40`: camera poses of recorded flights (20 Hz, 1 cm
and 0.5° an axis), of which 1 to 60 in a row, anywhere, are moved by one motion of 0.1 to 10 m and 1
to 180°, as by a tracker that starts on the wrong map or takes a wrong loop. Errors outside the span
stand beside those of the same filter without the wrong poses. Every third span stands at the start.
`--poses 30,60 --shift-m 0.05,0.5 --turn-deg 0.1,5` draws long spans that are moved by little.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.filter.unjudged import fuse_unjudged
from motorcade.fusion.metrics import absolute_translation_m
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.data import data_folder
from tests.bench.fusion.recorded import FLIGHTS, NOISE, SETTINGS, Flight, flight, measured

__all__ = ["SpanErrors", "WrongSpan", "span_errors", "wrong_span"]

MOST_RATIO = 1.5
"""Of the errors outside the span, what they may be times those of the right poses alone."""


@dataclass(frozen=True)
class WrongSpan:
    """Poses `first` to `first + count` are moved by one motion, about where the first of them is.

    Fields:
        first, count: of the poses.
        shift_m: ``(3,)``.
        turn_rad: ``(3,)``, axis times angle.
    """

    first: int
    count: int
    shift_m: tuple[float, float, float]
    turn_rad: tuple[float, float, float]

    def among(self, poses: int) -> NDArray[np.bool_]:
        """Which of so many poses are wrong."""
        row = np.arange(poses)
        return (row >= self.first) & (row < self.first + self.count)

    def moved(self, given: PoseMeasurements) -> PoseMeasurements:
        """The measurements with the span moved."""
        path = given.trajectory
        about = Motor.from_twist(np.r_[np.zeros(3), path.motors[self.first].translation_m])
        turn = Motor.from_twist(np.r_[self.turn_rad, np.zeros(3)])
        shift = Motor.from_twist(np.r_[np.zeros(3), self.shift_m])
        left = shift @ about @ turn @ about.inverse()
        wrong = self.among(len(path))
        whole = np.where(
            wrong[:, None], (left @ path.motors).coefficients, path.motors.coefficients
        )
        poses = Trajectory(path.time_ns, Motor(whole), path.parent, path.child)
        return PoseMeasurements(poses, given.covariance)

    @property
    def summary(self) -> str:
        """In words."""
        turn_deg = np.rad2deg(np.linalg.norm(self.turn_rad))
        shift_m = np.linalg.norm(self.shift_m)
        return f"{self.count} from {self.first} on by {shift_m:.2g} m, {turn_deg:.2g}°"


@dataclass(frozen=True)
class Drawn:
    """Least and largest of what spans are drawn from."""

    poses: tuple[float, float] = (1, 60)
    shift_m: tuple[float, float] = (0.1, 10.0)
    turn_deg: tuple[float, float] = (1.0, 180.0)


def wrong_span(poses: int, rng: np.random.Generator, of: Drawn = Drawn()) -> WrongSpan:
    """A span of so many poses: every third at the start, the others anywhere."""
    count = int(rng.integers(int(of.poses[0]), int(of.poses[1]) + 1))
    first = 0 if rng.random() < 1.0 / 3.0 else int(rng.integers(0, poses - count + 1))
    axes = rng.standard_normal((2, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    shift = np.exp(rng.uniform(*np.log(of.shift_m))) * axes[0]
    turn = np.deg2rad(np.exp(rng.uniform(*np.log(of.turn_deg)))) * axes[1]
    return WrongSpan(first, count, tuple(shift.tolist()), tuple(turn.tolist()))


@dataclass(frozen=True)
class SpanErrors:
    """Root mean square errors of the position outside the span, in metres.

    Fields:
        found_m: with the span moved.
        right_m: by the right poses alone.
        worst_m: the largest error with the span moved.
    """

    found_m: float
    right_m: float
    worst_m: float

    @property
    def ratio(self) -> float:
        """Infinite where something is no number."""
        ratio = self.found_m / self.right_m
        return ratio if np.isfinite(ratio) else np.inf


def span_errors(
    one: Flight, given: PoseMeasurements, span: WrongSpan, settings: FilterSettings, **how: Any
) -> SpanErrors:
    """Fuse a flight's poses with a span of them moved, and without it."""
    wrong = span.among(len(given))
    right = PoseMeasurements(given.trajectory[~wrong], given.covariance[~wrong])

    def error_m(measurements: PoseMeasurements) -> NDArray[np.float64]:
        fused: Fused = fuse_unjudged(
            measurements, one.imu, NOISE, Motor.identity(), right.trajectory.time_ns,
            settings=settings, state_covariances=False, **how,
        )  # fmt: skip
        stamps = fused.trajectory.time_ns
        return absolute_translation_m(fused.trajectory.motors, one.truth.motors_at(stamps))

    try:
        found = error_m(span.moved(given))
    except ValueError:
        found = np.array([np.inf])
    by_right = error_m(right)
    return SpanErrors(_rms(found), _rms(by_right), float(found.max()))


def _bounds(text: str) -> tuple[float, float]:
    least, largest = (float(number) for number in text.split(","))
    return least, largest


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def drawn(
    flights: tuple[str, ...], draws: int, seed: int, longest_s: float, of: Drawn
) -> Iterator[tuple[str, WrongSpan, Flight, PoseMeasurements]]:
    """Segments of flights, up to so long, and spans of them."""
    for name in flights:
        one = flight(name, data_folder())
        if one is None:
            print(f"{name}: not below {data_folder()}; set MOTORCADE_DATA")
            continue
        given = measured(one, seed, degraded=None)
        for draw in range(draws):
            rng = np.random.default_rng([seed, draw, *name.encode()])
            count = min(len(given), round(20.0 * rng.uniform(8.0, longest_s)))
            begin = int(rng.integers(0, len(given) - count + 1))
            part = slice(begin, begin + count)
            some = PoseMeasurements(given.trajectory[part], given.covariance[part])
            yield name, wrong_span(count, rng, of), one, some


def main() -> None:
    """Draw, fuse, print the worst."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.fusion.wrong_spans")
    parser.add_argument("--flights", default=",".join(FLIGHTS), help="by commas")
    parser.add_argument("--draws", type=int, default=20, help="of each flight")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--longest-s", type=float, default=60.0, help="segments are from 8 s on")
    parser.add_argument("--lag", type=float, default=np.inf, help="0: live")
    parser.add_argument("--upright", action="store_true", help="the vertical is not estimated")
    for name, bounds in vars(Drawn()).items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=_bounds, default=bounds)
    asked = parser.parse_args()
    of = Drawn(asked.poses, asked.shift_m, asked.turn_deg)
    settings = FilterSettings() if asked.upright else SETTINGS
    rows = []
    for name, span, one, given in drawn(
        tuple(asked.flights.split(",")), asked.draws, asked.seed, asked.longest_s, of
    ):
        errors = span_errors(one, given, span, settings, lag_s=asked.lag)
        rows.append((errors.ratio, errors, f"{name}, {len(given)} poses, {span.summary}"))
    rows.sort(key=lambda row: -row[0])
    ratios = np.array([row[0] for row in rows])
    for ratio, errors, what in rows[:15]:
        if ratio > MOST_RATIO:
            print(
                f"{ratio:9.2f}  {1e3 * errors.found_m:9.1f} mm ({1e3 * errors.worst_m:.1f})  {what}"
            )
    print(
        f"{len(rows)} spans: {np.count_nonzero(ratios > MOST_RATIO)} leave more than {MOST_RATIO} "
        f"times the errors of the right poses alone; median {np.median(ratios):.3f}, "
        f"worst {ratios.max():.2f}, {np.count_nonzero(~np.isfinite(ratios))} no numbers"
    )


if __name__ == "__main__":
    main()
