"""Motor kernels over batches: the compiled module where it is present, NumPy otherwise.

`backend` says which is in use, "compiled" or "numpy". All functions take float64 arrays whose last
dimension holds coefficients and whose leading dimensions broadcast.
"""

from __future__ import annotations

from motorcade.ga.kernels.numpy_kernels import (
    compose,
    exp,
    interpolate,
    inverse,
    log,
    rotor_compose,
    rotor_exp,
    rotor_interpolate,
    rotor_inverse,
    rotor_log,
)

backend = "numpy"

__all__ = [
    "backend", "compose", "exp", "interpolate", "inverse", "log",
    "rotor_compose", "rotor_exp", "rotor_interpolate", "rotor_inverse", "rotor_log",
]  # fmt: skip
