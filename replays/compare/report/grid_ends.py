"""Where a search ended on the first or last value of its grid, and what that means there.

A grid has an end with least smoothing and one with most. Least is asked for where any smoothing
costs more than it takes away, most where the motion is what the method takes for constant: then a
longer grid would be followed further, to little gain.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter

from motorcade.replays.compare.report.names import listed
from motorcade.replays.compare.report.results import REFERENCE, Results

__all__ = ["grid_ends"]

# Parameters that smooth more the larger they are; all others smooth less.
_WIDTHS = ("sigma_s", "window_s", "knot_spacing_s")


def grid_ends(results: Results) -> list[str]:
    """Sentences on what motors asked for with the first degradation, method by method."""
    found = sorted(_found(results), key=itemgetter(0, 1))
    made = []
    for (most, method), rows in groupby(found, key=itemgetter(0, 1)):
        motions = list(dict.fromkeys(motion for _, _, motion in rows))
        named = "every motion" if len(motions) == len(results.motions) else listed(motions)
        made.append(f"`{method}` asks for the {'most' if most else 'least'} smoothing on {named}.")
    return made


def _found(results: Results) -> Iterator[tuple[bool, str, str]]:
    """Whether it is the end with most smoothing, method and motion."""
    for motion in results.motions:
        for (method, representation), row in results.parameters(
            motion, results.degradations[0]
        ).items():
            if representation != REFERENCE or row["how"] != "grid":
                continue
            for grid in results.told["grids"][method]:
                value, values = row["parameters"][grid["parameter"]], grid["values"]
                if value in (values[0], values[-1]):
                    yield (grid["parameter"] in _WIDTHS) == (value == values[-1]), method, motion
