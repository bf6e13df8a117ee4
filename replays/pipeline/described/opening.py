"""Opening a recording whatever was told of it: what it lacks is found out, written and read."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorcade.ga.files import off_record
from motorcade.replays.engine.graph import Graph, Knobs
from motorcade.replays.engine.stage import GraphError
from motorcade.replays.io.atomic import write_bytes
from motorcade.replays.io.door import read_bounded
from motorcade.replays.io.readers.manifest import LOCAL_NAME
from motorcade.replays.io.readers.manifest.section import TOML_LIMIT, load_toml
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.described.describing import described, lacks_description
from motorcade.replays.pipeline.described.values import Assumption, Description

log = logging.getLogger("motorcade.graph")

STAGE = "described"


@dataclass(frozen=True, eq=False)
class OpenedRecording:
    """A recording, and what of it was not told.

    Fields:
        recording: complete as far as its files and pictures bear it.
        manifest: the text that repeats this, None where nothing was lacking.
        assumed: what stands in it without having been told.
        seconds: what finding that out took, now or when it was done.
    """

    recording: Recording
    manifest: str | None = None
    assumed: tuple[Assumption, ...] = ()
    seconds: float = 0.0


def description_graph() -> Graph:
    """The one stage that comes before the others: from a recording to what it lacks.

    >>> from motorcade.replays.pipeline.described.opening import description_graph
    >>> sorted(description_graph().stages["described"].knobs)
    ['board', 'fov_deg', 'rate_hz', 'shot', 'size_m', 'target']
    """
    return Graph([described], {"recording": Recording})


def parted(settings: Iterable[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Settings of this stage, and those of all others.

    >>> from motorcade.replays.pipeline.described.opening import parted
    >>> parted(["described.size_m=0.03", "tracked.by=slam"])
    (('described.size_m=0.03',), ('tracked.by=slam',))
    """
    given = tuple(settings)
    own = tuple(one for one in given if one.strip().startswith(f"{STAGE}."))
    return own, tuple(one for one in given if one not in own)


def open_described(
    recording: Recording, manifest: Path | None, cache: Path, knobs: Knobs
) -> OpenedRecording:
    """Complete a recording; where neither its files nor a manifest name a camera, find that out.

    Args:
        recording: as it was opened.
        manifest: by which it was opened, if any was named.
        cache: keeps what was found out.
        knobs: of the stage `described`.

    Raises:
        RecordingError: as `open_recording`.
        StageError: pictures that tell too little; the message says what to do.
        GraphError: knobs for a recording that lacks nothing.
    """
    path = recording.root
    given = _given(path, manifest)
    names_camera = given is not None and "camera" in load_toml(given)
    if names_camera or not lacks_description(recording):
        if knobs.get(STAGE):
            knob = next(iter(knobs[STAGE]))
            problem = f"{STAGE}.{knob}: {path} names its camera, so nothing is looked for"
            raise GraphError(f"{problem}; say it in a manifest instead")
        return OpenedRecording(recording)
    with off_record():
        recording = recording.intact()
    run = description_graph().run(STAGE, {"recording": recording}, cache, knobs)
    found: Description = run.outputs[STAGE]
    for one in found.assumed:
        log.info("assumed %s", one)
    before = "" if given is None else read_bounded(given, TOML_LIMIT).decode()
    text = found.manifest(before)
    place = cache / f"manifest-{hashlib.sha256(text.encode()).hexdigest()[:16]}.toml"
    write_bytes(place, text.encode())
    seconds = run.records[0].seconds
    return OpenedRecording(open_recording(path, place), text, found.assumed, seconds)


def _given(path: Path, manifest: Path | None) -> Path | None:
    """The manifest that was named, or lies in the recording."""
    if manifest is not None:
        return manifest
    local = path / LOCAL_NAME
    return local if local.exists() else None


def summary(opened: OpenedRecording) -> dict[str, Any]:
    """What was assumed, for machines; empty where nothing was."""
    return {} if opened.manifest is None else {"assumed": [str(one) for one in opened.assumed]}
