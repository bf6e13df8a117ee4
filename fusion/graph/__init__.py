"""Factor graphs over poses and inertial data, optimised by gtsam: batch, fixed lag, odometry."""

from __future__ import annotations

from motorcade.fusion.graph.fuse import fuse_by_graph
from motorcade.fusion.graph.odometry import fuse_odometry

__all__ = [
    "fuse_by_graph",
    "fuse_odometry",
]
