"""Frame-change defect: is smoothed motion the same in another world, with other extrinsics?

A smoother that is one of motions, not of numbers, commutes with a change of the world's frame
(left, ``L pose``) and of the sensor's (right, ``pose R``). The defect is how far smoothing first
and changing the frame first are apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor, Similarity, Trajectory

__all__ = ["FrameChangeDefect", "frame_change_defect"]


@dataclass(frozen=True)
class FrameChangeDefect:
    """Largest difference over all poses; left is the world's frame, right the sensor's.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import frame_change_defect
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.ga import Motor
        >>> path, rng = screw().sampled(30.0, 2.0), np.random.default_rng(0)
        >>> map_T_world, camera_T_imu = Motor.random(rng, (2,))
        >>> found = frame_change_defect(lambda given: given, path, map_T_world, camera_T_imu)
        >>> bool(found.left_m < 1e-12)
        True
    """

    left_m: float
    left_rad: float
    right_m: float
    right_rad: float


def frame_change_defect(
    smoother: Callable[[Trajectory], Trajectory],
    trajectory: Trajectory,
    left: Motor | Similarity,
    right: Motor | Similarity,
) -> FrameChangeDefect:
    """Smooth then change the frame, against change the frame then smooth, each side for itself.

    Args:
        smoother: what is judged; it must answer at the same stamps for both.
        trajectory: what it is judged on.
        left: change of the world's frame; `Motor.random` gives one of any orientation. With a
            similarity the differences are in the new world's metres.
        right: change of the sensor's frame.

    Raises:
        ValueError: a smoother whose stamps depend on the frame.

    Examples:
        >>> from functools import partial
        >>> import numpy as np
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import frame_change_defect
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.ga import Motor
        >>> path, rng = screw().sampled(30.0, 2.0), np.random.default_rng(0)
        >>> map_T_world, camera_T_imu = Motor.random(rng, (2,))
        >>> for representation in ("motor", "euler"):
        ...     smoother = partial(smooth, method="gaussian", representation=representation)
        ...     found = frame_change_defect(smoother, path, map_T_world, camera_T_imu)
        ...     print(f"{representation} {found.left_rad:.2f} rad")
        motor 0.00 rad
        euler 0.03 rad
    """
    smoothed = smoother(trajectory)
    left_m, left_rad = _apart(
        smoothed.transformed_by(left), smoother(trajectory.transformed_by(left))
    )
    right_m, right_rad = _apart(
        smoothed.transformed_by(right=right), smoother(trajectory.transformed_by(right=right))
    )
    return FrameChangeDefect(left_m, left_rad, right_m, right_rad)


def _apart(first: Trajectory, second: Trajectory) -> tuple[float, float]:
    if not np.array_equal(first.time_ns, second.time_ns):
        raise ValueError(
            f"smoother: expected the same stamps in every frame, got {len(first)} and "
            f"{len(second)} poses at stamps that differ"
        )
    shift = first.poses.translation_m - second.poses.translation_m
    turn = first.poses.rotor.inverse() @ second.poses.rotor
    return float(np.max(np.linalg.norm(shift, axis=-1))), float(np.max(turn.angle()))
