"""The filter's second pass: backwards over its stamps, so that every estimate knows all the data.

H. E. Rauch, F. Tung and C. T. Striebel, Maximum likelihood estimates of linear dynamic systems,
AIAA Journal 3(8), 1965, with errors formed and retracted on the group.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.fusion.filter.error_state import Estimate, Node

__all__ = ["smooth_backwards"]


def smooth_backwards(nodes: Sequence[Node]) -> list[Estimate]:
    """Estimates at the nodes' stamps given all measurements, in order."""
    estimate = nodes[-1].updated
    smoothed = [estimate]
    for node, after in zip(reversed(nodes[:-1]), reversed(nodes[1:]), strict=True):
        known, expected = node.updated, after.predicted
        gain = np.linalg.solve(expected.covariance, after.transition @ known.covariance).T
        error = np.concatenate([
            estimate.motion.error_from(expected.motion),
            estimate.gyro_bias - expected.gyro_bias,
            estimate.accel_bias - expected.accel_bias,
        ])  # fmt: skip
        spread = known.covariance + gain @ (estimate.covariance - expected.covariance) @ gain.T
        estimate = known.corrected(gain @ error, 0.5 * (spread + spread.T))
        smoothed.append(estimate)
    return smoothed[::-1]
