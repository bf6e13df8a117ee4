"""Where a single marker of known size stands: both planar poses that its corners allow.

A marker's frame is a board's: origin at its printed top-left corner, x right and y up as printed,
z out of its face; metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import check_length
from motorcade.tracking.markers.detection import Detection
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.pose import PlanarCandidates, planar_candidates


@dataclass(frozen=True, eq=False)
class PosedMarker:
    """A detection with both its planar poses.

    Args:
        detection: what was seen.
        candidates: both poses, the better first; their "world" is the marker's frame.

    >>> from motorcade.tracking import Camera, SingleMarker, detect_markers, pose_marker
    >>> image, _ = SingleMarker("tag36h11", 7, side_m=0.1).draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> [found] = detect_markers(image, "tag36h11", camera)
    >>> marker = pose_marker(found, camera, side_m=0.1)
    >>> float(marker.camera_T_marker[0].translation_m[2].round(2))  # 200 px * 0.1 m / 100 px
    0.2
    """

    detection: Detection
    candidates: PlanarCandidates

    @property
    def camera_T_marker(self) -> Motor:
        """Motor ``(2,)``: marker coordinates to camera coordinates, the better pose first."""
        return self.candidates.world_T_camera.inverse()

    @property
    def ambiguity(self) -> float:
        """The better reprojection error over the other, 0 to 1; near 1 the pixels cannot tell."""
        better, other = self.candidates.error_px
        return float(better / other) if other > 0.0 else 1.0


def pose_marker(detection: Detection, camera: Camera, side_m: float) -> PosedMarker:
    """Both planar poses of a marker by IPPE, with their reprojection errors.

    Args:
        detection: the marker.
        camera: what it was seen with.
        side_m: side of its black square, metres.

    Raises:
        ValueError: a side that is not above zero.
        TrackingError: corners through which the lens model has no ray.
    """
    check_length(side_m, "side_m")
    corners = BoardCorners(np.arange(4), detection.corners_px, marker_points_m(side_m))
    return PosedMarker(detection, planar_candidates(corners, camera))
