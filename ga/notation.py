"""How sums of blades are written: as plain text for terminals, as LaTeX, and as HTML for
notebooks.

They take pairs of a blade's name and its coefficient, and import nothing of ours, so that
multivectors and versors can show themselves by them.

Numbers have eight digits, as NumPy prints them; ``x.values`` has them whole. Zeros are left out. A
batch is shown by its first and last numbers and its shape, a symbol by its own text.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Callable, Iterable
from html import escape
from itertools import islice
from typing import Any

import numpy as np

Items = Iterable[tuple[str, Any]]
# More terms than anybody reads; a full multivector of five dimensions is shown whole.
MAX_TERMS = 64


def is_number(value: Any) -> bool:
    """Whether a coefficient is one number, and no batch or symbol.

    >>> import numpy as np
    >>> from motorcade.ga.notation import is_number
    >>> is_number(2), is_number(np.float32(0.5)), is_number(np.zeros(3))
    (True, True, False)
    """
    return isinstance(value, float | int | np.number | np.ndarray) and np.ndim(value) == 0


def all_numbers(items: Items) -> bool:
    """Whether every coefficient is one number."""
    return all(is_number(value) for _, value in items)


def rounded(value: Any, digits: int) -> str:
    """The size of a number to so many digits."""
    return f"{abs(float(value)):.{digits}g}"


def sum_of(
    items: Items, term: Callable[[str, Any], str], *, minus: str = "-", left_out: str = "…"
) -> str:
    """Terms joined by signs, zeros left out, the first `MAX_TERMS` of them; `0` without any.

    `term` writes the size of a number beside a blade; what is no number writes itself whole.

    >>> from motorcade.ga.notation import sum_of
    >>> sum_of([("e1", -2), ("e2", 0.0), ("e3", 1)], lambda blade, value: f"{abs(value)}{blade}")
    '-2e1 + 1e3'
    """
    terms = ""
    shown = ((blade, value) for blade, value in items if not _is_nothing(value))
    for count, (blade, value) in enumerate(islice(shown, MAX_TERMS + 1)):
        negative = is_number(value) and value < 0
        text = left_out if count == MAX_TERMS else term(blade, value)
        if not terms:
            terms = f"{minus}{text}" if negative else text
        else:
            terms += f" {minus if negative and count < MAX_TERMS else '+'} {text}"
    return terms or "0"


def _is_nothing(value: Any) -> bool:
    return is_number(value) and bool(value == 0)


_DIGITS_OF_TEXT = 8
_DIGITS_OF_BATCHES = 4
_MOST_OF_A_BATCH = 4
_LONGEST_SYMBOL = 60


def sum_text(items: Items) -> str:
    """A sum of blades on one line.

    >>> import numpy as np
    >>> from motorcade.ga.notation import sum_text
    >>> sum_text([("1", 1.5), ("e1", 0.0), ("e1^e2", 2.0), ("einf", -1.0)])
    '1.5 + 2*e1^e2 - einf'
    >>> sum_text([("e1", np.linspace(0.0, 1.0, 11)), ("e2", 1 / 3)])
    '[0, 0.1, …, 0.9, 1](11)*e1 + 0.33333333*e2'
    """
    return sum_of(items, _term)


def _term(blade: str, value: Any) -> str:
    text = _coefficient(value)
    if blade == "1":
        return text
    return blade if text == "1" and is_number(value) else f"{text}*{blade}"


def _coefficient(value: Any) -> str:
    if is_number(value):
        return rounded(value, _DIGITS_OF_TEXT)
    if isinstance(value, np.ndarray):
        return _batch(value)
    text = " ".join(str(value).split())
    if len(text) > _LONGEST_SYMBOL:
        text = f"{text[:_LONGEST_SYMBOL]}…"
    return text if text.isidentifier() else f"({text})"


def _batch(value: np.ndarray[Any, Any]) -> str:
    """A few of the numbers, and the shape where they are not all there."""
    flat = value.ravel()
    shown = [f"{float(number):.{_DIGITS_OF_BATCHES}g}" for number in _ends(flat)]
    if flat.size > _MOST_OF_A_BATCH:
        shown.insert(_MOST_OF_A_BATCH // 2, "…")
    whole = value.ndim == 1 and flat.size <= _MOST_OF_A_BATCH
    shape = "" if whole else f"({', '.join(map(str, value.shape))})"
    return f"[{', '.join(shown)}]{shape}"


def _ends(flat: np.ndarray[Any, Any]) -> list[Any]:
    if flat.size <= _MOST_OF_A_BATCH:
        return list(flat)
    half = _MOST_OF_A_BATCH // 2
    return [*flat[:half], *flat[-half:]]


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

    >>> from motorcade.ga.notation import name_text
    >>> [name_text(name) for name in ("x", "c12", "theta", "x_1")]
    ['x', 'c_{12}', '\\theta', '\\mathit{x\\_1}']
    """
    if name in _GREEK:
        return f"\\{name}"
    match = re.fullmatch(r"([A-Za-z])([0-9]*)", name)
    if match:
        return f"{match[1]}_{{{match[2]}}}" if match[2] else name
    return rf"\mathit{{{name.replace('_', chr(92) + '_')}}}"


def blade_text(blade: str) -> str:
    r"""A blade as it is set; of ``1`` nothing is left.

    >>> from motorcade.ga.notation import blade_text
    >>> print(blade_text("e1^einf"))
    \mathbf{e}_{1} \wedge \mathbf{e}_{\infty}
    """
    return " \\wedge ".join(_formula_vector(name) for name in blade.split("^") if name != "1")


def number_text(value: float, digits: int | None = None) -> str:
    r"""A number to its last digit, or to so many: ``0.5``, ``1.5 \cdot 10^{-7}``.

    >>> from motorcade.ga.notation import number_text
    >>> number_text(1.5e-7), number_text(2.0), number_text(1 / 3, 3)
    ('1.5 \\cdot 10^{-7}', '2', '0.333')
    """
    shown = repr(float(value)) if digits is None else f"{value:.{digits}g}"
    mantissa, _, exponent = shown.partition("e")
    mantissa = mantissa.removesuffix(".0")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def sum_formula(items: Items) -> str | None:
    r"""A sum of blades with numbers alone; None for batches and symbols, which are text.

    >>> from motorcade.ga.notation import sum_formula
    >>> print(sum_formula([("1", 0.5), ("e1^e2", -1.0)]))
    $\displaystyle 0.5 - \mathbf{e}_{1} \wedge \mathbf{e}_{2}$
    """
    items = list(items)
    if not all_numbers(items):
        return None
    return rf"$\displaystyle {sum_of(items, _formula_term, left_out=chr(92) + 'dots')}$"


def _formula_term(blade: str, value: Any) -> str:
    size, vector = number_text(abs(float(value)), _DIGITS), blade_text(blade)
    if vector and size == "1":
        return vector
    return size + (rf"\,{vector}" if vector else "")


def _formula_vector(name: str) -> str:
    index = name[1:] if name.startswith("e") and len(name) > 1 else ""
    if index == "inf":
        index = r"\infty"
    return (
        rf"\mathbf{{e}}_{{{index}}}" if index.isalnum() or index == r"\infty" else name_text(name)
    )


def sum_page(items: Items) -> str | None:
    """A sum of blades with numbers alone; None for batches and symbols, which are text.

    >>> from motorcade.ga.notation import sum_page
    >>> print(sum_page([("1", 0.5), ("e1^einf", -2.0)]))
    <span>0.5 − 2 <b>e</b><sub>1</sub>∧<b>e</b><sub>∞</sub></span>
    """
    items = list(items)
    return f"<span>{sum_of(items, _page_term, minus='−')}</span>" if all_numbers(items) else None


def _page_term(blade: str, value: Any) -> str:
    mantissa, _, exponent = rounded(value, _DIGITS).partition("e")
    size = f"{mantissa}·10<sup>{_power(exponent)}</sup>" if exponent else mantissa
    if blade == "1":
        return size
    vectors = "∧".join(map(_page_vector, blade.split("^")))
    return vectors if size == "1" else f"{size} {vectors}"


def _power(exponent: str) -> str:
    return str(int(exponent)).replace("-", "−")


def _page_vector(name: str) -> str:
    match = re.fullmatch(r"e(\w+)", name)
    if match is None:
        return f"<i>{escape(name)}</i>"
    return f"<b>e</b><sub>{'∞' if match[1] == 'inf' else escape(match[1])}</sub>"


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
