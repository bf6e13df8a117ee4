"""Makes a kind of a written clip: the file, and beside it the truth that still holds of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import av
import cv2
import numpy as np

from tests.end_to_end.phones.kinds.coding import Image, encode, upright_images
from tests.end_to_end.phones.kinds.kinds import Kind, times
from tests.end_to_end.phones.kinds.truths import cropped, mirrored, of_frames, scaled

__all__ = ["write_kind"]


def write_kind(clips: Path, folder: Path, kind: Kind) -> Path:
    """Write it from the clip that lies in `clips`; returns the file's path."""
    path = folder / f"{kind.name}{kind.coded.suffix}"
    source = clips / f"{kind.of}.mp4"
    truth = dict(np.load(source.with_suffix(".truth.npz")))
    rows = kind.rows(len(truth["time_s"]))
    time_s = times(truth["time_s"], rows, kind)
    images = _images(source, kind, rows.tolist())
    encode(path, _woven(images) if kind.woven else images, time_s, kind.coded)
    shown_s = time_s[kind.coded.skipped :] + _start_s(path)
    kept = of_frames(truth, rows[kind.coded.skipped :], shown_s)
    if kind.crop:
        kept = cropped(kept, *kind.crop[:2])
    kept = scaled(kept, kind.scale)
    if kind.mirrored:
        kept = mirrored(kept, _size(source, kind)[0])
    np.savez(path.with_suffix(".truth.npz"), **kept)  # type: ignore[arg-type]
    if kind.damage is not None:
        kind.damage(path)
    return path


def _start_s(path: Path) -> float:
    """The stamp of the first image: streams do not begin at 0."""
    if path.suffix not in (".ts", ".mts"):
        return 0.0
    with av.open(str(path)) as file:
        frame = next(file.decode(video=0))
    return float(frame.pts * frame.time_base)  # type: ignore[operator]


def _size(source: Path, kind: Kind) -> tuple[int, int]:
    height, width = next(iter(upright_images(source))).shape[:2]
    if kind.crop:
        width, height = kind.crop[2:]
    return round(kind.scale[0] * width), round(kind.scale[1] * height)


def _images(source: Path, kind: Kind, rows: list[int]) -> Iterator[Image]:
    """The chosen frames, edited; `rows` never go back."""
    size, wanted = _size(source, kind), iter(rows)
    row = next(wanted, None)
    for number, full in enumerate(upright_images(source)):
        if row is None:
            return
        if row != number:
            continue
        made = _made(full, kind, number, size)
        while row == number:
            yield made
            row = next(wanted, None)


def _woven(images: Iterator[Image]) -> Iterator[Image]:
    """Even rows of a frame, odd rows of the next: the truth of a row is up to a frame late."""
    before = next(images)
    for image in images:
        woven = before.copy()
        woven[1::2] = image[1::2]
        yield woven
        before = image
    yield before


def _made(full: Image, kind: Kind, number: int, size: tuple[int, int]) -> Image:
    image = full if kind.edit is None else kind.edit(full, number)
    if kind.crop:
        left, top, width, height = kind.crop
        image = image[top : top + height, left : left + width]
    if kind.mirrored:
        image = image[:, ::-1]
    return np.asarray(
        cv2.resize(np.ascontiguousarray(image), size, interpolation=cv2.INTER_AREA), np.uint8
    )
