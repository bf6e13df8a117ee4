import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray

_Kind = tuple[str, bool]
_Measured = tuple[FloatArray, FloatArray, NDArray[np.bool_], FloatArray, FloatArray]
_Loss = tuple[str, float]
_State = tuple[FloatArray, FloatArray]

def descend(
    kind: _Kind,
    measured: _Measured,
    loss: _Loss,
    state: _State,
    steps: int,
    converged: float,
    squares: FloatArray,
) -> float: ...
def step(
    kind: _Kind,
    measured: _Measured,
    loss: _Loss,
    state: _State,
    downhill: FloatArray,
    columns: FloatArray,
) -> None: ...
