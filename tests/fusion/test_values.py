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
from motorcade.fusion.metrics import (
    Consistency,
    alignment_of,
    associate,
    drift_by_length,
    evaluate,
    frame_change_defect,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor


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


def test_what_the_metrics_give_is_a_key_and_cannot_be_changed():
    path = MOTIONS["stop_and_go"].sampled(30.0, 4.0)
    pairs, found = associate(path, path), evaluate(path, path)
    values: list[Any] = [
        pairs,
        associate(path, path),
        found,
        found.ape_m,
        found.jitter,
        found.energy_excess,
        found.log_jerk,
        found.gimbal,
        alignment_of(pairs, "se3"),
        Consistency.of(np.ones((2, 3)), 1),
        frame_change_defect(lambda one: one, path, Motor.identity(), Motor.identity()),
        *drift_by_length(path.motors, path.motors, (0.1,)),
    ]
    assert len(set(values)) == len(values)
    assert values[0] != values[1]
    for value in values:
        name = fields(value)[0].name
        with pytest.raises(FrozenInstanceError):
            setattr(value, name, getattr(value, name))
