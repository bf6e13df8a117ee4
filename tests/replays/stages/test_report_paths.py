"""Which paths a report tells apart, and what it shows of a spot along two of them."""

from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.pipeline.report.film import spot_course
from motorcade.replays.pipeline.report.findings import alike, told_paths
from motorcade.replays.stages.values.paths import SmoothedPaths
from motorcade.tracking import Camera

STAMPS = (np.arange(150) * 1e9 / 30).astype(np.int64)
CAMERA = Camera(640, 480, 500.0, 505.0, 319.5, 239.5)


def way(off_rad: float = 0.0, off_m: float = 0.0, at: int = 70) -> Trajectory:
    """A camera that sways and looks along z; at one stamp it is off by so much."""
    time_s = 1e-9 * STAMPS
    turn = np.stack([0.1 * np.sin(time_s), 0.2 * np.cos(1.3 * time_s), 0 * time_s], axis=-1)
    place = np.stack([0.1 * np.cos(time_s), 0.05 * time_s, 0 * time_s], axis=-1)
    turn[at, 0] += off_rad
    place[at, 1] += off_m
    return Trajectory(STAMPS, Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place))


@pytest.mark.parametrize(
    ("other", "together"),
    [
        (way(), True),
        (way(off_rad=np.deg2rad(0.009)), True),
        (way(off_rad=np.deg2rad(0.011)), False),
        (way(off_m=9e-5), True),
        (way(off_m=2e-4), False),
        (way()[:-1], False),
    ],
)
def test_paths_are_told_apart_where_one_stamp_differs(other: Trajectory, together: bool) -> None:
    smoothed = SmoothedPaths({"motor": way(), "euler": other}, "gaussian", {})
    groups = alike(smoothed, metric=True)
    assert list(groups.values()) == ([("motor", "euler")] if together else [("motor",), ("euler",)])


def findings(paths: dict[str, Trajectory], method: str | None, by: str, **more: Any) -> Any:
    poses = SimpleNamespace(metric=True, camera=None)
    return SimpleNamespace(
        smoothed=SmoothedPaths(paths, method, {}),
        fused=SimpleNamespace(by=by),
        camera_poses=poses,
        **more,
    )


@pytest.mark.parametrize(
    ("method", "by", "told"),
    [
        ("gaussian", "imu", ["Measured", "Fused", "Smoothed"]),
        ("gaussian", "nothing", ["Measured", "Smoothed"]),
        (None, "imu", ["Measured", "Fused, not smoothed further"]),
        (None, "nothing", ["Measured", "Not smoothed: as measured"]),
    ],
)
def test_one_row_stands_for_representations_that_agree(
    method: str | None, by: str, told: list[str]
) -> None:
    same = {"motor": way(), "quaternion": way(), "euler": way()}
    assert list(told_paths(findings(same, method, by)).values()) == told


def test_those_that_agree_are_named_together() -> None:
    paths = {"motor": way(), "quaternion": way(), "euler": way(off_rad=0.1)}
    told = told_paths(findings(paths, "gaussian", "nothing"))
    assert told == {
        "measured": "Measured",
        "motor": "Smoothed, motors and quaternions",
        "euler": "Smoothed, Euler angles",
    }


def test_a_shake_is_shown_in_pixels_of_the_spot() -> None:
    """OpenCV's projection of the spot is the witness of what both lines differ by."""
    rng = np.random.default_rng(5)
    smooth = way()
    shaken = smooth.motors @ Motor.from_twist(rng.normal(scale=2e-3, size=(len(STAMPS), 6)))
    measured = Trajectory(STAMPS, shaken)
    spot = np.array([0.1, 0.2, 2.0])
    told = findings(
        {"motor": smooth},
        "gaussian",
        "nothing",
        recording=SimpleNamespace(camera=CAMERA),
        placed=SimpleNamespace(
            placement=SimpleNamespace(world_T_character=Motor.from_translation(spot))
        ),
    )
    told.camera_poses.measurements = SimpleNamespace(trajectory=measured)
    found = spot_course(told)
    assert found is not None
    rows = np.searchsorted(1e-9 * STAMPS, found.time_s - 1e-6)
    seen = []
    for path in (measured, smooth):
        away = path.motors[rows].inverse()
        pixels = [
            cv2.projectPoints(
                spot[None],
                one.rotor.as_rotation_vector(),
                one.translation_m,
                CAMERA.matrix,
                None,
            )[0].ravel()
            for one in away
        ]
        seen.append(np.array(pixels)[:, 0 if found.sideways else 1])
    np.testing.assert_allclose(found.measured_px - found.smoothed_px, seen[0] - seen[1], atol=1e-6)
    assert np.abs(found.smoothed_px).max() < 0.01, "the sway itself is the course"
    assert np.abs(found.measured_px).max() > 0.5
    assert found.time_s[-1] - found.time_s[0] <= 3.0 + 1e-9


def test_one_path_has_nothing_to_be_compared_with() -> None:
    told = findings(
        {"motor": way()},
        None,
        "nothing",
        recording=SimpleNamespace(camera=CAMERA),
        placed=SimpleNamespace(
            placement=SimpleNamespace(world_T_character=Motor.from_translation([0.0, 0.0, 2.0]))
        ),
    )
    told.camera_poses.measurements = SimpleNamespace(trajectory=way())
    assert spot_course(told) is None
    told.placed.placement.world_T_character = Motor.from_translation([0.0, 0.0, -2.0])
    assert spot_course(told) is None
