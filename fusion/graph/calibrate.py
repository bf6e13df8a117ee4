"""`calibrate_by_graph`: the IMU's scales and axes, along with all that `fuse_by_graph` finds.

The sensor's axes are those of its accelerometer: what was read r becomes ``C r``, with C close to
one, for the accelerometer with nothing above the diagonal (scales, and axes that are not square),
for the gyroscope full (its axes lie otherwise, too). So does Kalibr (J. Rehder et al., Extending
kalibr, ICRA 2016). gtsam's inertial factor knows no C: how its residual depends on C is taken by
differences of the samples summed up anew, and C joins the factor's unknowns; that is repeated with
the samples corrected until C stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.filter.fused import covered
from motorcade.fusion.graph.fuse import (
    as_fused,
    checked_graph_input,
    determined,
    factors_of,
    filtered_start,
    first_values,
    read_all,
)
from motorcade.fusion.graph.inertial import InertialGraph, optimised
from motorcade.fusion.graph.kinds import parameter_key
from motorcade.fusion.graph.shared import keys
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import MOST_CORRECTION, ImuStream
from motorcade.fusion.measurements.interface import Measurements
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive
from motorcade.tracking.measurements import PoseMeasurements

if TYPE_CHECKING:
    import gtsam

_NUMBERS = 15  # nine of the gyroscope, six of the accelerometer
_GRAVITY = 15  # what the size of gravity is more than assumed, where that is asked for
_LOWER = np.tril_indices(3)
_STEP = 1e-5  # of differences by C; the residual's curvature over it is nothing
_ITERATIONS, _RELATIVE = 50, 1e-8
_ROUNDS = 8  # five are enough for a scale that is wrong by a tenth
_CERTAIN = 1e-6  # deviation of a parameter that is known, beside others that are not
_STILL = 0.01  # of a deviation: C stays
_UNCORRECTED = 10.0  # times the noise, to start: that is what the pipeline takes sensors to have
# Gates of the first rounds, in which good poses disagree with a sensor that is not yet corrected.
_LOOSE = (100.0, 10.0)


@dataclass(frozen=True, eq=False)
class GraphCalibration:
    """What a calibration found, with deviations.

    Fields:
        fused: the path, gravity, extrinsics and offset, with the covariance of each state; see
            `Fused`.
        gyro_correction, accel_correction: ``(3, 3)``; times a reading, they give the true rate
            plus a bias, the true force plus a bias, in the axes of the accelerometer.
        gyro_sigma, accel_sigma: ``(3, 3)`` deviations of their entries, zero above the diagonal of
            the accelerometer's.
        also: the kinds with their parameters as found.
        parameter_sigma: deviations of the parameters of each; none where they were known.
        common: ``(p,)`` what the measured poses share, as found.
        gravity_m_s2: size of gravity, as found or as assumed.
        covariance: ``(25 + p, 25 + p)`` of all that the recording has but once: extrinsics (right
            perturbation: rad, m), offset (s), the gyroscope's nine corrections and the
            accelerometer's six, row by row, gravity's tilt (2, rad) and size (m/s²), `common`;
            zero where it was known.
        misfit: what residuals are, squared and a degree of freedom, of what was stated: 1 where
            noise is as stated and nothing is wrong with the model.
        rounds: how often the samples were summed up anew.

    Examples:
        >>> from motorcade.fusion.graph.calibrate import GraphCalibration
        >>> [name for name in GraphCalibration.__dataclass_fields__][:3]
        ['fused', 'gyro_correction', 'accel_correction']
    """

    fused: Fused
    gyro_correction: FloatArray
    accel_correction: FloatArray
    gyro_sigma: FloatArray
    accel_sigma: FloatArray
    also: tuple[Measurements, ...]
    parameter_sigma: tuple[FloatArray, ...]
    common: FloatArray
    gravity_m_s2: float
    covariance: FloatArray
    misfit: float
    rounds: int


def calibrate_by_graph(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    *,
    also: Sequence[Measurements] = (),
    settings: FilterSettings | None = None,
    time_offset_s: float = 0.0,
    correction_sigma: float = 0.02,
    gravity_size_sigma_m_s2: float = 0.0,
    pose_effect: FloatArray | None = None,
    state_covariances: bool = True,
) -> GraphCalibration:
    """Find the IMU's scales and misalignments, and what `settings` ask for, from a moving sensor.

    It needs turns about, and accelerations along, all three axes: what the motion leaves open
    keeps the deviation that it began with.

    Args:
        measurements: as for `fuse_by_graph`.
        imu: in one piece, without a gap of more than ten seconds.
        noise: the IMU's densities and bias walks.
        imu_T_camera: pose of the camera on the IMU, a first guess where `settings` say so.
        also: as for `fuse_by_graph`; the sensors' own parameters are found where they have
            deviations, as a camera's intrinsics by `CornerMeasurements`.
        settings: as for `fuse_by_graph`; deviations above zero of gravity, extrinsics and offset
            let these be found too.
        time_offset_s: as for `fuse_by_graph`.
        correction_sigma: how far each entry of the corrections may be from that of the identity:
            2 % of scale and 1.1° between axes are what small sensors have uncalibrated.
        gravity_size_sigma_m_s2: how far the size of gravity may be from that of `settings`; above
            zero, it is found too.
        pose_effect: ``(N, 6, p)``: how p numbers of unit normal distribution move each measured
            pose (right perturbation), as errors of the camera's intrinsics do that all poses share.
        state_covariances: without them, which take half the time, those of `fused` are zero.

    Raises:
        ValueError: as `fuse_by_graph`; a stream of several pieces; a deviation that is not above
            zero; data that leave the graph singular; readings that nothing but a correction by half
            and more makes follow the poses.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, ImuStream
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.graph.calibrate import calibrate_by_graph
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> from motorcade.ga import Motor
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 50.0, ADIS16448, rng)
        >>> seen = simulate_camera_poses(sensor.path, 5.0, 0.001, 0.001, rng)
        >>> read = sensor.stream
        >>> off = ImuStream(read.time_ns, 0.9 * read.angular_rate_rad_s, read.specific_force_m_s2)
        >>> found = calibrate_by_graph(
        ...     seen, off, ADIS16448, Motor.identity(), correction_sigma=0.1
        ... )
        >>> print(f"{found.gyro_correction[2, 2]:.2f}")  # one over 0.9
        1.11
    """
    chosen, kinds, shift_ns = checked_graph_input(also, settings, time_offset_s)
    sigma = checked_positive(correction_sigma, "correction_sigma")
    if not 0.0 <= gravity_size_sigma_m_s2 < np.inf:
        raise ValueError(
            f"gravity_size_sigma_m_s2: expected a number from 0 on, got {gravity_size_sigma_m_s2}"
        )
    parts = imu.segments()
    if len(parts) > 1:
        raise ValueError("imu: expected one segment, got gaps of more than ten seconds")
    (imu,) = parts
    used, effect = _covered(measurements, imu, shift_ns, pose_effect)
    wanted = used.trajectory.time_ns + shift_ns
    graph = InertialGraph.of(
        used, imu, noise, imu_T_camera, wanted, chosen, kinds, time_offset_s, effect
    )
    values = first_values(graph, *filtered_start(used, imu, noise.scaled(_UNCORRECTED), graph))
    unknown = [number for number, one in enumerate(kinds) if one.parameter_sigma.size]
    for number in unknown:
        values.insert(parameter_key(number), kinds[number].parameters)
    if effect is not None:
        values.insert(parameter_key(-1), np.zeros(effect.shape[-1]))
        unknown.append(-1)
    own = [replace(one, calibrated=one.number in unknown) for one in graph.kinds]
    graph = replace(graph, kinds=own)
    sigmas = np.full(_NUMBERS, sigma)
    if gravity_size_sigma_m_s2 > 0.0:
        sigmas = np.append(sigmas, gravity_size_sigma_m_s2)
    with determined():
        factors, values, rounds = _settled(graph, values, sigmas)
        judged = [replace(one, measurements=one.kind(values)) for one in graph.kinds]
        graph = replace(graph, kinds=judged)
        states, marginals = read_all(graph, factors, values, covariances=state_covariances)
    fused = as_fused(graph, states, measurements.trajectory, wanted, chosen)
    numbers = values.atVector(_key())
    gyro, accel = corrections(numbers)
    spread = np.sqrt(np.diag(marginals.marginalCovariance(_key())))
    gyro_sigma, accel_sigma = (one - np.eye(3) for one in corrections(spread))
    also_found, also_sigma = list(kinds), [np.zeros(0) for _ in kinds]
    for number in range(len(kinds)):
        if number in unknown:
            name = parameter_key(number)
            also_found[number] = kinds[number].with_parameters(values.atVector(name))
            also_sigma[number] = np.sqrt(np.diag(marginals.marginalCovariance(name)))
    return GraphCalibration(
        fused,
        gyro,
        accel,
        gyro_sigma,
        accel_sigma,
        tuple(also_found),
        tuple(also_sigma),
        values.atVector(parameter_key(-1)) if effect is not None else np.zeros(0),
        chosen.gravity_m_s2 + float(numbers[_GRAVITY:].sum()),
        _joint(graph, marginals, effect),
        _misfit(graph, factors, values),
        rounds,
    )


def _covered(
    measurements: PoseMeasurements, imu: ImuStream, shift_ns: int, effect: FloatArray | None
) -> tuple[PoseMeasurements, FloatArray | None]:
    """The measurements that the IMU covers, and how what they share moves those."""
    used = covered(measurements, imu, shift_ns)
    if effect is None:
        return used, None
    count = len(measurements)
    checked = checked_floats(effect, "pose_effect", (6, np.shape(effect)[-1]))
    if checked.shape[0] != count or not checked.shape[-1]:
        raise ValueError(f"pose_effect: expected {(count, 6, 'p')}, got {checked.shape}")
    return used, checked[np.searchsorted(measurements.trajectory.time_ns, used.trajectory.time_ns)]


def _settled(
    graph: InertialGraph, values: gtsam.Values, sigmas: FloatArray
) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values, int]:
    """Factors and values at the corrections that stay, and the rounds that took."""
    key = _key()
    values.insert(key, np.zeros(len(sigmas)))
    rounds = 0
    while True:
        loose = _LOOSE[rounds] if rounds < len(_LOOSE) else 1.0
        rounds += 1
        about = values.atVector(key)
        gated = replace(graph, gates=[loose * gate for gate in graph.gates])
        factors = _factors(gated, values, about, sigmas)
        values = optimised(factors, values, _ITERATIONS, _RELATIVE)
        now = values.atVector(key)
        worst = float(np.max(np.abs(now[:_NUMBERS])))
        if worst > MOST_CORRECTION:
            raise ValueError(
                f"imu: expected readings that follow the poses once scale and axes are corrected "
                f"by up to {MOST_CORRECTION:g}, got {worst:.2f}; are units, axes and stamps right?"
            )
        still = np.max(np.abs(now - about) / sigmas) < _STILL
        if rounds == _ROUNDS or (rounds > len(_LOOSE) and still):
            return factors, values, rounds


def _joint(
    graph: InertialGraph, marginals: gtsam.Marginals, effect: FloatArray | None
) -> FloatArray:
    """The covariance of all that the recording has but once, as `GraphCalibration` orders it."""
    import gtsam

    shared = graph.shared.keys
    width = 0 if effect is None else effect.shape[-1]
    places = [
        (shared.get("camera"), range(6)),
        (shared.get("offset"), range(6, 7)),
        (_key(), [*range(7, 22), 24]),
        (shared.get("tilt"), range(22, 24)),
        (parameter_key(-1) if width else None, range(25, 25 + width)),
    ]
    asked = [(key, list(rows)) for key, rows in places if key is not None]
    joint = marginals.jointMarginalCovariance(gtsam.KeyVector([key for key, _ in asked]))
    covariance = np.zeros((25 + width, 25 + width))
    for key, rows in asked:
        for other, columns in asked:
            block = joint.at(key, other)
            covariance[np.ix_(rows[: len(block)], columns[: block.shape[1]])] = block
    return covariance


def _misfit(
    graph: InertialGraph, factors: gtsam.NonlinearFactorGraph, values: gtsam.Values
) -> float:
    """The reduced χ² of all residuals; of outliers, what their loss leaves of them."""
    sizes = sum(factors.at(k).dim() for k in range(factors.size()))
    return float(2.0 * factors.error(values) / max(sizes - values.dim(), 1))


def corrections(numbers: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The matrices of gyroscope and accelerometer, from fifteen numbers that add to identities;
    what comes after those belongs to gravity.
    """
    accel = np.zeros((3, 3))
    accel[_LOWER] = numbers[9:_NUMBERS]
    return np.eye(3) + numbers[:9].reshape(3, 3), np.eye(3) + accel


def corrected(imu: ImuStream, numbers: FloatArray) -> ImuStream:
    """The stream with its readings corrected."""
    return imu.corrected(*corrections(numbers))


def _key() -> int:
    import gtsam

    return int(gtsam.symbol("k", 0))


def _factors(
    graph: InertialGraph, values: gtsam.Values, about: FloatArray, sigmas: FloatArray
) -> gtsam.NonlinearFactorGraph:
    """All factors, those of the samples as functions of the corrections near some."""
    import gtsam

    node_count = len(graph.time_ns)
    biases = [values.atConstantBias(keys(k).bias) for k in range(node_count)]

    def motions(numbers: FloatArray) -> list[gtsam.CombinedImuFactor]:
        size_m_s2 = graph.gravity_m_s2 + float(numbers[_GRAVITY:].sum())
        own = replace(graph, imu=corrected(graph.imu, numbers), gravity_m_s2=size_m_s2)
        return [own.motion(k, own.summed(k, biases[k - 1])) for k in range(1, node_count)]

    here = motions(about)
    errors = np.array([one.whitenedError(values) for one in here])
    effect = np.empty((*errors.shape, len(sigmas)))
    for k in range(len(sigmas)):
        ahead = about + _STEP * (np.arange(len(sigmas)) == k)
        for row, (factor, plain) in enumerate(zip(motions(ahead), here, strict=True)):
            # Whitened as the factor itself: its noise hardly depends on the corrections.
            moved = factor.unwhitenedError(values) - plain.unwhitenedError(values)
            effect[row, :, k] = plain.noiseModel().whiten(moved) / _STEP
    factors = factors_of(graph, [])
    for factor, by in zip(here, effect, strict=True):
        factors.push_back(_with_corrections(factor, about, by))
    for number, kind in enumerate(graph.also):
        if kind.parameter_sigma.size:
            certain = np.maximum(kind.parameter_sigma, _CERTAIN)
            known = gtsam.noiseModel.Diagonal.Sigmas(certain)
            name = parameter_key(number)
            factors.push_back(gtsam.PriorFactorVector(name, kind.parameters, known))
    if any(one.number < 0 and one.calibrated for one in graph.kinds):
        count = len(next(one for one in graph.kinds if one.number < 0).measurements.parameters)
        unit = gtsam.noiseModel.Unit.Create(count)
        factors.push_back(gtsam.PriorFactorVector(parameter_key(-1), np.zeros(count), unit))
    prior = gtsam.noiseModel.Diagonal.Sigmas(sigmas)
    factors.push_back(gtsam.PriorFactorVector(_key(), np.zeros(len(sigmas)), prior))
    return factors


def _with_corrections(
    plain: gtsam.CombinedImuFactor, about: FloatArray, effect: FloatArray
) -> gtsam.CustomFactor:
    """An inertial factor, whitened, plus what a change of the corrections does to it."""
    import gtsam

    names, key = list(plain.keys()), _key()
    widths = [6, 3, 6, 3, 6, 6]

    def error(_: Any, values: gtsam.Values, jacobians: list[FloatArray] | None) -> FloatArray:
        change: FloatArray = effect @ (values.atVector(key) - about)
        if jacobians is None:
            whitened: FloatArray = plain.whitenedError(values) + change
            return whitened
        linear: Any = plain.linearize(values)
        matrix, at = linear.getA(), np.cumsum([0, *widths])
        for k in range(len(names)):
            jacobians[k] = np.asfortranarray(matrix[:, at[k] : at[k + 1]])
        jacobians[-1] = np.asfortranarray(effect)
        left: FloatArray = change - linear.getb()
        return left

    model = gtsam.noiseModel.Unit.Create(len(effect))
    return gtsam.CustomFactor(model, [*names, key], error)
