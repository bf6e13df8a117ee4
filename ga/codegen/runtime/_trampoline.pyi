"""Functions of programs that were compiled at run time."""

from collections.abc import Callable
from typing import Any

def bind(
    name: str,
    inputs: list[tuple[str, int]],
    outputs: list[tuple[str, int]],
    negative: list[bool],
    bare: bool,
    single: str | None,
    real: str | None,
    symbol: str,
    threads: Callable[[], int],
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """A program's functions of arrays and of components, from its libraries.

    Operands are names and widths, -1 for scalars. The first function takes an array ``(*, width)``
    an input and gives one an output, without a tuple if `bare`; the second takes and gives single
    components, those of inputs that are `negative` with the other sign, and refuses results that
    are not finite. Either gives NotImplemented where there is
    no library of the precision that the arguments ask for.
    """

def processor_level() -> int:
    """The x86-64 level that the processor runs, 1 to 4; 0 on other processors."""
