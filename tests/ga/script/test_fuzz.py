"""A slice of `fuzz`: whatever the text, a ScriptError or finite values."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


def fuzz() -> ModuleType:
    """The command's module, which lies beside the tests."""
    found = importlib.util.spec_from_file_location("fuzz", Path(__file__).with_name("fuzz.py"))
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules["fuzz"] = module
    found.loader.exec_module(module)
    return module


@pytest.mark.parametrize("seed", [2, 3])
def test_only_script_errors_come_out_of_random_scripts(seed: int) -> None:
    pytest.importorskip("casadi")
    counts = fuzz().run(350, seed)
    assert counts.faults == []
    assert sum(counts.results.values()) > 20
    assert sum(counts.errors.values()) > 100


@pytest.mark.parametrize("kind", ["bytes", "tokens", "examples", "grammar", "nesting", "huge"])
def test_every_kind_of_input_is_made(kind: str) -> None:
    import numpy as np

    module = fuzz()
    texts = {module.MAKERS[kind][1](np.random.default_rng(seed)) for seed in range(20)}
    assert len(texts) > 5
    assert set(module.MAKERS) == {"bytes", "tokens", "examples", "grammar", "nesting", "huge"}


def test_a_fault_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    module = fuzz()

    def broken(text: str) -> None:
        raise RecursionError("deep")

    monkeypatch.setattr(module, "parse", broken)
    counts = module.run(5, 1)
    assert [fault for _, fault, _ in counts.faults] == ["RecursionError: deep"] * 5
