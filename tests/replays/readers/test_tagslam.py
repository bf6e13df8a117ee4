"""TagSLAM's recordings: corners in the house's order, sizes, hostile files, and what follows."""

import bz2
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from evo.core import metrics, sync
from evo.core.trajectory import PoseTrajectory3D
from rosbags.rosbag1 import Writer

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.ros import admission as ros_bag
from motorcade.replays.io.readers.ros.admission import message_types
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.replays.io.readers.tagslam.recording import read_reference
from motorcade.replays.io.readers.tagslam.scene import read_scene
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.mapping import map_markers
from tests.bench.tracking.tag_flips import bench_flips, count_flips, reference_rotors
from tests.bench.tracking.tag_map import reference_path

TAGS = "apriltag_msgs/msg/ApriltagArrayStamped"
CAMERAS = """
cam0:
  camera_model: pinhole
  intrinsics: [400.0, 401.0, 320.0, 240.0]
  distortion_model: radtan
  distortion_coeffs: [0, 0, 0, 0]
  resolution: [640, 480]
  tagtopic: /tags
"""
POSES = """
cam0:
  pose:
    position: {x: 0.1, y: 0.2, z: 0.3}
    rotation: {x: 0.0, y: 0.0, z: 1.0}
"""
BODIES = """
default_body: lab
bodies:
 - lab:
     type: simple
     default_tag_size: 0.5
     tags:
       - id: 1
         size: 0.2
       - id: 2
 - wall:
     type: staggered_board
     staggered_board: {tag_start_id: 10, tag_size: 0.05, tag_rows: 3, tag_columns: 3}
 - door:
     type: board
     board: {tag_start_id: 20, tag_size: 0.07, tag_rows: 2, tag_columns: 2}
"""
CORNERS = [(10.0, 40.0), (40.0, 40.0), (40.0, 10.0), (10.0, 10.0)]  # as recorded: bottom left first


def packed_bag(messages, corners=CORNERS, chunks=None) -> bytes:
    """A bag with one message a list of ids; stamps 1 s, 2 s, ...; chunks compressed where named."""
    import tempfile

    store = message_types(ros1=True)
    types = store.types
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "new.bag"
        writer = Writer(path)
        if chunks is not None:
            writer.set_compression(Writer.CompressionFormat[chunks])
        with writer as bag:
            link = bag.add_connection("/tags", TAGS, typestore=store)
            for second, ids in messages:
                stamp = types["builtin_interfaces/msg/Time"](sec=second, nanosec=5)
                header = types["std_msgs/msg/Header"](seq=0, stamp=stamp, frame_id="")
                point = types["geometry_msgs/msg/Point"]
                tags = [
                    types["apriltag_msgs/msg/Apriltag"](
                        id=one,
                        family="",
                        hamming=0,
                        border=1,
                        bits=6,
                        center=point(x=0.0, y=0.0, z=0.0),
                        corners=[point(x=x, y=y, z=0.0) for x, y in corners],
                    )
                    for one in ids
                ]
                message = types[TAGS](header=header, apriltags=tags)
                bag.write(link, second * 10**9, store.serialize_ros1(message, TAGS))
        return bz2.compress(path.read_bytes())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    tmp_path = tmp_path / "own"
    tmp_path.mkdir()
    (tmp_path / "cameras.yaml").write_text(CAMERAS)
    (tmp_path / "camera_poses.yaml").write_text(POSES)
    (tmp_path / "tagslam.yaml").write_text(BODIES)
    bag = packed_bag([(2, [10, 1]), (1, [2]), (3, [])])
    (tmp_path / "tag_detections.bag.bz2").write_bytes(bag)
    return tmp_path


def test_corners_run_clockwise_from_the_printed_top_left(folder: Path) -> None:
    found = tagslam.read_corners(folder)
    stream = found.streams["cam0"]
    np.testing.assert_array_equal(stream.time_ns, np.arange(1, 4) * 10**9 + 5)
    np.testing.assert_array_equal(stream.frame, [0, 1, 1])
    np.testing.assert_array_equal(stream.marker_ids, [2, 1, 10])
    np.testing.assert_array_equal(stream.corners_px[0], CORNERS[::-1])
    assert stream.camera == Camera(640, 480, 400.0, 401.0, 320.0, 240.0, "radtan", (0, 0, 0, 0))
    assert found.side_m == {1: 0.2, 2: 0.5, 10: 0.05}
    expected = Motor.from_rotor_translation(
        Rotor.from_rotation_vector([0.0, 0.0, 1.0]), [0.1, 0.2, 0.3]
    )
    np.testing.assert_array_equal(found.rig_T_camera["cam0"].coefficients, expected.coefficients)


@pytest.mark.parametrize("chunks", ["BZ2", "LZ4"])
def test_compressed_chunks_are_read(folder: Path, chunks: str) -> None:
    plain = tagslam.read_corners(folder).streams["cam0"]
    bag = packed_bag([(2, [10, 1]), (1, [2]), (3, [])], chunks=chunks)
    (folder / "tag_detections.bag.bz2").write_bytes(bag)
    found = tagslam.read_corners(folder).streams["cam0"]
    np.testing.assert_array_equal(found.marker_ids, plain.marker_ids)
    np.testing.assert_array_equal(found.corners_px, plain.corners_px)


def test_a_link_that_a_checkout_left_as_text_is_followed_beside_the_folder(folder: Path) -> None:
    beside = folder.parent / "beside"
    beside.mkdir()
    (folder / "tag_detections.bag.bz2").rename(beside / "tag_detections.bag.bz2")
    link = folder / "tag_detections.bag"
    link.write_text("../beside/tag_detections.bag")
    assert len(tagslam.read_corners(folder).streams["cam0"]) == 3
    for elsewhere in ("../../beside/tag_detections.bag", "../other/tag_detections.bag"):
        link.write_text(elsewhere)
        with pytest.raises(RecordingError, match="beside this folder"):
            tagslam.read_corners(folder)


def test_ids_change_over_time_as_stated(folder: Path) -> None:
    (folder / "tagslam.yaml").write_text(
        BODIES
        + """
tag_id_remap:
 - id: 10
   remaps:
    - {remap_id: 13, start_time: 1.5, end_time: 2.5}
    - {remap_id: 14, start_time: 2.6, end_time: 9.0}
"""
    )
    stream = tagslam.read_corners(folder).streams["cam0"]
    np.testing.assert_array_equal(stream.marker_ids, [2, 1, 13])


def test_poses_and_noise_are_read_as_they_are_stated(folder: Path) -> None:
    (folder / "tagslam.yaml").write_text(
        """
bodies:
 - wall:
     is_static: true
     type: staggered_board
     staggered_board:
       {tag_start_id: 10, tag_size: 0.05, tag_spacing: 1.0, tag_rows: 3, tag_columns: 3,
        tag_rotation_noise: 0.002, tag_position_noise: 0.001}
     pose:
       position: {x: 1, y: 2, z: 3}
       rotation: {x: 0, y: 0, z: 0.5}
       position_noise: {x: 0.1, y: 0.2, z: 0.3}
       rotation_noise: {x: 0.01, y: 0.02, z: 0.03}
 - wand:
     is_static: false
     type: simple
     fake_odom_translation_noise: 0.2
     fake_odom_rotation_noise: 0.1
     tags: [{id: 2, size: 0.2, pose: {position: {x: 0, y: 0, z: 1}, rotation: {x: 0, y: 0, z: 0}}}]
distance_measurements:
 - a: {tag1: 10, tag2: 13, corner1: 0, corner2: 3, distance: 0.5, noise: 0.01}
plane_measurements:
 - b: {tags: [10], distance: 0.7, noise: 0.02, direction: [0, 0, 1]}
"""
    )
    scene = tagslam.read_corners(folder).scene
    wall, wand, rig = scene.bodies
    assert (wall.moves, wand.moves, rig.moves, rig.name) == (False, True, True, "rig")
    assert wall.stated is not None
    np.testing.assert_allclose(wall.stated.pose.translation_m, [1, 2, 3])
    np.testing.assert_allclose(
        np.sqrt(np.diag(wall.stated.covariance)), [0.01, 0.02, 0.03, 0.1, 0.2, 0.3]
    )
    # The second row of a staggered board begins one place to the right, one place down.
    second = wall.markers[12].stated
    assert second is not None
    np.testing.assert_allclose(second.pose.translation_m, [0.1 - 0.025, -0.1 + 0.025, 0.0])
    (centre,) = (wand.markers[2].stated,)
    assert centre is not None
    np.testing.assert_allclose(centre.pose.translation_m, [-0.1, 0.1, 1.0])
    assert wand.still == (0.1, 0.2)
    assert scene.distances[0].corners == (3, 0)
    assert (scene.coordinates[0].marker, scene.coordinates[0].corner) == (10, None)


def test_sizes_of_boards_and_of_unlisted_tags(folder: Path) -> None:
    sides = read_scene(folder, {})
    assert [sides.side_m(one) for one in (9, 10, 14, 15)] == [0.5, 0.05, 0.05, 0.5]
    assert [sides.side_m(one) for one in (20, 23, 24)] == [0.07, 0.07, 0.5]
    (folder / "tagslam.yaml").write_text(BODIES.replace("default_body: lab", ""))
    assert read_scene(folder, {}).side_m(99) is None


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("tagslam.yaml", "- id: 2", "- id: 10", "tag 10 once"),
        ("tagslam.yaml", "size: 0.2", "size: -1", "metres above 0"),
        ("tagslam.yaml", "size: 0.2", "size: .nan", "size"),
        ("tagslam.yaml", "tag_rows: 3", "tag_rows: 1.5", "whole number"),
        (
            "tagslam.yaml",
            "tag_rows: 2, tag_columns: 2",
            "tag_rows: 99999, tag_columns: 99999",
            "at most 100000 tags",
        ),
        ("tagslam.yaml", "default_body: lab", "default_body: moon", "name of a body"),
        ("tagslam.yaml", "bodies:", "bodies: 3\nothers:", "a list"),
        ("cameras.yaml", "radtan", "fisheye", "radtan"),
        ("cameras.yaml", "400.0, 401.0", "400.0", "4 numbers"),
        ("cameras.yaml", "/tags", "/other", "expected messages on"),
        ("camera_poses.yaml", "x: 0.1", "x: here", "position"),
    ],
)
def test_calibrations_that_do_not_fit_are_refused(folder: Path, name, old, new, said) -> None:
    text = (folder / name).read_text()
    assert old in text
    (folder / name).write_text(text.replace(old, new))
    with pytest.raises(RecordingError, match=said):
        tagslam.read_corners(folder)


def test_bags_that_do_not_fit_are_refused(folder: Path, monkeypatch) -> None:
    path = folder / "tag_detections.bag.bz2"
    good = path.read_bytes()
    plain = bz2.decompress(good)
    broken = {
        "an id twice": packed_bag([(1, [3, 3])]),
        "stamps twice": packed_bag([(1, [3]), (1, [4])]),
        "no number": packed_bag([(1, [3])], [(np.nan, 0.0)] * 4),
        "cut short": good[: len(good) // 2],
        "not packed": b"hello",
        "not a bag": bz2.compress(b"hello"),
        "half a bag": bz2.compress(plain[: len(plain) // 2]),
        "nothing": b"",
    }
    for label, content in broken.items():
        path.write_bytes(content)
        with pytest.raises(RecordingError, match="tag_detections"):
            print(label, tagslam.read_corners(folder))
    path.write_bytes(good)
    monkeypatch.setattr(ros_bag, "BAG_LIMIT", 100)
    with pytest.raises(RecordingError, match="at most 100 bytes unpacked"):
        tagslam.read_corners(folder)
    path.unlink()
    assert not tagslam.recognise(folder)
    with pytest.raises(RecordingError, match=r"tag_detections\.bag or"):
        tagslam.read_corners(folder)


def test_damaged_bytes_never_give_anything_but_a_recording_or_its_error(folder: Path, rng) -> None:
    path = folder / "tag_detections.bag"
    plain = bz2.decompress((folder / "tag_detections.bag.bz2").read_bytes())
    for _ in range(60):
        damaged = bytearray(plain)
        for place in rng.integers(0, len(plain), 8):
            damaged[place] = rng.integers(0, 256)
        path.write_bytes(damaged)
        with suppress(RecordingError):
            tagslam.read_corners(folder)


# Flips, counted by hand --------------------------------------------------------------------------


def test_flips_are_counted_as_defined() -> None:
    camera = Camera(640, 480, 400.0, 400.0, 320.0, 240.0)
    time_ns = np.array([0, 1, 2, 9]) * 150_000_000
    stream = CornerStream(
        camera,
        time_ns,
        np.array([0, 0, 1, 1, 2, 3]),
        np.array([1, 2, 1, 2, 1, 1]),
        np.zeros((6, 4, 2)),
    )
    truth = Rotor.from_rotation_vector([[0.0, 0.1 * row, 0.0] for row in range(6)])
    reference = truth.coefficients.copy()
    normals = truth.apply([0.0, 0.0, 1.0])
    counted = count_flips(stream, normals, reference)
    assert (counted.steps, counted.flips, counted.detections, counted.wrong) == (3, 0, 6, 0)
    flipped = normals.copy()
    tilt = Rotor.from_rotation_vector([np.radians(15.1), 0.0, 0.0])
    flipped[2] = (truth[2] @ tilt).apply([0.0, 0.0, 1.0])
    counted = count_flips(stream, flipped, reference)
    assert (counted.flips, counted.wrong) == (2, 1)
    withheld = normals.copy()
    withheld[3] = np.nan
    counted = count_flips(stream, withheld, reference)
    assert (counted.flips, counted.wrong) == (1, 1)
    reference[:2] = np.nan
    counted = count_flips(stream, normals, reference)
    assert (counted.steps, counted.detections) == (1, 4)


# The recordings themselves -----------------------------------------------------------------------


@pytest.fixture(scope="session")
def tagslam_dir(data_dir: Path) -> Path:
    folder = data_dir / "tags" / "tagslam"
    if not folder.is_dir():
        pytest.skip("no recordings of tags here: set MOTORCADE_DATA to the recordings' folder")
    return folder


def test_what_the_recordings_hold(tagslam_dir: Path) -> None:
    rig = tagslam.read_corners(tagslam_dir / "test_21")
    counts = {name: (len(s.time_ns), len(s)) for name, s in rig.streams.items()}
    assert counts == {
        "cam0": (431, 1274),
        "cam1": (431, 1353),
        "cam2": (431, 275),
        "cam3": (431, 177),
    }
    assert list(rig.rig_T_camera) == ["cam0"]
    assert rig.side_m[2] == 0.16
    assert rig.side_m[101] == 0.1
    far = tagslam.read_corners(tagslam_dir / "test_24")
    true = reference_rotors(far.streams["cam0"], read_reference(tagslam_dir / "test_24"), "cam0")
    assert np.count_nonzero(np.isfinite(true[:, 0])) == 1139


def test_the_odometry_of_the_reference_is_the_pose_of_the_rig(tagslam_dir: Path) -> None:
    """By its transforms and by the trajectory file beside it, whatever it calls its child frame."""
    root = tagslam_dir / "test_21"
    reference = read_reference(root)
    assert len(reference.time_ns) == 430
    away = reference.odometry.motors.inverse() @ reference_path(root).motors
    assert np.abs(away.as_twist()).max() < 1e-5
    beside = read_trajectory(root / "tagslam.tum")
    np.testing.assert_array_equal(beside.time_ns, reference.time_ns)
    away = reference.odometry.motors.inverse() @ beside.motors
    assert np.abs(away.as_twist()).max() < 1e-5


@pytest.mark.slow
def test_flips_of_the_recordings(tagslam_dir: Path) -> None:
    rows = {(row["recording"], row["method"]): row for row in bench_flips(tagslam_dir)}
    alone = rows["test_24", "best reprojection"]
    assert (alone["steps"], alone["detections"]) == (811, 1139)
    assert alone["flips"] > 40
    for method in ("whole recording", "online, 2 frames late", "online, 5 frames late"):
        far, near = rows["test_24", method], rows["test_23", method]
        assert far["flips"] <= 4
        assert far["wrong_percent"] <= 1.5
        assert (near["steps"], near["flips"]) == (1875, 0)


@pytest.mark.slow
def test_the_map_of_an_unknown_layout_agrees_with_the_reference(tagslam_dir: Path) -> None:
    """SE3-aligned by evo, on every frame with a tag that has a reference."""
    root = tagslam_dir / "test_21"
    recording = tagslam.read_corners(root)
    found = map_markers(recording.streams, recording.side_m, recording.rig_T_camera)
    assert found.left_out == ()
    assert len(found.trajectory) == 402
    reference, estimate = sync.associate_trajectories(
        as_evo(reference_path(root)), as_evo(found.trajectory), max_diff=0.01
    )
    assert reference.num_poses >= 401
    estimate.align(reference)
    error = metrics.APE(metrics.PoseRelation.translation_part)
    error.process_data((reference, estimate))
    assert error.get_statistic(metrics.StatisticsType.rmse) < 0.015


def as_evo(path: Trajectory) -> PoseTrajectory3D:
    wxyz, positions = path.motors.as_quaternion_translation()
    return PoseTrajectory3D(positions, wxyz, path.time_ns * 1e-9)
