"""Changes one byte of every kind of file that a run opens, and prints what is computed again.

    python -m tests.end_to_end.stale

A row is a file, the way in which it is named, and which stages were computed again. Stages that
read the file must be, others where and only where the output of a stage before them has changed;
once the file is as it was, everything must be found again. Of a sweep over two characters or
recordings, the run that reads the file must be done again, and the other one must not. The program
ends with 1 where a row is wrong.
"""

from __future__ import annotations

import json
import logging
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorcade.replays.comparison.sweep import read_sweep, run_sweep
from motorcade.replays.pipeline.job import Job, pipeline_graph, run_job
from tests.end_to_end.stale.kinds import CHARACTERS, COMMENT, CONTAINERS, RECORDINGS, Kind, assimp
from tests.replays.tiny_recordings import write_tiny

STEADY = (
    "tracked.by=simulated",
    "convergence.duration_s=1.0",
    "smoothed.representations=motor",
    "placed.on=floor",
)
RUNS = ("one", "other")
GRAPH = pipeline_graph()


@dataclass(frozen=True)
class Row:
    """What became of stages, or of the runs of a sweep, after a file had changed.

    Fields:
        kind, way: which file, and by what it is named.
        again: stages, or runs, and whether they were computed again.
        faults: what is wrong about that.
    """

    kind: str
    way: str
    again: Mapping[str, bool]
    faults: tuple[str, ...]

    def __str__(self) -> str:
        again = [name for name, whether in self.again.items() if whether]
        judged = "; ".join(self.faults) or "right"
        told = f"{len(self.again) - len(again)} kept, again: {' '.join(again) or 'none'}"
        return f"{self.kind:<26}{self.way:<10}{judged:<7} {told}"


def written(folder: Path, kind: Kind) -> tuple[Path, Path, tuple[str, ...]]:
    """A recording and a character in a new folder: the recording, the file to change, settings."""
    recording = write_tiny(folder / "recording", 0.1)
    if not kind.character:
        return recording, kind.write(recording), STEADY
    (recording / "figure").mkdir()
    character = f"placed.character={recording / 'figure' / kind.character}"
    changing = kind.write(recording / "figure")
    return recording, changing, (*STEADY, character, f"placed.clip={kind.clip}")


def of_a_run(kind: Kind, way: str, folder: Path, cache: Path) -> Row:
    """Runs before and after; the file is named by a knob, or by the recording's manifest."""
    recording, changing, settings = written(folder, kind)
    if way == "manifest" and kind.character:
        manifest = recording / "motorcade.toml"
        settings = tuple(one.replace(f"{recording}/", "") for one in settings)  # as seen from there
        manifest.write_text(f"settings = {json.dumps(settings)}\n{manifest.read_text()}")
        settings = ()
    last = "errors" if not kind.character else "overlay" if way == "knob" else "placed"
    given = recording / "given.toml" if kind.container else None
    job = Job(
        recording / kind.container, folder / "out", given, cache, until=last, settings=settings
    )
    before = ran(job)
    shutil.copytree(changing.parent, folder / "as it was", symlinks=True)
    kind.change(changing)
    after = ran(job)
    shutil.rmtree(changing.parent)
    (folder / "as it was").rename(changing.parent)
    restored = ran(job)
    again = {name: not stage["cached"] for name, stage in after["stages"].items()}
    faults = [*stale(kind, before, after, cache)]
    faults += [f"{name} not found again" for name, one in restored["stages"].items()
               if not one["cached"]]  # fmt: skip
    return Row(kind.name, way, again, tuple(faults))


def ran(job: Job) -> dict[str, Any]:
    """The run log of a run."""
    run_job(job)
    return dict(json.loads((job.out / "run.json").read_text()))


def stale(
    kind: Kind, before: Mapping[str, Any], after: Mapping[str, Any], cache: Path
) -> Iterator[str]:
    """What was kept though it should not have been, and the other way round."""
    digests = [outputs(log, cache) for log in (before, after)]
    for name, stage in after["stages"].items():
        inputs = GRAPH.stages[name].inputs
        if kind is COMMENT or kind.name.startswith("setting"):
            reads = kind is not COMMENT and name == "smoothed"
        else:
            reads = name in ("placed", "overlay") if kind.character else "recording" in inputs
        expected = reads or any(digests[0].get(one) != digests[1].get(one) for one in inputs)
        if stage["cached"] == expected:
            yield f"{name} was {'kept' if expected else 'computed again'}"


def outputs(log: Mapping[str, Any], cache: Path) -> dict[str, str]:
    """The digest of each stage's output, of choices too."""
    found = {
        name: json.loads((cache / stage["key"] / "artifact.json").read_bytes())["digest"]
        for name, stage in log["stages"].items()
    }
    return found | {name: found[stage] for name, stage in log["chosen"].items()}


def of_a_sweep(kind: Kind, folder: Path) -> Row:
    """Two runs of a sweep, one of which reads the file."""
    (folder / "other").mkdir()
    recording, _, _ = written(folder / "other", kind)
    (folder / "one").mkdir()
    own, changing, _ = written(folder / "one", kind)
    knobs = [f"{one.partition('=')[0]} = {json.dumps(one.partition('=')[2])}" for one in STEADY]
    places = [own, recording]
    if kind.character:
        characters = [f"{name}/recording/figure/{kind.character}" for name in RUNS]
        knobs += [f"placed.character = {json.dumps(characters)}", f'placed.clip = "{kind.clip}"']
        places = [own]
    plan = folder / "sweep.toml"
    last = "placed" if kind.character else "errors"
    named = [str(one / kind.container) for one in places]
    tables = [f"{{path = {json.dumps(one)}}}" for one in named]
    if kind.container:
        tables = [
            f'{{path = "{name}", manifest = "{one}/given.toml"}}'
            for name, one in zip(named, places, strict=True)
        ]
    heads = [f"recordings = [{', '.join(tables)}]", f'until = "{last}"']
    plan.write_text("\n".join([*heads, "[knobs]", *knobs]))
    marks = [str(folder / one / "recording" / ("figure" if kind.character else "")) for one in RUNS]
    swept(plan, folder)
    before = [finished_at(folder, mark) for mark in marks]
    kind.change(changing)
    summary = swept(plan, folder)
    after = [finished_at(folder, mark) for mark in marks]
    again = {name: a != b for name, a, b in zip(RUNS, before, after, strict=True)}
    reads = kind is not COMMENT
    faults = [f"{summary.failed} runs failed"] if summary.failed else []
    if again != {"one": reads, "other": False} or summary.done != reads:
        faults.append(f"{summary.done} runs were done again")
    return Row(kind.name, "sweep", again, tuple(faults))


def swept(plan: Path, folder: Path) -> Any:
    return run_sweep(read_sweep(plan, GRAPH), folder / "out", "local")


def finished_at(folder: Path, mark: str) -> int:
    """When the last run was written that was about a path."""
    logs = [path for path in folder.glob("out/runs/*/run.json") if mark in path.read_text()]
    return max(path.stat().st_mtime_ns for path in logs)


def cases() -> list[tuple[Kind, str]]:
    """Every kind of file by every way in which it is named."""
    made = [(kind, way) for kind in CHARACTERS for way in ("knob", "manifest", "sweep")]
    made += [(kind, way) for kind in (*RECORDINGS, COMMENT) for way in ("folder", "sweep")]
    return made + [(kind, way) for kind in CONTAINERS for way in ("given", "sweep")]


def row(kind: Kind, way: str, folder: Path, cache: Path) -> Row:
    """One row of the table; `folder` is empty, `cache` may be shared by all."""
    with assimp():
        if way == "sweep":
            return of_a_sweep(kind, folder)
        return of_a_run(kind, way, folder, cache)


def main() -> int:
    """Print the table; 1 where a row is wrong."""
    logging.getLogger("motorcade").setLevel(logging.ERROR)
    wrong = 0
    with tempfile.TemporaryDirectory() as made:
        for number, (kind, way) in enumerate(cases()):
            folder = Path(made) / str(number)
            folder.mkdir()
            found = row(kind, way, folder, Path(made) / "cache")
            print(found, flush=True)
            wrong += bool(found.faults)
    print(f"{len(cases())} rows, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
