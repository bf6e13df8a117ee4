"""Recordings that are sound, and the faults that each of them is given."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motorcade.fusion.health import Health, check_health
from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Blackouts, Degradation, InTurn, Outliers
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking.measurements import PoseMeasurements

DEGRADED = InTurn((Outliers(0.02, 0.5, 0.5), Blackouts(2.0, 15.0)))
"""What any tracker does: 2 % of the poses are off, and for 2 s every 15 s there is none."""

EXTRINSICS: Mapping[str, Motor] = {
    # Euler angles and metres of a camera that sits askew, and EuRoC's own, turned by a quarter.
    "askew": Motor.from_euler_translation(np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])),
    "quarter": Motor.from_rotor_translation(
        Rotor.from_matrix(
            np.array(
                [
                    [0.0148655429818, -0.999880929698, 0.00414029679422],
                    [0.999557249008, 0.0149672133247, 0.025715529948],
                    [-0.0257744366974, 0.00375618835797, 0.999660727178],
                ]
            )
        ),
        np.array([-0.0216401454975, -0.064676986768, 0.00981073058949]),
    ),
}

FLIGHTS = {
    "MH_05": ("imu/flights/MH05_imu.txt", "imu/flights/MH_05_difficult.csv"),
    "V1_03": ("imu/flights/V103_imu.txt", "imu/flights/V1_03_difficult.csv"),
    "V2_02": ("imu/flights/V202_imu.txt", "imu/flights/V2_02_medium.csv"),
    "V1_02": ("imu/V102_imu.txt", "imu/V1_02_medium.csv"),
    "V1_01": (
        "replays/euroc_V1_01/mav0/imu0/data.csv",
        "replays/euroc_V1_01/V1_01_easy.txt",
    ),
}


@dataclass(frozen=True, eq=False)
class Case:
    """What a user hands in.

    Fields:
        poses: of the camera, measured.
        imu: the stream.
        imu_T_camera: the extrinsics, as stated.
        gravity_m_s2: as stated.
        truth: `world_T_imu`, for faults that need it.
        extrinsics: name of the extrinsics.
    """

    poses: PoseMeasurements
    imu: ImuStream
    imu_T_camera: Motor
    gravity_m_s2: float
    truth: Trajectory
    extrinsics: str = "askew"


def flown(
    name: str,
    folder: Path,
    extrinsics: str = "askew",
    seed: int = 0,
    degraded: Degradation | None = DEGRADED,
) -> Case:
    """A recorded flight with camera poses simulated from its ground truth: 20 Hz, 1 cm, 0.5°."""
    stream, states = (folder / one for one in FLIGHTS[name])
    imu, truth = read_imu(stream), read_trajectory(states, child="imu")
    inside = (truth.time_ns >= imu.time_ns[0]) & (truth.time_ns <= imu.time_ns[-1])
    return replace(
        case(truth[inside], imu, EXTRINSICS[extrinsics], seed, degraded), extrinsics=extrinsics
    )


def simulated(
    name: str, extrinsics: str = "askew", seed: int = 0, duration_s: float = 40.0
) -> Case:
    """One of the standard motions with a simulated sensor."""
    path = ContinuousPath.along(MOTIONS[name], duration_s, start_ns=10**18)
    sensor = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(seed))
    return replace(
        case(sensor.path, sensor.stream, EXTRINSICS[extrinsics], seed, DEGRADED),
        extrinsics=extrinsics,
    )


def case(
    truth: Trajectory, imu: ImuStream, extrinsics: Motor, seed: int, degraded: Degradation | None
) -> Case:
    """The case of a path and its stream, with the camera so on its IMU."""
    camera = truth.transformed_by(right=extrinsics, child="camera")
    rng = np.random.default_rng(seed)
    poses = simulate_camera_poses(camera, 20.0, 0.01, float(np.deg2rad(0.5)), rng, degraded)
    return Case(poses, imu, extrinsics, 9.81, truth)


Fault = Callable[[Case, Case], Case]


def _readings(rate: FloatArray | float = 1.0, force: FloatArray | float = 1.0) -> Fault:
    """Readings multiplied by a number or a matrix."""

    def degraded_case(one: Case, _: Case) -> Case:
        rates = one.imu.angular_rate_rad_s @ (np.eye(3) * rate if np.ndim(rate) == 0 else rate)
        forces = one.imu.specific_force_m_s2 @ (np.eye(3) * force if np.ndim(force) == 0 else force)
        return replace(one, imu=ImuStream(one.imu.time_ns, rates, forces))

    return degraded_case


def _on_the_moon(one: Case, _: Case) -> Case:
    """The same flight where gravity is the Moon's."""
    stamps = np.clip(one.imu.time_ns, one.truth.time_ns[0], one.truth.time_ns[-1])
    up = one.truth.motors_at(stamps).rotor.inverse().apply(np.array([0.0, 0.0, 1.0]))
    less = (9.81 - 1.62) * up
    imu = ImuStream(one.imu.time_ns, one.imu.angular_rate_rad_s, one.imu.specific_force_m_s2 - less)
    return replace(one, imu=imu)


def _extrinsics(changed: Callable[[Motor], Motor]) -> Fault:
    return lambda one, _: replace(one, imu_T_camera=changed(one.imu_T_camera))


def _turned(extrinsics: Motor) -> Motor:
    axis = np.array([1.0, -2.0, 1.5])
    vector = np.deg2rad(20.0) * axis / np.linalg.norm(axis)
    return extrinsics @ Motor.from_rotor_translation(
        Rotor.from_rotation_vector(vector), np.zeros(3)
    )


def _stamps(imu: Callable[..., np.ndarray], poses: Callable[..., np.ndarray]) -> Fault:
    """Other stamps for either stream."""

    def degraded_case(one: Case, _: Case) -> Case:
        stream = ImuStream(
            imu(one.imu.time_ns), one.imu.angular_rate_rad_s, one.imu.specific_force_m_s2
        )
        path = one.poses.trajectory
        moved = Trajectory(poses(path.time_ns), path.motors, path.parent, path.child)
        return replace(one, imu=stream, poses=PoseMeasurements(moved, one.poses.covariance))

    return degraded_case


def _positions(multiple: float) -> Fault:
    """Positions in another unit."""

    def degraded_case(one: Case, _: Case) -> Case:
        path = one.poses.trajectory
        poses = Motor.from_rotor_translation(
            path.motors.rotor, multiple * path.motors.translation_m
        )
        moved = Trajectory(path.time_ns, poses, path.parent, path.child)
        return replace(one, poses=PoseMeasurements(moved, one.poses.covariance))

    return degraded_case


def _columns(changed: Callable[[FloatArray], FloatArray], sensor: str) -> Fault:
    """All readings of one sensor changed together."""

    def degraded_case(one: Case, _: Case) -> Case:
        rates, forces = one.imu.angular_rate_rad_s, one.imu.specific_force_m_s2
        if sensor == "gyroscope":
            rates = changed(rates)
        else:
            forces = changed(forces)
        return replace(one, imu=ImuStream(one.imu.time_ns, rates, forces))

    return degraded_case


def _frozen(readings: FloatArray) -> FloatArray:
    """The reading in the middle again and again from there on."""
    return readings[np.minimum(np.arange(len(readings)), len(readings) // 2)]


def _clipped(readings: FloatArray) -> FloatArray:
    """A range that one reading in fifty lies beyond, about the median."""
    middle = np.median(readings, axis=0)
    limit = np.quantile(np.abs(readings - middle), 0.98, axis=0)
    return np.clip(readings, middle - limit, middle + limit)


def _stepping(step: float) -> Callable[[FloatArray], FloatArray]:
    """A bias that comes in the middle, of so much an axis."""
    return lambda readings: (
        readings + step * (np.arange(len(readings)) > len(readings) // 2)[:, None]
    )


def _without_gravity(one: Case, _: Case) -> Case:
    """What phones call linear acceleration."""
    stamps = np.clip(one.imu.time_ns, one.truth.time_ns[0], one.truth.time_ns[-1])
    up = one.truth.motors_at(stamps).rotor.inverse().apply(np.array([0.0, 0.0, 9.81]))
    forces = one.imu.specific_force_m_s2 - up
    return replace(one, imu=ImuStream(one.imu.time_ns, one.imu.angular_rate_rad_s, forces))


def _poses(changed: Callable[[Motor], Motor]) -> Fault:
    """Other poses at the same stamps."""

    def degraded_case(one: Case, _: Case) -> Case:
        path = one.poses.trajectory
        moved = Trajectory(path.time_ns, changed(path.motors), path.parent, path.child)
        return replace(one, poses=PoseMeasurements(moved, one.poses.covariance))

    return degraded_case


def _y_down(poses: Motor) -> Motor:
    """A world with OpenCV's axes."""
    quarter = Rotor.from_rotation_vector(np.array([np.pi / 2, 0.0, 0.0]))
    return Motor.from_rotor_translation(quarter, np.zeros(3)) @ poses


def _of_another(one: Case, other: Case) -> Case:
    """The stream of another recording, its stamps moved so that both begin together."""
    stamps = other.imu.time_ns - other.imu.time_ns[0] + one.imu.time_ns[0]
    stream = ImuStream(stamps, other.imu.angular_rate_rad_s, other.imu.specific_force_m_s2)
    return replace(one, imu=stream)


_SWAP = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_FLIP = np.diag([1.0, 1.0, -1.0])
_CYCLE = np.roll(np.eye(3), 1, axis=0)


def _same(stamps: np.ndarray) -> np.ndarray:
    return stamps


FAULTS: Mapping[str, tuple[Fault, str]] = {
    "deg/s": (_readings(rate=float(np.rad2deg(1.0))), "rate_unit"),
    "g": (_readings(force=1 / 9.80665), "force_unit"),
    "accelerometer's sign": (_readings(force=-1.0), "force_sign"),
    "gyroscope's sign": (_readings(rate=-1.0), "rate_sign"),
    "lunar gravity": (_on_the_moon, "gravity"),
    "gravity stated as the Moon's": (lambda one, _: replace(one, gravity_m_s2=1.62), "gravity"),
    "x and y swapped": (_readings(_SWAP, _SWAP), "axes"),
    "x and y of gyroscope swapped": (_readings(rate=_SWAP), "rate_axes"),
    "x and y of accelerometer swapped": (_readings(force=_SWAP), "force_axes"),
    "axes cycled": (_readings(_CYCLE, _CYCLE), "axes"),
    "z negated": (_readings(_FLIP, _FLIP), "axes"),
    "left-handed": (_readings(-_FLIP, _FLIP), "axes"),
    "extrinsics transposed": (
        _extrinsics(lambda extrinsics: extrinsics.inverse()),
        "extrinsics_inverted",
    ),
    "extrinsics off by 20°": (_extrinsics(_turned), "extrinsics_turned"),
    "IMU's stamps in µs": (_stamps(lambda ns: ns // 1000, _same), "stamp_unit"),
    "poses' stamps in µs": (_stamps(_same, lambda ns: ns // 1000), "stamp_unit"),
    "all stamps in µs": (_stamps(lambda ns: ns // 1000, lambda ns: ns // 1000), "stamp_unit"),
    "stamps in µs from 0": (
        _stamps(lambda ns: (ns - ns[0]) // 1000, lambda ns: ns - ns[0]),
        "stamp_unit",
    ),
    "half a second late": (_stamps(lambda ns: ns + 500_000_000, _same), "delay"),
    "half a second early": (_stamps(lambda ns: ns - 500_000_000, _same), "delay"),
    "20 ms early": (_stamps(lambda ns: ns - 20_000_000, _same), "delay"),
    "another recording's IMU": (_of_another, "unrelated"),
    "gyroscope reads 0": (_readings(rate=0.0), "stuck"),
    "gyroscope's y reads 0": (_readings(rate=np.diag([1.0, 0.0, 1.0])), "stuck"),
    "accelerometer frozen at half": (_columns(_frozen, "accelerometer"), "stuck"),
    "gyroscope by 1.2": (_readings(rate=1.2), "rate_unit"),
    "positions in centimetres": (_positions(100.0), "position_unit"),
    "positions in inches": (_positions(1.0 / 0.0254), "position_unit"),
    "positions in feet": (_positions(1.0 / 0.3048), "position_unit"),
    "positions in millimetres": (_positions(1000.0), "position_unit"),
    "milli-g": (_readings(force=1000.0 / 9.80665), "force_unit"),
    "mrad/s": (_readings(rate=1000.0), "rate_unit"),
    "gyroscope frozen at half": (_columns(_frozen, "gyroscope"), "stuck"),
    "accelerometer reads 0": (_readings(force=0.0), "stuck"),
    "gyroscope's z by 1.3": (_readings(rate=np.diag([1.0, 1.0, 1.3])), "rate_scale"),
    "accelerometer by 1.2": (_readings(force=1.2), "gravity|force_unit|force_scale"),
    "gyroscope clipped": (_columns(_clipped, "gyroscope"), "saturated"),
    "accelerometer clipped": (_columns(_clipped, "accelerometer"), "saturated"),
    "gyroscope off by 0.5 rad/s": (_columns(lambda x: x + 0.5, "gyroscope"), "rate_bias"),
    "accelerometer off by 3 m/s²": (_columns(lambda x: x + 3.0, "accelerometer"), "force_bias"),
    "gyroscope's bias steps": (_columns(_stepping(0.3), "gyroscope"), "rate_bias"),
    "gravity left out": (_without_gravity, "gravity"),
    "world's y down": (_poses(_y_down), "lean"),
    "poses inverted": (_poses(lambda poses: poses.inverse()), "poses_inverted"),
    "100 ms late": (_stamps(lambda ns: ns + 100_000_000, _same), "delay"),
    "1.5 s late": (_stamps(lambda ns: ns + 1_500_000_000, _same), "delay"),
    "IMU's clock fast by 0.2 %": (
        _stamps(lambda ns: ns + (ns - ns[0]) // 500, _same),
        "clock_drift",
    ),
}
"""Each with the name that the verdict must give it, or with those that do not differ there."""

SCALES = {"gyroscope's z by 1.3": ("z", 1.3)}
"""Axis and multiple of faults that a motion may not show: the verdict must say that it did not."""

ALIKE = {("quarter", "extrinsics transposed"): ("extrinsics_inverted", "axes")}
"""Mount and fault that no measurement tells from another: the verdict must give both names."""


def checked(fault: str, one: Case, other: Case) -> tuple[Health, bool]:
    """The verdict on a case with a fault ("none" for as it is), and whether it is right.

    It is where it names the fault, and where it is sound but says that the motion does not show so
    much (see `SCALES`).
    """
    plant, expected = FAULTS.get(fault, (None, ""))
    given = one if plant is None else plant(one, other)
    found = check_health(
        given.poses.trajectory, given.imu, given.imu_T_camera, gravity_m_s2=given.gravity_m_s2
    )
    if plant is None:
        return found, found.sound
    names = [(one.fault, one.instead) for one in found.findings]
    alike = ALIKE.get((one.extrinsics, fault))
    allowed = [alike] if alike else [(name, None) for name in expected.split("|")]
    return found, names in [[name] for name in allowed] or (found.sound and _untold(fault, found))


def _untold(fault: str, found: Health) -> bool:
    """Whether the verdict says that it cannot tell the scale of an axis up to the planted one."""
    axis, multiple = SCALES.get(fault, ("", 0.0))
    lines = [line for line in found.unknown if line.startswith("cannot tell the gyroscope's scale")]
    least = [float(one) for line in lines for one in re.findall(rf"{axis} below ([\d.]+)", line)]
    return bool(axis) and bool(least) and multiple < max(least)
