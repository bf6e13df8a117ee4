"""Gaalop's scripts with the results that Gaalop computes, and how they are run directly."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.algebra import Algebra
from motorcade.ga.script import Script, evaluate, parse
from motorcade.ga.script.errors import ScriptWarning
from motorcade.ga.script.meaning import algebra_named, free_variables

# Coefficients by blade, of each output.
Values = dict[str, dict[str, float]]
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Case:
    """A script; `expected` is None where Gaalop refuses it, and `refusal` says why."""

    name: str
    algebra: Algebra
    text: str
    inputs: Mapping[str, float]
    expected: Values | None
    refusal: str

    @property
    def script(self) -> Script:
        """The script, read."""
        return parsed(self.text)

    @property
    def given(self) -> dict[str, float]:
        """Values of the variables that the script reads."""
        free = free_variables(self.script, self.algebra)
        return {name: float(self.inputs[name]) for name in free}


@cache
def parsed(text: str) -> Script:
    """Read once."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ScriptWarning)
        return parse(text)


def read_cases(folder: Path) -> list[Case]:
    """The scripts of ``gaalop/oracle.json`` below a folder."""
    said: list[dict[str, Any]] = json.loads((folder / "gaalop" / "oracle.json").read_text())
    return [
        Case(
            case["name"],
            algebra_named(case["algebra"]),
            case["script"],
            case["inputs"],
            case.get("expected"),
            case.get("gaalop_error", ""),
        )
        for case in said
    ]


def directly(case: Case) -> Values | str:
    """The outputs of a script, evaluated on numbers, or why there are none."""
    try:
        made = evaluate(case.script, case.algebra, **case.given)
    except ValueError as refused:
        return f"{type(refused).__name__}: {str(refused).splitlines()[0]}"
    return {name: {blade: float(v) for blade, v in x.items()} for name, x in made.items()}


def undefined(case: Case) -> bool:
    """Whether Gaalop gives NaN, which is no number: a refusal agrees with it."""
    rows = (case.expected or {}).values()
    return any(np.isnan(v) for row in rows for v in row.values())


def difference(case: Case, made: Values | str, tolerance: float = TOLERANCE) -> str:
    """How outputs differ from Gaalop's; empty where they agree. A text says why there are none.

    Blades that neither side has are zero; so is an output that Gaalop leaves out.
    """
    assert case.expected is not None
    if isinstance(made, str):
        return "" if undefined(case) else made
    for name in case.expected:
        if name not in made:
            return f"no output {name}"
    for name, found in made.items():
        told = compared(case.algebra, found, case.expected.get(name, {}), tolerance)
        if told:
            return f"{name}: {told}"
    return ""


def compared(
    algebra: Algebra, found: Mapping[str, float], expected: Mapping[str, float], tolerance: float
) -> str:
    """The first blade whose coefficients differ by more than rounding; empty where none does."""
    ours, theirs = _by_mask(algebra, found), _by_mask(algebra, expected)
    size = max([1.0, *(abs(v) for v in theirs.values() if np.isfinite(v))])
    for mask in {**ours, **theirs}:
        one, two = ours.get(mask, 0.0), theirs.get(mask, 0.0)
        if not (abs(one - two) <= tolerance * size or (np.isnan(one) and np.isnan(two))):
            return f"{algebra.blade_name(mask)} is {one!r}, expected {two!r}"
    return ""


def _by_mask(algebra: Algebra, values: Mapping[str, float]) -> dict[int, float]:
    """Coefficients by basis blade, whatever order its vectors are named in."""
    total: dict[int, float] = {}
    for blade, value in values.items():
        for mask, sign in algebra.masks_of("1" if blade == "1.0" else blade):
            total[mask] = total.get(mask, 0.0) + sign * value
    return total
