"""Trajectories edited: thinned, merged, shifted in time, scaled, inverted, with drift.

Each function gives a new trajectory. Definitions are those of evo (github.com/MichaelGrupp/evo), so
that what other tools made can be made here, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.similarity import Similarity


def downsampled(trajectory: Trajectory, most: int) -> Trajectory:
    """At most so many poses, evenly spaced by their index, with the first and the last.

    Raises:
        ValueError: `most` is not 1 or more.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import downsampled
        >>> downsampled(Trajectory(np.arange(8), Motor.identity((8,))), 3).time_ns
        array([0, 3, 7])
    """
    if most < 1:
        raise ValueError(f"downsampled: expected 1 pose or more, got {most}")
    if len(trajectory) <= most:
        return trajectory
    return trajectory[np.linspace(0, len(trajectory) - 1, most, dtype=np.int64)]


def motion_filtered(trajectory: Trajectory, distance_m: float, angle_rad: float) -> Trajectory:
    """The first pose, and each that lies far enough from the one that was kept before it.

    Far enough is a path of `distance_m` or more since then, or a turn of `angle_rad` or more.

    Raises:
        ValueError: fewer than two poses, or a threshold that is not 0 or more.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import motion_filtered
        >>> along = np.arange(6.0)[:, None] * [0.1, 0.0, 0.0]
        >>> path = Trajectory(np.arange(6), Motor.from_translation(along))
        >>> motion_filtered(path, 0.15, 1.0).time_ns
        array([0, 2, 4])
    """
    for name, value in (("distance_m", distance_m), ("angle_rad", angle_rad)):
        if not value >= 0.0:
            raise ValueError(f"motion_filtered: {name}: expected 0 or more, got {value}")
    if len(trajectory) < 2:
        raise ValueError(f"motion_filtered: expected 2 or more poses, got {len(trajectory)}")
    along = path_lengths_m(trajectory).tolist()
    quaternions = trajectory.poses.rotor.as_quaternion().tolist()
    kept, at = [0], 0
    for index in range(1, len(trajectory)):
        far = along[index] - along[at] >= distance_m
        if far or _angle(quaternions[at], quaternions[index]) >= angle_rad:
            kept.append(index)
            at = index
    return trajectory[np.array(kept)]


def path_lengths_m(trajectory: Trajectory) -> FloatArray:
    """Length of the path from the first pose to each: ``(N,)`` metres, from 0.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import path_lengths_m
        >>> path = Trajectory(np.arange(2), Motor.from_translation([[0, 0, 0], [0, 3, 4]]))
        >>> path_lengths_m(path)
        array([0., 5.])
    """
    steps = np.linalg.norm(np.diff(trajectory.poses.translation_m, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def merged(trajectories: Sequence[Trajectory]) -> Trajectory:
    """All poses in the order of their stamps; of poses with equal stamps the first one's.

    Raises:
        ValueError: no trajectories, or some whose frames have other names.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import merged
        >>> even = Trajectory(np.array([0, 2, 4]), Motor.identity((3,)))
        >>> odd = Trajectory(np.array([1, 2, 3]), Motor.identity((3,)))
        >>> merged([even, odd]).time_ns
        array([0, 1, 2, 3, 4])
    """
    if not trajectories:
        raise ValueError("merged: expected one trajectory or more, got none")
    first = trajectories[0]
    for trajectory in trajectories[1:]:
        if (trajectory.parent, trajectory.child) != (first.parent, first.child):
            raise ValueError(
                f"merged: expected poses {first.parent}_T_{first.child}, got "
                f"{trajectory.parent}_T_{trajectory.child}"
            )
    stamps = np.concatenate([one.time_ns for one in trajectories])
    order = np.argsort(stamps, kind="stable")
    repeats = np.flatnonzero(np.diff(stamps[order]) == 0) + 1
    kept = np.delete(order, repeats)
    return Trajectory(stamps[kept], _joined(trajectories)[kept], first.parent, first.child)


def shifted(trajectory: Trajectory, offset_ns: int) -> Trajectory:
    """The same poses at stamps that are later by `offset_ns`.

    Raises:
        ValueError: stamps that end up 146 years or more from zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import shifted
        >>> shifted(Trajectory(np.array([0, 5]), Motor.identity((2,))), -5).time_ns
        array([-5,  0])
    """
    if abs(offset_ns) >= 2**62:
        raise ValueError(f"shifted: expected less than 2**62 ns, got {offset_ns}")
    stamps = trajectory.time_ns + np.int64(offset_ns)
    return Trajectory(stamps, trajectory.poses, trajectory.parent, trajectory.child)


def scaled(trajectory: Trajectory, factor: float) -> Trajectory:
    """Positions times `factor`; orientations stay.

    Raises:
        ValueError: a factor that is not above 0.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import scaled
        >>> path = Trajectory(np.array([0]), Motor.from_translation([[1.0, 2.0, 3.0]]))
        >>> scaled(path, 2.0).poses.translation_m
        array([[2., 4., 6.]])
    """
    if not 0.0 < factor < np.inf:
        raise ValueError(f"scaled: expected a factor above 0, got {factor}")
    poses = trajectory.motors
    motor = Motor.from_rotor_translation(poses.rotor, factor * poses.translation_m)
    return Trajectory(trajectory.time_ns, motor, trajectory.parent, trajectory.child)


def inverted(trajectory: Trajectory) -> Trajectory:
    """``child_T_parent``: where the parent frame is, seen from the child.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import inverted
        >>> inverted(Trajectory(np.array([0]), Motor.identity((1,)), "world", "camera"))
        Trajectory(camera_T_world, 1 poses, 0.000 s)
    """
    poses = trajectory.poses.inverse()
    return Trajectory(trajectory.time_ns, poses, trajectory.child, trajectory.parent)


def propagated(trajectory: Trajectory, right: Motor) -> Trajectory:
    """The path whose every step is ``step @ right``, from the same first pose on: growing drift.

    A step is ``pose[i].inverse() @ pose[i + 1]``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import propagated
        >>> still = Trajectory(np.arange(3), Motor.identity((3,)))
        >>> propagated(still, Motor.from_translation([1.0, 0.0, 0.0])).poses.translation_m[:, 0]
        array([0., 1., 2.])
    """
    poses = trajectory.motors
    steps = poses[:-1].inverse() @ poses[1:] @ right
    walked = [poses[0]]
    for step in steps:
        walked.append(Motor.normalize((walked[-1] @ step).coefficients))
    stacked = Motor.stack(walked)
    return Trajectory(trajectory.time_ns, stacked, trajectory.parent, trajectory.child)


def _angle(first: Sequence[float], second: Sequence[float]) -> float:
    """Angle between two rotations, unit quaternions; plain numbers, since it is asked in a loop."""
    w, x, y, z = first
    a, b, c, d = second
    along = abs(w * a + x * b + y * c + z * d)
    across = math.hypot(
        w * b - x * a - y * d + z * c, w * c + x * d - y * a - z * b, w * d - x * c + y * b - z * a
    )
    return 2.0 * math.atan2(across, along)


def _joined(trajectories: Sequence[Trajectory]) -> Motor | Similarity:
    if all(isinstance(one.poses, Motor) for one in trajectories):
        return Motor(np.concatenate([one.poses.coefficients for one in trajectories]))
    every = [
        Similarity.from_motor_scale(trajectory.poses)
        if isinstance(trajectory.poses, Motor)
        else trajectory.poses
        for trajectory in trajectories
    ]
    return Similarity(np.concatenate([poses.coefficients for poses in every]))
