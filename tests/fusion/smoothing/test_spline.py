"""The least-squares spline: SciPy's on plain components, the library's own on motors."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_lsq_spline

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import DroppedFrames, Gaussian
from motorcade.fusion.smoothing import REPRESENTATIONS, smooth
from motorcade.ga import CumulativeBSpline, Motor, Rotor, Similarity, Trajectory
from motorcade.ga.splines import fit_controls


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_positions_are_scipys_least_squares_spline(
    representation: str, rng: np.random.Generator
) -> None:
    time_ns = np.cumsum(rng.integers(20_000_000, 46_000_000, 200)).astype(np.int64)
    seconds = (time_ns - time_ns[0]) * 1e-9
    positions = np.sin(seconds[:, None] * [1.0, 1.7, 2.3]) + 0.01 * rng.standard_normal((200, 3))
    still = Motor.from_rotor_translation(Rotor.identity((200,)), positions)
    found = smooth(Trajectory(time_ns, still), "spline", representation, knot_spacing_s=0.25)
    segments = int(np.ceil(seconds[-1] / 0.25))
    knots = seconds[-1] / segments * np.arange(-5, segments + 6)
    basis = BSpline.design_matrix(seconds, knots, 5).toarray()
    faint = np.sqrt(1e-6 * 200 / segments) * np.diff(np.eye(segments + 5), n=5, axis=0)
    rows = np.concatenate([basis, faint])
    given = np.concatenate([positions, np.zeros((len(faint), 3))])
    expected = basis @ np.linalg.lstsq(rows, given, rcond=None)[0]
    # Motors fit position noise with a trace of rotation as well, which turns positions.
    atol = 1e-3 if representation in ("motor", "similarity") else 1e-8
    np.testing.assert_allclose(found.poses.translation_m, expected, atol=atol)
    unaided = make_lsq_spline(seconds, positions, knots, 5)(seconds)
    middle = slice(60, -60)  # the faint smoothness shows at the ends alone
    np.testing.assert_allclose(found.poses.translation_m[middle], unaided[middle], atol=1e-3)


def test_on_motors_it_is_the_cumulative_spline(rng: np.random.Generator) -> None:
    path = Gaussian(0.005, 0.01).apply(MOTIONS["tumble"].sampled(30.0, 4.0), rng)
    fitted = CumulativeBSpline.fit(path, 0.2).at(path.time_ns)
    found = smooth(path, "spline", knot_spacing_s=0.2)
    np.testing.assert_array_equal(found.poses.coefficients, fitted.coefficients)


@pytest.mark.parametrize("representation", [r for r in REPRESENTATIONS if r != "euler"])
def test_noise_falls_on_every_representation(representation: str, rng: np.random.Generator) -> None:
    truth = MOTIONS["antipodal_crossing"].sampled(60.0, 6.0)
    noisy = DroppedFrames(0.2).apply(Gaussian(0.005, 0.01).apply(truth, rng), rng)
    found = smooth(noisy, "spline", representation, knot_spacing_s=0.3)
    exact = truth.at(noisy.time_ns)
    before = np.linalg.norm((exact.inverse() @ noisy.poses).as_twist(), axis=1)
    after = np.linalg.norm((exact.inverse() @ found.poses).as_twist(), axis=1)
    assert np.sqrt(np.mean(after**2)) < 0.6 * np.sqrt(np.mean(before**2))


@pytest.mark.parametrize("representation", ["similarity", "motor", "rotor", "quaternion"])
def test_scales_are_fitted_beside(representation: str, rng: np.random.Generator) -> None:
    truth = MOTIONS["zoom"].sampled(30.0, 5.0)
    noisy = Gaussian(0.005, 0.01, 0.02).apply(truth, rng)
    found = smooth(noisy, "spline", representation, knot_spacing_s=0.4)
    assert isinstance(found.poses, Similarity)
    assert isinstance(truth.poses, Similarity)
    assert np.std(np.log(found.poses.scale / truth.poses.scale)) < 0.012


def test_bad_settings_are_refused() -> None:
    path = MOTIONS["screw"].sampled(30.0, 1.0)
    with pytest.raises(ValueError, match="knot_spacing_s: expected a positive number of seconds"):
        smooth(path, "spline", knot_spacing_s=0.0)
    with pytest.raises(ValueError, match="spline expected at least 2 poses, got 1"):
        smooth(path[:1], "spline")


def test_a_long_spline_fitted_in_parts_is_the_whole(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    truth = MOTIONS["handheld"].sampled(30.0, 12.0)
    path = Gaussian(0.005, 0.01).apply(truth, rng)
    whole = CumulativeBSpline.fit(path, 0.2).controls
    monkeypatch.setitem(fit_controls.__globals__, "_KEPT", 15)
    monkeypatch.setitem(fit_controls.__globals__, "_OVERLAP", 25)
    joined = CumulativeBSpline.fit(path, 0.2).controls
    np.testing.assert_allclose(joined.coefficients[2:-2], whole.coefficients[2:-2], atol=1e-6)
