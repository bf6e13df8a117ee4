"""What a comparison runs: motions, degradations, methods, representations, and cells of them.

A cell is a motion, a degradation and a seed: the true motion is sampled, degraded once, and every
method smooths the same poses in every representation. Parameters are chosen on other seeds than
those that are judged; both lists are part of the plan and of the results.

A method that refuses or fails leaves a row that says why; the others go on. What a cell gives
depends on nothing but its fields and the code, so cells can be computed anywhere and kept.
"""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from motorcade.fusion.motions.degradations import (
    Degradation,
    DroppedFrames,
    Gaussian,
    InTurn,
    Latency,
    Outliers,
    PlanarFlips,
    Quantised,
    StampJitter,
)
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES, REPRESENTATIONS, smooth
from motorcade.fusion.smoothing.representations import BEST_EULER
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.ga.names import did_you_mean
from motorcade.replays.comparison.evaluator import METRICS, PathEvaluator, RecordedMotion, truth_of

SEEDS = 6
"""Test seeds of the standard plan. What a mean over motions leaves open is the choice of motions
far more than the noise; more seeds would hardly narrow its interval."""

_MODERATE = Gaussian(0.005, float(np.deg2rad(0.5)), 0.005)
_OUTLIERS = Outliers(0.05, 0.1, 0.2)

COMPARED = tuple(
    name
    for representation in REPRESENTATIONS
    for name in (
        (BEST_EULER, representation) if representation == "euler_unwrapped" else (representation,)
    )
)
"""Representations of the standard plan: each of `REPRESENTATIONS`, and Euler angles of the order
that stays farthest from its gimbal lock."""

OWN = "own"
"""What stands for a representation where `auto` takes the one that it finds best, its default."""

DEGRADATIONS: Mapping[str, Degradation] = MappingProxyType(
    {
        "gaussian": _MODERATE,
        "gaussian_strong": Gaussian(0.02, float(np.deg2rad(2.0)), 0.02),
        "outliers": InTurn((_MODERATE, _OUTLIERS)),
        "outliers_and_flips": InTurn((PlanarFlips(0.02, 10.0), _MODERATE, _OUTLIERS)),
        "quantised": Quantised(0.01, float(np.deg2rad(1.0))),
        "stamp_jitter": InTurn((_MODERATE, StampJitter(0.005))),
        "dropped_frames": InTurn((_MODERATE, DroppedFrames(0.2, 3.0))),
        "latency": InTurn((_MODERATE, Latency(0.05, 0.003))),
    }
)
"""The standard degradations. Noise of the scale strikes similarities only; see `degradation_named`.
The delay's spread is a tenth of an interval: poses that overtake each other would be stamped a
nanosecond apart, where second differences, and so jitter, mean nothing."""


@dataclass(frozen=True)
class DegradedMotion:
    """A true motion, degraded once: draws depend on the seed and the names alone.

    Every method sees the same poses so, whatever else is run. `recorded` is of true paths of files.
    """

    motion: str
    degradation: str
    seed: int
    rate_hz: float
    duration_s: float
    recorded: RecordedMotion | None = None

    def drawn(self) -> tuple[Trajectory, PathEvaluator]:
        """The degraded poses, and the evaluator of their stamps."""
        truth = truth_of(self.motion, self.duration_s, self.recorded)
        names = (zlib.crc32(name.encode()) for name in (self.motion, self.degradation))
        drawn = np.random.default_rng([self.seed, *names])
        clean = truth.sampled(self.rate_hz, self.duration_s)
        degraded = degradation_named(self.degradation, truth.has_scale).apply(clean, drawn)
        return degraded, PathEvaluator(degraded.time_ns, truth)


@dataclass(frozen=True)
class ComparisonPlan:
    """A comparison; see the module.

    Args:
        motions: names of `MOTIONS` and of `recorded`.
        degradations: names of `DEGRADATIONS`.
        methods: names of `METHODS`.
        representations: of `REPRESENTATION_NAMES`.
        test_seeds: seeds of the cells that are judged.
        tuning_seeds: seeds on which parameters are chosen; none of them in `test_seeds`.
        rate_hz: poses a second.
        duration_s: of every motion.
        recorded: true paths from files.

    Raises:
        ValueError: an unknown name, an empty list, one that says something twice, seeds below 0,
            seeds in both lists, or a rate or duration that is not positive.
    """

    motions: tuple[str, ...]
    degradations: tuple[str, ...]
    methods: tuple[str, ...]
    representations: tuple[str, ...]
    test_seeds: tuple[int, ...]
    tuning_seeds: tuple[int, ...]
    rate_hz: float = 30.0
    duration_s: float = 12.0
    recorded: tuple[RecordedMotion, ...] = ()

    def __post_init__(self) -> None:
        files = {one.name: one for one in self.recorded}
        if len(files) < len(self.recorded) or set(files) & set(MOTIONS):
            raise ValueError(f"plan.recorded: expected names of their own, got {list(files)}")
        _check_names("motions", self.motions, {**MOTIONS, **files})
        _check_names("degradations", self.degradations, DEGRADATIONS)
        _check_names("methods", self.methods, METHODS)
        _check_names("representations", self.representations, REPRESENTATION_NAMES)
        _check_seeds("test_seeds", self.test_seeds)
        _check_seeds("tuning_seeds", self.tuning_seeds)
        both = sorted(set(self.test_seeds) & set(self.tuning_seeds))
        if both:
            raise ValueError(
                f"plan.tuning_seeds: expected other seeds than test_seeds, got {both} in both"
            )
        for name in ("rate_hz", "duration_s"):
            checked_positive(getattr(self, name), f"plan.{name}")

    def recording(self, motion: str) -> RecordedMotion | None:
        """The file of a motion; None of those with a formula."""
        return next((one for one in self.recorded if one.name == motion), None)

    def inputs(self, motion: str, degradation: str, seed: int) -> DegradedMotion:
        """What every method sees in one place with one seed."""
        known = self.recording(motion)
        return DegradedMotion(motion, degradation, seed, self.rate_hz, self.duration_s, known)

    def pairs(self) -> list[tuple[str, str]]:
        """Every method in every representation, and `auto` in its own."""
        combinations = [(one, other) for one in self.methods for other in self.representations]
        return [*combinations, ("auto", OWN)] if "auto" in self.methods else combinations

    def as_dict(self) -> dict[str, Any]:
        """All of it, ready for JSON, with what each degradation does."""
        degradations = {name: repr(DEGRADATIONS[name]) for name in self.degradations}
        return asdict(self) | {"degradation_values": degradations}


def degradation_named(name: str, similarities: bool) -> Degradation:
    """The degradation of that name; without noise of the scale where poses have none."""
    return DEGRADATIONS[name] if similarities else _rigid(DEGRADATIONS[name])


def standard(
    seeds: int = SEEDS,
    methods: Sequence[str] = (),
    representations: Sequence[str] = (),
    motions: Sequence[str] = (),
    degradations: Sequence[str] = (),
    recorded: Sequence[RecordedMotion] = (),
) -> ComparisonPlan:
    """The whole comparison, or the named parts of it, over so many test seeds, tuned on two."""
    return ComparisonPlan(
        motions=tuple(motions or (*MOTIONS, *(one.name for one in recorded))),
        degradations=tuple(degradations or DEGRADATIONS),
        methods=tuple(methods or METHODS),
        representations=tuple(representations or COMPARED),
        test_seeds=tuple(range(100, 100 + seeds)),
        tuning_seeds=(1, 2),
        recorded=tuple(recorded),
    )


def quick() -> ComparisonPlan:
    """Seconds instead of minutes: three motions, two degradations, four methods, five seeds."""
    return ComparisonPlan(
        motions=("gimbal_crossing", "walk_and_look", "zoom"),
        degradations=("gaussian", "outliers"),
        methods=("exponential", "one_euro", "rts_constant_velocity", "gaussian"),
        representations=COMPARED,
        test_seeds=(100, 101, 102, 103, 104),
        tuning_seeds=(1,),
        duration_s=6.0,
    )


def _rigid(degradation: Degradation) -> Degradation:
    if isinstance(degradation, InTurn):
        return InTurn(tuple(_rigid(step) for step in degradation.steps))
    if isinstance(degradation, Gaussian):
        return Gaussian(degradation.sigma_m, degradation.sigma_rad)
    return degradation


def _check_names(name: str, values: tuple[str, ...], known: Collection[str]) -> None:
    if not values or len(set(values)) < len(values):
        raise ValueError(f"plan.{name}: expected one or more different names, got {values}")
    for value in values:
        if value not in known:
            advice = did_you_mean(value, known)
            raise ValueError(f"plan.{name}: expected known names, got {value!r}; {advice}")


def _check_seeds(name: str, seeds: tuple[int, ...]) -> None:
    if not seeds or len(set(seeds)) < len(seeds) or min(seeds) < 0:
        raise ValueError(f"plan.{name}: expected one or more different seeds >= 0, got {seeds}")


FOR_POSITIONS = "position."
"""Begins the name of a parameter that positions are smoothed by, where rotations have another."""
RAW = ("raw", "none")
"""Method and representation of the row that measures the poses as they come."""
# Digits that are kept: rounding of the last ones may differ from machine to machine.
_DIGITS = 9
_FARTHEST = 1e9


@dataclass(frozen=True)
class Setting:
    """A method in a representation, or `OWN`, with its parameters: pairs of name and value.

    Those of names that begin with `FOR_POSITIONS` are of positions, the others then of rotations.
    """

    method: str
    representation: str
    parameters: tuple[tuple[str, float], ...] = ()

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Smooth a trajectory so.

        Raises ValueError: what the method refuses, or a result that runs away.
        """
        parameters: dict[str, Any] = dict(self.parameters)
        name = None if self.representation == OWN else self.representation
        others = {
            key.removeprefix(FOR_POSITIONS): parameters.pop(key)
            for key in list(parameters)
            if key.startswith(FOR_POSITIONS)
        }
        smoothed: Trajectory = smooth(trajectory, self.method, name, **parameters)
        if others:
            moved: Trajectory = smooth(trajectory, self.method, name, **parameters | others)
            smoothed = _parts_joined(smoothed, moved)
        farthest = float(np.max(np.abs(smoothed.poses.coefficients)))
        if not farthest < _FARTHEST:
            raise ValueError(f"the result runs away, to coefficients of {farthest:.3g}")
        return smoothed


def _parts_joined(turned: Trajectory, moved: Trajectory) -> Trajectory:
    """The rotations of one path, and positions and scales of another."""
    rigid = Motor.from_rotor_translation(turned.poses.rotor, moved.poses.translation_m)
    poses: Motor | Similarity = rigid
    if isinstance(moved.poses, Similarity):
        poses = Similarity.from_motor_scale(rigid, moved.poses.scale)
    return Trajectory(turned.time_ns, poses, turned.parent, turned.child)


@dataclass(frozen=True)
class MeasuredRow:
    """What one method in one representation made of a cell.

    Fields:
        values: by name of `METRICS`; None where one cannot be told. Empty where the method failed.
        failure: why there is no result, else "".
    """

    method: str
    representation: str
    values: dict[str, float | None]
    failure: str = ""


@dataclass(frozen=True)
class ComparisonCell:
    """What is to be smoothed and measured; rows are the raw poses' and one for each setting."""

    inputs: DegradedMotion
    settings: tuple[Setting, ...]


def run_cell(cell: ComparisonCell) -> tuple[MeasuredRow, ...]:
    """The rows of a cell."""
    return tuple(measured_rows(*cell.inputs.drawn(), cell.settings))


def measured_rows(
    degraded: Trajectory, evaluator: PathEvaluator, settings: Iterable[Setting]
) -> list[MeasuredRow]:
    """Smooth by every setting and measure, raw poses first."""
    names, paths, failed = [RAW], [degraded], []
    for setting in settings:
        name = (setting.method, setting.representation)
        try:
            smoothed = setting.smooth(degraded)
        except Exception as error:  # one failing method never ends the others; its row says why
            failed.append(MeasuredRow(*name, {}, why(error)))
            continue
        names.append(name)
        paths.append(smoothed)
    values = evaluator.measure(paths)
    return [
        MeasuredRow(*name, _rounded_metrics(row)) for name, row in zip(names, values, strict=True)
    ] + failed


def why(error: Exception) -> str:
    """An error as one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"[:300]


def _rounded_metrics(values: FloatArray) -> dict[str, float | None]:
    return {
        name: float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
        for name, value in zip(METRICS, values, strict=True)
    }
