"""What a camera saw of landmarks in its keyframes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen


@dataclass(frozen=True, eq=False)
class LandmarkObservations:
    """N sightings of L landmarks in K keyframes.

    Args:
        keyframe: ``(N,)`` from 0 on, rows of the keyframes.
        landmark: ``(N,)`` from 0 on, rows of the landmarks.
        px: ``(N, 2)`` where, in the camera's own (distorted) pixels.

    Raises:
        ValueError: shapes that do not agree, numbers below 0, pixels that are not finite, or a
            landmark twice in one keyframe.

    Examples:
        >>> from motorcade.fusion.visual_inertial import LandmarkObservations
        >>> seen = LandmarkObservations([0, 1], [0, 0], [[320.0, 240.0], [310.5, 240.2]])
        >>> len(seen)
        2
    """

    keyframe: IntArray
    landmark: IntArray
    px: FloatArray

    def __post_init__(self) -> None:
        px = frozen(checked_floats(self.px, "LandmarkObservations.px", (2,)))
        for name in ("keyframe", "landmark"):
            rows = np.array(getattr(self, name))
            if rows.dtype.kind not in "iu" or rows.shape != px.shape[:1] or np.any(rows < 0):
                raise ValueError(
                    f"LandmarkObservations.{name}: expected {px.shape[:1]} whole numbers from 0 "
                    f"on, got dtype {rows.dtype}, shape {rows.shape}"
                )
            rows = rows.astype(np.int64)
            rows.setflags(write=False)
            object.__setattr__(self, name, rows)
        pairs = np.stack([self.keyframe, self.landmark], axis=-1)
        if len(np.unique(pairs, axis=0)) < len(pairs):
            raise ValueError(
                "LandmarkObservations: expected a landmark once in a keyframe, got one twice"
            )
        object.__setattr__(self, "px", px)

    def __len__(self) -> int:
        """Number of sightings."""
        return len(self.px)
