"""Hard samples that every law of this room is run on, and how far apart two motions are.

Each sample is a batch: near zero, near π, exactly π, opposite signs, pure translations, far from
the origin, one versor without a batch, several batch dimensions; similarities grow and shrink by
up to four besides. Quaternions and translations are made here with sines and cosines, not with the
code under test.
"""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor

COUNT = 24
SCALES = (1.0, 1 + 1e-12, 1 - 1e-7, 0.25, 0.999, 1.5, 4.0)
ANGLES = (0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.2838, 1.0, 3.0, np.pi - 1e-3, np.pi - 1e-9, np.pi)


def turned_by(angle: float, rng: np.random.Generator) -> Motor:
    axis = rng.standard_normal((COUNT, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    scalar = 0.0 if angle == np.pi else np.cos(angle / 2)
    wxyz = np.concatenate([np.full((COUNT, 1), scalar), np.sin(angle / 2) * axis], axis=1)
    return Motor.from_quaternion_translation(wxyz, rng.standard_normal((COUNT, 3)))


def anywhere(rng: np.random.Generator, shape: tuple[int, ...], extent_m: float = 1.0) -> Motor:
    wxyz = rng.standard_normal((*shape, 4))
    wxyz /= np.linalg.norm(wxyz, axis=-1, keepdims=True)
    return Motor.from_quaternion_translation(wxyz, extent_m * rng.standard_normal((*shape, 3)))


def pure_translations(rng: np.random.Generator) -> Motor:
    return Motor.from_quaternion_translation([1.0, 0.0, 0.0, 0.0], rng.standard_normal((COUNT, 3)))


SAMPLES: dict[str, Callable[[np.random.Generator], Motor]] = {
    **{f"angle {angle:.10g}": lambda rng, angle=angle: turned_by(angle, rng) for angle in ANGLES},
    "anywhere": lambda rng: anywhere(rng, (COUNT,)),
    "negative sign": lambda rng: Motor(-turned_by(0.5, rng).coefficients),
    "pure translation": pure_translations,
    "far away": lambda rng: anywhere(rng, (COUNT,), 1e6),
    "single": lambda rng: anywhere(rng, ()),
    "one in a batch": lambda rng: anywhere(rng, (1,)),
    "batched": lambda rng: anywhere(rng, (2, 3, 4)),
}


def of_kind(kind: type[Versor], motors: Motor) -> Versor:
    """The rotation, the motion, or the motion after growth by `SCALES` in turn."""
    if kind is Rotor:
        return motors.rotor
    if kind is Motor:
        return motors
    return Similarity.from_motor_scale(motors, np.resize(SCALES, motors.shape))


@pytest.fixture(params=[Rotor, Motor, Similarity])
def kind(request: pytest.FixtureRequest) -> type[Versor]:
    return request.param


@pytest.fixture(params=SAMPLES)
def motors(request: pytest.FixtureRequest, rng: np.random.Generator) -> Motor:
    return SAMPLES[request.param](rng)


@pytest.fixture
def versors(kind: type[Versor], motors: Motor) -> Versor:
    return of_kind(kind, motors)


@pytest.fixture
def others(versors: Versor, rng: np.random.Generator) -> Versor:
    """As many versors as the sample has, anywhere."""
    return of_kind(type(versors), anywhere(rng, versors.shape))


def as_matrix(versor: Versor) -> np.ndarray:
    assert isinstance(versor, Motor | Rotor | Similarity)
    return versor.as_matrix()


@pytest.fixture
def distance() -> Callable[[Versor, Versor], float]:
    """Largest difference of matrix entries, relative to translations beyond 1 m."""

    def between(a: Versor, b: Versor) -> float:
        one, two = as_matrix(a), as_matrix(b)
        return float(np.max(np.abs(one - two), initial=0.0) / np.max(np.abs(one), initial=1.0))

    return between
