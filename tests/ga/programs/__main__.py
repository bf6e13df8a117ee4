"""Random scripts in six algebras, computed by clifford and in every target.

    python -m tests.ga.programs --programs 1000 --seed 1
    python -m tests.ga.programs --programs 1000 --language

A row a target: how many scripts agree by blade with clifford. `--language` takes scripts of the
whole language in all eleven algebras, which a second reading of its page computes. Ends with 1
where one does not agree.
"""

from __future__ import annotations

import argparse
import sys

from tests.ga.gaalop.__main__ import differences
from tests.ga.programs.grammar import VOLUMES, grammar_cases
from tests.ga.programs.random_scripts import ALGEBRAS, random_cases

# What a strategy says of algebras that it does not have.
TOO_LARGE = "strategy table: expected at most"


def main(arguments: list[str] | None = None) -> int:
    """Print the table; 1 if anything disagrees."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.ga.programs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--programs", type=int, default=1000, help="in all algebras together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--language", action="store_true", help="the whole of it, all algebras")
    given = parser.parse_args(arguments)
    names, made = (VOLUMES, grammar_cases) if given.language else (ALGEBRAS, random_cases)
    count = -(-given.programs // len(names))
    cases = [case for name in names for case in made(name, count, given.seed)]
    failed = False
    for target, everything in differences(cases):
        told = {name: why for name, why in everything.items() if not why.startswith(TOO_LARGE)}
        failed = failed or bool(told)
        print(f"{target:<24}{len(cases) - len(told):>6} of {len(cases)}", flush=True)
        for name, why in told.items():
            print(f"    {name}: {why}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
