"""A run knows its recording wherever both were moved together, and from any working folder."""

import json
from pathlib import Path

import pytest

from motorcade.replays.cli.main import main
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.job import Job
from motorcade.replays.pipeline.runs import read_origin

ROWS = """\
1 0 0 0 0 1 0 0 0 0 1 0
1 0 0 1 0 1 0 0 0 0 1 0
"""


def written(folder, recording, manifest):
    told = {
        "recording": str(folder / "before" / "clip.mp4"),
        "recording_from_here": recording,
        "manifest": str(folder / "before" / "fov90.toml"),
        "manifest_from_here": manifest,
        "content": "0",
        "settings": [],
    }
    run = folder / "before" / "out" / "run"
    run.mkdir(parents=True)
    (run / "run.json").write_text(json.dumps(told))
    for name in ("clip.mp4", "fov90.toml"):
        (folder / "before" / name).write_bytes(b"")
    return run


def test_a_run_that_was_moved_with_its_recording_finds_it(tmp_path, monkeypatch):
    run = written(tmp_path, "../../clip.mp4", "../../fov90.toml")
    assert read_origin(run).recording == tmp_path / "before" / "clip.mp4"
    (tmp_path / "before").rename(tmp_path / "after")
    monkeypatch.chdir(tmp_path / "after" / "out")
    for folder in (tmp_path / "after" / "out" / "run", Path("run")):
        found = read_origin(folder)
        assert found.recording == tmp_path / "after" / "clip.mp4"
        assert found.manifest == tmp_path / "after" / "fov90.toml"


def test_settings_that_name_files_are_found_from_anywhere(tmp_path, monkeypatch):
    run = written(tmp_path, "../../clip.mp4", "../../fov90.toml")
    cast = tmp_path / "before" / "cast.toml"
    cast.write_bytes(b"")
    log = json.loads((run / "run.json").read_text())
    log["settings"] = ["fused.gate=0.99", f"placed.cast={cast}", "placed.scene=none"]
    log["settings_from_here"] = [
        log["settings"][0],
        "placed.cast=../../cast.toml",
        "placed.scene=none",
    ]
    (run / "run.json").write_text(json.dumps(log))
    assert read_origin(run).knobs["placed"]["cast"] == cast
    (tmp_path / "before").rename(tmp_path / "after")
    monkeypatch.chdir(tmp_path / "after" / "out")
    for folder in (tmp_path / "after" / "out" / "run", Path("run")):
        assert read_origin(folder).settings == (
            "fused.gate=0.99",
            f"placed.cast={tmp_path / 'after' / 'cast.toml'}",
            "placed.scene=none",
        )


def test_settings_of_a_recording_are_stored_whole(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = ("placed.cast=clip/cast.toml", "placed.on=floor")
    recording = Recording("clip", Path("clip"), "made", frames=(None,), settings=own)
    settings = Job(Path("clip"), Path("out")).all_settings(recording)
    assert settings == (f"placed.cast={tmp_path / 'clip/cast.toml'}", "placed.on=floor")


@pytest.mark.parametrize("command", ["smooth", "evaluate"])
def test_stamps_of_kitti_files_come_as_the_message_says(tmp_path, capsys, command):
    poses, times = tmp_path / "poses.kitti", tmp_path / "times.txt"
    poses.write_text(ROWS * 8)
    times.write_text("".join(f"{0.1 * k:.1f}\n" for k in range(16)))
    rest = {"smooth": ["-o", str(tmp_path / "o.tum")], "evaluate": [str(poses)]}[command]
    words = [command, str(poses), *rest]
    assert main(words) == 1
    told = capsys.readouterr().err
    assert "--rate-hz HZ" in told
    assert "--times FILE" in told
    assert main([*words, "--rate-hz", "10"]) == 0
    assert main([*words, "--times", str(times)]) == 0
