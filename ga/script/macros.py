"""What a call means: a function, a macro of the script, or one of its algebra's.

Functions of Gaalop's come first, in any case of letters, as no macro of theirs name is ever called
there. A script's macros come before its algebra's and before the other functions, wherever in the
script they stand, but for calls inside the macro itself and inside the algebra's own.
"""

from __future__ import annotations

import difflib

from motorcade.ga.script.algebras import AlgebraDefinition, definitions
from motorcade.ga.script.functions import ANY_CASE, FUNCTIONS, Function
from motorcade.ga.script.reading.syntax import Call, Macro, Script

Key = tuple[str, int]


class Macros:
    """The macros that a script sees."""

    def __init__(self, script: Script, definition: AlgebraDefinition) -> None:
        self.own: dict[Key, Macro] = {}
        self._definition = definition
        for statement in script.statements:
            if isinstance(statement, Macro):
                self._define(statement)

    def _define(self, macro: Macro) -> None:
        key = (macro.name, macro.arity)
        if key in self.own or macro.name.lower() in ANY_CASE:
            raise macro.source.error(
                macro.place, f"{macro.name} is already defined", "choose another name"
            )
        self.own[key] = macro

    def is_own(self, macro: Macro | None) -> bool:
        """Whether a macro is the script's, or one that it imports."""
        return macro is not None and self.own.get((macro.name, macro.arity)) is macro

    def found(self, name: str, count: int, inside: Macro | None) -> Function | Macro | None:
        """What a call of `count` arguments means in the body of a macro, or outside of all."""
        if name.lower() in ANY_CASE:
            return FUNCTIONS[name.lower()]
        places = [self._definition.macros]
        if inside is None or self.is_own(inside):
            places.insert(0, self.own)
        for macros in places:
            macro = macros.get((name, count))
            if macro is not None and macro is not inside:
                return macro
        return FUNCTIONS.get(name)

    def unknown(self, node: Call, inside: Macro | None) -> tuple[str, str]:
        """Message and hint for a call that means nothing."""
        known = [*self.own, *self._definition.macros]
        counts = sorted({arity for name, arity in known if name == node.name})
        counts = [count for count in counts if count != len(node.arguments)]
        if counts:
            wanted = " or ".join(map(str, counts))
            return f"{node.name}: expected {wanted} arguments, got {len(node.arguments)}", ""
        message = f"there is no function or macro {node.name[:40]}"
        if inside is not None and inside.name == node.name:
            return message, "inside itself: a macro calls others alone"
        names = [*FUNCTIONS, *dict.fromkeys(name for name, _ in known if name[0] != "_")]
        near = difflib.get_close_matches(node.name[:40], names, n=1, cutoff=0.75)
        here = self._definition.algebra
        for name, other in definitions().items():
            if other.algebra != here and any(macro == node.name for macro, _ in other.macros):
                return message, f"{node.name} is a macro of {name}, and this is {here}"
        return message, f"did you mean {near[0]}?" if near else "define it as a macro"
