"""A figure put by taps where their rays meet the ground; a session that is a recording."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorcade.animation.authoring import read_scene
from motorcade.ga import Motor, Rotor
from motorcade.replays import Recording, open_recording
from motorcade.replays.live import LiveFrame, LivePose, LiveTracker
from motorcade.replays.live import tracker as live_tracker
from motorcade.replays.live.session import (
    LARGEST,
    LiveFigure,
    LivePlan,
    LiveRecorder,
    LiveSession,
    track_without_page,
)
from motorcade.replays.stages.camera.board_poses import board_poses
from tests.replays.live.drawn import BOARD, CAMERA, STEP_NS, frames, world_T_camera


def a_session(folder: Path | None = None) -> LiveSession:
    recorder = None if folder is None else LiveRecorder(folder)
    return LiveSession(LiveTracker(BOARD, CAMERA), LiveFigure("mannequin", 0.1), recorder)


def pixel_of(point: tuple[float, float], index: int, seed: int) -> list[float]:
    inside = world_T_camera(index, seed).inverse().apply([*point, 0.0])
    return CAMERA.project(inside).tolist()


def assert_replayed(recording: Recording, kept: Path) -> list[dict[str, Any]]:
    """A run's poses are the live ones that were measured, bit for bit; what was kept."""
    again = board_poses(recording).measurements.trajectory
    lines = [json.loads(line) for line in kept.read_text().splitlines()]
    measured = [line for line in lines if line.get("measured")]
    assert again.time_ns.tolist() == [line["time_ns"] for line in measured]
    same = np.concatenate([again.motors.translation_m, again.motors.rotor.as_quaternion()], axis=-1)
    assert np.array_equal(same, np.array([line["world_T_camera"] for line in measured]))
    return lines


def test_a_run_of_a_recorded_session_gives_its_poses_bit_for_bit(tmp_path: Path) -> None:
    folder, seed = tmp_path / "session", 21
    session = a_session(folder)
    for number, frame in enumerate(frames(8, seed)):
        session.take(frame, number)
    pixel = pixel_of((0.06, -0.05), 7, seed)
    session.gesture({"do": "stand", "frame": 7, "pixels": [pixel]})
    session.close()
    recording = open_recording(folder)
    assert recording.board == BOARD
    assert recording.settings == ("placed.scene=" + str(folder / "scene.json"),)
    lines = assert_replayed(recording, folder / "live.jsonl")
    assert [line["gesture"]["do"] for line in lines if "gesture" in line] == ["stand"]
    stood = read_scene(folder / "scene.json").pose("figure").as_similarity().translation_m
    assert np.linalg.norm(stood[:2] - [0.06, -0.05]) < 0.002


def test_taps_stand_move_turn_and_scale_the_figure() -> None:
    session, seed = a_session(), 4
    for number, frame in enumerate(frames(4, seed)):
        pose = session.take(frame, number)
    assert session.shown(pose)["figure"] is None
    tap = {"frame": 3, "pixels": [pixel_of((0.03, -0.04), 3, seed)]}
    session.gesture({"do": "stand", **tap})
    figure = session.figure
    assert np.linalg.norm(figure.position_m - [0.03, -0.04]) < 0.002
    eye = world_T_camera(3, seed).translation_m[:2] - figure.position_m
    facing = [np.cos(figure.heading_rad), np.sin(figure.heading_rad)]
    assert np.dot(facing, eye / np.linalg.norm(eye)) > 0.99, "it faces the camera"
    session.gesture({"do": "drag", "frame": 2, "pixels": [pixel_of((0.1, -0.1), 2, seed)]})
    assert np.linalg.norm(figure.position_m - [0.1, -0.1]) < 0.002
    before = figure.heading_rad
    session.gesture({"do": "turn", "by": 0.5})
    assert np.isclose(np.remainder(figure.heading_rad - before, 2 * np.pi), 0.5)
    for _ in range(9):
        session.gesture({"do": "resize", "by": 9.0})
    assert figure.scale == LARGEST


def test_it_walks_to_a_tapped_point_and_stays_there() -> None:
    session, seed = a_session(), 6
    for number, frame in enumerate(frames(3, seed)):
        session.take(frame, number)
    session.gesture({"do": "stand", "frame": 2, "pixels": [pixel_of((0.0, 0.0), 2, seed)]})
    session.gesture({"do": "walk", "frame": 2, "pixels": [pixel_of((0.12, -0.1), 2, seed)]})
    figure = session.figure
    at = [figure.state(0.07 + 0.1 * step) for step in range(70)]
    assert at[0]["motion"] == 1
    assert figure.joints(1) is not None
    assert figure.joints(9) is None
    steps = np.diff([state["pose"][:2] for state in at], axis=0)
    assert np.linalg.norm(steps, axis=-1).max() < 0.02
    assert at[-1]["motion"] == 0
    assert np.linalg.norm(np.array(at[-1]["pose"][:2]) - [0.12, -0.1]) < 0.002


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ({"do": "fly"}, "do: expected one of stand, walk"),
        ({"do": "stand", "frame": 99, "pixels": [[1, 1]]}, "frame: expected one that is on show"),
        ({"do": "stand", "frame": True, "pixels": [[1, 1]]}, "frame: expected one that is on show"),
        ({"do": "stand", "frame": 0, "pixels": []}, "pixels: expected one"),
        ({"do": "stand", "frame": 0, "pixels": [["a", 1]]}, "pixels: expected a number"),
        ({"do": "resize", "by": 1e6}, "by: expected a factor"),
        ({"do": "turn", "by": 1e300}, "by: expected a number"),
        ({"do": "turn"}, "by: expected a number"),
    ],
)
def test_gestures_that_are_none_are_refused(message: dict[str, object], said: str) -> None:
    session = a_session()
    session.take(next(iter(frames(1, 2))), 0)
    with pytest.raises(ValueError, match=said):
        session.gesture(message)


class TwoFloors:
    """SLAM that knows its poses, and points of a table 0.2 above a floor, in a frame of its own."""

    map_T_floor = Motor.from_twist([0.3, -0.2, 0.1, 0.5, -0.4, 0.2])
    table = np.array([[-0.4, 0.1], [0.4, 0.7]])
    number = 1

    def __init__(self, *_: object) -> None:
        rng = np.random.default_rng(3)
        floor = rng.uniform([-1.0, -1.0, 0.0], [1.0, 0.0, 0.0], (300, 3))
        table = rng.uniform([*self.table[0], 0.2], [*self.table[1], 0.2], (60, 3))
        both = np.concatenate([floor, table]) + rng.normal(0.0, 0.002, (360, 3))
        self.points = self.map_T_floor.apply(both)

    def snapshot(self) -> SimpleNamespace:
        return SimpleNamespace(points=self.points)

    def track(self, time_ns: int, _: object) -> SimpleNamespace:
        pose = self.map_T_floor @ self.floor_T_camera(time_ns / STEP_NS)
        return SimpleNamespace(world_T_camera=pose, state="tracking", map_number=self.number)

    @staticmethod
    def floor_T_camera(at: float) -> Motor:
        down = Rotor.from_rotation_vector([-0.75 * np.pi, 0.0, 0.0])
        return Motor.from_rotor_translation(down, [0.02 * at, -1.2, 1.2])

    def pixel(self, point: list[float], at: float) -> list[float]:
        return CAMERA.project(self.floor_T_camera(at).inverse().apply(point)).tolist()


def test_a_figure_stands_on_the_plane_that_is_tapped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_tracker, "VisualSlam", TwoFloors)
    slam = TwoFloors()
    session = LiveSession(LiveTracker("slam", CAMERA), LiveFigure("mannequin", 0.2))
    blank = np.zeros((CAMERA.height, CAMERA.width), np.uint8)

    def seen(number: int) -> LivePose:
        return session.take(LiveFrame(number * STEP_NS, blank), number)

    def stands_at(pose: LivePose) -> np.ndarray:
        feet = [*session.figure.position_m, 0.0]
        camera_point = pose.world_T_camera.inverse().apply(feet)
        return slam.floor_T_camera(pose.time_ns / STEP_NS).apply(camera_point)

    poses = [seen(number) for number in range(16)]
    assert "nothing flat" in poses[0].why
    assert poses[-1].state == "tracking"
    for tapped, act in (([0.1, -0.3, 0.0], "stand"), ([0.1, 0.3, 0.2], "walk")):
        number = len(poses)
        earlier = {"frame": number - 2, "pixels": [slam.pixel(tapped, number - 2)]}
        session.gesture({"do": act, **earlier})
        poses.append(seen(number))
        assert np.linalg.norm(stands_at(poses[-1]) - tapped) < 0.02, "on the plane that was tapped"
        assert abs(poses[-1].world_T_camera.translation_m[2] - (1.2 - tapped[2])) < 0.02
        assert poses[-1].state == "tracking"
    number = len(poses) - 3  # shown in the world before
    near = {"frame": number, "pixels": [slam.pixel([0.2, 0.4, 0.2], number)]}
    session.gesture({"do": "walk", **near})
    assert session.figure.state(session._time_s)["motion"] == 1, "on the same plane it walks"
    session.tracker._slam._slam.number = 2
    assert session.shown(seen(len(poses)))["figure"] is None, "where it stood is lost with its map"
    with pytest.raises(ValueError, match="frame: expected one that is on show"):
        session.gesture({"do": "stand", **near})
    near = {**near, "frame": len(poses)}
    session.tracker._slam._slam.points = np.full((90, 3), 5.0) + np.eye(3)[np.arange(90) % 3]
    with pytest.raises(ValueError, match="nothing flat is mapped there"):
        session.gesture({"do": "walk", **near})


def test_a_source_is_tracked_to_its_end_without_a_page(tmp_path: Path) -> None:
    session = a_session()
    figures = track_without_page(session, frames(5, 9))
    assert figures["frames"] >= 1
    assert set(figures["states"]) == {"tracking"}
    assert figures["registration_px"] < 0.3
    (tmp_path / "old.txt").write_text("kept")
    with pytest.raises(FileExistsError, match="expected an empty folder"):
        LiveRecorder(tmp_path)
    with pytest.raises(ValueError, match="expected what to track"):
        LivePlan().open()
