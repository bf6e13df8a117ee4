"""Compiled equations of reprojection against differences, and what they refuse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import to_frame
from motorcade.tracking.native._least_squares import Lens, Sight, View, eliminate, invert
from motorcade.tracking.optimise import huber, huber_cauchy
from motorcade.tracking.slam.geometry import lens_of
from motorcade.tracking.slam.mapping.adjustment import Bundle, BundleReprojection

CAMERAS = (
    Camera(640, 480, 400.0, 410.0, 320.0, 240.0),
    Camera(640, 480, 400.0, 410.0, 320.0, 240.0, "radtan", (-0.2, 0.05, 1e-3, -1e-3, 0.02)),
    Camera(640, 480, 300.0, 310.0, 320.0, 240.0, "equidistant", (0.02, -0.01, 3e-3, -1e-3)),
)
K, P, FB, SIGMA = 4, 12, 32.0, 0.5
every_lens = pytest.mark.parametrize("camera", CAMERAS, ids=[one.model for one in CAMERAS])


def bundle_of(camera: Camera, rng: np.random.Generator) -> Bundle:
    """Pixels that are off, some far, and a depth for every second one."""
    poses = Motor.from_twist(0.1 * rng.normal(size=(K, 6)))
    points = rng.uniform((-1.5, -1.0, 3.0), (1.5, 1.0, 6.0), (P, 3))
    pose_of, point_of = (axis.ravel() for axis in np.meshgrid(np.arange(K), np.arange(P)))
    kept = rng.random(K * P) < 0.8
    pose_of, point_of = pose_of[kept], point_of[kept]
    there = np.array(
        [to_frame(poses[a], points[b]) for a, b in zip(pose_of, point_of, strict=True)]
    )
    px = camera.project(there) + rng.normal(0, 2.0, (len(there), 2))
    depth = there[:, 2] + rng.normal(0, 0.2, len(there))
    depth[::2] = np.nan
    fixed = np.array([False, True, False, False])
    return Bundle(poses, fixed, points, pose_of, point_of, px, depth, camera, FB, SIGMA)


def slopes(function: Callable[[FloatArray], FloatArray], count: int) -> FloatArray:
    """Derivatives ``(n, count)`` of numbers ``(n,)`` by a step ``(count,)``, by differences."""
    steps = 1e-6 * np.eye(count)
    return np.stack([(function(one) - function(-one)) / 2e-6 for one in steps], axis=-1)


def residuals(bundle: Bundle, step: FloatArray) -> FloatArray:
    """Of pixels and depths ``(n, 3)``, after a step of all poses and points."""
    poses = bundle.world_T_camera.retract(step[: 6 * K].reshape(K, 6))
    points = bundle.points + step[6 * K :].reshape(P, 3)
    there = np.array(
        [
            to_frame(poses[a], points[b])
            for a, b in zip(bundle.pose_of, bundle.point_of, strict=True)
        ]
    )
    px = bundle.camera.project(there) - bundle.px
    along = FB / SIGMA * (1.0 / there[:, 2] - 1.0 / bundle.depth)
    return np.concatenate([px, np.nan_to_num(along)[:, None]], axis=1)


@every_lens
def test_a_bundles_equations_are_those_of_differences(
    camera: Camera, rng: np.random.Generator
) -> None:
    bundle = bundle_of(camera, rng)
    seen = BundleReprojection(bundle, (bundle.world_T_camera, bundle.points))
    here = residuals(bundle, np.zeros(6 * K + 3 * P))
    size, along = np.linalg.norm(here[:, :2], axis=1), np.abs(here[:, 2])
    (of_px, weight), (of_depth, by_depth) = huber(size, 1.5), huber(along, 1.5)
    assert np.isclose(seen.cost, of_px.sum() + of_depth.sum())
    np.testing.assert_allclose(seen.error_px, size, atol=1e-9)
    jacobian = slopes(lambda step: residuals(bundle, step).ravel(), 6 * K + 3 * P)
    weighed = jacobian * np.stack([weight, weight, by_depth], axis=1).reshape(-1, 1)
    free = np.concatenate([np.repeat(~bundle.fixed, 6), np.ones(3 * P, np.bool_)])
    information, gradient = (weighed.T @ jacobian)[free][:, free], (weighed.T @ here.ravel())[free]
    kept = 6 * (K - 1)
    close = {"rtol": 1e-5, "atol": 1e-5 * np.abs(information).max()}
    ours = seen.equations
    np.testing.assert_allclose(ours.information, information[:kept, :kept], **close)
    np.testing.assert_allclose(ours.gradient, gradient[:kept], **close)
    np.testing.assert_allclose(ours.block_gradient.ravel(), gradient[kept:], **close)
    blocks = information[kept:, kept:].reshape(P, 3, P, 3)[np.arange(P), :, np.arange(P)]
    np.testing.assert_allclose(ours.blocks, blocks, **close)
    cross = information[kept:, :kept].reshape(P, 3, K - 1, 6)
    np.testing.assert_allclose(ours.coupling, cross[ours.block_of, :, ours.group_of], **close)


@every_lens
def test_a_poses_equations_are_those_of_differences(
    camera: Camera, rng: np.random.Generator
) -> None:
    pose = Motor.from_twist(0.1 * rng.normal(size=6))
    points = pose.apply(rng.uniform((-1.5, -1.0, 3.0), (1.5, 1.0, 6.0), (30, 3)))
    px = camera.project(to_frame(pose, points)) + rng.normal(0, 2.5, (30, 2))

    def off(step: FloatArray) -> FloatArray:
        return np.asarray(camera.project(to_frame(pose.retract(step), points)) - px)

    here, jacobian = off(np.zeros(6)), slopes(lambda step: off(step).ravel(), 6)
    view = View(lens_of(camera), points, px, 1.5, 3.0)
    matrix = pose.inverse().as_matrix()
    size = np.linalg.norm(here, axis=1)
    loss, weight = huber_cauchy(size, 1.5, 3.0)
    cost, error_px = view.evaluate(matrix)
    assert np.isclose(cost, loss.sum())
    np.testing.assert_allclose(error_px, size, atol=1e-9)
    for most_px, expected in ((np.inf, weight), (3.0, (size <= 3.0).astype(float))):
        information, gradient = view.linearise(matrix, most_px)
        weighed = jacobian * np.repeat(expected, 2)[:, None]
        close = {"rtol": 1e-5, "atol": 1e-5 * np.abs(information).max()}
        np.testing.assert_allclose(information, weighed.T @ jacobian, **close)
        np.testing.assert_allclose(gradient, weighed.T @ here.ravel(), **close)


def test_what_is_behind_a_pinhole_is_infinitely_far_off(rng: np.random.Generator) -> None:
    bundle = bundle_of(CAMERAS[0], rng)
    bundle.points[3, 2] = -4.0
    seen = BundleReprojection(bundle, (bundle.world_T_camera, bundle.points))
    assert np.array_equal(np.isinf(seen.error_px), bundle.point_of == 3)
    assert np.isfinite(seen.cost)
    view = View(lens_of(CAMERAS[0]), bundle.points, np.zeros((P, 2)), 1.5, 3.0)
    cost, error_px = view.evaluate(np.eye(4))
    assert np.array_equal(np.flatnonzero(np.isinf(error_px)), [3])
    assert np.isfinite(cost)
    assert np.isfinite(view.linearise(np.eye(4), np.inf)[0]).all()


@pytest.mark.parametrize("z", [-2.0, 0.0])
def test_what_is_straight_behind_a_fisheye_is_infinitely_far_off(z: float) -> None:
    """It would be drawn all around the image; not in its middle, where it was seen here."""
    lens, middle = lens_of(CAMERAS[2]), np.tile([320.0, 240.0], (3, 1))
    points = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, z], [0.1, 0.0, -2.0]])
    view = View(lens, points, middle, 1.5, 3.0)
    cost, error_px = view.evaluate(np.eye(4))
    assert error_px[0] == 0.0
    assert np.array_equal(np.isinf(error_px), [False, True, False])
    assert np.isfinite(cost)
    assert all(np.isfinite(one).all() for one in view.linearise(np.eye(4), np.inf))
    at, rows = np.zeros(3, np.int64), np.arange(3)
    seen = Sight(lens, at, rows, at[:1], middle, np.full(3, np.nan), 1.0, 1.5, 1e-3)
    cost, error_px = seen.evaluate(np.eye(4)[None], points)
    assert np.array_equal(np.isinf(error_px), [False, True, False])
    assert np.isfinite(cost)
    assert all(np.isfinite(one).all() for one in seen.linearise(np.eye(4)[None], points))


def test_lenses_that_are_not_known_are_refused() -> None:
    with pytest.raises(ValueError, match="model: expected pinhole, radtan or equidistant"):
        Lens("fov", 300.0, 300.0, 320.0, 240.0, ())


def test_rows_that_are_not_there_are_refused(rng: np.random.Generator) -> None:
    bundle = bundle_of(CAMERAS[0], rng)
    state = bundle.world_T_camera, bundle.points
    for name, wrong in (("pose_of", K), ("point_of", P), ("point_of", -1)):
        rows = getattr(bundle, name).copy()
        rows[5] = wrong
        with pytest.raises(ValueError, match=name):
            BundleReprojection(replace(bundle, **{name: rows}), state)
    own = bundle.pose_of, bundle.point_of, np.array([1, -1, 0, 2])
    sight = Sight(lens_of(CAMERAS[0]), *own, bundle.px, bundle.depth, 1.0, 1.5, 1e-3)
    with pytest.raises(ValueError, match="slot"):
        sight.linearise(bundle.world_T_camera.inverse().as_matrix(), bundle.points)
    inverted = invert(np.eye(3)[None])
    assert inverted is not None
    at, far = np.zeros(1, np.int64), np.array([2])
    for block_of, group_of in ((far, at), (at, far)):
        with pytest.raises(ValueError, match="expected a row that is there"):
            eliminate(
                inverted,
                np.zeros((1, 3)),
                block_of,
                group_of,
                np.ones((1, 3, 6)),
                np.eye(6),
                np.zeros(6),
            )


@pytest.mark.parametrize("size", [1, 2, 3, 6])
def test_inverses_of_blocks_are_inverses(size: int, rng: np.random.Generator) -> None:
    roots = rng.normal(size=(50, size, size))
    blocks = roots @ np.swapaxes(roots, -1, -2) + 1e-3 * np.eye(size)
    np.testing.assert_allclose(
        invert(blocks) @ blocks, np.eye(size) * np.ones((50, 1, 1)), atol=1e-9
    )
    blocks[7] = 0.0
    assert invert(blocks) is None
