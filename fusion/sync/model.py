"""The residuals of camera and IMU with their derivatives, by CasADi over the project's algebra.

Every unknown enters as a small step from where the last iteration stands, so that products of
motors are all that is needed: ``M Exp(ξ)`` is ``M (1 + B)`` with ``B = -½ ξ``, to first order and
with exact derivatives. Residuals are twice the bivector of a motor near one: its logarithm to third
order, and bounded where it is far.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from motorcade.ga.algebra import Multivector
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.codegen.runtime.interpret import run_tape
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.kernels.definitions import elements as on

# Enough that NumPy computes more than it is called.
_ROWS_AT_ONCE = 4096


def interval_residuals(
    poses: tuple[FloatArray, FloatArray],
    velocities: tuple[FloatArray, FloatArray],
    bias_steps: FloatArray,
    gravity: FloatArray,
    motion: FloatArray,
    bias_jacobian: FloatArray,
    duration_s: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """What K preintegrated intervals miss between the states at their ends.

    Args:
        poses: coefficients ``(K, 8)`` of ``world_T_imu`` at starts and ends.
        velocities: ``(K, 3)`` in the world at starts and ends.
        bias_steps: ``(K, 6)``, biases at the ends minus those at the starts.
        gravity: ``(3,)`` in the world.
        motion: ``(K, 16)`` coefficients of the preintegrated pair of motors, at the start's biases.
        bias_jacobian: ``(K, 9, 6)`` of it.
        duration_s: ``(K,)``.

    Returns:
        Residuals ``(K, 15)``, rotation, position, velocity, biases, and their derivatives
        ``(K, 15, 33)`` by the start's pose, velocity, biases, the end's, and gravity.
    """
    count = len(duration_s)
    jacobian = bias_jacobian.transpose(0, 2, 1).reshape(count, 54)  # CasADi's order is by columns
    gravities = np.broadcast_to(gravity, (count, 3))
    return _interval()(
        *poses, *velocities, bias_steps, gravities, motion, jacobian, duration_s[:, None]
    )


def pose_residuals(
    poses: FloatArray, twists: FloatArray, imu_T_camera: FloatArray, measured: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How far N measured poses of the camera are from those that the IMU's poses imply.

    Args:
        poses: coefficients ``(N, 8)`` of ``world_T_imu``.
        twists: ``(N, 6)`` of the IMU, rad/s and m/s: where a later time would find it.
        imu_T_camera: ``(8,)`` of ``imu_T_camera``.
        measured: ``(N, 8)`` of ``world_T_camera``, scaled to metres.

    Returns:
        Residuals ``(N, 6)`` in the camera's axes, and their derivatives ``(N, 6, 14)`` by the
        pose, the time offset (s), the extrinsics, and the logarithm of the measurements' scale.
    """
    extrinsics = np.broadcast_to(imu_T_camera, (len(poses), 8))
    return _pose()(poses, twists, extrinsics, measured)


@dataclass(frozen=True, eq=False)
class _Traced:
    """Residuals and the derivatives that are not always zero, as one tape of scalar operations.

    Fields:
        tape: the operations; its outputs are the residuals and the derivatives.
        rows, unknowns: which residual, which unknown each of the derivatives belongs to.
        shape: how many residuals and unknowns there are.
    """

    tape: Tape
    rows: IntArray
    unknowns: IntArray
    shape: tuple[int, int]

    def __call__(self, *given: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Residuals ``(n, r)`` and derivatives ``(n, r, u)`` of n rows of each input."""
        count = len(given[0])
        residual, derivative = np.empty((count, self.shape[0])), np.zeros((count, *self.shape))
        for first in range(0, count, _ROWS_AT_ONCE):
            part = slice(first, first + _ROWS_AT_ONCE)
            columns = {
                (operand.name, i): column
                for operand, rows in zip(self.tape.inputs, given, strict=True)
                for i, column in enumerate(np.ascontiguousarray(rows[part].T))
            }
            missed, slopes = run_tape(self.tape, columns)
            for i, value in enumerate(missed):
                residual[part, i] = value
            for i, unknown, value in zip(self.rows, self.unknowns, slopes, strict=True):
                derivative[part, i, unknown] = value
        return residual, derivative


@cache
def _interval() -> _Traced:
    """Of one interval."""
    import casadi as ca

    sizes = (8, 8, 3, 3, 6, 3, 16, 54, 1)
    inputs = [ca.SX.sym(f"input{i}", size) for i, size in enumerate(sizes)]
    start, end, v0, v1, bias_step, fall, motion, jacobian, dt = inputs
    step = ca.SX.sym("step", 33)
    pose0, pose1 = _retract(start, step[:6]), _retract(end, step[15:21])
    v0, v1, fall = v0 + step[6:9], v1 + step[21:24], fall + step[30:]
    # Gravity and the first velocity taken back: the pose and the velocity that force alone makes.
    place = ~pose0 * _translator(-(v0 * dt + 0.5 * fall * dt**2)) * pose1
    speed = ~_turned(pose0, v0) * _translator(-fall * dt) * _turned(pose1, v1)
    summed = [on.MOTOR.of(_listed(motion[8 * i : 8 * i + 8])) for i in range(2)]
    shifted, gained = (_difference(a, b) for a, b in zip(summed, (place, speed), strict=True))
    by_bias = ca.reshape(jacobian, 9, 6) @ step[9:15]
    residual = ca.vertcat(shifted, gained[3:]) - by_bias
    residual = ca.vertcat(residual, bias_step + step[24:30] - step[9:15])
    return _traced("interval", inputs, residual, step)


@cache
def _pose() -> _Traced:
    """Of one measured pose."""
    import casadi as ca

    inputs = [ca.SX.sym(f"input{i}", size) for i, size in enumerate((8, 6, 8, 8))]
    pose, twist, imu_T_camera, measured = inputs
    step = ca.SX.sym("step", 14)
    later = _retract(pose, step[:6] + step[6] * twist)
    expected = later * _retract(imu_T_camera, step[7:13])
    # The expected place shrinks where the scale grows, not the measured one grows: its noise would
    # grow with it, and the scale come out too small.
    numbers = on.MOTOR.numbers(expected)
    shrunk = on.MOTOR.of(numbers[:4] + [(1 - step[13]) * number for number in numbers[4:]])
    residual = _difference(on.MOTOR.of(_listed(measured)), shrunk)
    return _traced("pose", inputs, residual, step)


def _traced(name: str, inputs: list[Any], residual: Any, step: Any) -> _Traced:
    """The residual and its derivative by the step, where that is zero."""
    import casadi as ca

    from motorcade.ga.codegen.recording import tape_of

    zero = ca.DM.zeros(step.shape[0])
    derivative = ca.jacobian(residual, step)
    missed, slope = (ca.substitute(one, step, zero) for one in (residual, derivative))
    rows, unknowns = slope.sparsity().get_triplet()
    outputs = [_operand("missed", residual.shape[0]), _operand("slope", len(rows))]
    operands = [_operand(f"input{i}", one.shape[0]) for i, one in enumerate(inputs)]
    tape = tape_of(name, operands, outputs, inputs, [_listed(missed), slope.nonzeros()])
    return _Traced(tape, np.array(rows), np.array(unknowns), slope.shape)


def _operand(name: str, width: int) -> Operand:
    return Operand(name, tuple(map(str, range(width))))


def _listed(column: Any) -> list[Any]:
    return [column[i] for i in range(column.shape[0])]


def _retract(motor: Any, twist: Any) -> Multivector:
    """``M (1 - ½ twist)``."""
    made: Multivector = on.MOTOR.of(_listed(motor)) * (1 + on.BIVECTOR.of(_listed(-0.5 * twist)))
    return made


def _translator(shift: Any) -> Multivector:
    made: Multivector = 1 + on.MOVED.of(_listed(-0.5 * shift))
    return made


def _turned(pose: Multivector, velocity: Any) -> Multivector:
    """The motor of a pose's rotor, with the velocity in place of the position."""
    made: Multivector = _translator(velocity) * on.ROTOR.of(on.MOTOR.numbers(pose)[:4])
    return made


def _difference(measured: Multivector, expected: Multivector) -> Any:
    """Twist from one motor to the other, with the sign that turns the short way."""
    import casadi as ca

    between = on.MOTOR.numbers(~measured * expected)
    sign = ca.if_else(between[0] < 0, -1, 1)
    return -2 * sign * ca.vertcat(*between[1:7])
