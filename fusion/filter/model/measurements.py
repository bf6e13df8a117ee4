"""What is measured, as functions of the state, and how its error moves them.

Residuals are measurement less prediction. Their derivative by the error at the right of the pose
M, and at the right of the camera's pose X on the IMU, is taken where they vanish. That of a pose
does not depend on M at all.
"""

from __future__ import annotations

from typing import Any

from motorcade.fusion.filter.model.symbols import (
    Definition,
    Numbers,
    blocks,
    derivative,
    disturbed,
    error_of,
    motor_at,
    rotated,
    symbols,
    translated,
)
from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.motors import exponential, logarithm

_ONE = [1.0, *[0.0] * 7]


def _pose(pose: Numbers, imu_T_camera: Numbers, measured: Numbers) -> list[Numbers]:
    predicted = on.MOTOR.of(pose) * on.MOTOR.of(imu_T_camera)
    bivector = logarithm(DOUBLE, ~predicted * on.MOTOR.of(measured), short_way=True)
    return [[-2 * value for value in on.BIVECTOR.numbers(bivector)]]


def _pose_effect(imu_T_camera: Numbers) -> list[Numbers]:
    xi = symbols("xi", 6)
    camera = on.MOTOR.of(imu_T_camera)
    perturbed = ~camera * disturbed(on.MOTOR.of(_ONE), [xi[i] for i in range(6)]) * camera
    return [blocks(derivative(error_of(perturbed), xi), slice(0, 6), slice(0, 6))]


def _point(pose: Numbers, arm: Numbers) -> list[Numbers]:
    """Where a point fixed to the IMU is in the world, and how that moves with the pose's error."""
    xi = symbols("xi", 6)
    at = _placed(on.MOTOR.of(pose), arm)
    perturbed = disturbed(on.MOTOR.of(pose), [xi[i] for i in range(6)])
    effect = derivative(_placed(perturbed, arm), xi)
    return [at, blocks(effect, slice(0, 3), slice(0, 6))]


def _placed(motor: Multivector, point: Numbers) -> Numbers:
    _, rotor, _ = motor_at(on.MOTOR.numbers(motor))
    turned = rotated(rotor, point)
    shift = on.translation_numbers(motor * ~rotor)
    return [a + b for a, b in zip(turned, shift, strict=True)]


def _velocity_effect(pose: Numbers) -> list[Numbers]:
    nu = symbols("nu", 3)
    perturbed = rotated(on.ROTOR.of(pose[:4]), [nu[i] for i in range(3)])
    return [blocks(derivative(perturbed, nu), slice(0, 3), slice(0, 3))]


def _corner(pose: Numbers, imu_T_camera: Numbers, point: Numbers) -> list[Numbers]:
    """A point of the world on the plane z = 1 of the camera, its depth, and the effects of both."""
    xi, eta = symbols("xi", 6), symbols("eta", 6)
    motor, camera = on.MOTOR.of(pose), on.MOTOR.of(imu_T_camera)
    seen = _seen(motor * camera, point)
    perturbed = _seen(disturbed(motor, [xi[i] for i in range(6)]) * camera, point)
    shifted = _seen(motor * disturbed(camera, [eta[i] for i in range(6)]), point)
    effects = [
        blocks(derivative(value[:2], by), slice(0, 2), slice(0, 6))
        for value, by in ((perturbed, xi), (shifted, eta))
    ]
    return [seen[:2], seen[2:], *effects]


def _seen(camera: Multivector, point: Numbers) -> Numbers:
    x, y, depth = _placed(~camera, point)
    return [x / depth, y / depth, depth]


def _retract(pose: Numbers, error: Numbers) -> list[Numbers]:
    """``M Exp(ξ)``, unit to rounding whatever the pose was; turns are held below π."""
    half = on.BIVECTOR.of([-0.5 * value for value in error])
    motor: Any = on.MOTOR.of(pose) * exponential(DOUBLE, half)
    excess = on.DUAL.of(on.DUAL.numbers(motor * ~motor))
    return [on.MOTOR.numbers(motor * (1.5 - 0.5 * excess))]


def _corrected(pose: Numbers, velocity: Numbers, error: Numbers) -> list[Numbers]:
    """Pose and velocity retracted as one extended pose: each as the pose of a motor of its own."""
    carrier = translated(velocity) * on.ROTOR.of(pose[:4])
    faster = motor_at(_retract(on.MOTOR.numbers(carrier), [*error[:3], *error[6:]])[0])[2]
    return [*_retract(pose, error[:6]), faster]


def _start(measured: Numbers, imu_T_camera: Numbers) -> list[Numbers]:
    """The IMU's pose by a measured one of the camera, and how that one's error turns up in it."""
    return [
        on.MOTOR.numbers(on.MOTOR.of(measured) * ~on.MOTOR.of(imu_T_camera)),
        *_pose_effect(on.MOTOR.numbers(~on.MOTOR.of(imu_T_camera))),
    ]


_POSE, _EXTRINSICS = on.MOTOR.operand("pose"), on.MOTOR.operand("imu_T_camera")
_ERROR = Operand("error", tuple(f"{kind}_{axis}" for kind in ("turn", "shift") for axis in "xyz"))
_FASTER = ("speed_x", "speed_y", "speed_z")

MEASUREMENTS = (
    Definition(
        "motorcade_retract",
        ("A motor with an error (rad, m) on its right.",),
        (_POSE, _ERROR),
        (on.MOTOR.operand("out"),),
        _retract,
    ),
    Definition(
        "motorcade_corrected",
        ("Pose and velocity with an error (rad, m, m/s) on the right of the extended pose.",),
        (_POSE, on.VECTOR.operand("velocity"), Operand("error", (*_ERROR.components, *_FASTER))),
        (on.MOTOR.operand("out"), on.VECTOR.operand("out_velocity")),
        _corrected,
    ),
    Definition(
        "motorcade_start",
        ("The IMU's pose by a measured one of the camera, and how an error on the right of the",
         "measured one turns up on its right, 6x6 by rows."),
        (on.MOTOR.operand("measured"), _EXTRINSICS),
        (on.MOTOR.operand("pose"), on.components("effect", 6, 6)),
        _start,
    ),
    Definition(
        "motorcade_pose_residual",
        ("Twist (rad, m) to the measured pose of the camera from pose times extrinsics.",),
        (_POSE, _EXTRINSICS, on.MOTOR.operand("measured")),
        (Operand("residual", _ERROR.components),),
        _pose,
    ),
    Definition(
        "motorcade_pose_effect",
        ("How an error of the pose turns up behind the extrinsics, 6x6 by rows.",),
        (_EXTRINSICS,),
        (on.components("effect", 6, 6),),
        _pose_effect,
    ),
    Definition(
        "motorcade_point",
        ("A point (m) fixed to the IMU, in the world, and how the pose's error moves it, 3x6.",),
        (_POSE, on.VECTOR.operand("arm")),
        (on.VECTOR.operand("at"), on.components("effect", 3, 6)),
        _point,
    ),
    Definition(
        "motorcade_velocity_effect",
        ("How the error of the velocity, in the IMU's axes, moves it in the world's, 3x3.",),
        (_POSE,),
        (on.components("effect", 3, 3),),
        _velocity_effect,
    ),
    Definition(
        "motorcade_corner",
        ("A point (m) of the world on the camera's plane z = 1, its depth (m) there, and how the",
         "errors of the pose and of the extrinsics move it, 2x6 each."),
        (_POSE, _EXTRINSICS, on.VECTOR.operand("point")),
        (Operand("seen", ("x", "y")), on.numbers("depth"), on.components("pose_effect", 2, 6),
         on.components("extrinsics_effect", 2, 6)),
        _corner,
    ),
)  # fmt: skip
