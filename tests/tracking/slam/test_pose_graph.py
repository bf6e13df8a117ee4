"""Pose graphs are relaxed as gtsam and scipy relax them."""

import gtsam
import numpy as np
import pytest
from scipy.optimize import least_squares

from motorcade.ga import Similarity
from motorcade.tracking.slam.mapping.loops import PoseGraph

COUNT = 8


def _ring(rng: np.random.Generator, log_scale: float) -> tuple[Similarity, PoseGraph]:
    """Nodes strung along noisy edges, and an edge from the last back to the first."""
    truth = Similarity.random(rng, (COUNT,), extent_m=2.0, log_scale=log_scale)
    a = np.append(np.arange(COUNT - 1), COUNT - 1)
    b = np.append(np.arange(1, COUNT), 0)
    noise = 0.03 * rng.standard_normal((COUNT, 7))
    if log_scale == 0.0:
        noise[:, 6] = 0.0
    edges = (truth[a].inverse() @ truth[b]).retract(noise)
    nodes = [truth[0]]
    for row in range(COUNT - 1):
        nodes.append(nodes[-1] @ edges[row])
    sigma = rng.uniform(0.01, 0.05, (COUNT, 7))
    fixed = np.arange(COUNT) == 0
    return Similarity.stack(nodes), PoseGraph(a, b, edges, sigma, fixed, log_scale == 0.0)


def test_rigid_nodes_end_where_gtsam_puts_them(rng: np.random.Generator) -> None:
    start, graph = _ring(rng, 0.0)
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    poses = [gtsam.Pose3(one) for one in start.rigid.as_matrix()]
    for row, pose in enumerate(poses):
        values.insert(row, pose)
    factors.add(gtsam.NonlinearEqualityPose3(0, poses[0]))
    for a, b, edge, sigma in zip(
        graph.a, graph.b, graph.a_S_b.rigid.as_matrix(), graph.sigma, strict=True
    ):
        noise = gtsam.noiseModel.Diagonal.Sigmas(sigma[:6])
        factors.add(gtsam.BetweenFactorPose3(int(a), int(b), gtsam.Pose3(edge), noise))
    theirs = gtsam.LevenbergMarquardtOptimizer(factors, values).optimize()
    expected = np.array([theirs.atPose3(row).matrix() for row in range(COUNT)])
    found = graph.relaxed(start)
    np.testing.assert_allclose(found.scale, 1.0, atol=1e-12)
    np.testing.assert_allclose(found.as_matrix(), expected, atol=1e-3)


def test_nodes_with_a_scale_end_where_scipy_puts_them(rng: np.random.Generator) -> None:
    start, graph = _ring(rng, 0.2)

    def residuals(step: np.ndarray) -> np.ndarray:
        twist = np.concatenate([np.zeros((1, 7)), step.reshape(-1, 7)])
        nodes = start.retract(twist)
        between = nodes[graph.a].inverse() @ nodes[graph.b]
        return (graph.a_S_b.local(between) / graph.sigma).ravel()

    solved = least_squares(residuals, np.zeros(7 * (COUNT - 1)), xtol=1e-12, ftol=1e-12)
    expected = start.retract(np.concatenate([np.zeros((1, 7)), solved.x.reshape(-1, 7)]))
    found = graph.relaxed(start)
    np.testing.assert_allclose(found.as_matrix(), expected.as_matrix(), atol=2e-3)
    assert found.scale[0] == pytest.approx(float(start.scale[0]))
