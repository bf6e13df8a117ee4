"""The logarithm of multivectors, their square roots, unit size, and the versor near an element.

``x = c + y`` with ``y² = s`` has ``log x = ½ log n + y θ(s/n, c/√n) / √n``, where ``n = c² - s``
and ``θ(-sin² a, cos a) = a / sin a``, ``θ(sinh² a, cosh a) = a / sinh a``. An even versor
``c + G + H`` of grades 0, 2 and 4 in at most five dimensions turns in two commuting planes; the
squares of their sines follow from ``⟨G²⟩₀`` and ``h = H²``, and its logarithm is
``½ log n + ℓ G + m H G``. Rotors, motors and similarities are of this kind. Angles come from atan2.

Where the blades say that one plane turns and nothing else happens, as in rotors and rigid motors,
the angle is that of the point ``(c, √-s)`` whatever ``n`` is, and nothing is brought to unit size.

An element with ``x ~x = s + F``, ``F² = f`` a scalar, is a versor times what commutes with it:
``[((s + ν) - F) / (ν √(2 (s + ν)))] x`` with ``ν = √(s² - f)`` takes that away. It is so for all
even elements in at most five dimensions. ``(1 + R) ~(1 + R)`` is of this form for a versor, and
``√R`` is the versor of ``1 + R``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from motorcade.ga.algebra.blade_sum import BladeSum
from motorcade.ga.algebra.exponential import (
    Square,
    any_holds,
    commuting_product,
    nonzero,
    numeric,
    parts_of_sum,
    plus,
    roundings,
    square_of,
    weights,
    without_scalar,
)
from motorcade.ga.algebra.scalars import (
    apply,
    arctangent,
    larger,
    magnitude,
    power_series,
    signed,
    where,
)

_NEAR = 0.02
_TERMS = 10
_RATIO = tuple((-1) ** n * math.comb(2 * n, n) / (4.0**n * (2 * n + 1)) for n in range(_TERMS))
_SUMS = tuple(4.0**n * math.factorial(n) ** 2 / math.factorial(2 * n + 1) for n in range(11))
_BEND = tuple((-1) ** n * (_SUMS[n] - _SUMS[n + 1]) for n in range(_TERMS))
# (1 - arctan t / t) / t² by t².
_ARCTANGENT_BEND = tuple((-1) ** n / (2 * n + 3) for n in range(9))

# Relative to the size of a versor, how far ``x ~x`` may be from a scalar.
_VERSOR_TOLERANCE = 1e-6
_LOST = 16.0


class EvenParts(NamedTuple):
    """``x = scalar + plane + volume`` of grades 0, 2, 4; `norm_squared` is ``⟨x ~x⟩₀``.

    `volume_squared` is None where it is zero by structure, `sign` its sign where known, and
    `plane_sign` that of `plane_squared`.
    """

    scalar: Any
    plane: BladeSum
    plane_squared: Any
    plane_sign: int
    volume: BladeSum
    volume_squared: Any
    sign: int
    norm_squared: Any


class _Angles(NamedTuple):
    """``log x = once G + twice H G`` of a unit versor, and where a half turn lost its plane."""

    once: Any
    twice: Any
    turned: Any


def log(x: BladeSum) -> BladeSum:
    """The ``y`` with ``exp y = x``, the angles of its planes at most π; coefficients over a batch.

    For a rotor of half the angle of its rotation this is a bivector of that half angle: flip the
    sign of the rotor first to go the short way round. The scalar part is the logarithm of the norm.

    Raises:
        ValueError: no real logarithm (a negative scalar, a norm of zero or less), a half turn in
            no plane, neither simple nor an even versor in at most five dimensions.
    """
    with np.errstate(all="ignore"):
        return by_structure("log", x, lambda c: _log_of_norm(c, c), _log_of_simple, _log_of_versor)


def by_structure(
    name: str,
    x: BladeSum,
    of_scalar: Callable[[Any], Any],
    of_simple: Callable[[BladeSum, BladeSum, Square], BladeSum],
    of_versor: Callable[[BladeSum, EvenParts], BladeSum],
) -> BladeSum:
    """A function of a scalar, of one beside something simple, or of an even versor.

    `of_simple` is given the element, the part beside the scalar, and the square of that.

    Raises ValueError: none of these.
    """
    rest = without_scalar(x)
    if not rest.masks:
        return plus(of_scalar(x.scalar_part()), rest)
    square = square_of(rest)
    if square is not None and square.is_scalar:
        return of_simple(x, rest, square)
    parts = _even_parts(x)
    if parts is not None:
        return of_versor(x, parts)
    kept = without_rounding(x)
    if kept.masks != x.masks:
        return by_structure(name, kept, of_scalar, of_simple, of_versor)
    raise ValueError(
        f"{name}: expected a scalar beside something with a scalar square, or an even versor in at "
        f"most five dimensions, got blades {' '.join(x.blades[:6])}"
    )


def _even_parts(x: BladeSum) -> EvenParts | None:
    """The grades of an even element; None in six dimensions and more, and for any other grade."""
    if x.algebra.dimension > 5 or not set(x.grades) <= {0, 2, 4}:
        return None
    c, plane, volume = x.scalar_part(), x.grade(2), x.grade(4)
    squared = plane.square().scalar_part()
    square = square_of(volume)
    if square is None or not square.is_scalar:
        return None
    known = bool(volume.square().masks)
    h = square.scalar if known else None
    norm_squared = c * c - squared + (h if known else 0.0)
    turning = square_of(plane)
    plane_sign = 0 if turning is None else turning.sign
    return EvenParts(c, plane, squared, plane_sign, volume, h, square.sign, norm_squared)


def _log_of_norm(value: Any, sign: Any) -> Any:
    if any_holds(value <= 0) or any_holds(sign <= 0):
        raise ValueError("log: has no finite real value here")
    return apply("log", value)


def _log_of_simple(x: BladeSum, y: BladeSum, square: Square) -> BladeSum:
    c, s = x.scalar_part(), square.scalar
    if type(s) is float and s == 0.0:
        return plus(_log_of_norm(c, c), y._divided(c))
    n = c * c - s
    whole = _log_of_norm(n, 1.0) / 2
    if numeric(x):
        _check_turn(x, where(c < 0, s / n, -1.0))
    if square.sign < 0:
        return plus(whole, y._scaled(_angle_terms(-s, c)[0]))
    size = apply("sqrt", n)
    ratio, _ = _ratios(s / n, c / size, square.sign)
    return plus(whole, y._scaled(ratio / size))


def _check_turn(x: BladeSum, turned: Any) -> None:
    if any_holds(turned >= -(roundings(x, _LOST) ** 2)):
        raise ValueError("log: expected a real logarithm, got a half turn in no plane")


def _log_of_versor(x: BladeSum, parts: EvenParts) -> BladeSum:
    n = parts.norm_squared
    whole = _log_of_norm(n, 1.0) / 2
    if parts.volume_squared is None and parts.plane_sign < 0:
        once, twice = _angle_terms(-parts.plane_squared, parts.scalar)
        turned = where(parts.scalar < 0, parts.plane_squared / n, -1.0) if numeric(x) else -1.0
    else:
        size = apply("sqrt", n)
        once, twice, turned = _angles(parts, n, parts.scalar / size)
        once, twice = once / size, twice / n
    if numeric(x):
        check_versor(x, "log")
        _check_turn(x, turned)
    product = commuting_product(parts.volume, parts.plane)
    return plus(whole, parts.plane._scaled(once), product._scaled(twice))


def _angle_terms(squared: Any, c: Any) -> tuple[Any, Any]:
    """``a / p`` and ``-(1 - a c / p) / p²`` of the angle ``a`` of the point ``(c, p)``.

    ``p² = squared`` is not negative; what is divided by is ``c`` where ``p`` is small beside it.
    """
    near = squared < where(c > 0, _NEAR, 0.0) * (c * c)
    root = apply("sqrt", nonzero(squared))
    inverse = 1 / where(near, c, root)
    reciprocal = inverse * inverse
    slope = squared * reciprocal  # about 1 where it is not needed
    bend = power_series(slope, _ARCTANGENT_BEND)
    once = where(near, 1.0 - slope * bend, arctangent(root, c)) * inverse
    return once, where(near, -bend, once * c - 1.0) * reciprocal


def _angles(parts: EvenParts, n: Any, c: Any) -> _Angles:
    s = parts.plane_squared / n
    if parts.volume_squared is None:
        ratio, bend = _ratios(s, c, parts.plane_sign)
        return _Angles(ratio, -bend, where(c < 0, s, -1.0))
    h = parts.volume_squared / n
    if parts.sign < 0:
        return _opposite(c, s, h)
    apart = 8 * h * c * c <= s * s
    same = _chosen(apart, _same(c, s, h), _split(c, s, h))
    return same if parts.sign > 0 else _chosen(h <= 0, _opposite(c, s, where(h <= 0, h, 0.0)), same)


def _chosen(condition: Any, a: _Angles, b: _Angles) -> _Angles:
    return _Angles(*(where(condition, one, other) for one, other in zip(a, b, strict=True)))


def _opposite(c: Any, s: Any, h: Any) -> _Angles:
    """``h <= 0``: one plane turns, the other stretches."""
    stretched, turned = parts_of_sum(s, 4 * h * c * c, -1)
    growth = larger(stretched - h, 0.0)
    grown = apply("sqrt", 1 + growth)
    return _joined((growth, grown, 1), (turned / (1 + growth), c / grown, -1))


def _same(c: Any, s: Any, h: Any) -> _Angles:
    """``h > 0``: both turn, or both stretch, by different amounts."""
    first, second = parts_of_sum(s, 4 * h * c * c, 0)
    larger_cosine = apply("sqrt", larger(c * c - second, 0.0))
    cosine = apply("sqrt", larger(c * c - first, 0.0))
    turned = where(c < 0, -larger_cosine, larger_cosine)
    return _joined((second - h, cosine, 0), (first - h, turned, 0))


def _joined(first: tuple[Any, Any, int], second: tuple[Any, Any, int]) -> _Angles:
    """From the squared sines and cosines of two planes; only the second may turn by over π/2."""
    ratio_1, bend_1 = _ratios(*first)
    ratio_2, bend_2 = _ratios(*second)
    weight_1, other = weights(first[0], second[0])
    once = weight_1 * ratio_1 * second[1] + other * ratio_2 * first[1]
    twice = -(weight_1 * bend_1 + other * bend_2)
    return _Angles(once, twice, where(second[1] < 0, second[0], -1.0))


def _split(c: Any, s: Any, h: Any) -> _Angles:
    """``h > 0``: by the values ``c ± √h`` of the cosine, where both planes turn nearly alike."""
    root = apply("sqrt", larger(h, 0.0))
    more, less = (s + 2 * c * root, c + root), (s - 2 * c * root, c - root)
    ratio, other = _ratios(*more, 0)[0], _ratios(*less, 0)[0]
    worst = [where(cosine < 0, squared, -1.0) for squared, cosine in (more, less)]
    return _Angles((ratio + other) / 2, (ratio - other) / (2 * nonzero(root)), larger(*worst))


def _ratios(squared: Any, cosine: Any, sign: int) -> tuple[Any, Any]:
    """``a / sin a`` and ``(1 - a cos a / sin a) / sin² a`` from ``-sin² a`` and ``cos a``.

    Positive squares are those of the hyperbolic sine; `sign` is theirs where it is known.
    """
    near = magnitude(squared) < where(cosine > 0, _NEAR, 0.0)
    small = where(near, squared, 0.0)
    root = apply("sqrt", nonzero(where(near, 1.0, magnitude(squared))))
    inverse = 1 / root
    angle: Any = 0.0
    if sign <= 0:
        angle = arctangent(root, cosine)
    if sign >= 0:
        grown = apply("log", larger(root + cosine, 1.0))
        angle = where(squared < 0, angle, grown) if sign == 0 else grown
    ratio = where(near, power_series(small, _RATIO), angle * inverse)
    bend = (ratio * cosine - 1) * signed(inverse * inverse, squared, sign)
    return ratio, where(near, power_series(small, _BEND), bend)


def check_versor(x: BladeSum, name: str) -> None:
    """Refuse numbers whose ``x ~x`` is no scalar.

    Raises ValueError: no versor, to a millionth of its size.
    """
    beside = [np.abs(value) for value in without_scalar(x.reverse_product()).values]
    size: Any = sum(np.square(value) for value in x.values)
    if any(any_holds(value > _VERSOR_TOLERANCE * size) for value in beside):
        raise ValueError(
            f"{name}: expected a versor, whose x ~x is a scalar, got other parts beside it; "
            "versor(x) is the one nearby"
        )


def without_rounding(x: BladeSum) -> BladeSum:
    """Numbers without the blades that rounding may have left; symbols as they are."""
    if not numeric(x):
        return x
    size: Any = sum(np.abs(value) for value in x.values)
    bound = roundings(x, _LOST)
    left = [np.abs(value) <= bound * size for value in x.values]
    dropped = {mask for mask, gone in zip(x.masks, left, strict=True) if np.all(gone)}
    return x._selected(lambda mask: mask == 0 or mask not in dropped)


def normalize(x: BladeSum) -> BladeSum:
    """``x / √|⟨x ~x⟩₀|``.

    Raises:
        ValueError: a size of zero to rounding.
    """
    with np.errstate(all="ignore"):
        size = apply("sqrt", magnitude(x.norm_squared()))
        largest: Any = sum(np.abs(value) for value in x.values) if numeric(x) else 0.0
        if numeric(x) and any_holds(size <= 1e-12 * largest):
            raise ValueError("normalize: expected a size, got x ~x with a scalar part of zero")
        return x._divided(size)


def versor(x: BladeSum) -> BladeSum:
    """The unit versor that `x` is a disturbed multiple of, as after a linear blend.

    Raises:
        ValueError: ``x ~x`` not of the form ``s + F`` above, or none nearby: ``s² <= F²``, or
            ``s + ν <= 0``.
    """
    with np.errstate(all="ignore"):
        whole = x.reverse_product()
        s, rest = whole.scalar_part(), without_scalar(whole)
        above = rest.square()
        if any(above.masks):
            kept = without_rounding(x)
            if kept.masks != x.masks:
                return versor(kept)
            raise ValueError(
                "versor: expected an even element in at most five dimensions, "
                f"got blades {' '.join(x.blades[:6])}"
            )
        return _corrected(x, s, rest, above.scalar_part() if above.masks else None)


def _corrected(x: BladeSum, s: Any, rest: BladeSum, f: Any) -> BladeSum:
    """The versor of `x` with ``x ~x = s + rest``, `f` the square of the rest; None: zero."""
    inside = s * s if f is None else s * s - f
    if any_holds(inside <= 0):
        raise ValueError("versor: expected an element with a versor nearby, got none")
    size = magnitude(s) if f is None else apply("sqrt", inside)
    # s + size, where nothing cancels for negative s.
    below = -(0.0 if f is None else f) / where(s < 0, size - s, 1.0)
    total = where(s < 0, below, s + size)
    if any_holds(total <= 0):
        raise ValueError("versor: expected an element with a versor nearby, got none")
    divisor = size * apply("sqrt", 2 * total)
    left = plus(total, -rest)._divided(divisor)
    return left._product("geometric", x, _kept(x))


def _kept(x: BladeSum) -> frozenset[int] | None:
    """The grades of the versor of an even or of an odd element."""
    parities = {grade % 2 for grade in x.grades}
    grades = range(x.algebra.dimension + 1)
    return frozenset(g for g in grades if g % 2 in parities) if len(parities) == 1 else None


def sqrt(x: BladeSum) -> BladeSum:
    """The ``y`` with ``y y = x``, the angles of its planes at most π/2; coefficients over a batch.

    Raises:
        ValueError: no real root (a negative scalar, a norm below zero), a half turn in no plane,
            neither simple nor an even versor in at most five dimensions.
    """
    with np.errstate(all="ignore"):
        return by_structure("sqrt", x, _root, _root_of_simple, _root_of_versor)


def _root(value: Any) -> Any:
    if any_holds(value < 0):
        raise ValueError("sqrt: has no finite real value here")
    return apply("sqrt", value)


def _root_of_simple(x: BladeSum, y: BladeSum, square: Square) -> BladeSum:
    """``(√n + x) / √(2 (√n + c))`` with ``n = c² - s``, where nothing cancels for negative `c`."""
    c, s = x.scalar_part(), square.scalar
    size = _root(c * c - s)
    scalar = where(c < 0, -s / where(c < 0, size - c, 1.0), size + c)
    if any_holds(scalar <= 0):
        raise ValueError("sqrt: expected a real root, got a half turn in no plane")
    root = apply("sqrt", 2 * scalar)
    return plus(scalar / root, y._divided(root))


def _root_of_versor(x: BladeSum, parts: EvenParts) -> BladeSum:
    """The versor of ``1 + x``, whose reverse product is ``2 (1 + c) + 2 H`` for a unit `x`."""
    n = parts.norm_squared
    size = _root(n)
    if numeric(x):
        if any_holds(size <= 0):
            raise ValueError("sqrt: expected a versor, got a norm of zero")
        check_versor(x, "sqrt")
    c, f = parts.scalar / size, parts.volume_squared
    h = 0.0 if f is None else f / n
    # 1 + c from the squared sines, where 1 and c cancel.
    below = parts.plane_squared / n * (c - 1) - 2 * c * h
    one_more = where(c < 0, below / where(c < 0, (c - 1) * (c - 1) - h, 1.0), 1 + c)
    beside = plus(one_more, without_scalar(x)._divided(size))
    volume = parts.volume._divided(size)._scaled(2.0)
    versor = _corrected(beside, 2 * one_more, volume, None if f is None else 4 * h)
    return versor._scaled(apply("sqrt", size))
