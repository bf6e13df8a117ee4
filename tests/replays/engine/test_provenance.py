"""A cache key must change with any code that a result can depend on, and with nothing else."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from motorcade.ga import Motor, Trajectory, mean
from motorcade.replays.engine import store
from motorcade.replays.engine.store import Reach, code_digest, reach, types_within
from motorcade.replays.pipeline.report.page import report
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.view.overlay import overlay
from tests.replays.engine.key_sizes import recording_of_a_board

PACKAGE = "motorcade.made_for_a_test"
SOURCES = {
    "__init__.py": '"""Ours."""\n',
    "eager/__init__.py": (
        f"from {PACKAGE}.eager.one import One as First\nfrom {PACKAGE}.eager.two import Two\n"
    ),
    "eager/one.py": "import json\n\nclass One: ...\n",
    "eager/two.py": "import numpy\n\nclass Two: ...\n",
    "eager/beside.py": "import yaml\n",
    "lazy/__init__.py": (
        "import lazy_loader\n"
        "__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)\n"
    ),
    "lazy/__init__.pyi": "from .near import First as First\nfrom .far import far as far\n",
    "lazy/near.py": f"from {PACKAGE}.eager import First\n",
    "lazy/far.py": "def far(): ...\n",
    "own/__init__.py": f"from {PACKAGE}.eager.two import Two\n\nLIMIT = 3\n",
    "through/__init__.py": f"from {PACKAGE}.own import *\n",
    "named.py": f"from {PACKAGE}.eager import First\n",
    "lazily.py": f"def work():\n    from {PACKAGE}.lazy import First\n    return First\n",
    "submodule.py": f"from {PACKAGE}.eager import beside\n",
    "limited.py": f"from {PACKAGE}.own import LIMIT\n",
    "starred.py": f"from {PACKAGE}.through import Two\n",
    "whole.py": f"import {PACKAGE}.eager\n",
    "whole_lazy.py": f"import {PACKAGE}.lazy\n",
    "relative.py": "from .eager import Two\n",
    "typed.py": (
        "from typing import TYPE_CHECKING\n"
        f"if TYPE_CHECKING:\n    from {PACKAGE}.eager import First\n"
        f"else:\n    from {PACKAGE}.lazy import far\n"
    ),
    "template.py": (
        "from importlib import import_module\n\n\ndef any_of(name):\n"
        f'    return import_module(f"{PACKAGE}.eager.{{name}}")\n'
    ),
}


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A small package of ours, found by name but never imported through its face."""
    import motorcade

    folder = tmp_path / "made_for_a_test"
    for name, source in SOURCES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(source)
    monkeypatch.setattr(motorcade, "__path__", [*motorcade.__path__, str(tmp_path)])
    forget()
    yield folder
    forget()
    for name in [one for one in sys.modules if one.startswith(PACKAGE)]:
        del sys.modules[name]


def forget() -> None:
    cached = ("reach", "_uses", "_trees", "_definers", "_find")
    for name in cached:
        getattr(store, name).cache_clear()


def followed(name: str) -> set[str]:
    """Modules of the small package under the key of one of them, without the package's name."""
    found = reach(f"{PACKAGE}.{name}").modules
    return {one.removeprefix(f"{PACKAGE}.") for one in found} - {name}


@pytest.mark.parametrize(
    ("name", "used"),
    [
        ("named", {"eager.one"}),
        ("lazily", {"lazy.near", "eager.one"}),
        ("submodule", {"eager.beside"}),
        ("limited", {"own", "eager.two"}),
        ("starred", {"own", "eager.two"}),
        ("whole", {"eager", "eager.one", "eager.two"}),
        ("whole_lazy", {"lazy", "lazy.far", "lazy.near", "eager.one"}),
        ("relative", {"eager.two"}),
        ("typed", {"lazy.far"}),
        ("template", {"eager.one", "eager.two", "eager.beside"}),
    ],
)
def test_names_are_followed_to_where_they_are_defined(
    made: Path, name: str, used: set[str]
) -> None:
    assert followed(name) == used


def test_packages_on_the_way_count_with_their_own_source_alone(made: Path) -> None:
    found = reach(f"{PACKAGE}.lazily")
    assert found.faces == {"motorcade", PACKAGE, f"{PACKAGE}.lazy", f"{PACKAGE}.eager"}
    assert found.foreign == frozenset()  # neither lazy_loader, nor numpy of what else is listed
    assert reach(f"{PACKAGE}.submodule").foreign == {"yaml"}


def of_module(name: str) -> object:
    def function() -> None: ...

    function.__module__ = f"{PACKAGE}.{name}"
    return function


@pytest.mark.parametrize(
    ("edited", "changes"),
    [
        ("eager/one.py", True),
        ("eager/__init__.py", True),
        ("__init__.py", True),
        ("eager/two.py", False),
        ("lazy/far.py", False),
    ],
)
def test_a_key_changes_with_what_is_used_and_with_nothing_beside_it(
    made: Path, edited: str, changes: bool
) -> None:
    function = of_module("lazily")
    before = code_digest(function)  # type: ignore[arg-type]
    assert code_digest(function) == before  # type: ignore[arg-type]
    (made / edited).write_text(SOURCES[edited] + "\nMORE = 1\n")
    forget()
    assert (code_digest(function) != before) is changes  # type: ignore[arg-type]


def reached(function: object) -> Reach:
    return reach(function.__module__)  # type: ignore[attr-defined]


def test_imports_are_followed_through_packages_and_functions() -> None:
    found = reached(smoothed)
    assert "motorcade.fusion.smoothing.window" in found.modules
    assert "motorcade.ga.kernels.batches" in found.modules
    assert "motorcade.ga.kernels.generated.python.products" in found.modules
    assert {"numpy", "scipy"} <= found.foreign


def test_rooms_that_a_stage_does_not_use_are_left_out() -> None:
    assert not any(name.startswith("motorcade.render") for name in reached(smoothed).modules)
    found = reached(overlay)
    assert "motorcade.render.backends.pyrender_backend" in found.modules
    assert {"pyrender", "av", "cv2"} <= found.foreign


def test_the_digest_changes_with_the_bytes_of_compiled_modules(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    compiled = "motorcade.ga.kernels._compiled"
    if store._find(compiled) is None:
        pytest.skip("the kernels are not compiled here")
    before = code_digest(smoothed)
    origin = store._origin

    def rebuilt(name: str) -> Path:
        if name != compiled:
            return origin(name)
        copy = tmp_path / origin(name).name
        copy.write_bytes(origin(name).read_bytes() + b"\0")
        return copy

    monkeypatch.setattr(store, "_origin", rebuilt)
    assert code_digest(smoothed) != before


def test_the_digest_changes_with_versions(monkeypatch: pytest.MonkeyPatch) -> None:
    before = code_digest(smoothed)
    monkeypatch.setattr(store, "_version", lambda package: "another")
    assert code_digest(smoothed) != before


def test_the_digest_changes_with_templates_and_shaders_beside_the_modules(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Path] = []
    texts = store._beside

    def noted(folder: Path) -> frozenset[Path]:
        found = texts(folder)
        seen.extend(found)
        return found

    monkeypatch.setattr(store, "_beside", noted)
    code_digest(report)
    assert {"template.html", "style.css", "script.js"} <= {path.name for path in seen}
    seen.clear()
    code_digest(overlay)
    assert {"shaded.frag", "mannequin.glb"} <= {path.name for path in seen}
    before = code_digest(report)
    monkeypatch.setattr(store, "_beside", lambda folder: frozenset())
    assert code_digest(report) != before


@dataclass(frozen=True)
class Held:
    """A value that is not ours, so that only what it holds could count."""

    anything: object


def test_types_are_found_in_fields_and_containers_of_values_of_ours() -> None:
    path = Trajectory([0, 1], Motor.identity((2,)))
    assert types_within({"a": (path, 3)}) == {Trajectory, Motor}
    assert types_within(Held(path)) == set()
    names = {one.__name__ for one in types_within(recording_of_a_board())}
    assert {"Recording", "ImageFrames", "Camera", "Checkerboard"} <= names


def test_what_reads_a_recording_counts_for_the_stages_that_are_given_it() -> None:
    recording = recording_of_a_board()
    alone = code_digest(mean)
    assert code_digest(mean, [recording]) != alone
    assert code_digest(mean, [None, 3.0]) == alone
