"""Contradictions planted in drawn recordings: is each named with its mend, and does the mend help?

    python -m tests.end_to_end.contradictions --out DIR [--only WORD] [--seed N] [--clean N]

Each kind's recording is drawn, stated wrongly and run with `--strict`: it must exit with 1, its
closing line must name the mend, and the manifest that follows that line must run clean. Clean
recordings of fresh seeds, and all at hand, must not be doubted. A line each; 1 where one fails.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import sys
import time
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.end_to_end.contradictions.drawing import Drawn
from tests.end_to_end.contradictions.kinds import BASES, Kind, kinds
from tests.end_to_end.contradictions.running import followed, run


def drawn_base(folder: Path, name: str, seed: int) -> Drawn:
    """A base's clean recording, drawn once."""
    place, note = folder / f"{name}-{seed}", folder / f"{name}-{seed}.toml"
    if note.exists():
        return Drawn(place, note.read_text())
    shutil.rmtree(place, ignore_errors=True)
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    drawn = BASES[name](place, rng)
    note.write_text(drawn.manifest)
    return drawn


def planted(kind: Kind, folder: Path, seed: int) -> Drawn:
    """A base's recording with the contradiction in it."""
    clean = drawn_base(folder, kind.base, seed)
    if kind.files:
        place = folder / "planted"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(clean.folder, place)
        clean = replace(clean, folder=place)
    return kind.plant(clean, np.random.default_rng(seed))


def judged(kind: Kind, folder: Path, seed: int) -> tuple[str, str]:
    """Whether it is named, or what is missing; and the closing lines."""
    wrong = planted(kind, folder, seed)
    answer = run(wrong)
    if answer.code != 1:
        return "MISSED", answer.closing
    if not re.search(kind.mend, answer.closing):
        return "UNNAMED", answer.closing
    if not kind.mendable:
        return "named", answer.closing
    try:
        again = run(followed(wrong, answer.closing, kind.known))
    except (ValueError, StopIteration) as fault:
        return "NO KEY", str(fault)
    return ("named" if again.code == 0 else "NOT MENDED"), f"{answer.closing} || {again.closing}"


def main() -> int:
    """Print a line each; 1 where one fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--clean", type=int, default=0)
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for kind in kinds():
        if asked.clean or asked.only not in f"{kind.base}: {kind.name}":
            continue
        start = time.perf_counter()
        verdict, closing = judged(kind, asked.out, asked.seed)
        rows.append((f"{kind.base}: {kind.name}", verdict, closing))
        seconds = time.perf_counter() - start
        print(f"{verdict:10} {rows[-1][0]} ({seconds:.1f} s): {closing}", flush=True)
    names = [name for name in BASES if asked.only in name]
    for number in range(asked.clean):
        name = names[number % len(names)]
        answer = run(drawn_base(asked.out, name, asked.seed + number))
        rows.append((name, "named" if answer.code == 0 else "FALSE", answer.closing))
        print(
            f"{rows[-1][1]:10} clean {name}, seed {asked.seed + number}: {answer.closing}",
            flush=True,
        )
    failed = sum(verdict != "named" for _, verdict, _ in rows)
    print(f"{len(rows) - failed} of {len(rows)} right")
    (asked.out / "rows.json").write_text(json.dumps(rows, indent=1))
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
