"""What twists do, for similarities: adjoint, Jacobians of exp, retract and local.

A twist is ``(ω, u, λ)``: rotation vector (rad), translational part (m), logarithm of the scale.
With ``Ω`` the cross product by ω and ``Z = Ω + λ``, its commutator takes ``(ω', u', λ')`` to
``(Ω ω', u × ω' + Z u' - λ' u, 0)``. So the left Jacobian has the blocks ``J = Σ Ωⁿ / (n + 1)!`` on
rotations, ``V = Σ Zⁿ / (n + 1)!`` on shifts, ``-Σ Zⁿ / (n + 2)! u`` on growth, and one that takes
rotations to shifts. As ``V u`` is the translation of ``exp``, it follows from its derivative:

    ``ω' ↦ (V u) × J ω' + (∂V/∂ω · ω') u``.

``V = A0 + A1 Ω + A2 Ω²``. What is divided by ``λ² + θ²`` in these coefficients and in their
derivatives by ``θ²`` vanishes with that, and its rounding is small beside the powers of ω that it
is multiplied by.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.motors import (
    HalfTurn,
    forward_series,
    half_turn,
    inverse_series,
)
from motorcade.ga.kernels.definitions.similarities import (
    Parts,
    exponential,
    growth_means,
    joined,
    logarithm,
    split,
)
from motorcade.ga.kernels.definitions.versors import Versors, matrix_rows

Numbers = list[Any]
# ``p0 + p1 Ω + p2 Ω²``
Polynomial = tuple[Any, Any, Any]


class _Means(NamedTuple):
    """Coefficients at one twist: of ``J``, ``V``, ``∂V/∂θ²`` and ``Σ Zⁿ / (n + 2)!``."""

    turn: Polynomial
    shift: Polynomial
    shift_by_square: Polynomial
    growth: Polynomial
    square: Any
    half: HalfTurn


def _means(precision: Precision, twist: Numbers) -> _Means:
    growth = twist[6]
    square = sum(value * value for value in twist[:3])
    half = half_turn(precision, 0.25 * square)
    (b, b_z), (d, _) = forward_series(precision, half)
    whole, first, second = growth_means(precision, growth)
    sinc = 1 - square * d
    sinc_slope = 0.25 * (half.slope * half.cosine - 0.5 * half.sinc * half.sinc)
    size = ca.fmax(growth * growth + square, precision.epsilon**3)
    share = growth * growth / size
    slope = first - second
    a1 = share * slope + (1 - share) * whole * (b - growth * d)
    a2 = (growth * (whole * b - slope) + square * whole * d) / size
    a1_slope = (whole * (0.5 * sinc + growth * sinc_slope) - a1) / size
    a2_slope = (whole * (0.25 * growth * b_z - sinc_slope) - a2) / size
    c1 = (growth * (a1 - second) + square * a2) / size
    c2 = (second - a1 + growth * a2) / size
    return _Means(
        (1, b, d), (first, a1, a2), (0, a1_slope, a2_slope), (second, c1, c2), square, half
    )


def _cross(a: Numbers, b: Numbers) -> Numbers:
    # Bivectors are duals of vectors; half their commutator is minus the cross product's.
    return on.ANGLES.numbers(-on.ANGLES.of(a).commutator(on.ANGLES.of(b)))


def _sum(*vectors: Numbers) -> Numbers:
    return [sum(values) for values in zip(*vectors, strict=True)]


def _scaled(factor: Any, vector: Numbers) -> Numbers:
    return [factor * value for value in vector]


def _polynomial(of: Polynomial, turn: Numbers, vector: Numbers) -> Numbers:
    once = _cross(turn, vector)
    terms = zip(of, (vector, once, _cross(turn, once)), strict=True)
    return _sum(*(_scaled(factor, term) for factor, term in terms))


def _shift_of_turn(means: _Means, twist: Numbers) -> Callable[[Numbers, Numbers], Numbers]:
    """The block from rotations to shifts, of a rotation and ``J`` of it."""
    turn, push = twist[:3], twist[3:6]
    shift = _polynomial(means.shift, turn, push)
    slope = _polynomial(means.shift_by_square, turn, push)
    _, a1, a2 = means.shift
    once = _cross(turn, push)

    def column(numbers: Numbers, turned: Numbers) -> Numbers:
        crossed = _cross(numbers, push)
        along = 2 * sum(x * y for x, y in zip(turn, numbers, strict=True))
        return _sum(
            _cross(shift, turned), _scaled(along, slope), _scaled(a1, crossed),
            _scaled(a2, _sum(_cross(numbers, once), _cross(turn, crossed))),
        )  # fmt: skip

    return column


def _left_jacobian(precision: Precision, twist: Numbers) -> Numbers:
    means = _means(precision, twist)
    turn, push = twist[:3], twist[3:6]
    shift_of_turn = _shift_of_turn(means, twist)
    of_growth = _polynomial(means.growth, turn, push)

    def column(y: Numbers) -> Numbers:
        turned = _polynomial(means.turn, turn, y[:3])
        moved = _polynomial(means.shift, turn, y[3:6])
        shift = _sum(moved, shift_of_turn(y[:3], turned), _scaled(-y[6], of_growth))
        return [*turned, *shift, y[6]]

    return matrix_rows(column, 7)


def _left_jacobian_inverse(precision: Precision, twist: Numbers) -> Numbers:
    means = _means(precision, twist)
    turn, push = twist[:3], twist[3:6]
    shift_of_turn = _shift_of_turn(means, twist)
    of_growth = _polynomial(means.growth, turn, push)
    back_turn = (1, -0.5, inverse_series(precision, means.half)[0])
    back_shift = _inverse(means)

    def column(y: Numbers) -> Numbers:
        turned = _polynomial(back_turn, turn, y[:3])
        rest = _sum(shift_of_turn(turned, y[:3]), _scaled(-y[6], of_growth))
        shift = _polynomial(back_shift, turn, _sum(y[3:6], _scaled(-1, rest)))
        return [*turned, *shift, y[6]]

    return matrix_rows(column, 7)


def _inverse(means: _Means) -> Polynomial:
    """``V⁻¹``: on the plane across the axis ``V`` is the complex number ``p + i θ A1``."""
    a0, a1, a2 = means.shift
    p = a0 - means.square * a2
    size = p * p + means.square * a1 * a1
    return 1 / a0, -a1 / size, (a1 * a1 - a2 * p) / (a0 * size)


def _transform_twist(s: Parts, twist: Numbers) -> Numbers:
    """``S Y ~S``; on rotations and shifts ``A + B`` is ``√ρ R``, its partner ``R / √ρ``."""
    grown, shrunk = s.turned + s.grown, s.turned - s.grown
    turn, push = on.ANGLES.of(twist[:3]), on.MOVED.of(twist[3:6])
    turned = on.ANGLES.numbers(grown * turn * ~shrunk)
    moved = (
        grown * turn * ~s.moved + s.moved * turn * ~grown + grown * push * ~grown
        + (-twist[6]) * (grown * ~s.moved - s.moved * ~grown)
    )  # fmt: skip
    return [*turned, *on.MOVED.numbers(moved)[:3], twist[6]]


def _of_twist(twist: Numbers) -> Numbers:
    return [*_scaled(-0.5, twist[:3]), 0.5 * twist[6], *_scaled(-0.5, twist[3:6])]


def _as_twist(log: Numbers) -> Numbers:
    return [*_scaled(-2, log[:3]), *_scaled(-2, log[4:]), 2 * log[3]]


SIMILARITIES = Versors(
    "similarity_",
    "similarity",
    "similarities",
    "Spiral",
    on.SIMILARITY,
    on.GROWING_BIVECTOR,
    7,
    split,
    joined,
    exponential,
    logarithm,
    _of_twist,
    _as_twist,
    _transform_twist,
    _left_jacobian,
    _left_jacobian_inverse,
)
