"""`ShownAsSum`: what notebooks show of a value that is a sum of blades."""

from __future__ import annotations

from abc import abstractmethod

from motorcade.ga.notation.formulas import sum_formula
from motorcade.ga.notation.pages import sum_page
from motorcade.ga.notation.terms import Items


class ShownAsSum:
    """Shown as HTML, and as LaTeX where a notebook becomes a paper; as text where neither is."""

    __slots__ = ()

    @abstractmethod
    def _shown(self) -> Items | None:
        """Pairs of blade and coefficient; None for what only text shows."""

    def _repr_latex_(self) -> str | None:
        items = self._shown()
        return None if items is None else sum_formula(items)

    def _repr_html_(self) -> str | None:
        # Notebooks take it before LaTeX, and exported ones show it without a page's help.
        items = self._shown()
        return None if items is None else sum_page(items)
