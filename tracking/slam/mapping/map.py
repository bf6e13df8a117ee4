"""The map: keyframes, points, and which keyframe saw which point where.

Points live in tables that get longer; a point's number never changes. A point that is not located
yet is NaN. `SlamMap.snapshot` gives frozen arrays, which are what is saved and handed out.

The vocabulary finds keyframes that look alike: descriptors are sorted into a tree whose nodes are
the bitwise majority of what lies below them (k-medians under Hamming's distance); a leaf is a word.
The tree is learnt from the first keyframes and once more, larger, when there are enough of them;
nothing is downloaded. For each word an inverted index holds the keyframes that show it. Words that
many keyframes show count little.

Sources: Nister & Stewenius 2006 (the tree, the index); Galvez-Lopez & Tardos 2012 (binary words);
Garcia-Fidalgo & Ortiz 2018 (learnt online).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Similarity
from motorcade.ga.archives import load_arrays, save_arrays
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.slam.features import Descriptors
from motorcade.tracking.slam.geometry import BoolArray, in_world, points_in_world

_FORMAT = "motorcade slam map 2"
GONE = -1


@dataclass(eq=False)
class Keyframe:
    """One image of the map; the mapper moves it and drops observations.

    Fields:
        time_ns: stamp.
        world_T_camera: its pose.
        ids: ``(n,)`` numbers of the points seen, rising.
        px: ``(n, 2)`` where; depth: ``(n,)`` NaN where not measured.
        gray: the image, while it may still serve to find points again; then None.
        map_number: in which world; maps that were not connected have worlds of their own. `GONE`
            for a keyframe that left its map, of which only the row remains.
        scale: by how much lengths around it were stretched since it was made.
    """

    time_ns: int
    world_T_camera: Motor
    ids: IntArray
    px: FloatArray
    depth: FloatArray
    gray: GrayImage | None
    map_number: int = 0
    scale: float = 1.0

    def move(self, world_S_camera: Similarity) -> None:
        """Take another pose, and note how much longer a unit of old is there."""
        self.world_T_camera = world_S_camera.rigid
        self.scale *= float(world_S_camera.scale)

    def keep(self, kept: BoolArray | IntArray) -> None:
        """Drop the other observations; rows are put in the order given."""
        self.ids, self.px, self.depth = self.ids[kept], self.px[kept], self.depth[kept]


@dataclass(frozen=True, eq=False)
class MapSnapshot:
    """A map as it was at one moment, read-only: what is saved, and what other estimators build on.

    Where lengths are not metres, poses and points share one free scale. Pixels are those of the
    undistorted image, a pinhole with the camera's matrix; or those of a fisheye (equidistant) as
    it is. The world is the first keyframe's camera, or that of the map that was gone on in.

    Args:
        time_ns: ``(k,)`` stamps of the keyframes; world_T_camera: Motor ``(k,)``.
        points: ``(p, 3)`` located points; descriptors: ``(p, 32)`` uint8.
        keyframe_of, point_of: ``(n,)`` rows of each observation; px ``(n, 2)``; depth ``(n,)``.
        metric: whether lengths are metres.

    Raises:
        ValueError: lengths that do not agree, or observations of what is not there.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import MapSnapshot
    >>> one_point = MapSnapshot(
    ...     time_ns=[0, 500_000_000],
    ...     world_T_camera=Motor.from_twist([[0.0] * 6, [0.0, 0.0, 0.0, 0.1, 0.0, 0.0]]),
    ...     points=[[0.0, 0.0, 2.0]],
    ...     descriptors=np.zeros((1, 32), np.uint8),
    ...     keyframe_of=[0, 1],
    ...     point_of=[0, 0],
    ...     px=[[319.5, 239.5], [294.5, 239.5]],
    ...     depth=[2.0, 2.0],
    ...     metric=True,
    ... )
    >>> camera_T_world = one_point.world_T_camera[1].inverse()
    >>> camera_T_world.apply(one_point.points)  # as the second keyframe sees it
    array([[-0.1,  0. ,  2. ]])
    """

    time_ns: IntArray
    world_T_camera: Motor
    points: FloatArray
    descriptors: Descriptors
    keyframe_of: IntArray
    point_of: IntArray
    px: FloatArray
    depth: FloatArray
    metric: bool

    def __post_init__(self) -> None:
        k, p, n = len(self.time_ns), len(self.points), len(self.keyframe_of)
        shapes: dict[str, tuple[int, ...]] = dict.fromkeys(
            ("keyframe_of", "point_of", "depth"), (n,)
        )
        shapes |= {"time_ns": (k,), "points": (p, 3), "descriptors": (p, 32), "px": (n, 2)}
        for name, shape in shapes.items():
            own = np.array(getattr(self, name))
            if own.shape != shape:
                raise ValueError(f"MapSnapshot.{name}: expected shape {shape}, got {own.shape}")
            own.setflags(write=False)
            object.__setattr__(self, name, own)
        if self.world_T_camera.shape != (k,):
            raise ValueError(
                f"MapSnapshot.world_T_camera: expected {(k,)}, got {self.world_T_camera.shape}"
            )
        for name, limit in (("keyframe_of", k), ("point_of", p)):
            rows = getattr(self, name)
            if n and (rows.min() < 0 or rows.max() >= limit):
                raise ValueError(f"MapSnapshot.{name}: expected rows below {limit}, got others")

    def save(self, path: Path) -> None:
        """Write an ``.npz`` file of plain arrays; the same map gives the same bytes.

        Raises:
            ValueError: a file name that does not end in ``.npz``.
            OSError: a file that cannot be written.
        """
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays["world_T_camera"] = self.world_T_camera.coefficients
        save_arrays(path, "MapSnapshot", _FORMAT, arrays)

    @classmethod
    def load(cls, path: Path) -> MapSnapshot:
        """Read what `save` wrote.

        Raises:
            FileError: a file that cannot be read, or unpacks to too much (`ga.archives`).
            ValueError: a file that holds no map, or values that are refused.
        """

        def make(stored: Mapping[str, NDArray[Any]]) -> MapSnapshot:
            values: dict[str, Any] = {name: stored[name] for name in _ARRAYS}
            values["world_T_camera"] = Motor(stored["world_T_camera"])
            return cls(**values | {"metric": bool(stored["metric"])})

        return load_arrays(path, "a saved map", _FORMAT, make)


_ARRAYS = tuple(field.name for field in fields(MapSnapshot))


class SlamMap:
    """The map while keyframes are inserted; or several, as long as nothing connects them.

    Fields:
        keyframes: of all maps, in the order in which they were made.
        metric: of each map by its number whether its lengths are metres.
        stored_count: how many keyframes, the first ones, an earlier session left, by its own clock.
    """

    def __init__(self) -> None:
        self.keyframes: list[Keyframe] = []
        self.metric: list[bool] = [False]
        self.stored_count = 0
        self._removed_count = 0
        self._index = KeyframeIndex()
        self._count = 0
        self._points = np.zeros((0, 3))
        self._descriptors: Descriptors = np.zeros((0, 32), dtype=np.uint8)
        self._alive = np.zeros(0, dtype=np.bool_)

    @property
    def points(self) -> FloatArray:
        """All points ``(p, 3)`` ever made; NaN where not located. May be written to."""
        return self._points[: self._count]

    @property
    def descriptors(self) -> Descriptors:
        """Descriptors ``(p, 32)`` of all points ever made."""
        return self._descriptors[: self._count]

    @property
    def alive(self) -> BoolArray:
        """Which points ``(p,)`` are still kept. May be written to."""
        return self._alive[: self._count]

    @property
    def located(self) -> BoolArray:
        """Which points ``(p,)`` are alive and located."""
        return self.alive & np.isfinite(self.points[:, 0])

    def add_points(self, descriptors: Descriptors) -> IntArray:
        """Make points that are not located yet; returns their numbers."""
        needed = self._count + len(descriptors)
        if needed > len(self._alive):
            room = max(2 * len(self._alive), needed, 1024)
            self._points = _longer(self._points, room, np.nan)
            self._descriptors = _longer(self._descriptors, room, 0)
            self._alive = _longer(self._alive, room, False)
        ids = np.arange(self._count, needed)
        self._descriptors[ids], self._alive[ids] = descriptors, True
        self._points[ids] = np.nan
        self._count = needed
        return ids

    def observations(self, rows: IntArray) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Of the keyframes `rows`: position in `rows`, point numbers, pixels, depths."""
        chosen = [self.keyframes[row] for row in rows]
        owner = np.repeat(np.arange(len(chosen)), [len(one.ids) for one in chosen])
        return (
            owner,
            np.concatenate([one.ids for one in chosen]),
            np.concatenate([one.px for one in chosen]),
            np.concatenate([one.depth for one in chosen]),
        )

    def rows_of(self, number: int) -> IntArray:
        """Rows of one map's keyframes, the oldest first."""
        mine = [row for row, one in enumerate(self.keyframes) if one.map_number == number]
        return np.array(mine, dtype=np.int64)

    @property
    def keyframe_rows(self) -> IntArray:
        """Rows of the keyframes of all maps, but for those that are gone."""
        kept = [row for row, one in enumerate(self.keyframes) if one.map_number != GONE]
        return np.array(kept, dtype=np.int64)

    @property
    def keyframe_count(self) -> int:
        """How many keyframes all maps have, but for those that are gone."""
        return len(self.keyframes) - self._removed_count

    def remove_keyframe(self, row: int) -> None:
        """Take a keyframe out of its map, and points that nothing else sees with it."""
        keyframe = self.keyframes[row]
        self._removed_count += 1
        left, keyframe.map_number, keyframe.gray = keyframe.ids, GONE, None
        keyframe.keep(np.zeros(0, dtype=np.int64))
        seen = np.zeros(self._count, dtype=np.bool_)
        for kept in self.keyframes:
            seen[kept.ids] = True
        self.alive[left[~seen[left]]] = False

    def points_of(self, number: int) -> IntArray:
        """Numbers of one map's located points."""
        rows = self.rows_of(number)
        if not len(rows):
            return np.zeros(0, dtype=np.int64)
        ids = np.unique(self.observations(rows)[1])
        return ids[self.located[ids]]

    def alike(self, descriptors: Descriptors, allowed: IntArray, count: int) -> IntArray:
        """Rows of up to `count` keyframes of `allowed` that look most like descriptors."""
        for keyframe in self.keyframes[len(self._index) :]:
            self._index.add(self.descriptors[keyframe.ids])
        return self._index.alike(descriptors, allowed, count)

    def join_maps(self, number: int, into: int, into_S_number: Similarity) -> None:
        """Make one map a part of another, whose world and unit it takes."""
        ids = self.points_of(number)
        self.points[ids] = points_in_world(into_S_number, self.points[ids])
        for row in self.rows_of(number):
            keyframe = self.keyframes[row]
            moved = into_S_number @ Similarity.from_motor_scale(keyframe.world_T_camera)
            keyframe.move(moved)
            keyframe.map_number = into

    def rescale(self, number: int, world_T_map: Similarity) -> None:
        """Take one map to another world and unit, as if it had been made there."""
        mine = np.ones(self._count, dtype=np.bool_)
        for keyframe in self.keyframes:
            if keyframe.map_number == number:
                keyframe.world_T_camera = in_world(world_T_map, keyframe.world_T_camera)
            else:
                mine[keyframe.ids] = False
        self.points[mine] = points_in_world(world_T_map, self.points[mine])

    def merge(self, gone: IntArray, kept: IntArray) -> None:
        """Let every keyframe that saw a point `gone` ``(n,)`` have seen `kept` ``(n,)`` instead.

        None of the one may stand in the other. A keyframe that saw both keeps what it saw of the
        kept one.
        """
        renamed = np.arange(self._count)
        renamed[gone] = kept
        self.alive[gone] = False
        for keyframe in self.keyframes:
            ids = renamed[keyframe.ids]
            order = np.lexsort((ids != keyframe.ids, ids))
            _, first = np.unique(ids[order], return_index=True)
            keyframe.keep(order[first])
            keyframe.ids = renamed[keyframe.ids]

    def shared(self, ids: IntArray) -> IntArray:
        """How many of the points `ids` each keyframe ``(k,)`` sees."""
        wanted = np.zeros(self._count, dtype=np.bool_)
        wanted[ids] = True
        return np.array([np.count_nonzero(wanted[one.ids]) for one in self.keyframes])

    @classmethod
    def of(cls, stored: MapSnapshot) -> SlamMap:
        """A map that goes on from a stored one; its keyframes have no images any more."""
        slam_map = cls()
        slam_map.metric = [stored.metric]
        ids = slam_map.add_points(stored.descriptors)
        slam_map.points[:] = stored.points
        stamped = zip(stored.time_ns.tolist(), stored.world_T_camera, strict=True)
        for row, (time_ns, pose) in enumerate(stamped):
            mine = stored.keyframe_of == row
            keyframe = Keyframe(
                time_ns, pose, ids[stored.point_of[mine]], stored.px[mine], stored.depth[mine], None
            )
            keyframe.keep(np.argsort(keyframe.ids))
            slam_map.keyframes.append(keyframe)
        slam_map.stored_count = len(slam_map.keyframes)
        return slam_map

    def snapshot(self, number: int) -> MapSnapshot:
        """One map's keyframes, located points and their observations, frozen."""
        rows, metric = self.rows_of(number), self.metric[number]
        row_of = np.full(self._count, -1)
        if not len(rows):
            return _nothing_mapped(metric)
        keyframes = [self.keyframes[row] for row in rows]
        owner, ids, px, depth = self.observations(rows)
        seen = self.located[ids]
        owner, ids, px, depth = owner[seen], ids[seen], px[seen], depth[seen]
        used = np.unique(ids)
        row_of[used] = np.arange(len(used))
        return MapSnapshot(
            np.array([one.time_ns for one in keyframes], dtype=np.int64),
            Motor.stack([one.world_T_camera for one in keyframes]),
            self.points[used],
            self.descriptors[used],
            owner,
            row_of[ids],
            px,
            depth,
            metric,
        )


def _nothing_mapped(metric: bool) -> MapSnapshot:
    none, rows = np.zeros(0, dtype=np.int64), np.zeros((0, 32), dtype=np.uint8)
    poses, points = Motor.identity((0,)), np.zeros((0, 3))
    return MapSnapshot(none, poses, points, rows, none, none, points[:, :2], np.zeros(0), metric)


def _longer(table: np.ndarray, room: int, fill: float | bool) -> np.ndarray:
    larger = np.full((room, *table.shape[1:]), fill, dtype=table.dtype)
    larger[: len(table)] = table
    return larger


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
    >>> from motorcade.tracking.slam.mapping.map import Vocabulary
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
        """Rows of up to `count` keyframes of `allowed` that look most like an image, best first.

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
