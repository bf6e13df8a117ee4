"""What a run says of its film: where the figure is in view, how large, and what is not sure."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorcade.animation import Placement
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.pipeline.report.film import FilmView, film_of
from motorcade.replays.pipeline.report.words import verdict
from motorcade.replays.stages.characters.acting import character_named
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.view import OverlayVideo, PlacedCharacter
from motorcade.tracking import Camera
from motorcade.tracking.audit import AuditFinding


def test_the_first_tile_is_about_the_film_and_names_what_is_not_sure() -> None:
    path = MOTIONS["handheld"].sampled(rate_hz=10.0, duration_s=1.0)
    checks = (AuditFinding("coverage", "consistent", 0.0, "share", "all have a pose"),)
    findings: Any = SimpleNamespace(
        integrity=Integrity(checks, {}, path, "smoothed"), doubts=("the focal length is a guess",)
    )
    film = FilmView(180, 172, 216.0, 0.2, "the board")
    label = verdict(findings, film).label
    assert label.startswith("The figure stands on the board, in view in 172 of 180 frames, a fifth")
    assert label.endswith("Not sure: the focal length is a guess.")


@pytest.mark.parametrize(
    ("height_share", "words"),
    [
        (0.5, "half of the picture"),
        (0.21, "a fifth of the picture"),
        (0.31, "a third"),
        (0.09, "9 %"),
        (0.95, "as the picture is"),
        (1.4, "more than the picture is"),
    ],
)
def test_sizes_in_words(height_share: float, words: str) -> None:
    assert f", {words}" in FilmView(9, 9, 1.0, height_share, "the floor").sentence


@pytest.mark.parametrize("distortion", [(), (-0.2, 0.05)])
def test_how_much_of_the_figure_a_film_shows_follows_from_where_it_stands(
    distortion: tuple[float, ...],
) -> None:
    """A figure of 1 m on the floor, 4 m ahead of a camera that turns away from it."""
    model: Any = "radtan" if distortion else "pinhole"
    camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5, model, distortion)
    upright = Rotor.from_rotation_vector([-np.pi / 2, 0.0, 0.0])  # looks along y
    away = np.deg2rad([0.0, 10.0, 20.0, 60.0, 90.0])
    turned = Rotor.from_rotation_vector(away[:, None] * [0.0, 0.0, 1.0]) @ upright
    path = Motor.from_rotor_translation(turned, [0.0, 0.0, 0.5])
    who = character_named("mannequin")
    placement = Placement(Motor.from_translation([0.0, 4.0, 0.0]), 1.0 / who.height_m)
    stamps = 100_000_000 * np.arange(len(away))
    drawn = Trajectory(stamps, path, "world", "camera")
    overlay = OverlayVideo(
        Path(), 3, len(away), "the floor", "", "original", "smoothed", (), 480, 0.0
    )
    findings: Any = SimpleNamespace(
        overlay=overlay,
        placed=PlacedCharacter("mannequin", "idle", placement, "the floor"),
        camera_poses=SimpleNamespace(camera=camera),
        recording=SimpleNamespace(frames=SimpleNamespace(time_ns=stamps)),
        integrity=SimpleNamespace(drawn=drawn),
    )
    film = film_of(findings)
    assert film is not None
    assert (film.frames, film.in_view) == (5, 3)
    assert film.height_px == pytest.approx(125.0, rel=0.12)  # 500 px * 1 m / 4 m
