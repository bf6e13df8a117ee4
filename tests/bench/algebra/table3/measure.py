"""`make bench SUITE=table3`: whole poses of three characters blended by every method, to matrices.

All methods blend the same poses in one process on one core, in turns, and each is checked against
scipy before it is timed. Figures are medians over the rounds, with quartiles. Beside the paper's
table stands what a compiler gives for joints in arrays, one a component, with GLM in the same run.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, kernels
from motorcade.ga.arrays import FloatArray
from tests.bench.algebra.blend import SCALARS
from tests.bench.algebra.glm import NotMeasured, compile_glm, measure_glm
from tests.bench.algebra.table3.characters import (
    BlendedCharacter,
    characters,
    random_character,
)
from tests.bench.algebra.table3.methods import (
    ARRAY_METHODS,
    METHODS,
    Blends,
    Method,
    compile_blends,
)
from tests.bench.algebra.table3.reference import blended_matrices
from tests.bench.algebra.table3.report import table3_table, verdict
from tests.bench.data import data_folder
from tests.bench.timing import on_one_core, seconds_a_call

__all__ = ["ARRAY_JOINTS", "GLM_LABELS", "KERNEL_LABEL", "Row", "bench_table3", "table3_table"]

FRACTION = 0.3
ARRAY_JOINTS = 54
TOLERANCE = {"float32": 2e-5, "float64": 1e-11}
# The fastest methods in rows, an array of joints as GLM takes it.
BESIDE_ARRAYS = [m for m in METHODS if m.name in ("dual_quaternion", "motor_linear_program")]
GLM_LABELS = {
    "slerp_mix": "GLM slerp + mix",
    "nlerp_mix": "GLM nlerp + mix",
    "dual_quaternion": "GLM dual quaternion",
}
KERNEL_LABEL = "the library's linear blend, arrays"
# GLM's program measures its three methods, and the machine, in one go.
GLM_SHARE = 5.0

# Runs something for about so many seconds; nanoseconds a joint.
Timed = Callable[[float], float]


@dataclass(frozen=True)
class Row:
    """One method on one character: milliseconds a pose and nanoseconds a joint."""

    method: str
    scalar: str
    character: str
    joints: int
    ms_a_character: float
    ns_a_joint: float
    ns_a_joint_lower_quartile: float
    ns_a_joint_upper_quartile: float


def bench_table3(seconds: float = 0.002, rounds: int = 41) -> dict[str, Any]:
    """Measure everything; `seconds` a method, character and round.

    Returns a JSON-ready tree: `rows` of the three characters and `array_rows` of 54 joints (see
    `Row`), `characters`, the `verdict` on the paper's table, `left_out` (what could not be
    measured and why). Raises RuntimeError where a method does not give the matrices of its
    reference.
    """
    shown = characters(data_folder())
    crowd = random_character(ARRAY_JOINTS)
    found: dict[str, Any] = {
        "rows": [],
        "array_rows": [],
        "left_out": [],
        "characters": [
            {"character": one.name, "joints": one.joints, "poses": one.source} for one in shown
        ],
    }
    with tempfile.TemporaryDirectory() as folder, on_one_core():
        glm = _glm(Path(folder), found["left_out"])
        for scalar in SCALARS:
            try:
                blends = compile_blends(Path(folder), scalar, (*METHODS, *ARRAY_METHODS))
            except NotMeasured as missing:
                found["left_out"].append(str(missing))
                break
            timed = [(m, one, timer(blends, m, one)) for one in shown for m in METHODS]
            found["rows"] += _rows(blends, timed, seconds, rounds)
            found["array_rows"] += _array_rows(blends, glm, crowd, seconds, rounds)
    found["verdict"] = verdict(found["rows"]) if found["rows"] else "Nothing was measured."
    return found


def _rows(
    blends: Blends,
    timed: Sequence[tuple[Method | str, BlendedCharacter, Timed]],
    seconds: float,
    rounds: int,
) -> list[dict[str, Any]]:
    """Time all in turns."""
    ns = np.array([[run(seconds) for _, _, run in timed] for _ in range(rounds)])
    lower, middle, upper = np.quantile(ns, (0.25, 0.5, 0.75), axis=0).tolist()
    made = [
        Row(
            method if isinstance(method, str) else method.label,
            blends.scalar,
            one.name,
            one.joints,
            1e-6 * middle[k] * one.joints,
            middle[k],
            lower[k],
            upper[k],
        )
        for k, (method, one, _) in enumerate(timed)
    ]
    return [asdict(row) for row in made]


def timer(blends: Blends, method: Method, one: BlendedCharacter) -> Timed:
    """What times a method, once its result is that of the reference."""
    call = blends.call(method, one.first, one.second, FRACTION)
    call.seconds(1)
    expected = blended_matrices(method.path, one.first, one.second, FRACTION)
    _check(f"{method.label}, {blends.scalar}", call.matrices(), expected, blends.scalar)
    once = min(call.seconds(1) for _ in range(3))

    def run(seconds: float) -> float:
        times = max(1, round(seconds / max(once, 1e-9)))
        return 1e9 * call.seconds(times) / times / one.joints

    return run


def _array_rows(
    blends: Blends, glm: Path | None, crowd: BlendedCharacter, seconds: float, rounds: int
) -> list[dict[str, Any]]:
    """Joints in arrays, one a component, beside joints in rows, GLM and the library's kernel."""
    timed: list[tuple[Method | str, BlendedCharacter, Timed]] = [
        (method, crowd, timer(blends, method, crowd)) for method in (*BESIDE_ARRAYS, *ARRAY_METHODS)
    ]
    timed.append((KERNEL_LABEL, crowd, _kernel(blends, crowd)))
    if glm is not None:
        timed += [(label, crowd, run) for label, run in _glm_timers(blends, glm, crowd)]
    return _rows(blends, timed, seconds, rounds)


def _kernel(blends: Blends, crowd: BlendedCharacter) -> Timed:
    """The library's kernel of the linear blend."""
    first, second = (_block(poses, blends) for poses in (crowd.first, crowd.second))
    out = kernels.Block(12, crowd.joints, blends.scalar)
    kernels.function("blend_matrix")(first, second, FRACTION, out)
    expected = blended_matrices("linear", crowd.first, crowd.second, FRACTION)
    _check(KERNEL_LABEL, np.asarray(out.array).reshape(-1, 3, 4), expected, blends.scalar)

    def run(seconds: float) -> float:
        spent = seconds_a_call("blend_matrix", seconds, first, second, FRACTION, out)
        return 1e9 * spent / crowd.joints

    return run


def _block(poses: Motor, blends: Blends) -> Any:
    block = kernels.Block(8, len(poses.coefficients), blends.scalar)
    block.array[:] = poses.coefficients
    return block


def _glm(folder: Path, left_out: list[str]) -> Path | None:
    try:
        return compile_glm(folder)
    except NotMeasured as missing:
        left_out.append(str(missing))
        return None


def _glm_timers(blends: Blends, glm: Path, crowd: BlendedCharacter) -> list[tuple[str, Timed]]:
    """GLM's methods; the program is run by the first of them, and tells the figures of all."""
    poses = np.stack(
        [
            np.concatenate(p.as_quaternion_translation(), axis=-1)
            for p in (crowd.first, crowd.second)
        ],
        axis=1,
    )
    turned = blended_matrices("slerp", crowd.first, crowd.second, FRACTION)[..., :3]
    weights = 4.0 * np.arange(3)[:, None] + np.arange(3) + 1.0
    expected = float(np.sum(turned * weights))
    told: dict[str, float] = {}

    def run(name: str, seconds: float) -> float:
        if name == "slerp_mix":
            found = measure_glm(glm, poses, blends.scalar, GLM_SHARE * seconds)
            off = np.array(found.checksum["slerp_mix"] - expected) / (np.sum(weights) * len(poses))
            _check("GLM slerp + mix", off, np.zeros(()), blends.scalar)
            told.update(found.ns)
        return told[name]

    return [(label, partial(run, name)) for name, label in GLM_LABELS.items()]


def _check(name: str, made: FloatArray, expected: FloatArray, scalar: str) -> None:
    """Refuse a result that is not the reference's; translations may be tens of units long."""
    error = float(np.max(np.abs(made - expected)))
    if not error <= TOLERANCE[scalar] * max(1.0, float(np.max(np.abs(expected)))):
        raise RuntimeError(
            f"bench table3: {name}: expected the matrices of scipy, got some {error:.3g} away"
        )
