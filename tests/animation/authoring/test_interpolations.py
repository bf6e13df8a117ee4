"""Keyframes joined in three ways: what each costs is what angles between matrices say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.animation.authoring import (
    ScenePart,
    between_keyframes,
    compare_interpolations,
    scene_of,
)

# (from, to) in degrees, intrinsic x-y'-z'', and the Euler path over the geodesic.
GIMBAL_TABLE = [
    ((10, 85, 10), (-170, 85, -160), 24.7),
    ((0, 89.9, 0), (170, 89.9, 170), 17.0),
    ((0, 45, 0), (180, 45, -180), 1.53),
    ((0, 89, 0), (90, 89, 0), 1.00),
]


def through(*keys: dict[str, Any]) -> ScenePart:
    thing = {"name": "a", "kind": "prop", "file": "a.glb", "keyframes": list(keys)}
    return scene_of({"objects": [thing]}, "scene").part("a")


@pytest.mark.parametrize(("start", "end", "ratio"), GIMBAL_TABLE)
def test_euler_keyframes_spin_where_the_table_says_and_motors_never(start, end, ratio) -> None:
    part = through(
        {"time_s": 0.0, "euler_deg": list(start)}, {"time_s": 2.0, "euler_deg": list(end)}
    )
    found = compare_interpolations(part)
    assert found["euler"].turned_over_geodesic == pytest.approx(ratio, abs=0.05 * ratio**0.5)
    for way in ("motor", "quaternion"):
        assert found[way].turned_over_geodesic == pytest.approx(1.0, abs=1e-9)
        assert found[way].peak_rad_s == pytest.approx(found[way].mean_rad_s, rel=1e-6)


def test_figures_are_those_of_matrices() -> None:
    """Angles by scipy, of poses that are read back as matrices."""
    keys = [
        {"time_s": 0.0, "position_m": [0, 0, 0], "euler_deg": [0, 80, 0]},
        {"time_s": 1.0, "position_m": [1, 0, 0], "euler_deg": [120, 80, 90], "scale": 2.0},
        {"time_s": 3.0, "position_m": [1, 1, 0], "euler_deg": [120, -20, 90]},
    ]
    part = through(*keys)
    found = compare_interpolations(part, samples=200)
    time_s = np.concatenate([np.arange(200) / 200, 1.0 + np.arange(200) / 100, [3.0]])
    screw = between_keyframes(part, time_s, "motor").as_matrix()
    for way in ("motor", "quaternion", "euler"):
        poses = between_keyframes(part, time_s, way).as_matrix()
        scale = np.cbrt(np.linalg.det(poses[:, :3, :3]))[:, None, None]
        turns = Rotation.from_matrix(poses[:, :3, :3] / scale)
        rates = (turns[:-1].inv() * turns[1:]).magnitude() / np.diff(time_s)
        assert found[way].peak_rad_s == pytest.approx(rates.max(), rel=1e-6)
        away = np.linalg.norm(poses[:, :3, 3] - screw[:, :3, 3], axis=1).max()
        assert found[way].off_screw_m == pytest.approx(away, abs=1e-9)
    assert found["motor"].off_screw_rad < 1e-6
    assert found["quaternion"].off_screw_rad < 1e-6
    assert found["quaternion"].off_screw_m > 0.05  # straight, where the screw bends


def test_one_keyframe_is_refused() -> None:
    with pytest.raises(ValueError, match="expected 2 keyframes and a step or more, got 1 and 1000"):
        compare_interpolations(through({"time_s": 0.0}))
