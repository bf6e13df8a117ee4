"""Functions of multivectors over batches, symbols and tensors: what they are over numbers."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.algebra.exponential import exp
from motorcade.ga.algebra.logarithm import log, normalize, sqrt, versor

FUNCTIONS: dict[str, Callable[[Multivector], Multivector]] = {
    "exp": exp,
    "log": lambda b: log(exp(b)),
    "sqrt": lambda b: sqrt(exp(b)),
    "versor": lambda b: versor(exp(b) + 0.1),
    "normalize": lambda b: normalize(exp(b)),
}
KINDS = {
    "rotor": (EGA3, {"e2^e3", "e1^e3", "e1^e2"}),
    "motor": (CGA3, {"e2^e3", "e1^e3", "e1^e2", "e1^einf", "e2^einf", "e3^einf"}),
    "similarity": (
        CGA3,
        {"e2^e3", "e1^e3", "e1^e2", "e0^einf", "e1^einf", "e2^einf", "e3^einf"},
    ),
    "pga": (PGA3, {"e2^e3", "e1^e3", "e1^e2", "e1^e0", "e2^e0", "e3^e0"}),
    "any": (CGA3, {name for name in CGA3.blades if name.count("^") == 1}),
    "double": (Algebra(4), {name for name in Algebra(4).blades if name.count("^") == 1}),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_batches_and_symbols_mean_what_numbers_mean(name: str, kind: str) -> None:
    ca = pytest.importorskip("casadi")
    algebra, blades = KINDS[kind]
    rng = np.random.default_rng(10)
    order = sorted(blades)
    rows = np.concatenate([rng.normal(scale=s, size=(4, len(order))) for s in (1e-6, 0.01, 0.6)])
    function = FUNCTIONS[name]
    batch = function(algebra.multivector(dict(zip(order, rows.T, strict=True))))
    symbols = ca.SX.sym("b", len(order))
    made = function(algebra.multivector({n: symbols[k] for k, n in enumerate(order)}))
    evaluated = ca.Function("f", [symbols], [ca.vertcat(*map(ca.SX, made.values))])
    for k, row in enumerate(rows):
        x = function(algebra.multivector(dict(zip(order, map(float, row), strict=True))))
        assert all(type(value) is float for value in x.values)
        symbolic_row = np.array(evaluated(row)).ravel()
        for blade, value in x.items():
            assert np.broadcast_to(batch.coefficient(blade), 12)[k] == pytest.approx(
                value, abs=1e-12
            )
            index = made.blades.index(blade)
            assert symbolic_row[index] == pytest.approx(value, abs=1e-12)


def test_float32_batches_stay_float32() -> None:
    t = np.linspace(-1, 1, 5, dtype=np.float32)
    x = exp(CGA3.multivector({"e1^e2": t, "e1^einf": 2 * t, "e3^einf": t}))
    for made in (x, log(x), sqrt(x), versor(x), normalize(x)):
        assert {np.asarray(value).dtype for value in made.values} == {np.dtype(np.float32)}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_tensors_mean_what_batches_mean(name: str, kind: str) -> None:
    torch = pytest.importorskip("torch")
    algebra, blades = KINDS[kind]
    rows = np.random.default_rng(11).normal(scale=0.4, size=(len(blades), 6))
    rows[:, 0] = 0.0
    function = FUNCTIONS[name]
    tensors = torch.tensor(rows, requires_grad=True)
    order = sorted(blades)
    found = function(algebra.multivector({n: tensors[k] for k, n in enumerate(order)}))
    expected = function(algebra.multivector(dict(zip(order, rows, strict=True))))
    assert found.blades == expected.blades
    for one, other in zip(found.values, expected.values, strict=True):
        np.testing.assert_allclose(
            np.broadcast_to(one.detach(), 6), np.broadcast_to(other, 6), atol=1e-13
        )


@pytest.mark.parametrize("kind", ["rotor", "motor", "pga"])
def test_derivatives_at_zero_are_those_of_the_series(kind: str) -> None:
    ca = pytest.importorskip("casadi")
    algebra, blades = KINDS[kind]
    order = sorted(blades)
    symbols = ca.SX.sym("b", len(order))
    b = algebra.multivector({name: symbols[k] for k, name in enumerate(order)})
    for made, factor in ((exp(b), 1.0), (log(exp(b)), 1.0), (sqrt(exp(b)), 0.5)):
        values = ca.vertcat(*(ca.SX(made.coefficient(name)) for name in order))
        slopes = ca.Function("f", [symbols], [ca.jacobian(values, symbols)])
        np.testing.assert_allclose(slopes(np.zeros(len(order))), factor * np.eye(len(order)))
