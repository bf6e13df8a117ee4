"""Whatever the algebra cannot compute is refused, with a message that says what was expected."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra
from motorcade.ga.algebra import conformal as cga

ORIGIN, X, Y, Z = np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, 1.0])


def refused(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Algebra(17), "1 to 16 basis vectors, got 17"),
        (lambda: Algebra(0), "1 to 16 basis vectors, got 0"),
        (lambda: Algebra(3, -1), r"Algebra\.q: expected a whole number"),
        (lambda: Algebra(2.0), r"Algebra\.p"),  # type: ignore[arg-type]
        (lambda: Algebra(True), r"Algebra\.p"),
        (lambda: Algebra(3, names=("x", "y")), "3 distinct names"),
        (lambda: Algebra(2, names=("x", "x")), "2 distinct names"),
        (lambda: Algebra(2, names=("x", "y^z")), "identifiers"),
        (lambda: Algebra(2, 0, 1, null_pair=True), r"\(p, 1, 0\)"),
        (lambda: Algebra(1, 1, names=("ep", "em"), null_pair=True), "no ep or em"),
    ],
)
def test_signatures(call: Callable[[], Any], message: str) -> None:
    refused(call, message)


@pytest.mark.parametrize("name", ["e4", "", "e1^", "e1 e2", "e12", "^", "E1", "e1^ep", "1^e1"])
def test_unknown_blades(name: str) -> None:
    refused(lambda: EGA3.blade(name), "a blade of e1 e2 e3")


def test_blades_that_are_zero_or_several() -> None:
    refused(lambda: EGA3.blade("e1^e1"), "not zero")
    refused(lambda: EGA3.blade(3), "name of a blade")  # type: ignore[arg-type]
    refused(lambda: CGA3.blade("e0").coefficient("ep"), "as_orthogonal")
    refused(lambda: CGA3.blade("e0").coefficient("ep^e0"), "as_orthogonal")
    refused(lambda: EGA3.vector([1.0, 2.0]), "expected 3, got 2")


@pytest.mark.parametrize(
    "value",
    [
        np.nan,
        np.inf,
        np.array([1.0, np.nan]),
        "1",
        None,
        True,
        1j,
        np.array([1j]),
        [1.0],
        np.array(["a"]),
        np.array([True]),
        EGA3.blade("e1"),
    ],
)
def test_coefficients_that_are_no_real_numbers(value: Any) -> None:
    refused(lambda: EGA3.multivector({"e1": value}), "coefficient of e1: expected")


def test_mixed_algebras() -> None:
    a, b = EGA3.blade("e1"), PGA3.blade("e1")
    for call in (
        lambda: a * b,
        lambda: a + b,
        lambda: a - b,
        lambda: a ^ b,
        lambda: a | b,
        lambda: a & b,
        lambda: a.sandwich(b),
        lambda: a.commutator(b),
        lambda: a / b,
        lambda: a.from_orthogonal(CGA3),
    ):
        refused(call, "of one algebra|expected a multivector of")


def test_tests_that_would_always_go_one_way() -> None:
    x = CGA3.scalar(0.0)
    assert x in [x]
    with pytest.raises(TypeError, match="no truth value: test its coefficients"):
        bool(x)
    for other in (0.0, None, CGA3.scalar(0.0), x):
        with pytest.raises(TypeError, match="isclose compares numbers"):
            assert x != other


def test_batches_that_do_not_broadcast() -> None:
    a = EGA3.multivector({"e1": np.ones(2)})
    refused(lambda: a * EGA3.multivector({"e1": np.ones(3)}), "broadcast")


@pytest.mark.parametrize(
    "x",
    [
        EGA3.scalar(1.0) + EGA3.blade("e1"),
        EGA3.multivector({}),
        EGA3.scalar(np.array([1.0, 0.0])),
        CGA3.blade("einf"),
        cga.point([0.1, 0.3, 0.7]),
        CGA3.scalar(1.0) + CGA3.blade("e0^einf"),
        PGA3.blade("e1^e0"),
        Algebra(2, 3).scalar(2.0) + 2.0 * Algebra(2, 3).blade("e1^e2^e3"),
    ],
    ids=str,
)
def test_elements_without_an_inverse(x: Any) -> None:
    refused(x.inverse, "invertible")
    refused(lambda: 1.0 / x, "invertible")


def test_products_with_a_zero_divisor_have_no_inverse(rng: np.random.Generator) -> None:
    for algebra in (CGA3, Algebra(2, 3), Algebra(3, 3)):
        half = 0.5 * (algebra.scalar(1.0) + algebra.blade("e1"))
        noise = algebra.multivector({n: rng.standard_normal() for n in algebra.blades})
        refused((noise * half).inverse, "invertible")


def test_far_translations_are_not_mistaken_for_zero_divisors() -> None:
    far = CGA3.scalar(1.0) + 1e12 * CGA3.blade("e1^einf")
    assert far.inverse().coefficient("e1^einf") == -1e12


def test_division_by_zero_and_by_symbolic_zero() -> None:
    refused(lambda: EGA3.blade("e1") / 0.0, "not zero")
    refused(lambda: EGA3.blade("e1") / np.array([1.0, 0.0]), "not zero")
    ca = pytest.importorskip("casadi")
    refused(lambda: EGA3.scalar(ca.SX(0)).inverse(), "invertible")


def test_dual_without_a_pseudoscalar_inverse() -> None:
    refused(PGA3.blade("e1").dual, "complement")
    refused(PGA3.blade("e1").undual, "complement")


LINE, PLANE = cga.line(ORIGIN, Z), cga.plane(Z, 1.0)
SPHERE, CIRCLE = cga.sphere(X, 2.0), cga.circle(X, Z, 2.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cga.point([1.0, 2.0]), r"point\(position\): expected shape \(\*, 3\)"),
        (lambda: cga.point([1.0, 2.0, np.nan]), "finite"),
        (lambda: cga.sphere(X, -1.0), ">= 0"),
        (lambda: cga.circle(X, Z, [1.0, -1.0]), ">= 0"),
        (lambda: cga.plane(2.0 * X, 1.0), "unit vector"),
        (lambda: cga.line(X, ORIGIN), "unit vector"),
        (lambda: cga.point_pair(X, X), "two points apart"),
        (lambda: cga.line_through(X, X), "two points apart"),
        (lambda: cga.circle_through(ORIGIN, X, 2.0 * X), "on no line"),
        (lambda: cga.plane_through(ORIGIN, X, 3.0 * X), "on no line"),
        (lambda: cga.plane_through(X, X, Y), "on no line"),
        (lambda: cga.sphere_through(ORIGIN, X, Y, X + Y), "on no plane"),
        (lambda: cga.meet(EGA3.blade("e1"), PLANE), "multivectors of Algebra"),
        (lambda: cga.meet(PLANE + 1.0, PLANE), "one grade"),
        (lambda: cga.meet(CGA3.scalar(1.0), PLANE), "one grade"),
        (lambda: cga.meet(PLANE, CGA3.pseudoscalar), "one grade"),
        (lambda: cga.join(LINE, LINE), "expected points"),
        (lambda: cga.coordinates(SPHERE), "expected a point"),
        (lambda: cga.coordinates(cga.infinity()), "1 that are none"),
        (lambda: cga.center(PLANE), "sphere, circle or point pair"),
        (lambda: cga.center(LINE), "sphere, circle or point pair"),
        (lambda: cga.center(cga.meet(LINE, PLANE)), "sphere, circle or point pair"),
        (lambda: cga.radius(PLANE), "sphere, circle or point pair"),
        (lambda: cga.radius_squared(LINE), "sphere, circle or point pair"),
        (lambda: cga.normal(SPHERE), "expected a plane"),
        (lambda: cga.normal(LINE), "expected a plane or circle"),
        (lambda: cga.normal(cga.point_pair(X, Y)), "grade 1 or 2"),
        (lambda: cga.plane_distance(cga.point(X)), "expected a plane"),
        (lambda: cga.direction(CIRCLE), "expected a line"),
        (lambda: cga.direction(PLANE), "grade 2 or 3"),
        (lambda: cga.two_points(CIRCLE), "grade 3"),
        (lambda: cga.two_points(cga.meet(cga.line(4.0 * X, Z), SPHERE)), "does not touch"),
        (lambda: cga.flat_position(cga.meet(cga.line(X, X), PLANE)), "not parallel"),
        (lambda: cga.flat_position(cga.point_pair(X, Y)), "a flat point"),
        (lambda: cga.direction(cga.meet(PLANE, cga.plane(Z, 2.0))), "a line or point pair"),
        (lambda: cga.center(EGA3.blade("e1")), "multivector of Algebra"),
    ],
)
def test_degenerate_objects(call: Callable[[], Any], message: str) -> None:
    refused(call, message)


@pytest.mark.parametrize("sizes", list(itertools.permutations((1e-9, 1.0, 1e9))))
def test_edges_of_any_length_span_where_none_is_along_the_others(
    sizes: tuple[float, float, float],
) -> None:
    a, b, c = (size * edge for size, edge in zip(sizes, (X, Y, Z), strict=True))
    cga.sphere_through(ORIGIN, a, b, c)
    cga.plane_through(ORIGIN, a, b)
    cga.circle_through(ORIGIN, b, c)
    refused(lambda: cga.sphere_through(ORIGIN, a, b, a + b), "on no plane")
    refused(lambda: cga.plane_through(ORIGIN, c, 2.0 * c), "on no line")


def test_one_degenerate_row_refuses_the_batch() -> None:
    ends = np.stack([Y, X])
    refused(lambda: cga.line_through(np.stack([X, X]), ends), "got 1 sets")
    spheres = cga.sphere(np.stack([X, 9.0 * X]), 2.0)
    refused(lambda: cga.two_points(cga.meet(LINE, spheres)), "got 1 with a negative")
