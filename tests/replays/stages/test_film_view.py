"""What a run says of its film: where the figure is in view, how large, and what is not sure."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.replays.pipeline.report.film import FilmView, film_of
from motorcade.replays.pipeline.report.summary import verdict
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.view import FigureCheck, OverlayVideo
from motorcade.tracking.audit import AuditFinding


def test_the_first_tile_is_about_the_film_and_names_what_is_not_sure() -> None:
    path = MOTIONS["handheld"].sampled(rate_hz=10.0, duration_s=1.0)
    checks = (AuditFinding("coverage", "consistent", 0.0, "share", "all have a pose"),)
    findings: Any = SimpleNamespace(
        integrity=Integrity(checks, {}, path, "smoothed"),
        doubts=("the focal length is a guess",),
        recording=SimpleNamespace(people="none"),
    )
    film = FilmView(180, 172, 216.0, 0.2, "the board")
    label = verdict(findings, film).label
    assert label.startswith("The figure stands on the board, in view in 172 of 180 frames, a fifth")
    assert label.endswith("Not sure: the focal length is a guess.")


@pytest.mark.parametrize(
    ("height_share", "words"),
    [
        (0.5, "half of the image"),
        (0.21, "a fifth of the image"),
        (0.31, "a third"),
        (0.09, "9 %"),
        (0.95, "as the image is"),
        (1.4, "more than the image is"),
    ],
)
def test_sizes_in_words(height_share: float, words: str) -> None:
    assert f", {words}" in FilmView(9, 9, 1.0, height_share, "the floor").sentence


def check_of(visible_px: list[float], height_px: list[float]) -> FigureCheck:
    """A figure seen as these numbers of pixels say; NaN where there is no pose."""
    seen, high = np.array(visible_px), np.array(height_px)
    return FigureCheck(
        "visitor", seen, seen, np.ones_like(seen), high, 0.0 * seen, seen * np.nan, 0.0
    )


def film_with(*checks: FigureCheck) -> FilmView:
    overlay = OverlayVideo(Path(), 6, 6, "the floor", "", "original", "smoothed", checks, 480, 0.0)
    findings: Any = SimpleNamespace(overlay=overlay)
    film = film_of(findings)
    assert film is not None
    return film


def test_frames_in_view_are_those_in_which_pixels_of_the_figure_are_seen() -> None:
    """Behind the board it is drawn, and not seen; without a pose it is not drawn."""
    hidden_at_first = check_of(
        [0.0, 0.4, 50.0, 900.0, 1000.0, np.nan], [90.0, 90.0, 95.0, 96.0, 97.0, np.nan]
    )
    film = film_with(hidden_at_first)
    assert (film.frames, film.in_view, film.height_px) == (6, 3, 96.0)
    assert (
        film.sentence
        == "the figure stands on the floor, in view in 3 of 6 frames, a fifth of the image high"
    )


def test_of_several_figures_one_in_view_is_enough() -> None:
    film = film_with(
        check_of([9.0, 0, 0, 0, 0, 0], [9.0] * 6), check_of([0, 0, 0, 7.0, 0, 0], [9.0] * 6)
    )
    assert (film.in_view, film.height_px) == (2, None)
    assert film_with(check_of([0.0] * 6, [0.0] * 6)).in_view == 0
