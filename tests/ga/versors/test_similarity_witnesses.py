"""Similarities against clifford, gtsam, scipy's matrix exponential, and mpmath at 50 digits."""

from collections.abc import Iterable
from typing import Any

import clifford
import gtsam
import mpmath
import numpy as np
import pytest
from scipy.linalg import expm

from motorcade.ga import Motor, Similarity
from tests.ga.cases import over

EPS = float(np.finfo(float).eps)
SCALES = (1e-3, 0.01, 0.25, 1 - 1e-7, 1.0, 1 + 1e-12, 2.0, 4.0, 30.0, 1e3)


def bound(scale: float) -> float:
    return 1e-14 if 0.25 <= scale <= 4 else 8 * EPS * max(scale, 1 / scale)


class Conformal:
    """Cl(4, 1) of clifford, with the basis of our coefficients built from its own products."""

    def __init__(self) -> None:
        self.layout, blades = clifford.Cl(4, 1)
        self.vectors = [blades["e1"], blades["e2"], blades["e3"]]
        e1, e2, e3 = self.vectors
        self.infinity = blades["e4"] + blades["e5"]
        self.origin = 0.5 * (blades["e5"] - blades["e4"])
        flat = self.origin ^ self.infinity
        pairs = [e2 ^ e3, e3 ^ e1, e1 ^ e2]
        shifts = [e ^ self.infinity for e in self.vectors]
        even = [self.layout.scalar, *pairs]
        self.basis = [*even, *(x * flat for x in even), *shifts, e1 ^ e2 ^ e3 ^ self.infinity]
        self.log_basis = [*pairs, flat, *shifts]

    def versor(self, coefficients: np.ndarray) -> Any:
        return sum(float(c) * b for c, b in zip(coefficients, self.basis, strict=True))

    def bivector(self, coefficients: np.ndarray) -> Any:
        return sum(float(c) * b for c, b in zip(coefficients, self.log_basis, strict=True))

    def coefficients(self, element: Any) -> np.ndarray:
        columns = np.stack([blade.value for blade in self.basis], axis=1)
        found = np.linalg.lstsq(columns, element.value, rcond=None)[0]
        np.testing.assert_allclose(columns @ found, element.value, rtol=0, atol=1e-12)
        return found

    def point(self, x: np.ndarray) -> Any:
        vector = sum(float(c) * e for c, e in zip(x, self.vectors, strict=True))
        return self.origin + vector + 0.5 * float(x @ x) * self.infinity

    def coordinates(self, point: Any) -> np.ndarray:
        weight = -float((point | self.infinity).value[0])
        return np.array([float((point | e).value[0]) / weight for e in self.vectors])

    def exp(self, bivector: Any) -> Any:
        term = total = 1.0 + 0.0 * bivector
        for n in range(1, 60):
            term = term * bivector / n
            total = total + term
        return total


@pytest.fixture(scope="module")
def conformal() -> Conformal:
    return Conformal()


@pytest.fixture(params=SCALES)
def scale(request: pytest.FixtureRequest) -> float:
    return request.param


@pytest.mark.quick_every(2)
def test_sandwich_in_cl41_is_apply(scale: float, conformal: Conformal) -> None:
    one = Similarity.from_motor_scale(Motor.random(np.random.default_rng(3)), scale)
    versor, x = conformal.versor(one.coefficients), np.array([0.3, -1.2, 0.7])
    moved = conformal.coordinates(versor * conformal.point(x) * ~versor)
    # In clifford the point's weight, 1 / scale, is what is left of terms as large as the scale.
    off = max(20 * bound(scale), 4 * EPS * scale**2)
    np.testing.assert_allclose(one.apply(x), moved, rtol=0, atol=off * max(1.0, scale))


def test_products_in_cl41_are_compose_and_inverse(
    rng: np.random.Generator, conformal: Conformal
) -> None:
    a, b = Similarity.random(rng, (20,)), Similarity.random(rng, (20,))
    for one, two in zip(a, b, strict=True):
        left, right = conformal.versor(one.coefficients), conformal.versor(two.coefficients)
        product = conformal.coefficients(left * right)
        np.testing.assert_allclose((one @ two).coefficients, product, rtol=0, atol=1e-14)
        reverse = conformal.coefficients(~left)
        np.testing.assert_allclose(one.inverse().coefficients, reverse, rtol=0, atol=1e-15)


def test_exponentials_in_cl41_are_exp(rng: np.random.Generator, conformal: Conformal) -> None:
    for log in 0.8 * rng.standard_normal((20, 7)):
        witness = conformal.coefficients(conformal.exp(conformal.bivector(log)))
        np.testing.assert_allclose(Similarity.exp(log).coefficients, witness, rtol=0, atol=1e-12)


@pytest.mark.parametrize("log_scale", [0.0, 1e-12, 1e-7, 0.7, -1.2, 3.0])
@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.5, 3.0])
def test_logarithms_exponentiate_back_in_cl41(
    log_scale: float, angle: float, rng: np.random.Generator, conformal: Conformal
) -> None:
    axis = rng.standard_normal(3)
    log = np.concatenate(
        [0.5 * angle * axis / np.linalg.norm(axis), [0.5 * log_scale], rng.standard_normal(3)]
    )
    versor = conformal.exp(conformal.bivector(log))
    found = Similarity.normalize(conformal.coefficients(versor)).log()
    np.testing.assert_allclose(found, log, rtol=0, atol=1e-12)


def test_projection_is_the_closed_form_in_cl41(
    rng: np.random.Generator, conformal: Conformal
) -> None:
    for element in np.eye(12)[0] + 0.4 * rng.standard_normal((20, 12)):
        m = conformal.versor(element)
        square = m * ~m
        s = float(square.value[0])
        rest = square - s
        nu = np.sqrt(s**2 - float((rest * rest).value[0]))
        witness = ((s + nu) - rest) * m / (nu * np.sqrt(2 * (s + nu)))
        found = Similarity.normalize(element).coefficients
        np.testing.assert_allclose(found, conformal.coefficients(witness), rtol=0, atol=1e-12)


def test_twist_is_the_logarithm_of_the_matrix(rng: np.random.Generator) -> None:
    for twist in rng.standard_normal((40, 7)):
        wx, wy, wz, *shift, growth = twist
        generator = np.zeros((4, 4))
        generator[:3, :3] = [[growth, -wz, wy], [wz, growth, -wx], [-wy, wx, growth]]
        generator[:3, 3] = shift
        made = Similarity.from_twist(twist)
        witness = expm(generator)
        size = max(1.0, float(np.max(np.abs(witness))))
        np.testing.assert_allclose(made.as_matrix(), witness, rtol=0, atol=1e-13 * size)
        if np.linalg.norm(twist[:3]) < np.pi:
            np.testing.assert_allclose(made.as_twist(), twist, rtol=0, atol=1e-14)


def test_gtsam_has_the_same_exponential_logarithm_and_action(rng: np.random.Generator) -> None:
    points = rng.standard_normal((50, 3))
    for twist, x in zip(rng.standard_normal((50, 7)), points, strict=True):
        witness, made = gtsam.Similarity3.Expmap(twist), Similarity.from_twist(twist)
        np.testing.assert_allclose(made.apply(x), witness.transformFrom(x), rtol=0, atol=1e-12)
        found = gtsam.Similarity3.Logmap(witness)
        np.testing.assert_allclose(made.as_twist(), found, rtol=0, atol=1e-12)


# Fifty digits ----------------------------------------------------------------------------------


def quaternion_product(a: list[Any], b: list[Any]) -> list[Any]:
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]


def across(axis: list[Any], vector: list[Any], along: Any, z_factor: Any) -> list[Any]:
    dot = sum(a * b for a, b in zip(axis, vector, strict=True))
    i, j, k = axis
    x, y, z = vector
    cross = [j * z - k * y, k * x - i * z, i * y - j * x]
    return [
        along * dot * a + z_factor.real * (v - dot * a) + z_factor.imag * c
        for a, v, c in zip(axis, vector, cross, strict=True)
    ]


def digits(numbers: Iterable[Any]) -> list[Any]:
    return [mpmath.mpf(c) for c in numbers]


def exact_exp(log: Iterable[Any]) -> list[Any]:
    """Dilation, rotation and translation from ``(e^z - 1) / z`` in 50 digits."""
    a1, a2, a3, e, n1, n2, n3 = digits(log)
    half = mpmath.sqrt(a1**2 + a2**2 + a3**2)
    axis = [-a / half for a in (a1, a2, a3)] if half else [mpmath.mpf(0)] * 3
    z = mpmath.mpc(2 * e, 2 * half)
    along = mpmath.expm1(2 * e) / (2 * e) if e else mpmath.mpf(1)
    factor = mpmath.expm1(z) / z if z else mpmath.mpc(1)
    t = across(axis, [-2 * n for n in (n1, n2, n3)], along, factor)
    # The Hamilton quaternion q, and the dual part of the motor, t q / 2.
    q = [mpmath.cos(half), *(mpmath.sin(half) * a for a in axis)]
    dual = [c / 2 for c in quaternion_product([mpmath.mpf(0), *t], q)]
    rotor = [q[0], -q[1], -q[2], -q[3]]
    shrink = mpmath.exp(-e)
    exact = [mpmath.cosh(e) * r for r in rotor] + [mpmath.sinh(e) * r for r in rotor]
    return exact + [-shrink * c for c in (dual[1], dual[2], dual[3], dual[0])]


def exact_log(coefficients: Iterable[Any]) -> list[Any]:
    """Rotor, scale and translation of the rounded coefficients, then ``z / (e^z - 1)``.

    The scale is the quotient of the lengths of ``A + B`` and ``A - B``, as projection has it, the
    rotor is half-way between them.
    """
    m = digits(coefficients)
    if m[0] < 0:
        m = [-c for c in m]
    grown = [a + b for a, b in zip(m[:4], m[4:8], strict=True)]
    shrunk = [a - b for a, b in zip(m[:4], m[4:8], strict=True)]
    grown_size, shrunk_size = (mpmath.sqrt(sum(c**2 for c in x)) for x in (grown, shrunk))
    middle = [a / grown_size + b / shrunk_size for a, b in zip(grown, shrunk, strict=True)]
    size = mpmath.sqrt(sum(c**2 for c in middle))
    rotor = [c / size for c in middle]
    e = mpmath.log(grown_size / shrunk_size) / 2
    dual = [-mpmath.exp(e) * c for c in (m[11], m[8], m[9], m[10])]
    t = [2 * c for c in quaternion_product(dual, rotor)[1:]]
    sine = mpmath.sqrt(sum(c**2 for c in rotor[1:]))
    half = mpmath.atan2(sine, rotor[0])
    axis = [-c / sine for c in rotor[1:]] if sine else [mpmath.mpf(0)] * 3
    z = mpmath.mpc(2 * e, 2 * half)
    along = 2 * e / mpmath.expm1(2 * e) if e else mpmath.mpf(1)
    factor = z / mpmath.expm1(z) if z else mpmath.mpc(1)
    u = across(axis, t, along, factor)
    return [*(-half * a for a in axis), e, *(-c / 2 for c in u)]


def blocks(given: Iterable[Any]) -> tuple[list[Any], list[Any], list[Any]]:
    """Hamilton quaternions ``P = A + B``, ``N = A - B`` and ``d`` of ``A + B E + d J``."""
    m = digits(given)
    signs = (1, -1, -1, -1)
    grown = [s * (x + y) for s, x, y in zip(signs, m[:4], m[4:8], strict=True)]
    shrunk = [s * (x - y) for s, x, y in zip(signs, m[:4], m[4:8], strict=True)]
    return grown, shrunk, [-m[11], -m[8], -m[9], -m[10]]


def joined(p: list[Any], n: list[Any], d: list[Any]) -> list[Any]:
    signs = (1, -1, -1, -1)
    even = [s * (x + y) / 2 for s, x, y in zip(signs, p, n, strict=True)]
    odd = [s * (x - y) / 2 for s, x, y in zip(signs, p, n, strict=True)]
    return [*even, *odd, -d[1], -d[2], -d[3], -d[0]]


def exact_product(a: Iterable[Any], b: Iterable[Any]) -> list[Any]:
    """The geometric product: blocks multiply as the matrices ``[[P, d], [0, N]]``."""
    (p1, n1, d1), (p2, n2, d2) = blocks(a), blocks(b)
    left, right = quaternion_product(p1, d2), quaternion_product(d1, n2)
    return joined(
        quaternion_product(p1, p2),
        quaternion_product(n1, n2),
        [x + y for x, y in zip(left, right, strict=True)],
    )


def exact_projection(element: Iterable[Any]) -> list[Any]:
    """``((s + ν) - F) m / (ν √(2 (s + ν)))``, block by block."""
    p, n, d = blocks(element)
    s, *g = quaternion_product(p, [n[0], -n[1], -n[2], -n[3]])
    nu = mpmath.sqrt(s**2 + sum(c**2 for c in g))
    size = nu * mpmath.sqrt(2 * (s + nu))
    minus, plus = (
        [(s + nu) / size, *(-c / size for c in g)],
        [(s + nu) / size, *(c / size for c in g)],
    )
    skew = 2 * sum(x * y for x, y in zip(p, d, strict=True)) / size
    moved = quaternion_product(minus, d)
    return joined(
        quaternion_product(minus, p),
        quaternion_product(plus, n),
        [x - skew * y for x, y in zip(moved, n, strict=True)],
    )


def exact_interpolation(a: np.ndarray, b: np.ndarray, fraction: float) -> list[Any]:
    back = [s * c for s, c in zip((1, -1, -1, -1, -1, 1, 1, 1, -1, -1, -1, 1), a, strict=True)]
    step = [mpmath.mpf(fraction) * c for c in exact_log(exact_product(back, b))]
    return exact_product(a, exact_exp(step))


def error(found: np.ndarray, exact: Iterable[Any]) -> float:
    """Normwise: the largest difference over the largest number, or over 1."""
    rounded = np.array([float(c) for c in exact])
    return float(np.max(np.abs(found - rounded)) / max(1.0, float(np.max(np.abs(rounded)))))


@over(scale=SCALES)
def test_products_are_exact_to_rounding(scale: float, motors: Motor) -> None:
    flat = Similarity.from_motor_scale(motors, scale).reshape(-1)[:2]
    other = Similarity.random(np.random.default_rng(1), flat.shape)
    for one, two in ((flat, other), (other, flat), (flat, flat)):
        with mpmath.workdps(50):
            product = (one @ two).coefficients
            worst = max(
                error(found, exact_product(x, y))
                for found, x, y in zip(product, one.coefficients, two.coefficients, strict=True)
            )
        assert worst <= 1e-14


@over(scale=SCALES)
def test_interpolation_is_exact_to_rounding(scale: float, motors: Motor) -> None:
    end = Similarity.from_motor_scale(motors, scale).reshape(-1)[:2]
    start = Similarity.from_motor_scale(Motor.random(np.random.default_rng(1), end.shape), 0.5)
    with mpmath.workdps(50):
        path = start.interpolate(end, 0.3).coefficients
        worst = max(
            error(found, exact_interpolation(x, y, 0.3))
            for found, x, y in zip(path, start.coefficients, end.coefficients, strict=True)
        )
    assert worst <= bound(max(2 * scale, 0.5 / scale))


@over(scale=SCALES)
def test_logarithm_is_exact_to_rounding(scale: float, motors: Motor) -> None:
    flat = Similarity.from_motor_scale(motors, scale).reshape(-1)[:2]
    with mpmath.workdps(50):
        worst = max(error(one.log(), exact_log(one.coefficients)) for one in flat)
    assert worst <= bound(scale)


@over(scale=SCALES)
def test_exponential_is_exact_to_rounding(scale: float, motors: Motor) -> None:
    logs = Similarity.from_motor_scale(motors, scale).log().reshape(-1, 7)[:2]
    with mpmath.workdps(50):
        worst = max(error(Similarity.exp(log).coefficients, exact_exp(log)) for log in logs)
    assert worst <= bound(scale)


@pytest.mark.parametrize("size", [1e-16, 1e-9, 3e-5, 9.9e-5, 1.01e-4, 1e-3, 0.02])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8), (-0.6, 0.8)])
def test_series_and_closed_form_meet(
    size: float, direction: tuple[float, float], rng: np.random.Generator
) -> None:
    axis = rng.standard_normal(3)
    turn = 0.5 * size * direction[1] * axis / np.linalg.norm(axis)
    log = np.concatenate([turn, [0.5 * size * direction[0]], rng.standard_normal(3)])
    with mpmath.workdps(50):
        assert error(Similarity.exp(log).coefficients, exact_exp(log)) <= 1e-15
        made = Similarity.exp(log)
        assert error(made.log(), exact_log(made.coefficients)) <= 1e-15


@over(scale=SCALES)
def test_projection_is_exact_to_rounding(
    scale: float, motors: Motor, rng: np.random.Generator
) -> None:
    flat = Similarity.from_motor_scale(motors, scale).reshape(-1)[:2].coefficients
    for noise in (0.0, 1e-9, 1e-2):
        size = min(1.0, scale, 1 / scale) * noise
        elements = flat * (1 + size * rng.standard_normal(flat.shape))
        with mpmath.workdps(50):
            found = Similarity.normalize(elements).coefficients
            worst = max(error(x, exact_projection(y)) for x, y in zip(found, elements, strict=True))
        assert worst <= 1e-14
