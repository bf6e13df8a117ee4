"""What a kind of measurement is, to filter, smoother and factor graph alike.

A kind is a class with stamps, covariances and a residual: measured less predicted, as a function of
the state. How the residual moves with the state's error (`Measurements.jacobian`) may be given too;
otherwise it is taken by differences. The error has 30 numbers, in these columns:

    rotation φ (rad), position ρ (m), velocity ν (m/s)  of the right perturbation, in the IMU's axes
    gyroscope bias, accelerometer bias                   true less estimated
    tilt of gravity (2, rad), extrinsics (6: rad, m)     where they are estimated
    time offset of the camera (1, s)                     where it is estimated
    earlier pose (6: rad, m)                             of kinds that relate two moments

with ``R' = R Exp(φ)``, ``p' = p + R ρ``, ``v' = v + R ν`` to first order.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.ga.motion import cross
from motorcade.ga.stamps import checked_stamps

ROTATION, POSITION, VELOCITY, GYRO_BIAS, ACCEL_BIAS = (slice(3 * i, 3 * i + 3) for i in range(5))
TILT, EXTRINSICS, OFFSET, EARLIER = slice(15, 17), slice(17, 23), 23, slice(24, 30)
EARLIER_ROTATION, EARLIER_POSITION = slice(24, 27), slice(27, 30)
ERROR_NUMBERS = 30
_PARTS = {
    "rotation": ROTATION,
    "position": POSITION,
    "velocity": VELOCITY,
    "gyro_bias": GYRO_BIAS,
    "pose": slice(0, 6),
    "earlier_pose": EARLIER,
}

MOST_NUMBERS = 8  # of one measurement; what the compiled filter has room for
_ASYMMETRY = 1e-9
# Differences over this step are exact to 1e-10 by its square, and to 1e-11 of a metre by rounding.
_STEP = 1e-5


def skew(vector: FloatArray) -> FloatArray:
    """Matrices ``(*, 3, 3)`` of the cross product with vectors ``(*, 3)`` from the left."""
    return cross(np.eye(3), vector[..., None, :])


def turn(angles: FloatArray) -> FloatArray:
    """``Exp(φ)`` as a matrix ``(3, 3)``."""
    return Rotor.from_rotation_vector(angles).as_matrix()


@dataclass(frozen=True, slots=True, eq=False)
class PredictedState:
    """The state at which a measurement is predicted, as matrices and vectors.

    Fields:
        world_R_imu, position_m: rotation ``(3, 3)`` and place ``(3,)`` of the IMU in the world.
        velocity_m_s: ``(3,)`` in the world.
        angular_rate_rad_s: ``(3,)`` in the IMU's axes: the gyroscope's reading less its bias.
        gyro_bias_rad_s, accel_bias_m_s2: ``(3,)``.
        world_R_gravity: ``(3, 3)``; turns -z to where gravity points.
        imu_T_camera: coefficients ``(8,)`` of that motor.
        time_offset_s: what is added to a camera's stamps to be the IMU's time.
        earlier_world_R_imu, earlier_position_m: the pose at the moment that the measurement
            refers to, of kinds that have `Measurements.since_ns`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.measurements.interface import PredictedState
        >>> from motorcade.ga import Motor
        >>> state = PredictedState.at(Motor.from_translation([1.0, 0.0, 0.0]), [0.0, 2.0, 0.0])
        >>> error = np.zeros(30)
        >>> error[3] = 0.5  # of the position
        >>> state.retract(error).position_m
        array([1.5, 0. , 0. ])
    """

    world_R_imu: FloatArray
    position_m: FloatArray
    earlier_world_R_imu: FloatArray
    earlier_position_m: FloatArray
    velocity_m_s: FloatArray
    angular_rate_rad_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    world_R_gravity: FloatArray
    imu_T_camera: FloatArray
    time_offset_s: float

    @classmethod
    def at(
        cls,
        world_T_imu: Motor,
        velocity_m_s: FloatArray,
        angular_rate_rad_s: FloatArray | None = None,
        earlier_world_T_imu: Motor | None = None,
    ) -> PredictedState:
        """A state with biases of zero, gravity along -z and the camera on the IMU."""
        zero = np.zeros(3)
        before = world_T_imu if earlier_world_T_imu is None else earlier_world_T_imu
        return cls(
            world_T_imu.rotor.as_matrix(),
            world_T_imu.translation_m,
            before.rotor.as_matrix(),
            before.translation_m,
            checked_floats(velocity_m_s, "velocity_m_s", (3,)),
            zero if angular_rate_rad_s is None else angular_rate_rad_s,
            zero,
            zero,
            np.eye(3),
            Motor.identity().coefficients,
            0.0,
        )

    @classmethod
    def random(cls, rng: np.random.Generator) -> PredictedState:
        """Any state, to try a kind at."""
        pose, earlier, camera = (Motor.random(rng) for _ in range(3))
        state = cls.at(pose, rng.standard_normal(3), rng.standard_normal(3), earlier)
        return replace(
            state,
            gyro_bias_rad_s=0.1 * rng.standard_normal(3),
            accel_bias_m_s2=0.1 * rng.standard_normal(3),
            world_R_gravity=turn(0.1 * rng.standard_normal(3)),
            imu_T_camera=camera.coefficients,
        )

    @property
    def world_T_imu(self) -> Motor:
        """The pose of the IMU."""
        return Motor.from_rotor_translation(Rotor.from_matrix(self.world_R_imu), self.position_m)

    @property
    def earlier_world_T_imu(self) -> Motor:
        """The pose at the moment that the measurement refers to."""
        rotor = Rotor.from_matrix(self.earlier_world_R_imu)
        return Motor.from_rotor_translation(rotor, self.earlier_position_m)

    @property
    def gravity_direction(self) -> FloatArray:
        """The unit vector ``(3,)`` along gravity in the world."""
        return -self.world_R_gravity[:, 2]

    def retract(self, error: FloatArray) -> PredictedState:
        """The state with an error of 30 numbers on its right; exact for one that only turns."""
        leaning = np.append(error[TILT], 0.0)
        camera = self.imu_T_camera
        if error[EXTRINSICS].any():
            camera = Motor(camera).retract(error[EXTRINSICS]).coefficients
        return PredictedState(
            self.world_R_imu @ turn(error[ROTATION]),
            self.position_m + self.world_R_imu @ error[POSITION],
            self.earlier_world_R_imu @ turn(error[EARLIER_ROTATION]),
            self.earlier_position_m + self.earlier_world_R_imu @ error[EARLIER_POSITION],
            self.velocity_m_s + self.world_R_imu @ error[VELOCITY],
            self.angular_rate_rad_s - error[GYRO_BIAS],
            self.gyro_bias_rad_s + error[GYRO_BIAS],
            self.accel_bias_m_s2 + error[ACCEL_BIAS],
            self.world_R_gravity @ turn(leaning),
            camera,
            self.time_offset_s + error[OFFSET],
        )


class Measurements(ABC):
    """N measurements of one kind, along with an IMU.

    A kind of one's own derives from this, has the three attributes and a `residual`, and goes
    wherever the kinds of `motorcade.fusion.measurements` go.

    Attributes:
        name: of the kind, for messages and `Innovation.kind`.
        time_ns: ``(N,)`` stamps of the IMU's clock, none before the last.
        covariance: ``(N, m, m)`` of the residuals, m from 1 to 8.
        since_ns: ``(N,)`` the earlier moment that each measurement refers to, or None.

    Examples:
        How far the IMU is from a beacon at a known place:

        >>> from dataclasses import dataclass
        >>> import numpy as np
        >>> from motorcade.fusion.measurements import Measurements, jacobian_error
        >>> @dataclass(frozen=True, eq=False)
        ... class Range(Measurements):
        ...     time_ns: np.ndarray
        ...     covariance: np.ndarray
        ...     range_m: np.ndarray
        ...     beacon_m: np.ndarray
        ...     name = "range"
        ...
        ...     def residual(self, row, state):
        ...         away = np.linalg.norm(state.position_m - self.beacon_m)
        ...         return np.array([self.range_m[row] - away])
        ...
        ...     def jacobian(self, row, state):  # may be left out
        ...         along = state.position_m - self.beacon_m
        ...         made = np.zeros((1, 30))
        ...         made[0, 3:6] = -along @ state.world_R_imu / np.linalg.norm(along)
        ...         return made
        >>> seen = Range(np.array([0]), np.full((1, 1, 1), 0.01), np.array([2.0]), np.zeros(3))
        >>> jacobian_error(seen, np.random.default_rng(0)) < 1e-8
        True
    """

    name: ClassVar[str]
    time_ns: IntArray
    covariance: FloatArray

    @property
    def since_ns(self) -> IntArray | None:
        """The earlier moments that measurements refer to; None: they do not."""
        return None

    @property
    def parameters(self) -> FloatArray:
        """Numbers ``(k,)`` of the sensor itself that `calibrate_by_graph` may find; else none."""
        return np.zeros(0)

    @property
    def parameter_sigma(self) -> FloatArray:
        """Their deviations ``(k,)`` beforehand; none where they are known."""
        return np.zeros(0)

    def with_parameters(self, parameters: FloatArray) -> Measurements:
        """The same measurements by a sensor with other parameters."""
        assert not len(parameters)
        return self

    def parameter_jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(m, k)`` of the residual by the parameters."""
        return np.zeros((self.covariance.shape[-1], 0))

    def __len__(self) -> int:
        return len(self.time_ns)

    @abstractmethod
    def residual(self, row: int, state: PredictedState) -> FloatArray:
        """Measured less predicted ``(m,)``, of one row at a state."""

    def jacobian(self, row: int, state: PredictedState) -> FloatArray:
        """Derivative ``(m, 30)`` of the residual by the state's error.

        By differences where a kind does not override it: right to about 1e-9, but sixty residuals
        a measurement, about a millisecond.
        """
        return numerical_jacobian(self, row, state)


def by_error(count: int, **parts: FloatArray) -> FloatArray:
    """A derivative ``(count, 30)`` of these columns, by the name of the error's part; else zero."""
    jacobian = np.zeros((count, ERROR_NUMBERS))
    for name, columns in parts.items():
        jacobian[:, _PARTS[name]] = columns
    return jacobian


def numerical_jacobian(kind: Measurements, row: int, state: PredictedState) -> FloatArray:
    """Derivative ``(m, 30)`` of a residual by central differences."""
    columns = []
    for k in range(ERROR_NUMBERS):
        error = np.zeros(ERROR_NUMBERS)
        error[k] = _STEP
        ahead, behind = (kind.residual(row, state.retract(one)) for one in (error, -error))
        columns.append((ahead - behind) / (2.0 * _STEP))
    return np.stack(columns, axis=-1)


def jacobian_error(kind: Measurements, rng: np.random.Generator, tries: int = 20) -> float:
    """Largest difference between a kind's own Jacobian and central differences.

    It is tried at random rows and states; a right one stays below about 1e-8 times the size of
    what is measured.
    """
    worst = 0.0
    for _ in range(tries):
        row, state = int(rng.integers(len(kind))), PredictedState.random(rng)
        apart = kind.jacobian(row, state) - numerical_jacobian(kind, row, state)
        worst = max(worst, float(np.max(np.abs(apart))))
    return worst


def checked_measurements(kind: Measurements) -> Measurements:
    """A kind whose stamps and covariances are as they must be.

    Raises:
        TypeError: something that is no kind of measurement.
        ValueError: stamps that do not rise, covariances of another shape or not positive definite.
    """
    if not isinstance(kind, Measurements):
        raise TypeError(f"also: expected kinds of measurements, got {type(kind).__name__}")
    name = f"{kind.name} measurements"
    stamps = np.asarray(kind.time_ns)
    if stamps.dtype.kind != "i" or stamps.ndim != 1 or np.any(np.diff(stamps) < 0):
        raise ValueError(f"{name}: time_ns: expected rising integer nanoseconds (N,), got others")
    given_covariance = np.asarray(kind.covariance)
    size = given_covariance.shape[-1] if given_covariance.ndim else 0
    covariance = checked_floats(given_covariance, f"{name}: covariance", (size, size))
    if covariance.shape != (len(stamps), size, size) or not 1 <= size <= MOST_NUMBERS:
        raise ValueError(
            f"{name}: covariance: expected {(len(stamps), 'm', 'm')} with m from 1 to "
            f"{MOST_NUMBERS}, got {covariance.shape}"
        )
    if len(stamps):
        skewness = np.abs(covariance - covariance.swapaxes(-1, -2)).max(axis=(-1, -2))
        even = np.all(skewness <= _ASYMMETRY * np.abs(covariance).max(axis=(-1, -2)))
        if not even or np.any(np.linalg.eigvalsh(covariance)[:, 0] <= 0.0):
            raise ValueError(
                f"{name}: covariance: expected symmetric positive definite matrices, got others"
            )
    since = kind.since_ns
    if since is not None and (
        since.dtype.kind != "i" or since.shape != stamps.shape or np.any(since >= stamps)
    ):
        raise ValueError(f"{name}: since_ns: expected integer stamps before time_ns, got others")
    return kind


def checked_rows(value: ArrayLike, name: str, count: int, trailing: tuple[int, ...]) -> FloatArray:
    """Numbers ``(N, *trailing)``, finite and read-only.

    Raises:
        ValueError: another shape, NaN or infinity.
    """
    array = checked_floats(value, name, trailing)
    if array.shape != (count, *trailing):
        raise ValueError(f"{name}: expected shape {(count, *trailing)}, got {array.shape}")
    return frozen(array)


def spread(value: ArrayLike, name: str, count: int, size: int) -> FloatArray:
    """Covariances ``(N, m, m)`` of one for all ``(m, m)`` or one each; of m = 1 also variances.

    Raises:
        ValueError: another shape, NaN or infinity.
    """
    array = checked_floats(value, name, ())
    if size == 1 and array.shape in ((), (count,)):
        array = array.reshape((*array.shape, 1, 1))
    if array.shape not in ((size, size), (count, size, size)):
        raise ValueError(
            f"{name}: expected shape {(size, size)} or {(count, size, size)}, got {array.shape}"
        )
    return frozen(np.broadcast_to(array, (count, size, size)))


def set_checked(
    kind: Measurements,
    size: int,
    vectors: tuple[str, ...] = (),
    **rows: tuple[int, ...],
) -> int:
    """Check a frozen kind's numbers as it is made, and set them read-only; how many rows it has.

    Args:
        kind: with stamps `time_ns` and a `covariance` as `spread` takes it.
        size: of the covariances; 0 where the kind sets its own.
        vectors: fields of three numbers.
        rows: fields of numbers ``(N, *shape)``, with that shape.

    Raises:
        ValueError: stamps that are no integers ``(N,)``, another shape, NaN or infinity.
    """
    stamps = checked_stamps(kind.time_ns, "time_ns")
    if stamps.ndim != 1:
        raise ValueError(f"time_ns: expected shape (N,), got {stamps.shape}")
    count = len(stamps)
    object.__setattr__(kind, "time_ns", stamps)
    for name, shape in rows.items():
        object.__setattr__(kind, name, checked_rows(getattr(kind, name), name, count, shape))
    if size:
        own = spread(kind.covariance, "covariance", count, size)
        object.__setattr__(kind, "covariance", own)
    for name in vectors:
        vector = checked_floats(getattr(kind, name), name, (3,))
        if vector.shape != (3,):
            raise ValueError(f"{name}: expected three numbers, got shape {vector.shape}")
        object.__setattr__(kind, name, frozen(vector))
    return count
