"""A camera found while it is used: from views of the board so far, better as more come.

Fits run in a thread of their own after 8, 24 and 64 views; meanwhile no view is looked for, since
the two would share one interpreter. A camera is taken once its focal length is known to 5 %, and a
later one where it is known better.
"""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from motorcade.tracking import SelfCalibration, SelfCalibrationError, self_calibrate_board
from motorcade.tracking.boards import BoardCorners

FITTED_AT = (8, 24, 64)
GOOD_SIGMA = 0.05
"""The relative doubt of a focal length with which a camera is taken: depth is as doubtful."""
_APART_NS = 100_000_000
_MOVED = 0.01
"""How far, in image widths, a view's corners are from those of the view before, in the mean."""


class LiveCalibration:
    """Collects views of a board, and finds the camera from them.

    Args:
        size: width and height of the images, pixels.

    It needs what every calibration from a plane needs: views of several tilts. A board that is
    always seen head on gives no focal length, and `status` says so.

    >>> from motorcade.replays.live.calibration import LiveCalibration
    >>> LiveCalibration((640, 480)).status
    'finding the camera: 0 of 8 views; move round the board, and tilt it'
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size
        self.found: SelfCalibration | None = None
        self._views: list[BoardCorners] = []
        self._stamps: list[int] = []
        self._reason = ""
        self._worker = ThreadPoolExecutor(1, "calibration")
        self._fit: Future[SelfCalibration] | None = None

    @property
    def done(self) -> bool:
        """Whether no more views are wanted."""
        return len(self._views) >= FITTED_AT[-1] and self._fit is None

    @property
    def status(self) -> str:
        """What is known of the camera, or what is lacking, for people."""
        if self.found is not None:
            focal, sigma = self.found.camera.fx, self.found.sigma_focal
            doubts = "".join(f"; {doubt}" for doubt in self.found.doubts)
            return f"camera found: focal length {focal:.0f} ± {sigma * focal:.0f} px{doubts}"
        views = len(self._views)
        wanted = next((count for count in FITTED_AT if count > views), FITTED_AT[-1])
        text = f"finding the camera: {views} of {wanted} views; move round the board, and tilt it"
        return f"{text} ({self._reason})" if self._reason else text

    def wants(self, time_ns: int) -> bool:
        """Whether a view at this stamp would be taken."""
        if self.done or self._fit is not None:
            return False
        return not self._stamps or time_ns - self._stamps[-1] >= _APART_NS

    def add(self, time_ns: int, view: BoardCorners) -> None:
        """Take a view, where the board has moved since the one before."""
        if not (self.wants(time_ns) and view.spanning and self._moved(view)):
            return
        self._views.append(view)
        self._stamps.append(time_ns)
        if len(self._views) in FITTED_AT:
            stamps = np.array(self._stamps)
            self._fit = self._worker.submit(
                self_calibrate_board, tuple(self._views), self.size, stamps
            )

    def poll(self) -> SelfCalibration | None:
        """A camera that is new and better than the one before; None without."""
        if self._fit is None or not self._fit.done():
            return None
        fit, self._fit = self._fit, None
        try:
            calibration = fit.result()
        except SelfCalibrationError as fault:
            self._reject(str(fault))
            return None
        if calibration.sigma_focal > GOOD_SIGMA:
            self._reject(f"known to {calibration.sigma_focal:.0%} only")
            return None
        if self.found is not None and calibration.sigma_focal >= self.found.sigma_focal:
            return None
        self.found = calibration
        return calibration

    def _reject(self, reason: str) -> None:
        """Say why there is no camera yet; after the last fit begin with other views."""
        self._reason = reason
        if self.found is None and len(self._views) >= FITTED_AT[-1]:
            self._views, self._stamps = self._views[-1:], self._stamps[-1:]

    def close(self) -> None:
        """Leave what is under way."""
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _moved(self, view: BoardCorners) -> bool:
        if not self._views:
            return True
        before = self._views[-1]
        _, here, there = np.intersect1d(view.ids, before.ids, return_indices=True)
        if len(here) == 0:
            return True
        steps = view.corners_px[here] - before.corners_px[there]
        return float(np.linalg.norm(steps, axis=-1).mean()) > _MOVED * self.size[0]
