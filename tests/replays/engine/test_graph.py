"""The stage graph: wiring is checked, nothing is computed twice, a killed run resumes."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from motorcade.replays.engine.graph import Graph, draw_mermaid, draw_svg
from motorcade.replays.engine.stage import GraphError, StageError, Unavailable

calls: list[str] = []


@dataclass(frozen=True)
class Text:
    content: str

    def digest(self) -> str:
        return f"digest of {self.content}"


@dataclass(frozen=True)
class Number:
    value: float


@dataclass(frozen=True)
class Row:
    values: np.ndarray


def length(text: Text, *, factor: float = 1.0) -> Number:
    calls.append("length")
    return Number(len(text.content) * factor)


def row(length: Number, *, count: int = 3) -> Row:
    calls.append("row")
    return Row(np.full(count, length.value))


def image(length: Number) -> Text:
    raise Unavailable("no images here: install a camera")


def total(row: Row, image: Text | None) -> Number:
    calls.append("total")
    return Number(float(row.values.sum()) + (100.0 if image else 0.0))


@pytest.fixture(autouse=True)
def _forget_calls() -> None:
    calls.clear()


def graph() -> Graph:
    return Graph([total, image, row, length], {"text": Text})


def test_a_target_runs_what_it_needs_in_order(tmp_path: Path) -> None:
    run = graph().run("row", {"text": Text("four")}, tmp_path)
    assert calls == ["length", "row"]
    np.testing.assert_array_equal(run.outputs["row"].values, [4.0, 4.0, 4.0])


def test_nothing_is_computed_twice(tmp_path: Path) -> None:
    first = graph().run("row", {"text": Text("four")}, tmp_path)
    again = graph().run("row", {"text": Text("four")}, tmp_path)
    assert calls == ["length", "row"]
    assert all(record.cached for record in again.records)
    np.testing.assert_array_equal(first.outputs["row"].values, again.outputs["row"].values)


def test_a_knob_recomputes_its_stage_and_what_follows(tmp_path: Path) -> None:
    graph().run("row", {"text": Text("four")}, tmp_path)
    run = graph().run("row", {"text": Text("four")}, tmp_path, {"row": {"count": 2}})
    assert calls == ["length", "row", "row"]
    assert run.outputs["row"].values.shape == (2,)


def test_other_content_is_another_key(tmp_path: Path) -> None:
    graph().run("length", {"text": Text("four")}, tmp_path)
    assert graph().run("length", {"text": Text("seven77")}, tmp_path).outputs["length"].value == 7


def test_equal_content_upstream_stops_recomputation(tmp_path: Path) -> None:
    graph().run("row", {"text": Text("four")}, tmp_path)
    graph().run("row", {"text": Text("five")}, tmp_path)
    assert calls == ["length", "row", "length"]


def test_an_optional_stage_that_cannot_run_is_left_out(tmp_path: Path) -> None:
    run = graph().run("total", {"text": Text("four")}, tmp_path)
    assert run.outputs["total"].value == 12.0
    assert run.unavailable == {"image": "no images here: install a camera"}


def test_a_stage_asked_for_by_name_says_what_it_lacks(tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="install a camera"):
        graph().run("image", {"text": Text("four")}, tmp_path)


def test_unknown_names_are_refused_with_those_that_exist(tmp_path: Path) -> None:
    with pytest.raises(GraphError, match=r"no stage 'rwo'.*row"):
        graph().run("rwo", {"text": Text("four")}, tmp_path)
    with pytest.raises(GraphError, match=r"row has no knob 'cuont'; did you mean count\?"):
        graph().run("row", {"text": Text("four")}, tmp_path, {"row": {"cuont": 2}})


def test_wrong_wiring_is_refused_when_the_graph_is_made() -> None:
    def asks_for_nothing_known(nobody: Number) -> Number:
        return nobody

    def takes_the_wrong_type(length: Row) -> Row:
        return length

    with pytest.raises(GraphError, match="asks for 'nobody'"):
        Graph([asks_for_nothing_known], {"text": Text})
    with pytest.raises(GraphError, match="takes length"):
        Graph([length, takes_the_wrong_type], {"text": Text})


def test_cycles_are_refused() -> None:
    def hen(egg: Number) -> Number:
        return egg

    def egg(hen: Number) -> Number:
        return hen

    with pytest.raises(GraphError, match="hen -> egg -> hen"):
        Graph([hen, egg], {"text": Text})


def test_drawings_hold_every_stage_and_edge() -> None:
    text = draw_mermaid(graph())
    assert "length --> row" in text
    assert "image -.-> total" in text
    svg = draw_svg(graph())
    assert svg.count("<rect") == 5
    assert svg.count('class="edge optional"') == 1


KILLED = """
import os, sys
from dataclasses import dataclass
from pathlib import Path
from motorcade.replays.engine.graph import Graph
import stages_on_disk as s

sys.path.insert(0, ".")
graph = Graph([s.first, s.second], {"text": s.Text})
run = graph.run("second", {"text": s.Text("a")}, Path("cache"))
print(*(r.stage for r in run.records if not r.cached), run.outputs["second"].value)
"""

STAGES = """
import os
from dataclasses import dataclass
from pathlib import Path

@dataclass(frozen=True)
class Text:
    content: str
    def digest(self): return self.content

@dataclass(frozen=True)
class Number:
    value: float

def first(text: Text) -> Number:
    return Number(1.5)

def second(first: Number) -> Number:
    if Path("die").exists():
        os.kill(os.getpid(), 9)
    return Number(first.value * 2)
"""


def test_a_killed_run_resumes_and_new_code_recomputes(tmp_path: Path) -> None:
    (tmp_path / "stages_on_disk.py").write_text(STAGES)
    (tmp_path / "die").touch()

    def run() -> subprocess.CompletedProcess[str]:
        environment = dict(os.environ, PYTHONPATH=str(tmp_path), PYTHONDONTWRITEBYTECODE="1")
        return subprocess.run(
            [sys.executable, "-c", KILLED],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    assert run().returncode == -9
    (tmp_path / "die").unlink()
    assert run().stdout == "second 3.0\n"
    assert run().stdout == "3.0\n"
    (tmp_path / "stages_on_disk.py").write_text(STAGES.replace("1.5", "2.5"))
    assert run().stdout == "first second 5.0\n"


def test_what_a_stage_refuses_names_the_stage(tmp_path: Path) -> None:
    def picky(text: Text) -> Number:
        raise ValueError(f"text: expected another, came {text.content}")

    with pytest.raises(StageError, match=r"^picky: text: expected another, came four$"):
        Graph([picky], {"text": Text}).run("picky", {"text": Text("four")}, tmp_path)
