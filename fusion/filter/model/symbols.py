"""What definitions are made of: versors and vectors over symbols, first-order errors, functions.

An error ξ = (φ, ρ) stands on the right of a motor: ``M (1 - ½ φ·e - ½ ρ∞)``, which is
``M Exp(ξ)`` to first order; derivatives at ξ = 0 are those of the exponential.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import fitted, horner

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
