"""Calibration of a camera from images of a board: intrinsics, how sure they are, what was used.

All views are fitted at once; views that fit much worse than the others are left
out. What the views cannot tell (too few, all at one angle) is refused, not guessed.

Source: Zhang 2000 for what views are needed; Triggs et al. 2000 for the fit.

A lens model with terms to spare fits what it saw as well as the right one; it does not predict what
it has not seen. The simplest model wins whose errors on held-out views are no larger than the best
one's, within what they scatter over views.

The poses are eliminated view by view, so a step costs time in proportion to the corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras import lenses
from motorcade.tracking.cameras.camera import Camera, CameraModel, reproject
from motorcade.tracking.optimise import BlockEquations, Stop, minimise
from motorcade.tracking.pose import SIGMA_FLOOR_PX, TrackingError, planar_candidates, refine

_STOP = Stop(steps=100, gain=1e-10)


@dataclass(frozen=True, eq=False)
class Observations:
    """The corners of V views, one view after the other.

    Fields:
        points_m: ``(N, 3)`` board frame.
        corners_px: ``(N, 2)``.
        starts: ``(V,)`` the first row of each view.
    """

    points_m: FloatArray
    corners_px: FloatArray
    starts: IntArray

    @classmethod
    def of(cls, views: list[BoardCorners]) -> Observations:
        """Put views behind one another."""
        counts = np.array([len(view) for view in views])
        return cls(
            np.concatenate([view.points_m for view in views]),
            np.concatenate([view.corners_px for view in views]),
            np.cumsum(counts) - counts,
        )

    @property
    def view(self) -> IntArray:
        """The view of each corner ``(N,)``."""
        counts = np.diff(np.append(self.starts, len(self.points_m)))
        return np.repeat(np.arange(len(self.starts)), counts)

    def sums(self, values: FloatArray) -> FloatArray:
        """Sums ``(V, ...)`` over the corners of each view."""
        return np.add.reduceat(values, self.starts, axis=0)


@dataclass(frozen=True, eq=False)
class Fit:
    """A camera and poses that are least squares.

    Fields:
        camera: with the fitted intrinsics.
        board_T_camera: Motor ``(V,)``.
        residuals_px: ``(N, 2)`` reprojection minus corner.
        information: ``(p, p)`` of fx, fy, cx, cy and the distortion, for corners of unit noise,
            the poses being unknown too.
        pose_information: ``(V, 6, 6)`` of each pose (right perturbation), the camera being known.
        coupling: ``(V, 6, p)`` the part of the information that pose and intrinsics have in common.
    """

    camera: Camera
    board_T_camera: Motor
    residuals_px: FloatArray
    information: FloatArray
    pose_information: FloatArray
    coupling: FloatArray


@dataclass(frozen=True, eq=False)
class _State:
    numbers: FloatArray  # fx, fy, cx, cy and the distortion
    board_T_camera: Motor

    def retract(self, step: tuple[FloatArray, FloatArray]) -> _State:
        numbers = self.numbers.copy()
        numbers[: step[0].size] += step[0].ravel()
        return _State(numbers, self.board_T_camera.retract(step[1]))


class _Reprojection:
    """All corners against their reprojection; infinite cost where no camera is like that."""

    def __init__(self, seen: Observations, like: Camera, state: _State) -> None:
        self._seen = seen
        self.cost = np.inf
        if not (np.isfinite(state.numbers).all() and (state.numbers[:2] > 0.0).all()):
            return
        self.camera = _camera(like, state.numbers)
        self._in_camera = state.board_T_camera.inverse()[seen.view].apply(seen.points_m)
        self._pixels, self._by_pose, _ = reproject(self.camera, self._in_camera)
        self.residuals_px: FloatArray = self._pixels - seen.corners_px
        self.cost = 0.5 * float((self.residuals_px**2).sum())

    @cached_property
    def equations(self) -> BlockEquations:
        seen, residuals = self._seen, self.residuals_px
        by_camera = _by_camera(self.camera, self._in_camera, self._pixels)
        flipped = self._by_pose.swapaxes(-1, -2)
        every = np.arange(len(seen.starts))
        return BlockEquations(
            information=np.einsum("nij,nik->jk", by_camera, by_camera),
            gradient=np.einsum("nij,ni->j", by_camera, residuals),
            blocks=seen.sums(flipped @ self._by_pose),
            block_gradient=seen.sums((flipped @ residuals[..., None])[..., 0]),
            block_of=every,
            group_of=np.zeros_like(every),
            coupling=seen.sums(flipped @ by_camera),
        )


def fit_camera(seen: Observations, camera: Camera, board_T_camera: Motor) -> Fit:
    """Minimise the reprojection error of all corners over camera and poses.

    Args:
        seen: the corners.
        camera: where to start; its model and count of coefficients stay. Rational radtan
            coefficients (k4 to k6) are held.
        board_T_camera: Motor ``(V,)`` to start from, every corner before the camera.
    """
    numbers = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
    evaluate = partial(_Reprojection, seen, camera)
    minimum = minimise(_State(numbers, board_T_camera), evaluate, _State.retract, _STOP)
    at, equations = minimum.evaluation, minimum.evaluation.equations
    return Fit(
        at.camera,
        minimum.state.board_T_camera,
        at.residuals_px,
        equations.reduced_information,
        equations.blocks,
        equations.coupling,
    )


def _camera(like: Camera, numbers: FloatArray) -> Camera:
    fx, fy, cx, cy, *distortion = numbers.tolist()
    return replace(like, fx=fx, fy=fy, cx=cx, cy=cy, distortion=tuple(distortion))


def _by_camera(camera: Camera, points: FloatArray, pixels: FloatArray) -> FloatArray:
    """Derivative ``(N, 2, p)`` of the pixels by fx, fy, cx, cy and the distortion."""
    focal = np.array([camera.fx, camera.fy])
    columns = np.zeros((len(points), 2, 4))
    columns[:, 0, 0], columns[:, 1, 1] = ((pixels - (camera.cx, camera.cy)) / focal).T
    columns[:, 0, 2] = columns[:, 1, 3] = 1.0
    if camera.model == "pinhole":
        return columns
    by_lens = lenses.by_coefficients(camera.model, points, range(min(len(camera.distortion), 5)))
    return np.concatenate([columns, focal[:, None] * by_lens], axis=-1)


LEAST_VIEWS = 3
# Focal lengths to start from, in image widths.
_FOCAL_STARTS = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0)
_COEFFICIENTS: dict[CameraModel, int] = {"pinhole": 0, "radtan": 4, "equidistant": 4}
_ROUNDS = 5
_OUTLIER_FACTOR = 3.0
_OUTLIER_FLOOR_PX = 0.3
_LEAST_TURN_DEG = 5.0
_WORST_SHARE = 0.05  # standard deviation of a focal length, or of a principal point in widths
_COVERAGE_CELLS = (8, 6)


class CalibrationError(ValueError):
    """Views from which no camera follows; the message says what they lack.

    >>> from motorcade.tracking import CalibrationError, calibrate
    >>> try:
    ...     calibrate([], (640, 480))
    ... except CalibrationError as error:
    ...     print(error)
    views: expected at least 3 that show the board, got 0
    """


@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera and what speaks for it.

    Fields:
        camera: the calibrated camera.
        deviation: ``(p,)`` standard deviations of fx, fy, cx, cy (pixels) and of the distortion
            coefficients, for corner errors that are independent; correlated ones (a bent board, a
            lens that the model does not describe) are not in them.
        used: ``(V,)`` which views were fitted.
        view_error_px: ``(V,)`` root mean square reprojection error of every view; of a view that
            was left out, after its pose alone was fitted; infinite where it has none.
        residuals_px: ``(N, 2)`` reprojection minus corner, of the used views' corners in order.
        camera_T_board: Motor ``(U,)``, of the used views.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Calibration, Camera
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> deviation = np.array([0.4, 0.4, 0.3, 0.3])  # of fx, fy, cx, cy; no distortion
    >>> camera_T_board = Motor.from_euler_translation([[3.1, 0, 0], [2.6, 0, 0]], [[0, 0, 0.5]] * 2)
    >>> residuals_px = np.full((60, 2), 0.1)  # of two views with 30 corners each
    >>> used, view_error_px = np.array([True, True]), np.array([0.14, 0.14])
    >>> found = Calibration(camera, deviation, used, view_error_px, residuals_px, camera_T_board)
    >>> round(found.rmse_px, 3), round(found.turn_deg, 1)
    (0.141, 28.6)
    """

    camera: Camera
    deviation: FloatArray
    used: NDArray[np.bool_]
    view_error_px: FloatArray
    residuals_px: FloatArray
    camera_T_board: Motor

    @property
    def rmse_px(self) -> float:
        """Root mean square distance of the used corners from their reprojection."""
        return float(np.sqrt((self.residuals_px**2).sum(axis=-1).mean()))

    @property
    def turn_deg(self) -> float:
        """The largest angle between the board's normals in two used views, degrees."""
        return _largest_turn_deg(self.camera_T_board)

    def coverage(self, views: Sequence[BoardCorners]) -> float:
        """Share of the image's 8 by 6 cells that hold a corner of a used view."""
        columns, rows = _COVERAGE_CELLS
        seen = np.concatenate(
            [view.corners_px for view, used in zip(views, self.used, strict=True) if used]
        )
        size = np.array([self.camera.width, self.camera.height])
        cells = np.floor((seen + 0.5) / size * (columns, rows)).astype(int)
        inside = ((cells >= 0) & (cells < (columns, rows))).all(axis=-1)
        return len(np.unique(cells[inside], axis=0)) / (columns * rows)


def calibrate(
    views: Sequence[BoardCorners], size: tuple[int, int], model: CameraModel = "radtan"
) -> Calibration:
    """Find the camera that saw a board in these views.

    Args:
        views: corners of one board, each view from another place; ten or more, tilted up to about
            45 degrees all ways and filling the image between them, are a good calibration.
        size: width and height of the images, pixels.
        model: "pinhole", "radtan" (k1 k2 p1 p2) or "equidistant" (k1 k2 k3 k4).

    Raises:
        CalibrationError: fewer than three views, views that do not fit together, or views from
            which the focal length does not follow (the board always at one angle).
        ValueError: an unknown model, or a view without four corners that span the board.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera, Checkerboard, calibrate
    >>> from motorcade.tracking.boards import BoardCorners
    >>> camera, board = Camera(640, 480, 500.0, 500.0, 315.0, 236.0), Checkerboard(6, 5, 0.04)
    >>> face_down = Rotor.from_rotation_vector([np.pi, 0.0, 0.0])  # printed face to the camera
    >>> views = []
    >>> for tilt in ([0.4, 0.0, 0.0], [-0.4, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, -0.4, 0.2]):
    ...     turn = Rotor.from_rotation_vector(tilt) @ face_down
    ...     camera_T_board = Motor.from_rotor_translation(turn, [-0.1, -0.08, 0.4])
    ...     px = camera.project(camera_T_board.apply(board.points_m))
    ...     views.append(BoardCorners(np.arange(30), px, board.points_m))
    >>> found = calibrate(views, (640, 480), "pinhole")
    >>> round(found.camera.fx, 3), round(found.camera.cx, 3), int(found.used.sum())
    (500.0, 315.0, 4)
    """
    if model not in _COEFFICIENTS:
        raise ValueError(f"model: expected {', '.join(_COEFFICIENTS)}, got {model!r}")
    if len(views) < LEAST_VIEWS:
        raise CalibrationError(
            f"views: expected at least {LEAST_VIEWS} that show the board, got {len(views)}"
        )
    for index, view in enumerate(views):
        if not view.spanning:
            raise ValueError(f"views[{index}]: expected four corners that span the board")
    camera = _start(views, size, model)
    used = np.ones(len(views), bool)
    for last in [False] * _ROUNDS + [True]:
        fit = _fitted(views, used, camera)
        camera = fit.camera
        errors = _view_errors_px(views, used, fit)
        fitting = errors <= max(_OUTLIER_FLOOR_PX, _OUTLIER_FACTOR * np.median(errors[used]))
        if last or np.array_equal(fitting, used):
            break
        if np.count_nonzero(fitting) < LEAST_VIEWS:
            raise CalibrationError(
                f"views: expected at least {LEAST_VIEWS} that fit one camera, got "
                f"{np.count_nonzero(fitting)} of {len(views)}; is it the right board, and the "
                "right lens model?"
            )
        used = fitting
    return Calibration(
        camera=camera,
        deviation=_checked_deviation(fit),
        used=used,
        view_error_px=errors,
        residuals_px=fit.residuals_px,
        camera_T_board=fit.board_T_camera.inverse(),
    )


def spread_views(views: Sequence[BoardCorners], most: int) -> IntArray:
    """Choose at most `most` views that differ most, rising: neighbours in a video hardly do.

    Farthest points first (Gonzalez 1985), by where the board's outermost points lie in the image.
    """
    points = np.concatenate([view.points_m[:, :2] for view in views])
    low, high = points.min(axis=0), points.max(axis=0)
    outer = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    places = np.stack([_mapped(view, outer).ravel() for view in views])
    chosen = [int(np.argmax([len(view) for view in views]))]
    nearest = np.linalg.norm(places - places[chosen[0]], axis=-1)
    while len(chosen) < min(most, len(views)):
        chosen.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, np.linalg.norm(places - places[chosen[-1]], axis=-1))
    return np.array(sorted(set(chosen)))


def _mapped(view: BoardCorners, points: FloatArray) -> FloatArray:
    """Where points of the board lie in the image, by an affine fit to the view's corners."""
    ones = np.ones((len(view), 1))
    affine, *_ = np.linalg.lstsq(np.hstack([view.points_m[:, :2], ones]), view.corners_px)
    mapped: FloatArray = np.hstack([points, np.ones((len(points), 1))]) @ affine
    return mapped


def _start(views: Sequence[BoardCorners], size: tuple[int, int], model: CameraModel) -> Camera:
    """The camera without distortion that fits the typical view best, centre in the middle."""
    width, height = size
    middle = (0.5 * (width - 1), 0.5 * (height - 1))
    lens = (0.0,) * _COEFFICIENTS[model]
    tried = [
        Camera(width, height, share * width, share * width, *middle, model, lens)
        for share in _FOCAL_STARTS
    ]
    some = [views[index] for index in spread_views(views, 20)]
    errors = [np.median([_posed(view, camera)[1] for view in some]) for camera in tried]
    if not np.isfinite(errors).any():
        raise CalibrationError("views: expected corners that some camera explains, got none")
    return tried[int(np.argmin(errors))]


def _posed(view: BoardCorners, camera: Camera) -> tuple[Motor, float]:
    """The camera's better planar pose and its error; infinite where there is none."""
    try:
        candidates = planar_candidates(view, camera)
    except TrackingError:
        return Motor.identity(), np.inf
    return candidates.world_T_camera[0], float(candidates.error_px[0])


def view_error_px(view: BoardCorners, camera: Camera) -> float:
    """Root mean square error of a view with its own best pose, pixels; infinite without one."""
    pose, error = _posed(view, camera)
    return refine(view, camera, pose).error_px if np.isfinite(error) else error


def _fitted(views: Sequence[BoardCorners], used: NDArray[np.bool_], camera: Camera) -> Fit:
    posed = [_posed(view, camera) for view, one in zip(views, used, strict=True) if one]
    if not np.isfinite([error for _, error in posed]).all():
        raise CalibrationError(
            "views: expected every corner inside what the lens model covers, got some outside; "
            "is it the right lens model?"
        )
    seen = Observations.of([view for view, one in zip(views, used, strict=True) if one])
    return fit_camera(seen, camera, Motor.stack([pose for pose, _ in posed]))


def _view_errors_px(views: Sequence[BoardCorners], used: NDArray[np.bool_], fit: Fit) -> FloatArray:
    errors = np.empty(len(views))
    ends = np.cumsum([len(view) for view, one in zip(views, used, strict=True) if one])
    squared = np.split((fit.residuals_px**2).sum(axis=-1), ends[:-1])
    errors[used] = [np.sqrt(one.mean()) for one in squared]
    errors[~used] = [
        view_error_px(view, fit.camera) for view, kept in zip(views, used, strict=True) if not kept
    ]
    return errors


def _checked_deviation(fit: Fit) -> FloatArray:
    """Standard deviations; refuses what leaves the focal length or the centre open."""
    turn_deg = _largest_turn_deg(fit.board_T_camera.inverse())
    if turn_deg < _LEAST_TURN_DEG:
        raise CalibrationError(
            f"views: expected the board tilted at different angles, got {turn_deg:.1f} degrees "
            "between any two views at most; the focal length does not follow from parallel "
            "views: tilt the board or the camera by 30 degrees and more, all ways"
        )
    count, parameters = fit.residuals_px.size, len(fit.information)
    freedom = max(count - parameters - 6 * len(fit.board_T_camera), 1)
    sigma = max(float(np.sqrt((fit.residuals_px**2).sum() / freedom)), SIGMA_FLOOR_PX)
    scale = 1.0 / np.sqrt(np.diag(fit.information))
    values, vectors = np.linalg.eigh(fit.information * scale[:, None] * scale)
    spread = (vectors**2 / np.maximum(values, 1e-15)).sum(axis=-1)
    deviation: FloatArray = sigma * scale * np.sqrt(spread)
    camera = fit.camera
    shares = deviation[:4] / (camera.fx, camera.fy, camera.width, camera.width)
    if not shares.max() <= _WORST_SHARE:
        raise CalibrationError(
            "views: expected them to fix focal length and centre to 5 %, got "
            f"fx = {camera.fx:.0f} +- {deviation[0]:.0f} and cx = {camera.cx:.0f} +- "
            f"{deviation[2]:.0f} pixels; take more views, tilted at other angles and nearer"
        )
    return deviation


def _largest_turn_deg(camera_T_board: Motor) -> float:
    normals = camera_T_board.rotor.apply([0.0, 0.0, 1.0])
    return float(np.degrees(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0).min())))


MODELS: tuple[CameraModel, ...] = ("pinhole", "radtan", "equidistant")
"""Simplest first."""
_AS_GOOD = 1.02  # a simpler model may predict so much worse than the best
_SCATTERS = 2.0
_FOLDS = 3
_ALIKE_PX = 1e-3  # errors below are rounding


@dataclass(frozen=True, eq=False)
class LensTrial:
    """A lens model on views of a board.

    Fields:
        model: which.
        held_out_px: ``(V,)`` root mean square error of each view, with the camera from the other
            views and the view's own pose; infinite where that camera cannot show it, or no camera
            of the model follows from the others.
        calibration: of all views; None where none follows.
        fault: why not.

    >>> import numpy as np
    >>> from motorcade.tracking.cameras.calibrate import LensTrial
    >>> LensTrial("radtan", np.array([0.1, 0.3, 0.2]), None).typical_px
    0.2
    """

    model: CameraModel
    held_out_px: FloatArray
    calibration: Calibration | None
    fault: str = ""

    @property
    def typical_px(self) -> float:
        """Median over views."""
        return float(np.median(self.held_out_px))


def try_lenses(views: Sequence[BoardCorners], size: tuple[int, int]) -> tuple[LensTrial, ...]:
    """Fit every lens model to views of a board, and predict views that were held out.

    Args:
        views: as for `calibrate`; of fewer than four none can be held out, and `held_out_px` is
            infinite.
        size: width and height of the images, pixels.

    Returns:
        a trial of each model, the simplest model first.

    Raises:
        ValueError: a view without four corners that span the board.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera, Checkerboard
    >>> from motorcade.tracking.boards import BoardCorners
    >>> from motorcade.tracking.cameras.calibrate import choose_lens, try_lenses
    >>> wide = Camera(640, 480, 190.0, 190.0, 315.0, 236.0, "equidistant", (0.02, -0.01, 0.0, 0.0))
    >>> board, views = Checkerboard(6, 5, 0.04), []
    >>> tilts = [[0.4, 0, 0], [-0.4, 0, 0], [0, 0.4, 0], [0, -0.4, 0], [0.3, 0.3, 0], [0.3, 0, 1]]
    >>> for tilt in tilts:
    ...     turn = Rotor.from_rotation_vector(tilt) @ Rotor.from_rotation_vector([np.pi, 0, 0])
    ...     camera_T_board = Motor.from_rotor_translation(turn, [-0.1, -0.08, 0.1])
    ...     px = wide.project(camera_T_board.apply(board.points_m))
    ...     views.append(BoardCorners(np.arange(30), px, board.points_m))
    >>> trials = try_lenses(views, (640, 480))
    >>> choose_lens(trials).model
    'equidistant'
    """
    trials = []
    for model in MODELS:
        try:
            whole = calibrate(views, size, model)
        except CalibrationError as fault:
            trials.append(LensTrial(model, np.full(len(views), np.inf), None, str(fault)))
        else:
            trials.append(LensTrial(model, _held_out_px(views, size, model), whole))
    return tuple(trials)


def choose_lens(trials: Sequence[LensTrial]) -> LensTrial:
    """The simplest model that predicts as well as the best; radtan where no view was held out."""
    best = min(trials, key=lambda trial: trial.typical_px)
    if not np.isfinite(best.typical_px):
        return next(trial for trial in trials if trial.model == "radtan")
    return next(trial for trial in trials if _predicts_as(trial, best))


def better_lens(trials: Sequence[LensTrial], stated: LensTrial) -> LensTrial | None:
    """The model that predicts held-out views better than the stated one; None where none does."""
    chosen = choose_lens(trials)
    beaten = np.isfinite(chosen.typical_px) and not _predicts_as(stated, chosen)
    return chosen if beaten else None


def _predicts_as(trial: LensTrial, other: LensTrial) -> bool:
    """Whether it predicts as well as another, or better, within the scatter over views."""
    if not np.isfinite(trial.typical_px):
        return False
    shown = np.isfinite(trial.held_out_px) & np.isfinite(other.held_out_px)
    errors = (np.maximum(each.held_out_px[shown], _ALIKE_PX) for each in (trial, other))
    worse = np.subtract(*map(np.log, errors))
    # The median's standard error, of a normal's scatter by its median deviation.
    scatter = 1.2533 * 1.4826 * float(np.median(np.abs(worse - np.median(worse))))
    limit = max(np.log(_AS_GOOD), _SCATTERS * scatter / np.sqrt(len(worse)))
    return bool(np.median(worse) <= limit)


def _held_out_px(
    views: Sequence[BoardCorners], size: tuple[int, int], model: CameraModel
) -> FloatArray:
    """Error of each view with the camera of the others, in a few parts; each part is spread out."""
    errors = np.full(len(views), np.inf)
    parts = _FOLDS if len(views) >= 2 * LEAST_VIEWS else len(views)
    if len(views) - len(range(0, len(views), parts)) < LEAST_VIEWS:
        return errors
    for part in range(parts):
        kept = [view for index, view in enumerate(views) if index % parts != part]
        try:
            camera = calibrate(kept, size, model).camera
        except CalibrationError:
            continue  # no camera follows: its views stay infinitely far
        errors[part::parts] = [view_error_px(view, camera) for view in views[part::parts]]
    return errors
