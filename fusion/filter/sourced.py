"""How kinds of measurements (`motorcade.fusion.measurements`) go into the compiled filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.native._filter import Engine
from motorcade.fusion.measurements.interface import (
    ERROR_NUMBERS,
    Measurements,
    PredictedState,
    checked_measurements,
)
from motorcade.ga.arrays import FloatArray, IntArray

SOURCED, KEEP = 5, 6  # of the compiled kinds


@dataclass(frozen=True, eq=False)
class Judgement:
    """What became of the N measurements of one kind.

    Fields:
        name: of the kind.
        time_ns: ``(N,)`` their stamps.
        nis: ``(N,)`` normalised innovations squared; NaN where the filter did not get to them, and
            from the factor graph.
        accepted: ``(N,)`` false where one was left out.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.sourced import Judgement
        >>> Judgement("altitude", np.array([0]), np.array([0.7]), np.array([True])).accepted
        array([ True])
    """

    name: str
    time_ns: IntArray
    nis: FloatArray
    accepted: NDArray[np.bool_]

    @classmethod
    def joined(cls, parts: Sequence[Judgement]) -> Judgement:
        """One of several that each saw some of the rows."""
        first = parts[0]
        nis = np.array([one.nis for one in parts])
        accepted = np.array([one.accepted for one in parts])
        seen = np.where(np.isnan(nis), -np.inf, nis).max(axis=0)
        return cls(
            first.name,
            first.time_ns,
            np.where(np.isfinite(seen), seen, np.nan),
            np.logical_or.reduce(accepted),
        )


def predicted(measurements: Measurements, row: int, known: FloatArray) -> FloatArray:
    """Residual and its Jacobian ``(m, 31)`` of a row, at the state that the filter holds.

    Raises:
        ValueError: a kind that gives other shapes, NaN or infinity.
    """
    state = PredictedState(
        known[:9].reshape(3, 3),
        known[9:12],
        known[12:21].reshape(3, 3),
        known[21:24],
        known[24:27],
        known[27:30],
        known[30:33],
        known[33:36],
        known[36:45].reshape(3, 3),
        known[45:53],
        float(known[53]),
    )
    residual, jacobian = measurements.residual(row, state), measurements.jacobian(row, state)
    size = measurements.covariance.shape[-1]
    if np.shape(residual) != (size,) or np.shape(jacobian) != (size, ERROR_NUMBERS):
        raise ValueError(
            f"{measurements.name} measurements: expected a residual {(size,)} and a jacobian "
            f"{(size, ERROR_NUMBERS)}, got {np.shape(residual)} and {np.shape(jacobian)}"
        )
    linearised = np.empty((size, 1 + ERROR_NUMBERS))
    linearised[:, 0], linearised[:, 1:] = residual, jacobian
    if not np.isfinite(linearised).all():
        raise ValueError(
            f"{measurements.name} measurements: expected a finite residual and jacobian, got "
            f"NaN or infinity at {measurements.time_ns[row]} ns"
        )
    return linearised


def prediction(measurements: Measurements) -> Callable[[int, FloatArray], FloatArray]:
    """What the compiled filter calls."""
    return lambda row, known: predicted(measurements, row, known)


def checked_also(also: Sequence[Measurements]) -> tuple[Measurements, ...]:
    """Kinds as the filter can take them.

    Raises:
        TypeError: something that is no kind of measurement.
        ValueError: kinds that are refused, or steps that overlap.
    """
    kinds = tuple(checked_measurements(one) for one in also)
    check_steps([(since, one.time_ns) for one in kinds if (since := one.since_ns) is not None])
    return kinds


def check_steps(steps: Sequence[tuple[IntArray, IntArray]]) -> None:
    """Refuse steps (starts, ends) that need more than one earlier pose at a time.

    Raises:
        ValueError: a step that starts within another one that does not start with it.
    """
    if not steps:
        return
    starts, ends = (np.concatenate([one[k] for one in steps]) for k in (0, 1))
    kept = np.unique(starts)
    inside = np.searchsorted(kept, ends, side="left") - np.searchsorted(kept, starts, side="right")
    if np.any(inside > 0):
        worst = int(np.argmax(inside))
        raise ValueError(
            f"also: expected steps that do not overlap, got one from {starts[worst]} to "
            f"{ends[worst]} ns within which another starts; fuse_by_graph takes such"
        )


def rows_within(measurements: Measurements, first_ns: int, last_ns: int) -> IntArray:
    """Rows of a kind whose moments all lie within a span."""
    inside = (measurements.time_ns >= first_ns) & (measurements.time_ns <= last_ns)
    if measurements.since_ns is not None:
        inside &= measurements.since_ns >= first_ns
    return np.flatnonzero(inside)


def schedule(run: Engine, also: Sequence[Measurements], first_ns: int, last_ns: int) -> None:
    """Give the filter all measurements within a span."""
    for number, measurements in enumerate(also):
        rows = rows_within(measurements, first_ns, last_ns)
        if not rows.size:
            continue
        if measurements.since_ns is not None:
            starts = np.unique(measurements.since_ns[rows])
            run.schedule(KEEP, starts, np.zeros((len(starts), 0)), None, None, None, -1)
        run.schedule(
            SOURCED,
            np.ascontiguousarray(measurements.time_ns[rows], dtype=np.int64),
            np.ascontiguousarray(measurements.covariance[rows].reshape(len(rows), -1)),
            None,
            rows.astype(np.int64),
            prediction(measurements),
            number,
        )


def judgements(
    also: Sequence[Measurements], about: NDArray[np.int64], values: FloatArray, *, live: bool
) -> tuple[Judgement, ...]:
    """What became of each kind, by what the filter says of its events."""
    judged = []
    for number, measurements in enumerate(also):
        own = (about[:, 2] == SOURCED) & (about[:, 4] == number)
        rows, outcomes = about[own, 1], values[own, 2:] if live else values[own, :2]
        nis = np.full(len(measurements), np.nan)
        accepted = np.zeros(len(measurements), dtype=np.bool_)
        nis[rows], accepted[rows] = outcomes[:, 0], outcomes[:, 1] > 0.0
        judged.append(Judgement(measurements.name, measurements.time_ns, nis, accepted))
    return tuple(judged)
