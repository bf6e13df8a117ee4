"""The lens models that a clip is tried with, a first focal length, and what cameras usually have.

Pixels are square and a phone's lens is round, so one focal length, the centre and up to three
radial terms are asked for: more follow the noise where corners do not reach the image's edges.

The prior is log-normal: a focal length that was measured badly is drawn towards it, and one that
was measured well is not.

Each plane's homography says how it lies for any focal length that is tried; a wrong one leaves
directions that are not perpendicular or not of one length (Zhang 2000, section 3.1), so corners are
reprojected elsewhere. Planes seen head on say nothing: there usual cameras decide.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras import lenses
from motorcade.tracking.cameras.camera import Camera, CameraModel
from motorcade.tracking.self_calibration.result import SelfCalibrationError

CENTRE_SHARE = 0.02
"""Standard deviation, in long sides, of a lens's centre about the image's before it is measured:
images are cut from the middle of the sensor, to a per cent or two."""
USUAL_FOCAL, FOCAL_SPREAD = 0.8, 0.35
"""Focal lengths of cameras, in long sides: log-normal about a phone's, so wide that action cameras
and short telephotos are two of its standard deviations off. It speaks where corners hardly do."""
_TERM = 1.0
_PLAIN = 3  # focal length and centre stand before the lens's terms


@dataclass(frozen=True)
class LensKind:
    """A lens model with `terms` free radial terms, the others zero."""

    name: str
    model: CameraModel
    terms: int

    def camera(self, numbers: FloatArray, size: tuple[int, int]) -> Camera:
        """The camera of numbers ``(3 + terms,)`` or more: focal length, centre, terms (pixels)."""
        focal, cx, cy, *terms = numbers[: _PLAIN + self.terms].tolist()
        return Camera(*size, focal, focal, cx, cy, self.model, self._distortion(terms))

    def _distortion(self, terms: list[float]) -> tuple[float, ...]:
        if self.model == "pinhole":
            return ()
        if self.model == "equidistant":
            return tuple(terms) + (0.0,) * (4 - len(terms))
        first = [*terms, 0.0, 0.0][:2]
        return tuple(first) if self.terms <= 2 else (*first, 0.0, 0.0, terms[2])

    def start(self, like: FloatArray, terms_like: int) -> FloatArray:
        """Numbers to start from, given those of another kind with `terms_like` terms."""
        numbers = np.zeros(_PLAIN + self.terms)
        kept = _PLAIN + min(self.terms, terms_like)
        numbers[:kept] = like[:kept]
        return numbers

    def prior(self, numbers: FloatArray, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """How far numbers are from what is expected of them, and the information of that.

        The logarithm of the focal length is expected to be a usual camera's, the centre to be the
        image's, the terms to be small.
        """
        width, height = size
        away = numbers.astype(np.float64)
        away[0] *= np.log(numbers[0] / (USUAL_FOCAL * max(size)))
        away[1:3] -= 0.5 * (width - 1), 0.5 * (height - 1)
        information = np.full(len(away), _TERM**-2)
        information[0] = (FOCAL_SPREAD * numbers[0]) ** -2.0
        information[1:3] = (CENTRE_SHARE * max(size)) ** -2.0
        return away, information

    def bend(self, numbers: FloatArray, size: tuple[int, int]) -> FloatArray:
        """Derivative ``(3 + terms,)`` by the numbers of how far, as a share of its distance from
        the middle, the terms move the image's corner.
        """
        corner = 0.5 * float(np.hypot(*size)) / numbers[0]
        return np.append(np.zeros(_PLAIN), corner ** (2.0 * np.arange(1, self.terms + 1)))

    def by_numbers(self, camera: Camera, in_camera: FloatArray, px: FloatArray) -> FloatArray:
        """Derivative ``(n, 2, 3 + terms)`` of pixels by the numbers, in which models are linear.

        Args:
            camera: of which numbers.
            in_camera: ``(n, 3)`` points.
            px: ``(n, 2)`` where they are seen.
        """
        columns = np.zeros((len(px), 2, _PLAIN + self.terms))
        columns[:, :, 0] = (px - (camera.cx, camera.cy)) / camera.fx
        columns[:, 0, 1] = columns[:, 1, 2] = 1.0
        if self.terms:
            which = (0, 1, 4 if self.model == "radtan" else 2, 3)[: self.terms]
            by_terms = lenses.by_coefficients(self.model, in_camera, which)
            columns[:, :, _PLAIN:] = camera.fx * by_terms
        return columns


PINHOLE = LensKind("pinhole", "pinhole", 0)
KINDS = (
    PINHOLE,
    LensKind("radtan with k1", "radtan", 1),
    LensKind("radtan with k1 k2", "radtan", 2),
    LensKind("equidistant with k1 k2", "equidistant", 2),
    LensKind("radtan with k1 k2 k3", "radtan", 3),
)
"""From the simplest on."""


def start_numbers(focal: float, size: tuple[int, int]) -> FloatArray:
    """Numbers ``(3,)`` of a pinhole with its centre in the middle of the image."""
    return np.array([focal, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)])


def with_prior(focal: float, sigma: float) -> tuple[float, float]:
    """A focal length in longer sides and its relative standard deviation, with what is usual.

    >>> with_prior(2.0, float("inf"))
    (0.8, 0.35)
    >>> [round(number, 3) for number in with_prior(1.0, 0.05)]
    [0.996, 0.049]
    """
    own, usual = 1.0 / sigma**2 if sigma > 0.0 else math.inf, 1.0 / FOCAL_SPREAD**2
    if math.isinf(own):
        return focal, sigma
    if math.isnan(own):
        return USUAL_FOCAL, FOCAL_SPREAD
    mean = (own * math.log(max(focal, 1e-3)) + usual * math.log(USUAL_FOCAL)) / (own + usual)
    return math.exp(mean), (own + usual) ** -0.5


def view_deg(focal: float) -> float:
    """Angle that is seen along the longer side.

    >>> round(view_deg(USUAL_FOCAL))
    64
    """
    return math.degrees(2.0 * math.atan(0.5 / focal))


def doubt_of(focal: float, sigma: float) -> str:
    """The range of a view that is hardly known, in words.

    >>> print(doubt_of(0.8, 0.35))
    how wide it sees is hardly known: 64 degrees, likely 48 to 83
    """
    wide, narrow = view_deg(focal * math.exp(-sigma)), view_deg(focal * math.exp(sigma))
    return (
        f"how wide it sees is hardly known: {view_deg(focal):.0f} degrees, likely {narrow:.0f} to "
        f"{wide:.0f}"
    )


LEAST_FOCAL, MOST_FOCAL = 0.2, 5.0
"""In long sides of the image; a lens of 120 degrees across has 0.29, one of 12 degrees 4.8."""
_TRIED = 41
_INDEPENDENT = 8.0  # planes; their neighbours err alike
_FAR = 5.0  # times the noise of planes: beyond it an error is as bad as any


def focal_from_planes(
    planes: Iterable[tuple[FloatArray, FloatArray]], size: tuple[int, int]
) -> float:
    """Focal length in pixels that images of planes agree on, the centre being in the middle.

    Right to some per cent where planes are seen at a slant; a camera's usual one where none is.

    Args:
        planes: points ``(n, 2 or 3)`` of a plane and their pixels ``(n, 2)``; n at least 4.
        size: width and height of the images.

    Raises:
        SelfCalibrationError: pixels that are no image of a plane.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.self_calibration.lens import focal_from_planes
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    >>> slanted = Motor.from_euler_translation([2.5, 0.3, 0.0], [0.0, 0.0, 4.0]).apply(square)
    >>> 490.0 < focal_from_planes([(square, camera.project(slanted))], (640, 480)) < 510.0
    True
    """
    long = float(max(size))
    middle = 0.5 * (np.array(size) - 1.0)
    focal = np.geomspace(LEAST_FOCAL, MOST_FOCAL, _TRIED)
    errors = []
    for points, px in planes:
        flat = np.ascontiguousarray(points[:, :2] - points[:, :2].mean(axis=0))
        seen = np.ascontiguousarray((px - middle) / long)
        homography, _ = cv2.findHomography(flat, seen)
        if homography is not None:
            errors.append(_reprojected(flat, seen, homography, focal))
    if not errors:
        raise SelfCalibrationError("expected a board or tag, got corners that no flat one shows")
    noise = max(float(np.median(np.min(errors, axis=1))), 0.05 / long)
    each = np.minimum(np.array(errors) / noise, _FAR) ** 2
    usual = (np.log(focal / USUAL_FOCAL) / FOCAL_SPREAD) ** 2
    cost = _INDEPENDENT * each.mean(axis=0) + usual
    best = int(np.clip(np.argmin(cost), 1, _TRIED - 2))
    before, at, after = cost[best - 1 : best + 2]
    aside = 0.5 * (before - after) / max(before - 2.0 * at + after, 1e-12)
    step = np.log(focal[1] / focal[0])
    return float(long * focal[best] * np.exp(step * np.clip(aside, -1.0, 1.0)))


def _reprojected(
    flat: FloatArray, seen: FloatArray, homography: FloatArray, focal: FloatArray
) -> FloatArray:
    """Root mean square error ``(F,)`` of a plane's corners, long sides, for each focal length."""
    columns = homography[None] / np.stack([focal, focal, np.ones_like(focal)], axis=-1)[..., None]
    columns = columns * np.sign(homography[2, 2])
    left, scale, right = np.linalg.svd(columns[..., :2], full_matrices=False)
    place = columns[..., 2] / scale.mean(axis=-1)[:, None]
    points = np.einsum("nk,fjk->fnj", flat, left @ right) + place[:, None]
    px = focal[:, None, None] * points[..., :2] / np.maximum(points[..., 2:], 1e-9)
    return np.asarray(np.sqrt(((px - seen) ** 2).sum(axis=-1).mean(axis=-1)), np.float64)
