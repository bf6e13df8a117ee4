"""Geometric algebras of any signature, and the named ones of three-dimensional space.

``EGA3`` (e1 e2 e3), ``PGA3`` (e1 e2 e3 e0 with e0² = 0) and ``CGA3`` on the null basis
e1 e2 e3 e0 einf with einf·e0 = -1. Nothing is computed at import: products are tabulated when two
sets of blades first meet.
"""

from __future__ import annotations

from motorcade.ga.algebra.algebra import CGA3, EGA3, PGA3, Algebra
from motorcade.ga.algebra.multivector import Multivector

__all__ = ["CGA3", "EGA3", "PGA3", "Algebra", "Multivector"]
