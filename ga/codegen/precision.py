"""The floating-point types that code is written in."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Precision:
    """A floating-point type: NumPy's and C's name, the suffix of functions, and its bits.

    Definitions of kernels ask for `epsilon`, below which nothing more is gained, and whether their
    code may have `branches`, as that for one row may.
    """

    numpy: str
    c: str
    suffix: str
    bits: int
    branches: bool = False

    @property
    def epsilon(self) -> float:
        """Spacing of the numbers at 1."""
        return 2.0 ** (1 - self.bits)


SINGLE = Precision("float32", "float", "f32", 24)
DOUBLE = Precision("float64", "double", "f64", 53)
PRECISIONS = (SINGLE, DOUBLE)
