"""What self-calibration gives, and why it may give nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from motorcade.tracking.cameras.camera import Camera, Zoom

Basis = Literal["board", "tags", "motion"]
ReadoutAxis = Literal["down", "up", "right", "left"]


class SelfCalibrationError(ValueError):
    """A clip from which no camera follows; the message says what it lacks.

    >>> from motorcade.tracking import SelfCalibrationError, self_calibrate_board
    >>> try:
    ...     self_calibrate_board([None, None], (1920, 1080), [0, 33_000_000])
    ... except SelfCalibrationError as error:
    ...     print(error)
    views: expected at least 5 frames that show the board, got 0 of 2
    """


class OnlyTurnsError(SelfCalibrationError):
    """A clip in which the camera changes its direction and not its place.

    Attributes:
        focal: the focal length, in longer sides of the image, that explains most of it.
    """

    def __init__(self, message: str, focal: float) -> None:
        super().__init__(message)
        self.focal = focal


@dataclass(frozen=True)
class ShutterReadout:
    """How a rolling shutter reads an image.

    Fields:
        seconds: from the first line to the last.
        sigma_s: standard deviation of it.
        axis: which way the lines follow one another in the image as it is seen: of a phone held
            upright the sensor's rows are the image's columns.

    >>> from motorcade.tracking.self_calibration.result import ShutterReadout
    >>> ShutterReadout(0.021, 0.0004, "down").seconds
    0.021
    """

    seconds: float
    sigma_s: float
    axis: ReadoutAxis


@dataclass(frozen=True, eq=False)
class SelfCalibration:
    """A camera found in a clip, and what speaks for and against it.

    Fields:
        camera: of the clip's upright images; square pixels.
        basis: what it was found from.
        sigma_focal: relative standard deviation of the focal length, the larger of what the
            residuals say and of half the difference between two halves of the clip.
        reason: why this lens model, one line.
        rms_px: root mean square reprojection error of what was fitted.
        views: frames that were fitted.
        readout: of the rolling shutter; None where the clip does not tell it.
        breathing: relative change of the focal length over the clip (largest less smallest), where
            it is more than its noise, else 0.
        doubts: sentences for people: what may be wrong with the camera.
        zoom: where the lens zooms, its focal length at each moment over the camera's, which is the
            shortest.

    Raises:
        ValueError: a sigma or an error that is not a finite number of zero or more.

    >>> from motorcade.tracking import Camera, SelfCalibration
    >>> camera = Camera(1920, 1080, 1500.0, 1500.0, 959.5, 539.5)
    >>> found = SelfCalibration(camera, "tags", 0.002, "pinhole: no lens fits better", 0.2, 90)
    >>> round(found.sigma_focal * found.camera.fx, 3)  # pixels
    3.0
    """

    camera: Camera
    basis: Basis
    sigma_focal: float
    reason: str
    rms_px: float
    views: int
    readout: ShutterReadout | None = None
    breathing: float = 0.0
    doubts: tuple[str, ...] = ()
    zoom: Zoom | None = None

    def __post_init__(self) -> None:
        for name in ("sigma_focal", "rms_px"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"SelfCalibration.{name}: expected 0 or more, got {value}")

    @property
    def readout_s(self) -> float | None:
        """Seconds from the first line of an image to the last; None where it is not known."""
        return None if self.readout is None else self.readout.seconds
