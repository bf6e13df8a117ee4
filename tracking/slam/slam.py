"""Visual SLAM: pictures in, a pose and a state a frame out, and a map in the end.

World: the camera of the first keyframe (OpenCV axes). Lengths are metres with depth or a stereo
pair; with one camera alone their unit is free (the median depth of the first map is 1), and only a
comparison that frees the scale makes sense.
"""

from __future__ import annotations

import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from motorcade.ga import FloatArray, IntArray, Motor
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.slam.features import DepthImage, Picture, find_corners
from motorcade.tracking.slam.geometry import PosedPicture, inverse, refine_pose
from motorcade.tracking.slam.initialise import FEWEST_CORNERS, Start, TwoViewInitialiser
from motorcade.tracking.slam.mapping.map import MapSnapshot, SlamMap
from motorcade.tracking.slam.mapping.mapper import Grown, Mapper
from motorcade.tracking.slam.mapping.relocalise import candidates, verified
from motorcade.tracking.slam.results import Diary, SlamResult, State, TrackedFrame
from motorcade.tracking.slam.settings import SlamSettings
from motorcade.tracking.slam.tracker import Followed, Tracker, trusted

__all__ = ["VisualSlam"]

_FEWEST_WITH_DEPTH = 60
_CANDIDATES = 4


@dataclass(frozen=True, eq=False)
class _Anchor:
    """The keyframe that poses are told from: its row, and the pose it had when it was tracked."""

    row: int
    camera_T_world: FloatArray


class VisualSlam:
    """Tracks a camera and maps what it sees; feed frames in order of time.

    Args:
        camera: the camera; its lens is taken out of every picture first.
        settings: see `SlamSettings`.
        known: a map to go on in. The camera is lost until it is found there; then it is tracked.
        extend: whether a known map grows by what is seen; if not, it is left as it is.
    """

    def __init__(
        self,
        camera: Camera,
        settings: SlamSettings | None = None,
        *,
        known: MapSnapshot | None = None,
        extend: bool = False,
    ) -> None:
        self.camera = camera
        self.settings = (settings or SlamSettings()).for_size(camera.width, camera.height)
        self._matrix = np.array(camera.matrix)
        self._map = SlamMap() if known is None else SlamMap.of(known)
        self._grows = known is None or extend
        self._mapper = Mapper(self._map, self._matrix, self.settings)
        self._mapper.metric = known is not None and known.metric
        self._tracker = Tracker(self._matrix)
        self._initialiser = TwoViewInitialiser(self._matrix, self.settings.features)
        self._state: State = "initialising" if known is None else "lost"
        self._loops = 0
        self._diary = Diary()
        self._anchor = _Anchor(0, np.eye(4))
        self._worker: ThreadPoolExecutor | None = None
        self._growing: Future[Grown] | None = None
        self._seconds = {"tracking": 0.0, "mapping": 0.0}

    def track(
        self,
        time_ns: int,
        gray: GrayImage,
        depth_m: DepthImage | None = None,
        right: GrayImage | None = None,
    ) -> TrackedFrame:
        """Take the next frame.

        Args:
            time_ns: its stamp, later than that of the frame before.
            gray: ``(height, width)`` uint8, of the camera's size.
            depth_m: depth registered to `gray`, the same size, NaN where unknown.
            right: the right picture of a rectified pair, which needs `SlamSettings.baseline_m`.

        Raises:
            ValueError: another type or size of picture, a stamp that is not later, or a right
                picture without a baseline.
        """
        started = time.perf_counter()
        waited = self._seconds["mapping"]
        picture = self._picture(time_ns, gray, depth_m, right)
        if self._growing is not None and self._growing.done():
            self._settle()
        if self._state == "initialising":
            frame = self._initialised(picture)
        elif self._state == "lost":
            frame = self._relocalised(picture)
        else:
            frame = self._tracked(picture)
        self._state = frame.state
        self._diary.frames.append((frame.time_ns, frame.state))
        spent = time.perf_counter() - started
        if not self.settings.threads:
            spent -= self._seconds["mapping"] - waited
        self._seconds["tracking"] += spent
        return frame

    def snapshot(self) -> MapSnapshot:
        """The map as it is now: keyframes, points, and where which was seen.

        With threads it waits for the keyframe that is being made.
        """
        self._settle()
        return self._map.snapshot(self._mapper.metric)

    def finish(self, *, adjust: bool = True) -> SlamResult:
        """Adjust the whole map once more (unless `adjust` is False) and give everything.

        Raises:
            ValueError: no frame was tracked at all.
        """
        if not self._diary.frames:
            raise ValueError("VisualSlam.finish: expected at least one frame, got none")
        self._settle()
        if self._worker is not None:
            self._worker.shutdown()
            self._worker = None
        if adjust and self.settings.adjust and self._grows:
            self._mapper.adjust_all()
        return self._diary.result(
            self._map, metric=self._mapper.metric, loops=self._loops, seconds=dict(self._seconds)
        )

    # Frames in each state ------------------------------------------------------------------------

    def _initialised(self, picture: Picture) -> TrackedFrame:
        if picture.depth_m is not None or picture.right is not None:
            return self._started_with_depth(picture)
        start = self._initialiser.feed(picture)
        return (
            TrackedFrame(picture.time_ns, "initialising") if start is None else self._begun(start)
        )

    def _started_with_depth(self, picture: Picture) -> TrackedFrame:
        corners = find_corners(picture.gray, self.settings.features)
        known = np.isfinite(self._mapper.depths(picture, corners.px))
        if len(corners) < FEWEST_CORNERS or np.count_nonzero(known) < _FEWEST_WITH_DEPTH:
            return TrackedFrame(picture.time_ns, "initialising")
        self._mapper.metric = True
        grown = self._mapper.grow(picture, np.eye(4), *_nothing())
        self._tracker.restart(grown.followed)
        self._tracker.anchor(grown.followed, np.eye(4))
        covariance = np.eye(6) * 1e-12  # the world is this camera
        self._remember(picture.time_ns, np.eye(4), covariance)
        return TrackedFrame(
            picture.time_ns, "tracking", Motor.identity(), covariance, int(known.sum()), True
        )

    def _begun(self, start: Start) -> TrackedFrame:
        """A map from two views, and the poses of the frames between them."""
        ids = self._map.add_points(start.corners.descriptors)
        self._mapper.append(start.first, np.eye(4), ids, start.corners.px)
        self._mapper.append(start.second, start.views.second_T_first, ids, start.second_px)
        self._mapper.triangulate_newest()
        self._mapper.adjust_all()
        self._set_unit()
        # The second comes back as an ordinary keyframe, with corners of its own.
        second_pose = self._map.keyframes.pop().camera_T_world
        self._remember(start.first.time_ns, np.eye(4), np.eye(6) * 1e-12, online=False)
        pose = np.eye(4)
        for stamp, rows, px in start.between:
            located = self._map.located[ids[rows]]
            posed = self._refined(pose, ids[rows][located], px[located])
            if trusted(posed, px[located], start.first.gray.shape):
                pose = posed.camera_T_world
                self._remember(stamp, pose, posed.covariance, online=False)
        located, alive = self._map.located[ids], self._map.alive[ids]
        posed = self._refined(second_pose, ids[located], start.second_px[located])
        places = self._map.places[ids[alive]]
        self._tracker.restart(
            Followed(start.second, second_pose, ids[alive], start.second_px[alive], places)
        )
        return self._mapped(start.second, posed)

    def _refined(self, pose: FloatArray, ids: IntArray, px: FloatArray) -> PosedPicture:
        return refine_pose(pose, self._map.places[ids], px, self._matrix)

    def _set_unit(self) -> None:
        """Make the median depth of the first keyframe 1."""
        places = self._map.places[self._map.located]
        unit = float(np.median(places[:, 2]))
        self._map.places[:] /= unit
        for keyframe in self._map.keyframes:
            keyframe.camera_T_world[:3, 3] /= unit

    def _tracked(self, picture: Picture) -> TrackedFrame:
        posed = self._tracker.step(picture)
        if posed is None and self._growing is not None:
            # Without the points that are being made the camera would be lost: wait for them.
            self._settle()
            posed = self._tracker.step(picture)
        if posed is None:
            self._tracker.lose()
            return TrackedFrame(picture.time_ns, "lost")
        if self._growing is None and self._tracker.wants_keyframe():
            if self._grows:
                return self._mapped(picture, posed)
            followed = self._tracker.followed
            self._tracker.anchor(self._mapper.seen_again(followed), followed.camera_T_world)
        self._remember(picture.time_ns, posed.camera_T_world, posed.covariance)
        return _frame(picture, posed, "tracking", posed.camera_T_world, False)

    def _mapped(self, picture: Picture, posed: PosedPicture) -> TrackedFrame:
        """Make a keyframe of a tracked picture; without threads its pose is the adjusted one."""
        pose = posed.camera_T_world
        followed = self._tracker.followed
        work = (picture, pose, followed.ids, followed.px)
        self._anchor = _Anchor(len(self._map.keyframes), pose)
        if self.settings.threads:
            self._worker = self._worker or ThreadPoolExecutor(1, "slam mapping")
            self._growing = self._worker.submit(self._mapper.grow, *work)
        else:
            self._take(self._mapper.grow(*work))
            pose = self._anchor.camera_T_world
        self._remember(picture.time_ns, pose, posed.covariance)
        return _frame(picture, posed, "tracking", pose, True)

    def _settle(self) -> None:
        """Wait for the keyframe that is being made, if one is, and take over what became of it."""
        if self._growing is None:
            return
        growing, self._growing = self._growing, None
        self._take(growing.result())

    def _take(self, grown: Grown) -> None:
        self._tracker.anchor(grown.followed, self._anchor.camera_T_world)
        self._anchor = _Anchor(self._anchor.row, grown.followed.camera_T_world)
        self._loops += grown.closed
        self._seconds["mapping"] += grown.seconds

    def _relocalised(self, picture: Picture) -> TrackedFrame:
        """Look for the map in the picture; what is found is sharpened before it is believed."""
        self._settle()
        corners = find_corners(picture.gray, self.settings.features)
        rows = candidates(self._map, corners, _CANDIDATES)
        found = verified(self._map, corners, rows, self._matrix)
        if found is None:
            return TrackedFrame(picture.time_ns, "lost")
        ids, px = self._mapper.recover(picture, found.posed.camera_T_world, _nothing()[0])
        if len(ids) < len(found.ids):
            ids, px = found.ids, found.px
        posed = self._refined(found.posed.camera_T_world, ids, px)
        if not trusted(posed, px, picture.gray.shape):
            return TrackedFrame(picture.time_ns, "lost")
        ids, px = ids[posed.inliers], px[posed.inliers]
        self._tracker.restart(
            Followed(picture, posed.camera_T_world, ids, px, self._map.places[ids])
        )
        row = found.keyframe
        self._anchor = _Anchor(row, np.array(self._map.keyframes[row].camera_T_world))
        self._remember(picture.time_ns, posed.camera_T_world, posed.covariance)
        return _frame(picture, posed, "relocalised", posed.camera_T_world, False)

    # Bookkeeping ---------------------------------------------------------------------------------

    def _remember(
        self, time_ns: int, pose: FloatArray, covariance: FloatArray, *, online: bool = True
    ) -> None:
        relative = pose @ inverse(self._anchor.camera_T_world)
        given = np.array(pose) if online else None
        self._diary.note(time_ns, self._anchor.row, relative, covariance, given)

    def _picture(
        self, time_ns: int, gray: GrayImage, depth_m: DepthImage | None, right: GrayImage | None
    ) -> Picture:
        if isinstance(time_ns, bool) or not isinstance(time_ns, (int, np.integer)):
            raise ValueError(f"time_ns: expected whole nanoseconds, got {time_ns!r}")
        if self._diary.frames and time_ns <= self._diary.frames[-1][0]:
            raise ValueError(
                f"time_ns: expected more than {self._diary.frames[-1][0]}, got {time_ns}"
            )
        if right is not None and self.settings.baseline_m is None:
            raise ValueError(
                "right: expected SlamSettings.baseline_m with a right picture, got None"
            )
        straight = self.camera.undistort_image(checked_gray(gray))
        depth = None if depth_m is None else self.camera.undistort_depth(depth_m)
        other = None if right is None else self.camera.undistort_image(checked_gray(right))
        return Picture(int(time_ns), straight, depth, other)


def _frame(
    picture: Picture, posed: PosedPicture, state: State, pose: FloatArray, keyframe: bool
) -> TrackedFrame:
    world_T_camera = Motor.from_matrix(inverse(pose))
    count = int(np.count_nonzero(posed.inliers))
    return TrackedFrame(picture.time_ns, state, world_T_camera, posed.covariance, count, keyframe)


def _nothing() -> tuple[IntArray, FloatArray]:
    """No points, nowhere."""
    return np.zeros(0, dtype=np.int64), np.zeros((0, 2))
