"""The image of the animation suite shows what was measured, and ozz-animation beside it."""

import inspect
import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.bench import animation
from tests.bench.__main__ import main
from tests.bench.images import OZZ_NS, animation_image
from tests.bench.tables import SUITES

FOUND = {
    "rows": [
        {"job": job, "figure": figure, "unit": unit, "subject": "a figure"}
        for job, figure, unit in (
            ("two samples, blend (motor), local to model, palette of motors", 12.5, "ns a joint"),
            ("two layers of 100 characters blended (motor)", 1.75, "ns a joint"),
            ("skinning, position and normal, linear, one core", 3.25, "ns a vertex"),
            ("skinning, position and normal, motor, 2 threads", 6.5, "ns a vertex"),
            ("skinning in NumPy, float64, motor", 840.0, "ns a vertex"),
            ("the same in NumPy, float64", 1500.0, "µs a character"),
        )
    ]
}


def test_jobs_stand_with_their_figures_and_marks() -> None:
    image = animation_image(FOUND)
    texts = [text.strip() for text in re.findall(r"<text[^>]*>([^<]*)</text>", image)]
    for row in FOUND["rows"][:4]:
        assert row["job"] in texts
        assert f"{row['figure']:.3g}" in texts
    assert not any("NumPy" in text for text in texts)
    marks = re.findall(r"fill: none; stroke: var\(--ink\); stroke-width: 2", image)
    assert len(marks) == len(OZZ_NS) == 3


def test_every_figure_of_ozz_has_a_job_of_ours() -> None:
    """The jobs' names are those that the suite gives."""
    source = inspect.getsource(animation)
    for start in OZZ_NS:
        assert start.split(", linear")[0] in source


def test_nothing_to_draw_is_refused() -> None:
    with pytest.raises(ValueError, match="expected jobs in ns a joint or ns a vertex"):
        animation_image({"rows": FOUND["rows"][-1:]})


def test_the_command_writes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["blend", "--svg", str(tmp_path / "no.svg")])
    assert "expected the suite animation" in capsys.readouterr().err

    def measured(name: str) -> tuple[Any, str]:
        assert name in SUITES
        return FOUND, "a table"

    monkeypatch.setattr("tests.bench.__main__.run_suite", measured)
    out, figures = tmp_path / "animation.svg", tmp_path / "animation.json"
    main(["animation", "--svg", str(out), "--json", str(figures)])
    assert json.loads(figures.read_text())["animation"] == FOUND
    assert out.read_text().startswith("<svg")
    assert "prefers-color-scheme" in out.read_text()
