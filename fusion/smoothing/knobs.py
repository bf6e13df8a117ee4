"""What people may ask of `method="auto"`: smoother or less so, noise they know, no far moves.

Other methods declare their parameters in their signatures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.smoothing.checks import checked_size
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_number

# A thousandth and a thousand times the time that the path calls for are as good as none and all.
_MOST = 10.0
# Representations whose vectors have a rotation and a translation an axis.
_OF_AXES = ("motor", "similarity", "rotor")


@dataclass(frozen=True)
class SmootherKnobs:
    """What is asked of a smoother that finds out the rest.

    Fields:
        smoothness: 0 smooths as the path calls for; each unit more doubles the time that a pose is
            averaged over, each less halves it; from -10 to 10.
        noise_m, noise_rad: deviation of positions and rotations an axis, where it is known: it is
            then used, not searched for; from 1e-30 to 1e30.
        max_move_m, max_move_rad: no pose is moved, or turned, farther than that from where it was
            measured, though it be wrong; from 1e-30 to 1e30.

    Raises:
        ValueError: a smoothness or a noise out of its range.
        TypeError: what is no number.

    Examples:
        >>> from motorcade.fusion.smoothing.knobs import SmootherKnobs
        >>> SmootherKnobs(smoothness=1.0, noise_m=0.005).noise_m
        0.005
    """

    smoothness: float = 0.0
    noise_m: float | None = None
    noise_rad: float | None = None
    max_move_m: float | None = None
    max_move_rad: float | None = None

    def __post_init__(self) -> None:
        if not -_MOST <= checked_number(self.smoothness, "smoothness") <= _MOST:
            raise ValueError(
                f"smoothness: expected {-_MOST:g} to {_MOST:g}, each unit twice as smooth, got "
                f"{self.smoothness}"
            )
        for name in ("noise_m", "noise_rad", "max_move_m", "max_move_rad"):
            size = getattr(self, name)
            if size is not None:
                checked_size(size, name, "metres" if name.endswith("_m") else "radians")

    def known_noise(self, representation: Representation, columns: int) -> FloatArray:
        """Of the columns of a representation ``(columns,)``; NaN where it is to be found out.

        Raises:
            ValueError: a noise of a representation whose vectors are not rotation and translation.
        """
        known = np.full(columns, np.nan)
        sizes = (self.noise_rad, self.noise_m)
        if sizes == (None, None):
            return known
        if representation.name not in _OF_AXES:
            raise ValueError(
                f"noise_m, noise_rad: expected none with {representation.name}, whose components "
                f"have noise of their own; take one of {', '.join(_OF_AXES)}"
            )
        ends = (0, *representation.ends)
        for noise, first, end in zip(sizes, ends[:-1], ends[1:], strict=True):
            known[first:end] = np.nan if noise is None else noise
        return known

    def allowed_share(self, smoothed: Motor, measured: Motor) -> FloatArray:
        """Of the way from measured rotations and positions to smoothed ones ``(N, 2)``."""
        turned = (measured.rotor.inverse() @ smoothed.rotor).angle()
        moved = np.linalg.norm(smoothed.translation_m - measured.translation_m, axis=1)
        limits = [np.inf if most is None else most for most in (self.max_move_rad, self.max_move_m)]
        way = np.maximum(np.column_stack([turned, moved]), 1e-300)
        return np.asarray(np.minimum(1.0, np.array(limits) / way), dtype=np.float64)
