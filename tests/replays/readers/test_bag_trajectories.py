"""Trajectories of bags: as they were written, as evo reads them, frames as tf2 joins them."""

from __future__ import annotations

import bz2
import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evo.tools import file_interface
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from scipy.spatial.transform import Rotation, Slerp

from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.ros import trajectories
from motorcade.replays.io.readers.ros import trajectories as bag_trajectories
from motorcade.replays.io.readers.ros.admission import message_types
from motorcade.replays.io.readers.ros.trajectories import list_bag_trajectories
from motorcade.replays.io.readers.tagslam.recording import read_reference
from motorcade.replays.io.trajectories import read_trajectory
from tests.replays.readers.bag_poses import KINDS, Messages, write_messages

START_NS = 1_700_000_000_123_456_789
POSE_TYPES = tuple(bag_trajectories._POSES)
MOVING = "geometry_msgs/msg/TransformStamped"


def numbers(rng: np.random.Generator, count: int) -> np.ndarray:
    """Positions and quaternions wxyz ``(count, 7)``."""
    wxyz = rng.standard_normal((count, 4))
    wxyz /= np.linalg.norm(wxyz, axis=1, keepdims=True)
    return np.concatenate([rng.standard_normal((count, 3)), wxyz], axis=1)


def stamps(count: int, step_ns: int = 50_000_000, start_ns: int = START_NS) -> list[int]:
    return [start_ns + step_ns * index for index in range(count)]


def assert_poses(path: Trajectory, time_ns: Any, wanted: np.ndarray) -> None:
    np.testing.assert_array_equal(path.time_ns, time_ns)
    poses = Motor.from_quaternion_translation(wanted[:, 3:], wanted[:, :3])
    np.testing.assert_allclose(path.motors.as_matrix(), poses.as_matrix(), atol=1e-12)


def said(problem: str, named: Any) -> None:
    with pytest.raises(RecordingError, match=problem) as caught:
        read_trajectory(named)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", KINDS)
def test_every_type_of_pose_comes_back(kind: str, tmp_path: Path) -> None:
    made, every = Messages(ros1=kind == "bag"), numbers(np.random.default_rng(1), 5)
    sent = [
        (f"/{name.rpartition('/')[2]}", stamp + 9, made.pose(name, stamp, row, ("/odom", "body")))
        for stamp, row in zip(stamps(5), every, strict=True)
        for name in POSE_TYPES
    ]
    bag = write_messages(tmp_path, kind, sent)
    still = np.concatenate([every[:, :3], np.tile([1.0, 0.0, 0.0, 0.0], (5, 1))], axis=1)
    for name in POSE_TYPES:
        short = name.rpartition("/")[2]
        path = read_trajectory(f"{bag}:/{short}")
        assert_poses(path, stamps(5), still if short == "PointStamped" else every)
        child = "body" if short in ("TransformStamped", "Odometry") else "camera"
        assert (path.parent, path.child) == ("odom", child)
        without_slash = read_trajectory(Path(f"{bag}:{short}"), parent="map", child="imu")
        assert (without_slash.parent, without_slash.child) == ("map", "imu")
    found = list_bag_trajectories(bag)
    assert found.topics["/Odometry"] == ("nav_msgs/msg/Odometry", 5)
    assert len(found.topics) == len(POSE_TYPES)


def test_a_packed_bag_is_read_and_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, every = Messages(ros1=True), numbers(np.random.default_rng(1), 3)
    rows = zip(stamps(3), every, strict=True)
    sent = [("p", at, made.pose(POSE_TYPES[0], at, row, ("a", ""))) for at, row in rows]
    bag = write_messages(tmp_path, "bag", sent)
    packed = tmp_path / "flight.bag.bz2"
    packed.write_bytes(bz2.compress(bag.read_bytes()))
    (tmp_path / "unpacked").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "unpacked"))
    assert_poses(read_trajectory(f"{packed}:p"), stamps(3), every)
    said("expected a topic of poses or two frames, got 'q'", f"{packed}:q")
    packed.write_bytes(bz2.compress(b"no bag"))
    said("expected a whole ROS bag", f"{packed}:p")
    assert not list((tmp_path / "unpacked").iterdir())


def test_stamps_out_of_order_are_sorted_and_repeated_ones_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made, every = Messages(ros1=False), numbers(np.random.default_rng(1), 4)
    given = [START_NS, START_NS + 20, START_NS + 10, START_NS + 20]
    sent = [
        ("/p", START_NS + index, made.pose(POSE_TYPES[0], stamp, row, ("a", "")))
        for index, (stamp, row) in enumerate(zip(given, every, strict=True))
    ]
    bag = write_messages(tmp_path, "mcap", sent)
    with caplog.at_level(logging.WARNING):
        path = read_trajectory(f"{bag}:/p")
    assert_poses(path, [START_NS, START_NS + 10, START_NS + 20], every[[0, 2, 1]])
    assert "stamps go back 1 times" in caplog.text
    assert "1 poses have the stamp of another" in caplog.text


def tree_of_frames(tmp_path: Path, kind: str) -> tuple[Path, np.ndarray, np.ndarray, np.ndarray]:
    """Frames: map -> odom (slow) -> base (fast) -> camera (static); base -> lidar (static)."""
    made, rng = Messages(ros1=kind == "bag"), np.random.default_rng(7)
    slow, fast, static = numbers(rng, 6), numbers(rng, 40), numbers(rng, 2)
    sent: list[tuple[str, int, Any]] = []
    for at, row in zip(stamps(6, 300_000_000, START_NS - 100), slow, strict=True):
        one = made.pose(MOVING, at, row, ("/map", "odom"))
        sent.append(("/tf", at, made.transforms(one)))
    for at, row in zip(stamps(40, 40_000_000), fast, strict=True):
        one = made.pose(MOVING, at, row, ("odom", "/base"))
        again = made.pose(MOVING, at, fast[0], ("odom", "base"))
        sent.append(("/tf", at, made.transforms(one, again)))
    links = [("base", "camera_link"), ("base", "lidar")]
    still = [
        made.pose(MOVING, START_NS, row, link) for row, link in zip(static, links, strict=True)
    ]
    sent.append(("/tf_static", START_NS, made.transforms(*still)))
    sent.sort(key=lambda one: one[1])
    return write_messages(tmp_path, kind, sent), slow, fast, static


def looked_up(time_ns: Any, rows: np.ndarray, wanted: Any) -> np.ndarray:
    """Matrices as tf2 interpolates: positions linearly, rotations by slerp."""
    at = (np.asarray(time_ns) - START_NS) * 1e-9
    there = (np.asarray(wanted) - START_NS) * 1e-9
    poses = np.tile(np.eye(4), (len(there), 1, 1))
    turns = Rotation.from_quat(rows[:, [4, 5, 6, 3]])
    poses[:, :3, :3] = Slerp(at, turns)(np.clip(there, at[0], at[-1])).as_matrix()
    poses[:, :3, 3] = np.stack([np.interp(there, at, rows[:, i]) for i in range(3)], axis=1)
    return poses


@pytest.mark.parametrize("kind", KINDS)
def test_frames_are_joined_as_tf2_joins_them(kind: str, tmp_path: Path) -> None:
    bag, slow, fast, static = tree_of_frames(tmp_path, kind)
    slow_ns, fast_ns = stamps(6, 300_000_000, START_NS - 100), stamps(40, 40_000_000)
    wanted = [at for at in fast_ns if at <= slow_ns[-1]]
    camera, lidar = (
        looked_up([START_NS, START_NS + 1], static[[i, i]], [START_NS]) for i in (0, 1)
    )
    base = looked_up(slow_ns, slow, wanted) @ looked_up(fast_ns, fast, wanted)
    for name in (
        "map/camera_link",
        "/map/camera_link",
        "/tf:map.camera_link",
        "/tf:/map//camera_link",
    ):
        path = read_trajectory(f"{bag}:{name}")
        assert (path.parent, path.child) == ("map", "camera_link")
        np.testing.assert_array_equal(path.time_ns, wanted)
        np.testing.assert_allclose(path.motors.as_matrix(), base @ camera, atol=1e-7)
    back = read_trajectory(f"{bag}:camera_link/map")
    np.testing.assert_allclose(back.motors.as_matrix(), np.linalg.inv(base @ camera), atol=1e-7)
    still = read_trajectory(f"{bag}:lidar/camera_link")
    assert still.time_ns.tolist() == [0]
    np.testing.assert_allclose(still.motors.as_matrix(), np.linalg.inv(lidar) @ camera, atol=1e-12)
    assert list_bag_trajectories(bag).links[0] == ("map", "odom")


def test_frames_that_do_not_join_are_refused(tmp_path: Path) -> None:
    made, rows = Messages(ros1=False), numbers(np.random.default_rng(1), 9)
    links = [("a", "b"), ("c", "d"), ("x", "y"), ("z", "y"), ("l", "m"), ("m", "l"), ("a", "late")]
    sent = [
        ("/tf", START_NS + i, made.transforms(made.pose(MOVING, START_NS + i, rows[i], link)))
        for i, link in enumerate(links)
    ]
    bag = write_messages(tmp_path, "mcap", sent)
    said("expected transforms that join them, got none up to 'a' and 'c'", f"{bag}:b/d")
    said("expected one parent of 'y', got 'x' and 'z'", f"{bag}:x/y")
    said("expected a tree of at most 100 levels", f"{bag}:l/m")
    said("expected transforms of one time, got those of 'late' from", f"{bag}:b/late")
    said("got 'b/none'; name one of them as .*:NAME: 'a/b', 'c/d'", f"{bag}:b/none")
    said("got no name; name one of them", bag)
    said("expected one of '/tf', got '/other'", f"{bag}:/other:a/b")


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda row, at: (row * np.repeat([1.0, 0.0], [3, 4]), at), "unit quaternion.* norm 0"),
        (lambda row, at: (row * np.nan, at), "pose 2: expected a position within"),
        (lambda row, at: (row * np.repeat([1e20, 1.0], [3, 4]), at), "expected a position within"),
        (lambda row, at: (row, 0), "stamps go back"),
    ],
)
def test_poses_that_are_none_are_refused(
    tmp_path: Path, change: Any, problem: str, caplog: pytest.LogCaptureFixture
) -> None:
    made, rows = Messages(ros1=True), numbers(np.random.default_rng(1), 4)
    sent = []
    for index, (at, row) in enumerate(zip(stamps(4), rows, strict=True)):
        numbers_, stamp = change(row, at) if index == 2 else (row, at)
        sent.append(("/p", at, made.pose(POSE_TYPES[0], stamp, numbers_, ("a", ""))))
    bag = write_messages(tmp_path, "bag", sent)
    if problem == "stamps go back":  # a stamp of 0 among others is a stamp
        assert read_trajectory(f"{bag}:/p").time_ns[0] == 0
        assert problem in caplog.text
    else:
        said(problem, f"{bag}:/p")


def test_what_else_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made, rows = Messages(ros1=True), numbers(np.random.default_rng(1), 4)
    odometry = "nav_msgs/msg/Odometry"
    sent = [
        ("/unstamped", at, made.pose(POSE_TYPES[0], 0, row, ("a", "")))
        for at, row in zip(stamps(4), rows, strict=True)
    ]
    for at, row, frame in zip(stamps(2), rows[:2], ("a", "b"), strict=True):
        sent.append(("/changing", at, made.pose(odometry, at, row, (frame, "body"))))
    bag = write_messages(tmp_path, "bag", sent)
    said("expected the stamps of headers, got 0 in every one", f"{bag}:/unstamped")
    said("pose 1: expected poses 'a_T_body' throughout, got 'b_T_body'", f"{bag}:/changing")
    said("the file is missing", f"{tmp_path}/none.bag:/p")
    with pytest.raises(ValueError, match=r"only KITTI files lack stamps; .* is read as a bag"):
        read_trajectory(f"{bag}:/changing", rate_hz=30.0)
    monkeypatch.setattr(bag_trajectories, "_MOST_POSES", 3)
    said("expected at most 3 poses", f"{bag}:/unstamped")


def test_frames_without_number_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bag, *_ = tree_of_frames(tmp_path, "mcap")
    monkeypatch.setattr(trajectories, "_MOST_LINKS", 3)
    said("expected at most 3 pairs of frames", f"{bag}:map/base")
    monkeypatch.setattr(trajectories, "_MOST_TRANSFORMS", 3)
    said("expected at most 3 transforms", f"{bag}:map/base")


def test_a_file_of_that_name_is_a_file(tmp_path: Path) -> None:
    path = tmp_path / "flight.bag:odom"
    path.write_text("0 1 2 3 0 0 0 1\n")
    assert read_trajectory(path).motors.translation_m.tolist() == [[1.0, 2.0, 3.0]]


@pytest.mark.parametrize("name", ["ROS_example.bag", "nav2_turtlebot.mcap"])
def test_real_topics_are_what_evo_reads(name: str, data_dir: Path) -> None:
    bag = data_dir / "replays" / "bags" / name
    topics = list_bag_trajectories(bag).topics
    assert len(topics) >= 2
    with (Reader1 if name.endswith(".bag") else Reader2)(bag) as reader:
        assert file_interface.get_supported_topics(reader) == sorted(topics)
        for topic in topics:
            theirs = file_interface.read_bag_trajectory(reader, topic)
            ours = read_trajectory(f"{bag}:{topic}")
            np.testing.assert_allclose(1e-9 * ours.time_ns, theirs.timestamps, atol=1e-6, rtol=0)
            np.testing.assert_allclose(
                ours.motors.as_matrix(), np.array(theirs.poses_se3), atol=1e-9
            )


@pytest.mark.parametrize(
    ("name", "chain"),
    [
        ("nav2_turtlebot.mcap", ("map", "odom", "base_link", "base_footprint")),
        ("tf_example.bag", ("odom", "base_footprint", "base_link")),
        ("tf_example", ("odom", "base_footprint", "base_link")),
    ],
)
def test_real_frames_are_joined_as_tf2_joins_them(
    name: str, chain: tuple[str, ...], data_dir: Path
) -> None:
    bag = data_dir / "replays" / "bags" / name
    path = read_trajectory(f"{bag}:{chain[0]}/{chain[-1]}")
    assert len(path) > 400
    rows: dict[str, dict[int, list[float]]] = {child: {} for child in chain[1:]}
    store = message_types(ros1=name.endswith(".bag"))
    take = store.deserialize_ros1 if name.endswith(".bag") else store.deserialize_cdr
    with (Reader1 if name.endswith(".bag") else Reader2)(bag) as reader:
        wanted = [one for one in reader.connections if one.topic in ("/tf", "/tf_static")]
        for connection, _, raw in reader.messages(wanted):
            for one in take(raw, connection.msgtype).transforms:  # type: ignore[attr-defined]
                if one.child_frame_id in rows:
                    t, q, at = one.transform.translation, one.transform.rotation, one.header.stamp
                    stamp = at.sec * 10**9 + at.nanosec
                    numbers_ = [t.x, t.y, t.z, q.w, q.x, q.y, q.z]
                    rows[one.child_frame_id].setdefault(stamp, numbers_)
    expected = np.tile(np.eye(4), (len(path), 1, 1))
    for child in chain[1:]:
        at = sorted(rows[child])
        every = np.array([rows[child][stamp] for stamp in at])
        if len(at) == 1:
            at, every = [START_NS, START_NS + 1], every[[0, 0]]
            expected = expected @ looked_up(at, every, [START_NS])
            continue
        expected = expected @ looked_up(at, every, path.time_ns)
    np.testing.assert_allclose(path.motors.as_matrix(), expected, atol=1e-6)


def test_tagslams_own_bags_are_read(data_dir: Path) -> None:
    folder = data_dir / "tags" / "tagslam" / "test_21"
    reference = read_reference(folder)
    path = read_trajectory(f"{folder / 'reference.bag.bz2'}:/tagslam/odom/body_rig")
    np.testing.assert_array_equal(path.time_ns, reference.time_ns)
    expected = reference.odometry.motors.as_matrix()
    np.testing.assert_allclose(path.motors.as_matrix(), expected, atol=1e-12)
    odometry = read_trajectory(f"{folder / 'tag_detections.bag.bz2'}:/vio_node/odom")
    beside = read_trajectory(folder / "vio.tum")
    np.testing.assert_allclose(
        odometry.motors_at(beside.time_ns[5:50]).translation_m,
        beside.motors.translation_m[5:50],
        atol=1e-3,
    )
    camera = read_trajectory(f"{folder / 'reference.bag.bz2'}:map/cam0")
    known = [row for row in reference.world_T_frame if "cam0" in row]
    assert len(camera) >= len(known) > 400
    expected = Motor.stack([row["cam0"] for row in known]).as_matrix()
    np.testing.assert_allclose(
        camera[np.isin(camera.time_ns, reference.time_ns)].motors.as_matrix(), expected, atol=1e-9
    )
