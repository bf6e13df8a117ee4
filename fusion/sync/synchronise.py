"""`synchronise`: the time offset between a camera and an IMU, and how one sits on the other.

Poses that contradict their neighbours are left out first. Each neighbour foretells a pose: its
orientation by its own and by what the gyroscope turned between, its place by the lines through
pairs of them. Medians of what each misses outvote neighbours that are wrong themselves.

How fast a rigid body turns is the same number in every one of its frames, so the norms of both
angular rates match before anything is known of the extrinsics. Sources: E. Mair et al.,
Spatio-temporal initialization for IMU to camera registration, ROBIO 2011; G. Wahba, A least squares
estimate of satellite attitude, SIAM Review 7(3), 1965.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.check import check_health, check_stamps
from motorcade.fusion.health.gyroscope import (
    LEAST_OVERLAP_S,
    CameraRates,
    TurnedAngle,
    norm_correlations,
)
from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import GRAVITY_SIGMA_M_S2, STANDARD_GRAVITY_M_S2, ImuStream
from motorcade.fusion.measurements.interface import skew
from motorcade.fusion.sync.alignment import GRAVITY, ROTATION, Aligned, Beliefs, Shared, align
from motorcade.fusion.sync.rotations import offset_by_rotations
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

log = logging.getLogger("motorcade.sync")

_LEVER_SIGMA_M = 1.0
_MARGIN_S = 0.1
_MOST_SEARCH_S = 60.0
# Unknowns and time grow with poses; errors of poses that follow each other faster hardly differ.
_SPACING_NS = 20_000_000
# Of the deviation that rates state for the offset: the estimate believes them no more than this,
# since it uses the same data again, and does not leave it.
_DOUBT = 6.0
# Times the accelerometer's noise, at which it tells nothing of the extrinsics.
_DEAF = 30.0
_NO_OFFSET_MENDS = (
    "rate_unit",
    "rate_sign",
    "rate_axes",
    "force_unit",
    "force_sign",
    "force_axes",
    "axes",
    "gravity",
)
_UNLIKELY = 10.83  # χ² with one degree of freedom exceeds it once in a thousand cases


@dataclass(frozen=True, eq=False)
class Synchronised:
    """How a camera and an IMU belong together.

    Fields:
        offset_s: what the IMU's clock shows at an event minus what the camera's shows.
        imu_T_camera: pose of the camera on the IMU.
        gravity_m_s2: ``(3,)`` in the world of the camera's poses.
        covariance: ``(10, 10)`` of offset (s), extrinsics (right perturbation in the camera's axes:
            rotation in rad, lever arm in m) and gravity (m/s²).
        gyro_bias_rad_s: ``(N, 3)``; accel_bias_m_s2: ``(N, 3)``, at the poses that were used.
        time_ns: ``(N,)`` their stamps on the camera's clock.
        correlation: of the norms of both angular rates at the start's offset.
        camera_sigma_rad, camera_sigma_m: noise of the camera's poses, an axis, as found.
        imu_noise: the IMU's noise as found, never below the stated: vibration and faults of scale
            and axes show here, and a filter that uses it weighs the sensor as it is.
        health: what else is wrong with the recording, and what cannot be told of it.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 6.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import synchronise
        >>> from motorcade.ga import Trajectory
        >>> camera = measured.trajectory
        >>> late = Trajectory(camera.time_ns - 30_000_000, camera.poses)
        >>> found = synchronise(late, sensor.stream, ADIS16448, search_s=0.2)

        >>> int(np.rint(found.on_imu_clock(late).time_ns[0] / 1e7))  # to 10 ms
        0
    """

    offset_s: float
    imu_T_camera: Motor
    gravity_m_s2: FloatArray
    covariance: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    time_ns: IntArray
    correlation: float
    camera_sigma_rad: float
    camera_sigma_m: float
    imu_noise: ImuNoise
    health: Health

    @property
    def offset_sigma_s(self) -> float:
        """Deviation of the offset."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def rotation_sigma_rad(self) -> FloatArray:
        """Deviations ``(3,)`` of the extrinsics' rotation about the camera's axes."""
        return np.sqrt(np.diag(self.covariance)[1:4])

    @property
    def lever_arm_sigma_m(self) -> FloatArray:
        """Deviations ``(3,)`` of the camera's place along the IMU's axes."""
        turn = self.imu_T_camera.rotor.as_matrix()
        return np.sqrt(np.diag(turn @ self.covariance[4:7, 4:7] @ turn.T))

    def on_imu_clock(self, camera: Trajectory) -> Trajectory:
        """The same poses with the IMU's stamps."""
        stamps = camera.time_ns + round(self.offset_s * 1e9)
        return Trajectory(stamps, camera.poses, camera.parent, camera.child)


def synchronise(
    camera: Trajectory, imu: ImuStream, noise: ImuNoise, *, search_s: float = 2.0
) -> Synchronised:
    """Estimate time offset and extrinsics from a metric camera path and an IMU that moved with it.

    Angular rates give offset and rotation to start from; everything is then estimated together,
    with the biases and gravity; poses that contradict their neighbours are left out before, and all
    but 50 a second. The offset is that at which the camera's orientations follow the gyroscope's,
    within blocks of four seconds: positions and forces have no say in it, and its deviation covers
    what blocks differ by. The other deviations believe that errors of the camera's poses are
    independent from one to the next: those of a smoothed path are not, and they are then too small.
    Faults of scale, axes and linearity of the sensor are seen only as noise, and can pull the
    extrinsics further than noise does: by 0.9° on EuRoC's V1_02, whose accelerometer strays by 0.04
    m/s² from the true force for a third of a second and longer, while its gyroscope alone fits
    within 0.1°. So the extrinsics is estimated without the accelerometer as well, and where both
    differ by more than noise explains, the deviations of its rotation cover the difference. A
    direction in which the motion tells nothing (the lever arm along the only axis of rotation)
    keeps the uncertainty that it starts with: 1 m, half a turn. A motion that repeats itself within
    `search_s` can be matched a period off.

    Args:
        camera: ``world_T_camera``, metres, on the camera's clock; its world may lean.
        imu: the stream, on its own clock.
        noise: the IMU's densities and bias walks.
        search_s: how far from zero the offset may be, up to 60 s.

    Raises:
        ValueError: streams that overlap for less than 2 s or 20 poses, angular rates that do not
            match (too little rotation, or another motion), an estimate that does not settle or
            leaves the offset that rates tell, or a search that is not above zero or too far;
            units, signs, axes or gravity that are not as expected, each with its mend.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 6.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import synchronise
        >>> from motorcade.ga import Trajectory
        >>> camera = measured.trajectory
        >>> late = Trajectory(camera.time_ns - 30_000_000, camera.poses)
        >>> found = synchronise(late, sensor.stream, ADIS16448, search_s=0.2)

        >>> bool(abs(found.offset_s - 0.03) < 0.005)
        True
    """
    if not 0.0 < search_s <= _MOST_SEARCH_S:
        raise ValueError(
            f"search_s: expected seconds above 0 and up to {_MOST_SEARCH_S:g}, got {search_s}; "
            "shift the stamps of one stream first where clocks differ by more"
        )
    unit = check_stamps(camera.time_ns, imu.time_ns)
    if unit is not None:
        raise ValueError(f"camera and imu: {unit.summary}")
    match = match_rates(camera, imu, search_s)
    used, imu = covered(camera, imu, match.offset_s, _MARGIN_S)
    used = _spaced(used[plausible(used, imu, match)])
    imu_T_camera = Motor.from_rotor_translation(match.imu_R_camera, np.zeros(3))
    start = Shared(match.offset_s, imu_T_camera, _gravity(used, imu, match.offset_s, imu_T_camera))
    health = _checked(used, imu, match)
    doubt_s = _DOUBT * match.offset_sigma_s
    beliefs = Beliefs(doubt_s, np.pi, _LEVER_SIGMA_M, GRAVITY_SIGMA_M_S2, 0.0)
    joint = align(used, imu, noise, start, beliefs)
    if abs(joint.shared.offset_s - match.offset_s) > doubt_s:
        raise ValueError(
            f"camera and imu: expected poses that agree with their rates, which put the offset at "
            f"{match.offset_s:.4f} ± {match.offset_sigma_s:.4f} s, got {joint.shared.offset_s:.4f}"
        )
    offset_s, covariance = _borne_out(joint, used, imu, beliefs)
    return Synchronised(
        offset_s,
        joint.shared.imu_T_camera,
        joint.shared.gravity_m_s2,
        covariance,
        joint.bias[:, :3],
        joint.bias[:, 3:],
        joint.time_ns,
        match.correlation,
        *joint.sigma,
        joint.noise,
        health,
    )


def _spaced(camera: Trajectory) -> Trajectory:
    """Poses at 50 a second where there are more: the IMU knows what lies between them."""
    step_ns = float(np.median(np.diff(camera.time_ns)))
    return camera[:: max(1, round(_SPACING_NS / step_ns))]


def _checked(camera: Trajectory, imu: ImuStream, match: RateMatch) -> Health:
    """The verdict on what was recorded.

    Raises:
        ValueError: units, signs or axes that no offset and no extrinsics mend, each with its mend.
    """
    imu_T_camera = Motor.from_rotor_translation(match.imu_R_camera, np.zeros(3))
    health = check_health(
        camera, imu, imu_T_camera, time_offset_s=match.offset_s, up=False, extrinsics_known=False
    )
    mended = [one.summary for one in health.findings if one.fault in _NO_OFFSET_MENDS]
    if mended:
        raise ValueError(f"camera and imu: {'; '.join(mended)}")
    for finding in health.findings:
        log.warning("%s", finding.summary)
    return health


def _borne_out(
    joint: Aligned, used: Trajectory, imu: ImuStream, beliefs: Beliefs
) -> tuple[float, FloatArray]:
    """Offset and covariance ``(10, 10)`` that do not rest on the forces alone.

    The offset is that of orientations (see `rotations`): on EuRoC's flights positions and forces
    put it by up to 5 ms off, at a fraction of a millisecond of stated deviation. Deviations of the
    extrinsics' rotation cover what forces change in it.

    J. Hausman, Specification tests in econometrics, Econometrica 46(6), 1978: of two estimates the
    one that believes more is the surer one, but they agree where its beliefs are right.
    """
    deaf = replace(joint.noise, accel_density_m_s2_rthz=_DEAF * joint.noise.accel_density_m_s2_rthz)
    turning = align(used, imu, deaf, joint.shared, beliefs, joint.sigma, adapt=False)
    apart = joint.shared.imu_T_camera.rotor.local(turning.shared.imu_T_camera.rotor)
    squares = apart**2
    covariance = joint.covariance[: GRAVITY.stop, : GRAVITY.stop]
    stated = np.diag(covariance)[ROTATION]
    own = np.diag(turning.covariance)[ROTATION]
    grown = np.ones(len(covariance))
    if np.any(squares > _UNLIKELY * own):  # then forces are believed about no axis
        grown[ROTATION] = np.sqrt(np.maximum((squares + own) / stated, 1.0))
    offset_s, rotor = joint.shared.offset_s, joint.shared.imu_T_camera.rotor
    bias = np.median(joint.bias[:, :3], axis=0)
    turned = offset_by_rotations(used, imu, offset_s, rotor, bias)
    if turned is not None:
        offset_s, grown[0] = turned.offset_s, turned.sigma_s / float(np.sqrt(covariance[0, 0]))
    inflated: FloatArray = covariance * grown * grown[:, None]
    return offset_s, inflated


def _gravity(
    camera: Trajectory, imu: ImuStream, offset_s: float, imu_T_camera: Motor
) -> FloatArray:
    """Against the mean of the specific force in the world: accelerations cancel over time."""
    force = imu.at(camera.time_ns + round(offset_s * 1e9)).specific_force_m_s2
    up = np.mean((camera.motors @ imu_T_camera.inverse()).rotor.apply(force), axis=0)
    size = float(np.linalg.norm(up))
    if size == 0.0:
        raise ValueError("imu: expected specific forces, got zeros")
    fall: FloatArray = -STANDARD_GRAVITY_M_S2 / size * up
    return fall


def covered(
    camera: Trajectory, imu: ImuStream, offset_s: float, margin_s: float
) -> tuple[Trajectory, ImuStream]:
    """The poses that the IMU covers at an offset and `margin_s` to either side of it, and the IMU.

    Where gaps of more than ten seconds split the stream it is the segment with the most poses.

    Raises:
        ValueError: fewer than three.
    """
    shift, margin = round(offset_s * 1e9), round(margin_s * 1e9)
    stamps = camera.time_ns + shift
    parts = imu.segments()
    masks = [
        (stamps - margin >= own.time_ns[0]) & (stamps + margin <= own.time_ns[-1]) for own in parts
    ]
    most = int(np.argmax([np.count_nonzero(mask) for mask in masks]))
    inside = masks[most]
    count = np.count_nonzero(inside)
    if len(parts) > 1:
        text = "gaps split the imu into %d segments: the longest is used, %d of %d poses"
        log.warning(text, len(parts), count, len(camera))
    if count < 3:
        raise ValueError(
            "camera and imu: expected three poses or more that the IMU covers, got "
            f"{count} at an offset of {offset_s:.3f} s"
        )
    return camera[inside], parts[most]


_STEPS = (-3, -2, -1, 1, 2, 3)  # to neighbours
_NEAR_S = 0.5  # beyond, neither gyroscope nor lines foretell
_OUTLIER_THRESHOLD = 6.0  # of the median's deviation
_MEDIAN_NORM = 1.538  # of three normal numbers
_LEAST_RAD, _LEAST_M = 1e-4, 1e-4


def plausible(camera: Trajectory, imu: ImuStream, match: RateMatch) -> NDArray[np.bool_]:
    """Which poses ``(N,)``, covered by the IMU, agree with neighbours or have none nearby."""
    turned = np.linalg.norm(_turn_errors(camera, imu, match), axis=-1)
    shifted = np.linalg.norm(_place_errors(camera), axis=-1)
    return ~(_outliers(turned, _LEAST_RAD) | _outliers(shifted, _LEAST_M))


def _outliers(error: FloatArray, least: float) -> NDArray[np.bool_]:
    """Which are far beyond what most are; NaN is not."""
    known = error[np.isfinite(error)]
    if known.size == 0:
        return np.zeros(len(error), dtype=np.bool_)
    scale = max(float(np.median(known)) / _MEDIAN_NORM, least)
    return error > _OUTLIER_THRESHOLD * scale


def _neighbours(count: int, step: int) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Indices ``(N,)`` so many poses on, and which of them exist."""
    index = np.arange(count) + step
    return np.clip(index, 0, count - 1), (index >= 0) & (index < count)


def _turn_errors(camera: Trajectory, imu: ImuStream, match: RateMatch) -> FloatArray:
    """Medians ``(N, 3)`` of what neighbours and the gyroscope miss of the orientations, rad."""
    stamps = camera.time_ns + round(match.offset_s * 1e9)
    angle = match.imu_R_camera.inverse().apply(TurnedAngle(imu).at(stamps))
    rotors, missed = camera.motors.rotor, []
    for step in _STEPS:
        index, there = _neighbours(len(camera), step)
        there &= np.abs(camera.time_ns[index] - camera.time_ns) <= _NEAR_S * 1e9
        foretold = rotors[index] @ Rotor.from_rotation_vector(angle - angle[index])
        error = (foretold.inverse() @ rotors).as_rotation_vector()
        missed.append(np.where(there[:, None], error, np.nan))
    return _medians(missed)


def _place_errors(camera: Trajectory) -> FloatArray:
    """Medians ``(N, 3)`` of what lines through pairs of neighbours miss of the places, m."""
    place, time_s = camera.motors.translation_m, camera.time_s
    missed = []
    for pair in combinations(_STEPS, 2):
        (a, a_there), (b, b_there) = (_neighbours(len(camera), step) for step in pair)
        near = np.maximum(np.abs(time_s[a] - time_s), np.abs(time_s[b] - time_s)) <= _NEAR_S
        there = a_there & b_there & near & (a != b)
        span = np.where(there, time_s[b] - time_s[a], 1.0)
        part = ((time_s - time_s[a]) / span)[:, None]
        error = place - (1.0 - part) * place[a] - part * place[b]
        missed.append(np.where(there[:, None], error, np.nan))
    return _medians(missed)


def _medians(missed: list[FloatArray]) -> FloatArray:
    """Medians of those that are known, NaN where none is."""
    stacked = np.stack(missed)
    none = np.all(np.isnan(stacked), axis=0)
    medians: FloatArray = np.nanmedian(np.where(none, 0.0, stacked), axis=0)
    return np.where(none, np.nan, medians)


_GRID_S = 0.005
_LEAST_CORRELATION = 0.5
_REFINEMENTS = 8
_CAUCHY = 11.3  # χ² with three degrees of freedom exceeds it in one of a hundred rates
_MEDIAN_CHI2 = 2.366  # its median
# Deviations of offset, rotation and bias beforehand: what nothing tells keeps them.
_LOOSE = np.repeat([1.0, np.pi, 10.0], [1, 3, 3])
_WRONG = 4.0  # medians of the difference of both norms


@dataclass(frozen=True)
class RateMatch:
    """What angular rates tell of two streams.

    Fields:
        offset_s: IMU's clock minus the camera's.
        offset_sigma_s: deviation of it, as the rates tell.
        imu_R_camera: the camera's orientation on the IMU; about the axis of a motion that turns
            about one axis only it is arbitrary.
        correlation: of the ranks of both rates' norms at that offset, up to 1.
        gyro_rms_rad_s: RMS of the angular rate about its mean.
    """

    offset_s: float
    offset_sigma_s: float
    imu_R_camera: Rotor
    correlation: float
    gyro_rms_rad_s: float


def match_rates(camera: Trajectory, imu: ImuStream, search_s: float) -> RateMatch:
    """Match both angular rates at offsets up to `search_s`; the camera's world does not matter.

    Raises:
        ValueError: streams that overlap for less than 2 s or 20 poses, or whose rates do not
            match anywhere within the search: too little rotation, or not one motion.
    """
    rates = CameraRates.of(camera)
    turned = TurnedAngle(imu)
    steps = round(search_s / _GRID_S)
    grid = _GRID_S * np.arange(-steps, steps + 1).astype(np.float64)
    score = norm_correlations(rates, turned, grid)
    if not np.any(np.isfinite(score)):
        raise ValueError(
            f"camera and imu: expected streams that overlap for {LEAST_OVERLAP_S} s or more, got "
            f"{camera.time_ns[0]} to {camera.time_ns[-1]} ns and {imu.time_ns[0]} to "
            f"{imu.time_ns[-1]} ns"
        )
    best = int(np.nanargmax(score))
    gyro = imu.angular_rate_rad_s - imu.angular_rate_rad_s.mean(axis=0)
    spread = float(np.sqrt(np.mean(np.sum(gyro**2, axis=-1))))
    if score[best] < _LEAST_CORRELATION:
        raise ValueError(
            f"camera and imu: expected angular rates that match within {search_s} s, got a "
            f"correlation of {score[best]:.2f} at best (the gyroscope turns by {spread:.3f} rad/s "
            "RMS): too little rotation, or not one motion"
        )
    offset = float(grid[best]) + _GRID_S * _peak(score, best)
    own, other = rates.beside(turned, offset)
    alike = _alike(own, other)
    rotation = _wahba(own[alike], other[alike])
    refined = _refined(rates, turned, offset, rotation)
    return RateMatch(*refined, float(score[best]), spread)


def _refined(
    rates: CameraRates, turned: TurnedAngle, offset_s: float, rotation: Rotor
) -> tuple[float, float, Rotor]:
    """Offset, its deviation and rotation by the rates' vectors; wrong ones weigh less.

    Noise of single poses makes rates that overlap differ by as much as it makes them agree, so
    that the deviation takes them for independent.
    """
    bias, covariance = np.zeros(3), np.zeros((7, 7))
    for _ in range(_REFINEMENTS):
        inside = rates.inside(turned, offset_s, _GRID_S)
        lags = offset_s, offset_s - 0.5 * _GRID_S, offset_s + 0.5 * _GRID_S
        (own, now), (_, before), (_, after) = (inside.beside(turned, lag) for lag in lags)
        expected = rotation.apply(own)
        left = now - expected - bias
        slope = np.zeros((len(own), 3, 7))
        slope[..., 0] = (after - before) / _GRID_S
        slope[..., 1:4] = skew(expected)
        slope[..., 4:] = -np.eye(3)
        squares = np.sum(left**2, axis=-1)
        scale = max(float(np.median(squares)) / _MEDIAN_CHI2, np.finfo(float).tiny)
        weight = 1.0 / (1.0 + squares / (_CAUCHY * scale))
        matrix = np.einsum("n,nij,nik->jk", weight, slope, slope)
        step = -np.linalg.lstsq(matrix, np.einsum("n,nij,ni->j", weight, slope, left))[0]
        step[0] = np.clip(step[0], -_GRID_S, _GRID_S)
        offset_s += float(step[0])
        rotation = Rotor.from_rotation_vector(step[1:4]) @ rotation
        bias = bias + step[4:]
        covariance = np.linalg.inv(matrix / scale + np.diag(_LOOSE**-2.0))
    return offset_s, float(np.sqrt(covariance[0, 0])), rotation


def _alike(own: FloatArray, other: FloatArray) -> NDArray[np.bool_]:
    """Which rates have norms that match as most do: those of wrong poses have not."""
    apart = np.abs(np.linalg.norm(own, axis=-1) - np.linalg.norm(other, axis=-1))
    alike: NDArray[np.bool_] = apart <= _WRONG * np.median(apart)
    return alike


def _peak(score: FloatArray, best: int) -> float:
    """Where between its neighbours the top of a parabola lies, in steps."""
    if not 0 < best < len(score) - 1 or not np.all(np.isfinite(score[best - 1 : best + 2])):
        return 0.0
    before, top, after = score[best - 1 : best + 2]
    curvature = before - 2.0 * top + after
    return float(0.5 * (before - after) / curvature) if curvature < 0.0 else 0.0


def _wahba(camera: FloatArray, imu: FloatArray) -> Rotor:
    """The rotation that takes the camera's rates to the IMU's, their means (biases) apart."""
    camera, imu = camera - camera.mean(axis=0), imu - imu.mean(axis=0)
    u, _, vt = np.linalg.svd(imu.T @ camera)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return Rotor.from_matrix(u @ sign @ vt)
