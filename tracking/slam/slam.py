"""Visual SLAM: images in, a pose and a state a frame out, and a map in the end.

World: the camera of the first keyframe (OpenCV axes). Lengths are metres with depth or a stereo
pair; with one camera alone their unit is free (the median depth of the first map is 1), and only a
comparison that frees the scale makes sense. Where the camera stays lost a new map begins, with a
world of its own, until both are seen to show the same.
"""

from __future__ import annotations

import time
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.frame_history import SlamState
from motorcade.tracking.slam.features import DepthImage, SlamImage, find_corners
from motorcade.tracking.slam.geometry import (
    FEWEST_CORNERS,
    FittedPose,
    TwoViewInitialiser,
    TwoViewStart,
    in_world,
    is_native,
    refine_pose,
    seen_through,
)
from motorcade.tracking.slam.mapping.adjustment import Adjuster
from motorcade.tracking.slam.mapping.loops import ClosedLoop
from motorcade.tracking.slam.mapping.map import MapSnapshot, SlamMap
from motorcade.tracking.slam.mapping.mapper import InsertedKeyframe, Mapper
from motorcade.tracking.slam.mapping.matching import candidates, verified
from motorcade.tracking.slam.results import KeyframeAnchor, RunLog, SlamFrame, SlamResult
from motorcade.tracking.slam.settings import SlamSettings
from motorcade.tracking.slam.tracker import TrackedPoints, Tracker, is_reliable

_LOST_FRAMES = 3  # in which nothing is found in the maps there are; in the last a new one may begin
_CANDIDATES = 4
_SAME_UNIT = 1e-9
_ENOUGH_POINTS = 12
_MOST_BETWEEN = 48  # frames whose corners are kept until the next keyframe


class VisualSlam:
    """Tracks a camera and maps what it sees; feed frames in order of time.

    Args:
        camera: the camera; its lens is taken out of every image first, but for a fisheye's
            (equidistant), whose images are tracked as they are, to 90 degrees and beyond.
        settings: see `SlamSettings`.
        known: a map to go on in. The camera is lost until it is found there; then it is tracked.
        extend: whether keyframes are inserted into a known map; if not, it is left as it is.

    Raises:
        ValueError: a known map in which no keyframe sees a point, so that nothing can be found.

    >>> import numpy as np
    >>> from motorcade.tracking import Camera, VisualSlam
    >>> noise = np.random.default_rng(0).integers(0, 255, (60, 80)).astype(np.uint8)
    >>> wall = np.kron(noise, np.ones((6, 6), np.uint8))  # 2 m away; the camera moves to the right
    >>> slam = VisualSlam(Camera(320, 240, 250.0, 250.0, 159.5, 119.5))
    >>> for step in range(3):
    ...     image = wall[50:290, 50 + 5 * step : 370 + 5 * step]  # 5 px = 0.04 m
    ...     frame = slam.track(step * 33_000_000, image, np.full((240, 320), 2.0, np.float32))
    >>> frame.state, bool(abs(frame.world_T_camera.translation_m[0] - 0.08) < 0.01)
    ('tracking', True)
    >>> result = slam.finish()
    >>> result.trajectory
    Trajectory(world_T_camera, 3 poses, 0.066 s)
    >>> result.metric, len(result.map.points) > 100
    (True, True)
    """

    def __init__(
        self,
        camera: Camera,
        settings: SlamSettings | None = None,
        *,
        known: MapSnapshot | None = None,
        extend: bool = False,
    ) -> None:
        if known is not None and not len(known.keyframe_of):
            raise ValueError("known: expected a map whose keyframes see points, got none")
        self.camera = camera
        self.settings = (settings or SlamSettings()).for_size(camera.width, camera.height)
        self._pinhole = seen_through(camera)
        self._map = SlamMap() if known is None else SlamMap.of(known)
        self._extends = known is None or extend
        self._mapper = Mapper(self._map, self._pinhole, self.settings)
        self._known = known is not None
        self._tracker = Tracker(self._pinhole)
        self._starter = MapStarter(self._mapper)
        self._lost_frames = 0
        self._state: SlamState = "initialising" if known is None else "lost"
        self._loops: list[ClosedLoop] = []
        self._log = RunLog()
        self._anchor = KeyframeAnchor(0, 0, Motor.identity())
        self._between: deque[tuple[int, IntArray, FloatArray]] = deque(maxlen=_MOST_BETWEEN)
        self._worker: ThreadPoolExecutor | None = None
        self._inserting: Future[InsertedKeyframe] | None = None
        self._seconds = {"tracking": 0.0, "mapping": 0.0}

    def track(
        self,
        time_ns: int,
        gray: GrayImage,
        depth_m: DepthImage | None = None,
        right: GrayImage | None = None,
        *,
        predicted: Motor | None = None,
    ) -> SlamFrame:
        """Take the next frame.

        Args:
            time_ns: its stamp, later than that of the frame before.
            gray: ``(height, width)`` uint8, of the camera's size.
            depth_m: depth registered to `gray`, the same size, NaN where unknown.
            right: the right image of a rectified pair, which needs `SlamSettings.baseline_m`.
            predicted: world_T_camera that something else (an IMU, say) expects, in the map's units:
                points are looked for where it puts them, in tracking and when lost.

        Raises:
            ValueError: another type or size of image, a stamp that is not later, or a right
                image without a baseline.
        """
        started = time.perf_counter()
        waited = self._seconds["mapping"]
        image = self._image(time_ns, gray, depth_m, right)
        if self._inserting is not None and self._inserting.done():
            self._settle()
        if self._state == "initialising":
            frame = self._started(image) or SlamFrame(image.time_ns, "initialising")
        elif self._state == "lost":
            frame = self._found_again(image, predicted)
        else:
            frame = self._tracked(image, predicted)
        self._state = frame.state
        self._log.saw(frame, self._map.keyframe_count)
        spent = time.perf_counter() - started
        if not self.settings.threads:
            spent -= self._seconds["mapping"] - waited
        self._seconds["tracking"] += spent
        return frame

    def rescale(self, world_T_map: Similarity, adjuster: Adjuster | None = None) -> None:
        """Take the map to a world in metres, and all that was said of its frames before with it.

        It is the map that is tracked in; others, which nothing connects to it, stay as they are.

        Args:
            world_T_map: from the map's world and unit.
            adjuster: adjusts keyframes and points from now on, by more than images.

        Raises:
            ValueError: a scale that is not 1 for a map that is in metres already.
        """
        scale = float(world_T_map.scale)
        if self._mapper.metric and abs(scale - 1.0) > _SAME_UNIT:
            raise ValueError(f"world_T_map: expected scale 1 for a map in metres, got {scale:.6g}")
        self._settle()
        self._map.rescale(self._mapper.active, world_T_map)
        self._anchor = replace(
            self._anchor, world_T_camera=in_world(world_T_map, self._anchor.world_T_camera)
        )
        self._tracker.rescale(world_T_map)
        self._log.rescale(world_T_map, self._map.rows_of(self._mapper.active))
        self._mapper.metric, self._mapper.adjuster = True, adjuster

    @property
    def metric(self) -> bool:
        """Whether the map that is tracked in is in metres."""
        return self._mapper.metric

    @property
    def loops(self) -> tuple[ClosedLoop, ...]:
        """Those closed so far, and maps that were joined."""
        return tuple(self._loops)

    def adjust_at_next_keyframe(self) -> None:
        """Let the whole map be adjusted when the next keyframe is made, not only its window."""
        self._mapper.adjusts_all = True

    def snapshot(self) -> MapSnapshot:
        """The map that is tracked in, as it is now: keyframes, points, and where which was seen.

        With threads it waits for the keyframe that is being made.
        """
        self._settle()
        return self._map.snapshot(self._mapper.active)

    def finish(self, *, adjust: bool = True) -> SlamResult:
        """Adjust the whole map once more (unless `adjust` is False) and give everything.

        Raises:
            ValueError: no frame was tracked at all.
        """
        if not self._log.frames:
            raise ValueError("VisualSlam.finish: expected at least one frame, got none")
        self._settle()
        if self._worker is not None:
            self._worker.shutdown()
            self._worker = None
        if adjust and self.settings.adjust and self._extends:
            self._mapper.adjust_all()
            self._measure_again()
        seconds = dict(self._seconds)
        return self._log.result(self._map, known=self._known, loops=self._loops, seconds=seconds)

    # Frames in each state ------------------------------------------------------------------------

    def _started(self, image: SlamImage) -> SlamFrame | None:
        """Begin a map, once the images allow it."""
        started = self._starter.feed(image)
        if started is None:
            return None
        self._anchor = KeyframeAnchor(started.row, self._mapper.active, Motor.identity())
        for stamp, pose, covariance in started.between:
            self._remember(stamp, pose, covariance, online=False)
        self._tracker.restart(started.tracked)
        if started.fit is not None:
            return self._mapped(image, started.fit)
        if started.inserted is not None:
            self._take(started.inserted)
        pose, covariance = self._anchor.world_T_camera, np.eye(6) * 1e-12
        self._remember(image.time_ns, pose, covariance)
        count = int(np.count_nonzero(started.tracked.located))
        number = self._anchor.map_number
        return SlamFrame(image.time_ns, "tracking", pose, covariance, count, True, number)

    def _refined(self, pose: Motor, ids: IntArray, px: FloatArray) -> FittedPose:
        return refine_pose(pose, self._map.points[ids], px, self._pinhole)

    def _tracked(self, image: SlamImage, predicted: Motor | None) -> SlamFrame:
        fit = self._tracker.step(image, predicted)
        if fit is None and self._inserting is not None:
            # Without the points that are being made the camera would be lost: wait for them.
            self._settle()
            fit = self._tracker.step(image, predicted)
        if fit is None:
            self._tracker.lose()
            self._starter.forget()
            self._lost_frames = 0
            return self._found_again(image, predicted)
        if self._inserting is None and self._tracker.wants_keyframe():
            if self._extends:
                return self._mapped(image, fit)
            tracked = self._tracker.tracked
            self._tracker.anchor(self._mapper.seen_again(tracked), tracked.world_T_camera)
        row = self._remember(image.time_ns, fit.world_T_camera, fit.covariance)
        tracked = self._tracker.tracked
        self._between.append((row, tracked.ids, tracked.px))
        state: SlamState = "weak" if self._tracker.is_weak else "tracking"
        return self._frame(image, fit, state, fit.world_T_camera, False)

    def _mapped(self, image: SlamImage, fit: FittedPose) -> SlamFrame:
        """Make a keyframe of a tracked image; without threads its pose is the adjusted one."""
        pose = fit.world_T_camera
        tracked = self._tracker.tracked
        state: SlamState = "weak" if self._tracker.is_weak else "tracking"
        work = (image, pose, tracked.ids, tracked.px)
        self._anchor = KeyframeAnchor(len(self._map.keyframes), self._mapper.active, pose)
        if self.settings.threads:
            self._worker = self._worker or ThreadPoolExecutor(1, "slam mapping")
            self._inserting = self._worker.submit(self._mapper.insert_keyframe, *work)
        else:
            self._take(self._mapper.insert_keyframe(*work))
            pose = self._anchor.world_T_camera
        self._remember(image.time_ns, pose, fit.covariance)
        return self._frame(image, fit, state, pose, True)

    def _settle(self) -> None:
        """Wait for the keyframe that is being made, if one is, and take over what became of it."""
        if self._inserting is None:
            return
        inserting, self._inserting = self._inserting, None
        self._take(inserting.result())

    def _take(self, inserted: InsertedKeyframe) -> None:
        tracked, stretch = inserted.tracked, inserted.stretch
        jumped = None if inserted.closed is None else stretch
        self._tracker.anchor(tracked, self._anchor.world_T_camera, jumped)
        number = self._mapper.active
        self._anchor = KeyframeAnchor(self._anchor.row, number, tracked.world_T_camera, stretch)
        if inserted.culled is not None:
            self._log.hang_on(inserted.culled)
        if inserted.closed is not None:
            self._loops.append(inserted.closed)
        self._measure_again()
        self._seconds["mapping"] += inserted.seconds

    def _measure_again(self) -> None:
        """Frames since the last keyframe, by points that are better known now than when tracked."""
        while self._between:
            row, ids, px = self._between.popleft()
            known = self._map.located[ids]
            seen = px[known]
            if len(seen) >= _ENOUGH_POINTS:
                self._log.refine(self._map, row, partial(self._refined, ids=ids[known], px=seen))

    def _found_again(self, image: SlamImage, predicted: Motor | None) -> SlamFrame:
        """Look for the camera in the maps there are; where it stays lost, begin a new one."""
        self._settle()
        frame = self._found_as_predicted(image, predicted) or self._relocalised(image)
        if frame is not None:
            return frame
        self._lost_frames += 1
        begins = self._extends and self.settings.new_maps
        if begins and self._lost_frames >= _LOST_FRAMES:
            frame = self._started(image)
        return frame or SlamFrame(image.time_ns, "lost")

    def _found_as_predicted(self, image: SlamImage, predicted: Motor | None) -> SlamFrame | None:
        """Look for points of the newest keyframes where a predicted pose puts them."""
        if predicted is None:
            return None
        ids, px = self._mapper.recover(image, predicted, self._mapper.active)
        fit = self._refined(predicted, ids, px)
        row = int(self._map.rows_of(self._mapper.active)[-1])
        return self._gone_on(image, fit, ids, px, row)

    def _relocalised(self, image: SlamImage) -> SlamFrame | None:
        """Look for the maps in the image; what is found is refined, then checked."""
        corners = find_corners(image.gray, self.settings.features)
        rows = candidates(self._map, corners, _CANDIDATES)
        recognised = verified(self._map, corners, rows, self._pinhole)
        if recognised is None:
            return None
        number = self._map.keyframes[recognised.keyframe].map_number
        ids, px = self._mapper.recover(image, recognised.fit.world_T_camera, number)
        if len(ids) < len(recognised.ids):
            ids, px = recognised.ids, recognised.px
        fit = self._refined(recognised.fit.world_T_camera, ids, px)
        return self._gone_on(image, fit, ids, px, recognised.keyframe)

    def _gone_on(
        self, image: SlamImage, fit: FittedPose, ids: IntArray, px: FloatArray, row: int
    ) -> SlamFrame | None:
        """Track on from a pose that was found again by the keyframe `row`, if it is reliable."""
        if not is_reliable(fit, px, image.gray.shape):
            return None
        pose, ids, px = fit.world_T_camera, ids[fit.inliers], px[fit.inliers]
        self._tracker.restart(TrackedPoints(image, pose, ids, px, self._map.points[ids]))
        anchor = self._map.keyframes[row]
        self._mapper.active = anchor.map_number
        self._anchor = KeyframeAnchor(row, anchor.map_number, anchor.world_T_camera, anchor.scale)
        self._remember(image.time_ns, pose, fit.covariance)
        return self._frame(image, fit, "relocalised", pose, False)

    def _frame(
        self, image: SlamImage, fit: FittedPose, state: SlamState, pose: Motor, keyframe: bool
    ) -> SlamFrame:
        count, number = int(np.count_nonzero(fit.inliers)), self._anchor.map_number
        return SlamFrame(image.time_ns, state, pose, fit.covariance, count, keyframe, number)

    # Bookkeeping ---------------------------------------------------------------------------------

    def _remember(
        self, time_ns: int, pose: Motor, covariance: FloatArray, *, online: bool = True
    ) -> int:
        return self._log.note(time_ns, self._anchor, pose, covariance, online=online)

    def _image(
        self, time_ns: int, gray: GrayImage, depth_m: DepthImage | None, right: GrayImage | None
    ) -> SlamImage:
        if isinstance(time_ns, bool) or not isinstance(time_ns, (int, np.integer)):
            raise ValueError(f"time_ns: expected whole nanoseconds, got {time_ns!r}")
        if self._log.frames and time_ns <= self._log.frames[-1].time_ns:
            raise ValueError(
                f"time_ns: expected more than {self._log.frames[-1].time_ns}, got {time_ns}"
            )
        if right is not None and self.settings.baseline_m is None:
            raise ValueError("right: expected SlamSettings.baseline_m with a right image, got None")
        if is_native(self.camera):
            return self._fisheye(time_ns, gray, depth_m, right)
        straight = self.camera.undistort_image(checked_gray(gray))
        depth = None if depth_m is None else self.camera.undistort_depth(depth_m)
        other = None if right is None else self.camera.undistort_image(checked_gray(right))
        return SlamImage(int(time_ns), straight, depth, other)

    def _fisheye(
        self, time_ns: int, gray: GrayImage, depth_m: DepthImage | None, right: GrayImage | None
    ) -> SlamImage:
        """The image as it is; checked as those are that a lens is taken out of."""
        size = (self.camera.height, self.camera.width)
        for name, image in (("gray", checked_gray(gray)), ("depth_m", depth_m)):
            if image is not None and image.shape != size:
                raise ValueError(f"{name}: expected shape {size}, got {image.shape}")
        if right is not None:
            raise ValueError("right: expected none with a fisheye, whose pairs are not rectified")
        return SlamImage(int(time_ns), gray, depth_m)


_FEWEST_WITH_DEPTH = 60


@dataclass(frozen=True, eq=False)
class StartedMap:
    """A map that has just been started; its world is its first keyframe's camera.

    Args:
        row: of the first keyframe.
        tracked: the newest image's points.
        inserted: what became of the first keyframe, where the newest image is that itself.
        fit: the newest image's pose where it is not.
        between: stamp, pose and covariance of frames that came before the newest one.
    """

    row: int
    tracked: TrackedPoints
    inserted: InsertedKeyframe | None = None
    fit: FittedPose | None = None
    between: tuple[tuple[int, Motor, FloatArray], ...] = ()


class MapStarter:
    """Starts maps from images.

    Args:
        mapper: makes their keyframes; where it has some already, those belong to another map.
    """

    def __init__(self, mapper: Mapper) -> None:
        self._mapper = mapper
        self.forget()

    def forget(self) -> None:
        """Begin with the next image, whatever came before."""
        features = self._mapper.settings.features
        self._initialiser = TwoViewInitialiser(self._mapper.camera, features)

    def feed(self, image: SlamImage) -> StartedMap | None:
        """Take the next image; a map once one is started."""
        if image.depth_m is not None or image.right is not None:
            return self._by_depth(image)
        start = self._initialiser.feed(image)
        return None if start is None else self._by_two_views(start)

    def _by_depth(self, image: SlamImage) -> StartedMap | None:
        mapper = self._mapper
        corners = find_corners(image.gray, mapper.settings.features)
        known = np.isfinite(mapper.depths(image, corners.px))
        if len(corners) < FEWEST_CORNERS or np.count_nonzero(known) < _FEWEST_WITH_DEPTH:
            return None
        self._make_room(metric=True)
        nothing = np.zeros(0, dtype=np.int64), np.zeros((0, 2))
        row = len(mapper.map.keyframes)
        inserted = mapper.insert_keyframe(image, Motor.identity(), *nothing)
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
