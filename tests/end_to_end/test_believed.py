"""Runs that were confident and wrong once: right now, or doubted by name."""

import pytest

from tests.end_to_end.believed import judged


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("charuco.rolling.1000", "the board's views say"),  # read upwards, stated downwards
        ("loose.moved.1001", "do not stand still"),  # two slide: 0.3 m, at 0.7 px
        ("marker.rolling.9102035", ""),  # a read-out that nobody states, and four corners hide
        ("marker.noisy.2000", ""),  # surer of itself than four corners allow
        ("checkerboard.shuffled.7", ""),
        ("grid.blurred.4410000", ""),  # blur draws corners aside, by more than noise lets them
        ("loose.hidden.9204003", ""),  # half a tag, alone in its frame
        ("charuco.hidden.31101000", ""),  # a corner half hidden, and one that is not there
        ("loose.moved.31103000", ""),  # one slides in a single frame, then is hidden
        ("loose.doubled.71001", ""),  # tags of nine pixels: their map's scale is no surer
    ],
)
def test_a_drawn_run_is_right_and_says_what_it_denies(name: str, said: str) -> None:
    outcome = judged(name)
    assert outcome.right
    assert bool(outcome.doubts) == bool(said)
    assert all(said in doubt for doubt in outcome.doubts)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["grid.doubled.4410000", "loose.doubled.5521002"])
def test_ids_that_stand_there_twice_are_named(name: str) -> None:
    assert any("twice" in doubt for doubt in judged(name).doubts)
