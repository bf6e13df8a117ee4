"""Time a pose: what a smoother costs."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

from motorcade.ga import Trajectory


def seconds_per_pose(
    smoother: Callable[[Trajectory], Trajectory], trajectory: Trajectory, repeats: int = 3
) -> float:
    """Wall time of the fastest of `repeats` runs over the number of poses, in seconds.

    The fastest run is the one that other work disturbed least. A short trajectory also shows what
    a call costs that has nothing to do with its length.

    Raises:
        ValueError: fewer than one run.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import seconds_per_pose
        >>> from motorcade.fusion.motions import screw
        >>> path = screw().sampled(30.0, 2.0)
        >>> seconds_per_pose(lambda given: smooth(given, "gaussian"), path) > 0.0
        True
    """
    if repeats < 1:
        raise ValueError(f"repeats: expected 1 or more, got {repeats}")
    fastest_s = float("inf")
    for _ in range(repeats):
        start_s = perf_counter()
        smoother(trajectory)
        fastest_s = min(fastest_s, perf_counter() - start_s)
    return fastest_s / len(trajectory)
