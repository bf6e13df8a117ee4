"""The IMU carries a pose to the frame that is shown, once how it sits on the camera is sure."""

from dataclasses import replace

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.live import LiveFrame, LiveTracker
from motorcade.replays.live.inertial import (
    BRIDGED_S,
    SURE_OFFSET_S,
    InertialPoses,
)
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.pose import refine
from tests.replays.live.drawn import (
    BOARD,
    CAMERA,
    IMU_T_CAMERA,
    OFFSET_S,
    STEP_NS,
    image_of,
    readings,
    world_T_camera,
)

LATE = 5


def off_px(pose: Motor, true: Motor) -> np.ndarray:
    drawn, seen = (CAMERA.project(m.inverse().apply(BOARD.points_m)) for m in (pose, true))
    return np.linalg.norm(drawn - seen, axis=-1)


@pytest.mark.parametrize("seed", [31, 32])
def test_drawn_error_does_not_grow_with_lateness(seed: int) -> None:
    rng = np.random.default_rng(seed)
    inertial, samples = InertialPoses(), readings(24.0, seed)
    measured, off, stale = [], [], []
    index = 0
    for frame in range(round(23.5e9 / STEP_NS)):
        now_ns = frame * STEP_NS
        fed = index
        while samples[index].time_ns <= now_ns + 1e9 * OFFSET_S:
            index += 1
        inertial.add_imu(samples[fed:index])
        true = world_T_camera(frame, seed)
        seen = CAMERA.project(true.inverse().apply(BOARD.points_m))
        corners = BoardCorners(
            np.arange(len(seen)), seen + rng.normal(0.0, 0.1, seen.shape), BOARD.points_m
        )
        measured.append((now_ns, refine(corners, CAMERA, true)))
        if frame >= LATE:
            ns, pose = measured[frame - LATE]
            inertial.add_pose(ns, pose.world_T_camera, pose.covariance)
        if inertial._fit is not None:
            inertial._fit.exception()  # wait for it, so that the machine's load plays no part
        carried = inertial.at(now_ns)
        assert carried is None or inertial.synchronised is not None, "it is used once it is sure"
        if carried is not None and frame > LATE:
            off.append(off_px(carried, true))
            stale.append(off_px(measured[frame - LATE][1].world_T_camera, true))
    inertial.close()
    assert inertial.synchronised is not None, inertial.status
    assert abs(inertial.synchronised.offset_s - OFFSET_S) < 3.0 * SURE_OFFSET_S
    turn = (inertial.synchronised.imu_T_camera.rotor.inverse() @ IMU_T_CAMERA.rotor).angle()
    assert turn < np.radians(1.5)
    assert "±" in inertial.status
    assert len(off) > 100

    assert np.median(off) < 0.3
    assert np.median(off) < 0.1 * np.median(stale), "held as it was it would be far off"


def test_an_imu_that_moves_otherwise_is_not_used() -> None:
    inertial, samples = InertialPoses(), readings(10.0, 41)
    inertial.add_imu(replace(sample, rate_rad_s=sample.rate_rad_s[::-1]) for sample in samples[::2])
    rng = np.random.default_rng(1)
    for frame in range(300):
        pose = world_T_camera(frame, 99)
        inertial.add_pose(frame * STEP_NS, pose.retract(rng.normal(0, 1e-4, 6)), 1e-8 * np.eye(6))
        if inertial._fit is not None:
            inertial._fit.exception()
    inertial.close()
    assert inertial.synchronised is None
    assert inertial.at(299 * STEP_NS) is None
    assert "not used yet" in inertial.status


def test_a_tracker_is_carried_while_the_lens_is_covered() -> None:
    seed, samples = 33, readings(14.0, 33)
    tracker, fed, last, carried = LiveTracker(BOARD, CAMERA), 0, None, []
    covered = np.full((CAMERA.height, CAMERA.width), 128, np.uint8)
    for frame in range(340):
        now_ns, first = frame * STEP_NS, fed
        while samples[fed].time_ns <= now_ns + 1e9 * OFFSET_S:
            fed += 1
        true = world_T_camera(frame, seed)
        hidden = frame >= 320
        image = covered if hidden else image_of(true)
        pose = tracker.update(LiveFrame(now_ns, image, imu=tuple(samples[first:fed])))
        if tracker.inertial._fit is not None:
            tracker.inertial._fit.exception()
        if not hidden:
            last = now_ns
        elif "IMU" in pose.why:
            carried.append(off_px(pose.world_T_camera, true))
        else:
            assert pose.state == "lost"
            assert now_ns - last > 1e9 * BRIDGED_S
    tracker.close()
    assert "IMU used" in tracker.inertial.status, tracker.inertial.status
    assert len(carried) == int(1e9 * BRIDGED_S / STEP_NS)
    assert np.median(carried[:5]) < 0.3
    assert np.median(carried[-1]) < 3.0
