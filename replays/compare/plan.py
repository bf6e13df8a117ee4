"""What a comparison runs: motions, degradations, methods, representations, and the seeds of both.

A cell is a motion, a degradation and a seed: the true motion is sampled, degraded once, and every
method smooths the same poses in every representation. Parameters are chosen on other seeds than
those that are judged; both lists are part of the plan and of the results.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
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
from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS
from motorcade.ga import Motor
from motorcade.ga.names import did_you_mean

SLOW = ("auto", "robust_map")
"""Methods whose cells are computed apart; see `standard`."""

_SLOW_RUN_ON = ("gaussian", "outliers_and_flips")
_MODERATE = Gaussian(0.005, float(np.deg2rad(0.5)), 0.005)
_OUTLIERS = Outliers(0.05, 0.1, 0.2)

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
class LeftOut:
    """What a plan does not run, and why: a method where all three of these hold."""

    method: str
    representations: tuple[str, ...]
    motions: tuple[str, ...]
    degradations: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class ComparisonPlan:
    """A comparison; see the module.

    Args:
        motions: names of `MOTIONS`.
        degradations: names of `DEGRADATIONS`.
        methods: names of `METHODS`.
        representations: names of `REPRESENTATIONS`.
        test_seeds: seeds of the cells that are judged.
        tuning_seeds: seeds on which parameters are chosen; none of them in `test_seeds`.
        rate_hz: poses a second.
        duration_s: of every motion.
        left_out: what is not run all the same, and why.

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
    left_out: tuple[LeftOut, ...] = field(default=())

    def __post_init__(self) -> None:
        _check_names("motions", self.motions, MOTIONS)
        _check_names("degradations", self.degradations, DEGRADATIONS)
        _check_names("methods", self.methods, METHODS)
        _check_names("representations", self.representations, REPRESENTATIONS)
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

    def runs(self, motion: str, degradation: str, method: str, representation: str) -> bool:
        """Whether the plan runs the method so; what it does not is in `left_out`."""
        return not any(
            one.method == method
            and representation in one.representations
            and motion in one.motions
            and degradation in one.degradations
            for one in self.left_out
        )

    def pairs(
        self, motion: str, degradation: str, methods: Sequence[str] = ()
    ) -> list[tuple[str, str]]:
        """Methods and representations that are run on a place, of `methods` or all."""
        return [
            (method, representation)
            for method in (methods or self.methods)
            for representation in self.representations
            if self.runs(motion, degradation, method, representation)
        ]

    def as_dict(self) -> dict[str, Any]:
        """All of it, ready for JSON, with what each degradation does."""
        told = {name: repr(DEGRADATIONS[name]) for name in self.degradations}
        return asdict(self) | {"degradation_values": told}


def degradation_named(name: str, similarities: bool) -> Degradation:
    """The degradation of that name; without noise of the scale where poses have none."""
    return DEGRADATIONS[name] if similarities else _rigid(DEGRADATIONS[name])


def standard(
    seeds: int = 20,
    methods: Sequence[str] = (),
    representations: Sequence[str] = (),
    motions: Sequence[str] = (),
    degradations: Sequence[str] = (),
) -> ComparisonPlan:
    """The whole comparison, or the named parts of it, over so many test seeds and three for tuning.

    The methods of `SLOW` cost some hundred times what the others do. They run on plain noise and on
    outliers with flips, for which they are made; and not as `similarity` on rigid motions, where
    it comes within hundredths of a millimetre of `motor`. A plan of one's own leaves nothing out.
    """
    named = ComparisonPlan(
        motions=tuple(motions or MOTIONS),
        degradations=tuple(degradations or DEGRADATIONS),
        methods=tuple(methods or METHODS),
        representations=tuple(representations or REPRESENTATIONS),
        test_seeds=tuple(range(100, 100 + seeds)),
        tuning_seeds=(1, 2, 3),
    )
    return replace(named, left_out=tuple(_left_out(named)))


def _left_out(plan: ComparisonPlan) -> Iterator[LeftOut]:
    others = tuple(name for name in plan.degradations if name not in _SLOW_RUN_ON)
    rigid = tuple(name for name in plan.motions if MOTIONS[name].versor is Motor)
    for method in plan.methods:
        if method not in SLOW:
            continue
        if others:
            reason = "slow; run on plain noise and on outliers with flips, for which it is made"
            yield LeftOut(method, plan.representations, plan.motions, others, reason)
        if rigid and {"similarity", "motor"} <= set(plan.representations):
            reason = "slow; on rigid poses within hundredths of a millimetre of motor"
            yield LeftOut(method, ("similarity",), rigid, plan.degradations, reason)


def quick() -> ComparisonPlan:
    """Seconds instead of minutes: three motions, two degradations, four methods, five seeds."""
    return ComparisonPlan(
        motions=("gimbal_crossing", "walk_and_look", "zoom"),
        degradations=("gaussian", "outliers"),
        methods=("exponential", "one_euro", "rts_constant_velocity", "gaussian"),
        representations=tuple(REPRESENTATIONS),
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


def _check_names(name: str, given: tuple[str, ...], known: Mapping[str, object]) -> None:
    if not given or len(set(given)) < len(given):
        raise ValueError(f"plan.{name}: expected one or more different names, got {given}")
    for one in given:
        if one not in known:
            advice = did_you_mean(one, known)
            raise ValueError(f"plan.{name}: expected known names, got {one!r}; {advice}")


def _check_seeds(name: str, seeds: tuple[int, ...]) -> None:
    if not seeds or len(set(seeds)) < len(seeds) or min(seeds) < 0:
        raise ValueError(f"plan.{name}: expected one or more different seeds >= 0, got {seeds}")
