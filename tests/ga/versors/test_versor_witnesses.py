"""Rotors and motors against independent programs: clifford, scipy, gtsam, pytransform3d, mpmath."""

from typing import Any

import clifford
import gtsam
import mpmath
import numpy as np
import pytest
from pytransform3d import transformations
from scipy.linalg import expm
from scipy.spatial.transform import RigidTransform, Rotation

from motorcade.ga import Motor, Rotor


class Conformal:
    """Cl(4, 1) of clifford, with the basis of our coefficients built from its own products."""

    def __init__(self) -> None:
        self.layout, blades = clifford.Cl(4, 1)
        self.e1, self.e2, self.e3 = blades["e1"], blades["e2"], blades["e3"]
        self.infinity = blades["e4"] + blades["e5"]
        self.origin = 0.5 * (blades["e5"] - blades["e4"])
        pairs = [self.e2 ^ self.e3, self.e3 ^ self.e1, self.e1 ^ self.e2]
        flat = [e ^ self.infinity for e in (self.e1, self.e2, self.e3)]
        volume = self.e1 ^ self.e2 ^ self.e3
        self.motor_basis = [self.layout.scalar, *pairs, *flat, volume ^ self.infinity]
        self.log_basis = [*pairs, *flat]
        # The same as matrices of columns, to read coefficients back.
        self.columns = np.stack([blade.value for blade in self.motor_basis], axis=1)

    def motor(self, coefficients: np.ndarray) -> Any:
        return sum(float(c) * b for c, b in zip(coefficients, self.motor_basis, strict=True))

    def bivector(self, coefficients: np.ndarray) -> Any:
        return sum(float(c) * b for c, b in zip(coefficients, self.log_basis, strict=True))

    def coefficients(self, element: Any) -> np.ndarray:
        found, rest, *_ = np.linalg.lstsq(self.columns, element.value, rcond=None)
        assert np.all(rest < 1e-20)
        return found

    def point(self, x: np.ndarray) -> Any:
        vector = x[0] * self.e1 + x[1] * self.e2 + x[2] * self.e3
        return self.origin + vector + 0.5 * float(x @ x) * self.infinity

    def coordinates(self, point: Any) -> np.ndarray:
        """Of a point of weight one, which is not divided by: far away it has lost its digits."""
        return np.array([float((point | e).value[0]) for e in (self.e1, self.e2, self.e3)])

    def weight(self, point: Any) -> float:
        return -float((point | self.infinity).value[0])

    def exp(self, bivector: Any) -> Any:
        term = total = 1.0 + 0.0 * bivector
        for n in range(1, 40):
            term = term * bivector / n
            total = total + term
        return total


@pytest.fixture(scope="module")
def conformal() -> Conformal:
    return Conformal()


def test_infinity_and_origin_follow_the_convention(conformal: Conformal) -> None:
    assert float((conformal.infinity | conformal.origin).value[0]) == -1.0
    assert abs(conformal.infinity * conformal.infinity) == 0


def test_sandwich_product_in_cl41_is_apply(motors: Motor, conformal: Conformal) -> None:
    one = motors.reshape(-1)[0]
    versor, x = conformal.motor(one.coefficients), np.array([0.3, -1.2, 0.7])
    sandwich = versor * conformal.point(x) * ~versor
    moved = conformal.coordinates(sandwich)
    scale = max(1.0, float(np.max(np.abs(moved))))
    # A point at distance d carries d², so the witness itself loses digits far away.
    assert abs(conformal.weight(sandwich) - 1.0) < 1e-15 * scale**2
    np.testing.assert_allclose(one.apply(x), moved, rtol=0, atol=1e-14 * scale**2)


def test_products_in_cl41_are_compose_and_inverse(
    rng: np.random.Generator, conformal: Conformal
) -> None:
    a, b = Motor.random(rng), Motor.random(rng)
    product = conformal.motor(a.coefficients) * conformal.motor(b.coefficients)
    np.testing.assert_allclose((a @ b).coefficients, conformal.coefficients(product), atol=1e-15)
    reverse = ~conformal.motor(a.coefficients)
    np.testing.assert_allclose(
        a.inverse().coefficients, conformal.coefficients(reverse), atol=1e-15
    )


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.3, 2.0, np.pi])
def test_series_in_cl41_is_exp(
    angle: float, rng: np.random.Generator, conformal: Conformal
) -> None:
    log = rng.standard_normal(6)
    log[:3] *= 0.5 * angle / np.linalg.norm(log[:3])
    series = conformal.coefficients(conformal.exp(conformal.bivector(log)))
    np.testing.assert_allclose(Motor.exp(log).coefficients, series, rtol=0, atol=1e-14)


def test_rotor_and_translator_have_their_closed_forms(conformal: Conformal) -> None:
    axis, angle, shift = np.array([2.0, -1.0, 2.0]) / 3.0, 0.8, np.array([0.4, 1.5, -0.6])
    rotor = conformal.exp(-0.5 * angle * conformal.bivector(np.append(axis, [0, 0, 0])))
    vector = shift[0] * conformal.e1 + shift[1] * conformal.e2 + shift[2] * conformal.e3
    motor = (1 - 0.5 * vector * conformal.infinity) * rotor
    ours = Motor.from_rotor_translation(Rotor.from_rotation_vector(angle * axis), shift)
    np.testing.assert_allclose(ours.coefficients, conformal.coefficients(motor), atol=1e-15)


def test_scipy_reads_the_same_rotation(motors: Motor) -> None:
    rotor = motors.rotor.reshape(-1)
    witness = Rotation.from_quat(rotor.as_quaternion(), scalar_first=True)
    np.testing.assert_allclose(rotor.as_matrix(), witness.as_matrix(), rtol=0, atol=1e-14)
    np.testing.assert_allclose(rotor.angle(), witness.magnitude(), rtol=0, atol=1e-14)
    x = np.array([0.3, -1.2, 0.7])
    np.testing.assert_allclose(rotor.apply(x), witness.apply(x), rtol=0, atol=1e-14)


def test_scipy_reads_the_same_rotation_vector(motors: Motor) -> None:
    rotor = motors.rotor.reshape(-1)
    witness = Rotation.from_quat(rotor.as_quaternion(), scalar_first=True).as_rotvec()
    ours = rotor.as_rotation_vector()
    # At half a turn both signs are right.
    turned = np.where(np.linalg.norm(ours - witness, axis=1, keepdims=True) > 3, -1.0, 1.0)
    np.testing.assert_allclose(ours, turned * witness, rtol=1e-13, atol=1e-14)


def test_scipy_moves_points_alike(motors: Motor, rng: np.random.Generator) -> None:
    flat = motors.reshape(-1)
    points = rng.standard_normal((flat.shape[0], 3))
    witness = RigidTransform.from_matrix(flat.as_matrix())
    scale = max(1.0, float(np.max(np.abs(flat.translation_m))))
    np.testing.assert_allclose(
        flat.apply(points), witness.apply(points), rtol=0, atol=1e-14 * scale
    )


def test_scipy_exponentiates_twists_alike(rng: np.random.Generator) -> None:
    twists = rng.standard_normal((200, 6))
    twists[:, :3] *= np.geomspace(1e-9, 3, 200)[:, None]
    witness = RigidTransform.from_exp_coords(twists)
    np.testing.assert_allclose(
        Motor.from_twist(twists).as_matrix(), witness.as_matrix(), rtol=0, atol=1e-12
    )


def test_twist_is_the_logarithm_of_the_matrix(rng: np.random.Generator) -> None:
    for twist in rng.standard_normal((20, 6)):
        wx, wy, wz, *shift = twist
        generator = np.zeros((4, 4))
        generator[:3, :3] = [[0, -wz, wy], [wz, 0, -wx], [-wy, wx, 0]]
        generator[:3, 3] = shift
        np.testing.assert_allclose(
            Motor.from_twist(twist).as_matrix(), expm(generator), rtol=0, atol=1e-14
        )


def test_gtsam_exponentiates_and_takes_logarithms_alike(rng: np.random.Generator) -> None:
    twists = rng.standard_normal((100, 6))
    lengths = np.linalg.norm(twists[:, :3], axis=1, keepdims=True)
    twists[:, :3] *= np.linspace(1e-3, np.pi - 1e-2, 100)[:, None] / lengths
    motors = Motor.from_twist(twists)
    witness = np.stack([gtsam.Pose3.Expmap(twist).matrix() for twist in twists])
    np.testing.assert_allclose(motors.as_matrix(), witness, rtol=0, atol=1e-13)
    logs = np.stack([gtsam.Pose3.Logmap(gtsam.Pose3(matrix)) for matrix in witness])
    np.testing.assert_allclose(motors.as_twist(), logs, rtol=0, atol=1e-11)


def test_gtsam_interpolates_alike(rng: np.random.Generator) -> None:
    a, b = Motor.random(rng, (20,)), Motor.random(rng, (20,))
    for one, two in zip(a, b, strict=True):
        first, second = gtsam.Pose3(one.as_matrix()), gtsam.Pose3(two.as_matrix())
        witness = first.compose(gtsam.Pose3.Expmap(0.3 * gtsam.Pose3.Logmap(first.between(second))))
        np.testing.assert_allclose(
            one.interpolate(two, 0.3).as_matrix(), witness.matrix(), rtol=0, atol=1e-12
        )


def test_pytransform3d_reads_the_same_dual_quaternion(motors: Motor) -> None:
    for one in motors.reshape(-1)[:3]:
        witness = transformations.transform_from_dual_quaternion(one.as_dual_quaternion())
        scale = max(1.0, float(np.max(np.abs(witness))))
        np.testing.assert_allclose(one.as_matrix(), witness, rtol=0, atol=1e-13 * scale)


def test_pytransform3d_interpolates_screws_alike(rng: np.random.Generator) -> None:
    # Turns of less than π, where its way and ours cannot differ.
    start = Motor.random(rng)
    end = start @ Motor.from_twist([0.4, -1.1, 0.9, 2.0, 0.3, -0.5])
    for fraction in (0.0, 0.4, 1.0):
        witness = transformations.dual_quaternion_sclerp(
            start.as_dual_quaternion(), end.as_dual_quaternion(), fraction
        )
        ours = start.interpolate(end, fraction).as_dual_quaternion()
        np.testing.assert_allclose(ours, witness, rtol=0, atol=1e-13)


def exact_logarithm(motor: Motor) -> np.ndarray:
    """The closed form of the rigid logarithm in 60 digits, on the coefficients as stored."""
    with mpmath.workdps(60):
        w, v1, v2, v3, n1, n2, n3, last = (mpmath.mpf(float(c)) for c in motor.coefficients)
        if w < 0:
            w, v1, v2, v3, n1, n2, n3, last = (-c for c in (w, v1, v2, v3, n1, n2, n3, last))
        sine = mpmath.sqrt(v1**2 + v2**2 + v3**2)
        if sine == 0:
            return np.array([0.0, 0.0, 0.0, float(n1), float(n2), float(n3)])
        half = mpmath.atan2(sine, w)
        slope = (1 - half * w / sine) / sine**2
        pairs = ((v1, n1), (v2, n2), (v3, n3))
        turn = [half / sine * v for v, _ in pairs]
        shift = [half / sine * n + slope * last * v for v, n in pairs]
        return np.array([float(c) for c in (*turn, *shift)])


def test_logarithm_is_exact_to_rounding(motors: Motor) -> None:
    for one in motors.reshape(-1)[:5]:
        exact = exact_logarithm(one)
        scale = max(1.0, float(np.max(np.abs(exact))))
        np.testing.assert_allclose(one.log(), exact, rtol=0, atol=4e-15 * scale)
