"""Compiled programs of a test lie in a folder of its own, and calls wait for them."""

import shutil
from pathlib import Path

import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of compiled programs; the first call of each waits for its C."""
    made = tmp_path / "programs"
    monkeypatch.setenv("MOTORCADE_PROGRAM_CACHE", str(made))
    monkeypatch.setenv("MOTORCADE_PROGRAMS", "wait")
    return made


@pytest.fixture
def compiled(folder: Path) -> Path:
    """The same, where the machine can compile."""
    pytest.importorskip(
        "motorcade.ga.codegen.runtime._trampoline", reason="installed without compiled code"
    )
    if COMPILER is None:
        pytest.skip("no C compiler here")
    return folder
