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
_KEPT_PX, _BETTER, _LEAST, _SOFT_PX, _COARSE = 1.5, 1.2, 2.0, 0.6, 1.5
"""How far the image must move an edge to be followed, how many times as much, and how much more of
255 a pixel, it must change along the new one; how soft the edge then is; and over how many times
the pixels of its edge's rims a coarse mask is soft."""


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

    In a band of about 1 % of the image's width on both sides of the given edge each pixel goes to
    the side whose colours it has, with as short an edge as its neighbours' differences allow
    (Rother et al. 2004, "GrabCut"). The given edge stays, whose pixels may be masked in part, where
    that moves it by less than `_KEPT_PX`, or the image changes hardly more along the new one.

    Args:
        mask: ``(h, w)`` uint8, 0 to 255.
        image: ``(h, w)`` or ``(h, w, 3)`` uint8.
    """
    inside = (mask >= 128).astype(np.uint8)
    rows, columns = (np.flatnonzero(inside.any(axis=axis)) for axis in (1, 0))
    band = max(2, round(_BAND * mask.shape[1]))
    if not len(rows) or inside.all():
        return mask
    part = tuple(slice(max(at[0] - 4 * band, 0), at[-1] + 4 * band + 1) for at in (rows, columns))
    inside, shown = inside[part], image[part]
    depth_px, away_px = (
        cv2.distanceTransform(side, cv2.DIST_L2, 5) for side in (inside, 1 - inside)
    )
    if depth_px.max() <= band or away_px.max() <= band:
        return mask  # nothing is surely one side's
    labels = np.where(inside > 0, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[depth_px > band], labels[away_px > band] = cv2.GC_FGD, cv2.GC_BGD
    colors = cv2.cvtColor(shown, cv2.COLOR_GRAY2RGB) if shown.ndim == 2 else shown.copy()
    cv2.setRNGSeed(0)  # its colour models start from drawn pixels
    cv2.grabCut(
        colors, labels, None, np.zeros((1, 65)), np.zeros((1, 65)), 1, cv2.GC_INIT_WITH_MASK
    )
    own = (labels & 1).astype(np.uint8)
    soft = cv2.GaussianBlur(shown.astype(np.float32), (0, 0), 1.0).reshape(*inside.shape, -1)
    change = np.sqrt(sum(np.sum(part**2, axis=2) for part in np.gradient(soft, axis=(0, 1))))
    along_new, along_given = (_along_edge(change, side, float(band)) for side in (own, inside))
    # A mask of fewer pixels than the image has a wide edge, and knows it no better than that.
    soft_px = np.count_nonzero(np.abs(mask[part] - 127.5) < 127.5 - COUNTS)
    coarse = soft_px > _COARSE * np.count_nonzero(_edge(inside))
    better = along_new > (1.0 if coarse else _BETTER) * along_given + _LEAST
    moved = (own != inside) & better & ((depth_px + away_px > _KEPT_PX) | coarse)
    moved = cv2.dilate(moved.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    hard = cv2.GaussianBlur(255 * np.where(moved, own, inside), (0, 0), _SOFT_PX)
    refined = mask.copy()
    refined[part] = np.where(moved | coarse, hard, mask[part])
    return refined


def _along_edge(
    values: NDArray[np.float32], side: GrayImage, sigma_px: float
) -> NDArray[np.float32]:
    """Mean ``(h, w)`` of values on the edge of a side, close by."""
    edge = _edge(side).astype(np.float32)
    total, count = (cv2.GaussianBlur(one, (0, 0), sigma_px) for one in (values * edge, edge))
    return np.asarray(total / np.maximum(count, 1e-3), np.float32)


def _edge(side: GrayImage) -> GrayImage:
    """The pixels on both sides of an edge, 1 of 0 and 1."""
    return np.asarray(cv2.morphologyEx(side, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)))


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
