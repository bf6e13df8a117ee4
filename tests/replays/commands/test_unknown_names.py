"""Names that do not exist are told of at once, with the nearest that does; lists stay short."""

import os
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga.names import did_you_mean
from motorcade.replays.cli import main
from motorcade.replays.cli.runs import _kept
from motorcade.replays.pipeline.job import Job, run_job


def test_of_many_names_a_dozen_is_shown() -> None:
    names = [f"clip{index:02d}" for index in range(80)]
    advice = did_you_mean("nonsense", names)
    assert advice == f"known here: {', '.join(names[:12])} and 68 more"
    assert did_you_mean("nonsense", names[:12]) == f"known here: {', '.join(names[:12])}"
    assert did_you_mean("clip7", names).startswith("did you mean clip")
    assert did_you_mean("x", []) == "known here: none"


def test_commands(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["smoth"])
    assert "no command 'smoth'; did you mean smooth?" in capsys.readouterr().err


def test_comparisons_name_the_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "--trajectories", "screww", "--out", str(tmp_path / "out")]) == 1
    assert "--trajectories: unknown 'screww'; did you mean screw?" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("character=none.glb", r"placed\.character: expected 'mannequin' or a file"),
        ("clip=wlak", r"placed\.clip: no clip 'wlak'; did you mean walk"),
    ],
)
def test_who_acts_is_looked_up_before_anything_runs(
    setting: str, message: str, tmp_path: Path
) -> None:
    folder, out = tmp_path / "recording", tmp_path / "out"
    folder.mkdir()
    for index in range(4):
        cv2.imwrite(str(folder / f"{index}.png"), np.zeros((48, 64), np.uint8))
    (folder / "motorcade.toml").write_text('[frames]\nimages = "*.png"\nrate_hz = 30.0\n')
    with pytest.raises(ValueError, match=message):
        run_job(Job(folder, out, settings=(f"placed.{setting}",)))
    assert not out.exists()


@pytest.mark.parametrize("command", [["demo"], ["simulate-imu", "path.tum"], ["consistency"]])
@pytest.mark.parametrize("seed", ["-1", "1.5", "one", "²", "9" * 5000])
def test_seeds_are_whole_numbers(
    command: list[str], seed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*command, f"--seed={seed}"])
    assert ended.value.code == 2
    assert "expected a whole number from 0 on, got" in capsys.readouterr().err


def test_options_of_all_commands_may_stand_before_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["-q", "view", str(tmp_path)]) == 1
    assert "run.json is not there" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["-v", "--quiet", "vew"])
    assert "no command 'vew'; did you mean view?" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["run", "inspect", "view", "author"])
def test_addresses_are_told_as_they_were_typed(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, "http://example.org/a/b.mp4"]) == 1
    message = capsys.readouterr().err
    assert "http://example.org/a" in message
    assert "http:/e" not in message


def test_a_video_through_a_pipe_becomes_a_file_beside_its_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe, out = tmp_path / "pipe", tmp_path / "out"
    monkeypatch.setattr("motorcade.replays.cli.runs.STDIN", str(pipe))
    for head, suffix in ((b"\0\0\0 ftypisom", ".mp4"), (b"RIFF\0\0\0\0AVI ", ".avi")):
        os.mkfifo(pipe)
        data = head + bytes(range(256)) * 9000
        writer = threading.Thread(target=pipe.write_bytes, args=(data,), daemon=True)
        writer.start()
        file = _kept(pipe, out)
        writer.join()
        assert file == out / f"recording{suffix}"
        assert file.read_bytes() == data
        pipe.unlink()
    assert _kept(out, tmp_path) == out


def test_what_comes_through_a_pipe_and_is_no_video_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motorcade.replays.cli.runs.STDIN", str(tmp_path / "pipe"))
    os.mkfifo(tmp_path / "pipe")
    writer = threading.Thread(target=(tmp_path / "pipe").write_bytes, args=(b"time,x,y\n",))
    writer.start()
    with pytest.raises(ValueError, match=r"pipe: expected a video \(mp4"):
        _kept(tmp_path / "pipe", tmp_path / "out")
    writer.join()
    assert not (tmp_path / "out").exists()
