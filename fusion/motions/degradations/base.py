"""What every degradation is: a frozen value that makes a measured trajectory of a true one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Trajectory


class Degradation(ABC):
    """A way in which measuring degrades a trajectory; sizes are in metres, radians and seconds.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Degradation, Gaussian
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> noise = Gaussian(sigma_m=0.01, sigma_rad=0.02)
        >>> isinstance(noise, Degradation), noise.apply(true, rng)
        (True, Trajectory(world_T_camera, 301 poses, 10.000 s))
    """

    @abstractmethod
    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """The degraded trajectory; the given one stays as it is."""


@dataclass(frozen=True)
class InTurn(Degradation):
    """Several degradations, the first one applied first.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Blackouts, Gaussian, InTurn
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> both = InTurn((Gaussian(0.01, 0.02), Blackouts(length_s=1.0, every_s=4.0)))
        >>> len(true), len(both.apply(true, rng))
        (301, 241)
    """

    steps: tuple[Degradation, ...]

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Apply each to what the one before it left."""
        for step in self.steps:
            trajectory = step.apply(trajectory, rng)
        return trajectory


def runs(
    rng: np.random.Generator, count: int, share: float, mean_length: float
) -> NDArray[np.bool_]:
    """Which of `count` poses are struck, a two-state Markov chain in its steady state.

    A share of all poses is struck, in runs of geometric length with mean `mean_length`; a mean of
    ``1 / (1 - share)`` is that of independent poses.
    """
    leave, enter = 1.0 / mean_length, share / ((1.0 - share) * mean_length)
    chance = rng.random(count)
    struck = np.empty(count, dtype=np.bool_)
    now = bool(chance[0] < share)
    for i in range(count):
        if i:
            now = bool(chance[i] >= leave) if now else bool(chance[i] < enter)
        struck[i] = now
    return struck


def check_number(owner: object, name: str, low: float = 0.0, high: float = np.inf) -> None:
    """Refuse a field that is not a finite number from `low` to `high`."""
    value = getattr(owner, name)
    if not (np.isfinite(value) and low <= value <= high):
        limits = f"{low:g} or more" if high == np.inf else f"{low:g} to {high:g}"
        raise ValueError(f"{type(owner).__name__}.{name}: expected {limits}, got {value}")


def check_runs(owner: object, share: float, mean_run: float) -> None:
    """Refuse a share and a mean run length, in poses, that no chain of runs can have."""
    name = type(owner).__name__
    if not 0.0 <= share < 1.0:
        raise ValueError(f"{name}.share: expected 0 to below 1, got {share}")
    if not max(1.0, share / (1.0 - share)) <= mean_run < np.inf:
        raise ValueError(
            f"{name}.mean_run: expected 1 pose or more, and {share / (1.0 - share):g} or more for "
            f"a share of {share:g}, got {mean_run}"
        )
