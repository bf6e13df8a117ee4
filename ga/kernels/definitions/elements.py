"""Versors, bivectors and points of CGA from scalars and back, in the library's order."""

from __future__ import annotations

from typing import Any

from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions.functions import Dual

# Basis blades in the order of the stored coefficients; e31 is stored, e1^e3 is the basis blade.
_MOTOR = (
    ("1", 1), ("e2^e3", 1), ("e1^e3", -1), ("e1^e2", 1),
    ("e1^einf", 1), ("e2^einf", 1), ("e3^einf", 1), ("e1^e2^e3^einf", 1),
)  # fmt: skip
_ROTOR = _MOTOR[:4]
_BIVECTOR = _MOTOR[1:7]
_ANGLES = _MOTOR[1:4]
_VECTOR = (("e1", 1), ("e2", 1), ("e3", 1))
_DUAL = (("1", 1), ("e1^e2^e3^einf", 1))
_MOVED = _MOTOR[4:]
_NAMES = ("1", "e23", "e31", "e12", "e1∞", "e2∞", "e3∞", "e123∞")
_GROWN = ("E", "e23E", "e31E", "e12E")


def _element(signed: tuple[tuple[str, int], ...], given: Any) -> Multivector:
    return CGA3.multivector(
        {
            blade: value if sign > 0 else -value
            for (blade, sign), value in zip(signed, given, strict=True)
        }
    )


def _read(signed: tuple[tuple[str, int], ...], element: Multivector) -> list[Any]:
    read = [(element.coefficient(blade), sign) for blade, sign in signed]
    return [value if sign > 0 else -value for value, sign in read]


def motor(name: str) -> Operand:
    """An operand of eight coefficients."""
    return Operand(name, _NAMES)


def rotor(name: str) -> Operand:
    """An operand of four coefficients."""
    return Operand(name, _NAMES[:4])


def similarity(name: str) -> Operand:
    """An operand of twelve coefficients."""
    return Operand(name, (*_NAMES[:4], *_GROWN, *_NAMES[4:]))


def defined_similarity(name: str) -> Operand:
    """An operand of twelve coefficients, and from 0 to 1 how well they are defined."""
    return Operand(name, (*similarity(name).components, "defined"))


def rotor_translation_scale(name: str) -> Operand:
    """An operand of a rotor, a translation and a scale."""
    return Operand(name, (*_NAMES[:4], "x", "y", "z", "scale"))


def growing_bivector(name: str) -> Operand:
    """An operand of seven coefficients, a similarity's logarithm."""
    return Operand(name, (*_NAMES[1:4], "E", *_NAMES[4:7]))


def bivector(name: str) -> Operand:
    """An operand of six coefficients, a motor's logarithm."""
    return Operand(name, _NAMES[1:7])


def angles(name: str) -> Operand:
    """An operand of three coefficients, a rotor's logarithm."""
    return Operand(name, _NAMES[1:4])


def points(name: str) -> Operand:
    """An operand of three coordinates."""
    return Operand(name, ("x", "y", "z"))


def numbers(name: str) -> Operand:
    """An operand of one number a row."""
    return Operand(name, (name,))


def twist(name: str, size: int) -> Operand:
    """An operand of a twist: rotation vector, then translational part, then log scale."""
    return Operand(name, ("rx", "ry", "rz", "x", "y", "z", "log_scale")[:size])


def components(name: str, rows: int, columns: int) -> Operand:
    """An operand that holds a matrix by rows."""
    return Operand(name, tuple(f"m{i}{j}" for i in range(rows) for j in range(columns)))


def dual_quaternion(name: str) -> Operand:
    """An operand of a Hamilton dual quaternion, real part first."""
    return Operand(name, ("w", "x", "y", "z", "εw", "εx", "εy", "εz"))


def motor_of(given: Any) -> Multivector:
    """The multivector of eight coefficients."""
    return _element(_MOTOR, given)


def rotor_of(given: Any) -> Multivector:
    """The multivector of four coefficients."""
    return _element(_ROTOR, given)


def bivector_of(given: Any) -> Multivector:
    """The multivector of six coefficients."""
    return _element(_BIVECTOR, given)


def angles_of(given: Any) -> Multivector:
    """The multivector of three coefficients on e23, e31, e12."""
    return _element(_ANGLES, given)


def moved_of(given: Any) -> Multivector:
    """The multivector of coefficients on e1∞, e2∞, e3∞ and, where there are four, e123∞."""
    return _element(_MOVED[: len(given)], given)


def dual_of(number: Dual) -> Multivector:
    """``c + d e123∞``, which commutes with motors."""
    return _element(_DUAL, number)


def vector(given: Any) -> Multivector:
    """``x e1 + y e2 + z e3``."""
    return _element(_VECTOR, given)


def motor_numbers(element: Multivector) -> list[Any]:
    """The eight coefficients."""
    return _read(_MOTOR, element)


def rotor_numbers(element: Multivector) -> list[Any]:
    """The four coefficients."""
    return _read(_ROTOR, element)


def bivector_numbers(element: Multivector) -> list[Any]:
    """The six coefficients."""
    return _read(_BIVECTOR, element)


def angle_numbers(element: Multivector) -> list[Any]:
    """The three coefficients on e23, e31, e12."""
    return _read(_ANGLES, element)


def moved_numbers(element: Multivector) -> list[Any]:
    """The four coefficients on e1∞, e2∞, e3∞, e123∞."""
    return _read(_MOVED, element)


def dual_numbers(element: Multivector) -> Dual:
    """Scalar part and coefficient of e123∞."""
    c, d = _read(_DUAL, element)
    return c, d


def vector_numbers(element: Multivector) -> list[Any]:
    """The coefficients of e1, e2, e3."""
    return _read(_VECTOR, element)


def translation_numbers(element: Multivector) -> list[Any]:
    """The vector ``t`` of ``(1 - ½ t∞)`` times any scalar, that scalar included."""
    return [-2 * element.coefficient(f"e{k}^einf") for k in (1, 2, 3)]


def angle_norm_squared(element: Multivector) -> Any:
    """Squares of the coefficients of e23, e31, e12, added up."""
    return sum(value * value for value in angle_numbers(element))


def scaled(element: Multivector, factor: Any) -> Multivector:
    """Every coefficient times a number."""
    product: Multivector = element * factor
    return product
