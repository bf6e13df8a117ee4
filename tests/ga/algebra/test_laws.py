"""Laws of geometric algebra, on ten signatures, exactly: coefficients are whole numbers."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motorcade.ga.algebra import CGA3, Algebra, Multivector

Draw = Callable[..., Multivector]
Same = Callable[[Multivector, Multivector], None]
Close = Callable[..., None]

law = settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@law
@given(data=st.data())
def test_geometric_and_outer_product_are_associative(
    data: st.DataObject, draw: Draw, same: Same
) -> None:
    a, b, c = draw(data), draw(data), draw(data)
    same((a * b) * c, a * (b * c))
    same((a ^ b) ^ c, a ^ (b ^ c))


@law
@given(data=st.data())
def test_products_distribute_over_sums(data: st.DataObject, draw: Draw, same: Same) -> None:
    a, b, c = draw(data), draw(data), draw(data)
    same(a * (b + c), a * b + a * c)
    same((b - c) * a, b * a - c * a)
    same(a ^ (b + c), (a ^ b) + (a ^ c))
    same(a | (b - c), (a | b) - (a | c))
    same((2 * a) * b, 2 * (a * b))


@law
@given(data=st.data())
def test_reverse_turns_products_round(data: st.DataObject, draw: Draw, same: Same) -> None:
    a, b = draw(data), draw(data)
    same(~(a * b), ~b * ~a)
    same(~(a ^ b), ~b ^ ~a)
    same((a * b).involute(), a.involute() * b.involute())
    same((a * b).conjugate(), b.conjugate() * a.conjugate())
    same(a.conjugate(), ~a.involute())
    same(~~a, a)


@law
@given(data=st.data())
def test_grades_add_up_and_project(
    data: st.DataObject, algebra: Algebra, draw: Draw, same: Same
) -> None:
    a = draw(data)
    parts = [a.grade(k) for k in range(algebra.dimension + 1)]
    same(sum(parts[1:], parts[0]), a)
    for k, part in enumerate(parts):
        assert part.grades in ((), (k,))
        same(part.grade(k), part)
    same(a.grade(0, 2), a.grade(0) + a.grade(2))


@law
@given(data=st.data())
def test_product_of_vectors_is_inner_and_outer(data: st.DataObject, draw: Draw, same: Same) -> None:
    a, b = draw(data, grade=1), draw(data, grade=1)
    same(a * b, (a | b) + (a ^ b))
    same(a | b, b | a)
    same(a ^ b, -(b ^ a))
    same((a ^ b) + (a ^ a), a ^ b)


@law
@given(data=st.data(), r=st.integers(0, 5), s=st.integers(0, 5))
def test_inner_and_outer_are_grades_of_the_product(
    data: st.DataObject, r: int, s: int, algebra: Algebra, draw: Draw, same: Same
) -> None:
    r, s = min(r, algebra.dimension), min(s, algebra.dimension)
    a, b = draw(data, grade=r), draw(data, grade=s)
    same(a ^ b, (a * b).grade(r + s))
    same(a | b, (a * b).grade(abs(r - s)) if r and s else algebra.multivector({}))


@law
@given(data=st.data())
def test_commutators_are_half_differences_and_obey_jacobi(
    data: st.DataObject, algebra: Algebra, draw: Draw, same: Same
) -> None:
    a, b = draw(data), draw(data)
    same(2 * a.commutator(b), a * b - b * a)
    if algebra.dimension >= 2:
        p, q, r = (draw(data, grade=2) for _ in range(3))
        around = p.commutator(q.commutator(r)) + q.commutator(r.commutator(p))
        same(around, -r.commutator(p.commutator(q)))
        assert p.commutator(q).grades in ((), (2,))


@law
@given(data=st.data())
def test_symmetric_products_drop_only_what_cancels(
    data: st.DataObject, draw: Draw, same: Same
) -> None:
    a = draw(data)
    same(a.square(), a * a)
    same(a.reverse_product(), a * ~a)
    assert set(a.reverse_product().blades) <= set((a * ~a).blades)
    assert set(a.reverse_product().grades) <= {0, 1, 4, 5}


@law
@given(data=st.data())
def test_dual_and_complement_have_mirrors(
    data: st.DataObject, algebra: Algebra, draw: Draw, same: Same
) -> None:
    a, b = draw(data), draw(data)
    same(a.complement().uncomplement(), a)
    same(a.uncomplement().complement(), a)
    same((a & b).complement(), a.complement() ^ b.complement())
    if algebra.signature[2] == 0:
        same(a.dual().undual(), a)
        same(a.dual() * algebra.pseudoscalar, a)
        same(a.undual(), a * algebra.pseudoscalar)


def test_blade_and_complement_span_everything(algebra: Algebra, same: Same) -> None:
    for name in algebra.blades:
        blade = algebra.blade(name)
        same(blade ^ blade.complement(), algebra.pseudoscalar)
        same(blade.uncomplement() ^ blade, algebra.pseudoscalar)


@law
@given(data=st.data(), count=st.integers(1, 4))
def test_sandwich_by_a_versor_keeps_grades(
    data: st.DataObject, count: int, algebra: Algebra, draw: Draw, same: Same
) -> None:
    versor = algebra.scalar(1)
    for _ in range(count):
        versor = versor * draw(data, grade=1)
    for k in range(algebra.dimension + 1):
        x = draw(data, grade=k)
        same(versor.sandwich(x), versor * x * ~versor)
        same((versor * x * ~versor).grade(k), versor * x * ~versor)


@law
@given(data=st.data())
def test_orthogonal_basis_multiplies_alike(
    data: st.DataObject, algebra: Algebra, draw: Draw, same: Same
) -> None:
    a, b = draw(data), draw(data)
    same(a.as_orthogonal().from_orthogonal(algebra), a)
    same((a * b).as_orthogonal(), a.as_orthogonal() * b.as_orthogonal())
    same((a ^ b).as_orthogonal(), a.as_orthogonal() ^ b.as_orthogonal())
    same((a | b).as_orthogonal(), a.as_orthogonal() | b.as_orthogonal())
    same(a.grade(2).as_orthogonal(), a.as_orthogonal().grade(2))


@law
@given(data=st.data())
def test_norm_squared_is_the_scalar_of_x_reverse_x(data: st.DataObject, draw: Draw) -> None:
    a = draw(data)
    assert a.norm_squared() == (a * ~a).coefficient("1")
    assert a.norm() == pytest.approx(np.sqrt(abs(a.norm_squared())))


def invertible(algebra: Algebra, rng: np.random.Generator, shape: tuple[int, ...]) -> Multivector:
    noise = {name: rng.uniform(-0.2, 0.2, shape) for name in algebra.blades}
    return algebra.multivector(noise) + 1.5


def test_general_inverses_on_both_sides(
    algebra: Algebra, rng: np.random.Generator, close: Close
) -> None:
    x = invertible(algebra, rng, (7,))
    one = algebra.scalar(np.ones(7))
    close(x * x.inverse(), one)
    close(x.inverse() * x, one)
    close(x / x, one)
    close(1.0 / x, x.inverse())


def test_inverses_of_versors_and_blades_keep_their_blades(
    algebra: Algebra, rng: np.random.Generator, close: Close
) -> None:
    if algebra.signature[0] + algebra.signature[1] == 0:
        pytest.skip("all vectors are null")
    plain = [n for n in algebra.orthogonal.names if algebra.blade(n).norm_squared() != 0]
    vector = algebra.multivector({n: 1.0 + k for k, n in enumerate(plain)})
    close(vector * vector.inverse(), algebra.scalar(1.0))
    assert vector.inverse().blades == vector.blades
    blade = algebra.blade("^".join(plain))
    close(blade * blade.inverse(), algebra.scalar(1.0))


def test_even_elements_of_conformal_space_are_inverted_without_the_general_formula(
    rng: np.random.Generator, close: Close
) -> None:
    x = invertible(CGA3, rng, (5,)).grade(0, 2, 4)
    assert set(x.inverse().grades) == {0, 2, 4}
    close(x * x.inverse(), CGA3.scalar(np.ones(5)), 1e-14)


def test_what_has_no_scalar_in_its_size_is_inverted_all_the_same() -> None:
    """``x ~x`` is of grade 4 alone, and the square of that is a number."""
    x = CGA3.multivector({"e1^einf": 2.0, "e2^e0": 1.0})
    assert x.reverse_product().grades == (4,)
    rest = x * x.inverse() - 1.0
    assert max(abs(v) for v in rest.values) < 1e-15
