"""What names of images say: their order, their numbers, whose series they are, and their stamps."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.frames.images import FRAME_LIMIT
from motorcade.replays.io.trajectories import even_stamps

_NUMBERED = re.compile(r"(.*?)([0-9]{1,18})([^0-9]*)")
_SERIES = 8


def numbered(paths: Sequence[Path]) -> list[int] | None:
    """The last number in each file name, or None where the names differ in something else."""
    patterns = _patterns(paths)
    return next(iter(patterns.values())) if len(patterns) == 1 else None


def _patterns(paths: Sequence[Path]) -> dict[str, list[int]]:
    """The last numbers of file names, by what else the names are; none where one has no number."""
    patterns: dict[str, list[int]] = {}
    for path in paths:
        part = _NUMBERED.fullmatch(path.name)
        if part is None:
            return {}
        patterns.setdefault(f"{part[1]}*{part[3]}", []).append(int(part[2]))
    return patterns


def _refuse_several(paths: Sequence[Path]) -> None:
    """Refuse images of several cameras: names of a few patterns that count alike."""
    patterns = _patterns(paths)
    if not 2 <= len(patterns) <= _SERIES:
        return
    numbers = [set(one) for one in patterns.values()]
    common, every = set.intersection(*numbers), set.union(*numbers)
    even = len(set(np.diff(sorted(every)).tolist())) == 1
    if even and 2 * len(common) > len(every):
        listed = " and ".join(patterns)
        raise refusal(
            paths[0].parent,
            f"expected the images of one camera, got {len(patterns)} series that count alike: "
            f"{listed}",
            advice=f'say which: [frames] images = "{next(iter(patterns))}"',
        )


def refuse_gaps(paths: Sequence[Path], advice: str) -> None:
    """Refuse numbered images of which one is missing: stamps made from a rate would be wrong.

    Raises:
        RecordingError: the numbers do not run in equal steps (the first missing one is named), or
            the names are of several series that count alike, as several cameras' are.
    """
    _refuse_several(paths)
    numbers = numbered(paths)
    if numbers is None or len(numbers) < 2:
        return
    steps = np.diff(np.array(numbers, dtype=np.int64))
    usual = int(np.median(steps))
    odd = np.flatnonzero(steps != usual)
    if odd.size:
        at = int(odd[0])
        before = paths[at]
        raise refusal(
            before.parent,
            f"expected images numbered in steps of {usual}, got {before.name} followed by "
            f"{paths[at + 1].name}: an image is missing",
            advice=advice,
        )


_SINCE_1970 = re.compile(r"(?:.*[^0-9])?(1[0-9]{9})[._]?([0-9]{3,9})")
_DATED = re.compile(
    r"(?:.*[^0-9])?((?:19|20)[0-9]{6})[-_ T]?([0-9]{6})[._-]?([0-9]{3})?(?:[^0-9].*)?"
)
_FARTHEST_APART = 10
"""Of numbers that count images, the usual step, in the smallest that divides all: one that counts
nanoseconds or rows of a log has thousands."""


def stamps_of_names(paths: Sequence[Path], rate_hz: float) -> IntArray:
    """Stamps ``(N,)`` of images in natural order, nanoseconds, by what their names say.

    Names that are times are the stamps: since 1970 (ten digits of seconds, then three to nine of
    their fraction), or a date and a time of the day, as phones name photographs. Numbers count
    images, `rate_hz` of them a second: where some were taken out or lost, the stamps leave a gap.
    Other names follow one another evenly, and so do dates several of which are the same.

    Raises:
        RecordingError: names of several series that count alike, as several cameras' are, or
            numbers that grow as no count of images does.

    >>> from pathlib import Path
    >>> from motorcade.replays.io.readers.frames.names import stamps_of_names
    >>> stamps_of_names([Path(f"img_{k}.png") for k in (1, 2, 5)], 10.0).tolist()
    [0, 100000000, 400000000]
    """
    _refuse_several(paths)
    times = [_SINCE_1970.fullmatch(path.stem) for path in paths]
    known = [int(time[1] + time[2].ljust(9, "0")) for time in times if time is not None]
    dates = [_dated_ns(path.stem) for path in paths]
    known = known or [date for date in dates if date is not None]
    if len(known) == len(paths) > 1 and min(np.diff(known)) > 0:
        return np.array(known)
    numbers = None if any(dates) else numbered(paths)
    if numbers is None or len(numbers) < 2:
        return even_stamps(len(paths), rate_hz)
    steps = np.diff(np.array(numbers, np.int64))
    unit = int(np.gcd.reduce(steps))
    counts = steps.min() > 0 and numbers[-1] - numbers[0] <= FRAME_LIMIT * unit
    if not counts or np.median(steps) > _FARTHEST_APART * unit:
        raise refusal(
            paths[0].parent,
            f"expected images that are numbered as they follow one another, got {paths[0].name} "
            f"followed by {paths[1].name}",
            advice="images taken at uneven times need [frames] stamps",
        )
    counted = (np.array(numbers) - numbers[0]) // unit
    return np.rint(counted * (1e9 / rate_hz)).astype(np.int64)


def _dated_ns(stem: str) -> int | None:
    """Nanoseconds from 1970 to a date and time of the day, of any time zone; None: no such name."""
    name = _DATED.fullmatch(stem)
    if name is None:
        return None
    try:
        moment = datetime.strptime(name[1] + name[2] + "+0000", "%Y%m%d%H%M%S%z")
    except ValueError:
        return None
    return int(moment.timestamp()) * 10**9 + int(name[3] or 0) * 10**6


def natural(path: Path) -> tuple[list[tuple[int, int, str]], str]:
    """Sort key that compares runs of digits as numbers."""
    parts = re.split(r"([0-9]+)", path.as_posix())
    return [
        (1, int(part[:18]), part) if index % 2 else (0, 0, part) for index, part in enumerate(parts)
    ], path.as_posix()
