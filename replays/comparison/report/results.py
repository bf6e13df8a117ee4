"""A finished comparison, read back from its folder; where its searches ended in their ranges."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from motorcade.ga.files import read_bounded
from motorcade.replays.comparison.statistics import PRACTICAL_SHARE
from motorcade.replays.comparison.tables import FORMAT

MAX_FILE_BYTES = 1 << 26

REFERENCE = "motor"
"""The representation that the tables hold all others against."""


class Figure(NamedTuple):
    """A metric of one method and representation in one place, NaN or "" where there is none.

    Mean over seeds with the ends of its interval, the difference of its cost from the same method
    on motors, and the verdict on that.
    """

    mean: float
    low: float
    high: float
    versus_motor: float
    verdict: str


class Ratio(NamedTuple):
    """A ratio with the ends of its interval; NaN where there is no interval."""

    value: float
    low: float
    high: float


def tied(ratio: Ratio) -> bool:
    """Whether a ratio is 1 for all that can be said: interval around 1, or 1 % from it at most."""
    return ratio.low <= 1.0 <= ratio.high or abs(ratio.value - 1.0) <= PRACTICAL_SHARE


Pair = tuple[str, str]
Key = tuple[str, str, str, str, str]


@dataclass(frozen=True, eq=False)
class Results:
    """What a comparison found.

    Fields:
        document: all of ``results.json``.
        figures: ``groups.csv`` by (motion, degradation, method, representation, metric).

    >>> from motorcade.replays.comparison.report.results import Results
    >>> plan = {"motions": ["handheld", "screw"], "degradations": ["gaussian"]}
    >>> results = Results({"plan": plan}, figures={})  # `read` fills both from a folder
    >>> results.places("motion:screw"), results.drawn_from
    ([('screw', 'gaussian')], 'seeds')
    """

    document: Mapping[str, Any]
    figures: Mapping[Key, Figure]

    @classmethod
    def read(cls, folder: Path) -> Results:
        """Read the folder of a comparison.

        Raises:
            FileError: a file that is missing or cannot be read.
            ValueError: a ``results.json`` of another format.
        """
        path = folder / "results.json"
        document = json.loads(read_bounded(path, MAX_FILE_BYTES))
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise ValueError(f"{path}: expected format {FORMAT!r}")
        groups = read_bounded(folder / "groups.csv", MAX_FILE_BYTES).decode("utf-8")
        rows = csv.DictReader(io.StringIO(groups, newline=""))
        figures = {_key(row): _figure(row) for row in rows}
        return cls(document, figures)

    @property
    def drawn_from(self) -> str:
        """What intervals are drawn from: "seeds", or "blocks" of a recording."""
        return "blocks" if "blocks" in self.document["plan"] else "seeds"

    @property
    def motions(self) -> list[str]:
        """As the plan lists them."""
        return list(self.document["plan"]["motions"])

    @property
    def degradations(self) -> list[str]:
        """As the plan lists them."""
        return list(self.document["plan"]["degradations"])

    @property
    def methods(self) -> list[str]:
        """As the plan lists them."""
        return list(self.document["plan"]["methods"])

    @property
    def representations(self) -> list[str]:
        """As the plan lists them."""
        return list(self.document["plan"]["representations"])

    def places(self, scope: str = "all") -> list[Pair]:
        """Motions and degradations of a scope: "all", "motion:NAME" or "degradation:NAME"."""
        kind, _, name = scope.partition(":")
        return [
            (motion, degradation)
            for motion in self.motions
            for degradation in self.degradations
            if kind == "all" or name == (motion if kind == "motion" else degradation)
        ]

    def ranking(self, scope: str = "all", metric: str = "score") -> Sequence[Mapping[str, Any]]:
        """Rows of a ranking, best first; none where nothing was complete."""
        for table in self.document["rankings"]:
            if table["scope"] == scope and table["metric"] == metric:
                return list(table["rows"])
        return []

    def unranked(self) -> list[Pair]:
        """Methods and representations without a result in every cell."""
        of_all = [ranking for ranking in self.document["rankings"] if ranking["scope"] == "all"]
        return [(method, name) for ranking in of_all[:1] for method, name in ranking["unranked"]]

    def ratio_to_raw(self, scope: str, metric: str) -> dict[Pair, Ratio]:
        """What is left of the raw poses' error, by method and representation."""
        return {
            (row["method"], row["representation"]): _ratio(row, "ratio_to_raw")
            for row in self.ranking(scope, metric)
        }

    def ratio_to_motor(self, scope: str, metric: str) -> dict[Pair, Ratio]:
        """Times what motors leave, by method ("all": over the complete ones) and representation."""
        return {
            (row["method"], row["representation"]): _ratio(row, "ratio_to_motor")
            for row in self.document["ratios_to_motor"]
            if row["scope"] == scope and row["metric"] == metric
        }

    def best_ratio(self, scope: str, representation: str) -> tuple[Ratio, str] | None:
        """What a representation leaves with the method that serves it best, and that method."""
        for row in self.ranking(scope):
            if row["representation"] == representation:
                return _ratio(row, "ratio_to_raw"), str(row["method"])
        return None

    def does_nothing(self, pair: Pair) -> bool:
        """Whether a smoother left all of the first place's poses as they were."""
        place = (self.motions[0], self.degradations[0])
        ours = self.figures.get((*place, *pair, "ape_rmse_m"))
        raw = self.figures.get((*place, "raw", "none", "ape_rmse_m"))
        return ours is not None and raw is not None and ours.mean == raw.mean

    def mean_size(self, scope: str, pair: Pair, metric: str) -> float:
        """Mean over a scope's places of a metric's size; NaN unless it is known in half of them."""
        places = self.places(scope)
        sizes = [
            abs(figure.mean)
            for place in places
            if (figure := self.figures.get((*place, *pair, metric))) is not None
            and math.isfinite(figure.mean)
        ]
        return sum(sizes) / len(sizes) if sizes and 2 * len(sizes) >= len(places) else math.nan

    def parameters(self, motion: str, degradation: str) -> dict[Pair, Mapping[str, Any]]:
        """Rows of what was found for a place, by method and representation."""
        return {
            (row["method"], row["representation"]): row
            for row in self.document["parameters"]
            if row["motion"] == motion and row["degradation"] == degradation
        }


def _key(row: Mapping[str, str]) -> Key:
    return (row["motion"], row["degradation"], row["method"], row["representation"], row["metric"])


def _figure(row: Mapping[str, str]) -> Figure:
    return Figure(
        _number(row["mean"]),
        _number(row["low"]),
        _number(row["high"]),
        _number(row["versus_motor"]),
        row["verdict"],
    )


def _number(text: str) -> float:
    return float(text) if text else math.nan


def _ratio(row: Mapping[str, Any], key: str) -> Ratio:
    values = (row[key], row["ratio_low"], row["ratio_high"])
    return Ratio(*(math.nan if value is None else float(value) for value in values))


# Parameters that smooth more the larger they are; all others smooth less.
_WIDTHS = ("sigma_s", "window_s", "knot_spacing_s")
# Share of a range, in logarithms, within which a search ended at its end.
_AT_AN_END = 0.03


def listed(names: list[str]) -> str:
    """``a, b and c``."""
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]


def range_ends(results: Results) -> list[str]:
    """Sentences on what motors asked for with the first degradation, method by method.

    A range has an end with least smoothing and one with most. Least is asked for where any costs
    more than it takes away, most where the motion is what the method takes for constant: then a
    longer range would be followed further, to little gain.
    """
    facts = sorted(_range_ends(results), key=itemgetter(0, 1))
    sentences = []
    for (most, method), rows in groupby(facts, key=itemgetter(0, 1)):
        motions = list(dict.fromkeys(motion for _, _, motion in rows))
        named = "every motion" if len(motions) == len(results.motions) else listed(motions)
        sentences.append(
            f"`{method}` asks for the {'most' if most else 'least'} smoothing on {named}."
        )
    return sentences


def _range_ends(results: Results) -> Iterator[tuple[bool, str, str]]:
    """Whether it is the end with most smoothing, method and motion."""
    for motion in results.motions:
        for (method, representation), row in results.parameters(
            motion, results.degradations[0]
        ).items():
            if representation != REFERENCE or row["how"] != "search":
                continue
            for searched in results.document["ranges"][method]:
                value = row["parameters"][searched["parameter"]]
                place = math.log(value / searched["low"]) / math.log(
                    searched["high"] / searched["low"]
                )
                if not _AT_AN_END < place < 1.0 - _AT_AN_END:
                    yield (searched["parameter"] in _WIDTHS) == (place > 0.5), method, motion
