"""Both sensors at once: of what explains each of them as well, what both have in common.

A camera that is mounted by a quarter turn looks the same with its extrinsics the wrong way round as
with two axes of both sensors negated, and one sensor alone does not tell which. Both share a
package and its extrinsics, so what needs the fewest faults for the two of them is believed. Where
two stories of equally many faults are the same to any measurement, both are told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.health.accelerometer import ForceTrial, ForceVerdict
from motorcade.fusion.health.gyroscope import RateVerdict
from motorcade.fusion.health.models import AxesVerdict, Base, Model, same_turns
from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Story:
    """What both sensors are believed to be: one story of what went wrong."""

    rates: RateVerdict
    forces: ForceVerdict


def judge_jointly(rates: RateVerdict, trial: ForceTrial) -> list[Story]:
    """One story, or two that no measurement can tell apart.

    Args:
        rates: the gyroscope's verdict alone.
        trial: the accelerometer's evidence.
    """
    verdicts = [rates]
    if rates.state == "named" and rates.axes is not None and len(rates.axes.rivals) > 1:
        turns = trial.camera_R_imu()
        models = _fewest(rates.axes.rivals, trial.rivals(), turns)
        verdicts = [_retold(rates, rates.axes, model, turns) for model in models]
    return [Story(own, trial.judged(own.axes if own.explained else None)) for own in verdicts]


def count_faults(model: Model, of_forces: FloatArray) -> int:
    """How many things went wrong at least.

    Args:
        model: how the extrinsics are to be read, and the gyroscope's axes ``(3, 3)``.
        of_forces: the accelerometer's ``(3, 3)``.
    """
    base, of_rates = model
    changed = [not np.array_equal(axes, np.eye(3)) for axes in (of_rates, of_forces)]
    # One frame for both: in a left-handed one rates turn the other way round.
    handed = round(float(np.linalg.det(of_forces)))
    shared = any(np.array_equal(sign * of_rates, of_forces) for sign in (1, handed))
    return int(base == "inverted") + (int(any(changed)) if shared else sum(changed))


def _fewest(
    of_rates: Sequence[Model], of_forces: Sequence[Model], turns: Mapping[Base, FloatArray]
) -> list[Model]:
    """What the gyroscope's rivals come to: the most believed, and what is the same as that."""
    pairs = [
        (count_faults((base, own), other), base, own, other)
        for base, own in of_rates
        for its_base, other in of_forces
        if its_base == base
    ]
    if not pairs:  # the accelerometer tells nothing, and may have whatever the gyroscope has
        pairs = [(count_faults((base, own), own), base, own, own) for base, own in of_rates]
    least, base, own, other = min(pairs, key=lambda pair: pair[0])
    chosen = turns[base] @ np.array([own, other])
    models = [(base, own)]
    for faults, its_base, mine, others in pairs:
        same = np.diag(same_turns(turns[its_base] @ np.array([mine, others]), chosen))
        if faults == least and its_base != base and np.all(same):
            models.append((its_base, mine))
    return models


def _retold(
    rates: RateVerdict, axes: AxesVerdict, model: Model, turns: Mapping[Base, FloatArray]
) -> RateVerdict:
    """The same verdict by the name of a rival."""
    base, permutation = model
    bias = turns[base].T @ turns[axes.base] @ rates.bias_rad_s
    return replace(rates, axes=replace(axes, base=base, permutation=permutation), bias_rad_s=bias)
