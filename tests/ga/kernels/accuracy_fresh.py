"""How accurate kernels of motors are on fresh inputs of any size, beside each input's condition.

Translations of 1e-3 to 1e3 that cancel leave a result that is small beside its inputs: rounding of
these alone then moves it by more than one of its own. So an error is given in roundings
(`numpy.finfo.eps`) times the condition of its input, ``|a| |b| / |a b|`` where motors multiply,
``(|x| + |t|) / |x'|`` for points, 1 else (N. J. Higham, Accuracy and Stability of Numerical
Algorithms, 2nd ed., 2002, ch. 1 and 3). The limits are by that book's bounds of sums of so many
products, set before anything was measured.

The reference shares nothing with the definitions: quadruples in 80-bit numbers, whose own rounding
is 2,000 times finer than that of float64. Where such are not to be had, there is no reference.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels import MOTORS
from tests.ga.kernels.accuracy_motors import dot, product

Numbers = NDArray[np.longdouble]
Pair = tuple[Any, Any]

LIMITS = {"compose": 8.0, "apply": 16.0, "exp": 4.0, "log": 8.0, "interpolate": 24.0}
"""Roundings times the condition that an error may have: a product is eight sums of two products and
one of eight; points go through two; exp and log end in one product; interpolation is all of them.
"""
_BLOCK = 50_000


def fresh_motors(rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Motors ``(count, 8)`` that turn by 1e-9 … π about any axis and move by 1e-3 … 1e3."""
    angles = np.where(
        rng.uniform(size=count) < 0.5,
        rng.uniform(0.0, np.pi, count),
        np.pi * 10.0 ** rng.uniform(-9.0, 0.0, count),
    )
    axes, ways = rng.standard_normal((2, count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    ways *= (10.0 ** rng.uniform(-3.0, 3.0, count) / np.linalg.norm(ways, axis=1))[:, None]
    twists = np.concatenate([angles[:, None] * axes, ways], axis=1)
    return np.asarray(MOTORS.exp(-0.5 * twists))


def fresh_errors(dtype: str, count: int, seed: int = 0) -> dict[str, tuple[float, float]]:
    """Of each kernel the largest normwise error, and the largest in roundings times the condition.

    Raises:
        RuntimeError: 80-bit numbers are not to be had here.
    """
    if np.finfo(np.longdouble).eps > 2e-19:
        raise RuntimeError("numpy.longdouble: expected 64 bits of mantissa or more, got fewer")
    rng, worst = np.random.default_rng(seed), dict.fromkeys(LIMITS, (0.0, 0.0))
    for first in range(0, count, _BLOCK):
        for name, found in _block(dtype, min(_BLOCK, count - first), rng).items():
            worst[name] = (max(worst[name][0], found[0]), max(worst[name][1], found[1]))
    return worst


def _block(dtype: str, count: int, rng: np.random.Generator) -> dict[str, tuple[float, float]]:
    a, b = (fresh_motors(rng, count).astype(dtype) for _ in range(2))
    fractions = rng.uniform(0.0, 1.0, count).astype(dtype)
    points = rng.standard_normal((count, 3)) * 10.0 ** rng.uniform(-3.0, 3.0, (count, 1))
    points, logs = points.astype(dtype), MOTORS.log(a)
    first, second = _motor(a), _motor(b)
    both = _between(first, second, fractions.astype(np.longdouble))
    moved = _applied(first, points.astype(np.longdouble).T)
    reach = _norm(points.astype(np.longdouble).T) + _norm(_shift(first))
    sizes = _norm(np.concatenate(first)) * _norm(np.concatenate(second))
    ones = np.ones(count, np.longdouble)
    kinds: dict[str, tuple[NDArray[Any], Any, Callable[[Any], Any]]] = {
        "compose": (MOTORS.compose(a, b), _row(_times(first, second)), lambda size: sizes / size),
        "apply": (MOTORS.apply(a, points), moved, lambda size: reach / size),
        "exp": (MOTORS.exp(logs), _row(_exp(logs.astype(np.longdouble).T)), lambda size: ones),
        "log": (logs, _log(first), lambda size: ones),
        "interpolate": (MOTORS.interpolate(a, b, fractions), both, lambda size: sizes / size),
    }
    eps, found = float(np.finfo(dtype).eps), {}
    for name, (ours, exact, condition) in kinds.items():
        exact = np.asarray(exact)
        size = _norm(exact)
        off = _norm(ours.astype(np.longdouble).T - exact) / size
        found[name] = (float(off.max()), float((off / condition(size)).max()) / eps)
    return found


def _norm(rows: Any) -> Any:
    return np.sqrt(np.sum(np.square(rows), axis=0))


def _motor(rows: NDArray[Any]) -> Pair:
    """Motors of 80 bits: the nearest of the rounded ones."""
    m = rows.astype(np.longdouble).T
    real, dual = m[:4], np.array([m[7], -m[4], -m[5], -m[6]])
    norm = _norm(real)
    real, dual = real / norm, dual / norm
    return real, dual - dot(real, dual) * real


def _row(m: Pair) -> list[Any]:
    return [*m[0], *(-x for x in m[1][1:]), m[1][0]]


def _times(a: Pair, b: Pair) -> Pair:
    dual = np.array(product(a[0], b[1])) + np.array(product(a[1], b[0]))
    return np.array(product(a[0], b[0])), dual


def _reverse(a: Pair) -> Pair:
    signs = np.array([[1], [-1], [-1], [-1]])
    return signs * a[0], signs * a[1]


def _log(m: Pair) -> list[Any]:
    short = np.where(m[0][0] < 0, -1, 1)
    (w, *v), (last, *n) = short * m[0], short * m[1]
    s = _norm(v)
    h = np.arctan2(s, w)
    g = (1 - h * w / s) / s**2
    return [*(h / s * x for x in v), *(g * last * x - h / s * y for x, y in zip(v, n, strict=True))]


def _exp(log: Any) -> Pair:
    a, b = np.asarray(log[:3]), -np.asarray(log[3:])
    h = _norm(a)
    sinc = np.sin(h) / h
    along = dot(a, b)
    dual = sinc * b + along * (np.cos(h) - sinc) / h**2 * a
    return np.array([np.cos(h), *(sinc * a)]), np.array([-sinc * along, *dual])


def _between(a: Pair, b: Pair, fractions: Any) -> Any:
    short = np.where(dot(a[0], b[0]) < 0, -1, 1)
    between = _times(_reverse(a), (short * b[0], short * b[1]))
    return _row(_times(a, _exp(fractions * np.array(_log(between)))))


def _applied(m: Pair, points: Any) -> Any:
    turned = product(product(m[0], np.insert(points, 0, 0, axis=0)), _reverse(m)[0])[1:]
    return np.array(turned) + _shift(m)


def _shift(m: Pair) -> Any:
    return 2 * np.array(product(m[1], _reverse(m)[0])[1:])
