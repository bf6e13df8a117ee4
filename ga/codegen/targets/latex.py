r"""LaTeX: the program as formulas, an ``align*`` of amsmath, with numbers to their last digit.

Values that are used more than once, and parts of long formulas, have a line of their own; below
stands each output as a sum of its blades. Names longer than a letter are set in one word, digits at
the end of a letter become its index, names of Greek letters these letters. An output that has the
name of a variable is primed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Node, Tape
from motorcade.ga.codegen.targets.names import typed
from motorcade.ga.codegen.targets.shared.expressions import component_name
from motorcade.ga.codegen.targets.shared.text import description
from motorcade.ga.notation import blade_text, name_text, number_text

_MOST_SYMBOLS = 18
_SUM, _PRODUCT, _CALL, _ATOM = 1, 2, 3, 4
_CALLS = {
    "exp": r"\exp", "log": r"\ln", "sin": r"\sin", "cos": r"\cos", "tan": r"\tan",
    "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "min": r"\min", "max": r"\max",
    "atan2": r"\operatorname{atan2}",
}  # fmt: skip
_AROUND = {
    "sqrt": (r"\sqrt{", "}"),
    "abs": (r"\left|", r"\right|"),
    "floor": (r"\left\lfloor ", r"\right\rfloor"),
    "ceil": (r"\left\lceil ", r"\right\rceil"),
}
_RELATIONS = {
    "lt": "<", "le": r"\le", "eq": "=", "ne": r"\ne", "and": r"\land", "or": r"\lor",
}  # fmt: skip
_Written = tuple[str, int, int]
"""The text of a value, how tightly it binds, and of how many symbols it is made."""


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The formulas.

    Raises ValueError: a precision other than float64, to which numbers are written.
    """
    if precision not in (None, DOUBLE):
        raise ValueError(f"target latex: expected precision float64, got {precision.numpy}")
    tape = typed(program.tape)
    lines, results = _lines(tape)
    inputs = {operand.name for operand in tape.inputs}
    for operand, row in zip(tape.outputs, results, strict=True):
        named = name_text(operand.name) + ("'" if operand.name in inputs else "")
        lines += _output(named, operand.components, row)
    text = [
        *(f"% {line}".rstrip() for line in description(program, "latex")),
        r"\begin{align*}",
        " \\\\\n".join(lines),
        r"\end{align*}",
    ]
    return {f"{program.name}.tex": "\n".join(text) + "\n"}


def _lines(tape: Tape) -> tuple[list[str], list[list[_Written]]]:
    """The lines of named values, and the text of each result."""
    widths = {operand.name: operand.width for operand in tape.inputs}
    taken = {component_name(o.name, k, o.width) for o in tape.inputs for k in range(o.width)}
    taken |= {operand.name for operand in tape.outputs}
    names = (name for k in count() if (name := f"t{k}") not in taken)
    uses = tape.uses()
    last = {index for row in tape.results for index in row}
    written: list[_Written] = []
    lines: list[str] = []
    for index, node in enumerate(tape.nodes):
        if node.op == "input":
            written_node = name_text(component_name(*node.source, widths[node.source[0]])), _ATOM, 1
        else:
            written_node = _operation(node, [written[k] for k in node.args], node.args)
        text, _, size = written_node
        if node.args and (uses[index] > 1 or (size > _MOST_SYMBOLS and index not in last)):
            name = name_text(next(names))
            lines.append(f"{name} &= {text}")
            written_node = name, _ATOM, 1
        written.append(written_node)
    return lines, [[written[k] for k in row] for row in tape.results]


def _operation(node: Node, args: Sequence[_Written], places: Sequence[int]) -> _Written:
    size = sum(arg[2] for arg in args) + 1
    texts = [arg[0] for arg in args]
    if node.op == "const":
        text = number_text(node.value)
        plain = node.value >= 0 and "cdot" not in text
        return text, _ATOM if plain else _PRODUCT, 1
    if node.op in _AROUND:
        opening, closing = _AROUND[node.op]
        return f"{opening}{texts[0]}{closing}", _ATOM, size
    if node.op in _CALLS:
        return rf"{_CALLS[node.op]}\left({', '.join(texts)}\right)", _CALL, size
    if node.op in _RELATIONS:
        left, right = (_bracketed(arg, _PRODUCT) for arg in args)
        return f"{left} {_RELATIONS[node.op]} {right}", _SUM, size
    if node.op in ("select", "keep"):
        condition, chosen, otherwise = (*texts, "0")[:3]
        cases = rf"{chosen} & \text{{if }} {condition} \\ {otherwise} & \text{{otherwise}}"
        return rf"\begin{{cases}} {cases} \end{{cases}}", _CALL, size
    if node.op in ("neg", "not"):
        sign = "-" if node.op == "neg" else r"\lnot "
        return sign + _bracketed(args[0], _PRODUCT, signed=False), _PRODUCT, size
    return (
        _infix(node.op, args, places),
        _SUM if node.op in ("add", "sub") else _level(node.op),
        size,
    )


def _level(op: str) -> int:
    return _CALL if op == "div" else _PRODUCT


def _infix(op: str, args: Sequence[_Written], places: Sequence[int]) -> str:
    left, right = args
    if op == "div":
        return rf"\frac{{{left[0]}}}{{{right[0]}}}"
    if op in ("add", "sub"):
        second = _bracketed(right, _SUM if op == "add" else _PRODUCT)
        if second.startswith("-"):  # a + (-b) is a - b
            op, second = ("sub" if op == "add" else "add"), second[1:]
            if right[1] == _SUM:
                op, second = "add", rf"\left({right[0]}\right)"
        return f"{left[0]} {'+' if op == 'add' else '-'} {second}"
    if places[0] == places[1]:
        return f"{_bracketed(left, _ATOM)}^{{2}}"
    if right[0][0].isdigit() and not left[0][0].isdigit():
        left, right = right, left
    first, second = _bracketed(left, _PRODUCT), _bracketed(right, _PRODUCT, signed=False)
    return f"{first} {chr(92)}cdot {second}" if second[0].isdigit() else rf"{first}\,{second}"


def _bracketed(written: _Written, least: int, *, signed: bool = True) -> str:
    text, level, _ = written
    if level >= least and (signed or not text.startswith("-")):
        return text
    return rf"\left({text}\right)"


def _output(named: str, blades: Sequence[str], row: Sequence[_Written]) -> list[str]:
    """Lines of one output, a blade each."""
    lines: list[str] = []
    for blade, value in zip(blades, row, strict=True):
        text, vector = value[0], blade_text(blade)
        if vector:
            signs = {"1": vector, "-1": f"-{vector}"}
            text = signs.get(text) or rf"{_bracketed(value, _PRODUCT)}\,{vector}"
        if lines and not text.startswith("-"):
            text = f"+ {text}"
        lines.append(rf"&\quad {text}" if lines else f"{named} &= {text}")
    return lines or [f"{named} &= 0"]
