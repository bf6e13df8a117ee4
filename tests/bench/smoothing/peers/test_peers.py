"""The peers of `make bench SUITE=smoothers` do the job that they are judged at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tests.bench.smoothing.peers.own_best as own_best
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.peers.graph import gtsam_positions, gtsam_rotations
from tests.bench.smoothing.peers.kalman import filterpy_rts
from tests.bench.smoothing.peers.tuned import Case, golden_section
from tests.bench.smoothing.smoothers import OWN, bench_smoothers, smoothers_table

TRUE = MOTIONS["handheld"].sampled(20.0, 2.0)
RAW = Gaussian(0.005, 0.01).apply(TRUE, np.random.default_rng(1))
TIME_S = RAW.time_s
WXYZ, POSITION_M = RAW.motors.as_quaternion_translation()


def test_graph_and_filter_have_one_optimum() -> None:
    """But for what filterpy supposes of the first speed."""
    by_graph = gtsam_positions(TIME_S, POSITION_M, 2.0, 0.01)
    by_filter = filterpy_rts(TIME_S, POSITION_M, 2.0)
    np.testing.assert_allclose(by_graph, by_filter, atol=1e-5)


@pytest.mark.parametrize("robust", [False, True])
def test_rotations_end_where_gtsam_ends(robust: bool) -> None:
    """Against factors in Python under gtsam's own optimiser, with its loss of Cauchy."""
    import gtsam

    density, noise = 1.0, 0.01
    normal = gtsam.noiseModel.Isotropic.Sigma(3, noise)
    cauchy = gtsam.noiseModel.mEstimator.Cauchy(1.0)
    model = gtsam.noiseModel.Robust.Create(cauchy, normal) if robust else normal
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for k, wxyz in enumerate(WXYZ):
        graph.add(gtsam.PriorFactorRot3(2 * k, gtsam.Rot3(*wxyz), model))
        values.insert(2 * k, gtsam.Rot3(*wxyz))
        values.insert(2 * k + 1, np.zeros(3))
    for k, dt in enumerate(np.diff(TIME_S).tolist()):
        sizes = density * np.sqrt(np.repeat([dt**3 / 12.0, dt], 3))
        keys, steady = list(range(2 * k, 2 * k + 4)), gtsam.noiseModel.Diagonal.Sigmas(sizes)
        graph.add(gtsam.CustomFactor(steady, keys, _moves_on(dt)))
    expected = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    found = gtsam_rotations(TIME_S, WXYZ, density, noise, robust)
    for k, wxyz in enumerate(found):
        off = gtsam.Rot3.Logmap(expected.atRot3(2 * k).between(gtsam.Rot3(*wxyz)))
        assert np.linalg.norm(off) < 0.03 * noise


def _moves_on(dt: float):  # type: ignore[no-untyped-def]  # gtsam's types
    import gtsam

    def error(factor, values, jacobians):  # type: ignore[no-untyped-def]
        first, last = (values.atRot3(factor.keys()[k]) for k in (0, 2))
        rates = [values.atVector(factor.keys()[k]) for k in (1, 3)]
        step = gtsam.Rot3.Logmap(first.between(last))
        if jacobians is not None:
            inverse = np.linalg.inv(gtsam.Rot3.ExpmapDerivative(step))
            none, one = np.zeros((3, 3)), np.eye(3)
            blocks = (
                (-inverse.T, none),
                (-0.5 * dt * one, -one),
                (inverse, none),
                (-0.5 * dt * one, one),
            )
            for k, pair in enumerate(blocks):
                jacobians[k] = np.asfortranarray(np.vstack(pair))
        return np.concatenate([step - 0.5 * dt * (rates[0] + rates[1]), rates[1] - rates[0]])

    return error


def test_golden_section_finds_what_is_least() -> None:
    found = golden_section(lambda one: abs(np.log(one / 30.0)), 0.1, 1e3, 16)
    assert found == pytest.approx(30.0, rel=0.01)


def case() -> Case:
    def errors(path: Trajectory) -> tuple[float, float]:
        turn = (TRUE.motors.rotor.inverse() @ path.motors.rotor).as_rotation_vector()
        shift = path.motors.translation_m - TRUE.motors.translation_m
        return float(np.sqrt(np.mean(turn**2))), float(np.sqrt(np.mean(shift**2)))

    return Case(RAW, errors, (0.01, 0.005), False)


def test_own_best_searches_every_method(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that no search is written for is not left out in silence."""
    assert set(METHODS) == own_best.SEARCHED
    monkeypatch.setattr(own_best, "METHODS", {"auto": None, "gaussian": None})
    with pytest.raises(ValueError, match="no search of"):
        own_best.own_best(case())
    monkeypatch.setattr(own_best, "METHODS", dict.fromkeys(own_best.SEARCHED))
    monkeypatch.setattr(own_best, "smooth", lambda raw, method, *_, **__: raw)
    found = own_best.own_best(case())
    assert found.e2 == 1.0
    assert found.trials > 100


def test_a_tuned_part_is_the_best_of_its_ways() -> None:
    def ways() -> list[FloatArray]:
        return [POSITION_M + off for off in (0.5, 0.01, 0.3)]

    assert np.array_equal(case().tuned(1, iter(ways())), ways()[1])


def test_signs_of_quaternions_are_made_continuous() -> None:
    signs = np.where(np.random.default_rng(0).random(len(RAW)) < 0.5, -1.0, 1.0)[:, None]
    poses = type(RAW.motors)(RAW.motors.coefficients * signs)
    turned = Case(Trajectory(RAW.time_ns, poses), case().errors, (0.0, 0.0), False).parts()[0]
    assert (np.sum(turned[1:] * turned[:-1], axis=1) > 0.0).all()
    off = Rotor.from_quaternion(turned).inverse() @ RAW.motors.rotor
    np.testing.assert_allclose(off.as_rotation_vector(), 0.0, atol=1e-12)


def test_the_table_holds_groups_regret_and_losses(tmp_path: Path) -> None:
    found = bench_smoothers(("screw",), ("white 5",), ("auto", "Savitzky-Golay 9"), tmp_path)
    rows = found["rows"]
    assert [row["way"] for row in rows] == ["auto", "Savitzky-Golay 9, 2"]
    assert rows[0]["e2"] < rows[1]["e2"] < 1.0
    best = rows[0] | {"way": OWN, "e2": 0.5 * rows[0]["e2"], "setting": "spline on rotors"}
    text = smoothers_table({"rows": [*rows, best]})
    assert "further motions, 1 cells" in text
    assert "100.0 % mean, 100.0 % worst (screw, white 5 mm, 0.5°)" in text
    assert "own best, tuned (spline on rotors)" in text
