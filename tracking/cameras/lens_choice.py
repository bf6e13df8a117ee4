"""Which lens model a calibration's views bear: each fitted to a part, judged by the views held out.

A model with terms to spare fits what it saw as well as the right one; it does not predict what it
has not seen. The simplest model wins whose errors on held-out views are no larger than the best
one's, within what they scatter over views.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import (
    LEAST_VIEWS,
    Calibration,
    CalibrationError,
    calibrate,
    view_error_px,
)
from motorcade.tracking.cameras.camera import CameraModel

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
    >>> from motorcade.tracking.cameras.lens_choice import LensTrial
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
        size: width and height of the pictures, pixels.

    Returns:
        a trial of each model, the simplest model first.

    Raises:
        ValueError: a view without four corners that span the board.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera, Checkerboard
    >>> from motorcade.tracking.boards import BoardCorners
    >>> from motorcade.tracking.cameras.lens_choice import choose_lens, try_lenses
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
