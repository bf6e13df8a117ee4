"""Exponentials, logarithms and roots: laws near 0, near π, null and hyperbolic, and witnesses."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.algebra.exponential import exp
from motorcade.ga.algebra.logarithm import log, normalize, sqrt, versor
from motorcade.ga.algebra.scalars import apply, sign, step, where
from tests.ga.cases import over

Generator = np.random.Generator
SMALL = Algebra(1, 1)
ALGEBRAS = {
    "EGA3": EGA3,
    "PGA3": PGA3,
    "CGA3": CGA3,
    "CGA2": Algebra(3, 1, null_pair=True),
    "Cl(4,0)": Algebra(4),
    "Cl(5,0)": Algebra(5),
    "Cl(2,2)": Algebra(2, 2),
    "Cl(1,3)": Algebra(1, 3),
    "Cl(3,2)": Algebra(3, 2),
    "Cl(2,0,2)": Algebra(2, 0, 2),
    "Cl(1,1,3)": Algebra(1, 1, 3),
}


@pytest.fixture(params=ALGEBRAS)
def algebra(request: pytest.FixtureRequest) -> Algebra:
    return ALGEBRAS[request.param]


def of_grades(algebra: Algebra, grades: set[int], rng: Generator, size: float) -> Multivector:
    names = [name for name in algebra.blades if set(algebra.blade(name).grades) <= grades]
    return algebra.multivector({name: float(rng.normal(scale=size)) for name in names})


def left_matrix(x: Multivector) -> np.ndarray[Any, Any]:
    """Multiplication from the left, made by sorting words of orthogonal vectors."""
    orthogonal = x.as_orthogonal()
    p, q, r = x.algebra.signature
    squares = [1] * p + [-1] * q + [0] * r
    count = len(squares)
    made = np.zeros((2**count, 2**count))
    for mask, value in zip(orthogonal.masks, orthogonal.values, strict=True):
        for other in range(2**count):
            swaps = sum((mask >> k & 1) * (other & (1 << k) - 1).bit_count() for k in range(count))
            sign = (-1) ** swaps
            for k in range(count):
                if mask & other & 1 << k:
                    sign *= squares[k]
            made[mask ^ other, other] += sign * value
    return made


def column(x: Multivector) -> np.ndarray[Any, Any]:
    made = np.zeros(2**x.algebra.dimension)
    orthogonal = x.as_orthogonal()
    made[list(orthogonal.masks)] = orthogonal.values
    return made


def close(found: Multivector, expected: Multivector, tolerance: float = 1e-13) -> None:
    size = max(1.0, *(float(np.max(np.abs(v))) for v in expected.values))
    rest = (found - expected).values
    worst = max((float(np.max(np.abs(v))) for v in rest), default=0.0)
    assert worst <= tolerance * size, f"{worst / size:.1e}\n{found}\n{expected}"


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("size", [1e-9, 1e-4, 0.03, 0.3, 1.0, 2.5])
def test_exp_is_that_of_the_matrix_of_left_multiplication(algebra: Algebra, size: float) -> None:
    rng = np.random.default_rng(3)
    for grades in ({1}, {2}, {3}, {4}, {0, 2}, {2, 4}, set(range(6))):
        for _ in range(3):
            x = of_grades(algebra, grades, rng, size)
            expected = scipy.linalg.expm(left_matrix(x))[:, 0]
            found = column(exp(x))
            np.testing.assert_allclose(found, expected, rtol=0, atol=2e-13 * np.abs(expected).max())


def test_exp_of_small_bivectors_keeps_every_digit(algebra: Algebra) -> None:
    rng = np.random.default_rng(4)
    b = of_grades(algebra, {2}, rng, 1e-5)
    close(exp(b) - 1.0 - b, (b * b + b * b * b / 3 + b * b * b * b / 12) / 2, 3e-16)


@pytest.mark.parametrize("size", [1e-9, 1e-5, 0.01, 0.1, 0.4])
def test_log_undoes_exp_of_bivectors(algebra: Algebra, size: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        b = of_grades(algebra, {0, 2}, rng, size)
        found = log(exp(b))
        rest = max(abs(v) for v in (found - b).values)
        assert rest <= 1e-13 * max(1e-2, size), rest


@pytest.mark.parametrize("size", [1e-9, 1e-5, 0.01, 0.3, 1.0, 1.5])
def test_exp_undoes_log_of_versors(algebra: Algebra, size: float) -> None:
    """Of any angles and stretches: several turns come back to the same versor."""
    rng = np.random.default_rng(6)
    for _ in range(20):
        x = exp(of_grades(algebra, {0, 2}, rng, size))
        try:
            y = log(x)
        except ValueError:
            # A stretch beside a half turn of both planes has no real logarithm, in Cl(2,2) say.
            assert algebra.signature[1] + algebra.signature[0] > 1
            assert x.scalar_part() < 0
            continue
        size_of_terms = max(1.0, *(abs(v) for v in x.values)) ** 2
        close(exp(y), x, 1e-12 * size_of_terms)


def rotor(angle: Any, axis: Any) -> Multivector:
    u = np.asarray(axis) / np.linalg.norm(axis)
    plane = CGA3.multivector({"e2^e3": u[0], "e3^e1": u[1], "e1^e2": u[2]})
    return np.cos(angle / 2) - np.sin(angle / 2) * plane


def translator(t: Any) -> Multivector:
    return 1.0 - 0.5 * CGA3.multivector({f"e{k + 1}^einf": t[k] for k in range(3)})


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.27, 0.29, 1.0, 3.1, 4.0, 2 * np.pi - 1e-3])
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_log_of_a_multiple_adds_the_log_of_its_size(angle: float, size: float) -> None:
    """Rotors and motors, whatever their size: angles at which small ones begin are among these."""
    axis, away = [0.2, -0.5, 0.8], CGA3.multivector({"e1^einf": 0.3, "e2^einf": -0.7})
    turn = log(rotor(0.5, axis)) * (angle / 0.5)
    for bivector in (turn, turn + away):
        found = log(size * exp(bivector))
        close(found, np.log(size) + bivector, 2e-12 if angle > 6 else 1e-14)


def dilator(scale: float) -> Multivector:
    half = np.log(scale) / 2
    return np.cosh(half) + np.sinh(half) * CGA3.blade("e0^einf")


VERSORS = {
    "identity": lambda r, t, d: CGA3.scalar(1.0),
    "rotor": lambda r, t, d: r,
    "translator": lambda r, t, d: t,
    "dilator": lambda r, t, d: d,
    "motor": lambda r, t, d: t * r,
    "spiral": lambda r, t, d: r * d,
    "similarity": lambda r, t, d: t * r * d,
    "stretch": lambda r, t, d: t * d,
    "transversion": lambda r, t, d: mirrored(t * r),
    "any": lambda r, t, d: mirrored(t * r) * t * d,
}
ANGLES = [0.0, 1e-12, 1e-8, 1e-4, 0.02, 1.0, np.pi - 1e-3, np.pi, 2 * np.pi - 1e-6]


def mirrored(x: Multivector) -> Multivector:
    """Turned inside out in the unit sphere: infinity goes to the origin."""
    sphere = CGA3.multivector({"e0": 1.0, "einf": -0.5})
    return sphere * x * sphere.inverse()


@pytest.mark.parametrize("kind", VERSORS)
@over(angle=ANGLES, scale=[1.0, 1 + 1e-7, 2.0, 0.3])
def test_versors_come_back_from_log_and_from_sqrt(kind: str, angle: float, scale: float) -> None:
    if kind == "any" and angle > 6:
        pytest.skip("the angle of this one is another")
    x = VERSORS[kind](rotor(angle, (1, -2, 0.5)), translator((3.0, -1.0, 0.2)), dilator(scale))
    y = log(x)
    # A screw of nearly a whole turn is a turn about an axis far away.
    far = max(1.0, *(abs(v) for v in y.values))
    close(exp(y), x, 3e-15 * far + 1e-13)
    root = sqrt(x)
    close(root * root, x, 3e-15 * far + 1e-13)
    close(root, exp(y / 2), 3e-15 * far + 1e-13)
    close(sqrt(9.0 * x), 3.0 * root, 3e-15 * far + 1e-13)


@pytest.mark.parametrize("angle", [1e-3, 0.1, 1.0, 3.0])
def test_motors_seen_in_any_sphere_keep_their_digits(angle: float) -> None:
    """Mirrored motors turn in one plane only, but of the other one rounding leaves a trace."""
    rng = np.random.default_rng(16)
    for _ in range(20):
        c = rng.normal(size=3)
        sphere = CGA3.vector([*c, 1.0, 0.5 * (c @ c) - 2.0])
        motor = translator(rng.normal(size=3)) * rotor(angle, rng.normal(size=3))
        x = sphere * motor * sphere.inverse()
        close(exp(log(x)), x, 1e-13)


def test_log_of_a_rotor_is_its_half_angle_up_to_pi() -> None:
    axis = np.array([1.0, -2.0, 0.5])
    for angle in ANGLES:
        b = log(rotor(angle, axis))
        expected = -angle / 2 * axis / np.linalg.norm(axis)
        found = [b.coefficient(name) for name in ("e2^e3", "e3^e1", "e1^e2")]
        np.testing.assert_allclose(found, expected, rtol=2e-10, atol=0)


def test_logs_of_motors_are_those_of_the_pose_library() -> None:
    from motorcade.ga import Motor
    from motorcade.ga.algebra import conformal as cga

    rng = np.random.default_rng(7)
    motors = Motor.random(rng, (50,))
    flipped = Motor(motors.coefficients * np.sign(motors.coefficients[:, :1]))
    b = log(cga.of_versor(flipped))
    names = ("e2^e3", "e3^e1", "e1^e2", "e1^einf", "e2^einf", "e3^einf")
    found = np.stack([b.coefficient(name) for name in names], axis=-1)
    np.testing.assert_allclose(found, flipped.log(), rtol=0, atol=1e-12)
    close(exp(b), cga.of_versor(flipped), 1e-13)


@pytest.mark.slow
def test_clifford_finds_the_same_exponentials_and_logarithms() -> None:
    clifford = pytest.importorskip("clifford")
    g3c = pytest.importorskip("clifford.tools.g3c.rotor_parameterisation")
    layout = pytest.importorskip("clifford.g3c").layout
    rng = np.random.default_rng(8)

    def theirs(x: Multivector) -> Any:
        made = layout.MultiVector()
        for (name, value), mask in zip(
            x.as_orthogonal().items(), x.as_orthogonal().masks, strict=True
        ):
            assert name
            blade = layout.scalar
            for k in range(5):
                if mask >> k & 1:
                    blade = blade ^ layout.blades[f"e{k + 1}"]
            made = made + value * blade
        return made

    for _ in range(20):
        b = of_grades(CGA3, {2}, rng, 0.5)
        assert np.abs((theirs(exp(b)) - theirs(b).exp()).value).max() < 1e-9
        angle, scale = rng.uniform(0.1, 2.5), rng.uniform(0.5, 2.0)
        x = translator(rng.normal(size=3)) * rotor(angle, rng.normal(size=3)) * dilator(scale)
        found = g3c.general_logarithm(theirs(x))
        assert np.abs((theirs(log(x)) - found).value).max() < 1e-9
    assert clifford


@pytest.mark.parametrize("half", [1e-9, 1e-3, 0.5, 1.5, 3.0, 3.14159])
def test_mpmath_finds_the_same_screw(half: float) -> None:
    """The exponential of a rigid bivector in 50 digits, as a series."""
    mp = pytest.importorskip("mpmath")
    mp.mp.dps = 50
    b = CGA3.multivector(
        {"e2^e3": 0.6 * half, "e1^e2": 0.8 * half, "e1^einf": 0.7, "e2^einf": 2.0, "e3^einf": 0.25}
    )
    exact = b._with([mp.mpf(v) for v in b.values])
    total = term = CGA3.scalar(mp.mpf(1))
    for k in range(1, 60):
        term = term * exact
        term = term._with([v / k for v in term.values])
        total = total + term
    found = exp(b)
    for name, value in found.items():
        assert abs(value - float(total.coefficient(name))) < 4e-16 * 10
    back = log(found)
    for name, value in b.items():
        assert abs(back.coefficient(name) - value) < 4e-15 / min(1.0, np.sin(half) ** 2 / half**2)


def test_simple_elements_of_every_kind() -> None:
    e1, e12, e0 = EGA3.blade("e1"), EGA3.blade("e1^e2"), PGA3.blade("e0")
    close(exp(0.7 * e1), np.cosh(0.7) + np.sinh(0.7) * e1)
    close(exp(0.7 * e12 + 2.0), np.exp(2.0) * (np.cos(0.7) + np.sin(0.7) * e12))
    close(exp(0.7 * e0), 1.0 + 0.7 * e0)
    close(log(np.cosh(0.7) + np.sinh(0.7) * e1), 0.7 * e1)
    close(log(3.0 + 0.6 * e0), np.log(3.0) + 0.2 * e0)
    close(log(e12), np.pi / 2 * e12)
    close(sqrt(e12), (1.0 + e12) / np.sqrt(2))
    close(sqrt(4.0 + 4.0 * e1), np.sqrt(2) * (1.0 + e1))
    close(sqrt(EGA3.scalar(9.0)), EGA3.scalar(3.0))
    close(exp(EGA3.multivector({})), EGA3.scalar(1.0))


REFUSED = {
    "log of zero": lambda: log(EGA3.multivector({})),
    "log of a negative scalar": lambda: log(EGA3.scalar(-1.0)),
    "log of one of a batch": lambda: log(EGA3.scalar(np.array([1.0, -1.0]))),
    "log of a projector": lambda: log(EGA3.multivector({"1": 1.0, "e1": 1.0})),
    "log of a reflection": lambda: log(EGA3.blade("e1")),
    "log of a half turn in no plane": lambda: log(EGA3.multivector({"1": -1.0, "e1^e2": 0.0})),
    "log of a half turn in a rounding": lambda: log(EGA3.multivector({"1": -1, "e1^e2": 1e-17})),
    "log of a negated translator": lambda: log(-translator((1.0, 2.0, 3.0))),
    "log of a negated boost": lambda: log(-dilator(2.0)),
    "log of a negated turned boost": lambda: log(-dilator(2.0) * rotor(0.0, (0, 0, 1))),
    "log of no versor": lambda: log(CGA3.multivector({"1": 1.0, "e1^e2": 1, "e3^e0": 1})),
    "log of mixed grades": lambda: log(CGA3.multivector({"1": 1.0, "e1": 1, "e2^e3": 1})),
    "log in six dimensions": lambda: log(Algebra(6).multivector({"1": 1, "e1^e2": 1, "e3^e4": 1})),
    "sqrt of a negative scalar": lambda: sqrt(EGA3.scalar(-1.0)),
    "sqrt of a vector": lambda: sqrt(EGA3.blade("e1")),
    "sqrt of a negated translator": lambda: sqrt(-translator((1.0, 2.0, 3.0))),
    "sqrt of no versor": lambda: sqrt(CGA3.multivector({"1": 1.0, "e1^e2": 1, "e3^e0": 1})),
    "normalize of a null vector": lambda: normalize(CGA3.blade("e0")),
    "versor of nothing": lambda: versor(CGA3.blade("e1^e2^e3^einf")),
    "versor of all grades": lambda: versor(of_grades(CGA3, set(range(6)), RNG, 1.0)),
    "exp of symbols of all grades": lambda: exp(symbolic(Algebra(3, 3))),
    "exp of what is too large": lambda: exp(1e7 * of_grades(Algebra(6), {2}, RNG, 1.0)),
}
RNG = np.random.default_rng(1)


def symbolic(algebra: Algebra) -> Multivector:
    ca = pytest.importorskip("casadi")
    return algebra.multivector({name: ca.SX.sym(f"x{k}") for k, name in enumerate(algebra.blades)})


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_value_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=name.split()[0]):
        REFUSED[name]()


@pytest.mark.parametrize("kind", VERSORS)
def test_the_versor_near_a_blend_is_unit_and_keeps_versors(kind: str) -> None:
    rng = np.random.default_rng(9)
    x, y = (
        VERSORS[kind](rotor(a, (1, 2, 3)), translator(rng.normal(size=3)), dilator(s))
        for a, s in ((0.4, 1.5), (1.0, 0.8))
    )
    close(versor(7.0 * x), x, 1e-12)
    near = versor(0.3 * x + 0.7 * y)
    close(near * ~near, CGA3.scalar(1.0), 1e-12)
    point = near * CGA3.vector([0.3, -1.0, 2.0, 1.0, 0.5 * 5.09]) * ~near
    close(point, point.grade(1), 1e-11)


def test_a_disturbed_versor_comes_back_to_first_order() -> None:
    """What commutes with a versor and keeps its reverse product is taken away wholly."""
    x = translator((1.0, 2.0, 3.0)) * rotor(1.0, (1, 0, 1)) * dilator(1.4)
    disturbed = x * CGA3.multivector({"1": 1.2, "e1^e2^e3^einf": 0.3, "e1^e2^e3^e0": -0.2})
    found = versor(disturbed)
    close(found * ~found, CGA3.scalar(1.0), 1e-13)


def test_normalize_divides_by_the_size() -> None:
    x = CGA3.multivector({"1": 3.0, "e1^e2": 4.0})
    close(normalize(x), x / 5.0)
    batch = CGA3.multivector({"e1": np.array([3.0, -6.0]), "e2": np.array([4.0, 8.0])})
    np.testing.assert_allclose(normalize(batch).norm(), 1.0, rtol=1e-15)


@pytest.mark.parametrize("function", [log, sqrt, versor], ids=lambda f: f.__name__)
def test_what_rounding_left_beside_a_versor_is_dropped(
    function: Callable[[Multivector], Multivector],
) -> None:
    x = translator((1.0, 2.0, 3.0)) * rotor(0.7, (1, 2, 3)) * dilator(1.2)
    perturbed = x + CGA3.multivector({"e1": 1e-18, "e2^e3^e0": -2e-18})
    assert function(perturbed).masks == function(x).masks
    close(function(perturbed), function(x), 1e-15)


@pytest.mark.parametrize("function", [log, sqrt, versor], ids=lambda f: f.__name__)
def test_elements_of_six_dimensions_without_a_closed_form_are_named(
    function: Callable[[Multivector], Multivector],
) -> None:
    x = of_grades(Algebra(6), {0, 2, 4}, np.random.default_rng(12), 1.0)
    with pytest.raises(
        ValueError, match=rf"{function.__name__}: expected .*, got blades 1 e1\^e2 "
    ):
        function(x)


def test_the_root_of_a_null_versor_is_refused() -> None:
    """``e0 (e1 + einf)`` and the like: even, and of no size."""
    null = CGA3.blade("e0") * CGA3.blade("e1") + CGA3.blade("e0") * CGA3.blade("e2")
    shifted = null + CGA3.multivector({"e1^e2^e3^e0": 1.0})
    with pytest.raises(ValueError, match="sqrt: "):
        sqrt(shifted)


@pytest.mark.parametrize("condition", [True, False])
def test_a_plain_condition_chooses_one_of_two(condition: bool) -> None:
    assert where(condition, "chosen", "otherwise") == ("chosen" if condition else "otherwise")
    assert where(np.bool_(condition), 1.0, 2.0) == (1.0 if condition else 2.0)


@pytest.mark.parametrize("x", [-2.0, -1e-9, 0.0, 1e-9, 0.5, 2.0])
def test_signs_and_steps_are_numpys(x: float) -> None:
    rows = np.array([x, x])
    assert sign(x) == np.sign(x)
    assert step(x) == np.heaviside(x, 1.0)
    np.testing.assert_array_equal(sign(rows), np.sign(rows))
    np.testing.assert_array_equal(step(rows), np.heaviside(rows, 1.0))


def test_scalars_without_a_function_are_named() -> None:
    with pytest.raises(ValueError, match="expected scalars that have sin, got Fraction"):
        apply("sin", Fraction(1, 2))
