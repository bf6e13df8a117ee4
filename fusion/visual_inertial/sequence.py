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

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.graph.inertial import InertialGraph, as_motor, as_pose, as_poses, optimised
from motorcade.fusion.graph.shared import SharedUnknowns, keys
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.visual_inertial.readout import (
    as_recorded,
    camera_twist_rate,
    checked_readout,
    rows_later_s,
    rows_moved_px,
)
from motorcade.fusion.visual_inertial.start import InertialStart, start_inertial
from motorcade.fusion.visual_inertial.window import held_pose_covariance
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.measurements import PoseMeasurements
from motorcade.tracking.slam import SlamResult
from motorcade.tracking.slam.geometry import is_native

if TYPE_CHECKING:
    import gtsam


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


# `adjust_visual_inertial`: keyframes, landmarks and IMU in one adjustment, by gtsam.
#
# Full smoothing over poses, velocities, biases and landmarks: reprojection with Huber's loss,
# gtsam's CombinedImuFactor between keyframes. Nothing but the IMU gives metres and up; position and
# heading of the first keyframe are held. Source: T. Qin, P. Li, S. Shen, VINS-Mono, IEEE TRO 34(4),
# 2018, without its sliding window.

_ITERATIONS = 50
_RELATIVE = 1e-6
_READOUT_ROUNDS = 2
# Landmarks hardly seen from two sides stay where they were, to a hundred metres.
_LANDMARK_SIGMA_M = 100.0


@dataclass(frozen=True, eq=False)
class VisualInertial:
    """Keyframes and landmarks after the adjustment, in metres, z up.

    Fields:
        trajectory: ``world_T_camera`` at the K keyframes.
        velocity_m_s: ``(K, 3)`` of the IMU in the world.
        gyro_bias_rad_s: ``(K, 3)``; accel_bias_m_s2: ``(K, 3)``.
        landmarks_m: ``(L, 3)``; those seen less than twice are where they were given.
        seen: ``(L,)`` whether each took part.
        error_px: ``(N,)`` reprojection error of each observation, infinite behind a camera that is
            no fisheye and where the landmark did not take part.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.visual_inertial.sequence import VisualInertial
        >>> from motorcade.ga import Motor, Trajectory
        >>> world_T_camera = Motor.from_translation([[0.0, 0.0, 1.5], [0.1, 0.0, 1.5]])
        >>> none, velocity_m_s = np.zeros((2, 3)), np.array([[0.2, 0.0, 0.0]] * 2)
        >>> found = VisualInertial(
        ...     Trajectory(np.array([0, 500_000_000]), world_T_camera), velocity_m_s, none, none,
        ...     landmarks_m=np.array([[0.0, 2.0, 1.5], [0.0, 9.0, 1.5]]),
        ...     seen=np.array([True, False]), error_px=np.array([0.2, 0.3, np.inf]),
        ... )
        >>> found.landmarks_m[found.seen], int(np.isfinite(found.error_px).sum())
        (array([[0. , 2. , 1.5]]), 2)
    """

    trajectory: Trajectory
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    landmarks_m: FloatArray
    seen: NDArray[np.bool_]
    error_px: FloatArray


def adjust_visual_inertial(
    keyframes: Trajectory,
    landmarks_m: FloatArray,
    observations: LandmarkObservations,
    camera: Camera,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    *,
    sigma_px: float = 1.0,
    gravity_m_s2: float = 9.81,
    readout_s: float = 0.0,
) -> VisualInertial:
    """Adjust everything together.

    Args:
        keyframes: ``world_T_camera`` to start from, z up within some 20° and metres within some
            20 %: see `start_inertial`. Two or more.
        landmarks_m: ``(L, 3)`` to start from, in the same world.
        observations: what the keyframes saw of them.
        camera: with its distortion.
        imu: must cover the keyframes.
        noise: its densities and walks.
        imu_T_camera: pose of the camera on the IMU.
        sigma_px: noise of a pixel coordinate.
        gravity_m_s2: size of gravity, along -z of the world.
        readout_s: from the first row of an image to the last, 0 for a global shutter; stamps are
            the middle row's. Pixels are taken to the stamp by the motion that was found, and
            everything is adjusted again, twice.

    Raises:
        ValueError: shapes or rows that do not fit, keyframes outside the stream, numbers that are
            not above zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, adjust_visual_inertial
        >>> from motorcade.fusion import simulate_imu
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.visual_inertial.sequence import LandmarkObservations
        >>> from motorcade.ga import Motor
        >>> from motorcade.tracking import Camera
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(handheld(rng), 2.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> keyframes = sensor.path[::50]  # five; the camera is where the IMU is
        >>> points = keyframes.motors[0].apply(rng.uniform([-1, -1, 4], [1, 1, 6], (30, 3)))
        >>> camera = Camera(640, 480, 400.0, 400.0, 320.0, 240.0)
        >>> row, point = np.indices((5, 30)).reshape(2, -1)
        >>> px = camera.project(keyframes.motors[row].inverse().apply(points[point]))
        >>> found = adjust_visual_inertial(
        ...     keyframes, points, LandmarkObservations(row, point, px), camera,
        ...     sensor.stream, ADIS16448, imu_T_camera=Motor.identity(),
        ... )
        >>> bool(np.median(found.error_px) < 0.1)
        True
    """
    import gtsam

    landmarks = _checked(keyframes, landmarks_m, observations, imu)
    checked_positive(sigma_px, "sigma_px")
    checked_positive(gravity_m_s2, "gravity_m_s2")
    checked_readout(readout_s)
    graph = _inertial(keyframes, imu, noise, gravity_m_s2)
    start = keyframes.motors @ imu_T_camera.inverse()
    used = np.bincount(observations.landmark, minlength=len(landmarks)) >= 2
    at_stamp, by_pixels = observations, (imu_T_camera, sigma_px)
    for rounds_left in range(_READOUT_ROUNDS if readout_s > 0.0 else 0, -1, -1):
        factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        _add_states(factors, values, graph, start, keyframes.time_s)
        add_observations(factors, at_stamp, _told(at_stamp, used, camera), camera, *by_pixels)
        _add_landmarks(factors, values, landmarks, used)
        values = optimised(factors, values, _ITERATIONS, _RELATIVE)
        adjusted = _read(values, keyframes, landmarks, used, at_stamp, camera, imu_T_camera)
        if rounds_left:
            at_stamp = _at_stamp(adjusted, observations, camera, imu, imu_T_camera, readout_s)
    return adjusted


def _told(observations: LandmarkObservations, used: NDArray[np.bool_], camera: Camera) -> IntArray:
    """Rows of observations of landmarks in use at pixels that the lens gives a ray."""
    known = np.isfinite(camera.bearings(observations.px)[:, 0])
    return np.flatnonzero(used[observations.landmark] & known)


def _at_stamp(
    adjusted: VisualInertial,
    observations: LandmarkObservations,
    camera: Camera,
    imu: ImuStream,
    imu_T_camera: Motor,
    readout_s: float,
) -> LandmarkObservations:
    """The observations as a global shutter would have had them."""
    keyframes, camera_T_imu = adjusted.trajectory, imu_T_camera.inverse()
    rate = imu.at(keyframes.time_ns).angular_rate_rad_s - adjusted.gyro_bias_rad_s
    twist = camera_twist_rate(
        keyframes.motors @ camera_T_imu, adjusted.velocity_m_s, rate, camera_T_imu
    )
    later_s = rows_later_s(camera, observations.px, readout_s)
    seen = observations.keyframe, adjusted.landmarks_m[observations.landmark]
    moved = rows_moved_px(camera, later_s, keyframes.motors, twist, *seen)
    return replace(observations, px=observations.px - moved)


def _checked(
    keyframes: Trajectory,
    landmarks_m: FloatArray,
    observations: LandmarkObservations,
    imu: ImuStream,
) -> FloatArray:
    landmarks = checked_floats(landmarks_m, "landmarks_m", (3,))
    for name, count in (("keyframe", len(keyframes)), ("landmark", len(landmarks))):
        rows = getattr(observations, name)
        if rows.size and int(rows.max()) >= count:
            raise ValueError(
                f"observations.{name}: expected rows below {count}, got {int(rows.max())}"
            )
    if len(keyframes) < 2:
        raise ValueError("keyframes: expected two or more, got 1")
    stamps = keyframes.time_ns
    if stamps[0] < imu.time_ns[0] or stamps[-1] > imu.time_ns[-1]:
        raise ValueError(
            f"keyframes: expected stamps in [{imu.time_ns[0]}, {imu.time_ns[-1]}], where there are "
            f"samples, got {stamps[0]} to {stamps[-1]}"
        )
    return landmarks


def _inertial(
    keyframes: Trajectory, imu: ImuStream, noise: ImuNoise, gravity_m_s2: float
) -> InertialGraph:
    """The chain of keyframes without any measured pose."""
    return InertialGraph(
        time_ns=keyframes.time_ns,
        imu=imu.around(keyframes.time_ns),
        noise=noise,
        gravity_m_s2=gravity_m_s2,
        measured=np.full(len(keyframes), -1),
        world_T_imu=Motor.identity((0,)),
        covariance=np.zeros((0, 6, 6)),
        gates=[],
        kinds=[],
        also=(),
        shared=SharedUnknowns(Motor.identity(), 0.0, 0.0, 0.0, 0.0, 0.0),
    )


def _add_states(
    factors: gtsam.NonlinearFactorGraph,
    values: gtsam.Values,
    graph: InertialGraph,
    start: Motor,
    time_s: FloatArray,
) -> None:
    """Poses, velocities and biases with what the samples say of them."""
    import gtsam

    bias = gtsam.imuBias.ConstantBias()
    velocity = np.gradient(start.translation_m, time_s, axis=0)
    for index, pose in enumerate(as_poses(start)):
        node = keys(index)
        values.insert(node.pose, pose)
        values.insert(node.velocity, velocity[index])
        values.insert(node.bias, bias)
        if index:
            factors.push_back(graph.motion(index, graph.summed(index, bias)))
    for prior in graph.priors():
        factors.push_back(prior)
    model = gtsam.noiseModel.Gaussian.Covariance(held_pose_covariance(start[0]))
    factors.push_back(gtsam.PriorFactorPose3(keys(0).pose, as_pose(start[0]), model))


def _add_landmarks(
    factors: gtsam.NonlinearFactorGraph,
    values: gtsam.Values,
    landmarks: FloatArray,
    used: NDArray[np.bool_],
) -> None:
    import gtsam

    loose = gtsam.noiseModel.Isotropic.Sigma(3, _LANDMARK_SIGMA_M)
    for row in np.flatnonzero(used).tolist():
        name = gtsam.symbol("l", row)
        values.insert(name, landmarks[row])
        factors.push_back(gtsam.PriorFactorPoint3(name, landmarks[row], loose))


def _read(
    values: gtsam.Values,
    keyframes: Trajectory,
    landmarks: FloatArray,
    used: NDArray[np.bool_],
    observations: LandmarkObservations,
    camera: Camera,
    imu_T_camera: Motor,
) -> VisualInertial:
    import gtsam

    nodes = [keys(index) for index in range(len(keyframes))]
    poses = as_motor([values.atPose3(node.pose) for node in nodes]) @ imu_T_camera
    biases = [values.atConstantBias(node.bias) for node in nodes]
    points = np.array(landmarks)
    for row in np.flatnonzero(used).tolist():
        points[row] = values.atPoint3(gtsam.symbol("l", row))
    own = poses[observations.keyframe].inverse().apply(points[observations.landmark])
    ahead = used[observations.landmark]
    if not is_native(camera):  # a fisheye sees all around
        ahead &= own[:, 2] > 0.0
    error = np.full(len(observations), np.inf)
    error[ahead] = np.linalg.norm(camera.project(own[ahead]) - observations.px[ahead], axis=-1)
    return VisualInertial(
        Trajectory(keyframes.time_ns, poses, keyframes.parent, keyframes.child),
        np.array([values.atVector(node.velocity) for node in nodes]),
        np.array([bias.gyroscope() for bias in biases]),
        np.array([bias.accelerometer() for bias in biases]),
        points,
        used,
        error,
    )


@dataclass(frozen=True, eq=False)
class LandmarkObservations:
    """N observations of L landmarks in K keyframes.

    Args:
        keyframe: ``(N,)`` from 0 on, rows of the keyframes.
        landmark: ``(N,)`` from 0 on, rows of the landmarks.
        px: ``(N, 2)`` where, in the camera's own (distorted) pixels.

    Raises:
        ValueError: shapes that do not agree, numbers below 0, pixels that are not finite, or a
            landmark twice in one keyframe.

    Examples:
        >>> from motorcade.fusion.visual_inertial.sequence import LandmarkObservations
        >>> seen = LandmarkObservations([0, 1], [0, 0], [[320.0, 240.0], [310.5, 240.2]])
        >>> len(seen)
        2
    """

    keyframe: IntArray
    landmark: IntArray
    px: FloatArray

    def __post_init__(self) -> None:
        px = frozen(checked_floats(self.px, "LandmarkObservations.px", (2,)))
        for name in ("keyframe", "landmark"):
            rows = np.array(getattr(self, name))
            if rows.dtype.kind not in "iu" or rows.shape != px.shape[:1] or np.any(rows < 0):
                raise ValueError(
                    f"LandmarkObservations.{name}: expected {px.shape[:1]} whole numbers from 0 "
                    f"on, got dtype {rows.dtype}, shape {rows.shape}"
                )
            rows = rows.astype(np.int64)
            rows.setflags(write=False)
            object.__setattr__(self, name, rows)
        pairs = np.stack([self.keyframe, self.landmark], axis=-1)
        if len(np.unique(pairs, axis=0)) < len(pairs):
            raise ValueError(
                "LandmarkObservations: expected a landmark once in a keyframe, got one twice"
            )
        object.__setattr__(self, "px", px)

    def __len__(self) -> int:
        """Number of observations."""
        return len(self.px)


_HUBER = 1.5


def add_observations(
    factors: gtsam.NonlinearFactorGraph,
    observations: LandmarkObservations,
    rows: IntArray,
    camera: Camera,
    imu_T_camera: Motor,
    sigma_px: float,
) -> None:
    """Add factors between poses and landmarks, of rows ``(m,)`` of what was seen; Huber's loss."""
    import gtsam

    loss = gtsam.noiseModel.mEstimator.Huber.Create(_HUBER)
    pinholes = _pinholes(camera, observations.px[rows], imu_T_camera, sigma_px)
    for row, (seen, noise, lens, extrinsics) in zip(rows.tolist(), pinholes, strict=True):
        pose = keys(int(observations.keyframe[row])).pose
        point = gtsam.symbol("l", int(observations.landmark[row]))
        model = gtsam.noiseModel.Robust.Create(loss, noise)
        between = seen, model, pose, point, lens, False, False, extrinsics
        factors.push_back(gtsam.GenericProjectionFactorCal3_S2(*between))


def _pinholes(
    camera: Camera, px: FloatArray, imu_T_camera: Motor, sigma_px: float
) -> Iterator[tuple[FloatArray, gtsam.noiseModel.Base, gtsam.Cal3_S2, gtsam.Pose3]]:
    """Pixel, its noise, lens and pose on the IMU of a pinhole that saw each pixel ``(m, 2)``.

    That of a fisheye looks along the pixel's ray, with a focal length of 1: there its image and
    the fisheye's differ by a linear map, and the noise goes through that.
    """
    import gtsam

    if not is_native(camera):
        matrix = camera.matrix
        lens = gtsam.Cal3_S2(matrix[0, 0], matrix[1, 1], 0.0, matrix[0, 2], matrix[1, 2])
        same = gtsam.noiseModel.Isotropic.Sigma(2, sigma_px), lens, as_pose(imu_T_camera)
        yield from ((seen, *same) for seen in camera.undistort(px))
        return
    rays = camera.bearings(px)
    camera_T_pinhole = _towards(rays)
    by_plane = camera.project_jacobian(rays)[1] @ camera_T_pinhole[:, :, :2]
    spread = sigma_px**2 * np.linalg.inv(by_plane.swapaxes(-1, -2) @ by_plane)
    turned = Motor.from_rotor_translation(Rotor.from_matrix(camera_T_pinhole), np.zeros(3))
    middle, lens = np.zeros(2), gtsam.Cal3_S2(1.0, 1.0, 0.0, 0.0, 0.0)
    for covariance, extrinsics in zip(spread, as_poses(imu_T_camera @ turned), strict=True):
        yield middle, gtsam.noiseModel.Gaussian.Covariance(covariance), lens, extrinsics


def _towards(rays: FloatArray) -> FloatArray:
    """Rotations ``(m, 3, 3)`` that take z to unit vectors ``(m, 3)``."""
    steep = np.abs(rays[:, 2:]) > np.sqrt(0.5)
    aside = np.cross(np.where(steep, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), rays)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    return np.stack([aside, np.cross(rays, aside), rays], axis=-1)
