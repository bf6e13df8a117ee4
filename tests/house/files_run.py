"""Counts the files of the product whose functions run in a task: how far one has to read for it.

    python -m tests.house.files_run             a whole run, one interpolation, one blended vertex
    python -m tests.house.files_run --list      and their names

Imports do not count, only functions that are called.
"""

from __future__ import annotations

import inspect
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")


def files_of(task: Callable[[], object]) -> set[str]:
    """Product files, by path below the repository, in which a function ran during the task."""
    codes: dict[str, bool] = {}

    def note(frame: FrameType, event: str, argument: Any) -> None:
        # Bodies of modules and classes are no functions: they run when something is imported.
        if event == "call" and frame.f_code.co_flags & inspect.CO_OPTIMIZED:
            codes[frame.f_code.co_filename] = True

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        task()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    import motorcade.ga

    root = Path(motorcade.ga.__file__).parents[1]
    paths = [Path(name) for name in codes if Path(name).is_relative_to(root)]
    below = [path.relative_to(root) for path in paths]
    return {str(path) for path in below if path.parts[0] in ROOMS}


def run() -> Callable[[], object]:
    """The whole graph on the embedded recording, computed from the start."""
    from motorcade.replays.cli import main

    def task() -> None:
        with tempfile.TemporaryDirectory() as folder:
            main(["demo", "--out", folder])

    return task


def interpolate() -> Callable[[], object]:
    """One motor between two others."""
    from motorcade.ga import Motor

    start, end = Motor.random(np.random.default_rng(0), (2,))
    return lambda: start.interpolate(end, 0.5)


def vertex() -> Callable[[], object]:
    """A character's vertices skinned in one pose."""
    from motorcade.animation import mannequin, skin

    figure = mannequin()
    pose = figure.clips[0].poses[0]
    return lambda: skin(figure, pose)


def main() -> None:
    for prepare in (run, interpolate, vertex):
        task_files = files_of(prepare())
        print(f"{len(task_files):4} files  {prepare.__doc__}")
        if "--list" in sys.argv:
            print("\n".join(f"       {name}" for name in sorted(task_files)))


if __name__ == "__main__":
    main()
