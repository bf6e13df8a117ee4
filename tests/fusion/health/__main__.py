"""A table of faults and recordings: which fault the verdict names on which recording.

`python -m tests.fusion.health [--extrinsics askew|quarter] [--seeds N] [--lines]`
"""

from __future__ import annotations

import argparse
import sys

from tests.bench.data import data_folder
from tests.fusion.health.cases import EXTRINSICS, FAULTS, FLIGHTS, Case, checked, flown, simulated

MOTIONS = ("handheld", "walk_and_look", "stop_and_go", "gimbal_hover", "tumble")


def main() -> int:
    """Print the table; 1 where a fault goes unnamed or a sound recording raises one.

    A fault is "untold" where the verdict says that the motion does not show so much.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--extrinsics", choices=EXTRINSICS, default="askew")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--lines", action="store_true", help="print each verdict in full")
    options = parser.parse_args()
    missed = 0
    for seed in range(options.seeds):
        cases = {name: flown(name, data_folder(), options.extrinsics, seed) for name in FLIGHTS}
        cases |= {name: simulated(name, options.extrinsics, seed) for name in MOTIONS}
        missed += _table(cases, lines=options.lines)
    print(f"{missed} of {options.seeds * (len(FAULTS) + 1) * (len(FLIGHTS) + len(MOTIONS))} missed")
    return int(missed > 0)


def _table(cases: dict[str, Case], *, lines: bool) -> int:
    names = list(cases)
    print(f"{'':<34}" + "".join(f"{name:>15}" for name in names))
    missed = 0
    for fault in ("none", *FAULTS):
        row = []
        for number, name in enumerate(names):
            found, right = checked(fault, cases[name], cases[names[number - 1]])
            missed += not right
            told = ", ".join(found.faults) or ("untold" if right and fault != "none" else "sound")
            row.append("named" if right and found.faults else told)
            if lines:
                print(f"{fault} | {name} | {found.summary}")
        print(f"{fault:<34}" + "".join(f"{one:>15}" for one in row), flush=True)
    return missed


if __name__ == "__main__":
    sys.exit(main())
