"""The compiled kernels and their binding run clean under AddressSanitizer and UBSan."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from motorcade.ga.codegen.library_kernels.library import GENERATED

SOURCES = GENERATED.parent / "native"
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1", "-fPIC"]

# Every kernel on every layout, with buffers that end where the data ends.
PROGRAM = """
import importlib.util, json, sys
spec = importlib.util.spec_from_file_location("_compiled", sys.argv[1])
compiled = importlib.util.module_from_spec(spec)
spec.loader.exec_module(compiled)
import numpy as np
rng = np.random.default_rng(0)
kernels = json.loads(sys.argv[2])
for dtype in ("float32", "float64"):
    for name, (_, widths, width) in kernels.items():
        kernel = getattr(compiled, name)
        for count in (0, 1, 5, 16, 54, 333, 70000):
            inputs = [rng.uniform(0.1, 1, (count, w) if w > 1 else count).astype(dtype)
                      for w in widths]
            out = np.zeros((count, width), dtype)
            kernel(*inputs, out)
            kernel(*map(np.asfortranarray, inputs), np.asfortranarray(out))
            kernel(*(x[::-1] for x in inputs), out[::-1])
            kernel(*(x[:1] if w > 1 else 0.5 for x, w in zip(inputs, widths)), out) if count else 0
            blocks = [compiled.Block(w, count, dtype) for w in (*widths, width)]
            kernel(*blocks)
            compiled.set_threads(2)
            kernel(*inputs, out)
        try:
            kernel(*inputs)
        except TypeError:
            pass
print("clean")
"""


def runtime(compiler: str, library: str) -> str:
    asked = [compiler, f"-print-file-name={library}"]
    return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()


@pytest.mark.slow
def test_kernels_run_clean_under_sanitizers(tmp_path: Path) -> None:
    nanobind = pytest.importorskip(
        "nanobind", reason="nanobind, which builds the kernels, is absent"
    )
    gcc, gxx = shutil.which("gcc"), shutil.which("g++")
    if gcc is None or gxx is None or not sys.platform.startswith("linux"):
        pytest.skip("needs gcc on Linux")
    objects = [build_c(gcc, path, tmp_path) for path in sorted(GENERATED.glob("c/*.c"))]
    module = tmp_path / "_compiled.so"
    include = Path(nanobind.include_dir())
    subprocess.run(
        [
            gxx,
            *SANITIZE,
            "-std=c++17",
            "-shared",
            "-fvisibility=hidden",
            "-fno-strict-aliasing",
            f"-I{SOURCES}",
            f"-I{include}",
            f"-I{sysconfig.get_path('include')}",
            f"-I{include.parent / 'ext' / 'robin_map' / 'include'}",
            str(SOURCES / "module.cpp"),
            str(SOURCES / "dispatch.cpp"),
            str(include.parent / "src" / "nb_combined.cpp"),
            *map(str, objects),
            "-lpthread",
            "-o",
            str(module),
        ],
        check=True,
    )
    from motorcade.ga.kernels.generated.python import KERNELS

    preload = " ".join(runtime(gcc, name) for name in ("libasan.so", "libubsan.so"))
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(module), json.dumps(KERNELS)],
        env={**os.environ, "LD_PRELOAD": preload, "ASAN_OPTIONS": "detect_leaks=0"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-4000:]
    assert done.stdout.strip() == "clean"


def build_c(gcc: str, path: Path, folder: Path) -> Path:
    made = folder / f"{path.stem}.o"
    flags = ["-std=c11", *SANITIZE, "-fno-math-errno", f"-I{SOURCES}"]
    subprocess.run([gcc, *flags, "-c", str(path), "-o", str(made)], check=True)
    return made
