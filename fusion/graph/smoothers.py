"""States by a factor graph, all at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.graph.inertial import InertialGraph, as_motor, as_poses, optimised
from motorcade.fusion.graph.shared import keys
from motorcade.fusion.graph.states import GraphStates
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    import gtsam

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
