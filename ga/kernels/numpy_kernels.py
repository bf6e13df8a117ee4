"""Motor and rotor kernels in NumPy: the fallback, and the witness of the compiled ones.

Coefficient order: rotor ``1, e23, e31, e12``; motor the same and ``e1∞, e2∞, e3∞, e123∞``.
With ``J = e123∞`` (``J² = 0``, it commutes with motors, ``J e23 = -e1∞``) a motor is a pair of
rotor-like quadruples ``real + J dual`` with ``dual = (m7, -m4, -m5, -m6)``. Inside this module the
component axis comes first, so every line works on whole batches; no line branches on an element.

Inputs are float64, ``(*, 4)`` or ``(*, 8)``, and broadcast; they are not validated here.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

__all__ = [
    "compose", "exp", "interpolate", "inverse", "log",
    "rotor_compose", "rotor_exp", "rotor_interpolate", "rotor_inverse", "rotor_log",
]  # fmt: skip

# Added under square roots: without effect on normal numbers, and it makes x/x come out as 1 at 0.
_TINY = 1e-300
# Below these squares the closed forms cancel; the series are then good to the last bit.
_SERIES_BELOW_SIN2 = 0.02
_SERIES_BELOW_ANGLE2 = 0.25
_REVERSE_ROTOR = np.array([1.0, -1.0, -1.0, -1.0])
_REVERSE_MOTOR = np.array([1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, 1.0])


def _components(array: FloatArray) -> FloatArray:
    return np.moveaxis(array, -1, 0)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geometric product on ``1, e23, e31, e12``, component axis first (note ``e23 e31 = -e12``)."""
    return np.stack([
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ])  # fmt: skip


def _dot3(a: FloatArray, b: FloatArray) -> FloatArray:
    total: FloatArray = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return total


def _dual(m: FloatArray) -> FloatArray:
    return np.stack([m[7], -m[4], -m[5], -m[6]])


def _motor(real: FloatArray, dual: FloatArray) -> FloatArray:
    joined = np.concatenate([real, -dual[1:], dual[:1]])
    return np.ascontiguousarray(np.moveaxis(joined, 0, -1))


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geometric product ``a b`` of motors, ``(*, 8)``."""
    first, second = _components(a), _components(b)
    real = _product(first[:4], second[:4])
    dual = _product(first[:4], _dual(second)) + _product(_dual(first), second[:4])
    return _motor(real, dual)


def inverse(m: FloatArray) -> FloatArray:
    """Reverse of motors, ``(*, 8)``: the inverse where they are unit."""
    reverse: FloatArray = m * _REVERSE_MOTOR
    return reverse


def _exp_factors(angle2: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """``cos h``, ``sin h / h`` and ``(cos h - sin h / h) / h²`` from ``h²``."""
    x = angle2 + _TINY
    h = np.sqrt(x)
    cosine, sinc = np.cos(h), np.sin(h) / h
    series = -1 / 3 + x * (
        1 / 30 - x * (1 / 840 - x * (1 / 45360 - x * (1 / 3991680 - x * (1 / 518918400))))
    )
    slope = np.where(x < _SERIES_BELOW_ANGLE2, series, (cosine - sinc) / x)
    return cosine, sinc, slope


def exp(log: FloatArray) -> FloatArray:
    """Motors ``(*, 8)`` from bivectors ``(*, 6)`` on ``e23, e31, e12, e1∞, e2∞, e3∞``."""
    bivector = _components(log)
    a, b = bivector[:3], -bivector[3:]
    cosine, sinc, slope = _exp_factors(_dot3(a, a))
    along = _dot3(a, b)
    real = np.concatenate([cosine[None], sinc * a])
    dual = np.concatenate([(-sinc * along)[None], sinc * b + (along * slope) * a])
    return _motor(real, dual)


def _log_factors(real: FloatArray, short_way: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sign that takes the short way, ``h / s`` and ``(1 - h w / s) / s²`` of the signed rotor.

    At ``w = 0`` both ways are equally long; the sign of the versor as it came then decides.
    """
    short = np.where(real[0] < 0.0, -1.0, 1.0)
    sign = short if short_way else np.ones_like(short)
    w = sign * real[0]
    x = _dot3(real[1:], real[1:]) + _TINY
    s = np.sqrt(x)
    ratio = np.arctan2(s, w) / s
    series = 1 / 3 + x * (
        2 / 15 + x * (8 / 105 + x * (16 / 315 + x * (128 / 3465 + x * (
            256 / 9009 + x * (1024 / 45045 + x * (2048 / 109395)))))))  # fmt: skip
    slope = np.where((x < _SERIES_BELOW_SIN2) & (w > 0.0), series, (1.0 - ratio * w) / x)
    return sign, ratio, slope


def log(m: FloatArray, short_way: bool = True) -> FloatArray:
    """Bivectors ``(*, 6)`` of unit motors ``(*, 8)``.

    With ``short_way`` the sign is flipped first where ``w < 0``, so half the rotation angle is at
    most π/2; without, it runs up to π, where the axis is lost.
    """
    motor = _components(m)
    real, dual = motor[:4], _dual(motor)
    sign, ratio, slope = _log_factors(real, short_way)
    a = (sign * ratio) * real[1:]
    b = (sign * ratio) * dual[1:] - (slope * dual[0]) * real[1:]
    return np.ascontiguousarray(np.moveaxis(np.concatenate([a, -b]), 0, -1))


def interpolate(
    a: FloatArray, b: FloatArray, fraction: FloatArray, short_way: bool = True
) -> FloatArray:
    """Screw interpolation ``a exp(fraction log(~a b))``; ``fraction`` broadcasts on the batch."""
    step = log(compose(inverse(a), b), short_way)
    return compose(a, exp(fraction[..., None] * step))


def rotor_compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geometric product ``a b`` of rotors, ``(*, 4)``."""
    product = _product(_components(a), _components(b))
    return np.ascontiguousarray(np.moveaxis(product, 0, -1))


def rotor_inverse(r: FloatArray) -> FloatArray:
    """Reverse of rotors, ``(*, 4)``: the inverse where they are unit."""
    reverse: FloatArray = r * _REVERSE_ROTOR
    return reverse


def rotor_exp(log: FloatArray) -> FloatArray:
    """Rotors ``(*, 4)`` from bivectors ``(*, 3)`` on ``e23, e31, e12``."""
    h = np.sqrt(np.sum(log * log, axis=-1, keepdims=True) + _TINY)
    return np.concatenate([np.cos(h), (np.sin(h) / h) * log], axis=-1)


def rotor_log(r: FloatArray, short_way: bool = True) -> FloatArray:
    """Bivectors ``(*, 3)`` of unit rotors ``(*, 4)``; the sign rule of `log`."""
    sign, ratio, _ = _log_factors(_components(r), short_way)
    bivector: FloatArray = (sign * ratio)[..., None] * r[..., 1:]
    return bivector


def rotor_interpolate(
    a: FloatArray, b: FloatArray, fraction: FloatArray, short_way: bool = True
) -> FloatArray:
    """Great-circle interpolation ``a exp(fraction log(~a b))``."""
    step = rotor_log(rotor_compose(rotor_inverse(a), b), short_way)
    return rotor_compose(a, rotor_exp(fraction[..., None] * step))
