"""Languages as data: which function stands for each operation, or which template."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motorcade.ga.codegen.expressions import Dialect
from motorcade.ga.codegen.precision import Precision

__all__ = ["COMPARISONS", "C_LOGIC", "SAME_NAMES", "Templates"]

# Operations that most languages call by their name here.
SAME_NAMES = {
    name: name
    for name in ("sqrt", "floor", "ceil", "exp", "log", "sin", "cos", "tan", "asin", "acos",
                 "atan", "atan2")
}  # fmt: skip
COMPARISONS = {"lt": "({} < {})", "le": "({} <= {})", "eq": "({} == {})", "ne": "({} != {})"}
C_LOGIC = COMPARISONS | {
    "and": "({} && {})", "or": "({} || {})", "not": "(!{})", "select": "({} ? {} : {})",
}  # fmt: skip


class Templates(Dialect):
    """A dialect of `calls`, names of functions, and `templates` for what is written otherwise.

    `prefix` and `suffix` stand around the functions' names, the suffix behind numbers too. Numbers
    are printed in the precision given, in float64 where there is none.
    """

    def __init__(
        self,
        templates: Mapping[str, str],
        calls: Mapping[str, str],
        precision: Precision | None = None,
        *,
        prefix: str = "",
        suffix: str = "",
    ) -> None:
        self._templates = templates
        self._calls = calls
        self._type = np.dtype(precision.numpy if precision else "float64").type
        self._prefix = prefix
        self._suffix = suffix

    def constant(self, value: float) -> str:
        """The number.

        Raises:
            ValueError: it is too large for the precision.
        """
        with np.errstate(over="ignore"):
            rounded = self._type(value)
        if not np.isfinite(rounded):
            raise ValueError(
                f"expected numbers that {np.dtype(self._type)} can hold, got {value!r}; "
                "write the code in float64"
            )
        return str(rounded) + self._suffix

    def call(self, op: str, args: list[str]) -> str:
        """The operation's template with its arguments, or the call of its function."""
        if op == "keep":
            return self.call("select", [*args, self.constant(0.0)])
        if op in self._templates:
            return self._templates[op].format(*args)
        return f"{self._prefix}{self._calls[op]}{self._suffix}({', '.join(args)})"
