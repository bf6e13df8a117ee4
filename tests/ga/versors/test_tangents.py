"""Adjoint, Jacobians of exp, retract and local: laws on hard samples, and witnesses."""

from collections.abc import Callable
from functools import partial
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor

Distance = Callable[[Versor, Versor], float]
ROUNDING = 4e-14
ANGLES = (0.0, 1e-300, 1e-12, 1e-8, 1e-4, 1e-2, 0.3, 1.0, 3.0, np.pi - 1e-9, np.pi, 3.3, 6.0, 11.0)
LOG_SCALES = (0.0, 1e-300, -1e-13, 1e-7, -1e-3, 0.4, 0.99, -1.01, 3.0, -6.0, 20.0, -20.0)


def exp_of(kind: type[Versor], twist: np.ndarray) -> Versor:
    return kind.identity(twist.shape[:-1]).astype(twist.dtype).retract(twist)


def hard_twists(kind: type[Versor], rng: np.random.Generator) -> np.ndarray:
    """Twists of every angle and, of similarities, every scale, two each."""
    size = kind.identity().log().size
    scales = LOG_SCALES if kind is Similarity else (0.0,)
    twists = rng.standard_normal((2, len(ANGLES), len(scales), size))
    length = np.linalg.norm(twists[..., :3], axis=-1, keepdims=True)
    twists[..., :3] *= np.reshape(ANGLES, (-1, 1, 1)) / length
    twists[..., 6:] = np.reshape(scales, (-1, 1))
    return twists.reshape(-1, size)


def of_size(twists: np.ndarray) -> float:
    return max(1.0, float(np.max(np.abs(twists), initial=0.0)))


def carried(matrix: np.ndarray, twist: np.ndarray) -> np.ndarray:
    return (matrix @ twist[..., None])[..., 0]


def test_local_undoes_retract_up_to_half_a_turn(versors: Versor, rng: np.random.Generator) -> None:
    size = versors.log().shape[-1]
    for angle in (1e-12, 1e-6, 0.1, 1.0, 3.1):
        twist = rng.uniform(-1.0, 1.0, (*versors.shape, size))
        twist[..., :3] *= angle / np.linalg.norm(twist[..., :3], axis=-1, keepdims=True)
        reach = of_size(versors.coefficients) ** 2
        moved = versors.retract(twist)
        np.testing.assert_allclose(versors.local(moved), twist, rtol=0, atol=ROUNDING * reach)


def test_retract_undoes_local(versors: Versor, others: Versor, distance: Distance) -> None:
    back = versors.retract(versors.local(others))
    assert distance(back, others) < ROUNDING * of_size(versors.coefficients)


def test_retract_moves_on_the_right(versors: Versor, distance: Distance) -> None:
    twist = np.full(versors.log().shape[-1], 0.3)
    step = exp_of(type(versors), twist)
    assert distance(versors.retract(twist), versors @ step) < ROUNDING


def test_twists_of_all_types_are_those_of_from_twist(rng: np.random.Generator) -> None:
    turn, rigid, growing = (rng.standard_normal((5, size)) for size in (3, 6, 7))
    for ours, witness in (
        (exp_of(Rotor, turn), Rotor.from_rotation_vector(turn)),
        (exp_of(Motor, rigid), Motor.from_twist(rigid)),
        (exp_of(Similarity, growing), Similarity.from_twist(growing)),
    ):
        np.testing.assert_allclose(ours.coefficients, witness.coefficients, rtol=0, atol=1e-14)
    poses = Motor.from_twist(0.1 * rigid)
    np.testing.assert_allclose(Motor.identity().local(poses), poses.as_twist(), rtol=0, atol=1e-15)


def test_adjoint_carries_a_motion_to_the_other_side(
    versors: Versor, rng: np.random.Generator, distance: Distance
) -> None:
    twist = rng.uniform(-0.5, 0.5, versors.log().shape)
    there = carried(versors.adjoint(), twist)
    step = exp_of(type(versors), twist)
    assert distance(exp_of(type(versors), there) @ versors, versors @ step) < ROUNDING


def test_transform_twist_is_the_adjoint(versors: Versor, rng: np.random.Generator) -> None:
    twist = rng.standard_normal(versors.log().shape)
    there = versors.transform_twist(twist)
    witness = carried(versors.adjoint(), twist)
    np.testing.assert_allclose(there, witness, rtol=0, atol=1e-14 * of_size(witness))


def test_adjoint_of_a_product_is_the_product_of_adjoints(versors: Versor, others: Versor) -> None:
    product = versors.adjoint() @ others.adjoint()
    np.testing.assert_allclose(
        (versors @ others).adjoint(), product, rtol=0, atol=ROUNDING * of_size(product)
    )


def test_adjoint_of_the_negative_versor_is_the_same(versors: Versor) -> None:
    negative = type(versors)(-versors.coefficients)
    np.testing.assert_array_equal(negative.adjoint(), versors.adjoint())


def test_left_jacobian_is_the_adjoint_times_the_right_one(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    for twist in hard_twists(kind, rng):
        left, right = kind.left_jacobian(twist), kind.right_jacobian(twist)
        product = exp_of(kind, twist).adjoint() @ right
        size = of_size(exp_of(kind, twist).adjoint()) * of_size(right)
        np.testing.assert_allclose(product, left, rtol=0, atol=1e-13 * size)


def test_inverse_jacobians_invert(kind: type[Versor], rng: np.random.Generator) -> None:
    twists = hard_twists(kind, rng)
    for jacobian, inverse in (
        (kind.left_jacobian(twists), kind.left_jacobian_inverse(twists)),
        (kind.right_jacobian(twists), kind.right_jacobian_inverse(twists)),
    ):
        size = np.max(np.abs(jacobian), axis=(1, 2)) * np.max(np.abs(inverse), axis=(1, 2))
        rest = jacobian @ inverse - np.eye(twists.shape[-1])
        assert np.max(np.max(np.abs(rest), axis=(1, 2)) / size) < 1e-14


def test_local_changes_by_the_inverse_jacobians(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    """``local(a exp(x), b exp(y))``, by central differences."""
    a, b = kind.random(rng, (20,)), kind.random(rng, (20,))
    twist, size = a.local(b), a.log().shape[-1]
    by_base, by_target = -kind.left_jacobian_inverse(twist), kind.right_jacobian_inverse(twist)
    h = 1e-5
    for k, step in enumerate(h * np.eye(size)):
        ahead, behind = a.retract(step).local(b), a.retract(-step).local(b)
        np.testing.assert_allclose((ahead - behind) / (2 * h), by_base[..., k], atol=1e-6)
        ahead, behind = a.local(b.retract(step)), a.local(b.retract(-step))
        np.testing.assert_allclose((ahead - behind) / (2 * h), by_target[..., k], atol=1e-6)


def bracket(twist: np.ndarray) -> Any:
    """The commutator with a twist as a matrix of mpmath numbers."""
    size = len(twist)
    made = mp.zeros(size)
    blocks = [(0, 0, 0)] if size == 3 else [(0, 0, 0), (3, 3, 0), (3, 0, 3)]
    for row, column, of in blocks:
        x, y, z = (mp.mpf(float(value)) for value in twist[of : of + 3])
        for (i, j), value in {(1, 0): z, (0, 2): y, (2, 1): x}.items():
            made[row + i, column + j], made[row + j, column + i] = value, -value
    if size == 7:
        for i in range(3, 6):
            made[i, i] = mp.mpf(float(twist[6]))
            made[i, 6] = -mp.mpf(float(twist[i]))
    return made


def series_jacobian(twist: np.ndarray) -> Any:
    """``Σ adⁿ / (n + 1)!`` at 50 digits, of a part of the twist, doubled until it is the whole."""
    halvings = 8
    ad = bracket(twist) / 2**halvings
    term, total = mp.eye(len(twist)), mp.zeros(len(twist))
    for n in range(1, 28):
        total += term
        term = term * ad / (n + 1)
    for _ in range(halvings):
        total, ad = total + ad * total * total / 2, 2 * ad
    return total


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_jacobians_are_the_series_of_the_commutator_to_their_rounding(
    kind: type[Versor], dtype: Any, rng: np.random.Generator
) -> None:
    epsilon = float(np.finfo(dtype).eps)
    twists = hard_twists(kind, rng)[:: 7 if kind is Similarity else 2]
    if dtype == np.float32:
        twists = twists[np.abs(twists[:, -1]) < 10.0]
    twists = twists.astype(dtype)
    ours, inverse = kind.left_jacobian(twists), kind.left_jacobian_inverse(twists)
    assert ours.dtype == inverse.dtype == dtype
    with mp.workdps(50):
        for twist, made, back in zip(twists, ours, inverse, strict=True):
            exact = series_jacobian(twist)
            witness = np.array(exact.tolist(), dtype=float)
            # Growth takes a factor of its logarithm where the block of turns to shifts cancels.
            allowed = (4 + 2 * abs(twist[6] if kind is Similarity else 0)) * epsilon
            assert np.max(np.abs(made - witness)) < allowed * np.max(np.abs(witness))
            witness = np.array((exact**-1).tolist(), dtype=float)
            condition = np.max(np.abs(witness))
            assert np.max(np.abs(back - witness)) < allowed * condition * (1 + condition)


def test_jacobians_keep_all_digits_near_zero(kind: type[Versor]) -> None:
    """To first order ``1 ± ½ ad``: entries as small as the twist keep their relative precision."""
    size = kind.identity().log().size
    for scale in (1e-300, 1e-20, 1e-9):
        twist = scale * np.array([0.3, -0.2, 0.7, 1.1, -0.5, 0.4, 0.9])[:size]
        first = np.array(bracket(twist).tolist(), dtype=float)
        off = ~np.eye(size, dtype=bool)
        for jacobian, share in (
            (kind.left_jacobian, 0.5),
            (kind.right_jacobian, -0.5),
            (kind.left_jacobian_inverse, -0.5),
            (kind.right_jacobian_inverse, 0.5),
        ):
            made = jacobian(twist)[off]
            np.testing.assert_allclose(made, share * first[off], rtol=2e-9, atol=scale**2)


def test_gtsam_agrees_on_rigid_motions(motors: Motor) -> None:
    gtsam = pytest.importorskip("gtsam")
    for motor in motors.reshape(-1):
        pose = gtsam.Pose3(motor.as_matrix())
        np.testing.assert_allclose(
            motor.adjoint(), pose.AdjointMap(), rtol=0, atol=1e-14 * of_size(pose.AdjointMap())
        )


def test_gtsam_agrees_on_jacobians(rng: np.random.Generator) -> None:
    gtsam = pytest.importorskip("gtsam")
    for angle in (1e-3, 0.1, 1.0, 2.0, 3.1):
        twist = rng.standard_normal(6)
        twist[:3] *= angle / np.linalg.norm(twist[:3])
        close = partial(np.testing.assert_allclose, rtol=0, atol=1e-9)
        close(Motor.right_jacobian(twist), gtsam.Pose3.ExpmapDerivative(twist))
        pose = gtsam.Pose3.Expmap(twist)
        close(Motor.right_jacobian_inverse(twist), gtsam.Pose3.LogmapDerivative(pose))
        close(Rotor.right_jacobian(twist[:3]), gtsam.Rot3.ExpmapDerivative(twist[:3]))
        close(Motor.identity().retract(twist).as_matrix(), pose.matrix())


def test_one_twist_serves_a_whole_batch(kind: type[Versor], rng: np.random.Generator) -> None:
    many, size = kind.random(rng, (4, 3)), kind.identity().log().size
    twist = rng.standard_normal(size)
    assert many.retract(twist).shape == (4, 3)
    assert many.transform_twist(twist).shape == (4, 3, size)
    assert many[0, 0].local(many).shape == (4, 3, size)
    assert many.adjoint().shape == (4, 3, size, size)
    assert kind.left_jacobian(np.zeros((2, 5, size))).shape == (2, 5, size, size)
    none = kind.identity((0, 2))
    assert none.retract(twist).shape == (0, 2)
    assert none.adjoint().shape == (0, 2, size, size)


def test_precision_is_the_versors_own(kind: type[Versor], rng: np.random.Generator) -> None:
    one = kind.random(rng, (20,)).astype(np.float32)
    twist = rng.standard_normal((20, kind.identity().log().size))
    results = [
        one.retract(twist).coefficients,
        one.local(one),
        one.adjoint(),
        one.transform_twist(twist),
        kind.left_jacobian(twist.astype(np.float32)),
        kind.right_jacobian_inverse(twist.astype(np.float32)),
    ]
    assert {array.dtype for array in results} == {np.dtype(np.float32)}


def test_what_does_not_fit_is_refused(kind: type[Versor], rng: np.random.Generator) -> None:
    one, size = kind.random(rng, (3,)), kind.identity().log().size
    with pytest.raises(ValueError, match=rf"retract\(twist\): expected shape \(\*, {size}\)"):
        one.retract(np.zeros(size + 1))
    with pytest.raises(ValueError, match="expected finite numbers"):
        one.transform_twist(np.full(size, np.nan))
    with pytest.raises(ValueError, match=r"\(3,\) and \(2,\)"):
        one.retract(np.zeros((2, size)))
    with pytest.raises(ValueError, match=r"right_jacobian\(twist\): expected shape"):
        kind.right_jacobian(np.zeros(2))
    other = Rotor.identity() if kind is not Rotor else Motor.identity()
    with pytest.raises(TypeError, match=rf"expected a {kind.__name__}, got {type(other).__name__}"):
        one.local(other)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="one precision, got float32 and float64"):
        one.local(one.astype(np.float32))
