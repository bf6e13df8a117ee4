"""The strategy ``table``: multiplication tables interpreted at run time, one call a product.

A multivector is an array of all coefficients of the algebra and a bit for each grade in use, as in
Gaigen. A product runs over the grades that both sides use and over the table's terms of each such
pair of grades; nothing is known in advance about which coefficients are zero.

The strategy ``table-code``: these tables written out as code, as Gaigen 2 does it. A multivector is
the same array with a bit for each grade in use, and a call takes operands by address. But a product
holds the terms of each pair of grades as statements, behind a test of the bits, instead of running
over a table.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from motorcade.ga.algebra.basis import grade_of
from motorcade.ga.algebra.products import PRODUCTS, Masks
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies.product import SIGNS, CallWriter, files
from motorcade.ga.codegen.strategies.record import Step
from motorcade.ga.codegen.targets.shared.c_family import indented
from motorcade.ga.script import Script

MAX_DIMENSION = 10


def write(script: Script, program: Program, precision: Precision | None) -> dict[str, str]:
    """Names and texts of the source and the header of a script; `program` is what it compiles to.

    Raises ValueError: names that C or C++ keeps for itself, numbers too large for the precision, an
    algebra of more than ten dimensions, whose multivectors are too large for a stack.
    """
    if program.algebra.dimension > MAX_DIMENSION:
        raise ValueError(
            f"strategy table: expected at most {MAX_DIMENSION} dimensions, "
            f"got {program.algebra.dimension}"
        )
    return files(TableWriter, "table", script, program, precision)


_STRUCTS = """\
/* All coefficients, by grade and then in the order of the basis; bit g: grade g is in use. */
typedef struct {{ unsigned grades; {real} c[{size}]; }} {name}_mv;"""

_TABLE = """\
/* A term of a product: c[result] gains factor * a.c[left] * b.c[right]. */
struct {name}_term {{ unsigned short left, right, result; {real} factor; }};

/* Grades r and s have the terms from first[{grades} r + s] on; into has a bit for each grade they
 * lead to. */
struct {name}_table {{
    const struct {name}_term *terms;
    const unsigned *first, *into;
}};"""

_PRODUCT = """\
static {name}_mv {name}_product(const struct {name}_table *table, const {name}_mv *a,
                                const {name}_mv *b)
{{
    {name}_mv made = {{0, {{0}}}};
    for (unsigned r = 0; r < {grades}; ++r) {{
        if (!(a->grades >> r & 1)) continue;
        for (unsigned s = 0; s < {grades}; ++s) {{
            const unsigned pair = {grades} * r + s;
            if (!(b->grades >> s & 1)) continue;
            for (unsigned k = table->first[pair]; k < table->first[pair + 1]; ++k) {{
                const struct {name}_term *t = &table->terms[k];
                made.c[t->result] += t->factor * a->c[t->left] * b->c[t->right];
            }}
            made.grades |= table->into[pair];
        }}
    }}
    return made;
}}"""

_SUM = """\
static {name}_mv {name}_sum(const {name}_mv *a, {real} factor, const {name}_mv *b)
{{
    {name}_mv made = {{a->grades | b->grades, {{0}}}};
    for (unsigned k = 0; k < {size}; ++k) made.c[k] = a->c[k] + factor * b->c[k];
    return made;
}}"""

_SIGNED = """\
static {name}_mv {name}_signed(const signed char *signs, const {name}_mv *a)
{{
    {name}_mv made = {{a->grades, {{0}}}};
    for (unsigned k = 0; k < {size}; ++k) made.c[k] = signs[k] * a->c[k];
    return made;
}}"""

_PART = """\
static {name}_mv {name}_part(unsigned grades, unsigned count, const unsigned short *kept,
                             {name}_mv a)
{{
    {name}_mv made = {{grades, {{0}}}};
    for (unsigned k = 0; k < count; ++k) made.c[kept[k]] = a.c[kept[k]];
    return made;
}}"""


class TableWriter(CallWriter):
    """Writes calls that take their operands by address and interpret a table."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        masks = (self.algebra.masks_of(blade)[0][0] for blade in self.algebra.blades)
        self.place = {mask: k for k, mask in enumerate(masks)}
        # Pairs of grades that a product meets, by its kind; kinds of sign; functions beside them.
        self.tables: dict[str, set[tuple[int, int]]] = {}
        self._signs: set[str] = set()
        self._functions: set[str] = set()

    def type_of(self, masks: Masks) -> str:
        """One type for all."""
        return f"{self.name}_mv"

    def coefficient(self, number: int, mask: int) -> str:
        """By its place among all coefficients."""
        return f"v{number}.c[{self.place[mask]}]"

    def given(self, masks: Masks, values: list[str]) -> str:
        """All coefficients, those not given being zero."""
        at = ", ".join(
            f"[{self.place[mask]}] = {value}" for mask, value in zip(masks, values, strict=True)
        )
        return f"{{{_bits(masks)}, {{{at}}}}}"

    def call(self, step: Step) -> str:
        """A call; grades that are known to vanish are cut off its result."""
        operands = [self._operand(number) for number in step.args]
        if step.op in SIGNS:
            self._signs.add(step.op)
            text = f"{self.name}_signed({self.name}_{step.op}, {operands[0]})"
        elif step.op == "part":
            return self._part(step, f"v{step.args[0]}")
        elif step.op in PRODUCTS:
            self._meet(step)
            text = self.product(step.op, operands)
        else:
            self._functions.add("sum")
            factor = self.dialect.constant(1.0 if step.op == "add" else -1.0)
            text = f"{self.name}_sum({operands[0]}, {factor}, {operands[1]})"
        if step.is_scalar:
            return f"{text}.c[0]"
        return (
            text if self._grades(step) <= {*map(grade_of, step.masks)} else self._part(step, text)
        )

    def definitions(self) -> list[str]:
        """The type, the tables of the grades that meet, and the functions."""
        named = {"name": self.name, "real": self.real, "size": len(self.place)}
        parts = [_STRUCTS.format(**named), *self.products()]
        if "sum" in self._functions:
            parts.append(_SUM.format(**named))
        if self._signs:
            parts += [*map(self._sign_list, sorted(self._signs)), _SIGNED.format(**named)]
        if "part" in self._functions:
            parts.append(_PART.format(**named))
        return parts

    def product(self, kind: str, operands: list[str]) -> str:
        """A call of the product, with the table of its kind."""
        return f"{self.name}_product(&{self.name}_{kind}, {', '.join(operands)})"

    def products(self) -> list[str]:
        """The tables of all kinds, and the function that interprets them."""
        if not self.tables:
            return []
        named = {"name": self.name, "real": self.real, "grades": self.algebra.dimension + 1}
        tables = [self._table(kind) for kind in sorted(self.tables)]
        return [_TABLE.format(**named), *tables, _PRODUCT.format(**named)]

    def terms_of(self, kind: str, left: int, right: int) -> list[tuple[int, int, int, float]]:
        """Left, right, result and factor of each term of a product of two grades."""
        multiply = PRODUCTS[kind]
        of_grade = [[m for m in self.place if grade_of(m) == grade] for grade in (left, right)]
        return [
            (a, b, mask, factor)
            for a in of_grade[0] for b in of_grade[1]
            for mask, factor in multiply(self.algebra.basis, a, b)
        ]  # fmt: skip

    def _operand(self, number: int) -> str:
        if self.record.steps[number].is_scalar:
            return f"&(const {self.name}_mv){{1u, {{s{number}}}}}"
        return f"&v{number}"

    def _part(self, step: Step, operand: str) -> str:
        self._functions.add("part")
        places = ", ".join(str(self.place[mask]) for mask in step.masks)
        kept = f"(const unsigned short[]){{{places}}}"
        text = f"{self.name}_part({_bits(step.masks)}, {len(step.masks)}, {kept}, {operand})"
        return f"{text}.c[0]" if step.is_scalar else text

    def _grades(self, step: Step) -> set[int]:
        """The grades that the operation leaves in use."""
        sides = [self.record.steps[number].masks for number in step.args]
        if step.op in PRODUCTS:
            return {*map(grade_of, self.algebra.plan(step.op, sides[0], sides[1]).masks)}
        return {grade_of(mask) for side in sides for mask in side}

    def _meet(self, step: Step) -> None:
        left, right = ({*map(grade_of, self.record.steps[k].masks)} for k in step.args)
        self.tables.setdefault(step.op, set()).update((r, s) for r in left for s in right)

    def _table(self, kind: str) -> str:
        """The terms of a product, the first one of each pair of grades, and where they lead."""
        count = self.algebra.dimension + 1
        rows, first, into = [], [0], []
        for pair in range(count * count):
            grades = divmod(pair, count)
            met = grades in self.tables[kind]
            terms = self.terms_of(kind, *grades) if met else []
            rows += [self._row(*term) for term in terms]
            into.append(sum(1 << g for g in {grade_of(term[2]) for term in terms}))
            first.append(len(rows))
        name = f"{self.name}_{kind}"
        return "\n".join([
            f"static const struct {self.name}_term {name}_terms[] = {{", *_lines(rows), "};",
            f"static const unsigned {name}_first[] = {{", *_lines(map(str, first)), "};",
            f"static const unsigned {name}_into[] = {{", *_lines(map(str, into)), "};",
            f"static const struct {self.name}_table {name} = {{",
            f"    {name}_terms, {name}_first, {name}_into", "};",
        ])  # fmt: skip

    def _row(self, left: int, right: int, result: int, factor: float) -> str:
        places = ", ".join(str(self.place[mask]) for mask in (left, right, result))
        return f"{{{places}, {self.dialect.constant(factor)}}}"

    def _sign_list(self, kind: str) -> str:
        signs = [str(SIGNS[kind](grade_of(mask))) for mask in self.place]
        return "\n".join(
            [f"static const signed char {self.name}_{kind}[] = {{", *_lines(signs), "};"]
        )


def _bits(masks: Masks) -> str:
    return f"{sum(1 << grade for grade in {*map(grade_of, masks)})}u"


def _lines(items: Iterable[str]) -> list[str]:
    return indented([", ".join(items)])


def write_code(script: Script, program: Program, precision: Precision | None) -> dict[str, str]:
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
