"""The adjustment against a general factor graph (gtsam) on the same problem."""

import gtsam
import numpy as np
import pytest

from motorcade.ga import Motor, progress
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import project
from motorcade.tracking.slam.mapping.adjustment import Bundle, adjust

CAMERA = Camera(640, 480, 400.0, 400.0, 320.0, 240.0)
FB, SIGMA = 32.0, 0.5


def _problem(rng: np.random.Generator, with_depth: bool) -> tuple[Bundle, Motor]:
    """Five cameras, eighty points, noisy pixels, a start that is off; and the true poses."""
    k, p = 5, 80
    steps = np.concatenate([rng.normal(0, 0.05, (k, 3)), rng.uniform(-0.5, 0.5, (k, 3))], axis=1)
    truth = Motor.from_twist(steps)
    points = rng.uniform((-1.5, -1.0, 3.0), (1.5, 1.0, 6.0), (p, 3))
    pose_of, point_of = (axis.ravel() for axis in np.meshgrid(np.arange(k), np.arange(p)))
    seen = [
        project(CAMERA, truth[a], points[b : b + 1]) for a, b in zip(pose_of, point_of, strict=True)
    ]
    px = np.concatenate([one[0] for one in seen]) + rng.normal(0, 0.3, (k * p, 2))
    disparity = FB / np.concatenate([one[1] for one in seen]) + rng.normal(0, 0.1, k * p)
    depth = FB / disparity if with_depth else np.full(k * p, np.nan)
    fixed = np.arange(k) < 2  # two fixed poses hold the scale
    start = truth.retract(rng.normal(0, 0.01, (k, 6)) * ~fixed[:, None])
    off = points + rng.normal(0, 0.05, points.shape)
    bundle = Bundle(start, fixed, off, pose_of, point_of, px, depth, CAMERA, FB, SIGMA)
    return bundle, truth


def _by_gtsam(bundle: Bundle) -> tuple[np.ndarray, np.ndarray]:
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    lens = gtsam.Cal3_S2(400.0, 400.0, 0.0, 320.0, 240.0)
    noise = gtsam.noiseModel.Isotropic.Sigma(2, 1.0)
    robust = gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Huber.Create(1.5), noise)
    for row, pose in enumerate(bundle.world_T_camera.as_matrix()):
        values.insert(row, gtsam.Pose3(pose))
        if bundle.fixed[row]:
            graph.add(gtsam.NonlinearEqualityPose3(row, gtsam.Pose3(pose)))
    for row, point in enumerate(bundle.points):
        values.insert(1000 + row, point)
    for a, b, px in zip(bundle.pose_of, bundle.point_of, bundle.px, strict=True):
        graph.add(gtsam.GenericProjectionFactorCal3_S2(px, robust, int(a), 1000 + int(b), lens))
    result = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    poses = np.stack([result.atPose3(row).matrix() for row in range(len(bundle.fixed))])
    return poses, np.stack([result.atPoint3(1000 + r) for r in range(len(bundle.points))])


def test_pixels_alone_give_what_gtsam_gives(rng: np.random.Generator) -> None:
    bundle, _ = _problem(rng, with_depth=False)
    bundle.px[::37] += 20.0  # outliers, which both weigh down alike
    ours = adjust(bundle, iterations=100)
    poses, points = _by_gtsam(bundle)
    assert ours.cost < ours.before
    assert np.abs(ours.world_T_camera.as_matrix() - poses).max() < 1e-3
    assert np.median(np.abs(ours.points - points)) < 1e-3


@pytest.mark.parametrize("fixed", [1, 2])
def test_depth_holds_the_scale(rng: np.random.Generator, fixed: int) -> None:
    bundle, truth = _problem(rng, with_depth=True)
    bundle.fixed[:] = np.arange(len(truth)) < fixed
    ours = adjust(bundle, iterations=50)
    still = ours.world_T_camera[:fixed], bundle.world_T_camera[:fixed]
    assert np.array_equal(*(one.coefficients for one in still))
    apart = ours.world_T_camera[4].translation_m - truth[4].translation_m
    assert np.linalg.norm(apart) < 0.01
    assert np.median(ours.error_px) < 0.6


def test_a_whole_map_says_how_far_its_adjustment_is(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "LINE_EVERY_S", -1.0)
    for steps, said in ((8, False), (20, True)):
        adjust(_problem(rng, True)[0], steps)
        assert ("adjusting the map: 1 of " in capsys.readouterr().err) == said
