"""Values of the room are frozen, and those that hold arrays are equal to nothing but themselves."""

import dataclasses
import importlib
import inspect
import pkgutil
from collections.abc import Iterator

import numpy as np
import pytest

import motorcade.ga
from motorcade.ga import DualQuaternion, EulerPose, Motor, QuaternionPose, Rotor, Similarity

ARRAYS = ("FloatArray", "IntArray", "Motor", "Similarity", "Trajectory", "V", "Rotor")


def dataclasses_of_the_room() -> Iterator[type]:
    for found in pkgutil.walk_packages(motorcade.ga.__path__, "motorcade.ga."):
        if "generated" not in found.name and not found.name.endswith("__main__"):
            module = importlib.import_module(found.name)
            for _, kind in inspect.getmembers(module, inspect.isclass):
                if dataclasses.is_dataclass(kind) and kind.__module__ == found.name:
                    yield kind


@pytest.mark.parametrize("kind", dataclasses_of_the_room(), ids=lambda kind: kind.__qualname__)
def test_values_are_frozen_and_arrays_are_not_compared(kind: type) -> None:
    assert kind.__dataclass_params__.frozen
    annotated = {str(field.type).partition(" |")[0] for field in dataclasses.fields(kind)}
    if annotated & set(ARRAYS):
        assert not kind.__dataclass_params__.eq


@pytest.mark.parametrize("kind", [Rotor, Motor, Similarity, QuaternionPose, DualQuaternion])
def test_a_single_value_shows_its_coefficients_and_a_batch_its_shape(kind: type) -> None:
    assert repr(kind.identity((2, 3))) == f"{kind.__name__}(shape=(2, 3))"
    shown = kind.identity().coefficients.tolist()
    assert repr(kind.identity()) == f"{kind.__name__}({shown})"


def test_euler_poses_show_their_angles() -> None:
    assert "shape=(2,)" in repr(EulerPose.identity((2,)))
    assert repr(EulerPose.identity()).startswith("EulerPose(")


@pytest.mark.parametrize("kind", [Rotor, Motor, Similarity])
def test_versors_take_another_shape_and_keep_their_order(
    kind: type[Rotor] | type[Motor] | type[Similarity], rng: np.random.Generator
) -> None:
    given = kind.random(rng, (2, 6))
    np.testing.assert_array_equal(
        given.reshape(3, -1).coefficients, given.coefficients.reshape(3, 4, -1)
    )
    assert [one.shape for one in given] == [(6,), (6,)]
    assert given[:1, 0].reshape().shape == ()
