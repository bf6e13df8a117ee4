import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray

def spline(
    time_s: FloatArray,
    values: FloatArray,
    weights: FloatArray,
    jumps: IntArray,
    order: int,
    density: float,
    memory_s: float,
    out: tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None = None,
    shocks: FloatArray | None = None,
) -> tuple[float, list[float], float]: ...
def chain(
    time_s: FloatArray,
    poses: FloatArray,
    rotation: tuple[float, float],
    translation: tuple[float, float],
    kept: NDArray[np.bool_],
) -> None: ...
