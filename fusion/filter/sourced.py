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
        >>> from motorcade.fusion.filter import Judgement
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


def predicted(given: Measurements, row: int, known: FloatArray) -> FloatArray:
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
    residual, jacobian = given.residual(row, state), given.jacobian(row, state)
    size = given.covariance.shape[-1]
    if np.shape(residual) != (size,) or np.shape(jacobian) != (size, ERROR_NUMBERS):
        raise ValueError(
            f"{given.name} measurements: expected a residual {(size,)} and a jacobian "
            f"{(size, ERROR_NUMBERS)}, got {np.shape(residual)} and {np.shape(jacobian)}"
        )
    made = np.empty((size, 1 + ERROR_NUMBERS))
    made[:, 0], made[:, 1:] = residual, jacobian
    if not np.isfinite(made).all():
        raise ValueError(
            f"{given.name} measurements: expected a finite residual and jacobian, got NaN or "
            f"infinity at {given.time_ns[row]} ns"
        )
    return made


def prediction(given: Measurements) -> Callable[[int, FloatArray], FloatArray]:
    """What the compiled filter calls."""
    return lambda row, known: predicted(given, row, known)


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


def rows_within(given: Measurements, first_ns: int, last_ns: int) -> IntArray:
    """Rows of a kind whose moments all lie within a span."""
    inside = (given.time_ns >= first_ns) & (given.time_ns <= last_ns)
    if given.since_ns is not None:
        inside &= given.since_ns >= first_ns
    return np.flatnonzero(inside)


def schedule(run: Engine, also: Sequence[Measurements], first_ns: int, last_ns: int) -> None:
    """Give the filter all measurements within a span."""
    for number, given in enumerate(also):
        rows = rows_within(given, first_ns, last_ns)
        if not rows.size:
            continue
        if given.since_ns is not None:
            starts = np.unique(given.since_ns[rows])
            run.schedule(KEEP, starts, np.zeros((len(starts), 0)), None, None, None, -1)
        run.schedule(
            SOURCED,
            np.ascontiguousarray(given.time_ns[rows], dtype=np.int64),
            np.ascontiguousarray(given.covariance[rows].reshape(len(rows), -1)),
            None,
            rows.astype(np.int64),
            prediction(given),
            number,
        )


def judgements(
    also: Sequence[Measurements], about: NDArray[np.int64], values: FloatArray, *, live: bool
) -> tuple[Judgement, ...]:
    """What became of each kind, by what the filter says of its events."""
    made = []
    for number, given in enumerate(also):
        own = (about[:, 2] == SOURCED) & (about[:, 4] == number)
        rows, found = about[own, 1], values[own, 2:] if live else values[own, :2]
        nis, accepted = np.full(len(given), np.nan), np.zeros(len(given), dtype=np.bool_)
        nis[rows], accepted[rows] = found[:, 0], found[:, 1] > 0.0
        made.append(Judgement(given.name, given.time_ns, nis, accepted))
    return tuple(made)
