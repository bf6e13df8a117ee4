"""How accurate the kernels of similarities are: normwise errors against 50 digits.

As `motors` has it, with scales from a quarter to four. In the reference a similarity
``A + B E + d e123∞`` is the three quadruples ``P = A + B``, ``N = A - B`` and ``d``, of which
products are ``P₁P₂, N₁N₂, P₁d₂ + d₁N₂``; projection is the closed form ``((s + ν) - F) m /
(ν √(2 (s + ν)))`` of ``m ~m = s + F``, logarithm and exponential are those of the complex number
``z = ln ρ + iθ``. Needs mpmath.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels import (
    SIMILARITIES,
    similarity_blend,
    similarity_normalize,
    similarity_of_motor,
)
from tests.ga.kernels.accuracy_motors import (
    Numbers,
    dot,
    hard_motors,
    product,
    signs,
    worst_error,
)

__all__ = ["hard_similarities", "similarity_errors"]

_SCALES = (1.0, 1 + 1e-12, 1 - 1e-9, 1 + 1e-6, 0.999, 0.25, 1.5, 4.0)
_FRACTIONS = (0.0, 0.3, 0.5, 1.0)

Triple = tuple[Numbers, Numbers, Numbers]

_ONE: Triple = ([1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0])


def hard_similarities(rng: np.random.Generator, each: int = 4) -> NDArray[np.float64]:
    """Similarities ``(n, 12)``: hard motors after growth by 1/4 … 4, next to nothing included."""
    motors = hard_motors(rng, each)
    made: NDArray[np.float64] = similarity_of_motor(motors, rng.choice(_SCALES, len(motors)))
    return made


def similarity_errors(dtype: str, seed: int = 0) -> dict[str, float]:
    """The largest normwise error of each kernel in float32 or float64.

    Raises:
        ModuleNotFoundError: without mpmath.
    """
    import mpmath as mp

    rng = np.random.default_rng(seed)
    a = hard_similarities(rng).astype(dtype)
    # Pairs whose difference is hard, and pairs anywhere.
    near = SIMILARITIES.compose(hard_similarities(rng), a.astype("float64")).astype(dtype)
    b = np.where(rng.uniform(size=(len(a), 1)) < 0.8, near, a[::-1])
    fractions = rng.choice(_FRACTIONS, len(a)).astype(dtype)
    points = rng.standard_normal((len(a), 3)).astype(dtype)
    elements = (a + 0.2 * rng.standard_normal(a.shape)).astype(dtype)
    logs, tie = SIMILARITIES.log(a), 4 * float(np.finfo(dtype).eps)
    with mp.workdps(50):
        first, second = [_similarity(row) for row in a], [_similarity(row) for row in b]
        steps = [mp.mpf(fraction) for fraction in fractions.tolist()]
        pairs = list(zip(first, second, steps, strict=True))

        def both(path: Callable[..., Triple]) -> list[list[Numbers]]:
            return [[_row(path(*pair, sign)) for sign in signs(*pair[:2], tie)] for pair in pairs]

        compared: dict[str, tuple[Any, list[list[Numbers]]]] = {
            "compose": (SIMILARITIES.compose(a, b), [[_row(_times(x, y))] for x, y, _ in pairs]),
            "log": (logs, [[_log(x, sign) for sign in signs(_ONE, x, tie)] for x in first]),
            "exp": (SIMILARITIES.exp(logs), [[_row(_exp(_digits(row)))] for row in logs]),
            "interpolate": (SIMILARITIES.interpolate(a, b, fractions), both(_between)),
            "blend": (similarity_blend(a, b, fractions), both(_mixed)),
            "normalize": (
                similarity_normalize(elements)[0],
                [[_row(_similarity(row))] for row in elements],
            ),
            "apply": (
                SIMILARITIES.apply(a, points),
                [[_moved(_matrix(x), _digits(p))] for x, p in zip(first, points, strict=True)],
            ),
            "matrix34": (SIMILARITIES.matrix34(a), [[_matrix(x)] for x in first]),
        }
        return {f"similarity_{name}": worst_error(*pair) for name, pair in compared.items()}


def _digits(row: NDArray[Any]) -> list[Any]:
    import mpmath as mp

    return [mp.mpf(value) for value in row.tolist()]


def _sum(*rows: Numbers) -> list[Any]:
    return [sum(column) for column in zip(*rows, strict=True)]


def _scaled(factor: Any, row: Numbers) -> list[Any]:
    return [factor * value for value in row]


def _reverse(row: Numbers) -> list[Any]:
    return [row[0], *(-value for value in row[1:])]


def _times(x: Triple, y: Triple) -> Triple:
    moved = _sum(product(x[0], y[2]), product(x[2], y[1]))
    return product(x[0], y[0]), product(x[1], y[1]), moved


def _undone(x: Triple) -> Triple:
    return _reverse(x[1]), _reverse(x[0]), _reverse(x[2])


def _similarity(row: NDArray[Any]) -> Triple:
    m = _digits(row)
    grown, shrunk = _sum(m[:4], m[4:8]), _sum(m[:4], _scaled(-1, m[4:8]))
    return _projected((grown, shrunk, [m[11], -m[8], -m[9], -m[10]]))


def _row(x: Triple) -> list[Any]:
    even, odd = _sum(x[0], x[1]), _sum(x[0], _scaled(-1, x[1]))
    return [*(v / 2 for v in even), *(v / 2 for v in odd), *(-v for v in x[2][1:]), x[2][0]]


def _projected(m: Triple) -> Triple:
    import mpmath as mp

    (s, *g), _, moved = _times(m, _undone(m))
    nu = mp.sqrt(s**2 + dot(g, g))
    size = nu * mp.sqrt(2 * (s + nu))
    left = [s + nu, *(-v for v in g)], [s + nu, *g], _scaled(-1, moved)
    return _times(
        (_scaled(1 / size, left[0]), _scaled(1 / size, left[1]), _scaled(1 / size, left[2])), m
    )


def _across(axis: Numbers, vector: Numbers, along: Any, factor: Any) -> list[Any]:
    """`along` the axis, and across it a complex factor, ``i = axis×``."""
    (i, j, k), (x, y, z) = axis, vector
    on_axis = _scaled(dot(axis, vector), axis)
    off_axis = _sum(vector, _scaled(-1, on_axis))
    turned = [j * z - k * y, k * x - i * z, i * y - j * x]
    return _sum(
        _scaled(along, on_axis), _scaled(factor.real, off_axis), _scaled(factor.imag, turned)
    )


def _exp(log: Numbers) -> Triple:
    import mpmath as mp

    half, h = mp.sqrt(dot(log[:3], log[:3])), log[3]
    axis = _scaled(-1 / half, log[:3]) if half else [mp.mpf(0)] * 3
    z = mp.mpc(2 * h, 2 * half)
    along = mp.expm1(2 * h) / (2 * h) if h else mp.mpf(1)
    t = _across(axis, _scaled(-2, log[4:]), along, mp.expm1(z) / z if z else mp.mpc(1))
    rotor = [mp.cos(half), *_scaled(-mp.sin(half), axis)]
    shrunk = _scaled(mp.exp(-h), rotor)
    return _scaled(mp.exp(h), rotor), shrunk, product([mp.mpf(0), *_scaled(0.5, t)], shrunk)


def _log(x: Triple, sign: int) -> list[Any]:
    import mpmath as mp

    size = mp.sqrt(dot(x[0], x[0]))
    rotor, h = _scaled(sign / size, x[0]), mp.log(size)
    sine = mp.sqrt(dot(rotor[1:], rotor[1:]))
    half = mp.atan2(sine, rotor[0])
    axis = _scaled(-1 / sine, rotor[1:]) if sine else [mp.mpf(0)] * 3
    z = mp.mpc(2 * h, 2 * half)
    along = 2 * h / mp.expm1(2 * h) if h else mp.mpf(1)
    u = _across(axis, _translation(x), along, z / mp.expm1(z) if z else mp.mpc(1))
    return [*_scaled(-half, axis), h, *_scaled(-0.5, u)]


def _translation(x: Triple) -> list[Any]:
    return [2 * v for v in product(x[2], _reverse(x[0]))[1:]]


def _between(a: Triple, b: Triple, fraction: Any, sign: int) -> Triple:
    return _times(a, _exp(_scaled(fraction, _log(_times(_undone(a), b), sign))))


def _mixed(a: Triple, b: Triple, fraction: Any, sign: int) -> Triple:
    grown, shrunk, moved = (
        _sum(_scaled(1 - fraction, p), _scaled(sign * fraction, q))
        for p, q in zip(a, b, strict=True)
    )
    return _projected((grown, shrunk, moved))


def _matrix(x: Triple) -> list[Any]:
    """By rows, from the images of the axes under ``P e ~P``, as in Hamilton's product."""
    columns = []
    for k in range(3):
        axis = [0, *(1 if i == k else 0 for i in range(3))]
        columns.append(product(product(x[0], axis), _reverse(x[0]))[1:])
    columns.append(_translation(x))
    return [columns[j][i] for i in range(3) for j in range(4)]


def _moved(matrix: Numbers, point: Numbers) -> list[Any]:
    return [dot(matrix[4 * i : 4 * i + 3], point) + matrix[4 * i + 3] for i in range(3)]
