r"""Formulas: names, numbers, blades and multivectors as LaTeX, for notebooks and generated text."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from motorcade.ga.algebra.scalars import is_numeric

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

    >>> from motorcade.ga.drawing.formulas import name_text
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

    >>> from motorcade.ga.drawing.formulas import blade_text
    >>> print(blade_text("e1^einf"))
    \mathbf{e}_{1} \wedge \mathbf{e}_{\infty}
    """
    return " \\wedge ".join(_vector(name) for name in blade.split("^") if name != "1")


def number_text(value: float, digits: int | None = None) -> str:
    r"""A number to its last digit, or to so many: ``0.5``, ``1.5 \cdot 10^{-7}``.

    >>> from motorcade.ga.drawing.formulas import number_text
    >>> number_text(1.5e-7), number_text(2.0), number_text(1 / 3, 3)
    ('1.5 \\cdot 10^{-7}', '2', '0.333')
    """
    shown = repr(float(value)) if digits is None else f"{value:.{digits}g}"
    mantissa, _, exponent = shown.partition("e")
    mantissa = mantissa.removesuffix(".0")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def multivector_text(x: Any) -> str | None:
    r"""A multivector of plain numbers as a sum of blades; None for batches and symbols.

    >>> from motorcade.ga import EGA3
    >>> from motorcade.ga.drawing.formulas import multivector_text
    >>> print(multivector_text(EGA3.multivector({"1": 0.5, "e1^e2": -1.0})))
    0.5 - \mathbf{e}_{1} \wedge \mathbf{e}_{2}
    """
    terms: list[str] = []
    for blade, value in x.items():
        if not is_numeric(value) or np.ndim(value):
            return None
        size, vector = number_text(abs(value), _DIGITS), blade_text(blade)
        text = vector if vector and size == "1" else size + (rf"\,{vector}" if vector else "")
        if size != "0":
            sign = "-" if value < 0 else "+"
            first = "-" if value < 0 else ""
            terms.append(f"{sign} {text}" if terms else first + text)
    return " ".join(terms) or "0"


def shown_formula(text: str | None) -> str | None:
    """What notebooks set as a formula."""
    return None if text is None else rf"$\displaystyle {text}$"


def _vector(name: str) -> str:
    index = name[1:] if name.startswith("e") and len(name) > 1 else ""
    if index == "inf":
        index = r"\infty"
    return (
        rf"\mathbf{{e}}_{{{index}}}" if index.isalnum() or index == r"\infty" else name_text(name)
    )
