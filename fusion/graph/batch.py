"""Full smoothing: all nodes at once, by Levenberg and Marquardt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.graph.conversions import as_motor, as_poses, optimised
from motorcade.fusion.graph.inertial import InertialGraph, keys, state_covariance
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    import gtsam

__all__ = ["GraphStates", "smooth_all"]

_ITERATIONS = 100
_RELATIVE = 1e-7


@dataclass(frozen=True, eq=False)
class GraphStates:
    """States at N nodes: ``world_T_imu``, velocity, biases (gyroscope first), covariance as of
    `motorcade.fusion.filter.Fused`.
    """

    world_T_imu: Motor
    velocity_m_s: FloatArray
    bias: FloatArray
    covariance: FloatArray


def smooth_all(graph: InertialGraph) -> GraphStates:
    """The most probable states, each by all the data."""
    import gtsam

    factors = gtsam.NonlinearFactorGraph()
    for prior in graph.priors():
        factors.push_back(prior)
    bias = gtsam.imuBias.ConstantBias()
    for index in range(len(graph.time_ns)):
        seen = graph.seen(index)
        if seen is not None:
            factors.push_back(seen)
        if index:
            factors.push_back(graph.motion(index, graph.summed(index, bias)))
    return _read(graph, factors, optimised(factors, _start(graph), _ITERATIONS, _RELATIVE))


def _start(graph: InertialGraph) -> gtsam.Values:
    """Along the measured poses, with their velocities and without biases."""
    import gtsam

    seen = graph.measured >= 0
    path = Trajectory(graph.time_ns[seen], graph.world_T_imu[graph.measured[seen]])
    poses = path.motors_at(np.minimum(graph.time_ns, path.time_ns[-1]))
    velocity = np.zeros((len(poses), 3))
    if len(path) > 1:
        measured = np.gradient(path.motors.translation_m, path.time_s, axis=0)
        columns = [np.interp(graph.time_ns, path.time_ns, one) for one in measured.T]
        velocity = np.stack(columns, axis=-1)
    values = gtsam.Values()
    for index, pose in enumerate(as_poses(poses)):
        node = keys(index)
        values.insert(node.pose, pose)
        values.insert(node.velocity, velocity[index])
        values.insert(node.bias, gtsam.imuBias.ConstantBias())
    return values


def _read(
    graph: InertialGraph, factors: gtsam.NonlinearFactorGraph, found: gtsam.Values
) -> GraphStates:
    import gtsam

    marginals = gtsam.Marginals(factors, found)
    poses, velocity, bias, covariance = [], [], [], []
    for index in range(len(graph.time_ns)):
        node = keys(index)
        poses.append(found.atPose3(node.pose))
        velocity.append(found.atVector(node.velocity))
        own = found.atConstantBias(node.bias)
        bias.append(np.concatenate([own.gyroscope(), own.accelerometer()]))
        names = gtsam.KeyVector([node.pose, node.velocity, node.bias])
        joint = marginals.jointMarginalCovariance(names)
        ordered = [node.pose, node.velocity, node.bias]
        covariance.append(np.block([[joint.at(a, b) for b in ordered] for a in ordered]))
    motors = as_motor(poses)
    spread = state_covariance(np.array(covariance), motors)
    return GraphStates(motors, np.array(velocity), np.array(bias), spread)
