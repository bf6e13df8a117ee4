"""Surfaces laid on each other: drift is taken out, and what registers depth is found."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.tracking.depth import DepthCamera
from motorcade.tracking.depth.adjustment import CamerasPrior, adjust_rgbd, plane_distance_m
from motorcade.tracking.depth.residuals import GLOBALS, Matches, RgbdState
from motorcade.tracking.depth.surfaces import DepthSurfaces
from motorcade.tracking.slam.geometry import parallax_rad
from tests.textured_room.scenarios import scenario
from tests.tracking.depth.test_registration import COLOUR, COLOUR_T_DEPTH, TAKEN_BY, seen

FRAMES = (0, 40, 80, 120)
PAIRS = [(a, b) for a in range(4) for b in range(a + 1, 4)]


def truth() -> Motor:
    return scenario("handheld").truth().motors[list(FRAMES)]


def surfaces() -> DepthSurfaces:
    return DepthSurfaces.of([seen(number)[1].depth_m for number in FRAMES])


def matches(rng: np.random.Generator) -> Matches:
    """Points of the colour pictures, where all frames see them, with tracking's noise."""
    poses, depth_m = truth(), seen(FRAMES[0])[0].depth_m
    px = rng.uniform((30.0, 30.0), (290.0, 210.0), (400, 2)).round()
    points = COLOUR.unproject(px) * depth_m[px[:, 1].astype(int), px[:, 0].astype(int), None]
    points = poses[0].apply(points)
    rows = []
    for b in range(1, 4):
        there = COLOUR.project(poses[b].inverse().apply(points))
        ahead = poses[b].inverse().apply(points)[:, 2]
        cell = np.rint(np.nan_to_num(there, nan=-1.0)).astype(int)
        inside = np.all((cell >= 0) & (cell < (320, 240)), axis=-1)
        cell[~inside] = 0
        inside &= np.abs(seen(FRAMES[b])[0].depth_m[cell[:, 1], cell[:, 0]] - ahead) < 0.02
        inside &= parallax_rad(poses[0], poses[b], points) > 0.0
        rows.append((b, px[inside], there[inside] + 0.2 * rng.standard_normal((inside.sum(), 2))))
    return Matches(
        np.concatenate([np.zeros(len(one), dtype=np.int64) for _, one, _ in rows]),
        np.concatenate([np.full(len(one), b) for b, one, _ in rows]),
        np.concatenate([one for _, one, _ in rows]),
        np.concatenate([two for _, _, two in rows]),
    )


def test_drift_of_keyframes_is_taken_out() -> None:
    rng = np.random.default_rng(3)
    found, exact = surfaces(), truth()
    drift = np.concatenate([np.zeros((1, 6)), rng.normal(0.0, [0.004] * 3 + [0.01] * 3, (3, 6))])
    start = RgbdState(exact.retract(drift), COLOUR, TAKEN_BY)
    prior = CamerasPrior(COLOUR, TAKEN_BY, np.zeros(GLOBALS))
    fit = adjust_rgbd(start, found, matches(rng), PAIRS, [0], prior)
    before, after = (
        np.abs(exact.local(one.world_T_colour)).max(axis=0) for one in (start, fit.state)
    )
    assert np.all(after[:3] < 0.001)
    assert np.all(after[3:] < 0.002)
    assert np.all(10.0 * after < 10.0 * before)
    assert plane_distance_m(fit.state, found, PAIRS) < 0.5 * plane_distance_m(start, found, PAIRS)


def test_a_wrong_registration_is_found() -> None:
    """Depth turned by 1.5 degrees and 20 mm off: the adjustment finds where the sensor sits."""
    rng = np.random.default_rng(4)
    off = COLOUR_T_DEPTH @ Motor.from_twist([0.01, 0.02, -0.01, 0.02, -0.01, 0.01])
    wrong = DepthCamera(TAKEN_BY.camera, off)
    sigma = np.array([0.0, 0.0, *[0.05] * 3, *[0.05] * 3])
    start = RgbdState(truth(), COLOUR, wrong)
    fit = adjust_rgbd(
        start, surfaces(), matches(rng), PAIRS, [0], CamerasPrior(COLOUR, wrong, sigma)
    )
    apart = COLOUR_T_DEPTH.local(fit.state.depth.colour_T_depth)
    assert np.all(np.abs(apart[:3]) < 0.003), apart
    assert np.all(np.abs(apart[3:]) < 0.006), apart
