"""Files are paired, aligned, resampled and read as what they say of themselves, or refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS, handheld
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory


@pytest.fixture
def path() -> Trajectory:
    return handheld(np.random.default_rng(35)).sampled(20.0, 6.0, start_ns=1_600_000_000 * 10**9)


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, dict[str, str], str]:
    code = main([str(word) for word in words])
    printed, said = capsys.readouterr()
    rows = (line.split() for line in printed.splitlines())
    return code, {row[0]: row[-1] for row in rows if len(row) > 1}, said


@pytest.mark.parametrize("cut", ["first", "last"])
def test_kitti_files_of_different_length_are_not_paired_by_row(
    path: Trajectory, tmp_path: Path, capsys: pytest.CaptureFixture[str], cut: str
) -> None:
    part = path[2:] if cut == "first" else path[:-1]
    write_trajectory(path, tmp_path / "ref.kitti")
    write_trajectory(part, tmp_path / "est.kitti")
    words = ["evaluate", tmp_path / "est.kitti", tmp_path / "ref.kitti", "--rate-hz", 10]
    code, _, said = run(capsys, *words)
    assert code == 1
    assert f"{len(part)} in" in said
    assert "--rows FROM" in said
    code, figures, _ = run(capsys, *words, "--rows", 2 if cut == "first" else 0)
    assert code == 0
    assert int(figures["pairs"]) == len(part)
    assert float(figures["ape_rmse_m"]) < 1e-9


def test_a_column_of_frame_numbers_pairs_kitti_rows(
    path: Trajectory, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_trajectory(path, tmp_path / "ref.kitti")
    lines = (tmp_path / "ref.kitti").read_text().splitlines()
    some = [f"{k} {line}" for k, line in enumerate(lines) if k >= 3 and k % 4]
    (tmp_path / "est.txt").write_text("\n".join(some) + "\n")
    words = ["evaluate", tmp_path / "est.txt", tmp_path / "ref.kitti", "--rate-hz", 10]
    code, figures, _ = run(capsys, *words)
    assert code == 0
    assert int(figures["pairs"]) == len(some)
    assert float(figures["ape_rmse_m"]) < 1e-9
    (tmp_path / "est.txt").write_text("\n".join(some[::-1]) + "\n")
    assert "rising numbers of frames" in run(capsys, *words)[2]


def test_the_heading_alone_is_fitted_where_that_is_asked_for(path: Trajectory) -> None:
    """A lean stays as an error, a heading does not; along no axis is it more than in all."""
    turned = path.transformed_by(Motor.from_euler_translation([0.0, 0.0, 1.1], [3.0, 1.0, -2.0]))
    assert evaluate(turned, path, "yaw").ape_m.max < 1e-9
    assert evaluate(turned, path, "yaw").rotation_deg.max < 1e-6
    leaning = turned.transformed_by(Motor.from_euler_translation([0.05, 0.0, 0.0], [0.0, 0.0, 0.0]))
    found = evaluate(leaning, path, "yaw")
    assert found.tilt_deg.mean == pytest.approx(np.rad2deg(0.05), rel=1e-6)
    assert evaluate(leaning, path, "se3").ape_m.max < 1e-9
    assert np.linalg.norm(found.ape_axes_rmse_m) == pytest.approx(found.ape_m.rmse)
    assert found.as_dict()["ape_z_rmse_m"] == found.ape_axes_rmse_m[2]


def test_positions_above_each_other_leave_the_heading_free() -> None:
    still = Trajectory(np.arange(5) * 10**9, Motor.identity((5,)))
    with pytest.raises(ValueError, match="leave the heading free"):
        evaluate(still, still, "yaw")


def test_what_is_resampled_within_a_gap_is_said_and_left_out_where_asked(
    path: Trajectory,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    gone = path[np.abs(path.time_s - path.time_s[60]) > 1.0]
    write_trajectory(gone, tmp_path / "gap.tum")
    out = tmp_path / "out.tum"
    words = ["trajectory", tmp_path / "gap.tum", "--resample-hz", 20, "-o", out]
    code, _, _ = run(capsys, *words)
    assert code == 0
    assert "41 of 121 poses lie in gaps" in caplog.text
    assert len(read_trajectory(out)) == 121
    run(capsys, *words, "--max-gap-s", 0.5)
    assert "left out" in caplog.text
    assert len(read_trajectory(out)) == 80
    _, figures, _ = run(
        capsys, "evaluate", tmp_path / "gap.tum", _shifted(path, tmp_path), "--interpolate",
        "--max-difference-s", 3, "--max-gap-s", 0.5,
    )  # fmt: skip
    assert "pairs are left out" in caplog.text
    assert float(figures["ape_max_m"]) < 0.01


def _shifted(path: Trajectory, folder: Path) -> Path:
    """The truth at fewer stamps, which lie between those of the path."""
    few = path.resampled(path.time_ns[10:-10:5] + 10_000_000)
    write_trajectory(few, folder / "few.tum")
    return folder / "few.tum"


def _rows(path: Trajectory, folder: Path) -> str:
    """TUM's numbers with commas between, without its header."""
    write_trajectory(path, folder / "plain.tum")
    rows = (folder / "plain.tum").read_text().splitlines()
    return "".join(row.replace(" ", ",") + "\n" for row in rows if not row.startswith("#"))


@pytest.mark.parametrize("ending", [".tum", ".txt"])
@pytest.mark.parametrize(
    "header",
    ["", "# timestamp tx ty tz qx qy qz qw\n", "#,timestamp,tx,ty,tz,qx,qy,qz,qw\n"],
)
def test_a_comma_alone_makes_no_quaternion_begin_with_w(
    path: Trajectory, tmp_path: Path, ending: str, header: str
) -> None:
    rows = _rows(path, tmp_path)
    (tmp_path / f"commas{ending}").write_text(header + rows)
    found = read_trajectory(tmp_path / f"commas{ending}")
    np.testing.assert_array_equal(found.time_ns, path.time_ns)
    assert evaluate(found, path).rotation_deg.max < 1e-6


def test_stamps_that_contradict_the_ending_are_said(
    path: Trajectory, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = _rows(path, tmp_path)
    (tmp_path / "commas.csv").write_text(rows)
    assert evaluate(read_trajectory(tmp_path / "commas.csv"), path).rotation_deg.max > 1.0
    assert "read with qw first, as the ending says" in caplog.text
    (tmp_path / "commas.csv").write_text("# timestamp tx ty tz qx qy qz qw\n" + rows)
    assert evaluate(read_trajectory(tmp_path / "commas.csv"), path).rotation_deg.max < 1e-6
    noisy = Gaussian(0.0, 0.01).apply(MOTIONS["screw"].sampled(30.0, 1.0), np.random.default_rng(1))
    write_trajectory(noisy, tmp_path / "euroc.csv")
    bare = "\n".join((tmp_path / "euroc.csv").read_text().splitlines()[1:])
    (tmp_path / "bare.csv").write_text(bare + "\n")
    assert evaluate(read_trajectory(tmp_path / "bare.csv"), noisy).rotation_deg.max < 1e-6
