"""Whether a video file is as long as its own outermost boxes say, so that a cut copy is named.

Players make the best of a cut file: they show what is there, and say nothing. Looked at are the
boxes of MP4 and MOV (ISO 14496-12), the segment of Matroska and WebM (RFC 9559), and the first
RIFF chunk of AVI. Files of which the length is not told, such as streams, pass.
"""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from motorcade.ga.names import one_line
from motorcade.render.video import MAX_FILE_BYTES
from motorcade.replays.io.door import open_bounded

_EBML, _SEGMENT = b"\x1a\x45\xdf\xa3", b"\x18\x53\x80\x67"


def said_of_cut(path: Path) -> str:
    """What is said of a file that ends before its outermost boxes do; empty of a whole one.

    Raises:
        OSError: it cannot be read.
    """
    end = path.stat().st_size
    with open_bounded(path, MAX_FILE_BYTES) as file:
        start = file.read(12)
        file.seek(0)
        if start[4:8] == b"ftyp":
            return _cut_box(file, end)
        if start[:4] == _EBML:
            return _cut_segment(file, end)
        if start[:4] == b"RIFF" and start[8:12] == b"AVI ":
            size = int.from_bytes(start[4:8], "little")
            if size + 8 > end:  # 0 where recording was never ended, which tells nothing
                return _cut("RIFF", size, 0)
    return ""


def _cut_box(file: BinaryIO, end: int) -> str:
    """Walk the outermost boxes of an MP4 or MOV file."""
    at = 0
    while at + 8 <= end:
        file.seek(at)
        header = file.read(16)
        size = int.from_bytes(header[:4], "big")
        if size == 1:
            size = int.from_bytes(header[8:], "big")
        elif size == 0:
            break
        if size < 8 or at + size > end:
            return _cut(one_line(header[4:8]), size, at)
        at += size
    return ""


def _cut_segment(file: BinaryIO, end: int) -> str:
    """Look at the length of a Matroska file's segment, which holds all of it but the header."""
    file.seek(len(_EBML))
    header = _length(file)
    if header is None:
        return ""
    at = file.tell() + header
    file.seek(at)
    if file.read(len(_SEGMENT)) != _SEGMENT:
        return ""
    size = _length(file)
    if size is not None and file.tell() + size > end:
        return _cut("Segment", size, at)
    return ""


def _length(file: BinaryIO) -> int | None:
    """An EBML length: the first byte's leading zeros say how long it is; None where not told."""
    first = file.read(1)
    if not first or not first[0]:
        return None
    more = 8 - first[0].bit_length()
    bits = 7 * (more + 1)
    size = int.from_bytes(first + file.read(more), "big") & ((1 << bits) - 1)
    return None if size == (1 << bits) - 1 else size


def _cut(box: str, size: int, at: int) -> str:
    return f"the video is truncated: its box {box} of {size} bytes at {at} is not whole"
