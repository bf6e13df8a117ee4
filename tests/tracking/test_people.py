"""People are tracked through gaps of the nets and back, believed on evidence, dropped in doubt.

A stand-in plays the nets: what is red in an image is a person to it.
"""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from motorcade.tracking.people import SeenPerson, find_people, overlap

HEIGHT, WIDTH, COUNT = 120, 200, 24
Image = np.ndarray


class RedPeople:
    """Scores of the red things in each image, by its number; sees them in squares about them."""

    def __init__(self, scores: Callable[[int], Sequence[float]], presence: float = 1.0) -> None:
        self.scores, self.presence, self.looked = scores, presence, [-1]

    def detect(self, image: Image) -> list[tuple[float, Image]]:
        number = int(image[0, 0, 2])
        self.looked.append(number)
        return [
            (score, _body(_red(image, side)))
            for side, score in enumerate(self.scores(number))
            if score > 0.0
        ]

    def segment(self, image: Image, body_px: Image) -> SeenPerson:
        reach = 1.25 * np.hypot(*(body_px[1] - body_px[0]))
        rows, columns = np.indices(image.shape[:2])
        near = np.maximum(abs(columns - body_px[0, 0]), abs(rows - body_px[0, 1])) < reach
        mask = np.where(near & (image[..., 0] > 200), 255, 0).astype(np.uint8)
        seen = bool(mask.any())
        return SeenPerson(self.presence * seen, mask, _body(mask) if seen else body_px)


def _red(image: Image, side: int) -> Image:
    """The red of an image's left or right half."""
    mask = np.where(image[..., 0] > 200, 255, 0).astype(np.uint8)
    mask[:, (0, WIDTH // 2)[1 - side] : (WIDTH // 2, WIDTH)[1 - side]] = 0
    return mask


def _body(mask: Image) -> Image:
    rows, columns = np.nonzero(mask)
    middle = np.array([columns.mean(), rows.mean()])
    return np.stack([middle, middle - [0.0, np.ptp(rows)]])


def drawn(size: int = 40, *, second: bool = False) -> tuple[list[Image], list[Image]]:
    """Images of somebody who walks by, with what is drawn of them; number in the third channel."""
    noise = np.random.default_rng(3).integers(0, 90, (HEIGHT, WIDTH, 3)).astype(np.uint8)
    images, masks = [], []
    for number in range(COUNT):
        image, mask = noise.copy(), np.zeros((HEIGHT, WIDTH), np.uint8)
        mask[20 : 20 + 2 * size, 10 + number : 10 + number + size] = 255
        if second:
            mask[60:100, 150 - number : 170 - number] = 255
        image[mask > 0] = [255, 0, 0]
        image[:, :, 2] = np.where(mask > 0, 0, image[:, :, 2])
        image[0, 0] = [0, 0, number]
        images.append(image)
        masks.append(mask)
    return images, masks


def masks_of(images: list[Image], nets: RedPeople) -> list[Image | None]:
    return list(find_people(images, nets.detect, nets.segment))


def test_who_is_found_twice_is_masked_before_between_and_after() -> None:
    images, drawn_masks = drawn()
    nets = RedPeople(lambda number: [0.9 if number in (8, 16) else 0.0])
    for mask, own in zip(masks_of(images, nets), drawn_masks, strict=True):
        assert mask is not None
        np.testing.assert_array_equal(mask, own)
    assert nets.looked[1:4] == [0, 4, 8]  # nobody is tracked
    assert set(np.diff(nets.looked[3:])) == {2}


@pytest.mark.parametrize(
    ("scores", "presence"),
    [
        ({8: 0.95}, 1.0),
        (dict.fromkeys(range(0, COUNT, 2), 0.7), 1.0),
        ({8: 0.9, 16: 0.9}, 0.8),
        ({8: 0.3, 16: 0.3}, 1.0),
    ],
    ids=["once", "never surely", "hardly there", "low"],
)
def test_who_is_not_believed_is_not_masked(scores: dict[int, float], presence: float) -> None:
    nets = RedPeople(lambda number: [scores.get(number, 0.0)], presence)
    assert masks_of(drawn()[0], nets) == [None] * COUNT


def test_two_people_are_two_tracks_and_one_mask() -> None:
    images, drawn_masks = drawn(30, second=True)
    masks = masks_of(images, RedPeople(lambda number: [0.9, 0.85]))
    assert all(overlap(mask, own) == 1.0 for mask, own in zip(masks, drawn_masks, strict=True))


def test_a_mask_of_more_than_half_the_image_is_none() -> None:
    images, _ = drawn(20)
    for image in images[10:]:
        image[:, :150] = [255, 0, 0]
        image[0, 0] = [0, 0, 12]
    masks = masks_of(images, RedPeople(lambda number: [0.9]))
    assert all(mask is not None for mask in masks[:10])
    assert masks[11:] == [None] * (COUNT - 11)


def test_without_images_nobody_is_found() -> None:
    assert masks_of([], RedPeople(lambda number: [])) == []


def test_images_are_looked_at_in_colour_and_small() -> None:
    grey = [np.full((720, 1280), 80, np.uint8)]
    looked = []

    def detect(image: Image) -> list[tuple[float, Image]]:
        looked.append(image.shape)
        return []

    assert list(find_people(grey, detect, RedPeople(lambda number: []).segment)) == [None]
    assert looked == [(360, 640, 3)]
