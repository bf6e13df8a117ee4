"""What a sweep runs: a TOML file of recordings, knobs with alternatives, and seeds.

.. code-block:: toml

    recordings = ["flights/*", {path = "board.mp4", manifest = "board.toml"}]
    seeds = [0, 1, 2]            # without it, one run with the knobs' own seeds
    until = "errors"             # or any later stage, as with `motorcade run --until`

    [knobs]
    tracked.by = "simulated"    # the same in every run
    fused.gate = [0.99, 0.9999]          # each in turn; every combination is run

Paths are relative to the file, those of knobs too. A list is always a list of alternatives: a knob
that holds several values is written as text, as on the command line ("motor,euler").
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from motorcade.ga.names import one_line
from motorcade.replays.engine.graph import Graph
from motorcade.replays.engine.knobs import parse_knobs
from motorcade.replays.engine.stage import GraphError
from motorcade.replays.io.errors import RecordingError, refusal
from motorcade.replays.io.readers.manifest.section import Section, load_toml, setting_from

MOST_RUNS = 100_000
_KEYS = ("recordings", "seeds", "until", "knobs")
SEEDED = ("simulated_poses.seed", "imu.seed")
"""The knobs that a seed of the sweep sets."""


@dataclass(frozen=True)
class PlannedRun:
    """One run of a sweep.

    Fields:
        recording, manifest: what is run on.
        seed: of everything random; None for the knobs' own.
        varied: (knob, value) of the knobs that differ between runs, as text.
        settings: all settings, each "stage.knob=value".
        until: the last stage.

    >>> from pathlib import Path
    >>> from motorcade.replays.comparison.sweep import PlannedRun
    >>> setting = "smoothed.window_s=0.4"
    >>> run = PlannedRun(Path("V1_01_easy"), None, None, (("smoothed.window_s", "0.4"),),
    ...     (setting,), until="errors")
    >>> dict(run.varied)
    {'smoothed.window_s': '0.4'}
    """

    recording: Path
    manifest: Path | None
    seed: int | None
    varied: tuple[tuple[str, str], ...]
    settings: tuple[str, ...]
    until: str


@dataclass(frozen=True)
class Sweep:
    """A sweep as its file states it; its runs are all combinations.

    Fields:
        recordings: path and manifest of each.
        seeds: (None,) where the file names none.
        knobs: knob and its alternatives, as text.
        until: the last stage of every run.

    >>> from pathlib import Path
    >>> from motorcade.replays.comparison.sweep import Sweep
    >>> knobs = (("smoothed.window_s", ("0.2", "0.4")),)
    >>> sweep = Sweep(((Path("V1_01_easy"), None),), seeds=(1, 2), knobs=knobs, until="errors")
    >>> len(sweep), [(run.varied[0][1], run.seed) for run in sweep.runs()]
    (4, [('0.2', 1), ('0.2', 2), ('0.4', 1), ('0.4', 2)])
    """

    recordings: tuple[tuple[Path, Path | None], ...]
    seeds: tuple[int | None, ...]
    knobs: tuple[tuple[str, tuple[str, ...]], ...]
    until: str

    def __len__(self) -> int:
        count = len(self.recordings) * len(self.seeds)
        for _, values in self.knobs:
            count *= len(values)
        return count

    def runs(self) -> Iterator[PlannedRun]:
        """Every run, the seed changing fastest."""
        choices = [[(name, value) for value in values] for name, values in self.knobs]
        several = {name for name, values in self.knobs if len(values) > 1}
        combined = itertools.product(self.recordings, itertools.product(*choices), self.seeds)
        for (recording, manifest), chosen, seed in combined:
            settings = [f"{name}={value}" for name, value in chosen]
            if seed is not None:
                settings += [f"{name}={seed}" for name in SEEDED]
            varied = tuple(one for one in chosen if one[0] in several)
            yield PlannedRun(recording, manifest, seed, varied, tuple(settings), self.until)


def read_sweep(path: Path, graph: Graph) -> Sweep:
    r"""Read a sweep's file and check every name and value in it against the graph.

    Raises:
        RecordingError: the file is missing, not TOML, or a key is unknown or of the wrong kind.
        GraphError: a stage, knob or value that the graph does not have.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.replays import pipeline_graph
    >>> from motorcade.replays.comparison.sweep import read_sweep
    >>> config = "recordings = ['room']\nseeds = [1, 2]\nknobs.smoothed.window_s = [0.2, 0.4]"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = Path(folder, "sweep.toml").write_text(config)
    ...     sweep = read_sweep(Path(folder, "sweep.toml"), pipeline_graph())
    >>> len(sweep), sweep.seeds
    (4, (1, 2))
    """
    top = Section(path, "", load_toml(path), _KEYS)
    until = top.text("until") if "until" in top else "errors"
    seeds = _seeds(top)
    knobs = tuple(_knobs(top)) if "knobs" in top else ()
    try:
        graph.needed(until)
        for name, values in knobs:
            if seeds != (None,) and name in SEEDED:
                raise top.fault(f"knobs.{name}", "expected either this or seeds, got both")
            for value in values:
                parse_knobs([f"{name}={value}"], graph)
    except GraphError as fault:
        raise GraphError(f"{path}: {fault}") from fault
    sweep = Sweep(_recordings(top), seeds, knobs, until)
    if len(sweep) > MOST_RUNS:
        raise refusal(path, f"expected at most {MOST_RUNS} runs, got {len(sweep)}")
    return sweep


def _seeds(top: Section) -> tuple[int | None, ...]:
    if "seeds" not in top:
        return (None,)
    seeds = top["seeds"]
    if not isinstance(seeds, list) or not seeds:
        raise top.fault("seeds", f"expected a list of whole numbers, got {one_line(seeds)}")
    for seed in seeds:
        if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < 2**31:
            raise top.fault("seeds", f"expected whole numbers of at least 0, got {one_line(seed)}")
    if len(set(seeds)) < len(seeds):
        raise top.fault("seeds", "expected different ones, got one twice")
    return tuple(seeds)


def _knobs(top: Section) -> Iterator[tuple[str, tuple[str, ...]]]:
    stages = top["knobs"]
    if not isinstance(stages, Mapping):
        raise top.fault("knobs", f"expected a table, got {one_line(stages)}")
    for stage, settings in stages.items():
        if not isinstance(settings, Mapping):
            raise top.fault(f"knobs.{stage}", f"expected stage.knob, got {one_line(settings)}")
        for knob, value in settings.items():
            name = f"{stage}.{knob}"
            values = value if isinstance(value, list) else [value]
            texts = tuple(_text(top, name, one) for one in values)
            texts = tuple(_from_file(top, name, text) for text in texts)
            if not texts or len(set(texts)) < len(texts):
                raise top.fault(
                    f"knobs.{name}", f"expected different values, got {one_line(value)}"
                )
            yield name, texts


def _text(top: Section, name: str, value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float | str):
        return str(value)
    raise top.fault(f"knobs.{name}", f"expected a number, text or truth, got {one_line(value)}")


def _from_file(top: Section, name: str, text: str) -> str:
    """The value of a knob; a file that it names is looked for beside the sweep's."""
    setting = setting_from(f"{name}={text}", lambda value: top.path.parent / value)
    return setting.partition("=")[2]


def _recordings(top: Section) -> tuple[tuple[Path, Path | None], ...]:
    patterns = top["recordings"]
    if not isinstance(patterns, list) or not patterns:
        raise top.fault("recordings", f"expected a list, got {one_line(patterns)}")
    recordings: dict[tuple[Path, Path | None], None] = {}
    for entry in patterns:
        if not isinstance(entry, str | Mapping):
            expected = "expected paths, or tables of path and manifest"
            raise top.fault("recordings", f"{expected}, got {one_line(entry)}")
        section = Section(
            top.path,
            "recordings",
            {"path": entry} if isinstance(entry, str) else entry,
            ("path", "manifest"),
        )
        manifest = top.path.parent / section.text("manifest") if "manifest" in section else None
        try:
            places = _places(top.path.parent, section.text("path"))
        except (NotImplementedError, ValueError) as fault:
            if isinstance(fault, RecordingError):
                raise
            raise section.fault("path", f"expected a path or pattern: {fault}") from fault
        if not places:
            raise section.fault("path", f"no recording is called {one_line(section.text('path'))}")
        recordings |= dict.fromkeys((place, manifest) for place in places)
    return tuple(recordings)


def _places(folder: Path, text: str) -> list[Path]:
    """What a path or pattern names; a path that is missing stays, so that its run tells of it."""
    if not any(letter in text for letter in "*?["):
        return [folder / text]
    pattern = Path(text)
    base = Path(pattern.anchor) if pattern.is_absolute() else folder
    return sorted(base.glob(str(pattern.relative_to(pattern.anchor))))
