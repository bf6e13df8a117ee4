"""`InertialSlam`: visual SLAM with an IMU inside, in metres, z up, as frames come in.

Images make a map first. As soon as the IMU can tell its scale and its lean well enough, the map
goes over to metres, and keyframes are adjusted with the samples between them from then on. A filter
runs along: it predicts where each image is taken from, and where the camera is while it sees
nothing. The whole map is adjusted again whenever what the IMU has felt of it has grown by half, so
that the scale settles.

Sources: C. Campos et al., ORB-SLAM3, IEEE TRO 37(6), 2021, for the order of steps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motorcade.fusion.filter import Fused, PoseFilter, fuse
from motorcade.fusion.filter.pose_filter import FilterState
from motorcade.fusion.filter.settings import FilterSettings
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.visual_inertial.readout import Readout
from motorcade.fusion.visual_inertial.sequence import FLOOR, measured_in_map
from motorcade.fusion.visual_inertial.start import InertialStart, start_inertial
from motorcade.fusion.visual_inertial.window import InertialAdjuster, KeyframeMotion
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.measurements import PoseMeasurements
from motorcade.tracking.slam import SlamFrame, SlamResult, SlamSettings, VisualSlam
from motorcade.tracking.slam.mapping.map import MapSnapshot

InertialState = Literal["initialising", "visual", "tracking", "inertial", "lost"]

# Less motion than this leaves scale, lean and biases to each other; tried again so often, and only
# once there is so much more: each try goes through all so far, so that all tries stay linear.
_FIRST_START_S, _TRY_AGAIN_S, _TRY_AGAIN_SHARE = 2.0, 0.5, 0.2
# The start may be as wrong as linearising forgives; the adjustments that follow do the rest.
_MOST_LOG_SCALE_SIGMA, _MOST_TILT_SIGMA_RAD = 0.05, 0.02
_GROWTH, _SETTLED_S = 1.5, 60.0
# The filter is fed again from so long ago when the map was adjusted.
_REPLAY_S = 10.0
# Inertia alone leads a pose astray by metres before long; it is given as long as it says a place to
# within this (one axis, standard deviation).
_MOST_SIGMA_M = 0.3


@dataclass(frozen=True, eq=False)
class InertialFrame:
    """What is known of a frame as soon as it has been seen.

    Args:
        time_ns: stamp.
        state: "initialising" without a map, "visual" while the IMU tells nothing, "tracking" by
            images and IMU, "inertial" by the IMU alone, "lost" where that is too long ago.
        world_T_camera: metres, z up; None before the map has metres, and where lost.
        covariance: ``(6, 6)`` of the right perturbation, rotation (rad) then translation (m).
        velocity_m_s: ``(3,)`` of the IMU in the world, None where there is no pose.
        visual: what visual SLAM said.

    >>> from motorcade.fusion.visual_inertial.online import InertialFrame
    >>> from motorcade.tracking.slam import SlamFrame
    >>> InertialFrame(0, "initialising", None, None, None, SlamFrame(0, "initialising")).state
    'initialising'
    """

    time_ns: int
    state: InertialState
    world_T_camera: Motor | None
    covariance: FloatArray | None
    velocity_m_s: FloatArray | None
    visual: SlamFrame


@dataclass(frozen=True, eq=False)
class InertialSlamResult:
    """A whole recording.

    Args:
        slam: keyframes, points and frames, in metres with z up where `start` is known.
        start: scale and lean as first found; None where the IMU never told them.
        metric_from_ns: stamp of the frame at which the map got metres; None likewise.
        measurements: poses of the frames that images gave, in metres, as the fused path takes
            them; None likewise.
        fused: the path at all frames from the first pose on, through darkness too; None likewise.
        states: of all frames.
    """

    slam: SlamResult
    start: InertialStart | None
    metric_from_ns: int | None
    measurements: PoseMeasurements | None
    fused: Fused | None
    states: tuple[InertialState, ...]


class InertialSlam:
    """Tracks a camera, or a rectified pair, that an IMU sits on, in metres with z up.

    Feed samples up to each frame's stamp, then the frame. A pair has metres from the start, and
    waits for the IMU only to know what is up and how it moves.

    Args:
        camera: the camera, the left one of a pair.
        noise: the IMU's.
        imu_T_camera: its pose on the IMU, metres.
        settings: of visual SLAM, without threads; `baseline_m` for a pair.
        gravity_m_s2: size of gravity.
        sigma_px: noise of a pixel's coordinate.
        readout_s: from the first row of an image to the last; 0 for a global shutter. Stamps are
            the middle row's. Keyframes are adjusted with it; frames between are tracked without.

    Raises:
        ValueError: settings with threads, or a readout time below 0 or above 0.2 s.
    """

    def __init__(
        self,
        camera: Camera,
        noise: ImuNoise,
        imu_T_camera: Motor,
        settings: SlamSettings | None = None,
        *,
        gravity_m_s2: float = 9.81,
        sigma_px: float = 1.0,
        readout_s: float = 0.0,
    ) -> None:
        if settings is not None and settings.threads:
            raise ValueError("settings.threads: expected False with an IMU inside, got True")
        # A map of its own would have neither the IMU's metres nor its world.
        self._slam = VisualSlam(camera, replace(settings or SlamSettings(), new_maps=False))
        self._noise, self._imu_T_camera = noise, imu_T_camera
        readout = Readout(camera, readout_s) if readout_s != 0.0 else None
        self._adjuster = InertialAdjuster(noise, imu_T_camera, gravity_m_s2, sigma_px, readout)
        self._settings = FilterSettings(gravity_m_s2=gravity_m_s2)
        self._samples = self._adjuster.samples
        self._filter: PoseFilter | None = None
        self._fed_ns = 0
        self._frames: list[tuple[int, InertialState]] = []
        self._mapped_ns: int | None = None
        self._tried_ns = 0
        self._adjusted_s = 0.0
        self._start: InertialStart | None = None
        self._metric_from_ns: int | None = None
        self._replays = False

    def imu(self, samples: ImuStream) -> None:
        """Take the samples since the last call.

        Raises:
            ValueError: samples that do not come after those before.
        """
        self._samples.add(samples)

    def track(self, time_ns: int, gray: GrayImage, right: GrayImage | None = None) -> InertialFrame:
        """Take the next frame.

        Args:
            time_ns: its stamp.
            gray: its image.
            right: the right image of a rectified pair, which needs `SlamSettings.baseline_m`.

        Raises:
            ValueError: samples that do not reach the stamp, or what `VisualSlam.track` refuses.
        """
        if self._samples.last_ns < time_ns:
            last = "none" if self._samples.last_ns < 0 else self._samples.last_ns
            raise ValueError(f"time_ns: expected samples up to {time_ns}, got them up to {last}")
        before = self._advanced(time_ns)
        expected = None if before is None else before.world_T_camera
        closed = len(self._slam.loops)
        seen = self._slam.track(time_ns, gray, right=right, predicted=expected)
        # A loop moves the world under the filter, which would predict in the old one for seconds.
        self._replays |= len(self._slam.loops) > closed
        if seen.world_T_camera is not None and self._mapped_ns is None:
            self._mapped_ns = time_ns
        frame = self._unmeasured(seen) if before is None else self._metric(seen, before)
        self._frames.append((time_ns, frame.state))
        if self._start is None:
            self._try_start(time_ns)
        elif seen.keyframe and self._adjusted_long_ago(time_ns):
            self._slam.adjust_at_next_keyframe()
            self._adjusted_s = (time_ns - (self._mapped_ns or 0)) * 1e-9
            self._replays = True
        return frame

    def snapshot(self) -> MapSnapshot:
        """The map as it is now; in metres with z up once it has them."""
        return self._slam.snapshot()

    def finish(self) -> InertialSlamResult:
        """Adjust everything once more, and give the path at all frames.

        Raises:
            ValueError: no frame was tracked at all.
        """
        slam = self._slam.finish()
        states = tuple(state for _, state in self._frames)
        if self._start is None or slam.trajectory is None:
            return InertialSlamResult(slam, None, None, None, None, states)
        measured = measured_in_map(slam.trajectory, slam.covariance, slam.map.time_ns)
        sensor = self._samples.all(), self._noise, self._imu_T_camera
        fused = fuse(measured, *sensor, slam.time_ns, settings=self._settings, fits_noise=False)
        return InertialSlamResult(slam, self._start, self._metric_from_ns, measured, fused, states)

    # Frames --------------------------------------------------------------------------------------

    def _unmeasured(self, seen: SlamFrame) -> InertialFrame:
        state: InertialState = "initialising" if self._mapped_ns is None else "visual"
        return InertialFrame(seen.time_ns, state, None, None, None, seen)

    def _metric(self, seen: SlamFrame, before: FilterState) -> InertialFrame:
        # A map that began before the IMU told metres has a world and a unit of its own.
        if seen.world_T_camera is None or seen.covariance is None or not self._slam.metric:
            spread = before.covariance[:6, :6]
            adjoint = self._imu_T_camera.inverse().adjoint()
            spread = adjoint @ spread @ adjoint.T
            if np.sqrt(np.linalg.eigvalsh(spread[3:, 3:])[-1]) > _MOST_SIGMA_M:
                return InertialFrame(seen.time_ns, "lost", None, None, None, seen)
            return InertialFrame(
                seen.time_ns, "inertial", before.world_T_camera, spread, before.velocity_m_s, seen
            )
        self._correct(seen)
        after = self._filter.state if self._filter is not None else None
        velocity = (after or before).velocity_m_s
        return InertialFrame(
            seen.time_ns, "tracking", seen.world_T_camera, seen.covariance, velocity, seen
        )

    # The filter ----------------------------------------------------------------------------------

    def _advanced(self, time_ns: int) -> FilterState | None:
        """The filter's state at a stamp, by all samples up to it."""
        if self._filter is None:
            return None
        imu = self._samples.between(self._fed_ns, time_ns)
        rows = slice(*np.searchsorted(imu.time_ns, [self._fed_ns, time_ns], side="right"))
        gyro, accel = imu.angular_rate_rad_s[rows], imu.specific_force_m_s2[rows]
        for row, stamp in enumerate(imu.time_ns[rows].tolist()):
            self._filter.imu(stamp, gyro[row], accel[row])
            self._fed_ns = stamp
        if self._fed_ns < time_ns:
            now = imu.at(np.array([time_ns - 1, time_ns]))
            self._filter.imu(time_ns, now.angular_rate_rad_s[1], now.specific_force_m_s2[1])
            self._fed_ns = time_ns
        return self._filter.state

    def _correct(self, seen: SlamFrame) -> None:
        if self._replays and seen.keyframe:
            self._replay()
        elif self._filter is not None and seen.world_T_camera is not None:
            spread = np.asarray(seen.covariance) + np.diag(FLOOR)
            self._filter.camera_pose(seen.time_ns, seen.world_T_camera, spread)

    def _replay(self) -> None:
        """Feed a new filter with the poses of late, as the map has them now."""
        self._replays = False
        result = self._slam.finish(adjust=False)
        path = result.trajectory
        if path is None:
            return
        self._filter = PoseFilter(
            self._noise, self._imu_T_camera, settings=self._settings, history_s=0.5
        )
        last_ns = int(path.time_ns[-1])
        first = max(last_ns - round(_REPLAY_S * 1e9), self._samples.first_ns)
        rows = np.flatnonzero(path.time_ns >= first)
        self._fed_ns = int(path.time_ns[rows[0]]) - 1
        for row in rows.tolist():
            time_ns = int(path.time_ns[row])
            self._advanced(time_ns)
            spread = result.covariance[row] + np.diag(FLOOR)
            self._filter.camera_pose(time_ns, path.motors[row], spread)

    # Metres --------------------------------------------------------------------------------------

    def _adjusted_long_ago(self, time_ns: int) -> bool:
        known_s = (time_ns - (self._mapped_ns or 0)) * 1e-9
        return known_s < _SETTLED_S and known_s > _GROWTH * self._adjusted_s

    def _try_start(self, time_ns: int) -> None:
        """Give the map metres as soon as the IMU tells them."""
        if self._mapped_ns is None or time_ns - self._mapped_ns < _FIRST_START_S * 1e9:
            return
        tried_s = (self._tried_ns - self._mapped_ns) * 1e-9
        if (time_ns - self._tried_ns) * 1e-9 < max(_TRY_AGAIN_S, _TRY_AGAIN_SHARE * tried_s):
            return
        self._tried_ns = time_ns
        result = self._slam.finish(adjust=False)
        path = result.trajectory
        if path is None:
            return
        measured = PoseMeasurements(path, result.covariance + np.diag(FLOOR))
        try:
            start = start_inertial(
                measured, self._samples.all(), self._noise, self._imu_T_camera, metric=result.metric
            )
        except ValueError:
            return  # too little motion so far: the frame's state stays "visual", which says so
        sigmas = np.array([start.log_scale_sigma, start.tilt_sigma_rad])
        if np.any(sigmas > (_MOST_LOG_SCALE_SIGMA, _MOST_TILT_SIGMA_RAD)):
            return
        self._start, self._metric_from_ns = start, time_ns
        biases = np.concatenate([start.gyro_bias_rad_s, start.accel_bias_m_s2], axis=-1)
        motions = map(KeyframeMotion, start.velocity_m_s, biases)
        self._adjuster.motions = dict(zip(start.time_ns.tolist(), motions, strict=True))
        self._slam.rescale(start.world_T_visual, self._adjuster)
        self._slam.adjust_at_next_keyframe()
        self._adjusted_s = (time_ns - self._mapped_ns) * 1e-9
        self._replay()
        self._replays = True
