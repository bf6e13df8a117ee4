"""The video at a glance: some of its frames on one sheet, small enough for the page."""

from __future__ import annotations

from pathlib import Path

import cv2

from motorcade.render.video import contact_sheet, read_frames

__all__ = ["sheet_jpeg"]

MOST_FRAMES, COLUMNS, WIDTH_PX = 12, 3, 340
MOST_BYTES = 300_000
_QUALITIES = (85, 75, 65, 50, 35, 20)


def sheet_jpeg(film: Path, frames: int) -> bytes:
    """Twelve frames or fewer, even in time, with their times, as JPEG of 300 kB at most.

    Args:
        film: a video.
        frames: how many it holds.

    Raises:
        OSError: a file that cannot be read or holds no video.
    """
    chosen = list(read_frames(film, every=-(-frames // MOST_FRAMES)))
    labels = [f"{1e-9 * time_ns:.1f} s" for time_ns, _ in chosen]
    sheet = contact_sheet([picture for _, picture in chosen], COLUMNS, WIDTH_PX, labels)
    for quality in _QUALITIES:
        done, data = cv2.imencode(".jpg", sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
        if not done:
            raise OSError(f"{film}: the sheet of its frames cannot be written as JPEG")
        if data.size <= MOST_BYTES:
            break
    return bytes(data)
