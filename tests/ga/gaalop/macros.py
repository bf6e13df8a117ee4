"""Macros of our algebras against Gaalop's own definitions of them, which are read as a witness.

Both are evaluated on the same random arguments. Gaalop's text becomes the macros of an algebra file
with the same vectors, so that its macros call each other and never ours.
"""

from __future__ import annotations

import dataclasses
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.algebra import Multivector
from motorcade.ga.script import ScriptError, parse
from motorcade.ga.script.algebras import AlgebraDefinition, definitions
from motorcade.ga.script.run import Run
from motorcade.ga.script.syntax import Call, Macro
from tests.ga.gaalop.scripts import compared

ROUNDS = 3
# How often arguments are drawn until Gaalop's definition has a value for some.
TRIES = 5
Key = tuple[str, int]


def algebras(data: Path) -> list[str]:
    """Names of Gaalop's algebras."""
    text = (data / "gaalop" / "algebras" / "definedAlgebras.txt").read_text()
    return [line.partition(";")[0] for line in text.splitlines() if line]


@cache
def theirs(data: Path, name: str) -> dict[Key, Macro]:
    """Gaalop's macros of an algebra by name and number of arguments."""
    text = (data / "gaalop" / "algebras" / name / "macros.clu").read_text()
    statements = parse(text, name).statements
    macros = [_of_scalars(m) for m in statements if isinstance(m, Macro)]
    return {(macro.name, macro.arity): macro for macro in macros}


def _of_scalars(node: Any) -> Any:
    """A part of a script with ``sqrt(scalar(x))`` for ``sqrt(x)``, as Gaalop computes it."""
    if isinstance(node, tuple):
        return tuple(map(_of_scalars, node))
    if not dataclasses.is_dataclass(node) or isinstance(node, type):
        return node
    parts = {f.name: getattr(node, f.name) for f in dataclasses.fields(node)}
    place = parts.pop("place")
    made = dataclasses.replace(node, **{name: _of_scalars(part) for name, part in parts.items()})
    if isinstance(made, Call) and made.name == "sqrt":
        inner = Call(place, "scalar", made.arguments)
        return dataclasses.replace(made, arguments=(inner,))
    return made


def disagreements(data: Path, name: str, rounds: int = ROUNDS) -> tuple[int, dict[str, str]]:
    """How many macros an algebra of Gaalop's has, and how ours differ from them."""
    ours = definitions()[name]
    witness = dataclasses.replace(ours)
    # The macros of a definition are read when they are asked for: these are given instead.
    witness.__dict__["macros"] = theirs(data, name)
    rng = np.random.default_rng(11)
    wrong = {}
    for key in theirs(data, name):
        for _ in range(rounds):
            told = _difference(ours, witness, key, rng)
            if told:
                wrong["/".join(map(str, key))] = told
                break
    return len(theirs(data, name)), wrong


def _difference(
    ours: AlgebraDefinition, witness: AlgebraDefinition, key: Key, rng: np.random.Generator
) -> str:
    """What differs for the first arguments that Gaalop's definition has a value for."""
    told = "no arguments found for which Gaalop's definition has a value"
    for drawn in (drawn for _ in range(TRIES) for drawn in _arguments(ours, key, rng)):
        try:
            expected = _called(witness, key, drawn)
        except ScriptError as refused:
            told = f"Gaalop's definition: {refused.message}"
            continue
        try:
            made = _called(ours, key, drawn)
        except ScriptError as refused:
            if "expected products of at most" not in refused.message:
                return refused.message
            told = refused.message
            continue
        return compared(ours.algebra, dict(made.items()), dict(expected.items()), 1e-9)
    return told


def _called(definition: AlgebraDefinition, key: Key, drawn: list[Multivector]) -> Multivector:
    names = [f"argument_{k}" for k in range(len(drawn))]
    call = "*argument_0" if key == ("Dual", 1) else f"{key[0]}({', '.join(names)})"
    script = parse(f"?made = {call};")
    given = dict(zip(names, drawn, strict=True))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return Run(script, definition.algebra, definition, given).outputs()["made"]


def _arguments(
    definition: AlgebraDefinition, key: Key, rng: np.random.Generator
) -> list[list[Multivector]]:
    """Arguments that a macro may be for: multivectors of all grades, or of one, or scalars."""
    algebra, count = definition.algebra, key[1]
    vectors = len(algebra.names)

    def scalar() -> Multivector:
        return algebra.scalar(float(rng.uniform(0.5, 2.0)))

    def blades(grade: int, size: int) -> Multivector:
        masks = [sum(1 << int(k) for k in rng.permutation(vectors)[:grade]) for _ in range(size)]
        names = {algebra.blade_name(mask): float(rng.normal()) for mask in masks}
        return algebra.multivector(names)

    def mixed() -> Multivector:
        made = algebra.scalar(float(rng.normal()))
        for grade in range(1, min(vectors, 5) + 1):
            made = made + blades(grade, 2)
        return made

    def point() -> Multivector:
        made = [(*key, k) for *key, k in definition.macros if key == ["createPoint"]]
        arity = made[0][1] if made else 0
        return _called(definition, ("createPoint", arity), [scalar() for _ in range(arity)])

    kinds = [mixed, lambda: blades(1, vectors), lambda: blades(2, 6), lambda: blades(3, 6)]
    if ("createPoint", 3) in definition.macros or ("createPoint", 2) in definition.macros:
        kinds.append(point)
    drawn = [[kind() for _ in range(count)] for kind in kinds]
    drawn.append([point() if k == 0 and len(kinds) > 4 else scalar() for k in range(count)])
    scalars = [scalar() for _ in range(count)]
    return [drawn[0], scalars, *drawn[1:]] if count < 3 else [scalars, *drawn]
