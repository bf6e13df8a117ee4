"""Comparisons from beginning to end: same results however they come about, failures contained."""

import csv
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS, REPRESENTATIONS
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.comparison import run as own_data
from motorcade.replays.comparison.evaluator import METRICS, RecordedMotion
from motorcade.replays.comparison.plan import (
    COMPARED,
    DEGRADATIONS,
    OWN,
    ComparisonPlan,
    DegradedMotion,
    Setting,
    quick,
    standard,
)
from motorcade.replays.comparison.run import compare_recorded, exact_ties, run_comparison
from motorcade.replays.comparison.tuning import RANGES, SearchPlace, Tuned, tuned
from motorcade.replays.io.trajectories import write_trajectory

UNITS = ("_m", "_deg", "_s2", "_ms", "_ratio", "_turns", "log_scale_rmse")
SMALL = ComparisonPlan(
    motions=("walk_and_look", "zoom"),
    degradations=("gaussian",),
    methods=("exponential", "double_exponential"),
    representations=("motor", "similarity", "euler"),
    test_seeds=(10, 11, 12),
    tuning_seeds=(1,),
    duration_s=3.0,
)


def without_times(folder: Path) -> dict[str, Any]:
    told: dict[str, Any] = json.loads((folder / "results.json").read_text())
    for trait in told["traits"]:
        trait.pop("time_us_per_pose")
    return told


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("small")
    run_comparison(SMALL, folder)
    return folder


def same(first: Path, second: Path) -> bool:
    names = ("cells.csv", "groups.csv")
    equal = all((first / n).read_bytes() == (second / n).read_bytes() for n in names)
    return equal and without_times(first) == without_times(second)


def test_seeds_are_disjoint_and_stand_in_the_results(small: Path) -> None:
    for plan in (standard(), quick(), standard(seeds=50)):
        assert not set(plan.test_seeds) & set(plan.tuning_seeds)
    assert len(standard(seeds=50).test_seeds) == 50
    plan = json.loads((small / "results.json").read_text())["plan"]
    assert plan["test_seeds"] == [10, 11, 12]
    assert plan["tuning_seeds"] == [1]
    assert {row["seed"] for row in rows_of(small / "cells.csv")} == {"10", "11", "12"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tuning_seeds": (11,)}, "expected other seeds than test_seeds, got \\[11\\]"),
        ({"methods": ("exponental",)}, "did you mean exponential"),
        ({"motions": ()}, "plan.motions: expected one or more"),
        ({"test_seeds": (3, 3)}, "plan.test_seeds"),
        ({"duration_s": 0.0}, "plan.duration_s: expected a number above 0"),
    ],
)
def test_plans_that_make_no_sense_are_refused(change: Mapping[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(SMALL, **change)


def test_the_standard_plan_is_complete() -> None:
    plan = standard()
    assert set(plan.motions) == set(MOTIONS)
    assert set(plan.degradations) == set(DEGRADATIONS)
    every = {(method, name) for method in METHODS for name in COMPARED}
    assert set(COMPARED) == {*REPRESENTATIONS, "euler_best"}
    assert set(plan.pairs()) == every | {("auto", OWN)}
    assert set(RANGES) | {"auto"} == set(METHODS)


def test_two_processes_give_what_one_gives(small: Path, tmp_path: Path) -> None:
    run_comparison(SMALL, tmp_path, "processes:2")
    assert same(small, tmp_path)


def test_a_failing_method_says_why_and_ends_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(trajectory: Trajectory, representation: Any, *, cutoff_hz: float = 1.0) -> None:
        if representation.name == "euler":
            raise ZeroDivisionError("gone\nwrong")
        return original(trajectory, representation, cutoff_hz=cutoff_hz)

    original = METHODS["exponential"]
    monkeypatch.setitem(METHODS, "exponential", broken)
    told = run_comparison(replace(SMALL, motions=("walk_and_look",)), tmp_path)
    rows = rows_of(tmp_path / "cells.csv")
    failed = [row for row in rows if row["failure"]]
    assert {(row["method"], row["representation"]) for row in failed} == {("exponential", "euler")}
    assert {row["failure"] for row in failed} == {"ZeroDivisionError: gone wrong"}
    assert len(failed) == 3
    assert len(rows) == 3 * (1 + 2 * 3)
    (failure,) = told["failures"]
    assert failure["seeds"] == 3
    how = {(one["method"], one["representation"]): one["how"] for one in told["parameters"]}
    assert how["exponential", "euler"] == "defaults"
    assert how["double_exponential", "euler"] == "search"


def test_keys_carry_units(small: Path) -> None:
    assert all(metric.endswith(UNITS) for metric in METRICS)
    (row, *_) = rows_of(small / "cells.csv")
    assert {"linear_jitter_ratio", "angular_jitter_ratio", *METRICS} <= set(row)
    told = json.loads((small / "results.json").read_text())
    for key in told["traits"][0]:
        assert key.endswith(("_m", "_rad", "_us_per_pose")) or key in {
            "method",
            "representation",
            "poses",
            "failure",
        }
    for one in told["parameters"]:
        units = ("_hz", "_s", "_m", "_rad", "_s2", "_s3", "_per_m", "_per_rad")
        assert all(name.endswith(units) for name in one["parameters"])


def test_every_representation_is_tuned_with_the_same_trials(small: Path) -> None:
    told = json.loads((small / "results.json").read_text())
    searched = [one for one in told["parameters"] if one["how"] == "search"]
    for method in SMALL.methods:
        assert len({one["trials"] for one in searched if one["method"] == method}) == 1
    (given,) = told["ranges"]["exponential"]
    for one in searched:
        if one["method"] == "exponential":
            assert given["low"] <= one["parameters"]["cutoff_hz"] <= given["high"]


def test_rotations_and_positions_are_tuned_apart_where_they_can_be() -> None:
    """A screw's positions curve where its rotations do not."""
    degraded, evaluator = DegradedMotion("screw", "gaussian", 1, 30.0, 4.0).drawn()
    raw = evaluator.errors([degraded])[0]
    (one,) = RANGES["gaussian"]
    for name in ("quaternion", "rotor", "euler_best"):
        found = tuned("gaussian", name, [(degraded, evaluator)], [raw])
        parameters = dict(found.setting.parameters)
        assert parameters["position.sigma_s"] < 0.7 * parameters["sigma_s"]
        errors = evaluator.errors([found.setting.smooth(degraded)])[0]
        assert found.objective == pytest.approx(np.nanmean(errors / raw), rel=1e-8)
        for value in np.geomspace(one.low, one.high, 20):
            path = Setting("gaussian", name, (("sigma_s", value),)).smooth(degraded)
            assert found.objective < 1.01 * np.nanmean(evaluator.errors([path])[0] / raw)


@pytest.mark.parametrize("name", ["motor", "euler"])
def test_the_value_that_is_taken_is_as_good_as_any_of_a_fine_grid(name: str) -> None:
    degraded, evaluator = DegradedMotion("handheld", "gaussian", 1, 30.0, 4.0).drawn()
    raw = evaluator.errors([degraded])[0]
    found = tuned("gaussian", name, [(degraded, evaluator)], [raw])
    (one,) = RANGES["gaussian"]

    def objective(value: float) -> float:
        path = Setting("gaussian", name, ((one.parameter, value),)).smooth(degraded)
        return float(np.mean(evaluator.errors([path])[0, :4] / raw[:4]))

    if name == "motor":
        assert found.objective == pytest.approx(
            objective(dict(found.setting.parameters)["sigma_s"]), rel=1e-8
        )
    finest = min(map(objective, np.geomspace(one.low, one.high, 40)))
    assert found.objective < 1.02 * finest
    assert found.trials == 9


def test_the_robust_method_is_told_its_noise_and_takes_the_process_noise_of_plain_noise() -> None:
    place = SearchPlace("gaussian_strong", "robust_map", "similarity")
    assert place.lender(True) == SearchPlace("gaussian", "rts_constant_velocity", "motor")
    assert place.lender(False) == SearchPlace("gaussian", "rts_constant_velocity", "similarity")
    parameters = (("noise_m", 0.005), ("noise_rad", 0.01), ("acceleration_m_s2", 0.7))
    lent = Tuned(Setting("rts_constant_velocity", "motor", parameters), "search", 0.3, 24)
    made = place.borrowed(lent)
    assert (made.setting.method, made.setting.representation) == ("robust_map", "similarity")
    assert dict(made.setting.parameters) == {
        "noise_m": 0.02,
        "noise_rad": np.deg2rad(2.0),
        "acceleration_m_s2": 0.7,
    }
    usual = SearchPlace("outliers", "gaussian", "rotor")
    assert usual.lender(True) == usual


def test_scales_are_judged_where_there_are_some(small: Path) -> None:
    for row in rows_of(small / "cells.csv"):
        assert bool(row["log_scale_rmse"]) == (row["motion"] == "zoom")


def test_ties_that_theory_predicts_hold() -> None:
    found = exact_ties()
    assert all(one["holds"] for one in found)
    assert any("dual quaternion linear blend" in one["theory"] for one in found)


def test_a_recording_is_compared_on_blocks_it_was_not_tuned_on(tmp_path: Path) -> None:
    truth = MOTIONS["handheld"].sampled(100.0, 15.0)
    moved = (
        MOTIONS["handheld"]
        .sampled(30.0, 14.9)
        .transformed_by(
            Motor.from_rotor_translation(
                Rotor.from_rotation_vector([0.4, -2.0, 0.3]), [3.0, 2.0, 1.0]
            )
        )
    )
    noisy = Gaussian(0.005, 0.01).apply(moved, np.random.default_rng(1))
    told = compare_recorded(
        noisy, truth, tmp_path, methods=("gaussian",), representations=("motor", "quaternion")
    )
    seeds = told["plan"]["tuning_seeds"], told["plan"]["test_seeds"]
    assert seeds == ([0, 2, 4, 6], [1, 3, 5, 7])
    rows = rows_of(tmp_path / "cells.csv")
    assert {row["seed"] for row in rows} == {"1", "3", "5", "7"}
    mean = {
        row["method"]: float(row["ape_rmse_m"]) for row in rows if row["representation"] != "euler"
    }
    assert mean["gaussian"] < 0.7 * mean["raw"] < 0.01
    with pytest.raises(ValueError, match="200 poses or more within the ground truth, got 150"):
        compare_recorded(noisy[:150], truth, tmp_path)


def test_a_comparison_of_own_data_goes_on_where_it_was_and_runs_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    truth = MOTIONS["handheld"].sampled(60.0, 8.0)
    clean = MOTIONS["handheld"].sampled(30.0, 7.9)
    noisy = Gaussian(0.005, 0.01).apply(clean, np.random.default_rng(1))

    def compared(folder: str, *methods: str, executor: str = "local") -> str:
        out = tmp_path / folder
        compare_recorded(
            noisy, truth, out, methods=methods, representations=("motor",), executor=executor
        )
        return (out / "cells.csv").read_text()

    here = compared("here", "gaussian")
    assert compared("elsewhere", "gaussian", executor="processes:2") == here
    searched = []

    def counted(method: str, *given: Any) -> Tuned:
        searched.append(method)
        return tuned(method, *given)

    monkeypatch.setattr(own_data, "tuned", counted)
    assert compared("here", "gaussian") == here
    assert searched == []
    compared("here", "gaussian", "exponential")
    assert searched == ["exponential"]
    noisy = Gaussian(0.005, 0.01).apply(clean, np.random.default_rng(2))
    compared("here", "gaussian")
    assert searched == ["exponential", "gaussian"]


def test_the_command_runs_quickly_and_refuses_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["compare", "--quick", "--seeds", "3", "--trajectories", "screw", "--noise", "gaussian"]
    assert (
        main([*words, "--methods", "exponential", "--executor", "local", "--out", str(tmp_path)])
        == 0
    )
    printed = capsys.readouterr().out
    assert "exponential" in printed
    assert "dual quaternion linear blend: holds" in printed
    assert main([*words, "--methods", "expnential"]) == 1
    assert "did you mean exponential?" in capsys.readouterr().err
    assert main(["compare", "--input", "a.tum", "--out", str(tmp_path)]) == 1
    assert "expected --input and --truth together" in capsys.readouterr().err


def test_a_recorded_motion_is_degraded_and_judged_as_one_with_a_formula(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    true = MOTIONS["handheld"].sampled(100.0, 12.0)
    write_trajectory(true, tmp_path / "flight.tum")
    recorded = RecordedMotion.of(tmp_path / "flight.tum")
    degraded, evaluator = DegradedMotion("flight", "gaussian", 1, 30.0, 6.0, recorded).drawn()
    assert len(degraded) == 181
    time_s = 3.0 + np.arange(181) / 30.0  # the middle of the path
    np.testing.assert_allclose(evaluator.time_s + evaluator.truth.origin_ns * 1e-9, time_s)
    at = MOTIONS["handheld"].at(time_s).pose
    np.testing.assert_allclose(evaluator.true.translation_m, at.translation_m, atol=1e-6)
    words = ["compare", "--quick", "--trajectories", "screw", str(tmp_path / "flight.tum")]
    words += ["--seeds", "2", "--noise", "gaussian", "--methods", "exponential"]
    words += ["--representations", "motor", "--executor", "local", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    told = json.loads((tmp_path / "out" / "results.json").read_text())
    assert told["plan"]["motions"] == ["screw", "flight"]
    assert told["plan"]["recorded"][0]["digest"] == recorded.digest
    assert (tmp_path / "out" / "motions" / "flight.html").is_file()
    write_trajectory(true[:900], tmp_path / "flight.tum")
    with pytest.raises(ValueError, match="changed since"):
        recorded.read()
    assert main([*words[:3], str(tmp_path / "flight.tum"), "handhold"]) == 1
    assert "did you mean handheld?" in capsys.readouterr().err


def test_own_files_are_compared_from_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = MOTIONS["handheld"].sampled(60.0, 10.0)
    noisy = Gaussian(0.005, 0.01).apply(
        MOTIONS["handheld"].sampled(30.0, 10.0), np.random.default_rng(1)
    )
    write_trajectory(noisy, tmp_path / "noisy.tum")
    write_trajectory(truth, tmp_path / "truth.tum")
    words = [
        "compare",
        "--input",
        str(tmp_path / "noisy.tum"),
        "--truth",
        str(tmp_path / "truth.tum"),
        "--methods",
        "gaussian",
        "--representations",
        "motor",
        "--out",
        str(tmp_path / "out"),
    ]
    assert main(words) == 0
    assert "gaussian" in capsys.readouterr().out
    assert json.loads((tmp_path / "out" / "results.json").read_text())["plan"]["align"] == "se3"


def test_splines_settle_beside_poses_that_are_plainly_wrong() -> None:
    path, _ = DegradedMotion("distant_circle", "outliers_and_flips", 102, 30.0, 12.0).drawn()
    made = Setting("spline", "motor", (("knot_spacing_s", 0.6),)).smooth(path)
    assert np.max(np.linalg.norm(made.poses.translation_m - path.poses.translation_m, axis=1)) < 5.0
