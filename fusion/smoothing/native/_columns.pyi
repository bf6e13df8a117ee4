from motorcade.ga.arrays import FloatArray

def spline(
    time_s: FloatArray,
    values: FloatArray,
    weights: FloatArray,
    order: int,
    density: float,
    out: tuple[FloatArray, FloatArray, FloatArray] | None = None,
) -> tuple[float, float, float]: ...
