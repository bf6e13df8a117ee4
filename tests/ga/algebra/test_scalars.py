"""One algebra over every kind of scalar: floats, NumPy batches, fractions, CasADi SX, torch."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.algebra import conformal as cga

Close = Callable[..., None]

MOTOR = ("1", "e1^e2", "e1^e3", "e2^e3", "e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf")
OPERATIONS: dict[str, Callable[[Multivector, Multivector], Multivector]] = {
    "geometric": lambda a, b: a * b,
    "outer": lambda a, b: a ^ b,
    "inner": lambda a, b: a | b,
    "regressive": lambda a, b: a & b,
    "commutator": lambda a, b: a.commutator(b),
    "sum": lambda a, b: a + 2.0 * b - 0.5,
    "sandwich": lambda a, b: a.sandwich(b),
    "dual": lambda a, b: a.dual() + b.undual(),
    "inverse": lambda a, b: (a + 4.0).inverse() * b / 3.0,
    "even inverse": lambda a, b: (a.grade(0, 2) + 4.0).inverse() + b,
    "norm": lambda a, b: b * a.norm() + a.reverse_product() + b.square(),
}


@pytest.fixture(params=OPERATIONS)
def operation(request: pytest.FixtureRequest) -> Callable[[Multivector, Multivector], Multivector]:
    return OPERATIONS[request.param]


def draw(algebra: Algebra, rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Any:
    return {name: rng.uniform(-1, 1, shape) for name in algebra.blades}


@pytest.mark.parametrize("algebra", [EGA3, CGA3], ids=["EGA3", "CGA3"])
def test_batches_are_their_rows(algebra: Algebra, operation: Any, rng: np.random.Generator) -> None:
    a, b = draw(algebra, rng, (5,)), draw(algebra, rng, (3, 1))
    whole = operation(algebra.multivector(a), algebra.multivector(b))
    for i, j in np.ndindex(3, 5):
        one = operation(
            algebra.multivector({name: float(v[j]) for name, v in a.items()}),
            algebra.multivector({name: float(v[i, 0]) for name, v in b.items()}),
        )
        assert one.blades == whole.blades
        for name, value in one.items():
            batch = np.broadcast_to(whole.coefficient(name), (3, 5))
            np.testing.assert_allclose(batch[i, j], value, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("algebra", [EGA3, CGA3], ids=["EGA3", "CGA3"])
def test_casadi_symbols_evaluate_to_the_numbers(
    algebra: Algebra, operation: Any, rng: np.random.Generator, close: Close
) -> None:
    ca = pytest.importorskip("casadi")
    symbols = [ca.SX.sym(name) for name in 2 * algebra.blades]
    count = len(algebra.blades)
    a, b = (
        algebra.multivector(dict(zip(algebra.blades, part, strict=True)))
        for part in (symbols[:count], symbols[count:])
    )
    made = operation(a, b)
    function = ca.Function("made", symbols, [ca.SX(value) for value in made.values])
    x, y = draw(algebra, rng), draw(algebra, rng)
    values = function(*x.values(), *y.values())
    found = dict(zip(made.blades, map(float, values), strict=True))
    expected = operation(algebra.multivector(x), algebra.multivector(y))
    assert made.blades == expected.blades
    close(algebra.multivector(found), expected, 1e-11)


def test_casadi_scalars_multiply_from_both_sides() -> None:
    ca = pytest.importorskip("casadi")
    s = ca.SX.sym("s")
    for made in (s * EGA3.blade("e1"), EGA3.blade("e1") * s):
        assert made.blades == ("e1",)
        assert made.coefficient("e1").is_symbolic() or made.coefficient("e1").n_dep() == 2


def test_casadi_objects_evaluate_to_the_numbers() -> None:
    ca = pytest.importorskip("casadi")
    a, b, c = (ca.SX.sym(name, 3) for name in "abc")
    circle = cga.circle_through(a, b, c)
    outputs = [*cga.center(circle), cga.radius(circle), *cga.normal(circle)]
    given = np.array([[1.0, 2.0, 3.0], [0.5, -1.0, 2.0], [4.0, 0.0, 1.0]])
    found = np.array(ca.Function("circle", [a, b, c], [ca.vertcat(*outputs)])(*given)).ravel()
    numbers = cga.circle_through(*given)
    expected = [*cga.center(numbers), cga.radius(numbers), *cga.normal(numbers)]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_casadi_columns_of_another_length_are_refused() -> None:
    ca = pytest.importorskip("casadi")
    with pytest.raises(ValueError, match=r"point\(position\): expected shape"):
        cga.point(ca.SX.sym("x", 2))


def test_torch_objects_are_the_numbers_and_differentiate(rng: np.random.Generator) -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    given = rng.standard_normal((3, 5, 3))
    corners = torch.tensor(given, requires_grad=True)
    radius = cga.radius(cga.circle_through(*corners))
    expected = cga.radius(cga.circle_through(*given))
    np.testing.assert_allclose(radius.detach().numpy(), expected, rtol=1e-12)
    radius.sum().backward()
    assert torch.isfinite(corners.grad).all()
    with pytest.raises(ValueError, match=r"expected shape \(\*, 3\)"):
        cga.point(corners[..., :2])


def test_torch_tensors_compute_and_differentiate(
    operation: Any, rng: np.random.Generator, close: Close
) -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    a, b = draw(EGA3, rng, (5,)), draw(EGA3, rng, (3, 1))
    tensors = [
        EGA3.multivector({n: torch.tensor(v, requires_grad=True) for n, v in part.items()})
        for part in (a, b)
    ]
    made = operation(*tensors)
    expected = operation(EGA3.multivector(a), EGA3.multivector(b))
    assert made.blades == expected.blades
    for name, value in made.items():
        np.testing.assert_allclose(
            value.detach().numpy(), expected.coefficient(name), rtol=1e-11, atol=1e-11
        )
    sum(value.sum() for value in made.values).backward()
    assert torch.isfinite(tensors[1].values[1].grad).all()


def test_fractions_stay_exact() -> None:
    x = PGA3.multivector({name: Fraction(k + 1, 7) for k, name in enumerate(PGA3.blades)})
    square = x * x
    assert all(isinstance(value, Fraction) for value in square.values)
    assert square.coefficient("1") == sum(
        sign * Fraction(k, 7) ** 2 for k, sign in ((1, 1), (2, 1), (3, 1), (4, 1))
    ) + sum(-(x.coefficient(n) ** 2) for n in ("e1^e2", "e1^e3", "e2^e3", "e1^e2^e3"))


def test_single_precision_stays_single(rng: np.random.Generator) -> None:
    m = CGA3.multivector({n: rng.uniform(-1, 1, 4).astype(np.float32) for n in MOTOR})
    for made in (m * m, m.sandwich(m), m.inverse(), m.dual(), m / 2.0, m.norm() * m):
        assert {value.dtype for value in made.values} == {np.dtype(np.float32)}


def test_batches_multiply_from_both_sides() -> None:
    batch = np.array([1.0, 2.0, 3.0])
    for made in (batch * EGA3.blade("e1"), EGA3.blade("e1") * batch):
        np.testing.assert_array_equal(made.coefficient("e1"), batch)


def test_whole_numbers_become_floats_in_arrays() -> None:
    assert EGA3.multivector({"e1": np.array([1, 2])}).coefficient("e1").dtype == np.float64


def test_fractions_that_are_zero_do_not_divide() -> None:
    x = EGA3.multivector({"e1": Fraction(1, 3)})
    with pytest.raises(ValueError, match="divisor: expected a number that is not zero"):
        x / Fraction(0)
    assert (x / Fraction(2)).coefficient("e1") == Fraction(1, 6)


def test_fractions_stay_exact_where_terms_come_twice() -> None:
    x = Algebra(4).multivector({"e1^e2": Fraction(1, 3), "e3^e4": Fraction(1, 7)})
    assert x.square().coefficient("e1^e2^e3^e4") == Fraction(2, 21)
    assert x.square().scalar_part() == -Fraction(1, 9) - Fraction(1, 49)
