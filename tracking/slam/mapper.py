"""The mapper: which pictures become keyframes, where points are, and what is believed of them.

Sources: keyframes and culling after Mur-Artal & Tardos 2017; tracks as in Qin et al. 2018.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import FloatArray, IntArray
from motorcade.tracking.slam.adjustment import Adjusted, Bundle, adjust
from motorcade.tracking.slam.features import (
    Picture,
    depth_at,
    find_corners,
    follow,
    stereo_depth,
)
from motorcade.tracking.slam.geometry import (
    OUTLIER_PX,
    inverse,
    moved,
    parallax_rad,
    project,
    triangulate,
)
from motorcade.tracking.slam.map import Keyframe, SlamMap
from motorcade.tracking.slam.settings import SlamSettings

__all__ = ["Mapper"]

_KEPT_SHARE = 0.8
_MOVED_SHARE = 0.06
_FEW_POINTS = 150
_PARALLAX_RAD = np.deg2rad(1.0)
_GOOD_PX = 2.0
_DEPTH_BASELINE_M = 0.08
_MOST_FIXED = 10
_PICTURES_KEPT = 30
_RECOVERED_FROM = 3
_FEWEST_HIDDEN = 15
_SCALE_CHANGE = 1.5


class Mapper:
    """Adds keyframes to a map and keeps it consistent.

    Args:
        slam_map: the map; matrix: ``(3, 3)`` intrinsics.
    """

    def __init__(self, slam_map: SlamMap, matrix: FloatArray, settings: SlamSettings) -> None:
        self.map = slam_map
        self.matrix = matrix
        self.settings = settings
        baseline_m = settings.baseline_m or _DEPTH_BASELINE_M
        self.disparity_px_m = float(matrix[0, 0]) * baseline_m
        self._located_then = 0

    def wants(self, picture: Picture, ids: IntArray, px: FloatArray) -> bool:
        """Whether this picture should become a keyframe, by what is followed in it."""
        newest = self.map.keyframes[-1]
        located = int(np.count_nonzero(self.map.located[ids]))
        if located < max(_FEW_POINTS, _KEPT_SHARE * self._located_then):
            return True
        _, then, now = np.intersect1d(newest.ids, ids, assume_unique=True, return_indices=True)
        motion = np.linalg.norm(newest.px[then] - px[now], axis=1)
        return bool(np.median(motion) > _MOVED_SHARE * picture.gray.shape[1])

    def append(self, picture: Picture, pose: FloatArray, ids: IntArray, px: FloatArray) -> Keyframe:
        """Make a keyframe of a picture; points with a measured depth and no place get one."""
        order = np.argsort(ids)
        ids, px = ids[order], px[order]
        depth = self.depths(picture, px)
        keyframe = Keyframe(picture.time_ns, np.array(pose), ids, px, depth, picture.gray)
        self.map.keyframes.append(keyframe)
        if len(self.map.keyframes) > _PICTURES_KEPT:
            self.map.keyframes[-1 - _PICTURES_KEPT].gray = None
        new = np.isfinite(depth) & ~self.map.located[ids]
        rays = (px[new] - self.matrix[:2, 2]) / self.matrix[(0, 1), (0, 1)]
        in_camera = np.concatenate([rays, np.ones((len(rays), 1))], axis=1) * depth[new, None]
        self.map.places[ids[new]] = moved(inverse(pose), in_camera)
        return keyframe

    def insert(
        self, picture: Picture, pose: FloatArray, ids: IntArray, px: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Make a keyframe, fill it with corners, locate points and adjust the window.

        Returns:
            numbers and pixels of all that is to be followed from here.
        """
        found_ids, found_px = self.recover(picture, pose, ids)
        ids, px = np.concatenate([ids, found_ids]), np.concatenate([px, found_px])
        corners = find_corners(picture.gray, self.settings.features, px)
        ids = np.concatenate([ids, self.map.add_points(corners.descriptors)])
        px = np.concatenate([px, corners.px])
        keyframe = self.append(picture, pose, ids, px)
        self.triangulate_newest()
        if self.settings.adjust:
            self.adjust_window()
        self._located_then = int(np.count_nonzero(self.map.located[keyframe.ids]))
        return self.followed()

    def followed(self) -> tuple[IntArray, FloatArray]:
        """Numbers and pixels of all that the newest keyframe sees and that is still believed."""
        newest = self.map.keyframes[-1]
        alive = self.map.alive[newest.ids]
        return newest.ids[alive], newest.px[alive]

    def depths(self, picture: Picture, px: FloatArray) -> FloatArray:
        """Depths ``(n,)`` at pixels from the depth image or the right picture; NaN elsewhere."""
        if picture.depth_m is not None:
            return depth_at(picture.depth_m, px)
        if picture.right is not None:
            return stereo_depth(picture.gray, picture.right, px, self.disparity_px_m)
        return np.full(len(px), np.nan)

    def recover(
        self, picture: Picture, pose: FloatArray, ids: IntArray
    ) -> tuple[IntArray, FloatArray]:
        """Points of the map that should be in view but are not followed, found again.

        They are followed from the keyframe's own picture, so they come back without drift.
        """
        height, width = picture.gray.shape
        followed = np.zeros(len(self.map.alive), dtype=np.bool_)
        followed[ids] = True
        all_ids, all_px = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 2))]
        hidden = []
        for keyframe in self.map.keyframes[-_PICTURES_KEPT:]:
            places = self.map.places[keyframe.ids]
            usable = self.map.located[keyframe.ids] & ~followed[keyframe.ids]
            expected, depth = project(pose, places, self.matrix)
            then = moved(keyframe.camera_T_world, places)[:, 2]
            with np.errstate(invalid="ignore", divide="ignore"):
                near = np.abs(np.log(depth / then)) < np.log(_SCALE_CHANGE)
                inside = np.all((expected > 0) & (expected < (width, height)), axis=1)
            rows = np.flatnonzero(usable & near & inside)
            if len(rows) >= _FEWEST_HIDDEN and keyframe.gray is not None:
                hidden.append((len(rows), keyframe, rows, expected))
        hidden.sort(key=lambda one: -one[0])
        for _, keyframe, rows, expected in hidden[:_RECOVERED_FROM]:
            rows = rows[~followed[keyframe.ids[rows]]]
            gray = keyframe.gray
            if gray is None or not len(rows):
                continue
            px, found = follow(gray, picture.gray, keyframe.px[rows], expected[rows])
            found &= np.linalg.norm(px - expected[rows], axis=1) < OUTLIER_PX
            all_ids.append(keyframe.ids[rows[found]])
            all_px.append(px[found])
            followed[all_ids[-1]] = True
        return np.concatenate(all_ids), np.concatenate(all_px)

    def triangulate_newest(self) -> None:
        """Locate points that the newest keyframe and an older one of the window see."""
        newest = self.map.keyframes[-1]
        for older in self.map.keyframes[-1 - self.settings.window : -1]:
            wanted = self.map.alive[newest.ids] & ~self.map.located[newest.ids]
            ids, rows, older_rows = np.intersect1d(
                newest.ids[wanted], older.ids, assume_unique=True, return_indices=True
            )
            if not len(ids):
                continue
            px, older_px = newest.px[wanted][rows], older.px[older_rows]
            poses = older.camera_T_world, newest.camera_T_world
            points = triangulate(*poses, older_px, px, self.matrix)
            good = parallax_rad(*poses, points) > _PARALLAX_RAD
            for pose, pixels in zip(poses, (older_px, px), strict=True):
                seen, depth = project(pose, points, self.matrix)
                error = np.linalg.norm(seen - pixels, axis=1)
                good &= (depth > 0.0) & (np.nan_to_num(error, nan=np.inf) < _GOOD_PX)
            self.map.places[ids[good]] = points[good]

    def adjust_window(self) -> None:
        """Adjust the newest keyframes and their points; older ones that see these stay fixed."""
        count = len(self.map.keyframes)
        free = np.arange(max(count - self.settings.window, 0), count)
        seen = np.unique(np.concatenate([self.map.keyframes[row].ids for row in free]))
        seen = seen[self.map.located[seen]]
        shared = self.map.shared(seen)
        shared[free] = 0
        fixed = np.argsort(-shared, kind="stable")[:_MOST_FIXED]
        fixed = np.sort(fixed[shared[fixed] > 0])
        self._adjust(np.concatenate([fixed, free]), len(fixed), seen)

    def adjust_all(self, iterations: int = 20) -> None:
        """Adjust the whole map; the first keyframe stays where it is."""
        rows = np.arange(len(self.map.keyframes))
        self._adjust(rows, 0, np.flatnonzero(self.map.located), iterations)

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
        result = adjust(
            Bundle(
                np.stack([self.map.keyframes[row].camera_T_world for row in rows]), fixed,
                self.map.places[points], owner[used], slot[ids[used]], px[used], depth[used],
                self.matrix, self.disparity_px_m, self.settings.depth_sigma_px,
            ), iterations,
        )  # fmt: skip
        for row, pose in zip(rows, result.poses, strict=True):
            self.map.keyframes[row].camera_T_world = pose
        self.map.places[points] = result.points
        self._cull(rows, points, owner, used, result)

    def _cull(
        self, rows: IntArray, points: IntArray, owner: IntArray, used: np.ndarray, result: Adjusted
    ) -> None:
        """Drop observations that do not agree, and points that nothing holds any more."""
        good = np.ones(len(owner), dtype=np.bool_)
        good[used] = result.error_px <= OUTLIER_PX
        held = np.zeros(len(self.map.alive), dtype=np.int64)
        for position, row in enumerate(rows):
            keyframe = self.map.keyframes[row]
            keyframe.keep(good[owner == position])
            held[keyframe.ids] += 1 + np.isfinite(keyframe.depth)
        loose = points[held[points] < 2]
        self.map.alive[loose] = False
