"""The strategy ``table-code``: the tables of `table` written out as code, as Gaigen 2 does it.

A multivector is the same array with a bit for each grade in use, and a call takes operands by
address. But a product holds the terms of each pair of grades as statements, behind a test of the
bits, instead of running over a table.
"""

from __future__ import annotations

from motorcade.ga.algebra.basis import grade_of
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies.calls import files
from motorcade.ga.codegen.strategies.table import TableWriter
from motorcade.ga.codegen.targets.shared.c_family import indented
from motorcade.ga.script import Script


def write(script: Script, program: Program, precision: Precision | None) -> dict[str, str]:
    """Names and texts of the source and the header of a script; `program` is what it compiles to.

    Raises ValueError: names that C or C++ keeps for itself, numbers too large for the precision.
    """
    return files(_CodeWriter, "table-code", script, program, precision)


class _CodeWriter(TableWriter):
    """Writes one function a kind of product, with the code of all pairs of grades that meet."""

    def product(self, kind: str, operands: list[str]) -> str:
        """A call of the function of this kind."""
        return f"{self.name}_{kind}({', '.join(operands)})"

    def products(self) -> list[str]:
        """The functions, one a kind of product."""
        return [self._product(kind) for kind in sorted(self.tables)]

    def _product(self, kind: str) -> str:
        name = f"{self.name}_mv"
        lines = [
            f"static {name} {self.name}_{kind}(const {name} *a, const {name} *b)",
            "{",
            f"    {name} made = {{0, {{0}}}};",
        ]
        for left, right in sorted(self.tables[kind]):
            terms = self.terms_of(kind, left, right)
            if terms:
                bits = sum(1 << grade for grade in {grade_of(term[2]) for term in terms})
                lines.append(f"    if ((a->grades >> {left} & 1) && (b->grades >> {right} & 1)) {{")
                lines += indented(self._statements(terms), 2)
                lines += [f"        made.grades |= {bits}u;", "    }"]
        return "\n".join([*lines, "    return made;", "}"])

    def _statements(self, terms: list[tuple[int, int, int, float]]) -> list[str]:
        """One statement a coefficient of the result."""
        sums: dict[int, str] = {}
        for left, right, result, factor in terms:
            size = "" if abs(factor) == 1.0 else f"{self.dialect.constant(abs(factor))} * "
            term = f"{size}a->c[{self.place[left]}] * b->c[{self.place[right]}]"
            before = sums.get(result, "")
            sign = (" - " if factor < 0 else " + ") if before else "-" if factor < 0 else ""
            sums[result] = f"{before}{sign}{term}"
        return [f"made.c[{self.place[result]}] += {text};" for result, text in sums.items()]
