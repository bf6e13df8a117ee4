"""Every product against the library clifford, and the null basis blade by blade."""

from collections.abc import Callable
from functools import cache
from typing import Any

import clifford
import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector

# Their basis vectors in the order of ours: in Cl(3,0,1) the null vector comes first there.
CASES = {
    "Cl(3)": (EGA3, (3, 0, 0), (0, 1, 2)),
    "Cl(4,1)": (CGA3.orthogonal, (4, 1, 0), (0, 1, 2, 3, 4)),
    "Cl(3,0,1)": (PGA3, (3, 0, 1), (1, 2, 3, 0)),
    "Cl(2,3)": (Algebra(2, 3), (2, 3, 0), (0, 1, 2, 3, 4)),
}


class Witness:
    """An algebra of ours and one of theirs, with our blades built by their outer products."""

    def __init__(self, algebra: Algebra, layout: Any, vectors: dict[str, Any]) -> None:
        self.algebra = algebra
        self.layout = layout
        self.blades = {name: self._blade(name, vectors) for name in algebra.blades}
        self.columns = np.stack([b.value.astype(float) for b in self.blades.values()], axis=1)

    def _blade(self, name: str, vectors: dict[str, Any]) -> Any:
        made = self.layout.scalar
        for factor in [] if name == "1" else name.split("^"):
            made = made ^ vectors[factor]
        return made

    def theirs(self, x: Multivector) -> Any:
        return sum((float(v) * self.blades[n] for n, v in x.items()), 0.0 * self.layout.scalar)

    def check(self, ours: Multivector, theirs: Any, tolerance: float = 1e-12) -> None:
        found = np.array([float(ours.coefficient(name)) for name in self.blades])
        expected = np.linalg.solve(self.columns, theirs.value)
        size = max(1.0, float(np.max(np.abs(expected))))
        np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * size)


@cache
def layout_of(signature: tuple[int, int, int]) -> Any:
    return clifford.Cl(*signature)[0]


def of_case(name: str) -> Witness:
    algebra, signature, order = CASES[name]
    layout = layout_of(signature)
    vectors = dict(zip(algebra.names, (layout.blades_of_grade(1)[k] for k in order), strict=True))
    return Witness(algebra, layout, vectors)


def conformal() -> Witness:
    layout = layout_of((4, 1, 0))
    blades = layout.blades
    ep, em = blades["e4"], blades["e5"]
    vectors = {
        "e1": blades["e1"],
        "e2": blades["e2"],
        "e3": blades["e3"],
        "e0": 0.5 * (em - ep),
        "einf": ep + em,
    }
    return Witness(CGA3, layout, vectors)


@pytest.fixture(scope="module", params=[*CASES, "null basis"])
def witness(request: pytest.FixtureRequest) -> Witness:
    return conformal() if request.param == "null basis" else of_case(request.param)


@pytest.fixture
def anything(witness: Witness, rng: np.random.Generator) -> Callable[[], Multivector]:
    def made() -> Multivector:
        return witness.algebra.multivector(
            {name: rng.standard_normal() for name in witness.algebra.blades}
        )

    return made


def test_products(witness: Witness, anything: Callable[[], Multivector]) -> None:
    a, b = anything(), anything()
    x, y = witness.theirs(a), witness.theirs(b)
    witness.check(a * b, x * y)
    witness.check(a ^ b, x ^ y)
    witness.check(a | b, x | y)
    witness.check(a.commutator(b), 0.5 * (x * y - y * x))


def test_involutions_grades_and_norms(
    witness: Witness, anything: Callable[[], Multivector]
) -> None:
    a = anything()
    x = witness.theirs(a)
    witness.check(~a, ~x)
    witness.check(a.involute(), x.gradeInvol())
    witness.check(a.conjugate(), x.conjugate())
    for k in range(witness.algebra.dimension + 1):
        witness.check(a.grade(k), x(k))
    assert a.norm_squared() == pytest.approx(float(x.mag2()), rel=1e-12)
    witness.check(a.square(), x * x)
    witness.check(a.reverse_product(), x * ~x)


def test_duals_and_inverses(witness: Witness, anything: Callable[[], Multivector]) -> None:
    a = anything() * 0.3 + 1.5
    x = witness.theirs(a)
    unit = np.zeros(len(x.value))
    unit[0] = 1.0
    inverse = x.layout.MultiVector(np.linalg.solve(x.layout.get_left_gmt_matrix(x), unit))
    witness.check(a.inverse(), inverse)
    if witness.algebra.signature[2] == 0:
        whole = witness.theirs(witness.algebra.pseudoscalar)
        witness.check(a.dual(), x * whole.inv())
        witness.check(a.undual(), x * whole)


def test_every_pair_of_blades(witness: Witness) -> None:
    """Their multiplication tables, brought to our blades, have exactly our terms."""
    tables = {"*": witness.layout.gmt, "^": witness.layout.omt, "|": witness.layout.imt}
    columns, names = witness.columns, list(witness.blades)
    for sign, table in tables.items():
        products = np.einsum("ia,ikj,jb->kab", columns, table.todense(), columns, optimize=True)
        theirs = np.linalg.solve(columns, products.reshape(len(names), -1))
        theirs = theirs.reshape(products.shape)
        ours = np.zeros_like(theirs)
        for a, one in enumerate(names):
            for b, two in enumerate(names):
                left, right = witness.algebra.blade(one), witness.algebra.blade(two)
                product = {"*": left * right, "^": left ^ right, "|": left | right}[sign]
                for name, value in product.items():
                    ours[names.index(name), a, b] = value
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12, err_msg=sign)
