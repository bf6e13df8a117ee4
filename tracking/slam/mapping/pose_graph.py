"""A pose graph: keyframes moved so that all their relative poses fit, lengths with them if need be.

With one camera the unit drifts along with the pose, so nodes are similarities: 7 numbers each.
Where lengths are metres the scale stays and 6 remain.

Source: Strasdat, Montiel & Davison 2010 (scale drift-aware loop closing).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.optimise import PairIndex, Stop, minimise, sum_by
from motorcade.tracking.slam.geometry import BoolArray
from motorcade.tracking.sparse import SparseEquations

_STOP = Stop(steps=30, gain=1e-6, damping=1e-6, what="closing the loop")


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """What is known of relative poses.

    Args:
        a, b: ``(e,)`` the nodes that each edge joins.
        a_S_b: Similarity ``(e,)``, the pose of b from a.
        sigma: ``(e, 7)`` its noise: rotation (rad), translation, logarithm of the scale.
        fixed: ``(k,)`` nodes that stay.
        rigid: whether all nodes keep their scale.
    """

    a: IntArray
    b: IntArray
    a_S_b: Similarity
    sigma: FloatArray
    fixed: BoolArray
    rigid: bool

    @property
    def width(self) -> int:
        """Numbers a node has."""
        return 6 if self.rigid else 7

    def relaxed(self, world_S: Similarity) -> Similarity:
        """The nodes Similarity ``(k,)`` that fit best, from nodes that are near.

        >>> import numpy as np
        >>> from motorcade.ga import Motor, Similarity
        >>> from motorcade.tracking.slam.mapping.pose_graph import PoseGraph
        >>> step = Similarity.from_motor_scale(Motor.from_translation([1.0, 0.0, 0.0]))
        >>> back = Similarity.from_motor_scale(Motor.from_translation([-1.7, 0.0, 0.0]))
        >>> edges = Similarity.stack([step, step, back])
        >>> first = np.array([True, False, False])
        >>> rows = np.array([0, 1, 2]), np.array([1, 2, 0])
        >>> graph = PoseGraph(*rows, edges, np.full((3, 7), 0.1), first, rigid=True)
        >>> odometry = Similarity.stack([Similarity.identity(), step, step @ step])
        >>> graph.relaxed(odometry).translation_m[:, 0].round(6)  # 0.3 spread over three edges
        array([0. , 0.9, 1.8])
        """
        minimum = minimise(world_S, partial(_Edges, self), self._retract, _STOP)
        return minimum.state

    def _retract(self, world_S: Similarity, step: FloatArray) -> Similarity:
        twist = np.zeros((len(self.fixed), 7))
        twist[~self.fixed, : self.width] = step
        return world_S.retract(twist)


class _Edges:
    """All edges against the nodes as they are."""

    def __init__(self, graph: PoseGraph, world_S: Similarity) -> None:
        self._graph = graph
        self._between = world_S[graph.a].inverse() @ world_S[graph.b]
        self._residual = graph.a_S_b.local(self._between)
        self._weighed = self._residual[:, : graph.width] / graph.sigma[:, : graph.width]
        self.cost = 0.5 * float(np.sum(self._weighed**2))

    @cached_property
    def equations(self) -> SparseEquations:
        """Normal equations of the free nodes."""
        graph, width = self._graph, self._graph.width
        by_b = Similarity.right_jacobian_inverse(self._residual)
        by_a = -by_b @ self._between.inverse().adjoint()
        scale = 1.0 / graph.sigma[:, :width, None]
        ends = [
            (node, ~graph.fixed[node], scale * jacobian[:, :width, :width])
            for node, jacobian in ((graph.a, by_a), (graph.b, by_b))
        ]
        slot = np.cumsum(~graph.fixed) - 1
        gradient = np.zeros((int(np.count_nonzero(~graph.fixed)), width))
        rows, columns, blocks = [], [], []
        for node, free, derivative in ends:
            left = derivative.swapaxes(-1, -2)
            pull = (left @ self._weighed[..., None])[..., 0]
            gradient += sum_by(pull[free], slot[node[free]], len(gradient))
            for other, other_free, by_other in ends:
                both = free & other_free
                rows.append(slot[node[both]])
                columns.append(slot[other[both]])
                blocks.append(left[both] @ by_other[both])
        index = PairIndex(np.concatenate(rows), np.concatenate(columns))
        return SparseEquations(
            index.rows, index.columns, index.sums(np.concatenate(blocks)), gradient
        )
