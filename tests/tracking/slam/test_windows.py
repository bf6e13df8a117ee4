"""Windows of adjustment: amid the map after a loop, and where the camera was put elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.ga import Motor, Similarity
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import project
from motorcade.tracking.slam import SlamSettings
from motorcade.tracking.slam.features import SlamImage
from motorcade.tracking.slam.mapping import mapper as mapper_module
from motorcade.tracking.slam.mapping.loops import LoopClosure
from motorcade.tracking.slam.mapping.map import Keyframe, SlamMap
from motorcade.tracking.slam.mapping.mapper import Mapper

CAMERA = Camera(320, 240, 300.0, 300.0, 160.0, 120.0)
COUNT, WINDOW, NEW = 30, 6, 40
NOISE_PX, MOVED_M, MOVED_RAD = 0.2, 0.01, 0.003
PLACE_M = 0.2 * np.concatenate([np.arange(COUNT // 2), np.arange(COUNT // 2)[::-1] + 0.5])
SETTINGS = SlamSettings(window=WINDOW)
IMAGE = SlamImage(0, np.zeros((240, 320), np.uint8))


def _along(rng: np.random.Generator, place_m: np.ndarray = PLACE_M) -> tuple[SlamMap, Motor]:
    """Keyframes along a wall 2 m away; all but the first stand a little elsewhere."""
    truth = Motor.from_translation(place_m[:, None] * [1.0, 0.0, 0.0])
    slam_map = SlamMap()
    slam_map.metric = [True]
    far = place_m.max() + 1.0
    points = rng.uniform((-1.0, -0.7, 1.8), (far, 0.7, 2.4), (NEW * COUNT, 3))
    ids = slam_map.add_points(rng.integers(0, 256, (len(points), 32), dtype=np.uint8))
    step = rng.normal(size=(len(place_m), 6)) * np.repeat([MOVED_RAD, MOVED_M], 3)
    step[0] = 0.0
    for row, (pose, moved) in enumerate(zip(truth, truth.retract(step), strict=True)):
        px, _ = project(CAMERA, pose, points)
        seen = np.all((px > 0.0) & (px < (319.0, 239.0)), axis=1)
        noisy = px[seen] + rng.normal(0.0, NOISE_PX, (np.count_nonzero(seen), 2))
        keyframe = Keyframe(row, moved, ids[seen], noisy, np.full(len(noisy), np.nan), None)
        slam_map.keyframes.append(keyframe)
    slam_map.points[ids] = points + rng.normal(0.0, MOVED_M, points.shape)
    return slam_map, truth


def _error_px(slam_map: SlamMap) -> float:
    """RMS of all observations of located points."""
    errors = []
    for keyframe in slam_map.keyframes:
        good = slam_map.located[keyframe.ids]
        seen, _ = project(CAMERA, keyframe.world_T_camera, slam_map.points[keyframe.ids[good]])
        errors.append(seen - keyframe.px[good])
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


@pytest.fixture
def closing(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The newest keyframe closes a loop to the first; how many keyframes each adjustment moves."""
    pose = Similarity.from_motor_scale(Motor.from_translation([PLACE_M[-1], 0.0, 0.0]))
    found: list[LoopClosure] = []
    moved: list[int] = []
    adjust = mapper_module.adjust

    def counted(bundle, iterations):
        moved.append(int(np.count_nonzero(~bundle.fixed)))
        return adjust(bundle, iterations)

    def find_loop(slam_map: SlamMap, *_: object) -> LoopClosure | None:
        newest = slam_map.keyframes[-1]
        found.append(LoopClosure(0, COUNT - 1, pose, newest.ids, newest.px))
        return found[-1] if len(found) == 1 else None

    monkeypatch.setattr(mapper_module, "adjust", counted)
    monkeypatch.setattr(mapper_module, "find_loop", find_loop)
    monkeypatch.setattr(Mapper, "_fill", lambda *_: None)
    return moved


def _insert(mapper: Mapper, times: int) -> None:
    for _ in range(times):
        mapper.insert_keyframe(IMAGE, Motor.identity(), np.zeros(0, np.int64), np.zeros((0, 2)))


def test_no_keyframe_is_followed_by_more_than_a_window(
    rng: np.random.Generator, closing: list[int]
) -> None:
    slam_map, _ = _along(rng)
    mapper = Mapper(slam_map, CAMERA, SETTINGS)
    before = _error_px(slam_map)
    _insert(mapper, 1)
    assert len(closing) == 1
    _insert(mapper, 2 * COUNT // WINDOW)
    assert max(closing) <= WINDOW
    assert len(closing) <= 2 * COUNT // WINDOW
    assert before > 1.5
    assert _error_px(slam_map) < 2.0 * NOISE_PX


def test_windows_wait_while_the_camera_is_in_another_map(
    rng: np.random.Generator, closing: list[int]
) -> None:
    slam_map, _ = _along(rng)
    mapper = Mapper(slam_map, CAMERA, SETTINGS)
    _insert(mapper, 1)
    mapper.begin_map()
    _insert(mapper, 2 * COUNT // WINDOW)
    assert len(closing) == 1
    mapper.active = 0
    _insert(mapper, 2 * COUNT // WINDOW)
    assert _error_px(slam_map) < 2.0 * NOISE_PX


def test_no_point_is_lost_for_being_seen_once_in_a_window(
    rng: np.random.Generator, closing: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mapper_module, "_MOST_FIXED", 1)  # others see what the window's edges see
    slam_map, _ = _along(rng)
    seen = np.bincount(slam_map.observations(np.arange(COUNT))[1], minlength=NEW * COUNT)
    _insert(Mapper(slam_map, CAMERA, SETTINGS), 2 * COUNT // WINDOW)
    assert np.count_nonzero(seen >= 3) > 500
    assert np.mean(slam_map.located[seen >= 3]) > 0.99


def test_the_first_keyframe_stays_where_the_world_is(
    rng: np.random.Generator, closing: list[int]
) -> None:
    slam_map, truth = _along(rng)
    _insert(Mapper(slam_map, CAMERA, SETTINGS), 2 * COUNT // WINDOW)
    first, second = (slam_map.keyframes[row].world_T_camera for row in (0, 1))
    assert np.array_equal(first.coefficients, truth[0].coefficients)
    assert np.abs(second.local(truth[1])).max() < 0.6 * MOVED_M


def test_a_camera_put_back_is_held_by_the_keyframes_that_were_there(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those it was at just before see nothing of what it sees now, and are many."""
    monkeypatch.setattr(mapper_module, "_MOST_FIXED", 3)
    place_m = np.concatenate([0.2 * np.arange(8), 6.0 + 0.05 * np.arange(24), [2.0]])
    slam_map, truth = _along(rng, place_m)
    mapper = Mapper(slam_map, CAMERA, SETTINGS)
    mapper.adjust_all()
    newest = slam_map.keyframes[-1]
    seen = np.intersect1d(newest.ids, slam_map.keyframes[7].ids)
    seen = seen[slam_map.located[seen]]
    away = slam_map.keyframes[-2].world_T_camera
    newest.world_T_camera = newest.world_T_camera.retract([0.0, 0.0, 0.0, 0.02, 0.0, 0.02])
    mapper.adjust_window()
    assert len(seen) > 50
    assert np.mean(slam_map.located[seen]) > 0.95
    aligned = slam_map.keyframes[7].world_T_camera @ truth[7].inverse() @ truth[-1]
    assert np.linalg.norm(newest.world_T_camera.local(aligned)[3:]) < 0.01
    assert slam_map.keyframes[-2].world_T_camera is away  # nothing ties it to what is seen here
