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
