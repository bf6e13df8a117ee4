"""Trajectories edited: cropped, thinned, merged, shifted in time, scaled, turned about, projected.

Each function gives a new trajectory. Definitions are those of evo (github.com/MichaelGrupp/evo), so
that what other tools made can be made here, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.rotor import Rotor
from motorcade.ga.versors.similarity import Similarity

Plane = Literal["xy", "xz", "yz"]
"""Two axes of a trajectory's parent frame."""

_NORMAL = {"xy": 2, "xz": 1, "yz": 0}


def cropped(
    trajectory: Trajectory, start_ns: int | None = None, end_ns: int | None = None
) -> Trajectory:
    """The poses from one stamp to another, both included; None: from the first, to the last.

    Raises:
        ValueError: no pose lies there.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import cropped
        >>> path = Trajectory(np.arange(5), Motor.identity((5,)))
        >>> cropped(path, 1, 3).time_ns
        array([1, 2, 3])
    """
    stamps = trajectory.time_ns
    first = int(stamps[0]) if start_ns is None else start_ns
    last = int(stamps[-1]) if end_ns is None else end_ns
    kept = (stamps >= first) & (stamps <= last)
    if not kept.any():
        raise ValueError(
            f"cropped: expected poses from {first} to {last} ns, got none; they span "
            f"{stamps[0]} to {stamps[-1]} ns"
        )
    return trajectory[kept]


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
    for one in trajectories[1:]:
        if (one.parent, one.child) != (first.parent, first.child):
            raise ValueError(
                f"merged: expected poses {first.parent}_T_{first.child}, got "
                f"{one.parent}_T_{one.child}"
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
    made = Motor.from_rotor_translation(poses.rotor, factor * poses.translation_m)
    return Trajectory(trajectory.time_ns, made, trajectory.parent, trajectory.child)


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
    made = [poses[0]]
    for step in steps:
        made.append(Motor.normalize((made[-1] @ step).coefficients))
    stacked = Motor.stack(made)
    return Trajectory(trajectory.time_ns, stacked, trajectory.parent, trajectory.child)


def projected(trajectory: Trajectory, plane: Plane) -> Trajectory:
    """Positions put onto a plane through the origin, rotations cut to a turn about its normal.

    The turn is the angle about that axis of the rotation's fixed-axis angles x, y, z (yaw for
    "xy"), as evo has it. For "xz" the angle about y is the middle one: it lies within ±90°, and a
    turn beyond folds back (`folds_back` tells where).

    Raises:
        ValueError: another plane, or similarities.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.ga.trajectory_edits import projected
        >>> world_T_camera = Motor.from_euler_translation([[0.2, 0.0, 0.0]], [[1.0, 2.0, 3.0]])
        >>> flat = projected(Trajectory(np.array([0]), world_T_camera), "xy")
        >>> flat.poses.translation_m, float(flat.poses.rotor.angle()[0])
        (array([[1., 2., 0.]]), 0.0)
    """
    normal = _normal(plane)
    poses = trajectory.motors
    angles = np.zeros((len(trajectory), 3))
    angles[:, normal] = _fixed_angles(poses.rotor)[:, normal]
    place = np.array(poses.translation_m)
    place[:, normal] = 0.0
    made = Motor.from_rotor_translation(Rotor.from_rotation_vector(angles), place)
    return Trajectory(trajectory.time_ns, made, trajectory.parent, trajectory.child)


def folds_back(trajectory: Trajectory, plane: Plane) -> NDArray[np.bool_]:
    """Whether each pose ``(N,)`` turns by more than 90° about y, which `projected` folds back.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Rotor, Trajectory
        >>> from motorcade.ga.trajectory_edits import folds_back
        >>> turns = Rotor.from_rotation_vector([[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
        >>> path = Trajectory(np.arange(2), Motor.from_rotor_translation(turns, np.zeros(3)))
        >>> folds_back(path, "xz")
        array([False,  True])
    """
    if _normal(plane) != 1:
        return np.zeros(len(trajectory), dtype=np.bool_)
    folded: NDArray[np.bool_] = np.abs(_fixed_angles(trajectory.motors.rotor)[:, 0]) > np.pi / 2
    return folded


def _normal(plane: str) -> int:
    if plane not in _NORMAL:
        raise ValueError(f"plane: expected one of {', '.join(get_args(Plane))}, got {plane!r}")
    return _NORMAL[plane]


def _fixed_angles(rotor: Rotor) -> FloatArray:
    """Angles ``(N, 3)`` about the fixed axes x, then y, then z."""
    matrix = rotor.as_matrix()
    across = np.hypot(matrix[:, 0, 0], matrix[:, 1, 0])
    steep = across <= 4.0 * np.finfo(np.float64).eps
    roll = np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])
    yaw = np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0])
    roll[steep] = np.arctan2(-matrix[steep, 1, 2], matrix[steep, 1, 1])
    yaw[steep] = 0.0
    return np.stack([roll, np.arctan2(-matrix[:, 2, 0], across), yaw], axis=1)


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
        Similarity.from_motor_scale(one.poses) if isinstance(one.poses, Motor) else one.poses
        for one in trajectories
    ]
    return Similarity(np.concatenate([poses.coefficients for poses in every]))
