"""Kinds of measurements beside the camera's poses: one interface for filter, smoother and graph.

Each kind holds N measurements with stamps of the IMU's clock, in a world whose z points up. They go
into `fuse` and `fuse_by_graph` as `also=[…]`, and into a `PoseFilter` by its `measure`.
`Measurements` says how to write a kind of one's own; `jacobian_error` checks its derivative.
"""

from motorcade.fusion.measurements.interface import Measurements, jacobian_error
from motorcade.fusion.measurements.poses import RelativePoseMeasurements
from motorcade.fusion.measurements.positions import GeodeticOrigin, PositionMeasurements

__all__ = [
    "GeodeticOrigin",
    "Measurements",
    "PositionMeasurements",
    "RelativePoseMeasurements",
    "jacobian_error",
]
