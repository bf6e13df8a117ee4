"""`docs/which_smoother.md` and a line of the README, from a finished comparison.

python -m docs.making.guide out/compare   # keep the figures, write both from them
python -m docs.making.guide               # write both from the figures that are kept

What is kept, `which_smoother.json`, is all that the page shows, and the means of one place, which
`tests/replays/compare/test_guide.py` computes again.
"""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.making.guide_tables import (
    COLUMNS,
    choices,
    degradation_rows,
    example,
    method_rows,
    reasons,
    starting_values,
    text_rows,
)
from docs.making.in_short import in_short, shares
from motorcade.fusion.motions import MOTIONS
from motorcade.replays.comparison.plan import SEEDS
from motorcade.replays.comparison.report.matrix import (
    CAUSAL,
    DEGRADATIONS,
    LABELS,
    REPRESENTATIONS,
    best_of_each,
    exact_ties,
)
from motorcade.replays.comparison.report.page import findings
from motorcade.replays.comparison.report.results import REFERENCE, Results, listed, range_ends

__all__ = ["figures", "kept", "main", "page", "readme_line", "with_line"]

_HERE = Path(__file__)
_TEMPLATE, _KEPT = _HERE.with_name("guide.md.jinja"), _HERE.with_name("which_smoother.json")
_DOCS = _HERE.parents[1]
_PAGE, _README = _DOCS / "which_smoother.md", _DOCS.parent / "README.md"
_README_END = "| – | `motorcade compare` |"
_DIGITS = 5


def figures(results: Results) -> dict[str, Any]:
    """All that the page shows, ready for JSON.

    Raises:
        ValueError: a comparison in which nothing could be ranked, or without motors.
    """
    if not results.ranking() or REFERENCE not in results.representations:
        raise ValueError("results: expected a comparison with motors and complete smoothers")
    plan = results.document["plan"]
    found = findings(results)
    recorded = [one["name"] for one in plan.get("recorded", ())]
    return {
        "command": _command(results, recorded),
        "motions": [one for one in results.motions if one not in recorded],
        "recorded": recorded,
        "degradations": {name: DEGRADATIONS[name] for name in results.degradations},
        "labels": {name: LABELS[name] for name in results.degradations},
        "representations": {name: REPRESENTATIONS[name] for name in results.representations},
        "plan": {name: plan[name] for name in _OF_THE_PLAN},
        "in_short": in_short(results),
        "shares": shares(results),
        "choices": choices(results),
        "offline": example(results, False),
        "live": example(results, True),
        "methods": method_rows(results),
        "by_degradation": degradation_rows(results),
        "starts": starting_values(results),
        "reasons": reasons(results),
        "range_ends": range_ends(results),
        "best_of_each": text_rows(best_of_each(results)),
        "at_their_best": found.at_their_best,
        "over_all": found.representations,
        "wins": found.wins,
        "artifacts": found.artifacts,
        "frames": found.frames,
        "cost": found.cost,
        "ties": exact_ties(results),
        "means": _means(results),
    }


def _command(results: Results, recorded: Sequence[str]) -> str:
    """What makes the figures; a file stands for each recorded motion."""
    synthetic = [one for one in results.motions if one not in recorded]
    words = [" ".join(synthetic)] if synthetic != list(MOTIONS) else ["all"] if recorded else []
    words += [f"{name}.csv" for name in recorded]
    seeds = len(results.document["plan"]["test_seeds"])
    made = "motorcade compare" + (" --trajectories " + " ".join(words) if words else "")
    made += f" --seeds {seeds}" if seeds != SEEDS else ""
    return "\n".join(textwrap.wrap(f"{made} --out out/compare", 96, subsequent_indent="    "))


_OF_THE_PLAN = ("methods", "test_seeds", "tuning_seeds", "rate_hz", "duration_s")


def page(kept: Mapping[str, Any]) -> str:
    """The page as Markdown, from what `figures` gave."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["listed"] = listed
    template = environment.from_string(_TEMPLATE.read_text(encoding="utf-8"))
    return template.render(**kept, CAUSAL=CAUSAL)


def readme_line(kept: Mapping[str, Any]) -> str:
    """The README's row on smoothing."""
    shares = kept["shares"]
    beside = (
        f"{shares['best']}, `{shares['method']}` tuned on ground truth; {shares['euler']}, the "
        "same on Euler angles of the best order"
    )
    return (
        "| residual error and jitter that `smooth` leaves of raw poses, told nothing | "
        f"{shares['auto']} | {beside} {_README_END}"
    )


def with_line(readme: str, line: str) -> str:
    """A README with that row in the place of its last one."""
    lines = [line if one.endswith(_README_END) else one for one in readme.splitlines()]
    return "\n".join(lines) + "\n"


def kept() -> dict[str, Any]:
    """The figures that the page shows today."""
    told: dict[str, Any] = json.loads(_KEPT.read_text(encoding="utf-8"))
    return told


def _means(results: Results) -> dict[str, Any]:
    """Mean figures of the first place over all seeds, for a test to compute again."""
    place = (results.motions[0], results.degradations[0])
    rows = [
        [*pair, *(_rounded(results, (*place, *pair, metric)) for metric in COLUMNS[1:])]
        for pair in results.parameters(*place)
    ]
    return {
        "motion": place[0],
        "degradation": place[1],
        "metrics": COLUMNS[1:],
        "rows": rows,
    }


def _rounded(results: Results, key: tuple[str, str, str, str, str]) -> float | None:
    figure = results.figures.get(key)
    return None if figure is None else float(f"{figure.mean:.{_DIGITS}g}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Keep the figures of finished comparisons where some are named; write the page and README."""
    parser = argparse.ArgumentParser(prog="python -m docs.making.guide")
    parser.add_argument("folder", nargs="?", type=Path, help="of a finished `motorcade compare`")
    given = parser.parse_args(arguments)
    if given.folder is not None:
        made = json.dumps(figures(Results.read(given.folder)), indent=0, ensure_ascii=False)
        _KEPT.write_text(made + "\n", encoding="utf-8")
    told = kept()
    _PAGE.write_text(page(told), encoding="utf-8")
    readme = with_line(_README.read_text(encoding="utf-8"), readme_line(told))
    _README.write_text(readme, encoding="utf-8")


if __name__ == "__main__":
    main()
