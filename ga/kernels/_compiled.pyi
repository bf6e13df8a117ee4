"""Generated kernels, each called with its inputs and the output that it writes into.

An operand is a Block or an array ``(*, width)`` of the output's precision with one row or as many
as the output; operands of one number a row may be plain floats.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

class Block:
    def __init__(self, width: int, count: int, dtype: str = "float64") -> None: ...
    def __len__(self) -> int: ...
    @property
    def width(self) -> int: ...
    @property
    def array(self) -> NDArray[np.floating[Any]]: ...

# The same functions, which give whether all numbers of their inputs were finite.
checked: dict[str, Callable[..., bool]]

def register_versor(versor: type[Any], size: int) -> None: ...
def fast_path(
    method: Callable[..., Any],
    name: str,
    operands: str,
    result: str,
    above: float,
    within: float,
    /,
) -> Any: ...
def set_threads(threads: int) -> None: ...
def threads() -> int: ...
def repeat(name: str, times: int, *operands: Any) -> float: ...
