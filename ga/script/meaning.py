"""What a script means: its outputs as multivectors over any scalars.

Statements run in order and a name may be assigned again. An output marked ``?`` has the value it
had at its last mark; one named by a pragma alone has its value at the end. Outputs come in the
order of the script, those of pragmas last.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.script.errors import Place
from motorcade.ga.script.reading.syntax import (
    AlgebraPragma,
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
from motorcade.ga.script.run import Run, constants_of

_Signature = tuple[str, int]
ALGEBRAS: dict[str, Algebra] = {
    "ega2": Algebra(2),
    "ega3": EGA3,
    "pga2": Algebra(2, 0, 1, ("e1", "e2", "e0")),
    "pga3": PGA3,
    "cga2": Algebra(3, 1, null_pair=True),
    "cga3": CGA3,
}
# What other scripts call the null vectors, where they come up as free variables.
_CALLED = {
    **dict.fromkeys(("e", "n", "ni"), "the point at infinity is einf"),
    **dict.fromkeys(("no", "nbar"), "the origin is e0"),
    "I": "the pseudoscalar of cga3 is e1^e2^e3^einf^e0, and *x is x/I",
}


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


def evaluate(
    script: Script, /, algebra: Algebra | None = None, **variables: Any
) -> dict[str, Multivector]:
    """The outputs of a script, by name.

    Args:
        script: from `parse`.
        algebra: CGA3 unless given here or by the script's algebra pragma.
        variables: the script's free variables: real scalars of any kind, batches ``(*)`` included.

    Raises:
        ScriptError: free variables without a value, what is not defined, numbers that overflow,
            a divisor without inverse, too many steps.
        ValueError: variables that the script does not have, or that are no finite real scalars.

    >>> from motorcade.ga.script import evaluate, parse
    >>> script = parse("a = x*e1 + 2*e2; ?square = a*a;")
    >>> evaluate(script, x=3.0)["square"].coefficient("1")
    13.0
    """
    chosen = algebra_of(script, algebra)
    given = _given_variables(script, chosen, variables)
    with np.errstate(all="ignore"):
        return Run(script, chosen, given).outputs()


def algebra_of(script: Script, given: Algebra | None = None) -> Algebra:
    """The algebra of a script: the one given or that of its pragma, CGA3 where there is neither.

    Raises:
        ScriptError: an algebra that is not known, or two that differ.
    """
    chosen = given
    for pragma in script.pragmas:
        if isinstance(pragma, AlgebraPragma):
            named = _pragma_algebra(script, pragma)
            if chosen is not None and chosen != named:
                raise script.source.error(
                    pragma.place, f"expected one algebra, got {chosen} and {named}"
                )
            chosen = chosen or named
    return CGA3 if chosen is None else chosen


def algebra_named(name: str) -> Algebra:
    """An algebra by what a pragma would call it: a name, or ``P Q R``.

    Raises:
        ValueError: neither, or a signature that is too large.
    """
    if name in ALGEBRAS:
        return ALGEBRAS[name]
    if re.fullmatch(r"[0-9]{1,3}( +[0-9]{1,3}){2}", name, re.ASCII):
        p, q, r = map(int, name.split())
        return Algebra(p, q, r)
    raise ValueError(f"algebra: expected {', '.join(ALGEBRAS)} or a signature P Q R, got {name!a}")


def _pragma_algebra(script: Script, pragma: AlgebraPragma) -> Algebra:
    if not pragma.name:
        try:
            return Algebra(*pragma.signature)
        except ValueError as refused:
            raise script.source.error(pragma.place, str(refused)) from refused
    if pragma.name not in ALGEBRAS:
        raise script.source.error(
            pragma.place,
            f"expected an algebra {', '.join(ALGEBRAS)}, got {pragma.name[:40]}",
            "any other is written as its signature: //#pragma algebra P Q R",
        )
    return ALGEBRAS[pragma.name]


def free_variables(script: Script, algebra: Algebra) -> dict[str, Place]:
    """Variables that a script needs from outside, in the order of first use, and where that is.

    Raises:
        ScriptError: one is named ``algebra``, which `evaluate` could not be given.
    """
    free = free_names(script, constants_of(algebra))
    if "algebra" in free:
        raise script.source.error(
            free["algebra"], "no free variable can be named algebra", "choose another name"
        )
    return free


def _given_variables(
    script: Script, algebra: Algebra, variables: dict[str, Any]
) -> dict[str, Multivector]:
    free = free_variables(script, algebra)
    missing = [name for name in free if name not in variables]
    if missing:
        raise script.source.error(
            free[missing[0]],
            f"expected values of the free variables {', '.join(missing)}, got none",
            _CALLED.get(missing[0], "") or f"assign them, or pass them to evaluate: {missing[0]}=…",
        )
    unknown = [name for name in variables if name not in free]
    if unknown:
        raise ValueError(
            f"variables: expected {', '.join(free) or 'none'}, got also {', '.join(unknown)}"
        )
    made = {}
    for name, value in variables.items():
        try:
            made[name] = algebra.scalar(float(value) if type(value) is int else value)
        except (ValueError, OverflowError) as refused:
            raise ValueError(f"variable {name}: {refused}") from refused
    return made
