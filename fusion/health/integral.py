"""Running integrals of an IMU's readings, for means over any spans."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray

# Up to so many samples the sum at each is kept, in six megabytes; of more one in eight, and those
# between are made again where they are asked for.
_ALL_KEPT, _STRIDE = 1 << 18, 8
_BLOCK = 1 << 15  # samples at once


class RunningIntegral:
    """Integral from the first sample on, by trapezoids.

    Args:
        time_ns: ``(N,)`` rising.
        values: ``(N, 3)``; both are held, not copied.
    """

    def __init__(self, time_ns: IntArray, values: FloatArray) -> None:
        self._time_ns, self._values = time_ns, values
        self._stride = stride = 1 if len(time_ns) <= _ALL_KEPT else _STRIDE
        kept = np.zeros(((len(time_ns) - 1) // stride + 1, 3))
        for first in range(0, len(time_ns) - 1, _BLOCK):
            steps = self._steps(np.arange(first, min(first + _BLOCK, len(time_ns) - 1)))
            steps[0] += kept[first // stride]
            sums = np.cumsum(steps, axis=0)[stride - 1 :: stride]
            kept[first // stride + 1 : first // stride + 1 + len(sums)] = sums
        self._kept = kept

    def at(self, time_ns: IntArray) -> FloatArray:
        """The integral at stamps ``(m,)``, between samples by the line between their sums.

        Before the first sample it is zero, after the last as there.
        """
        most = _BLOCK // self._stride
        parts = [self._at(time_ns[k : k + most]) for k in range(0, len(time_ns), most)]
        return np.concatenate(parts) if parts else np.zeros((0, 3))

    def _at(self, time_ns: IntArray) -> FloatArray:
        known = self._time_ns
        wanted = np.clip(time_ns, known[0], known[-1])
        before = np.minimum(np.searchsorted(known, wanted, side="right"), len(known) - 1) - 1
        share = (wanted - known[before]) / (known[before + 1] - known[before])
        if self._stride == 1:
            sums = np.take(self._kept, before, axis=0)
            sums += share[:, None] * (np.take(self._kept, before + 1, axis=0) - sums)
            return sums
        number, left = np.divmod(before, self._stride)
        sums = self._kept[number]
        for k in range(self._stride - 1):  # in the order in which the kept ones were summed
            more = np.flatnonzero(left > k)
            sums[more] += self._steps(number[more] * self._stride + k)
        sums += share[:, None] * self._steps(before)
        return sums

    def _steps(self, rows: IntArray) -> FloatArray:
        """What is added from samples to the next ones ``(m, 3)``."""
        seconds = (self._time_ns[rows + 1] - self._time_ns[rows]) * 1e-9
        steps: FloatArray = 0.5 * (self._values[rows] + self._values[rows + 1]) * seconds[:, None]
        return steps
