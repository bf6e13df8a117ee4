"""What a calibration of camera and IMU gives: every number with its deviation, or why not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera

# Rows of the covariance, as `GraphCalibration.covariance` orders them.
TURN, LEVER, OFFSET, GYRO, ACCEL, TILT, SIZE = (
    slice(0, 3),
    slice(3, 6),
    slice(6, 7),
    slice(7, 16),
    slice(16, 22),
    slice(22, 24),
    slice(24, 25),
)
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
        for sensor, matrix, sigma, motion in (
            (
                "gyro",
                self.gyro_correction,
                self.gyro_sigma,
                "turn faster, and further, about the IMU's {}",
            ),
            (
                "accel",
                self.accel_correction,
                self.accel_sigma,
                "lay gravity along the IMU's {0}, or shake along it",
            ),
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
