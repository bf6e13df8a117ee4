"""`PoseFilter`: the filter fed as data come in, late and out of order where they do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.fusion.filter.settings import FilterSettings, engine
from motorcade.fusion.filter.sourced import KEEP, SOURCED, check_steps, prediction
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.measurements.interface import Measurements, checked_measurements
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive
from motorcade.tracking.cameras.camera import Camera

KINDS = {"camera_pose": 1, "imu_pose": 2, "velocity": 3, "corners": 4}


_ASYMMETRY = 1e-9


@dataclass(frozen=True, eq=False)
class FilterState:
    """What is known at one moment: that of the last inertial sample.

    Fields:
        time_ns: on the IMU's clock.
        world_T_imu, velocity_m_s: pose, and velocity in the world ``(3,)``.
        gyro_bias_rad_s, accel_bias_m_s2: ``(3,)``.
        gravity_m_s2: in the world ``(3,)``.
        imu_T_camera, time_offset_s: as estimated, or as given (the identity without a camera).
        covariance: ``(15, 15)`` or ``(24, 24)``; see `Fused.state_covariance`.
        contradicted_since_ns: stamp of the first measurement that was left out since one was
            believed; None where the last one was. The state may be wrong from there on.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, PoseFilter
        >>> from motorcade.ga import Motor
        >>> live = PoseFilter(ADIS16448)
        >>> for k in range(100):  # at rest, with a pose every tenth sample
        ...     live.imu(10_000_000 * k, np.zeros(3), np.array([0.0, 0.0, 9.81]))
        ...     if k % 10 == 0:
        ...         live.pose(10_000_000 * k, Motor.identity(), 1e-4 * np.eye(6))

        >>> live.state.time_ns, live.state.covariance.shape
        (990000000, (15, 15))
    """

    time_ns: int
    world_T_imu: Motor
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    gravity_m_s2: FloatArray
    imu_T_camera: Motor
    time_offset_s: float
    covariance: FloatArray
    contradicted_since_ns: int | None = None

    @property
    def world_T_camera(self) -> Motor:
        """Pose of the camera."""
        return self.world_T_imu @ self.imu_T_camera


@dataclass(frozen=True)
class Innovation:
    """What became of a measurement.

    Fields:
        time_ns: the stamp that was given.
        kind: camera_pose, imu_pose, corners, velocity (at rest), or the name of another kind
            (`motorcade.fusion.measurements`).
        nis: normalised innovation squared; NaN for the pose that the filter started from, and
            for corners behind the camera.
        freedom: its degrees of freedom.
        weight: 1 where it was believed, less where it was weighed down, 0 where it was left out.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, PoseFilter
        >>> from motorcade.ga import Motor
        >>> live = PoseFilter(ADIS16448)
        >>> for k in range(100):  # at rest, with a pose every tenth sample
        ...     live.imu(10_000_000 * k, np.zeros(3), np.array([0.0, 0.0, 9.81]))
        ...     if k % 10 == 0:
        ...         live.pose(10_000_000 * k, Motor.identity(), 1e-4 * np.eye(6))

        >>> live.innovations[-1].kind, live.innovations[-1].weight
        ('imu_pose', 1.0)
    """

    time_ns: int
    kind: str
    nis: float
    freedom: int
    weight: float


class PoseFilter:
    """A filter of pose, velocity and biases that runs along with the data.

    It starts at the first pose that is measured. Measurements wait until inertial data reach
    their stamps; those that come late are put where they belong and all since is done again, so
    that the order of arrival changes nothing, to the last bit, within `history_s`. Where several
    measurements contradict it but not each other, it gives its prediction up: the start, if that
    was wrong, or the map, if that was relocated. `given_up` tells for which spans.

    Args:
        noise: the IMU's; see `fuse`.
        imu_T_camera: pose of the camera on the IMU; None without a camera.
        settings: gravity, gate, rest, what else to estimate.
        time_offset_s: what is added to a camera's stamps to be the IMU's time.
        history_s: how late a measurement may come; memory is 56 bytes a sample and 4 kB a
            measurement of that time.
        relative: keep an earlier pose too, for measurements that relate two moments.
        lag_s: how far back `state_at` can look. Measurements of that time are judged anew with
            each that comes, by all that are known; the state goes on from that.

    Raises:
        ValueError: a history, a lag or an offset that is out of range.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, PoseFilter
        >>> from motorcade.ga import Motor
        >>> live = PoseFilter(ADIS16448)
        >>> for k in range(100):  # at rest, with a pose every tenth sample
        ...     live.imu(10_000_000 * k, np.zeros(3), np.array([0.0, 0.0, 9.81]))
        ...     if k % 10 == 0:
        ...         live.pose(10_000_000 * k, Motor.identity(), 1e-4 * np.eye(6))

        >>> bool(np.abs(live.state.world_T_imu.translation_m).max() < 1e-9)
        True
    """

    def __init__(
        self,
        noise: ImuNoise,
        imu_T_camera: Motor | None = None,
        *,
        settings: FilterSettings | None = None,
        time_offset_s: float = 0.0,
        history_s: float = 2.0,
        relative: bool = False,
        lag_s: float = 0.0,
    ) -> None:
        checked_positive(history_s, "history_s")
        if not 0.0 <= lag_s < np.inf:
            raise ValueError(f"lag_s: expected finite seconds from 0 on, got {lag_s}")
        if not np.isfinite(time_offset_s):
            raise ValueError(f"time_offset_s: expected a finite number, got {time_offset_s}")
        self._settings = settings or FilterSettings()
        self._has_camera = imu_T_camera is not None
        extrinsics = Motor.identity() if imu_T_camera is None else imu_T_camera
        kept_s = history_s + lag_s
        self._engine = engine(
            self._settings, noise, extrinsics, time_offset_s, kept_s, relative, lag_s
        )
        self._relative, self._history_ns = relative, round(min(kept_s, 1e9) * 1e9)
        self._lag_ns = round(lag_s * 1e9)
        self._steps: list[tuple[int, int]] = []
        self._names: list[str] = []

    def imu(self, time_ns: int, gyro: ArrayLike, accel: ArrayLike) -> None:
        """Take a sample of angular rate (rad/s) and specific force (m/s²), ``(3,)`` each.

        Raises:
            ValueError: a stamp not after the last one, numbers that are not finite.
        """
        if type(gyro) is not np.ndarray or type(accel) is not np.ndarray:
            gyro, accel = np.asarray(gyro, np.float64), np.asarray(accel, np.float64)
        self._engine.imu(time_ns, gyro, accel)

    def pose(self, time_ns: int, world_T_imu: Motor, covariance: ArrayLike) -> None:
        """Take a pose of the IMU, with the covariance ``(6, 6)`` of its right perturbation.

        Raises:
            ValueError: a stamp from before the start or the history, a covariance that is not
                symmetric and positive definite. So all that follow.
        """
        row = np.concatenate([_one(world_T_imu), _spread(covariance, 6)])
        self._add("imu_pose", time_ns, row)

    def camera_pose(self, time_ns: int, world_T_camera: Motor, covariance: ArrayLike) -> None:
        """Take a pose of the camera, stamped by the camera's clock; see `pose`.

        Raises:
            ValueError: a filter that was not told `imu_T_camera`, besides. So all of the camera.
        """
        self._check_extrinsics()
        row = np.concatenate([_one(world_T_camera), _spread(covariance, 6)])
        self._add("camera_pose", time_ns, row)

    def tag_pose(
        self, time_ns: int, camera_T_tag: Motor, covariance: ArrayLike, world_T_tag: Motor
    ) -> None:
        """Take the pose in which the camera saw a tag that stands at a known place.

        `covariance` is that of the right perturbation of `camera_T_tag`, in the tag's axes.
        """
        adjoint = camera_T_tag.adjoint()
        spread = adjoint @ _spread(covariance, 6).reshape(6, 6) @ adjoint.T
        self.camera_pose(time_ns, world_T_tag @ camera_T_tag.inverse(), 0.5 * (spread + spread.T))

    def tag(
        self,
        time_ns: int,
        corners_px: ArrayLike,
        corners_m: ArrayLike,
        camera: Camera,
        sigma_px: float = 1.0,
    ) -> None:
        """Take up to four corners ``(n, 2)`` in pixels of points ``(n, 3)`` of the world.

        The lens's distortion is taken off them first; their noise, `sigma_px` an axis, goes along
        by its derivative.
        """
        self._check_extrinsics()
        pixels = checked_floats(corners_px, "corners_px", (2,))
        points = checked_floats(corners_m, "corners_m", (3,))
        if pixels.ndim != 2 or not 1 <= len(pixels) <= 4 or points.shape != (len(pixels), 3):
            raise ValueError(
                "corners_px: expected (n, 2) pixels of (n, 3) points with n from 1 to 4, got "
                f"{pixels.shape} and {points.shape}"
            )
        checked_positive(sigma_px, "sigma_px")
        self._add("corners", time_ns, _corner_rows(pixels, points, camera, sigma_px).ravel())

    def measure(self, measurements: Measurements) -> None:
        """Take measurements of another kind (`motorcade.fusion.measurements`), one or several.

        Raises:
            ValueError: a kind that relates two moments where `relative` was not set, or whose
                steps overlap.
        """
        checked_measurements(measurements)
        if measurements.since_ns is not None:
            self._keep_earlier(measurements)
        if measurements.name not in self._names:
            self._names.append(measurements.name)
        number, predict = self._names.index(measurements.name), prediction(measurements)
        for row, (time_ns, spread) in enumerate(
            zip(measurements.time_ns.tolist(), measurements.covariance, strict=True)
        ):
            data = np.ascontiguousarray(spread, dtype=np.float64).ravel()
            self._engine.add(SOURCED, time_ns, row, data, predict, number)

    @property
    def state(self) -> FilterState | None:
        """What is known at the last inertial sample; None before the start."""
        known = self._engine.state()
        return None if known is None else self._state(known)

    def state_at(self, time_ns: int) -> FilterState:
        """What is known by now of a moment within the last `lag_s`: the path answered late.

        Asked for the last sample's stamp less the lag whenever a measurement came, it gives what
        `fuse` does with the same `lag_s`.

        Raises:
            ValueError: a moment after the last sample, before the start or beyond the lag.
        """
        newest = self.state
        if newest is None or not newest.time_ns - self._lag_ns <= time_ns <= newest.time_ns:
            span = (
                "a filter that started"
                if newest is None
                else (f"one within [{newest.time_ns - self._lag_ns}, {newest.time_ns}]")
            )
            raise ValueError(f"time_ns: expected {span}, got {time_ns}")
        known = newest if time_ns == newest.time_ns else self._engine.state_at(time_ns)
        if known is None:
            raise ValueError(f"time_ns: expected a moment after the start, got {time_ns}")
        return known if isinstance(known, FilterState) else self._state(known)

    def _state(self, known: Any) -> FilterState:
        time_ns, pose, velocity, bias, gravity, extrinsics, offset_s, covariance = known
        down = np.array([0.0, 0.0, -self._settings.gravity_m_s2])
        _, since_ns = self._engine.doubted()
        return FilterState(
            time_ns,
            Motor.normalize(pose),
            velocity,
            bias[:3],
            bias[3:],
            Rotor(gravity).apply(down),
            Motor.normalize(extrinsics),
            offset_s,
            covariance[: self._settings.error_size, : self._settings.error_size],
            since_ns,
        )

    @property
    def given_up(self) -> tuple[tuple[int, int], ...]:
        """Spans of which it knows today that its state was wrong in them, or may have been.

        Each reaches from the first measurement that another account explains better to the moment
        when it was believed; see `FilterState.contradicted_since_ns` for what is not yet decided.
        """
        return tuple((first, last) for first, last in self._engine.doubted()[0].tolist())

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """What became of the measurements that the history holds, by time."""
        names = {number: name for name, number in KINDS.items()}
        return tuple(
            Innovation(
                time_ns,
                self._names[source] if kind == SOURCED else names[kind],
                nis,
                freedom,
                1.0 / factor if factor > 0.0 else 0.0,
            )
            for (time_ns, _, kind, freedom, source), (nis, factor, _, _) in zip(
                *(part.tolist() for part in self._engine.judged()), strict=True
            )
        )

    def _keep_earlier(self, measurements: Measurements) -> None:
        if not self._relative:
            raise ValueError(
                f"{measurements.name} measurements: expected a filter that keeps an earlier "
                "pose, got another; give it relative=True"
            )
        assert measurements.since_ns is not None
        steps = list(
            zip(measurements.since_ns.tolist(), measurements.time_ns.tolist(), strict=True)
        )
        newest = max((end for _, end in [*self._steps, *steps]), default=0)
        recent = [one for one in self._steps if one[1] >= newest - self._history_ns]
        both = np.array([*recent, *steps], dtype=np.int64).reshape(-1, 2)
        check_steps([(both[:, 0], both[:, 1])])
        kept = {start for start, _ in recent}
        for start, _ in steps:
            if start not in kept:
                self._engine.add(KEEP, start, 0, np.zeros(0), None, -1)
                kept.add(start)
        self._steps = [*recent, *steps]

    def _check_extrinsics(self) -> None:
        if not self._has_camera:
            raise ValueError(
                "imu_T_camera: expected the camera's pose on the IMU to take what a camera saw, "
                "got None; give it to PoseFilter"
            )

    def _add(self, kind: str, time_ns: int, row: FloatArray) -> None:
        self._engine.add(KINDS[kind], time_ns, 0, np.ascontiguousarray(row), None, -1)


def _one(pose: Motor) -> FloatArray:
    if pose.shape != ():
        raise ValueError(f"pose: expected one, got {pose.shape}")
    return pose.coefficients


def _spread(covariance: ArrayLike, size: int) -> NDArray[np.float64]:
    matrix = checked_floats(covariance, "covariance", (size, size))
    if matrix.shape != (size, size):
        raise ValueError(f"covariance: expected shape {(size, size)}, got {matrix.shape}")
    skew = np.abs(matrix - matrix.T).max()
    if skew > _ASYMMETRY * np.abs(matrix).max() or np.linalg.eigvalsh(matrix)[0] <= 0.0:
        raise ValueError("covariance: expected a symmetric positive definite matrix, got another")
    return matrix.ravel()


def _corner_rows(
    pixels: FloatArray, points: FloatArray, camera: Camera, sigma_px: float
) -> FloatArray:
    """Rows of world point, x/z and y/z in the camera, and xx, xy, yy of their covariance."""
    rays = camera.unproject(pixels)
    if not np.all(np.isfinite(rays)):
        raise ValueError("corners_px: expected pixels that the lens reaches, got others")
    plane = rays / rays[:, 2:]
    _, effect = camera.project_jacobian(plane)
    back = np.linalg.inv(effect[:, :, :2])
    spread = sigma_px**2 * back @ back.swapaxes(-1, -2)
    return np.column_stack(
        [points, plane[:, :2], spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]]
    )
