"""The compiled modules under AddressSanitizer and UBSan: builds them so, and runs their tests.

    python -m tests.sanitized                             all tests of compiled code
    python -m tests.sanitized tests/fusion/filter -x      those named, and options of pytest

A wrong index, a read before it was written to or an overflow ends the run with a message that shows
the line. The build lies in build/sanitized; the environment's own modules are left as they are.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
BUILD = REPOSITORY / "build/sanitized"
MODULES = {
    "motorcade.ga.codegen.runtime._trampoline",
    "motorcade.ga.kernels._compiled",
    "motorcade.fusion.smoothing.native._columns",
    "motorcade.fusion.smoothing.native._robust_map",
    "motorcade.fusion.smoothing.native._scans",
    "motorcade.fusion.smoothing.native._live",
    "motorcade.fusion.orientation.native._orientation",
    "motorcade.fusion.filter.native._filter",
    "motorcade.animation.native._ik",
    "motorcade.animation.native._runtime",
    "motorcade.tracking.markers.native._quads",
    "motorcade.tracking.native._flow",
    "motorcade.tracking.native._least_squares",
}
TESTS = (
    "tests/ga/codegen/runtime/test_programs_that_run.py",
    "tests/ga/kernels/test_kernels.py",
    "tests/ga/kernels/test_odd_layouts.py",
    "tests/fusion/smoothing/test_native_verbs.py",
    "tests/fusion/smoothing/test_causal.py",
    "tests/fusion/smoothing/test_kalman.py",
    "tests/fusion/smoothing/test_live.py",
    "tests/fusion/smoothing/test_columns.py",
    "tests/fusion/smoothing/test_inliers.py",
    "tests/fusion/smoothing/test_robust_map.py",
    "tests/fusion/orientation/test_orientation.py",
    "tests/fusion/filter/test_filter.py",
    "tests/fusion/filter/test_pose_filter.py",
    "tests/animation/ik/test_fabrik.py",
    "tests/animation/ik/test_solver.py",
    "tests/animation/test_runtime.py",
    "tests/animation/skin",
    "tests/tracking/markers/test_detection.py",
    "tests/tracking/optimise",
    "tests/tracking/test_images.py",
    # Thousands of samples for the accuracy, and an hour of them, on paths that the others take.
    "--deselect=tests/ga/kernels/test_kernels.py::test_backends_agree_on_hard_motors",
    "--deselect=tests/fusion/orientation/test_orientation.py::test_it_stays_sound_over_an_hour",
)


class SanitizedModules(MetaPathFinder):
    """Finds the compiled modules in the build, before the environment's own are looked for."""

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        """See `MetaPathFinder`."""
        if fullname not in MODULES:
            return None
        (built,) = BUILD.glob(f"{fullname.rpartition('.')[2]}.*.so")
        return importlib.util.spec_from_file_location(fullname, built)


def build() -> None:
    """Compile all modules with CMake's build type Sanitize; what is up to date stays."""
    options = ["--no-build-isolation", "--no-deps", "--quiet", f"--wheel-dir={BUILD / 'wheel'}"]
    settings = ["-C", "cmake.build-type=Sanitize", "-C", f"build-dir={BUILD}"]
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", *options, *settings, str(REPOSITORY)], check=True
    )


def run_tests(arguments: list[str]) -> int:
    """Run pytest on the built modules; meant for a process that has loaded the sanitizers."""
    sys.meta_path.insert(0, SanitizedModules())
    status = pytest.main(["-q", "-p", "no:cacheprovider", "-m", "not slow", *arguments])
    print(f"{len(sys.modules.keys() & MODULES)} of {len(MODULES)} compiled modules were loaded")
    return int(status)


def main(arguments: list[str]) -> int:
    """Build, then run the tests in a process of their own; returns its exit status."""
    if not sys.platform.startswith("linux") or shutil.which("gcc") is None:
        print("sanitize: needs gcc on Linux", file=sys.stderr)
        return 1
    build()
    libraries = [
        subprocess.run(
            ["gcc", f"-print-file-name={name}"], check=True, capture_output=True, text=True
        ).stdout.strip()
        for name in ("libasan.so", "libubsan.so")
    ]
    # Leaks are not looked for: Python itself keeps what it has until the end.
    environment = {"LD_PRELOAD": " ".join(libraries), "ASAN_OPTIONS": "detect_leaks=0"}
    code = "import sys; from tests.sanitized import run_tests; sys.exit(run_tests(sys.argv[1:]))"
    command = [sys.executable, "-c", code, *(arguments or TESTS)]
    return subprocess.run(
        command, cwd=REPOSITORY, env=os.environ | environment, check=False
    ).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
