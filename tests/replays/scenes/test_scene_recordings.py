"""Whole runs with scenes of three characters and two props: the film shows each where it is."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.animation import write_gltf
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.replays.pipeline.runs import open_run
from tests.props import box, write_props
from tests.replays.carried_marker import ID, write_carried

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("opengl")]

MANIFEST = Path(__file__).parents[3] / "docs" / "manifests" / "vamr_board.toml"
FRAMES = 24


def thing(name: str, parent: str, file: str = "mannequin", **more: Any) -> dict[str, Any]:
    kind = "character" if file == "mannequin" else "prop"
    return {"name": name, "kind": kind, "file": file, "parent": parent, **more}


def people(parent: str, step_m: float) -> list[dict[str, Any]]:
    """Three in a row that leaves each in view: one walks, one waves, one turns its head."""
    turn = {"time_s": 0.0, "joints": {"head": [0.8, 0.0, 0.0, 0.6]}}
    way = [[0.0, -step_m], [0.6 * step_m, -step_m]]
    place = {"height_m": step_m, "euler_deg": [0, 0, -90]}
    return [
        thing("walker", parent, height_m=step_m, walk={"path_m": way}),
        thing("waver", parent, **place, position_m=[1.6 * step_m, -step_m, 0], clip="wave"),
        thing("looker", parent, **place, position_m=[3 * step_m, -step_m, 0])
        | {"joint_keyframes": [turn]},
    ]


def run_with(recording: Path, manifest: Path | None, scene: Path, out: Path) -> None:
    settings = ("smoothed.representations=motor", "placed.floor_m=0")
    run_job(Job(recording, out, manifest, settings=settings, scene=scene))


def check_film(out: Path, least: float) -> None:
    """In most frames the middle of every object differs from the footage, in the film itself."""
    shown = open_run(out)
    camera, film = shown.recording.camera, cv2.VideoCapture(str(out / "overlay.mp4"))
    assert camera is not None
    assert len(shown.cast) == 5
    differs: dict[str, list[bool]] = {name: [] for name in shown.cast}
    for frame in shown.recording.frames:
        read, image = film.read()
        assert read
        before = np.asarray(frame.image()).reshape(*image.shape[:2], -1)[..., ::-1]
        changed = np.abs(image.astype(int) - before).max(axis=-1) > 20
        eye = shown.path.motors_at(np.int64(frame.time_ns)).inverse()
        for name, one in shown.cast.items():
            pose = one.world_T_character(frame.time_ns)
            middle = pose.apply([0.0, 0.0, 0.45 * one.character.height_m])
            x, y = camera.project(eye.apply(middle)).round().astype(int)
            around = changed[max(y - 3, 0) : y + 4, max(x - 3, 0) : x + 4]
            if around.size == 49:
                differs[name].append(bool(around.mean() > 0.3))
    for name, found in differs.items():
        assert len(found) > 0.8 * len(shown.recording.frames), name
        assert np.mean(found) > least, name


def write_board(data_dir: Path, folder: Path, frames: int = FRAMES) -> tuple[Path, Path]:
    """The first frames of vamr_board, and their manifest."""
    source, recording = data_dir / "replays" / "vamr_board", folder / "board"
    (recording / "images").mkdir(parents=True)
    for image in sorted((source / "images").iterdir())[:frames]:
        shutil.copy(image, recording / "images")
    for name in ("K.txt", "D.txt"):
        shutil.copy(source / name, recording)
    lines = [line for line in (source / "poses.txt").read_text().splitlines() if line.strip()]
    (recording / "poses.txt").write_text("\n".join(lines[:frames]) + "\n")
    manifest = folder / "board.toml"
    manifest.write_text(MANIFEST.read_text().replace("rows = 250", f"rows = {frames}"))
    return recording, manifest


def test_three_characters_and_two_props_on_the_board(data_dir: Path, tmp_path: Path) -> None:
    recording, manifest = write_board(data_dir, tmp_path)
    write_props(tmp_path)
    keys = [
        {"time_s": 0.0, "position_m": [0.05, -0.05, 0.05], "scale": 0.2},
        {"time_s": 0.7, "position_m": [0.25, -0.05, 0.05], "euler_deg": [0, 0, 170], "scale": 0.3},
    ]
    objects = [
        *people("table", 0.08),
        thing("box", "table", "box.glb", position_m=[0.16, -0.15, 0.0], scale=0.2),
        thing("ball", "table", "ball.glb", keyframes=keys),
    ]
    scene = {"anchors": {"table": {"on": "board"}}, "objects": objects}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    run_with(recording, manifest, tmp_path / "scene.json", tmp_path / "out")
    check_film(tmp_path / "out", 0.9)


def test_three_characters_and_two_props_on_a_marker_that_moves(tmp_path: Path) -> None:
    write_carried(tmp_path / "carried")
    write_props(tmp_path)
    write_gltf(tmp_path / "box.glb", box(shade=0.95))  # brighter than the wall
    objects = [
        *people("tag", 0.05),
        thing("box", "tag", "box.glb", position_m=[0.02, -0.12, 0.0], scale=0.15),
        thing("ball", "wall", "ball.glb", position_m=[0.05, -0.2, 0.0], scale=0.3),
    ]
    anchors = {"tag": {"on": "marker", "marker": ID}, "wall": {"on": "marker", "marker": 2}}
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps({"anchors": anchors, "objects": objects}))
    run_with(tmp_path / "carried", None, scene, tmp_path / "out")
    check_film(tmp_path / "out", 0.8)
