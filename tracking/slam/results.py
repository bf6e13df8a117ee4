"""What visual SLAM says: of a frame as soon as it has been seen, and of a whole recording.

Of every frame only its state and its pose relative to a keyframe are kept, so that a map that is
corrected later corrects it too, and memory grows with keyframes (whose corners are kept), hardly
with frames.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.frame_history import SlamEvent, SlamHistory, SlamState
from motorcade.tracking.slam.geometry import FittedPose, in_world
from motorcade.tracking.slam.mapping.loops import ClosedLoop
from motorcade.tracking.slam.mapping.map import MapSnapshot, SlamMap
from motorcade.tracking.slam.mapping.mapper import CulledKeyframe


@dataclass(frozen=True, eq=False)
class SlamFrame:
    """What is known of a frame as soon as it has been seen.

    Args:
        time_ns: stamp; state: one of `SLAM_STATES`.
        world_T_camera: the pose; None while initialising or lost.
        covariance: ``(6, 6)`` of the right perturbation, rotation (rad) then translation.
        inliers: how many corners the pose explains.
        keyframe: whether it became a keyframe of the map.
        map_number: in which map's world the pose is: 0 for the first (or the known) one, more for
            those begun where the camera stayed lost.

    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.slam import SlamFrame
    >>> lost = SlamFrame(0, "lost")
    >>> found = SlamFrame(50_000_000, "tracking", Motor.from_translation([0.1, 0, 0]), inliers=250)
    >>> [frame.time_ns for frame in (lost, found) if frame.world_T_camera is not None]
    [50000000]
    """

    time_ns: int
    state: SlamState
    world_T_camera: Motor | None = None
    covariance: FloatArray | None = None
    inliers: int = 0
    keyframe: bool = False
    map_number: int = 0


@dataclass(frozen=True, eq=False)
class SeparateMap:
    """A map that nothing connected to the main one; how its world lies there is not known.

    Args:
        trajectory: world_T_camera of the frames that have a pose in it; None if there are none.
        map: keyframes and points.
    """

    trajectory: Trajectory | None
    map: MapSnapshot


@dataclass(frozen=True, eq=False)
class SlamResult:
    """A whole recording.

    Where the camera stayed lost a new map was begun. If they met, they are one; if not, `map` is
    the one that was known from the start or else has the most frames, and the others are apart.

    Args:
        trajectory: world_T_camera of every frame that has a pose in `map`, as it is in the end;
            None if there is none.
        covariance: ``(n, 6, 6)`` of these poses within the map, rotation (rad) then translation.
        history: what became of every frame, and what happened on the way.
        online: world_T_camera as given at the time, of the frames that had a pose in it then.
        map: keyframes and points.
        separate: maps that were not connected to it.
        metric: whether lengths are metres.
        loops: those that were closed, and maps that were joined.
        seconds: time spent a part: "tracking", "mapping".

    >>> import numpy as np
    >>> from motorcade.tracking import Camera, VisualSlam
    >>> slam = VisualSlam(Camera(320, 240, 250.0, 250.0, 159.5, 119.5))
    >>> frame = slam.track(0, np.full((240, 320), 128, np.uint8))  # a grey wall shows no corners
    >>> result = slam.finish()
    >>> result.trajectory is None, result.states, len(result.map.points)
    (True, ('initialising',), 0)
    """

    trajectory: Trajectory | None
    covariance: FloatArray
    history: SlamHistory
    online: Trajectory | None
    map: MapSnapshot
    separate: tuple[SeparateMap, ...]
    metric: bool
    loops: tuple[ClosedLoop, ...]
    seconds: dict[str, float]

    @property
    def time_ns(self) -> IntArray:
        """Stamps ``(f,)`` of all frames."""
        return self.history.time_ns

    @property
    def states(self) -> tuple[SlamState, ...]:
        """States of all frames."""
        return self.history.states


@dataclass(frozen=True, eq=False)
class KeyframeAnchor:
    """The keyframe that poses are relative to.

    Args:
        row: its row, which may still have to be made.
        map_number: of the map that it belongs to.
        world_T_camera: its pose when it was tracked.
        scale: its `Keyframe.scale` then.
    """

    row: int
    map_number: int
    world_T_camera: Motor
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class _Entry:
    """A frame's pose relative to a keyframe, in the unit that lengths had there then."""

    time_ns: int
    keyframe: int
    scale: float
    map_number: int
    keyframe_T_camera: Motor
    covariance: FloatArray
    online: Motor | None


@dataclass(frozen=True)
class _Seen:
    """What became of a frame; `map_number` is -1 without a pose."""

    time_ns: int
    state: SlamState
    map_number: int
    inliers: int
    keyframes: int


class RunLog:
    """State and pose of every frame so far."""

    def __init__(self) -> None:
        self.frames: list[_Seen] = []
        self._entries: list[_Entry] = []
        self._entries_of: dict[int, list[int]] = {}

    def saw(self, frame: SlamFrame, keyframes: int) -> None:
        """Remember what became of a frame, and how many keyframes there are after it."""
        number = -1 if frame.world_T_camera is None else frame.map_number
        self.frames.append(_Seen(frame.time_ns, frame.state, number, frame.inliers, keyframes))

    def note(
        self,
        time_ns: int,
        anchor: KeyframeAnchor,
        world_T_camera: Motor,
        covariance: FloatArray,
        *,
        online: bool,
    ) -> int:
        """Remember a frame by a keyframe near it; returns its number, for `refine`.

        Args:
            time_ns: its stamp.
            anchor: the keyframe.
            world_T_camera: its pose.
            covariance: ``(6, 6)``.
            online: whether the pose was given at the time.
        """
        relative = anchor.world_T_camera.inverse() @ world_T_camera
        in_world = world_T_camera if online else None
        where = anchor.row, anchor.scale, anchor.map_number
        self._entries_of.setdefault(anchor.row, []).append(len(self._entries))
        self._entries.append(_Entry(time_ns, *where, relative, covariance, in_world))
        return len(self._entries) - 1

    def refine(self, slam_map: SlamMap, row: int, refined: Callable[[Motor], FittedPose]) -> None:
        """Measure a frame again by the map as it is now, from where the map puts it now.

        Args:
            slam_map: with its keyframe.
            row: as `note` gave it.
            refined: gives the pose that the frame's corners ask for, from one that is near.
        """
        entry = self._entries[row]
        keyframe = slam_map.keyframes[entry.keyframe]
        fit = refined(keyframe.world_T_camera @ _stretched(entry, keyframe.scale)[0])
        if np.isfinite(fit.covariance).all():
            relative = keyframe.world_T_camera.inverse() @ fit.world_T_camera
            self._entries[row] = replace(
                entry,
                scale=keyframe.scale,
                keyframe_T_camera=relative,
                covariance=fit.covariance,
            )

    def hang_on(self, culled: CulledKeyframe) -> None:
        """Tell the frames of a keyframe that left the map by the one that stands for it."""
        mine = self._entries_of.pop(culled.row, [])
        for row in mine:
            entry = self._entries[row]
            relative, covariance = _stretched(entry, culled.scale)
            self._entries[row] = replace(
                entry,
                keyframe=culled.kept,
                scale=culled.kept_scale,
                keyframe_T_camera=culled.kept_T_culled @ relative,
                covariance=covariance,
            )
        self._entries_of.setdefault(culled.kept, []).extend(mine)

    def rescale(self, world_T_map: Similarity, keyframes: IntArray) -> None:
        """Tell what was noted by these keyframes in another world, to which they were taken."""
        scale = float(world_T_map.scale)
        units = np.repeat([1.0, scale], 3)
        taken = set(keyframes.tolist())
        for row, entry in enumerate(self._entries):
            if entry.keyframe not in taken:
                continue
            relative = Motor.from_rotor_translation(
                entry.keyframe_T_camera.rotor, scale * entry.keyframe_T_camera.translation_m
            )
            online = None if entry.online is None else in_world(world_T_map, entry.online)
            spread = units[:, None] * entry.covariance * units
            self._entries[row] = replace(
                entry, keyframe_T_camera=relative, covariance=spread, online=online
            )

    def result(
        self, slam_map: SlamMap, *, known: bool, loops: list[ClosedLoop], seconds: dict[str, float]
    ) -> SlamResult:
        """Everything, by the map as it is now; the first keyframe's is the main one if `known`."""
        kept = sorted(self._entries, key=lambda entry: entry.time_ns)
        numbers = [slam_map.keyframes[one.keyframe].map_number for one in kept]
        held = np.bincount(numbers, minlength=len(slam_map.metric))
        main = slam_map.keyframes[0].map_number if known else int(np.argmax(held))
        by_map: dict[int, list[_Entry]] = {main: []}
        for entry, number in zip(kept, numbers, strict=True):
            by_map.setdefault(number, []).append(entry)
        mine = by_map.pop(main)
        poses, covariance = _corrected(slam_map, mine)
        seen = [
            (entry.time_ns, entry.online)
            for entry in mine
            if entry.online is not None and entry.map_number == main
        ]
        return SlamResult(
            trajectory=_trajectory([one.time_ns for one in mine], poses),
            covariance=covariance,
            history=_history(self.frames, loops),
            online=_trajectory([stamp for stamp, _ in seen], [pose for _, pose in seen]),
            map=slam_map.snapshot(main),
            separate=tuple(
                SeparateMap(
                    _trajectory([one.time_ns for one in apart], _corrected(slam_map, apart)[0]),
                    slam_map.snapshot(number),
                )
                for number, apart in sorted(by_map.items())
            ),
            metric=slam_map.metric[main],
            loops=tuple(loops),
            seconds=seconds,
        )


def _history(frames: list[_Seen], loops: list[ClosedLoop]) -> SlamHistory:
    numbers = np.array(
        [(one.map_number, one.inliers, one.keyframes) for one in frames], dtype=np.int64
    )
    map_number, inliers, keyframes = numbers.reshape(-1, 3).T.copy()
    events = [*_turns(frames), *(_closing(one) for one in loops)]
    return SlamHistory(
        np.array([one.time_ns for one in frames], dtype=np.int64),
        tuple(one.state for one in frames),
        map_number,
        inliers,
        keyframes,
        tuple(sorted(events, key=lambda event: event.time_ns)),
    )


def _turns(frames: list[_Seen]) -> Iterator[SlamEvent]:
    """Maps that were begun, and where the camera was lost and found again."""
    begun: set[int] = set()
    before: SlamState = "initialising"
    for frame in frames:
        if frame.state == "relocalised":
            yield SlamEvent(frame.time_ns, "relocalised", frame.map_number)
        elif frame.map_number >= 0 and frame.map_number not in begun:
            yield SlamEvent(frame.time_ns, "map begun", frame.map_number)
        elif frame.state == "lost" and before not in ("lost", "initialising"):
            yield SlamEvent(frame.time_ns, "lost", None)
        begun.add(frame.map_number)
        before = frame.state


def _closing(loop: ClosedLoop) -> SlamEvent:
    number, change = loop.maps[1], loop.correction
    scale = float(change.scale)
    if loop.maps[0] != number:  # two worlds: how far apart they are says nothing
        seen = loop.old_time_ns
        return SlamEvent(loop.time_ns, "maps joined", number, seen, stretched=scale)
    moved, turned = float(np.linalg.norm(change.translation_m)), float(change.rotor.angle())
    return SlamEvent(loop.time_ns, "loop closed", number, loop.old_time_ns, moved, turned, scale)


def _corrected(slam_map: SlamMap, entries: list[_Entry]) -> tuple[list[Motor], FloatArray]:
    """Poses and covariances ``(n, 6, 6)`` by the keyframes as they are now."""
    poses, covariances = [], np.zeros((len(entries), 6, 6))
    for row, entry in enumerate(entries):
        keyframe = slam_map.keyframes[entry.keyframe]
        relative, covariances[row] = _stretched(entry, keyframe.scale)
        poses.append(keyframe.world_T_camera @ relative)
    return poses, covariances


def _stretched(entry: _Entry, scale: float) -> tuple[Motor, FloatArray]:
    """A frame's pose from its keyframe, and its covariance, in the unit that is valid there now."""
    stretch, pose = scale / entry.scale, entry.keyframe_T_camera
    units = np.repeat([1.0, stretch], 3)
    relative = Motor.from_rotor_translation(pose.rotor, stretch * pose.translation_m)
    return relative, units[:, None] * entry.covariance * units


def _trajectory(stamps: list[int], poses: list[Motor]) -> Trajectory | None:
    if not stamps:
        return None
    return Trajectory(np.array(stamps, dtype=np.int64), Motor.stack(poses))
