"""`fuse_by_graph`: what `motorcade.fusion.filter.fuse` does, by a factor graph instead."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.filter import FilterSettings, Fused
from motorcade.fusion.filter.fused import by_segment, camera_covariance, covered, wanted_stamps
from motorcade.fusion.filter.settings import MOST_NOISE
from motorcade.fusion.filter.unjudged import fuse_unjudged
from motorcade.fusion.graph.inertial import (
    GraphStates,
    InertialGraph,
    as_motor,
    as_poses,
    optimised,
)
from motorcade.fusion.graph.shared import keys
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.interface import Measurements, checked_measurements
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import checked_span_ns
from motorcade.tracking.measurements import PoseMeasurements

if TYPE_CHECKING:
    import gtsam


def fuse_by_graph(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    also: Sequence[Measurements] = (),
    settings: FilterSettings | None = None,
    time_offset_s: float = 0.0,
) -> Fused:
    """Fuse measured camera poses with an IMU by gtsam, all at once; `fuse` also does so with a lag.

    Every stamp, measured or wanted, is a node of 15 unknowns with its own covariance: the graph is
    for frames, not for the IMU's own rate. Of `settings` it takes gravity, what else to estimate
    (the direction of gravity, the camera's pose on the IMU, its time offset) and the gate: a
    measurement beyond it loses its weight smoothly, and where the result leaves it
    ten gates away it counts as not accepted. `nis` is NaN: a graph has no
    innovations.

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out. Gaps are
            bridged linearly, which nothing accounts for; those of more than ten seconds split the
            stream, as for `fuse`.
        noise: the IMU's densities and bias walks.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: as for `fuse`.
        also: as for `fuse`; steps may overlap.
        settings: as for `fuse`.
        time_offset_s: as for `fuse`.

    Raises:
        ValueError: as `fuse`; settings that look for rest; gaps in the stream that leave the
            graph singular.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import fuse_by_graph
        >>> from motorcade.ga import Motor
        >>> fused = fuse_by_graph(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> fused.trajectory
        Trajectory(world_T_imu, 61 poses, 3.000 s)
    """
    chosen, kinds, shift_ns = checked_graph_input(also, settings, time_offset_s)

    def fuse_part(part: PoseMeasurements, stream: ImuStream, stamps: IntArray | None) -> Fused:
        used = covered(part, stream, shift_ns)
        wanted = wanted_stamps(used.trajectory.time_ns + shift_ns, stream, stamps)
        graph = InertialGraph.of(
            used, stream, noise, imu_T_camera, wanted, chosen, kinds, time_offset_s
        )
        start = filtered_start(used, stream, noise, graph) if kinds else None
        with determined():
            states = smooth_all(graph, start)
        return as_fused(graph, states, part.trajectory, wanted, chosen)

    return by_segment(fuse_part, measurements, imu, stamps_ns, shift_ns)


def checked_graph_input(
    also: Sequence[Measurements], settings: FilterSettings | None, time_offset_s: float
) -> tuple[FilterSettings, tuple[Measurements, ...], int]:
    """Settings, kinds, and the offset in nanoseconds, as a graph can take them.

    Raises:
        ValueError: what it cannot take.
    """
    chosen = settings or FilterSettings()
    kinds = tuple(checked_measurements(one) for one in also)
    if chosen.rest is not None:
        raise ValueError(
            "settings: expected no detection of rest, got some; zero velocities can be measured"
        )
    return chosen, kinds, checked_span_ns(time_offset_s, "time_offset_s")


def as_fused(
    graph: InertialGraph,
    states: GraphStates,
    path: Trajectory,
    wanted: IntArray,
    chosen: FilterSettings,
) -> Fused:
    """What was found at the stamps asked for, seen from the camera."""
    rows, count = np.searchsorted(graph.time_ns, wanted), len(wanted)
    poses = states.world_T_imu[rows] @ states.imu_T_camera
    spread = states.covariance[rows]
    fall = -chosen.gravity_m_s2 * states.world_R_up[:, 2]
    return Fused(
        trajectory=Trajectory(wanted, poses, path.parent, path.child),
        velocity_m_s=states.velocity_m_s[rows],
        gyro_bias_rad_s=states.bias[rows, :3],
        accel_bias_m_s2=states.bias[rows, 3:],
        covariance=camera_covariance(spread, states.imu_T_camera),
        state_covariance=spread,
        nis=np.full(count, np.nan),
        accepted=graph.accepted(states, MOST_NOISE)[rows],
        gravity_m_s2=np.tile(fall, (count, 1)),
        imu_T_camera=Motor.stack([states.imu_T_camera] * count),
        time_offset_s=np.full(count, states.time_offset_s),
        also=graph.judgements(states, MOST_NOISE),
    )


def filtered_start(
    measurements: PoseMeasurements, imu: ImuStream, noise: ImuNoise, graph: InertialGraph
) -> tuple[Motor, FloatArray, FloatArray]:
    """Where the filter sees the nodes by all kinds that do not relate two moments."""
    kinds = [one for one in graph.also if one.since_ns is None and not one.parameter_sigma.size]
    shared = graph.shared
    fused = fuse_unjudged(
        measurements,
        imu,
        noise,
        shared.imu_T_camera,
        graph.time_ns,
        also=kinds,
        time_offset_s=shared.time_offset_s,
        state_covariances=False,
    )
    bias = np.hstack([fused.gyro_bias_rad_s, fused.accel_bias_m_s2])
    return fused.trajectory.motors @ shared.imu_T_camera.inverse(), fused.velocity_m_s, bias


_ITERATIONS = 100
_RELATIVE = 1e-7
_WIDTHS = {"tilt": 2, "camera": 6, "offset": 1}


def smooth_all(
    graph: InertialGraph, start: tuple[Motor, FloatArray, FloatArray] | None = None
) -> GraphStates:
    """The most probable states, each by all the data.

    Without a `start` of poses, velocities and biases at the nodes it is along the measured poses.
    """
    import gtsam

    bias = gtsam.imuBias.ConstantBias()
    nodes = range(1, len(graph.time_ns))
    motions = [graph.motion(index, graph.summed(index, bias)) for index in nodes]
    factors = factors_of(graph, motions)
    values = first_values(graph, *(_measured(graph) if start is None else start))
    return read_all(graph, factors, optimised(factors, values, _ITERATIONS, _RELATIVE))[0]


def factors_of(
    graph: InertialGraph, motions: Sequence[gtsam.NonlinearFactor]
) -> gtsam.NonlinearFactorGraph:
    """All factors: what is believed beforehand, what was measured, and motions between nodes."""
    import gtsam

    factors = gtsam.NonlinearFactorGraph()
    for prior in graph.priors():
        factors.push_back(prior)
    for index in range(len(graph.time_ns)):
        for factor in graph.seen(index):
            factors.push_back(factor)
        if 0 < index <= len(motions):
            factors.push_back(motions[index - 1])
    return factors


@contextmanager
def determined() -> Iterator[None]:
    """Raise ValueError where gtsam finds that the data do not determine what is asked."""
    try:
        yield
    except RuntimeError as fault:
        if "Indeterminate" not in str(fault):
            raise
        raise ValueError(
            "measurements and imu: expected data that determine the path, got a graph that is "
            "singular in float64, as gaps of a second in the imu leave it; `fuse` bridges them"
        ) from fault


def _measured(graph: InertialGraph) -> tuple[Motor, FloatArray, FloatArray]:
    """Poses and velocities along the measured poses, and no biases."""
    seen = graph.measured >= 0
    path = Trajectory(graph.time_ns[seen], graph.world_T_imu[graph.measured[seen]])
    poses = path.motors_at(np.minimum(graph.time_ns, path.time_ns[-1]))
    velocity = np.zeros((len(poses), 3))
    if len(path) > 1:
        measured = np.gradient(path.motors.translation_m, path.time_s, axis=0)
        columns = [np.interp(graph.time_ns, path.time_ns, one) for one in measured.T]
        velocity = np.stack(columns, axis=-1)
    return poses, velocity, np.zeros((len(poses), 6))


def first_values(
    graph: InertialGraph, poses: Motor, velocity: FloatArray, bias: FloatArray
) -> gtsam.Values:
    """What the optimiser starts from."""
    import gtsam

    values = gtsam.Values()
    for index, pose in enumerate(as_poses(poses)):
        node = keys(index)
        values.insert(node.pose, pose)
        values.insert(node.velocity, velocity[index])
        own = gtsam.imuBias.ConstantBias(bias[index, 3:], bias[index, :3])
        values.insert(node.bias, own)
    graph.shared.insert(values)
    return values


def read_all(
    graph: InertialGraph,
    factors: gtsam.NonlinearFactorGraph,
    values: gtsam.Values,
    *,
    covariances: bool = True,
) -> tuple[GraphStates, gtsam.Marginals]:
    """The states at the optimum, and gtsam's marginals for what else is asked of it.

    Without `covariances`, which take longest, those of the states are zero.
    """
    import gtsam

    marginals = gtsam.Marginals(factors, values)
    poses, velocity, bias, covariance = [], [], [], []
    for index in range(len(graph.time_ns)):
        node = keys(index)
        poses.append(values.atPose3(node.pose))
        velocity.append(values.atVector(node.velocity))
        own = values.atConstantBias(node.bias)
        bias.append(np.concatenate([own.gyroscope(), own.accelerometer()]))
        if not covariances:
            continue
        ordered = [node.pose, node.velocity, node.bias, *graph.shared.keys.values()]
        joint = marginals.jointMarginalCovariance(gtsam.KeyVector(ordered))
        covariance.append(np.block([[joint.at(a, b) for b in ordered] for a in ordered]))
    size = 15 + sum(width for name, width in _WIDTHS.items() if name in graph.shared.keys)
    spread = np.array(covariance) if covariances else np.zeros((len(poses), size, size))
    states = np.array(velocity), np.array(bias), spread
    return GraphStates.of(as_motor(poses), *states, graph.shared, values), marginals
