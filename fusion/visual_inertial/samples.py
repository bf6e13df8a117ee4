"""Inertial samples as they come in, joined only where they are asked for."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray


class GrowingImu:
    """Samples in chunks; chunks of like length are joined, so that each is copied few times.

    >>> import numpy as np
    >>> from motorcade.fusion import ImuStream
    >>> from motorcade.fusion.visual_inertial.samples import GrowingImu
    >>> still, samples = np.zeros((4, 3)), GrowingImu()
    >>> for start in (0, 4):
    ...     samples.add(ImuStream(5_000_000 * np.arange(start, start + 4), still, still))
    >>> samples.last_ns, len(samples.between(0, 25_000_000))
    (35000000, 8)
    """

    def __init__(self) -> None:
        self._chunks: list[ImuStream] = []

    def add(self, samples: ImuStream) -> None:
        """Take samples after those before.

        Raises:
            ValueError: samples that do not come after those before.
        """
        if self._chunks and samples.time_ns[0] <= self.last_ns:
            raise ValueError(
                f"samples: expected stamps after {self.last_ns}, got {samples.time_ns[0]}"
            )
        self._chunks.append(samples)
        while len(self._chunks) > 1 and len(self._chunks[-2]) <= 2 * len(self._chunks[-1]):
            self._chunks[-2:] = [_joined(self._chunks[-2:])]

    @property
    def first_ns(self) -> int:
        """Stamp of the first sample.

        Raises:
            ValueError: no samples so far. So `all` and `between`.
        """
        return int(self._some()[0].time_ns[0])

    @property
    def last_ns(self) -> int:
        """Stamp of the last sample; -1 without any."""
        return int(self._chunks[-1].time_ns[-1]) if self._chunks else -1

    def all(self) -> ImuStream:
        """Everything so far."""
        self._chunks = [_joined(self._some())]
        return self._chunks[0]

    def between(self, first_ns: int, last_ns: int) -> ImuStream:
        """Samples that cover a span, and more."""
        starts = [int(chunk.time_ns[0]) for chunk in self._some()]
        first = max(int(np.searchsorted(starts, first_ns, side="right")) - 1, 0)
        last = int(np.searchsorted(starts, last_ns, side="right"))
        return _joined(self._chunks[first : last + 1])

    def rates_at(self, time_ns: IntArray) -> FloatArray:
        """Angular rates ``(k, 3)``, rad/s, at two stamps ``(k,)`` or more in any order."""
        rising, place = np.unique(time_ns, return_inverse=True)
        return self.around(rising).at(rising).angular_rate_rad_s[place]

    def around(self, time_ns: IntArray) -> ImuStream:
        """Samples that cover stamps ``(k,)``, and more."""
        return self.between(int(time_ns.min()), int(time_ns.max()))

    def _some(self) -> list[ImuStream]:
        if not self._chunks:
            raise ValueError("GrowingImu: expected samples, got none")
        return self._chunks


def _joined(chunks: list[ImuStream]) -> ImuStream:
    if len(chunks) == 1:
        return chunks[0]
    return ImuStream(
        np.concatenate([one.time_ns for one in chunks]),
        np.concatenate([one.angular_rate_rad_s for one in chunks]),
        np.concatenate([one.specific_force_m_s2 for one in chunks]),
    )
