"""Mutants of a Python source: one small change each, as a fault would be.

Operators and their order, comparisons at their bounds, numbers and booleans, conditions, signs,
returned values, and statements left out. Texts, annotations, `assert`, what a `raise` says, and
``strict=`` of `zip`, which guards against our own faults, stay as they are.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["Mutant", "mutants", "sample"]

_OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
_COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_OPPOSITES = (ast.Eq, ast.NotEq, ast.Is, ast.IsNot, ast.In, ast.NotIn)
_LEFT_ALONE = (ast.Import, ast.ImportFrom, ast.Assert, ast.JoinedStr)
_Node = ast.expr | ast.stmt


@dataclass(frozen=True)
class Mutant:
    """One change: the bytes from `start` to `end` of the source become `after`.

    Attributes:
        lines: first and last line of the statement, or of the head of a block, that it is in.
        at_import: whether the statement runs once, when the module is imported.
    """

    line: int
    lines: tuple[int, int]
    start: int
    end: int
    before: str
    after: str
    at_import: bool

    def applied(self, source: str) -> str:
        """The whole source with the change."""
        data = source.encode()
        return (data[: self.start] + self.after.encode() + data[self.end :]).decode()


def sample(found: list[Mutant], count: int, seed: str) -> list[Mutant]:
    """So many of the mutants, the same for the same seed, in the order of the source."""
    chosen = random.Random(seed).sample(range(len(found)), min(count, len(found)))
    return [found[k] for k in sorted(chosen)]


def mutants(source: str) -> list[Mutant]:
    """All mutants of a source that compile, in the order of its syntax tree."""
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    made = []
    for statement, at_import, node, after in _changes(ast.parse(source)):
        start = starts[node.lineno - 1] + node.col_offset
        end = starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
        before = source.encode()[start:end].decode()
        lines = (statement.lineno, _last_line(statement))
        made.append(Mutant(node.lineno, lines, start, end, before, after, at_import))
    return [mutant for mutant in made if _compiles(mutant.applied(source))]


def _compiles(source: str) -> bool:
    try:
        compile(source, "<mutant>", "exec", dont_inherit=True)
    except SyntaxError:
        return False
    return True


def _last_line(statement: ast.stmt) -> int:
    body = getattr(statement, "body", None)
    last = statement.end_lineno or statement.lineno
    return max(statement.lineno, body[0].lineno - 1) if body else last


def _changes(tree: ast.Module) -> Iterator[tuple[ast.stmt, bool, _Node, str]]:
    """Statement, whether it runs at import, the node in it to replace, and the text instead."""
    waiting: list[tuple[ast.AST, ast.stmt | None, bool]] = [(tree, None, True)]
    while waiting:
        node, statement, at_import = waiting.pop()
        if isinstance(node, _LEFT_ALONE) or _is_left_alone(node):
            continue
        statement = node if isinstance(node, ast.stmt) else statement
        if statement is not None:
            for replaced, after in (*_instead(node, at_import), *_negated(node)):
                yield statement, at_import, replaced, after
        if isinstance(node, ast.Raise):
            continue
        for field, value in reversed(list(ast.iter_fields(node))):
            later = isinstance(node, ast.FunctionDef | ast.Lambda) and field == "body"
            for child in reversed(value if isinstance(value, list) else [value]):
                if isinstance(child, ast.AST) and field not in ("annotation", "returns"):
                    waiting.append((child, statement, at_import and not later))


def _is_left_alone(node: ast.AST) -> bool:
    """Names for other modules, what only type checkers read, and `strict=`."""
    if isinstance(node, ast.Assign):
        return any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets)
    if isinstance(node, ast.If):
        return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    return isinstance(node, ast.keyword) and node.arg == "strict"


def _instead(node: ast.AST, at_import: bool) -> Iterator[tuple[_Node, str]]:
    match node:
        case ast.BinOp(left, ast.MatMult(), right):
            if ast.dump(left) != ast.dump(right):
                yield node, _text(ast.BinOp(right, ast.MatMult(), left))
        case ast.BinOp(left, operator, right):
            # At import a union of types is what `|` makes.
            if not (at_import and isinstance(operator, ast.BitOr)):
                yield node, _text(ast.BinOp(left, _OPERATORS[type(operator)](), right))
        case ast.Compare(left, operators, others):
            for k, operator in enumerate(operators):
                swapped = [*operators[:k], _COMPARISONS[type(operator)](), *operators[k + 1 :]]
                yield node, _text(ast.Compare(left, swapped, others))
        case ast.BoolOp(operator, values):
            other = ast.Or() if isinstance(operator, ast.And) else ast.And()
            yield node, _text(ast.BoolOp(other, values))
        case ast.UnaryOp(ast.Not() | ast.USub() | ast.Invert(), operand):
            yield node, _text(operand)
        case ast.Constant(bool() as value):
            yield node, str(not value)
        case ast.Constant(int() | float() as value):
            yield node, repr(value + 1)
        case ast.Return(ast.expr() as value) if not _is_none(value):
            yield node, "return None"
        case ast.Expr(ast.Call()) | ast.AugAssign() | ast.Raise():
            yield node, "pass"
        case ast.Break():
            yield node, "continue"
        case ast.Continue():
            yield node, "break"


def _negated(node: ast.AST) -> Iterator[tuple[_Node, str]]:
    """Conditions that no other mutant negates."""
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        tests = [node.test]
    else:
        tests = node.ifs if isinstance(node, ast.comprehension) else []
    for test in tests:
        compared = isinstance(test, ast.Compare) and isinstance(test.ops[0], _OPPOSITES)
        if not compared and not (isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not)):
            yield test, _text(ast.UnaryOp(ast.Not(), test))


def _is_none(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and value.value is None


def _text(node: ast.expr) -> str:
    return f"({ast.unparse(node)})"
