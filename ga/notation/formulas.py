r"""Formulas: names, numbers, blades and their sums as LaTeX, for notebooks and generated text."""

from __future__ import annotations

import re
from typing import Any

from motorcade.ga.notation.terms import Items, all_numbers, sum_of

_GREEK = frozenset(
    re.findall(
        r"\w+",
        """
        alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau
        upsilon phi chi psi omega
        """,
    )
)
_DIGITS = 6


def name_text(name: str) -> str:
    r"""An identifier as it is set: ``x``, ``x_{1}``, ``\theta``, ``\mathit{left\_arm}``.

    >>> from motorcade.ga.notation.formulas import name_text
    >>> [name_text(name) for name in ("x", "c12", "theta", "x_1")]
    ['x', 'c_{12}', '\\theta', '\\mathit{x\\_1}']
    """
    if name in _GREEK:
        return f"\\{name}"
    found = re.fullmatch(r"([A-Za-z])([0-9]*)", name)
    if found:
        return f"{found[1]}_{{{found[2]}}}" if found[2] else name
    return rf"\mathit{{{name.replace('_', chr(92) + '_')}}}"


def blade_text(blade: str) -> str:
    r"""A blade as it is set; of ``1`` nothing is left.

    >>> from motorcade.ga.notation.formulas import blade_text
    >>> print(blade_text("e1^einf"))
    \mathbf{e}_{1} \wedge \mathbf{e}_{\infty}
    """
    return " \\wedge ".join(_vector(name) for name in blade.split("^") if name != "1")


def number_text(value: float, digits: int | None = None) -> str:
    r"""A number to its last digit, or to so many: ``0.5``, ``1.5 \cdot 10^{-7}``.

    >>> from motorcade.ga.notation.formulas import number_text
    >>> number_text(1.5e-7), number_text(2.0), number_text(1 / 3, 3)
    ('1.5 \\cdot 10^{-7}', '2', '0.333')
    """
    shown = repr(float(value)) if digits is None else f"{value:.{digits}g}"
    mantissa, _, exponent = shown.partition("e")
    mantissa = mantissa.removesuffix(".0")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def sum_formula(items: Items) -> str | None:
    r"""A sum of blades with numbers alone; None for batches and symbols, which are text.

    >>> from motorcade.ga.notation.formulas import sum_formula
    >>> print(sum_formula([("1", 0.5), ("e1^e2", -1.0)]))
    $\displaystyle 0.5 - \mathbf{e}_{1} \wedge \mathbf{e}_{2}$
    """
    items = list(items)
    if not all_numbers(items):
        return None
    return rf"$\displaystyle {sum_of(items, _term, left_out=chr(92) + 'dots')}$"


def _term(blade: str, value: Any) -> str:
    size, vector = number_text(abs(float(value)), _DIGITS), blade_text(blade)
    if vector and size == "1":
        return vector
    return size + (rf"\,{vector}" if vector else "")


def _vector(name: str) -> str:
    index = name[1:] if name.startswith("e") and len(name) > 1 else ""
    if index == "inf":
        index = r"\infty"
    return (
        rf"\mathbf{{e}}_{{{index}}}" if index.isalnum() or index == r"\infty" else name_text(name)
    )
