"""A cache key must change with any code that a result can depend on, and with nothing else."""

from pathlib import Path

import pytest

from motorcade.replays.engine import provenance
from motorcade.replays.stages.report import report
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.view.overlay import overlay


def reachable(function: object) -> tuple[frozenset[str], frozenset[str]]:
    return provenance._reachable(function.__module__)  # type: ignore[attr-defined]


def test_imports_are_followed_through_packages_and_functions() -> None:
    ours, foreign = reachable(smoothed)
    assert "motorcade.fusion.smoothing.window.local_polynomial" in ours
    assert "motorcade.ga.kernels.batches" in ours
    assert "motorcade.fusion.filter.native._filter" in ours
    assert {"numpy", "scipy"} <= foreign


def test_rooms_that_a_stage_does_not_use_are_left_out() -> None:
    ours, _ = reachable(smoothed)
    assert not any(name.startswith("motorcade.render") for name in ours)
    ours, foreign = reachable(overlay)
    assert "motorcade.render.backends.pyrender_backend" in ours
    assert {"pyrender", "av", "cv2"} <= foreign


def test_the_digest_changes_with_the_bytes_of_any_module_reached(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    before = provenance.code_digest(smoothed)
    assert provenance.code_digest(smoothed) == before
    origin = provenance._origin

    def edited(name: str) -> Path:
        path = origin(name)
        if name != "motorcade.ga.trajectory":
            return path
        copy = tmp_path / "trajectory.py"
        copy.write_bytes(path.read_bytes() + b"\n# one more line\n")
        return copy

    monkeypatch.setattr(provenance, "_origin", edited)
    assert provenance.code_digest(smoothed) != before


def test_the_digest_changes_with_versions(monkeypatch: pytest.MonkeyPatch) -> None:
    before = provenance.code_digest(smoothed)
    monkeypatch.setattr(provenance, "_version", lambda package: "another")
    assert provenance.code_digest(smoothed) != before


def test_the_digest_changes_with_templates_and_shaders_beside_the_modules(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Path] = []
    texts = provenance._texts

    def noted(folder: Path) -> frozenset[Path]:
        found = texts(folder)
        seen.extend(found)
        return found

    monkeypatch.setattr(provenance, "_texts", noted)
    provenance.code_digest(report)
    assert {"template.html", "style.css", "script.js"} <= {path.name for path in seen}
    seen.clear()
    provenance.code_digest(overlay)
    assert "surface.frag" in {path.name for path in seen}
    before = provenance.code_digest(report)
    monkeypatch.setattr(provenance, "_texts", lambda folder: frozenset())
    assert provenance.code_digest(report) != before
