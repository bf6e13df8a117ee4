"""The multivector type under its short name; it lives with the algebras."""

from __future__ import annotations

from motorcade.ga.algebra.multivector import Multivector

__all__ = ["Multivector"]
