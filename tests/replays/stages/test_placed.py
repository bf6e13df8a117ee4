"""Characters stand on the board, on a plane that the depth shows, or the floor, and say so."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.animation import mannequin, skin, write_gltf
from motorcade.fusion.imu import ImuStream
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses, PoseOrigin
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.paths import SmoothedPaths
from motorcade.replays.stages.values.view import PlacedCharacter
from motorcade.replays.stages.view.acting import (
    character_named,
    clip_named,
    performers,
    walked,
)
from motorcade.replays.stages.view.ground import upward
from motorcade.replays.stages.view.overlay import overlay
from motorcade.replays.stages.view.placed import placed
from motorcade.tracking import Board, Checkerboard, MarkerGrid, PoseMeasurements
from motorcade.tracking.depth import DepthCamera
from tests.textured_room.paths import handheld
from tests.textured_room.recording import write_recording
from tests.textured_room.scenarios import Scenario, scenario


@pytest.fixture(scope="module")
def looking_down(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A few frames on the spot, with floor, walls and boxes in view."""
    folder = tmp_path_factory.mktemp("room") / "room"
    write_recording(folder, scenario("loop", frames=4), name="room")
    return open_recording(folder)


def drawn(recording: Recording, left: Motor | None = None) -> Integrity:
    path = recording.truth
    assert path is not None
    return Integrity((), {}, path if left is None else path.transformed_by(left=left), "smoothed")


def poses(path: Integrity, origin: PoseOrigin = "slam", **more: Any) -> CameraPoses:
    """The same path as the stage before would give it."""
    trajectory = path.drawn
    sure = np.tile(np.eye(6) * 1e-6, (len(trajectory), 1, 1))
    nothing = np.full(len(trajectory), np.nan)
    measured = PoseMeasurements(trajectory, sure)
    return CameraPoses(measured, trajectory.time_ns, nothing, origin, "as given", **more)


def stood(
    recording: Recording, path: Integrity, origin: PoseOrigin = "slam", **knobs: Any
) -> PlacedCharacter:
    """What the stage makes of a path that another source measured."""
    return placed(recording, poses(path, origin), path, **knobs)


def test_with_depth_and_no_board_it_stands_on_a_plane_that_was_found(
    looking_down: Recording,
) -> None:
    made = stood(looking_down, drawn(looking_down))
    # The room's floor, and its box tops, are level.
    up = made.placement.world_T_character.rotor.apply([0.0, 0.0, 1.0])
    assert up[2] > 0.9999
    sole = made.placement.apply([0.0, 0.0, 0.0])
    assert sole[2] == pytest.approx(0.0, abs=0.005)
    assert "a plane of" in made.stands_on
    assert "up being its normal" in made.stands_on


def test_the_plane_is_found_however_the_world_is_turned(
    looking_down: Recording, rng: np.random.Generator
) -> None:
    other_T_world = Motor.random(rng)
    upright = stood(looking_down, drawn(looking_down)).placement
    turned = stood(looking_down, drawn(looking_down, other_T_world)).placement
    wanted = other_T_world @ upright.world_T_character
    np.testing.assert_allclose(turned.world_T_character.as_matrix(), wanted.as_matrix(), atol=1e-9)
    assert turned.scale == pytest.approx(upright.scale)


def test_a_board_goes_before_the_plane_and_the_floor_can_be_asked_for(
    looking_down: Recording,
) -> None:
    board = Checkerboard(columns=7, rows=5, square_m=0.03)
    with_board = replace(looking_down, board=board)
    path = drawn(looking_down)
    assert stood(with_board, path, "board").stands_on == "the board"
    assert "a plane of" in stood(with_board, path, on="plane").stands_on
    floor = stood(with_board, path, on="floor", floor_m=0.25)
    assert floor.stands_on == "the world's z = 0.25 m"
    assert floor.placement.apply([0.0, 0.0, 0.0])[2] == pytest.approx(0.25)


def test_the_floor_is_chosen_against_gravity_where_an_imu_tells_it(
    looking_down: Recording, rng: np.random.Generator
) -> None:
    """A camera on its side: the image's up is a wall's, the accelerometer's is the floor's."""
    truth = looking_down.truth
    assert truth is not None
    rate_ns = 5_000_000
    stamps = np.arange(truth.time_ns[0], truth.time_ns[-1] + rate_ns, rate_ns)
    imu_T_camera = Motor.random(rng)
    world_T_imu = truth.motors_at(np.minimum(stamps, truth.time_ns[-1])) @ imu_T_camera.inverse()
    force = world_T_imu.inverse().rotor.apply(np.array([0.0, 0.0, 9.81]))
    noisy = force + 0.2 * rng.standard_normal(force.shape)
    with_imu = replace(
        looking_down, imu=ImuStream(stamps, np.zeros_like(force), noisy), imu_T_camera=imu_T_camera
    )
    other_T_world = Motor.random(rng)
    path = drawn(with_imu, other_T_world)
    found = upward(with_imu, poses(path), path.drawn)
    assert found is not None
    true_up = other_T_world.rotor.apply([0.0, 0.0, 1.0])
    assert found[0] @ true_up > np.cos(np.deg2rad(1.0))
    made = stood(with_imu, path)
    assert "up being against gravity" in made.stands_on
    assert made.placement.world_T_character.rotor.apply([0.0, 0.0, 1.0]) @ true_up > 0.999
    upright = stood(looking_down, drawn(looking_down), "simulated")
    assert "up being the world's" in upright.stands_on


def test_on_a_map_without_unit_the_size_follows_the_scene(
    looking_down: Recording, rng: np.random.Generator
) -> None:
    """A level plane 1.5 below a camera that looks ahead, in a world of any unit."""
    frames = looking_down.frames
    assert isinstance(frames, ImageFrames)
    blind = replace(looking_down, frames=replace(frames, depth_files=()))
    truth = looking_down.truth
    assert truth is not None
    path = Integrity((), {}, truth.transformed_by(left=truth.motors[0].inverse()), "smoothed")
    for unit in (0.01, 1.0, 100.0):
        ground = rng.uniform([-3.0, 1.5, 3.0], [3.0, 1.5, 9.0], (400, 3))
        points = unit * (ground + rng.normal(0.0, 0.003, ground.shape))
        given = poses(path, points=points, metric=False)
        made = placed(blind, given, path)
        assert "units found in the map, up being its normal" in made.stands_on
        assert made.doubt == ""
        assert made.placement.apply([0.0, 0.0, 0.0])[1] == pytest.approx(1.5 * unit, rel=0.01)
        up = made.placement.world_T_character.rotor.apply([0.0, 0.0, 1.0])
        assert up @ [0.0, -1.0, 0.0] > 0.999
        assert made.placement.scale * mannequin().height_m == pytest.approx(
            0.25 * 6.0 * unit, rel=0.1
        )
        level = placed(blind, given, path, on="floor")
        assert "a level at the foot of the map" in level.stands_on
        assert level.placement.apply([0.0, 0.0, 0.0])[1] == pytest.approx(1.5 * unit, rel=0.02)


def test_without_depth_it_stands_on_the_floor_and_a_plane_is_refused(
    looking_down: Recording, tmp_path: Path
) -> None:
    frames = looking_down.frames
    assert isinstance(frames, ImageFrames)
    blind = replace(looking_down, frames=replace(frames, depth_files=()))
    assert stood(blind, drawn(blind)).stands_on == "the world's z = 0 m"
    covered = Scenario(handheld, 3, covered=(0, 3))
    write_recording(tmp_path / "covered", covered, name="room")
    unseen = open_recording(tmp_path / "covered")
    assert stood(unseen, drawn(unseen)).stands_on == "the world's z = 0 m"
    with pytest.raises(ValueError, match=r"room: placed\.on=plane, but no plane"):
        stood(blind, drawn(blind), on="plane")
    with pytest.raises(ValueError, match=r"room: placed\.on=board, but no board is known"):
        stood(blind, drawn(blind), on="board")


def test_in_a_real_kitchen_it_stands_upright_on_the_table(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "7scenes_redkitchen")
    truth = recording.truth
    assert isinstance(truth, Trajectory)
    floor = stood(recording, Integrity((), {}, truth, "smoothed"))
    made = stood(recording, Integrity((), {}, truth, "smoothed"), floor=2)
    both = [one.placement.world_T_character.rotor.apply([0.0, 0.0, 1.0]) for one in (floor, made)]
    assert both[0] @ both[1] > np.cos(np.deg2rad(3.0))
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


def test_a_files_character_plays_its_own_clips_and_the_mannequins(
    looking_down: Recording, tmp_path: Path
) -> None:
    file = tmp_path / "figure.glb"
    figure = mannequin()
    write_gltf(file, figure, [figure.clip("wave")])
    made = stood(looking_down, drawn(looking_down), character=file, clip="wave")
    assert (made.character, made.clip) == (str(file), "wave")
    read = character_named(str(file))
    assert clip_named(read, "wave").duration_s == pytest.approx(figure.clip("wave").duration_s)
    lent = clip_named(read, "walk")  # which the file does not hold
    moved, own = (
        s.skeleton.world(c.at(0.3)).translation_m
        for s, c in ((read, lent), (figure, figure.clip("walk")))
    )
    shift = moved - own  # its soles are kept out of the ground, all of it as one
    np.testing.assert_allclose(shift[:, :2], 0.0, atol=1e-6)
    np.testing.assert_allclose(shift[:, 2], shift[0, 2], atol=1e-6)
    assert 0.0 <= shift[0, 2] < 0.005 * own[:, 2].max()
    assert stood(looking_down, drawn(looking_down), character=file).clip == "idle"


def test_along_a_path_it_walks_with_planted_feet_and_stays(looking_down: Recording) -> None:
    points = (0.0, 0.0, 0.3, 0.1, 0.5, 0.4)
    seen = drawn(looking_down)
    made = placed(looking_down, poses(seen), seen, path=points, height_m=0.3)
    assert made.clip == "walk"
    np.testing.assert_allclose(made.path_m, np.reshape(points, (3, 2)))
    figure = character_named("mannequin")
    walk = walked(
        figure, figure.clip("walk"), made.path_m, made.placement.scale, made.plane_T_character
    )
    assert isinstance(walk.poses, Motor)
    plane = made.placement.world_T_character @ made.plane_T_character.inverse()
    hips = figure.skeleton.world(walk.poses).translation_m[:, 0]
    in_plane = plane.inverse().apply(made.placement.apply(hips))
    ends = in_plane[[0, -1], :2]
    np.testing.assert_allclose(ends, [[0.0, 0.0], [0.5, 0.4]], atol=0.02)
    vertices = skin(figure, walk.poses[::10], "linear")[0]
    low = plane.inverse().apply(made.placement.apply(vertices))[..., 2].min(axis=1)
    assert np.abs(low).max() < 0.01 * 0.3
    later = walk.at(walk.time_s[-1] + 5.0)
    np.testing.assert_allclose(later.coefficients, walk.poses[-1].coefficients, atol=1e-12)


@pytest.mark.parametrize(
    ("board", "outline"),
    [
        # Over all squares, from the first inner corner; over all markers, from the first's corner.
        (
            Checkerboard(columns=7, rows=5, square_m=0.03),
            "-0.03 to 0.21 m in x and from -0.15 to 0.03",
        ),
        (MarkerGrid("tag36h11", 3, 2, 0.08, 0.02), "0 to 0.28 m in x and from -0.18 to 0"),
    ],
)
def test_a_path_off_the_board_is_told_with_the_boards_outline(
    looking_down: Recording, caplog: pytest.LogCaptureFixture, board: Board, outline: str
) -> None:
    seen = drawn(looking_down)
    with_board = replace(looking_down, board=board)
    height_m = 0.05
    on = (0.02, -0.14, 0.2, -0.01)
    placed(with_board, poses(seen, "board"), seen, path=on, height_m=height_m)
    # On a floor nothing is known to end.
    beyond = (0.02, 0.05, 0.2, 0.12)
    placed(looking_down, poses(seen), seen, path=beyond, on="floor", height_m=height_m)
    assert not caplog.records
    placed(with_board, poses(seen, "board"), seen, path=(*on, 0.2, 0.12), height_m=height_m)
    (told,) = caplog.messages
    assert "1 of 3 points lie off the board, the first at x, y = 0.2, 0.12 m" in told
    assert f"from {outline} m in y" in told


@pytest.mark.parametrize(
    ("knobs", "message"),
    [
        ({"character": Path("nobody.glb")}, r"placed\.character: expected 'mannequin' or a file"),
        ({"clip": "swim"}, r"placed\.clip: no clip 'swim'; known here: idle, walk"),
        ({"path": (0.0, 0.0, 1.0)}, r"placed\.path: expected x,y of two points or more"),
        ({"path": (0.0, 0.0, 0.0, 0.0)}, r"placed\.path: .* neighbours apart"),
        ({"path": (0.0, 0.0, 1.0, 0.0), "position_m": (0.0, 0.0)}, r"placed\.position_m"),
        ({"path": (0.0, 0.0, 1.0, 0.0), "clip": "wave"}, r"placed\.path: 'wave' is no walk"),
    ],
)
def test_refusals_name_the_knob(
    looking_down: Recording, knobs: dict[str, Any], message: str
) -> None:
    seen = drawn(looking_down)
    with pytest.raises(ValueError, match=message):
        placed(looking_down, poses(seen), seen, **knobs)


def test_a_file_that_is_no_character_is_refused_by_the_knobs_name(tmp_path: Path) -> None:
    broken = tmp_path / "broken.glb"
    broken.write_bytes(b"no glTF")
    with pytest.raises(ValueError, match=r"placed\.character: .*broken\.glb"):
        character_named(str(broken))


def test_depth_is_seen_as_the_poses_were_found_with_it(
    looking_down: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A depth camera that the recording states half a metre aside, and that SLAM found to be none.

    The character stands, and is hidden, by the depth that the poses were tracked with.
    """
    frames, camera = looking_down.frames, looking_down.camera
    assert isinstance(frames, ImageFrames)
    assert camera is not None
    aside = DepthCamera(camera, Motor.from_translation([0.5, 0.0, 0.0]))
    stated = replace(frames, depth_camera=aside, colour_camera=camera)
    told_wrong, path = replace(looking_down, frames=stated), drawn(looking_down)
    right = stood(looking_down, path).placement.world_T_character.as_matrix()
    wrong = stood(told_wrong, path).placement.world_T_character.as_matrix()
    given = poses(path, depth_camera=DepthCamera(camera))
    found = placed(told_wrong, given, path)
    assert np.abs(wrong - right).max() > 0.05
    np.testing.assert_allclose(found.placement.world_T_character.as_matrix(), right, atol=1e-3)
    hiding: list[np.ndarray] = []
    monkeypatch.setattr(
        "motorcade.replays.stages.view.overlay.render_performers",
        lambda images, *_, **__: hiding.extend(depth_m for _, _, depth_m, *_ in images),
    )
    monkeypatch.setattr("motorcade.replays.stages.view.overlay.write_video", lambda *_: None)
    overlay(told_wrong, given, SmoothedPaths({"motor": path.drawn}, None, {}), path, found)
    np.testing.assert_allclose(hiding[0], frames[0].depth_m(), atol=1e-6)


def test_another_candidate_is_taken_by_its_number(
    looking_down: Recording, rng: np.random.Generator
) -> None:
    """A board that lies where it is seen, and what else there is to stand on."""
    board = Checkerboard(columns=7, rows=5, square_m=0.03)
    with_board = replace(looking_down, board=board)
    path = drawn(looking_down)
    best = stood(with_board, path, "board")
    other = stood(with_board, path, "board", floor=2)
    names = [one.name for one in best.choices]
    assert (best.stands_on, other.stands_on) == (names[0], names[1])
    assert all(one.corners_m.shape[1] == 3 for one in best.choices)
    told = rf"placed\.floor: expected 1 to {len(names)}, got 99 \(1: "
    with pytest.raises(ValueError, match=told):
        stood(with_board, path, "board", floor=99)
    with pytest.raises(ValueError, match=r"placed\.floor: expected 1 on, got -1"):
        stood(with_board, path, "board", floor=-1)


@pytest.mark.parametrize(("above_deg", "looks_up"), [(25.0, False), (55.0, True), (82.0, True)])
def test_steeply_from_above_it_lifts_its_head_to_the_camera(
    looking_down: Recording, above_deg: float, looks_up: bool, rng: np.random.Generator
) -> None:
    """A camera that looks at a board's middle from any side; from nearly above that is said."""
    with_board = replace(looking_down, board=Checkerboard(columns=7, rows=5, square_m=0.03))
    truth = looking_down.truth
    assert truth is not None
    round_rad, above_rad = rng.uniform(0.0, 2.0 * np.pi), np.deg2rad(above_deg)
    away = np.array([np.cos(round_rad), np.sin(round_rad), np.tan(above_rad)]) * np.cos(above_rad)
    aim = np.array([0.09, -0.06, 0.0])
    side = np.cross(-away, [0.0, 0.0, 1.0]) / np.cos(above_rad)
    axes = np.stack([side, np.cross(-away, side), -away], axis=-1)
    eye = Motor.from_rotor_translation(Rotor.from_matrix(axes), aim + 0.6 * away)
    path = drawn(looking_down, eye @ truth.motors[0].inverse())
    made = stood(with_board, path, "board")
    assert (made.looks_at_m is not None) == looks_up
    assert ("nearly straight above" in made.doubt) == (above_deg > 70.0)
    [shown], [still] = performers(made), performers(replace(made, looks_at_m=None))
    head = shown.character.skeleton.index("head")
    faces = [
        made.placement.world_T_character.rotor.apply(
            one.character.skeleton.world(one.clip.poses)[:, head].rotor.apply([1.0, 0.0, 0.0])
        )
        for one in (shown, still)
    ]
    lifted_deg = np.rad2deg(np.median(np.arcsin(faces[0][:, 2]) - np.arcsin(faces[1][:, 2])))
    assert lifted_deg > 30.0 if looks_up else lifted_deg == 0.0
