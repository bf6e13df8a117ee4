"""Images of several runs side by side, with their errors drawn below as they arise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.style import COLOURS, INK
from motorcade.render.scene import ImageArray

__all__ = ["ErrorTraces", "beside"]

PAPER, DARK, RULE = (250, 250, 250), (34, 34, 34), (215, 215, 215)
LEFT_PX, MARGIN_PX = 64, 12


def beside(images: Mapping[str, ImageArray], strip: ImageArray | None = None) -> ImageArray:
    """Images in one row, each with its name, and a strip below.

    Args:
        images: uint8 (h, w, 3) of one size, by name in plain ASCII.
        strip: (s, W, 3) as wide as the row, such as `ErrorTraces.strip` draws.

    Returns:
        (h + s, W, 3) uint8, W the sum of widths.

    Raises:
        ValueError: no images, sizes that differ, or a strip of another width.
    """
    shapes = {image.shape for image in images.values()}
    if len(shapes) != 1:
        raise ValueError(f"beside(images): expected one or more of one size, got {shapes}")
    row = np.concatenate([_named(one, name) for name, one in images.items()], axis=1)
    if strip is None:
        return row
    if strip.shape[1:] != row.shape[1:]:
        raise ValueError(
            f"beside(strip): expected {row.shape[1]} pixels across, got {strip.shape[1]}"
        )
    return np.concatenate([row, strip], axis=0)


class ErrorTraces:
    """Errors over time, drawn up to now.

    Args:
        time_s: (N,) increasing.
        errors: a name of `plots.style.COLOURS` to (N,) values.
        unit: for the axis, in plain ASCII.
        size: width and height of the strip, pixels; 200 by 60 or more.
        highest: upper end of the axis; by default the largest value. What is above is cut off.

    Raises:
        ValueError: shapes that differ, values that are not finite, or a strip too small.
    """

    def __init__(
        self,
        time_s: FloatArray,
        errors: Mapping[str, FloatArray],
        unit: str,
        size: tuple[int, int],
        highest: float | None = None,
    ) -> None:
        if size[0] < 200 or size[1] < 60:
            raise ValueError(f"ErrorTraces(size): expected 200 x 60 or more, got {size}")
        for name, values in errors.items():
            if values.shape != time_s.shape or not np.all(np.isfinite(values)):
                raise ValueError(
                    f"ErrorTraces(errors): expected {time_s.shape} finite values, got "
                    f"{values.shape} for {name!r}"
                )
        self._time_s, self._errors, self._size = time_s, dict(errors), size
        top = max((float(values.max()) for values in errors.values()), default=1.0)
        self._top = max(highest or top, 1e-9)
        self._ground = self._axes(unit)

    def strip(self, now_s: float) -> ImageArray:
        """The traces up to a time, (height, width, 3) uint8, with the values they have then."""
        image = self._ground.copy()
        passed = self._time_s <= now_s
        if not passed.any():
            return image
        for k, (name, values) in enumerate(self._errors.items()):
            points = self._place(self._time_s[passed], values[passed])
            color = _color(name)
            cv2.polylines(image, [points], False, color, 2, cv2.LINE_AA, shift=4)
            text = f"{name} {values[passed][-1]:.2f}"
            _write(image, text, (LEFT_PX + 8 + 190 * k, MARGIN_PX + 8), color)
        return image

    def _place(self, time_s: FloatArray, values: FloatArray) -> FloatArray:
        """Sixteenths of pixels, as OpenCV draws them."""
        width, height = self._size
        first, last = self._time_s[0], self._time_s[-1]
        x = LEFT_PX + (width - LEFT_PX - MARGIN_PX) * (time_s - first) / max(last - first, 1e-9)
        share = np.clip(values / self._top, 0.0, 1.0)
        y = height - MARGIN_PX - (height - 2 * MARGIN_PX - 14) * share
        placed: FloatArray = np.rint(16.0 * np.stack([x, y], axis=1)).astype(np.int32)
        return placed

    def _axes(self, unit: str) -> ImageArray:
        width, height = self._size
        ground = np.full((height, width, 3), PAPER, dtype=np.uint8)
        ends = self._time_s[[0, -1]]
        for level in (0.0, 0.5, 1.0):
            line = self._place(ends, np.full(2, level * self._top))
            cv2.polylines(ground, [line], False, RULE, 1, cv2.LINE_AA, shift=4)
            _write(ground, f"{level * self._top:.3g}", (6, int(line[0, 1] / 16) + 4), DARK)
        _write(ground, unit, (6, MARGIN_PX), DARK)
        return ground


def _named(image: ImageArray, name: str) -> ImageArray:
    """An image with its name in a bar of its colour on top."""
    shown = image.copy()
    height = min(22, image.shape[0])
    shown[:height] = _color(name)
    _write(shown, name, (8, min(16, height)), (255, 255, 255))
    return shown


def _color(name: str) -> tuple[int, int, int]:
    code = COLOURS.get(name, INK)
    if code == INK:
        return DARK
    return int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16)


def _write(image: ImageArray, text: str, at: Sequence[int], color: Sequence[int]) -> None:
    cv2.putText(
        image, text, tuple(at), cv2.FONT_HERSHEY_SIMPLEX, 0.42, tuple(color), 1, cv2.LINE_AA
    )
