"""Running a tape as it is, one NumPy operation after the other: no code is written or compiled."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from motorcade.ga.codegen.tape import Tape

NUMPY_OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "neg": np.negative,
    "sqrt": np.sqrt, "abs": np.abs, "floor": np.floor, "ceil": np.ceil, "min": np.minimum,
    "max": np.maximum, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
    "lt": np.less, "le": np.less_equal, "eq": np.equal, "ne": np.not_equal,
    "and": np.logical_and, "or": np.logical_or, "not": np.logical_not,
    "select": lambda condition, x, y: np.where(np.asarray(condition) != 0.0, x, y),
    "keep": lambda condition, x: np.where(np.asarray(condition) != 0.0, x, 0.0),
}  # fmt: skip


def run_tape(tape: Tape, inputs: Mapping[tuple[str, int], Any]) -> list[list[Any]]:
    """The components of each output.

    `inputs` gives a number or an array for each name and component of an input; arrays broadcast.
    Where a value is no real number the result is NaN or infinite.
    """
    values: list[Any] = []
    left = tape.uses()  # a value that nothing else needs is let go: its memory is the next one's
    with np.errstate(all="ignore"):
        for node in tape.nodes:
            if node.op == "const":
                values.append(np.float64(node.value))
            elif node.op == "input":
                values.append(np.asarray(inputs[node.source], dtype=np.float64))
            else:
                value = NUMPY_OPERATIONS[node.op](*[values[k] for k in node.args])
                values.append(np.asarray(value, dtype=np.float64))
                for k in node.args:
                    left[k] -= 1
                    if left[k] == 0:
                        values[k] = None
    return [[values[k] for k in row] for row in tape.results]
