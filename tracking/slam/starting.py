"""Starting a map: from one picture with depth (or a stereo pair), or from two views of one camera.

The first map starts so, and each further one where the camera stays lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.slam.features import SlamPicture, find_corners
from motorcade.tracking.slam.geometry import FittedPose, refine_pose
from motorcade.tracking.slam.initialise import FEWEST_CORNERS, TwoViewInitialiser, TwoViewStart
from motorcade.tracking.slam.mapping.mapper import InsertedKeyframe, Mapper
from motorcade.tracking.slam.tracker import TrackedPoints, is_reliable

_FEWEST_WITH_DEPTH = 60


@dataclass(frozen=True, eq=False)
class StartedMap:
    """A map that has just been started; its world is its first keyframe's camera.

    Args:
        row: of the first keyframe.
        tracked: the newest picture's points.
        inserted: what became of the first keyframe, where the newest picture is that itself.
        fit: the newest picture's pose where it is not.
        between: stamp, pose and covariance of frames that came before the newest one.
    """

    row: int
    tracked: TrackedPoints
    inserted: InsertedKeyframe | None = None
    fit: FittedPose | None = None
    between: tuple[tuple[int, Motor, FloatArray], ...] = ()


class MapStarter:
    """Starts maps from pictures.

    Args:
        mapper: makes their keyframes; where it has some already, those belong to another map.
    """

    def __init__(self, mapper: Mapper) -> None:
        self._mapper = mapper
        self.forget()

    def forget(self) -> None:
        """Begin with the next picture, whatever came before."""
        features = self._mapper.settings.features
        self._initialiser = TwoViewInitialiser(self._mapper.camera, features)

    def feed(self, picture: SlamPicture) -> StartedMap | None:
        """Take the next picture; a map once one is started."""
        if picture.depth_m is not None or picture.right is not None:
            return self._by_depth(picture)
        start = self._initialiser.feed(picture)
        return None if start is None else self._by_two_views(start)

    def _by_depth(self, picture: SlamPicture) -> StartedMap | None:
        mapper = self._mapper
        corners = find_corners(picture.gray, mapper.settings.features)
        known = np.isfinite(mapper.depths(picture, corners.px))
        if len(corners) < FEWEST_CORNERS or np.count_nonzero(known) < _FEWEST_WITH_DEPTH:
            return None
        self._make_room(metric=True)
        nothing = np.zeros(0, dtype=np.int64), np.zeros((0, 2))
        row = len(mapper.map.keyframes)
        inserted = mapper.insert_keyframe(picture, Motor.identity(), *nothing)
        return StartedMap(row, inserted.tracked, inserted=inserted)

    def _by_two_views(self, start: TwoViewStart) -> StartedMap:
        mapper, slam_map = self._mapper, self._mapper.map
        self._make_room(metric=False)
        row = len(slam_map.keyframes)
        ids = slam_map.add_points(start.corners.descriptors)
        pose = Motor.identity()
        mapper.append(start.first, pose, ids, start.corners.px)
        mapper.append(start.second, start.views.first_T_second, ids, start.second_px)
        mapper.triangulate_newest()
        mapper.adjust_all()
        self._set_unit()
        # The second comes back as an ordinary keyframe, with corners of its own.
        second_pose = slam_map.keyframes.pop().world_T_camera
        between = []
        for stamp, rows, px in start.between:
            located = slam_map.located[ids[rows]]
            fit = self._refined(pose, ids[rows][located], px[located])
            if is_reliable(fit, px[located], start.first.gray.shape):
                pose = fit.world_T_camera
                between.append((stamp, pose, fit.covariance))
        located, alive = slam_map.located[ids], slam_map.alive[ids]
        fit = self._refined(second_pose, ids[located], start.second_px[located])
        points = slam_map.points[ids[alive]]
        tracked = TrackedPoints(
            start.second, second_pose, ids[alive], start.second_px[alive], points
        )
        first = (start.first.time_ns, Motor.identity(), np.eye(6) * 1e-12)
        return StartedMap(row, tracked, fit=fit, between=(first, *between))

    def _make_room(self, *, metric: bool) -> None:
        """Begin a map of its own where there is one already."""
        if self._mapper.map.keyframes:
            self._mapper.begin_map()
        self._mapper.metric = metric

    def _refined(self, pose: Motor, ids: IntArray, px: FloatArray) -> FittedPose:
        return refine_pose(pose, self._mapper.map.points[ids], px, self._mapper.camera)

    def _set_unit(self) -> None:
        """Make the median depth of the new map's first keyframe 1."""
        slam_map = self._mapper.map
        ids = slam_map.points_of(self._mapper.active)
        unit = float(np.median(slam_map.points[ids, 2]))
        slam_map.points[ids] /= unit
        for row in slam_map.rows_of(self._mapper.active):
            keyframe = slam_map.keyframes[row]
            pose = keyframe.world_T_camera
            keyframe.world_T_camera = Motor.from_rotor_translation(
                pose.rotor, pose.translation_m / unit
            )
