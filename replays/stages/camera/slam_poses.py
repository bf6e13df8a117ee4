"""Stage `slam_poses`: camera poses by visual SLAM; no board is needed.

The world is the first camera that has a pose; where an IMU gives one camera's map its metres, the
world stands upright where that map has its origin.

The deviation of the scale believes the poses' own covariances. A map that drifts, or a lens that is
not quite the one it was made with, errs otherwise, and a scale far off may then come out as sure;
so the IMU is asked again whether the path that it gave metres to is one that it felt.

The cameras of an RGB-D recording are found where its images contradict those that are stated. Edges
tell how depth lies on colour, so the ratio of both focal lengths, but not which of the two is
wrong: the first frames are tracked once more, and both focal lengths adjusted with their poses.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.filter import FilterSettings, fuse
from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.fusion.metrics import most_by_chance
from motorcade.fusion.visual_inertial.online import InertialSlam, InertialSlamResult
from motorcade.fusion.visual_inertial.sequence import MetricMap, metric_map
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.progress import track
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import (
    as_found,
    camera_of,
    require_images,
    rows_readout_s,
)
from motorcade.replays.stages.camera.sensor_audit import (
    audited_depth,
    audited_pair,
    measured_depth,
    refined_by_depth,
)
from motorcade.replays.stages.inertial.filter_input import assumed_noise
from motorcade.replays.stages.values.camera_poses import SightedPoints
from motorcade.replays.stages.values.inertial import InertialHistory
from motorcade.replays.stages.values.slam_poses import SlamPoses
from motorcade.tracking import PoseMeasurements, TrackingError
from motorcade.tracking.audit import AuditFinding, centre_finding
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.cameras import DepthCamera
from motorcade.tracking.depth.refine import FocalFactor, focal_factor
from motorcade.tracking.slam.geometry import seen_through

if TYPE_CHECKING:
    from motorcade.tracking.slam import MapSnapshot, SlamResult, SlamSettings


log = logging.getLogger("motorcade.slam")

# Frames that no sample covers get no pose: so few may be left out at either end for its sake.
_MOST_OUTSIDE_S = 0.5
_FEWEST_SAMPLES = 2  # beyond a frame's stamp, so that readings at the stamp lie between two


@dataclass(frozen=True, eq=False)
class MappedWithImu:
    """A finished run, its map in metres with z up, and what the IMU told."""

    slam: SlamResult
    measurements: PoseMeasurements
    history: InertialHistory


def carries_imu(recording: Recording) -> bool:
    """Whether a camera or a pair was recorded with an IMU that sits somewhere known, all along."""
    imu, stamps = recording.imu, recording.frames.time_ns
    if imu is None or recording.imu_T_camera is None or len(imu) <= _FEWEST_SAMPLES:
        return False
    outside_ns = max(imu.time_ns[0] - stamps[0], stamps[-1] - imu.time_ns[-_FEWEST_SAMPLES])
    without_depth = recording.frames[0].read_depth is None
    return (
        without_depth and recording.slam_map is None and bool(outside_ns <= 1e9 * _MOST_OUTSIDE_S)
    )


def mapped_with_imu(recording: Recording, settings: SlamSettings) -> MappedWithImu | None:
    """Track a recording that `carries_imu`, with the samples inside; None: they told no metres."""
    imu, imu_T_camera = recording.imu, recording.imu_T_camera
    if imu is None or imu_T_camera is None:
        raise ValueError("recording: expected one that carries an IMU, got none")
    noise = assumed_noise(recording.imu_noise or ADIS16448, "recorded")
    slam = InertialSlam(
        camera_of(recording), noise, imu_T_camera, settings, readout_s=rows_readout_s(recording)
    )
    stamps, fed = recording.frames.time_ns, 0
    covered = np.flatnonzero((stamps >= imu.time_ns[0]) & (stamps <= imu.time_ns[-_FEWEST_SAMPLES]))
    if not len(covered):
        return None
    for row in track(covered.tolist(), "mapping with the IMU", len(covered)):
        frame = recording.frames[row]
        fed = _fed(slam, imu, fed, frame.time_ns)
        right = None if settings.baseline_m is None else frame.right()
        slam.track(frame.time_ns, frame.gray(), right)
    return _metric_map(recording, slam.finish())


def _fed(slam: InertialSlam, imu: ImuStream, fed: int, time_ns: int) -> int:
    """Hand over samples until they reach beyond a stamp; returns how many were given so far.

    A stream is two samples or more, so none is left by itself.
    """
    reached = int(np.searchsorted(imu.time_ns, time_ns)) + _FEWEST_SAMPLES
    if reached <= fed:
        return fed
    reached = max(reached, fed + _FEWEST_SAMPLES)
    if len(imu) - reached < _FEWEST_SAMPLES:
        reached = len(imu)
    rows = slice(fed, reached)
    turn, force = imu.angular_rate_rad_s[rows], imu.specific_force_m_s2[rows]
    slam.imu(ImuStream(imu.time_ns[rows], turn, force))
    return reached


def _metric_map(recording: Recording, result: InertialSlamResult) -> MappedWithImu | None:
    start, measurements = result.start, result.measurements
    if start is None or result.metric_from_ns is None or measurements is None:
        log.info("%s: no metres while mapping, so they are looked for afterwards", recording.name)
        return None
    scale = float(start.world_T_visual.scale)
    history = InertialHistory(
        result.slam.time_ns,
        result.states,
        result.metric_from_ns,
        scale,
        start.log_scale_sigma,
        start.world_T_visual.rotor.inverse().apply(np.array([0.0, 0.0, -1.0])),
        start.tilt_sigma_rad,
        rows_readout_s(recording),
    )
    return MappedWithImu(result.slam, measurements, history)


_FIRST_S = 5.0
"""A hand turns a camera by tens of degrees in that time."""
_OFF = 0.02
"""Share of a focal length that is worth telling: calibrations are good to a hundredth."""
_DEVIATIONS = 3.0
_FARTHEST = 2.0 * _OFF
"""So far may the deviations reach: a lens that is wrong by 5 % still differs from a right one."""
_NAME = "focal_lengths"


@dataclass(frozen=True, eq=False)
class FoundCameras:
    """What took images and depth, None where it is as stated, and what the audit says."""

    camera: Camera | None
    depth_camera: DepthCamera | None
    audit: tuple[AuditFinding, ...]


def found_cameras(recording: Recording) -> FoundCameras:
    """Look whether depth lies on colour; where it does not, find the cameras with which it does."""
    depth_camera, audit = audited_depth(recording)
    if depth_camera is None:
        return FoundCameras(None, None, audit)
    stated = measured_depth(recording)[0].camera
    if abs(np.log(depth_camera.camera.fx / stated.fx)) < _OFF:
        return FoundCameras(None, depth_camera, audit)
    registered = as_found(recording, None, depth_camera)
    correction = _factor(registered)
    if correction is None or _DEVIATIONS * correction.sigma > _FARTHEST:
        summary = f"the first {_FIRST_S:g} s do not tell which focal length is wrong"
        finding = AuditFinding(_NAME, "unknown", None, "share", f"{summary}; depth's was corrected")
        return FoundCameras(None, depth_camera, (*audit, finding))
    colour = _longer(camera_of(recording), correction.factor)
    depth = _longer(depth_camera.camera, correction.factor)
    finding = _told(camera_of(recording), stated, correction, (colour, depth))
    return FoundCameras(colour, DepthCamera(depth, depth_camera.colour_T_depth), (*audit, finding))


def _factor(recording: Recording) -> FocalFactor | None:
    """By what both focal lengths are wrong alike, as the first frames have it."""
    from motorcade.tracking.slam import VisualSlam

    frames, camera = recording.frames, camera_of(recording)
    slam = VisualSlam(camera)
    count = int(np.searchsorted(frames.time_ns - frames.time_ns[0], 1e9 * _FIRST_S))
    for number in track(range(count), "finding focal lengths", count):
        frame = frames[number]
        slam.track(frame.time_ns, frame.gray(), frame.still().depth_m(), None)
    result = slam.finish()
    if result.trajectory is None or not result.metric:
        return None
    taken_by, depth_m = measured_depth(recording)
    index = {stamp: row for row, stamp in enumerate(frames.time_ns.tolist())}
    return focal_factor(
        result.map,
        result.trajectory,
        seen_through(camera),
        taken_by,
        lambda time_ns: depth_m(index[time_ns]),
    )


def _longer(camera: Camera, factor: float) -> Camera:
    return replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)


def _told(
    colour: Camera, depth: Camera, by: FocalFactor, cameras: tuple[Camera, Camera]
) -> AuditFinding:
    """What is said of both focal lengths beside those that were stated."""
    off = [one.fx / stated.fx - 1.0 for one, stated in zip(cameras, (colour, depth), strict=True)]
    most = max(map(abs, off))
    sigma_px = by.sigma / by.factor * cameras[0].fx, by.sigma / by.factor * cameras[1].fx
    summary = (
        f"colour's focal length looks like {cameras[0].fx:.0f} ± {sigma_px[0]:.0f} px "
        f"({colour.fx:.0f} stated), depth's like {cameras[1].fx:.0f} ± {sigma_px[1]:.0f} px "
        f"({depth.fx:.0f} stated); tracked with these"
    )
    advice = "calibrate both, or state these"
    return AuditFinding(_NAME, "contradicted", most, "share", summary, advice)


_SIGMA_FLOOR_RAD, _SIGMA_FLOOR_M = 1e-4, 1e-4


def slam_poses(
    recording: Recording,
    *,
    adjust: bool = True,
    close_loops: bool = True,
    threads: bool = False,
    imu_inside: bool = True,
) -> SlamPoses:
    """Track a recording by what it sees, with its depth or else its right images if it has any.

    In a saved map of the place, where the recording brings one, it goes on: the world is then that
    map's, and until the camera finds itself in it there is no pose. The covariance is that of each
    frame's pose within the map; that the map itself drifts is not in it.

    With depth, the surfaces of keyframes are laid on each other in the end, and the path follows.
    One camera or a pair that was recorded with an IMU goes over to metres and up as soon as the IMU
    tells them, and is mapped and tracked with it from then on; if it never tells them, what one
    camera's images alone gave is adjusted with the IMU afterwards.

    `adjust` and `close_loops` switched off show what the map's adjustment and its loops are worth;
    `threads` maps in a second thread, after which two runs may differ, and `imu_inside` switched
    off keeps the IMU till afterwards, as `threads` or no `adjust` do.

    Raises:
        NotOffered: no camera known, or no images.
        TrackingError: nothing in the images from which a map could start.
    """
    camera_of(recording)
    require_images(recording)
    from motorcade.tracking.slam import SlamSettings

    start = time.perf_counter()
    paired = recording.baseline_m is not None and recording.frames[0].read_depth is None
    settings = SlamSettings(
        adjust=adjust,
        close_loops=close_loops,
        threads=threads,
        baseline_m=recording.baseline_m if paired else None,
    )
    cameras = found_cameras(recording)
    audit = cameras.audit
    recording = as_found(recording, cameras.camera, cameras.depth_camera)
    if recording.baseline_m is not None:
        audit = (*audit, *audited_pair(recording))
    mapped = None
    if imu_inside and adjust and not threads and carries_imu(recording):
        mapped = mapped_with_imu(recording, settings)
    if mapped is not None:
        poses = _with_imu_inside(recording, mapped)
    else:
        try:
            result = _by_vision(recording, settings)
        except TrackingError as fault:
            findings = filter(None, (*audit, centre_finding(camera_of(recording))))
            reasons = [finding.sentence for finding in findings if not finding.passed]
            raise TrackingError("; ".join([str(fault), *reasons])) from fault
        if result.metric and adjust and not paired and recording.slam_map is None:
            result = refined_by_depth(recording, result) or result
        poses = _measured(recording, result)
    return replace(
        poses,
        seconds=time.perf_counter() - start,
        audit=audit,
        camera=cameras.camera,
        depth_camera=cameras.depth_camera,
    )


def _by_vision(recording: Recording, settings: SlamSettings) -> SlamResult:
    """A finished run by images, and depth or right images where there are some."""
    from motorcade.tracking.slam import VisualSlam

    known = recording.slam_map
    slam = VisualSlam(camera_of(recording), settings, known=known, extend=known is not None)
    for frame in track(recording.frames, "mapping", len(recording.frames)):
        right = None if settings.baseline_m is None else frame.right()
        slam.track(frame.time_ns, frame.gray(), frame.still().depth_m(), right)
    result = slam.finish()
    if result.trajectory is None:
        raise TrackingError(
            f"{recording.name}: visual SLAM found no pose: too little texture, a camera that only "
            "turns, or images taken too far apart to be followed; film past things at different "
            "depths, or lay a printed board into view"
        )
    return result


def _measured(recording: Recording, result: SlamResult) -> SlamPoses:
    """The path in metres where depth, a known map or an IMU gives them, else in the map's unit."""
    if result.metric:
        return _as_mapped(recording, result, "with depth")
    try:
        metres = in_metres(recording, result)
    except NoMetres as why:
        scale = f"by one camera (scale: free, lengths have no unit; {why})"
        return _as_mapped(recording, result, scale)
    return _by_inertia(recording, result, metres)


def _as_mapped(recording: Recording, result: SlamResult, scale: str) -> SlamPoses:
    """The path as it was tracked."""
    path = result.trajectory
    if path is None:
        raise ValueError("result: expected a run of SLAM that found poses, got none")
    floor = np.repeat((_SIGMA_FLOOR_RAD**2, _SIGMA_FLOOR_M**2), 3)
    covariance: FloatArray = result.covariance + np.diag(floor)
    resumed = recording.slam_map is not None
    first_T_world = Motor.identity() if resumed else path.motors[0].inverse()
    in_world = path.transformed_by(left=first_T_world)
    if recording.readout_s > 0.0:
        scale += f", the readout time of {1e3 * recording.readout_s:g} ms left aside without an IMU"
    poses = _poses_of(recording, result, PoseMeasurements(in_world, covariance), scale)
    points = first_T_world.apply(result.map.points)
    return replace(poses, metric=result.metric, points=points)


def _poses_of(
    recording: Recording,
    result: SlamResult,
    measurements: PoseMeasurements,
    scale: str,
    unit: float = 1.0,
) -> SlamPoses:
    """What every run of SLAM leaves; `unit` is what the map's unit is in the poses'."""
    return SlamPoses(
        measurements,
        recording.frames.time_ns,
        np.full(len(measurements), np.nan),
        "slam",
        _summary(recording, result, scale),
        points=result.map.points,
        sighted=_sighted(recording, result.map, measurements.trajectory, unit),
        slam_map=result.map,
        slam_history=result.history,
    )


def _by_inertia(recording: Recording, result: SlamResult, metres: Metres) -> SlamPoses:
    """The path in metres, z up."""
    unit, sigma = metres.scaled_map.metres_a_unit, metres.scale_sigma
    scale = (
        f"by one camera, metres and up found by the IMU (the map's unit is {unit:.4g} m "
        f"± {100 * sigma:.2g} %)"
    )
    poses = _poses_of(recording, result, metres.scaled_map.measurements, scale, unit)
    points = metres.scaled_map.keyframes.landmarks_m
    return replace(poses, points=points, metres_a_unit=unit, scale_sigma=sigma)


def _with_imu_inside(recording: Recording, mapped: MappedWithImu) -> SlamPoses:
    """The path in metres, z up, that SLAM with an IMU inside gave."""
    result, history = mapped.slam, mapped.history
    after = f"{history.metric_from_s:.1f} s after the first frame"
    scale, unit, sigma = f"by a stereo pair with the IMU inside, upright {after}", None, None
    if recording.baseline_m is None:
        unit, sigma = history.metres_a_unit, history.scale_sigma
        scale = (
            f"by one camera with the IMU inside, metres and up {after} (the map's unit was "
            f"{unit:.4g} m ± {100 * sigma:.2g} % then)"
        )
    poses = _poses_of(recording, result, mapped.measurements, scale)
    return replace(poses, metres_a_unit=unit, scale_sigma=sigma, inertial=history)


def _sighted(
    recording: Recording, known: MapSnapshot, measured: Trajectory, unit: float = 1.0
) -> SightedPoints | None:
    """The map's points as this recording's keyframes saw them; None where it has no keyframes.

    They hang on the measured poses, in their world and in metres where an IMU gave these.
    """
    own = np.flatnonzero(np.isin(known.time_ns, measured.time_ns))
    kept = np.isin(known.keyframe_of, own)
    if not np.any(kept):
        return None
    frame = known.keyframe_of[kept]
    camera_T_map = known.world_T_camera[frame].inverse()
    in_camera = unit * camera_T_map.apply(known.points[known.point_of[kept]])
    points = measured.motors_at(known.time_ns[frame]).apply(in_camera)
    camera = seen_through(camera_of(recording))
    return SightedPoints(camera, known.time_ns, frame, points, known.px[kept])


def _summary(recording: Recording, result: SlamResult, scale: str) -> str:
    resumed = "in a saved map, " if recording.slam_map is not None else ""
    text = f"tracked by visual SLAM {resumed}{scale}"
    loops = result.history.count("loop closed")
    if loops:
        text += f", {loops} {'loops' if loops > 1 else 'loop'} closed"
    if result.separate:
        apart = sum(0 if one.trajectory is None else len(one.trajectory) for one in result.separate)
        text += (
            f"; {apart} frames lie in {len(result.separate)} other maps, which nothing connects to "
            "this one, and have no pose here"
        )
    return text


_MOST_SIGMA = 0.1
_CONTAMINATION = 0.1
"""Share of the poses that may contradict the IMU, as in the check of the run (`integrity`)."""
_FREEDOM = 6


class NoMetres(ValueError):
    """The IMU does not tell the scale; the message says why."""


@dataclass(frozen=True, eq=False)
class Metres:
    """The map in metres with z up, and the relative deviation of its scale."""

    scaled_map: MetricMap
    scale_sigma: float


def in_metres(recording: Recording, result: SlamResult) -> Metres:
    """Give a finished run of SLAM scale and up, by the recorded IMU at its recorded stamps.

    Raises:
        NoMetres: no IMU, one that is not known to sit anywhere, motion that tells the scale to no
            better than a tenth, or a path in metres that the IMU contradicts.
    """
    imu, camera = recording.imu, recording.camera
    if imu is None or camera is None:
        raise NoMetres("no IMU whose extrinsics are known was recorded")
    if recording.imu_T_camera is None:
        raise NoMetres("where the camera sits on the IMU is not known")
    noise = assumed_noise(recording.imu_noise or ADIS16448, "recorded")
    try:
        readout_s = rows_readout_s(recording)
        scaled_map = metric_map(result, camera, imu, noise, recording.imu_T_camera, readout_s)
    except (ValueError, RuntimeError) as refused:  # gtsam's own errors are RuntimeErrors
        raise NoMetres(f"the IMU does not tell the scale: {refused}") from refused
    sigma = scaled_map.start.log_scale_sigma
    if not sigma <= _MOST_SIGMA:
        raise NoMetres(
            f"the IMU tells the scale to ±{100 * sigma:.0f} % only: too little acceleration"
        )
    beyond, count = _contradicting(scaled_map, imu, noise, recording.imu_T_camera)
    if beyond > most_by_chance(count, _CONTAMINATION):
        raise NoMetres(
            f"the IMU does not tell the scale: {beyond} of {count} poses of the path that it was "
            "to bring to metres contradict it"
        )
    return Metres(scaled_map, sigma)


def _contradicting(
    scaled_map: MetricMap, imu: ImuStream, noise: ImuNoise, imu_T_camera: Motor
) -> tuple[int, int]:
    """How many of the poses in metres the filter's gate would not let pass, and of how many."""
    stamps = scaled_map.measurements.trajectory.time_ns
    fused = fuse(scaled_map.measurements, imu, noise, imu_T_camera, stamps)
    judged = fused.nis[np.isfinite(fused.nis)]
    return int(np.count_nonzero(judged > FilterSettings().gate_limit(_FREEDOM))), len(judged)
