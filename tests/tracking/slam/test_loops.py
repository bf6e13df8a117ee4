"""Closing a loop takes out the drift between two passes and moves the points along."""

import numpy as np

from motorcade.tracking.slam.geometry import exp, inverse, moved
from motorcade.tracking.slam.loops import Loop, close_loop
from motorcade.tracking.slam.map import Keyframe, SlamMap

COUNT, SHARED = 24, 12


def _ring(rng: np.random.Generator) -> tuple[SlamMap, np.ndarray, np.ndarray]:
    """Keyframes around a circle whose map drifts by the same small motion at every step.

    Returns:
        the map, the true camera_T_world ``(COUNT, 4, 4)``, and the true places of its points.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, COUNT)
    still = np.zeros(COUNT)
    truth = exp(np.stack([still, angle, still, still, still, still], axis=1))
    truth[:, :3, 3] += (0.0, 0.0, 1.0)
    # Along the axis of the circle: what drifts across it cancels over a full turn.
    drift = exp(np.array([0.0, 0.004, 0.0, 0.0, 0.01, 0.0]))
    slam_map, places = SlamMap(), []
    pose = truth[0]
    for row in range(COUNT):
        if row:
            pose = drift @ truth[row] @ inverse(truth[row - 1]) @ pose
        ids = slam_map.add_points(np.zeros((SHARED, 32), dtype=np.uint8))
        in_camera = rng.uniform((-1.0, -1.0, 2.0), (1.0, 1.0, 4.0), (SHARED, 3))
        slam_map.places[ids] = moved(inverse(pose), in_camera)
        places.append(moved(inverse(truth[row]), in_camera))
        seen = ids if row == 0 else np.concatenate([ids - SHARED, ids])
        px, depth = np.zeros((len(seen), 2)), np.full(len(seen), np.nan)
        slam_map.keyframes.append(Keyframe(row, pose, np.sort(seen), px, depth, None))
    return slam_map, truth, np.concatenate(places)


def _worst_m(slam_map: SlamMap, truth: np.ndarray) -> float:
    ours = inverse(np.stack([one.camera_T_world for one in slam_map.keyframes]))
    return float(np.linalg.norm(ours[:, :3, 3] - inverse(truth)[:, :3, 3], axis=1).max())


def test_a_closed_loop_takes_out_most_of_the_drift(rng: np.random.Generator) -> None:
    slam_map, truth, places = _ring(rng)
    before = _worst_m(slam_map, truth)
    points_before = np.linalg.norm(slam_map.places - places, axis=1).mean()
    ids = np.arange(SHARED)
    px = rng.uniform(0.0, 300.0, (SHARED, 2))
    close_loop(slam_map, Loop(0, COUNT - 1, truth[-1], ids, px))
    assert before > 0.1
    assert _worst_m(slam_map, truth) < before / 3.0
    assert np.linalg.norm(slam_map.places - places, axis=1).mean() < points_before / 3.0


def test_the_newest_keyframe_then_sees_the_old_points(rng: np.random.Generator) -> None:
    slam_map, truth, _ = _ring(rng)
    px = rng.uniform(0.0, 300.0, (SHARED, 2))
    close_loop(slam_map, Loop(0, COUNT - 1, truth[-1], np.arange(SHARED), px))
    newest = slam_map.keyframes[-1]
    assert np.array_equal(newest.ids, np.unique(newest.ids))
    assert np.array_equal(newest.px[np.isin(newest.ids, np.arange(SHARED))], px)
    assert len(newest.ids) == len(newest.px) == len(newest.depth)
