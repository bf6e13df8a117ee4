"""Cameras, printed boards and their tracking: pictures in, pose measurements out.

Poses are ``world_T_camera``; for a board the world is the board's own frame (origin at its first
corner, x right and y up as printed, z out of the printed face). Needs OpenCV.
"""

from __future__ import annotations

from motorcade.tracking.board_tracking.registration import registration_px
from motorcade.tracking.board_tracking.selection import Choice, choose
from motorcade.tracking.board_tracking.track import FRAME_STATES, BoardTrack, track_board
from motorcade.tracking.board_tracking.tracker import BoardTracker, TrackedFrame
from motorcade.tracking.boards import (
    Board,
    BoardCorners,
    CharucoBoard,
    Checkerboard,
    GrayImage,
    MarkerGrid,
    Pattern,
    SingleMarker,
)
from motorcade.tracking.cameras.calibrate import (
    Calibration,
    CalibrationError,
    calibrate,
    spread_views,
)
from motorcade.tracking.cameras.camera import Camera, CameraModel
from motorcade.tracking.markers import (
    FAMILIES,
    Detection,
    PosedMarker,
    detect_markers,
    pose_marker,
)
from motorcade.tracking.measurements import MarkerObservation, PoseMeasurements
from motorcade.tracking.pose import (
    SIGMA_FLOOR_PX,
    PlanarCandidates,
    RefinedPose,
    TrackingError,
    planar_candidates,
    refine,
    reprojection_px,
)

__all__ = [
    "FAMILIES",
    "FRAME_STATES",
    "SIGMA_FLOOR_PX",
    "Board",
    "BoardCorners",
    "BoardTrack",
    "BoardTracker",
    "Calibration",
    "CalibrationError",
    "Camera",
    "CameraModel",
    "CharucoBoard",
    "Checkerboard",
    "Choice",
    "Detection",
    "GrayImage",
    "MarkerGrid",
    "MarkerObservation",
    "Pattern",
    "PlanarCandidates",
    "PoseMeasurements",
    "PosedMarker",
    "RefinedPose",
    "SingleMarker",
    "TrackedFrame",
    "TrackingError",
    "calibrate",
    "choose",
    "detect_markers",
    "planar_candidates",
    "pose_marker",
    "refine",
    "registration_px",
    "reprojection_px",
    "spread_views",
    "track_board",
]
