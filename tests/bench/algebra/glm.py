"""GLM's pose blends, compiled on the spot and timed in a process of their own.

The source beside this file is compiled with `-O3 -march=native` against the headers of libglm-dev,
so that GLM gets every instruction that this machine has.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from motorcade.ga.arrays import FloatArray

__all__ = ["GlmFigures", "compile_glm", "measure_glm"]

Scalar = Literal["float32", "float64"]
SOURCE = Path(__file__).with_name("glm_blend.cpp")
FLAGS = ("-O3", "-march=native", "-std=c++17")


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
    compiler = shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        raise NotMeasured("GLM: no C++ compiler here (apt-get install g++)")
    program = folder / "glm_blend"
    done = subprocess.run(
        [compiler, *FLAGS, str(SOURCE), "-o", str(program)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        missing = "glm/glm.hpp" in done.stderr
        reason = "no GLM headers (apt-get install libglm-dev)" if missing else "it does not compile"
        raise NotMeasured(f"GLM: {reason}")
    return program


def measure_glm(program: Path, poses: FloatArray, scalar: Scalar, seconds: float) -> GlmFigures:
    """Blend `poses` (N, 2, 7), two a joint as wxyz and metres, for about `seconds` a method."""
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
    found = json.loads(done.stdout)
    methods = ("slerp_mix", "nlerp_mix", "dual_quaternion")
    return GlmFigures(
        ns={name: found[name]["ns"] for name in methods},
        checksum={name: found[name]["checksum"] for name in methods},
        memory_floor_ns=found["memory_floor"]["ns"],
        gflops=found["gflops"],
    )
