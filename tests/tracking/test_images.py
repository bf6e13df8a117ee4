"""Corners found again: against OpenCV's flow, and against motions that are known."""

from __future__ import annotations

import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

from motorcade.tracking.images import grey_levels, print_noise_px, track_corners
from motorcade.tracking.native._flow import Pyramid, follow_corners

HEIGHT, WIDTH = 210, 290


@pytest.fixture
def texture(rng: np.random.Generator) -> np.ndarray:
    """Noise of several sizes, larger than an image."""
    layers = [
        cv2.resize(
            rng.normal(0, 1, (330 // s, 410 // s)), (410, 330), interpolation=cv2.INTER_CUBIC
        )
        for s in (6, 12, 30)
    ]
    return np.clip(128 + 35 * sum(layers), 0, 255).astype(np.float32)


def taken(texture: np.ndarray, turn_rad: float, shift_px: tuple[float, float]) -> np.ndarray:
    """An image of the texture, turned about its first pixel and shifted."""
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    rows = np.array([[cosine, -sine, 60 + shift_px[0]], [sine, cosine, 60 + shift_px[1]]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(texture, rows, (WIDTH, HEIGHT), flags=flags).round().astype(np.uint8)


@pytest.fixture
def corners() -> np.ndarray:
    grid = np.meshgrid(np.linspace(30, WIDTH - 30, 12), np.linspace(30, HEIGHT - 30, 8))
    return np.stack(grid, axis=-1).reshape(-1, 2) + 0.3


def by_opencv(before: np.ndarray, after: np.ndarray, px: np.ndarray) -> np.ndarray:
    start = px.astype(np.float32).reshape(-1, 1, 2)
    flags, stop = cv2.OPTFLOW_USE_INITIAL_FLOW, (3, 20, 0.01)
    there, *_ = cv2.calcOpticalFlowPyrLK(
        before, after, start, start.copy(), winSize=(21, 21), maxLevel=3, criteria=stop, flags=flags
    )
    return there[:, 0].astype(np.float64)


@pytest.mark.parametrize(
    ("turn_rad", "shift_px"), [(0.0, (0.0, 0.0)), (0.02, (3.3, -2.7)), (-0.01, (17.5, 11.0))]
)
def test_corners_are_found_where_opencv_finds_them(
    texture: np.ndarray, corners: np.ndarray, turn_rad: float, shift_px: tuple[float, float]
) -> None:
    before, after = taken(texture, 0.0, (0.0, 0.0)), taken(texture, turn_rad, shift_px)
    there, found = track_corners(before, after, corners, corners)
    theirs = by_opencv(before, after, corners)
    assert np.count_nonzero(found) > 0.6 * len(corners)
    assert np.quantile(np.linalg.norm(there - theirs, axis=1)[found], 0.9) < 0.02


def test_corners_are_found_where_the_image_was_moved_to(
    texture: np.ndarray, corners: np.ndarray
) -> None:
    before, after = taken(texture, 0.0, (0.0, 0.0)), taken(texture, 0.0, (5.25, -3.5))
    there, found = track_corners(before, after, corners, corners + 1.0)
    assert np.count_nonzero(found) > 0.9 * len(corners)
    off = np.abs(there - (corners - (5.25, -3.5)))[found]
    assert np.quantile(off, 0.9) < 0.1
    assert np.median(off) < 0.05


def test_pyramids_and_images_give_the_same(texture: np.ndarray, corners: np.ndarray) -> None:
    before, after = taken(texture, 0.0, (0.0, 0.0)), taken(texture, 0.01, (2.0, 1.0))
    one = track_corners(before, after, corners, corners)
    other = track_corners(Pyramid(before), Pyramid(after), corners, corners)
    by_columns = track_corners(np.asfortranarray(before), after, corners, corners)
    for ours, theirs in zip((*one, *one), (*other, *by_columns), strict=True):
        assert np.array_equal(ours, theirs)


def test_any_number_of_threads_finds_the_same(texture: np.ndarray, corners: np.ndarray) -> None:
    before, after = (Pyramid(taken(texture, 0.0, shift)) for shift in ((0.0, 0.0), (2.0, 1.0)))
    px = np.repeat(corners, 3, axis=0)[:250] + np.linspace(0.0, 9.0, 250)[:, None]
    one, *others = (follow_corners(before, after, px, px, 0.7, n) for n in (1, 0, 2, 3, 300))
    for other in others:
        assert np.array_equal(one[0], other[0])
        assert np.array_equal(one[1], other[1])


WITHOUT_THREADS = """
import resource
import numpy as np
from motorcade.tracking.native._flow import Pyramid, follow_corners

image = Pyramid(np.random.default_rng(0).integers(0, 255, (90, 90)).astype(np.uint8))
px = np.random.default_rng(1).uniform(20.0, 70.0, (1280, 2))
expected = follow_corners(image, image, px, px + 0.5, 0.7, 1)
for spare in (1 << 20, 20 << 20):  # less than the stack of one thread, and than those of three
    pages = int(open("/proc/self/statm").read().split()[0])
    most = pages * resource.getpagesize() + spare
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.RLIM_INFINITY))
    made = follow_corners(image, image, px, px + 0.5, 0.7, 20)
    assert all(map(np.array_equal, made, expected))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits and /proc of Linux")
def test_threads_that_cannot_be_made_are_done_without() -> None:
    alone = {**os.environ, "LD_PRELOAD": "", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_THREADS], env=alone, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "start", [(-1e300, 50.0), (50.0, 1e300), (np.nan, 50.0), (np.inf, np.inf), (-25.0, 50.0)]
)
def test_nothing_is_found_outside_an_image(texture: np.ndarray, start: tuple[float, float]) -> None:
    image = taken(texture, 0.0, (0.0, 0.0))
    inside = np.array([[50.0, 50.0], [60.0, 50.0]])
    for px, guess in (
        (np.array([start, inside[1]]), inside),
        (inside, np.array([start, inside[1]])),
    ):
        _, found = track_corners(image, image, px, guess)
        assert not found[0]
        assert found[1]


@pytest.mark.parametrize("shape", [(1, 1), (7, 300), (22, 22), (45, 23)])
def test_nothing_is_found_where_nothing_is_seen(shape: tuple[int, int]) -> None:
    flat = np.full(shape, 90, np.uint8)
    px = np.array([[0.0, 0.0], [shape[1] / 2, shape[0] / 2], [shape[1] - 1.0, shape[0] - 1.0]])
    _, found = track_corners(flat, flat, px, px, border_px=0.0)
    assert not found.any()


def test_beyond_its_edge_an_image_goes_on_as_the_edge(
    texture: np.ndarray, rng: np.random.Generator
) -> None:
    """An image too small for levels, against one that holds what is beyond its edges."""
    before, after = (taken(texture, 0.0, (s, s))[:39, :37] for s in (0.0, 1.5))
    px = rng.uniform(-12.0, 50.0, (600, 2))
    guess = px + rng.normal(0, 4.0, px.shape)
    one, wider = Pyramid(before), Pyramid(np.pad(after, 32, mode="edge"))
    there, _ = follow_corners(one, Pyramid(after), px, guess, 0.7, 1)
    expected, _ = follow_corners(one, wider, px, guess + 32.0, 0.7, 1)
    followed = np.any(there != guess, axis=1)
    window = there[followed] - 10.0
    beyond = np.any((window < 0.0) | (window + 20.0 > np.array([36.0, 38.0])), axis=1)
    assert np.count_nonzero(beyond) > 200
    np.testing.assert_allclose(there[followed], expected[followed] - 32.0, atol=1e-3)


def test_every_place_to_the_edge_can_be_looked_at(rng: np.random.Generator) -> None:
    """Windows reach beyond all edges of all levels; `make sanitize` runs this."""
    noise = rng.integers(0, 255, (61, 47)).astype(np.uint8)
    px = rng.uniform(-22.0, 83.0, (400, 2))
    there, found = track_corners(noise, noise[::-1], px, px + rng.normal(0, 9.0, px.shape))
    assert np.isfinite(there).all()
    assert np.all((there[found] >= 12.0) & (there[found] <= (46.0 - 12.0, 60.0 - 12.0)))


def test_images_that_are_none_are_refused() -> None:
    for shape in ((0, 5), (5, 0), (2, 32768)):
        with pytest.raises(ValueError, match="image: expected 1 to 32767 pixels a side"):
            Pyramid(np.zeros(shape, np.uint8))
    one = np.zeros((30, 30), np.uint8)
    with pytest.raises(ValueError, match="guess: expected one for each"):
        track_corners(one, one, np.zeros((2, 2)), np.zeros((1, 2)))


def test_a_print_of_which_no_square_is_whole_says_nothing_of_blur() -> None:
    """Corners are seen, but no four of a square: `print_noise_px` is asked about nothing."""
    image = np.full((40, 40), 120, np.uint8)
    noise_px, bias_px = print_noise_px([image, image], [np.zeros((0, 4, 2))] * 2, 1.0)
    assert noise_px == bias_px == 0.0
    assert grey_levels(image, np.zeros((0, 2))).shape == (0,)
