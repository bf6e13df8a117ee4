"""Which kernels run: the compiled ones where they are present, the NumPy ones otherwise.

The environment variable MOTORCADE_KERNELS set to "numpy" forces the latter. MOTORCADE_THREADS says
how many threads large batches are shared among at first.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.util import find_spec
from math import inf
from typing import TYPE_CHECKING, Any, TypeVar

__all__ = [
    "Block",
    "backend",
    "checked_function",
    "fast_path",
    "function",
    "register_versor",
    "set_threads",
    "threads",
]

Method = TypeVar("Method", bound=Callable[..., Any])


def _backend() -> str:
    wanted = os.environ.get("MOTORCADE_KERNELS", "")
    if wanted not in ("", "numpy"):
        raise ValueError(f"MOTORCADE_KERNELS: expected 'numpy' or nothing, got {wanted!r}")
    present = find_spec("motorcade.ga.kernels._compiled") is not None
    return "compiled" if present and not wanted else "numpy"


backend = _backend()

if TYPE_CHECKING or backend == "compiled":
    from motorcade.ga.kernels import _compiled
if TYPE_CHECKING or backend == "numpy":
    from motorcade.ga.kernels.numpy_backend import (
        Block,
        checked_function,
        function,
        set_threads,
        threads,
    )
else:
    from motorcade.ga.kernels._compiled import Block, set_threads, threads

    def function(name: str) -> Callable[..., None]:
        """The kernel of that name, called with its inputs and the operand that it writes into."""
        return getattr(_compiled, name)

    def checked_function(name: str) -> Callable[..., bool]:
        """As `function`; it computes, and gives whether all inputs were finite."""
        return _compiled.checked[name]


def register_versor(versor: type[Any], size: int) -> None:
    """Say on which type of so many coefficients fast paths work; its subclasses take none."""
    if backend == "compiled":
        _compiled.register_versor(versor, size)


def fast_path(
    name: str, operands: str, result: str, within: float = inf, above: float = -inf
) -> Callable[[Method], Method]:
    """Have single values and short batches go from a method straight to its kernel.

    The method itself runs where an argument is to be converted, broadcast or refused, where a
    number or a versor is not finite, and where the kernels are NumPy's. Both must mean the same.

    Args:
        name: the kernel, without the prefix of the versor's type where it has one.
        operands: a letter an argument: ``i`` the versor that is constructed, ``c`` its class, ``v``
            a versor of the type, ``r`` a rotor, ``m`` a motor,
            ``x`` numbers, ``s`` a square matrix, ``f`` one number, ``p`` one above 0; last, and
            "xyz" where it is left out, ``e`` a sequence of Euler angles, ``o`` one of three axes.
        result: ``i`` or ``v`` a versor, ``x`` numbers, ``z`` numbers without -0, ``s`` a square
            matrix.
        within: the most that the number which follows the result may be, in float64.
        above: what that number must be above.
    """

    def decorate(method: Method) -> Method:
        if backend != "compiled":
            return method
        path: Method = _compiled.fast_path(method, name, operands, result, above, within)
        return path

    return decorate


def _threads_at_first() -> int:
    value = os.environ.get("MOTORCADE_THREADS", "")
    if not value:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if not value.isdecimal() or int(value) < 1:
        raise ValueError(f"MOTORCADE_THREADS: expected a count of at least 1, got {value!r}")
    return int(value)


set_threads(_threads_at_first())
