"""Functions of multivectors: exponential, logarithm, square root, and back to the versors.

They hold over numbers, batches and symbols, in every algebra whose structure gives a closed form:
`commuting` says which. Numbers that have no real value are refused; for symbols the caller answers.
Derivatives of symbols hold too, of rotors and rigid motors everywhere; those of elements that turn
in two planes, or stretch in one, have no number where both vanish.
"""

from __future__ import annotations

from motorcade.ga.algebra.functions.exponential import exp
from motorcade.ga.algebra.functions.logarithm import log, normalize, sqrt, versor

__all__ = ["exp", "log", "normalize", "sqrt", "versor"]
