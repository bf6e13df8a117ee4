"""The residuals of camera and IMU by symbols, and ``python -m motorcade.fusion.sync.model``, which
writes them and their derivatives as NumPy's functions, by CasADi over the project's algebra.

Every unknown enters as a small step from where the last iteration stands, so that products of
motors are all that is needed: ``M Exp(ξ)`` is ``M (1 + B)`` with ``B = -½ ξ``, to first order and
with exact derivatives. Residuals are twice the bivector of a motor near one: its logarithm to third
order, and bounded where it is far.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.numpy import kernel_function
from motorcade.ga.kernels.definitions import elements as on

GENERATED = Path(__file__).resolve().parent / "generated" / "residuals.py"
_OPENING = '''"""Residuals of camera and IMU; tables hold (residual, unknown) of each derivative.

Written by ``python -m motorcade.fusion.sync.model``; edit that.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np
'''


class Residual(NamedTuple):
    """A residual to generate.

    `define` takes the step in the unknowns, and the inputs, which `widths` names in their order,
    as CasADi's vectors.
    """

    name: str
    summary: str
    widths: dict[str, int]
    unknowns: int
    define: Callable[..., Any]


def residuals_source() -> str:
    """The text of the generated module.

    Raises:
        ModuleNotFoundError: without CasADi, which only this needs.
    """
    parts = [_OPENING.rstrip("\n")]
    for residual in RESIDUALS:
        places, kernel = _traced(residual)
        table = f"{residual.name.upper()}: tuple[tuple[int, int], ...] = ("
        lines = [", ".join(map(str, places[i : i + 10])) + "," for i in range(0, len(places), 10)]
        parts += ["\n".join([table, *(f"    {line}" for line in lines), ")"])]
        parts += ["\n" + kernel_function(kernel, DOUBLE)]
    return "\n\n".join(parts) + "\n"


def _interval(step: Any, *inputs: Any) -> Any:
    """What one preintegrated interval misses between the states at its ends."""
    import casadi as ca

    start, end, v0, v1, bias_step, fall, motion, jacobian, dt = inputs
    pose0, pose1 = _retract(start, step[:6]), _retract(end, step[15:21])
    v0, v1, fall = v0 + step[6:9], v1 + step[21:24], fall + step[30:]
    # Gravity and the first velocity taken back: the pose and the velocity that force alone makes.
    position = ~pose0 * _translator(-(v0 * dt + 0.5 * fall * dt**2)) * pose1
    speed = ~_rotated(pose0, v0) * _translator(-fall * dt) * _rotated(pose1, v1)
    summed = [on.MOTOR.of(_listed(motion[8 * i : 8 * i + 8])) for i in range(2)]
    shifted, gained = (_difference(a, b) for a, b in zip(summed, (position, speed), strict=True))
    by_bias = ca.reshape(jacobian, 9, 6) @ step[9:15]
    residual = ca.vertcat(shifted, gained[3:]) - by_bias
    return ca.vertcat(residual, bias_step + step[24:30] - step[9:15])


def _pose(step: Any, pose: Any, twist: Any, imu_T_camera: Any, measured: Any) -> Any:
    """How far one measured pose of the camera is from the one that the IMU's pose implies."""
    later = _retract(pose, step[:6] + step[6] * twist)
    expected = later * _retract(imu_T_camera, step[7:13])
    # The expected position shrinks where the scale grows, not the measured one grows: its noise
    # would grow with it, and the scale come out too small.
    numbers = on.MOTOR.numbers(expected)
    shrunk = on.MOTOR.of(numbers[:4] + [(1 - step[13]) * number for number in numbers[4:]])
    return _difference(on.MOTOR.of(_listed(measured)), shrunk)


RESIDUALS = (
    Residual(
        "interval",
        "What an interval misses: rotation, position, velocity, biases",
        {
            "start": 8,
            "end": 8,
            "velocity0": 3,
            "velocity1": 3,
            "bias_step": 6,
            "gravity": 3,
            "motion": 16,
            "bias_jacobian": 54,
            "duration": 1,
        },
        33,
        _interval,
    ),
    Residual(
        "pose",
        "What a measured pose misses: rotation, position",
        {"pose": 8, "twist": 6, "imu_T_camera": 8, "measured": 8},
        14,
        _pose,
    ),
)


def _traced(residual: Residual) -> tuple[list[tuple[int, int]], Kernel]:
    """Places of the derivatives that are not always zero, and the function of all numbers."""
    import casadi as ca

    symbols = [ca.SX.sym(*operand) for operand in residual.widths.items()]
    step = ca.SX.sym("step", residual.unknowns)
    missed = residual.define(step, *symbols)
    zero = ca.DM.zeros(residual.unknowns)
    missed, slope = ca.substitute([missed, ca.jacobian(missed, step)], [step], [zero])
    rows, unknowns = slope.sparsity().get_triplet()
    derivatives: list[Any] = slope.nonzeros()
    values = ca.Function("values", symbols, [ca.densify(ca.vertcat(missed, *derivatives))])
    operands = tuple(_operand(*operand) for operand in residual.widths.items())

    def define(_: object, *inputs: list[Any]) -> list[list[Any]]:
        vectors: list[Any] = [ca.vertcat(*column) for column in inputs]
        return [_listed(values(*vectors))]

    count = missed.shape[0] + len(rows)
    kernel = Kernel(
        residual.name, "sync", operands, (_operand("result", count),), define, residual.summary
    )
    return list(zip(rows, unknowns, strict=True)), kernel


def _operand(name: str, width: int) -> Operand:
    return Operand(name, tuple(map(str, range(width))))


def _listed(column: Any) -> list[Any]:
    return [column[i] for i in range(column.shape[0])]


def _retract(motor: Any, twist: Any) -> Multivector:
    """``M (1 - ½ twist)``."""
    return on.MOTOR.of(_listed(motor)) * (1 + on.BIVECTOR.of(_listed(-0.5 * twist)))


def _translator(shift: Any) -> Multivector:
    return 1 + on.MOVED.of(_listed(-0.5 * shift))


def _rotated(pose: Multivector, velocity: Any) -> Multivector:
    """The motor of a pose's rotor, with the velocity in place of the position."""
    return _translator(velocity) * on.ROTOR.of(on.MOTOR.numbers(pose)[:4])


def _difference(measured: Multivector, expected: Multivector) -> Any:
    """Twist from one motor to the other, with the sign that turns the short way."""
    import casadi as ca

    between = on.MOTOR.numbers(~measured * expected)
    sign = ca.if_else(between[0] < 0, -1, 1)
    return -2 * sign * ca.vertcat(*between[1:7])


if __name__ == "__main__":
    GENERATED.write_text(residuals_source(), encoding="utf-8")
    sys.stdout.write(f"{GENERATED}\n")
