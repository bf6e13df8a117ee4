"""Versors to and from other libraries' poses and arrays; each is imported only where it is used.

=============================== ============================== ==================================
library                         from a versor                  to a versor
=============================== ============================== ==================================
scipy ``Rotation``              `rotation_from_rotor`          `rotor_from_rotation`
scipy ``RigidTransform``        `rigid_transform_from_motor`   `motor_from_rigid_transform`
gtsam ``Pose3``                 `pose3_from_motor`             `motor_from_pose3`
kornia ``Se3``                  `se3_from_motor`               `motor_from_se3`
torch ``Tensor``                `tensor_from_versor`           `versor_from_tensor`
CasADi ``DM``                   `dm_from_versor`               `versor_from_dm`
=============================== ============================== ==================================

All name the same motion: ``A_T_B`` stays ``A_T_B``, the product of two stays their product.
Lengths stay in metres. ModuleNotFoundError where the library is not installed.
"""

from __future__ import annotations

from motorcade.ga.conversions.arrays import (
    dm_from_versor,
    tensor_from_versor,
    versor_from_dm,
    versor_from_tensor,
)
from motorcade.ga.conversions.poses import (
    motor_from_pose3,
    motor_from_rigid_transform,
    motor_from_se3,
    pose3_from_motor,
    rigid_transform_from_motor,
    rotation_from_rotor,
    rotor_from_rotation,
    se3_from_motor,
)

__all__ = [
    "dm_from_versor",
    "motor_from_pose3",
    "motor_from_rigid_transform",
    "motor_from_se3",
    "pose3_from_motor",
    "rigid_transform_from_motor",
    "rotation_from_rotor",
    "rotor_from_rotation",
    "se3_from_motor",
    "tensor_from_versor",
    "versor_from_dm",
    "versor_from_tensor",
]
