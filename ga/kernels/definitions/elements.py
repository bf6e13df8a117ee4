"""Versors, bivectors and points of CGA from scalars and back, in the library's order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.codegen.tape import Operand


class Coefficients(NamedTuple):
    """The names of an element's coefficients, and for each the basis blade and its sign.

    >>> from motorcade.ga.kernels.definitions.elements import ROTOR
    >>> quarter_turn = ROTOR.of([0.5**0.5, 0, 0, -(0.5**0.5)])
    >>> [round(value, 6) + 0.0 for value in ROTOR.numbers(quarter_turn * quarter_turn)]
    [0.0, 0.0, 0.0, -1.0]
    """

    names: tuple[str, ...]
    signed: tuple[tuple[str, int], ...]

    def operand(self, name: str) -> Operand:
        """An operand of these coefficients."""
        return Operand(name, self.names)

    def of(self, given: Sequence[Any]) -> Multivector:
        """The multivector of the first coefficients; those that are not given are zero."""
        signed = zip(self.signed[: len(given)], given, strict=True)
        return CGA3.multivector(
            {blade: value if sign > 0 else -value for (blade, sign), value in signed}
        )

    def numbers(self, element: Multivector) -> list[Any]:
        """The coefficients of a multivector; others that it has are left out."""
        read = [(element.coefficient(blade), sign) for blade, sign in self.signed]
        return [value if sign > 0 else -value for value, sign in read]


# e31 is stored, e1^e3 is the basis blade.
MOTOR = Coefficients(
    ("1", "e23", "e31", "e12", "e1∞", "e2∞", "e3∞", "e123∞"),
    (
        ("1", 1), ("e2^e3", 1), ("e1^e3", -1), ("e1^e2", 1),
        ("e1^einf", 1), ("e2^einf", 1), ("e3^einf", 1), ("e1^e2^e3^einf", 1),
    ),
)  # fmt: skip


def _part(first: int, last: int) -> Coefficients:
    return Coefficients(MOTOR.names[first:last], MOTOR.signed[first:last])


ROTOR, BIVECTOR, ANGLES, MOVED = _part(0, 4), _part(1, 7), _part(1, 4), _part(4, 8)
VECTOR = Coefficients(("x", "y", "z"), (("e1", 1), ("e2", 1), ("e3", 1)))
# ``c + d e123∞``, which commutes with motors.
DUAL = Coefficients(("1", "e123∞"), (MOTOR.signed[0], MOTOR.signed[7]))

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
