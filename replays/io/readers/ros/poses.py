"""Stamped poses collected from messages, checked and put in the order of their stamps."""

from __future__ import annotations

import logging
from array import array
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import IntArray
from motorcade.ga.stamps import STAMP_LIMIT_NS
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.readers.tables import REACH_M, UNIT_TOLERANCE

_LOG = logging.getLogger("motorcade.replays")


class StampedPoses:
    """Poses in the order they were recorded, which need not be that of their stamps.

    Args:
        path: the bag, for what is said of it.
        field: the topic, or the two frames.
    """

    def __init__(self, path: Path, field: str) -> None:
        self._path, self._field = path, field
        self._stamps, self._numbers = array("q"), array("d")

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp_ns: int, place: Any, turn: Any | None) -> None:
        """Add a pose: a message's point or vector, and its quaternion (None: not turned).

        Raises:
            RecordingError: a stamp that is 146 years or more from zero.
        """
        if abs(stamp_ns) >= STAMP_LIMIT_NS:
            raise self._refusal(len(self), f"expected a stamp within 146 years, got {stamp_ns} ns")
        self._stamps.append(stamp_ns)
        wxyz = (1.0, 0.0, 0.0, 0.0) if turn is None else (turn.w, turn.x, turn.y, turn.z)
        self._numbers.extend((place.x, place.y, place.z, *wxyz))

    @cached_property
    def ordered(self) -> tuple[IntArray, Motor]:
        """Increasing stamps ``(N,)`` and their poses ``(N,)``; of equal stamps the first's.

        Raises:
            RecordingError: no poses, no stamps, or a pose that is no finite rigid motion.
        """
        time_ns = np.frombuffer(self._stamps, np.int64)
        if not time_ns.size:
            raise refusal(self._path, "expected poses, got none", field=self._field)
        if time_ns.size > 1 and not time_ns.any():
            problem = "expected the stamps of headers, got 0 in every one"
            raise refusal(self._path, problem, field=self._field)
        numbers = np.frombuffer(self._numbers, np.float64).reshape(-1, 7)
        far = ~(np.abs(numbers[:, :3]).max(axis=1) <= REACH_M)
        self._refuse(far, numbers[:, :3], f"expected a position within {REACH_M:g} m, got")
        with np.errstate(over="ignore", invalid="ignore"):
            norm = np.sqrt(np.sum(numbers[:, 3:] ** 2, axis=1))
        askew = ~(np.abs(norm - 1.0) <= UNIT_TOLERANCE)
        self._refuse(askew, norm, "expected a unit quaternion, got one of norm")
        order = self._order(time_ns)
        wxyz = numbers[order, 3:] / norm[order, None]
        return time_ns[order], Motor.from_quaternion_translation(wxyz, numbers[order, :3])

    def _order(self, time_ns: IntArray) -> IntArray:
        """Places of the poses by their stamps, one for each; what is not used is told."""
        order = np.argsort(time_ns, kind="stable")
        late = int(np.count_nonzero(np.diff(time_ns) < 0))
        if late:
            text = "%s, %s: stamps go back %d times; poses are taken in the order of their stamps"
            _LOG.warning(text, self._path, self._field, late)
        repeats = np.flatnonzero(np.diff(time_ns[order]) == 0) + 1
        if repeats.size:
            text = "%s, %s: %d poses have the stamp of another; the first of each is kept"
            _LOG.warning(text, self._path, self._field, repeats.size)
        return np.delete(order, repeats)

    def _refuse(self, bad: Any, values: Any, problem: str) -> None:
        if np.any(bad):
            at = int(np.flatnonzero(bad)[0])
            raise self._refusal(at, f"{problem} {np.array2string(values[at], precision=6)}")

    def _refusal(self, at: int, problem: str) -> Exception:
        return refusal(self._path, problem, field=f"{self._field}, pose {at}")
