"""The committed kernels are what the definitions say today."""

from pathlib import Path

import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")
pytest.importorskip("mpmath", reason="mpmath, which only the generator needs, is not installed")

from motorcade.ga.codegen import __main__ as library
from motorcade.ga.codegen.__main__ import (
    GENERATED,
    library_files,
    write_library,
    written_files,
)


def test_generated_files_are_current() -> None:
    advice = "run `python -m motorcade.ga.codegen`"
    committed = {
        path.relative_to(GENERATED).as_posix(): path.read_text(encoding="utf-8")
        for path in written_files(GENERATED)
    }
    files = library_files()
    assert set(committed) == set(files), advice
    for name, text in files.items():
        assert committed[name] == text, f"{name} is not what the definitions say; {advice}"


def test_files_of_kernels_that_are_gone_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(library, "library_files", lambda: {"c/table.c": "int one;\n"})
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "gone.c").write_text("")
    write_library(tmp_path)
    assert not (tmp_path / "c" / "gone.c").exists()
    assert (tmp_path / "c" / "table.c").exists()
