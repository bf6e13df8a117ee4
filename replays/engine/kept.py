"""Which artifacts still hold: those whose files are in the state in which they were read.

What a stage reads is known only once it has run, so that a key of inputs, knobs and code leads to
several artifacts, each with the files that it was made from. The first one has the key's name.
Where a file of it is in another state now, the next one to look at is named after that state, and
so on. Files that change back lead back to what was made of them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from motorcade.ga.files import UNSETTLED, files_now, put_on_record
from motorcade.replays.engine.artifacts import Stored, discard_artifact, find_artifact


def find_kept(folder: Path) -> tuple[Path, Stored | None]:
    """Among the artifacts of a key, the first of which lies in `folder`, the one that holds.

    Its files are put on record, as if they were read here. Where none holds, the place is given
    where one may be stored.
    """
    while (stored := find_artifact(folder)) is not None:
        now = files_now(stored.files)
        if now == stored.files:
            put_on_record(now)
            return folder, stored
        if UNSETTLED in stored.files.values():  # it will never hold
            discard_artifact(stored)
            break
        folder = folder.with_name(_next_name(folder.name, now))
    return folder, None


def holds(stored: Stored | None) -> bool:
    """Whether there is an artifact, and all files that it was made from are as they were."""
    return stored is not None and files_now(stored.files) == stored.files


def _next_name(name: str, files: Mapping[Path, str]) -> str:
    """What an artifact is called that is looked for where another one does not hold."""
    states = sorted((str(path), state) for path, state in files.items())
    digest = hashlib.sha256(json.dumps([name, states]).encode()).hexdigest()
    return f"{name.rpartition('-')[0]}-{digest[:24]}"
