"""Algebras as files: basis vectors, null pairs, names of other vectors, macros in CLUScript.

Each folder here holds one: ``definition.toml`` and, where it has macros, ``macros.clu``. Files of
users' own look the same; `read_definition` reads them. A definition has the tables ``squares`` (1,
-1 or 0 by basis vector, in the order of the basis) and may have ``null_pairs`` (pairs of vectors of
square 0 whose inner product is -1), ``named`` (sums of basis vectors by a name of their own),
``names`` (of the algebra) and ``macros`` (the name of a file below the definition's folder).

A call means a function, a macro of the script, or one of its algebra's. Functions of Gaalop's come
first, in any case of letters, as no macro of theirs name is ever called there. A script's macros
come before its algebra's and before the other functions, wherever in the script they stand, but for
calls inside the macro itself and inside the algebra's own.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra
from motorcade.ga.algebra.signature import MAX_DIMENSION
from motorcade.ga.files import FileError, read_bounded
from motorcade.ga.script.errors import MAX_IMPORTED_BYTES, path_below, text_of
from motorcade.ga.script.functions import ANY_CASE, FUNCTIONS, Function
from motorcade.ga.script.parser import parse
from motorcade.ga.script.syntax import Call, Macro, Screen, Script

MAX_DEFINITION_BYTES = 100_000
MAX_NAME = 64
_Table = Mapping[tuple[str, int], Macro]
_TABLES = ("names", "squares", "null_pairs", "named", "macros")
_KNOWN = {algebra: algebra for algebra in (CGA3, EGA3, PGA3)}


@dataclass(frozen=True)
class AlgebraDefinition:
    """An algebra, the names it goes by, and its macros by name and number of arguments."""

    names: tuple[str, ...]
    algebra: Algebra
    folder: Path | None = None
    macro_file: str = ""

    @cached_property
    def macros(self) -> _Table:
        """The macros, read when they are first asked for.

        Raises FileError: a file that cannot be read; ScriptError: what is wrong with one.
        """
        common = _common_macros()
        if not self.macro_file:
            return common
        path = path_below(self.folder, self.macro_file)
        text = text_of(path, read_bounded(path, MAX_IMPORTED_BYTES))
        return common | _macros_of(parse(text, str(path), self.folder))


@cache
def _common_macros() -> dict[tuple[str, int], Macro]:
    """What every algebra has that does not say otherwise."""
    path = Path(__file__).parent / "common.clu"
    return _macros_of(parse(text_of(path, read_bounded(path, MAX_IMPORTED_BYTES)), "<macros>"))


def _macros_of(script: Script) -> dict[tuple[str, int], Macro]:
    macros: dict[tuple[str, int], Macro] = {}
    for statement in script.statements:
        if isinstance(statement, Screen):
            continue
        if not isinstance(statement, Macro):
            raise script.source.error(statement.place, "expected macros alone in an algebra's file")
        key = (statement.name, statement.arity)
        if key in macros:
            raise statement.source.error(statement.place, f"{statement.name} is already defined")
        macros[key] = statement
    return macros


@cache
def definitions() -> dict[str, AlgebraDefinition]:
    """The algebras that have a name, in the order of their folders."""
    by_name = {}
    for path in sorted(Path(__file__).parent.glob("*/definition.toml")):
        definition = read_definition(path.parent, path.name)
        by_name.update(dict.fromkeys(definition.names, definition))
    return by_name


@cache
def _by_algebra() -> dict[Algebra, AlgebraDefinition]:
    return {found.algebra: found for found in definitions().values()}


def definition_of(algebra: Algebra) -> AlgebraDefinition:
    """The definition of an algebra: with macros of its own if it has a name, else the common ones.

    >>> from motorcade.ga.algebra import CGA3, Algebra
    >>> from motorcade.ga.script.algebras import definition_of
    >>> definition_of(CGA3).names, definition_of(Algebra(3, 3)).names
    (('cga', 'cga3'), ())
    """
    return _by_algebra().get(algebra) or AlgebraDefinition((), algebra)


def read_definition(folder: Path | None, file: str) -> AlgebraDefinition:
    """Read a definition from a file below a folder.

    Raises ValueError: a file that cannot be read, is larger than `MAX_DEFINITION_BYTES` or is no
    TOML; tables that are not those above; what `Algebra.of` refuses.
    """
    path = path_below(folder, file)
    text = text_of(path, read_bounded(path, MAX_DEFINITION_BYTES))
    try:
        said = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as refused:
        raise FileError(path, f"expected TOML, got {refused}") from refused
    try:
        return _definition(path.parent, said)
    except ValueError as refused:
        raise FileError(path, str(refused)) from refused


def _definition(folder: Path, said: dict[str, Any]) -> AlgebraDefinition:
    unknown = [name for name in said if name not in _TABLES]
    if unknown:
        raise ValueError(f"expected the fields {', '.join(_TABLES)}, got also {unknown[0][:40]!a}")
    squares: Any = said.get("squares")
    named = said.get("named")
    names, pairs = said.get("names", []), said.get("null_pairs", [])
    macros = said.get("macros", "")
    _expect(isinstance(squares, dict), "squares", "1, -1 or 0 by basis vector", squares)
    _expect(isinstance(named, dict | None), "named", "a table by the new names", named)
    _expect(_texts(names), "names", "a list of names", names)
    _expect(isinstance(macros, str), "macros", "the name of a file", macros)
    _expect(isinstance(pairs, list), "null_pairs", "a list of pairs of names", pairs)
    for number, pair in enumerate(pairs):
        two = _texts(pair) and len(pair) == 2
        _expect(two, f"null_pairs[{number}]", "two names of basis vectors", pair)
    for name, parts in (named or {}).items():
        field = f"named.{name[:40]}"
        _expect(isinstance(parts, dict), field, "numbers by basis vectors", parts)
    for name in (*squares, *(named or {})):
        _expect(len(name) <= MAX_NAME, "squares and named", f"names of up to {MAX_NAME}", name)
    _expect(len(pairs) <= MAX_DIMENSION, "null_pairs", f"at most {MAX_DIMENSION}", len(pairs))
    if macros:
        path_below(folder, macros)
    algebra = Algebra.of(squares, [(o, i) for o, i in pairs], named)
    return AlgebraDefinition(tuple(names), _KNOWN.get(algebra, algebra), folder, macros)


def _expect(holds: bool, field: str, wanted: str, got: object) -> None:
    """Refuse a field that is not what it should be."""
    if not holds:
        shown = "nothing" if got is None else repr(got)
        shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
        raise ValueError(f"{field}: expected {wanted}, got {shown}")


def _texts(value: Any) -> bool:
    texts = isinstance(value, list) and all(isinstance(item, str) for item in value)
    return texts and all(len(item) <= MAX_NAME for item in value)


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

    def named(self, name: str) -> Macro | None:
        """The script's macro of a name whatever it takes, if there is one."""
        return next((macro for (known, _), macro in self.own.items() if known == name), None)

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
