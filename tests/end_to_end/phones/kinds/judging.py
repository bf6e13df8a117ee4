"""Whether a kind came out as it must: right, refused for the right reason, or doubted aloud."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

from tests.end_to_end.phones.cases import CASES
from tests.end_to_end.phones.kinds.kinds import Kind
from tests.end_to_end.phones.scores import Score, film_faults, scored

__all__ = ["Judged", "judge"]

_PROGRESS = re.compile(r"\w+: [\d.]+ s$|done as far as|done in|look into")


@dataclass(frozen=True)
class Judged:
    """What a kind came to.

    Fields:
        kind: which.
        status: with which the command ended.
        said: the lines on standard error that are neither assumptions in order nor progress.
        score: against the truth, where there is a result.
        seconds: that the command took.
        doubts: what the run itself doubts.
    """

    kind: Kind
    status: int
    said: tuple[str, ...]
    score: Score | None
    seconds: float
    doubts: tuple[str, ...] = ()

    @property
    def right(self) -> bool:
        """Whether it is as it must be; never with a traceback, nor with more than one line."""
        if any("Traceback" in line for line in self.said):
            return False
        if self.kind.must == "filmed":
            doubted = any(re.search(self.kind.why, line) for line in self.doubts)
            return self.score is not None and self.score.right and doubted
        if self.score is not None and self.score.right and self.kind.must != "refused":
            return True
        if self.kind.must == "right":
            return False
        told = self.said[-1:] if self.status else self.doubts
        refused = self.status == 1 or (self.kind.must == "told" and self.status == 0)
        return refused and any(re.search(self.kind.why, line) for line in told)

    def line(self) -> str:
        """A row of a table."""
        verdict = "yes" if self.right else "NO"
        name, seconds = self.kind.name, f"{self.seconds:.0f}"
        if self.status or self.score is None:
            last = self.said[-1] if self.said else "nothing"
            return f"| {name} | {verdict} | ({self.status}) {last} | | | | {seconds} |"
        row = self.score.line().split(" | ")
        told = dict.fromkeys((*self.doubts, self.score.camera))
        doubts = "".join(f"\n    {one}" for one in told)
        return " | ".join([f"| {name}", verdict, *row[2:-1], f"{seconds} |"]) + doubts


def judge(file: Path, kind: Kind, out: Path, until: str) -> Judged:
    """Run the command on a file with nothing but its name; hold what it leaves against truth."""
    alone = out.with_name(f"{out.name}_file")  # the truth lies beside the file: none may find it
    alone.mkdir(parents=True, exist_ok=True)
    clip = Path(shutil.copy(file, alone))
    command = [str(Path(sys.executable).with_name("motorcade")), "run", clip.name]
    start = time.perf_counter()
    ran = subprocess.run(
        [*command, "--out", str(out.resolve()), "--until", until],
        capture_output=True,
        text=True,
        check=False,
        cwd=alone,
    )
    seconds = time.perf_counter() - start
    lines = (line.strip() for line in re.split(r"[\r\n]+", ran.stderr))
    said = tuple(line for line in lines if line and not _PROGRESS.match(line))
    if ran.returncode:
        return Judged(kind, ran.returncode, said, None, seconds)
    case = next(one for one in CASES if one.name == kind.of)
    case = replace(case, name=kind.name, rotation=kind.coded.turned_deg if case.readout_s else 0)
    if kind.must == "filmed":  # from no path that a truth could be held against
        score = Score(kind.name, False, seconds, faults=film_faults(file, out, until))
    else:
        score = scored(file, case, out, until, seconds)
    log = json.loads((out / "run.json").read_text())
    doubts = [one for one in log.get("assumed", []) if ";" in one.split("; override")[0]]
    doubts += [one for one in said if not one.startswith("assumed")]
    return Judged(kind, 0, said, score, seconds, tuple(doubts))
