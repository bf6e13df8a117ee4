"""Every observation of a marker with both its planar poses, and how well the pixels fix each.

``camera_T_marker`` maps the marker's frame (origin at its printed top-left corner, x right and y up
as printed, z out of its face; metres) to the camera's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.cameras.camera import Camera, reproject
from motorcade.tracking.markers.corner_stream import (
    CornerStream,
    checked_numbers,
    checked_stamps,
)
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.planar import planar_poses

# A pose whose pixels leave a direction quite free would be inverted to infinity.
_LEAST_INFORMATION = 1e-9


@dataclass(frozen=True, eq=False)
class MarkerObservations:
    """All observations of one camera, in order of time.

    Args:
        time_ns: ``(F,)`` stamps of all frames, strictly increasing.
        frame: ``(N,)`` row of ``time_ns`` that each observation belongs to, never falling.
        marker_ids: ``(N,)``; an id stands at most once in a frame.
        camera_T_marker: Motor ``(N, 2)``, both planar poses, the better reprojection first.
        error_px: ``(N, 2)`` their root mean square reprojection errors.
        rotation_covariance: ``(N, 2, 3, 3)`` of a small turn of the marker before the camera
            (camera axes), rad² for corners with 1 pixel of noise a coordinate.

    Raises:
        ValueError: shapes that do not agree, frames or stamps out of order, an id twice in a
            frame, numbers that are not finite.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.markers.disambiguate import MarkerObservations
    >>> two = Motor.from_euler_translation([[3, 0.2, 0], [3, -0.2, 0]], [[0, 0, 0.6]] * 2)
    >>> seen = MarkerObservations([0, 50_000_000], [0, 1], [7, 7], Motor.stack([two, two]),
    ...     [[0.2, 0.9], [0.3, 0.4]], np.broadcast_to(1e-4 * np.eye(3), (2, 2, 3, 3)))
    >>> len(seen), seen.of_frame(1)  # two observations of marker 7, the second one nearly ambiguous
    (2, array([1]))
    """

    time_ns: IntArray
    frame: IntArray
    marker_ids: IntArray
    camera_T_marker: Motor
    error_px: FloatArray
    rotation_covariance: FloatArray

    def __post_init__(self) -> None:
        stamps = checked_stamps(self.time_ns, "MarkerObservations.time_ns")
        frame, ids = checked_numbers(self.frame, self.marker_ids, len(stamps), "MarkerObservations")
        count = len(ids)
        if self.camera_T_marker.shape != (count, 2):
            raise ValueError(
                f"MarkerObservations.camera_T_marker: expected {(count, 2)} poses, "
                f"got {self.camera_T_marker.shape}"
            )
        errors = frozen(checked_floats(self.error_px, "MarkerObservations.error_px", (2,)))
        field = "MarkerObservations.rotation_covariance"
        covariance = frozen(checked_floats(self.rotation_covariance, field, (3, 3)))
        if errors.shape != (count, 2) or covariance.shape != (count, 2, 3, 3):
            raise ValueError(
                f"MarkerObservations.error_px, rotation_covariance: expected {(count, 2)} and "
                f"{(count, 2, 3, 3)}, got {errors.shape} and {covariance.shape}"
            )
        values = {"time_ns": stamps, "frame": frame, "marker_ids": ids, "error_px": errors}
        for name, value in (values | {"rotation_covariance": covariance}).items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        """Number of observations."""
        return len(self.marker_ids)

    def of_frame(self, row: int) -> IntArray:
        """Rows of the observations in one frame."""
        first, last = np.searchsorted(self.frame, [row, row + 1])
        return np.arange(first, last)

    @classmethod
    def joined(cls, parts: Sequence[MarkerObservations]) -> MarkerObservations:
        """One after the other; at least one part, each later than the one before.

        Raises:
            ValueError: parts out of order.
        """
        starts = np.cumsum([0, *(len(one.time_ns) for one in parts[:-1])])
        return cls(
            np.concatenate([one.time_ns for one in parts]),
            np.concatenate([one.frame + start for one, start in zip(parts, starts, strict=True)]),
            np.concatenate([one.marker_ids for one in parts]),
            Motor.concatenate([one.camera_T_marker for one in parts]),
            np.concatenate([one.error_px for one in parts]),
            np.concatenate([one.rotation_covariance for one in parts]),
        )

    def of_frames(self, rows: IntArray) -> MarkerObservations:
        """Only these frames ``(f,)``, rising."""
        chosen = np.isin(self.frame, rows)
        return MarkerObservations(
            self.time_ns[rows],
            np.searchsorted(rows, self.frame[chosen]),
            self.marker_ids[chosen],
            self.camera_T_marker[chosen],
            self.error_px[chosen],
            self.rotation_covariance[chosen],
        )


def pose_stream(stream: CornerStream, side_m: Mapping[int, float]) -> MarkerObservations:
    """Both planar poses of every detection, by IPPE.

    Detections through whose corners the lens model has no ray, or that no planar pose explains,
    are left out.

    Args:
        stream: corners of one camera.
        side_m: side of each marker's black square, metres, by id.

    Raises:
        ValueError: a marker whose size is not given, or is not above 0.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.markers.corner_stream import CornerStream
    >>> from motorcade.tracking.markers.disambiguate import best_single, pose_stream, resolve
    >>> from motorcade.tracking.markers.families import marker_points_m
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> tilted = Rotor.from_rotation_vector([np.pi - 0.5, 0.0, 0.0])
    >>> camera_T_marker = Motor.from_rotor_translation(tilted, [[0.0, 0.0, 0.6], [0.05, 0.0, 0.6]])
    >>> corners_px = camera.project(camera_T_marker[:, None].apply(marker_points_m(0.1)))
    >>> stream = CornerStream(camera, [0, 33_000_000], [0, 1], [7, 7], corners_px)
    >>> observations = pose_stream(stream, {7: 0.1})
    >>> resolve(observations).choice, best_single(observations).choice
    (array([0, 0]), array([0, 0]))
    """
    missing = sorted(set(stream.marker_ids.tolist()) - set(side_m))
    if missing:
        raise ValueError(f"side_m: expected the size of marker {missing[0]}, got none")
    wrong = [one for one, side in side_m.items() if not 0.0 < side < np.inf]
    if wrong:
        raise ValueError(
            f"side_m: expected metres above 0, got {side_m[wrong[0]]} for marker {wrong[0]}"
        )
    sides = np.array([side_m[int(marker)] for marker in stream.marker_ids], np.float64)
    rows, camera_T_marker, errors = planar_poses(stream.camera, stream.corners_px, sides)
    points = marker_points_m(sides[rows])
    return MarkerObservations(
        stream.time_ns,
        stream.frame[rows],
        stream.marker_ids[rows],
        camera_T_marker,
        errors,
        rotation_covariance(stream.camera, camera_T_marker, points[:, None]),
    )


def rotation_covariance(camera: Camera, camera_T_marker: Motor, points_m: FloatArray) -> FloatArray:
    """How far corners with 1 pixel of noise let a marker turn, translation left free.

    Args:
        camera: who sees the markers.
        camera_T_marker: Motor ``(*)``.
        points_m: ``(*, 4, 3)`` corners in the markers' frames.

    Returns:
        ``(*, 3, 3)`` rad², camera axes.
    """
    _, by_twist, _ = reproject(camera, camera_T_marker[..., None].apply(points_m))
    jacobian = by_twist.reshape(*camera_T_marker.shape, 8, 6)
    jacobian = np.nan_to_num(jacobian)  # a corner without an image tells nothing
    information = jacobian.swapaxes(-1, -2) @ jacobian
    slack = np.diag([1.0] * 3 + [1e-3] * 3) * _LEAST_INFORMATION
    covariance = np.asarray(np.linalg.inv(information + slack)[..., :3, :3], np.float64)
    return 0.5 * (covariance + covariance.swapaxes(-1, -2))
