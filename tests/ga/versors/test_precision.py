"""Versors of float32 stay float32, compute to its rounding, and mix with no other."""

import pickle
from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor, blend, mean

EPSILON = float(np.finfo(np.float32).eps)


def single(versor: Versor) -> Versor:
    return type(versor)(np.asarray(versor.coefficients, dtype=np.float32))


def test_every_verb_keeps_float32(kind: type[Versor], rng: np.random.Generator) -> None:
    m = kind.random(rng, (20,)).astype(np.float32)
    results = [
        m.coefficients,
        (m @ m).coefficients,
        m.inverse().coefficients,
        m.log(),
        kind.exp(m.log()).coefficients,
        m.interpolate(m.inverse(), 0.3).coefficients,
        m.interpolate(m, np.linspace(0, 1, 20)).coefficients,
        m.apply(np.ones(3)),
        kind.normalize(m.coefficients).coefficients,
        kind.stack([m, m]).coefficients,
        m[3].coefficients,
        m.reshape(4, 5).coefficients,
        pickle.loads(pickle.dumps(m)).coefficients,
    ]
    assert isinstance(m, Rotor | Motor | Similarity)
    assert {array.dtype for array in [*results, m.as_matrix()]} == {np.dtype(np.float32)}


def test_float32_computes_to_its_rounding(
    versors: Versor, others: Versor, distance: Callable[[Versor, Versor], float]
) -> None:
    a, b = single(versors), single(others)
    size = 1.0 + max(float(np.max(np.abs(x.coefficients))) for x in (a, b))
    for ours, witness in (
        (a @ b, a.astype(float) @ b.astype(float)),
        (type(a).exp(a.log()), a.astype(float)),
        (a.interpolate(b, 0.3), a.astype(float).interpolate(b.astype(float), 0.3)),
    ):
        assert distance(ours.astype(float), witness) <= 40 * EPSILON * size


def test_blend_and_mean_keep_float32_to_its_rounding(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    near = 0.3 * kind.random(rng, (7, 4)).log()
    many = kind.exp(near).astype(np.float32)
    weights = rng.uniform(0.1, 1.0, 4)
    for combined in (blend, mean):
        ours, witness = combined(many, weights), combined(many.astype(np.float64), weights)
        assert ours.dtype == np.float32
        assert witness.dtype == np.float64
        np.testing.assert_array_equal(
            ours.coefficients, np.asarray(witness.coefficients, dtype=np.float32)
        )
    pair = kind.exp(np.stack([near[0, 0], near[0, 0] * (1 + 1e-6)]))
    blend(pair, [1.0, -1.0])
    with pytest.raises(ValueError, match="1 in which the versors cancel"):
        blend(pair.astype(np.float32), [1.0, -1.0])


def test_versors_of_different_precision_do_not_mix(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    double = kind.random(rng, (3,))
    half = double.astype("float32")
    for mixed in (
        lambda: double @ half,
        lambda: half.interpolate(double, 0.5),
        lambda: kind.stack([half, double]),
        lambda: kind.concatenate([double, half]),
    ):
        with pytest.raises(TypeError, match=r"one precision, got float32 and float64; astype"):
            mixed()
    with pytest.raises(ValueError, match="expected float32 or float64, got float16"):
        double.astype(np.float16)
