"""Three coordinates over any scalars: the vector calculus that points and directions need.

A triple is a tuple of three scalars; over NumPy each is a batch. Numbers are checked as they come
in, symbols cannot be looked at and pass.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.algebra.scalars import is_numeric, square_root
from motorcade.ga.arrays import checked_floats

# How far from 1 the length of a direction may be before it is refused.
_UNIT_TOLERANCE = 1e-6

Triple = tuple[Any, Any, Any]


def triple(value: Any, name: str) -> Triple:
    """Three coordinates from an array ``(*, 3)``, or from three scalars of any kind.

    Raises:
        ValueError: another number of them, NaN or infinity.
    """
    if isinstance(value, list | tuple) and len(value) == 3:
        plain = all(is_numeric(part) for part in value)
        if not plain and not any(isinstance(part, list | tuple) for part in value):
            return value[0], value[1], value[2]
    if hasattr(value, "numel"):
        return _unpacked(value, name)
    array = checked_floats(value, name, (3,))
    return array[..., 0], array[..., 1], array[..., 2]


def _unpacked(value: Any, name: str) -> Triple:
    """A CasADi column of three, or a tensor ``(*, 3)``."""
    shape = tuple(value.shape)
    if hasattr(value, "nnz") and shape in ((3, 1), (1, 3)):
        return value[0], value[1], value[2]
    if hasattr(value, "nnz") or shape[-1:] != (3,):
        raise ValueError(f"{name}: expected shape (*, 3), got {shape}")
    return value[..., 0], value[..., 1], value[..., 2]


def unit_triple(value: Any, name: str) -> Triple:
    """As `triple`, for unit vectors.

    Raises:
        ValueError: a length more than 1e-6 from 1.
    """
    given = triple(value, name)
    size = square_root(dot(given, given))
    if is_numeric(size):
        worst = float(np.max(np.abs(size - 1.0), initial=0.0))
        if worst > _UNIT_TOLERANCE:
            raise ValueError(
                f"{name}: expected a unit vector (length within {_UNIT_TOLERANCE:g} of 1), got a "
                f"length off by {worst:.3g}; divide by it first"
            )
    return given


def length(value: Any, name: str) -> Any:
    """A length, not negative where it can be looked at."""
    given = number(value, name)
    if is_numeric(given) and np.any(np.asarray(given) < 0.0):
        raise ValueError(f"{name}: expected a length >= 0, got {float(np.min(given)):g}")
    return given


def dot(a: Triple, b: Triple) -> Any:
    """Scalar product of two triples."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Triple, b: Triple) -> Triple:
    """Vector product of two triples."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def add(a: Triple, b: Triple) -> Triple:
    """Sum of two triples."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Triple, b: Triple) -> Triple:
    """Difference of two triples."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(factor: Any, a: Triple) -> Triple:
    """Multiple of a triple."""
    return a[0] * factor, a[1] * factor, a[2] * factor


def normalized(a: Triple) -> Triple:
    """A triple divided by its length."""
    return scale(1.0 / square_root(dot(a, a)), a)


def number(value: Any, name: str) -> Any:
    """A scalar of any kind, or a batch of numbers; NaN and infinity are refused."""
    if is_numeric(value) or isinstance(value, list | tuple):
        return checked_floats(value, name, ())[()]
    return value


def size_of(a: Triple) -> Any:
    """Length of a triple."""
    return square_root(dot(a, a))
