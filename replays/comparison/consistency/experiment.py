"""One experiment: a motion, its simulated sensors, and what a filter's errors come to.

Every filter starts `tilt_deg` wrong in tilt, always to the same side, and states that as its
deviation; it starts at rest, 20 m/s uncertain, and with zero biases, while the true ones are drawn
from its prior. So the first square of the velocity is near 0 and that of the pose near 5: all later
ones are draws from what the filter is told, Gaussian noise and bias walks. Errors are judged in the
filter's own coordinates, by the covariance that it states in them, after each measured pose.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from zlib import crc32

import numpy as np

from motorcade.fusion.filter import FilterSettings, fuse
from motorcade.fusion.filter.comparison import (
    ErrorCoordinates,
    Estimates,
    EulerErrors,
    ExactEulerErrors,
    ExtendedPoseErrors,
    QuaternionTranslationErrors,
    Runs,
    RunStates,
    filter_runs,
)
from motorcade.fusion.imu import ContinuousPath, ImuFaults, ImuNoise, ImuStream, simulate_imu
from motorcade.fusion.metrics.consistency import normalised_squared
from motorcade.fusion.motions import MOTIONS, Motion
from motorcade.fusion.simulate_poses import simulate_camera_poses
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import nearest_name
from motorcade.tracking.measurements import PoseMeasurements

PARTS: Mapping[str, slice] = MappingProxyType(
    {
        "pose": slice(0, 6),
        "velocity": slice(6, 9),
        "biases": slice(9, 15),
    }
)
"""What is judged apart: places in the error of 15 numbers."""

# Deviations of the true biases, those of the filter's prior.
_GYRO_BIAS_RAD_S, _ACCEL_BIAS_M_S2 = 0.1, 0.5
# Motions of a camera that looks ahead. Their IMU has its x axis ahead and z up, as on vehicles:
# in the camera's axes Euler angles would stand at gimbal lock all the time.
_LOOKING_AHEAD = (
    "screw",
    "distant_circle",
    "handheld",
    "walk_and_look",
    "stop_and_go",
    "fast_spin",
)
_AHEAD = Motor.from_rotor_translation(
    Rotor.from_matrix(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])), np.zeros(3)
)


# White noise of a cheap sensor, and biases that wander so fast that a run sees many of them.
_FAST_WALKS = ImuNoise(1e-3, 1e-3, 1e-2, 1e-2)


@dataclass(frozen=True)
class Experiment:
    """What is simulated, and how long.

    Fields:
        motion: name of one of `MOTIONS`, rigid.
        duration_s: of each run. Bias errors live for seconds; the share of steps within bounds
            means something only over many times that.
        noise: of the IMU. The default has the white noise of a cheap sensor and fast bias walks,
            so that a run sees many independent biases.
        imu_hz: inertial samples a second.
        camera_hz: measured poses a second, a divisor of `imu_hz`.
        sigma_m, sigma_deg: deviations of measured poses, an axis.
        tilt_deg: how wrong the first orientation is, about the world's x.
    """

    motion: str
    duration_s: float = 120.0
    noise: ImuNoise = _FAST_WALKS
    imu_hz: float = 200.0
    camera_hz: float = 20.0
    sigma_m: float = 0.01
    sigma_deg: float = 0.5
    tilt_deg: float = 5.0

    def path(self) -> ContinuousPath:
        """The true path of the IMU.

        Raises:
            ValueError: a name that is no rigid motion's.
        """
        motion = MOTIONS.get(self.motion)
        if motion is None or motion.versor is not Motor:
            names = [name for name, one in MOTIONS.items() if one.versor is Motor]
            near = nearest_name(self.motion, names)
            listed = ", ".join(names)
            raise ValueError(f"motion: expected one of {listed}, got {self.motion!r}{near}")
        rigid: Motion[Motor] = motion
        path = ContinuousPath.along(rigid, self.duration_s)
        return path.seen_from(_AHEAD) if self.motion in _LOOKING_AHEAD else path

    def settings(self) -> FilterSettings:
        """What every filter is told."""
        return FilterSettings(initial_tilt_error_rad=float(np.deg2rad(self.tilt_deg)))


@dataclass(frozen=True, eq=False)
class Simulated:
    """R runs of one experiment, and the true states ``(R, M)`` at the measured stamps."""

    recorded: tuple[tuple[PoseMeasurements, ImuStream], ...]
    truth: RunStates


@dataclass(frozen=True, eq=False)
class Judged:
    """Squares and errors ``(R, M)`` of R runs at M measured stamps.

    Fields:
        time_s: ``(M,)`` from the start.
        nees: by part of the state, see `PARTS`.
        nis: of the innovations; NaN at the first stamp.
        rotation_rad, position_m: sizes of the errors.
        left_out: ``(R,)`` measurements that the gate refused.
    """

    time_s: FloatArray
    nees: dict[str, FloatArray]
    nis: FloatArray
    rotation_rad: FloatArray
    position_m: FloatArray
    left_out: IntArray


def simulate(experiment: Experiment, seeds: range) -> Simulated:
    """Simulate a run a seed; a seed's run is the same whatever the others are."""
    path, tag = experiment.path(), crc32(experiment.motion.encode())
    made = [_run(experiment, path, np.random.default_rng((tag, seed))) for seed in seeds]
    return Simulated(tuple(data for data, _ in made), RunStates.stacked([true for _, true in made]))


def _run(
    experiment: Experiment, path: ContinuousPath, rng: np.random.Generator
) -> tuple[tuple[PoseMeasurements, ImuStream], RunStates]:
    faults = ImuFaults(
        gyro_bias_rad_s=_GYRO_BIAS_RAD_S * rng.standard_normal(3),
        accel_bias_m_s2=_ACCEL_BIAS_M_S2 * rng.standard_normal(3),
    )
    imu = simulate_imu(path, experiment.imu_hz, experiment.noise, rng, faults=faults)
    measured = simulate_camera_poses(
        imu.path, experiment.camera_hz, experiment.sigma_m, np.deg2rad(experiment.sigma_deg), rng
    )
    at = np.searchsorted(imu.stream.time_ns, measured.trajectory.time_ns)
    bias = np.concatenate([imu.gyro_bias_rad_s, imu.accel_bias_m_s2], axis=-1)
    true = imu.path.motors[at]
    return (measured, imu.stream), RunStates(
        true.rotor, true.translation_m, imu.velocity_m_s[at], bias[at]
    )


def judge(simulated: Simulated, experiment: Experiment, name: str) -> Judged:
    """Filter the runs of an experiment by the filter of a name in `FILTERS`, and judge it."""
    filtered, coordinates = FILTERS[name]
    found = filtered(simulated, experiment)
    errors = coordinates.local(found.state, simulated.truth)
    nees = {
        part: normalised_squared(errors[..., at], found.covariance[..., at, at])
        for part, at in PARTS.items()
    }
    turn = (found.state.rotor.inverse() @ simulated.truth.rotor).angle()
    shift = np.linalg.norm(found.state.position_m - simulated.truth.position_m, axis=-1)
    time_s = simulated.recorded[0][0].trajectory.time_s
    left_out = np.count_nonzero(~found.accepted, axis=1)
    return Judged(time_s - time_s[0], nees, found.nis, turn, shift, left_out)


def _on_motors(simulated: Simulated, experiment: Experiment) -> Estimates:
    """The filter itself, run by run."""
    each = [
        fuse(
            measured,
            imu,
            experiment.noise,
            Motor.identity(),
            settings=experiment.settings(),
            smoothed=False,
            fits_noise=False,
        )
        for measured, imu in simulated.recorded
    ]
    states = [
        RunStates(
            one.trajectory.motors.rotor,
            one.trajectory.motors.translation_m,
            one.velocity_m_s,
            np.concatenate([one.gyro_bias_rad_s, one.accel_bias_m_s2], axis=-1),
        )
        for one in each
    ]
    return Estimates(
        RunStates.stacked(states),
        np.stack([one.state_covariance for one in each]),
        np.stack([one.nis for one in each]),
        np.stack([one.accepted for one in each]),
    )


def _in(coordinates: ErrorCoordinates) -> Filtering:
    def filtered(simulated: Simulated, experiment: Experiment) -> Estimates:
        return filter_runs(
            Runs.of(simulated.recorded), experiment.noise, coordinates, experiment.settings()
        )

    return filtered


Filtering = Callable[[Simulated, Experiment], Estimates]
FILTERS: Mapping[str, tuple[Filtering, ErrorCoordinates]] = MappingProxyType(
    {
        "motor": (_on_motors, ExtendedPoseErrors()),
        "quaternion": (_in(QuaternionTranslationErrors()), QuaternionTranslationErrors()),
        "euler": (_in(EulerErrors()), EulerErrors()),
        "euler_exact": (_in(ExactEulerErrors()), ExactEulerErrors()),
    }
)
"""Every filter by name: what runs it, and the coordinates of its errors."""
