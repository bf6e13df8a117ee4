"""What compiled code does to one versor at a time: the functions of ``generated/cpp/versors.h``.

Those of batches keep the name that they have for every versor; the argument tells which one is
meant. The others work on twists: rotation vector, translational part and, of similarities, the
logarithm of the scale.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import blends, conversions, motors, rotors, similarities
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions import similarity_conversions as scaled

__all__ = ["FUNCTIONS"]

Numbers = list[Any]

_ROOMS = (rotors, motors, blends, conversions, similarities, scaled)
_BATCHED = {kernel.name: kernel for room in _ROOMS for kernel in room.KERNELS}


def _of(name: str, precision: Precision, *inputs: Numbers) -> Numbers:
    """What a kernel of batches gives."""
    (made,) = _BATCHED[name].define(precision, *inputs)
    return list(made)


def _log_of(twist: Numbers) -> Numbers:
    halves = [-0.5 * x for x in twist[:6]]
    return [*halves[:3], 0.5 * twist[6], *halves[3:]] if len(twist) == 7 else halves


def _twist_of(log: Numbers) -> Numbers:
    if len(log) == 7:
        return [*(-2 * x for x in (*log[:3], *log[4:])), 2 * log[3]]
    return [-2 * x for x in log]


def _retract(prefix: str) -> Any:
    def define(precision: Precision, base: Numbers, twist: Numbers) -> list[Numbers]:
        step = _of(f"{prefix}exp", precision, _log_of(twist))
        return [_of(f"{prefix}compose", precision, base, step)]

    return define


def _local(prefix: str) -> Any:
    def define(precision: Precision, m: Numbers, base: Numbers) -> list[Numbers]:
        step = _of(f"{prefix}compose", precision, _of(f"{prefix}inverse", precision, base), m)
        return [_twist_of(_of(f"{prefix}log", precision, step))]

    return define


def _rotation(r: Numbers) -> Numbers:
    rows = conversions.matrix_rows([*r, 0, 0, 0, 0], unit=True)
    return [rows[4 * i + j] for i in range(3) for j in range(3)]


def _matrix33(precision: Precision, r: Numbers) -> list[Numbers]:
    return [_rotation(r)]


def _adjoint_of(rotation: Numbers, t: Numbers, scale: Any) -> list[Numbers]:
    """Rows on twists: R, and below ``[t]× R`` and ``ρ R``."""
    lever = [
        t[(i + 1) % 3] * rotation[3 * ((i + 2) % 3) + j]
        - t[(i + 2) % 3] * rotation[3 * ((i + 1) % 3) + j]
        for i in range(3)
        for j in range(3)
    ]
    upper = [[*rotation[3 * i : 3 * i + 3], 0.0, 0.0, 0.0] for i in range(3)]
    lower = [
        [*lever[3 * i : 3 * i + 3], *(scale * x for x in rotation[3 * i : 3 * i + 3])]
        for i in range(3)
    ]
    return [*upper, *lower]


def _motor_adjoint(precision: Precision, m: Numbers) -> list[Numbers]:
    rows = _adjoint_of(_rotation(m[:4]), _translation_of(m), 1)
    return [[x for row in rows for x in row]]


def _similarity_adjoint(precision: Precision, m: Numbers) -> list[Numbers]:
    (parts,) = _BATCHED["rotor_translation_scale"].define(precision, m)
    t = parts[4:7]
    rows = [*_adjoint_of(_rotation(parts[:4]), t, parts[7]), 6 * [0.0]]
    last = [0.0, 0.0, 0.0, *(-x for x in t), 1.0]
    return [[x for row, end in zip(rows, last, strict=True) for x in (*row, end)]]


def _renormalized(precision: Precision, r: Numbers) -> list[Numbers]:
    square = sum(x * x for x in r)
    return [[(1.5 - 0.5 * square) * x for x in r]]


def _translation_of(m: Numbers) -> Numbers:
    return on.translation_numbers(on.motor_of(m) * ~on.rotor_of(m[:4]))


def _translation(precision: Precision, m: Numbers) -> list[Numbers]:
    return [_translation_of(m)]


def _motor_of(precision: Precision, r: Numbers, t: Numbers) -> list[Numbers]:
    translator = on.motor_of([1, 0, 0, 0, *(-0.5 * x for x in t), 0])
    return [on.motor_numbers(translator * on.rotor_of(r))]


_R, _M, _S = on.rotor("m"), on.motor("m"), on.similarity("m")
_TURN = ("x", "y", "z")
_TWIST = (*_TURN, "tx", "ty", "tz")
_KINDS = (
    ("rotor_", on.rotor, _TURN),
    ("", on.motor, _TWIST),
    ("similarity_", on.similarity, (*_TWIST, "log scale")),
)


def _kernel(
    name: str, summary: str, inputs: tuple[Operand, ...], output: Operand, define: Any
) -> tuple[str, Kernel]:
    return name, Kernel(name, "versors", summary, inputs, (output,), define)


def _on_twists() -> Iterator[tuple[str, Kernel]]:
    onwards = "The pose that lies a twist from a base, in the base's body frame"
    between = "The twist from a base to a pose, in the base's body frame"
    for prefix, kind, components in _KINDS:
        base, m, twist = kind("base"), kind("m"), Operand("twist", components)
        yield _kernel("retract", onwards, (base, twist), kind("out"), _retract(prefix))
        yield _kernel("local", between, (m, base), Operand("out", components), _local(prefix))


_OF_ROTOR = "Ad of a rotor: its 3×3 matrix, by rows"
_OF_MOTOR = "Ad of a motor on twists, by rows"
_OF_SIMILARITY = "Ad of a similarity on twists, by rows"
_NEWTON = "One Newton step towards unit length, which rounding leaves by little"
_ORIGIN = "Where a motor takes the origin"
_MOTOR = "The motor that turns by a rotor, then moves by a translation"
_OWN = (
    *_on_twists(),
    _kernel("adjoint", _OF_ROTOR, (_R,), on.components("out", 3, 3), _matrix33),
    _kernel("adjoint", _OF_MOTOR, (_M,), on.components("out", 6, 6), _motor_adjoint),
    _kernel("adjoint", _OF_SIMILARITY, (_S,), on.components("out", 7, 7), _similarity_adjoint),
    _kernel("renormalize", _NEWTON, (_R,), on.rotor("out"), _renormalized),
    _kernel("translation", _ORIGIN, (_M,), on.points("out"), _translation),
    _kernel("motor_of", _MOTOR, (on.rotor("r"), on.points("t")), on.motor("out"), _motor_of),
)

# The name in C++ and the kernels of batches that it stands for.
_NAMES = {
    "compose": ("rotor_compose", "compose", "similarity_compose"),
    "inverse": ("rotor_inverse", "inverse", "similarity_inverse"),
    "exp": ("rotor_exp", "exp", "similarity_exp"),
    "log": ("rotor_log", "log", "similarity_log"),
    "normalize": ("normalize",),
    "rotor_translation_scale": ("rotor_translation_scale",),
    "similarity_of": ("similarity_of_motor",),
}

FUNCTIONS: tuple[tuple[str, Kernel], ...] = (
    *((name, _BATCHED[kernel]) for name, kernels in _NAMES.items() for kernel in kernels),
    *_OWN,
)
