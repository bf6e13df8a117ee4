"""Filters as methods of `smooth`: over a whole trajectory, with the filter's own parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from motorcade.fusion.smoothing.causal.stream import CausalFilter
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Trajectory

__all__ = ["FilterMethod"]

F = TypeVar("F", bound=CausalFilter)


class FilterMethod(Generic[F]):
    """A filter over a whole trajectory; called as ``method(trajectory, representation, **its)``.

    Parameters, their defaults and refusals are those of the filter.

    Args:
        kind: the filter.
        smoothed: what is done with a trajectory and the filter; by default the filter runs forward.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS
        >>> noisy = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> METHODS["exponential"](noisy, REPRESENTATIONS["motor"], cutoff_hz=3.0)
        Trajectory(world_T_camera, 61 poses, 2.000 s)
    """

    def __init__(
        self,
        kind: type[F],
        smoothed: Callable[[Trajectory, F], Trajectory] = lambda path, model: model.smooth(path),
    ) -> None:
        self._kind, self._smoothed = kind, smoothed
        trajectory, representation, _ = inspect.signature(self.__call__).parameters.values()
        own = [
            parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)
            for name, parameter in inspect.signature(kind).parameters.items()
            if name != "representation"
        ]
        self.__signature__ = inspect.Signature([trajectory, representation, *own])

    def __call__(
        self, trajectory: Trajectory, representation: Representation, **parameters: Any
    ) -> Trajectory:
        """Smooth a trajectory.

        Raises:
            ValueError: parameters that the filter refuses, for themselves or for the trajectory.
            TypeError: parameters that the filter does not have.
        """
        model = self._kind(**parameters, representation=representation.name)
        return self._smoothed(trajectory, model)
