"""Poses of a camera over a board, image by image, and the errors that they have in common.

A camera that is calibrated from the same images is known only so well, and its error moves every
pose. Least squares over camera and poses splits into two parts that lose nothing (Schur): what all
images together say of the intrinsics, and what each image says of its pose at given intrinsics,
with how that moves as the intrinsics do. Whoever goes on to estimate more from the poses, as
`motorcade.fusion.camera_imu` does, takes both, and has in effect used every corner.

The board frame is called ``world``; poses are ``world_T_camera``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.audit import scatter_px
from motorcade.tracking.board_tracking.tracker import PoseChoice, choose_pose
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import (
    Calibration,
    Fit,
    Observations,
    calibrate,
    fit_camera,
    spread_views,
)
from motorcade.tracking.cameras.camera import Camera, CameraModel
from motorcade.tracking.measurements import PoseMeasurements
from motorcade.tracking.pose import (
    SIGMA_FLOOR_PX,
    RefinedPose,
    TrackingError,
    planar_candidates,
)

_MOST_VIEWS = 60  # that a camera is found from; with all others it is then refined
# Corners of a view are wrong where it fits worse than this and than so many times a typical view,
# or than any corner can scatter (`scatter_px`), however the others fit.
_OUTLIER_FACTOR = 3.0
_OUTLIER_FLOOR_PX = 0.3
_CONTINUITY_NS = 500_000_000  # how long an earlier pose helps to choose between two


@dataclass(frozen=True, eq=False)
class BoardMeasurements:
    """Poses over a board, with what their errors have in common.

    Fields:
        camera: who saw it, as given or as found.
        calibration: how it was found; None where it was given.
        views: V, in how many images the board was found.
        measurements: ``world_T_camera`` of the N that fit, the board's frame the world; covariances
            at given intrinsics.
        intrinsics_root: ``(p, p)``; times p numbers of unit normal distribution it gives errors of
            fx, fy, cx, cy (pixels) and the distortion as the corners leave them open; p is zero
            where the camera was given.
        effect: ``(N, 6, p)`` how those numbers move each pose (right perturbation, rad and m).
        sigma_px: noise of a corner's coordinate that all this stands on.
        error_px: ``(N,)`` root mean square reprojection errors.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Rotor
        >>> from motorcade.tracking import Camera, Checkerboard, measure_board
        >>> from motorcade.tracking.boards import BoardCorners
        >>> camera, board = Camera(640, 480, 500.0, 500.0, 315.0, 236.0), Checkerboard(6, 5, 0.04)
        >>> face_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])  # printed face to the camera
        >>> camera_T_board = Motor.from_rotor_translation(face_down, [-0.1, -0.08, 0.4])
        >>> px = camera.project(camera_T_board.apply(board.points_m))
        >>> views = [BoardCorners(np.arange(30), px, board.points_m)]
        >>> seen = measure_board(np.array([0]), views, camera)
        >>> world_T_camera = seen.measurements.trajectory.motors[0]
        >>> np.allclose(world_T_camera.coefficients, camera_T_board.inverse().coefficients)
        True
    """

    camera: Camera
    calibration: Calibration | None
    views: int
    measurements: PoseMeasurements
    intrinsics_root: FloatArray
    effect: FloatArray
    sigma_px: float
    error_px: FloatArray

    def camera_at(self, common: FloatArray) -> Camera:
        """The camera whose intrinsics are off by what these numbers ``(p,)`` say."""
        if not len(self.intrinsics_root):
            return self.camera
        own = self.camera
        stated = np.array([own.fx, own.fy, own.cx, own.cy, *own.distortion])
        fx, fy, cx, cy, *distortion = (stated + self.intrinsics_root @ common).tolist()
        return replace(own, fx=fx, fy=fy, cx=cx, cy=cy, distortion=tuple(distortion))


def measure_board(
    time_ns: IntArray,
    views: Sequence[BoardCorners],
    camera: Camera | None = None,
    *,
    size: tuple[int, int] | None = None,
    model: CameraModel = "radtan",
) -> BoardMeasurements:
    """Poses of the camera in every view, and the camera itself where it is not given.

    Args:
        time_ns: ``(V,)`` stamps of the views, rising.
        views: corners of one board.
        camera: known; None: it is found from these views.
        size: width and height of the images, where the camera is to be found.
        model: of its lens.

    Raises:
        CalibrationError: what `calibrate` refuses.
        TrackingError: no view from which a pose follows, or none that a pose fits as well as
            corners can scatter in images of this size.
        ValueError: neither a camera nor a size.
    """
    calibrated = None
    if camera is None:
        if size is None:
            raise ValueError("size: expected width and height where no camera is given, got none")
        calibrated = calibrate([views[k] for k in spread_views(views, _MOST_VIEWS)], size, model)
        camera = calibrated.camera
    rows, poses = _posed(time_ns, views, camera)
    if not poses:
        raise TrackingError(f"views: expected some that give a pose, got none of {len(views)}")
    errors = np.array([pose.error_px for pose in poses])
    usual_px = max(_OUTLIER_FLOOR_PX, _OUTLIER_FACTOR * float(np.median(errors)))
    limit_px = scatter_px(camera)
    fits = errors <= min(usual_px, limit_px)
    if not fits.any():
        raise TrackingError(
            f"views: expected some that a pose fits to {limit_px:.2g} px, got {errors.min():.2g} "
            "at best; look at the camera and the board as stated"
        )
    kept = [views[row] for row in rows[fits]]
    chosen = [pose for pose, fit in zip(poses, fits, strict=True) if fit]
    stamps, motors = time_ns[rows[fits]], Motor.stack([pose.world_T_camera for pose in chosen])
    if calibrated is None:
        freedom = sum(max(2 * len(view) - 6, 0) for view in kept)
        squares = sum(float(np.sum(pose.residuals_px**2)) for pose in chosen)
        sigma_px = _sigma(squares, freedom)
        covariance = np.stack(
            [(sigma_px / pose.sigma_px) ** 2 * pose.covariance for pose in chosen]
        )
        measured = PoseMeasurements(Trajectory(stamps, motors), covariance)
        nothing = np.zeros((len(kept), 6, 0))
        return BoardMeasurements(
            camera, None, len(views), measured, np.zeros((0, 0)), nothing, sigma_px, errors[fits]
        )
    fit = fit_camera(Observations.of(kept), camera, motors)
    return _fitted(fit, calibrated, stamps, kept, len(views))


def _posed(
    time_ns: IntArray, views: Sequence[BoardCorners], camera: Camera
) -> tuple[NDArray[np.intp], list[RefinedPose]]:
    """Rows of the views that give a pose, and those; neighbours help to choose between two."""
    rows: list[int] = []
    poses: list[RefinedPose] = []
    before: tuple[int, PoseChoice] | None = None
    for row, (stamp, view) in enumerate(zip(time_ns.tolist(), views, strict=True)):
        if before is not None and stamp - before[0] > _CONTINUITY_NS:
            before = None
        try:
            both = planar_candidates(view, camera)
            if before is None:
                choice = choose_pose(both, view, camera)
            else:
                choice = choose_pose(both, view, camera, before[1], 1e-9 * (stamp - before[0]))
        except TrackingError:  # counted: `BoardMeasurements.views` less those that have a pose
            continue
        before = stamp, choice
        rows.append(row)
        poses.append(choice.pose)
    return np.array(rows, dtype=np.intp), poses


def _fitted(
    fit: Fit, calibration: Calibration, stamps: IntArray, kept: list[BoardCorners], views: int
) -> BoardMeasurements:
    """Poses, and how what is left open of the intrinsics moves them."""
    counts = np.array([len(view) for view in kept])
    freedom = 2 * int(counts.sum()) - 6 * len(kept) - len(fit.information)
    squares = (fit.residuals_px**2).sum(axis=-1)
    sigma_px = _sigma(float(squares.sum()), freedom)
    inverse = np.linalg.inv(fit.pose_information)
    root = sigma_px * np.linalg.inv(np.linalg.cholesky(fit.information)).T
    sums = np.add.reduceat(squares, np.cumsum(counts) - counts)
    measured = PoseMeasurements(
        Trajectory(stamps, fit.board_T_camera),
        sigma_px**2 * 0.5 * (inverse + inverse.swapaxes(-1, -2)),
    )
    return BoardMeasurements(
        camera=fit.camera,
        calibration=calibration,
        views=views,
        measurements=measured,
        intrinsics_root=root,
        effect=-(inverse @ fit.coupling) @ root,
        sigma_px=sigma_px,
        error_px=np.sqrt(sums / counts),
    )


def _sigma(squares: float, freedom: int) -> float:
    return max(float(np.sqrt(squares / max(freedom, 1))), SIGMA_FLOOR_PX)
