"""A sweep is every combination that its file states; what the graph does not have is refused."""

from collections.abc import Callable
from itertools import product
from pathlib import Path

import pytest

from motorcade.replays.comparison.sweep import read_sweep
from motorcade.replays.engine.stage import GraphError
from motorcade.replays.io.files import RecordingError
from motorcade.replays.pipeline.job import pipeline_graph

Config = Callable[..., Path]


def test_runs_are_the_product_of_recordings_knobs_and_seeds(config: Config) -> None:
    path = config(knobs="smoothed.order = [1, 2]\nfused.look_ahead = [true, false]")
    plan = read_sweep(path, pipeline_graph())
    runs = list(plan.runs())
    combined = product(("one", "two"), ("1", "2"), ("true", "false"), (0, 1))
    assert [
        (one.recording.name, *(value for _, value in one.varied), one.seed) for one in runs
    ] == list(combined)
    assert len(plan) == len(runs) == 16
    assert {"simulated_poses.seed=1", "imu.seed=1", "fused.look_ahead=false"} <= set(
        runs[-1].settings
    )


def test_patterns_find_recordings_and_tables_name_manifests(config: Config, tmp_path: Path) -> None:
    plan = read_sweep(config('["*o", "t*", {path = "one", manifest = "m.toml"}]'), pipeline_graph())
    assert plan.recordings == (
        (tmp_path / "two", None),
        (tmp_path / "one", tmp_path / "m.toml"),
    )


def test_a_missing_recording_is_left_to_its_run_but_an_empty_pattern_is_refused(
    config: Config,
) -> None:
    assert len(read_sweep(config('["one", "gone"]'), pipeline_graph())) == 4
    with pytest.raises(RecordingError, match=r"toml, .*: no recording is called 'gone\*'"):
        read_sweep(config('["gone*"]'), pipeline_graph())


@pytest.mark.parametrize(
    ("knobs", "seeds", "told"),
    [
        ("fused.gat = 0.9", "[0]", "fused has no knob 'gat'"),
        ('smoothed.order = [1, "two"]', "[0]", "smoothed.order: expected int"),
        ("smoothed.order = [1, 1]", "[0]", "expected different values"),
        ("smoothed.order = []", "[0]", "expected different values"),
        ("imu.seed = 3", "[0]", "either this or seeds"),
        ("fuzed = 3", "[0]", "expected stage.knob"),
        ("", "[0, 0]", "got one twice"),
        ("", "[-1]", "whole numbers of at least 0"),
        ("", "3", "expected a list"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(
    config: Config, knobs: str, seeds: str, told: str
) -> None:
    with pytest.raises((RecordingError, GraphError), match=told):
        read_sweep(config(knobs=knobs, seeds=seeds), pipeline_graph())


def test_no_more_runs_than_the_bound(config: Config) -> None:
    seeds = str(list(range(1001)))
    gates = ", ".join(f"0.{one}" for one in range(100, 200) if one % 10)
    with pytest.raises(RecordingError, match="at most 100000 runs, got 180180"):
        read_sweep(config(knobs=f"fused.gate = [{gates}]", seeds=seeds), pipeline_graph())
