"""Two runs of the benchmarks beside each other, figure by figure: what a change did to them.

    make bench SUITE=tracking JSON=before.json        (then again after the change)
    python -m tests.bench.beside before.json after.json [--share 0.01]

Printed are the figures that differ by more than `share` of the larger one, and those that only one
run has; the last line counts all that were compared. Rows of a table are matched by their place.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ABOUT = ("machine", "runs")
"""Keys beside the suites that hold no figures of theirs."""


def figures(tree: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a JSON tree with the path that leads to it."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            if path or key not in ABOUT:
                yield from figures(value, f"{path}/{key}")
    elif isinstance(tree, list):
        for place, value in enumerate(tree):
            yield from figures(value, f"{path}[{place}]")
    elif isinstance(tree, int | float) and not isinstance(tree, bool):
        yield path, float(tree)


def differ(before: float, after: float, share: float) -> bool:
    """Whether two figures are further apart than that share of the larger one."""
    if before != before or after != after:
        return (before != before) != (after != after)
    return abs(after - before) > share * max(abs(before), abs(after))


def table(before: dict[str, float], after: dict[str, float], share: float) -> Iterator[str]:
    """A line a figure that differs or is missing on one side."""
    for name in (*before, *(name for name in after if name not in before)):
        old, new = before.get(name), after.get(name)
        if old is None or new is None:
            yield f"{name}  only {'after' if old is None else 'before'}"
        elif differ(old, new, share):
            ratio = f"{new / old:8.3f}" if old else "     new"
            yield f"{old:14.6g} {new:14.6g} {ratio}  {name}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--share", type=float, default=0.01)
    given = parser.parse_args()
    before, after = (
        dict(figures(json.loads(path.read_text()))) for path in (given.before, given.after)
    )
    lines = list(table(before, after, given.share))
    print("\n".join(lines))
    print(f"{len(before.keys() & after.keys())} figures compared, {len(lines)} lines above")


if __name__ == "__main__":
    main()
