"""Versors, bivectors and points of CGA from scalars and back, in the library's order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.codegen.tape import Operand


class Coefficients(NamedTuple):
    """The names of an element's coefficients, and the blades that they stand on.

    >>> from motorcade.ga.kernels.definitions.elements import ROTOR
    >>> quarter_turn = ROTOR.of([0.5**0.5, 0, 0, -(0.5**0.5)])
    >>> [round(value, 6) + 0.0 for value in ROTOR.numbers(quarter_turn * quarter_turn)]
    [0.0, 0.0, 0.0, -1.0]
    """

    names: tuple[str, ...]
    blades: tuple[str, ...]

    def operand(self, name: str) -> Operand:
        """An operand of these coefficients."""
        return Operand(name, self.names)

    def of(self, values: Sequence[Any]) -> Multivector:
        """The multivector of the first coefficients; those that are not given are zero."""
        return CGA3.multivector(dict(zip(self.blades[: len(values)], values, strict=True)))

    def numbers(self, element: Multivector) -> list[Any]:
        """The coefficients of a multivector; others that it has are left out."""
        return [element.coefficient(blade) for blade in self.blades]


MOTOR = Coefficients(
    ("1", "e23", "e31", "e12", "e1∞", "e2∞", "e3∞", "e123∞"),
    ("1", "e2^e3", "e3^e1", "e1^e2", "e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf"),
)


def _part(first: int, last: int) -> Coefficients:
    return Coefficients(MOTOR.names[first:last], MOTOR.blades[first:last])


ROTOR, BIVECTOR, ANGLES, MOVED = _part(0, 4), _part(1, 7), _part(1, 4), _part(4, 8)
VECTOR = Coefficients(("x", "y", "z"), ("e1", "e2", "e3"))
# ``c + d e123∞``, which commutes with motors.
DUAL = Coefficients(("1", "e123∞"), (MOTOR.blades[0], MOTOR.blades[7]))

# A similarity, its logarithm, and other names of components.
SIMILARITY = (*ROTOR.names, "E", "e23E", "e31E", "e12E", *MOVED.names)
# The last, from 0 to 1, is how well the others are defined.
DEFINED_SIMILARITY = (*SIMILARITY, "defined")
GROWING_BIVECTOR = (*ANGLES.names, "E", *MOVED.names[:3])
ROTOR_TRANSLATION_SCALE = (*ROTOR.names, "x", "y", "z", "scale")
# Hamilton's, real part first.
DUAL_QUATERNION = ("w", "x", "y", "z", "εw", "εx", "εy", "εz")


def numbers(name: str) -> Operand:
    """An operand of one number a row."""
    return Operand(name, (name,))


def twist(name: str, size: int) -> Operand:
    """An operand of a twist: rotation vector, then translational part, then log scale."""
    return Operand(name, ("rx", "ry", "rz", "x", "y", "z", "log_scale")[:size])


def components(name: str, rows: int, columns: int) -> Operand:
    """An operand that holds a matrix by rows."""
    return Operand(name, tuple(f"m{i}{j}" for i in range(rows) for j in range(columns)))


def translation_numbers(element: Multivector) -> list[Any]:
    """The vector ``t`` of ``(1 - ½ t∞)`` times any scalar, that scalar included."""
    return [-2 * element.coefficient(f"e{k}^einf") for k in (1, 2, 3)]


def angle_norm_squared(element: Multivector) -> Any:
    """Squares of the coefficients of e23, e31, e12, added up."""
    return sum(value * value for value in ANGLES.numbers(element))


def scaled(element: Multivector, factor: Any) -> Multivector:
    """Every coefficient times a number."""
    product: Multivector = element * factor
    return product
