"""Algebras that every law is run on, and multivectors made of whole numbers, so that laws hold
exactly: no tolerance hides a wrong sign.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector

ALGEBRAS = {
    "EGA3": EGA3,
    "CGA3": CGA3,
    "CGA3 orthogonal": CGA3.orthogonal,
    "CGA1": Algebra(2, 1, null_pair=True),
    "PGA3": PGA3,
    "Cl(2,3)": Algebra(2, 3),
    "Cl(1,1,1)": Algebra(1, 1, 1),
    "Cl(0,2)": Algebra(0, 2),
    "Grassmann": Algebra(0, 0, 3),
    "line": Algebra(1),
}


@pytest.fixture(params=ALGEBRAS)
def algebra(request: pytest.FixtureRequest) -> Algebra:
    return ALGEBRAS[request.param]


def multivectors(algebra: Algebra, grade: int | None = None) -> st.SearchStrategy[Multivector]:
    names = [b for b in algebra.blades if grade is None or algebra.blade(b).grades == (grade,)]
    numbers = st.integers(-6, 6)
    return st.dictionaries(st.sampled_from(names), numbers, max_size=12).map(algebra.multivector)


@pytest.fixture
def draw(algebra: Algebra) -> Callable[..., Multivector]:
    """Draws a multivector of the algebra under test, of one grade or any."""

    def drawn(data: st.DataObject, grade: int | None = None) -> Multivector:
        return data.draw(multivectors(algebra, grade))

    return drawn


def known(x: Multivector) -> dict[str, Any]:
    """The coefficients that are not zero."""
    return {name: value for name, value in x.items() if np.any(value != 0)}


@pytest.fixture
def same() -> Callable[[Multivector, Multivector], None]:
    def check(one: Multivector, two: Multivector) -> None:
        assert known(one) == known(two)

    return check


@pytest.fixture
def close() -> Callable[..., None]:
    """Compares all coefficients, relative to the largest of them."""

    def check(one: Multivector, two: Multivector, tolerance: float = 1e-12) -> None:
        names = dict.fromkeys((*one.blades, *two.blades))
        largest = max((float(np.max(np.abs(v))) for v in two.values), default=1.0)
        for name in names:
            np.testing.assert_allclose(
                one.coefficient(name),
                two.coefficient(name),
                rtol=0,
                atol=tolerance * max(1.0, largest),
                err_msg=name,
            )

    return check
