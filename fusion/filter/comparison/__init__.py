"""The same filter with its error written in other coordinates, for `motorcade consistency`.

Motion, noise, measurements and gate are those of `fusion.filter`, and so is the linearisation of
the motion; what differs is how an error of the state is written as 15 numbers, so what a correction
does and what the covariance means.
"""

from motorcade.fusion.filter.comparison.batched import (
    ErrorCoordinates,
    Estimates,
    EulerErrors,
    ExactEulerErrors,
    ExtendedPoseErrors,
    QuaternionTranslationErrors,
    Runs,
    RunStates,
    filter_runs,
)

__all__ = [
    "ErrorCoordinates",
    "Estimates",
    "EulerErrors",
    "ExactEulerErrors",
    "ExtendedPoseErrors",
    "QuaternionTranslationErrors",
    "RunStates",
    "Runs",
    "filter_runs",
]
