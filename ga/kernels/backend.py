"""Which kernels run: the compiled ones where they are present, the NumPy ones otherwise.

The environment variable MOTORCADE_KERNELS set to "numpy" forces the latter. MOTORCADE_THREADS says
how many threads large batches are shared among at first.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING

__all__ = ["Block", "backend", "checked_function", "function", "set_threads", "threads"]


def _backend() -> str:
    wanted = os.environ.get("MOTORCADE_KERNELS", "")
    if wanted not in ("", "numpy"):
        raise ValueError(f"MOTORCADE_KERNELS: expected 'numpy' or nothing, got {wanted!r}")
    present = find_spec("motorcade.ga.kernels._compiled") is not None
    return "compiled" if present and not wanted else "numpy"


backend = _backend()

if TYPE_CHECKING or backend == "numpy":
    from motorcade.ga.kernels.numpy_backend import (
        Block,
        checked_function,
        function,
        set_threads,
        threads,
    )
else:
    from motorcade.ga.kernels import _compiled
    from motorcade.ga.kernels._compiled import Block, set_threads, threads

    def function(name: str) -> Callable[..., None]:
        """The kernel of that name, called with its inputs and the operand that it writes into."""
        return getattr(_compiled, name)

    def checked_function(name: str) -> Callable[..., bool]:
        """As `function`; it computes, and gives whether all inputs were finite."""
        return _compiled.checked[name]


def _threads_at_first() -> int:
    value = os.environ.get("MOTORCADE_THREADS", "")
    if not value:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if not value.isdecimal() or int(value) < 1:
        raise ValueError(f"MOTORCADE_THREADS: expected a count of at least 1, got {value!r}")
    return int(value)


set_threads(_threads_at_first())
