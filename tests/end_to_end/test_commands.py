"""The command line as a user meets it: what it leaves, what it prints, how it ends."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motorcade.render import read_frames
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import read_trajectory


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a job that must fail: exit 1, one line on standard error, which is returned."""
    assert run(*arguments) == 1
    error = capsys.readouterr().err
    assert error.startswith("motorcade: ")
    assert error.count("\n") == 1
    return error


@pytest.fixture(scope="session")
def finished(board_recording: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output folder of a whole run."""
    out = tmp_path_factory.mktemp("out")
    assert run("run", board_recording, "--out", out) == 0
    return out


def test_a_run_leaves_report_video_and_trajectories(finished: Path) -> None:
    report = json.loads((finished / "report.json").read_text())
    assert report["camera_poses"]["measured"] == report["camera_poses"]["frames"] == 24
    assert report["errors"]["motor"]["ape_rmse_m"] < 0.001
    assert report["errors"]["motor"]["rotation_rmse_deg"] < 0.2
    for name in ("camera_poses_motor", "fused_motor", "smoothed_motor", "smoothed_quaternion"):
        assert len(read_trajectory(finished / "trajectories" / f"{name}.tum")) == 24
    assert set(json.loads((finished / "run.json").read_text())["stages"]) >= {"fused", "report"}


def test_the_report_holds_no_time_and_the_run_log_does(finished: Path) -> None:
    def keys(tree: object) -> set[str]:
        if not isinstance(tree, dict):
            return set()
        return set(tree).union(*map(keys, tree.values()))

    timed = {"seconds", "frames_per_s", "cached"}
    assert not timed & keys(json.loads((finished / "report.json").read_text()))
    run_log = json.loads((finished / "run.json").read_text())
    assert timed <= keys(run_log)
    assert run_log["tracking"]["seconds"] > 0.0


def test_a_run_with_the_mannequin_depends_on_no_file_beside_the_recording(finished: Path) -> None:
    stages = json.loads((finished / "run.json").read_text())["stages"]
    assert {name: stage["files"] for name, stage in stages.items() if stage["files"]} == {}


def test_the_same_inputs_leave_the_same_report(
    board_recording: Path, finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(board_recording.parent)
    assert run("run", board_recording.name, "--out", tmp_path) == 0
    for name in ("report.json", "report.html"):
        assert (tmp_path / name).read_bytes() == (finished / name).read_bytes(), name


def test_the_page_needs_nothing_beside_it(finished: Path) -> None:
    page = (finished / "report.html").read_text()
    assert 'id="film-overlay"' in page or "No video" in page
    assert "src=" not in re.sub(r'src="data:[^"]*"', "", page)
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert page.count("<svg") >= 5


def test_the_video_has_every_frame_at_its_stamp(finished: Path) -> None:
    film = finished / "overlay.mp4"
    if not film.exists():
        pytest.skip("no OpenGL here")
    stamps = [time_ns for time_ns, _ in read_frames(film)]
    np.testing.assert_allclose(stamps, np.arange(24) * 50_000_000, atol=20_000)


def test_a_second_run_computes_nothing(
    board_recording: Path, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def compute(*arguments: object) -> None:
        raise AssertionError("a stage was computed again")

    monkeypatch.setattr("motorcade.replays.engine.store.StageStore._compute", compute)
    before = {path.name: path.read_bytes() for path in finished.glob("report.*")}
    assert run("run", board_recording, "--out", finished) == 0
    assert before == {path.name: path.read_bytes() for path in finished.glob("report.*")}


KILLER = """
import os, sys
from motorcade.replays.engine import artifacts
from motorcade.replays.cli import main

stage, whole = sys.argv[1], artifacts._publish

def publish(building, folder):
    if folder.name.startswith(stage):
        os.kill(os.getpid(), 9)
    whole(building, folder)

artifacts._publish = publish
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.parametrize(
    "stage",
    [
        "board_poses",
        *(
            pytest.param(stage, marks=pytest.mark.slow)
            for stage in ("camera_poses", "smoothed", "fused", "overlay", "report")
        ),
    ],
)
def test_a_run_killed_in_any_stage_resumes_to_the_same_bytes(
    stage: str, board_recording: Path, finished: Path, tmp_path: Path
) -> None:
    if stage == "overlay" and not (finished / "overlay.mp4").exists():
        pytest.skip("no OpenGL here")
    arguments = ["run", str(board_recording), "--out", str(tmp_path)]
    killed = subprocess.run([sys.executable, "-c", KILLER, stage, *arguments], check=False)
    assert killed.returncode == -9
    assert not (tmp_path / "report.html").exists()
    assert run(*arguments) == 0
    compared = [*(finished / "trajectories").iterdir(), *finished.glob("overlay.mp4")]
    assert len(compared) >= 5
    for path in compared:
        again = tmp_path / path.relative_to(finished)
        assert again.read_bytes() == path.read_bytes(), f"{path.name} differs"
    leftovers = [path.name for path in (tmp_path / ".cache").iterdir() if path.name[0] == "."]
    assert leftovers == []


@pytest.mark.slow
def test_without_opengl_all_but_the_video_is_there(board_recording: Path, tmp_path: Path) -> None:
    environment = dict(os.environ, PYOPENGL_PLATFORM="none")
    program = [
        sys.executable,
        "-c",
        "import sys; from motorcade.replays.cli import main; sys.exit(main())",
    ]
    done = subprocess.run(
        [*program, "run", str(board_recording), "--out", str(tmp_path)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "PYOPENGL_PLATFORM" in done.stderr
    assert not (tmp_path / "overlay.mp4").exists()
    assert "apt-get install" in (tmp_path / "report.html").read_text()
    assert (tmp_path / "trajectories" / "smoothed_motor.tum").exists()


def test_knobs_reach_their_stage(board_recording: Path, tmp_path: Path) -> None:
    settings = ["--set", "smoothed.representations=motor", "--set", "smoothed.window_s=0.4"]
    assert run("run", board_recording, "--out", tmp_path, "--until", "smoothed", *settings) == 0
    names = {path.name for path in (tmp_path / "trajectories").iterdir()}
    assert names == {"camera_poses_motor.tum", "fused_motor.tum", "smoothed_motor.tum"}
    record = json.loads((tmp_path / "run.json").read_text())["stages"]["smoothed"]
    assert record["knobs"]["window_s"] == "0.4"


def test_results_of_an_earlier_run_do_not_stay_beside_new_ones(
    board_recording: Path, tmp_path: Path
) -> None:
    assert run("run", board_recording, "--out", tmp_path) == 0
    (tmp_path / "trajectories" / "mine.tum").write_text("a user's own")
    settings = ["--until", "smoothed", "--set", "smoothed.representations=motor"]
    assert run("run", board_recording, "--out", tmp_path, *settings) == 0
    left = {path.name for path in tmp_path.iterdir()} - {".cache"}
    assert left == {"run.json", "trajectories"}
    kept = {path.name for path in (tmp_path / "trajectories").iterdir()}
    assert kept == {
        "camera_poses_motor.tum",
        "fused_motor.tum",
        "smoothed_motor.tum",
        "mine.tum",
    }


def test_the_demo_never_touches_a_folder_that_it_did_not_make(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = tmp_path / "recording" / "raw.bin"
    own.parent.mkdir()
    own.write_text("mine")
    assert "choose another --out" in refused(capsys, "demo", "--out", tmp_path)
    assert own.read_text() == "mine"


@pytest.mark.slow
@pytest.mark.usefixtures("opengl")
def test_the_demo_contradicts_nothing_that_it_states(tmp_path: Path) -> None:
    out = str(tmp_path / "demo")
    assert main(["demo", "-q", "--strict", "--until", "integrity", "--out", out]) == 0


def test_recordings_of_one_name_are_refused_before_anything_runs(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    error = refused(capsys, "run", board_recording, board_recording, "--out", tmp_path / "out")
    assert "2 recordings are called 'small_board'" in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("count", [1, 3, 6])
def test_short_recordings_without_truth_run(
    count: int, board_recording: Path, tmp_path: Path
) -> None:
    short = tmp_path / "short"
    short.mkdir()
    for path in sorted(board_recording.glob("*.png"))[:count]:
        shutil.copy(path, short)
    manifest = (board_recording / "motorcade.toml").read_text().partition("[truth]")[0]
    manifest = manifest.replace('images = "*.png"\n', "").replace("20.0", "8.0")
    (short / "motorcade.toml").write_text(manifest)
    assert run("run", short, "--out", tmp_path / "out", "--until", "errors") == 0
    fused = read_trajectory(tmp_path / "out" / "trajectories" / "fused_motor.tum")
    assert len(fused) == count


def test_several_recordings_fan_out_and_one_failure_ends_only_itself(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    out = tmp_path / "out"
    until = ["--until", "smoothed", "--executor", "processes"]
    assert run("run", empty, board_recording, "--out", out, *until) == 1
    assert "1 of 2 recordings failed" in capsys.readouterr().err
    assert (out / "small_board" / "trajectories" / "smoothed_motor.tum").exists()


def test_bad_recordings_end_in_one_line_and_leave_earlier_results(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.html").write_text("earlier")
    broken = tmp_path / "broken"
    shutil.copytree(board_recording, broken)
    (broken / "012.png").rename(broken / "9000012.png")
    assert "expected images that are numbered" in refused(capsys, "run", broken, "--out", out)
    (broken / "9000012.png").rename(broken / "012.png")
    manifest = (broken / "motorcade.toml").read_text()
    for wrong, named in (
        (manifest.replace("rate_hz", "rate_hertz"), "rate_hertz"),
        (manifest.replace('"pinhole"', '"radtan"\ndistortion = [0.1, 0.2, 0.3]'), "distortion"),
    ):
        (broken / "motorcade.toml").write_text(wrong)
        assert named in refused(capsys, "run", broken, "--out", out)
    (broken / "motorcade.toml").write_text(manifest)
    rows = (broken / "truth.tum").read_text().splitlines()
    for wrong_rows, named in (
        ([*rows[:3], rows[1], *rows[3:]], "line"),
        ([rows[0], rows[1].rsplit(" ", 1)[0] + " nan", *rows[2:]], "line 2"),
    ):
        (broken / "truth.tum").write_text("\n".join(wrong_rows))
        assert named in refused(capsys, "run", broken, "--out", out)
    assert (out / "report.html").read_text() == "earlier"


def test_an_output_folder_that_cannot_be_written_is_named(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    assert "--out" in refused(capsys, "run", board_recording, "--out", tmp_path / "file" / "out")


def test_an_empty_folder_is_called_empty(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "empty folder" in refused(capsys, "run", tmp_path, "--out", tmp_path / "out")


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("smoothed", "expected stage.knob=value"),
        ("smothed.window_s=1", "no stage 'smothed' to set; did you mean smoothed?"),
        ("placed.charater=x", "no knob 'charater'; did you mean character?"),
        ("smoothed.windw=1", "no knob 'windw'"),
        ("smoothed.window_s=wide", "expected float, got 'wide'"),
        ("placed.on=ceiling", "expected one of auto, board, marker, plane, floor"),
        ("simulated_poses.sigma_m=nan", "expected a number within"),
        ("smoothed.window_s=1e300", "expected a number within"),
        ("smoothed.representations=", "smoothed: representations: expected at least one"),
        ("fused.noise_factor=0", "fused: "),
        ("placed.height_m=0", "placed: "),
    ],
)
def test_bad_settings_are_named(
    setting: str,
    named: str,
    board_recording: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert named in refused(capsys, "run", board_recording, "--out", tmp_path, "--set", setting)


def test_bad_usage_exits_with_two() -> None:
    with pytest.raises(SystemExit, match="2"):
        run("run")


def test_smooth_then_evaluate(board_recording: Path, tmp_path: Path) -> None:
    truth, smooth = board_recording / "truth.tum", tmp_path / "smooth.tum"
    assert run("smooth", truth, "-o", smooth, "--method", "gaussian", "--set", "sigma_s=0.05") == 0
    assert run("evaluate", smooth, truth, "--align", "se3", "--json", tmp_path / "e.json") == 0
    found = json.loads((tmp_path / "e.json").read_text())
    assert found["pairs"] == 24
    assert 0 < found["ape_rmse_m"] < 0.002


def test_simulated_imu_is_a_recording_s_imu(board_recording: Path, tmp_path: Path) -> None:
    from motorcade.replays.io.imu import read_imu

    out = tmp_path / "imu.csv"
    arguments = ["simulate-imu", board_recording / "truth.tum", "-o", out, "--rate-hz", "100"]
    assert run(*arguments) == 0
    first = out.read_bytes()
    stream = read_imu(out)
    assert stream.rate_hz == pytest.approx(100.0)
    assert np.linalg.norm(stream.specific_force_m_s2, axis=1).mean() == pytest.approx(9.81, abs=1)
    assert run(*arguments) == 0
    assert out.read_bytes() == first, "the same seed gives the same bytes"


def test_inspect_and_graph_print(
    board_recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("inspect", board_recording, "--json") == 0
    about = json.loads(capsys.readouterr().out)
    assert about["frames_count"] == 24
    assert about["frames_rate_hz"] == pytest.approx(20.0)
    assert run("graph") == 0
    assert "camera_poses --> fused" in capsys.readouterr().out
    assert run("graph", "--svg", tmp_path / "graph.svg") == 0
    assert (tmp_path / "graph.svg").read_text().startswith("<svg")
