"""One pose, and after it only what tells a part of the state: the rest is not known, and said so.

What is unknown of turn, place and speed grows by the second then. A filter that takes the altitude
for a straight function of it learns the horizontal speed from it, which it does not tell: errors
of a hundred metres at deviations of one.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from motorcade.fusion import ADIS16448, ContinuousPath, fuse, simulate_imu
from motorcade.fusion.filter import Fused
from motorcade.fusion.measurements.positions import AltitudeMeasurements
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import PoseMeasurements
from tests.fusion.measurements.along import Along, measured_along

SIGMAS = np.repeat([np.deg2rad(0.5), 0.01], 3)
BOUND = 27.86 / 6.0
"""χ² with six degrees of freedom stays below, but for one of ten thousand."""


def fused_after_one_pose(
    kinds: tuple[str, ...], motion: str, seed: int, *, smoothed: bool, duration_s: int = 6
) -> tuple[Fused, Motor]:
    """Ten measurements a second, and where the sensor was."""
    rng = np.random.default_rng(seed)
    path = ContinuousPath.along(MOTIONS[motion], duration_s + 0.5)
    sensor = simulate_imu(path, 200.0, ADIS16448, rng)
    rows = slice(1, 200 * duration_s + 2, 20)
    stamps = sensor.stream.time_ns[rows]
    poses, later, sooner = (sensor.path.motors_at(stamps + off) for off in (0, 500_000, -500_000))
    speed = 1e3 * (later.translation_m - sooner.translation_m)
    along = Along(stamps, poses, speed, sensor.stream.angular_rate_rad_s[rows])
    first = poses[:1] @ Motor.from_twist(SIGMAS * rng.standard_normal((1, 6)))
    found = fuse(
        PoseMeasurements(Trajectory(stamps[:1], first), np.diag(SIGMAS**2)[None]),
        sensor.stream,
        ADIS16448,
        Motor.identity(),
        stamps,
        also=[measured_along(kind, along[1:], rng) for kind in kinds],
        smoothed=smoothed,
    )
    return found, poses


def nees_per_dimension(found: Fused, true: Motor) -> FloatArray:
    off = found.trajectory.motors.local(true)
    return np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.covariance), off) / 6.0


@pytest.mark.parametrize("smoothed", [False, True], ids=["live", "smoothed"])
@pytest.mark.parametrize(
    "kinds",
    [("altitude",), ("heading",), ("position",), ("altitude", "heading")],
    ids="+".join,
)
def test_what_is_not_told_is_not_known(kinds: tuple[str, ...], smoothed: bool) -> None:
    each = [
        nees_per_dimension(*fused_after_one_pose(kinds, motion, seed, smoothed=smoothed))
        for motion, seed in (("handheld", 1), ("walk_and_look", 0), ("walk_and_look", 1))
    ]
    assert np.mean(each) < BOUND


def test_an_altitude_leaves_the_horizontal_place_unknown() -> None:
    """Speed is unknown by 20 m/s: after six seconds so is the place, by 120 m."""
    found, true = fused_after_one_pose(("altitude",), "walk_and_look", 0, smoothed=False)
    turned = found.trajectory.motors.rotor.as_matrix()
    spread = turned @ found.covariance[:, 3:, 3:] @ np.swapaxes(turned, 1, 2)
    sigma_m = np.sqrt(np.einsum("nii->ni", spread))
    assert np.all(sigma_m[-1, :2] > 60.0)
    off_m = np.abs(found.trajectory.motors.translation_m - true.translation_m)
    assert np.all(off_m < 5.0 * sigma_m)


@pytest.mark.parametrize("smoothed", [False, True], ids=["live", "smoothed"])
def test_beyond_what_it_can_tell_it_says_so(smoothed: bool) -> None:
    """The turn is unknown by a radian then, and no Gaussian holds where that points."""
    for kinds, duration_s, said in (
        (("altitude",), 4, False),
        (("altitude",), 12, True),
        (("pose",), 12, False),
    ):
        found, _ = fused_after_one_pose(
            kinds, "handheld", 1, smoothed=smoothed, duration_s=duration_s
        )
        assert len(found.doubts) == said
        assert not said or re.match(r"from [67]\.\d to 1[12]\.\d s the attitude", found.doubts[0])


def test_where_the_state_is_known_an_altitude_counts_in_full() -> None:
    """Beside poses, what bends is too little to be seen: NIS of the altitude is one."""
    rng = np.random.default_rng(4)
    sensor = simulate_imu(ContinuousPath.along(MOTIONS["handheld"], 20.0), 200.0, ADIS16448, rng)
    stamps = sensor.stream.time_ns[20:-20:20]
    true = sensor.path.motors_at(stamps)
    poses = true @ Motor.from_twist(SIGMAS * rng.standard_normal((len(stamps), 6)))
    spread = np.broadcast_to(np.diag(SIGMAS**2), (len(stamps), 6, 6))
    height = true.translation_m[:, 2] + 0.003 * rng.standard_normal(len(stamps))
    found = fuse(
        PoseMeasurements(Trajectory(stamps, poses), spread),
        sensor.stream,
        ADIS16448,
        Motor.identity(),
        also=[AltitudeMeasurements(time_ns=stamps[1:], altitude_m=height[1:], covariance=9e-6)],
        smoothed=False,
    )
    assert 0.8 < np.mean(found.also[0].nis) < 1.2
