"""What moves before a scene, by masks of each image: edges refined, and the image without it.

A mask ``(height, width)`` uint8 says how much of each pixel shows somebody or something that moves:
255 all of it, 0 nothing. Whatever made it, its edge is known to a few pixels; the image knows it
better wherever the two sides differ in colour.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage

COUNTS = 32
"""Of 255: what is masked by less is a mask's noise."""
_BAND = 0.008
"""Half the width of the band about an edge in which the image decides, in image widths."""
_FADE_PX = 6
"""Over so many pixels the image goes over into what fills a mask."""
_SPREAD, _APART = 2.5, 12.0
"""Standard deviations of its texture that a side's colours reach from their mean, and how far apart
(of 255) both sides' must then still lie for a pixel to tell which it is.
"""


def fill_masked(image: NDArray[np.uint8], mask: GrayImage) -> NDArray[np.uint8]:
    """An image ``(h, w)`` or ``(h, w, 3)`` whose masked parts are filled smoothly from around.

    What fills them has no corners and no edges, and moves with nothing. It is a guess of the mean
    colour there, made from coarser and coarser images of what is seen (Gortler et al. 1996,
    "pull-push"), and meant for what looks for corners, motion or light, not for people.

    >>> import numpy as np
    >>> from motorcade.tracking.masks import fill_masked
    >>> image, mask = np.full((40, 40), 90, np.uint8), np.zeros((40, 40), np.uint8)
    >>> image[10:20, 10:20], mask[10:20, 10:20] = 255, 255
    >>> int(fill_masked(image, mask)[15, 15])
    90
    """
    hidden = (mask >= COUNTS).astype(np.uint8)
    if not hidden.any():
        return image
    hidden = cv2.dilate(hidden, np.ones((5, 5), np.uint8))
    away_px = cv2.distanceTransform(1 - hidden, cv2.DIST_L2, 3)
    kept = np.minimum(away_px / _FADE_PX, 1.0)
    if image.ndim == 3:
        kept = kept[..., None]
    filled = _pulled(image.astype(np.float32), 1.0 - hidden.astype(np.float32))
    return np.asarray(np.rint(kept * image + (1.0 - kept) * filled), np.uint8)


def _pulled(image: NDArray[np.float32], known: NDArray[np.float32]) -> NDArray[np.float32]:
    """An image with all that is not known (0 of 0 to 1) taken from an image of half its size."""
    height, width = known.shape
    if min(height, width) < 4 or known.min() > 0.0:
        return image
    spread = known if image.ndim == 2 else known[..., None]
    coarse = cv2.pyrDown(known)
    weight = np.maximum(coarse, 0.05).reshape(*coarse.shape, *(1,) * (image.ndim - 2))
    below = _pulled(cv2.pyrDown(image * spread) / weight, (coarse > 0.05).astype(np.float32))
    return np.where(spread > 0.0, image, cv2.pyrUp(below, dstsize=(width, height)))


def refine_mask(mask: GrayImage, image: NDArray[np.uint8]) -> GrayImage:
    """A mask whose edge lies where the image's colours change.

    In a band of about 1 % of the image's width on both sides of the given edge each pixel is put
    between the mean colour of what is surely masked and of what surely is not, both taken from
    close by, and is wholly a side's that it differs from by no more than its texture does; where
    textures meet, the given mask stays.

    Args:
        mask: ``(h, w)`` uint8, 0 to 255.
        image: ``(h, w)`` or ``(h, w, 3)`` uint8.
    """
    inside = (mask >= 128).astype(np.uint8)
    rows, columns = (np.flatnonzero(inside.any(axis=axis)) for axis in (1, 0))
    if not len(rows) or inside.all():
        return mask
    band = max(2, round(_BAND * mask.shape[1]))
    part = tuple(slice(max(at[0] - 4 * band, 0), at[-1] + 4 * band + 1) for at in (rows, columns))
    inside, stated = inside[part], mask[part].astype(np.float32) / 255.0
    shown = image[part].astype(np.float32).reshape(*inside.shape, -1)
    depth_px = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
    away_px = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)
    (own, own_var, own_far), (other, other_var, other_far) = (
        _around(shown, (distance > band).astype(np.float32), float(band))
        for distance in (depth_px, away_px)
    )
    between = own - other
    length = np.maximum(np.sqrt(np.sum(between**2, axis=2)), 1.0)
    along = np.sum((shown - other) * between, axis=2) / length
    # What is as far from a side's mean as its texture is that side's.
    low, high = _SPREAD * np.sqrt(other_var), length - _SPREAD * np.sqrt(own_var)
    decided = (depth_px + away_px <= band + 1.0) & (high - low > _APART) & own_far & other_far
    share = np.clip((along - low) / np.maximum(high - low, 1.0), 0.0, 1.0)
    refined = mask.copy()
    refined[part] = np.rint(255.0 * np.where(decided, share, stated))
    return refined


def _around(
    shown: NDArray[np.float32], sure: NDArray[np.float32], sigma_px: float
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Mean ``(h, w, c)`` and variance ``(h, w)`` of sure pixels close by; where there are any."""

    def spread(values: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(cv2.GaussianBlur(values, (0, 0), sigma_px), np.float32)

    weight = spread(sure)
    enough = np.maximum(weight, 1e-3)
    mean = spread(shown * sure[..., None]).reshape(shown.shape) / enough[..., None]
    square = spread(np.sum(shown**2, axis=2) * sure) / enough
    variance = np.maximum(square - np.sum(mean**2, axis=2), 0.0)
    return mean.astype(np.float32), variance.astype(np.float32), weight > 1e-2


def standing_depth(
    mask: GrayImage, camera: Camera, camera_T_ground: Motor, depth_m: NDArray[np.float32] | None
) -> NDArray[np.float32]:
    """How far off each masked thing is, metres (h, w) along the axis; 0 before all else.

    A thing that hangs together has one depth: the middle of what is measured, else of where it
    stands, the nearest at which a ray through its outline meets the ground. What reaches the
    image's left, right or lower edge may stand anywhere, and is before all else. Somebody who
    jumps, or a hand over a table, seems farther.
    """
    away_m = np.full(mask.shape, np.inf, np.float32)
    normal, origin_m = camera_T_ground.rotor.apply([0.0, 0.0, 1.0]), camera_T_ground.translation_m
    inside = (mask >= COUNTS).astype(np.uint8)
    for outline in cv2.findContours(inside, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]:
        x, y, width, height = cv2.boundingRect(outline)
        own_m = np.zeros(0)
        if depth_m is not None:
            within = inside & cv2.drawContours(np.zeros_like(inside), [outline], 0, 1, cv2.FILLED)
            own_m = np.median(depth_m[(within > 0) & (depth_m > 0.0)], keepdims=True)
        elif x > 1 and x + width < mask.shape[1] - 1 and y + height < mask.shape[0] - 1:
            towards = camera.bearings(outline[:, 0].astype(np.float64))
            with np.errstate(divide="ignore"):
                own_m = towards[:, 2] * (normal @ origin_m) / (towards @ normal)
        ahead_m = own_m[own_m > 0.0]
        nearest_m = float(ahead_m.min()) if len(ahead_m) else 0.0
        for how in (cv2.FILLED, 5):  # and its soft rim
            cv2.drawContours(away_m, [outline], 0, nearest_m, how)
    return away_m
