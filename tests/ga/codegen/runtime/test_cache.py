"""Compiled programs are kept, found again, and used only where they are what they say."""

import logging
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import compile as compile_program
from motorcade.ga.codegen.runtime import evaluator
from motorcade.ga.codegen.runtime.evaluator import CompileError, Compiler, find_compiler

SCRIPT = "?a = x*y*e1 + sin(x)*e2;"
RUN = f"""
import numpy as np
from motorcade.ga import compile
f = compile({SCRIPT!r})
x = np.linspace(0, 1, 100)
print(float(f.arrays(x, 2 * x)["a"].sum()), f.backend())
"""


def ran() -> str:
    function = compile_program(SCRIPT)
    x = np.linspace(0, 1, 100)
    made = function.arrays(x, 2 * x)["a"]
    np.testing.assert_allclose(made, np.stack([2 * x * x, np.sin(x)], axis=-1), atol=1e-15)
    return function.backend()


def test_a_library_is_compiled_once(compiled: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert ran() == "c"
    (kept,) = compiled.glob("*.so")
    assert compiled.stat().st_mode & 0o777 == 0o700
    assert kept.stat().st_mode & 0o777 == 0o500

    def refuse(*given: object) -> bytes:
        raise AssertionError("compiled again")

    monkeypatch.setattr(Compiler, "library", refuse)
    assert ran() == "c"
    assert [path.name for path in compiled.iterdir()] == [kept.name]


@pytest.mark.parametrize("fault", ["cut off", "changed", "empty", "a link", "others may write"])
def test_a_changed_library_is_compiled_again(fault: str, compiled: Path, tmp_path: Path) -> None:
    assert ran() == "c"
    (kept,) = compiled.glob("*.so")
    data = kept.read_bytes()
    kept.chmod(0o700)
    if fault == "a link":
        (tmp_path / "elsewhere.so").write_bytes(data)
        kept.unlink()
        kept.symlink_to(tmp_path / "elsewhere.so")
    elif fault == "others may write":
        kept.chmod(0o722)
    else:
        kept.unlink()  # the process goes on with what it has loaded
        middle = len(data) // 2
        changed = data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]
        kept.write_bytes({"cut off": data[:middle], "changed": changed, "empty": b""}[fault])
    assert ran() == "c"
    (again,) = compiled.glob("*.so")
    assert not again.is_symlink()
    assert again.stat().st_mode & 0o777 == 0o500
    assert evaluator._is_whole(again)


def test_a_folder_that_others_may_write_into_is_not_used(
    compiled: Path, caplog: pytest.LogCaptureFixture
) -> None:
    compiled.mkdir()
    compiled.chmod(0o777)
    with caplog.at_level(logging.WARNING):
        assert ran() == "c"
    assert "expected a folder that others may not write into" in caplog.text
    assert list(compiled.iterdir()) == []


def test_a_file_in_the_folders_place_is_no_obstacle(compiled: Path) -> None:
    compiled.write_text("")
    assert ran() == "c"


def test_the_oldest_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluator, "MOST_BYTES", 250)
    kept = [evaluator.keep_library(tmp_path, f"key{k}", bytes([k]) * 100) for k in range(2)]
    for age, path in enumerate(kept):
        os.utime(path, ns=(0, 10**9 * (10 - age)))
    assert evaluator.cached_library(tmp_path, "key1") == kept[1], "what is used is young again"
    newest = evaluator.keep_library(tmp_path, "key2", b"z" * 100)
    assert sorted(tmp_path.iterdir()) == sorted([kept[1], newest])


def test_without_a_compiler_it_runs_as_numpy(
    folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompileError, match="no C compiler here: looked for cc, gcc, clang"):
        find_compiler(0)
    assert ran().startswith("numpy: ")


def test_a_compiler_that_fails_leaves_numpy(
    compiled: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "cc -fno-such-option-here")
    said = ran()
    assert said.startswith("numpy: ")
    assert "ended with 1" in said
    assert list(compiled.glob("*")) == []


def test_it_can_be_turned_off(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTORCADE_PROGRAMS", "numpy")
    assert ran() == "numpy: MOTORCADE_PROGRAMS says so"
    assert not folder.exists()
    monkeypatch.setenv("MOTORCADE_PROGRAMS", "fortran")
    with pytest.raises(ValueError, match="MOTORCADE_PROGRAMS: expected 'numpy', 'wait' or nothing"):
        ran()


def test_calls_go_on_while_it_is_compiled(compiled: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTORCADE_PROGRAMS", "")
    assert ran() == "numpy: being compiled"
    function = compile_program(SCRIPT)
    assert function.wait()
    assert function.backend() == "c"
    assert function.backend("float32") == "numpy: not called yet"
    with pytest.raises(ValueError, match="precision: expected float32 or float64, got 'half'"):
        function.wait("half")


def test_long_programs_stay_with_numpy(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluator, "LONGEST_COMPILED", 1)
    if evaluator._trampoline() is None:
        pytest.skip("installed without compiled code")
    assert ran() == "numpy: more than 1 operations"


def test_processes_may_compile_at_once(compiled: Path) -> None:
    running = [
        subprocess.Popen([sys.executable, "-c", RUN], stdout=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    told = {process.communicate(timeout=120)[0] for process in running}
    assert len(told) == 1
    assert told.pop().endswith(" c\n")
    assert len(list(compiled.iterdir())) == 1
