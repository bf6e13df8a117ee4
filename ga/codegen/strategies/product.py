"""The strategy ``product``: one straight-line function a product and pair of operand types.

A type is a set of blades, as in libvsr, whose templates find the type and the terms of a product
from the types of its operands. Nothing is shared between the functions and no result is simplified
with what is known about another: that is left to the C compiler, as it is with templates.
"""

from __future__ import annotations

from typing import Any

from motorcade.ga.algebra.basis import grade_of
from motorcade.ga.algebra.products import PRODUCTS, Masks
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies.calls import SIGNS, CallWriter, files
from motorcade.ga.codegen.strategies.record import Step
from motorcade.ga.codegen.targets.shared.c_family import indented
from motorcade.ga.script import Script


def write(script: Script, program: Program, precision: Precision | None) -> dict[str, str]:
    """Names and texts of the source and the header of a script; `program` is what it compiles to.

    Raises ValueError: names that C or C++ keeps for itself, numbers too large for the precision.
    """
    return files(_ProductWriter, "product", script, program, precision)


class _ProductWriter(CallWriter):
    """Writes calls of functions made for the types of their operands, which go by value."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._types: dict[Masks, str] = {}
        self._functions: dict[str, str] = {}

    def type_of(self, masks: Masks) -> str:
        """The type of a set of blades, defined when first asked for; scalars are numbers."""
        if masks == (0,):
            return self.real
        if masks not in self._types:
            self._types[masks] = f"{self.name}_mv{len(self._types) + 1}"
        return self._types[masks]

    def coefficient(self, number: int, mask: int) -> str:
        """By its place among the blades of the type."""
        return f"v{number}.c[{self.record.steps[number].masks.index(mask)}]"

    def given(self, masks: Masks, values: list[str]) -> str:
        """The coefficients in their order."""
        return f"{{{{{', '.join(values)}}}}}"

    def call(self, step: Step) -> str:
        """A call of the function of these types, which is written when first called."""
        sides = [self.record.steps[number].masks for number in step.args]
        types = [
            self.type_of(masks).removeprefix(f"{self.name}_") for masks in (*sides, step.masks)
        ]
        function = f"{self.name}_{step.op}_{'_'.join(types[:-1])}_to_{types[-1]}"
        if function not in self._functions:
            self._functions[function] = self._function(function, step, sides)
        operands = (f"s{k}" if self.record.steps[k].is_scalar else f"v{k}" for k in step.args)
        return f"{function}({', '.join(operands)})"

    def definitions(self) -> list[str]:
        """All types and functions."""
        types = [
            f"typedef struct {{ {self.real} c[{len(masks)}]; }} {name};"
            f" /* {' '.join(map(self.algebra.blade_name, masks))} */"
            for masks, name in self._types.items()
        ]
        return ["\n".join(types), *self._functions.values()]

    def _function(self, name: str, step: Step, sides: list[Masks]) -> str:
        letters = "ab"[: len(sides)]
        arguments = (
            f"const {self.type_of(masks)} {letter}"
            for letter, masks in zip(letters, sides, strict=True)
        )
        values = [self._value(step, sides, mask) for mask in step.masks]
        kind = self.type_of(step.masks)
        lines = [f"static inline {kind} {name}({', '.join(arguments)})", "{"]
        if step.is_scalar:
            lines += indented([f"return {values[0]};"])
        else:
            lines += [f"    return ({kind}){{{{"]
            lines += indented([f"{value}," for value in values], 2)
            lines += ["    }};"]
        return "\n".join([*lines, "}"])

    def _value(self, step: Step, sides: list[Masks], mask: int) -> str:
        """One coefficient of the result, as an expression of those of the operands."""
        if step.op in PRODUCTS:
            plan = self.algebra.plan(step.op, sides[0], sides[1])
            return self._sum_of_terms(plan.terms[plan.masks.index(mask)], sides)
        if step.op in ("add", "sub"):
            left, right = (
                _place(letter, masks, masks.index(mask)) if mask in masks else ""
                for letter, masks in zip("ab", sides, strict=True)
            )
            sign = "+" if step.op == "add" else "-"
            if left and right:
                return f"{left} {sign} {right}"
            return left or right if step.op == "add" or left else f"-{right}"
        place = _place("a", sides[0], sides[0].index(mask))
        negative = step.op != "part" and SIGNS[step.op](grade_of(mask)) < 0
        return f"-{place}" if negative else place

    def _sum_of_terms(self, terms: tuple[tuple[float, int, int], ...], sides: list[Masks]) -> str:
        text = ""
        for factor, i, j in terms:
            size = "" if abs(factor) == 1.0 else f"{self.dialect.constant(abs(factor))} * "
            term = f"{size}{_place('a', sides[0], i)} * {_place('b', sides[1], j)}"
            joint = (" - " if factor < 0 else " + ") if text else ("-" if factor < 0 else "")
            text += joint + term
        return text


def _place(letter: str, masks: Masks, index: int) -> str:
    return letter if masks == (0,) else f"{letter}.c[{index}]"
