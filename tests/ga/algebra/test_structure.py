"""Names, order, structural zeros, frozen values."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra


def test_blades_are_ordered_by_grade_then_basis() -> None:
    assert EGA3.blades == ("1", "e1", "e2", "e3", "e1^e2", "e1^e3", "e2^e3", "e1^e2^e3")
    assert CGA3.names == ("e1", "e2", "e3", "e0", "einf")
    assert len(CGA3.blades) == 32
    assert CGA3.blades[15] == "e0^einf"
    assert PGA3.blades[-1] == "e1^e2^e3^e0"


@pytest.mark.parametrize(
    ("product", "expected"),
    [
        (("einf", "e0"), {"1": -1.0, "e0^einf": -1.0}),
        (("e0", "einf"), {"1": -1.0, "e0^einf": 1.0}),
        (("einf", "einf"), {}),
        (("e0", "e0"), {}),
        (("e0^einf", "e0^einf"), {"1": 1.0}),
        (("e1^e2^e3^einf", "e2^e3"), {"e1^einf": -1.0}),
        (("e1^e2^e3^einf", "e1^e2^e3^einf"), {}),
    ],
)
def test_products_of_null_blades(product: tuple[str, str], expected: dict[str, float]) -> None:
    left, right = (CGA3.blade(name) for name in product)
    assert dict((left * right).items()) == expected


def test_named_pseudoscalars() -> None:
    assert dict(CGA3.pseudoscalar.square().items()) == {"1": -1.0}
    assert CGA3.pseudoscalar.coefficient("e1^e2^e3^einf^e0") == 1.0
    assert dict(EGA3.pseudoscalar.square().items()) == {"1": -1.0}
    assert dict(PGA3.pseudoscalar.square().items()) == {}


def test_plus_and_minus_vectors_are_understood_in_the_null_basis() -> None:
    ep, em = CGA3.blade("ep"), CGA3.blade("em")
    assert dict(ep.items()) == {"e0": -1.0, "einf": 0.5}
    assert dict(em.items()) == {"e0": 1.0, "einf": 0.5}
    assert (ep * ep).coefficient("1") == 1.0
    assert (em * em).coefficient("1") == -1.0
    assert dict((ep ^ em).items()) == dict(CGA3.blade("ep^em").items())


def test_factors_out_of_order_change_the_sign() -> None:
    x = EGA3.multivector({"e3^e1": 2.0})
    assert x.blades == ("e1^e3",)
    assert x.coefficient("e1^e3") == -2.0
    assert x.coefficient("e3^e1") == 2.0
    assert x.coefficient("e2") == 0.0


def test_structural_zeros_are_never_stored() -> None:
    x = EGA3.multivector({"e1^e2": 1.0, "e1": 2.0})
    assert (x * EGA3.blade("e1")).blades == ("1", "e2")
    assert (EGA3.blade("e1") ^ EGA3.blade("e1")).blades == ()
    motor = dict.fromkeys(
        ("1", "e1^e2", "e1^e3", "e2^e3", "e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf"), 1.0
    )
    m = CGA3.multivector(motor)
    assert set((m * m).blades) == set(motor)
    assert m.reverse_product().blades == ("1", "e1^e2^e3^einf")
    assert m.sandwich(CGA3.blade("e0")).grades == (1,)


def test_values_are_frozen() -> None:
    given = np.ones(3)
    x = EGA3.multivector({"e1": given})
    given[0] = 5.0
    assert x.coefficient("e1")[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        x.coefficient("e1")[0] = 2.0
    for made in (-x, x * x, x + x, x | x, x.dual(), EGA3.multivector({"e3^e1": given})):
        assert not any(value.flags.writeable for value in made.values)
    assert given.flags.writeable
    with pytest.raises(AttributeError, match="frozen"):
        x.values = ()  # type: ignore[misc]
    with pytest.raises(AttributeError, match="frozen"):
        del x.masks


def test_algebras_and_multivectors_travel_between_processes() -> None:
    assert pickle.loads(pickle.dumps(CGA3)) == CGA3
    assert hash(pickle.loads(pickle.dumps(CGA3))) == hash(CGA3)
    x = pickle.loads(pickle.dumps(CGA3.blade("e1^einf")))
    assert dict((x + CGA3.blade("e1^einf")).items()) == {"e1^einf": 2.0}


def test_same_signature_with_other_names_is_another_algebra() -> None:
    assert Algebra(3) == EGA3
    assert Algebra(3, names=("x", "y", "z")) != EGA3
    assert Algebra(4, 1) != CGA3
    assert CGA3.orthogonal == Algebra(4, 1, names=("e1", "e2", "e3", "ep", "em"))
    assert EGA3 != "EGA3"


def test_written_out() -> None:
    assert repr(EGA3.multivector({"e1": 2.0, "1": 1.0})) == "1 + 2*e1"
    assert repr(EGA3.multivector({})) == "0"
    assert repr(CGA3) == "Algebra(4, 1, 0)[e1 e2 e3 e0 einf]"
    assert dict(EGA3.vector([1.0, 2.0, 3.0]).items()) == {"e1": 1.0, "e2": 2.0, "e3": 3.0}


def test_import_brings_numpy_only_and_tabulates_nothing() -> None:
    script = (
        "import sys, motorcade.ga.algebra.conformal, motorcade.ga as ga\n"
        "heavy = {'casadi', 'torch', 'scipy', 'clifford', 'mpmath', 'cv2'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "assert not ga.CGA3._plans and not ga.CGA3.basis._products\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


SEVERAL_PAIRS = Algebra.of(
    dict.fromkeys(["i1", "x", "o2", "y", "o1", "z", "i2"], 0) | {"x": 1, "y": -1},
    [("o1", "i1"), ("o2", "i2")],
)


@given(data=st.data())
def test_several_null_pairs_are_their_orthogonal_basis(data: st.DataObject) -> None:
    """In any order of the basis, products are those of the vectors ep and em of each pair."""
    masks = st.dictionaries(st.integers(0, 127), st.integers(-5, 5), max_size=6)
    a, b = (
        SEVERAL_PAIRS.multivector({SEVERAL_PAIRS.blade_name(m): v for m, v in drawn.items()})
        for drawn in (data.draw(masks), data.draw(masks))
    )
    there, back = a.as_orthogonal(), b.as_orthogonal()
    for found, expected in [
        (a * b, there * back),
        (a ^ b, there ^ back),
        (a | b, there | back),
        (a.left_contraction(b), there.left_contraction(back)),
        (a.right_contraction(b), there.right_contraction(back)),
    ]:
        assert found.as_orthogonal().isclose(expected, atol=0)
        assert found.isclose(expected.from_orthogonal(SEVERAL_PAIRS), atol=0)


def test_contractions_are_adjoint_to_the_outer_product() -> None:
    """``⟨(a ∧ b) c⟩₀ = ⟨a (b ⌋ c)⟩₀``: Dorst, Fontijne and Mann, "Geometric Algebra", 3.2."""
    rng = np.random.default_rng(5)
    for algebra in (CGA3, PGA3, SEVERAL_PAIRS):
        names = algebra.blades
        chosen = rng.integers(0, len(names), (3, 9)).tolist()
        a, b, c = (
            algebra.multivector({names[k]: int(rng.integers(-4, 5)) for k in row}) for row in chosen
        )
        assert ((a ^ b) * c).scalar_part() == (a * b.left_contraction(c)).scalar_part()
        assert (~a.left_contraction(b)).isclose((~b).right_contraction(~a), atol=0)


def test_vectors_of_other_names_are_sums_of_basis_vectors() -> None:
    algebra = Algebra.of({"o": 0, "i": 0}, [("o", "i")], {"p": {"i": 0.5, "o": -1.0}})
    assert algebra.named == ("p",)
    assert (algebra.blade("p") ** 2)["1"] == 1.0
    assert algebra.blade("p^o").isclose(algebra.multivector({"o^i": -0.5}))
    assert pickle.loads(pickle.dumps(algebra)) == algebra
