"""What other images of a scene show before figures, in the pixels of the footage.

Where the two views taken next to a frame show nothing before them, the frame is not searched.
"""

from __future__ import annotations

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.lens import LensWarp, Window, as_pinhole
from motorcade.render.scene import ImageArray
from motorcade.tracking.depth.sweep import Nearer, SceneViews

# Edges of what is nearer, found in so many pixels of what was compared: in squared grey values of
# 0 to 1; and how fast its share goes from nothing to all.
_EDGE, _EDGE_PX, _SHARP = 1e-3, 3.0, 2.0


class SceneOccluders:
    """What stands before figures by views of the scene.

    Args:
        views: by `LensWarp(camera).pinhole` of the footage's camera.
    """

    def __init__(self, views: SceneViews) -> None:
        self._views = views
        self._hides: dict[int, bool] = {}

    def before(
        self,
        image: ImageArray,
        lens: LensWarp,
        window: Window,
        time_ns: int,
        world_T_camera: Motor,
        hull_m: FloatArray,
        world_T_ground: Motor,
    ) -> tuple[FloatArray, float] | None:
        """The share ``(h, w)`` of each pixel of a window that shows something nearer than a hull.

        Args:
            image: the whole frame, grey or RGB.
            lens: through which it was taken.
            window: rows and columns of it.
            time_ns: when.
            world_T_camera: from where.
            hull_m: ``(c, 3)`` corners about all figures, world.
            world_T_ground: that they stand on, which hides nothing.

        Returns:
            that, and how far away it is; None where nothing is nearer, or the lens has zoomed.
        """
        views = self._views
        if views.camera != lens.pinhole or not self._near_in_time(time_ns, hull_m, world_T_ground):
            return None
        gray = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        small = as_pinhole(gray, lens.camera, views.camera, views.scale_of(views.camera))
        nearer = views.nearer(small, world_T_camera, hull_m, world_T_ground)
        if nearer is None:
            return None
        share = np.zeros(gray[window].shape)
        part, inside = _part_of(nearer, lens, window)
        if share[inside].size:
            share[inside] = _at_full_size(nearer, lens, part, gray[part])
        return share, nearer.depth_m

    def _near_in_time(self, time_ns: int, hull_m: FloatArray, world_T_ground: Motor) -> bool:
        """Whether anything is nearer in the views just before and after."""
        after = int(np.searchsorted(self._views.time_ns, time_ns))
        for k in {max(after - 1, 0), min(after, len(self._views.images) - 1)}:
            if k not in self._hides:
                seen, pose = self._views.images[k], self._views.world_T_camera[k]
                self._hides[k] = self._views.nearer(seen, pose, hull_m, world_T_ground) is not None
            if self._hides[k]:
                return True
        return False


def _part_of(nearer: Nearer, lens: LensWarp, window: Window) -> tuple[Window, Window]:
    """The rows and columns of the footage about what was compared, and these within a window."""
    first = np.array(nearer.first_px)
    last = first + nearer.share.shape[::-1]
    low, high = (np.rint(at / nearer.scale).astype(np.int64) for at in (first, last))
    shown = lens.shown((np.maximum(low, 0), high))
    starts = [max(one.start, other.start) for one, other in zip(shown, window, strict=True)]
    stops = [min(one.stop, other.stop) for one, other in zip(shown, window, strict=True)]
    rows, columns = (slice(a, max(a, b)) for a, b in zip(starts, stops, strict=True))
    top, left = window[0].start, window[1].start
    inside = (
        slice(rows.start - top, rows.stop - top),
        slice(columns.start - left, columns.stop - left),
    )
    return (rows, columns), inside


def _at_full_size(nearer: Nearer, lens: LensWarp, part: Window, gray: ImageArray) -> FloatArray:
    """What was found in small pixels, in those of the footage, its edges where that has them."""
    sources = nearer.scale * (lens.sources(part) + 0.5) - 0.5 - np.array(nearer.first_px)
    share = cv2.remap(
        nearer.share, sources.astype(np.float32), None, cv2.INTER_LINEAR, borderValue=(-1.0,)
    )
    radius = max(2, round(_EDGE_PX / nearer.scale))
    share = cv2.ximgproc.guidedFilter(gray.astype(np.float32) / 255.0, share, radius, _EDGE)
    return np.asarray(np.clip(0.5 + _SHARP * share, 0.0, 1.0), np.float64)
