"""`check_health`: an IMU beside a camera's path, and what is wrong with either."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorcade.fusion.health import verdict as say
from motorcade.fusion.health.accelerometer import FORCE_UNITS, ForceTrial, ForceVerdict, Pushes
from motorcade.fusion.health.gyroscope import (
    LAG_TOLERANCE_S,
    RATE_UNITS,
    CameraRates,
    RateVerdict,
    TurnedAngle,
    judge_rates,
    steady,
)
from motorcade.fusion.health.models import (
    SIGMAS,
    TURN_TOLERANCE_RAD,
    AxesVerdict,
    Base,
    Model,
    same_turns,
)
from motorcade.fusion.health.verdict import Health, HealthFinding
from motorcade.fusion.imu.noise import GYRO_BIAS_SIGMA_RAD_S
from motorcade.fusion.imu.screening import saturated_axes
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

_MOST_WINDOWS = 300
# Both sensors share a package. Where the accelerometer alone seems turned two calibrations meet,
# its own and that between the poses' attitudes and places, each good to the tolerance. Judged on
# flights: 0.5 to 2.1° (deviations of one) on MH_05, V1_02, V1_03, V2_02, 6° on V1_01.
_FORCE_TURN_RAD = 2.0 * TURN_TOLERANCE_RAD


def check_health(
    camera: Trajectory,
    imu: ImuStream,
    imu_T_camera: Motor,
    *,
    time_offset_s: float = 0.0,
    gravity_m_s2: float = 9.81,
    up: bool = True,
    lean_sigma_rad: float = 0.0,
    extrinsics_sigma_rad: float = 0.0,
    time_offset_sigma_s: float = 0.0,
    extrinsics_known: bool = True,
    search_s: float = 2.0,
) -> Health:
    """Test what an IMU read against what the camera beside it did, and name what is wrong.

    Rates of both are compared over spans of 0.15 s, accelerations over windows of a second. Each
    sensor's readings are tested as stated, in other units, with other signs and in other orders of
    its axes (left-handed ones included), with the extrinsics the other way round, under any
    rotation, and at another offset; the accelerometer's besides under another gravity. A fault is
    what explains them better at odds of 160,000 to 1 and differs from what is stated by more than
    sensors and calibrations usually do: 10 % in scale, 5° in axes, 10 ms in time, 7 % in gravity.
    Where the motion tells too little of something that is said under `Health.unknown`; slow motion
    is no fault. Gross errors of the poses count little, up to half of them.

    Args:
        camera: ``world_T_camera``, in metres.
        imu: the stream.
        imu_T_camera: pose of the camera on the IMU.
        time_offset_s: what is added to the camera's stamps to be the IMU's time.
        gravity_m_s2: its size.
        up: whether the world's z is up; else gravity's size alone is tested.
        lean_sigma_rad: how far z may be from up.
        extrinsics_sigma_rad: how far the extrinsics may be off, where they are estimated: up to
            four times that is no fault.
        time_offset_sigma_s: the same of the offset.
        extrinsics_known: whether `imu_T_camera` was stated, so that it may be the wrong way round;
            False where it was estimated from the same rates.
        search_s: how far from `time_offset_s` another offset is looked for.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, ImuStream, simulate_imu
        >>> from motorcade.fusion.health import check_health
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.ga import Motor
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(handheld(rng), 20.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> check_health(sensor.path, sensor.stream, Motor.identity()).summary
        'the IMU agrees with the path'

        >>> stream = sensor.stream
        >>> degrees = np.rad2deg(stream.angular_rate_rad_s)
        >>> wrong = ImuStream(stream.time_ns, degrees, stream.specific_force_m_s2)
        >>> check_health(sensor.path, wrong, Motor.identity()).faults
        ('rate_unit',)
    """
    stamps = check_stamps(camera.time_ns, imu.time_ns)
    if stamps is not None:
        return Health((stamps,))
    stuck = find_stuck_axes(camera, imu, imu_T_camera, time_offset_s, up=up)
    if stuck:
        return Health(tuple(stuck))
    turn = imu_T_camera.rotor.as_matrix().T
    turned, spans = TurnedAngle(imu), CameraRates.of(camera)
    rates = judge_rates(spans, turned, turn, time_offset_s, search_s, known=extrinsics_known)
    if rates.state not in ("sound", "unknown") or rates.late:
        other = _inverted_or_changing(camera, turned, turn, time_offset_s + rates.lag_s, search_s)
        if other is not None:
            return Health((other,))
    if rates.state == "unrelated":
        return Health((say.unrelated(rates, search_s),))
    offset_s = time_offset_s + rates.lag_s
    if rates.explained and rates.axes is not None:
        base = turn if rates.axes.base == "stated" else turn.T
        camera_R_read = base @ rates.axes.matrix
        kept = steady(camera, turned, offset_s, camera_R_read, rates.bias_rad_s, rates.sigma_rad_s)
        camera = camera[kept] if np.any(kept) else camera
    pushes = Pushes.of(camera, imu, offset_s, _MOST_WINDOWS)
    trial = ForceTrial(pushes, imu_T_camera, extrinsics_known, gravity_m_s2, up, lean_sigma_rad)
    hypotheses = judge_jointly(rates, trial)
    rates, forces = hypotheses[0]
    scale = None if forces.state == "named" and forces.agrees else trial.position_scale()
    if scale is not None:
        of_rates = _units(rates, replace(forces, state="unknown"))
        return Health((*of_rates, say.position_unit(scale)))
    if not rates.explained and forces.state == "unexplained":
        return Health((say.unrelated(rates, search_s),))
    findings = _units(rates, forces)
    if rates.explained and rates.late and abs(rates.lag_s) > SIGMAS * time_offset_sigma_s:
        findings.append(say.delay(rates))
    estimated_rad = SIGMAS * extrinsics_sigma_rad if extrinsics_known else np.pi
    findings += say.both([_axes(*sensors, estimated_rad) for sensors in hypotheses])
    if forces.state == "gravity":
        findings.append(say.gravity(forces, gravity_m_s2))
    findings += say.unexplained(rates, forces)
    share = trial.size_share() if forces.state == "sound" else None
    if share is not None:
        findings.append(say.force_scale(share, gravity_m_s2))
    saturated = saturated_axes(imu)
    if saturated:
        findings.append(HealthFinding("saturated", "; ".join(saturated)))
    return Health(tuple(findings), say.unknown(rates, forces))


def _inverted_or_changing(
    camera: Trajectory, turned: TurnedAngle, turn: FloatArray, offset_s: float, search_s: float
) -> HealthFinding | None:
    """Poses that are those of the world seen from the camera; a clock or a bias that changes."""

    def judged(path: Trajectory) -> RateVerdict:
        return judge_rates(CameraRates.of(path), turned, turn, offset_s, search_s, known=False)

    inverse = judged(
        Trajectory(camera.time_ns, camera.motors.inverse(), camera.child, camera.parent)
    )
    if inverse.state == "sound" and not inverse.late:
        return say.POSES_INVERTED
    middle = len(camera) // 2
    if middle < 2:
        return None
    first, second = judged(camera[:middle]), judged(camera[middle:])
    states = {first.state, second.state}
    if states == {"sound"}:
        lag_s = second.lag_s - first.lag_s
        sigma_s = float(np.hypot(first.lag_sigma_s, second.lag_sigma_s))
        if abs(lag_s) > np.hypot(LAG_TOLERANCE_S, SIGMAS * sigma_s):
            apart_s = 0.5e-9 * float(camera.time_ns[-1] - camera.time_ns[0])
            return say.clock_drift(lag_s / apart_s)
    step_rad_s = second.bias_rad_s - first.bias_rad_s
    steps = np.max(np.abs(step_rad_s)) > GYRO_BIAS_SIGMA_RAD_S  # as much as is usual of a bias
    if steps and "sound" in states and states <= {"sound", "unexplained"}:
        return say.bias_step(step_rad_s)
    return None


def _units(rates: RateVerdict, forces: ForceVerdict) -> list[HealthFinding]:
    findings = []
    of_rates = rates.axes if rates.state == "named" else None
    of_forces = forces.axes if forces.state == "named" else None
    if of_rates is not None and of_rates.multiple != 1.0:
        findings.append(say.unit("gyroscope", of_rates.multiple, RATE_UNITS))
    if of_rates is not None and of_rates.scales != (1.0,) * 3:
        findings.append(say.rate_scale(of_rates.scales))
    if of_forces is not None and of_forces.multiple != 1.0:
        findings.append(say.unit("accelerometer", of_forces.multiple, FORCE_UNITS))
    return findings


def _axes(rates: RateVerdict, forces: ForceVerdict, estimated_rad: float) -> list[HealthFinding]:
    """Extrinsics and axes: what both sensors have in common is said once."""
    of_rates = rates.axes if rates.state == "named" else None
    of_forces = forces.axes if forces.state == "named" else None
    moved = [axes for axes in (of_rates, of_forces) if axes is not None]
    if moved and all(_turned(axes) and axes.turn_rad <= estimated_rad for axes in moved):
        return []
    inverted = [say.EXTRINSICS_INVERTED] if any(axes.base == "inverted" for axes in moved) else []
    return inverted + _own_axes(rates, forces, of_rates, of_forces)


def _own_axes(
    rates: RateVerdict,
    forces: ForceVerdict,
    of_rates: AxesVerdict | None,
    of_forces: AxesVerdict | None,
) -> list[HealthFinding]:
    """The IMU's axes, or one sensor's, the extrinsics read as they must be."""
    if of_rates is not None and _changed(of_rates) and forces.agrees:
        if forces.state in ("named", "unknown") or not _permuted(of_rates):
            return say.shared_axes(of_rates)
        return [say.own_axes("gyroscope", of_rates)]
    if not rates.explained and of_forces is not None and _changed(of_forces):
        if _permuted(of_forces):
            return [say.own_axes("accelerometer", of_forces)]
        return say.shared_axes(of_forces)
    alone = of_rates is None and of_forces is not None and _turned(of_forces)
    if alone and of_forces is not None and rates.allows(of_forces.turn):
        return say.shared_axes(of_forces)
    if (
        of_rates is not None
        and of_forces is not None
        and np.array_equal(of_rates.permutation, -of_forces.permutation)
        and np.linalg.det(of_forces.permutation) < 0.0
        and not _same(of_rates.permutation)
    ):
        return [say.mirrored_axes(of_rates, of_forces)]
    if of_forces is not None and _turned(of_forces) and of_forces.turn_rad < _FORCE_TURN_RAD:
        of_forces = None
    sensors: tuple[tuple[say.Sensor, AxesVerdict | None], ...]
    sensors = ("gyroscope", of_rates), ("accelerometer", of_forces)
    return [say.own_axes(name, axes) for name, axes in sensors if axes and _changed(axes)]


def _changed(axes: AxesVerdict) -> bool:
    return _permuted(axes) or not _same(axes.turn)


def _turned(axes: AxesVerdict) -> bool:
    return not _same(axes.turn) and not _permuted(axes)


def _permuted(axes: AxesVerdict) -> bool:
    return not _same(axes.permutation)


def _same(matrix: np.ndarray) -> bool:
    return bool(np.allclose(matrix, np.eye(3)))


# Both sensors at once: of what explains each of them as well, what both have in common.
#
# A camera that is mounted by a quarter turn looks the same with its extrinsics the wrong way round
# as with two axes of both sensors negated, and one sensor alone does not tell which. Both share a
# package and its extrinsics, so what needs the fewest faults for the two of them is believed. Where
# two hypotheses of equally many faults are the same to any measurement, both are told.


def judge_jointly(rates: RateVerdict, trial: ForceTrial) -> list[tuple[RateVerdict, ForceVerdict]]:
    """What both sensors are believed to be: one hypothesis, or two that no measurement tells apart.

    By the gyroscope's verdict alone and the accelerometer's evidence.
    """
    verdicts = [rates]
    if rates.state == "named" and rates.axes is not None and len(rates.axes.candidates) > 1:
        turns = trial.camera_R_imu()
        models = _fewest(rates.axes.candidates, trial.candidates(), turns)
        verdicts = [_retold(rates, rates.axes, model, turns) for model in models]
    return [(own, trial.judged(own.axes if own.explained else None)) for own in verdicts]


def count_faults(model: Model, of_forces: FloatArray) -> int:
    """How many things went wrong at least, by the extrinsics and the axes ``(3, 3)`` of both."""
    base, of_rates = model
    changed = [not np.array_equal(axes, np.eye(3)) for axes in (of_rates, of_forces)]
    # One frame for both: in a left-handed one rates turn the other way round.
    handed = round(float(np.linalg.det(of_forces)))
    shared = any(np.array_equal(sign * of_rates, of_forces) for sign in (1, handed))
    return int(base == "inverted") + (int(any(changed)) if shared else sum(changed))


def _fewest(
    of_rates: Sequence[Model], of_forces: Sequence[Model], turns: Mapping[Base, FloatArray]
) -> list[Model]:
    """What the gyroscope's candidates come to: the most believed, and what is the same as that."""
    pairs = [
        (count_faults((base, own), other), base, own, other)
        for base, own in of_rates
        for its_base, other in of_forces
        if its_base == base
    ]
    if not pairs:  # the accelerometer tells nothing, and may have whatever the gyroscope has
        pairs = [(count_faults((base, own), own), base, own, own) for base, own in of_rates]
    least, base, own, other = min(pairs, key=lambda pair: pair[0])
    chosen = turns[base] @ np.array([own, other])
    models = [(base, own)]
    for faults, its_base, mine, others in pairs:
        same = np.diag(same_turns(turns[its_base] @ np.array([mine, others]), chosen))
        if faults == least and its_base != base and np.all(same):
            models.append((its_base, mine))
    return models


def _retold(
    rates: RateVerdict, axes: AxesVerdict, model: Model, turns: Mapping[Base, FloatArray]
) -> RateVerdict:
    """The same verdict by the name of a candidate."""
    base, permutation = model
    bias = turns[base].T @ turns[axes.base] @ rates.bias_rad_s
    return replace(rates, axes=replace(axes, base=base, permutation=permutation), bias_rad_s=bias)


# What stamps and readings show by themselves: other units than nanoseconds, axes that are stuck.
#
# A converter's last digit changes with the sensor's own noise. Readings that stay the same for two
# seconds while the camera beside them turns are none, whichever number they show.

# No sensor of this kind is read out faster (the fastest MEMS parts give 32 kHz) or slower.
_IMU_HZ = (4.0, 33_000.0)
# Cameras and trackers.
_POSES_HZ = (0.05, 5_000.0)
_UNITS = {1_000: "µs", 1_000_000: "ms", 1_000_000_000: "s"}
_LEAST_COMMON = 0.5  # of the shorter span


def check_stamps(poses_ns: IntArray, imu_ns: IntArray) -> HealthFinding | None:
    """Whether stamps of either stream look like microseconds, milliseconds or seconds.

    They do where the rate is none that a sensor has and another unit makes it one, or where the
    streams do not overlap and another unit of one of them makes them.
    """
    factors = [1, *_UNITS]
    plain = _plausible(poses_ns, 1, _POSES_HZ) and _plausible(imu_ns, 1, _IMU_HZ)
    if plain and _common(poses_ns, imu_ns, 1, 1) >= _LEAST_COMMON:
        return None
    pairs = [(a, b) for a in factors for b in factors if (a, b) != (1, 1)]
    for of_poses, of_imu in sorted(pairs, key=lambda pair: (pair[0] * pair[1], pair[0])):
        if (
            _plausible(poses_ns, of_poses, _POSES_HZ)
            and _plausible(imu_ns, of_imu, _IMU_HZ)
            and _common(poses_ns, imu_ns, of_poses, of_imu) >= _LEAST_COMMON
        ):
            return HealthFinding("stamp_unit", _line(of_poses, of_imu))
    return None


def _line(of_poses: int, of_imu: int) -> str:
    wrong = {"the poses'": of_poses, "the IMU's": of_imu}
    each = [f"{whose} stamps are in {_UNITS[by]}" for whose, by in wrong.items() if by > 1]
    mend = " and ".join(f"{by:,}" for by in dict.fromkeys(wrong.values()) if by > 1)
    return f"{' and '.join(each)}, where nanoseconds are expected: multiply them by {mend}"


def _plausible(stamps: IntArray, factor: int, bounds: tuple[float, float]) -> bool:
    if len(stamps) < 2:
        return True
    rate = 1e9 / (float(np.median(np.diff(stamps))) * factor)
    return bounds[0] <= rate <= bounds[1]


def _common(poses_ns: IntArray, imu_ns: IntArray, of_poses: int, of_imu: int) -> float:
    """What both have in common, as a share of the shorter."""
    a, b = (float(value) * of_poses for value in poses_ns[[0, -1]])
    c, d = (float(value) * of_imu for value in imu_ns[[0, -1]])
    shorter = min(b - a, d - c)
    return (min(b, d) - max(a, c)) / shorter if shorter > 0.0 else 1.0


_LEAST_S = 2.0
# Turns are looked at over so long a time: noise of poses is then small beside them.
_OVER_S = 1.0
# Three degrees: one in five of the changes must be larger.
_CHANGED, _CHANGED_QUANTILE = 0.05, 0.8


def find_stuck_axes(
    camera: Trajectory, imu: ImuStream, imu_T_camera: Motor, offset_s: float, *, up: bool
) -> list[HealthFinding]:
    """Findings of axes that repeat one reading while what they measure changes.

    Of the gyroscope, turns about the axis; of the accelerometer, how far the world's up, where that
    is known, is along it.
    """
    sensors = [("gyroscope", "rad/s", imu.angular_rate_rad_s, _turns_between)]
    if up:
        sensors.append(("accelerometer", "m/s²", imu.specific_force_m_s2, _changes_of_up))
    findings = []
    for sensor, unit, readings, changes_between in sensors:
        lines = []
        for axis, name in enumerate("xyz"):
            first, last = _longest_repeat(readings[:, axis])
            seconds = 1e-9 * float(imu.time_ns[last] - imu.time_ns[first])
            values = readings[:, axis]
            ends = values[first] in (np.min(values), np.max(values))
            cut_off = ends and last - first < len(values) // 2
            if seconds < _LEAST_S or cut_off:
                continue
            span_ns = imu.time_ns[[first, last]] - round(1e9 * offset_s)
            changes = changes_between(camera, imu_T_camera, span_ns)[:, axis]
            if changes.size and np.quantile(np.abs(changes), _CHANGED_QUANTILE) > _CHANGED:
                lines.append(f"{name} {values[first]:.6g} {unit} for {seconds:.1f} s")
        if lines:
            line = (
                f"the {sensor} reads the same again and again while the camera turns "
                f"({', '.join(lines)}): it is dead or frozen there; leave that time out, or record "
                "anew"
            )
            findings.append(HealthFinding("stuck", line))
    return findings


def _longest_repeat(readings: FloatArray) -> tuple[int, int]:
    """First and last row of the longest run of one reading."""
    ends = np.flatnonzero(np.append(np.diff(readings) != 0.0, True))
    starts = np.append(0, ends[:-1] + 1)
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest])


def _pairs(camera: Trajectory, span_ns: IntArray) -> tuple[IntArray, IntArray]:
    """Rows of poses a second apart, within a span of the camera's time."""
    stamps = camera.time_ns
    later = np.searchsorted(stamps, stamps + round(1e9 * _OVER_S))
    earlier = np.flatnonzero((stamps >= span_ns[0]) & (later < len(stamps)))
    earlier = earlier[stamps[later[earlier]] <= span_ns[1]]
    return earlier, later[earlier]


def _turns_between(camera: Trajectory, imu_T_camera: Motor, span_ns: IntArray) -> FloatArray:
    """Rotation vectors ``(M, 3)`` in the IMU's axes."""
    earlier, later = _pairs(camera, span_ns)
    rotors = camera.motors.rotor
    turns = (rotors[earlier].inverse() @ rotors[later]).as_rotation_vector()
    return imu_T_camera.rotor.apply(turns)


def _changes_of_up(camera: Trajectory, imu_T_camera: Motor, span_ns: IntArray) -> FloatArray:
    """By how much the world's up ``(M, 3)`` in the IMU's axes changes."""
    earlier, later = _pairs(camera, span_ns)
    rotors = camera.motors.rotor.inverse()
    up = imu_T_camera.rotor.apply(rotors.apply(np.array([0.0, 0.0, 1.0])))
    return up[later] - up[earlier]
