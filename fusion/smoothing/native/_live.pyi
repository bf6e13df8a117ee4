from typing import overload

from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray

class Live:
    @overload
    def __init__(self, lag_s: float, memory_s: float) -> None: ...
    @overload
    def __init__(self, other: Live) -> None: ...
    @property
    def usual_interval_s(self) -> float: ...
    def update(
        self, time_s: float, position_m: ArrayLike, wxyz: ArrayLike
    ) -> tuple[float, FloatArray, FloatArray]: ...
    def predict(self, time_s: float) -> tuple[float, FloatArray, FloatArray]: ...

def smooth(
    lag_s: float, memory_s: float, time_s: FloatArray, poses: FloatArray, out: FloatArray
) -> None: ...
