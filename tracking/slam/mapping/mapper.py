"""The mapper: inserts keyframes, locates points, and drops those that do not hold up.

Sources: keyframes and culling after Mur-Artal & Tardos 2017; tracks as in Qin et al. 2018.

Keyframes that show nothing which others do not show as well leave the map, so it grows with what
the camera has seen, not with how long it has looked. Frames that hung on such a keyframe hang on
its neighbour from then on.

Source: Mur-Artal & Tardos 2017 (ORB-SLAM2): 90 % of the points seen by three others at the same or
a finer scale.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, project
from motorcade.tracking.images import track_corners
from motorcade.tracking.slam.features import (
    Corners,
    SlamImage,
    depth_at,
    find_corners,
    stereo_depth,
)
from motorcade.tracking.slam.geometry import OUTLIER_PX, parallax_rad, triangulate
from motorcade.tracking.slam.mapping.adjustment import AdjustedBundle, Adjuster, Bundle, adjust
from motorcade.tracking.slam.mapping.loops import (
    ClosedLoop,
    close_loop,
    find_loop,
)
from motorcade.tracking.slam.mapping.map import Keyframe, SlamMap
from motorcade.tracking.slam.mapping.matching import alike_where_expected, any_in_view, in_view
from motorcade.tracking.slam.settings import SlamSettings
from motorcade.tracking.slam.tracker import TrackedPoints

_ALL_ITERATIONS = 10
_PARALLAX_RAD = np.deg2rad(1.0)
_GOOD_PX = 2.0
_DEPTH_BASELINE_M = 0.08
_MOST_FIXED = 10
_IMAGES_KEPT = 30
_RECOVERED_FROM = 3
_FEWEST_HIDDEN = 15
_FEWEST_HELD = 15  # points by which a keyframe that stays holds a window, as for a pose found anew
_AROUND = 3  # keyframes before and after an old one, whose points may come into view
_ALIKE_PX = 5.0


@dataclass(frozen=True, eq=False)
class InsertedKeyframe:
    """What became of a keyframe.

    Args:
        tracked: its points, to be tracked from here.
        closed: the loop that it closed, or None; stretch: by how much that stretched its lengths.
        culled: an older keyframe that it made redundant, or None.
        seconds: what it took.
    """

    tracked: TrackedPoints
    closed: ClosedLoop | None
    stretch: float
    culled: CulledKeyframe | None
    seconds: float


class Mapper:
    """Inserts keyframes into a map and keeps it consistent.

    Args:
        slam_map: the map; camera: the pinhole; settings: see `SlamSettings`.

    Fields:
        active: number of the map that keyframes are inserted into.
        adjuster: adjusts by more than images (an IMU, say); None: by images alone.
        adjusts_all: whether the next keyframe is followed by an adjustment of the whole map.

    A loop moves the whole map, and adjusting all of that at once would hold up the frame that
    closes it. The pose graph has brought keyframes near already, so their windows are adjusted one
    after the other instead, one with each keyframe that is inserted into that map.
    """

    def __init__(self, slam_map: SlamMap, camera: Camera, settings: SlamSettings) -> None:
        self.map = slam_map
        self.camera = camera
        self.settings = settings
        baseline_m = settings.baseline_m or _DEPTH_BASELINE_M
        self.disparity_px_m = camera.fx * baseline_m
        self.active = 0
        self.adjuster: Adjuster | None = None
        self.adjusts_all = False
        self._windows_left: dict[int, list[tuple[IntArray, IntArray]]] = {}  # by map number
        if settings.close_loops:
            import scipy.sparse.linalg  # noqa: F401  # so that no frame that closes a loop waits for it

    @property
    def metric(self) -> bool:
        """Whether the active map's lengths are metres."""
        return self.map.metric[self.active]

    @metric.setter
    def metric(self, metric: bool) -> None:
        """Say whether they are; points and keyframes stay where they are."""
        self.map.metric[self.active] = metric

    def begin_map(self) -> None:
        """Insert keyframes into a new map from now on, with a world of its own."""
        self.map.metric.append(False)
        self.active = len(self.map.metric) - 1

    def insert_keyframe(
        self, image: SlamImage, pose: Motor, ids: IntArray, px: FloatArray
    ) -> InsertedKeyframe:
        """Make a keyframe of a tracked image, and close a loop where it shows one.

        Args:
            image: the image.
            pose: world_T_camera as tracked.
            ids: ``(n,)`` points tracked in it.
            px: ``(n, 2)`` where.
        """
        started = time.perf_counter()
        self._fill(image, pose, ids, px)
        newest = self.map.keyframes[-1]
        closed = self._closed() if self.settings.close_loops else None
        windows = self._windows_left.get(self.active)
        if self.adjusts_all:
            self.adjust_all(_ALL_ITERATIONS)
            self.adjusts_all = False
        elif windows and self.settings.adjust:
            self._adjust_between(*windows.pop(0))
        tracked, culled = self._newest(image), self._culled()
        seconds = time.perf_counter() - started
        return InsertedKeyframe(tracked, closed, newest.scale, culled, seconds)

    def _culled(self) -> CulledKeyframe | None:
        """Let the keyframe that has left the window leave the map too, if others make up for it."""
        mine = self.map.rows_of(self.active)
        # An IMU's samples link each keyframe to the next; one camera's unit is handed on by nothing
        # but what its keyframes share, and drifts the more the fewer there are.
        if not self.settings.cull_keyframes or self.adjuster is not None or not self.metric:
            return None
        if len(mine) <= self.settings.window:
            return None
        return cull(self.map, int(mine[-1 - self.settings.window]))

    def _closed(self) -> ClosedLoop | None:
        """Close a loop, or join two maps, where the newest keyframe shows one."""
        loop = find_loop(self.map, self.settings.features, self.camera)
        if loop is None:
            return None
        closed = close_loop(self.map, loop, self.camera)
        self.active = closed.maps[1]
        if self.adjuster is not None:
            # It measures from one keyframe to the next, from the first to the newest.
            self.adjusts_all = self.settings.adjust
        mine = self.map.rows_of(self.active)
        self._windows_left.pop(closed.maps[0], None)
        self._windows_left[self.active] = windows_along(mine, loop.old, self.settings.window)
        return closed

    def append(self, image: SlamImage, pose: Motor, ids: IntArray, px: FloatArray) -> Keyframe:
        """Make a keyframe of an image; a measured depth locates points that are not yet."""
        order = np.argsort(ids)
        ids, px = ids[order], px[order]
        depth = self.depths(image, px) if self.metric else np.full(len(px), np.nan)
        keyframe = Keyframe(image.time_ns, pose, ids, px, depth, image.gray, self.active)
        self.map.keyframes.append(keyframe)
        if len(self.map.keyframes) > _IMAGES_KEPT:
            self.map.keyframes[-1 - _IMAGES_KEPT].gray = None
        new = np.isfinite(depth) & ~self.map.located[ids]
        in_camera = self.camera.unproject(px[new]) * depth[new, None]
        self.map.points[ids[new]] = pose.apply(in_camera)
        return keyframe

    def _fill(self, image: SlamImage, pose: Motor, ids: IntArray, px: FloatArray) -> None:
        """Make a keyframe, fill it with corners, locate points and adjust the window."""
        found_ids, found_px = self.recover(image, pose, self.active, ids)
        ids, px = np.concatenate([ids, found_ids]), np.concatenate([px, found_px])
        corners = find_corners(image.gray, self.settings.features, px)
        known_ids, rows = self.recognised(pose, ids, corners)
        new = np.setdiff1d(np.arange(len(corners)), rows)
        ids = np.concatenate([ids, known_ids, self.map.add_points(corners.descriptors[new])])
        px = np.concatenate([px, corners.px[rows], corners.px[new]])
        self.append(image, pose, ids, px)
        self.triangulate_newest()
        if self.settings.adjust:
            self.adjust_window()

    def _newest(self, image: SlamImage) -> TrackedPoints:
        """All that the newest keyframe, made of this image, sees and that is still kept."""
        newest = self.map.keyframes[-1]
        alive = self.map.alive[newest.ids]
        ids = newest.ids[alive]
        points = self.map.points[ids]
        return TrackedPoints(image, newest.world_T_camera, ids, newest.px[alive], points)

    def seen_again(self, tracked: TrackedPoints) -> TrackedPoints:
        """Add points of the map, as it is, that the image shows beside those tracked in it."""
        image, pose = tracked.image, tracked.world_T_camera
        ids, px = tracked.ids, tracked.px
        corners = find_corners(image.gray, self.settings.features, px)
        more, rows = self.recognised(pose, ids, corners)
        ids, px = np.concatenate([ids, more]), np.concatenate([px, corners.px[rows]])
        order = np.argsort(ids)
        return TrackedPoints(image, pose, ids[order], px[order], self.map.points[ids[order]])

    def depths(self, image: SlamImage, px: FloatArray) -> FloatArray:
        """Depths ``(n,)`` at pixels from the depth image or the right image; NaN elsewhere."""
        if image.depth_m is not None:
            return depth_at(image.depth_m, px)
        if image.right is not None:
            return stereo_depth(image.pyramid, image.right, px, self.disparity_px_m)
        return np.full(len(px), np.nan)

    def recover(
        self, image: SlamImage, pose: Motor, number: int, ids: IntArray | None = None
    ) -> tuple[IntArray, FloatArray]:
        """Points of a map that should be in view but are not tracked (`ids`), found again.

        They are tracked from the keyframe's own image, so they come back without drift.
        """
        tracked = np.zeros(len(self.map.alive), dtype=np.bool_)
        if ids is not None:
            tracked[ids] = True
        all_ids, all_px = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 2))]
        hidden = []
        for row in self.map.rows_of(number)[-_IMAGES_KEPT:]:
            keyframe = self.map.keyframes[row]
            usable, expected = in_view(self.map, keyframe, keyframe.ids, pose, self.camera)
            rows = np.flatnonzero(usable & ~tracked[keyframe.ids])
            if len(rows) >= _FEWEST_HIDDEN and keyframe.gray is not None:
                hidden.append((len(rows), keyframe, rows, expected))
        hidden.sort(key=lambda view: -view[0])
        for _, keyframe, rows, expected in hidden[:_RECOVERED_FROM]:
            rows = rows[~tracked[keyframe.ids[rows]]]
            gray = keyframe.gray
            if gray is None or not len(rows):
                continue
            px, held = track_corners(gray, image.pyramid, keyframe.px[rows], expected[rows])
            held &= np.linalg.norm(px - expected[rows], axis=1) < OUTLIER_PX
            all_ids.append(keyframe.ids[rows[held]])
            all_px.append(px[held])
            tracked[all_ids[-1]] = True
        return np.concatenate(all_ids), np.concatenate(all_px)

    def recognised(self, pose: Motor, ids: IntArray, corners: Corners) -> tuple[IntArray, IntArray]:
        """Points of long ago that new corners look like, where they should be; and whose rows.

        Looked for where the camera has been before: around old keyframes that share points with
        what is tracked now.
        """
        mine = self.map.rows_of(self.active)
        mine = mine[[self.map.keyframes[row].gray is None for row in mine]]
        near = np.flatnonzero(self.map.shared(ids)[mine] >= _FEWEST_HIDDEN)
        around = np.unique(near[:, None] + np.arange(-_AROUND, _AROUND + 1))
        around = mine[around[(around >= 0) & (around < len(mine))]]
        known, expected = any_in_view(self.map, around.tolist(), ids, pose, self.camera)
        points, rows = alike_where_expected(
            expected, self.map.descriptors[known], corners, _ALIKE_PX
        )
        return known[points], rows

    def triangulate_newest(self) -> None:
        """Locate points that the newest keyframe and an older one of the window see."""
        newest = self.map.keyframes[-1]
        for row in self.map.rows_of(self.active)[-1 - self.settings.window : -1]:
            older = self.map.keyframes[row]
            wanted = self.map.alive[newest.ids] & ~self.map.located[newest.ids]
            ids, rows, older_rows = np.intersect1d(
                newest.ids[wanted], older.ids, assume_unique=True, return_indices=True
            )
            if not len(ids):
                continue
            px, older_px = newest.px[wanted][rows], older.px[older_rows]
            poses = older.world_T_camera, newest.world_T_camera
            points = triangulate(*poses, older_px, px, self.camera)
            good = parallax_rad(*poses, points) > _PARALLAX_RAD
            for pose, pixels in zip(poses, (older_px, px), strict=True):
                seen, _ = project(self.camera, pose, points)  # behind the camera none is seen
                error = np.linalg.norm(seen - pixels, axis=1)
                good &= np.nan_to_num(error, nan=np.inf) < _GOOD_PX
            self.map.points[ids[good]] = points[good]

    def adjust_window(self) -> None:
        """Adjust the newest keyframes and their points; older ones that see these stay fixed.

        Where the camera was put elsewhere, those from before have nothing to do with the newest.
        """
        mine = self.map.rows_of(self.active)
        free = mine[-self.settings.window :]
        if self.adjuster is None:
            free = connected(self.map, free, _FEWEST_HELD)
        seen = points_seen(self.map, free)
        shared = self.map.shared(seen)
        shared[free] = 0
        if self.adjuster is not None and len(mine) > len(free):
            shared[mine[-1 - len(free)]] = len(seen) + 1  # motion is measured from the one before
        fixed = np.argsort(-shared, kind="stable")[:_MOST_FIXED]
        fixed = np.sort(fixed[shared[fixed] > 0])
        rows = np.concatenate([fixed, free])
        self._adjust(rows, len(fixed), held_by(self.map, rows, seen))

    def _adjust_between(self, free: IntArray, holders: IntArray) -> None:
        """Adjust keyframes `free` amid the map, between those of `holders` that see the same."""
        live = self.map.rows_of(self.active)
        free, holders = (rows[np.isin(rows, live)] for rows in (free, holders))
        if not len(free):
            return
        seen = points_seen(self.map, free)
        shared = np.zeros(len(self.map.keyframes), dtype=np.int64)
        shared[holders] = self.map.shared(seen)[holders]
        shared[free] = 0
        fixed = np.argsort(-shared, kind="stable")[:_MOST_FIXED]
        fixed = np.sort(fixed[shared[fixed] >= _FEWEST_HELD])
        if not len(fixed):
            return
        rows = np.concatenate([fixed, free])
        self._adjust(rows, len(fixed), held_by(self.map, rows, seen))

    def adjust_all(self, iterations: int = 20) -> None:
        """Adjust the whole active map; its first keyframe stays where it is."""
        rows = self.map.rows_of(self.active)
        self._adjust(rows, 0, self.map.points_of(self.active), iterations)

    def _adjust(
        self, rows: IntArray, fixed_count: int, points: IntArray, iterations: int = 8
    ) -> None:
        """Adjust points and keyframes `rows`, whose first `fixed_count` (at least 1) stay."""
        if not len(points) or len(rows) < 2:
            return
        slot = np.full(len(self.map.alive), -1)
        slot[points] = np.arange(len(points))
        owner, ids, px, depth = self.map.observations(rows)
        used = slot[ids] >= 0
        fixed = np.arange(len(rows)) < max(fixed_count, 1)
        bundle = Bundle(
            Motor.stack([self.map.keyframes[row].world_T_camera for row in rows]),
            fixed,
            self.map.points[points],
            owner[used],
            slot[ids[used]],
            px[used],
            depth[used],
            self.camera,
            self.disparity_px_m,
            self.settings.depth_sigma_px,
        )
        if self.adjuster is None:
            result = adjust(bundle, iterations)
        else:
            time_ns = np.array([self.map.keyframes[row].time_ns for row in rows], dtype=np.int64)
            result = self.adjuster(bundle, time_ns, iterations)
            if fixed_count == 0:
                # It may know how long a unit is: frames are then as much farther from keyframes.
                stretch = _extent(result.world_T_camera) / _extent(bundle.world_T_camera)
                for row in rows:
                    self.map.keyframes[row].scale *= stretch
        for row, pose in zip(rows, result.world_T_camera, strict=True):
            self.map.keyframes[row].world_T_camera = pose
        self.map.points[points] = result.points
        self._cull(rows, points, owner, used, result)

    def _cull(
        self,
        rows: IntArray,
        points: IntArray,
        owner: IntArray,
        used: np.ndarray,
        result: AdjustedBundle,
    ) -> None:
        """Drop outliers, and points that too few observations hold."""
        good = np.ones(len(owner), dtype=np.bool_)
        good[used] = result.error_px <= OUTLIER_PX
        held = np.zeros(len(self.map.alive), dtype=np.int64)
        for position, row in enumerate(rows):
            keyframe = self.map.keyframes[row]
            keyframe.keep(good[owner == position])
            held[keyframe.ids] += 1 + np.isfinite(keyframe.depth)
        loose = points[held[points] < 2]
        self.map.alive[loose] = False


def _extent(world_T_camera: Motor) -> float:
    """RMS distance of places from their mean."""
    places = world_T_camera.translation_m
    return float(np.sqrt(np.mean(np.sum((places - places.mean(axis=0)) ** 2, axis=-1))))


def connected(slam_map: SlamMap, rows: IntArray, fewest: int) -> IntArray:
    """Those keyframes that the last of `rows` is tied to by points, directly or by others.

    Args:
        slam_map: the map.
        rows: of keyframes, rising.
        fewest: points that tie a keyframe to the others.
    """
    tied = np.zeros(len(slam_map.alive), dtype=np.bool_)
    tied[slam_map.keyframes[rows[-1]].ids] = True
    kept = [rows[-1]]
    for row in rows[-2::-1]:
        ids = slam_map.keyframes[row].ids
        if np.count_nonzero(tied[ids]) >= fewest:
            tied[ids] = True
            kept.append(row)
    return np.array(kept[::-1], dtype=np.int64)


def points_seen(slam_map: SlamMap, rows: IntArray) -> IntArray:
    """Numbers of the located points that some keyframes see."""
    seen = np.unique(slam_map.observations(rows)[1])
    return seen[slam_map.located[seen]]


def held_by(slam_map: SlamMap, rows: IntArray, points: IntArray) -> IntArray:
    """Points but for those that one keyframe of `rows` sees and that others elsewhere hold.

    Such a point would follow the one, and then count as seen by too few.
    """
    count = len(slam_map.alive)
    _, ids, _, depth = slam_map.observations(rows)
    here = np.bincount(ids, 1.0 + np.isfinite(depth), count)
    every = slam_map.observations(slam_map.keyframe_rows)[1]
    elsewhere = np.bincount(every, minlength=count) - np.bincount(ids, minlength=count)
    held: IntArray = points[(here[points] >= 2.0) | (elsewhere[points] == 0)]
    return held


def windows_along(rows: IntArray, old: int, size: int) -> list[tuple[IntArray, IntArray]]:
    """Windows of keyframes to adjust after a loop, with those that each may be held by.

    They overlap by half, from the newest keyframe back to the old one. The first is held by the old
    pass alone, which draws it there; the others carry that on.

    Args:
        rows: of the map's keyframes, rising.
        old: the row that was recognised.
        size: of a window.
    """
    first = max(int(np.searchsorted(rows, old)) - size, 1)  # the map's first one stays
    stops = range(len(rows), first, -(size // 2))
    free = [rows[max(stop - size, first) : stop] for stop in stops]
    holders = [rows[: max(len(rows) - 2 * size, 1)], *[rows] * len(free)]
    return list(zip(free, holders, strict=False))


_OTHERS = 3
_SHARE = 0.9
_COARSER = 1.2  # an octave of the pyramid there, and how much farther away counts as the same scale
# Frames are as rigid with a keyframe as it is near; inertial samples are summed up over no more.
_LONGEST_GAP_NS = 500_000_000


@dataclass(frozen=True, eq=False)
class CulledKeyframe:
    """A keyframe that left the map.

    Args:
        row: its row; kept: that of the neighbour which stands for it.
        kept_T_culled: its pose from there.
        scale, kept_scale: `Keyframe.scale` of both at that moment.
    """

    row: int
    kept: int
    kept_T_culled: Motor
    scale: float
    kept_scale: float


def is_redundant(slam_map: SlamMap, row: int) -> bool:
    """Whether almost all points that a keyframe sees are seen by enough others as well as by it."""
    keyframe = slam_map.keyframes[row]
    ids = keyframe.ids[slam_map.located[keyframe.ids]]
    if not len(ids):
        return False
    points, place = slam_map.points[ids], np.full(len(slam_map.alive), -1)
    place[ids] = np.arange(len(ids))
    apart_m = np.linalg.norm(points - keyframe.world_T_camera.translation_m, axis=1)
    seen = np.zeros(len(ids), dtype=np.int64)
    for other in slam_map.rows_of(keyframe.map_number):
        mine = place[slam_map.keyframes[other].ids]
        mine = mine[mine >= 0]
        if other == row or not len(mine):
            continue
        from_m = slam_map.keyframes[other].world_T_camera.translation_m
        seen[mine] += np.linalg.norm(points[mine] - from_m, axis=1) <= _COARSER * apart_m[mine]
    return bool(np.mean(seen >= _OTHERS) >= _SHARE)


def cull(slam_map: SlamMap, row: int) -> CulledKeyframe | None:
    """Take a keyframe out of its map if it is redundant there; a map's first and last one stay.

    It stays where it would leave its neighbours far apart in time, and beside keyframes of a stored
    map, whose stamps are of another clock.
    """
    keyframe = slam_map.keyframes[row]
    mine = slam_map.rows_of(keyframe.map_number)
    position = int(np.searchsorted(mine, row))
    if not 0 < position < len(mine) - 1:
        return None
    before, after = (int(mine[position + step]) for step in (-1, 1))
    gap_ns = slam_map.keyframes[after].time_ns - slam_map.keyframes[before].time_ns
    if before < slam_map.stored_count or not 0 < gap_ns <= _LONGEST_GAP_NS:
        return None
    if not is_redundant(slam_map, row):
        return None
    kept = slam_map.keyframes[before]
    relative = kept.world_T_camera.inverse() @ keyframe.world_T_camera
    slam_map.remove_keyframe(row)
    return CulledKeyframe(row, before, relative, keyframe.scale, kept.scale)
