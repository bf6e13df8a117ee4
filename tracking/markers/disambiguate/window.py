"""A segment of frames with all that their observations say, and what is remembered of earlier ones.

Two facts decide between candidates. A motion of the camera moves all markers in view, so that
candidates of many markers vote for one rotation between frames (`vote`). And most markers do not
move: over many frames only one orientation in the world fits (`orientations`). Of a marker never
seen before the company speaks: many hang on the same boards and walls (`states`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.disambiguate.observations import MarkerObservations
from motorcade.tracking.pose import SIGMA_FLOOR_PX

# Orientations that are kept for a marker until the evidence has spoken.
MODES = 4
# Orientations are never taken as surer than this: lenses and paper bend.
_SYSTEMATIC_RAD = np.radians(1.0)
# Corners err with heavier tails than the normal distribution's (Student's t, Lange et al. 1989).
_TAIL = 4.0
_FREEDOM = 2  # of reprojections: eight coordinates less the six numbers of a pose
_TURN_FREEDOM = 3
_MEDIAN_CHI2 = 1.3863  # median of chi squared with two degrees of freedom


@dataclass(frozen=True, eq=False)
class Window:
    """MarkerObservations of some frames, with their noise.

    Args:
        observations: N observations of K markers in F frames.
        marker_ids: ``(K,)`` rising.
        marker: ``(N,)`` row of ``marker_ids`` of each observation.
        camera_R_marker: Rotor ``(N, 2)``.
        evidence: ``(N, 2)`` what the pixels say against either candidate, nats; the lesser is 0.
        covariance: ``(N, 2, 3, 3)`` of a small turn, rad², camera axes.
        information: ``(N, 2, 3, 3)`` its inverse.
    """

    observations: MarkerObservations
    marker_ids: IntArray
    marker: IntArray
    camera_R_marker: Rotor
    evidence: FloatArray
    covariance: FloatArray
    information: FloatArray

    @classmethod
    def of(cls, observations: MarkerObservations, sigma_px: float) -> Window:
        """All observations, for corners with this noise a coordinate, pixels."""
        ids, marker = np.unique(observations.marker_ids, return_inverse=True)
        against = misfit(2.0 * (observations.error_px / sigma_px) ** 2, _FREEDOM)
        covariance = observations.rotation_covariance * sigma_px**2 + _SYSTEMATIC_RAD**2 * np.eye(3)
        return cls(
            observations,
            ids,
            marker,
            observations.camera_T_marker.rotor,
            against - against.min(axis=-1, keepdims=True),
            covariance,
            np.linalg.inv(covariance),
        )

    def of_frame(self, row: int) -> Window:
        """The observations of one frame only."""
        rows = self.observations.of_frame(row)
        ids, marker = np.unique(self.marker_ids[self.marker[rows]], return_inverse=True)
        return Window(
            self.observations.of_frames(np.array([row])),
            ids,
            marker,
            self.camera_R_marker[rows],
            self.evidence[rows],
            self.covariance[rows],
            self.information[rows],
        )

    @property
    def frame(self) -> IntArray:
        """``(N,)`` frame of each observation."""
        return self.observations.frame

    def excess(self, world_R_camera: Rotor, world_R_marker: Rotor) -> tuple[FloatArray, FloatArray]:
        """How far each candidate would have to turn to stand as the marker's orientations have it.

        Args:
            world_R_camera: Rotor ``(F,)``.
            world_R_marker: Rotor ``(K, H)``.

        Returns:
            rotation vectors ``(N, H, 2, 3)``, camera axes, and ``(N, H, 2)`` half their squares in
            units of the noise, nats.
        """
        expected = world_R_camera[self.frame][:, None].inverse() @ world_R_marker[self.marker]
        turn = expected[:, :, None] @ self.camera_R_marker[:, None, :].inverse()
        vector = turn.as_rotation_vector()
        half = 0.5 * np.einsum("nhci,ncij,nhcj->nhc", vector, self.information, vector)
        return vector, half


@dataclass(frozen=True, eq=False)
class Memory:
    """What is known of M markers from frames that are no longer looked at.

    Args:
        marker_ids: ``(M,)`` rising.
        world_R_marker: Rotor ``(M, H)``, orientations that each may have.
        information: ``(M, H, 3, 3)`` of those, world axes.
        message: ``(M, S)`` cost of each state at the last observation (see `states`).
        last_ns: ``(M,)`` stamp of the last observation.
        last_R: Rotor ``(M, 2)``, world orientation by either candidate of it.
        last_covariance: ``(M, 2, 3, 3)`` of those, world axes.
    """

    marker_ids: IntArray
    world_R_marker: Rotor
    information: FloatArray
    message: FloatArray
    last_ns: IntArray
    last_R: Rotor
    last_covariance: FloatArray

    def normals(self, still: int) -> FloatArray:
        """``(M, 3)`` world, by the most probable of each marker's first `still` states."""
        if len(self.marker_ids) == 0:
            return np.zeros((0, 3))
        mode = np.argmin(self.message[:, :still], axis=-1) // 2
        rotors = self.world_R_marker[np.arange(len(mode)), mode]
        return rotors.apply(np.array([0.0, 0.0, 1.0]))

    def rows_of(self, marker_ids: IntArray) -> IntArray:
        """Row ``(K,)`` of each of these markers; -1 where it is not known."""
        if len(self.marker_ids) == 0:
            return np.full(len(marker_ids), -1)
        row = np.minimum(np.searchsorted(self.marker_ids, marker_ids), len(self.marker_ids) - 1)
        return np.where(self.marker_ids[row] == marker_ids, row, -1)


def misfit(half: FloatArray, freedom: int = _TURN_FREEDOM) -> FloatArray:
    """What half a squared distance in units of the noise tells against it, nats, with heavy tails.

    Never settles at a ceiling: of two candidates that are both far off the nearer stays the better.
    """
    against: FloatArray = 0.5 * (_TAIL + freedom) * np.log1p(2.0 * half / _TAIL)
    return against


def influence(half: FloatArray) -> FloatArray:
    """How much a turn at such a distance counts in a mean; fades as heavy tails have it."""
    weight: FloatArray = (_TAIL + _TURN_FREEDOM) / (_TAIL + 2.0 * half)
    return weight


def corner_noise_px(error_px: FloatArray) -> float:
    """Noise a coordinate of corners, from the better errors ``(N,)`` of many observations.

    The median is not moved by the few corners that are quite wrong. At least `SIGMA_FLOOR_PX`.
    """
    if len(error_px) == 0:
        return SIGMA_FLOOR_PX
    return max(float(2.0 * np.median(error_px) / np.sqrt(_MEDIAN_CHI2)), SIGMA_FLOOR_PX)
