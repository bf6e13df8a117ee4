"""The rivals of `make bench SUITE=smooth` do the job that they are timed at."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from tests.bench.smoothing.rivals import (
    NumpyOneEuro,
    ScipyOneEuro,
    numpy_gaussian,
    numpy_rts,
    scipy_gaussian,
)
from tests.bench.smoothing.smooth import noisy_path, smooth_table

PATH = noisy_path(300)
Q, T = PATH.poses.as_quaternion_translation()


def apart(components: FloatArray, poses: Motor) -> FloatArray:
    """Largest error of rotation (rad) or translation (m) for each pose."""
    found = Motor.from_quaternion_translation(components[:, :4], components[:, 4:])
    between = (found.rotor.inverse() @ poses.rotor).as_rotation_vector()
    return np.abs(np.concatenate([between, found.translation_m - poses.translation_m], -1)).max(-1)


def test_rivals_filter_as_rotors_do() -> None:
    expected = smooth(PATH, "one_euro", "rotor").poses
    numpys, scipys = NumpyOneEuro(), ScipyOneEuro()
    rows = zip(Q, T, PATH.time_s, strict=True)
    both = [(numpys.update(*row), scipys.update(*row)) for row in rows]
    assert apart(np.array([one for one, _ in both]), expected).max() < 1e-12
    xyzw = np.array([other for _, other in both])
    assert apart(xyzw[:, [3, 0, 1, 2, 4, 5, 6]], expected).max() < 1e-12


def test_rivals_smooth_as_rotors_do() -> None:
    """But for the turn of the errors, which they leave out, and the first poses' priors."""
    expected = smooth(PATH, "rts_constant_velocity", "rotor").poses
    found = numpy_rts(PATH.time_s, Q, T, np.array([2.0, 1.0]))
    assert apart(found, expected)[20:-20].max() < 1e-3


def test_rivals_average_as_quaternions_do() -> None:
    expected = smooth(PATH, "gaussian", "quaternion", sigma_s=3.75 / 30.0).poses
    for rival in (scipy_gaussian, numpy_gaussian):
        assert apart(rival(Q, T, 3.75), expected)[20:-20].max() < 1e-5


def test_the_table_holds_every_row() -> None:
    rows = [{"job": "a job", "way": "motors", "seconds": 0.5, "over_ours": 1.0}]
    text = smooth_table({"rows": rows, "bytes_a_pose": {"one": 81.0, "other": None}})
    assert "a job: motors" in text
    assert "0.500 s" in text
    assert "unknown" in text
