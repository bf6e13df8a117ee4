"""Scenes of bodies that move each on their own: found as they were, and wrong statements named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import AuditFinding, Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.planar import planar_poses
from motorcade.tracking.markers.scenes import (
    BodyOdometry,
    CornerCoordinate,
    CornerDistance,
    FixedMarker,
    MarkerBody,
    MarkerScene,
    StatedPose,
    map_scene,
)
from motorcade.tracking.markers.scenes.estimate import hand_eye, odometry_finding
from motorcade.tracking.markers.scenes.mapped import MappedScene

CAMERA = Camera(640, 480, 420.0, 420.0, 319.5, 239.5)
FRAMES, RATE_HZ = 60, 10.0
TIME_NS = np.rint(1e9 * np.arange(FRAMES) / RATE_HZ).astype(np.int64)
SIDE_M = 0.16
SURE = np.diag(np.repeat([1e-5, 1e-4], 3) ** 2)
ROOM = {
    k: Motor.from_euler_translation(
        [0.1 * k, -0.05 * k, 0.2 * k], [0.3 * (k % 3), 0.3 * (k // 3), 0]
    )
    for k in range(6)
}
BLOCK = {100: Motor.identity(), 101: Motor.from_euler_translation([0, 0.5, 0], [0.2, 0, 0.05])}
BODY_T_ODOMETRY = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([1.2, 1.2, 1.2]), [0.05, -0.02, 0.1]
)


def rig_path(rng: np.random.Generator) -> Motor:
    """A camera that looks down at the room, turning about all its axes."""
    s = np.linspace(0.0, 4.0 * np.pi, FRAMES)
    vector = np.stack([np.pi + 0.2 * np.sin(s), 0.25 * np.cos(0.7 * s), 0.2 * np.sin(1.3 * s)], -1)
    place = np.stack([0.3 + 0.2 * np.cos(s), 0.15 + 0.2 * np.sin(0.8 * s), 1.3 + 0 * s], -1)
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(vector), place)


def block_path() -> Motor:
    s = np.linspace(0.0, 3.0, FRAMES)
    vector = np.stack([0.1 * np.sin(s), 0.2 * np.cos(s), s], -1)
    place = np.stack([0.1 * s, 0.45 - 0.1 * s, 0.1 + 0.02 * s], -1)
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(vector), place)


def seen_by(world_T_rig: Motor, rng: np.random.Generator, side_m: float = SIDE_M) -> CornerStream:
    """Corners of both bodies, with 0.2 px of noise; every tenth frame shows nothing."""
    frame, ids, corners = [], [], []
    carried = block_path()
    for row in range(FRAMES):
        if row % 10 == 9:
            continue
        camera_T_world = world_T_rig[row].inverse()
        poses = {k: camera_T_world @ pose for k, pose in ROOM.items()}
        poses |= {k: camera_T_world @ carried[row] @ pose for k, pose in BLOCK.items()}
        for marker, pose in poses.items():
            size_m = side_m if marker == 3 else SIDE_M
            px = CAMERA.project(pose.apply(marker_points_m(size_m)))
            frame.append(row)
            ids.append(marker)
            corners.append(px + 0.2 * rng.standard_normal((4, 2)))
    return CornerStream(CAMERA, TIME_NS, frame, ids, np.array(corners))


def scene(odometry: BodyOdometry | None = None) -> MarkerScene:
    room = MarkerBody(
        "room",
        moves=False,
        stated=StatedPose(Motor.identity(), SURE),
        markers={0: FixedMarker(SIDE_M, StatedPose(ROOM[0], SURE))},
        other_side_m=SIDE_M,
    )
    block = MarkerBody(
        "block",
        moves=True,
        markers={
            100: FixedMarker(SIDE_M, StatedPose(BLOCK[100], SURE)),
            101: FixedMarker(SIDE_M),
        },
    )
    rig = MarkerBody("rig", moves=True, odometry=odometry)
    stated = {"camera": StatedPose(Motor.identity(), SURE)}
    return MarkerScene((room, block, rig), {"camera": "rig"}, stated, sigma_px=0.2)


def off_m(found: MappedScene, name: str, true: Motor) -> FloatArray:
    path = found.body(name).trajectory
    rows = np.searchsorted(TIME_NS, path.time_ns)
    return np.linalg.norm(path.motors.translation_m - true[rows].translation_m, axis=-1)


def odometry_of(world_T_rig: Motor, stated: Motor) -> BodyOdometry:
    """What sits on the rig at BODY_T_ODOMETRY, in a world of its own."""
    elsewhere = Motor.from_euler_translation([0.3, 0.1, 2.0], [5.0, 1.0, 0.0])
    poses = elsewhere @ world_T_rig @ BODY_T_ODOMETRY
    return BodyOdometry(Trajectory(TIME_NS, poses, "odom", "imu"), stated)


def verdicts(found: MappedScene) -> dict[str, str]:
    return {one.name: one.verdict for one in found.audit}


def disagreed(found: MappedScene) -> dict[str, str]:
    return {name: verdict for name, verdict in verdicts(found).items() if verdict != "consistent"}


def test_two_bodies_that_move_are_both_found(rng: np.random.Generator) -> None:
    truth = rig_path(rng)
    found = map_scene({"camera": seen_by(truth, rng)}, scene())
    assert len(found.body("rig")) == len(found.body("block")) == 54
    assert off_m(found, "rig", truth).max() < 0.02
    assert off_m(found, "block", block_path()).max() < 0.02
    path = found.seen_from("camera")
    assert len(path.marker_map) == 6
    place = path.marker_map.world_T_marker.translation_m - [ROOM[k].translation_m for k in range(6)]
    assert np.abs(place).max() < 0.005
    assert disagreed(found) == {"stated_poses": "unknown"}  # one on each body: it is its frame


def test_a_camera_that_wiggles_pulls_no_frame_off(rng: np.random.Generator) -> None:
    truth = rig_path(rng)
    wiggle = Motor.exp(0.02 * rng.standard_normal((FRAMES, 6)))
    seen = {"camera": seen_by(truth, rng), "loose": seen_by(truth @ wiggle, rng)}
    stated = replace(
        scene(),
        camera_body={"camera": "rig", "loose": "rig"},
        cameras={name: StatedPose(Motor.identity(), SURE) for name in seen},
        wiggle={"loose": (0.02, 0.02)},
    )
    found, alone = map_scene(seen, stated), map_scene({"camera": seen["camera"]}, scene())
    off = [float(np.median(off_m(one, "rig", truth))) for one in (found, alone)]
    assert off[0] < 1.1 * off[1]
    assert found.camera("loose").isclose(Motor.identity(), atol=1e-3).all()
    assert not disagreed(found)
    spread = [one.body("rig").covariance.diagonal(axis1=1, axis2=2) for one in (found, alone)]
    assert np.median(spread[0]) > 0.6 * np.median(spread[1])  # half, were both cameras sure


def test_a_camera_that_stands_still_is_seen_from_what_moves(rng: np.random.Generator) -> None:
    still = Motor.stack([rig_path(rng)[0]] * FRAMES)
    stated = scene()
    room = replace(stated.bodies[0], name="frame", markers={}, other_side_m=None)
    stated = replace(
        stated,
        bodies=(room, stated.bodies[1]),
        camera_body={"camera": "frame"},
        cameras={"camera": StatedPose(still[0], SURE)},
    )
    found = map_scene({"camera": seen_by(still, rng)}, stated)
    path = found.seen_from("camera").measurements.trajectory
    true = block_path()[np.searchsorted(TIME_NS, path.time_ns)].inverse() @ still[0]
    assert np.abs((true.inverse() @ path.motors).translation_m).max() < 0.04


def test_the_stated_place_of_odometry_means_what_its_name_says(rng: np.random.Generator) -> None:
    """120° about a diagonal: taken the other way round it would turn every step's axis."""
    truth = rig_path(rng)
    seen = {"camera": seen_by(truth, rng)}
    found = map_scene(seen, scene(odometry_of(truth, BODY_T_ODOMETRY)))
    assert verdicts(found)["odometry_extrinsics"] == "consistent"
    assert len(found.body("rig")) == FRAMES  # the frames that show nothing, too
    assert off_m(found, "rig", truth).max() < 0.02
    wrong = map_scene(seen, scene(odometry_of(truth, BODY_T_ODOMETRY.inverse())))
    (told,) = (one for one in wrong.audit if one.name == "odometry_extrinsics")
    assert told.verdict == "contradicted"
    assert told.figure == pytest.approx(120.0, abs=5.0)
    assert "give the inverse" in told.sentence
    # What was stated wrongly does no harm.
    assert off_m(wrong, "rig", truth).max() < 0.02


def test_extrinsics_are_consistent_only_where_other_axes_are_out() -> None:
    """Rotations that noise drowns fit any order of axes: the answer is unknown."""
    rng, count = np.random.default_rng(8), len(TIME_NS)
    turns = np.cumsum(rng.normal(0.0, 0.03, (count, 3)), axis=0)
    body = Motor.from_rotor_translation(Rotor.from_rotation_vector(turns), np.zeros((count, 3)))

    def verdict(noise_rad: float) -> AuditFinding:
        drift = Rotor.from_rotation_vector(rng.normal(0.0, noise_rad, (count, 3)))
        seen = body @ Motor.from_rotor_translation(drift, np.zeros((count, 3)))
        fit = hand_eye(odometry_of(body, BODY_T_ODOMETRY), TIME_NS, seen)
        return odometry_finding("rig", fit)

    assert verdict(0.002).verdict == "consistent"
    assert "e^" in verdict(0.002).summary
    assert verdict(0.4).verdict == "unknown"


def test_a_wrong_size_and_a_wrong_place_are_named(rng: np.random.Generator) -> None:
    truth = rig_path(rng)
    small = map_scene({"camera": seen_by(truth, rng, 0.9 * SIDE_M)}, scene())
    (told,) = (one for one in small.audit if one.name == "marker_sizes")
    assert told.verdict == "contradicted"
    assert "1 markers look larger or smaller than stated: 3 (-" in told.summary
    stated = scene()
    room = stated.bodies[0]
    moved = ROOM[4] @ Motor.from_translation([0.2, 0.0, 0.0])
    room = replace(room, markers={**room.markers, 4: FixedMarker(SIDE_M, StatedPose(moved, SURE))})
    stated = replace(stated, bodies=(room, *stated.bodies[1:]))
    found = map_scene({"camera": seen_by(truth, rng)}, stated)
    (poses,) = (finding for finding in found.audit if finding.name == "stated_poses")
    assert poses.verdict == "contradicted"


def test_stated_poses_are_consistent_only_where_something_speaks_of_them(
    rng: np.random.Generator,
) -> None:
    seen, stated = {"camera": seen_by(rig_path(rng), rng)}, scene()
    room = stated.bodies[0]
    second = FixedMarker(SIDE_M, StatedPose(ROOM[4], 1e4 * SURE))
    two = replace(room, markers={**room.markers, 4: second})
    for bodies, verdict, alone in (
        (stated.bodies, "unknown", 4),
        ((two, *stated.bodies[1:]), "consistent", 3),
    ):
        found = map_scene(seen, replace(stated, bodies=bodies))
        (poses,) = (finding for finding in found.audit if finding.name == "stated_poses")
        assert poses.verdict == verdict, poses.summary
        assert f"of {alone} of them nothing that was seen speaks" in poses.summary


def test_a_marker_that_nothing_connects_is_told(rng: np.random.Generator) -> None:
    """Frames that show the others show it never, so that no frame tells where it is."""
    seen = seen_by(rig_path(rng), rng)
    alone = CornerStream(
        CAMERA,
        TIME_NS,
        np.append(seen.frame, FRAMES - 1),
        np.append(seen.marker_ids, 77),
        np.append(seen.corners_px, seen.corners_px[:1], axis=0),
    )
    found = map_scene({"camera": alone}, scene())
    assert found.left_out == (77,)
    (told,) = (one for one in found.audit if one.name == "marker_connection")
    assert told.verdict == "doubtful"
    assert told.sentence == (
        "8 of 9 markers hang together; show marker 77 beside one of the others, or state its pose"
    )


def test_measured_distances_are_heeded(rng: np.random.Generator) -> None:
    """All sides stated 3 % too large: a length across the room says so."""
    truth = rig_path(rng)
    stated = scene()
    big = 1.03 * SIDE_M
    room = replace(
        stated.bodies[0],
        markers={0: FixedMarker(big, stated.bodies[0].markers[0].stated)},
        other_side_m=big,
    )
    ends = [ROOM[k].apply(marker_points_m(SIDE_M)[0]) for k in (1, 5)]
    length_m = float(np.linalg.norm(ends[0] - ends[1]))
    loose = replace(stated, bodies=(room, *stated.bodies[1:]))
    held = replace(loose, distances=(CornerDistance((1, 5), (0, 0), length_m, 1e-5),))
    seen = {"camera": seen_by(truth, rng)}
    lengths = []
    for one in (loose, held):
        known = map_scene(seen, one).seen_from("camera").marker_map
        corners = [known.world_T_marker[k].apply(marker_points_m(big)[0]) for k in (1, 5)]
        lengths.append(float(np.linalg.norm(corners[0] - corners[1])))
    assert abs(lengths[0] - length_m) > 0.01
    assert abs(lengths[1] - length_m) < 1e-3


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: FixedMarker(0.0), "FixedMarker.side_m"),
        (lambda: MarkerBody("room", moves=False, other_side_m=-0.1), "MarkerBody.other_side_m"),
        (lambda: MarkerBody("room", moves=True, still=(0.1, np.nan)), "MarkerBody.still"),
        (lambda: CornerDistance((1, 5), (0, 4), 0.5, 0.01), "CornerDistance.corners"),
        (lambda: CornerDistance((1, 5), (0, 3), np.nan, 0.01), "CornerDistance.distance_m"),
        (lambda: CornerDistance((1, 5), (0, 3), 0.5, 0.0), "CornerDistance.sigma_m"),
        (lambda: CornerCoordinate(1, -1, (0, 0, 1), 0.5, 0.01), "CornerCoordinate.corner"),
        (lambda: CornerCoordinate(1, 0, (0, 0, np.inf), 0.5, 0.01), "CornerCoordinate.direction"),
        (lambda: CornerCoordinate(1, None, (0, 0, 1), 0.5, -0.01), "CornerCoordinate.sigma_m"),
        (lambda: replace(scene(), wiggle={"camera": (0.01, 0.0)}), "MarkerScene.wiggle of camera"),
        (lambda: replace(scene(), sigma_px=0.0), "MarkerScene.sigma_px"),
        (lambda: replace(scene(), sigma_px=np.inf), "MarkerScene.sigma_px"),
    ],
)
def test_values_that_no_scene_has_are_refused(made, said: str) -> None:
    with pytest.raises(ValueError, match=f"{said}: expected"):
        made()


@pytest.mark.parametrize("covariance", [np.ones((6, 6)), np.nan * SURE, -SURE, np.eye(3)])
def test_covariances_that_weigh_nothing_are_refused(covariance: FloatArray) -> None:
    bad, good = StatedPose(Motor.identity(), covariance), scene()
    with pytest.raises(ValueError, match="covariance of camera camera"):
        replace(good, cameras={"camera": bad})
    for room, name in (
        (replace(good.bodies[0], stated=bad), "body room"),
        (replace(good.bodies[0], markers={0: FixedMarker(SIDE_M, bad)}), "marker 0"),
    ):
        with pytest.raises(ValueError, match=f"covariance of {name}"):
            replace(good, bodies=(room, *good.bodies[1:]))


def test_only_cameras_of_the_scene_wiggle() -> None:
    with pytest.raises(ValueError, match="wiggle: other is no camera"):
        replace(scene(), wiggle={"other": (0.01, 0.01)})


def test_streams_of_no_camera_and_of_strange_cameras_are_refused(rng: np.random.Generator) -> None:
    with pytest.raises(ValueError, match="at least one camera"):
        map_scene({}, scene())
    with pytest.raises(ValueError, match="of the scene \\(camera\\), got other"):
        map_scene({"other": seen_by(rig_path(rng), rng)}, scene())


def test_a_noisy_marker_alone_turns_no_frame_over(rng: np.random.Generator) -> None:
    truth = rig_path(rng)
    stream = seen_by(truth, rng)
    frame, marker = 20, 3
    alone = (stream.frame != frame) | (stream.marker_ids == marker)
    alone &= abs(stream.frame - frame) < 6
    row = int(np.flatnonzero(alone & (stream.frame == frame))[0])
    true = truth[frame].inverse() @ ROOM[marker]
    clean = CAMERA.project(true.apply(marker_points_m(SIDE_M)))
    for _ in range(1000):  # until the wrong one of both planar poses fits better by far
        corners = clean + 1.5 * rng.standard_normal((4, 2))
        _, both, error_px = planar_poses(CAMERA, corners[None], np.array([SIDE_M]))
        turned = (both[0].inverse() @ true).rotor.angle()
        better = 4.0 * (error_px[0, 1] ** 2 - error_px[0, 0] ** 2) / 0.2**2
        if turned[0] > np.radians(30.0) and turned[1] < turned[0] / 2.0 and better > 40.0:
            break
    else:
        pytest.fail("no draw")
    noisy = stream.corners_px.copy()
    noisy[row] = corners
    part = CornerStream(
        CAMERA, TIME_NS, stream.frame[alone], stream.marker_ids[alone], noisy[alone]
    )
    found = map_scene({"camera": part}, replace(scene(), sigma_px=1.0)).body("rig").trajectory
    assert TIME_NS[frame] in found.time_ns
    off = found.motors[int(np.searchsorted(found.time_ns, TIME_NS[frame]))].inverse() @ truth[frame]
    assert off.rotor.angle() < np.radians(30.0)


@pytest.mark.parametrize("off_px", [0.2, 3.0])
def test_a_frame_whose_only_observation_misfits_has_no_pose(
    rng: np.random.Generator, off_px: float
) -> None:
    truth = rig_path(rng)
    stream = seen_by(truth, rng)
    frame = 20
    kept = (stream.frame != frame) | (stream.marker_ids == 3)
    kept &= abs(stream.frame - frame) < 4
    corners = stream.corners_px[kept].copy()
    twisted = off_px * np.array([[1, 1], [-1, -1], [1, 1], [-1, -1]])  # no pose of a square does so
    corners[stream.frame[kept] == frame] += twisted
    part = CornerStream(CAMERA, TIME_NS, stream.frame[kept], stream.marker_ids[kept], corners)
    found = map_scene({"camera": part}, scene())
    told = [one for one in found.audit if one.name == "misfit_frames"]
    posed = TIME_NS[frame] in found.body("rig").trajectory.time_ns
    assert posed == (off_px < 1.0) == (not told)
    if told:
        assert told[0].verdict == "doubtful"  # of one such frame, one
        assert told[0].summary.startswith("1 of 1 frames that one observation alone places")
        assert np.isinf(found.error_px[found.seen.frame == frame]).all()


def test_corners_that_lie_off_are_counted_by_what_was_stated_of_them(
    rng: np.random.Generator,
) -> None:
    truth = rig_path(rng)
    stream = seen_by(truth, rng)
    rough = rng.random(len(stream)) < 0.4  # four pixels of noise, where one is stated
    noise_px = np.where(rough, 4.0, 1.3)[:, None, None] * rng.standard_normal((len(stream), 4, 2))
    found = map_scene(
        {"camera": replace(stream, corners_px=stream.corners_px + noise_px)},
        replace(scene(), sigma_px=1.0),
    )
    (corners,) = (finding for finding in found.audit if finding.name == "marker_corners")
    assert corners.verdict == "doubtful", corners.summary
    assert "more than 3.2 px" in corners.summary
