"""Pose blends of others in C++, compiled on the spot and timed in a process of their own.

GLM's own, against the headers of libglm-dev, and quaternions in arrays of one component each, which
need nothing. Both get the flags of the kernels, every instruction that this machine has, and are
timed by the processor's clock.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from motorcade.ga.arrays import FloatArray

__all__ = ["GlmFigures", "compile_arrays", "compile_glm", "measure_arrays", "measure_glm"]

Scalar = Literal["float32", "float64"]
SOURCE = Path(__file__).with_name("glm_blend.cpp")
ARRAYS = Path(__file__).with_name("array_blend.cpp")
FLAGS = (
    "-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast",
    "-std=c++17",
)  # fmt: skip


class NotMeasured(RuntimeError):
    """A peer that cannot be measured here; the message says what is missing."""


@dataclass(frozen=True)
class GlmFigures:
    """Nanoseconds a joint and checksums a method, and the machine's floors for the same data."""

    ns: dict[str, float]
    checksum: dict[str, float]
    memory_floor_ns: float
    gflops: float


def compile_glm(folder: Path) -> Path:
    """Compile the program into `folder`; NotMeasured where compiler or headers are missing."""
    return _compile("GLM", SOURCE, folder)


def compile_arrays(folder: Path) -> Path:
    """The same for quaternions in arrays, which need a compiler alone."""
    return _compile("quaternions in arrays", ARRAYS, folder)


def _compile(peer: str, source: Path, folder: Path) -> Path:
    compiler = shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        raise NotMeasured(f"{peer}: no C++ compiler here (apt-get install g++)")
    program = folder / source.stem
    done = subprocess.run(
        [compiler, *FLAGS, str(source), "-o", str(program)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        missing = "glm/glm.hpp" in done.stderr
        reason = "no GLM headers (apt-get install libglm-dev)" if missing else "it does not compile"
        raise NotMeasured(f"{peer}: {reason}")
    return program


def measure_glm(program: Path, poses: FloatArray, scalar: Scalar, seconds: float) -> GlmFigures:
    """Blend `poses` (N, 2, 7), two a joint as wxyz and metres, for about `seconds` a method."""
    found = _measured(program, poses, scalar, seconds)
    methods = ("slerp_mix", "nlerp_mix", "dual_quaternion")
    return GlmFigures(
        ns={name: found[name]["ns"] for name in methods},
        checksum={name: found[name]["checksum"] for name in methods},
        memory_floor_ns=found["memory_floor"]["ns"],
        gflops=found["gflops"],
    )


def measure_arrays(
    program: Path, poses: FloatArray, scalar: Scalar, seconds: float
) -> dict[str, dict[str, float]]:
    """Nanoseconds a joint and checksum, `ns` and `checksum`, of each method in arrays."""
    return dict(_measured(program, poses, scalar, seconds))


def _measured(program: Path, poses: FloatArray, scalar: Scalar, seconds: float) -> dict[str, Any]:
    done = subprocess.run(
        [
            str(program),
            scalar.replace("float32", "float").replace("float64", "double"),
            str(len(poses)),
            str(seconds),
        ],
        input=poses.tobytes(),
        capture_output=True,
        check=True,
    )
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures
