"""Factor graphs over poses and inertial data, optimised by gtsam: batch, fixed lag, odometry."""

from __future__ import annotations

from motorcade.fusion.graph.calibrate import GraphCalibration, calibrate_by_graph
from motorcade.fusion.graph.fuse import fuse_by_graph
from motorcade.fusion.graph.odometry import OdometryNoise, fuse_odometry

__all__ = [
    "GraphCalibration",
    "OdometryNoise",
    "calibrate_by_graph",
    "fuse_by_graph",
    "fuse_odometry",
]
