"""Trajectory: stamped poses of one frame in another, ``parent_T_child``.

Stamps are integer nanoseconds, strictly increasing. A pose maps child coordinates to parent
coordinates (``world_T_camera`` by default); it is rigid, or a similarity where lengths in the two
frames differ. Between stamps the pose follows the screw, or spiral, from one neighbour to the next;
outside the span nothing is invented.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga.archives import load_arrays, save_arrays
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import checked_increasing, checked_stamps, stamps_at_rate
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.similarity import Similarity
from motorcade.ga.versors.versor import Versor

V = TypeVar("V", bound=Versor)

_FORMAT = "motorcade trajectory 1"


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses ``parent_T_child`` at strictly increasing stamps.

    Args:
        time_ns: ``(N,)`` integer nanoseconds, N at least 1.
        poses: Motor or Similarity of shape ``(N,)``.
        parent: name of the frame that poses map to.
        child: name of the frame that moves.

    Raises:
        ValueError: stamps that are no integers, do not increase or lie 146 years or more from
            zero, or lengths that differ.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> poses = Motor.from_translation([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        >>> path = Trajectory(np.array([0, 1_000_000_000]), poses, "world", "camera")
        >>> path
        Trajectory(world_T_camera, 2 poses, 1.000 s)
        >>> path.at(250_000_000).translation_m + 0.0
        array([0.5, 0. , 0. ])
    """

    time_ns: IntArray
    poses: Motor | Similarity
    parent: str = "world"
    child: str = "camera"

    def __post_init__(self) -> None:
        stamps = checked_increasing(self.time_ns, "Trajectory.time_ns", 1)
        if not isinstance(self.poses, Motor | Similarity):
            raise ValueError(
                "Trajectory.poses: expected a Motor or a Similarity, got "
                f"{type(self.poses).__name__}"
            )
        if self.poses.shape != stamps.shape:
            raise ValueError(
                f"Trajectory.poses: expected shape {stamps.shape} to match time_ns, "
                f"got {self.poses.shape}"
            )
        object.__setattr__(self, "time_ns", stamps)

    def __len__(self) -> int:
        return int(self.time_ns.size)

    def __repr__(self) -> str:
        return (
            f"Trajectory({self.parent}_T_{self.child}, {len(self)} poses, {self.duration_s:.3f} s)"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild through the constructor, so copies sent to other processes stay read-only."""
        return Trajectory, (np.array(self.time_ns), self.poses, self.parent, self.child)

    @property
    def motors(self) -> Motor:
        """The poses ``(N,)`` of a rigid trajectory.

        Raises:
            ValueError: the poses are similarities.
        """
        return _rigid(self.poses, "Trajectory.motors")

    @property
    def rigid(self) -> Trajectory:
        """The same stamps with rigid poses: itself, or without the growth of similarities."""
        if isinstance(self.poses, Motor):
            return self
        return Trajectory(self.time_ns, self.poses.rigid, self.parent, self.child)

    @property
    def duration_s(self) -> float:
        """Seconds from the first stamp to the last."""
        return float(self.time_ns[-1] - self.time_ns[0]) * 1e-9

    @property
    def time_s(self) -> FloatArray:
        """Stamps ``(N,)`` in seconds after the first.

        Raises:
            ValueError: stamps that seconds cannot tell apart, as those of a nanosecond after years.
        """
        seconds: FloatArray = (self.time_ns - self.time_ns[0]) * 1e-9
        alike = np.flatnonzero(np.diff(seconds) <= 0.0)
        if alike.size:
            at = int(alike[0])
            raise ValueError(
                "Trajectory.time_s: expected stamps that seconds after the first tell apart, got "
                f"two {int(self.time_ns[at + 1] - self.time_ns[at])} ns apart after "
                f"{seconds[at]:.6g} s; cut the trajectory at its gaps"
            )
        return seconds

    def __getitem__(self, index: slice | ArrayLike) -> Trajectory:
        """Part of the trajectory, by slice, boolean mask or increasing indices.

        Raises:
            ValueError: a selection that is empty or not increasing.
            TypeError: a single index; that is ``trajectory.poses[i]``.
        """
        chosen = index if isinstance(index, slice) else np.asarray(index)
        if not isinstance(chosen, slice) and chosen.ndim != 1:
            raise TypeError("Trajectory index: expected a slice or a 1-d array of indices")
        return Trajectory(self.time_ns[chosen], self.poses[chosen], self.parent, self.child)

    def motors_at(self, time_ns: ArrayLike) -> Motor:
        """Poses of a rigid trajectory at stamps ``(*)`` in nanoseconds; see `at`.

        Raises:
            ValueError: as `at`, or the poses are similarities.
        """
        return _rigid(self.at(time_ns), "Trajectory.motors_at")

    def at(self, time_ns: ArrayLike) -> Motor | Similarity:
        """Poses at stamps ``(*)`` in nanoseconds, by screw interpolation between neighbours.

        Raises:
            ValueError: stamps that are no integers, or outside the span of the trajectory.
        """
        stamps = checked_stamps(time_ns, "Trajectory.at(time_ns)")
        first, last = int(self.time_ns[0]), int(self.time_ns[-1])
        outside = (stamps < first) | (stamps > last)
        if np.any(outside):
            raise ValueError(
                f"Trajectory.at(time_ns): expected stamps in [{first}, {last}], got "
                f"{int(stamps[outside][0])} and {int(np.count_nonzero(outside)) - 1} more outside"
            )
        if len(self) == 1:
            return self.poses[np.zeros(stamps.shape, dtype=np.int64)]
        before = np.searchsorted(self.time_ns, stamps, side="right") - 1
        before = np.minimum(before, len(self) - 2)
        step = self.time_ns[before + 1] - self.time_ns[before]
        fraction = (stamps - self.time_ns[before]) / step
        return _between(self.poses, before, fraction)

    def resampled(self, time_ns: ArrayLike) -> Trajectory:
        """The trajectory at other stamps ``(M,)`` inside its span; see `at`."""
        stamps = checked_stamps(time_ns, "Trajectory.resampled(time_ns)")
        return Trajectory(stamps, self.at(stamps), self.parent, self.child)

    def at_rate(self, rate_hz: float) -> Trajectory:
        """The trajectory at even stamps, `rate_hz` a second from the first on; see `at`.

        A gap of more than ten seconds (and three median intervals) stays a gap: nothing is invented
        within, and the stamps begin anew after it.

        Raises:
            ValueError: a rate that is not positive, or that makes more than 50,000 poses and
                500 more for each that there is.
        """
        stamps = stamps_at_rate(self.time_ns, rate_hz, "Trajectory.at_rate: rate_hz")
        return self.resampled(stamps)

    def transformed_by(
        self,
        left: Motor | Similarity | None = None,
        right: Motor | Similarity | None = None,
        *,
        parent: str | None = None,
        child: str | None = None,
    ) -> Trajectory:
        """``left @ pose @ right``: move the parent frame by `left`, the child frame by `right`.

        ``parent`` and ``child`` name the new frames; without them the old names stay. A similarity
        on either side makes similarities of rigid poses.
        """
        poses = self.poses if left is None else _composed(left, self.poses)
        poses = poses if right is None else _composed(poses, right)
        return Trajectory(self.time_ns, poses, parent or self.parent, child or self.child)

    def save(self, path: Path) -> None:
        """Write an ``.npz`` file of plain arrays; the same trajectory gives the same bytes.

        Raises:
            ValueError: a file name that does not end in ``.npz``.
            OSError: a file that cannot be written.
        """
        arrays = {
            "time_ns": self.time_ns,
            "coefficients": self.poses.coefficients,
            "parent": np.array(self.parent),
            "child": np.array(self.child),
        }
        save_arrays(path, "Trajectory", _FORMAT, arrays)

    @classmethod
    def load(cls, path: Path) -> Trajectory:
        """Read what `save` wrote.

        Raises:
            FileError: a file that cannot be read, or unpacks to too much (`ga.archives`).
            ValueError: a file that is no trajectory, or holds values that are refused.
        """

        def make(stored: Mapping[str, NDArray[Any]]) -> Trajectory:
            coefficients = stored["coefficients"]
            kind = Similarity if coefficients.shape[-1:] == (12,) else Motor
            frames = str(stored["parent"]), str(stored["child"])
            return cls(stored["time_ns"], kind(coefficients), *frames)

        return load_arrays(path, "a saved trajectory", _FORMAT, make)


def _between(poses: V, before: IntArray, fraction: FloatArray) -> V:
    return poses[before].interpolate(poses[before + 1], fraction)


def _rigid(poses: Motor | Similarity, name: str) -> Motor:
    if isinstance(poses, Motor):
        return poses
    raise ValueError(
        f"{name}: expected rigid poses, got similarities; as_motor_scale takes the scale off"
    )


def _composed(a: Motor | Similarity, b: Motor | Similarity) -> Motor | Similarity:
    if isinstance(a, Motor) and isinstance(b, Motor):
        return a @ b
    first, second = (
        Similarity.from_motor_scale(versor) if isinstance(versor, Motor) else versor
        for versor in (a, b)
    )
    return first @ second
