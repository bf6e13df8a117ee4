"""How accurate the kernels of motors are: normwise errors against 50 digits over hard samples.

The reference is written out here in mpmath and shares nothing with the definitions: products of
quadruples, `atan2`, sines and cosines. It is fed the same rounded inputs, brought onto the motors
at 50 digits; where both arcs are equally long to 4 eps, either counts. An error is
``|ours - reference| / |reference|`` over all components of a row. Needs mpmath.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels import (
    MOTORS,
    blend_matrix,
    screw_blend,
    screw_blend_matrix,
)

__all__ = ["Numbers", "dot", "hard_motors", "largest_errors", "product", "signs", "worst_error"]

_ANGLES = (0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 0.1, 1.0, 2.0, 3.0, pi - 1e-9, pi)
_FRACTIONS = (0.0, 0.3, 0.5, 1.0)

Numbers = Sequence[Any]
Pair = tuple[Numbers, Numbers]

_ONE: Pair = ([1, 0, 0, 0], [0, 0, 0, 0])


def hard_motors(rng: np.random.Generator, each: int = 4) -> NDArray[np.float64]:
    """Motors ``(n, 8)`` that turn by 0, 1e-12 … π, of both signs, and pure translations."""
    made = []
    for angle in _ANGLES:
        for _ in range(each):
            axis = rng.standard_normal(3)
            axis /= np.linalg.norm(axis)
            scalar = 0.0 if angle == pi else np.cos(0.5 * angle)
            rotor = np.array([scalar, *(-np.sin(0.5 * angle) * axis)])
            made.append(_moved(rotor, rng.standard_normal(3)))
            made.append(-_moved(rotor, rng.standard_normal(3)))
    return np.array(made)


def largest_errors(dtype: str, seed: int = 0) -> dict[str, float]:
    """The largest normwise error of each kernel in float32 or float64.

    Raises:
        ModuleNotFoundError: without mpmath.
    """
    import mpmath as mp

    rng = np.random.default_rng(seed)
    a = hard_motors(rng).astype(dtype)
    # Pairs whose difference is hard, and pairs anywhere.
    near = MOTORS.compose(hard_motors(rng).astype("float64"), a.astype("float64")).astype(dtype)
    b = np.where(rng.uniform(size=(len(a), 1)) < 0.8, near, a[::-1])
    fractions = rng.choice(_FRACTIONS, len(a)).astype(dtype)
    logs = MOTORS.log(a)
    tie = 4 * float(np.finfo(dtype).eps)
    with mp.workdps(50):
        first, second = [_motor(row) for row in a], [_motor(row) for row in b]
        steps = [mp.mpf(fraction) for fraction in fractions.tolist()]
        pairs = list(zip(first, second, steps, strict=True))
        arcs = [[_between(x, y, f, sign) for sign in signs(x, y, tie)] for x, y, f in pairs]
        lines = [[_mixed(x, y, f, sign) for sign in signs(x, y, tie)] for x, y, f in pairs]
        compared: dict[str, tuple[Any, list[list[Numbers]]]] = {
            "compose": (MOTORS.compose(a, b), [[_row(_times(x, y))] for x, y, _ in pairs]),
            "log": (logs, [[_log(x, sign) for sign in signs(_ONE, x, 0)] for x in first]),
            "exp": (
                MOTORS.exp(logs),
                [[_row(_exp([mp.mpf(v) for v in row.tolist()]))] for row in logs],
            ),
            "interpolate": (
                MOTORS.interpolate(a, b, fractions),
                [[*map(_row, both)] for both in arcs],
            ),
            "screw_blend": (screw_blend(a, b, fractions), [[*map(_row, both)] for both in arcs]),
            "screw_blend_matrix": (
                screw_blend_matrix(a, b, fractions),
                [[*map(_matrix, both)] for both in arcs],
            ),
            "blend_matrix": (
                blend_matrix(a, b, fractions),
                [[*map(_matrix, both)] for both in lines],
            ),
        }
        return {name: worst_error(ours, reference) for name, (ours, reference) in compared.items()}


def worst_error(ours: NDArray[Any], references: list[list[Numbers]]) -> float:
    """The largest normwise error of rows, each beside the nearest of its references."""
    rows = ours.reshape(len(ours), -1).tolist()
    return max(
        min(_error(row, exact) for exact in either)
        for row, either in zip(rows, references, strict=True)
    )


def _error(row: Sequence[float], exact: Numbers) -> float:
    import mpmath as mp

    off = mp.norm([mp.mpf(x) - y for x, y in zip(row, exact, strict=True)])
    size = mp.norm(exact)
    return float(off / size if size else off)


def signs(a: Sequence[Numbers], b: Sequence[Numbers], tie: float) -> list[int]:
    """The sign that takes b the short way from a; where the arcs are equally long, both."""
    scalar = dot(a[0], b[0])
    short = -1 if scalar < 0 else 1
    return [short, -short] if abs(scalar) <= tie else [short]


def _moved(rotor: NDArray[Any], t: NDArray[Any]) -> NDArray[Any]:
    w, v = rotor[0], rotor[1:]
    return np.array([*rotor, *(-0.5 * (w * t + np.cross(v, t))), -0.5 * (v @ t)])


def product(a: Numbers, b: Numbers) -> list[Any]:
    """Quadruples multiplied on ``1, e23, e31, e12``, where ``e23 e31 = -e12``."""
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ]


def _times(a: Pair, b: Pair) -> Pair:
    dual = zip(product(a[0], b[1]), product(a[1], b[0]), strict=True)
    return product(a[0], b[0]), [x + y for x, y in dual]


def _reverse(a: Pair) -> Pair:
    return [a[0][0], *(-x for x in a[0][1:])], [a[1][0], *(-x for x in a[1][1:])]


def dot(a: Numbers, b: Numbers) -> Any:
    """Sum of products."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def _unit(real: Numbers, dual: Numbers) -> Pair:
    import mpmath as mp

    norm = mp.sqrt(dot(real, real))
    real, dual = [x / norm for x in real], [x / norm for x in dual]
    off = dot(real, dual)
    return real, [x - off * y for x, y in zip(dual, real, strict=True)]


def _motor(row: NDArray[Any]) -> Pair:
    import mpmath as mp

    m = [mp.mpf(x) for x in row.tolist()]
    return _unit(m[:4], [m[7], -m[4], -m[5], -m[6]])


def _row(m: Pair) -> list[Any]:
    return [*m[0], *(-x for x in m[1][1:]), m[1][0]]


def _log(m: Pair, sign: int) -> list[Any]:
    import mpmath as mp

    (w, *v), (last, *n) = [sign * x for x in m[0]], [sign * x for x in m[1]]
    s = mp.sqrt(dot(v, v))
    if s == 0:
        return [*v, *(-x for x in n)]
    h = mp.atan2(s, w)
    g = (1 - h * w / s) / s**2
    return [*(h / s * x for x in v), *(g * last * x - h / s * y for x, y in zip(v, n, strict=True))]


def _exp(log: Numbers) -> Pair:
    import mpmath as mp

    a, b = log[:3], [-x for x in log[3:]]
    h = mp.sqrt(dot(a, a))
    sinc = mp.sin(h) / h if h else mp.mpf(1)
    k = (mp.cos(h) - sinc) / h**2 if h else -mp.mpf(1) / 3
    along = dot(a, b)
    dual = [sinc * y + along * k * x for x, y in zip(a, b, strict=True)]
    return [mp.cos(h), *(sinc * x for x in a)], [-sinc * along, *dual]


def _between(a: Pair, b: Pair, fraction: Any, sign: int) -> Pair:
    return _times(a, _exp([fraction * x for x in _log(_times(_reverse(a), b), sign)]))


def _mixed(a: Pair, b: Pair, fraction: Any, sign: int) -> Pair:
    part = sign * fraction
    halves = [
        [(1 - fraction) * x + part * y for x, y in zip(p, q, strict=True)]
        for p, q in zip(a, b, strict=True)
    ]
    return _unit(halves[0], halves[1])


def _matrix(m: Pair) -> list[Any]:
    w, x, y, z = m[0][0], *(-v for v in m[0][1:])
    t = [2 * v for v in product(m[1], _reverse(m)[0])[1:]]
    return [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), t[0],
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), t[1],
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), t[2],
    ]  # fmt: skip
