"""A keyframe leaves the map where others see its points as well; what hung on it stays."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.ga import Motor, Similarity
from motorcade.tracking import Camera
from motorcade.tracking.slam.features import Corners
from motorcade.tracking.slam.geometry import in_world
from motorcade.tracking.slam.mapping.map import GONE, Keyframe, SlamMap
from motorcade.tracking.slam.mapping.mapper import cull, is_redundant
from motorcade.tracking.slam.mapping.matching import candidates
from motorcade.tracking.slam.results import KeyframeAnchor, RunLog

CAMERA = Camera(320, 240, 300.0, 300.0, 160.0, 120.0)
COUNT, STEP_NS = 6, 100_000_000
MIDDLE = 3


def along(rng: np.random.Generator, ahead_m: float = 0.0, step_ns: int = STEP_NS) -> SlamMap:
    """Keyframes that step to the side and all see the same; one stands nearer by `ahead_m`."""
    places = np.arange(COUNT)[:, None] * [0.02, 0.0, 0.0]
    places[MIDDLE, 2] += ahead_m
    slam_map = SlamMap()
    slam_map.metric = [True]
    ids = slam_map.add_points(rng.integers(0, 256, (50, 32), dtype=np.uint8))
    slam_map.points[ids] = rng.uniform((-0.4, -0.4, 2.0), (0.4, 0.4, 2.2), (50, 3))
    for row, pose in enumerate(Motor.from_translation(places)):
        px = CAMERA.project(slam_map.points - pose.translation_m)
        unknown = np.full(len(ids), np.nan)
        slam_map.keyframes.append(Keyframe(row * step_ns, pose, ids, px, unknown, None))
    return slam_map


def test_a_keyframe_whose_points_three_others_see_leaves_the_map(rng: np.random.Generator) -> None:
    slam_map = along(rng)
    culled = cull(slam_map, MIDDLE)
    assert culled is not None
    assert (culled.row, culled.kept) == (MIDDLE, MIDDLE - 1)
    assert slam_map.rows_of(0).tolist() == [0, 1, 2, 4, 5]
    assert slam_map.keyframe_rows.tolist() == [0, 1, 2, 4, 5]
    assert slam_map.keyframe_count == COUNT - 1
    assert slam_map.keyframes[MIDDLE].map_number == GONE
    assert len(slam_map.snapshot(0).time_ns) == COUNT - 1
    assert slam_map.located.all()


def test_what_it_sees_alone_keeps_it(rng: np.random.Generator) -> None:
    slam_map = along(rng)
    for row in (0, 1, 2):  # two others are left that see these: too few
        slam_map.keyframes[row].keep(slice(6, None))
    assert not is_redundant(slam_map, MIDDLE)
    slam_map = along(rng)
    for row in (0, 1, 2):
        slam_map.keyframes[row].keep(slice(5, None))  # a tenth, which may go
    assert is_redundant(slam_map, MIDDLE)


def test_who_stands_nearer_sees_what_others_do_not(rng: np.random.Generator) -> None:
    assert is_redundant(along(rng, ahead_m=0.2), MIDDLE)
    assert not is_redundant(along(rng, ahead_m=0.6), MIDDLE)


def test_points_that_nothing_else_sees_go_with_it(rng: np.random.Generator) -> None:
    slam_map = along(rng)
    for row in set(range(COUNT)) - {MIDDLE}:
        slam_map.keyframes[row].keep(slice(2, None))
    assert cull(slam_map, MIDDLE) is not None
    assert not slam_map.alive[:2].any()
    assert slam_map.alive[2:].all()


@pytest.mark.parametrize("row", [0, COUNT - 1])
def test_the_first_and_the_newest_stay(rng: np.random.Generator, row: int) -> None:
    slam_map = along(rng)
    assert is_redundant(slam_map, row)
    assert cull(slam_map, row) is None


def test_neighbours_are_not_left_far_apart_in_time(rng: np.random.Generator) -> None:
    assert cull(along(rng, step_ns=249_000_000), MIDDLE) is not None
    assert cull(along(rng, step_ns=251_000_000), MIDDLE) is None


@pytest.mark.parametrize("since_ns", [-STEP_NS * COUNT, -STEP_NS * 2, 0])
def test_stamps_of_another_session_are_not_compared(
    rng: np.random.Generator, since_ns: int
) -> None:
    """A stored map's clock is its own: what follows it may seem near in time, or earlier."""
    unknown = np.full(50, np.nan)
    slam_map = SlamMap.of(along(rng).snapshot(0))
    for row in range(COUNT):
        pose = Motor.from_translation([0.02 * (COUNT + row), 0.0, 0.0])
        px = CAMERA.project(slam_map.points - pose.translation_m)
        time_ns = COUNT * STEP_NS + since_ns + row * STEP_NS
        slam_map.keyframes.append(Keyframe(time_ns, pose, np.arange(50), px, unknown, None))
    for row in range(1, COUNT + 1):
        assert is_redundant(slam_map, row)
        assert cull(slam_map, row) is None, row
    assert cull(slam_map, COUNT + 1) is not None


def test_it_is_not_looked_for_any_more(rng: np.random.Generator) -> None:
    slam_map = along(rng)
    corners = Corners(slam_map.keyframes[MIDDLE].px, slam_map.descriptors)
    assert MIDDLE in candidates(slam_map, corners, COUNT)
    assert cull(slam_map, MIDDLE) is not None
    assert MIDDLE not in candidates(slam_map, corners, COUNT)


def test_its_frames_hang_on_its_neighbour_in_the_unit_that_is_valid_there(
    rng: np.random.Generator,
) -> None:
    slam_map, log = along(rng), RunLog()
    slam_map.metric = [False]
    keyframe, kept = (slam_map.keyframes[row] for row in (MIDDLE, MIDDLE - 1))
    frame = keyframe.world_T_camera @ Motor.from_twist([0.1, 0.0, 0.2, 0.3, 0.1, 0.0])
    anchor = KeyframeAnchor(MIDDLE, 0, keyframe.world_T_camera)
    log.note(MIDDLE * STEP_NS + 1, anchor, frame, np.eye(6), online=True)

    def told() -> tuple[Motor, np.ndarray]:
        result = log.result(slam_map, known=False, loops=[], seconds={})
        assert result.trajectory is not None
        return result.trajectory.motors[0], result.covariance[0]

    np.testing.assert_allclose(told()[0].coefficients, frame.coefficients, atol=1e-12)
    # A loop moves and stretches everything, before the keyframe goes and after.
    moves = Similarity.from_twist(rng.normal(size=(2, 7)) * 0.3)
    for row, world_S in enumerate(moves):
        frame = in_world(world_S, frame)
        for one in slam_map.keyframes:
            one.move(world_S @ Similarity.from_motor_scale(one.world_T_camera))
        slam_map.points[:] = world_S.apply(slam_map.points)
        if row == 0:
            culled = cull(slam_map, MIDDLE)
            assert culled is not None
            log.hang_on(culled)
            keyframe.world_T_camera = Motor.identity()  # nothing is told by it any more
    pose, covariance = told()
    np.testing.assert_allclose(pose.as_matrix(), frame.as_matrix(), atol=1e-12)
    stretch = float((moves[1] @ moves[0]).scale)
    units = np.repeat([1.0, stretch**2], 3)
    np.testing.assert_allclose(np.diag(covariance), units, rtol=1e-12)
    assert kept.scale == pytest.approx(stretch)
