"""Causal filters, each as a stream and as a scan of it; and the smoother of the Kalman filters."""

from __future__ import annotations

from motorcade.fusion.smoothing.causal.kalman import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    KalmanFilter,
    SmoothedStates,
    constant_acceleration,
    constant_velocity,
    rts_constant_acceleration,
    rts_constant_velocity,
    smoothed_states,
)
from motorcade.fusion.smoothing.causal.stream import (
    DoubleExponential,
    Exponential,
    OneEuro,
    double_exponential,
    exponential,
    one_euro,
)

__all__ = [
    "ConstantAccelerationFilter",
    "ConstantVelocityFilter",
    "DoubleExponential",
    "Exponential",
    "KalmanFilter",
    "OneEuro",
    "SmoothedStates",
    "constant_acceleration",
    "constant_velocity",
    "double_exponential",
    "exponential",
    "one_euro",
    "rts_constant_acceleration",
    "rts_constant_velocity",
    "smoothed_states",
]
