"""Knobs as a user meets them: what is told of each can be typed, and every one has a meaning."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pytest

from motorcade.fusion.smoothing import REPRESENTATIONS
from motorcade.replays.cli import main
from motorcade.replays.engine.graph import Graph, Knob, described_knobs, parse_knobs
from motorcade.replays.engine.stage import Stage
from motorcade.replays.pipeline.described.describing import description_graph
from motorcade.replays.pipeline.job import pipeline_graph

GRAPH = pipeline_graph()
STAGES = (*description_graph().stages.values(), *GRAPH.stages.values())
EVERY = [(stage, knob) for stage in STAGES for knob in described_knobs(stage)]
IDS = [f"{stage.name}.{knob.name}" for stage, knob in EVERY]


@dataclass(frozen=True)
class Words:
    """Any output."""


def walked(
    *,
    gait: Literal["trot", "walk"] = "walk",
    speed_m_s: float | None = None,
    stops: tuple[int, ...] = (3, 5),
    places: tuple[float, ...] = (),
    led: bool = True,
    by: Path = Path("rope"),
    name: str = "Ada",
    unsaid: int = 1,
) -> Words:
    """Walk in a `gait`. It is
    `speed_m_s` fast (at
    most 2.5 m/s; e.g. 1); `led=false` lets go.

    `gait` again, which is not told. (The `stops` are counted.) `places`, `by` the sea
    """
    raise NotImplementedError


def test_each_is_told_with_values_default_and_its_first_sentence() -> None:
    walk = "Walk in a `gait`."
    fast = "It is `speed_m_s` fast (at most 2.5 m/s; e.g. 1); `led=false` lets go."
    last = "`places`, `by` the sea"
    assert described_knobs(Stage.of(walked)) == (
        Knob("gait", "trot, walk", "walk", walk),
        Knob("speed_m_s", "float or none", "none", fast),
        Knob("stops", "int,int,…", "3,5", "(The `stops` are counted.)"),
        Knob("places", "float,float,…", "", last),
        Knob("led", "true, false", "true", fast),
        Knob("by", "path", "rope", last),
        Knob("name", "text", "Ada", ""),
        Knob("unsaid", "int", "1", ""),
    )


def test_a_default_of_any_kind_is_told_as_it_is_typed() -> None:
    graph = Graph([walked], {})
    typed = [
        f"walked.{knob.name}={knob.default}" for knob in described_knobs(graph.stages["walked"])
    ]
    read = parse_knobs(typed, graph)["walked"]
    assert read == {name: knob.default for name, knob in graph.stages["walked"].knobs.items()}


@pytest.mark.parametrize(("stage", "knob"), EVERY, ids=IDS)
def test_every_default_can_be_typed_as_it_is_told(stage: Stage, knob: Knob) -> None:
    graph = GRAPH if stage.name in GRAPH.stages else description_graph()
    read = parse_knobs([f"{stage.name}.{knob.name}={knob.default}"], graph)
    assert read == {stage.name: {knob.name: stage.knobs[knob.name].default}}


@pytest.mark.parametrize(("stage", "knob"), EVERY, ids=IDS)
def test_every_knob_has_its_meaning_in_its_stages_docstring(stage: Stage, knob: Knob) -> None:
    assert f"`{knob.name}" in knob.meaning
    assert knob.meaning.endswith((".", ".)"))
    assert len(knob.meaning) < 400


def test_the_representations_that_can_be_compared_are_all_named() -> None:
    (knob,) = (k for k in described_knobs(GRAPH.stages["smoothed"]) if k.name == "representations")
    assert set(re.findall(r"\w+", knob.meaning)) >= set(REPRESENTATIONS)


def test_the_command_tells_them_all(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["graph", "--knobs"]) == 0
    lines = capsys.readouterr().out.splitlines()
    told = [line for line in lines if not line.startswith(" ")]
    assert told == [f"{s.name}.{k.name}={k.default}  ({k.values})" for s, k in EVERY]
    assert "placed.character=mannequin  (path)" in told
    assert max(map(len, lines)) <= 100
    meanings = " ".join(" ".join(line for line in lines if line.startswith(" ")).split())
    assert meanings == " ".join(knob.meaning for _, knob in EVERY)
