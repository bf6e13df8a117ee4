"""Which keyframes look like a picture: a bag of words over descriptors, learnt from the recording.

Descriptors are sorted into a tree whose nodes are the bitwise majority of what lies below them
(k-medians under Hamming's distance); a leaf is a word. The tree is learnt from the first keyframes
and once more, larger, when there are enough of them; nothing is downloaded. For each word an
inverted index holds the keyframes that show it. Words that many keyframes show count little.

Sources: Nister & Stewenius 2006 (the tree, the index); Galvez-Lopez & Tardos 2012 (binary words);
Garcia-Fidalgo & Ortiz 2018 (learnt online).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.slam.features import Descriptors

Packed = NDArray[np.uint64]

_BRANCHES = 8
_ROUNDS = 4
_MOST_LEARNT = 4096  # descriptors; more do not change a tree of so many leaves
_LEARNT_AT = {8: 3, 40: 4}  # keyframes, and the levels of the tree then learnt


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """A tree of words.

    Args:
        levels: centres ``(8^(l+1), 4)`` uint64 of each level; the children of node n are 8 n to
            8 n + 7 of the next.

    >>> import numpy as np
    >>> from motorcade.tracking.slam.mapping.vocabulary import Vocabulary
    >>> seen = np.random.default_rng(0).integers(0, 256, (500, 32)).astype(np.uint8)
    >>> vocabulary = Vocabulary.learnt(seen, depth=2)
    >>> turned = seen.copy()
    >>> turned[:, 0] ^= 1  # one bit of 256
    >>> bool(np.mean(vocabulary.words(seen) == vocabulary.words(turned)) > 0.9)
    True
    """

    levels: tuple[Packed, ...]

    @classmethod
    def learnt(cls, descriptors: Descriptors, depth: int) -> Vocabulary:
        """From descriptors ``(n, 32)``, evenly thinned where there are many; always the same."""
        rows = np.unique(np.linspace(0, len(descriptors) - 1, _MOST_LEARNT).astype(np.int64))
        packed = _packed(descriptors[rows])
        bits = np.unpackbits(packed.view(np.uint8), axis=1).astype(np.float32)
        node = np.zeros(len(packed), dtype=np.int64)
        levels = []
        for level in range(depth):
            parents = _BRANCHES**level
            centres = _first_centres(packed, node, parents)
            for _ in range(_ROUNDS):
                child = _nearest_child(packed, node, centres)
                centres = _majorities(bits, child, centres)
            node = _nearest_child(packed, node, centres)
            levels.append(centres)
        return cls(tuple(levels))

    def words(self, descriptors: Descriptors) -> IntArray:
        """The word ``(n,)`` of each descriptor ``(n, 32)``."""
        packed = _packed(descriptors)
        node = np.zeros(len(packed), dtype=np.int64)
        for centres in self.levels:
            node = _nearest_child(packed, node, centres)
        return node


class KeyframeIndex:
    """Finds keyframes by the words they show."""

    def __init__(self) -> None:
        self._descriptors: list[Descriptors] = []
        self._vocabulary: Vocabulary | None = None
        self._showing: dict[int, list[tuple[int, int]]] = {}

    def __len__(self) -> int:
        return len(self._descriptors)

    def add(self, descriptors: Descriptors) -> None:
        """Take the next keyframe, by the descriptors ``(n, 32)`` of what it shows."""
        self._descriptors.append(descriptors)
        learnt = 0 if self._vocabulary is None else len(self._vocabulary.levels)
        depth = max((one for count, one in _LEARNT_AT.items() if count <= len(self)), default=0)
        if depth > learnt and any(len(one) for one in self._descriptors):
            self._vocabulary = Vocabulary.learnt(np.concatenate(self._descriptors), depth)
            self._showing = {}
            for row, known in enumerate(self._descriptors):
                self._enter(row, known)
            if depth == max(_LEARNT_AT.values()):
                self._descriptors = [one[:0] for one in self._descriptors]
        elif self._vocabulary is not None:
            self._enter(len(self) - 1, descriptors)
            if learnt == max(_LEARNT_AT.values()):
                self._descriptors[-1] = descriptors[:0]

    def alike(self, descriptors: Descriptors, allowed: IntArray, count: int) -> IntArray:
        """Rows of up to `count` keyframes of `allowed` that look most like a picture, best first.

        While there are too few keyframes for a vocabulary all are alike, and the newest come first.
        """
        if self._vocabulary is None:
            return np.sort(allowed)[::-1][:count]
        score = self._scores(descriptors)[allowed]
        best = np.argsort(-score, kind="stable")[:count]
        return np.asarray(allowed[best[score[best] > 0.0]])

    def _enter(self, row: int, descriptors: Descriptors) -> None:
        if self._vocabulary is None:
            raise AssertionError("a vocabulary is learnt before keyframes are entered")
        words, counts = np.unique(self._vocabulary.words(descriptors), return_counts=True)
        for word, shown in zip(words.tolist(), counts.tolist(), strict=True):
            self._showing.setdefault(word, []).append((row, shown))

    def _scores(self, descriptors: Descriptors) -> FloatArray:
        """How much each keyframe ``(k,)`` has in common with the descriptors."""
        score = np.zeros(len(self))
        if self._vocabulary is None or not len(descriptors):
            return score
        words, counts = np.unique(self._vocabulary.words(descriptors), return_counts=True)
        for word, here in zip(words.tolist(), counts.tolist(), strict=True):
            shown = np.array(self._showing.get(word, ()), dtype=np.int64).reshape(-1, 2)
            rarity = np.log(len(self) / max(len(shown), 1))
            score[shown[:, 0]] += rarity * np.minimum(shown[:, 1], here)
        return score


def _packed(descriptors: Descriptors) -> Packed:
    return np.ascontiguousarray(descriptors).view(np.uint64)


def _nearest_child(packed: Packed, node: IntArray, centres: Packed) -> IntArray:
    """The child ``(n,)`` of each descriptor's node whose centre differs in fewest bits."""
    children = centres.reshape(-1, _BRANCHES, 4)[node]
    bits = np.bitwise_count(children ^ packed[:, None]).sum(axis=-1, dtype=np.int64)
    nearest: IntArray = _BRANCHES * node + np.argmin(bits, axis=1)
    return nearest


def _first_centres(packed: Packed, node: IntArray, parents: int) -> Packed:
    """Descriptors spread evenly over each node's; a node without any keeps zeros."""
    order = np.argsort(node, kind="stable")
    starts = np.searchsorted(node[order], np.arange(parents + 1))
    share = (np.arange(_BRANCHES) + 0.5) / _BRANCHES
    held = np.diff(starts)[:, None]
    rows = (starts[:-1, None] + share * held).astype(np.int64)
    centres = packed[order[np.minimum(rows, len(packed) - 1)]]
    centres[held[:, 0] == 0] = 0
    return np.ascontiguousarray(centres.reshape(-1, 4))


def _majorities(bits: NDArray[np.float32], owner: IntArray, before: Packed) -> Packed:
    """Bitwise majority of what belongs to each centre; one that nothing belongs to stays."""
    order = np.argsort(owner, kind="stable")
    owners, starts, counts = np.unique(owner[order], return_index=True, return_counts=True)
    share = np.add.reduceat(bits[order], starts, axis=0) / counts[:, None]
    centres = before.copy()
    centres[owners] = np.packbits(share > 0.5, axis=1).view(np.uint64)
    return centres
