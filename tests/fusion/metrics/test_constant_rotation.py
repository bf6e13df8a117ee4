"""A constant turn is told from errors of single poses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.metrics.poses.pose_error import constant_rotation
from motorcade.fusion.motions import handheld
from motorcade.ga import Motor, Rotor, Trajectory


@pytest.mark.parametrize("angle_rad", [1e-8, 0.005, 0.5, 3.0])
@pytest.mark.parametrize("side", ["world", "moving"])
def test_a_constant_turn_is_taken_out(angle_rad: float, side: str) -> None:
    rng = np.random.default_rng(1)
    true = Motor.random(rng, (50,))
    axis = np.array([0.6, -0.8, 0.0])
    turn = Motor.from_rotor_translation(Rotor.from_rotation_vector(angle_rad * axis), np.zeros(3))
    constant_rad, rest_rad = constant_rotation(
        turn @ true if side == "world" else true @ turn, true
    )
    assert constant_rad == pytest.approx(angle_rad, rel=1e-6)
    assert rest_rad.max() < 1e-9


def test_what_is_left_is_what_scipy_leaves_after_its_alignment() -> None:
    rng = np.random.default_rng(2)
    true = Motor.random(rng, (80,))
    noise = Rotor.from_rotation_vector(0.01 * rng.standard_normal((80, 3)))
    tilt = Rotor.from_rotation_vector([0.05, 0.02, -0.03])
    ours = Motor.from_rotor_translation(tilt @ noise @ true.rotor, np.zeros(3))
    constant_rad, rest_rad = constant_rotation(ours, true)
    apart = Rotation.from_matrix(true.rotor.as_matrix()) * (
        Rotation.from_matrix(ours.rotor.as_matrix()).inv()
    )
    mean = apart.mean()
    assert constant_rad == pytest.approx(mean.magnitude(), rel=1e-9)
    assert np.allclose(rest_rad, (apart * mean.inv()).magnitude(), atol=1e-9)


def test_an_evaluation_tells_both_parts() -> None:
    rng = np.random.default_rng(3)
    true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)
    turn = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.0, 0.01, 0.0]), np.zeros(3))
    found = evaluate(Trajectory(true.time_ns, turn @ true.motors), true).as_dict()
    assert found["rotation_constant_deg"] == pytest.approx(np.rad2deg(0.01))
    assert found["rotation_rmse_deg"] == pytest.approx(np.rad2deg(0.01))
    assert found["rotation_rest_rmse_deg"] == pytest.approx(0.0, abs=1e-9)
