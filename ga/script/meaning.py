"""What a script means: its outputs as multivectors over any scalars.

Statements run in order and a name may be assigned again. An output marked ``?`` has the value it
had at its last mark; one named by a pragma alone has its value at the end. Outputs come in the
order of the script, those of pragmas last.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.algebra import CGA3, Algebra, Multivector
from motorcade.ga.script import clucalc, syntax
from motorcade.ga.script.algebras import (
    AlgebraDefinition,
    Macros,
    definition_of,
    definitions,
    read_definition,
)
from motorcade.ga.script.errors import Place, ScriptError
from motorcade.ga.script.run import Run, Watch, constants_of
from motorcade.ga.script.syntax import AlgebraPragma, Script


class _Names:
    """Names that a script reads and assigns so far."""

    def __init__(
        self, constants: frozenset[str], macros: Macros, normalized: list[Place], drawn: bool
    ) -> None:
        self._normalized = normalized
        self._drawn = drawn
        self.free: dict[str, Place] = {}
        self._constants = constants
        self._known = set(constants)
        self.macros = macros
        self._seen: set[syntax.Macro] = set()

    @property
    def known(self) -> frozenset[str]:
        """The names that have been assigned."""
        return frozenset(self._known)

    def read(self, name: str, place: Place) -> None:
        if name not in self._known:
            self.free.setdefault(name, place)

    def run(self, steps: Sequence[syntax.Step]) -> None:
        """Go through statements in their order; what a branch assigns is known behind it."""
        for step in steps:
            if isinstance(step, syntax.Mark):
                self.read(step.name, step.place)
            elif isinstance(step, syntax.Assignment):
                self._read_all(self._inside([step.value], None))
                self._known.add(step.name.removeprefix("::"))
                if step.mark == "?" and any(place < step.place for place in self._normalized):
                    self._known.add(f"{step.name}_unnormalized")
            elif isinstance(step, syntax.If):
                self._read_all(self._inside([step.condition], None))
                self.run(step.then)
                self.run(step.otherwise)
            elif isinstance(step, syntax.Loop):
                self.run(step.body)
            elif isinstance(step, syntax.Screen) and self._drawn and not step.word and step.value:
                self._read_all(self._inside([step.value], None))

    def _read_all(self, start: Iterator[syntax.Name | syntax.Macro]) -> None:
        """The names that are read, those of macros where they are called, without recursion."""
        waiting = [start]
        while waiting:
            node = next(waiting[-1], None)
            if node is None:
                waiting.pop()
            elif isinstance(node, syntax.Name):
                self.read(node.name.removeprefix("::"), node.place)
            elif node not in self._seen:
                self._seen.add(node)
                waiting.append(self._of_macro(node))

    def _inside(
        self, values: Iterable[syntax.Expression], macro: syntax.Macro | None
    ) -> Iterator[syntax.Name | syntax.Macro]:
        """Names and macros of the script in expressions; `macro` is what they stand in."""
        for node in (node for value in values for node in syntax.postorder(value)):
            call = ("Dual", 1) if isinstance(node, syntax.Unary) and node.operator == "*" else None
            if isinstance(node, syntax.Call):
                call = (node.name.removeprefix("::"), len(node.arguments))
            if isinstance(node, syntax.Name):
                yield node
            elif isinstance(node, syntax.Call) and node.name == ":=":
                self._known.add(getattr(node.arguments[0], "text", ""))
            elif call is not None:
                macro_called = self.macros.found(*call, macro) or self.macros.named(call[0])
                if isinstance(macro_called, syntax.Macro) and self.macros.is_own(macro_called):
                    yield macro_called

    def _of_macro(self, macro: syntax.Macro) -> Iterator[syntax.Name | syntax.Macro]:
        """What a macro reads beside its own names."""
        local = set(self._constants)

        def steps_of(steps: Sequence[syntax.Step]) -> Iterator[tuple[syntax.Expression, str]]:
            for step in steps:
                if isinstance(step, syntax.Assignment):
                    yield step.value, step.name
                elif isinstance(step, syntax.Mark):
                    yield syntax.Name(step.place, step.name), ""
                elif isinstance(step, syntax.If):
                    yield step.condition, ""
                    yield from steps_of((*step.then, *step.otherwise))
                elif isinstance(step, syntax.Loop):
                    yield from steps_of(step.body)

        last = [] if macro.value is None else [(macro.value, "")]
        for value, assigned in (*steps_of(macro.body), *last):
            for node in self._inside([value], macro):
                if isinstance(node, syntax.Macro) or node.name not in local:
                    yield node
            (self._known if assigned.startswith("::") else local).add(assigned.removeprefix("::"))


def free_names(
    script: syntax.Script, algebra: Algebra, definition: AlgebraDefinition, *, drawn: bool = False
) -> dict[str, Place]:
    """Names that need values from outside, in the order of first use, and where that is.

    `drawn`: those too that only what is drawn needs.
    """
    normalized = [p.place for p in script.pragmas if isinstance(p, syntax.NormalizePragma)]
    names = _Names(constants_of(algebra), Macros(script, definition), normalized, drawn)
    names.run([step for step in script.statements if not isinstance(step, syntax.Macro)])
    for pragma in script.pragmas:
        if isinstance(pragma, syntax.OutputPragma):
            names.read(pragma.name, pragma.place)
    if script.clucalc:
        known = [name for name in names.free if clucalc.is_predefined(name, algebra)]
        known += [name for name in names.free if names.macros.named(name) is not None]
        known += names.known
        return {name: place for name, place in names.free.items() if name not in known}
    return names.free


def first_place(script: syntax.Script, name: str) -> Place | None:
    """Where a script's statements first have a name; None where only its pragmas do, or macros."""
    waiting = [step for step in reversed(script.statements) if not isinstance(step, syntax.Macro)]
    while waiting:
        step = waiting.pop()
        if isinstance(step, syntax.Assignment | syntax.Mark) and step.name == name:
            return step.place
        for node in (n for value in syntax.expressions_of([step]) for n in syntax.postorder(value)):
            if isinstance(node, syntax.Name) and node.name.removeprefix("::") == name:
                return node.place
        if isinstance(step, syntax.If):
            waiting += reversed((*step.then, *step.otherwise))
        elif isinstance(step, syntax.Loop):
            waiting += reversed(step.body)
    return None


def declared_inputs(script: syntax.Script) -> dict[str, Place]:
    """The inputs that ``#pragma in2out`` names, in its order."""
    return {
        pragma.name: pragma.place
        for pragma in script.pragmas
        if isinstance(pragma, syntax.InputPragma)
    }


# What other scripts call the null vectors, where they come up as free variables.
_CALLED = {
    **dict.fromkeys(("e", "n", "ni"), "the point at infinity is einf"),
    **dict.fromkeys(("no", "nbar"), "the origin is e0"),
    **dict.fromkeys(("pi", "Pi", "PI"), "the number is acos(-1)"),
    "I": "the pseudoscalar of cga3 is e1^e2^e3^einf^e0, and *x is x/I",
}


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
    return watched(script, None, algebra, variables)


def watched(
    script: Script, watch: Watch | None, algebra: Algebra | None, variables: dict[str, Any]
) -> dict[str, Multivector]:
    """As `evaluate`; who watches is shown what is marked for an image as it comes by.

    Raises:
        ScriptError: what `evaluate` refuses, also in what is drawn.
        ValueError: as there.
    """
    definition = definition_for(script, algebra)
    chosen = definition.algebra if algebra is None else algebra
    read = free_names(script, chosen, definition, drawn=watch is not None)
    values = _given_variables(script, chosen, read, variables)
    with np.errstate(all="ignore"):
        return Run(script, chosen, definition, values, watch).outputs()


def algebra_of(script: Script, preferred: Algebra | None = None) -> Algebra:
    """The algebra of a script: the one given or that of its pragma, CGA3 where there is neither.

    Raises ScriptError: an algebra that is not known, or two that differ.
    """
    algebra = definition_for(script, preferred).algebra
    return algebra if preferred is None else preferred


def definition_for(script: Script, algebra: Algebra | None = None) -> AlgebraDefinition:
    """The algebra of a script as `algebra_of` finds it, with its macros.

    Raises ScriptError: an algebra that is not known, or two that differ.
    """
    chosen = None if algebra is None else definition_of(algebra)
    for pragma in script.pragmas:
        if isinstance(pragma, AlgebraPragma):
            named = _pragma_definition(script, pragma)
            if chosen is not None and chosen.algebra != named.algebra:
                raise script.source.error(
                    pragma.place, f"expected one algebra, got {chosen.algebra} and {named.algebra}"
                )
            chosen = named
    return definition_of(CGA3) if chosen is None else chosen


def algebra_named(name: str) -> Algebra:
    """An algebra by what a pragma would call it: a name, or ``P Q R``.

    Raises ValueError: neither, or a signature that is too large.
    """
    known = definitions()
    if name in known:
        return known[name].algebra
    if re.fullmatch(r"[0-9]{1,3}( +[0-9]{1,3}){2}", name, re.ASCII):
        p, q, r = map(int, name.split())
        return Algebra(p, q, r)
    raise ValueError(
        f"algebra: expected {', '.join(known)} or a signature P Q R, got {name[:80]!a}"
    )


def with_algebra(script: Script, name: str) -> Script:
    """The script in an algebra: as if it said so itself, but that a file may lie anywhere.

    Args:
        script: from `parse`.
        name: as `algebra_named` takes it, or the path of a definition, which ends in .toml.

    Raises:
        FileError: a definition, or its macros, that cannot be read or are wrong, and which field.
        ScriptError: what is wrong with its macros.
        ValueError: neither a name nor a signature nor such a path.

    >>> from motorcade.ga.script import evaluate, parse
    >>> from motorcade.ga.script.meaning import with_algebra
    >>> evaluate(with_algebra(parse("?square = e4*e4;"), "sta"))["square"]
    -1
    """
    if not name.endswith(".toml"):
        try:
            algebra_named(name)
        except ValueError as refused:
            hint = "a definition of one's own is a file that ends in .toml"
            raise ValueError(f"{refused}; {hint}") from None
        p, q, r = map(int, name.split()) if " " in name else (0, 0, 0)
        pragma = AlgebraPragma(Place(1, 1), "" if " " in name else name, (p, q, r), by_caller=True)
        return replace(script, pragmas=(pragma, *script.pragmas))
    path = Path(name)
    # What the user points to by a link is meant, and its macros lie beside what that leads to.
    path = path.resolve() if path.is_symlink() else path
    _read(path.parent, path.name)
    pragma = AlgebraPragma(Place(1, 1), path.name, (0, 0, 0), by_caller=True, folder=path.parent)
    return replace(script, pragmas=(pragma, *script.pragmas))


def _pragma_definition(script: Script, pragma: AlgebraPragma) -> AlgebraDefinition:
    known = definitions()
    try:
        if not pragma.name:
            return definition_of(Algebra(*pragma.signature))
        if pragma.name.endswith(".toml"):
            return _read(pragma.folder if pragma.by_caller else script.folder, pragma.name)
    except ScriptError:
        raise
    except ValueError as refused:
        raise script.source.error(pragma.place, str(refused)) from refused
    if pragma.name not in known:
        raise script.source.error(
            pragma.place,
            f"expected an algebra {', '.join(known)}, got {pragma.name[:40]}",
            "any other is written as its signature or as its file: #pragma algebra P Q R",
        )
    return known[pragma.name]


def _read(folder: Path | None, file: str) -> AlgebraDefinition:
    """The definition of a file, whose macros are read to be refused here and not later."""
    definition = read_definition(folder, file)
    assert definition.macros is not None
    return definition


def free_variables(script: Script, algebra: Algebra) -> dict[str, Place]:
    """Variables that a script needs from outside, in the order of first use, and where that is.

    Raises ScriptError: one is named ``algebra``, which `evaluate` could not be given.
    """
    read = free_names(script, algebra, definition_for(script, algebra))
    return _with_declared(script, algebra, read)


def _with_declared(script: Script, algebra: Algebra, read: dict[str, Place]) -> dict[str, Place]:
    """The variables that a script reads, after those that it declares as inputs."""
    free = {**declared_inputs(script), **read}
    for name in sorted(set(free) & constants_of(algebra)):
        raise script.source.error(free[name], f"{name} is a basis vector of {algebra}")
    if "algebra" in free:
        raise script.source.error(
            free["algebra"], "no free variable can be named algebra", "choose another name"
        )
    return free


def _given_variables(
    script: Script, algebra: Algebra, read: dict[str, Place], variables: dict[str, Any]
) -> dict[str, Multivector]:
    free = _with_declared(script, algebra, read)
    missing = [name for name in read if name not in variables]
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
    given_variables = {}
    for name, value in variables.items():
        try:
            given_variables[name] = algebra.scalar(float(value) if type(value) is int else value)
        except (ValueError, OverflowError) as refused:
            raise ValueError(f"variable {name}: {refused}") from refused
    return given_variables
