"""Motion and measurements as functions over symbols, made of versors, vectors, first-order errors.

An error ξ = (φ, ρ) stands on the right of a motor: ``M (1 - ½ φ·e - ½ ρ∞)``, which is
``M Exp(ξ)`` to first order; derivatives at ξ = 0 are those of the exponential.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import fitted, horner
from motorcade.ga.kernels.definitions.motors import exponential, logarithm

Numbers = list[Any]

LARGEST_TURN_RAD = 3.0
"""Turns of one step are held below this: the functions of it are polynomials of its square."""


@dataclass(frozen=True)
class Definition:
    """One C function: vectors in, vectors out."""

    name: str
    summary: tuple[str, ...]
    inputs: tuple[Operand, ...]
    outputs: tuple[Operand, ...]
    define: Callable[..., Sequence[Numbers]]


def symbols(name: str, count: int) -> Any:
    """A CasADi vector."""
    import casadi as ca

    return ca.SX.sym(name, count)


def disturbed(pose: Multivector, error: Numbers) -> Multivector:
    """The motor with an error ``(6,)`` on its right, to first order."""
    half = on.BIVECTOR.of([-0.5 * value for value in error])
    return pose + pose * half


def error_of(motor: Multivector) -> Numbers:
    """The twist ``(6,)`` of a motor near one, to first order."""
    return [-2 * value for value in on.BIVECTOR.numbers(motor)]


def translated(by: Numbers) -> Multivector:
    """The translator ``1 - ½ t∞``."""
    return on.MOTOR.of([1.0, 0.0, 0.0, 0.0, *(-0.5 * value for value in by), 0.0])


def rotated(rotor: Multivector, vector: Numbers) -> Numbers:
    """``R x ~R``."""
    return on.VECTOR.numbers(rotor * on.VECTOR.of(vector) * ~rotor)


def cross(turn: Numbers, vector: Numbers) -> Numbers:
    """``φ × x``, the commutator of a vector with the bivector of a turn."""
    plane, x = on.ANGLES.of(turn), on.VECTOR.of(vector)
    return on.VECTOR.numbers(0.5 * (x * plane - plane * x))


def motor_at(numbers: Numbers) -> tuple[Multivector, Multivector, Numbers]:
    """A motor of eight coefficients, its rotor and its translation."""
    motor, rotor = on.MOTOR.of(numbers), on.ROTOR.of(numbers[:4])
    return motor, rotor, on.translation_numbers(motor * ~rotor)


def derivative(values: Numbers, by: Any) -> Any:
    """Jacobian of numbers by a CasADi vector, at its zero."""
    import casadi as ca

    column = ca.vertcat(*map(ca.SX, values))
    return ca.substitute(ca.jacobian(column, by), by, ca.SX.zeros(by.shape[0]))


def blocks(matrix: Any, rows: slice, columns: slice) -> Numbers:
    """A part of a matrix by rows."""
    part = matrix[rows, columns]
    return [part[i, j] for i in range(part.shape[0]) for j in range(part.shape[1])]


def turn_functions(square: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
    """``cos ½x``, ``sin(½x) / ½x``, and four remainders of the series of sine and cosine, of x².

    The remainders are ``third = (x - sin x) / x³``, ``fourth = (½x² - 1 + cos x) / x⁴``,
    ``fifth = (1/6 - third) / x²`` and ``sixth = (1/24 - fourth) / x²``. For x up to
    `LARGEST_TURN_RAD`, as polynomials that can be differentiated at zero.
    """
    last, error = LARGEST_TURN_RAD**2 + 0.1, DOUBLE.epsilon / 16
    cosine, sinc, fifth, sixth = (
        horner(fitted(function, 0, last, error), square)
        for function in (_cosine_half, _sinc_half, _fifth, _sixth)
    )
    return cosine, sinc, 1 / 6 - square * fifth, 1 / 24 - square * sixth, fifth, sixth


def _cosine_half(y: Any) -> Any:
    import mpmath as mp

    return mp.cos(mp.sqrt(y) / 2)


def _sinc_half(y: Any) -> Any:
    import mpmath as mp

    half = mp.sqrt(y) / 2
    return mp.sin(half) / half


def _fifth(y: Any) -> Any:
    import mpmath as mp

    with mp.extradps(80):
        x = mp.sqrt(y)
        return (x**3 / 6 - x + mp.sin(x)) / x**5


def _sixth(y: Any) -> Any:
    import mpmath as mp

    with mp.extradps(80):
        return (y**2 / 24 - y / 2 + 1 - mp.cos(mp.sqrt(y))) / y**3


# How a moving IMU's state goes on over one interval of constant rate and force, and its error.
#
#     M' = T(v Δt + ½ g Δt²) M ΔM,    v' = v + g Δt + R Δv ~R,    ΔM = T(Δp) ΔR
#
# with the turn φ = (rate - bias) Δt, ``ΔR = exp(-½ φ·e)``, ``Δv = ∫₀¹ Exp(sφ) ds f Δt`` and ``Δp =
# ∫₀¹ (1-s) Exp(sφ) ds f Δt²`` of the force f = force - bias, holds exactly. Errors stand on the
# right of the extended pose, ``true = (M Exp(φ, ρ), v + R ν ~R)``; their motion does not depend on
# the state (A. Barrau and S. Bonnabel, The invariant extended Kalman filter as a stable observer,
# IEEE TAC 62(4), 2017), so that its derivative is taken at the origin, at rest, where it is
# shortest. Only where the direction of gravity is estimated does it depend on the attitude.


def increment(
    rate: Numbers, force: Numbers, dt: Any, *, held: bool = False
) -> tuple[Multivector, Numbers, Numbers]:
    """The rotor ΔR, and Δv and Δp in the axes at the interval's start; biases are taken off.

    `held` keeps the force in those axes for the whole interval, as gtsam does on its manifold.
    """
    turn = [value * dt for value in rate]
    cosine, sinc, third, fourth, *_ = turn_functions(sum(value * value for value in turn))
    rotor = on.ROTOR.of([cosine, *(-0.5 * sinc * value for value in turn)])
    if held:
        gained = [dt * f for f in force]
        return rotor, gained, [0.5 * dt * v for v in gained]
    once = cross(turn, force)
    twice = cross(turn, once)
    second = 0.5 * sinc * sinc  # (1 - cos x) / x²
    velocity = [
        dt * (f + second * a + third * b) for f, a, b in zip(force, once, twice, strict=True)
    ]
    position = [
        dt * dt * (0.5 * f + third * a + fourth * b)
        for f, a, b in zip(force, once, twice, strict=True)
    ]
    return rotor, velocity, position


def advanced(
    pose: Numbers, velocity: Numbers, rate: Numbers, force: Numbers, dt: Any, gravity: Numbers,
    *, held: bool = False,
) -> tuple[Multivector, Numbers]:  # fmt: skip
    """Motor and velocity after an interval."""
    motor, rotor, _ = motor_at(pose)
    turn, gained, shifted = increment(rate, force, dt, held=held)
    fallen = [v * dt + 0.5 * g * dt * dt for v, g in zip(velocity, gravity, strict=True)]
    faster = rotated(rotor, gained)
    return (
        translated(fallen) * motor * (translated(shifted) * turn),
        [v + g * dt + a for v, g, a in zip(velocity, gravity, faster, strict=True)],
    )


def _less(values: Numbers, bias: Numbers) -> Numbers:
    return [value - off for value, off in zip(values, bias, strict=True)]


def _step(
    pose: Numbers, velocity: Numbers, bias: Numbers, rate: Numbers, force: Numbers, dt: Numbers,
    gravity: Numbers, *, held: bool = False,
) -> list[Numbers]:  # fmt: skip
    """The next pose, kept unit by ``m (3 - m ~m) / 2``, and the next velocity."""
    plain = _less(rate, bias[:3]), _less(force, bias[3:])
    motor, faster = advanced(pose, velocity, *plain, dt[0], gravity, held=held)
    excess = on.DUAL.of(on.DUAL.numbers(motor * ~motor))
    return [on.MOTOR.numbers(motor * (1.5 - 0.5 * excess)), faster]


def _transition(
    bias: Numbers, rate: Numbers, force: Numbers, dt: Numbers, *, held: bool = False
) -> list[Numbers]:
    """Blocks of the error's transition over the interval; see `MOTION`.

    With ``B = Exp(-φ)`` turn and velocity are carried by B, what the force moved by ``-B [Δv]×``,
    and a bias by derivatives of the integrals: ``∫ Exp(-sφ) ds`` is ``1 - second [φ]× + third
    [φ]×²``, where of x = ‖φ‖ ``second = (1 - cos x) / x²``. A test holds them against derivatives.
    """
    rate, force, h = _less(rate, bias[:3]), _less(force, bias[3:]), dt[0]
    turn = [value * h for value in rate]
    cosine, sinc, third, fourth, fifth, sixth = turn_functions(sum(v * v for v in turn))
    second = 0.5 * sinc * sinc
    across = _crossing(turn)
    twice = _times(across, across)
    back = _sum((1, _ONE), (-sinc * cosine, across), (second, twice))
    right = _sum((-h, _ONE), (h * second, across), (-h * third, twice))
    _, gained, shifted = increment(rate, force, h, held=held)
    velocity_accel, velocity_gyro = right, _NONE
    position_accel, position_gyro = _sum((-0.5 * h * h, back)), _NONE
    if held:
        velocity_accel = _sum((-h, back))
    else:
        position_accel = _sum(
            (-0.5 * h * h, _ONE),
            (h * h * (second - third), across),
            (h * h * (fourth - third), twice),
        )
        # Of the coefficients by x², twice.
        slopes = 2 * fourth - third, 3 * fifth - fourth, 4 * sixth - fifth
        once = cross(turn, force)
        fast = _by_turn(turn, force, once, (second, third), slopes[:2])
        far = _by_turn(turn, force, once, (third, fourth), slopes[1:])
        velocity_gyro = _sum((-h * h, _times(back, fast)))
        position_gyro = _sum((-h * h * h, _times(back, far)))
    transition = (
        back, _sum((-1, _times(back, _crossing(shifted)))),
        _sum((-1, _times(back, _crossing(gained)))), right, position_gyro, velocity_gyro,
        position_accel, velocity_accel,
    )  # fmt: skip
    return [[value for row in block for value in row] for block in transition]


def _by_turn(
    turn: Numbers, force: Numbers, once: Numbers, factors: tuple[Any, Any], slopes: tuple[Any, ...]
) -> list[Numbers]:
    """Derivative of ``a φ × f + b φ × (φ × f)`` by φ; a and b have these derivatives by ½x²."""
    along = [slopes[0] * a + slopes[1] * b for a, b in zip(once, cross(turn, once), strict=True)]
    return _sum(
        (-factors[0], _crossing(force)),
        (-factors[1], _crossing(once)),
        (-factors[1], _times(_crossing(turn), _crossing(force))),
        (1, [[a * t for t in turn] for a in along]),
    )


_ONE: list[Numbers] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
_NONE: list[Numbers] = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]


def _crossing(v: Numbers) -> list[Numbers]:
    """The matrix of ``v ×``."""
    return [[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]


def _times(a: list[Numbers], b: list[Numbers]) -> list[Numbers]:
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def _sum(*parts: tuple[Any, list[Numbers]]) -> list[Numbers]:
    """Matrices, each times a factor."""
    return [
        [sum(factor * matrix[i][j] for factor, matrix in parts) for j in range(3)] for i in range(3)
    ]


def _gravity(gravity_rotor: Numbers, size: Numbers) -> list[Numbers]:
    """Gravity in the world: ``-z`` of the world turned by a rotor."""
    return [rotated(on.ROTOR.of(gravity_rotor), [0.0, 0.0, -size[0]])]


def _gravity_effect(
    pose: Numbers, gravity_rotor: Numbers, size: Numbers, dt: Numbers
) -> list[Numbers]:
    """What tilting that rotor does to the error's velocity, in the axes of the pose at the end."""
    tilt = symbols("tilt", 2)
    rotor, upright = on.ROTOR.of(pose[:4]), on.ROTOR.of(gravity_rotor)
    tilted = upright + upright * on.ANGLES.of([-0.5 * tilt[0], -0.5 * tilt[1], 0.0])
    fall = rotated(~rotor, rotated(tilted, [0.0, 0.0, -size[0]]))
    matrix = derivative(fall, tilt)
    return [[dt[0] * value for value in blocks(matrix, slice(0, 3), slice(0, 2))]]


def _matrix(name: str, columns: int = 3) -> Operand:
    return on.components(name, 3, columns)


_POSE, _VELOCITY = on.MOTOR.operand("pose"), on.VECTOR.operand("velocity")
_BIAS = Operand("bias", tuple(f"{kind}_{axis}" for kind in ("gyro", "accel") for axis in "xyz"))
_RATE, _FORCE, _DT = on.VECTOR.operand("rate"), on.VECTOR.operand("force"), on.numbers("dt")
_GRAVITY, _SIZE = on.ROTOR.operand("gravity_rotor"), on.numbers("size")

_STEP_IN = (_POSE, _VELOCITY, _BIAS, _RATE, _FORCE, _DT, on.VECTOR.operand("gravity"))
_STEP_OUT = on.MOTOR.operand("next_pose"), on.VECTOR.operand("next_velocity")
_BLOCKS = tuple(
    _matrix(name)
    for name in (
        "turn_turn", "position_turn", "velocity_turn", "turn_gyro", "position_gyro",
        "velocity_gyro", "position_accel", "velocity_accel",
    )
)  # fmt: skip

MOTION = (
    Definition(
        "motorcade_step",
        ("The state after an interval dt (s) of constant rate (rad/s) and force (m/s²), which are",
         "what the sensor read; |rate - bias| dt must be at most 3 rad."),
        _STEP_IN, _STEP_OUT, _step,
    ),
    Definition(
        "motorcade_transition",
        ("The error's transition over that interval, in blocks of 3x3 by rows: turn_turn is also",
         "that of position and of velocity on themselves, and dt times it that of position on",
         "velocity; the others are zero, biases stay."),
        (_BIAS, _RATE, _FORCE, _DT), _BLOCKS, _transition,
    ),
    Definition(
        "motorcade_held_step",
        ("As motorcade_step, but the force acts in the axes at the start for the whole interval.",),
        _STEP_IN, _STEP_OUT, partial(_step, held=True),
    ),
    Definition(
        "motorcade_held_transition",
        ("The error's transition over a held step.",),
        (_BIAS, _RATE, _FORCE, _DT), _BLOCKS, partial(_transition, held=True),
    ),
    Definition(
        "motorcade_gravity",
        ("Gravity (m/s²) in the world: its size along -z turned by a rotor.",),
        (_GRAVITY, _SIZE),
        (on.VECTOR.operand("gravity"),),
        _gravity,
    ),
    Definition(
        "motorcade_gravity_effect",
        ("What a tilt of gravity, an error on its right about its x and y, adds over dt (s) to",
         "the error's velocity, 3x2 by rows, in the axes of the pose; dt/2 times it to position."),
        (_POSE, _GRAVITY, _SIZE, _DT),
        (_matrix("velocity_tilt", 2),),
        _gravity_effect,
    ),
)  # fmt: skip


# What is measured, as functions of the state, and how its error moves them.
#
# Residuals are measurement less prediction. Their derivative by the error at the right of the pose
# M, and at the right of the camera's pose X on the IMU, is taken where they vanish. That of a pose
# does not depend on M at all.

_STILL = [1.0, *[0.0] * 7]


def _pose(pose: Numbers, imu_T_camera: Numbers, measured: Numbers) -> list[Numbers]:
    predicted = on.MOTOR.of(pose) * on.MOTOR.of(imu_T_camera)
    bivector = logarithm(DOUBLE, ~predicted * on.MOTOR.of(measured), short_way=True)
    return [[-2 * value for value in on.BIVECTOR.numbers(bivector)]]


def _pose_effect(imu_T_camera: Numbers) -> list[Numbers]:
    xi = symbols("xi", 6)
    camera = on.MOTOR.of(imu_T_camera)
    perturbed = ~camera * disturbed(on.MOTOR.of(_STILL), [xi[i] for i in range(6)]) * camera
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


_EXTRINSICS = on.MOTOR.operand("imu_T_camera")
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
