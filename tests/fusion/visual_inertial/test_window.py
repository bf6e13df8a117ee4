"""Keyframes and points adjusted with the samples between them, against gtsam and differences."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ImuStream
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.visual_inertial import InertialSlam, online
from motorcade.fusion.visual_inertial.window import (
    GrowingImu,
    InertialAdjuster,
    KeyframeMotion,
    _chained,
    _Problem,
    _State,
)
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.slam import SlamFrame, SlamSettings, VisualSlam
from motorcade.tracking.slam.mapping.adjustment import Bundle
from tests.fusion.visual_inertial.test_tight import CAMERA, IMU_T_CAMERA, SIGMA_PX, Scene, scene

__all__ = ["scene"]


def _bundle(scene: Scene, fixed: int, seed: int = 4) -> Bundle:
    """Poses and points a little off, the first `fixed` poses where they are."""
    rng = np.random.default_rng(seed)
    held = np.arange(len(scene.keyframes)) < fixed
    twist = rng.standard_normal((len(held), 6)) * np.repeat([0.002, 0.01], 3)
    twist[held] = 0.0
    seen = scene.observations
    return Bundle(
        scene.keyframes.motors.retract(twist),
        held,
        scene.landmarks_m + 0.02 * rng.standard_normal(scene.landmarks_m.shape),
        seen.keyframe,
        seen.landmark,
        CAMERA.undistort(seen.px),
        np.full(len(seen), np.nan),
        CAMERA.undistorted(),
        1.0,
        0.5,
    )


def _adjuster(scene: Scene) -> InertialAdjuster:
    adjuster = InertialAdjuster(ADIS16448, IMU_T_CAMERA, 9.81, SIGMA_PX)
    adjuster.samples.add(scene.imu)
    for stamp, velocity in zip(scene.keyframes.time_ns.tolist(), _speed(scene), strict=True):
        adjuster.motions[stamp] = KeyframeMotion(velocity, np.zeros(6))
    return adjuster


def _speed(scene: Scene) -> FloatArray:
    """Of the IMU at the keyframes."""
    path = MOTIONS["handheld"].sampled(100.0, 8.0)
    speed = np.gradient(path.motors.translation_m, path.time_s, axis=0)
    return speed[np.searchsorted(path.time_ns, scene.keyframes.time_ns)]


def test_all_keyframes_come_out_as_gtsam_has_them(scene: Scene):
    bundle = _bundle(scene, 1)
    found = _adjuster(scene)(bundle, scene.keyframes.time_ns, 30)
    ours = Trajectory(scene.keyframes.time_ns, found.world_T_camera)
    theirs = scene.adjusted(
        Trajectory(scene.keyframes.time_ns, bundle.world_T_camera), bundle.points
    ).trajectory
    judged = [evaluate(one, scene.keyframes, align="se3") for one in (ours, theirs)]
    assert judged[0].ape_m.rmse < 1.2 * judged[1].ape_m.rmse
    assert judged[0].rotation_deg.rmse < 0.1
    apart = evaluate(ours, theirs, align="none")
    assert apart.ape_m.rmse < 0.005
    assert apart.rotation_deg.rmse < 0.05


def test_a_window_hangs_on_the_keyframe_before_it(scene: Scene):
    """Fixed keyframes stay, and a velocity that nobody told follows from the one before."""
    bundle, adjuster = _bundle(scene, 22), _adjuster(scene)
    stamps = scene.keyframes.time_ns
    for stamp in stamps[22:].tolist():
        del adjuster.motions[stamp]
    found = adjuster(bundle, stamps, 20)
    held = bundle.world_T_camera.coefficients[:22]
    np.testing.assert_array_equal(found.world_T_camera.coefficients[:22], held)
    off = scene.keyframes.motors.local(found.world_T_camera)[22:]
    start = scene.keyframes.motors.local(bundle.world_T_camera)[22:]
    assert np.sqrt(np.mean(off[:, 3:] ** 2)) < 0.5 * np.sqrt(np.mean(start[:, 3:] ** 2))
    told = np.array([adjuster.motions[one].velocity_m_s for one in stamps.tolist()])
    assert np.abs(told - _speed(scene))[22:].max() < 0.05
    assert found.cost < 0.5 * found.before


@pytest.mark.parametrize("fixed", [0, 3])
def test_slopes_are_those_of_the_cost(scene: Scene, fixed: int):
    """The gradient of the equations against central differences, near the minimum: the factor's
    derivatives leave out terms that vanish with its residual.
    """
    adjuster, stamps = _adjuster(scene), scene.keyframes.time_ns
    bundle = _bundle(scene, fixed)
    rng = np.random.default_rng(7)
    velocity = np.array([adjuster.motions[one].velocity_m_s for one in stamps.tolist()])
    bias = rng.standard_normal((len(stamps), 6)) * np.repeat([1e-4, 1e-3], 3)
    chain = _chained(bundle, stamps)
    problem = _Problem(adjuster, bundle, stamps, chain, bias)
    exact = scene.keyframes.motors.retract(1e-5 * rng.standard_normal((len(stamps), 6)))
    start = _State(exact, scene.landmarks_m, velocity, bias)
    gradient = problem.evaluated(start).equations.blocks.gradient
    points = np.zeros_like(scene.landmarks_m)
    for column in rng.choice(len(gradient), 60, replace=False).tolist():
        step = np.zeros(len(gradient))
        step[column] = 1e-6
        high, low = (
            problem.evaluated(problem.retracted(start, (sign * step, points))).cost
            for sign in (1.0, -1.0)
        )
        slope = (high - low) / 2e-6
        assert gradient[column] == pytest.approx(slope, rel=0.03, abs=0.02 * abs(gradient).max())


def test_nothing_hangs_together_across_thirty_days_without_samples(scene: Scene):
    """Half of the keyframes and samples come thirty days later: one link less, poses as good."""
    late_ns, middle_ns = 30 * 86_400 * 10**9, int(scene.keyframes.time_ns[16]) + 1
    imu = scene.imu
    keys = scene.keyframes.time_ns + np.where(scene.keyframes.time_ns > middle_ns, late_ns, 0)
    stamps = imu.time_ns + np.where(imu.time_ns > middle_ns, late_ns, 0)
    kept = np.abs(imu.time_ns - middle_ns) > 2  # the sample at the last keyframe before stays
    kept |= imu.time_ns <= middle_ns
    adjuster = InertialAdjuster(ADIS16448, IMU_T_CAMERA, 9.81, SIGMA_PX)
    adjuster.samples.add(
        ImuStream(stamps[kept], imu.angular_rate_rad_s[kept], imu.specific_force_m_s2[kept])
    )
    for stamp, velocity in zip(keys.tolist(), _speed(scene), strict=True):
        adjuster.motions[stamp] = KeyframeMotion(velocity, np.zeros(6))
    bundle = _bundle(scene, 1)
    found = adjuster(bundle, keys, 30)
    ours = Trajectory(scene.keyframes.time_ns, found.world_T_camera)
    assert evaluate(ours, scene.keyframes, align="se3").ape_m.rmse < 0.003
    chain = _chained(bundle, keys)
    problem = _Problem(adjuster, bundle, keys, chain, np.zeros((len(keys), 6)))
    assert len(problem.one) == len(keys) - 2


def test_samples_are_joined_where_they_are_asked_for():
    rng, samples = np.random.default_rng(0), GrowingImu()
    rate, force = rng.standard_normal((2, 60, 3))
    stamps = 5_000_000 * np.arange(60)
    for start in range(0, 60, 3):
        part = slice(start, start + 3)
        samples.add(ImuStream(stamps[part], rate[part], force[part]))
    for first, last in ((0, 295_000_000), (101_000_000, 104_000_000), (290_000_000, 295_000_000)):
        found = samples.between(first, last)
        assert found.time_ns[0] <= first
        assert found.time_ns[-1] >= last
        rows = np.searchsorted(stamps, found.time_ns)
        np.testing.assert_array_equal(found.angular_rate_rad_s, rate[rows])
        np.testing.assert_array_equal(found.specific_force_m_s2, force[rows])
    np.testing.assert_array_equal(samples.all().time_ns, stamps)
    with pytest.raises(ValueError, match="samples: expected stamps after 295000000, got 0"):
        samples.add(ImuStream(stamps, rate, force))


@pytest.mark.parametrize(
    "asked", [lambda imu: imu.first_ns, lambda imu: imu.all(), lambda imu: imu.between(0, 1)]
)
def test_no_samples_are_told_where_some_are_asked_for(asked: Callable[[GrowingImu], object]):
    assert GrowingImu().last_ns == -1
    with pytest.raises(ValueError, match="GrowingImu: expected samples, got none"):
        asked(GrowingImu())


class _Images:
    """Visual SLAM of a camera at rest; the world moves by `moved_m` where a loop is closed."""

    metric = True

    def __init__(self, loop_ns: int, moved_m: float) -> None:
        self._loop_ns, self._moved_m = loop_ns, moved_m
        self._stamps: list[int] = []
        self.loops: tuple[int, ...] = ()
        self.asked: list[int] = []

    def track(
        self, time_ns: int, gray: object, *, right: object, predicted: Motor | None
    ) -> SlamFrame:
        self._stamps.append(time_ns)
        if time_ns == self._loop_ns:
            self.loops = (time_ns,)
        closed = time_ns == self._loop_ns
        return SlamFrame(time_ns, "tracking", self._pose(), np.eye(6) * 1e-8, 200, closed)

    def finish(self, *, adjust: bool) -> Any:
        self.asked.append(self._stamps[-1])
        path = Trajectory(np.array(self._stamps), Motor.stack([self._pose()] * len(self._stamps)))
        spread = np.broadcast_to(np.eye(6) * 1e-8, (len(path), 6, 6))
        return SimpleNamespace(trajectory=path, covariance=spread, metric=False)

    def _pose(self) -> Motor:
        return Motor.from_translation([self._moved_m * len(self.loops), 0.0, 0.0])


def _at_rest(images: _Images, rate_hz: int) -> tuple[InertialSlam, IntArray]:
    """SLAM that has a map since 0 ns, the samples of a minute at rest, and the frames' stamps."""
    slam = InertialSlam(CAMERA, ADIS16448, Motor.identity())
    slam._slam = cast("VisualSlam", images)
    still = np.zeros((12_020, 3))
    stamps = 5_000_000 * np.arange(len(still))
    slam.imu(ImuStream(stamps, still, still + np.array([0.0, 0.0, 9.81])))
    return slam, np.arange(0, 60_000_000_000, 1_000_000_000 // rate_hz)


def test_the_filter_goes_into_the_world_that_a_late_loop_leaves(monkeypatch: pytest.MonkeyPatch):
    images = _Images(loop_ns=3_000_000_000, moved_m=1.0)
    slam, stamps = _at_rest(images, 20)
    monkeypatch.setattr(slam, "_start", object())
    monkeypatch.setattr(slam, "_adjusted_s", np.inf)  # nothing but the loop feeds it again
    slam._mapped_ns = 0
    for stamp in stamps[:20].tolist():
        slam.track(stamp, np.zeros(0))
    slam._replay()
    for stamp in stamps[20:62].tolist():
        slam.track(stamp, np.zeros(0))
    assert images.asked == [950_000_000, 3_000_000_000]
    state = slam._filter.state if slam._filter is not None else None
    assert state is not None
    np.testing.assert_allclose(state.world_T_imu.translation_m, [1.0, 0.0, 0.0], atol=0.01)


def test_a_start_that_the_imu_never_tells_is_tried_at_growing_intervals(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(online, "start_inertial", _too_little_motion)
    images = _Images(loop_ns=-1, moved_m=0.0)
    slam, stamps = _at_rest(images, 10)
    for stamp in stamps.tolist():
        slam.track(stamp, np.zeros(0))
    tried = np.array(images.asked) * 1e-9
    np.testing.assert_allclose(tried[:3], [2.0, 2.5, 3.0])
    assert len(tried) < 22
    assert np.all(np.diff(tried[3:]) >= 0.2 * tried[3:-1] - 1e-9)


def _too_little_motion(*_: object, **__: object) -> None:
    raise ValueError("too little motion")


def test_frames_that_samples_do_not_reach_are_refused():
    slam = InertialSlam(
        CAMERA, ADIS16448, Motor.from_rotor_translation(Rotor.identity(), [0, 0, 0])
    )
    gray = np.full((CAMERA.height, CAMERA.width), 90, np.uint8)
    with pytest.raises(ValueError, match="time_ns: expected samples up to 0, got them up to none"):
        slam.track(0, gray)
    still = np.zeros((4, 3))
    slam.imu(ImuStream(5_000_000 * np.arange(4), still, still))
    frame = slam.track(15_000_000, gray)
    assert (frame.state, frame.world_T_camera) == ("initialising", None)
    with pytest.raises(ValueError, match="samples up to 16000000, got them up to 15000000"):
        slam.track(16_000_000, gray)
    found = slam.finish()
    assert (found.start, found.fused, found.states) == (None, None, ("initialising",))
    with pytest.raises(ValueError, match=r"settings\.threads: expected False"):
        InertialSlam(CAMERA, ADIS16448, Motor.identity(), SlamSettings(threads=True))
