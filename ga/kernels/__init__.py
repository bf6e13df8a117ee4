"""Versor kernels over batches, float32 and float64, written by the project's own generator.

`backend` says which code runs, "compiled" or "numpy" (see `motorcade.ga.kernels.backend`).
`ROTORS`, `MOTORS` and `SIMILARITIES` have the verbs of all versors; other functions work on one
kind. They take arrays ``(*, n)`` whose batches broadcast; nothing is validated: versors are taken
for unit, numbers for finite. For repeated calls on the same storage `Block` holds operands as the
kernels want them and `function` gives the kernel itself: ``function("compose")(a, b, out)``.
Batches of more than 65536 rows are shared among `threads()` threads; `set_threads` says how many.

>>> import numpy as np
>>> from motorcade.ga import Motor, kernels
>>> turn, step = Motor.from_twist([[0, 0, np.pi / 2, 0, 0, 0], [0, 0, 0, 1, 0, 0]]).coefficients
>>> kernels.MOTORS.apply(kernels.MOTORS.compose(step, turn), np.array([1.0, 0.0, 0.0])).round(6)
array([1., 1., 0.])
>>> motors, inverses = kernels.Block(8, 2), kernels.Block(8, 2)
>>> motors.array[:] = turn, step
>>> kernels.function("inverse")(motors, inverses)
>>> inverses.array[1, 4].item()
0.5
"""

from __future__ import annotations

from motorcade.ga.kernels.backend import Block, backend, function, set_threads, threads
from motorcade.ga.kernels.batches import (
    MOTORS,
    ROTORS,
    SIMILARITIES,
    PoseKernels,
    VersorKernels,
    blend,
    blend_many,
    blend_many_matrix,
    blend_matrix,
    dual_quaternion,
    normalize,
    rotor_translation_scale,
    screw_blend,
    screw_blend_matrix,
    similarity_blend,
    similarity_normalize,
    similarity_of_motor,
)

__all__ = [
    "MOTORS",
    "ROTORS",
    "SIMILARITIES",
    "Block",
    "PoseKernels",
    "VersorKernels",
    "backend",
    "blend",
    "blend_many",
    "blend_many_matrix",
    "blend_matrix",
    "dual_quaternion",
    "function",
    "normalize",
    "rotor_translation_scale",
    "screw_blend",
    "screw_blend_matrix",
    "set_threads",
    "similarity_blend",
    "similarity_normalize",
    "similarity_of_motor",
    "threads",
]
