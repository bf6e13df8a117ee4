"""Poses as numbers that a linear smoother can average: motors, quaternions, Euler angles (twice).

Each representation says how a trajectory is written down once (`chart`), which numbers are averaged
around a pose (`around`), and how an average becomes a pose again (`back`). Quaternions and Euler
angles are averaged the way practitioners do it, component by component beside the translation;
motors in the tangent space at the pose itself, where rotation and translation stay one screw.
Euler angles come twice: as they are ("euler"), and made continuous over time first, as a careful
practitioner does ("euler_unwrapped"). Gimbal lock harms both: the pitch folds back at ±90° while
the other two leap by half a turn. Naive averages are off by radians there; unwrapped ones lose the
tip of the fold, a few degrees in turns of some radians a second.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from motorcade.ga import FloatArray, Motor

__all__ = ["REPRESENTATIONS", "Representation"]


class Representation(Protocol):
    """How poses turn into averaged numbers and back; D numbers written down, d averaged."""

    def chart(self, poses: Motor) -> FloatArray:
        """Write down a trajectory's poses (N,) as (N, D)."""
        ...

    def around(self, chart: FloatArray, centre: FloatArray) -> FloatArray:
        """Numbers (*, K, d) to average for K neighbours (*, K, D) of a centre (*, 1, D)."""
        ...

    def back(self, average: FloatArray, centre: FloatArray) -> Motor:
        """Poses (*,) from averages (*, d) around centres (*, D)."""
        ...


class _Motors:
    """Twists from the centre pose to its neighbours: independent of world and sensor frame."""

    def chart(self, poses: Motor) -> FloatArray:
        return poses.coefficients

    def around(self, chart: FloatArray, centre: FloatArray) -> FloatArray:
        return (Motor(centre).inverse() @ Motor(chart)).as_twist()

    def back(self, average: FloatArray, centre: FloatArray) -> Motor:
        return Motor(centre) @ Motor.from_twist(average)


class _Quaternions:
    """Components of quaternions whose signs follow each other, averaged and renormalised."""

    def chart(self, poses: Motor) -> FloatArray:
        wxyz, translation = poses.as_quaternion_translation()
        turns = np.sum(wxyz[1:] * wxyz[:-1], axis=-1) < 0.0
        signs = np.where(np.concatenate([[False], np.cumsum(turns) % 2 == 1]), -1.0, 1.0)
        return np.concatenate([signs[:, None] * wxyz, translation], axis=-1)

    def around(self, chart: FloatArray, centre: FloatArray) -> FloatArray:
        return chart

    def back(self, average: FloatArray, centre: FloatArray) -> Motor:
        wxyz = average[..., :4]
        unit = wxyz / np.linalg.norm(wxyz, axis=-1, keepdims=True)
        return Motor.from_quaternion_translation(unit, average[..., 4:])


class _EulerAngles:
    """Intrinsic x-y′-z″ angles as they come, each averaged for itself: at ±π they leap."""

    def chart(self, poses: Motor) -> FloatArray:
        angles, translation = poses.as_euler_translation("xyz")
        return np.concatenate([angles, translation], axis=-1)

    def around(self, chart: FloatArray, centre: FloatArray) -> FloatArray:
        return chart

    def back(self, average: FloatArray, centre: FloatArray) -> Motor:
        return Motor.from_euler_translation(average[..., :3], average[..., 3:], "xyz")


class _UnwrappedEulerAngles(_EulerAngles):
    """The same angles, each made continuous over time first; the pitch still folds at ±90°."""

    def chart(self, poses: Motor) -> FloatArray:
        angles, translation = np.split(super().chart(poses), 2, axis=-1)
        return np.concatenate([np.unwrap(angles, axis=0), translation], axis=-1)


REPRESENTATIONS: dict[str, Representation] = {
    "motor": _Motors(),
    "quaternion": _Quaternions(),
    "euler_unwrapped": _UnwrappedEulerAngles(),
    "euler": _EulerAngles(),
}
"""Every representation that `smooth` runs on, by name."""
