"""Runs a script: statement by statement, each expression on a stack of its own."""

from __future__ import annotations

import difflib
from functools import cache

import numpy as np

from motorcade.ga.algebra import CGA3, Algebra, Multivector
from motorcade.ga.algebra.functions.commuting import square_of, without_scalar
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.script.errors import Place, ScriptError
from motorcade.ga.script.functions import COMMON_MACROS, CONFORMAL_MACROS, FUNCTIONS, is_finite
from motorcade.ga.script.reading.parser import parse
from motorcade.ga.script.reading.syntax import (
    Argument,
    Assignment,
    Binary,
    Call,
    Expression,
    Macro,
    Name,
    Number,
    OutputPragma,
    RangePragma,
    Script,
    Unary,
    postorder,
)

MAX_STEPS = 100_000
MAX_TERMS = 200_000
_PRODUCTS = frozenset("*^.")
# How many products the closed forms of functions take at most, and the series of `exp`.
_CLOSED = 12
_SERIES = 40
MAX_MACRO_DEPTH = 32


class Budget:
    """How much an evaluation has cost so far."""

    def __init__(self) -> None:
        self._steps = 0
        self._terms = 0

    def spend(self, node: Expression, operands: list[Multivector]) -> str:
        """Count a step that is about to be done: what is wrong if it is one too many, or ""."""
        self._steps += 1
        if self._steps > MAX_STEPS:
            return f"expected at most {MAX_STEPS} steps"
        self._terms += _terms(node, operands)
        if self._terms > MAX_TERMS:
            return f"expected products of at most {MAX_TERMS} terms in all"
        return ""


def _terms(node: Expression, operands: list[Multivector]) -> int:
    sizes = [len(x.masks) for x in operands]
    if isinstance(node, Binary) and node.operator in _PRODUCTS:
        return sizes[0] * sizes[1]
    if isinstance(node, Binary) and node.operator == "/":
        right = operands[1]
        whole = len(right.masks) if _has_scalar_size(right) else 1 << right.algebra.dimension
        return _of_inverse(right) + sizes[0] * whole
    if isinstance(node, Call) and len(operands) == 1:
        return _of_function(node.name, operands[0])
    return sum(sizes) if isinstance(node, Binary | Unary) else 0


def _of_inverse(x: Multivector) -> int:
    size, dimension = len(x.masks), x.algebra.dimension
    if _has_scalar_size(x):
        return size * size
    return size * size + (size << dimension + (dimension + 1) // 2)


def _has_scalar_size(x: Multivector) -> bool:
    """Whether ``x ~x`` is a scalar by structure; looked at only where that is cheap."""
    return len(x.masks) ** 2 <= MAX_TERMS and not any(x._reverse_plan().masks)


def _of_function(name: str, x: Multivector) -> int:
    size, whole = len(x.masks), 1 << x.algebra.dimension
    if size * size > MAX_TERMS or name == "invert":
        return _of_inverse(x)
    if name not in ("exp", "log", "sqrt", "versor"):
        return size * size
    if name != "exp" or square_of(without_scalar(x)) is not None:
        return _CLOSED * size * size
    return _SERIES * size * whole


def constants_of(algebra: Algebra) -> frozenset[str]:
    """The names of the basis vectors, ep and em beside a null pair included."""
    return frozenset((*algebra.names, *algebra.named))


@cache
def _built_in(algebra: Algebra) -> dict[tuple[str, int], tuple[Script, Macro]]:
    text = COMMON_MACROS + (CONFORMAL_MACROS if algebra == CGA3 else "")
    script = parse(text, "<macros>")
    found = [statement for statement in script.statements if isinstance(statement, Macro)]
    return {(macro.name, macro.arity): (script, macro) for macro in found}


class _Scope:
    """What one body sees: its own names, its arguments, and the macros above itself."""

    def __init__(
        self,
        script: Script,
        names: dict[str, Multivector],
        arguments: tuple[Multivector, ...] = (),
        macro: Macro | None = None,
    ) -> None:
        self.script = script
        self.names = names
        self.macro = macro
        self.arguments = arguments

    def error(self, place: Place, message: str, hint: str = "") -> ScriptError:
        return self.script.source.error(place, message, hint)


class Run:
    """One evaluation of a script over the values that are given for its free variables."""

    def __init__(self, script: Script, algebra: Algebra, given: dict[str, Multivector]) -> None:
        self._script = script
        self._algebra = algebra
        self._constants = {name: algebra.blade(name) for name in constants_of(algebra)}
        self._values = dict(given)
        self._scope = _Scope(script, self._values)
        self._macros = dict(_built_in(algebra))
        self._own: set[tuple[str, int]] = set()
        self._budget = Budget()
        self._depth = 0

    def outputs(self) -> dict[str, Multivector]:
        """The outputs by name.

        Raises:
            ScriptError: see `meaning.evaluate`.
        """
        self._check_ranges()
        made: dict[str, Multivector] = {}
        for statement in self._script.statements:
            if isinstance(statement, Macro):
                self._define(statement)
                continue
            if isinstance(statement, Assignment):
                self._assign(statement, self._scope)
            if statement.mark == "?":
                made[statement.name] = self._lookup(Name(statement.place, statement.name))
        return self._selected(made)

    def _selected(self, made: dict[str, Multivector]) -> dict[str, Multivector]:
        """Add the outputs of pragmas, and keep the blades they name."""
        blades: dict[str, dict[str, Place]] = {}
        for pragma in self._script.pragmas:
            if isinstance(pragma, OutputPragma):
                made.setdefault(pragma.name, self._lookup(Name(pragma.place, pragma.name)))
                wanted = blades.setdefault(pragma.name, {})
                wanted.update(dict.fromkeys(pragma.blades, pragma.place))
        return {name: self._kept(x, blades.get(name, {})) for name, x in made.items()}

    def _kept(self, x: Multivector, blades: dict[str, Place]) -> Multivector:
        if not blades:
            return x
        kept: set[int] = set()
        for blade, place in blades.items():
            try:
                kept.update(mask for mask, _ in self._algebra.masks_of(blade))
            except ValueError as refused:
                raise self._scope.error(place, str(refused)) from refused
        return x._selected(kept.__contains__)

    def _lookup(self, name: Name) -> Multivector:
        return self._read_name(name, self._scope)

    def _check_ranges(self) -> None:
        for pragma in self._script.pragmas:
            if isinstance(pragma, RangePragma) and pragma.name in self._values:
                value = self._values[pragma.name].scalar_part()
                if is_numeric(value) and not np.all((value >= pragma.low) & (value <= pragma.high)):
                    raise self._scope.error(
                        pragma.place,
                        f"expected {pragma.name} from {pragma.low:g} to {pragma.high:g}, "
                        f"got values from {np.min(value):g} to {np.max(value):g}",
                    )

    def _define(self, macro: Macro) -> None:
        key = (macro.name, macro.arity)
        if key in self._own or macro.name in FUNCTIONS:
            raise self._scope.error(
                macro.place, f"{macro.name} is already defined", "choose another name"
            )
        self._own.add(key)
        self._macros[key] = (self._script, macro)

    def _assign(self, statement: Assignment, scope: _Scope) -> None:
        if statement.name in self._constants:
            raise scope.error(
                statement.place,
                f"{statement.name} is a basis vector of {self._algebra}",
                "assign to another name",
            )
        scope.names[statement.name] = self._value(statement.value, scope)

    def _value(self, root: Expression, scope: _Scope) -> Multivector:
        stack: list[Multivector] = []
        for node in postorder(root):
            taken = _operand_count(node)
            operands = stack[len(stack) - taken :]
            del stack[len(stack) - taken :]
            over = self._budget.spend(node, operands)
            if over:
                raise scope.error(node.place, over, "split the script, or let macros do less")
            made = self._applied(node, operands, scope)
            if not all(map(is_finite, made.values)):
                raise scope.error(node.place, "expected finite numbers, got an overflow")
            stack.append(made)
        return stack.pop()

    def _applied(self, node: Expression, operands: list[Multivector], scope: _Scope) -> Multivector:
        if isinstance(node, Number):
            return self._algebra.scalar(node.value)
        if isinstance(node, Name):
            return self._read_name(node, scope)
        if isinstance(node, Argument):
            return scope.arguments[node.index - 1]
        if isinstance(node, Call) and node.name not in FUNCTIONS:
            return self._called(node, tuple(operands), scope)
        try:
            return _operated(node, operands)
        except (ValueError, ArithmeticError) as refused:
            shown = str(refused)
            if isinstance(node, Call) and not shown.startswith(f"{node.name}: "):
                shown = f"{node.name}: {shown}"
            raise scope.error(node.place, shown) from refused

    def _read_name(self, node: Name, scope: _Scope) -> Multivector:
        for names in (self._constants, scope.names, self._values):
            if node.name in names:
                return names[node.name]
        raise scope.error(node.place, f"{node.name} has no value here")

    def _called(self, node: Call, arguments: tuple[Multivector, ...], scope: _Scope) -> Multivector:
        found = self._visible(node, scope)
        if found is None:
            raise self._unknown(node, scope)
        if self._depth >= MAX_MACRO_DEPTH:
            raise scope.error(
                node.place, f"expected at most {MAX_MACRO_DEPTH} macros that call each other"
            )
        script, macro = found
        inner = _Scope(script, {}, arguments, macro)
        self._depth += 1
        try:
            for statement in macro.body:
                self._assign(statement, inner)
            return self._value(macro.value, inner)
        except ScriptError as refused:
            if script is self._script:
                raise
            # A macro of ours has no place in the user's file: the call has.
            raise scope.error(node.place, f"{node.name}: {refused.message}", refused.hint) from None
        finally:
            self._depth -= 1

    def _visible(self, node: Call, scope: _Scope) -> tuple[Script, Macro] | None:
        """The macro of a call; those of ours call each other, whatever the script defines."""
        key = (node.name, len(node.arguments))
        macros = self._macros if scope.script is self._script else _built_in(self._algebra)
        found = macros.get(key)
        own = found is not None and found[0] is self._script
        if own and found and scope.macro is not None and found[1].place >= scope.macro.place:
            return _built_in(self._algebra).get(key)
        return found

    def _unknown(self, node: Call, scope: _Scope) -> ScriptError:
        counts = sorted(arity for name, arity in self._macros if name == node.name)
        if any(count != len(node.arguments) for count in counts):
            wanted = " or ".join(map(str, counts))
            return scope.error(
                node.place, f"{node.name}: expected {wanted} arguments, got {len(node.arguments)}"
            )
        known = [*FUNCTIONS, *dict.fromkeys(name for name, _ in self._macros)]
        known = [name for name in known if name != node.name]
        near = difflib.get_close_matches(node.name[:40], known, n=1, cutoff=0.75)
        hint = f"did you mean {near[0]}?" if near else "a macro is defined above its first use"
        if any(name == node.name for name, _ in _built_in(CGA3)):
            hint = f"{node.name} is a macro of cga3, and this is {self._algebra}"
        return scope.error(node.place, f"there is no function or macro {node.name[:40]}", hint)


def _operand_count(node: Expression) -> int:
    if isinstance(node, Call):
        return len(node.arguments)
    return 2 if isinstance(node, Binary) else int(isinstance(node, Unary))


def _operated(node: Expression, operands: list[Multivector]) -> Multivector:
    if isinstance(node, Call):
        function = FUNCTIONS[node.name]
        if len(operands) != function.arity:
            wanted = "one argument" if function.arity == 1 else f"{function.arity} arguments"
            raise ValueError(f"expected {wanted}, got {len(operands)}")
        return function.apply(*operands)
    if isinstance(node, Unary):
        return _prefixed(node.operator, operands[0])
    left, right = operands
    operator = node.operator if isinstance(node, Binary) else ""
    if operator == "^":
        return left ^ right
    if operator == ".":
        return left | right
    if operator == "/":
        return left / right
    if operator == "*":
        return left * right
    return left + right if operator == "+" else left - right


def _prefixed(operator: str, x: Multivector) -> Multivector:
    if operator == "*":
        return x.dual()
    return ~x if operator == "~" else -x
