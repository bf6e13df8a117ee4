"""Maps of markers: the layout, the path and the rig come back from corners alone."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera, SingleMarker, TrackingError, detect_markers
from motorcade.tracking.images import blur_bias_px
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.mapping import map_markers, track_rig
from motorcade.tracking.markers.mapping.adjust import linearised, residuals_px
from motorcade.tracking.markers.mapping.rig import gather
from motorcade.tracking.markers.marker_map import MarkerMap

RIG_T_RIGHT = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([0.02, 0.2, -0.05]), [0.12, 0.01, -0.02]
)
SIDES = {0: 0.16, **dict.fromkeys(range(1, 9), 0.1)}


@pytest.fixture(scope="module")
def rig(scenes):
    """Two cameras on a rig before nine markers; the second one's stamps are 3 ms late."""
    rng = np.random.default_rng(3)
    path, wall = scenes.path(25, rng), scenes.wall(9, rng)
    left = scenes.seen_by(scenes.camera, path, wall, SIDES, 0.2, rng)
    path_right = path @ RIG_T_RIGHT.reshape(1)
    right = scenes.seen_by(scenes.camera, path_right, wall, SIDES, 0.2, rng, start_ns=1_003_000_000)
    return path, wall, {"left": left.stream, "right": right.stream}


def apart(found: Motor, true: Motor) -> tuple[float, float]:
    """Largest difference in metres and degrees."""
    motion = found.inverse() @ true
    return (
        float(np.linalg.norm(motion.translation_m, axis=-1).max()),
        float(np.degrees(motion.rotor.angle()).max()),
    )


def test_layout_path_and_rig_come_back(rig) -> None:
    path, wall, streams = rig
    found = map_markers(streams, SIDES)
    markers = found.marker_map
    assert found.left_out == ()
    np.testing.assert_array_equal(markers.marker_ids, np.arange(9))
    anchor = int(np.argmin(np.linalg.norm(markers.world_T_marker.as_twist(), axis=-1)))
    world_T_ours = wall[anchor].reshape(1)
    metres, degrees = apart(world_T_ours @ markers.world_T_marker, wall)
    assert metres < 0.006
    assert degrees < 1.0
    metres, degrees = apart(world_T_ours @ found.trajectory.motors, path)
    assert metres < 0.012
    assert degrees < 0.5
    metres, degrees = apart(found.rig_T_camera["right"], RIG_T_RIGHT)
    assert metres < 0.002
    assert degrees < 0.1


def test_a_given_camera_stays_where_it_was_given(rig) -> None:
    _, _, streams = rig
    known = {"left": Motor.identity(), "right": RIG_T_RIGHT}
    found = map_markers(streams, SIDES, known)
    given = found.rig_T_camera["right"].coefficients
    np.testing.assert_array_equal(given, RIG_T_RIGHT.coefficients)


def test_the_map_tracks_its_own_recording_and_a_part_of_it(rig) -> None:
    _, _, streams = rig
    found = map_markers(streams, SIDES)
    again = track_rig(found.marker_map, streams, found.rig_T_camera)
    metres, degrees = apart(again.trajectory.motors, found.trajectory.motors)
    assert metres < 1e-3
    assert degrees < 0.05
    alone = track_rig(found.marker_map, {"left": streams["left"]})
    assert apart(alone.trajectory.motors, found.trajectory.motors)[0] < 0.02


def test_the_derivatives_are_those_of_differences(rig) -> None:
    path, wall, streams = rig
    known = {"left": Motor.identity(), "right": RIG_T_RIGHT}
    seen = gather(streams, known, SIDES, 0.05).only(np.arange(12))
    poses, markers = path[seen.frame], wall[seen.marker]
    residuals, jacobians = linearised(seen, poses, markers)
    np.testing.assert_allclose(residuals, residuals_px(seen, poses, markers).reshape(-1, 8))
    for axis, step in enumerate(1e-6 * np.eye(6)):
        nudge = Motor.from_twist(step)
        one = nudge.reshape(1)
        moved = [
            residuals_px(seen, poses @ one, markers),
            residuals_px(seen, poses, markers @ one),
            residuals_px(replace(seen, rig_T_camera=seen.rig_T_camera @ one), poses, markers),
        ]
        for part, changed in enumerate(moved):
            slope = (changed.reshape(-1, 8) - residuals) / 1e-6
            np.testing.assert_allclose(jacobians[:, part, :, axis], slope, rtol=1e-3, atol=0.05)


def test_markers_never_seen_beside_the_others_are_left_out_and_named(scenes) -> None:
    rng = np.random.default_rng(4)
    path, wall = scenes.path(10, rng), scenes.wall(6, rng)
    stream = scenes.seen_by(
        scenes.camera, path, wall, dict.fromkeys(range(6), 0.12), 0.2, rng
    ).stream
    early = stream.frame < 6
    kept = (early & (stream.marker_ids < 4)) | (~early & (stream.marker_ids >= 4))
    split = replace(
        stream,
        frame=stream.frame[kept],
        marker_ids=stream.marker_ids[kept],
        corners_px=stream.corners_px[kept],
    )
    found = map_markers({"one": split}, dict.fromkeys(range(6), 0.12))
    assert found.left_out == (4, 5)
    np.testing.assert_array_equal(found.trajectory.time_ns, stream.time_ns[:6])


def test_the_same_map_gives_the_same_bytes_also_after_reading(rig, tmp_path: Path) -> None:
    _, _, streams = rig
    for name in ("once", "twice"):
        map_markers(streams, SIDES).marker_map.save(tmp_path / name)
    read = MarkerMap.load(tmp_path / "once")
    read.save(tmp_path / "again")
    once = (tmp_path / "once").read_bytes()
    assert once == (tmp_path / "twice").read_bytes() == (tmp_path / "again").read_bytes()
    assert read.sides == SIDES
    corner = read.world_T_marker[2].apply([0.1, -0.1, 0.0])
    np.testing.assert_allclose(read.points_m[4 * 2 + 2], corner)


GOOD = {"id": 1, "side_m": 0.1, "quaternion_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, 0]}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"side_m": 0.0}, "above 0"),
        ({"side_m": "wide"}, "not a marker map"),
        ({"quaternion_wxyz": [2, 0, 0, 0]}, "unit"),
        ({"quaternion_wxyz": [1, 0, 0]}, "not a marker map"),
        ({"translation_m": [0, 0, float("nan")]}, "origin_m"),
        ({"id": True}, "whole numbers"),
        ({"id": 10**30}, "not a marker map"),
    ],
)
def test_maps_that_make_no_sense_are_refused(change, said: str, tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    MarkerMap(np.array([1]), np.array([0.1]), Rotor.identity((1,)), np.zeros((1, 3))).save(path)
    content = json.loads(path.read_text())
    content["markers"] = [GOOD | change]
    path.write_text(json.dumps(content))
    with pytest.raises(ValueError, match=said):
        MarkerMap.load(path)


@pytest.mark.parametrize("text", ["[]", "{", "[" * 10**5, '{"format": "motorcade marker map 1"}'])
def test_files_that_are_no_maps_are_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    path.write_text(text)
    with pytest.raises(ValueError, match="not a marker map"):
        MarkerMap.load(path)
    path.write_text("")
    with pytest.raises(ValueError, match="the file is empty"):
        MarkerMap.load(path)


def test_maps_of_nothing_are_refused(rig) -> None:
    _, _, streams = rig
    empty = replace(
        streams["left"],
        frame=np.zeros(0, int),
        marker_ids=np.zeros(0, int),
        corners_px=np.zeros((0, 4, 2)),
    )
    with pytest.raises(ValueError, match="streams"):
        map_markers({}, SIDES)
    with pytest.raises(TrackingError, match="expected markers"):
        map_markers({"left": empty}, SIDES)
    with pytest.raises(TrackingError, match="right: expected a marker seen together"):
        map_markers({"left": streams["left"], "right": empty}, SIDES)
    with pytest.raises(ValueError, match="rig_T_camera"):
        map_markers(streams, SIDES, {"top": Motor.identity()})
    with pytest.raises(ValueError, match="sync_s"):
        map_markers(streams, SIDES, sync_s=float("nan"))


def test_the_covariance_of_tracked_poses_is_their_scatter(scenes) -> None:
    """Errors against the true map, squared in units of the covariance, are six in the mean."""
    rng = np.random.default_rng(8)
    path, wall = scenes.path(60, rng), scenes.wall(9, rng)
    scene = scenes.seen_by(scenes.camera, path, wall, SIDES, 0.3, rng)
    known = MarkerMap(
        np.arange(9), np.array([SIDES[one] for one in range(9)]), wall.rotor, wall.translation_m
    )
    found = track_rig(known, {"camera": scene.stream})
    assert len(found.trajectory) == len(found.covariance) == len(found.frame_error_px) == 60
    twist = (found.trajectory.motors.inverse() @ path).as_twist()
    squares = np.einsum("ni,nij,nj->n", twist, np.linalg.inv(found.covariance), twist)
    assert squares.mean() / 6.0 == pytest.approx(1.0, abs=0.35)
    # Two coordinates a corner, 0.3 pixels each.
    assert np.sqrt(np.mean(found.frame_error_px**2)) == pytest.approx(0.3 * np.sqrt(2), rel=0.15)


def test_frames_of_a_rig_have_stamps_of_their_own() -> None:
    """A camera of a higher rate comes twice while another has one frame: stamps still rise."""
    camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    none = np.zeros(0, np.int64)
    slow, fast = (
        CornerStream(camera, np.array(stamps), none, none, np.zeros((0, 4, 2)))
        for stamps in ([100_000_000, 200_000_000], [95_000_000, 100_000_000, 195_000_000])
    )
    given = {"slow": Motor.identity(), "fast": Motor.identity()}
    found = gather({"slow": slow, "fast": fast}, given, {}, sync_s=0.01)
    assert found.time_ns.tolist() == [95_000_000, 100_000_000, 200_000_000]


def test_poses_are_as_unsure_as_errors_that_last_make_their_map() -> None:
    """Two views of four tags, six frames each, in which each corner is off by the same."""
    rng, camera = np.random.default_rng(5), Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    wall = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(0.2 * rng.standard_normal((4, 3))),
        [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.2, 0.2, 0.0]],
    )
    turns = Rotor.from_rotation_vector([[np.pi - 0.5, 0.1, 0.0], [np.pi + 0.3, 0.5, 0.1]])
    views = Motor.from_rotor_translation(turns, [[-0.1, 0.1, 0.7], [-0.1, 0.1, 0.8]])
    points = (views.reshape(2, 1) @ wall)[..., None].apply(marker_points_m(0.08))
    stamps, view = 33_000_000 * np.arange(12), np.repeat([0, 1], 6)
    squared = []
    for _ in range(8):
        seen = camera.project(points) + rng.normal(0.0, 0.3, (2, 4, 4, 2))
        frames, ids = np.repeat(np.arange(12), 4), np.tile(np.arange(4), 12)
        corners = seen[view].reshape(-1, 4, 2) + rng.normal(0.0, 0.05, (48, 4, 2))
        stream = CornerStream(camera, stamps, frames, ids, corners)
        found = map_markers({"one": stream}, dict.fromkeys(range(4), 0.08))
        path = found.trajectory.motors
        moved, true = path[0].inverse() @ path[-1], views[0] @ views[1].inverse()
        at_end = moved.inverse().adjoint()
        spread = at_end @ found.covariance[0] @ at_end.T + found.covariance[-1]
        off = moved.local(true)
        squared.append(float(off @ np.linalg.solve(spread, off)) / 6.0)
    assert 0.1 < np.mean(squared) < 3.0


def test_blur_draws_corners_aside_as_far_as_it_is_said_to() -> None:
    """Sharp tags tell nothing aside; a blur of half a cell moves corners by a sixth of itself."""
    rng = np.random.default_rng(8)
    for blur_px, size_px in ((0.7, 60), (2.5, 40), (3.5, 60)):
        off, told = [], []
        for marker_id in rng.integers(0, 500, 6).tolist():
            marker = SingleMarker("tag36h11", marker_id, 0.08)
            drawn, origin = marker.draw(8 * size_px / 0.08)
            fine = np.pad(drawn, 160, constant_values=120)
            fine = fine[: len(fine) // 8 * 8, : fine.shape[1] // 8 * 8]
            image = cv2.resize(fine, None, fx=0.125, fy=0.125, interpolation=cv2.INTER_AREA)
            image = cv2.GaussianBlur(image, (0, 0), blur_px)
            at = marker.points_m[:, :2] * (1, -1) * 8 * size_px / 0.08 + origin + 160
            for one in detect_markers(image, "tag36h11"):
                off.append(one.corners_px - ((at + 0.5) / 8.0 - 0.5))
                told.append(float(blur_bias_px(image, one.corners_px[None], 0.125)[0]))
        rms_px = float(np.sqrt(np.mean(np.square(off))))
        assert np.median(told) == pytest.approx(rms_px, rel=0.5, abs=0.03), blur_px
