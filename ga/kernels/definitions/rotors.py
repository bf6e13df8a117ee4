"""Rotors: product, reverse, exponential, logarithm, interpolation along the great circle."""

from __future__ import annotations

from typing import Any

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.motors import exponential, logarithm

__all__ = ["KERNELS"]

Numbers = list[Any]


def _compose(precision: Precision, a: Numbers, b: Numbers) -> list[Numbers]:
    """Product a b of rotors."""
    return [on.rotor_numbers(on.rotor_of(a) * on.rotor_of(b))]


def _inverse(precision: Precision, r: Numbers) -> list[Numbers]:
    """Reverse of a rotor: its inverse."""
    return [on.rotor_numbers(~on.rotor_of(r))]


def _exp(precision: Precision, log: Numbers) -> list[Numbers]:
    """Rotor of a bivector of any size."""
    return [on.rotor_numbers(exponential(precision, on.angles_of(log)))]


def _log(precision: Precision, r: Numbers) -> list[Numbers]:
    """Bivector of a rotor, by the sign that turns by at most π."""
    return [on.angle_numbers(logarithm(precision, on.rotor_of(r), True))]


def _log_long(precision: Precision, r: Numbers) -> list[Numbers]:
    """Bivector of a rotor by its own sign, turning by up to 2π."""
    return [on.angle_numbers(logarithm(precision, on.rotor_of(r), False))]


def _between(
    precision: Precision, a: Numbers, b: Numbers, fraction: Numbers, short_way: bool
) -> list[Numbers]:
    first, second = on.rotor_of(a), on.rotor_of(b)
    step = logarithm(precision, ~first * second, short_way) * fraction[0]
    return [on.rotor_numbers(first * exponential(precision, step))]


def _interpolate(precision: Precision, a: Numbers, b: Numbers, f: Numbers) -> list[Numbers]:
    """Screw a exp(fraction log(~a b)), the short way round."""
    return _between(precision, a, b, f, True)


def _interpolate_long(precision: Precision, a: Numbers, b: Numbers, f: Numbers) -> list[Numbers]:
    """Screw a exp(fraction log(~a b)), by the signs of a and b."""
    return _between(precision, a, b, f, False)


_A, _B, _R, _OUT = on.rotor("a"), on.rotor("b"), on.rotor("r"), on.rotor("out")
_LOG, _LOG_OUT, _F = on.angles("log"), on.angles("out"), on.numbers("fraction")

KERNELS = (
    Kernel("rotor_compose", "rotors", (_A, _B), (_OUT,), _compose),
    Kernel("rotor_inverse", "rotors", (_R,), (_OUT,), _inverse),
    Kernel("rotor_exp", "rotors", (_LOG,), (_OUT,), _exp),
    Kernel("rotor_log", "rotors", (_R,), (_LOG_OUT,), _log),
    Kernel("rotor_log_long", "rotors", (_R,), (_LOG_OUT,), _log_long),
    Kernel("rotor_interpolate", "rotors", (_A, _B, _F), (_OUT,), _interpolate),
    Kernel("rotor_interpolate_long", "rotors", (_A, _B, _F), (_OUT,), _interpolate_long),
)
