"""Names from scripts in generated code: those that a language needs for itself are refused.

A variable becomes a parameter of its own name, the script's file name becomes the function's.
Outputs get names of their own making (``out_A``), or are text in dictionaries.
"""

from __future__ import annotations

import keyword
import re
import tomllib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from motorcade.ga.codegen.programs import Program
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
