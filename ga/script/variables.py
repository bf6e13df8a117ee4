"""The free variables of a script: names that it reads before it assigns them.

Macros read names of the script too, and are looked into where they are first called.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from motorcade.ga.algebra import Algebra
from motorcade.ga.script import clucalc
from motorcade.ga.script.algebras import AlgebraDefinition, Macros
from motorcade.ga.script.errors import Place
from motorcade.ga.script.reading import syntax
from motorcade.ga.script.run import constants_of


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
