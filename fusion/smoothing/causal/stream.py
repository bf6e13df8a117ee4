"""What every causal filter shares: poses in one after another, or a whole trajectory at once.

The state lives in compiled code (`motorcade.fusion.smoothing.native`) and does not grow. A filter
takes the kind of its first pose, Motor or Similarity, and keeps to it until it is reset.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from motorcade.fusion.smoothing.checks import checked_cutoff
from motorcade.fusion.smoothing.native._scans import Scan
from motorcade.fusion.smoothing.representations import Representation, representation_named
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

P = TypeVar("P", Motor, Similarity)


class CausalFilter(ABC):
    """A filter that sees a pose and those before it.

    Args:
        representation: a name of `REPRESENTATIONS`: what the filter's differences are.

    Raises:
        ValueError: an unknown representation.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import MOTIONS
        >>> from motorcade.fusion.smoothing.causal import CausalFilter, ConstantVelocityFilter
        >>> from motorcade.fusion.smoothing.causal import OneEuro
        >>> path = MOTIONS["handheld"].sampled(rate_hz=30.0, duration_s=1.0)
        >>> def streamed(live: CausalFilter) -> list:
        ...     return [live.update(*one) for one in zip(path.motors, path.time_ns, strict=True)]
        >>> for live in (OneEuro(), ConstantVelocityFilter(noise_m=0.005, noise_rad=0.01)):
        ...     last = live.smooth(path).motors[-1]
        ...     print(np.array_equal(last.coefficients, streamed(live)[-1].coefficients))
        True
        True
    """

    _cutoffs_hz: ClassVar[tuple[str, ...]] = ()

    def __init__(self, representation: str = "motor") -> None:
        self._averaged_as = representation_named(representation)
        self.representation = representation
        self.reset()

    @abstractmethod
    def _scan(self, scale: bool) -> Scan:
        """A compiled filter that has seen nothing, of motors or similarities."""

    def reset(self) -> None:
        """Forget all poses; the next one begins anew and may be of another kind."""
        self._running: Scan | None = None
        self._kind: type[Motor] | type[Similarity] | None = None

    def update(self, pose: P, time_ns: int) -> P:
        """The filtered pose at a stamp, from a measured one; the first comes back as it is.

        Args:
            pose: one Motor or Similarity, no batch; the result is in float64.
            time_ns: stamp in integer nanoseconds, after those before. Gaps need no care: all steps
                are by time.

        Raises:
            ValueError: a batch of poses, a stamp that is no integer or not after the last one,
                or a result beyond float64. The filter is then as it was.
            TypeError: another kind of pose than before.
        """
        running = self._running
        if running is None or type(pose) is not self._kind:
            running = self._begin(pose)
        out = np.empty(pose._size)
        running.update(self._averaged_as.to_compiled(pose).coefficients, time_ns, out)
        return self._averaged_as.from_compiled(pose._trusted(out))

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """What `update` gives for a trajectory's poses in turn, to the last bit.

        A stream that this filter is fed with goes on as if nothing had been.

        Raises:
            ValueError: a cut-off that is not below half the sampling rate (of the median interval),
                or a result beyond float64.
        """
        for name in self._cutoffs_hz:
            checked_cutoff(getattr(self, name), trajectory, name)
        scan = self._scan(isinstance(trajectory.poses, Similarity))
        return self._run(scan, trajectory)

    def _run(
        self, scan: Scan, trajectory: Trajectory, noise: FloatArray | None = None
    ) -> Trajectory:
        measured = coefficients_of(trajectory, self._averaged_as)
        out = np.empty(measured.shape, measured.dtype)
        scan.run(measured, trajectory.time_ns, out, noise)
        return trajectory_of(trajectory, out, self._averaged_as)

    def _begin(self, pose: Motor | Similarity) -> Scan:
        if not isinstance(pose, Motor | Similarity):
            raise TypeError(f"pose: expected a Motor or Similarity, got {type(pose).__name__}")
        if self._kind is not None:
            raise TypeError(
                f"pose: expected a {self._kind.__name__} like those before, got "
                f"{type(pose).__name__}; reset() begins anew"
            )
        if pose.shape:
            raise ValueError(f"pose: expected one pose, got a batch of shape {pose.shape}")
        self._running = self._scan(isinstance(pose, Similarity))
        self._kind = type(pose)
        return self._running


def coefficients_of(trajectory: Trajectory, representation: Representation) -> FloatArray:
    """Coefficients ``(N, 8)`` or ``(N, 12)`` as the compiled scans want them."""
    poses = representation.to_compiled(trajectory.poses)
    return np.ascontiguousarray(poses.coefficients, dtype=np.float64)


def trajectory_of(
    like: Trajectory, coefficients: FloatArray, representation: Representation
) -> Trajectory:
    """Scanned coefficients with the stamps and frames of the trajectory that was scanned."""
    poses = representation.from_compiled(type(like.poses)._trusted(coefficients))
    return Trajectory(like.time_ns, poses, like.parent, like.child)


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
