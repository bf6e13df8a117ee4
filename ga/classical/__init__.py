"""Quaternions, dual quaternions and Euler angles: array functions, and poses made of them.

Quaternions are ``(*, 4)``, w first, Hamilton's; dual quaternions ``(*, 8)``, the real part first;
angles are in radians, translations in metres, batch in front. ``nearest_…`` and ``interpolate_…``
say how each is made continuous and led from one pose to the next. Conversions of Euler angles are
those of `motorcade.ga.versors.euler_angles`.

`QuaternionPose`, `DualQuaternion` and `EulerPose` are frozen poses with the verbs of the versors,
so that one test or comparison runs on all. None of it is built on the versors, whose witness it is.
"""

from __future__ import annotations

from motorcade.ga.classical.dual_quaternion import (
    dual_quaternion_apply,
    dual_quaternion_as_quaternion_translation,
    dual_quaternion_blend,
    dual_quaternion_conjugate,
    dual_quaternion_exp,
    dual_quaternion_from_quaternion_translation,
    dual_quaternion_log,
    dual_quaternion_mean,
    dual_quaternion_multiply,
    dual_quaternion_normalize,
    dual_quaternion_screw,
)
from motorcade.ga.classical.euler import (
    EulerPose,
    euler_rates_from_body,
    follow_euler,
    interpolate_euler,
    nearest_branch,
    nearest_euler,
)
from motorcade.ga.classical.pose import Pose
from motorcade.ga.classical.quaternion import (
    nearest_sign,
    quaternion_apply,
    quaternion_as_matrix,
    quaternion_as_rotation_vector,
    quaternion_conjugate,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    quaternion_mean,
    quaternion_multiply,
    quaternion_nlerp,
    quaternion_normalize,
    quaternion_slerp,
)
from motorcade.ga.classical.quaternion_poses import DualQuaternion, QuaternionPose

__all__ = [
    "DualQuaternion",
    "EulerPose",
    "Pose",
    "QuaternionPose",
    "dual_quaternion_apply",
    "dual_quaternion_as_quaternion_translation",
    "dual_quaternion_blend",
    "dual_quaternion_conjugate",
    "dual_quaternion_exp",
    "dual_quaternion_from_quaternion_translation",
    "dual_quaternion_log",
    "dual_quaternion_mean",
    "dual_quaternion_multiply",
    "dual_quaternion_normalize",
    "dual_quaternion_screw",
    "euler_rates_from_body",
    "follow_euler",
    "interpolate_euler",
    "nearest_branch",
    "nearest_euler",
    "nearest_sign",
    "quaternion_apply",
    "quaternion_as_matrix",
    "quaternion_as_rotation_vector",
    "quaternion_conjugate",
    "quaternion_from_matrix",
    "quaternion_from_rotation_vector",
    "quaternion_mean",
    "quaternion_multiply",
    "quaternion_nlerp",
    "quaternion_normalize",
    "quaternion_slerp",
]
