"""Values of the room are frozen, and those that hold arrays are compared by identity."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields, is_dataclass
from typing import Any

import numpy as np
import pytest

import motorcade.fusion
from motorcade.fusion.metrics import Consistency, associate
from motorcade.ga import Motor, Trajectory


def dataclasses_of_the_room() -> Iterator[type[Any]]:
    for found in pkgutil.walk_packages(motorcade.fusion.__path__, "motorcade.fusion."):
        if not found.name.endswith("__main__"):
            module = importlib.import_module(found.name)
            for _, kind in inspect.getmembers(module, inspect.isclass):
                if is_dataclass(kind) and kind.__module__ == found.name:
                    yield kind


def test_all_are_frozen_and_arrays_are_not_compared():
    """An array's truth is ambiguous, so `==` over fields would raise, and so would `hash`."""
    found = list(dataclasses_of_the_room())
    assert len(found) > 50
    for kind in found:
        parameters = kind.__dataclass_params__
        assert parameters.frozen, kind
        holds_arrays = any("Array" in str(field.type) for field in fields(kind))
        assert not (parameters.eq and holds_arrays), kind


def test_a_frozen_value_is_a_key_and_cannot_be_changed():
    path = Trajectory(np.arange(3), Motor.identity((3,)))
    values = [associate(path, path), associate(path, path), Consistency.of(np.ones((2, 3)), 1)]
    assert len(set(values)) == 3
    assert values[0] != values[1]
    with pytest.raises(FrozenInstanceError):
        values[0].time_ns = np.arange(3)
