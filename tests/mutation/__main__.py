"""Mutation testing: do the tests notice small faults in the code?

    python -m tests.mutation ga/versors ga/classical        the modules in these folders
    python -m tests.mutation fusion/metrics --tests tests/fusion/test_metrics.py
    python -m tests.mutation ga/versors --again          what survived, after `--measure` or not

Of every module a seeded sample of its mutants is taken (`mutants` says which kinds there are), and
over each the tests run that reach its lines, until one fails. Which tests reach what, and how long
they take, comes from one run of all tests named (those of the room, if none are): the first time,
and with ``--measure``, which new tests or changed lines need. Of the tests that reach a mutant as
many run as take ``--seconds`` of a processor together. It is caught when a test fails or takes five
times as long. Mutants that compute the same as the original stand, with the reason, in
``equivalent.toml``.

Results lie in ``build/mutation``, and a run that was ended goes on where it was. Two runs at a time
are fine where their modules differ. No source is changed: see `running`.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

from tests.mutation.measure import Measured, measured
from tests.mutation.mutants import Mutant, mutants, sample
from tests.mutation.running import Watch, forked, import_others, install, run_tests

FOLDER = Path("build/mutation")
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
# Setting up takes time that no test counts.
_SLOWER, _SETTING_UP_S = 5.0, 30.0

Record = dict[str, Any]


def main() -> int:
    """Run the sample of every module; print the survivors, and a table."""
    options = _options()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", str(FOLDER.resolve() / "hypothesis"))
    modules = [file for path in options.modules for file in _files(path)]
    room = modules[0].parts[0]
    tests = options.tests or [Path("tests") / room]
    import_others(file for path in tests for file in _files(path))
    known = measured(room, tests, FOLDER, anew=options.measure)
    found = {file: _run_module(file, known, options) for file in modules}
    for file, records in found.items():
        for record in records:
            if record["outcome"] == "survived":
                print(f"\n{file}:{record['line']}\n-{record['was']}\n+{record['becomes']}")
    return _print_table({file: records for file, records in found.items() if records})


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation")
    parser.add_argument("modules", nargs="+", type=Path, help="sources, or folders of them")
    parser.add_argument("--tests", nargs="+", type=Path, help="tests that may catch them")
    parser.add_argument("--sample", type=int, default=20, help="mutants a module")
    parser.add_argument("--seed", default="0")
    parser.add_argument("--seconds", type=float, default=20.0, help="of tests over one mutant")
    parser.add_argument("--measure", action="store_true", help="find out anew what tests reach")
    parser.add_argument("--again", action="store_true", help="try again what survived")
    return parser.parse_args()


def _files(path: Path) -> list[Path]:
    found = sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return [file for file in found if "generated" not in file.parts]


def _run_module(file: Path, known: Measured, options: argparse.Namespace) -> list[Record]:
    """What became of each mutant of the sample; kept after each, so that nothing runs twice."""
    source = file.read_text(encoding="utf-8")
    kept = FOLDER / f"{'.'.join(file.with_suffix('').parts)}.json"
    before = json.loads(kept.read_text("utf-8")) if kept.exists() else []
    done = {(record["line"], record["was"], record["becomes"]): record for record in before}
    same = _equivalent(file)
    records = []
    for mutant in sample(mutants(source), options.sample, f"{options.seed} {file.as_posix()}"):
        was, becomes = _changed_lines(source, mutant)
        record = done.get((mutant.line, was, becomes))
        if (was, becomes) in same:
            record = {"outcome": "equivalent", "by": None}
        elif record is None or (options.again and record["outcome"] == "survived"):
            record = _tried(file, mutant.applied(source), known, mutant, options.seconds)
            print(f"{file}:{mutant.line} {record['outcome']}", file=sys.stderr, flush=True)
        records.append(record | {"line": mutant.line, "was": was, "becomes": becomes})
        rest = {(r["line"], r["was"], r["becomes"]): r for r in records}
        kept.write_text(json.dumps(list((done | rest).values()), indent=1), encoding="utf-8")
    return records


def _tried(file: Path, text: str, known: Measured, mutant: Mutant, most_s: float) -> Record:
    tests = known.tests_of(file, mutant, most_s)
    expected_s = sum(known.seconds[name] for name in tests)

    def work() -> list[str]:
        install(file, text)
        watch = Watch(tests)
        for path in dict.fromkeys(name.partition("::")[0] for name in tests):
            code = run_tests(watch, "-x", path)
            if watch.failed or code not in (0, 5):
                return watch.failed or [f"{path}: pytest ends with {code}"]
        return []

    start = time.monotonic()
    try:
        failed = forked(work, _SLOWER * expected_s + _SETTING_UP_S) if tests else []
    except (TimeoutError, ChildProcessError) as ended:
        failed = [str(ended)]
    return {
        "outcome": "caught" if failed else "survived",
        "by": failed[0] if failed else None,
        "tests": len(tests),
        "seconds": round(time.monotonic() - start, 1),
    }


def _changed_lines(source: str, mutant: Mutant) -> tuple[str, str]:
    """The lines that a mutant changes, before and after, each as one line of text."""
    made = mutant.applied(source)
    first, last = source.encode()[: mutant.start].count(b"\n"), mutant.before.count("\n")
    longer = mutant.after.count("\n")
    was = source.splitlines()[first : first + last + 1]
    becomes = made.splitlines()[first : first + longer + 1]
    return " ".join(" ".join(was).split()), " ".join(" ".join(becomes).split())


def _equivalent(file: Path) -> set[tuple[str, str]]:
    if not EQUIVALENT.exists():
        return set()
    entries = tomllib.loads(EQUIVALENT.read_text("utf-8")).get(file.as_posix(), [])
    return {(entry["was"], entry["becomes"]) for entry in entries}


def _print_table(found: dict[Path, list[Record]]) -> int:
    """A row a module; the share caught is of those that are not equivalent."""
    print(f"\n{'module':50s} mutants caught equivalent survived  share")
    total = Counter[str]()
    for name, records in (*((str(file), records) for file, records in found.items()), ("all", [])):
        counts = Counter(record["outcome"] for record in records) if records else total
        total += counts if records else Counter()
        share = counts["caught"] / max(1, counts["caught"] + counts["survived"])
        print(
            f"{name:50s} {counts.total():7d} {counts['caught']:6d} {counts['equivalent']:10d}"
            f" {counts['survived']:8d} {share:6.0%}"
        )
    return 0 if total["survived"] == 0 else 1


if __name__ == "__main__":
    raise SystemExit(main())
