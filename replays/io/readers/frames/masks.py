"""Masks of what moves before the scene, one image a frame, as any model for people leaves them.

White (255) is what moves, black the scene, grey between them a soft edge. Labels are taken too: of
colours every one that is not black, of a cut-out its alpha, and 0 and 1 as 0 and 255.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.frames import images
from motorcade.replays.io.readers.frames.files import numbered
from motorcade.replays.io.recording import ImageArray
from motorcade.tracking.masks import COUNTS

_LOG = logging.getLogger("motorcade.replays")
_WHITE_BACKGROUND = 0.6
_NAMED = 3
_FIELD = "[frames] masks"


@dataclass(frozen=True, eq=False)
class MaskFiles:
    """A mask for each of some frames, found by the frame's stamp.

    Fields:
        files: `N` image files.
        time_ns: ``(N,)`` stamps of the frames that they belong to.
        size: width and height that each must have: the frames', as shown.
    """

    files: tuple[Path, ...]
    time_ns: IntArray
    size: tuple[int, int]

    def reader(self, time_ns: int) -> Callable[[], ImageArray] | None:
        """What reads the mask of the frame with a stamp; None where there is none."""
        row = int(np.searchsorted(self.time_ns, time_ns))
        if row == len(self.time_ns) or self.time_ns[row] != time_ns:
            return None
        return partial(read_mask, self.files[row], self.size)

    def check(self) -> None:
        """Read every file and look at its header, end and size; say where masks seem inverted.

        Raises:
            RecordingError: the first that is missing, truncated or of another size.
        """
        for _ in self.content():
            pass
        some = self.files[:: 1 + len(self.files) // 8]
        share = float(np.mean([read_mask(path, self.size) >= COUNTS for path in some]))
        if share > _WHITE_BACKGROUND:
            _LOG.warning(
                "%s: masks cover %.0f %% of the images: white must be what moves; invert them if "
                "it is the background",
                self.files[0].parent,
                100.0 * share,
            )

    def content(self) -> Iterator[bytes]:
        """The stamps, and a digest of every file; raises as `check`."""
        yield self.time_ns.tobytes()
        for path in self.files:
            yield hashlib.sha256(_read(path, self.size)).digest()


def _read(path: Path, size: tuple[int, int]) -> bytes:
    advice = f"make masks of the images as they are shown, {size[0]} x {size[1]}"
    return images.read_image_bytes(path, _FIELD, size, advice)


def read_mask(path: Path, size: tuple[int, int]) -> ImageArray:
    """Decode a mask: uint8 ``(height, width)``, 255 for what moves.

    Raises RecordingError: missing, truncated, another size, or nothing that can be decoded.
    """
    stored = cv2.imdecode(np.frombuffer(_read(path, size), np.uint8), cv2.IMREAD_UNCHANGED)
    if stored is None or stored.shape[1::-1] != size:
        raise refusal(path, "the mask cannot be decoded", field=_FIELD, advice="write it as PNG")
    if stored.ndim == 3 and stored.shape[2] == 4 and stored[..., 3].min() < 255:
        stored = stored[..., 3]
    elif stored.ndim == 3:
        highest, lowest = stored[..., :3].max(axis=2), stored[..., :3].min(axis=2)
        labels = np.where(highest >= COUNTS, 255, 0)
        stored = highest if np.array_equal(highest, lowest) else labels
    if stored.dtype == np.uint16 and stored.max() > 1:
        stored = stored >> 8
    return np.asarray(stored * 255 if stored.max() == 1 else stored, dtype=np.uint8)


def paired_masks(
    files: Sequence[Path], names: Sequence[str], time_ns: IntArray, size: tuple[int, int]
) -> MaskFiles:
    """Give each frame its mask: by name where masks are called as the images are, else by order.

    Args:
        files: of masks, in natural order.
        names: of the frames' image files; empty where they are in one file.
        time_ns: ``(N,)`` stamps of the frames.
        size: of the frames as shown.

    Raises:
        RecordingError: a frame without a mask, or masks of which one is missing (by name or
            number), or more or fewer than frames.
    """
    folder, stems = files[0].parent, {Path(name).stem: row for row, name in enumerate(names)}
    rows = {name: row for row, name in enumerate(names)} | stems
    own = {rows[path.stem]: path for path in files if path.stem in rows}
    missing: list[str] = []
    if 2 * len(own) > len(files):
        missing = [name for row, name in enumerate(names) if row not in own]
        files = [own[row] for row in sorted(own)]
    else:
        steps = np.diff(np.array(numbered(files) or range(len(files))))
        jumps = np.flatnonzero(steps != np.median(steps)) if len(steps) else np.zeros(0, np.int64)
        missing = [f"what follows {files[row].name}" for row in jumps.tolist()]
    if missing or len(files) != len(time_ns):
        listed = f"; missing: {', '.join(missing[:_NAMED])}" if missing else ""
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        raise refusal(
            folder,
            f"expected {len(time_ns)} masks, one for each frame, got {len(files)}{listed}{more}",
            field=_FIELD,
            advice="call them as the images are called; a frame in which nothing moves needs a "
            "black one",
        )
    return MaskFiles(tuple(files), time_ns, size)
