"""Poses fitted to points: what many of them in a row do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.optimise import huber_cauchy
from motorcade.tracking.slam.geometry import refine_pose

CAMERA = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(3).uniform([-1.0, -1.0, 2.0], [1.0, 1.0, 4.0], (50, 3))


def defect(motor: Motor) -> float:
    """How far a motor's rotation matrix is from an orthonormal one."""
    turn = motor.as_matrix()[:3, :3]
    return float(np.abs(turn.T @ turn - np.eye(3)).max())


def test_poses_stay_unit_motors_where_each_follows_its_keyframe(points: np.ndarray) -> None:
    """Every pose becomes a keyframe, the map moves that one, and the pose moves along."""
    true = pose = Motor.identity()
    for _ in range(60):
        before, keyframe = pose, pose.retract([1e-3, -2e-3, 1e-3, 2e-3, 1e-3, -1e-3])
        start = (keyframe @ before.inverse()) @ pose
        true = true @ Motor.from_twist([0.001, -0.002, 0.001, 0.002, 0.001, 0.0])
        px = CAMERA.project(true.inverse().apply(points))
        pose = refine_pose(start, points, px, CAMERA).world_T_camera
    assert defect(pose) < 1e-14
    assert np.abs(pose.local(true)).max() < 1e-6


def test_no_other_pose_near_fits_better(points: np.ndarray, rng: np.random.Generator) -> None:
    """SciPy, which knows no derivative, finds nothing better; some pixels are far off."""
    true = Motor.from_twist([0.05, -0.1, 0.02, 0.1, -0.2, 0.05])
    px = CAMERA.project(true.inverse().apply(points)) + rng.normal(0, 0.8, (50, 2))
    px[::9] += rng.uniform(-40.0, 40.0, px[::9].shape)
    found = refine_pose(Motor.identity(), points, px, CAMERA).world_T_camera

    def cost(step: np.ndarray) -> float:
        there = CAMERA.project(found.retract(step).inverse().apply(points))
        return float(huber_cauchy(np.linalg.norm(there - px, axis=1), 1.5, 3.0)[0].sum())

    around = np.concatenate([np.zeros((1, 6)), 1e-3 * np.eye(6)])
    options = {"initial_simplex": around, "xatol": 1e-7, "fatol": 1e-9, "maxiter": 1500}
    best = minimize(cost, around[0], method="Nelder-Mead", options=options)
    assert np.abs(best.x).max() < 1e-4
    assert cost(np.zeros(6)) < best.fun + 1e-4
