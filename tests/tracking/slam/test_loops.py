"""Closing a loop takes out the drift between two passes and moves the points along."""

import numpy as np
import pytest

from motorcade.ga import Motor, Similarity
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import project
from motorcade.tracking.slam.mapping.loops import LoopClosure, _scale_by_depths, close_loop
from motorcade.tracking.slam.mapping.map import Keyframe, SlamMap

COUNT, SHARED = 24, 12
CAMERA = Camera(320, 240, 300.0, 300.0, 160.0, 120.0)


def _ring(rng: np.random.Generator) -> tuple[SlamMap, Motor, np.ndarray]:
    """Keyframes around a circle whose map drifts by the same small motion at every step.

    Returns:
        the map, the true world_T_camera ``(COUNT,)``, and where its points truly are.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, COUNT)
    still = np.zeros(COUNT)
    turns = Motor.from_twist(np.stack([still, angle, still, still, still, still], axis=1))
    truth = (Motor.from_twist([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]) @ turns).inverse()
    # Along the axis of the circle: what drifts across it cancels over a full turn.
    drift = Motor.from_twist([0.0, -0.004, 0.0, 0.0, -0.01, 0.0])
    slam_map, points = SlamMap(), []
    slam_map.metric = [True]
    pose = truth[0]
    for row in range(COUNT):
        if row:
            pose = pose @ truth[row - 1].inverse() @ truth[row] @ drift
        ids = slam_map.add_points(np.zeros((SHARED, 32), dtype=np.uint8))
        in_camera = rng.uniform((-1.0, -1.0, 2.0), (1.0, 1.0, 4.0), (SHARED, 3))
        slam_map.points[ids] = pose.apply(in_camera)
        points.append(truth[row].apply(in_camera))
        seen = ids if row == 0 else np.concatenate([ids - SHARED, ids])
        px, depth = np.zeros((len(seen), 2)), np.full(len(seen), np.nan)
        slam_map.keyframes.append(Keyframe(row, pose, np.sort(seen), px, depth, None))
    return slam_map, truth, np.concatenate(points)


def _rigid(pose: Motor) -> Similarity:
    return Similarity.from_motor_scale(pose)


def _worst_m(slam_map: SlamMap, truth: Motor) -> float:
    ours = Motor.stack([one.world_T_camera for one in slam_map.keyframes])
    return float(np.linalg.norm(ours.translation_m - truth.translation_m, axis=1).max())


def test_a_closed_loop_takes_out_most_of_the_drift(rng: np.random.Generator) -> None:
    slam_map, truth, points = _ring(rng)
    before = _worst_m(slam_map, truth)
    points_before = np.linalg.norm(slam_map.points - points, axis=1).mean()
    ids = np.arange(SHARED)
    px = rng.uniform(0.0, 300.0, (SHARED, 2))
    close_loop(slam_map, LoopClosure(0, COUNT - 1, _rigid(truth[-1]), ids, px), CAMERA)
    assert before > 0.1
    assert _worst_m(slam_map, truth) < before / 3.0
    assert np.linalg.norm(slam_map.points - points, axis=1).mean() < points_before / 3.0


def test_the_newest_keyframe_then_sees_the_old_points(rng: np.random.Generator) -> None:
    slam_map, truth, _ = _ring(rng)
    px = rng.uniform(0.0, 300.0, (SHARED, 2))
    close_loop(
        slam_map, LoopClosure(0, COUNT - 1, _rigid(truth[-1]), np.arange(SHARED), px), CAMERA
    )
    newest = slam_map.keyframes[-1]
    assert np.array_equal(newest.ids, np.unique(newest.ids))
    assert np.array_equal(newest.px[np.isin(newest.ids, np.arange(SHARED))], px)
    assert len(newest.ids) == len(newest.px) == len(newest.depth)


def test_points_mapped_twice_become_one(rng: np.random.Generator) -> None:
    slam_map, truth, _ = _ring(rng)
    slam_map.descriptors[:] = rng.integers(0, 256, slam_map.descriptors.shape)
    old, new = slam_map.keyframes[0], slam_map.keyframes[-1]
    # What the last keyframe mapped is what the first one mapped, drifted and seen anew.
    twins = new.ids[-SHARED:]
    slam_map.descriptors[twins] = slam_map.descriptors[old.ids]
    drifted = new.world_T_camera @ truth[-1].inverse()
    slam_map.points[twins] = drifted.apply(slam_map.points[old.ids])
    new.px[-SHARED:] = project(CAMERA, truth[-1], slam_map.points[old.ids])[0]
    seen = np.all((new.px[-SHARED:] > 12.0) & (new.px[-SHARED:] < (307.0, 227.0)), axis=1)
    assert np.count_nonzero(seen) >= 3
    close_loop(
        slam_map, LoopClosure(0, COUNT - 1, _rigid(truth[-1]), old.ids, new.px[-SHARED:]), CAMERA
    )
    merged = ~slam_map.alive[twins]
    assert np.count_nonzero(merged[seen]) >= np.count_nonzero(seen) - 2
    assert not np.isin(twins[merged], new.ids).any()
    assert np.isin(old.ids[merged], new.ids).all()


def test_merging_keeps_one_observation_a_keyframe(rng: np.random.Generator) -> None:
    slam_map, _, _ = _ring(rng)
    both = slam_map.keyframes[1]  # sees the points of keyframe 0 and its own
    own = both.px[both.ids < SHARED].copy()
    own[:] = 7.0
    both.px[both.ids < SHARED] = 7.0
    slam_map.merge(np.arange(SHARED, 2 * SHARED), np.arange(SHARED))
    assert np.array_equal(both.ids, np.arange(SHARED))
    assert np.array_equal(both.px, own)
    later = slam_map.keyframes[2]
    assert np.array_equal(later.ids, np.unique(later.ids))
    assert np.isin(np.arange(SHARED), later.ids).all()
    assert not slam_map.alive[SHARED : 2 * SHARED].any()


def test_a_unit_that_drifted_is_brought_back_along_the_loop(rng: np.random.Generator) -> None:
    slam_map, truth, points = _ring(rng)
    slam_map.metric = [False]
    # What one camera maps: every step three per cent longer than the one before.
    growth = 1.03 ** np.arange(COUNT)
    pose = truth[0]
    for row in range(COUNT):
        keyframe = slam_map.keyframes[row]
        if row:
            step = truth[row - 1].inverse() @ truth[row]
            longer = growth[row] * step.translation_m
            pose = pose @ Motor.from_rotor_translation(step.rotor, longer)
        keyframe.world_T_camera = pose
        mine = np.arange(row * SHARED, (row + 1) * SHARED)
        in_camera = truth[row].inverse().apply(points[mine])
        slam_map.points[mine] = pose.apply(growth[row] * in_camera)
    before = _worst_m(slam_map, truth)
    world_S_new = Similarity.from_motor_scale(truth[-1], 1.0 / growth[-1])
    px = rng.uniform(0.0, 300.0, (SHARED, 2))
    closed = close_loop(
        slam_map, LoopClosure(0, COUNT - 1, world_S_new, np.arange(SHARED), px), CAMERA
    )
    assert before > 0.9
    assert _worst_m(slam_map, truth) < before / 5.0
    stretched = np.array([one.scale for one in slam_map.keyframes])
    np.testing.assert_allclose(stretched * growth, 1.0, atol=0.1)
    # What the graph made of the measured scale, which it weighs against every edge.
    np.testing.assert_allclose(closed.correction.scale, stretched[-1], rtol=1e-12)
    assert abs(stretched[-1] * growth[-1] - 1.0) > 1e-6


@pytest.mark.parametrize("metric", ["older", "newer"])
def test_two_maps_that_meet_are_one_in_the_world_of_the_one_in_metres(
    rng: np.random.Generator, metric: str
) -> None:
    slam_map, _, _ = _ring(rng)
    slam_map.metric = [metric == "older", metric == "newer"]
    half = COUNT // 2
    for row in range(half, COUNT):
        keyframe = slam_map.keyframes[row]
        keyframe.map_number = 1
        keyframe.keep(keyframe.ids >= half * SHARED)
    expected = [one.world_T_camera.as_matrix() for one in slam_map.keyframes]
    points = slam_map.points.copy()
    # The other half as one camera has it: in a world and unit of its own.
    away = Similarity.from_twist([0.3, -0.2, 0.5, 1.0, 2.0, -1.0, 0.7])
    slam_map.metric.append(False)
    gone, into = (1, 0) if metric == "older" else (0, 1)
    slam_map.join_maps(gone, 2, away)
    newest = slam_map.keyframes[-1]
    old_S_new = away.inverse() if metric == "older" else away
    world_S_new = old_S_new @ Similarity.from_motor_scale(newest.world_T_camera)
    loop = LoopClosure(0, COUNT - 1, world_S_new, np.arange(SHARED), np.zeros((SHARED, 2)))
    closed = close_loop(slam_map, loop, CAMERA)
    assert closed.maps == (2, into)
    stretched = float(old_S_new.scale) if metric == "older" else 1.0
    np.testing.assert_allclose(closed.correction.scale, stretched)
    assert {one.map_number for one in slam_map.keyframes} == {into}
    found = [one.world_T_camera.as_matrix() for one in slam_map.keyframes]
    np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_allclose(slam_map.points, points, atol=1e-9)
    scales = [one.scale for one in slam_map.keyframes]
    np.testing.assert_allclose(scales, 1.0, atol=1e-9)


def test_one_map_goes_to_another_world_without_the_others(rng: np.random.Generator) -> None:
    slam_map, _, _ = _ring(rng)
    slam_map.metric = [False, False]
    half = COUNT // 2
    for keyframe in slam_map.keyframes[half:]:
        keyframe.map_number = 1
        keyframe.keep(keyframe.ids >= half * SHARED)
    points = slam_map.points.copy()
    poses = Motor.stack([one.world_T_camera for one in slam_map.keyframes])
    world_T_map = Similarity.from_twist([0.3, -0.2, 0.5, 1.0, 2.0, -1.0, 0.7])
    slam_map.rescale(1, world_T_map)
    found = Motor.stack([one.world_T_camera for one in slam_map.keyframes])
    mine = np.arange(COUNT) >= half
    np.testing.assert_array_equal(found[~mine].coefficients, poses[~mine].coefficients)
    places = world_T_map.apply(poses[mine].translation_m)
    np.testing.assert_allclose(found[mine].translation_m, places, atol=1e-9)
    own = np.arange(COUNT * SHARED) >= half * SHARED
    np.testing.assert_array_equal(slam_map.points[~own], points[~own])
    np.testing.assert_allclose(slam_map.points[own], world_T_map.apply(points[own]), atol=1e-9)


def test_points_behind_the_camera_tell_no_scale(rng: np.random.Generator) -> None:
    slam_map, count = SlamMap(), 20
    px = rng.uniform(0.0, 200.0, (count, 2))
    ids = slam_map.add_points(np.zeros((2 * count, 32), dtype=np.uint8))
    slam_map.points[:] = np.repeat([[0.0, 0.0, 2.0], [0.0, 0.0, -2.0]], count, axis=0)
    own = ids[count:]
    newest = Keyframe(0, Motor.identity(), own, px, np.full(count, np.nan), None)
    assert _scale_by_depths(slam_map, newest, Motor.identity(), ids[:count], px) is None
