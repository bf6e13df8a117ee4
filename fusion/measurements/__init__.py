"""Kinds of measurements beside the camera's poses: one interface for filter, smoother and graph.

Each kind holds N measurements with stamps of the IMU's clock, in a world whose z points up. They go
into `fuse` and `fuse_by_graph` as `also=[…]`, and into a `PoseFilter` by its `measure`.
`Measurements` says how to write a kind of one's own; `jacobian_error` checks its derivative.
"""

from motorcade.fusion.measurements.interface import (
    Measurements,
    PredictedState,
    jacobian_error,
)
from motorcade.fusion.measurements.poses import (
    BodyPoseMeasurements,
    CornerMeasurements,
    RelativePoseMeasurements,
)
from motorcade.fusion.measurements.positions import (
    AltitudeMeasurements,
    BodyVelocityMeasurements,
    GeodeticOrigin,
    HeadingMeasurements,
    MagneticFieldMeasurements,
    PositionMeasurements,
    VelocityMeasurements,
)

__all__ = [
    "AltitudeMeasurements",
    "BodyPoseMeasurements",
    "BodyVelocityMeasurements",
    "CornerMeasurements",
    "GeodeticOrigin",
    "HeadingMeasurements",
    "MagneticFieldMeasurements",
    "Measurements",
    "PositionMeasurements",
    "PredictedState",
    "RelativePoseMeasurements",
    "VelocityMeasurements",
    "jacobian_error",
]
