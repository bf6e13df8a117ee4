"""What a film shows of its figures, frame by frame: pixels seen, what is hidden, how large.

It is counted on the layers that are laid over the footage, after what hides them. Of several
figures each pixel belongs to the nearest whose projected vertices lie around it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.lens import LensWarp, Window
from motorcade.render.scene import Layer

# So many vertices of a figure tell how large it is.
VERTICES = 2000


@dataclass(frozen=True)
class FigureSeen:
    """A figure in a frame.

    Fields:
        drawn_px: its pixels in the image, were nothing before it; parts of pixels at its edges.
        visible_px: those that are seen.
        inside: the share of its vertices that lies within the image.
        height_px: from its lowest to its highest vertex in the image; 0 out of view.
        bottom: how high its lowest point lies over its ground, in its heights.
    """

    drawn_px: float
    visible_px: float
    inside: float
    height_px: float
    bottom: float

    @property
    def hidden(self) -> float:
        """The share of its pixels in the image that something hides."""
        return 1.0 - self.visible_px / self.drawn_px if self.drawn_px > 0.0 else 0.0


def figures_seen(
    lens: LensWarp,
    window: Window,
    layer: Layer,
    visible: FloatArray | None,
    own_m: list[FloatArray],
    camera_T_ground: list[Motor],
    heights_m: list[float],
) -> tuple[FigureSeen, ...]:
    """Count what a layer shows of each figure.

    Args:
        lens: of the footage.
        window: the part of the image that the layer fills.
        layer: (h, w) of all figures.
        visible: (h, w) share of the layer that nothing hides; None for all of it.
        own_m: (V, 3) of each figure its vertices in metres, in the frame of its ground.
        camera_T_ground: of each.
        heights_m: of each.
    """
    alpha = layer.rgba[..., 3] / 255.0
    seen = alpha if visible is None else alpha * visible
    camera = lens.camera
    pixels, depths = [], []
    for vertices, pose in zip(own_m, camera_T_ground, strict=True):
        at = pose.apply(vertices[:: 1 + len(vertices) // VERTICES])
        px = camera.project(np.where(at[:, 2:] > 0.0, at, np.nan), allow_nan=True)
        with np.errstate(invalid="ignore"):
            inside = np.all((px > -0.5) & (px < [camera.width - 0.5, camera.height - 0.5]), axis=1)
        pixels.append((px, inside))
        depths.append(float(np.median(at[:, 2])))
    alone = len(own_m) == 1
    masks = [alpha] if alone else [_mask(px[inside], alpha.shape, window) for px, inside in pixels]
    order = np.argsort(depths)
    # A pixel is the nearest one's of those that lie around it, else of the next to it.
    apart = [
        cv2.distanceTransform((masks[k] == 0.0).astype(np.uint8), cv2.DIST_L2, 3) for k in order
    ]
    whose = order[np.argmin(apart, axis=0)]
    counted = [
        (
            float(alpha[whose == k].sum() + mask[(whose != k) & (alpha > 0.0)].sum()),
            float(seen[whose == k].sum()),
        )
        for k, mask in enumerate(masks)
    ]
    return tuple(
        FigureSeen(
            *counted[k],
            float(np.mean(inside)),
            float(np.ptp(px[inside, 1])) if np.any(inside) else 0.0,
            float(own_m[k][:, 2].min()) / heights_m[k],
        )
        for k, (px, inside) in enumerate(pixels)
    )


def _mask(px: FloatArray, shape: tuple[int, ...], window: Window) -> NDArray[np.float64]:
    """Where a figure is in a window (h, w): around its projected vertices (n, 2)."""
    mask = np.zeros(shape, np.uint8)
    if not len(px):
        return mask.astype(np.float64)
    start = np.array([window[1].start or 0, window[0].start or 0])
    column, row = (np.rint(px) - start).astype(np.int64).T
    within = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    mask[row[within], column[within]] = 1
    box = np.maximum(np.ptp(px, axis=0), 1.0)
    apart = int(2.0 * np.sqrt(box[0] * box[1] / len(px))) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (apart + 2, apart + 2))
    return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, kernel), dtype=np.float64)
