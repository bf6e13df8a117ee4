"""Pictures of a video on one sheet, and as numbered files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np

from motorcade.render.scene import ImageArray

__all__ = ["contact_sheet", "write_pictures"]

GAP_PX, PAPER = 6, 250


def contact_sheet(
    frames: Iterable[ImageArray], columns: int, width: int, labels: Sequence[str] = ()
) -> ImageArray:
    """Frames side by side, row by row, each made smaller and labelled in its corner.

    Args:
        frames: uint8 (h, w, 3) of one size, 1 or more.
        columns: a row holds, 1 or more.
        width: of each picture on the sheet, pixels.
        labels: one a frame, or none; in plain ASCII.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ValueError: no frames, sizes that differ, labels that do not fit, or a count below 1.

    >>> import numpy as np
    >>> from motorcade.render.video import contact_sheet
    >>> contact_sheet(np.zeros((3, 48, 64, 3), np.uint8), columns=2, width=32).shape
    (66, 82, 3)
    """
    given = list(frames)
    if not given or any(one.shape != given[0].shape for one in given) or 0 in given[0].shape:
        shapes = sorted({one.shape for one in given})
        raise ValueError(f"contact_sheet(frames): expected frames of one size, got {shapes}")
    if columns < 1 or width < 1 or (labels and len(labels) != len(given)):
        raise ValueError(
            f"contact_sheet: expected columns and a width above 0 and a label a frame, got "
            f"{columns}, {width} and {len(labels)} labels for {len(given)} frames"
        )
    height = max(1, round(given[0].shape[0] * width / given[0].shape[1]))
    rows = -(-len(given) // columns)
    step = height + GAP_PX, width + GAP_PX
    across = min(columns, len(given))
    sheet = np.full((rows * step[0] + GAP_PX, across * step[1] + GAP_PX, 3), PAPER, np.uint8)
    for k, frame in enumerate(given):
        small = cv2.resize(frame, (width, height), interpolation=cv2.INTER_AREA)
        if labels:
            _write(small, labels[k])
        top, left = GAP_PX + (k // columns) * step[0], GAP_PX + (k % columns) * step[1]
        sheet[top : top + height, left : left + width] = small
    return sheet


def write_pictures(folder: Path, frames: Iterable[tuple[int, ImageArray]]) -> int:
    """Write frames as PNG files named by their stamps in ns, which sort as they follow.

    Args:
        folder: made where it is missing.
        frames: (stamp in ns, 0 or more; uint8 (h, w, 3) RGB).

    Returns:
        how many were written.

    Raises:
        ValueError: a stamp below 0.
        OSError: a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for time_ns, frame in frames:
        if time_ns < 0:
            raise ValueError(f"write_pictures(frames): expected stamps from 0, got {time_ns}")
        done, data = cv2.imencode(".png", frame[..., ::-1])
        if not done:
            raise OSError(f"{folder}: the frame at {time_ns} ns cannot be written as PNG")
        (folder / f"{time_ns:019d}.png").write_bytes(data.tobytes())
        count += 1
    return count


def _write(picture: ImageArray, text: str) -> None:
    """A label in the upper left corner, light with a dark rim."""
    size = max(0.35, min(1.0, picture.shape[1] / 420.0))
    x, y = int(8 * size), int(22 * size)
    # The rim is made of shifted copies: thicker strokes would be spaced wider.
    rim = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
    for dx, dy, color in [(*step, (0, 0, 0)) for step in rim] + [(0, 0, (255, 255, 255))]:
        cv2.putText(
            picture,
            text,
            (x + dx, y + dy),
            cv2.FONT_HERSHEY_SIMPLEX,
            0.6 * size,
            color,
            1,
            cv2.LINE_AA,
        )
