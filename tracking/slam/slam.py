"""Visual SLAM: pictures in, a pose and a state a frame out, and a map in the end.

World: the camera of the first keyframe (OpenCV axes). Lengths are metres with depth or a stereo
pair; with one camera alone their unit is free (the median depth of the first map is 1), and only a
comparison that frees the scale makes sense.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorcade.ga import FloatArray, IntArray, Motor, Trajectory
from motorcade.tracking.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.slam.features import DepthImage, Picture, find_corners
from motorcade.tracking.slam.geometry import PosedPicture, inverse, refine_pose
from motorcade.tracking.slam.initialise import FEWEST_CORNERS, Start, TwoViewInitialiser
from motorcade.tracking.slam.loops import close_loop, find_loop
from motorcade.tracking.slam.map import MapSnapshot, SlamMap
from motorcade.tracking.slam.mapper import Mapper
from motorcade.tracking.slam.relocalise import candidates, verified
from motorcade.tracking.slam.settings import SlamSettings
from motorcade.tracking.slam.tracker import Tracker, trusted

__all__ = ["SLAM_STATES", "SlamResult", "State", "TrackedFrame", "VisualSlam"]

State = Literal["initialising", "tracking", "lost", "relocalised"]
SLAM_STATES: tuple[State, ...] = ("initialising", "tracking", "lost", "relocalised")
_FEWEST_WITH_DEPTH = 60
_CANDIDATES = 4
_LOOP_ITERATIONS = 10


@dataclass(frozen=True, eq=False)
class TrackedFrame:
    """What is known of a frame as soon as it has been seen.

    Args:
        time_ns: stamp; state: one of `SLAM_STATES`.
        world_T_camera: the pose; None while initialising or lost.
        covariance: ``(6, 6)`` of the right perturbation, rotation (rad) then translation.
        inliers: corners that agree with the pose.
        keyframe: whether the map grew by it.
    """

    time_ns: int
    state: State
    world_T_camera: Motor | None = None
    covariance: FloatArray | None = None
    inliers: int = 0
    keyframe: bool = False


@dataclass(frozen=True, eq=False)
class SlamResult:
    """A whole recording.

    Args:
        trajectory: world_T_camera of every frame that has a pose, as the final map corrects it;
            None if there is none.
        covariance: ``(n, 6, 6)`` of these poses within the map, rotation (rad) then translation.
        time_ns: ``(f,)`` stamps of all frames; states: theirs.
        online: world_T_camera as given at the time, of the frames that had a pose then.
        map: keyframes and points.
        metric: whether lengths are metres.
        loops: how many loops were closed.
        seconds: time spent a part: "tracking", "mapping".
    """

    trajectory: Trajectory | None
    covariance: FloatArray
    time_ns: np.ndarray
    states: tuple[State, ...]
    online: Trajectory | None
    map: MapSnapshot
    metric: bool
    loops: int
    seconds: dict[str, float]


@dataclass(frozen=True, eq=False)
class _Remembered:
    """A frame's pose relative to a keyframe, which is all that is kept of it."""

    time_ns: int
    keyframe: int
    camera_T_keyframe: FloatArray
    covariance: FloatArray
    online: FloatArray | None


class VisualSlam:
    """Tracks a camera and maps what it sees; feed frames in order of time.

    Args:
        camera: the camera; its lens is taken out of every picture first.
        settings: see `SlamSettings`.
    """

    def __init__(self, camera: Camera, settings: SlamSettings | None = None) -> None:
        self.camera = camera
        self.settings = (settings or SlamSettings()).for_size(camera.width, camera.height)
        self._matrix = np.array(camera.matrix)
        self._map = SlamMap()
        self._mapper = Mapper(self._map, self._matrix, self.settings)
        self._tracker = Tracker(self._map, self._matrix)
        self._initialiser = TwoViewInitialiser(self._matrix, self.settings.features)
        self._state: State = "initialising"
        self._metric = False
        self._loops = 0
        self._frames: list[tuple[int, State]] = []
        self._remembered: list[_Remembered] = []
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
        mapped = self._seconds["mapping"]
        picture = self._picture(time_ns, gray, depth_m, right)
        if self._state == "initialising":
            frame = self._initialised(picture)
        elif self._state == "lost":
            frame = self._relocalised(picture)
        else:
            frame = self._tracked(picture)
        self._state = frame.state
        self._frames.append((frame.time_ns, frame.state))
        spent = time.perf_counter() - started
        self._seconds["tracking"] += spent - (self._seconds["mapping"] - mapped)
        return frame

    def finish(self, *, adjust: bool = True) -> SlamResult:
        """Adjust the whole map once more (unless `adjust` is False) and give everything.

        Raises:
            ValueError: no frame was tracked at all.
        """
        if not self._frames:
            raise ValueError("VisualSlam.finish: expected at least one frame, got none")
        if adjust and self.settings.adjust:
            self._mapper.adjust_all()
        kept = sorted(self._remembered, key=lambda one: one.time_ns)
        final = [
            one.camera_T_keyframe @ self._map.keyframes[one.keyframe].camera_T_world for one in kept
        ]
        seen = [one for one in kept if one.online is not None]
        return SlamResult(
            trajectory=_trajectory([one.time_ns for one in kept], final),
            covariance=np.array([one.covariance for one in kept]).reshape(-1, 6, 6),
            time_ns=np.array([stamp for stamp, _ in self._frames], dtype=np.int64),
            states=tuple(state for _, state in self._frames),
            online=_trajectory(
                [one.time_ns for one in seen],
                [one.online for one in seen if one.online is not None],
            ),
            map=self._map.snapshot(),
            metric=self._metric,
            loops=self._loops,
            seconds=dict(self._seconds),
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
        self._metric = True
        ids = self._map.add_points(corners.descriptors)
        ids, px = self._mapper.insert(picture, np.eye(4), ids, corners.px)
        self._tracker.restart(picture, np.eye(4), ids, px)
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
        self._tracker.restart(start.second, second_pose, ids[alive], start.second_px[alive])
        return self._mapped(start.second, posed, "tracking")

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
        if posed is None:
            return TrackedFrame(picture.time_ns, "lost")
        if self._mapper.wants(picture, self._tracker.ids, self._tracker.px):
            return self._mapped(picture, posed, "tracking")
        self._remember(picture.time_ns, posed.camera_T_world, posed.covariance)
        return _frame(picture, posed, "tracking", posed.camera_T_world, False)

    def _mapped(self, picture: Picture, posed: PosedPicture, state: State) -> TrackedFrame:
        """Make a keyframe of a tracked picture; its pose is then what the adjustment says."""
        started = time.perf_counter()
        tracker = self._tracker
        ids, px = self._mapper.insert(picture, posed.camera_T_world, tracker.ids, tracker.px)
        if self.settings.close_loops and self._metric:
            loop = find_loop(self._map, self.settings.features, self._matrix)
            if loop is not None:
                close_loop(self._map, loop)
                self._mapper.adjust_all(_LOOP_ITERATIONS)
                self._loops += 1
                ids, px = self._mapper.followed()
        pose = self._map.keyframes[-1].camera_T_world
        tracker.accept(picture, pose, ids, px)
        self._remember(picture.time_ns, pose, posed.covariance)
        self._seconds["mapping"] += time.perf_counter() - started
        return _frame(picture, posed, state, pose, True)

    def _relocalised(self, picture: Picture) -> TrackedFrame:
        """Look for the map in the picture; what is found is sharpened before it is believed."""
        corners = find_corners(picture.gray, self.settings.features)
        rows = candidates(self._map, corners, _CANDIDATES)
        found = verified(self._map, corners, rows, self._matrix)
        if found is None:
            return TrackedFrame(picture.time_ns, "lost")
        nothing = np.zeros(0, dtype=np.int64)
        ids, px = self._mapper.recover(picture, found.posed.camera_T_world, nothing)
        if len(ids) < len(found.ids):
            ids, px = found.ids, found.px
        posed = self._refined(found.posed.camera_T_world, ids, px)
        if not trusted(posed, px, picture.gray.shape):
            return TrackedFrame(picture.time_ns, "lost")
        kept = posed.inliers
        self._tracker.restart(picture, posed.camera_T_world, ids[kept], px[kept])
        self._remember(picture.time_ns, posed.camera_T_world, posed.covariance)
        return _frame(picture, posed, "relocalised", posed.camera_T_world, False)

    # Bookkeeping ---------------------------------------------------------------------------------

    def _remember(
        self, time_ns: int, pose: FloatArray, covariance: FloatArray, *, online: bool = True
    ) -> None:
        newest = len(self._map.keyframes) - 1
        camera_T_keyframe = pose @ inverse(self._map.keyframes[newest].camera_T_world)
        given = np.array(pose) if online else None
        self._remembered.append(_Remembered(time_ns, newest, camera_T_keyframe, covariance, given))

    def _picture(
        self, time_ns: int, gray: GrayImage, depth_m: DepthImage | None, right: GrayImage | None
    ) -> Picture:
        if isinstance(time_ns, bool) or not isinstance(time_ns, (int, np.integer)):
            raise ValueError(f"time_ns: expected whole nanoseconds, got {time_ns!r}")
        if self._frames and time_ns <= self._frames[-1][0]:
            raise ValueError(f"time_ns: expected more than {self._frames[-1][0]}, got {time_ns}")
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


def _trajectory(stamps: list[int], poses: list[FloatArray]) -> Trajectory | None:
    if not stamps:
        return None
    world_T_camera = Motor.from_matrix(inverse(np.stack(poses)))
    return Trajectory(np.array(stamps, dtype=np.int64), world_T_camera)
