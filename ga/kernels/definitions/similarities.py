"""Similarities: products, exponential and logarithm, interpolation, projection, linear blend.

With ``E = e0∧e∞`` a similarity is ``S = A + B E + M``: two rotor-like elements and one of multiples
of ``e∞``. ``E`` commutes with rotors, ``E² = 1``, ``E M = M = -M E``. A unit versor of scale
``ρ = e^2h`` has ``A = R cosh h`` and ``B = R sinh h``, so that ``A + B = √ρ R`` and
``A - B = R / √ρ``, and ``M = -½ t∞ (A - B)`` with the translation ``t``.
"""

from __future__ import annotations

from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.library_kernels.powers_of_two import exponent, power_of_two
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.blends import linear
from motorcade.ga.kernels.definitions.functions import (
    angle_over_sine,
    angle_over_sine_beyond,
    cosine_sinc,
    select,
)
from motorcade.ga.kernels.definitions.growth import hyperbolic, inverse_hyperbolic

__all__ = ["KERNELS", "Parts", "joined", "scalar", "split"]

Numbers = list[Any]

_LIFT = "e1^e2^e3^einf"


class Parts(NamedTuple):
    """``S = turned + grown E + moved``."""

    turned: Multivector
    grown: Multivector
    moved: Multivector


def split(m: Numbers) -> Parts:
    """The parts of twelve coefficients."""
    return Parts(on.rotor_of(m[:4]), on.rotor_of(m[4:8]), on.moved_of(m[8:]))


def joined(s: Parts) -> Numbers:
    """The twelve coefficients."""
    moved = on.moved_numbers(s.moved)
    return [*on.rotor_numbers(s.turned), *on.rotor_numbers(s.grown), *moved]


def scalar(element: Multivector) -> Any:
    """The scalar part."""
    return element.coefficient("1")


def product(a: Parts, b: Parts) -> Parts:
    """``a b``."""
    return Parts(
        a.turned * b.turned + a.grown * b.grown,
        a.turned * b.grown + a.grown * b.turned,
        (a.turned + a.grown) * b.moved + a.moved * (b.turned - b.grown),
    )


def reverse(s: Parts) -> Parts:
    """``~s``; the reverse of ``B E`` is ``-~B E``."""
    return Parts(~s.turned, -(~s.grown), ~s.moved)


def exponential(precision: Precision, log: Numbers) -> Parts:
    """``exp(V + h E + U)`` with an angle bivector V, ``V² = -φ²``, and ``U = -½ u∞``.

    The part of U across V anticommutes with ``G = V + h E`` and becomes ``(sinh G / G) U``, the
    part along V commutes with V and becomes ``(sinh h / h) e^V U``. Written with commutators, so
    that nothing is divided by φ; what is divided by ``h² + φ²`` is that small itself.
    """
    import casadi as ca

    angles, h, push = on.angles_of(log[:3]), log[3], on.moved_of(log[4:])
    square = on.angle_norm_squared(angles)
    cosine, sinc, _ = cosine_sinc(precision, square)
    cosh, sinh, over = hyperbolic(precision, h)
    rotor = cosine + sinc * angles
    across = angles.commutator(push)
    rest = (cosh * sinc - over * cosine) / ca.fmax(h * h + square, precision.epsilon**3)
    moved = (
        over * cosine * push
        + rest * (h * across - angles.commutator(across))
        + over * sinc * (angles ^ push)
    )
    return Parts(cosh * rotor, sinh * rotor, moved)


def logarithm(precision: Precision, s: Parts, short_way: bool) -> Numbers:
    """The bivector ``V + h E + U``, undoing `exponential` part by part.

    With ``σ = sin φ`` what is divided by ``σ² + sinh² h`` vanishes with that where ``φ ≤ ½ π``.
    """
    import casadi as ca

    if short_way:
        sign = select(scalar(s.turned) < 0, -1, 1)
        s = Parts(*(on.scaled(part, sign) for part in s))
    cosh = ca.sqrt(scalar(s.turned * ~s.turned))
    rotor = s.turned * (1 / cosh)
    sinh = scalar(s.grown * ~rotor)
    w, bivector = scalar(rotor), on.angles_of(on.angle_numbers(rotor))
    square = on.angle_norm_squared(rotor)
    if short_way:
        turn, _ = angle_over_sine(precision, w)
    else:
        turn, _ = angle_over_sine_beyond(precision, w, square)
    h, growth = inverse_hyperbolic(precision, cosh, sinh)
    numbers = on.moved_numbers(s.moved)
    shift, lift = on.moved_of(numbers[:3]), on.moved_of([0, 0, 0, numbers[3]])
    across = bivector.commutator(shift)
    share = 1 / ca.fmax(square + sinh * sinh, precision.epsilon**3)
    push = (
        growth * (w * shift - bivector * lift)
        + (growth * w - turn * cosh) * share * bivector.commutator(across)
        + sinh * (turn * w - growth * cosh) * share * across
    )
    return [*(turn * v for v in on.angle_numbers(bivector)), h, *on.moved_numbers(push)[:3]]


def projected(precision: Precision, s: Parts) -> tuple[Parts, Any]:
    """The similarity nearest to an even element, and how well it is defined, from 0 to 1.

    With ``m ~m = s + F``, ``F² = f`` and ``ν = √(s² - f)`` it is ``((s + ν) - F) m /
    (ν √(2 (s + ν)))``. Here ``ν = |P| |N|`` with ``P = A + B`` and ``N = A - B``, so that its rotor
    is half-way between the directions of P and N and its scale is ``|P| / |N|``. Nothing is defined
    where P or N vanish (no scale) or are opposite (``s = -ν``).
    """
    import casadi as ca

    a, b, moved = _of_size_two(precision, s)
    (grown, p), (shrunk, n) = (_direction(precision, part) for part in (a + b, a - b))
    both, rotor = _direction(precision, p + n)
    least = 2 * precision.epsilon * ca.fmax(grown, shrunk)
    lesser = ca.fmin(grown, shrunk)
    root = 1 / ca.sqrt(ca.fmax(grown, least) * ca.fmax(shrunk, least))
    cosh = 0.5 * (grown + shrunk) * root
    sinh = 2 * scalar(a * ~b) / (grown + shrunk) * root
    moved = rotor * ~p * moved * root
    # What is left of ``S ~S`` on e123∞ is taken away along N.
    off = 2 * (moved * ~rotor).coefficient(_LIFT) / ca.fmax(both, precision.epsilon)
    moved = moved - off * (n * on.moved_of([0, 0, 0, 1]))
    defined = select(lesser > least, 0.5 * both, 0)
    return Parts(cosh * rotor, sinh * rotor, moved), defined


def _of_size_two(precision: Precision, s: Parts) -> Parts:
    """The element times a power of two, so that nothing is rounded and its squares are numbers."""
    import casadi as ca

    sizes = [ca.fabs(value) for part in s[:2] for value in on.rotor_numbers(part)]
    highest = float(np.finfo(precision.numpy).maxexp - 1)
    factor = power_of_two(ca.fmin(1 - exponent(reduce(ca.fmax, sizes)), highest))
    return Parts(*(on.scaled(part, factor) for part in s))


def _direction(precision: Precision, rotor: Multivector) -> tuple[Any, Multivector]:
    """Length, and the element divided by it."""
    import casadi as ca

    length = ca.sqrt(scalar(rotor * ~rotor))
    return length, rotor * (1 / ca.fmax(length, precision.epsilon**2))


def _compose(precision: Precision, a: Numbers, b: Numbers) -> list[Numbers]:
    """Geometric product a b of similarities."""
    return [joined(product(split(a), split(b)))]


def _inverse(precision: Precision, m: Numbers) -> list[Numbers]:
    """Reverse of a similarity: its inverse."""
    return [joined(reverse(split(m)))]


def _exp(precision: Precision, log: Numbers) -> list[Numbers]:
    """Similarity of a bivector of any angle."""
    return [joined(exponential(precision, log))]


def _log(precision: Precision, m: Numbers) -> list[Numbers]:
    """Bivector of a similarity, by the sign that turns by at most π."""
    return [logarithm(precision, split(m), True)]


def _log_long(precision: Precision, m: Numbers) -> list[Numbers]:
    """Bivector of a similarity by its own sign, turning by up to 2π."""
    return [logarithm(precision, split(m), False)]


def _between(
    precision: Precision, a: Numbers, b: Numbers, fraction: Numbers, short_way: bool
) -> list[Numbers]:
    first, second = split(a), split(b)
    log = logarithm(precision, product(reverse(first), second), short_way)
    step = exponential(precision, [fraction[0] * value for value in log])
    return [joined(product(first, step))]


def _interpolate(precision: Precision, a: Numbers, b: Numbers, f: Numbers) -> list[Numbers]:
    """Spiral a exp(fraction log(~a b)), the short way round."""
    return _between(precision, a, b, f, True)


def _interpolate_long(precision: Precision, a: Numbers, b: Numbers, f: Numbers) -> list[Numbers]:
    """Spiral a exp(fraction log(~a b)), by the signs of a and b."""
    return _between(precision, a, b, f, False)


def _normalize(precision: Precision, m: Numbers) -> list[Numbers]:
    """The similarity nearest to an even element, and how well it is defined."""
    made, defined = projected(precision, split(m))
    return [[*joined(made), defined]]


def _blend(precision: Precision, a: Numbers, b: Numbers, fraction: Numbers) -> list[Numbers]:
    """Linear blend of two similarities, the short way round, made unit."""
    made, _ = projected(precision, split(linear(a, b, fraction[0])))
    return [joined(made)]


_A, _B, _M, _OUT = (on.similarity(name) for name in ("a", "b", "m", "out"))
_LOG, _LOG_OUT, _F = on.growing_bivector("log"), on.growing_bivector("out"), on.numbers("fraction")
_PRODUCTS, _LOGS = "similarity_products", "similarity_exponentials"
_SPIRALS, _LONG, _BLENDS = "similarity_spirals", "similarity_long_spirals", "similarity_blends"

KERNELS = (
    Kernel("similarity_compose", _PRODUCTS, (_A, _B), (_OUT,), _compose),
    Kernel("similarity_inverse", _PRODUCTS, (_M,), (_OUT,), _inverse),
    Kernel("similarity_exp", _LOGS, (_LOG,), (_OUT,), _exp),
    Kernel("similarity_log", _LOGS, (_M,), (_LOG_OUT,), _log),
    Kernel("similarity_log_long", _LOGS, (_M,), (_LOG_OUT,), _log_long),
    Kernel("similarity_interpolate", _SPIRALS, (_A, _B, _F), (_OUT,), _interpolate),
    Kernel("similarity_interpolate_long", _LONG, (_A, _B, _F), (_OUT,), _interpolate_long),
    Kernel("similarity_normalize", _BLENDS, (_M,), (on.defined_similarity("out"),), _normalize),
    Kernel("similarity_blend", _BLENDS, (_A, _B, _F), (_OUT,), _blend),
)
