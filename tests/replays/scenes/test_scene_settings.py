"""Runs know when a scene, or a file that it names, has changed; and leave a scene's film."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.animation import write_gltf
from motorcade.replays.cli import main
from motorcade.replays.demo import write_recording
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.replays.pipeline.runs import open_run
from tests.props import ball, write_props

ONE = ("smoothed.representations=motor",)
BALL = {"name": "ball", "kind": "prop", "file": "ball.glb", "position_m": [0.0, 0.0, 0.0]}
WHO = {"name": "who", "kind": "character", "file": "mannequin", "height_m": 0.5}


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory, opengl: None) -> Path:
    """A short recording of the synthetic room, whose manifest places a character."""
    folder = tmp_path_factory.mktemp("scene") / "room"
    write_recording(folder, frames=12)
    return folder


def written(folder: Path, *objects: dict[str, Any]) -> Path:
    path = folder / "scene.json"
    path.write_text(json.dumps({"objects": objects}))
    return path


def kept(out: Path, stage: str = "placed") -> set[str]:
    return {one.name for one in (out / ".cache").glob(f"{stage}-*")}


def test_what_a_scene_names_is_part_of_what_its_stages_are_kept_under(
    room: Path, tmp_path: Path
) -> None:
    write_props(tmp_path)
    scene, out = written(tmp_path, WHO, BALL), tmp_path / "out"
    job = Job(room, out, until="placed", settings=ONE, scene=scene)
    run_job(job)
    first = kept(out)
    assert len(first) == 1
    made = (out / ".cache" / next(iter(first)) / "artifact.json").stat().st_mtime_ns
    run_job(job)
    assert kept(out) == first
    assert (out / ".cache" / next(iter(first)) / "artifact.json").stat().st_mtime_ns == made

    def changed() -> bool:
        before = {n: (out / ".cache" / n / "artifact.json").stat().st_mtime_ns for n in kept(out)}
        run_job(job)
        after = {n: (out / ".cache" / n / "artifact.json").stat().st_mtime_ns for n in kept(out)}
        return before != after

    assert not changed()
    write_gltf(tmp_path / "ball.glb", ball(0.2))
    assert changed()
    written(tmp_path, WHO, {**BALL, "position_m": [0.1, 0.0, 0.0]})
    assert changed()
    assert not changed()


def test_a_run_draws_a_scene_and_its_folder_says_so(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_props(tmp_path)
    scene, out = written(tmp_path, WHO, BALL), tmp_path / "out"
    told = ["run", str(room), "--scene", str(scene), "--out", str(out), "--set", *ONE, "--json"]
    assert main(told) == 0
    summary = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in summary["cast"]["characters"]] == ["who", "ball"]
    assert summary["overlay"]["frames_with_character"] == 12
    assert (out / "overlay.mp4").stat().st_size > 10_000
    settings = json.loads((out / "run.json").read_text())["settings"]
    assert f"placed.scene={scene}" in settings
    assert not any(one.startswith("placed.height_m") for one in settings)  # the room's own
    assert len(open_run(out).path) > 0  # which reads the scene again


def test_a_scene_found_in_a_recording_names_no_file_outside_it(tmp_path: Path) -> None:
    folder = tmp_path / "recording"
    folder.mkdir()
    lines = "settings = ['placed.scene=scene.json']\n[frames]\nrate_hz = 30\n"
    (folder / "motorcade.toml").write_text(lines)
    assert cv2.imwrite(str(folder / "0.png"), np.zeros((8, 8), np.uint8))
    written(folder, {**BALL, "file": "../ball.glb"})
    with pytest.raises(RecordingError, match="expected files inside"):
        open_recording(folder)
    written(folder, BALL)
    (setting,) = open_recording(folder).settings
    assert setting == f"placed.scene={folder / 'scene.json'}"


def test_a_scene_that_cannot_be_played_is_refused_before_anything_is_tracked(
    room: Path, tmp_path: Path
) -> None:
    write_props(tmp_path)
    scene = written(tmp_path, {**WHO, "walk": {"path_m": [[0, 0], [1, 0]], "gaits": ["swim"]}})
    with pytest.raises(ValueError, match=r"scene, 'who': .*no clip 'swim'"):
        run_job(Job(room, tmp_path / "out", settings=ONE, scene=scene))
    assert not (tmp_path / "out").exists()
