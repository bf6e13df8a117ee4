"""Posing and skinning in float32. Arrays are C-ordered and checked for shape alone."""

from collections.abc import Sequence
from enum import Enum

import numpy as np
from numpy.typing import NDArray

class Skinning(Enum):
    matrix = 0
    dual_quaternion = 1
    motor = 2
    similarity = 3

class Mesh:
    def __init__(
        self,
        positions: NDArray[np.float64],
        normals: NDArray[np.float64],
        joints: NDArray[np.int64],
        weights: NDArray[np.float64],
    ) -> None: ...
    def reshape(self, positions: NDArray[np.float64], normals: NDArray[np.float64]) -> None: ...
    def skin(
        self,
        method: Skinning,
        palette: NDArray[np.float32],
        positions: NDArray[np.float32],
        normals: NDArray[np.float32],
        threads: int,
    ) -> None: ...

class Rig:
    def __init__(self, parents: NDArray[np.int64], inverse_rest: NDArray[np.float64]) -> None: ...
    def add(self, time_s: NDArray[np.float64], poses: NDArray[np.float64], looped: bool) -> int: ...
    def pose(
        self,
        layers: Sequence[tuple[int, float, float]],
        by_screw: bool,
        kind: str,
        out: NDArray[np.float32],
    ) -> None: ...
    def repeat(
        self,
        layers: Sequence[tuple[int, float, float]],
        by_screw: bool,
        kind: str,
        out: NDArray[np.float32],
        times: int,
    ) -> float: ...
