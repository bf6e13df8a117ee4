"""Each from_… undoes its as_…, on every hard sample, and agrees with scipy where scipy has it."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga import Motor, Rotor, Versor
from motorcade.ga.versors.euler_angles import SEQUENCES
from tests.ga.cases import over

Distance = Callable[[Versor, Versor], float]
ROUNDING = 2e-14


def test_matrices_return(versors: Versor, distance: Distance) -> None:
    assert distance(type(versors).from_matrix(versors.as_matrix()), versors) < ROUNDING


def test_quaternions_return(motors: Motor) -> None:
    rotor = Rotor.from_quaternion(motors.rotor.as_quaternion())
    np.testing.assert_array_equal(rotor.coefficients, motors.rotor.coefficients)


def test_rotation_vectors_return(motors: Motor, distance: Distance) -> None:
    again = Rotor.from_rotation_vector(motors.rotor.as_rotation_vector())
    assert distance(again, motors.rotor) < ROUNDING


def test_quaternions_with_translations_return(motors: Motor, distance: Distance) -> None:
    again = Motor.from_quaternion_translation(*motors.as_quaternion_translation())
    assert distance(again, motors) < ROUNDING


def test_dual_quaternions_return(motors: Motor) -> None:
    again = Motor.from_dual_quaternion(motors.as_dual_quaternion())
    np.testing.assert_array_equal(again.coefficients, motors.coefficients)


def test_twists_return(motors: Motor, distance: Distance) -> None:
    assert distance(Motor.from_twist(motors.as_twist()), motors) < ROUNDING


def test_twist_is_minus_twice_the_logarithm(motors: Motor) -> None:
    np.testing.assert_array_equal(motors.as_twist(), -2 * motors.log())


@over(sequence=SEQUENCES)
def test_euler_angles_return(sequence: str, motors: Motor, distance: Distance) -> None:
    again = Motor.from_euler_translation(*motors.as_euler_translation(sequence), sequence)
    assert distance(again, motors) < ROUNDING


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_are_scipys(sequence: str, rng: np.random.Generator) -> None:
    angles = rng.uniform(-np.pi, np.pi, (200, 3))
    rotor = Rotor.from_euler(angles, sequence)
    witness = Rotation.from_euler(sequence.upper(), angles)  # scipy's intrinsic is upper case
    np.testing.assert_allclose(rotor.as_matrix(), witness.as_matrix(), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        rotor.as_euler(sequence), witness.as_euler(sequence.upper()), rtol=0, atol=1e-11
    )


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("off_lock", [0.0, 1e-15, 1e-9, 1e-6])
def test_euler_angles_return_at_gimbal_lock(
    sequence: str, off_lock: float, rng: np.random.Generator, distance: Distance
) -> None:
    angles = rng.uniform(-np.pi, np.pi, (50, 3))
    if sequence[0] == sequence[2]:
        angles[:, 1] = rng.choice([0, np.pi], 50) + off_lock
    else:
        angles[:, 1] = rng.choice([-np.pi / 2, np.pi / 2], 50) - off_lock
    rotor = Rotor.from_euler(angles, sequence)
    again = rotor.as_euler(sequence)
    assert distance(Rotor.from_euler(again, sequence), rotor) < ROUNDING
    if off_lock == 0.0:
        np.testing.assert_array_equal(again[:, 0], 0.0)


def test_xyz_turns_about_moved_axes_in_this_order() -> None:
    a, b, c = 0.3, -0.7, 1.1
    x, y, z = np.eye(3)
    about = [Rotor.from_rotation_vector(turn) for turn in (a * x, b * y, c * z)]
    product = about[0] @ about[1] @ about[2]
    np.testing.assert_allclose(
        Rotor.from_euler([a, b, c]).as_matrix(), product.as_matrix(), rtol=0, atol=1e-15
    )


def test_quaternion_of_a_rotor_is_the_right_handed_one() -> None:
    quarter = Rotor.from_quaternion([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
    np.testing.assert_allclose(quarter.apply([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(quarter.coefficients, [np.sqrt(0.5), 0, 0, -np.sqrt(0.5)])


def test_reading_the_dual_part_with_the_wrong_sign_is_caught() -> None:
    # The dual part is (m7, -m4, -m5, -m6); without the minus this motor's logarithm is off by 0.05.
    motor = Motor.from_twist([0.3, -0.2, 0.5, 0.4, 0.1, -0.3])
    wrong = motor.coefficients * [1, 1, 1, 1, -1, -1, -1, 1]
    assert np.max(np.abs(Motor.normalize(wrong).as_twist() - motor.as_twist())) > 0.05
    np.testing.assert_allclose(motor.as_twist(), [0.3, -0.2, 0.5, 0.4, 0.1, -0.3], atol=1e-15)


def test_matrices_printed_with_six_digits_are_read(rng: np.random.Generator) -> None:
    rotor = Rotor.random(rng, (100,))
    again = Rotor.from_matrix(np.round(rotor.as_matrix(), 6))
    assert np.max((again.inverse() @ rotor).angle()) < 2e-6
