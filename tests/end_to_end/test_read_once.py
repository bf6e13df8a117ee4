"""A run opens each image once to check and digest it, once to track, once to draw into.

The report opens it once more, for the copy of the footage that its viewer plays.

A few, spread over the recording, are opened once more, for the light in them, and up to forty to
see what stands before the figure.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.replays.stages.view.overlay import LIT_FRAMES
from motorcade.tracking.depth.sweep import MOST_VIEWS

_counted: list[Counter[Path]] = []


def _count(event: str, arguments: tuple[object, ...]) -> None:
    if event == "open" and _counted and isinstance(arguments[0], str):
        _counted[-1][Path(arguments[0])] += 1


sys.addaudithook(_count)  # it stays for good, and counts only within `counting`


@contextmanager
def counting() -> Iterator[Counter[Path]]:
    """Within the block, how often each file is opened by Python."""
    _counted.append(Counter())
    try:
        yield _counted[-1]
    finally:
        _counted.pop()


def images(opened: Counter[Path], folder: Path) -> list[int]:
    """How often each image of a recording was opened, in the order of their names."""
    files = sorted(folder.glob("**/*.png"))
    assert files
    return [opened[path] for path in files]


def test_images_are_read_once_for_check_and_digest_together(board_recording: Path) -> None:
    with counting() as opened:
        recording = open_recording(board_recording).intact()
        first, again = recording.digest(), recording.digest()
    first_image, *others = images(opened, board_recording)
    assert set(others) == {1}
    assert first_image == 2  # once more for its size, which the manifest leaves out
    assert first == again == open_recording(board_recording).digest()


@pytest.mark.parametrize("until", ["camera_poses", "report"])
def test_a_run_opens_each_image_as_often_as_it_needs_it(
    until: str, board_recording: Path, tmp_path: Path
) -> None:
    with counting() as opened:
        run_job(Job(board_recording, tmp_path / "out", until=until))
    drawn = (tmp_path / "out" / "overlay.mp4").exists()
    counts = images(opened, board_recording)
    usual = np.full(len(counts), 3 if drawn else 2) + (until == "report")
    if drawn:
        for often in (LIT_FRAMES, MOST_VIEWS):
            usual[np.unique(np.linspace(0, len(counts) - 1, often).round()).astype(int)] += 1
    # The first is looked at for its size, a dozen spread over the recording for whether the board
    # is as stated, and one for what can be stood on.
    more = np.array(counts) - usual
    assert more.min() == 0
    assert more.max() <= 4
    assert more.sum() <= 20

    with counting() as opened:
        run_job(Job(board_recording, tmp_path / "out", until=until))
    assert sum(images(opened, board_recording)) == len(counts) + 1
