"""The gimbal table against rotation matrices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.animation.authoring.gimbal import gimbal_rows


@pytest.mark.parametrize("asked", [1.0, 30.0, -120.0])
def test_the_table_says_what_matrices_say(asked: float) -> None:
    rows = gimbal_rows(asked_deg=asked)
    assert [row.pitch_deg for row in rows] == [85.0] * 3 + [89.0] * 3 + [89.9] * 3
    for row in rows:
        start = Rotation.from_euler("XYZ", [0, row.pitch_deg, 0], degrees=True)
        unit = np.eye(3)["xyz".index(row.axis)]
        wanted = start * Rotation.from_rotvec(asked * unit, degrees=True)
        held = np.array([0, row.pitch_deg, 0]) + asked * unit
        made = Rotation.from_euler("XYZ", held, degrees=True)
        off = np.degrees((wanted.inv() * made).magnitude())
        assert row.euler_off_deg == pytest.approx(off, abs=1e-6)
        assert row.rotor_off_deg < 1e-6
        axis = (start.inv() * made).as_rotvec()
        turned = np.degrees(
            np.arccos(np.clip(np.sign(asked) * axis @ unit / np.linalg.norm(axis), -1, 1))
        )
        assert row.euler_axis_off_deg == pytest.approx(turned, abs=1e-5)


def test_euler_angles_turn_about_another_axis_and_their_numbers_run() -> None:
    rows = {(row.pitch_deg, row.axis): row for row in gimbal_rows()}
    for pitch in (85.0, 89.0, 89.9):
        assert rows[pitch, "x"].euler_axis_off_deg == pytest.approx(pitch)
    runs = [rows[pitch, "x"].angles_run_deg for pitch in (85.0, 89.0, 89.9)]
    assert runs == sorted(runs)
    assert runs[-1] > 40.0  # a tenth of a degree on the object, more than forty on the dial


@pytest.mark.parametrize(
    ("given", "said"), [(([90.0], 30.0), "within ±90"), (([10.0], 0.0), "up to 180")]
)
def test_refusals(given: tuple[list[float], float], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        gimbal_rows(*given)
