"""Keyframes, landmarks and IMU adjusted together: metres from a monocular start."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from motorcade.fusion.filter import fuse
from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.visual_inertial import adjust_visual_inertial, start_inertial
from motorcade.fusion.visual_inertial.sequence import (
    LandmarkObservations,
    VisualInertial,
    measured_in_map,
    metric_map,
)
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking import Camera, PoseMeasurements
from motorcade.tracking.frame_history import SlamState
from motorcade.tracking.slam import SlamHistory, SlamResult
from motorcade.tracking.slam.mapping.map import MapSnapshot

IMU_T_CAMERA = Motor.from_euler_translation(
    np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])
)
CAMERA = Camera(640, 480, 400.0, 400.0, 320.0, 240.0, "radtan", (-0.1, 0.02, 0.0, 0.0))
SIGMA_PX = 0.5


def history(time_ns: IntArray, states: tuple[SlamState, ...]) -> SlamHistory:
    """Frames in these states, of which no more is told."""
    none = np.zeros(len(time_ns), np.int64)
    return SlamHistory(time_ns, states, none, none, none, ())


@dataclass(frozen=True)
class Scene:
    """True keyframes and landmarks, what was seen, and which observations are wrong."""

    keyframes: Trajectory
    landmarks_m: FloatArray
    observations: LandmarkObservations
    imu: ImuStream
    wrong: FloatArray

    def adjusted(self, keyframes: Trajectory, landmarks_m: FloatArray) -> VisualInertial:
        return adjust_visual_inertial(
            keyframes,
            landmarks_m,
            self.observations,
            CAMERA,
            self.imu,
            ADIS16448,
            IMU_T_CAMERA,
            sigma_px=SIGMA_PX,
        )


@pytest.fixture(scope="module")
def scene() -> Scene:
    rng = np.random.default_rng(3)
    path = MOTIONS["handheld"].sampled(100.0, 8.0, child="imu")
    simulated = simulate_imu(path, 100.0, ADIS16448, rng)
    keyframes = simulated.path.transformed_by(right=IMU_T_CAMERA).at_rate(4.0)
    points = []
    for pose in keyframes.motors[::3]:
        rays = CAMERA.unproject(rng.uniform([20.0, 20.0], [620.0, 460.0], (12, 2)))
        points.append(pose.apply(rays * rng.uniform(2.0, 6.0, (12, 1))))
    landmarks = np.concatenate(points)
    rows, names, px = [], [], []
    for k, pose in enumerate(keyframes.motors):
        own = pose.inverse().apply(landmarks)
        ahead = np.flatnonzero((own[:, 2] > 0.3) & (np.abs(own[:, 0]) < own[:, 2]))
        seen = CAMERA.project(own[ahead])
        inside = np.all((seen > 0.0) & (seen < [640.0, 480.0]), axis=-1)
        rows.append(np.full(np.count_nonzero(inside), k))
        names.append(ahead[inside])
        px.append(seen[inside])
    pixels = np.concatenate(px)
    wrong = rng.random(len(pixels)) < 0.02
    pixels = pixels + SIGMA_PX * rng.standard_normal(pixels.shape)
    pixels[wrong] += 40.0 * rng.standard_normal((np.count_nonzero(wrong), 2))
    seen_all = LandmarkObservations(np.concatenate(rows), np.concatenate(names), pixels)
    return Scene(keyframes, landmarks, seen_all, simulated.stream, wrong)


def test_frames_between_keyframes_count_less_than_those():
    """All are 3 mm off the same way but keyframes; the fused path stays with the keyframes."""
    rng = np.random.default_rng(6)
    path = MOTIONS["handheld"].sampled(100.0, 4.0, child="imu")
    simulated = simulate_imu(path, 100.0, ADIS16448, rng)
    truth = simulated.path.transformed_by(right=IMU_T_CAMERA).at_rate(25.0)
    off = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.003], (len(truth), 1))
    off[::8] = 0.0
    hung = replace(truth, poses=truth.motors @ Motor.from_twist(off))
    small = np.tile(1e-8 * np.eye(6), (len(truth), 1, 1))
    given = measured_in_map(hung, small, truth.time_ns[::8])
    fused = fuse(given, simulated.stream, ADIS16448, IMU_T_CAMERA)
    assert evaluate(fused.trajectory, truth, align="none").ape_m.rmse < 0.0005


def test_a_fisheye_is_adjusted_by_all_that_it_sees():
    """Points at the rim alone, 75 to 115 degrees off the axis, where no pinhole has pixels left."""
    rng = np.random.default_rng(4)
    fisheye = Camera(800, 800, 200.0, 200.0, 399.5, 399.5, "equidistant", (0.01, -0.002, 0.0, 0.0))
    path = MOTIONS["handheld"].sampled(100.0, 4.0, child="imu")
    simulated = simulate_imu(path, 100.0, ADIS16448, rng)
    truth = simulated.path.transformed_by(right=IMU_T_CAMERA).at_rate(4.0)
    away, around = np.deg2rad(rng.uniform(75.0, 115.0, 80)), rng.uniform(0.0, 2.0 * np.pi, 80)
    rays = np.stack([np.cos(around) * np.sin(away), np.sin(around) * np.sin(away), np.cos(away)])
    landmarks = truth.motors[0].apply(rays.T * rng.uniform(2.0, 4.0, (80, 1)))
    row, point = np.indices((len(truth), 80)).reshape(2, -1)
    px = fisheye.project(truth.motors[row].inverse().apply(landmarks[point]))
    px += SIGMA_PX * rng.standard_normal(px.shape)
    astray = np.repeat([0.01, 0.03], 3) * rng.standard_normal((len(truth), 6))
    found = adjust_visual_inertial(
        replace(truth, poses=truth.motors @ Motor.from_twist(astray)),
        landmarks + 0.05 * rng.standard_normal(landmarks.shape),
        LandmarkObservations(row, point, px),
        fisheye,
        simulated.stream,
        ADIS16448,
        IMU_T_CAMERA,
        sigma_px=SIGMA_PX,
    )
    assert np.median(found.error_px) < 1.2 * SIGMA_PX * np.sqrt(2.0 * np.log(2.0))
    assert np.isfinite(found.error_px).all()
    assert evaluate(found.trajectory, truth, align="se3").ape_m.rmse < 0.005


def test_a_monocular_start_becomes_metric(scene: Scene):
    """Poses and points of unknown scale, leaning: scale within 1 %, keyframes within a centimetre,
    though the start was some per cent off.
    """
    rng = np.random.default_rng(5)
    visual = Similarity.from_motor_scale(
        Motor.from_euler_translation(np.array([0.4, 0.3, 1.0]), np.array([1.0, 2.0, 3.0])), 0.27
    )
    noise = Motor.from_twist(
        rng.standard_normal((len(scene.keyframes), 6)) * np.repeat([0.003, 0.01], 3)
    )
    poses = scene.keyframes.motors @ noise
    turned = Motor.from_rotor_translation(
        visual.rotor @ poses.rotor, visual.apply(poses.translation_m)
    )
    path = Trajectory(scene.keyframes.time_ns, turned, "visual")
    points = visual.apply(scene.landmarks_m + 0.03 * rng.standard_normal(scene.landmarks_m.shape))
    spread = np.diag(np.repeat([0.003, 0.01 * 0.27], 3) ** 2)
    given = PoseMeasurements(path, np.tile(spread, (len(path), 1, 1)))
    start = start_inertial(given, scene.imu, ADIS16448, IMU_T_CAMERA)
    found = scene.adjusted(start.in_metres(path), start.world_T_visual.apply(points))
    rigid = evaluate(found.trajectory, scene.keyframes, align="se3")
    assert rigid.ape_m.rmse < 0.01
    assert rigid.rotation_deg.rmse < 0.2
    scaled = evaluate(found.trajectory, scene.keyframes, align="sim3")
    assert scaled.scale == pytest.approx(1.0, abs=0.01)
    # Up is up: heights of landmarks are right whatever the heading.
    heights = found.landmarks_m[found.seen, 2] - found.trajectory.motors[0].translation_m[2]
    true = scene.landmarks_m[found.seen, 2] - scene.keyframes.motors[0].translation_m[2]
    assert np.median(np.abs(heights - true)) < 0.01
    good = found.error_px[~scene.wrong]
    assert np.sqrt(np.mean(good[np.isfinite(good)] ** 2)) == pytest.approx(
        SIGMA_PX * np.sqrt(2.0), rel=0.15
    )
    assert np.median(found.error_px[scene.wrong]) > 10.0
    assert np.max(np.abs(found.gyro_bias_rad_s)) < 2e-3
    assert np.max(np.abs(found.accel_bias_m_s2)) < 0.05


def test_what_the_imu_alone_gives_is_metres(scene: Scene):
    """Start 10 % too small: the adjustment grows it back, which pixels cannot tell."""
    centre = scene.keyframes.motors[0].translation_m

    def shrunk(points: FloatArray) -> FloatArray:
        return centre + 0.9 * (points - centre)

    motors = scene.keyframes.motors
    small = Motor.from_rotor_translation(motors.rotor, shrunk(motors.translation_m))
    start = Trajectory(scene.keyframes.time_ns, small)
    found = scene.adjusted(start, shrunk(scene.landmarks_m))
    scaled = evaluate(found.trajectory, scene.keyframes, align="sim3")
    assert scaled.scale == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(found.trajectory.motors[0].translation_m, centre, atol=1e-3)


def test_landmarks_seen_once_stay_where_they_were(scene: Scene):
    observations = scene.observations
    first = int(observations.landmark[0])
    kept = (observations.landmark != first) | (np.arange(len(observations)) == 0)
    thinned = LandmarkObservations(
        observations.keyframe[kept], observations.landmark[kept], observations.px[kept]
    )
    found = replace(scene, observations=thinned).adjusted(scene.keyframes, scene.landmarks_m)
    assert not found.seen[first]
    np.testing.assert_array_equal(found.landmarks_m[first], scene.landmarks_m[first])
    assert np.isinf(found.error_px[0])


def test_bad_input_is_refused(scene: Scene):
    seen = scene.observations
    with pytest.raises(ValueError, match="once in a keyframe"):
        LandmarkObservations(np.zeros(2, int), np.zeros(2, int), np.zeros((2, 2)))
    with pytest.raises(ValueError, match="whole numbers from 0"):
        LandmarkObservations(seen.keyframe - 1, seen.landmark, seen.px)
    with pytest.raises(ValueError, match=r"observations\.landmark: expected rows below 5"):
        scene.adjusted(scene.keyframes, scene.landmarks_m[:5])
    first = seen.keyframe == 0
    alone = LandmarkObservations(seen.keyframe[first], seen.landmark[first], seen.px[first])
    with pytest.raises(ValueError, match="keyframes: expected two or more, got 1"):
        replace(scene, observations=alone).adjusted(scene.keyframes[:1], scene.landmarks_m)
    later = Trajectory(scene.keyframes.time_ns + 10**12, scene.keyframes.poses)
    with pytest.raises(ValueError, match="keyframes: expected stamps"):
        scene.adjusted(later, scene.landmarks_m)
    with pytest.raises(ValueError, match="sigma_px"):
        adjust_visual_inertial(
            scene.keyframes,
            scene.landmarks_m,
            seen,
            CAMERA,
            scene.imu,
            ADIS16448,
            IMU_T_CAMERA,
            sigma_px=0.0,
        )


def test_a_run_of_slam_becomes_a_metric_path_through_darkness(scene: Scene):
    """Poses at 20 Hz in units of 0.27 of a metre, none for a second in the middle."""
    rng = np.random.default_rng(8)
    visual = Similarity.from_motor_scale(
        Motor.from_euler_translation(np.array([0.4, 0.3, 1.0]), np.array([1.0, 2.0, 3.0])), 0.27
    )

    def in_units(path: Trajectory) -> Trajectory:
        turned, places = visual.rotor @ path.motors.rotor, visual.apply(path.motors.translation_m)
        return Trajectory(path.time_ns, Motor.from_rotor_translation(turned, places))

    truth = MOTIONS["handheld"].sampled(20.0, 8.0).transformed_by(right=IMU_T_CAMERA)
    noise = rng.standard_normal((len(truth), 6)) * np.repeat([0.001, 0.003], 3)
    seen = (truth.time_s < 4.0) | (truth.time_s >= 5.0)
    frames = in_units(truth.transformed_by(right=Motor.from_twist(noise))[seen])
    keyframes, observed = in_units(scene.keyframes), scene.observations
    straight = CAMERA.undistort(observed.px)
    count = len(scene.landmarks_m)
    snapshot = MapSnapshot(
        keyframes.time_ns,
        keyframes.motors,
        visual.apply(scene.landmarks_m),
        np.zeros((count, 32), np.uint8),
        observed.keyframe,
        observed.landmark,
        straight,
        np.full(len(observed), np.nan),
        False,
    )
    spread = np.diag(np.repeat([0.001, 0.003 * 0.27], 3) ** 2)
    result = SlamResult(
        frames,
        np.tile(spread, (len(frames), 1, 1)),
        history(truth.time_ns, tuple("tracking" if one else "lost" for one in seen)),
        None,
        snapshot,
        (),
        False,
        (),
        {},
    )
    sensor = scene.imu, ADIS16448, IMU_T_CAMERA
    found, wanted = metric_map(result, CAMERA, *sensor), np.asarray(result.time_ns)
    path = fuse(found.measurements, *sensor, wanted, fits_noise=False).trajectory
    np.testing.assert_array_equal(path.time_ns, truth.time_ns)
    judged = evaluate(path, truth, align="se3")
    assert judged.ape_m.rmse < 0.01
    assert judged.ape_m.max < 0.03
    scaled = evaluate(found.keyframes.trajectory, scene.keyframes, align="sim3")
    assert scaled.scale == pytest.approx(1.0, abs=0.01)
    with pytest.raises(ValueError, match="found poses"):
        metric_map(replace(result, trajectory=None), CAMERA, *sensor)
