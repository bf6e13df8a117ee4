"""Motor kernels over batches: the compiled module where it is present, NumPy otherwise.

`backend` says which is in use, "compiled" or "numpy"; the environment variable MOTORCADE_KERNELS
set to "numpy" forces the latter. All functions take float64 arrays whose last dimension holds
coefficients and whose leading dimensions broadcast; nothing is validated here. Rotors have NumPy
kernels only.
"""

from __future__ import annotations

import os
from importlib.util import find_spec

from motorcade.ga.kernels.numpy_kernels import (
    rotor_compose,
    rotor_exp,
    rotor_interpolate,
    rotor_inverse,
    rotor_log,
)

__all__ = [
    "backend", "compose", "exp", "interpolate", "inverse", "log",
    "rotor_compose", "rotor_exp", "rotor_interpolate", "rotor_inverse", "rotor_log",
]  # fmt: skip


def _backend() -> str:
    wanted = os.environ.get("MOTORCADE_KERNELS", "")
    if wanted not in ("", "numpy"):
        raise ValueError(f"MOTORCADE_KERNELS: expected 'numpy' or nothing, got {wanted!r}")
    present = find_spec("motorcade.ga.kernels._compiled") is not None
    return "compiled" if present and not wanted else "numpy"


backend = _backend()

if backend == "compiled":
    from motorcade.ga.kernels.compiled_kernels import compose, exp, interpolate, inverse, log
else:
    from motorcade.ga.kernels.numpy_kernels import compose, exp, interpolate, inverse, log
