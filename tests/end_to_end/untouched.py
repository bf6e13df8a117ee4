"""`python -m tests.end_to_end.untouched RUN…`: whether films keep the pixels of their clips.

A film is held against the decoded clip away from what was drawn, and the clip, encoded anew as
films are, says what coding alone changes. What was drawn is found by what differs most: a figure
with its shadow is one part of the image, footage that was bent differs everywhere. Exit status 1
where a film differs elsewhere.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from motorcade.render import read_frames, write_video
from motorcade.render.composite import as_rgb
from motorcade.replays.io.readers.opening import open_recording

IMAGES = 12
DIFFERS, MARGIN_PX, MOST_SHARE = 14.0, 0.04, 0.5
LEVEL_TIMES, LEVEL_MORE = 1.25, 0.3


@dataclass(frozen=True)
class Untouched:
    """One film against its clip.

    Fields:
        drawn: largest share of an image that was taken for figure and shadow.
        outside: root mean square difference elsewhere, of 255; encoder: what coding alone leaves.
    """

    drawn: float
    outside: float
    encoder: float

    @property
    def kept(self) -> bool:
        """Whether only coding changed the footage, and a figure is a part of the image."""
        level = LEVEL_TIMES * self.encoder + LEVEL_MORE
        return self.drawn < MOST_SHARE and self.outside <= level


def untouched(run: Path) -> Untouched:
    """Compare a run's film with the recording that it was made from, every so many images.

    Raises:
        ValueError: a film with another count of images than its recording.
    """
    told = json.loads((run / "run.json").read_text())
    manifest = Path(told["manifest"]) if told.get("manifest") else None
    frames = open_recording(Path(told["recording"]), manifest).frames
    every = max(1, len(frames) // IMAGES)
    film = [image for _, image in read_frames(run / "overlay.mp4", every)]
    if len(film) != -(-len(frames) // every):
        raise ValueError(f"{run}: expected a film of {len(frames)} images, got another count")
    clip = [as_rgb(frames[every * k].image()) for k in range(len(film))]
    with tempfile.TemporaryDirectory() as folder:
        again = Path(folder) / "again.mp4"
        write_video(again, clip, 40_000_000 * np.arange(len(clip)))
        coded = [image for _, image in read_frames(again)]
    drawn, squares = 0.0, []
    for given, shown, plain in zip(clip, film, coded, strict=True):
        height, width = given.shape[:2]
        off, own = (one[:height, :width].astype(np.float32) - given for one in (shown, plain))
        part = drawn_part(off)
        drawn = max(drawn, float(part.mean()))
        squares.append([np.square(one[~part]).mean() for one in (off, own) if not part.all()])
    outside, encoder = np.sqrt(np.mean([one for one in squares if one], axis=0))
    return Untouched(drawn, float(outside), float(encoder))


def drawn_part(off: np.ndarray) -> np.ndarray:
    """Where an image was drawn into, by its difference: the box about the largest such part."""
    size = cv2.blur(np.abs(off).max(axis=-1), (5, 5))
    wide = max(1, round(MARGIN_PX * max(size.shape)))
    near = cv2.dilate((size > DIFFERS).astype(np.uint8), np.ones((wide, wide), np.uint8))
    count, _, boxes, _ = cv2.connectedComponentsWithStats(near)
    part = np.zeros(size.shape, bool)
    if count > 1:
        left, top, width, height, _ = boxes[1 + int(np.argmax(boxes[1:, cv2.CC_STAT_AREA]))]
        part[top : top + height, left : left + width] = True
    return part


def main() -> int:
    """Compare and print."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.untouched")
    parser.add_argument("runs", type=Path, nargs="+", metavar="RUN", help="folders of runs")
    print("| run | drawn | differs elsewhere, of 255 | coding alone | as filmed |")
    print("|---|---|---|---|---|")
    fine = True
    for run in parser.parse_args().runs:
        if not (run / "overlay.mp4").exists():
            print(f"| {run.name} | no film | | | |")
            continue
        one = untouched(run)
        fine &= one.kept
        print(
            f"| {run.name} | {one.drawn:.0%} | {one.outside:.2f} | {one.encoder:.2f} | "
            f"{'yes' if one.kept else 'NO'} |",
            flush=True,
        )
    return int(not fine)


if __name__ == "__main__":
    sys.exit(main())
