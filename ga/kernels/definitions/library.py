"""All kernels, and what compiled code does to one versor at a time: ``generated/cpp/versors.h``.

Most functions of the header are kernels of batches, under the name that they share for every
versor: the argument tells which one is meant. To have another one there, name it in `_SINGLE`.
"""

from __future__ import annotations

from typing import Any

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import (
    blends,
    chains,
    conversions,
    similarities,
    similarity_conversions,
    skinning,
)
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.blends import average_kernels
from motorcade.ga.kernels.definitions.motors import MOTORS, ROTORS
from motorcade.ga.kernels.definitions.parts import euler
from motorcade.ga.kernels.definitions.parts import motors as motor_parts
from motorcade.ga.kernels.definitions.parts import rotors as rotor_parts
from motorcade.ga.kernels.definitions.parts import similarities as similarity_parts
from motorcade.ga.kernels.definitions.similarity_tangents import SIMILARITIES
from motorcade.ga.kernels.definitions.versors import twist_kernels, versor_kernels

Numbers = list[Any]

KERNELS = (
    *versor_kernels(MOTORS, ("products", "exponentials", "screws", "screws")),
    *conversions.KERNELS,
    *blends.KERNELS,
    *versor_kernels(ROTORS, ("rotors",) * 4),
    *versor_kernels(
        SIMILARITIES,
        (
            "similarity_products",
            "similarity_exponentials",
            "similarity_spirals",
            "similarity_long_spirals",
        ),
    ),
    *similarities.KERNELS,
    *similarity_conversions.KERNELS,
    *skinning.KERNELS,
    *chains.KERNELS,
    *rotor_parts.KERNELS,
    *euler.KERNELS,
    *motor_parts.KERNELS,
    *similarity_parts.KERNELS,
    *(kernel for kind in (MOTORS, ROTORS, SIMILARITIES) for kernel in twist_kernels(kind)),
    *(kernel for kind in (MOTORS, ROTORS, SIMILARITIES) for kernel in average_kernels(kind)),
)

# The name in C++, and the kernels that it stands for.
_SINGLE = {
    "compose": ("rotor_compose", "compose", "similarity_compose"),
    "inverse": ("rotor_inverse", "inverse", "similarity_inverse"),
    "exp": ("rotor_exp", "exp", "similarity_exp"),
    "log": ("rotor_log", "log", "similarity_log"),
    "retract": ("rotor_retract", "retract", "similarity_retract"),
    "local": ("rotor_local", "local", "similarity_local"),
    "adjoint": ("rotor_adjoint", "adjoint", "similarity_adjoint"),
    "left_jacobian_inverse": (
        "rotor_left_jacobian_inverse",
        "left_jacobian_inverse",
        "similarity_left_jacobian_inverse",
    ),
    "normalize": ("normalize",),
    "matrix34": ("matrix34",),
    "rotor_translation_scale": ("rotor_translation_scale",),
    "similarity_of": ("similarity_of_motor",),
    "reach": ("reach",),
    "translation": ("translation",),
    "motor_of": ("motor_of",),
}


def _renormalize(precision: Precision, r: Numbers) -> list[Numbers]:
    """One Newton step of a rotor towards unit length, which rounding leaves by little."""
    factor = 1.5 - 0.5 * sum(x * x for x in r)
    return [[factor * x for x in r]]


_OWN = (
    Kernel(
        "renormalize", "single", (on.ROTOR.operand("r"),), (on.ROTOR.operand("out"),), _renormalize
    ),
)
_NAMED = {kernel.name: kernel for kernel in KERNELS}

FUNCTIONS: tuple[tuple[str, Kernel], ...] = (
    *((name, _NAMED[kernel]) for name, kernels in _SINGLE.items() for kernel in kernels),
    *((kernel.name, kernel) for kernel in _OWN),
)
