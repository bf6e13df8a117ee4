"""The map: keyframes, points, and which keyframe saw which point where.

Points live in tables that get longer; a point's number never changes. A point that is not located
yet is NaN. `SlamMap.snapshot` gives frozen arrays, which are what is saved and handed out.
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
from motorcade.tracking.slam.mapping.vocabulary import KeyframeIndex

_FORMAT = "motorcade slam map 2"
GONE = -1


@dataclass(eq=False)
class Keyframe:
    """One picture of the map; the mapper moves it and drops observations.

    Fields:
        time_ns: stamp.
        world_T_camera: its pose.
        ids: ``(n,)`` numbers of the points seen, rising.
        px: ``(n, 2)`` where; depth: ``(n,)`` NaN where not measured.
        gray: the picture, while it may still serve to find points again; then None.
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
    undistorted picture, a pinhole with the camera's matrix; or those of a fisheye (equidistant) as
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
        """A map that goes on from a stored one; its keyframes have no pictures any more."""
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
