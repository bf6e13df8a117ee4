"""Hostile inputs of every kind by the thousand: own errors or valid values, in bounds, or a fault.

    python -m tests.fuzz                                  # every kind, a few seconds each
    python -m tests.fuzz manifests --seed 7 --inputs 20000 --seconds 600
    python -m tests.fuzz manifests --seed 7 --only 1697   # that input again, with its traceback
    python -m tests.fuzz --record runs.jsonl              # adds what was fed, and what came of it
    python -m tests.fuzz --table runs.jsonl               # all that was recorded, as a table

Every input must end in an error of ours in one line, or in valid values, within 10 s of a
processor, 60 s in all and 1 GiB more memory. The program ends with 1 where one did not.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.fuzz import guided
from tests.fuzz.runner import KINDS, Result, SkippedError, feed_of, fresh, run
from tests.fuzz.targets import TARGETS

EVERY = (*KINDS, *TARGETS)
GUIDED_SHARE = 0.25
"""Of a kind's time: there are more of them, and they are short."""


def main() -> int:
    """Run as the module says; 0 where every input ended well."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=", ".join(EVERY))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--inputs", type=int, default=100_000, help="of each kind, at most")
    parser.add_argument("--seconds", type=float, default=6.0, help="for each kind (6)")
    parser.add_argument("--only", type=int, metavar="N", help="feed this input alone, unbounded")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where --only leaves its files")
    parser.add_argument("--record", type=Path, metavar="FILE", help="add the results to a file")
    parser.add_argument("--table", type=Path, metavar="FILE", help="print recorded results; no run")
    arguments = parser.parse_args()
    if arguments.table is not None:
        print(table(arguments.table.read_text().splitlines()))
        return 0
    for kind in arguments.kinds:
        if kind not in EVERY:
            parser.error(f"expected kinds of {', '.join(EVERY)}, got {kind}")
    if arguments.only is not None:
        return _again(arguments.kinds[0], arguments.seed, arguments.only, arguments.keep)
    faults = 0
    for kind in arguments.kinds or EVERY:
        try:
            found = _fed(kind, arguments.seed, arguments.inputs, arguments.seconds)
        except SkippedError as why:
            _tell(f"{kind:13} skipped: {why}")
            continue
        faults += found.ended["FAULT"]
        _tell(described(found))
        if arguments.record is not None:
            with arguments.record.open("a") as file:
                file.write(json.dumps(recorded(found)) + "\n")
    return 1 if faults else 0


def _fed(kind: str, seed: int, inputs: int, seconds: float) -> Result:
    """Feed a kind, and tell of its faults."""
    if kind not in TARGETS:
        return run(kind, seed, inputs, seconds, _tell)
    found = guided.run(kind, seed, inputs, GUIDED_SHARE * seconds)
    for fault in found.faults:
        _tell(fault)
    return found


def described(found: Result) -> str:
    """A line on what came of a kind."""
    ended = ", ".join(f"{count} {name}" for name, count in sorted(found.ended.items()))
    return (
        f"{found.kind:13} {found.inputs:8} inputs in {found.seconds:5.0f} s: {ended}; slowest "
        f"{found.slowest[0]:.2f} s (--only {found.slowest[1]}), {found.peak_bytes >> 20} MiB"
    )


def recorded(found: Result) -> dict[str, object]:
    """What is kept of a kind's run."""
    return {
        "kind": found.kind,
        "seed": found.seed,
        "inputs": found.inputs,
        "ended": dict(found.ended),
        "slowest_s": round(found.slowest[0], 2),
        "peak_mib": found.peak_bytes >> 20,
    }


def table(lines: list[str]) -> str:
    """Recorded results by kind, in Markdown."""
    runs = [json.loads(line) for line in lines]
    rows = ["| kind | inputs | valid | refused | faults | seeds | slowest | memory |"]
    rows.append("|---|---:|---:|---:|---:|---|---:|---:|")
    whole: Counter[str] = Counter()
    for kind in dict.fromkeys(one["kind"] for one in runs):
        mine = [one for one in runs if one["kind"] == kind]
        ended: Counter[str] = Counter()
        for one in mine:
            ended.update(one["ended"])
        counts = Counter(
            inputs=sum(one["inputs"] for one in mine),
            refused=ended["refused"],
            faults=ended["FAULT"],
        )
        counts["valid"] = counts["inputs"] - counts["refused"] - counts["faults"]
        whole.update(counts)
        seeds = ", ".join(map(str, sorted({one["seed"] for one in mine})))
        slowest = max(one["slowest_s"] for one in mine)
        memory = max(one["peak_mib"] for one in mine)
        rows.append(f"| {kind} | {_counted(counts)} | {seeds} | {slowest} s | {memory} MiB |")
    rows.append(f"| all | {_counted(whole)} | | | |")
    return "\n".join(rows)


def _counted(counts: Counter[str]) -> str:
    return " | ".join(f"{counts[name]:,}" for name in ("inputs", "valid", "refused", "faults"))


def _again(kind: str, seed: int, number: int, keep: Path | None) -> int:
    """Feed one input as it was, without bounds; a fault's traceback comes out."""
    folder = Path(tempfile.mkdtemp()) if keep is None else keep
    folder.mkdir(parents=True, exist_ok=True)
    try:
        print(feed_of(kind, folder)(fresh(seed, number)))
    finally:
        if keep is None:
            shutil.rmtree(folder)
    return 0


def _tell(line: str) -> None:
    print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main())
