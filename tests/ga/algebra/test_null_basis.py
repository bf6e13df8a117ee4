"""The null basis e0, einf of CGA against the orthogonal basis ep, em."""

import pytest

from motorcade.ga.algebra import CGA3


@pytest.mark.parametrize(
    ("product", "expected"),
    [
        (("einf", "e0"), {"1": -1.0, "e0^einf": -1.0}),
        (("e0", "einf"), {"1": -1.0, "e0^einf": 1.0}),
        (("einf", "einf"), {}),
        (("e0", "e0"), {}),
        (("e0^einf", "e0^einf"), {"1": 1.0}),
        (("e1^e2^e3^einf", "e2^e3"), {"e1^einf": -1.0}),
    ],
)
def test_products_of_null_blades(product: tuple[str, str], expected: dict[str, float]) -> None:
    left, right = (CGA3.blade(name) for name in product)
    assert dict((left * right).items()) == expected


def test_pseudoscalar_squares_to_minus_one() -> None:
    assert dict(CGA3.pseudoscalar.square().items()) == {"1": -1.0}
    assert CGA3.pseudoscalar.coefficient("e1^e2^e3^einf^e0") == 1.0
