"""Characters stand on the board, on a plane that the depth shows, or the floor, and say so."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.replays.readers.frames import PictureFrames
from motorcade.replays.recording import Recording, open_recording
from motorcade.replays.stages.placed import placed
from motorcade.replays.stages.smoothed import Smoothed
from motorcade.replays.textured_room import Scenario, handheld, scenario, write_recording
from motorcade.tracking import Checkerboard


@pytest.fixture(scope="module")
def looking_down(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A few frames on the spot, with floor, walls and boxes in view."""
    folder = tmp_path_factory.mktemp("room") / "room"
    write_recording(folder, scenario("loop", frames=4), name="room")
    return open_recording(folder)


def smoothed(recording: Recording, left: Motor | None = None) -> Smoothed:
    path = recording.truth
    assert path is not None
    return Smoothed({"motor": path if left is None else path.transformed_by(left=left)}, None)


def test_with_depth_and_no_board_it_stands_on_a_plane_that_was_found(
    looking_down: Recording,
) -> None:
    made = placed(looking_down, smoothed(looking_down))
    # The room's floor, and its box tops, are level.
    up = made.placement.world_T_character.rotor.apply([0.0, 0.0, 1.0])
    assert up[2] > 0.9999
    sole = made.placement.apply([0.0, 0.0, 0.0])
    assert sole[2] == pytest.approx(0.0, abs=0.005)
    assert "a plane of" in made.stands_on
    assert "up being the picture's" in made.stands_on


def test_the_plane_is_found_however_the_world_is_turned(
    looking_down: Recording, rng: np.random.Generator
) -> None:
    other_T_world = Motor.random(rng)
    upright = placed(looking_down, smoothed(looking_down)).placement
    turned = placed(looking_down, smoothed(looking_down, other_T_world)).placement
    wanted = other_T_world @ upright.world_T_character
    np.testing.assert_allclose(turned.world_T_character.as_matrix(), wanted.as_matrix(), atol=1e-9)
    assert turned.scale == pytest.approx(upright.scale)


def test_a_board_goes_before_the_plane_and_the_floor_can_be_asked_for(
    looking_down: Recording,
) -> None:
    board = Checkerboard(columns=7, rows=5, square_m=0.03)
    with_board = replace(looking_down, board=board)
    path = smoothed(looking_down)
    assert placed(with_board, path).stands_on == "the board"
    assert "a plane of" in placed(with_board, path, on="plane").stands_on
    floor = placed(with_board, path, on="floor", floor_m=0.25)
    assert floor.stands_on == "the world's z = 0.25 m"
    assert floor.placement.apply([0.0, 0.0, 0.0])[2] == pytest.approx(0.25)


def test_without_depth_it_stands_on_the_floor_and_a_plane_is_refused(
    looking_down: Recording, tmp_path: Path
) -> None:
    frames = looking_down.frames
    assert isinstance(frames, PictureFrames)
    blind = replace(looking_down, frames=replace(frames, depth_files=()))
    assert placed(blind, smoothed(blind)).stands_on == "the world's z = 0 m"
    covered = Scenario(handheld, 3, covered=(0, 3))
    write_recording(tmp_path / "covered", covered, name="room")
    unseen = open_recording(tmp_path / "covered")
    assert placed(unseen, smoothed(unseen)).stands_on == "the world's z = 0 m"
    with pytest.raises(ValueError, match=r"room: placed\.on=plane, but no plane"):
        placed(blind, smoothed(blind), on="plane")
    with pytest.raises(ValueError, match=r"room: placed\.on=board, but no board is known"):
        placed(blind, smoothed(blind), on="board")


def test_in_a_real_kitchen_it_stands_upright_on_the_table(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "7scenes_redkitchen")
    truth = recording.truth
    assert isinstance(truth, Trajectory)
    made = placed(recording, Smoothed({"motor": truth}, None))
    first = truth.motors[0].inverse() @ made.placement.world_T_character
    up = first.rotor.apply([0.0, 0.0, 1.0])
    # The table as frame 0 sees it: 0.66 m from the lens, tilted by 29 degrees.
    assert up @ [0.0, -1.0, 0.0] == pytest.approx(np.cos(np.deg2rad(29.0)), abs=0.03)
    assert -up @ first.translation_m == pytest.approx(0.66, abs=0.02)
    depth = recording.frames[0].depth_m()
    assert depth is not None
    assert recording.camera is not None
    column, row = np.rint(recording.camera.project(first.translation_m)).astype(int)
    assert first.translation_m[2] == pytest.approx(depth[row, column], abs=0.03)
