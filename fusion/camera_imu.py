"""Camera and IMU calibrated together from a recording of a board, as Kalibr does it.

Unlike `motorcade.fusion.sync`, which takes poses as they are, this uses what is known of a board's
images: how sure each pose is, and how the camera's intrinsics move them all. Poses over a board,
with what their errors have in common, and the IMU's samples go into one factor graph
(`calibrate_by_graph`). It starts from `synchronise`, with a noise that covers what scales and axes
leave unexplained. Once these are corrected, `synchronise` says how noisy the IMU is, and with that
all is found again.

Sources: P. Furgale, J. Rehder, R. Siegwart, Unified temporal and spatial calibration for
multi-sensor systems, IROS 2013; J. Rehder et al., Extending kalibr, ICRA 2016.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter import FilterSettings
from motorcade.fusion.graph.calibrate import GraphCalibration, calibrate_by_graph
from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import (
    GRAVITY_SIGMA_M_S2,
    STANDARD_GRAVITY_M_S2,
    ImuStream,
    upright,
)
from motorcade.fusion.sync.synchronise import Synchronised, covered, synchronise
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.tracking.board_tracking.poses import BoardMeasurements
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["CameraImuCalibration", "calibrate_camera_imu"]

# What is believed of the start: next to nothing, or the recording would be counted twice.
_TILT_SIGMA_RAD = 0.1
_TURN_SIGMA_RAD = 0.3
_LEVER_SIGMA_M = 0.5
_OFFSET_SIGMA_S = 0.01
_MARGIN_S = 0.1
# Extrinsics and clocks that are less sure than this are no calibration: a glance tells a rotation
# to two degrees, and half a period of a camera at 20 Hz is 25 ms.
_WORST_TURN_RAD = np.deg2rad(1.0)
_WORST_OFFSET_S = 0.005
# A board's pose errs by some tenths of a degree; rotation must be far above that.
_LEAST_TURN_RAD = np.deg2rad(2.0)
# Times a sensor's noise, what scales of one and square axes leave unexplained of one that is off by
# 1 %: 3 rad/s are then wrong by 0.03 rad/s, and white noise of 2e-4 by 0.01 over a twentieth of a
# second. It decides where the second round starts, and nothing else.
_UNCORRECTED = 10.0


def calibrate_camera_imu(
    seen: BoardMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    *,
    gravity_m_s2: float | None = None,
    search_s: float = 2.0,
    correction_sigma: float = 0.02,
) -> CameraImuCalibration:
    """Calibrate camera and IMU from a recording of a board that does not move.

    Turn about all axes of the IMU and shake along them, for half a minute or longer, the board in
    the image and the images sharp. What the motion leaves open is said in `unobservable`; where it
    leaves the extrinsics' rotation or the offset open, it is refused.

    Args:
        seen: poses over the board, see `motorcade.tracking.measure_board`.
        imu: the stream, on its own clock.
        noise: the IMU's densities and bias walks, from its data sheet or an Allan deviation.
        gravity_m_s2: its size where the recording was made; None: 9.81, give or take 0.02, which
            then makes the accelerometer's scales less sure.
        search_s: how far from zero the offset may be.
        correction_sigma: how far scales may be from one, and axes from square (rad), beforehand.

    Raises:
        ValueError: what `synchronise` and `calibrate_by_graph` refuse, or a motion that leaves the
            extrinsics or the offset open.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, simulate_imu
        >>> from motorcade.fusion import simulate_camera_poses
        >>> from motorcade.fusion.camera_imu import calibrate_camera_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> from motorcade.ga import Trajectory
        >>> from motorcade.tracking import BoardMeasurements, Camera
        >>> rng = np.random.default_rng(0)
        >>> world_T_camera = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(world_T_camera, 100.0, ADIS16448, rng, time_offset_s=0.02)
        >>> true = Trajectory(sensor.path.time_ns, sensor.path.poses)  # of the camera
        >>> poses = simulate_camera_poses(true, 10.0, 0.002, 0.002, rng)
        >>> camera, nothing = Camera(640, 480, 500.0, 500.0, 319.5, 239.5), np.zeros((31, 6, 0))
        >>> seen = BoardMeasurements(
        ...     camera, None, 31, poses, np.zeros((0, 0)), nothing, 0.1, np.full(31, 0.1)
        ... )
        >>> found = calibrate_camera_imu(seen, sensor.stream, ADIS16448, gravity_m_s2=9.81)
        >>> print(f"{found.offset_s:.2f} s; open after three seconds: {found.unobservable[-1]}")
        0.02 s; open after three seconds: accel_axis_zy: lay gravity ...
    """
    size = STANDARD_GRAVITY_M_S2 if gravity_m_s2 is None else gravity_m_s2
    checked_positive(size, "gravity_m_s2", "m/s²")
    size_sigma = GRAVITY_SIGMA_M_S2 if gravity_m_s2 is None else 0.0
    path = seen.measurements.trajectory
    _check_turns(path)
    doubted = noise.scaled(_UNCORRECTED)
    start = synchronise(path, imu, doubted, search_s=search_s)
    imu = covered(path, imu, start.offset_s, _MARGIN_S)[1]
    run = _Run(seen, imu, start, size, size_sigma, correction_sigma)
    calibration = run.calibrated(doubted, start.imu_T_camera, start.offset_s)
    corrected = imu.corrected(calibration.gyro_correction, calibration.accel_correction)
    used = synchronise(path, corrected, noise, search_s=search_s).imu_noise
    last = calibration.fused
    calibration = run.calibrated(used, last.imu_T_camera[-1], float(last.time_offset_s[-1]))
    return _checked(run.result(calibration, used, start))


def _check_turns(path: Trajectory) -> None:
    """Refuse what hardly turns about a second axis: nothing tells extrinsics and clocks then."""
    vectors = path.motors.rotor[:1].local(path.motors.rotor)
    spread = np.linalg.eigvalsh(np.cov(vectors.T)) if len(path) > 1 else np.zeros(3)
    second_rad = float(np.sqrt(max(spread[1], 0.0)))
    if second_rad < _LEAST_TURN_RAD:
        raise ValueError(
            "camera and imu: expected rotation about two axes or three, of ten degrees and more to "
            f"either side, got {np.rad2deg(second_rad):.1f}° (RMS) about the second"
        )


class _Run:
    """The recording in a world whose z is up, ready for the graph."""

    def __init__(
        self,
        seen: BoardMeasurements,
        imu: ImuStream,
        start: Synchronised,
        size_m_s2: float,
        size_sigma_m_s2: float,
        correction_sigma: float,
    ) -> None:
        stamps = seen.measurements.trajectory.time_ns
        rows = np.flatnonzero(np.isin(stamps, start.time_ns))
        self.seen, self.imu, self.rows = seen, imu, rows
        self.size_m_s2, self.size_sigma_m_s2 = size_m_s2, size_sigma_m_s2
        self.correction_sigma = correction_sigma
        self.level_T_board = Motor.from_rotor_translation(upright(start.gravity_m_s2), np.zeros(3))
        path = seen.measurements.trajectory[rows]
        self.measurements = PoseMeasurements(
            path.transformed_by(left=self.level_T_board), seen.measurements.covariance[rows]
        )

    def calibrated(self, noise: ImuNoise, imu_T_camera: Motor, offset_s: float) -> GraphCalibration:
        """All unknowns, from extrinsics and offset to start from."""
        settings = FilterSettings(
            gravity_m_s2=self.size_m_s2,
            gravity_sigma_rad=_TILT_SIGMA_RAD,
            extrinsics_sigma_rad=_TURN_SIGMA_RAD,
            extrinsics_sigma_m=_LEVER_SIGMA_M,
            time_offset_sigma_s=_OFFSET_SIGMA_S,
        )
        effect = self.seen.effect[self.rows]
        return calibrate_by_graph(
            self.measurements,
            self.imu,
            noise,
            imu_T_camera,
            settings=settings,
            time_offset_s=offset_s,
            correction_sigma=self.correction_sigma,
            gravity_size_sigma_m_s2=self.size_sigma_m_s2,
            pose_effect=effect if effect.shape[-1] else None,
            state_covariances=False,
        )

    def result(
        self, calibration: GraphCalibration, noise: ImuNoise, start: Synchronised
    ) -> CameraImuCalibration:
        """What was found, in the board's frame."""
        fused, seen = calibration.fused, self.seen
        covariance = calibration.covariance * max(calibration.misfit, 1.0)
        own = covariance[COMMON:, COMMON:]
        root = seen.intrinsics_root
        spread = np.sqrt(np.diag(root @ own @ root.T)) if len(root) else np.zeros(0)
        down = fused.gravity_m_s2[-1] * (calibration.gravity_m_s2 / self.size_m_s2)
        stamps = fused.trajectory.time_ns
        return CameraImuCalibration(
            camera=seen.camera_at(calibration.common),
            intrinsics_sigma=spread,
            imu_T_camera=fused.imu_T_camera[-1],
            offset_s=float(fused.time_offset_s[-1]),
            gravity_m_s2=self.level_T_board.inverse().rotor.apply(down),
            gyro_correction=calibration.gyro_correction,
            accel_correction=calibration.accel_correction,
            gyro_bias_rad_s=fused.gyro_bias_rad_s.mean(axis=0),
            accel_bias_m_s2=fused.accel_bias_m_s2.mean(axis=0),
            covariance=covariance,
            misfit=calibration.misfit,
            noise=noise,
            poses=len(stamps),
            refused=int(np.count_nonzero(~fused.accepted)),
            span_s=1e-9 * float(stamps[-1] - stamps[0]),
            sigma_px=seen.sigma_px,
            error_px=float(np.sqrt(np.mean(seen.error_px**2))),
            correction_sigma=self.correction_sigma,
            health=start.health,
        )


def _checked(calibration: CameraImuCalibration) -> CameraImuCalibration:
    """The result, where it is worth the name."""
    turn, offset = float(calibration.rotation_sigma_rad.max()), calibration.offset_sigma_s
    if turn > _WORST_TURN_RAD or offset > _WORST_OFFSET_S:
        raise ValueError(
            "camera and imu: expected motion that tells how one sits on the other and their clocks "
            f"apart, got deviations of {np.rad2deg(turn):.2g}° and {1e3 * offset:.2g} ms; turn "
            "about all axes, faster and longer"
        )
    return calibration


# What a calibration of camera and IMU gives: every number with its deviation, or why not.

# Rows of the covariance, as `GraphCalibration.covariance` orders them.
TURN, LEVER, OFFSET = slice(0, 3), slice(3, 6), slice(6, 7)
GYRO, ACCEL, TILT, SIZE = slice(7, 16), slice(16, 22), slice(22, 24), slice(24, 25)
COMMON = 25
_AXES = "xyz"
_LENS = {"radtan": ("k1", "k2", "p1", "p2", "k3"), "equidistant": ("k1", "k2", "k3", "k4")}


@dataclass(frozen=True)
class Parameter:
    """One number of a calibration.

    Fields:
        name: with its unit, as in ``lever_arm_x_m``.
        value, sigma: as found, and its deviation.
        unobservable: where the motion does not tell it, what would; else empty.

    Examples:
        >>> from motorcade.fusion.camera_imu import Parameter
        >>> Parameter("offset_s", 0.0123, 2e-5, "").unobservable
        ''
    """

    name: str
    value: float
    sigma: float
    unobservable: str


@dataclass(frozen=True, eq=False)
class CameraImuCalibration:
    """Camera and IMU, calibrated together.

    Fields:
        camera: with its intrinsics, as given or as found with all the rest.
        intrinsics_sigma: ``(p,)`` deviations of fx, fy, cx, cy and the distortion; none where the
            camera was given.
        imu_T_camera: pose of the camera on the IMU, whose axes are those of its accelerometer.
        offset_s: what the IMU's clock shows at an event minus what the camera's shows, Kalibr's
            ``timeshift_cam_imu``.
        gravity_m_s2: ``(3,)`` in the board's axes.
        gyro_correction, accel_correction: ``(3, 3)``; times a reading, they give the true rate
            plus a bias, the true force plus a bias.
        gyro_bias_rad_s, accel_bias_m_s2: ``(3,)`` means over the recording of those biases.
        covariance: ``(25 + p, 25 + p)`` of extrinsics (right perturbation in the camera's axes:
            rad, m), offset (s), the gyroscope's nine corrections and the accelerometer's six, row
            by row, gravity's tilt (2, rad) and size (m/s²), and p common errors of the intrinsics;
            with the misfit in it where that is above 1.
        misfit: what residuals are, squared and a degree of freedom, of what was stated. Far above
            1 something is wrong that the model does not know: a board that is bent or of another
            size, a rolling shutter, a sensor on a spring.
        noise: of the IMU as found, never below what was stated.
        poses, refused: how many images were used; in how many of them the pose was refused.
        span_s: from the first of them to the last.
        sigma_px, error_px: noise of a corner's coordinate, and the images' root mean square
            reprojection error.
        correction_sigma: deviation that corrections were believed to have beforehand.
        health: what is wrong with the recording, and what cannot be told of it.

    Examples:
        See `calibrate_camera_imu`.

        >>> from motorcade.fusion.camera_imu import CameraImuCalibration
        >>> "offset_s" in CameraImuCalibration.__dataclass_fields__
        True
    """

    camera: Camera
    intrinsics_sigma: FloatArray
    imu_T_camera: Motor
    offset_s: float
    gravity_m_s2: FloatArray
    gyro_correction: FloatArray
    accel_correction: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    covariance: FloatArray
    misfit: float
    noise: ImuNoise
    poses: int
    refused: int
    span_s: float
    sigma_px: float
    error_px: float
    correction_sigma: float
    health: Health

    @property
    def rotation_sigma_rad(self) -> FloatArray:
        """Deviations ``(3,)`` of the extrinsics' rotation about the camera's axes."""
        return self._sigmas[TURN]

    @property
    def lever_arm_sigma_m(self) -> FloatArray:
        """Deviations ``(3,)`` of the camera's place along the IMU's axes."""
        turn = self.imu_T_camera.rotor.as_matrix()
        return np.sqrt(np.diag(turn @ self.covariance[LEVER, LEVER] @ turn.T))

    @property
    def offset_sigma_s(self) -> float:
        """Deviation of the offset."""
        return float(self._sigmas[OFFSET][0])

    @property
    def gravity_sigma_m_s2(self) -> float:
        """Deviation of gravity's size; zero where it was given."""
        return float(self._sigmas[SIZE][0])

    @property
    def gyro_sigma(self) -> FloatArray:
        """``(3, 3)`` deviations of the gyroscope's correction."""
        return self._sigmas[GYRO].reshape(3, 3)

    @property
    def accel_sigma(self) -> FloatArray:
        """``(3, 3)`` deviations of the accelerometer's, zero above the diagonal."""
        sigma = np.zeros((3, 3))
        sigma[np.tril_indices(3)] = self._sigmas[ACCEL]
        return sigma

    @property
    def gyro_matrix(self) -> FloatArray:
        """``(3, 3)`` from the true rate to what is read less its bias: `gyro_correction` inverted.

        Kalibr splits it into a lower triangle and a rotation, see `kalibr_gyroscope`.
        """
        return np.asarray(np.linalg.inv(self.gyro_correction), np.float64)

    @property
    def accel_matrix(self) -> FloatArray:
        """``(3, 3)``, lower triangular, from the true force to what is read: Kalibr's ``M``."""
        return np.tril(np.linalg.inv(self.accel_correction))

    @property
    def kalibr_gyroscope(self) -> tuple[FloatArray, FloatArray]:
        """Kalibr's lower triangle ``M`` and rotation ``C_gyro_i``, with `gyro_matrix` = M C."""
        orthogonal, upper = np.linalg.qr(self.gyro_matrix.T)
        signs = np.diag(np.sign(np.diag(upper)))
        return (signs @ upper).T, (orthogonal @ signs).T

    def corrected(self, imu: ImuStream) -> ImuStream:
        """A stream of this sensor with scales and axes corrected; biases are left in."""
        return imu.corrected(self.gyro_correction, self.accel_correction)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Every number of the calibration with its deviation, and what the motion does not tell."""
        parameters = [*self._extrinsics(), *self._corrections()]
        if len(self.intrinsics_sigma):
            own = self.camera
            names = ("fx_px", "fy_px", "cx_px", "cy_px", *_LENS.get(own.model, ()))
            values = (own.fx, own.fy, own.cx, own.cy, *own.distortion)
            rows = zip(names, values, self.intrinsics_sigma.tolist(), strict=False)
            parameters += [Parameter(*row, "") for row in rows]
        return tuple(parameters)

    @property
    def unobservable(self) -> tuple[str, ...]:
        """What the motion does not tell, and what motion would, one line each."""
        return tuple(f"{p.name}: {p.unobservable}" for p in self.parameters if p.unobservable)

    @property
    def _sigmas(self) -> FloatArray:
        return np.sqrt(np.diag(self.covariance))

    def _extrinsics(self) -> list[Parameter]:
        camera = self.imu_T_camera
        vector = np.rad2deg(camera.rotor.as_rotation_vector()).tolist()
        turn_deg = np.rad2deg(self.rotation_sigma_rad).tolist()
        place, arm = camera.translation_m.tolist(), self.lever_arm_sigma_m.tolist()
        parameters = [Parameter("offset_s", self.offset_s, self.offset_sigma_s, "")]
        for k, axis in enumerate(_AXES):
            parameters.append(Parameter(f"rotation_{axis}_deg", vector[k], turn_deg[k], ""))
        for k, axis in enumerate(_AXES):
            others = " and ".join(_AXES.replace(axis, ""))
            why = f"turn about the IMU's {others}" if arm[k] > LEAST_LEVER_M else ""
            parameters.append(Parameter(f"lever_arm_{axis}_m", place[k], arm[k], why))
        for k, axis in enumerate(_AXES):
            parameters.append(Parameter(f"gravity_{axis}_m_s2", *self._gravity(k), ""))
        return parameters

    def _gravity(self, k: int) -> tuple[float, float]:
        """A component in the board's axes: its size's deviation, and tilt across it."""
        size = float(np.linalg.norm(self.gravity_m_s2))
        along = self.gravity_m_s2[k] / size
        across = size * float(np.sqrt(np.diag(self.covariance)[TILT].mean() * (1.0 - along**2)))
        return float(self.gravity_m_s2[k]), float(np.hypot(along * self.gravity_sigma_m_s2, across))

    def _corrections(self) -> list[Parameter]:
        parameters = []
        gyro, accel = (
            (self.gyro_correction, self.gyro_sigma),
            (self.accel_correction, self.accel_sigma),
        )
        for sensor, (matrix, sigma), motion in (
            ("gyro", gyro, "turn faster, and further, about the IMU's {}"),
            ("accel", accel, "lay gravity along the IMU's {}, or shake along it"),
        ):
            for row, column in np.ndindex(3, 3):
                if sensor == "accel" and column > row:
                    continue
                value, spread = float(matrix[row, column]), float(sigma[row, column])
                known = spread < LEAST_TOLD * self.correction_sigma
                name = "scale" if row == column else "axis"
                label = f"{sensor}_{name}_{_AXES[row]}{'' if row == column else _AXES[column]}"
                why = "" if known else motion.format(_AXES[column])
                parameters.append(Parameter(label, value, spread, why))
        return parameters


# A ruler tells a lever arm to a centimetre: what is less sure was not worth a recording.
LEAST_LEVER_M = 0.01
# Half the deviation is left of what was believed beforehand where three quarters of what is known
# come from the recording.
LEAST_TOLD = 0.5
