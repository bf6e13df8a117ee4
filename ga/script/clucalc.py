"""What scripts of CLUCalc's have beside multivectors: texts, lists, and the values of its window.

A script is run as CLUCalc runs it when it is loaded: ``ExecMode`` is that of a change, ``Time`` is
0, sliders and boxes are where the script puts them, the mouse has not moved. Colours, and what
drawing gives, are None: nothing can be computed from them. Lists are limited in size and depth, so
that what is cheap to write is not dear to read. The meaning of operators and functions is that of
CLUCalc's manual (C. Perwass, *The CLU Project*, CLUScript 4).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga.algebra import Algebra, Multivector, scalars
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.script import syntax
from motorcade.ga.script.functions import FUNCTIONS, computed, scalar_of
from motorcade.ga.script.functions import operated as operated_on_multivectors

MAX_ROUNDS = 10_000
"""After which CLUCalc leaves a loop."""
MAX_ITEMS = 4_000
MAX_DEPTH = 12
MAX_TEXT = 100_000
_CHANGE = 1.0
_MODES = ("NEW", "ANIMATE", "TOOL", "KEYDOWN", "KEYUP", "LINK", "USER")
_NUMBERS = {
    "Pi": math.pi,
    "RadPerDeg": math.pi / 180,
    "ExecMode": _CHANGE,
    "EM_CHANGE": _CHANGE,
    **{f"EM_{mode}": 2.0**k for k, mode in enumerate(_MODES, 1)},
    **dict.fromkeys(("true", "id"), 1.0),
    **dict.fromkeys(("false", "Time", "dTime"), 0.0),
}
_TEXTS = ("ToolName", "LinkData")
# Colours, and how objects are drawn.
_STYLES = re.compile(
    r"[MD]?(?:Black|White|Gray|Red|Green|Blue|Cyan|Magenta|Yellow|Orange|Alpha)|[IO]PNS"
    r"|(?:DRAW|N3|E3|P3)_[A-Z0-9_]+|_(?:2dView|DoAnimate|FrameBoxSize|BGColor)"
)
_TOOLS = ("Slider", "CheckBox", "Choice", "Input", "Stepper")
_VALUES = ("Size", "Len", "Str", "String", "Type", "Mouse", "Color", "Matrix", "GradeList", "List")
_WORDS = ("pow", "<<", "=")


@dataclass(frozen=True, eq=False)
class Items:
    """A list, or the rows of a matrix: how many values they hold in all, and how deep they lie."""

    values: tuple[Any, ...]
    weight: int
    depth: int
    matrix: bool = False


def listed(values: Sequence[Any], matrix: bool = False) -> Items:
    """A list of values. Raises ValueError: too many of them, or too deep in each other."""
    lists = [value for value in values if isinstance(value, Items)]
    weight = len(values) + sum(item.weight for item in lists)
    depth = 1 + max((item.depth for item in lists), default=0)
    if weight > MAX_ITEMS or depth > MAX_DEPTH:
        raise ValueError(f"expected lists of at most {MAX_ITEMS} values, {MAX_DEPTH} deep")
    return Items(tuple(values), weight, depth, matrix)


def coordinates_of(value: Items) -> list[Any]:
    """The numbers of a list that a vector is made of; those of a matrix row by row."""
    rows = value.values if value.matrix else (value,)
    return [x for row in rows for x in (row.values if isinstance(row, Items) else (row,))]


def weight_of(value: Any) -> int:
    """How many steps a value counts as, where it is an operand."""
    if isinstance(value, str):
        return len(value) // 100
    return value.weight // 100 if isinstance(value, Items) else 0


def kind_of(value: Any) -> str:
    """What a value is, in CLUCalc's words."""
    if isinstance(value, Multivector):
        return "scalar" if set(value.blades) <= {"1"} else "multivector"
    names = {str: "string", Items: "list", syntax.Macro: "code"}
    return names.get(type(value), "what is only drawn")


def outputs_of(name: str, value: Any) -> dict[str, Multivector]:
    """The multivectors of a value: those of lists by their numbers; texts have none."""
    if isinstance(value, Items):
        parts: dict[str, Multivector] = {}
        for number, item in enumerate(value.values, 1):
            parts.update(outputs_of(f"{name}_{number}", item))
        return parts
    return {name: value} if isinstance(value, Multivector) else {}


def assigned_names(statements: Sequence[syntax.Statement]) -> set[str]:
    """The names that a script gives a value anywhere: until it does they stand for nothing."""
    names: set[str] = set()
    waiting = list(statements)
    while waiting:
        step = waiting.pop()
        if isinstance(step, syntax.Assignment):
            names.add(step.name.removeprefix("::"))
        elif isinstance(step, syntax.If):
            waiting += (*step.then, *step.otherwise)
        elif isinstance(step, syntax.Loop | syntax.Macro):
            waiting += step.body
    return names


def is_predefined(name: str, algebra: Algebra) -> bool:
    """Whether CLUCalc defines a variable before the script does."""
    infinity = name in ("e", "n") and "einf" in algebra.names
    known = name in _NUMBERS or name in _TEXTS or name == "I" or infinity
    return known or _STYLES.fullmatch(name) is not None


def predefined(name: str, algebra: Algebra) -> Any:
    """The value of such a variable; None for colours and styles."""
    if name in ("e", "n"):
        return algebra.blade("einf")
    if name == "I":
        inverse: Any = algebra.scalar(1.0).dual()
        return inverse.inverse()
    if name in _NUMBERS:
        return algebra.scalar(_NUMBERS[name])
    return "None" if name in _TEXTS else None


def item_of(value: Any, places: Sequence[Any]) -> Any:
    """``value(i)`` of a list or a text, from 1; ``value(i, j)`` of the list at i.

    Raises ValueError: no such place, or nothing that has any.
    """
    for place in places:
        if isinstance(value, Multivector) and len(places) == 1:
            return _component(value, _whole(place, "a place"))
        if not isinstance(value, Items | str):
            raise ValueError(f"expected a list, got a {kind_of(value)}")
        if isinstance(place, str) and isinstance(value, Items):
            index = _named(value, place)
            if not index:
                raise ValueError(f"expected an item named {place[:40]!a}, got none")
            value = value.values[index - 1].values[1]
            continue
        if isinstance(place, Items):
            return listed([item_of(value, [index]) for index in place.values])
        held = value.values if isinstance(value, Items) else value
        index = _whole(place, "a place")
        if not 1 <= index <= len(held):
            raise ValueError(f"expected a place from 1 to {len(held)}, got {index}")
        value = held[index - 1]
    return value


def _component(x: Multivector, place: int) -> Multivector:
    """The scalar, which comes first, or a coordinate of a multivector."""
    blades = ("1", *x.algebra.names)
    if not 1 <= place <= len(blades):
        raise ValueError(f"expected a place from 1 to {len(blades)}, got {place}")
    algebra: Any = x.algebra
    scalar: Multivector = algebra.scalar(x.coefficient(blades[place - 1]))
    return scalar


def _named(value: Items, name: str) -> int:
    """The place of the pair of a name and its value in a list; 0 if there is none."""
    for index, pair in enumerate(value.values, 1):
        key = pair.values[0] if isinstance(pair, Items) and len(pair.values) == 2 else None
        if isinstance(key, str) and key == name:
            return index
    return 0


def _with_item(value: Any, places: Sequence[Any], new: Any) -> Items:
    """A list with another value at a place: by number, or by a name that is added if it is new."""
    if not isinstance(value, Items):
        raise ValueError(f"expected a list, got a {kind_of(value)}")
    place, further, items = places[0], places[1:], list(value.values)
    if isinstance(place, str):
        index = _named(value, place)
        old = items[index - 1].values[1] if index else listed([])
        pair = listed([place, _with_item(old, further, new) if further else new])
        return listed([*items[: index - 1], pair, *items[index:]] if index else [*items, pair])
    index = _whole(place, "a place")
    if not 1 <= index <= len(items):
        raise ValueError(f"expected a place from 1 to {len(items)}, got {index}")
    items[index - 1] = _with_item(items[index - 1], further, new) if further else new
    return listed(items)


def _whole(value: Any, what: str) -> int:
    number = scalar_of(value) if isinstance(value, Multivector) else None
    if not isinstance(number, int | float) or number != int(number):
        raise ValueError(f"expected {what} as a whole number, got a {kind_of(value)}")
    return int(number)


def is_its_own(node: syntax.Expression, operands: Sequence[Any], clucalc: bool) -> bool:
    """Whether an operator is CLUCalc's alone: of other values, or one that others do not have."""
    if not all(isinstance(x, Multivector) for x in operands):
        return True
    if not isinstance(node, syntax.Binary | syntax.Unary):
        return False
    scalars = all(set(x.blades) <= {"1"} for x in operands)
    flags = clucalc and node.operator == "&" and scalars
    compared = clucalc and node.operator in ("==", "!=") and not scalars
    return node.operator in ("%", "!") or flags or compared


def operated(algebra: Algebra, node: syntax.Expression, operands: Sequence[Any]) -> Any:
    """The value of an operator, of lists item by item: those of two lists as a table.

    Raises ValueError: operands that it has no value for.
    """
    for number, value in enumerate(operands):
        if isinstance(value, Items):
            if value.matrix and len(operands) == 2 and isinstance(operands[1 - number], Items):
                raise ValueError("there are no products, sums or comparisons of matrices")
            rest = list(operands)
            parts = []
            for item in value.values:
                rest[number] = item
                parts.append(operated(algebra, node, rest))
            return listed(parts, value.matrix)
    operator = getattr(node, "operator", "")
    if operator == "+" and any(isinstance(x, str) for x in operands):
        return _joined(operands)
    if operator in ("==", "!="):
        alike = _alike(*operands)
        return algebra.scalar(float(alike == (operator == "==")))
    kinds = {type(x) for x in operands if not isinstance(x, Multivector)}
    if kinds == {type(None)}:
        return None
    if kinds:
        named = " and ".join(map(kind_of, operands))
        raise ValueError(f"{operator or 'this'} has no value for {named}")
    if operator == "!":
        return operands[0].inverse()
    if operator in ("%", "&") and is_its_own(node, operands, True):
        return algebra.scalar(_remainder(operator, *map(scalar_of, operands)))
    return operated_on_multivectors(algebra, node, list(operands))


def _remainder(operator: str, x: Any, y: Any) -> Any:
    """C's ``fmod``, or what two whole numbers have in common bit by bit."""
    if operator == "&":
        if not all(isinstance(part, int | float) and part == int(part) for part in (x, y)):
            raise ValueError("expected whole numbers")
        return float(int(x) & int(y))
    if is_numeric(y) and np.any(y == 0):
        raise ValueError("expected a divisor that is not 0")
    if type(x) is float and type(y) is float:
        return math.fmod(x, y)
    ratio = x / y
    return x - y * scalars.sign(ratio) * scalars.apply("floor", abs(ratio))


def _alike(left: Any, right: Any) -> bool:
    if isinstance(left, Multivector) and isinstance(right, Multivector):
        values = (left - right).values
        if not all(map(is_numeric, values)):
            raise ValueError("expected numbers, got symbols")
        return all(bool(np.all(value == 0)) for value in values)
    for value, other in ((left, right), (right, left)):
        if value is None or isinstance(value, Items | syntax.Macro):
            raise ValueError(f"cannot compare a {kind_of(value)} with a {kind_of(other)}")
    return isinstance(left, str) and isinstance(right, str) and left == right


def _joined(values: Sequence[Any]) -> str:
    text = "".join(value if isinstance(value, str) else _shown(value) for value in values)
    if len(text) > MAX_TEXT:
        raise ValueError(f"expected texts of at most {MAX_TEXT} letters")
    return text


def _shown(value: Any) -> str:
    if isinstance(value, Items):
        return f"[{', '.join(map(_shown, value.values))}]"
    return str(value) if isinstance(value, Multivector | str) else f"<{kind_of(value)}>"


def is_called(name: str, operands: Sequence[Any]) -> bool:
    """Whether a call is CLUCalc's alone, or one of values that only its scripts have."""
    others = bool(operands) and not all(isinstance(x, Multivector) for x in operands)
    return name in (*_TOOLS, *_VALUES, *_WORDS) or others


def called(algebra: Algebra, name: str, operands: Sequence[Any], tools: dict[str, Any]) -> Any:
    """The value of a function of CLUCalc's, or of another over the items of lists.

    `tools` holds the sliders and boxes so far, by what is written beside them.

    Raises ValueError: a function that does not exist, or what it refuses.
    """
    if name in _TOOLS:
        return _tool(algebra, name, operands, tools)
    if name == "<<":
        return _appended(operands[0], operands[1:])
    if name == "=":
        return _with_item(operands[0], operands[1:-1], operands[-1])
    if name == "Mouse":
        return algebra.scalar(0.0)
    if name == "Color":
        return None
    if name in _ABOUT and len(operands) == 1:
        return _ABOUT[name](algebra, operands[0])
    for number, value in enumerate(operands):
        if isinstance(value, Items):
            before, after = list(operands[:number]), list(operands[number + 1 :])
            parts = [called(algebra, name, [*before, item, *after], tools) for item in value.values]
            return listed(parts, value.matrix)
    if any(x is None for x in operands):
        return None
    if name == "pow" and len(operands) == 2:
        return _power(algebra, *operands)
    if name not in FUNCTIONS or not all(isinstance(x, Multivector) for x in operands):
        kinds = ", ".join(map(kind_of, operands))
        raise ValueError(f"there is no function or macro of this name for {kinds}")
    return computed(FUNCTIONS[name], list(operands))


def _tool(algebra: Algebra, name: str, operands: Sequence[Any], tools: dict[str, Any]) -> Any:
    """Where a slider or box stands at first: its last number, 0 if there is none."""
    if not operands or not isinstance(operands[0], str):
        raise ValueError("expected a text as the first argument")
    numbers = [x for x in operands[1:] if isinstance(x, Multivector)]
    if numbers:
        tools[operands[0]] = numbers[-1]
    return tools.get(operands[0], algebra.scalar(1.0 if name == "Choice" else 0.0))


def _appended(value: Any, items: Sequence[Any]) -> Any:
    if isinstance(value, str):
        return _joined([value, *items])
    held = value.values if isinstance(value, Items) else (value,)
    added: list[Any] = []
    for item in items:
        added.extend(item.values if isinstance(item, Items) else [item])
    return listed([*held, *added])


def _power(algebra: Algebra, x: Any, exponent: Any) -> Any:
    if not isinstance(x, Multivector) or not isinstance(exponent, Multivector):
        raise ValueError(f"expected numbers, got {kind_of(x)} and {kind_of(exponent)}")
    power = scalar_of(exponent)
    if set(x.blades) <= {"1"}:
        base = scalar_of(x)
        if type(base) is float and type(power) is float:
            return algebra.scalar(math.pow(base, power))
        return algebra.scalar(scalars.apply("power", base, power))
    count = _whole(exponent, "a power of a multivector")
    if not 0 <= count <= 16:
        raise ValueError(f"expected a power from 0 to 16, got {count}")
    product: Any = algebra.scalar(1.0)
    for _ in range(count):
        product = product * x
    return product


def _size(algebra: Algebra, value: Any) -> Any:
    if isinstance(value, Items | str):
        return algebra.scalar(float(len(value.values if isinstance(value, Items) else value)))
    raise ValueError(f"expected a list or a text, got a {kind_of(value)}")


def _grades(algebra: Algebra, value: Any) -> Any:
    if not isinstance(value, Multivector):
        raise ValueError(f"expected a multivector, got a {kind_of(value)}")
    if not all(isinstance(part, int | float) for part in value.values):
        raise ValueError("expected one multivector of numbers")
    parts = zip(value.masks, value.values, strict=True)
    grades = {mask.bit_count() for mask, part in parts if part}
    return listed([algebra.scalar(float(grade)) for grade in sorted(grades, reverse=True)])


def _list(algebra: Algebra, value: Any) -> Any:
    count = _whole(value, "a size")
    if not 0 <= count <= MAX_ITEMS:
        raise ValueError(f"expected a size from 0 to {MAX_ITEMS}, got {count}")
    return listed([algebra.scalar(0.0)] * count)


def _matrix(value: Any) -> Items:
    rows = value.values if isinstance(value, Items) else ()
    sizes = {len(row.values) for row in rows if isinstance(row, Items)}
    if len(sizes) != 1 or not all(isinstance(row, Items) for row in rows):
        raise ValueError("expected a list of rows of one size")
    return listed([listed(row.values, matrix=True) for row in rows], matrix=True)


_ABOUT: dict[str, Callable[[Algebra, Any], Any]] = {
    "Size": _size,
    "Len": _size,
    "List": _list,
    "GradeList": _grades,
    "Str": lambda algebra, value: _joined([value]),
    "String": lambda algebra, value: _joined([value]),
    "Matrix": lambda algebra, value: _matrix(value),
    "Type": lambda algebra, value: kind_of(value),
}
