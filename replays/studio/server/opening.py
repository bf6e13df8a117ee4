"""What `motorcade author` opens: a run, a folder of runs, or a scene that lies beside its run."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from motorcade.replays.studio.server.desk import open_desk
from motorcade.replays.studio.server.offers import Offer

log = logging.getLogger("motorcade.studio")

MOST_RUNS = 1000
RUN_LOG = "run.json"


def offered(path: Path, run: Path | None = None) -> list[Offer]:
    """The runs whose scenes can be edited.

    Args:
        path: a run's folder, a folder of runs, or a scene's file.
        run: of a scene that lies elsewhere.

    Raises:
        ValueError: none of these.
    """
    if path.is_dir():
        if run is not None:
            raise ValueError(f"--run: expected with a scene's file, got the folder {path}")
        if (path / RUN_LOG).is_file():
            return [_offer(path, None)]
        runs = sorted(one.parent for one in path.glob(f"*/{RUN_LOG}"))
        if not runs:
            raise ValueError(f"{path}: expected what `motorcade run` wrote, or a folder of such")
        if len(runs) > MOST_RUNS:
            log.warning("%s: the first %d of %d runs are listed", path, MOST_RUNS, len(runs))
        return [_offer(one, None) for one in runs[:MOST_RUNS]]
    folder = path.absolute().parent if run is None else run
    if not (folder / RUN_LOG).is_file():
        raise ValueError(
            f"{path}: expected a run's folder, or a scene in one; {folder} holds no run. A scene "
            "is edited on footage: `motorcade run RECORDING --out RUN` makes a run, and "
            f"`motorcade author {path} --run RUN` opens the scene on it"
        )
    return [_offer(folder, path)]


def ready(offer: Offer, say: Callable[[str], None]) -> Offer:
    """An offer that was opened, so that what keeps it from being edited is told before the link.

    Args:
        offer: a single one.
        say: takes a line on what is under way.

    Raises:
        ValueError: a run or a scene that cannot be read.
        OSError: its recording is gone, or another process edits the scene.
    """
    say(f"{offer.name}: opening the run")
    since = time.monotonic()
    desk = offer.open()
    say(f"{offer.name}: {desk.frames} pictures, {time.monotonic() - since:.1f} s")
    return replace(offer, open=lambda: desk)


def _offer(run: Path, scene: Path | None) -> Offer:
    return Offer(run.absolute().name, lambda: open_desk(run, scene))
