"""The unit of a structured-light sensor's depth, from the steps that it is measured in.

Such a sensor measures disparities in eighths of a pixel, so that the inverse depths it can give lie
apart by one step, ``1 / (8 f b)`` for focal length f and baseline b. The step shows in the values
that occur in a picture, and tells a wrong unit or scale of the depth.

Source: Khoshelham & Elberink 2012 (the first Kinect).
"""

from __future__ import annotations

import numpy as np

from motorcade.tracking.depth.cameras import DepthImage

_NEAREST_M, _FARTHEST_M = 0.3, 12.0
_FEWEST = 40
_REGULAR, _SHARE = 0.2, 0.6
_COARSE = 4.0
"""Steps have to be so many times as wide as the file's own unit, else rounding hides them."""


def inverse_depth_step(depth_m: DepthImage, unit_m: float) -> float | None:
    """The step between inverse depths, 1/m; None where the values do not stand on such a lattice.

    Args:
        depth_m: as stored, not resampled, NaN where unknown.
        unit_m: the smallest difference that the file can hold.

    >>> import numpy as np
    >>> from motorcade.tracking.depth.lattice import inverse_depth_step
    >>> disparities = np.arange(120, 400)
    >>> depth_m = np.round(1.0 / (0.0029 * disparities), 3).astype(np.float32)
    >>> round(inverse_depth_step(depth_m[None], 0.001), 4)
    0.0029
    """
    values = np.unique(depth_m[np.isfinite(depth_m)]).astype(np.float64)
    values = values[(values > _NEAREST_M) & (values < _FARTHEST_M)]
    apart, middle = np.diff(values), 0.5 * (values[1:] + values[:-1])
    wide = apart > _COARSE * unit_m
    if np.count_nonzero(wide) < _FEWEST:
        return None
    steps = (apart / middle**2)[wide]
    step = float(np.median(steps))
    regular = np.abs(steps - step) < _REGULAR * step
    if np.mean(regular) < _SHARE:
        return None
    return float(np.mean(steps[regular]))
