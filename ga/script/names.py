"""Which names of a script are free: read before anything is assigned to them.

A macro sees its arguments, its own names, those of the script and the macros above it. As it can
call only these, macros never recurse. Macros of one name may differ in their number of arguments.
Once a macro has been called, all the names that it reads are known or free: a second call adds
none, so that every macro is looked into once.
"""

from __future__ import annotations

from collections.abc import Iterator

from motorcade.ga.script.errors import Place
from motorcade.ga.script.reading.syntax import (
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


class _Body:
    """A macro and the macros above it that it calls; looked into once."""

    def __init__(self, macro: Macro, above: dict[_Signature, _Body]) -> None:
        self.macro = macro
        last = Assignment(macro.place, "", "", macro.value)
        self._statements = (*macro.body, last)
        nodes = (node for made in self._statements for node in postorder(made.value))
        calls = {_signature(node) for node in nodes if isinstance(node, Call)}
        self._called = {key: above[key] for key in calls if key in above}
        self._seen = False

    def reads(self, constants: frozenset[str]) -> Iterator[Name | _Body]:
        """The names of the script that it reads, and the macros that it calls, in order."""
        if self._seen:
            return
        self._seen = True
        local = set(constants)
        for statement in self._statements:
            for node in postorder(statement.value):
                if isinstance(node, Name) and node.name not in local:
                    yield node
                elif isinstance(node, Call) and _signature(node) in self._called:
                    yield self._called[_signature(node)]
            local.add(statement.name)


def free_names(script: Script, constants: frozenset[str]) -> dict[str, Place]:
    """Names that need values from outside, in the order of first use, and where that is."""
    known = set(constants)
    free: dict[str, Place] = {}
    macros: dict[_Signature, _Body] = {}

    def read(name: str, place: Place) -> None:
        if name not in known:
            free.setdefault(name, place)

    for statement in script.statements:
        if isinstance(statement, Macro):
            macros[statement.name, statement.arity] = _Body(statement, macros)
        elif isinstance(statement, Mark):
            read(statement.name, statement.place)
        else:
            for node in _read(statement.value, macros, constants):
                read(node.name, node.place)
            known.add(statement.name)
    for pragma in script.pragmas:
        if isinstance(pragma, OutputPragma):
            read(pragma.name, pragma.place)
    return free


def _signature(call: Call) -> _Signature:
    return call.name, len(call.arguments)


def _read(
    value: Expression, macros: dict[_Signature, _Body], constants: frozenset[str]
) -> Iterator[Name]:
    for node in postorder(value):
        if isinstance(node, Name):
            yield node
        elif isinstance(node, Call) and _signature(node) in macros:
            yield from _inside(macros[_signature(node)], constants)


def _inside(body: _Body, constants: frozenset[str]) -> Iterator[Name]:
    """The names that a macro reads by itself or through others, without recursion."""
    waiting = [body.reads(constants)]
    while waiting:
        found = next(waiting[-1], None)
        if found is None:
            waiting.pop()
        elif isinstance(found, Name):
            yield found
        else:
            waiting.append(found.reads(constants))
