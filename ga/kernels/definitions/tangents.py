"""What twists do, for rotors and motors: adjoint, Jacobians of exp, retract and local.

A twist is ``-2 log``: rotation vector (rad), then translational part (m). On a bivector ``Y`` the
adjoint is ``M Y ~M`` and the left Jacobian of exp at ``X`` is ``Y + b [X, Y] + d [X, [X, Y]]`` with
the coefficients of `jacobian_series`, dual numbers ``b + b' e123∞`` on motors. Both are linear, so
that they are the same on twists. The right Jacobian is the left one at ``-X``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import Dual
from motorcade.ga.kernels.definitions.jacobian_series import (
    forward_series,
    half_turn,
    inverse_series,
)
from motorcade.ga.kernels.definitions.motors import exponential, logarithm

__all__ = ["KERNELS", "Definitions", "kernels_of", "matrix_rows"]

Numbers = list[Any]
_Numbers = Callable[[Multivector], Numbers]


class _Group(NamedTuple):
    """How versors of one kind and their bivectors are read and written."""

    versor: Callable[[Any], Multivector]
    versor_numbers: _Numbers
    bivector: Callable[[Any], Multivector]
    bivector_numbers: _Numbers
    size: int

    def half(self, twist: Numbers) -> Multivector:
        return self.bivector([-0.5 * value for value in twist])


_MOTORS = _Group(on.motor_of, on.motor_numbers, on.bivector_of, on.bivector_numbers, 6)
_ROTORS = _Group(on.rotor_of, on.rotor_numbers, on.angles_of, on.angle_numbers, 3)


def matrix_rows(column: Callable[[Numbers], Numbers], size: int) -> Numbers:
    """A linear function of twists as a matrix by rows."""
    columns = [column([float(i == k) for i in range(size)]) for k in range(size)]
    return [columns[j][i] for i in range(size) for j in range(size)]


def _adjoint(group: _Group, precision: Precision, m: Numbers) -> list[Numbers]:
    return [matrix_rows(lambda y: _transform_twist(group, precision, m, y)[0], group.size)]


def _transform_twist(
    group: _Group, precision: Precision, m: Numbers, twist: Numbers
) -> list[Numbers]:
    versor = group.versor(m)
    return [group.bivector_numbers(versor * group.bivector(twist) * ~versor)]


def _left_jacobian(group: _Group, precision: Precision, twist: Numbers) -> list[Numbers]:
    x = group.half(twist)
    z, dual_z = on.dual_numbers(-(x * x))
    b, d = forward_series(precision, half_turn(precision, z))
    return _series_rows(group, x, _dual(b, dual_z), _dual(d, dual_z))


def _left_jacobian_inverse(group: _Group, precision: Precision, twist: Numbers) -> list[Numbers]:
    x = group.half(twist)
    z, dual_z = on.dual_numbers(-(x * x))
    c = inverse_series(precision, half_turn(precision, z))
    return _series_rows(group, x, on.dual_of((-0.5, 0)), _dual(c, dual_z))


def _series_rows(
    group: _Group, x: Multivector, first: Multivector, second: Multivector
) -> list[Numbers]:
    """``1 + first ad + second ad²`` by rows; ``a.commutator(b)`` is ``½ [a, b]``."""

    def column(y: Numbers) -> Numbers:
        once = 2 * x.commutator(group.bivector(y))
        twice = 2 * x.commutator(once)
        return group.bivector_numbers(group.bivector(y) + first * once + second * twice)

    return [matrix_rows(column, group.size)]


def _dual(value: Dual, dual_z: Any) -> Multivector:
    return on.dual_of((value[0], value[1] * dual_z))


def _retract(group: _Group, precision: Precision, m: Numbers, twist: Numbers) -> list[Numbers]:
    step = exponential(precision, group.half(twist))
    return [group.versor_numbers(group.versor(m) * step)]


def _local(group: _Group, precision: Precision, a: Numbers, b: Numbers) -> list[Numbers]:
    log = logarithm(precision, ~group.versor(a) * group.versor(b), True)
    return [[-2 * value for value in group.bivector_numbers(log)]]


class Definitions(NamedTuple):
    """The six definitions of one kind of versor."""

    adjoint: Callable[..., list[Numbers]]
    transform_twist: Callable[..., list[Numbers]]
    left_jacobian: Callable[..., list[Numbers]]
    left_jacobian_inverse: Callable[..., list[Numbers]]
    retract: Callable[..., list[Numbers]]
    local: Callable[..., list[Numbers]]


def kernels_of(
    prefix: str, versor: Callable[[str], Operand], size: int, define: Definitions
) -> tuple[Kernel, ...]:
    """The kernels of one kind of versor, whose twists have `size` numbers."""
    one, m, out, others = f"{prefix or 'motor'}", versor("m"), versor("out"), map(versor, "ab")
    twist, made = on.twist("twist", size), on.twist("out", size)
    square = on.components("out", size, size)
    name = f"{prefix}_" if prefix else ""
    group, jacobians = f"{name}tangents", f"{name}jacobians"
    adjoint = f"Adjoint matrix of a {one} on twists"
    other_side = f"A twist seen from the other side of a {one}"
    left = f"Left Jacobian of a {one}'s exponential at a twist"
    inverse = f"Inverse left Jacobian of a {one}'s exponential, singular at full turns"
    retract = f"A {one} moved by a twist in its own frame"
    local = f"The twist, turning by at most π, that takes {one} a to b"

    def kernel(
        verb: str, file: str, inputs: tuple[Operand, ...], output: Operand, summary: str
    ) -> Kernel:
        return Kernel(name + verb, file, inputs, (output,), getattr(define, verb), summary)

    return (
        kernel("adjoint", group, (m,), square, adjoint),
        kernel("transform_twist", group, (m, twist), made, other_side),
        kernel("left_jacobian", jacobians, (twist,), square, left),
        kernel("left_jacobian_inverse", jacobians, (twist,), square, inverse),
        kernel("retract", group, (m, twist), out, retract),
        kernel("local", group, tuple(others), made, local),
    )


def _bound(group: _Group) -> Definitions:
    functions = (
        _adjoint,
        _transform_twist,
        _left_jacobian,
        _left_jacobian_inverse,
        _retract,
        _local,
    )
    return Definitions(*(partial(function, group) for function in functions))


KERNELS = (
    *kernels_of("", on.motor, 6, _bound(_MOTORS)),
    *kernels_of("rotor", on.rotor, 3, _bound(_ROTORS)),
)
