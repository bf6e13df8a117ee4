"""The lens models that a clip is tried with, as few numbers, and back to a camera.

Pixels are square and a phone's lens is round, so one focal length, the centre and up to three
radial terms are asked for: more follow the noise where corners do not reach the image's edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras import lenses
from motorcade.tracking.cameras.camera import Camera, CameraModel

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
        if not self.terms:
            return columns
        length = 8 if self.model == "radtan" else 4
        plain = lenses.distort(self.model, np.zeros(length), in_camera)
        for term in range(self.terms):
            unit = np.zeros(length)
            unit[4 if self.model == "radtan" and term == 2 else term] = 1.0
            bent = lenses.distort(self.model, unit, in_camera) - plain
            columns[:, :, _PLAIN + term] = camera.fx * bent
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
