"""What a comparison runs: motions, degradations, methods, representations, and the seeds of both.

A cell is a motion, a degradation and a seed: the true motion is sampled, degraded once, and every
method smooths the same poses in every representation. Parameters are chosen on other seeds than
those that are judged; both lists are part of the plan and of the results.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from motorcade.fusion.motions import MOTIONS
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
from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES, REPRESENTATIONS
from motorcade.fusion.smoothing.representations import BEST_EULER
from motorcade.ga.names import did_you_mean
from motorcade.replays.comparison.truth import RecordedMotion

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
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"plan.{name}: expected above 0, got {getattr(self, name)}")

    def recording(self, motion: str) -> RecordedMotion | None:
        """The file of a motion; None of those with a formula."""
        return next((one for one in self.recorded if one.name == motion), None)

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
