"""Everything that can be compared has a name, and ties are what their intervals say."""

import math

import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES
from motorcade.render.plots.style import COLOURS
from motorcade.replays.comparison.evaluator import METRICS as RULER_METRICS
from motorcade.replays.comparison.plan import DEGRADATIONS
from motorcade.replays.comparison.report import matrix
from motorcade.replays.comparison.report.results import Ratio, tied


@pytest.mark.parametrize(
    ("ratio", "tie"),
    [
        (Ratio(1.005, 1.004, 1.006), True),
        (Ratio(1.3, 0.9, 1.5), True),
        (Ratio(1.3, 1.2, 1.5), False),
        (Ratio(0.98, 0.97, 0.985), False),
        (Ratio(1.02, math.nan, math.nan), False),
    ],
)
def test_ties(ratio: Ratio, tie: bool) -> None:
    assert tied(ratio) == tie


def test_everything_that_can_be_compared_has_a_name_and_a_line() -> None:
    assert set(matrix.METHODS) == set(METHODS)
    assert set(matrix.REPRESENTATIONS) == set(REPRESENTATION_NAMES)
    assert set(matrix.MOTIONS) == set(MOTIONS)
    assert set(matrix.DEGRADATIONS) == set(matrix.LABELS) == {*DEGRADATIONS, "recorded"}
    assert set(matrix.METRICS) == {"score", *RULER_METRICS}
    assert set(matrix.CAUSAL) == {name for name, line in matrix.METHODS.items() if "causal" in line}
    assert set(COLOURS) >= set(REPRESENTATION_NAMES)
