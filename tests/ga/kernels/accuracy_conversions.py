"""How accurate the kernels are that convert, move points and average: errors against 50 digits.

As `accuracy_motors` has it, whose arithmetic of quadruples is the reference, with that of
`accuracy_similarities` for triples. Angles that are read from a rotor are put together again, and
the rotor compared: where a middle angle locks the others, no angle is the right one. Matrices and
parts are rounded from 50 digits, and what is made of them compared with what they came from. Needs
mpmath.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels import function
from motorcade.ga.kernels.generated.python import KERNELS
from motorcade.ga.versors.euler_angles import SEQUENCES, sequence_operands
from tests.ga.kernels import accuracy_motors as motors
from tests.ga.kernels import accuracy_similarities as similarities
from tests.ga.kernels.accuracy_motors import Numbers, dot, hard_motors, product, worst_error

__all__ = ["conversion_errors"]

Rows = NDArray[Any]
Compared = dict[str, tuple[Rows, list[list[Numbers]]]]


def conversion_errors(dtype: str, seed: int = 0) -> dict[str, float]:
    """The largest normwise error of each kernel in float32 or float64.

    Raises:
        ModuleNotFoundError: without mpmath.
    """
    import mpmath as mp

    rng = np.random.default_rng(seed)
    made: Compared = {}
    with mp.workdps(50):
        given = hard_motors(rng, 2).astype(dtype)
        points = rng.standard_normal((len(given), 3)).astype(dtype)
        for some in (_of_rotors, _of_motors, _of_similarities, _averaged):
            made |= some(given, points, rng)
        made |= _of_angles(given, points, rng)
        return {name: worst_error(ours, exact) for name, (ours, exact) in made.items()}


def _call(name: str, *inputs: Rows) -> Rows:
    out = np.empty((len(inputs[0]), KERNELS[name][2]), inputs[0].dtype)
    function(name)(*inputs, out)
    return out


def _digits(rows: Rows) -> list[list[Any]]:
    import mpmath as mp

    return [[mp.mpf(value) for value in row] for row in rows.tolist()]


def _rounded(rows: list[Numbers], like: Rows) -> Rows:
    return np.array([[float(value) for value in row] for row in rows], like.dtype)


def _negative(row: Numbers) -> list[Any]:
    return [-value for value in row]


def _either(rows: list[Numbers]) -> list[list[Numbers]]:
    """A versor and its negative."""
    return [[row, _negative(row)] for row in rows]


def _one(rows: list[Numbers]) -> list[list[Numbers]]:
    return [[row] for row in rows]


def _quaternion(rotor: Numbers) -> list[Any]:
    return [rotor[0], *_negative(rotor[1:])]


def _turned(rotor: Numbers, point: Numbers) -> list[Any]:
    """In Hamilton's product, as the quadruples are multiplied."""
    return product(product(rotor, [0, *point]), _quaternion(rotor))[1:]


def _joined(rotor: Numbers, t: Numbers) -> motors.Pair:
    return rotor, product([0, *(x / 2 for x in t)], rotor)


def _block(matrix: Numbers) -> list[Any]:
    return [matrix[4 * i + j] for i in range(3) for j in range(3)]


def _homogeneous(matrix: Numbers) -> list[Any]:
    return [*matrix, 0, 0, 0, 1]


def _unit(row: Numbers) -> list[Any]:
    import mpmath as mp

    size = mp.sqrt(dot(row, row))
    return [value / size for value in row]


def _of_rotors(given: Rows, points: Rows, rng: np.random.Generator) -> Compared:
    r = np.ascontiguousarray(given[:, :4])
    exact = [_unit(row) for row in _digits(r)]
    matrices = [_block(motors._matrix(_joined(row, [0, 0, 0]))) for row in exact]
    stretched = (rng.uniform(0.1, 9.0, (len(r), 1)) * r).astype(r.dtype)
    still = [_joined(row, [0, 0, 0]) for row in exact]
    shorter = [
        [
            [-2 * value for value in motors._log(m, sign)[:3]]
            for sign in motors.signs(motors._ONE, m, _tie(r))
        ]
        for m in still
    ]
    as_given = _rounded([own[0] for own in shorter], r)
    return {
        "rotor_apply": (
            _call("rotor_apply", r, points),
            _one([_turned(x, p) for x, p in zip(exact, _digits(points), strict=True)]),
        ),
        "rotor_matrix33": (_call("rotor_matrix33", r), _one(matrices)),
        "rotor_of_matrix33": (
            _call("rotor_of_matrix33", _rounded(matrices, r))[:, :4],
            _either(exact),
        ),
        "rotor_of_quaternion": (
            _call("rotor_of_quaternion", _rounded([_quaternion(x) for x in exact], r))[:, :4],
            _one(exact),
        ),
        "rotor_normalize": (
            _call("rotor_normalize", stretched)[:, :4],
            _one([_unit(row) for row in _digits(stretched)]),
        ),
        "rotor_as_twist": (_call("rotor_as_twist", r), shorter),
        "rotor_of_twist": (
            _call("rotor_of_twist", as_given),
            _one([_rotor_of(row) for row in _digits(as_given)]),
        ),
    }


def _rotor_of(twist: Numbers) -> list[Any]:
    return motors._exp([-value / 2 for value in (*twist, 0, 0, 0)])[0]


def _of_motors(given: Rows, points: Rows, rng: np.random.Generator) -> Compared:
    exact = [motors._motor(row) for row in given]
    matrices = [motors._matrix(m) for m in exact]
    shifts = [matrix[3::4] for matrix in matrices]
    quaternions = _rounded([_quaternion(m[0]) for m in exact], given)
    duals = [[*_quaternion(m[0]), -m[1][0], *m[1][1:]] for m in exact]
    t, rotors = _rounded(shifts, given), _rounded([m[0] for m in exact], given)
    joined = [motors._row(_joined(m[0], x)) for m, x in zip(exact, _digits(t), strict=True)]
    elements = (given + 0.2 * rng.standard_normal(given.shape)).astype(given.dtype)
    kept = np.sum(elements[:, :4] ** 2, axis=-1) > 0.1
    elements[~kept] = given[~kept]
    logs = [[motors._log(m, s) for s in motors.signs(motors._ONE, m, _tie(given))] for m in exact]
    twists = [[[-2 * v for v in row] for row in own] for own in logs]
    as_given = _rounded([own[0] for own in twists], given)
    moved = [similarities._moved(x, p) for x, p in zip(matrices, _digits(points), strict=True)]
    return {
        "translation": (_call("translation", given), _one(shifts)),
        "motor_of": (_call("motor_of", rotors, t), _one(joined)),
        "motor_of_quaternion": (
            _call("motor_of_quaternion", quaternions, t)[:, :8], _one(joined)),
        "motor_of_matrix44": (
            _call("motor_of_matrix44", _rounded([*map(_homogeneous, matrices)], given))[:, :8],
            _either([motors._row(m) for m in exact]),
        ),
        "motor_of_dual_quaternion": (
            _call("motor_of_dual_quaternion", _rounded(duals, given))[:, :8],
            _one([motors._row(m) for m in exact]),
        ),
        "dual_quaternion": (_call("dual_quaternion", given), _one(duals)),
        "project": (
            _call("project", elements)[:, :8],
            _one([motors._row(motors._motor(row)) for row in elements]),
        ),
        "transform": (_call("transform", _rounded(matrices, given), points), _one(moved)),
        "matrix34": (_call("matrix34", given), _one(matrices)),
        "matrix44": (_call("matrix44", given), _one([*map(_homogeneous, matrices)])),
        "apply": (_call("apply", given, points), _one(moved)),
        "as_twist": (_call("as_twist", given), twists),
        "of_twist": (
            _call("of_twist", as_given),
            _one([motors._row(motors._exp([-v / 2 for v in row])) for row in _digits(as_given)]),
        ),
    }  # fmt: skip


def _tie(rows: Rows) -> float:
    return 4 * float(np.finfo(rows.dtype).eps)


def _of_similarities(given: Rows, points: Rows, rng: np.random.Generator) -> Compared:
    import mpmath as mp

    exact = [motors._motor(row) for row in given]
    rotors = _rounded([m[0] for m in exact], given)
    scales = rng.choice(similarities._SCALES, (len(given), 1)).astype(given.dtype)
    t = rng.standard_normal((len(given), 3)).astype(given.dtype)
    triples = []
    for m, shift, (scale,) in zip(exact, _digits(t), _digits(scales), strict=True):
        root = mp.sqrt(scale)
        shrunk = [value / root for value in m[0]]
        lifted = product([0, *(x / 2 for x in shift)], shrunk)
        triples.append(([root * value for value in m[0]], shrunk, lifted))
    rows = [similarities._row(x) for x in triples]
    matrices = [_homogeneous(similarities._matrix(x)) for x in triples]
    rounded = _rounded(rows, given)
    parts = []
    for row in rounded:
        p = similarities._similarity(row)
        rotor, growth = _unit(p[0]), dot(p[0], p[0])
        parts.append([*motors._row(_joined(rotor, similarities._translation(p))), growth])
    again = [similarities._similarity(row) for row in rounded]
    tie = _tie(given)
    twists = [
        [_of_log(similarities._log(x, s)) for s in motors.signs(similarities._ONE, x, tie)]
        for x in again
    ]
    as_given = _rounded([own[0] for own in twists], given)
    made = [similarities._row(similarities._exp(_of_twist(row))) for row in _digits(as_given)]
    return {
        "similarity_of": (_call("similarity_of", rotors, t, scales), _one(rows)),
        "similarity_of_matrix44": (
            _call("similarity_of_matrix44", _rounded(matrices, given))[:, :12],
            _either(rows),
        ),
        "motor_scale": (_call("motor_scale", rounded), _one(parts)),
        "similarity_as_twist": (_call("similarity_as_twist", rounded), twists),
        "similarity_of_twist": (_call("similarity_of_twist", as_given), _one(made)),
    }


def _of_log(log: Numbers) -> list[Any]:
    """The twist of a similarity's bivector: rotation, translation, logarithm of the scale."""
    return [*(-2 * v for v in log[:3]), *(-2 * v for v in log[4:]), 2 * log[3]]


def _of_twist(twist: Numbers) -> list[Any]:
    return [*(-v / 2 for v in twist[:3]), twist[6] / 2, *(-v / 2 for v in twist[3:6])]


def _of_angles(given: Rows, points: Rows, rng: np.random.Generator) -> Compared:
    """All sequences at once, each with some rotors."""
    r = np.ascontiguousarray(given[:, :4])
    exact = [_unit(row) for row in _digits(r)]
    chosen = [sequence_operands(SEQUENCES[k % 12]) for k in range(len(r))]
    axes = np.array([one.axes[r.dtype] for one in chosen])
    frames = np.array([one.frame[r.dtype] for one in chosen])
    angles = rng.uniform(-3.1, 3.1, (len(r), 3)).astype(r.dtype)
    turned = [_of_euler(a, x) for a, x in zip(_digits(angles), axes.tolist(), strict=True)]
    moved = zip(turned, _digits(points), strict=True)
    joined = [motors._row(_joined(rotor, t)) for rotor, t in moved]
    made: Compared = {
        "rotor_of_euler": (_call("rotor_of_euler", angles, axes), _either(turned)),
        "motor_of_euler": (_call("motor_of_euler", angles, axes, points), _either(joined)),
    }
    for name, proper in (("rotor_tait_bryan", False), ("rotor_proper_euler", True)):
        own = np.array([one.proper == proper for one in chosen])
        read = _call(name, np.ascontiguousarray(r[own]), np.ascontiguousarray(frames[own]))
        again = [_of_euler(a, x) for a, x in zip(_digits(read), axes[own].tolist(), strict=True)]
        rows = np.array([[float(value) for value in row] for row in again])
        kept = [row for row, mine in zip(exact, own, strict=True) if mine]
        made[name] = (rows, _either(kept))
    return made


def _of_euler(angles: Numbers, axes: list[float]) -> list[Any]:
    import mpmath as mp

    made: list[Any] = [mp.mpf(1), mp.mpf(0), mp.mpf(0), mp.mpf(0)]
    for k, angle in enumerate(angles):
        sine = -mp.sin(angle / 2)
        made = product(made, [mp.cos(angle / 2), *(sine * x for x in axes[3 * k : 3 * k + 3])])
    return made


def _averaged(given: Rows, points: Rows, rng: np.random.Generator) -> Compared:
    """One versor more in sums: of coefficients beside a pivot, and of twists."""
    weights = rng.uniform(-1.0, 1.0, (len(given), 1)).astype(given.dtype)
    sums = rng.standard_normal((len(given), 13)).astype(given.dtype)
    grown = similarities.hard_similarities(rng, 2).astype(given.dtype)
    kinds: tuple[tuple[str, Rows, Callable[[Any, Any, int], Numbers]], ...] = (
        ("rotor_", np.ascontiguousarray(given[:, :4]), _rotor_local),
        ("", given, lambda a, b, sign: _motor_local(motors._motor(a), motors._motor(b), sign)),
        ("similarity_", grown, _similarity_local),
    )
    made: Compared = {}
    for prefix, m, local in kinds:
        pivot = m[rng.permutation(len(m))]
        d = KERNELS[f"{prefix}add_local"][2]
        total, twists = sums[:, : m.shape[1] + 1].copy(), sums[:, :d].copy()
        added, moved = [], []
        for s, twist, a, b, (w,), first, second in zip(
            _digits(total), _digits(twists), _digits(pivot), _digits(m), _digits(weights), pivot, m,
            strict=True,
        ):  # fmt: skip
            both = motors.signs([a[:4]], [b[:4]], _tie(m))
            bulk = s[-1] + abs(w) * max(map(abs, b[:4]))
            added.append([[*_plus(s[:-1], sign * w, b), bulk] for sign in both])
            moved.append([_plus(twist, w, local(first, second, sign)) for sign in both])
        name = f"{prefix}add_weighted"
        made[name] = (_call(name, total, pivot, m, weights), added)
        name = f"{prefix}add_local"
        made[name] = (_call(name, twists, pivot, m, weights), moved)
    return made


def _plus(total: Numbers, weight: Any, more: Numbers) -> list[Any]:
    return [x + weight * y for x, y in zip(total, more, strict=True)]


def _motor_local(a: motors.Pair, b: motors.Pair, sign: int) -> list[Any]:
    return [-2 * v for v in motors._log(motors._times(motors._reverse(a), b), sign)]


def _rotor_local(a: Rows, b: Rows, sign: int) -> list[Any]:
    (first,), (second,) = _digits(a[None]), _digits(b[None])
    still = [0, 0, 0]
    return _motor_local(_joined(_unit(first), still), _joined(_unit(second), still), sign)[:3]


def _similarity_local(a: Rows, b: Rows, sign: int) -> list[Any]:
    first, second = similarities._similarity(a), similarities._similarity(b)
    between = similarities._times(similarities._undone(first), second)
    return _of_log(similarities._log(between, sign))
