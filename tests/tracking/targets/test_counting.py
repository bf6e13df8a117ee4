"""Boards that are counted in drawn scenes, whatever lies beside or upon them."""

import pytest

from motorcade.tracking.targets.chessboards import checkerboard_seen
from tests.tracking.targets.counting import BOARDS, TEXTURES, count_drawn, drawn_scene


def test_a_board_is_counted_with_lines_beside_it() -> None:
    size, counted, images = count_drawn("lines beside", 101)
    assert counted == size
    assert images >= 6


@pytest.mark.slow
@pytest.mark.parametrize("seed", [211, 212, 213])
@pytest.mark.parametrize("kind", BOARDS)
def test_a_board_is_counted(kind: str, seed: int) -> None:
    size, counted, _ = count_drawn(kind, seed)
    assert counted == size


@pytest.mark.slow
@pytest.mark.parametrize("seed", [211, 212, 213])
@pytest.mark.parametrize("kind", TEXTURES)
def test_a_texture_holds_no_board(kind: str, seed: int) -> None:
    assert count_drawn(kind, seed) == (None, None, 0)


def test_a_board_of_which_no_image_shows_all_sides_is_the_least_that_it_can_be() -> None:
    images, size = drawn_scene("head on", 105)
    assert size is not None
    counted = checkerboard_seen([image[:, 330:] for image in images[:4]])
    assert counted is None or not counted.ends
