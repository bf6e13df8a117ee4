"""What compiled code does to one versor at a time: the functions of ``generated/cpp/versors.h``.

Most are kernels of batches, under the name that they share for every versor: the argument tells
which one is meant. To have another kernel in the header, name it in `_KERNELS`.
"""

from __future__ import annotations

from typing import Any

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import KERNELS, conversions
from motorcade.ga.kernels.definitions import elements as on

__all__ = ["FUNCTIONS"]

Numbers = list[Any]

# The name in C++, and the kernels that it stands for.
_KERNELS = {
    "compose": ("rotor_compose", "compose", "similarity_compose"),
    "inverse": ("rotor_inverse", "inverse", "similarity_inverse"),
    "exp": ("rotor_exp", "exp", "similarity_exp"),
    "log": ("rotor_log", "log", "similarity_log"),
    "retract": ("rotor_retract", "retract", "similarity_retract"),
    "local": ("rotor_local", "local", "similarity_local"),
    "adjoint": ("rotor_adjoint", "adjoint", "similarity_adjoint"),
    "normalize": ("normalize",),
    "rotor_translation_scale": ("rotor_translation_scale",),
    "similarity_of": ("similarity_of_motor",),
}


def _renormalize(precision: Precision, r: Numbers) -> list[Numbers]:
    """One Newton step of a rotor towards unit length, which rounding leaves by little."""
    factor = 1.5 - 0.5 * sum(x * x for x in r)
    return [[factor * x for x in r]]


def _translation(precision: Precision, m: Numbers) -> list[Numbers]:
    """Where a motor takes the origin."""
    return [conversions.matrix_rows(m, unit=True)[3::4]]


def _motor_of(precision: Precision, r: Numbers, t: Numbers) -> list[Numbers]:
    """The motor that turns by a rotor, then moves by a translation."""
    translator = on.motor_of([1, 0, 0, 0, *(-0.5 * x for x in t), 0])
    return [on.motor_numbers(translator * on.rotor_of(r))]


_R, _M, _T = on.rotor("r"), on.motor("m"), on.points("t")
_OWN = (
    Kernel("renormalize", "single", (_R,), (on.rotor("out"),), _renormalize),
    Kernel("translation", "single", (_M,), (_T,), _translation),
    Kernel("motor_of", "single", (_R, _T), (on.motor("out"),), _motor_of),
)
_NAMED = {kernel.name: kernel for kernel in KERNELS}

FUNCTIONS: tuple[tuple[str, Kernel], ...] = (
    *((name, _NAMED[kernel]) for name, kernels in _KERNELS.items() for kernel in kernels),
    *((kernel.name, kernel) for kernel in _OWN),
)
