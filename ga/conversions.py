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

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.rotor import Rotor
from motorcade.ga.versors.versor import Versor

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform, Rotation

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

V = TypeVar("V", bound=Versor)


def rotation_from_rotor(rotor: Rotor) -> Rotation:
    """A scipy ``Rotation`` of the same batch shape; the sign of each rotor is kept."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(rotor.as_quaternion(), scalar_first=True)


def rotor_from_rotation(rotation: Rotation) -> Rotor:
    """Rotors of a scipy ``Rotation``, of its batch shape; signs are kept."""
    return Rotor.from_quaternion(rotation.as_quat(scalar_first=True))


def rigid_transform_from_motor(motor: Motor) -> RigidTransform:
    """A scipy ``RigidTransform`` (from scipy 1.16) of the same batch shape."""
    from scipy.spatial.transform import RigidTransform

    rotation = rotation_from_rotor(motor.rotor)
    return RigidTransform.from_components(motor.translation_m, rotation)


def motor_from_rigid_transform(transform: RigidTransform) -> Motor:
    """Motors of a scipy ``RigidTransform``, of its batch shape.

    Raises:
        ValueError: not orthonormal to 1e-5; scipy itself takes care of that.
    """
    return Motor.from_matrix(transform.as_matrix())


def pose3_from_motor(motor: Motor) -> Any:
    """A gtsam ``Pose3`` of one motor; gtsam has no batches.

    Raises:
        ValueError: several motors.
    """
    import gtsam

    if motor.shape != ():
        raise ValueError(
            f"pose3_from_motor(motor): expected one motor, got {motor.shape}; take them in turn"
        )
    # gtsam takes a quaternion that is unit in double precision, whatever the motor has
    wxyz = motor.rotor.as_quaternion().astype(np.float64)
    rotation = gtsam.Rot3.Quaternion(*(wxyz / np.linalg.norm(wxyz)))
    return gtsam.Pose3(rotation, motor.translation_m.astype(np.float64))


def motor_from_pose3(pose: Any) -> Motor:
    """One motor of a gtsam ``Pose3``; the rotor's scalar part is not negative."""
    wxyz = pose.rotation().toQuaternion().coeffs()[[3, 0, 1, 2]]
    rotor = Rotor.from_quaternion(wxyz if wxyz[0] >= 0.0 else -wxyz)
    return Motor.from_rotor_translation(rotor, pose.translation())


def se3_from_motor(motor: Motor) -> Any:
    """A kornia ``Se3`` on the CPU, of the motor's precision; signs are kept.

    Raises:
        ValueError: more than one batch dimension, which kornia does not have.
    """
    import torch
    from kornia.geometry.liegroup import Se3, So3
    from kornia.geometry.quaternion import Quaternion

    if len(motor.shape) > 1:
        raise ValueError(
            f"se3_from_motor(motor): expected (N,) motors or one, got {motor.shape}; reshape them"
        )
    wxyz = torch.tensor(motor.rotor.as_quaternion())
    return Se3(So3(Quaternion(wxyz)), torch.tensor(motor.translation_m))


def motor_from_se3(pose: Any) -> Motor:
    """Motors of a kornia ``Se3``, of its batch shape, without its gradients; signs are kept.

    Raises:
        ValueError: a quaternion more than 1e-6 from unit, NaN or infinity.
    """
    wxyz = pose.r.q.data.detach().cpu().double().numpy()
    t = pose.t.data.detach().cpu().double().numpy()
    return Motor.from_rotor_translation(Rotor.from_quaternion(wxyz), t)


def tensor_from_versor(versor: Versor, device: Any = None) -> Any:
    """Coefficients ``(*, n)`` as a torch tensor of the same precision, copied to `device`."""
    import torch

    return torch.tensor(versor.coefficients, device=device)


def versor_from_tensor(kind: type[V], tensor: Any) -> V:
    """Versors of coefficients ``(*, n)``, copied to the CPU and without gradients.

    Args:
        kind: Rotor, Motor or Similarity.
        tensor: what the class takes; what an optimiser has moved goes through `normalize` first.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or not unit (see the class).
    """
    return kind(tensor.detach().cpu().numpy().copy())


def dm_from_versor(versor: Versor) -> Any:
    """Coefficients as a CasADi ``DM``: a column a versor, as generated CasADi functions take them.

    Raises:
        ValueError: more than one batch dimension, which CasADi does not have.
    """
    import casadi

    if len(versor.shape) > 1:
        raise ValueError(
            f"dm_from_versor(versor): expected (N,) versors or one, got {versor.shape}; "
            "reshape them"
        )
    return casadi.DM(np.atleast_2d(versor.coefficients).T.astype(np.float64))


def versor_from_dm(kind: type[V], matrix: Any) -> V:
    """Versors of a CasADi ``DM`` ``(n, N)``: shape ``(N,)``, or one versor where N is 1.

    Args:
        kind: Rotor, Motor or Similarity.
        matrix: numbers; symbols have none.

    Raises:
        ValueError: symbols, wrong rows, NaN or infinity, or not unit (see the class).
    """
    import casadi

    if not isinstance(matrix, casadi.DM):
        raise ValueError(
            f"versor_from_dm(matrix): expected a DM of numbers, got {type(matrix).__name__}"
        )
    columns = np.array(matrix.full()).T
    return kind(columns[0] if len(columns) == 1 else columns)
