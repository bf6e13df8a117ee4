"""Runs a script: statement by statement, each expression on a stack of its own, within a budget.

What a step costs is estimated from the blades of its operands, before it is done.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.algebra.exponential import square_of, without_scalar
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.script import clucalc, syntax
from motorcade.ga.script.algebras import AlgebraDefinition, Macros
from motorcade.ga.script.errors import Place, ScriptError, Source
from motorcade.ga.script.functions import (
    ANY_CASE,
    FUNCTIONS,
    chosen,
    computed,
    decided,
    is_finite,
    operand_count,
    operated,
    rows_of,
    scalar_of,
)

MAX_MACRO_DEPTH = 32
# Is shown each mark for the image where it is run, with its value; None for a word.
Watch = Callable[[syntax.Assignment | syntax.Mark | syntax.Screen, Multivector | None], None]


def constants_of(algebra: Algebra) -> frozenset[str]:
    """The names of the basis vectors, and of the vectors that are sums of them."""
    return frozenset((*algebra.names, *algebra.named))


class _Scope:
    """What one body sees: its own names and arguments, and what it is the body of."""

    def __init__(
        self,
        source: Source,
        names: dict[str, Multivector],
        arguments: tuple[Multivector, ...] = (),
        macro: syntax.Macro | None = None,
    ) -> None:
        self.names = names
        self.references: set[str] = set()
        self.macro = macro
        self.arguments = arguments
        self.error = source.error
        self.source = source


class Run:
    """One evaluation of a script over the values that are given for its free variables."""

    def __init__(
        self,
        script: syntax.Script,
        algebra: Algebra,
        definition: AlgebraDefinition,
        fields: dict[str, Multivector],
        watch: Watch | None = None,
    ) -> None:
        self._script = script
        self._watch = watch
        self._algebra = algebra
        self._constants = {name: algebra.blade(name) for name in constants_of(algebra)}
        self._values = dict(fields)
        self._scope = _Scope(script.source, self._values)
        self._macros = Macros(script, definition)
        self._budget = Budget()
        self._depth = 0
        self._undecided: list[Any] = []
        self._made: dict[str, Multivector] = {}
        self._drawn: dict[str, Multivector] = {}
        self._tools: dict[str, Any] = {}
        self._assigned = clucalc.assigned_names(script.statements) if script.clucalc else set()
        self._gaalop = _names_gaalop(script, definition)
        self._normalized = [
            p.place for p in script.pragmas if isinstance(p, syntax.NormalizePragma)
        ]

    def outputs(self) -> dict[str, Multivector]:
        """The outputs by name. Raises ScriptError: see `meaning.evaluate`."""
        self._check_ranges()
        steps = [step for step in self._script.statements if not isinstance(step, syntax.Macro)]
        self._run(steps, self._scope)
        if not self._script.clucalc or self._made or self._names_outputs:
            return self._selected(self._made)
        for name, value in self._values.items() if not self._drawn else ():
            if not name.startswith("_"):
                self._drawn.update(clucalc.outputs_of(name, value))
        return self._selected(self._drawn)

    @property
    def _names_outputs(self) -> bool:
        return any(isinstance(pragma, syntax.OutputPragma) for pragma in self._script.pragmas)

    def _selected(self, outputs: dict[str, Multivector]) -> dict[str, Multivector]:
        """Add the outputs of pragmas, and keep the blades they name."""
        blades: dict[str, dict[str, Place]] = {}
        leading: dict[str, Multivector] = {}
        for pragma in self._script.pragmas:
            if isinstance(pragma, syntax.OutputPragma):
                if pragma.name not in outputs:
                    outputs[pragma.name] = self._read_name(
                        syntax.Name(pragma.place, pragma.name), self._scope
                    )
                if pragma.leads:
                    leading[pragma.name] = outputs[pragma.name]
                if not isinstance(outputs[pragma.name], Multivector):
                    kind = clucalc.kind_of(outputs[pragma.name])
                    raise self._scope.error(pragma.place, f"expected a multivector, got a {kind}")
                wanted = blades.setdefault(pragma.name, {})
                wanted.update(dict.fromkeys(pragma.blades, pragma.place))
        ordered = {**leading, **outputs}
        return {name: self._kept(x, blades.get(name, {})) for name, x in ordered.items()}

    def _kept(self, x: Multivector, blades: dict[str, Place]) -> Multivector:
        if not blades:
            return x
        kept: set[int] = set()
        for blade, place in blades.items():
            kept.update(self._masks(blade, place, self._scope))
        return x._selected(kept.__contains__)

    def _masks(self, blade: str, place: Place, scope: _Scope) -> list[int]:
        try:
            return [mask for mask, _ in self._algebra.masks_of(blade)]
        except ValueError as refused:
            raise scope.error(place, str(refused)) from refused

    def _check_ranges(self) -> None:
        for pragma in self._script.pragmas:
            if isinstance(pragma, syntax.RangePragma) and pragma.name in self._values:
                value = self._values[pragma.name].scalar_part()
                if is_numeric(value) and not np.all((value >= pragma.low) & (value <= pragma.high)):
                    raise self._scope.error(
                        pragma.place,
                        f"expected {pragma.name} from {pragma.low:g} to {pragma.high:g}, "
                        f"got values from {np.min(value):g} to {np.max(value):g}",
                    )

    # Statements ----------------------------------------------------------------------------------

    def _run(self, steps: Sequence[syntax.Step], scope: _Scope) -> bool:
        """Run statements in their order; whether a ``break`` ended them."""
        for step in steps:
            if isinstance(step, syntax.Break):
                if self._undecided:
                    raise scope.error(
                        step.place, "expected a break on a condition that is known", _ROUNDS
                    )
                return True
            if isinstance(step, syntax.If):
                if self._branch(step, scope):
                    return True
            elif isinstance(step, syntax.Loop):
                self._loop(step, scope)
            elif isinstance(step, syntax.Screen):
                self._draw(step, scope)
            else:
                if isinstance(step, syntax.Assignment):
                    self._assign(step, scope)
                if step.mark == "?":
                    self._output(step, scope)
                elif step.mark == ":":
                    self._draw(step, scope)
        return False

    def _draw(self, step: syntax.Assignment | syntax.Mark | syntax.Screen, scope: _Scope) -> None:
        """Show what is marked to who watches: those rows that come by here; macros draw nothing.

        What a script of CLUCalc's draws under a name is its output where it marks none.
        """
        clucalcs = self._script.clucalc and not self._undecided
        if scope.macro is not None or (self._watch is None and not clucalcs):
            return
        name = f"line_{step.place.line}" if isinstance(step, syntax.Screen) else step.name
        if isinstance(step, syntax.Screen) and (step.word or step.value is None):
            if self._watch is not None:
                self._watch(step, None)
            return
        if isinstance(step, syntax.Screen) and step.value is not None:
            value = self._value(step.value, scope)
        else:
            value = self._read_name(syntax.Name(step.place, name), scope)
        parts = clucalc.outputs_of(name, value)
        if clucalcs:
            self._drawn.update(parts)
        for part in parts.values():
            rows = rows_of(part, self._undecided) if self._undecided else part
            if rows is not None and self._watch is not None:
                self._watch(step, rows)

    def _branch(self, step: syntax.If, scope: _Scope) -> bool:
        condition, known = self._condition(step.condition, scope)
        if known is not None:
            return self._run(step.then if known else step.otherwise, scope)
        before = dict(scope.names)
        self._undecided.append(condition != 0)
        self._run(step.then, scope)
        then = dict(scope.names)
        scope.names.clear()
        scope.names.update(before)
        self._undecided[-1] = condition == 0
        self._run(step.otherwise, scope)
        self._undecided.pop()
        for name in {**then, **scope.names}:
            if name not in then or name not in scope.names:
                # What one branch alone has made has no value behind them.
                scope.names.pop(name, None)
            elif then[name] is not scope.names[name]:
                if not all(isinstance(x[name], Multivector) for x in (then, scope.names)):
                    kind = clucalc.kind_of(then[name])
                    raise scope.error(
                        step.place, f"{name}: expected one {kind} for a condition that is not known"
                    )
                merged = chosen(self._algebra, condition, then[name], scope.names[name])
                scope.names[name] = merged
        return False

    def _loop(self, step: syntax.Loop, scope: _Scope) -> None:
        rounds = 0
        while not step.rounds or rounds < step.rounds:
            over = self._budget.spend(None, [])
            if over:
                raise scope.error(step.place, over, "does the loop end in a break?")
            if self._run(step.body, scope):
                return
            rounds += 1
            if self._script.clucalc and rounds == clucalc.MAX_ROUNDS:
                return

    def _condition(self, condition: syntax.Expression, scope: _Scope) -> tuple[Any, bool | None]:
        """The value of a condition, and whether it holds where that is known.

        A recorded multivector tells by what it comes to in terms of the inputs, `flat`.
        """
        value = self._value(condition, scope)
        if not isinstance(value, Multivector):
            raise scope.error(
                condition.place, f"condition: expected a scalar, got {clucalc.kind_of(value)}"
            )
        try:
            return scalar_of(value), decided(scalar_of(getattr(value, "flat", value)))
        except ValueError as refused:
            raise scope.error(condition.place, f"condition: {refused}") from refused

    def _assign(self, step: syntax.Assignment, scope: _Scope) -> None:
        if step.name in self._constants:
            raise scope.error(
                step.place,
                f"{step.name} is a basis vector of {self._algebra}",
                "assign to another name",
            )
        value = self._value(step.value, scope)
        name, outer = step.name.removeprefix("::"), step.name.startswith("::")
        names = self._values if outer else scope.names
        references = (self._scope if outer else scope).references
        if name in references and not step.refers:
            hint = "there are no references: a name behind -> is read alone"
            raise scope.error(step.place, f"{name} refers to another value", hint)
        if outer and self._undecided:
            raise scope.error(step.place, "expected this outside of branches that are not known")
        if step.refers:
            references.add(name)
        if not name:
            return
        if step.mark == "?" and any(place < step.place for place in self._normalized):
            scope.names[f"{step.name}_unnormalized"] = value
            size = FUNCTIONS["abs"].apply(value)
            try:
                value = value / size
            except ValueError as refused:
                raise scope.error(step.place, f"normalize: {refused}") from refused
        names[name] = value

    def _output(self, step: syntax.Assignment | syntax.Mark, scope: _Scope) -> None:
        """Take an output; those of macros have the names that Gaalop gives them."""
        if self._undecided:
            raise scope.error(
                step.place,
                "expected outputs outside of branches whose condition is not known",
                f"write ?{step.name}; behind the branch",
            )
        value = self._read_name(syntax.Name(step.place, step.name), scope)
        if not isinstance(value, Multivector):
            self._made.update(clucalc.outputs_of(step.name, value))
            return
        name = step.name
        if scope.macro is not None:
            name = first = f"macro_{scope.macro.name}_{step.name}"
            number = 0
            while name in self._made:
                number += 1
                name = f"{first}{number}"
        self._made[name] = value

    # Expressions ---------------------------------------------------------------------------------

    def _value(self, root: syntax.Expression, scope: _Scope) -> Any:
        """A multivector; in scripts of CLUCalc's also a text, a list, a macro, or None."""
        stack: list[Any] = []
        for node in syntax.postorder(root):
            taken = operand_count(node)
            operands = stack[len(stack) - taken :]
            del stack[len(stack) - taken :]
            over = self._budget.spend(node, operands)
            if over:
                raise scope.error(node.place, over, "split the script, or let macros do less")
            result = self._applied(node, operands, scope)
            if isinstance(result, Multivector) and not all(map(is_finite, result.values)):
                raise scope.error(node.place, "expected finite numbers, got an overflow")
            stack.append(result)
        return stack.pop()

    def _applied(self, node: syntax.Expression, operands: list[Any], scope: _Scope) -> Any:
        if isinstance(node, syntax.Text):
            return node.text
        if isinstance(node, syntax.Skipped):
            for number, drawn in enumerate(operands if scope.macro is None else (), 1):
                name = f"line_{node.place.line}_{number}"
                self._drawn.update(clucalc.outputs_of(name, drawn))
            return None
        if isinstance(node, syntax.ListOf):
            return self._in_clucalc(node, lambda: clucalc.listed(operands), scope)
        if isinstance(node, syntax.Number):
            return self._algebra.scalar(node.value)
        if isinstance(node, syntax.Name):
            return self._read_name(node, scope)
        if isinstance(node, syntax.Argument):
            if not node.index:
                return self._in_clucalc(node, lambda: clucalc.listed(scope.arguments), scope)
            if node.index > len(scope.arguments):
                raise scope.error(node.place, f"this macro was called without _P({node.index})")
            return scope.arguments[node.index - 1]
        if isinstance(node, syntax.Slice):
            masks = [m for blade in node.blades for m in self._masks(blade, node.place, scope)]
            return operands[0]._selected(set(masks).__contains__)
        if isinstance(node, syntax.Unary) and node.operator == "*":
            node = syntax.Call(node.place, "Dual", (node.operand,))
        if isinstance(node, syntax.Call):
            return self._called(node, operands, scope)
        if clucalc.is_its_own(node, operands, self._script.clucalc):
            return self._in_clucalc(
                node, lambda: clucalc.operated(self._algebra, node, operands), scope
            )
        if self._gaalop and isinstance(node, syntax.Binary) and node.operator == "/":
            size = operands[1].reverse_product()
            self._warn_of_parts(node, size, "Gaalop divides right by versors alone", scope)
        try:
            return operated(self._algebra, node, operands)
        except (ValueError, ArithmeticError) as refused:
            raise scope.error(node.place, str(refused)) from refused

    def _read_name(self, node: syntax.Name, scope: _Scope) -> Any:
        name = node.name.removeprefix("::")
        places = [self._constants, scope.names]
        if scope.macro is None or self._macros.is_own(scope.macro):
            places.append(self._values)
        if name != node.name:
            places = [self._constants, self._values]
        for names in places:
            if name in names:
                return names[name]
        if self._script.clucalc:
            macro = self._macros.named(name)
            if macro is not None or clucalc.is_predefined(name, self._algebra):
                return macro or clucalc.predefined(name, self._algebra)
            if name in self._assigned:
                return None  # as a label of CLUCalc's that nothing is known of yet
        raise scope.error(node.place, f"{name} has no value here")

    def _in_clucalc(
        self, node: syntax.Expression, compute: Callable[[], Any], scope: _Scope
    ) -> Any:
        """A value that only scripts of CLUCalc's have."""
        try:
            return compute()
        except (ValueError, ArithmeticError) as refused:
            name = f"{node.name}: " if isinstance(node, syntax.Call) and node.name else ""
            raise scope.error(node.place, f"{name}{refused}") from refused

    def _called(self, node: syntax.Call, operands: list[Any], scope: _Scope) -> Any:
        name = node.name.removeprefix("::")
        if name == ":=":
            scope.names[operands[0]] = operands[1]
            return operands[1]
        value = operands.pop(0) if not name else None
        if name and (name in scope.names or name in self._values):
            value = self._read_name(syntax.Name(node.place, node.name), scope)
        if isinstance(value, syntax.Macro):
            return self._expanded(node, value, tuple(operands), scope)
        if value is not None and (not name or not isinstance(value, Multivector)):
            return self._in_clucalc(node, lambda: clucalc.item_of(value, operands), scope)
        if name.startswith("Vec") and len(operands) == 1 and isinstance(operands[0], clucalc.Items):
            operands = clucalc.coordinates_of(operands[0])
        callee = self._macros.found(name, len(operands), scope.macro)
        if callee is None and name in self._assigned and name in self._values and value is None:
            return None
        if callee is None and isinstance(value, Multivector):
            return self._in_clucalc(node, lambda: clucalc.item_of(value, operands), scope)
        if self._script.clucalc and callee is None:
            callee = self._macros.named(name)
        if not isinstance(callee, syntax.Macro) and clucalc.is_called(name, operands):
            return self._in_clucalc(
                node, lambda: clucalc.called(self._algebra, name, operands, self._tools), scope
            )
        if callee is None:
            raise scope.error(node.place, *self._macros.unknown(node, scope.macro))
        if isinstance(callee, syntax.Macro):
            return self._expanded(node, callee, tuple(operands), scope)
        if name.lower() in ANY_CASE:
            name = name.lower()
            if len(operands) > callee.arity:
                scope.source.warn(
                    node.place, f"{node.name} takes {callee.arity}: what follows is left out"
                )
                operands = operands[: callee.arity]
        if self._gaalop and name in ("exp", "log", "sqrt"):
            self._warn_of_parts(node, operands[0], "Gaalop takes the scalar part alone", scope)
        try:
            return computed(callee, operands)
        except (ValueError, ArithmeticError) as refused:
            shown = str(refused)
            shown = shown if shown.startswith(f"{name}: ") else f"{name}: {shown}"
            raise scope.error(node.place, shown) from refused

    def _warn_of_parts(
        self, node: syntax.Expression, x: Multivector, what: str, scope: _Scope
    ) -> None:
        """Warn where Gaalop computes something else, as what it takes for a scalar is none."""
        try:
            scalar_of(x)
        except ValueError:
            where = scope if scope.macro is None or self._macros.is_own(scope.macro) else None
            if where is not None:
                where.source.warn(node.place, f"{what}; here all of it counts")

    def _expanded(
        self,
        node: syntax.Call,
        macro: syntax.Macro,
        arguments: tuple[Multivector, ...],
        scope: _Scope,
    ) -> Any:
        if self._depth >= MAX_MACRO_DEPTH:
            raise scope.error(
                node.place, f"expected at most {MAX_MACRO_DEPTH} macros that call each other"
            )
        inner = _Scope(macro.source, {}, arguments, macro)
        self._depth += 1
        try:
            if self._run(macro.body, inner) or macro.value is None:
                return None
            return self._value(macro.value, inner)
        except ScriptError as refused:
            if self._macros.is_own(macro):
                raise
            # A macro of the algebra has no place in the user's file: the call has.
            raise scope.error(node.place, f"{node.name}: {refused.message}", refused.hint) from None
        finally:
            self._depth -= 1


def _names_gaalop(script: syntax.Script, definition: AlgebraDefinition) -> bool:
    """Whether a script names its algebra as Gaalop does, and so may come from there."""
    said = [
        p.name for p in script.pragmas if isinstance(p, syntax.AlgebraPragma) and not p.by_caller
    ]
    return bool(definition.names) and definition.names[0] in said


_ROUNDS = "how often a loop runs must not depend on symbols, or differ over a batch"


MAX_STEPS = 100_000
MAX_TERMS = 200_000
_PRODUCTS = frozenset(["*", "^", ".", "&", "<<", ">>"])
# How many products the closed forms of functions take at most, and the series of `exp`.
_CLOSED = 12
_SERIES = 40


class Budget:
    """How much an evaluation has cost so far."""

    def __init__(self) -> None:
        self._steps = 0
        self._terms = 0

    def spend(self, node: syntax.Expression | None, operands: list[Any]) -> str:
        """Count a step that is about to be done: what is wrong if it is one too many, or ""."""
        self._steps += 1 + sum(map(clucalc.weight_of, operands))
        if self._steps > MAX_STEPS:
            return f"expected at most {MAX_STEPS} steps"
        self._terms += 0 if node is None else _terms(node, operands)
        if self._terms > MAX_TERMS:
            return f"expected products of at most {MAX_TERMS} terms in all"
        return ""


def _terms(node: syntax.Expression, operands: list[Any]) -> int:
    if not all(isinstance(x, Multivector) for x in operands):
        return 0
    sizes = [len(x.masks) for x in operands]
    if isinstance(node, syntax.Binary) and node.operator in _PRODUCTS:
        return sizes[0] * sizes[1]
    if isinstance(node, syntax.Binary) and node.operator == "/":
        right = operands[1]
        whole = len(right.masks) if _has_scalar_size(right) else 1 << right.algebra.dimension
        return _of_inverse(right) + sizes[0] * whole
    if isinstance(node, syntax.Call) and len(operands) == 1:
        return _of_function(node.name.lower(), operands[0])
    return sum(sizes) if isinstance(node, syntax.Binary | syntax.Unary) else 0


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
