"""Random scripts in six algebras, computed by clifford and in every target.

    python -m tests.ga.programs --programs 1000 --seed 1

A row a target: how many scripts agree by blade with clifford. Ends with 1 where one does not.
"""

from __future__ import annotations

import argparse
import sys

from tests.ga.gaalop.__main__ import differences
from tests.ga.programs.random_scripts import ALGEBRAS, random_cases


def main(arguments: list[str] | None = None) -> int:
    """Print the table; 1 if anything disagrees."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.ga.programs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--programs", type=int, default=1000, help="in all algebras together")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args(arguments)
    count = -(-given.programs // len(ALGEBRAS))
    cases = [case for name in ALGEBRAS for case in random_cases(name, count, given.seed)]
    failed = False
    for target, told in differences(cases):
        failed = failed or bool(told)
        print(f"{target:<24}{len(cases) - len(told):>6} of {len(cases)}", flush=True)
        for name, why in told.items():
            print(f"    {name}: {why}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
