"""Points are matched to corners that lie where they should be and look alike, one to one."""

import numpy as np

from motorcade.tracking.slam.features import Corners
from motorcade.tracking.slam.mapping.matching import alike_where_expected

COUNT = 60


def _bits_changed(descriptors: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """The same descriptors with so many of their 256 bits turned over."""
    bits = np.unpackbits(descriptors, axis=1)
    for row in bits:
        row[rng.choice(256, count, replace=False)] ^= 1
    return np.packbits(bits, axis=1)


def test_every_point_finds_its_corner_and_only_that(rng: np.random.Generator) -> None:
    px = rng.uniform(20.0, 600.0, (COUNT, 2))
    descriptors = rng.integers(0, 256, (COUNT, 32)).astype(np.uint8)
    order = rng.permutation(COUNT)
    near = px[order] + rng.uniform(-3.0, 3.0, (COUNT, 2))
    corners = Corners(near, _bits_changed(descriptors[order], rng, 30))
    points, rows = alike_where_expected(px, descriptors, corners, 4.0)
    assert len(points) == COUNT
    assert np.array_equal(order[rows], points)


def test_what_lies_elsewhere_or_looks_different_is_no_match(rng: np.random.Generator) -> None:
    px = rng.uniform(20.0, 600.0, (COUNT, 2))
    descriptors = rng.integers(0, 256, (COUNT, 32)).astype(np.uint8)
    far = Corners(px + np.array([0.0, 4.5]), descriptors)
    assert not len(alike_where_expected(px[:1], descriptors[:1], far, 4.0)[0])
    other = Corners(px, _bits_changed(descriptors, rng, 90))
    assert not len(alike_where_expected(px, descriptors, other, 4.0)[0])
    none = Corners(np.zeros((0, 2)), np.zeros((0, 32), dtype=np.uint8))
    assert not len(alike_where_expected(px, descriptors, none, 4.0)[0])
    assert not len(alike_where_expected(px[:0], descriptors[:0], other, 4.0)[0])


def test_of_two_rivals_the_more_alike_is_taken(rng: np.random.Generator) -> None:
    descriptor = rng.integers(0, 256, (1, 32)).astype(np.uint8)
    rivals = np.concatenate([_bits_changed(descriptor, rng, bits) for bits in (40, 10, 25)])
    px = np.full((3, 2), 100.0)
    one = px[:1], descriptor, Corners(px, rivals)
    points, rows = alike_where_expected(*one, 4.0)
    assert points.tolist() == [0]
    assert rows.tolist() == [1]
    # And the other way round: of three points one corner belongs to the most alike.
    points, rows = alike_where_expected(px, rivals, Corners(px[:1], descriptor), 4.0)
    assert points.tolist() == [1]
    assert rows.tolist() == [0]
