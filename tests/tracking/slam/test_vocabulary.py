"""Keyframes are found by the words that they share with an image."""

import numpy as np

from motorcade.tracking.slam.mapping.map import KeyframeIndex, Vocabulary

SEEN, COUNT = 200, 50


def _noisy(descriptors: np.ndarray, rng: np.random.Generator, share: float) -> np.ndarray:
    bits = np.unpackbits(descriptors, axis=1)
    bits ^= (rng.random(bits.shape) < share).astype(np.uint8)
    return np.packbits(bits, axis=1)


def _scenes(rng: np.random.Generator) -> list[np.ndarray]:
    """Descriptors of scenes with nothing in common but the kinds of corners that there are."""
    kinds = rng.integers(0, 256, (300, 32)).astype(np.uint8)
    return [_noisy(kinds[rng.integers(0, 300, SEEN)], rng, 0.12) for _ in range(COUNT)]


def test_the_keyframe_that_shows_the_same_comes_first(rng: np.random.Generator) -> None:
    scenes, index = _scenes(rng), KeyframeIndex()
    for scene in scenes:
        index.add(scene)
    every = np.arange(COUNT)
    for row in range(0, COUNT, 7):
        again = _noisy(scenes[row][20:], rng, 0.04)
        assert index.alike(again, every, 3)[0] == row
        others = np.delete(every, row)
        assert row not in index.alike(again, others, 3)


def test_before_there_are_words_the_newest_come_first(rng: np.random.Generator) -> None:
    index = KeyframeIndex()
    for scene in _scenes(rng)[:5]:
        index.add(scene)
    assert index.alike(_scenes(rng)[0], np.arange(5), 3).tolist() == [4, 3, 2]


def test_words_are_learnt_once_a_keyframe_shows_something(rng: np.random.Generator) -> None:
    scenes, index = _scenes(rng), KeyframeIndex()
    for _ in range(9):
        index.add(scenes[0][:0])
    assert index.alike(scenes[0], np.arange(9), 2).tolist() == [8, 7]
    for scene in scenes[:3]:
        index.add(scene)
    assert index.alike(scenes[0], np.arange(12), 1).tolist() == [9]


def test_the_same_descriptors_give_the_same_words(rng: np.random.Generator) -> None:
    seen = np.concatenate(_scenes(rng)[:10])
    one, other = (Vocabulary.learnt(seen, 3).words(seen) for _ in range(2))
    assert np.array_equal(one, other)
    assert len(np.unique(one)) > 250


def test_few_or_equal_descriptors_make_a_vocabulary_too() -> None:
    alike = np.zeros((3, 32), dtype=np.uint8)
    words = Vocabulary.learnt(alike, 3).words(alike)
    assert len(np.unique(words)) == 1
