"""Similarity kernels in NumPy: product, reverse, exponential, logarithm, projection.

Coefficient order: ``1, e23, e31, e12``, the same four times ``E = e0∧e∞``, then ``e1∞, e2∞, e3∞,
e123∞``. With ``J = e123∞`` a versor is ``A + B E + d J`` for three rotor-like quadruples, where
``d = (m11, -m8, -m9, -m10)``. They commute with ``E`` and ``J``, and ``E² = 1``, ``E J = J``,
``J E = -J``, ``J² = 0``: so ``P = A + B`` and ``N = A - B`` multiply by themselves, and a unit
versor of scale ``ρ`` has ``P = √ρ R``, ``N = R / √ρ``.

Inside this module the component axis comes first, so every line works on whole batches. Inputs are
float64, ``(*, 12)`` or ``(*, 7)``, and broadcast; they are not validated here.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

__all__ = ["compose", "exp", "interpolate", "inverse", "log", "parts", "projected", "unit"]

_REVERSE = np.array([1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
# Below this |z|² the series are exact to the last bit, and squares of z might vanish.
_SERIES_BELOW_Z2 = 1e-8


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geometric product on ``1, e23, e31, e12``, component axis first (note ``e23 e31 = -e12``)."""
    return np.stack([
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ])  # fmt: skip


def _reverse(a: FloatArray) -> FloatArray:
    return np.concatenate([a[:1], -a[1:]])


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    total: FloatArray = np.sum(a * b, axis=0)
    return total


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack([
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
    ])  # fmt: skip


def unit(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Length and direction, component axis first; no square under- or overflows, 0 stays 0."""
    largest = np.max(np.abs(vector), axis=0)
    safe = np.where(largest > 0.0, largest, 1.0)
    scaled = vector / safe
    length = np.sqrt(_dot(scaled, scaled))
    return largest * length, scaled / np.where(length > 0.0, length, 1.0)


def _quadruples(m: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """``A, B, d`` of ``(*, 12)``, component axis first."""
    c = np.moveaxis(m, -1, 0)
    return c[:4], c[4:8], np.stack([c[11], -c[8], -c[9], -c[10]])


def _joined(a: FloatArray, b: FloatArray, d: FloatArray) -> FloatArray:
    a, b, d = np.broadcast_arrays(a, b, d)
    return np.ascontiguousarray(np.moveaxis(np.concatenate([a, b, -d[1:], d[:1]]), 0, -1))


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geometric product ``a b`` of similarities, ``(*, 12)``."""
    (a1, b1, d1), (a2, b2, d2) = _quadruples(a), _quadruples(b)
    return _joined(
        _product(a1, a2) + _product(b1, b2),
        _product(a1, b2) + _product(b1, a2),
        _product(a1 + b1, d2) + _product(d1, a2 - b2),
    )


def inverse(m: FloatArray) -> FloatArray:
    """Reverse of similarities, ``(*, 12)``: the inverse where they are unit."""
    reverse: FloatArray = m * _REVERSE
    return reverse


def parts(m: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotor ``(4, *)``, half the logarithm of the scale ``(*)`` and translation ``(3, *)`` (m).

    The rotor is read from ``A = R cosh`` and the scale from ``B = R sinh``, where nothing cancels
    however large or small the scale.
    """
    a, b, d = _quadruples(m)
    _, rotor = unit(a)
    half_log_scale = np.arcsinh(_dot(b, rotor))
    moved = _product(d, _reverse(rotor))[1:]
    return rotor, half_log_scale, 2.0 * np.exp(half_log_scale) * moved


def _turn_and_growth(log_scale: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``e^z - 1`` for ``z = log_scale + i angle``, without cancellation near 0."""
    real = np.expm1(log_scale) * np.cos(angle) - 2.0 * np.sin(0.5 * angle) ** 2
    return real, np.exp(log_scale) * np.sin(angle)


def _growth(log_scale: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """``(e^λ - 1) / λ``, and real and imaginary part of ``(e^z - 1) / z``."""
    still = log_scale == 0.0
    along = np.where(still, 1.0, np.expm1(log_scale) / np.where(still, 1.0, log_scale))
    x, y = _turn_and_growth(log_scale, angle)
    square = log_scale**2 + angle**2
    small = square < _SERIES_BELOW_Z2
    safe = np.where(small, 1.0, square)
    z2 = log_scale**2 - angle**2
    real = 1.0 + log_scale / 2 + z2 / 6 + log_scale * (z2 - 2 * angle**2) / 24
    imaginary = angle * (0.5 + log_scale / 3 + (z2 + 2 * log_scale**2) / 24)
    return (
        along,
        np.where(small, real, (x * log_scale + y * angle) / safe),
        np.where(small, imaginary, (y * log_scale - x * angle) / safe),
    )


def _shrinkage(
    log_scale: FloatArray, angle: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """``λ / (e^λ - 1)``, and real and imaginary part of ``z / (e^z - 1)``: safe for ``|θ| ≤ π``."""
    still = log_scale == 0.0
    along = np.where(still, 1.0, log_scale / np.where(still, 1.0, np.expm1(log_scale)))
    x, y = _turn_and_growth(log_scale, angle)
    small = log_scale**2 + angle**2 < _SERIES_BELOW_Z2
    safe = np.where(small, 1.0, x**2 + y**2)
    return (
        along,
        np.where(small, 1.0 - log_scale / 2 + (log_scale**2 - angle**2) / 12,
                 (log_scale * x + angle * y) / safe),
        np.where(small, angle * (log_scale / 6 - 0.5), (angle * x - log_scale * y) / safe),
    )  # fmt: skip


def _spread(
    factors: tuple[FloatArray, FloatArray, FloatArray], axis: FloatArray, vector: FloatArray
) -> FloatArray:
    """The first factor along `axis`, across it the other two as a complex number, ``i = axis×``."""
    along, real, imaginary = factors
    spread: FloatArray = (
        real * vector
        + ((along - real) * _dot(axis, vector)) * axis
        + imaginary * _cross(axis, vector)
    )
    return spread


def exp(log: FloatArray) -> FloatArray:
    """Similarities ``(*, 12)`` from ``(*, 7)`` on ``e23, e31, e12, E, e1∞, e2∞, e3∞``."""
    bivector = np.moveaxis(log, -1, 0)
    half, direction = unit(bivector[:3])
    half_log_scale = bivector[3]
    translation = _spread(
        _growth(2.0 * half_log_scale, 2.0 * half), -direction, -2.0 * bivector[4:]
    )
    rotor = np.concatenate([np.cos(half)[None], np.sin(half) * direction])
    zero = np.zeros_like(translation[:1])
    moved = _product(np.concatenate([zero, 0.5 * translation]), rotor)
    return _joined(
        np.cosh(half_log_scale) * rotor,
        np.sinh(half_log_scale) * rotor,
        np.exp(-half_log_scale) * moved,
    )


def log(m: FloatArray, short_way: bool = True) -> FloatArray:
    """Bivectors ``(*, 7)`` of unit similarities ``(*, 12)``.

    With ``short_way`` the sign is flipped first where the scalar is negative, so half the rotation
    angle is at most π/2; without, it runs up to π, where the axis is lost.
    """
    rotor, half_log_scale, translation = parts(m)
    if short_way:
        rotor = np.where(rotor[:1] < 0.0, -rotor, rotor)
    sine, direction = unit(rotor[1:])
    half = np.arctan2(sine, rotor[0])
    push = _spread(_shrinkage(2.0 * half_log_scale, 2.0 * half), -direction, translation)
    bivector = np.concatenate([half * direction, half_log_scale[None], -0.5 * push])
    return np.ascontiguousarray(np.moveaxis(bivector, 0, -1))


def interpolate(
    a: FloatArray, b: FloatArray, fraction: FloatArray, short_way: bool = True
) -> FloatArray:
    """Constant-speed path ``a exp(fraction log(~a b))``; ``fraction`` broadcasts on the batch."""
    step = log(compose(inverse(a), b), short_way)
    return compose(a, exp(fraction[..., None] * step))


def projected(m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nearest similarities ``(*, 12)`` of even elements, and how well they are defined ``(*)``.

    With ``m ~m = s + F``, ``F² = f`` and ``ν = √(s² - f)`` the versor is ``((s + ν) - F) m /
    (ν √(2 (s + ν)))``. Here ``ν = |P| |N|``, so that its rotor is half-way between the directions
    of ``P`` and ``N`` and its scale is ``|P| / |N|``. The second result is 0 where ``P`` or ``N``
    vanish (no scale) or are opposite (``s = -ν``), and 1 for a versor.
    """
    a, b, d = _quadruples(m)
    (grown, p), (shrunk, n) = unit(a + b), unit(a - b)
    middle, rotor = unit(p + n)
    lesser = np.minimum(grown, shrunk)
    defined = np.where(lesser > 4e-16 * np.maximum(grown, shrunk), 0.5 * middle, 0.0)
    safe_grown, safe_shrunk = np.where(grown > 0, grown, 1.0), np.where(shrunk > 0, shrunk, 1.0)
    half_log_scale = 0.5 * (np.log(safe_grown) - np.log(safe_shrunk))
    size = np.sqrt(safe_grown) * np.sqrt(safe_shrunk)
    moved = _product(_product(rotor, _reverse(p)), d / size)
    lever = _dot(n, rotor)
    moved = moved - (_dot(moved, rotor) / np.where(lever > 0.0, lever, 1.0)) * n
    made = _joined(np.cosh(half_log_scale) * rotor, np.sinh(half_log_scale) * rotor, moved)
    return made, defined
