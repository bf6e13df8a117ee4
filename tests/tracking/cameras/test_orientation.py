"""Turned cameras: exactly where turned images have what the camera saw."""

import numpy as np
import pytest

from motorcade.tracking import Camera
from motorcade.tracking.cameras.camera import (
    ImageOrientation,
    camera_T_turned,
    turned_camera,
)
from tests.tracking.cameras.test_camera import CAMERAS, in_view, name

every_camera = pytest.mark.parametrize("camera", CAMERAS, ids=name)


@every_camera
@pytest.mark.parametrize("turns", range(-1, 5))
def test_a_turned_camera_sees_points_where_the_turned_image_has_them(
    camera: Camera, turns: int
) -> None:
    points = in_view(camera, (200,))
    turned = turned_camera(camera, turns)
    seen = turned.project(camera_T_turned(turns).inverse().apply(points))
    # The witness turns numbered pixels: each pixel's own place travels with it.
    rows, columns = np.indices((camera.height, camera.width))
    places = np.rot90(np.stack([columns, rows], axis=-1), -turns)
    assert (turned.height, turned.width) == places.shape[:2]
    back = np.stack(
        [np.interp(seen[:, k], np.arange(size), line) for k, size, line in _lines(places)], axis=-1
    )
    expected = camera.project(points)
    swapped = back[:, ::-1] if turns % 2 else back
    np.testing.assert_allclose(swapped, expected, atol=1e-9)


def _lines(places: np.ndarray) -> list[tuple[int, int, np.ndarray]]:
    """Along columns and along rows: which coordinate of the stored pixel changes, and how."""
    across, down = places[0], places[:, 0]
    which = int(np.ptp(across[:, 0]) == 0)
    return [(0, len(across), across[:, which]), (1, len(down), down[:, 1 - which])]


@every_camera
def test_four_quarter_turns_are_none(camera: Camera) -> None:
    again = turned_camera(turned_camera(camera, 3), 1)
    assert again.distortion == camera.distortion
    assert (again.width, again.fx) == (camera.width, camera.fx)
    np.testing.assert_allclose((again.cx, again.cy), (camera.cx, camera.cy), atol=1e-12)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("turns", range(4))
def test_the_matrix_says_where_pixels_go(turns: int, mirrored: bool) -> None:
    orientation = ImageOrientation(turns, mirrored)
    image = np.zeros((5, 7), np.uint8)
    image[2, 3] = 1  # the middle stays
    image[2 + 1, 3 + 2] = 2  # two to the right of it, one down
    upright = orientation.upright(image)
    assert orientation.size((7, 5)) == upright.shape[::-1]
    middle, other = (np.argwhere(upright == value)[0][::-1] for value in (1, 2))
    assert (other - middle).tolist() == (orientation.matrix @ [2, 1]).tolist()


def test_other_turns_are_refused() -> None:
    with pytest.raises(ValueError, match="quarter_turns: expected 0 to 3, got 4"):
        ImageOrientation(4)
