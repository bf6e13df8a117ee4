import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

def chain(
    time_s: FloatArray,
    poses: FloatArray,
    rotation: tuple[float, float],
    translation: tuple[float, float],
    kept: NDArray[np.bool_],
) -> None: ...
