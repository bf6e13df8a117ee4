"""`motorcade evaluate` prints what matters, everything where asked, and keeps its JSON whole."""

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory


def test_the_figures_that_matter_are_printed_and_all_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = MOTIONS["screw"].sampled(30.0, 3.0)
    noisy = Gaussian(0.005, 0.01).apply(truth, np.random.default_rng(2))
    write_trajectory(truth, tmp_path / "truth.tum")
    write_trajectory(noisy, tmp_path / "noisy.tum")
    words = ["evaluate", str(tmp_path / "noisy.tum"), str(tmp_path / "truth.tum")]
    kept = tmp_path / "errors.json"
    assert main([*words, "--json", str(kept)]) == 0
    short = dict(line.split() for line in capsys.readouterr().out.splitlines())
    assert main([*words, "--all"]) == 0
    full = dict(line.split() for line in capsys.readouterr().out.splitlines())
    found = evaluate(*(read_trajectory(tmp_path / f"{name}.tum") for name in ("noisy", "truth")))
    assert json.loads(kept.read_text()) == found.as_dict()
    assert list(full) == list(found.as_dict())
    assert short.items() <= full.items()
    assert "None" not in short.values()
    assert 10 <= len(short) <= 13
    assert {"align", "pairs", "ape_rmse_m", "rotation_rmse_deg", "rpe_trans_rmse_m"} <= set(short)
    assert {"linear_jitter_m_s2", "angular_jitter_rad_s2", "lag_ms"} <= set(short)
    assert float(short["ape_rmse_m"]) == pytest.approx(found.as_dict()["ape_rmse_m"], rel=1e-4)


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    """A folder with a path, and two estimates of it of different noise."""
    truth = MOTIONS["walk_and_look"].sampled(20.0, 8.0)
    write_trajectory(truth, tmp_path / "truth.tum")
    for name, noise_m in (("near", 0.002), ("far", 0.02)):
        noisy = Gaussian(noise_m, 0.01).apply(truth, np.random.default_rng(2))
        write_trajectory(noisy, tmp_path / f"{name}.tum")
    return tmp_path


def evaluated(folder: Path, *words: str) -> int:
    return main(["evaluate", *(str(folder / w) if w.endswith(".tum") else w for w in words)])


def test_several_estimates_stand_side_by_side(
    walk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = walk / "both.json"
    assert evaluated(walk, "near.tum", "far.tum", "truth.tum", "--json", str(kept)) == 0
    head, *rows = (line.split() for line in capsys.readouterr().out.splitlines())
    assert head == ["near", "far"]
    assert all(len(row) == 3 for row in rows)
    both = json.loads(kept.read_text())
    assert list(both) == ["near", "far"]
    table = {key: (near, far) for key, near, far in rows}
    assert float(table["ape_rmse_m"][1]) == pytest.approx(both["far"]["ape_rmse_m"], rel=1e-4)
    assert both["far"]["ape_rmse_m"] > 5.0 * both["near"]["ape_rmse_m"]
    alone = walk / "alone.json"
    assert evaluated(walk, "near.tum", "truth.tum", "--json", str(alone)) == 0
    assert json.loads(alone.read_text()) == both["near"]


def test_estimates_of_one_name_are_told_by_their_paths(
    walk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = walk / "other"
    other.mkdir()
    (walk / "near.tum").rename(other / "far.tum")
    assert evaluated(walk, "other/far.tum", "far.tum", "truth.tum") == 0
    assert capsys.readouterr().out.split()[:2] == [str(other / "far.tum"), str(walk / "far.tum")]
    assert evaluated(walk, "far.tum", "far.tum", "truth.tum") == 1
    assert "expected each file once" in capsys.readouterr().err


def test_what_was_asked_for_is_printed(walk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--relations", "full,angle_rad", "--delta", "2", "--delta-unit", "m", "--all-pairs"]
    assert evaluated(walk, "near.tum", "truth.tum", *words, "--drift", "1,2,900") == 0
    found = dict(line.split() for line in capsys.readouterr().out.splitlines())
    assert (found["rpe_delta"], found["rpe_delta_unit"], found["rpe_pairs"]) == ("2", "m", "all")
    assert {"ape_full_rmse", "ape_full_max", "rpe_angle_rmse_rad"} <= set(found)
    assert 0.0 < float(found["drift_translation_percent"]) < 5.0
    assert float(found["drift_rotation_deg_100m"]) > 0.0


def test_errors_and_an_image_are_written_where_asked(walk: Path) -> None:
    errors, plot = walk / "errors.csv", walk / "errors.svg"
    words = ["--errors", str(errors), "--plot", str(plot), "--project", "yz"]
    assert evaluated(walk, "near.tum", "far.tum", "truth.tum", *words) == 0
    assert len(errors.read_text().splitlines()) == 1 + 2 * 161
    image = plot.read_text()
    assert "far" in image
    assert "z (m)" in image


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--relations", "ful"], "--relations: unknown 'ful'; did you mean full?"),
        (["--plot", "errors.png"], "--plot: expected a name ending in .svg, got errors.png"),
        (["--drift", "ten"], "--drift: expected kitti, or lengths in metres"),
        (["--drift", "0"], "length_m: expected a number above 0"),
        (["--delta", "1.5"], "delta: expected a whole number of frames, got 1.5"),
        (["--delta", "200", "--delta-unit", "deg"], "delta: expected above 0 and at most 180 deg"),
        (["--delta-tolerance", "nan"], "delta tolerance: expected 0 or more"),
        (["--n-to-align", "9"], "n_to_align: only se3, sim3, yaw, scale, scaled_origin are fitted"),
        (["--align", "se3", "--n-to-align", "-1"], "n_to_align: expected 3 or more pairs"),
        (["--start-s", "5", "--end-s", "4"], "expected a start before the end, got 5.0, 4.0"),
        (["--start-s", "1e9"], "expected poses from 1000000000.0 to inf s, got none"),
        (["--end-s", "nan"], "expected a start before the end"),
        (["--offset-s", "inf"], "offset_s: expected at most 3.2e9 s"),
        (["--offset-s", "30"], "expected stamps within max_difference_s = 0.01 s"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(
    walk: Path, capsys: pytest.CaptureFixture[str], words: list[str], problem: str
) -> None:
    assert evaluated(walk, "near.tum", "truth.tum", *words) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert problem in line
