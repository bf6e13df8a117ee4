"""Which names of a script are free: read before anything is assigned to them.

A macro sees its arguments, its own names, those of the script and the macros above it. As it can
call only these, macros never recurse. Macros of one name may differ in their number of arguments.
"""

from __future__ import annotations

from collections.abc import Iterator

from motorcade.ga.script.errors import Place
from motorcade.ga.script.syntax import (
    Assignment,
    Call,
    Expression,
    Macro,
    Mark,
    Name,
    OutputPragma,
    Script,
    postorder,
)

__all__ = ["free_names"]

_Signature = tuple[str, int]


def free_names(script: Script, constants: frozenset[str]) -> dict[str, Place]:
    """Names that need values from outside, in the order of first use, and where that is."""
    known = set(constants)
    free: dict[str, Place] = {}
    macros: dict[_Signature, dict[str, Place]] = {}

    def read(name: str, place: Place) -> None:
        if name not in known:
            free.setdefault(name, place)

    for statement in script.statements:
        if isinstance(statement, Macro):
            signature = (statement.name, statement.arity)
            macros[signature] = _outside(statement, constants, macros)
        elif isinstance(statement, Mark):
            read(statement.name, statement.place)
        else:
            for name, place in _read(statement.value, macros):
                read(name, place)
            known.add(statement.name)
    for pragma in script.pragmas:
        if isinstance(pragma, OutputPragma):
            read(pragma.name, pragma.place)
    return free


def _outside(
    macro: Macro, constants: frozenset[str], macros: dict[_Signature, dict[str, Place]]
) -> dict[str, Place]:
    """The names of the script that a macro reads, by itself or through others."""
    local = set(constants)
    outside: dict[str, Place] = {}
    last = Assignment(macro.place, "", "", macro.value)
    for statement in (*macro.body, last):
        for node in postorder(statement.value):
            if isinstance(node, Name) and node.name not in local:
                outside.setdefault(node.name, node.place)
            elif isinstance(node, Call):
                outside |= macros.get((node.name, len(node.arguments)), {})
        local.add(statement.name)
    return outside


def _read(
    value: Expression, macros: dict[_Signature, dict[str, Place]]
) -> Iterator[tuple[str, Place]]:
    for node in postorder(value):
        if isinstance(node, Name):
            yield node.name, node.place
        elif isinstance(node, Call):
            yield from macros.get((node.name, len(node.arguments)), {}).items()
