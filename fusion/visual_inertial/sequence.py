"""What monocular SLAM left behind, and an IMU: a metric map, and one path through darkness.

`metric_map` starts, and adjusts keyframes and points; `fuse` with its measurements adds the frames
between, and where the camera saw nothing.

Examples:
    A map of forty points along three seconds, in units of two metres:

    >>> import numpy as np
    >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
    >>> from motorcade.fusion.motions import gimbal_crossing
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.tracking import Camera, MapSnapshot, SlamResult
    >>> from motorcade.tracking.slam import SlamHistory
    >>> rng = np.random.default_rng(0)
    >>> sensor = simulate_imu(ContinuousPath.along(gimbal_crossing(), 3.0), 100.0, ADIS16448, rng)
    >>> frames, camera = sensor.path[::5], Camera(640, 480, 400.0, 400.0, 320.0, 240.0)
    >>> half_m = 0.5 * frames.motors.translation_m
    >>> map_T_camera = Motor.from_rotor_translation(frames.motors.rotor, half_m)
    >>> keyframes = map_T_camera[::10]
    >>> points = keyframes[0].apply(rng.uniform([-1, -1, 2], [1, 1, 3], (40, 3)))
    >>> row, point = np.indices((len(keyframes), 40)).reshape(2, -1)
    >>> px = camera.project(keyframes[row].inverse().apply(points[point]))
    >>> seen = np.isfinite(px).all(axis=-1)
    >>> row, point, px, unknown = row[seen], point[seen], px[seen], np.full(seen.sum(), np.nan)
    >>> looks = np.zeros((40, 32), np.uint8)
    >>> snapshot = MapSnapshot(frames.time_ns[::10], keyframes, points, looks, row, point, px,
    ...     unknown, metric=False)
    >>> path = Trajectory(frames.time_ns, map_T_camera)
    >>> covariance = np.broadcast_to(1e-6 * np.eye(6), (len(path), 6, 6))
    >>> none = np.zeros(len(path), np.int64)
    >>> history = SlamHistory(path.time_ns, ("tracking",) * len(path), none, none, none, ())
    >>> result = SlamResult(path, covariance, history, path, snapshot, (), False, (), {})

    >>> from motorcade.fusion import fuse
    >>> from motorcade.fusion.visual_inertial import metric_map
    >>> imu, on_imu = sensor.stream, Motor.identity()
    >>> found = metric_map(result, camera, imu, ADIS16448, imu_T_camera=on_imu)
    >>> bool(abs(found.start.world_T_visual.scale - 2.0) < 0.05)
    True
    >>> bool(np.median(found.keyframes.error_px) < 0.1)
    True
    >>> stamps_ns = np.asarray(result.time_ns)
    >>> fused = fuse(found.measurements, imu, ADIS16448, on_imu, stamps_ns, fits_noise=False)
    >>> fused.trajectory
    Trajectory(world_T_camera, 61 poses, 3.000 s)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.visual_inertial.readout import as_recorded
from motorcade.fusion.visual_inertial.start import InertialStart, start_inertial
from motorcade.fusion.visual_inertial.tight import (
    LandmarkObservations,
    VisualInertial,
    adjust_visual_inertial,
)
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.measurements import PoseMeasurements
from motorcade.tracking.slam import SlamResult

# No frame is surer than this (rad, units of the map, metres), whatever its corners say: the
# keyframes that it hangs on are not. A map's unit is about the depth of what it shows.
FLOOR = np.repeat([1e-3, 2e-3], 3) ** 2
# Keyframes are the map: what their pixels leave open was adjusted, with those of all others. A
# tenth stays for what repeats in neighbours, as a lens that is not quite known.
_KEYFRAME_FLOOR = 0.1**2 * FLOOR


@dataclass(frozen=True, eq=False)
class MetricMap:
    """Frames, keyframes and points in metres with z up, and what they started from.

    Fields:
        measurements: ``world_T_camera`` of the frames with a pose, hung on the keyframes.
        keyframes: after the adjustment, with all points of the map.
        start: scale and up as first found, with their deviations.
        metres_a_unit: scale in the end.
    """

    measurements: PoseMeasurements
    keyframes: VisualInertial
    start: InertialStart
    metres_a_unit: float


def metric_map(
    result: SlamResult,
    camera: Camera,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    readout_s: float = 0.0,
) -> MetricMap:
    """Give a finished run of visual SLAM metres and up.

    Args:
        result: one map, its unit free or metres.
        camera: what SLAM ran with.
        imu: the stream, on the camera's clock; frames outside it are left out.
        noise: its densities and walks.
        imu_T_camera: pose of the camera on the IMU.
        readout_s: from the first row of an image to the last; see `adjust_visual_inertial`.

    Raises:
        ValueError: a run without poses, or what `start_inertial` refuses.
    """
    path, snapshot = result.trajectory, result.map
    if path is None:
        raise ValueError("result: expected a run of SLAM that found poses, got none")
    poses = PoseMeasurements(path, result.covariance + np.diag(FLOOR))
    start = start_inertial(poses, imu, noise, imu_T_camera)
    inside = (snapshot.time_ns >= imu.time_ns[0]) & (snapshot.time_ns <= imu.time_ns[-1])
    own = Trajectory(snapshot.time_ns[inside], snapshot.world_T_camera[inside])
    before = start.in_metres(own)
    seen = inside[snapshot.keyframe_of]
    rows = np.cumsum(inside) - 1
    px = as_recorded(camera, snapshot.px[seen])
    observations = LandmarkObservations(
        rows[snapshot.keyframe_of[seen]], snapshot.point_of[seen], px
    )
    points, sensor = start.world_T_visual.apply(snapshot.points), (imu, noise, imu_T_camera)
    keyframes = adjust_visual_inertial(
        before, points, observations, camera, *sensor, readout_s=readout_s
    )
    scale = float(start.world_T_visual.scale) * _spread(keyframes.trajectory) / _spread(before)
    measured = _in_metres(path, result.covariance, own, keyframes.trajectory.motors, scale)
    return MetricMap(measured, keyframes, start, scale)


def measured_in_map(
    path: Trajectory, covariance: FloatArray, keyframes_ns: IntArray
) -> PoseMeasurements:
    """Frames of a finished run as measurements of a filter.

    Between keyframes each frame hangs on one of them by what was known of the map at the time; so
    errors of neighbours are alike, and an IMU leads from keyframe to keyframe better than many of
    them together would say.

    Args:
        path: of all frames, in metres.
        covariance: ``(n, 6, 6)`` of each by its own corners alone.
        keyframes_ns: stamps of the keyframes that were adjusted.
    """
    floor = np.where(np.isin(path.time_ns, keyframes_ns)[:, None], _KEYFRAME_FLOOR, FLOOR)
    spread = covariance + floor[:, :, None] * np.eye(6)
    return PoseMeasurements(path, 0.5 * (spread + spread.swapaxes(-1, -2)))


def _spread(path: Trajectory) -> float:
    """RMS of positions about their mean, metres."""
    places = path.motors.translation_m
    return float(np.sqrt(np.mean(np.sum((places - places.mean(axis=0)) ** 2, axis=-1))))


def _in_metres(
    path: Trajectory, covariance: FloatArray, own: Trajectory, adjusted: Motor, scale: float
) -> PoseMeasurements:
    """Frames hung on the adjusted keyframes as they hung on the map's own."""
    after = np.clip(np.searchsorted(own.time_ns, path.time_ns), 1, max(1, len(own) - 1))
    nearer = path.time_ns - own.time_ns[after - 1] < own.time_ns[after] - path.time_ns
    row = np.where(nearer, after - 1, after)
    relative = own.motors[row].inverse() @ path.motors
    metric = Motor.from_rotor_translation(relative.rotor, scale * relative.translation_m)
    units = np.repeat([1.0, scale], 3)
    in_world = Trajectory(path.time_ns, adjusted[row] @ metric, "world", "camera")
    return measured_in_map(in_world, units[:, None] * covariance * units, own.time_ns)
