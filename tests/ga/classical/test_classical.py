"""The classical formulas are right: their own laws hold, and scipy and the motors agree."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from motorcade.ga import Motor, Rotor
from motorcade.ga.classical.dual_quaternion import (
    dual_quaternion_apply,
    dual_quaternion_as_quaternion_translation,
    dual_quaternion_blend,
    dual_quaternion_conjugate,
    dual_quaternion_from_quaternion_translation,
    dual_quaternion_multiply,
    dual_quaternion_normalize,
    dual_quaternion_screw,
)
from motorcade.ga.classical.euler import interpolate_euler
from motorcade.ga.classical.quaternion import (
    quaternion_apply,
    quaternion_as_matrix,
    quaternion_conjugate,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    quaternion_multiply,
    quaternion_nlerp,
    quaternion_normalize,
    quaternion_slerp,
)
from motorcade.ga.versors.euler_angles import euler_from_matrix, matrix_from_euler


def test_quaternions_are_scipys(motors: Motor, rng: np.random.Generator) -> None:
    q = motors.rotor.reshape(-1).as_quaternion()
    p = Rotor.random(rng, q.shape[:1]).as_quaternion()
    ours, theirs = (Rotation.from_quat(x, scalar_first=True) for x in (q, p))
    np.testing.assert_allclose(quaternion_as_matrix(q), ours.as_matrix(), rtol=0, atol=1e-14)
    product = quaternion_as_matrix(quaternion_multiply(q, p))
    np.testing.assert_allclose(product, (ours * theirs).as_matrix(), rtol=0, atol=1e-14)
    x = rng.standard_normal((len(q), 3))
    np.testing.assert_allclose(quaternion_apply(q, x), ours.apply(x), rtol=0, atol=1e-14)
    returned = quaternion_as_matrix(quaternion_from_matrix(ours.as_matrix()))
    np.testing.assert_allclose(returned, ours.as_matrix(), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        quaternion_multiply(q, quaternion_conjugate(q)),
        np.tile(np.eye(4)[0], (len(q), 1)),
        atol=1e-15,
    )


def test_rotation_vectors_become_scipys_quaternions(rng: np.random.Generator) -> None:
    vectors = rng.standard_normal((100, 3)) * np.geomspace(1e-12, 3, 100)[:, None]
    np.testing.assert_allclose(
        quaternion_from_rotation_vector(vectors),
        Rotation.from_rotvec(vectors).as_quat(scalar_first=True, canonical=False),
        rtol=0,
        atol=1e-15,
    )


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 3e-8, 1e-3, 1.0, np.pi - 1e-6])
def test_slerp_is_scipys(angle: float, rng: np.random.Generator) -> None:
    start = Rotor.random(rng)
    axis = rng.standard_normal(3)
    end = start @ Rotor.from_rotation_vector(angle * axis / np.linalg.norm(axis))
    witness = Slerp(
        [0, 1],
        Rotation.from_quat(
            np.stack([start.as_quaternion(), end.as_quaternion()]), scalar_first=True
        ),
    )
    fractions = np.linspace(0, 1, 9)
    path = quaternion_slerp(start.as_quaternion(), end.as_quaternion(), fractions)
    np.testing.assert_allclose(
        quaternion_as_matrix(path), witness(fractions).as_matrix(), rtol=0, atol=1e-14
    )


def test_slerp_takes_the_short_way_only_when_asked(rng: np.random.Generator) -> None:
    q = Rotor.from_rotation_vector([0.0, 0.0, 1.0]).as_quaternion()
    here = np.array([1.0, 0.0, 0.0, 0.0])
    short, long = quaternion_slerp(here, -q, 0.5), quaternion_slerp(here, -q, 0.5, short_way=False)
    assert 2 * np.arccos(abs(short[0])) == pytest.approx(0.5)
    assert 2 * np.arccos(abs(long[0])) == pytest.approx(np.pi - 0.5)


def test_nlerp_follows_the_path_of_slerp_at_another_speed(rng: np.random.Generator) -> None:
    a, b = (Rotor.random(rng, (50,)).as_quaternion() for _ in range(2))
    np.testing.assert_allclose(
        quaternion_nlerp(a, b, 0.5), quaternion_slerp(a, b, 0.5), rtol=0, atol=1e-14
    )
    early, even = quaternion_nlerp(a, b, 0.2), quaternion_slerp(a, b, 0.2)
    assert np.max(np.abs(early - even)) > 1e-3
    normals = np.linalg.svd(np.stack([a, b, early], axis=1))[1]
    np.testing.assert_allclose(normals[:, 2], 0.0, atol=1e-14)


def test_dual_quaternions_move_as_motors_do(motors: Motor, rng: np.random.Generator) -> None:
    q = motors.as_dual_quaternion()
    other = Motor.random(rng, motors.shape)
    scale = max(1.0, float(np.max(np.abs(q))))
    product = dual_quaternion_multiply(q, other.as_dual_quaternion())
    witness = (motors @ other).as_dual_quaternion()
    np.testing.assert_allclose(product, witness, rtol=0, atol=1e-14 * scale)
    x = rng.standard_normal((*motors.shape, 3))
    np.testing.assert_allclose(
        dual_quaternion_apply(q, x), motors.apply(x), rtol=0, atol=1e-14 * scale
    )
    undone = dual_quaternion_multiply(q, dual_quaternion_conjugate(q))
    np.testing.assert_allclose(undone - np.eye(8)[0], np.zeros_like(q), atol=1e-14 * scale)
    again = dual_quaternion_from_quaternion_translation(
        *dual_quaternion_as_quaternion_translation(q)
    )
    np.testing.assert_allclose(again, q, rtol=0, atol=1e-14 * scale)


def test_screw_interpolation_is_the_motors(motors: Motor, rng: np.random.Generator) -> None:
    start = Motor.random(rng, motors.shape)
    screw = dual_quaternion_screw(start.as_dual_quaternion(), motors.as_dual_quaternion(), 0.3)
    witness = start.interpolate(motors, 0.3).as_dual_quaternion()
    scale = max(1.0, float(np.max(np.abs(witness))))
    np.testing.assert_allclose(screw, witness, rtol=0, atol=1e-13 * scale)


def test_linear_blending_is_the_projected_sum_of_motors(rng: np.random.Generator) -> None:
    motors = Motor.random(rng, (40, 4))
    weights = rng.dirichlet(np.ones(4), 40)
    blend = dual_quaternion_blend(motors.as_dual_quaternion(), weights)
    pivot = motors.coefficients[:, :1, :4]
    signs = np.where(np.sum(pivot * motors.coefficients[..., :4], axis=-1) < 0, -1.0, 1.0)
    total = np.sum((signs * weights)[..., None] * motors.coefficients, axis=1)
    np.testing.assert_allclose(
        Motor.normalize(total).as_dual_quaternion(), blend, rtol=0, atol=1e-13
    )


def test_linear_blending_does_not_depend_on_signs(rng: np.random.Generator) -> None:
    q = Motor.random(rng, (20, 3)).as_dual_quaternion()
    weights = rng.dirichlet(np.ones(3), 20)
    flipped = q * rng.choice([-1.0, 1.0], (20, 1, 1)) * np.array([1.0, -1.0, -1.0])[:, None]
    one, two = dual_quaternion_blend(q, weights), dual_quaternion_blend(flipped, weights)
    same = np.minimum(np.abs(one - two).max(axis=1), np.abs(one + two).max(axis=1))
    np.testing.assert_allclose(same, 0.0, atol=1e-13)


def test_weights_must_fit_the_poses() -> None:
    with pytest.raises(ValueError, match=r"weights: expected \(\*, K\)"):
        dual_quaternion_blend(np.tile(np.eye(8)[0], (3, 1)), [0.5, 0.5])


def test_zero_has_no_direction() -> None:
    with pytest.raises(ValueError, match="non-zero"):
        quaternion_normalize(np.zeros(4))
    with pytest.raises(ValueError, match="non-zero real part"):
        dual_quaternion_normalize(np.zeros(8))


@pytest.mark.parametrize(
    ("start", "end", "longer"),
    [
        ((10, 85, 10), (-170, 85, -160), 24.7),
        ((0, 89.9, 0), (170, 89.9, 170), 17.0),
        ((0, 45, 0), (180, 45, -180), 1.53),
        ((0, 89, 0), (90, 89, 0), 1.00),
    ],
)
def test_euler_angles_wander_near_gimbal_lock(
    start: tuple[float, ...], end: tuple[float, ...], longer: float
) -> None:
    first, last = np.deg2rad(start), np.deg2rad(end)
    fractions = np.linspace(0, 1, 1001)
    path = Rotor.from_euler(interpolate_euler(first, last, fractions))
    geodesic = float((path[0].inverse() @ path[-1]).angle())
    ratio = float((path[:-1].inverse() @ path[1:]).angle().sum()) / geodesic
    assert ratio == pytest.approx(longer, rel=0.01)
    straight = path[0].interpolate(path[-1], fractions)
    assert float((straight[:-1].inverse() @ straight[1:]).angle().sum()) == pytest.approx(geodesic)


def test_euler_interpolation_does_not_wrap() -> None:
    almost, beyond = np.deg2rad([179.0, 0.0, 0.0]), np.deg2rad([-179.0, 0.0, 0.0])
    np.testing.assert_allclose(interpolate_euler(almost, beyond, 0.5), 0.0, atol=1e-15)


def test_euler_matrices_refuse_wrong_shapes() -> None:
    with pytest.raises(ValueError, match=r"angles_rad: expected shape \(\*, 3\)"):
        matrix_from_euler([1.0, 2.0])
    with pytest.raises(ValueError, match=r"matrix: expected shape \(\*, 3, 3\)"):
        euler_from_matrix(np.eye(2))


def test_screws_without_a_turn_are_straight_and_even(rng: np.random.Generator) -> None:
    wxyz = Rotor.random(rng).as_quaternion()
    start, end = rng.standard_normal((2, 3))
    pair = [dual_quaternion_from_quaternion_translation(wxyz, t) for t in (start, end)]
    fractions = np.array([-0.5, 0.0, 0.25, 1.0, 2.0])
    made = dual_quaternion_screw(pair[0], pair[1], fractions)
    turned, moved = dual_quaternion_as_quaternion_translation(made)
    np.testing.assert_allclose(turned, np.tile(wxyz, (5, 1)), rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        moved, start + fractions[:, None] * (end - start), rtol=0, atol=1e-14
    )


@pytest.mark.parametrize("size", [1e-300, 1e-200, 1e200, 1e300])
def test_normalize_takes_numbers_whose_squares_no_float_holds(size: float) -> None:
    given = np.array([3.0, 0.0, 0.0, 4.0, 4.0, 1.0, 2.0, -3.0])
    for normalize, count in ((quaternion_normalize, 4), (dual_quaternion_normalize, 8)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = normalize(size * given[:count])
        np.testing.assert_allclose(found, normalize(given[:count]), rtol=1e-15)
