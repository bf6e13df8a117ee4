"""Clips taken apart: cuts and black frames are found, and what a camera does is named."""

import cv2
import numpy as np
import pytest

from motorcade.tracking.shots import find_shots
from motorcade.tracking.shots.rotation import track_rotation
from tests.end_to_end.shots import FOCAL, KINDS, SIZE, draw, turning
from tests.tracking.self_calibration.clips import Camera


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_clip_is_named(kind: str) -> None:
    images, expected = draw(kind, seed=7)
    assert expected.fault(find_shots(images)) == ""


def blobs(seed: int) -> np.ndarray:
    """An image of grey blobs."""
    noise = np.random.default_rng(seed).normal(0.0, 1.0, (180, 320)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 3.0)
    return np.clip(128.0 + 50.0 * smooth / smooth.std(), 0, 255).astype(np.uint8)


def test_a_cut_and_black_frames_are_left_between_shots() -> None:
    black = np.full((180, 320), 5, np.uint8)
    shots = find_shots([black] * 5 + [blobs(1)] * 10 + [blobs(2)] * 12)
    assert [(each.first, each.last) for each in shots.shots] == [(5, 14), (15, 26)]
    assert [each.kind for each in shots.breaks] == ["black"]
    assert shots.longest == 1
    assert not shots.whole


def test_a_flash_and_a_step_of_exposure_are_no_cuts() -> None:
    scene = blobs(3)
    flash = np.full_like(scene, 250)
    shots = find_shots([scene] * 10 + [flash] + [scene] * 10 + [scene // 2] * 10)
    assert [(each.first, each.last) for each in shots.shots] == [(0, 9), (11, 30)] or shots.whole


def test_photographs_are_no_film() -> None:
    shots = find_shots([blobs(seed) for seed in range(12)])
    assert shots.whole
    assert shots.shots[0].motion.kind == "unknown"


def test_black_images_have_no_shot() -> None:
    assert find_shots([np.zeros((48, 64), np.uint8)] * 20).shots == ()


def test_images_taken_in_poor_light_are_not_black() -> None:
    """A black frame shows nothing but noise; a dim scene has contrast, however dark it is."""
    dim = [(16 + (blobs(4) // 11)).astype(np.uint8)] * 10
    assert max(int(one.max()) for one in dim) < 40
    assert find_shots(dim).whole


@pytest.mark.slow
def test_the_attitudes_of_a_turning_camera_come_back() -> None:
    count = 40
    images = [
        np.clip(one, 0, 255).astype(np.uint8) for one in turning(np.random.default_rng(5), count)
    ]
    middle = 0.5 * (np.array(SIZE) - 1.0)
    found = track_rotation(images, Camera(*SIZE, FOCAL, FOCAL, *middle), held=False)
    assert len(found.known) == count
    cosine = (np.trace(found.first_R_camera[-1]) - 1.0) / 2.0
    assert np.arccos(cosine) == pytest.approx(0.005 * (count - 1), rel=0.05, abs=0.01)
