"""Scenes put together on the page: the film and a file of glTF have all where the page had it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.pipeline.runs import open_run
from tests.end_to_end.pages.authored_scene import NAMES, Authored, authored
from tests.end_to_end.pages.conftest import Browser
from tests.replays.carried_marker import ID, write_carried
from tests.replays.scenes.test_scene_export import Assimp
from tests.replays.scenes.test_scene_recordings import check_film, write_board

pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group("pages"),
    pytest.mark.usefixtures("opengl"),
]


def check_places(made: Authored) -> None:
    """In the run that drew the film, and in the file as another program reads it."""
    shown = open_run(made.film)
    stamps = shown.recording.frames.time_ns
    inside = (stamps >= shown.path.time_ns[0]) & (stamps <= shown.path.time_ns[-1])
    assert set(shown.cast) == set(NAMES)
    for name, one in shown.cast.items():
        placed = one.world_T_character(stamps[inside]).as_matrix()[:, :3, 3]
        np.testing.assert_allclose(placed, made.world_m[name][inside], atol=1e-5)
    if shutil.which("assimp") is None:
        pytest.skip("assimp is not installed")
    upright = Motor.from_quaternion_translation([0.5, -0.5, -0.5, -0.5], [0.0, 0.0, 0.0])
    read = Assimp(made.gltf)
    for name in NAMES:
        time_s, found = read.keys(f"{name} path")
        # Of a walk there are keys between frames, which the page does not tell.
        away_s = np.abs(time_s[:, None] - 1e-9 * (stamps[inside] - stamps[inside][0]))
        kept = away_s.min(axis=1) < 1e-5
        assert kept.sum() > 1
        wanted = upright.apply(made.world_m[name][inside][away_s.argmin(axis=1)[kept]])
        np.testing.assert_allclose(found[kept, :3, 3], wanted, atol=1e-5)
    walked, rolled = (np.ptp(made.world_m[name], axis=0).max() for name in ("Person", "ball"))
    assert min(walked, rolled) > 0.01


def test_a_scene_on_the_board(browser: Browser, data_dir: Path, tmp_path: Path) -> None:
    recording, manifest = write_board(data_dir, tmp_path)
    made = authored(browser, recording, manifest, tmp_path, None)
    check_places(made)
    check_film(made.film, 0.8)


def test_a_scene_on_a_marker_that_moves(browser: Browser, tmp_path: Path) -> None:
    write_carried(tmp_path / "recording")
    made = authored(browser, tmp_path / "recording", None, tmp_path, f"Marker {ID}")
    check_places(made)
    check_film(made.film, 0.8)
