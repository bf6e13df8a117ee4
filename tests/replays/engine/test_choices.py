"""A choice takes the first of several stages that works, and the others leave no trace."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from motorcade.replays.engine import store
from motorcade.replays.engine.graph import Graph, draw_mermaid, parse_knobs
from motorcade.replays.engine.stage import Chosen, GraphError, NotOffered, StageError, first_of
from motorcade.replays.pipeline.job import pipeline_graph
from tests.replays.engine.key_sizes import modules_under, recording_of_a_board

calls: list[str] = []


class NothingThere(ValueError):
    """What a way of measuring raises that found nothing."""


@dataclass(frozen=True)
class Room:
    width_m: float

    def digest(self) -> str:
        return f"{self.width_m}"


@dataclass(frozen=True)
class Length:
    value_m: float


@dataclass(frozen=True)
class TapedLength(Length):
    marks: int


@dataclass(frozen=True)
class Told:
    text: str


def by_laser(room: Room) -> Length:
    calls.append("by_laser")
    if room.width_m > 50.0:
        raise NothingThere("no echo")
    if room.width_m < 0.0:
        raise NotOffered("no laser for rooms that small")
    return Length(room.width_m)


def by_tape(room: Room, *, marks: int = 10) -> TapedLength:
    calls.append("by_tape")
    if abs(room.width_m) > 90.0:
        raise NothingThere("the tape is too short")
    return TapedLength(abs(room.width_m), marks)


def length(measured: Chosen[Length]) -> Told:
    calls.append("length")
    return Told(f"{measured.value.value_m:g} by {measured.by} {list(measured.skipped)}")


def marks(length: Told, by_tape: TapedLength | None) -> Told:
    return Told("none" if by_tape is None else f"{by_tape.marks}")


MEASURED = first_of("measured", skips=NothingThere, laser=by_laser, tape=by_tape)
GRAPH = Graph([MEASURED, length, marks], {"room": Room})


@pytest.fixture(autouse=True)
def _forget_calls() -> None:
    calls.clear()


def told(cache: Path, width_m: float, *settings: str, target: str = "length") -> str:
    knobs = parse_knobs(settings, GRAPH)
    return str(GRAPH.run(target, {"room": Room(width_m)}, cache, knobs).outputs[target].text)


def test_the_first_that_works_is_taken_and_no_other_is_run(tmp_path: Path) -> None:
    assert told(tmp_path, 3.0) == "3 by laser []"
    assert calls == ["by_laser", "length"]


def test_one_that_finds_nothing_is_told_and_one_that_lacks_its_input_is_not(tmp_path: Path) -> None:
    assert told(tmp_path, 60.0) == "60 by tape ['laser: no echo']"
    assert told(tmp_path, -4.0) == "4 by tape []"


def test_what_found_nothing_is_not_tried_again(tmp_path: Path) -> None:
    first = told(tmp_path, 60.0)
    calls.clear()
    assert told(tmp_path, 60.0) == first
    assert calls == []
    assert told(tmp_path, 60.0, "by_tape.marks=3", target="marks") == "3"
    assert calls == ["by_tape", "length"]


def test_a_knob_names_one_of_them(tmp_path: Path) -> None:
    assert told(tmp_path, 3.0, "measured.by=tape") == "3 by tape []"
    assert calls == ["by_tape", "length"]
    with pytest.raises(StageError, match="by_laser: no echo"):
        told(tmp_path, 60.0, "measured.by=laser")
    with pytest.raises(StageError, match="by_laser: no laser"):
        told(tmp_path, -4.0, "measured.by=laser")
    with pytest.raises(GraphError, match="expected one of auto, laser, tape"):
        told(tmp_path, 3.0, "measured.by=eye")


def test_where_none_works_every_reason_is_told(tmp_path: Path) -> None:
    with pytest.raises(StageError, match="measured: laser: no echo; tape: the tape is too short"):
        told(tmp_path, 99.0)
    told(tmp_path, 60.0)
    with pytest.raises(StageError, match="by_laser: no echo"):
        told(tmp_path, 60.0, target="by_laser")


def test_others_may_take_one_of_them_and_get_none_where_it_was_not_chosen(tmp_path: Path) -> None:
    assert told(tmp_path, 3.0, target="marks") == "none"
    assert told(tmp_path, 60.0, target="marks") == "10"
    run = GRAPH.run("marks", {"room": Room(60.0)}, tmp_path)
    assert run.chosen == {"measured": "by_tape"}
    assert run.outputs["by_laser"] is None


def test_wrong_wiring_of_choices_is_refused() -> None:
    def wants_a_tape(measured: Chosen[TapedLength]) -> Told:
        return Told(f"{measured}")

    def wants_it_always(by_tape: TapedLength) -> Told:
        return Told(f"{by_tape}")

    def wants_it_bare(measured: Length) -> Told:
        return Told(f"{measured}")

    for stage in (wants_a_tape, wants_it_bare):
        with pytest.raises(GraphError, match="takes measured"):
            Graph([MEASURED, stage], {"room": Room})
    with pytest.raises(GraphError, match="allow None"):
        Graph([MEASURED, wants_it_always], {"room": Room})


def test_a_drawing_shows_that_one_is_enough() -> None:
    text = draw_mermaid(GRAPH)
    assert "by_laser -.-> measured" in text
    assert "by_tape -.-> measured" in text
    assert "measured --> length" in text


def test_an_edit_of_slam_computes_nothing_anew_of_a_run_on_a_board(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every file of SLAM is edited at once: no key of a stage that such a run computes changes."""
    aside = ("slam_poses", "turning_poses", "tracked")  # not computed where a board tells poses
    order = [name for name in pipeline_graph().order if name not in aside]
    keys = {name: _digest(name) for name in [*order, "slam_poses"]}
    origin, copies = store._origin, {}

    def edited(name: str) -> Path:
        path = origin(name)
        if not name.startswith("motorcade.tracking.slam"):
            return path
        copies[name] = tmp_path / f"{name}.py"
        copies[name].write_bytes(path.read_bytes() + b"\n# one more line\n")
        return copies[name]

    monkeypatch.setattr(store, "_origin", edited)
    assert {name: _digest(name) for name in order} == {name: keys[name] for name in order}
    assert _digest("slam_poses") != keys["slam_poses"]
    assert copies


def _digest(stage: str) -> str:
    known = pipeline_graph().stages[stage]
    given = [recording_of_a_board()] if "recording" in known.inputs else []
    return store.code_digest(known.function, given)  # type: ignore[union-attr]


def test_the_key_of_smoothing_covers_little_but_smoothing() -> None:
    names = modules_under("smoothed")
    assert len(names) <= 120
    for room in ("tracking", "render", "animation"):
        assert not any(name.startswith(f"motorcade.{room}") for name in names)
