"""Other libraries' poses move points as the versor does, compose as it does, and come back."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.conversions import (
    dm_from_versor,
    motor_from_pose3,
    motor_from_rigid_transform,
    motor_from_se3,
    pose3_from_motor,
    rigid_transform_from_motor,
    rotation_from_rotor,
    rotor_from_rotation,
    se3_from_motor,
    tensor_from_versor,
    versor_from_dm,
    versor_from_tensor,
)

POINT = np.array([0.3, -1.2, 2.0])


def _by_scipy(pose: Any) -> np.ndarray:
    return np.asarray(pose.apply(POINT))


def _by_gtsam(poses: list[Any]) -> np.ndarray:
    return np.array([pose.transformFrom(POINT) for pose in poses])


def _by_kornia(pose: Any) -> np.ndarray:
    import torch

    point = torch.tensor(POINT, dtype=pose.r.q.data.dtype)
    return np.asarray((pose.matrix()[..., :3, :3] @ point + pose.matrix()[..., :3, 3]).detach())


def _pose3s(motors: Motor) -> list[Any]:
    return [pose3_from_motor(one) for one in motors.reshape(-1)]


CASES: dict[str, tuple[str, Callable[[Motor], Any], Callable[[Any], Motor], Any, Any]] = {
    "scipy": (
        "scipy",
        rigid_transform_from_motor,
        motor_from_rigid_transform,
        _by_scipy,
        lambda a, b: a * b,
    ),
    "gtsam": (
        "gtsam",
        _pose3s,
        lambda poses: Motor.stack([motor_from_pose3(one) for one in poses]),
        _by_gtsam,
        lambda a, b: [x * y for x, y in zip(a, b, strict=True)],
    ),
    "kornia": ("kornia", se3_from_motor, motor_from_se3, _by_kornia, lambda a, b: a * b),
}


@pytest.fixture(params=CASES)
def library(request: pytest.FixtureRequest) -> Any:
    module, *rest = CASES[request.param]
    pytest.importorskip(module)
    return rest


def test_points_products_and_the_way_back(
    library: Any, motors: Motor, rng: np.random.Generator
) -> None:
    to, back, applied, product = library
    first = motors.reshape(-1)
    second = Motor.random(rng, first.shape)
    np.testing.assert_allclose(applied(to(first)), first.apply(POINT), atol=1e-12, rtol=1e-12)
    composed = applied(product(to(first), to(second)))
    np.testing.assert_allclose(composed, (first @ second).apply(POINT), atol=1e-11, rtol=1e-11)
    returned = back(to(first))
    assert returned.shape == first.shape
    np.testing.assert_allclose(returned.as_matrix(), first.as_matrix(), atol=1e-12, rtol=1e-12)


def test_one_motor_stays_one(library: Any, rng: np.random.Generator) -> None:
    to, back, _, _ = library
    if to is _pose3s:
        to, back = pose3_from_motor, motor_from_pose3
    one = Motor.random(rng)
    assert back(to(one)).shape == ()
    np.testing.assert_allclose(back(to(one)).as_matrix(), one.as_matrix(), atol=1e-13)


def test_scipy_rotations_keep_the_sign(motors: Motor) -> None:
    rotor = motors.rotor
    rotation = rotation_from_rotor(rotor)
    np.testing.assert_allclose(rotation.apply(POINT), rotor.apply(POINT), atol=1e-12)
    back = rotor_from_rotation(rotation)
    np.testing.assert_allclose(back.coefficients, rotor.coefficients, atol=1e-15)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("kind", [Rotor, Motor, Similarity])
def test_tensors_are_copies_of_the_same_numbers(
    kind: type[Any], precision: str, rng: np.random.Generator
) -> None:
    torch = pytest.importorskip("torch")
    versor = kind.random(rng, (4, 3)).astype(precision)
    tensor = tensor_from_versor(versor)
    assert tensor.dtype == getattr(torch, precision)
    np.testing.assert_array_equal(np.asarray(tensor), versor.coefficients)
    back = versor_from_tensor(kind, tensor.requires_grad_())
    np.testing.assert_array_equal(back.coefficients, versor.coefficients)
    tensor.data[:] = 7.0
    assert not np.any(back.coefficients == 7.0)
    with pytest.raises(ValueError, match=kind.__name__):
        versor_from_tensor(kind, tensor)


@pytest.mark.parametrize("kind", [Rotor, Motor, Similarity])
def test_casadi_matrices_have_a_column_a_versor(kind: type[Any], rng: np.random.Generator) -> None:
    casadi = pytest.importorskip("casadi")
    versors = kind.random(rng, (5,))
    matrix = dm_from_versor(versors)
    assert matrix.shape == versors.coefficients.T.shape
    np.testing.assert_array_equal(matrix[:, 3].full().ravel(), versors[3].coefficients)
    back = versor_from_dm(kind, matrix)
    np.testing.assert_array_equal(back.coefficients, versors.coefficients)
    assert versor_from_dm(kind, dm_from_versor(versors[0])).shape == ()
    with pytest.raises(ValueError, match="expected a DM of numbers, got SX"):
        versor_from_dm(kind, casadi.SX.sym("m", 8))


def test_batches_that_a_library_does_not_have_are_refused(rng: np.random.Generator) -> None:
    pytest.importorskip("kornia")
    pytest.importorskip("gtsam")
    many = Motor.random(rng, (2, 3))
    for convert in (pose3_from_motor, se3_from_motor, dm_from_versor):
        with pytest.raises(ValueError, match=r"got \(2, 3\)"):
            convert(many)
