"""Images whose rows are read one after the other, adjusted with the IMU's motion between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.visual_inertial import adjust_visual_inertial
from motorcade.fusion.visual_inertial.readout import Readout, checked_readout
from motorcade.fusion.visual_inertial.sequence import LandmarkObservations
from motorcade.fusion.visual_inertial.window import InertialAdjuster
from motorcade.ga import Trajectory
from motorcade.tracking import Camera
from motorcade.tracking.slam.mapping.adjustment import Bundle
from tests.fusion.visual_inertial.test_tight import CAMERA, IMU_T_CAMERA, SIGMA_PX, Scene, scene

__all__ = ["scene"]

READOUT_S = 0.03
_FINE_HZ = 2000.0


@pytest.fixture(scope="module")
def rolling(scene: Scene) -> Scene:
    """What a rolling shutter sees from the keyframes, but for the first and the last one."""
    fine = MOTIONS["handheld"].sampled(_FINE_HZ, 8.0).motors @ IMU_T_CAMERA
    seen = scene.observations
    rows = np.flatnonzero((seen.keyframe > 0) & (seen.keyframe < len(scene.keyframes) - 1))
    stamp_s = scene.keyframes.time_s[seen.keyframe[rows]]
    points = scene.landmarks_m[seen.landmark[rows]]
    px = seen.px[rows]
    for _ in range(3):
        later_s = (px[:, 1] / (CAMERA.height - 1) - 0.5) * READOUT_S
        which = np.rint((stamp_s + later_s) * _FINE_HZ).astype(np.int64)
        px = CAMERA.project(fine[which].inverse().apply(points))
        px = np.where(np.isfinite(px), px, seen.px[rows])
    px = px + SIGMA_PX * np.random.default_rng(9).standard_normal(px.shape)
    observed = LandmarkObservations(seen.keyframe[rows] - 1, seen.landmark[rows], px)
    return replace(scene, keyframes=scene.keyframes[1:-1], observations=observed)


def test_the_readout_time_mends_what_rolling_bends(rolling: Scene):
    stamps = rolling.keyframes.time_ns
    errors = []
    for readout_s in (0.0, READOUT_S):
        readout = Readout(CAMERA, readout_s)
        adjuster = InertialAdjuster(ADIS16448, IMU_T_CAMERA, 9.81, SIGMA_PX, readout)
        adjuster.samples.add(rolling.imu)
        bundle = Bundle(
            rolling.keyframes.motors,
            np.arange(len(stamps)) < 1,
            rolling.landmarks_m,
            rolling.observations.keyframe,
            rolling.observations.landmark,
            CAMERA.undistort(rolling.observations.px),
            np.full(len(rolling.observations), np.nan),
            CAMERA.undistorted(),
            1.0,
            0.5,
        )
        found = Trajectory(stamps, adjuster(bundle, stamps, 30).world_T_camera)
        errors.append(evaluate(found, rolling.keyframes, align="se3").ape_m.rmse)
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 0.003


@pytest.mark.parametrize("model", ["pinhole", "radtan", "equidistant"])
def test_rows_are_those_of_the_sensor(model: str):
    """The lens moves corners by 50 rows and more in the undistorted image."""
    numbers = {"pinhole": (), "radtan": (-0.3, 0.08), "equidistant": (0.01, 0.0, 0.0, 0.0)}[model]
    camera = Camera(640, 480, 300.0, 300.0, 319.5, 239.5, model, numbers)
    recorded = np.array([[20.0, 0.0], [319.5, 239.5], [600.0, 479.0]])
    shown = camera.undistort(recorded) if model == "radtan" else recorded
    assert (np.abs(shown - recorded).max() > 50.0) == (model == "radtan")
    later_s = Readout(camera, READOUT_S).later_s(shown)
    np.testing.assert_allclose(later_s, [-0.5 * READOUT_S, 0.0, 0.5 * READOUT_S], atol=1e-12)


def test_gtsams_adjustment_takes_it_too(rolling: Scene):
    errors = []
    for readout_s in (0.0, READOUT_S):
        found = adjust_visual_inertial(
            rolling.keyframes,
            rolling.landmarks_m,
            rolling.observations,
            CAMERA,
            rolling.imu,
            ADIS16448,
            IMU_T_CAMERA,
            sigma_px=SIGMA_PX,
            readout_s=readout_s,
        )
        judged = evaluate(found.trajectory, rolling.keyframes, align="se3")
        errors.append((judged.ape_m.rmse, np.median(found.error_px[np.isfinite(found.error_px)])))
    assert errors[1][0] < 0.3 * errors[0][0]
    assert errors[1][1] < 1.3 * SIGMA_PX < errors[0][1]


def test_readout_times_that_no_camera_has_are_refused():
    assert checked_readout(0.0) == 0.0
    for wrong in (-0.001, 0.3, float("nan")):
        with pytest.raises(ValueError, match=r"readout_s: expected seconds from 0 to 0\.2"):
            checked_readout(wrong)
