"""Grey levels between pixels, and corners of one image found in the next.

Corners are tracked by pyramidal Lucas-Kanade flow. A corner counts as found if the flow back from
its new place ends where it began. Places that are found are right to some tenths of a pixel. The
compiled flow finds what OpenCV's finds, in half of its time, or in a fifth where pyramids are kept.
It runs on as many threads as `motorcade.ga.kernels.threads` says.

Sources: Lucas & Kanade 1981; Bouguet 2000 (pyramids); Kalal et al. 2010 (forward-backward check).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.ga.kernels import threads
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.native._flow import Pyramid, follow_corners

_NOISE_MASK = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]], np.float32)
_BLOCK_PX, _ROUNDING = 7, 12.0**-0.5
"""Side of the window about a corner whose gradients count; noise of whole grey levels alone."""
_SOBEL_PX2 = 0.66
"""Variance that Sobel's mask adds to a step's."""


def grey_levels(image: GrayImage, px: FloatArray) -> FloatArray:
    """Bilinear grey levels ``(*, n)`` at pixels ``(*, n, 2)``; beyond the edge those of the edge.

    >>> import numpy as np
    >>> from motorcade.tracking.images import grey_levels
    >>> grey_levels(np.array([[0, 100], [0, 100]], np.uint8), np.array([[0.5, 0.0], [9.0, 1.0]]))
    array([ 50., 100.])
    """
    if not px.size:
        return np.zeros(px.shape[:-1])
    grid = px.astype(np.float32).reshape(-1, px.shape[-2], 2)
    levels = cv2.remap(image, grid, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(levels, np.float64).reshape(px.shape[:-1])


def track_corners(
    before: GrayImage | Pyramid,
    after: GrayImage | Pyramid,
    px: FloatArray,
    guess: FloatArray,
    *,
    return_px: float = 0.7,
    border_px: float = 12.0,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Where corners of one image are in another, and which of them were found.

    Motions of up to about 60 px from the guess are found.

    Args:
        before: the image that holds the corners, or its pyramid, for one that is used again.
        after: the image to find them in, likewise.
        px: ``(n, 2)`` in `before`.
        guess: ``(n, 2)`` about where in `after`.
        return_px: how far from its start the flow back may end.
        border_px: nothing is found nearer to the edge of the image.

    >>> import cv2, numpy as np
    >>> from motorcade.tracking.images import track_corners
    >>> noise = np.random.default_rng(0).integers(0, 255, (100, 120)).astype(np.uint8)
    >>> image = cv2.GaussianBlur(noise, (0, 0), 3.0)
    >>> corners = np.array([[40.0, 50.0], [70.0, 60.0]])
    >>> there, found = track_corners(image, np.roll(image, 2, axis=1), corners, corners)
    >>> (there - corners).round(1) + 0.0, found
    (array([[2., 0.],
           [2., 0.]]), array([ True,  True]))
    """
    if not len(px):
        return np.zeros((0, 2)), np.zeros(0, dtype=np.bool_)
    first, other = (of if isinstance(of, Pyramid) else Pyramid(of) for of in (before, after))
    there, tracked = follow_corners(first, other, px, guess, return_px, threads())
    limit = (other.width - 1 - border_px, other.height - 1 - border_px)
    return there, tracked & np.all((there >= border_px) & (there <= limit), axis=-1)


def corner_noise_px(images: Iterable[GrayImage], corners_px: Iterable[FloatArray]) -> float:
    """How far noise lets corners scatter in images, standard deviation of a coordinate, pixels.

    Noise is what Immerkær's mask (1996) leaves of an image; a corner is as sure as the gradients
    about it are steep, along the direction that they tell least (Förstner 1987): blur and want of
    contrast lower them. The median over all corners ``(n, 2)``; 0 without any.

    >>> import numpy as np
    >>> from motorcade.tracking.images import corner_noise_px
    >>> image = np.kron(np.eye(2, dtype=np.uint8) * 200, np.ones((20, 20), np.uint8))
    >>> noisy = image + np.random.default_rng(0).integers(0, 30, (40, 40)).astype(np.uint8)
    >>> 0.01 < corner_noise_px([noisy], [np.array([[19.5, 19.5]])]) < 0.1
    True
    """
    sigmas = [np.zeros(0)]
    for image, px in zip(images, corners_px, strict=True):
        levels = image.astype(np.float32)
        noise = float(np.median(np.abs(cv2.filter2D(levels, -1, _NOISE_MASK)))) / (6.0 * 0.6745)
        steep = cv2.cornerMinEigenVal(levels, _BLOCK_PX, ksize=3) * (0.5 * _BLOCK_PX) ** 2
        squares = np.maximum(grey_levels(steep, px), 1e-9)
        sigmas.append(max(noise, _ROUNDING) / np.sqrt(squares))
    joined = np.concatenate(sigmas)
    return float(np.median(joined)) if len(joined) else 0.0


def blur_bias_px(image: GrayImage, quads: FloatArray, cell_share: float) -> FloatArray:
    """How far blur lets a print's cells draw its corners ``(m, 4, 2)`` aside, deviation ``(m,)``.

    Blur is what the steepest step about a corner is wide beyond a sharp one's. A side leans on what
    is printed a cell further in as far as the two overlap: the law holds to a third for tags drawn
    18 to 70 pixels wide with a blur of 0 to 4. `cell_share` is a cell's width over the side.

    >>> import numpy as np
    >>> from motorcade.tracking.images import blur_bias_px
    >>> image = np.pad(np.zeros((40, 40), np.uint8), 20, constant_values=200)
    >>> quad = np.array([[[19.5, 19.5], [59.5, 19.5], [59.5, 59.5], [19.5, 59.5]]])
    >>> bool(blur_bias_px(image, quad, 0.125)[0] < 0.01)
    True
    """
    side_px = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=-1).mean(axis=1)
    levels = image.astype(np.float32)
    steep = np.hypot(*(cv2.Sobel(levels, -1, *axis, scale=0.125) for axis in ((1, 0), (0, 1))))
    reach = max(3, round(min(2.0 * cell_share, 1.0) * float(np.median(side_px))))
    about = np.ones((2 * reach + 1,) * 2, np.uint8)
    step = cv2.dilate(levels, about) - cv2.erode(levels, about)
    steepest = grey_levels(cv2.dilate(steep, about), quads)
    width_px = np.median(grey_levels(step, quads) / np.maximum(steepest, 1e-3), axis=1)
    blur_px = np.sqrt(np.maximum(width_px**2 / (2.0 * np.pi) - _SOBEL_PX2, 1e-6))
    return np.asarray(blur_px / 3.0 * np.exp(-((cell_share * side_px / blur_px) ** 2) / 12.0))


def print_noise_px(
    images: Sequence[GrayImage], quads: Sequence[FloatArray], cell_share: float
) -> tuple[float, float]:
    """How far corners ``(m, 4, 2)`` of prints can scatter in images, and by blur alone, pixels.

    Joins the medians of `corner_noise_px` and `blur_bias_px`; the cells are a marker's, or squares.

    >>> import cv2, numpy as np
    >>> from motorcade.tracking.images import print_noise_px
    >>> image = np.pad(np.zeros((8, 8), np.uint8), 8, constant_values=200)
    >>> quad = np.array([[[8.0, 8.0], [15.0, 8.0], [15.0, 15.0], [8.0, 15.0]]])
    >>> print_noise_px([cv2.blur(image, (5, 5))], [quad], 0.125)[1] > 0.1
    True
    """
    noise_px = corner_noise_px(images, [px.reshape(-1, 2) for px in quads])
    seen = [pair for pair in zip(images, quads, strict=True) if len(pair[1])]
    blurred = [blur_bias_px(image, px, cell_share) for image, px in seen]
    bias_px = float(np.median(np.concatenate(blurred))) if blurred else 0.0
    return float(np.hypot(noise_px, bias_px)), bias_px


def shrunk(image: GrayImage, longest_px: int) -> GrayImage:
    """A grey image halved until its longer side is at most `longest_px`; itself if it is.

    >>> import numpy as np
    >>> from motorcade.tracking.images import shrunk
    >>> shrunk(np.zeros((480, 640), np.uint8), 320).shape
    (240, 320)
    """
    while max(image.shape) > longest_px:
        height, width = image.shape
        image = np.asarray(
            cv2.resize(image, (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8
        )
    return image
