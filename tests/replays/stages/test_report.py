"""The report's numbers are shown as they are: units, digits, dashes, and what JSON cannot say."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.render.plots import plot_series
from motorcade.replays.pipeline.report import page
from motorcade.replays.pipeline.report.page import _rows
from motorcade.replays.pipeline.report.summary import (
    LEFT_AS_IT_WAS,
    as_table,
    length_words,
    plainly,
    shown_columns,
    shown_value,
    verdict,
    without_nan,
)
from motorcade.replays.stages.values.errors import Integrity
from motorcade.tracking.audit import AuditFinding, Verdict

FIGURES = {
    "measured": {"ape_rmse_m": 0.0173, "rotation_rmse_deg": 0.8629, "lag_ms": -0.05},
    "motor": {"ape_rmse_m": 0.003871, "rotation_rmse_deg": 0.145, "lag_ms": None},
    "euler": {"ape_rmse_m": 0.003872, "rotation_rmse_deg": 12.0, "lag_ms": 0.7},
}


@pytest.mark.parametrize(
    ("key", "value", "shown"),
    [
        ("ape_rmse_m", 0.0173, "17.3"),
        ("ape_rmse_m", 1.5, "1500"),
        ("rotation_rmse_deg", 0.0067, "0.0067"),
        ("lag_ms", 0.0, "0.00"),
        ("lag_ms", None, "–"),
        ("lag_ms", float("nan"), "–"),
    ],
)
def test_figures_are_shown_in_their_unit(key: str, value: float | None, shown: str) -> None:
    assert shown_value(key, value) == shown


def test_only_columns_with_figures_are_shown() -> None:
    assert shown_columns(FIGURES) == ["ape_rmse_m", "rotation_rmse_deg", "lag_ms"]


def test_the_table_lines_up() -> None:
    lines = as_table({"errors": FIGURES}).splitlines()
    assert len({len(line) for line in lines}) == 1
    assert lines[2].split() == ["motor", "3.87", "0.145", "–"]


def test_equal_figures_share_the_honour() -> None:
    rows = _rows(FIGURES, ["ape_rmse_m", "lag_ms"])
    best = {row["name"]: [cell["best"] for cell in row["cells"]] for row in rows}
    assert best == {"measured": [False, True], "motor": [True, False], "euler": [True, False]}


def test_where_all_are_equal_none_is_best() -> None:
    same = {name: {"lag_ms": 0.021, "ape_rmse_m": FIGURES[name]["ape_rmse_m"]} for name in FIGURES}
    rows = _rows(same, ["ape_rmse_m", "lag_ms"])
    best = [[cell["best"] for cell in row["cells"]] for row in rows]
    assert best == [[False, False], [True, False], [True, False]]


def test_that_nothing_was_smoothed_is_told_below_the_table() -> None:
    smoothed = as_table({"errors": FIGURES, "smoothed": {"method": "gaussian"}})
    left = as_table({"errors": FIGURES, "smoothed": {"method": None}})
    assert left == f"{smoothed}\n{LEFT_AS_IT_WAS}"


def test_lengths_without_unit_are_not_told_in_metres() -> None:
    jitter = {"motor": {"angular_jitter_rad_s2": 0.1, "linear_jitter_m_s2": 0.3}}
    free = {"errors": jitter, "camera_poses": {"scale": "free"}}
    head = as_table(free).splitlines()[0]
    assert "lin. jitter (units/s²)" in head
    assert "ang. jitter (rad/s²)" in head
    assert "m/s²" in as_table(free | {"camera_poses": {"scale": "metric"}})
    judged = {"motor": jitter["motor"] | {"ape_rmse_m": 0.1}}
    assert "m/s²" in as_table(free | {"errors": judged}), "the ground truth gives the metre"


def test_what_json_cannot_say_becomes_null() -> None:
    tree = without_nan({"a": [1.0, float("nan")], "b": (float("inf"), "text", None)})
    assert json.dumps(tree, allow_nan=False) == '{"a": [1.0, null], "b": [null, "text", null]}'


@pytest.mark.parametrize(("limit", "inside"), [(18, True), (17, False)])
def test_films_too_large_together_for_a_page_lie_beside_it(
    limit: int, inside: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "FILMS_INSIDE_BYTES", limit)
    paths = {name: tmp_path / f"some-{name}.mp4" for name in ("overlay", "footage")}
    for path in paths.values():
        path.write_bytes(b"not long.")
    found = page._films(paths)
    assert [one.data for one in found.values()] == ["bm90IGxvbmcu" if inside else ""] * 2
    beside = [one.beside for one in found.values()]
    assert beside == (["", ""] if inside else ["overlay.mp4", "footage.mp4"])


@pytest.mark.parametrize(
    ("verdicts", "value"),
    [
        (("consistent", "unknown"), "Looks right"),
        (("doubtful", "unknown"), "Doubtful"),
        (("doubtful", "contradicted"), "Contradicted"),
        (("unknown", "unknown"), "Cannot be told"),
    ],
)
def test_the_first_tile_says_whether_the_result_can_be_relied_on(
    verdicts: tuple[Verdict, Verdict], value: str
) -> None:
    path = MOTIONS["handheld"].sampled(rate_hz=10.0, duration_s=1.0)
    names = ("coverage", "extrinsics")
    checks = tuple(
        AuditFinding(name, verdict, 0.5, "share", f"{name} is off", "mend it")
        for name, verdict in zip(names, verdicts, strict=True)
    )
    failed = [check.name for check in checks if not check.passed]
    drawn_is: Any = "measured" if failed else "smoothed"
    found: Any = SimpleNamespace(
        integrity=Integrity(checks, {}, path, drawn_is),
        doubts=(),
        recording=SimpleNamespace(people="none"),
    )
    tile = verdict(found, None)
    assert tile.value == value
    assert tile.wrong == bool(failed)
    told = "; ".join(f"{name} is off" for name in failed)
    assert tile.label == {
        "Looks right": "Nothing that was checked speaks against it: enough images have a camera "
        "pose. This recording cannot tell: extrinsics.",
        "Cannot be told": "This recording cannot tell: coverage, extrinsics.",
    }.get(value, f"{told.capitalize()}. The character stands along the measured path.")


@pytest.mark.parametrize(
    ("value", "floor", "shown"),
    [
        (0.0, 0.01, "under 0.01"),
        (0.0099, 0.01, "under 0.01"),
        (0.0526, 0.01, "0.053"),
        (1.349, 0.01, "1.3"),
        (12.6, 0.01, "13"),
        (1234.5, 0.01, "1,234"),
    ],
)
def test_people_are_told_two_digits(value: float, floor: float, shown: str) -> None:
    assert plainly(value, floor) == shown


def test_lengths_are_in_units_that_a_person_uses() -> None:
    assert length_words(0.000535, "m") == "0.54 mm"
    assert length_words(0.0871, "m") == "87 mm"
    assert length_words(3.21, "m") == "3.2 m"
    assert length_words(0.0871, "units") == "0.087 units"


def test_plots_take_their_ink_from_the_page_and_are_reproducible() -> None:
    time_s = np.linspace(0.0, 1.0, 50)
    series = {"motor": (time_s, np.exp(-time_s)), "truth": (time_s, np.ones(50))}
    plot = plot_series(series, "error", "m", log_scale=True, shaded_s=((0.2, 0.4),))
    assert plot.startswith("<svg")
    assert "var(--ink)" in plot
    assert "#123456" not in plot
    assert "<metadata" not in plot
    assert plot == plot_series(series, "error", "m", log_scale=True, shaded_s=((0.2, 0.4),))
