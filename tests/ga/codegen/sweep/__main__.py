"""Code of every target, by the thousand: drawn, written, run, and held against evaluation.

    python -m tests.ga.codegen.sweep --count 20000 --seed 1
    python -m tests.ga.codegen.sweep --only 17 --seed 1 --target rust    # one script, and its code

Scripts have 0 to 80 inputs, 1 to 9 outputs, names of 1 to 90 letters and expressions nested up to
40 deep. Each is written by every target and strategy; what is written is compiled and run, or read
and worked out where nothing here runs it. Ends with 1 where one text fails or differs by 1e-12.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motorcade.ga.codegen.generate import STRATEGIES
from motorcade.ga.codegen.targets import TARGETS
from tests.ga.codegen.sweep.drawn import script_case
from tests.ga.codegen.sweep.runners import WAYS
from tests.ga.gaalop.scripts import difference
from tests.ga.gaalop.targets import Prepared, prepared

TOLERANCE = 1e-12
SINGLE_TOLERANCE = 1e-6
TOGETHER = 100
# Why a script has no code: what its own target says of names, sizes and values.
REFUSALS = ("is reserved in", "is used by the generated code", "have one parameter", "expected ")


@dataclass
class Swept:
    """What came of a sweep: texts by their way that agree, that were refused, and the faults."""

    agree: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)

    @property
    def texts(self) -> int:
        """How many were written."""
        return self.agree.total() + len(self.faults)


def sweep(numbers: range, seed: int, ways: list[str], swept: Swept) -> None:
    """Add the scripts of these numbers, as one run of every tool."""
    cases = [case for n in numbers if (case := script_case(n, seed)).expected is not None]
    swept.refused["evaluation"] += len(numbers) - len(cases)
    ready = [entry for case in cases if isinstance(entry := prepared(case), Prepared)]
    swept.refused["programs"] += len(cases) - len(ready)
    for way in ways:
        written = [entry for entry in ready if _written(way, entry, swept)]
        with tempfile.TemporaryDirectory() as folder:
            try:
                results = WAYS[way](written, Path(folder))
            except Exception as fault:
                swept.faults.append(f"{way}, {numbers}: {type(fault).__name__}: {fault}")
                continue
        for entry in written:
            why = difference(entry.case, results[entry.case.name], _tolerance(way, entry))
            if why:
                swept.faults.append(f"{way} {entry.case.name}: {why}")
            else:
                swept.agree[way] += 1


def _tolerance(way: str, entry: Prepared) -> float:
    """Shaders' numbers are in single precision, which some that were worked out are not."""
    numbers = np.array([n.value for n in entry.program.tape.nodes if n.op == "const"])
    exact = bool((numbers.astype(np.float32) == numbers).all())
    return TOLERANCE if exact or way not in ("glsl", "wgsl") else SINGLE_TOLERANCE


def _written(way: str, entry: Prepared, swept: Swept) -> bool:
    """Whether a target takes a program; if not, it must say why."""
    try:
        text_of(way, entry)
    except ValueError as refused:
        if any(words in str(refused) for words in REFUSALS):
            swept.refused[way] += 1
        else:
            swept.faults.append(f"{way} {entry.case.name}: {refused}")
        return False
    return True


def text_of(way: str, entry: Prepared) -> dict[str, str]:
    """The files of a program."""
    target, _, strategy = way.partition(" --strategy ")
    if strategy:
        return STRATEGIES[strategy](entry.case.script, entry.program, None)
    return TARGETS[target](entry.program, None)


def main(arguments: list[str] | None = None) -> int:
    """Print a row a target; 1 if a text fails."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.ga.codegen.sweep",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--count", type=int, default=2000, help="texts, of all targets together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--target", choices=list(WAYS), help="this one alone")
    parser.add_argument("--only", type=int, metavar="N", help="this script alone, with its code")
    options = parser.parse_args(arguments)
    ways = [options.target] if options.target else list(WAYS)
    swept = Swept()
    if options.only is not None:
        case = script_case(options.only, options.seed)
        print(case.text, case.refusal, sep="\n")
        entry = prepared(case)
        for way in ways if isinstance(entry, Prepared) else []:
            print("\n".join(text_of(way, entry).values()))
        sweep(range(options.only, options.only + 1), options.seed, ways, swept)
    else:
        printed, number = 0, 0
        while swept.texts < options.count:
            sweep(range(number, number + TOGETHER), options.seed, ways, swept)
            number += TOGETHER
            for fault in swept.faults[printed:]:
                print(fault[:2000], flush=True)
            printed = len(swept.faults)
    print(f"{'written as':<26}{'agree':>8}{'refused':>9}")
    for way in [*ways, "evaluation", "programs"]:
        print(f"{way:<26}{swept.agree[way]:>8}{swept.refused[way]:>9}")
    print(f"{swept.texts} texts, {len(swept.faults)} of them wrong")
    return int(bool(swept.faults))


if __name__ == "__main__":
    sys.exit(main())
