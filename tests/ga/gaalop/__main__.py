"""Prints how Gaalop's scripts and macros agree: `python -m tests.ga.gaalop [--data FOLDER]`.

A row a target: how many scripts agree by blade with what Gaalop computes, and which do not. Those
that Gaalop itself refuses are listed. Then a row an algebra: its macros against Gaalop's own
definitions of them, on random arguments.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from motorcade.ga.codegen.targets import TARGETS
from tests.ga.gaalop.languages import LANGUAGES
from tests.ga.gaalop.macros import algebras, disagreements
from tests.ga.gaalop.scripts import TOLERANCE, Case, difference, directly, read_cases
from tests.ga.gaalop.targets import RUNNERS, Prepared, Results, prepared

# How a runner says that its tool is not installed.
MISSING = ("no OpenGL", "no C compiler", "no Node", "no rustc", "no g++")
REPOSITORY = Path(__file__).resolve().parents[3]


def usual_data() -> Path:
    """Where real recordings lie, and Gaalop's scripts beside them."""
    return Path(os.environ.get("MOTORCADE_DATA", REPOSITORY.parent / "shared" / "data"))


def differences(cases: list[Case]) -> Iterator[tuple[str, dict[str, str]]]:
    """For each way to run them, how cases differ from Gaalop's results."""
    yield "evaluate", _told(cases, {case.name: directly(case) for case in cases}, TOLERANCE)
    programs = {case.name: prepared(case) for case in cases}
    ready = [one for one in programs.values() if isinstance(one, Prepared)]
    refused = {name: one for name, one in programs.items() if isinstance(one, str)}
    others = {name: (run, 1e-9) for name, run in LANGUAGES.items() if name in TARGETS}
    for target, (run, tolerance) in {**RUNNERS, **others}.items():
        with tempfile.TemporaryDirectory() as folder:
            made = run(ready, Path(folder))
        yield target, _told(cases, {**made, **refused}, tolerance)


def _told(cases: list[Case], made: Results, tolerance: float) -> dict[str, str]:
    told = {case.name: difference(case, made[case.name], tolerance) for case in cases}
    return {name: why for name, why in told.items() if why}


def main(arguments: list[str] | None = None) -> int:
    """Print the tables; 1 if anything disagrees."""
    parser = argparse.ArgumentParser(prog="python -m tests.ga.gaalop", description=__doc__)
    parser.add_argument("--data", type=Path, default=usual_data())
    data: Path = parser.parse_args(arguments).data
    cases = read_cases(data)
    judged = [case for case in cases if case.expected is not None]
    failed = False
    print(f"{'scripts in':<24}{'agree':>12}  differ")
    for target, told in differences(judged):
        failed = failed or bool(told)
        print(f"{target:<24}{len(judged) - len(told):>5} of {len(judged)}  {len(told)}")
        for name, why in told.items():
            print(f"    {name}: {why}")
    for case in cases:
        if case.expected is None:
            print(f"Gaalop refuses {case.name}: {case.refusal.partition(' / ')[0]}")
    print(f"\n{'macros of':<24}{'agree':>12}  differ")
    for name in algebras(data):
        count, wrong = disagreements(data, name)
        failed = failed or bool(wrong)
        print(f"{name:<24}{count - len(wrong):>5} of {count}  {len(wrong)}")
        for macro, why in wrong.items():
            print(f"    {macro}: {why}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
