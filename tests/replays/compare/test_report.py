"""The comparison's pages show the figures that were found, and say what these figures say."""

import copy
import csv
import json
import math
import re
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from docs.making.guide import figures, page
from motorcade.replays.comparison.plan import (
    ComparisonCell,
    ComparisonPlan,
    DegradedMotion,
    MeasuredRow,
    Setting,
    run_cell,
)
from motorcade.replays.comparison.report.matrix import METRICS, shown
from motorcade.replays.comparison.report.page import findings, write_report
from motorcade.replays.comparison.report.results import Results, range_ends
from motorcade.replays.comparison.run import Trait, run_trait
from motorcade.replays.comparison.statistics import Sample
from motorcade.replays.comparison.tables import write_tables
from motorcade.replays.comparison.tuning import Tuned

PLAN = ComparisonPlan(
    motions=("gimbal_crossing", "walk_and_look"),
    degradations=("gaussian", "outliers"),
    methods=("exponential", "gaussian"),
    representations=("motor", "quaternion", "euler"),
    test_seeds=(7, 8, 9),
    tuning_seeds=(1, 2),
    duration_s=4.0,
)
PARAMETERS = {"exponential": (("cutoff_hz", 4.0),), "gaussian": (("sigma_s", 0.08),)}
VOID = {"meta", "link", "br", "wbr", "input", "img", "hr"}
PAIRS = [(method, name) for method in PLAN.methods for name in PLAN.representations]


def written(folder: Path, rename: Callable[[str], str]) -> Results:
    """Run the plan's cells with given parameters, renaming representations in what was found."""
    settings = tuple(Setting(*pair, PARAMETERS[pair[0]]) for pair in PAIRS)
    samples, found = [], {}
    for motion in PLAN.motions:
        for degradation in PLAN.degradations:
            for seed in PLAN.test_seeds:
                cell = ComparisonCell(PLAN.inputs(motion, degradation, seed), settings)
                rows = [
                    MeasuredRow(r.method, rename(r.representation), r.values)
                    for r in run_cell(cell)
                ]
                samples.append(Sample.of(cell, rows))
            for one in settings:
                place = (motion, degradation, one.method, one.representation)
                found[place] = Tuned(one, "search", 0.5, 12)
    traits = [
        run_trait(Trait(PLAN.inputs("walk_and_look", "gaussian", 1), one)) for one in settings
    ]
    traits = [row | {"representation": rename(row["representation"])} for row in traits]
    write_tables(folder, PLAN.as_dict(), samples, found, traits, TIES)
    return Results.read(folder)


TIES: list[dict[str, Any]] = [
    {
        "theory": "one is the other",
        "reason": "they are equal",
        "method": method,
        "first": "motor",
        "second": "quaternion",
        "largest_difference_m": size,
        "largest_difference_rad": None,
        "bound": 1e-9,
        "holds": size < 1e-9,
    }
    for method, size in (("exponential", 3e-15), ("gaussian", 2e-3))
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small comparison with its pages."""
    made = tmp_path_factory.mktemp("comparison")
    write_report(written(made, lambda name: name), made)
    return made


@pytest.fixture(scope="module")
def results(folder: Path) -> Results:
    return Results.read(folder)


@pytest.fixture(scope="module")
def swapped(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The same figures with the names of motors and Euler angles exchanged."""
    return written(tmp_path_factory.mktemp("swapped"), lambda name: SWAP.get(name, name))


SWAP = {"motor": "euler", "euler": "motor"}


class Page(HTMLParser):
    """A page's tables by the id of what they stand in, links and ids; refuses crossed tags."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.open: list[tuple[str, str | None]] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.tables: dict[str, list[list[tuple[str, float | None]]]] = {}
        self.cell: tuple[str, float | None] | None = None
        self.text: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        assert len(given) == len(attrs), f"an attribute twice in {tag}: {attrs}"
        if given.get("id"):
            self.ids.append(str(given["id"]))
        self.links += [str(v) for k, v in attrs if k in ("href", "src", "xlink:href", "srcset")]
        if tag not in VOID:
            self.open.append((tag, given.get("id")))
        if tag == "tr" and self.place():
            self.tables.setdefault(self.place(), []).append([])
        if tag in ("th", "td"):
            self.cell = ("", None)
        if tag == "data" and self.cell is not None:
            self.cell = (self.cell[0], float(str(given["value"])))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"{tag} closed and never opened"
        assert self.open[-1][0] == tag, f"{tag} closed in {self.open[-3:]}"
        if tag in ("th", "td") and self.cell is not None:
            if self.place():
                self.tables[self.place()][-1].append(self.cell)
            self.cell = None
        self.open.pop()

    def handle_data(self, data: str) -> None:
        if not any(tag in ("style", "script") for tag, _ in self.open):
            self.text.append(data)
        if self.cell is not None and not any(tag == "small" for tag, _ in self.open):
            self.cell = (self.cell[0] + data.strip(), self.cell[1])

    def place(self) -> str:
        return next((name for _, name in reversed(self.open) if name), "")

    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


def pages(folder: Path) -> list[Path]:
    return [folder / "report.html", *sorted((folder / "motions").glob("*.html"))]


def agrees(text: str, value: float) -> bool:
    """Whether a number is another one rounded to the digits that are shown."""
    if "e" in text:
        return math.isclose(float(text), value, rel_tol=0.5)
    last = 10.0 ** -len(text.partition(".")[2])
    return abs(float(text) - value) <= 0.5001 * last


def test_there_is_a_page_for_each_motion_and_it_names_all_that_was_run(folder: Path) -> None:
    assert [path.stem for path in pages(folder)] == ["report", *PLAN.motions]
    for path in pages(folder):
        words = Page(path).words()
        for name in (*PLAN.methods, *PLAN.representations):
            assert name in words
    for name in (*PLAN.motions, *PLAN.degradations):
        assert name in Page(folder / "report.html").words()


@pytest.mark.parametrize("number", range(3))
def test_pages_are_well_formed_and_need_nothing_from_elsewhere(folder: Path, number: int) -> None:
    path = pages(folder)[number]
    page = Page(path)
    assert len(set(page.ids)) == len(page.ids)
    for link in page.links:
        if link.startswith("#"):
            assert link[1:] in page.ids, link
        elif not link.startswith("data:"):
            assert (path.parent / link).is_file(), link
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"@import|url\((?!#)|fetch\(|XMLHttp", text)
    used = set(re.findall(r"url\(#([^)]+)\)", text))
    assert used <= set(page.ids)


def test_the_overview_shows_the_figures_of_the_results(folder: Path) -> None:
    told = json.loads((folder / "results.json").read_text())
    tables = Page(folder / "report.html").tables
    checked = 0
    for ranking in told["rankings"]:
        if ranking["scope"] != "all":
            continue
        head, *rows = tables[f"raw-{ranking['metric']}"]
        assert [name for name, _ in head[1:]] == list(PLAN.representations)
        expected = {(r["method"], r["representation"]): r["ratio_to_raw"] for r in ranking["rows"]}
        for (method, _), *cells in rows:
            for name, (text, value) in zip(PLAN.representations, cells, strict=True):
                assert value == expected[method, name]
                assert agrees(text, expected[method, name])
                checked += 1
    assert checked == 5 * len(PAIRS)


@pytest.mark.parametrize("motion", PLAN.motions)
def test_every_figure_of_a_motion_is_the_mean_of_its_cells(folder: Path, motion: str) -> None:
    metrics = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")
    tables = Page(folder / "motions" / f"{motion}.html").tables
    with (folder / "cells.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["motion"] == motion]
    for degradation in PLAN.degradations:
        shown_rows = tables[f"figures-{degradation}"][1:]
        assert len(shown_rows) == 1 + len(PAIRS)
        for (method, _), (name, _), *cells in shown_rows:
            for metric, (text, value) in zip(metrics, cells, strict=False):
                mean = (
                    np.mean(
                        [
                            float(row[metric])
                            for row in rows
                            if (row["degradation"], row["method"], row["representation"])
                            == (degradation, method, name)
                        ]
                    )
                    * METRICS[metric].factor
                )
                assert value == pytest.approx(mean, rel=1e-5)
                assert agrees(text, mean)


def test_seeds_and_parameters_are_shown(folder: Path) -> None:
    words = Page(folder / "report.html").words()
    assert "Judged on seeds 7–9" in words
    assert "parameters chosen on seeds 1, 2" in words
    for motion in PLAN.motions:
        text = Page(folder / "motions" / f"{motion}.html").words()
        assert "cutoff_hz 4" in text
        assert "sigma_s 0.08" in text


def test_ties_that_do_not_hold_are_not_called_ties(folder: Path) -> None:
    words = Page(folder / "report.html").words()
    assert "2e-03 m does not hold: gaussian" in words


def test_sentences_follow_the_figures(results: Results, swapped: Results) -> None:
    def exchanged(sentence: str) -> str:
        return re.sub(r"`(motor|euler)`", lambda name: f"`{SWAP[name[1]]}`", sentence)

    ours, theirs = findings(results), findings(swapped)
    assert tuple(map(exchanged, ours.best)) == theirs.best
    assert ours.best != theirs.best
    (euler,) = [one for one in ours.representations if one.startswith("`euler`")]
    (motor,) = [one for one in theirs.representations if one.startswith("`euler`")]
    more = float(re.findall(r"leaves ([\d.]+) times", euler)[0])
    less = float(re.findall(r"leaves ([\d.]+) times", motor)[0])
    assert more > 1.5
    assert more * less == pytest.approx(1.0, rel=0.01)
    assert "2 of 2 methods" in ours.frames[0]
    assert "none of 2 methods" in theirs.frames[0]


def test_over_all_sentences_give_the_ratio_of_the_cells(results: Results, folder: Path) -> None:
    with (folder / "cells.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    logs: dict[str, list[float]] = {}
    for raw, cell in by_cell(rows):
        for row in cell:
            left = np.mean(
                [
                    float(row[key]) / float(raw[key])
                    for key in (
                        "ape_rmse_m",
                        "rotation_rmse_deg",
                        "linear_jitter_m_s2",
                        "angular_jitter_rad_s2",
                    )
                ]
            )
            logs.setdefault(row["representation"], []).append(math.log(left))
    expected = math.exp(np.mean(logs["euler"]) - np.mean(logs["motor"]))
    (sentence,) = [one for one in findings(results).representations if "`euler`" in one]
    assert f"leaves {shown(expected)} times" in sentence


def by_cell(rows: list[dict[str, str]]) -> Iterator[tuple[dict[str, str], list[dict[str, str]]]]:
    cells: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in rows:
        cells.setdefault((row["motion"], row["degradation"], row["seed"]), []).append(row)
    for cell in cells.values():
        (raw,) = [row for row in cell if row["method"] == "raw"]
        yield raw, [row for row in cell if row is not raw]


def test_the_drawn_passage_is_that_of_the_first_seed(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    found = re.search(r'id="crossing-data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    data = json.loads(found[1])
    method = re.search(r"Each\s+image holds what <code>(\w+)</code>", text)
    assert method is not None
    degraded, evaluator = DegradedMotion(
        "gimbal_crossing", "gaussian", 7, PLAN.rate_hz, PLAN.duration_s
    ).drawn()
    true = Rotation.from_matrix(evaluator.true.as_matrix()[:, :3, :3])
    assert set(data["points"]) == {"truth", *PLAN.representations}
    for name in PLAN.representations:
        smoothed = Setting(method[1], name, PARAMETERS[method[1]]).smooth(degraded)
        turned = Rotation.from_matrix(smoothed.motors.as_matrix()[:, :3, :3])
        angle_deg = np.rad2deg((true.inv() * turned).magnitude())
        np.testing.assert_allclose(data["errors"][name], angle_deg, atol=0.0051)
    assert max(data["errors"]["euler"]) > 20.0
    assert max(data["errors"]["motor"]) < 5.0
    # Without perspective, opposite corners have the same sum, and the axis is where they meet.
    points = np.array(data["points"]["euler"]).reshape(len(degraded), 6, 2)
    np.testing.assert_allclose(points[:, 0] + points[:, 2], points[:, 1] + points[:, 3], atol=2.0)


def test_the_guide_is_written_from_the_figures(results: Results, swapped: Results) -> None:
    text = page(figures(results))
    for pair, ratio in results.ratio_to_raw("all", "ape_rmse_m").items():
        if pair[1] == "motor":
            (row,) = re.findall(rf"\| `{pair[0]}`.*? \| (.*) \|\n", text.split("## Methods")[1])[:1]
            assert row.split(" | ")[1] == f"{shown(100 * ratio.value)} %"
    for sentence in (*findings(results).wins, *findings(results).representations):
        assert sentence in text
    assert text != page(figures(swapped))
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", text, re.DOTALL)):
        compile(block, f"block {number}", "exec")


def test_ends_of_ranges_are_told(results: Results) -> None:
    assert range_ends(results) == []
    told = copy.deepcopy(dict(results.document))
    first = PLAN.motions[0]
    for row in told["parameters"]:
        if row["motion"] == first and row["representation"] == "motor":
            name = next(iter(row["parameters"]))
            row["parameters"][name] = told["ranges"][row["method"]][0]["high"]
    changed = Results(told, results.figures)
    # The last value of a cut-off smooths least, that of a width most.
    assert range_ends(changed) == [
        f"`exponential` asks for the least smoothing on {first}.",
        f"`gaussian` asks for the most smoothing on {first}.",
    ]
    text = page(figures(changed))
    for sentence in range_ends(changed):
        assert f"- {sentence}" in text


def test_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text('{"format": "something else"}')
    with pytest.raises(ValueError, match="expected format 'motorcade comparison 2'"):
        Results.read(tmp_path)
