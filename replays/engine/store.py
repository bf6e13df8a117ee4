"""The outputs of a run: taken from the cache where they are there, computed and kept otherwise.

A key covers the content of the inputs, the knobs and the code; files that a stage opens are kept
with its output, which holds for as long as they are as they were.

What a stage reads is known only once it has run, so that a key of inputs, knobs and code leads to
several artifacts, each with the files that it was made from. The first one has the key's name.
Where a file of it is in another state now, the next one to look at is named after that state, and
so on. Files that change back lead back to what was made of them.
"""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorcade.ga.files import UNSETTLED, files_now, files_read, off_record, put_on_record
from motorcade.ga.progress import working
from motorcade.ga.unfinished import remove_unfinished
from motorcade.replays.engine import artifacts
from motorcade.replays.engine.artifacts import Stored, discard_artifact, find_artifact
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.engine.stage import AUTO, Choice, Chosen, NotOffered, Stage, StageError

log = logging.getLogger("motorcade.graph")

_MISSING = "none"


@dataclass(frozen=True)
class Computed:
    """How one stage of a run came to its output.

    Fields:
        stage: its name.
        key: the name of the output in the cache.
        knobs: their values.
        files: those that it opened beside the recording, with the state that they were in.
        seconds: how long it took when it was computed.
        cached: whether that was in an earlier run.
    """

    stage: str
    key: str
    knobs: Mapping[str, str]
    files: Mapping[str, str]
    seconds: float
    cached: bool


@dataclass(frozen=True)
class _NothingFound:
    """Stored in the place of an output where a stage of a choice found nothing."""

    reason: str


class StageStore:
    """Outputs of stages by name, as a run goes on.

    Args:
        cache: the folder of artifacts; made where it is missing.
        knobs: settings by stage and name.
    """

    def __init__(
        self, cache: Path, sources: Mapping[str, Any], knobs: Mapping[str, Mapping[str, Any]]
    ) -> None:
        cache.mkdir(parents=True, exist_ok=True)
        remove_unfinished(cache)
        self.outputs: dict[str, Any] = dict(sources)
        self.records: list[Computed] = []
        self._cache, self._knobs = cache, knobs
        with off_record():  # what they read is in their digests
            self._digests = {name: source.digest() for name, source in sources.items()}

    def obtain(self, stage: Stage) -> None:
        """Have the output of a stage whose inputs are there; raises whatever the stage raises."""
        output, digest = self._find_or_compute(stage)
        if isinstance(output, _NothingFound):
            raise StageError(f"{stage.name}: {output.reason}")
        self._keep(stage.name, output, digest)

    def choose(self, choice: Choice) -> str:
        """Have the output of the first stage of a choice that works; gives that stage's name.

        Raises StageError: none works, or the one that is asked for does not.
        """
        by = self._knobs.get(choice.name, {}).get("by", AUTO)
        for stage in choice.members.values():
            self.leave_out(stage.name)
        if by != AUTO:
            self.obtain(choice.members[by])
            return self._chosen(choice, by, ())
        skipped, lacking = [], []
        for label, stage in choice.members.items():
            try:
                output, digest = self._find_or_compute(stage, choice.skips)
            except NotOffered as reason:
                lacking.append(str(reason))
                continue
            if isinstance(output, _NothingFound):
                log.warning("%s: skipped: %s", stage.name, output.reason)
                skipped.append(f"{label}: {output.reason}")
                continue
            self._keep(stage.name, output, digest)
            return self._chosen(choice, label, tuple(skipped))
        raise StageError(f"{choice.name}: {'; '.join(dict.fromkeys([*skipped, *lacking]))}")

    def _chosen(self, choice: Choice, label: str, skipped: tuple[str, ...]) -> str:
        name = choice.members[label].name
        content = json.dumps([self._digests[name], label, skipped]).encode()
        value = Chosen(self.outputs[name], label, skipped)
        self._keep(choice.name, value, hashlib.sha256(content).hexdigest())
        return name

    def leave_out(self, name: str) -> None:
        """Have nothing of a stage."""
        self._keep(name, None, _MISSING)

    def _keep(self, name: str, output: Any, digest: str) -> None:
        self.outputs[name], self._digests[name] = output, digest

    def _find_or_compute(
        self, stage: Stage, skips: type[Exception] | None = None
    ) -> tuple[Any, str]:
        """Output and digest, cached or computed; `_NothingFound` where it raises what is skipped.

        Raises NotOffered: the stage does, and something is skipped.
        """
        settings = stage.settings(self._knobs.get(stage.name, {}))
        folder, kept = find_kept(self._cache / f"{stage.name}-{self._key(stage, settings)}")
        if kept:
            log.info("%s: kept from before", stage.name)
        stored = kept or self._compute(stage, settings, folder, skips)
        kind = stage.output | _NothingFound
        try:
            output = artifacts.read_artifact(stored, kind)
        except artifacts.ArtifactError:
            if artifacts.find_artifact(stored.folder) is not None:
                raise
            # Another run took it away just now.
            stored = self._compute(stage, settings, folder, skips)
            output = artifacts.read_artifact(stored, kind)
        texts = {knob: repr(value) for knob, value in settings.items()}
        files = {str(path): state for path, state in stored.files.items()}
        name, cached = stored.folder.name, kept is not None
        self.records.append(Computed(stage.name, name, texts, files, stored.seconds, cached))
        return output, stored.digest

    def _key(self, stage: Stage, settings: Mapping[str, Any]) -> str:
        """Content of the inputs, knobs and code, as the name under which outputs are cached."""
        parts = {
            "inputs": {name: self._digests[name] for name in stage.inputs},
            "knobs": {name: repr(value) for name, value in settings.items()},
            "code": code_digest(stage.function, [self.outputs[name] for name in stage.inputs]),
            "format": artifacts.FORMAT_VERSION,
        }
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]

    def _compute(
        self,
        stage: Stage,
        settings: Mapping[str, Any],
        folder: Path,
        skips: type[Exception] | None,
    ) -> artifacts.Stored:
        log.debug("%s ...", stage.name)
        start = time.perf_counter()
        with artifacts.workspace(folder.parent), working(stage.name):
            try:
                with files_read() as files:
                    value = stage.function(*(self.outputs[one] for one in stage.inputs), **settings)
            except (ValueError, OverflowError, MemoryError) as error:
                if skips is None or not isinstance(error, (skips, NotOffered)):
                    raise StageError(f"{stage.name}: {error}") from error
                if isinstance(error, NotOffered):
                    raise
                value = _NothingFound(str(error))
            seconds = time.perf_counter() - start
            stored = artifacts.write_artifact(value, folder, seconds, files)
        log.info("%s: %.1f s", stage.name, seconds)
        if stored.files != files:  # another run was faster, with other files under the same names
            return self._compute(stage, settings, find_kept(folder)[0], skips)
        return stored


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
