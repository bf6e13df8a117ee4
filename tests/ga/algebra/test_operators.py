"""Powers, parts by name, comparison, exact fractions, and square roots near the identity."""

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector

ALGEBRAS = [EGA3, PGA3, CGA3]


def anything(algebra: Algebra, rng: np.random.Generator) -> Multivector:
    return algebra.multivector({name: float(rng.standard_normal()) for name in algebra.blades})


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=str)
def test_powers_are_repeated_products(algebra: Algebra, rng: np.random.Generator) -> None:
    x = anything(algebra, rng)
    product = algebra.scalar(1.0)
    for exponent in range(7):
        assert (x**exponent).isclose(product, rtol=1e-9, atol=1e-9)
        assert (x**-exponent * product).isclose(1, atol=1e-6)
        product = product * x


def test_powers_of_batches_and_of_nothing(rng: np.random.Generator) -> None:
    x = EGA3.multivector({"1": rng.standard_normal(5), "e1^e2": rng.standard_normal(5)})
    assert np.all((x**3).isclose(x * x * x))
    assert (x**0).isclose(1)
    with pytest.raises(ValueError, match=r"expected a whole exponent, got 0\.5"):
        x**0.5  # type: ignore[operator]
    with pytest.raises(ValueError, match="expected an invertible multivector"):
        CGA3.blade("einf") ** -1


def test_parts_by_name_and_by_grade(rng: np.random.Generator) -> None:
    x = anything(CGA3, rng)
    assert x["e1^e2"] == x.coefficient("e1^e2") == -x["e2^e1"]
    assert x["1"] == x.scalar_part()
    assert x[2].blades == x.grade(2).blades
    assert EGA3.blade("e1")["e2"] == 0.0
    for wrong in (6, -1, 1.0, "e9"):
        with pytest.raises(ValueError, match="expected"):
            x[wrong]  # type: ignore[index]
    assert not isinstance(x, Iterable)


def test_isclose_compares_blade_by_blade() -> None:
    x = EGA3.multivector({"1": 1.0, "e1": np.array([0.0, 1e-12, 1e-3])})
    np.testing.assert_array_equal(x.isclose(EGA3.scalar(1.0)), [True, True, False])
    np.testing.assert_array_equal(x.isclose(1.0, atol=1e-2), [True, True, True])
    assert EGA3.blade("e1").isclose(EGA3.blade("e1") * (1 + 1e-9))
    assert not EGA3.blade("e1").isclose(EGA3.blade("e2"))
    assert EGA3.multivector({}).isclose(0)
    with pytest.raises(ValueError, match="of one algebra"):
        EGA3.blade("e1").isclose(PGA3.blade("e1"))


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=str)
def test_fractions_stay_fractions(algebra: Algebra) -> None:
    third = Fraction(1, 3)
    a = algebra.vector([Fraction(k + 1, 3) for k in range(algebra.dimension)])
    b = algebra.vector([Fraction(k * k - 2, 5) for k in range(algebra.dimension)])
    even = a * b
    made = [
        even, a ^ b, a | b, even & (b * a), ~even, even.sandwich(a), even.square(), even**3,
        even.commutator(a * (b + a)), a.complement(), a.uncomplement(), even.grade(2),
        even.reverse_product(), a.involute(), even.conjugate(), a.as_orthogonal(), a / 7, 3 * a,
        third * algebra.blade("e1"), even / third, a.inverse(), even**-1,
    ]  # fmt: skip
    if algebra is not PGA3:
        made += [a.dual(), a.undual()]
    kinds = {type(value) for one in made for value in one.values}
    assert kinds == {Fraction}
    assert even.isclose(b * a + 2 * (a ^ b))
    assert type(a.norm_squared()) is Fraction


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-160, 1e-16, 1e-9, 1e-8, 1.1e-8, 3e-8, 1e-4, 0.1])
@pytest.mark.parametrize("of", [float, np.float64, lambda x: np.array([x, x])])
def test_square_roots_of_motors_keep_their_digits_near_the_identity(angle: float, of: Any) -> None:
    """Against 50 digits, for each coefficient relative to what it is."""
    translation = (0.3, -0.2, 0.7)
    with mp.workdps(50):
        whole, half = exact_motor(angle, translation), exact_root(angle, translation)
    names = ("1", "e1^e2", "e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf")
    x = CGA3.multivector({n: of(float(v)) for n, v in zip(names, whole, strict=True)})
    root = x.sqrt()
    for name, value in zip(names, half, strict=True):
        np.testing.assert_allclose(root[name], float(value), rtol=4e-16, atol=1e-320, err_msg=name)
    assert np.all(CGA3.scalar(of(1.0)).sqrt().isclose(1.0, rtol=0.0, atol=0.0))


def exact_motor(angle: float, t: tuple[float, ...]) -> list[Any]:
    """``(1 - ½ t∞) (c - s e12)`` of an angle about e3."""
    c, s = mp.cos(mp.mpf(angle) / 2), mp.sin(mp.mpf(angle) / 2)
    x, y, z = map(mp.mpf, t)
    return [c, -s, -(c * x + s * y) / 2, -(c * y - s * x) / 2, -c * z / 2, s * z / 2]


def exact_root(angle: float, t: tuple[float, ...]) -> list[Any]:
    """Half the angle, half the way along the axis; ``T' + R' T' ~R' = T`` across it."""
    quarter = mp.mpf(angle) / 4
    x, y, z = map(mp.mpf, t)
    # Half of (1 + e^{iφ/2})^{-1}, times 2: the shift that is made twice, the second time turned.
    turn = mp.expj(2 * quarter)
    shift = mp.mpc(x, y) / (1 + turn)
    return exact_motor(float(angle) / 2, (shift.real, shift.imag, z / 2))
