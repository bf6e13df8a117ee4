"""How much code stands under the cache key of each stage, for a run on a board's images.

    python -m tests.replays.engine.key_sizes

An edit in one of these modules computes the stage anew. Modules are counted by room; what a stage
is given beside the recording is made by other stages, whose values' code is counted here too.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from motorcade.replays.engine.stage import Choice
from motorcade.replays.engine.store import reach, types_within
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.job import pipeline_graph
from motorcade.tracking.boards import Checkerboard
from motorcade.tracking.cameras.camera import Camera

ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")


def recording_of_a_board() -> Recording:
    """What a folder of images and a manifest with a camera and a board are read as."""
    frames = ImageFrames((Path("0.png"), Path("1.png")), np.array([0, 10**8]), (640, 480))
    camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    board = Checkerboard(8, 5, 0.03)
    return Recording("board", Path(), "images", frames, camera=camera, board=board)


def modules_under(stage: str) -> frozenset[str]:
    """Names of our modules under the cache key of a stage; none under a choice, which runs none."""
    known = pipeline_graph().stages[stage]
    if isinstance(known, Choice):
        return frozenset()
    given = types_within(recording_of_a_board()) if "recording" in known.inputs else set()
    found = reach(known.function.__module__, *sorted({one.__module__ for one in given}))
    return found.modules | found.faces


def main() -> None:
    """Print a table."""
    print(f"{'stage':<16}{'modules':>8}", *(f"{room:>10}" for room in ROOMS), f"{'SLAM':>6}")
    for stage in pipeline_graph().order:
        names = modules_under(stage)
        rooms = Counter(name.split(".")[1] for name in names if "." in name)
        slam = sum(name.startswith("motorcade.tracking.slam") for name in names)
        counts = (f"{rooms[room]:>10}" for room in ROOMS)
        print(f"{stage:<16}{len(names):>8}", *counts, f"{slam:>6}")


if __name__ == "__main__":
    main()
