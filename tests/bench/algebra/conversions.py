"""Points moved and versors converted: one at a time and in batches, beside scipy in the same run.

Of one it is the time of a whole call from Python in float64, checks included; of a batch of 100,000
that time divided by their number. scipy converts in float64 alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity, Versor, blend, mean
from tests.bench.timing import median_seconds, on_one_core

__all__ = ["bench_conversions", "conversions_table"]

COUNT = 100_000
SECONDS = 0.25
Call = Callable[[], object]


def bench_conversions() -> dict[str, Any]:
    """Times by what is done: of one in µs, of each of a batch in ns."""
    with on_one_core():
        return {"apply": _applied(), "conversions": _converted(), "averages": _averages()}


def conversions_table(found: Mapping[str, Any]) -> str:
    """All figures as text; a dash where scipy has no such thing."""
    lines = [f"{f'{COUNT:,} points moved, µs':<44}{'one':>10}{'as many':>10}"]
    for name, row in found["apply"].items():
        lines.append(f"{name:<44}{_number(row['one'])}{_number(row['many'])}")
    lines += ["", f"{'converted':<44}{'one, µs':>10}{'scipy':>10}{'each, ns':>10}{'scipy':>10}"]
    for name, row in found["conversions"].items():
        told = "".join(_number(row.get(key)) for key in ("one", "scipy_one", "each", "scipy_each"))
        lines.append(name.ljust(44) + told)
    lines += ["", f"{'of four versors, ns a result':<44}{'blend':>10}{'mean':>10}"]
    for name, row in found["averages"].items():
        lines.append(f"{name:<44}{_number(row['blend'])}{_number(row['mean'])}")
    return "\n".join(lines) + "\n"


def _number(value: float | None) -> str:
    return f"{'–':>10}" if value is None else f"{value:>10.2f}"


def _seconds(call: Call) -> float:
    return median_seconds(call, SECONDS)


def _applied() -> dict[str, dict[str, float]]:
    """Microseconds of one versor on all points, and of as many versors as points."""
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(0)
    found: dict[str, dict[str, float]] = {}
    for scalar in ("float64", "float32"):
        points = rng.standard_normal((COUNT, 3)).astype(scalar)
        for kind in (Rotor, Motor, Similarity):
            many = kind(kind.random(rng, (COUNT,)).coefficients).astype(scalar)
            one = many[0]
            found[f"{kind.__name__}.apply, {scalar}"] = {
                "one": 1e6 * _seconds(partial(one.apply, points)),
                "many": 1e6 * _seconds(partial(many.apply, points)),
            }
    points = rng.standard_normal((COUNT, 3))
    turns = Rotation.random(COUNT, rng=1)
    found["scipy Rotation.apply, float64"] = {
        "one": 1e6 * _seconds(lambda: turns[0].apply(points)),
        "many": 1e6 * _seconds(lambda: turns.apply(points)),
    }
    return found


def _converted() -> dict[str, dict[str, float]]:
    rng = np.random.default_rng(1)
    found: dict[str, dict[str, float]] = {}
    for shape, ours, theirs, scale in (((), "one", "scipy_one", 1e6),
                                       ((COUNT,), "each", "scipy_each", 1e9 / COUNT)):  # fmt: skip
        motors, grown = Motor.random(rng, shape), Similarity.random(rng, shape)
        for name, call in {**_rotors(motors.rotor), **_motors(motors), **_similar(grown)}.items():
            found.setdefault(name, {})[ours] = scale * _seconds(call)
        for name, call in _scipys(motors).items():
            found[name][theirs] = scale * _seconds(call)
    return found


def _rotors(r: Rotor) -> dict[str, Call]:
    q, v, m, e = r.as_quaternion(), r.as_rotation_vector(), r.as_matrix().copy(), r.as_euler()
    return {
        "Rotor.from_quaternion": lambda: Rotor.from_quaternion(q),
        "Rotor.as_quaternion": r.as_quaternion,
        "Rotor.from_rotation_vector": lambda: Rotor.from_rotation_vector(v),
        "Rotor.as_rotation_vector": r.as_rotation_vector,
        "Rotor.from_matrix": lambda: Rotor.from_matrix(m),
        "Rotor.as_matrix": r.as_matrix,
        "Rotor.from_euler": lambda: Rotor.from_euler(e, "xyz"),
        "Rotor.as_euler": lambda: r.as_euler("xyz"),
    }


def _motors(m: Motor) -> dict[str, Call]:
    r, t, matrix = m.rotor, m.translation_m, m.as_matrix().copy()
    q, dual, twist = r.as_quaternion(), m.as_dual_quaternion(), m.as_twist()
    return {
        "Motor.from_rotor_translation": lambda: Motor.from_rotor_translation(r, t),
        "Motor.rotor, Motor.translation_m": lambda: (m.rotor, m.translation_m),
        "Motor.from_matrix": lambda: Motor.from_matrix(matrix),
        "Motor.as_matrix": m.as_matrix,
        "Motor.from_quaternion_translation": lambda: Motor.from_quaternion_translation(q, t),
        "Motor.as_quaternion_translation": m.as_quaternion_translation,
        "Motor.from_dual_quaternion": lambda: Motor.from_dual_quaternion(dual),
        "Motor.as_dual_quaternion": m.as_dual_quaternion,
        "Motor.from_twist": lambda: Motor.from_twist(twist),
        "Motor.as_twist": m.as_twist,
    }


def _similar(s: Similarity) -> dict[str, Call]:
    r, t, scale = s.as_rotor_translation_scale()
    matrix, twist = s.as_matrix().copy(), s.as_twist()
    make = Similarity.from_rotor_translation_scale
    return {
        "Similarity.from_rotor_translation_scale": lambda: make(r, t, scale),
        "Similarity.as_rotor_translation_scale": s.as_rotor_translation_scale,
        "Similarity.from_matrix": lambda: Similarity.from_matrix(matrix),
        "Similarity.as_matrix": s.as_matrix,
        "Similarity.from_twist": lambda: Similarity.from_twist(twist),
        "Similarity.as_twist": s.as_twist,
    }


def _scipys(motors: Motor) -> dict[str, Call]:
    from scipy.spatial.transform import Rotation

    q = motors.rotor.as_quaternion()
    turns = Rotation.from_quat(q, scalar_first=True)
    v, m, e = turns.as_rotvec(), turns.as_matrix(), turns.as_euler("XYZ")
    return {
        "Rotor.from_quaternion": lambda: Rotation.from_quat(q, scalar_first=True),
        "Rotor.as_quaternion": lambda: turns.as_quat(scalar_first=True),
        "Rotor.from_rotation_vector": lambda: Rotation.from_rotvec(v),
        "Rotor.as_rotation_vector": turns.as_rotvec,
        "Rotor.from_matrix": lambda: Rotation.from_matrix(m),
        "Rotor.as_matrix": turns.as_matrix,
        "Rotor.from_euler": lambda: Rotation.from_euler("XYZ", e),
        "Rotor.as_euler": lambda: turns.as_euler("XYZ"),
    }


def _averages() -> dict[str, dict[str, float]]:
    """Nanoseconds a result of a tenth as many sets of four versors near one another."""
    rng = np.random.default_rng(2)
    sets = COUNT // 10
    found: dict[str, dict[str, float]] = {}
    for kind in (Rotor, Motor, Similarity):
        middle: Versor = kind.random(rng, (sets, 1))
        around = middle.retract(0.3 * rng.standard_normal((sets, 4, kind._log_size)))
        weights = rng.uniform(0.1, 1.0, (sets, 4))
        found[kind.__name__] = {
            "blend": 1e9 / sets * _seconds(partial(blend, around, weights)),
            "mean": 1e9 / sets * _seconds(partial(mean, around, weights)),
        }
    return found
