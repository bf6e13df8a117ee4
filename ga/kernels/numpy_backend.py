"""The kernels in NumPy, called like the compiled ones: the fallback and their witness.

`function` looks up a generated function and writes its result into the output; batches broadcast.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels.generated.python import KERNELS

_SUFFIXES = {"float32": "f32", "float64": "f64"}


class Block:
    """Storage of `count` rows of `width` numbers; `array` ``(count, width)`` shows it.

    Raises:
        ValueError: another dtype than float32 or float64.
    """

    def __init__(self, width: int, count: int, dtype: str = "float64") -> None:
        if dtype not in _SUFFIXES:
            raise ValueError(f"Block: expected dtype 'float32' or 'float64', got {dtype!r}")
        self.width = width
        self.array: NDArray[Any] = np.zeros((width, count), dtype=dtype).T

    def __len__(self) -> int:
        return len(self.array)


@cache
def function(name: str) -> Callable[..., None]:
    """The kernel of that name, called with its inputs and the array that it writes into."""
    group, widths, _ = KERNELS[name]
    module = import_module(f"motorcade.ga.kernels.generated.python.{group}")
    functions = {dtype: getattr(module, f"{name}_{suffix}") for dtype, suffix in _SUFFIXES.items()}

    def kernel(*operands: Any) -> None:
        if len(operands) != len(widths) + 1:
            raise TypeError(f"{name}: expected {len(widths) + 1} arguments, got {len(operands)}")
        out = _array(operands[-1])
        if any(_overlap(x, out) for x in operands[:-1]):
            raise ValueError("expected an output apart from the inputs: they overlap")
        inputs = [_input(x, width, out) for x, width in zip(operands, widths, strict=False)]
        shape = out.shape[:-1]
        for k, component in enumerate(functions[out.dtype.name](*inputs)):
            every = np.size(component) == out.size // out.shape[-1]
            out[..., k] = np.reshape(component, shape) if every else component

    return kernel


@cache
def checked_function(name: str) -> Callable[..., bool]:
    """As `function`; it gives whether all inputs were finite, and does not warn where not."""
    plain = function(name)

    def kernel(*operands: Any) -> bool:
        with np.errstate(all="ignore"):
            plain(*operands)
        return all(bool(np.isfinite(_array(x)).all()) for x in operands[:-1])

    return kernel


def _array(operand: Any) -> Any:
    return operand.array if isinstance(operand, Block) else operand


def _overlap(operand: Any, out: NDArray[Any]) -> bool:
    """Whether an output shares memory with an input; rows that lie between others' do not."""
    array = _array(operand)
    return isinstance(array, np.ndarray) and bool(np.shares_memory(array, out))


def _input(operand: Any, width: int, out: NDArray[Any]) -> NDArray[Any]:
    """An input as rows, in the output's precision."""
    if isinstance(operand, float):
        return np.full((1, 1), operand, dtype=out.dtype)
    array: NDArray[Any] = _array(operand)
    if array.dtype != out.dtype:
        raise TypeError("expected one precision, got float32 and float64; convert one of them")
    if width > 1 and array.shape[-1:] != (width,):
        raise ValueError(f"expected arrays (*, {width}), got {array.shape}")
    return array.reshape(-1, width)


def set_threads(threads: int) -> None:
    """NumPy kernels run on one thread; accepted so that callers need not ask which backend runs."""


def threads() -> int:
    """How many threads large batches are shared among: one."""
    return 1
