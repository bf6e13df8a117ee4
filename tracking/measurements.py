"""Pose measurements: where the camera was seen to be, and how sure that is.

Poses are ``world_T_camera``. A covariance belongs to the right (camera-frame) perturbation
``world_T_camera @ Motor.from_twist(delta)``, ``delta`` = rotation (rad), then translation (m).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen

_ASYMMETRY = 1e-9


@dataclass(frozen=True, eq=False)
class MarkerObservation:
    """Corners of a board in one image, with both planar poses that they allow.

    Args:
        time_ns: stamp of the image.
        ids: ``(n,)`` rising; each is the corner's row in its board's ``points_m``.
        corners_px: ``(n, 2)`` pixels.
        candidates: Motor ``(2,)``, ``world_T_camera`` of both planar solutions, better one first.
        candidate_error_px: ``(2,)`` their root mean square reprojection errors, rising.

    Raises:
        ValueError: shapes that do not agree, or numbers that are not finite.
    """

    time_ns: int
    ids: IntArray
    corners_px: FloatArray
    candidates: Motor
    candidate_error_px: FloatArray

    def __post_init__(self) -> None:
        ids = np.array(self.ids, dtype=np.int64)
        ids.setflags(write=False)
        corners = frozen(checked_floats(self.corners_px, "MarkerObservation.corners_px", (2,)))
        if corners.shape != (*ids.shape, 2) or ids.ndim != 1:
            raise ValueError(
                f"MarkerObservation.corners_px: expected {(*ids.shape, 2)}, got {corners.shape}"
            )
        if self.candidates.shape != (2,):
            raise ValueError(
                f"MarkerObservation.candidates: expected 2 poses, got {self.candidates.shape}"
            )
        field = "MarkerObservation.candidate_error_px"
        errors = frozen(checked_floats(self.candidate_error_px, field, (2,)))
        object.__setattr__(self, "ids", ids)
        object.__setattr__(self, "corners_px", corners)
        object.__setattr__(self, "candidate_error_px", errors)


@dataclass(frozen=True, eq=False)
class PoseMeasurements:
    """Measured poses and their covariances.

    Args:
        trajectory: ``world_T_camera`` at the N stamps that have a measurement.
        covariance: ``(N, 6, 6)`` of the right perturbation, rotation (rad) then translation (m).

    Raises:
        ValueError: another shape, NaN or infinity, or matrices that are not symmetric and
            positive definite.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.tracking import PoseMeasurements
    >>> world_T_camera = Trajectory([0, 50_000_000], Motor.identity((2,)))
    >>> sigma = np.repeat([0.01, 0.002], 3)  # rad, m, in the camera's frame
    >>> len(PoseMeasurements(world_T_camera, np.tile(np.diag(sigma**2), (2, 1, 1))))
    2
    """

    trajectory: Trajectory
    covariance: FloatArray

    def __post_init__(self) -> None:
        field = "PoseMeasurements.covariance"
        covariance = checked_floats(self.covariance, field, (6, 6))
        if covariance.shape != (len(self.trajectory), 6, 6):
            raise ValueError(
                f"{field}: expected {(len(self.trajectory), 6, 6)}, got {covariance.shape}"
            )
        skew = np.abs(covariance - covariance.swapaxes(-1, -2)).max(axis=(-1, -2))
        largest = np.abs(covariance).max(axis=(-1, -2))
        if np.any(skew > _ASYMMETRY * largest):
            raise ValueError(f"{field}: expected symmetric matrices, got one that is not")
        if np.any(np.linalg.eigvalsh(covariance)[..., 0] <= 0.0):
            raise ValueError(f"{field}: expected positive definite matrices, got one that is not")
        object.__setattr__(self, "covariance", frozen(covariance))

    def __len__(self) -> int:
        return len(self.trajectory)
