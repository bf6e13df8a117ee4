"""How a moving IMU's state goes on over one interval of constant rate and force, and its error.

    M' = T(v Δt + ½ g Δt²) M ΔM,    v' = v + g Δt + R Δv ~R,    ΔM = T(Δp) ΔR

with the turn φ = (rate - bias) Δt, ``ΔR = exp(-½ φ·e)``, ``Δv = ∫₀¹ Exp(sφ) ds f Δt`` and
``Δp = ∫₀¹ (1-s) Exp(sφ) ds f Δt²`` of the force f = force - bias, holds exactly. Errors stand on
the right of the extended pose, ``true = (M Exp(φ, ρ), v + R ν ~R)``; their motion does not depend
on the state (A. Barrau and S. Bonnabel, The invariant extended Kalman filter as a stable observer,
IEEE TAC 62(4), 2017), so that its derivative is taken at the origin, at rest, where it is shortest.
Only where the direction of gravity is estimated does it depend on the attitude.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from motorcade.fusion.filter.model.symbols import (
    Definition,
    Numbers,
    blocks,
    cross,
    derivative,
    motor_at,
    rotated,
    symbols,
    translated,
    turn_functions,
)
from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on


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
