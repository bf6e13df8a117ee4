"""`make bench SUITE=blend`: two poses a joint, blended, as 3x4 matrices; beside GLM on one core.

GLM keeps a pose after the other; quaternions written for arrays of one component each, as motors
are kept here, show what the layout does and what the motors do. All sides blend the same poses by
the same fraction, compiled with the same flags, and are timed in turns in one run, pinned to one
core, by the processor's clock; figures are medians. The rotations must agree: screw motion turns as
slerp does, the linear motor blend as normalised lerp (the translations differ, since quaternions
leave them to be mixed apart).
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from motorcade.ga import Motor, kernels
from motorcade.ga.arrays import FloatArray
from tests.bench.algebra.glm import (
    GlmFigures,
    NotMeasured,
    Scalar,
    compile_arrays,
    compile_glm,
    measure_arrays,
    measure_glm,
)
from tests.bench.algebra.peers import python_peers
from tests.bench.timing import on_one_core, seconds_a_call

__all__ = ["BlendRow", "bench_blend", "blend_table"]

SIZES = (54, 64, 1000, 100_000)
SCALARS: tuple[Scalar, ...] = ("float32", "float64")
FRACTION = 0.3
OURS = {"blend_matrix": "motor linear", "screw_blend_matrix": "motor screw"}
SAME_ROTATION = {"blend_matrix": "nlerp_mix", "screw_blend_matrix": "slerp_mix"}
ARRAYS = {
    "slerp_arrays": "quaternion slerp + mix in arrays",
    "nlerp_arrays": "quaternion nlerp + mix in arrays",
}
GLM = {
    "slerp_mix": "GLM slerp + mix",
    "nlerp_mix": "GLM nlerp + mix",
    "dual_quaternion": "GLM dual quaternion",
}


@dataclass(frozen=True)
class BlendRow:
    """One method at one size: nanoseconds a joint, and times as fast as GLM's two blends."""

    method: str
    scalar: str
    joints: int
    ns: float
    over_slerp_mix: float | None
    over_nlerp_mix: float | None


def bench_blend(seconds: float = 0.2, rounds: int = 3) -> dict[str, Any]:
    """Measure everything; `seconds` a method, size and round.

    Returns a JSON-ready tree: `rows` (see `BlendRow`), `floors` (memory in ns a joint over the
    same data, arithmetic in GFLOP/s), `python` (µs a call from Python), `left_out` (what could not
    be measured and why). Raises RuntimeError where two sides did not do the same work.
    """
    left_out: list[str] = []
    rows: list[BlendRow] = []
    floors: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder, on_one_core():
        programs: dict[Callable[[Path], Path], Path | None] = {}
        for compiled in (compile_glm, compile_arrays):
            try:
                programs[compiled] = compiled(Path(folder))
            except NotMeasured as missing:
                programs[compiled] = None
                left_out.append(str(missing))
        glm, arrays = programs[compile_glm], programs[compile_arrays]
        for scalar in SCALARS:
            for joints in SIZES:
                measured, floor = _one_size(glm, arrays, scalar, joints, seconds, rounds)
                rows += measured
                floors += floor
        peers = python_peers(FRACTION)
    return {
        "kernels": kernels.backend,
        "rows": [asdict(row) for row in rows],
        "floors": floors,
        "python": peers.microseconds,
        "left_out": [*left_out, *peers.left_out],
    }


def _one_size(
    program: Path | None,
    arrays: Path | None,
    scalar: Scalar,
    joints: int,
    seconds: float,
    rounds: int,
) -> tuple[list[BlendRow], list[dict[str, Any]]]:
    poses = random_poses(joints)
    ours: dict[str, list[float]] = {name: [] for name in OURS}
    theirs: list[GlmFigures] = []
    in_arrays: dict[str, list[float]] = {name: [] for name in ARRAYS if arrays}
    for _ in range(rounds):
        if arrays is not None:
            for name, figures in measure_arrays(arrays, poses, scalar, seconds).items():
                in_arrays[name].append(figures["ns"])
        if program is not None:
            theirs.append(measure_glm(program, poses, scalar, seconds))
        for name in OURS:
            spent, checksum = _ours(name, poses, scalar, seconds)
            ours[name].append(spent)
            if theirs:
                _check_same(name, checksum, theirs[-1].checksum[SAME_ROTATION[name]], scalar)
    found = {OURS[name]: median(times) for name, times in ours.items()}
    glm = {name: median(one.ns[name] for one in theirs) for name in GLM} if theirs else {}
    found |= {ARRAYS[name]: median(times) for name, times in in_arrays.items()}
    found |= {GLM[name]: ns for name, ns in glm.items()}
    rows = [
        BlendRow(
            method,
            scalar,
            joints,
            ns,
            glm["slerp_mix"] / ns if glm else None,
            glm["nlerp_mix"] / ns if glm else None,
        )
        for method, ns in found.items()
    ]
    floor = (
        {
            "scalar": scalar,
            "joints": joints,
            "memory_ns": median(one.memory_floor_ns for one in theirs),
            "gflops": median(one.gflops for one in theirs),
        }
        if theirs
        else None
    )
    return rows, [floor] if floor else []


def random_poses(joints: int) -> FloatArray:
    """Two poses a joint, (N, 2, 7) as wxyz and metres, the same for every method and run."""
    motors = Motor.random(np.random.default_rng(joints), (joints, 2))
    return np.concatenate(motors.as_quaternion_translation(), axis=-1)


def _ours(name: str, poses: FloatArray, scalar: Scalar, seconds: float) -> tuple[float, float]:
    """Nanoseconds a joint, and the checksum of the rotations."""
    motors = Motor.from_quaternion_translation(poses[..., :4], poses[..., 4:]).coefficients
    first, second = kernels.Block(8, len(poses), scalar), kernels.Block(8, len(poses), scalar)
    first.array[:], second.array[:] = motors[:, 0], motors[:, 1]
    out = kernels.Block(12, len(poses), scalar)
    spent = seconds_a_call(name, seconds, first, second, FRACTION, out)
    weight = np.arange(1.0, 13.0) * (np.arange(12) % 4 != 3)
    return 1e9 * spent / len(poses), float(np.sum(out.array.astype(np.float64) @ weight))


def _check_same(name: str, ours: float, theirs: float, scalar: Scalar) -> None:
    tolerance = 1e-4 if scalar == "float32" else 1e-9
    if abs(ours - theirs) > tolerance * max(1.0, abs(theirs)):
        raise RuntimeError(
            f"bench blend: {OURS[name]} and {GLM[SAME_ROTATION[name]]} give other rotations: "
            f"checksums {ours!r} and {theirs!r}"
        )


def blend_table(found: Mapping[str, Any]) -> str:
    """Nanoseconds a joint, a row a method and precision; floors, Python calls, what is missing."""
    sizes = "".join(f"{size:>10}" for size in SIZES)
    lines = [f"{'ns a joint, one core, to 3x4 matrices':<38}{sizes}"]
    for scalar in ("float32", "float64"):
        methods = dict.fromkeys(row["method"] for row in found["rows"])
        for method in methods:
            ns = {
                row["joints"]: row["ns"]
                for row in found["rows"]
                if (row["method"], row["scalar"]) == (method, scalar)
            }
            cells = "".join(f"{ns[size]:>10.2f}" for size in SIZES)
            lines.append(f"{method + ', ' + scalar:<38}{cells}")
        floors = {row["joints"]: row for row in found["floors"] if row["scalar"] == scalar}
        if floors:
            cells = "".join(f"{floors[size]['memory_ns']:>10.2f}" for size in SIZES)
            lines.append(f"{'memory floor, ' + scalar:<38}{cells}")
            gflops = max(row["gflops"] for row in floors.values())
            lines.append(f"{'arithmetic, ' + scalar:<38}{gflops:>10.0f} GFLOP/s")
    lines += ["", "times as fast as GLM (the linear blend: nlerp + mix; the screw: slerp + mix)"]
    rivals = {"motor linear": "over_nlerp_mix", "motor screw": "over_slerp_mix"}
    for row in found["rows"]:
        factor = row.get(rivals.get(row["method"], ""))
        if factor is not None:
            name = f"{row['method']}, {row['scalar']}, {row['joints']} joints"
            lines.append(f"{name:<38}{factor:>10.2f}")
    lines += ["", "called from Python, 54 joints where no other number stands: µs a call"]
    lines += [f"{name:<38}{us:>10.2f}" for name, us in found["python"].items()]
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)
