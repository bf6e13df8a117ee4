"""Names from scripts in generated code: those that a language needs for itself are refused.

The words that languages keep are in ``reserved.toml``. `typed` keeps conditions and numbers of a
tape apart, for languages in which true is no number.

A variable becomes a parameter of its own name, the script's file name becomes the function's.
Outputs get names of their own making (``out_A``), or are text in dictionaries.
"""

from __future__ import annotations

import keyword
import re
import tomllib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import BOOLEANS, Node, Tape
from motorcade.ga.codegen.targets.shared.text import SAME_NAMES, variables

C_FUNCTIONS = SAME_NAMES | {"abs": "fabs", "min": "fmin", "max": "fmax"}


_TABLE = Path(__file__).with_name("reserved.toml")
_RESERVED: dict[str, str] = tomllib.loads(_TABLE.read_text(encoding="utf-8"))


def reserved_words(language: str) -> frozenset[str]:
    """The words of ``reserved.toml`` that a language keeps."""
    return frozenset(_RESERVED[language].split())


C_WORDS = reserved_words("c")
C_LIBRARY = reserved_words("c_library") | {
    name + kind for name in reserved_words("c_math") for kind in ("", "f", "l")
}
GLSL_WORDS = reserved_words("glsl")
PYTHON_WORDS = frozenset(keyword.kwlist) | {"__debug__"}


@dataclass(frozen=True)
class Reserved:
    """What a language keeps: `words` altogether, `functions` as names of functions only.

    Where it keeps `underscores`, names that begin with one or hold two in a row are its own, and
    so are those that begin with ``gl_``.
    """

    language: str
    words: frozenset[str]
    functions: frozenset[str] = frozenset()
    underscores: bool = False

    def keeps(self, name: str) -> bool:
        """Whether no variable can have the name."""
        return name in self.words or self.keeps_form(name)

    def keeps_form(self, name: str) -> bool:
        """Whether nothing can have the name, nor one made of it."""
        return self.underscores and (name.startswith(("_", "gl_")) or "__" in name)


C_NAMES = Reserved(
    "C or C++",
    C_WORDS | {f"{name}{kind}" for name in C_FUNCTIONS.values() for kind in ("", "f")},
    C_LIBRARY,
    underscores=True,
)
GLSL_NAMES = Reserved("GLSL", GLSL_WORDS, underscores=True)


def python_names(*used: str, modules: Sequence[str] = (), underscores: bool = False) -> Reserved:
    """What Python keeps and a module uses; no file is named as one of `modules`."""
    return Reserved("Python code", PYTHON_WORDS | set(used), frozenset(modules), underscores)


class RefusedName(ValueError):
    """A name that generated code cannot have; `name` is what the script calls it."""

    def __init__(self, name: str, message: str) -> None:
        super().__init__(message)
        self.name = name


def check_names(
    program: Program, reserved: Reserved, slots: Sequence[tuple[str, str]] = ()
) -> None:
    """Refuse what a language keeps, and names that the generated code needs twice.

    `slots` are parameters with names of their own: the output or variable that each belongs to,
    and its name.

    Raises RefusedName: naming the name to use instead.
    """
    parameters = variables(program)
    taken = {*parameters} | {slot for _, slot in slots}
    why = f"is reserved in {reserved.language}"
    if reserved.keeps(program.name) or program.name in reserved.functions:
        raise _refused("file name", program.name, why, reserved, reserved.functions)
    for name in parameters:
        if reserved.keeps(name):
            raise _refused("variable", name, why, reserved, taken)
        if any(slot == name for _, slot in slots):
            raise _refused("variable", name, "is used by the generated code", reserved, taken)
    owners: dict[str, str] = {}
    for owner, slot in slots:
        if reserved.keeps_form(owner):
            raise _refused("output", owner, why, reserved, taken)
        if owners.setdefault(slot, owner) != owner:
            why = f"and {owners[slot]} have one parameter, {slot}, in the generated code"
            raise _refused("output", owner, why, reserved, taken)


def file_identifier(name: str) -> str:
    """The name of a file where that is an identifier, otherwise one like it to propose."""
    if re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name):
        return name
    identifier = re.sub("[^A-Za-z0-9_]+", "_", name).strip("_") or "script"
    return f"script_{identifier}" if identifier[0].isdigit() else identifier


def _refused(
    what: str, name: str, why: str, reserved: Reserved, taken: Collection[str]
) -> ValueError:
    free = name
    if reserved.keeps_form(free):
        free = re.sub("_+", "_", free.removeprefix("gl_")).strip("_") or "x"
    while free == name or reserved.keeps(free) or free in taken:
        free += "_" if not free.endswith("_") else "0"
    return RefusedName(name, f"{what} {name} {why}: rename {name} to {free}")


_FUNCTIONS = frozenset(SAME_NAMES) | {"abs", "min", "max"}


# Parameters are patterns in Rust: those named as a constructor of its prelude would match it.
RUST_NAMES = Reserved("Rust", reserved_words("rust"), frozenset({"main"}))
JAVASCRIPT_NAMES = Reserved("JavaScript", reserved_words("javascript"))
JULIA_NAMES = Reserved("Julia", _FUNCTIONS | reserved_words("julia"))
WGSL_NAMES = Reserved(
    "WGSL", _FUNCTIONS | reserved_words("wgsl"), frozenset({"main"}), underscores=True
)
CPP_NAMES = replace(C_NAMES, words=C_NAMES.words | {"std"})


_LOGIC = frozenset({"and", "or", "not"})


def typed(tape: Tape) -> Tape:
    """The same tape where choices and logic take conditions only, and all else takes numbers.

    A condition that is used as a number becomes the choice of 1 or 0, a number that is used as a
    condition is compared with 0.
    """
    nodes: list[Node] = []
    numbers: list[int] = []
    conditions: dict[int, int] = {}
    known: dict[Node, int] = {}

    def add(node: Node) -> int:
        if node not in known:
            known[node] = len(nodes)
            nodes.append(node)
        return known[node]

    def condition(old: int) -> int:
        if old not in conditions:
            zero = add(Node("const", value=0.0))
            conditions[old] = add(Node("ne", (numbers[old], zero)))
        return conditions[old]

    def number(old: int) -> int:
        if numbers[old] < 0:
            ends = add(Node("const", value=1.0)), add(Node("const", value=0.0))
            numbers[old] = add(Node("select", (conditions[old], *ends)))
        return numbers[old]

    for old, node in enumerate(tape.nodes):
        args = tuple(
            condition(k) if node.op in _LOGIC or (place == 0 and _chooses(node)) else number(k)
            for place, k in enumerate(node.args)
        )
        new = add(Node(node.op, args, node.value, node.source))
        numbers.append(new)
        if node.op in BOOLEANS:
            conditions[old], numbers[old] = new, -1
    results = tuple(tuple(number(k) for k in row) for row in tape.results)
    return Tape(tape.inputs, tape.outputs, tuple(nodes), results)


def _chooses(node: Node) -> bool:
    return node.op in ("select", "keep")
