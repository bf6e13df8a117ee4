"""Inverse kinematics in float64. Arrays are C-ordered and checked for shape alone."""

import numpy as np
from numpy.typing import NDArray

class Solver:
    def __init__(
        self,
        parents: NDArray[np.int64],
        rest: NDArray[np.float64],
        kinds: NDArray[np.int64],
        numbers: NDArray[np.int64],
        axes: NDArray[np.float64],
        limits: NDArray[np.float64],
    ) -> None: ...
    @property
    def size_m(self) -> float: ...
    def solve(
        self,
        local: NDArray[np.float64],
        aims: NDArray[np.int64],
        marks: NDArray[np.float64],
        targets: NDArray[np.float64],
        tolerance: float,
        restarts: int,
        poses: NDArray[np.float64],
        residuals: NDArray[np.float64],
        presses: NDArray[np.float64],
    ) -> int: ...

def fabrik(
    points: NDArray[np.float64],
    targets: NDArray[np.float64],
    directions: NDArray[np.float64],
    limits: NDArray[np.float64],
    tolerance: float,
    errors: NDArray[np.float64],
) -> int: ...
