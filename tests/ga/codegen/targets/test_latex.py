"""LaTeX is read back: its formulas give what evaluation gives, to the last digits of numbers."""

import re
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.precision import SINGLE
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import latex
from motorcade.ga.notation import name_text
from motorcade.ga.script import parse

TOKEN = re.compile(
    r"\s*(\\mathit\{(?:[A-Za-z0-9]|\\_)+\}|\\mathbf\{e\}_\{[^}]*\}'?|\\operatorname\{\w+\}"
    r"|\\begin\{cases\}|\\end\{cases\}|\\text\{[^}]*\}|\\left\\[a-z]+|\\right\\[a-z]+"
    r"|\\left.|\\right.|\\\\|\\,|\\[A-Za-z]+|\d+\.?\d*|[A-Za-z](?:_\{\d+\})?|[-+=<>&^{},'])"
)
FUNCTIONS = {
    r"\exp": np.exp, r"\ln": np.log, r"\sin": np.sin, r"\cos": np.cos, r"\tan": np.tan,
    r"\arcsin": np.arcsin, r"\arccos": np.arccos, r"\arctan": np.arctan, r"\min": np.minimum,
    r"\max": np.maximum, r"\operatorname{atan2}": np.arctan2,
}  # fmt: skip
RELATIONS = {"<": np.less, r"\le": np.less_equal, "=": np.equal, r"\ne": np.not_equal}
LOGIC = {r"\land": np.logical_and, r"\lor": np.logical_or}
AROUND = {r"\left|": np.abs, r"\left\lfloor": np.floor, r"\left\lceil": np.ceil}


class Reader:
    """Evaluates one formula; a name is looked up by its text."""

    def __init__(self, text: str, names: dict[str, Any]) -> None:
        self.left = TOKEN.findall(text)
        assert "".join(self.left) == re.sub(r"\s", "", text).replace("\\text{if}", "\\text{if }")
        self.names = names

    def at(self, *tokens: str) -> bool:
        return bool(self.left) and self.left[0] in tokens

    def take(self, token: str = "") -> str:
        found = self.left.pop(0)
        assert found == token or not token, (found, token)
        return found

    def condition(self) -> Any:
        value = self.sum()
        while self.at(*RELATIONS, *LOGIC):
            value = (RELATIONS | LOGIC)[self.take()](value, self.sum())
        return value

    def sum(self) -> Any:
        value = self.product()
        while self.at("+", "-"):
            value = value + self.product() if self.take() == "+" else value - self.product()
        return value

    def product(self) -> Any:
        if self.at("-"):
            self.take()
            return -self.product()
        if self.at(r"\lnot"):
            self.take()
            return np.logical_not(self.product())
        value = self.power()
        while self.at(r"\,", r"\cdot"):
            if self.take() == r"\," and self.at("\\mathbf"):
                break
            value = value * self.power()
        return value

    def power(self) -> Any:
        value = self.atom()
        if self.at("^"):
            self.take()
            value = value ** self.braced()
        return value

    def braced(self) -> Any:
        self.take("{")
        value = self.condition()
        self.take("}")
        return value

    def atom(self) -> Any:
        token = self.take()
        if token == r"\frac":
            return self.braced() / self.braced()
        if token == r"\sqrt":
            return np.sqrt(self.braced())
        if token in FUNCTIONS:
            self.take(r"\left(")
            args = [self.condition()]
            while self.at(","):
                self.take()
                args.append(self.condition())
            self.take(r"\right)")
            return FUNCTIONS[token](*args)
        if token == r"\left(":
            value = self.condition()
            self.take(r"\right)")
            return value
        if token in AROUND:
            value = AROUND[token](self.condition())
            self.take()
            return value
        if token == r"\begin{cases}":
            return self.cases()
        return float(token) if token[0].isdigit() else self.names[token]

    def cases(self) -> Any:
        chosen = self.condition()
        self.take("&"), self.take(r"\text{if }")
        condition = self.condition()
        self.take("\\\\")
        otherwise = self.condition()
        self.take("&"), self.take(r"\text{otherwise}"), self.take(r"\end{cases}")
        return np.where(condition, chosen, otherwise)


def read(text: str, inputs: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """What each line defines: named values, and outputs by name and blade."""
    names = {name_text(name): value for name, value in inputs.items()}
    made: dict[str, dict[str, Any]] = {}
    body = re.search(r"\\begin\{align\*\}\n(.*)\n\\end\{align\*\}", text, re.S)
    assert body is not None
    current = ""
    for line in body[1].split(" \\\\\n"):
        name, formula = line.split(" &= ", 1) if " &= " in line else ("", line)
        current = name or current
        formula = formula.removeprefix(r"&\quad ")
        found = re.search(
            r"(?:\\,|^|[-+] ?)(\\mathbf\{e\}\S*(?: \\wedge \\mathbf\{e\}\S*)*)$", formula
        )
        blade = found[1] if found else "1"
        formula = formula[: found.start(1)].removesuffix(r"\,").strip() if found else formula
        formula = formula + "1" if formula in ("", "+", "-") else formula
        value = Reader(formula.removeprefix("+"), names).condition()
        if not made.get(current) and name:
            names.setdefault(name, value)
        made.setdefault(current, {})[blade] = value
    return made


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_formulas_agree_with_evaluation(script: str, cases: Any) -> None:
    case = cases(script, "float64")
    (text,) = latex.write(case.program, None).values()
    made = read(text, case.inputs)
    rows = []
    for operand in case.program.tape.outputs:
        lines = list(made[name_text(operand.name) + "'" * (operand.name in case.inputs)].values())
        assert len(lines) == max(operand.width, 1)
        rows += lines[: operand.width]
    count = len(next(iter(case.inputs.values())))
    case.checked(case.by_place(np.array([np.broadcast_to(row, count) for row in rows])), 1e-12)


def formulas(text: str) -> str:
    (made,) = latex.write(compile_script(parse(text), "one"), None).values()
    return made.split("\n", made.count("% ") + made.count("%\n"))[-1].strip()


def test_it_reads_as_one_would_write_it() -> None:
    made = formulas("?d = sqrt(x*x + y*y)/(2 + left_arm) - 1.5e-7*theta;")
    assert made == (
        "\\begin{align*}\nd &= \\frac{\\sqrt{x^{2} + y^{2}}}{\\mathit{left\\_arm} + 2} "
        "- 1.5 \\cdot 10^{-7}\\,\\theta\n\\end{align*}"
    )


def test_every_blade_has_a_line() -> None:
    made = formulas("?v = x*e1^einf + 2 - e2;")
    assert made.split("\n")[1:-1] == [
        "v &= 2 \\\\",
        "&\\quad -\\mathbf{e}_{2} \\\\",
        "&\\quad + x\\,\\mathbf{e}_{1} \\wedge \\mathbf{e}_{\\infty}",
    ]


def test_an_output_of_a_variables_name_is_primed() -> None:
    assert "x' &= x + 1" in formulas("x = x + 1;\n?x;")


def test_nothing_of_a_name_is_a_command() -> None:
    made = formulas("?out_ = __proto__ + input + def;")
    assert "\\mathit{\\_\\_proto\\_\\_}" in made
    assert "\\mathit{input}" in made


def test_it_is_written_to_double_precision() -> None:
    with pytest.raises(ValueError, match="target latex: expected precision float64, got float32"):
        latex.write(compile_script(parse("?a = x;"), "one"), SINGLE)
