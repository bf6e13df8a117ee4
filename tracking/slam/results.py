"""What visual SLAM says: of a frame as soon as it has been seen, and of a whole recording.

Of every frame only its state and its pose relative to a keyframe are kept, so that a map that is
corrected later corrects it too, and memory grows with keyframes (whose corners are kept), hardly
with frames.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.slam.geometry import in_world
from motorcade.tracking.slam.mapping.map import MapSnapshot, SlamMap

SlamState = Literal["initialising", "tracking", "lost", "relocalised"]
SLAM_STATES: tuple[SlamState, ...] = ("initialising", "tracking", "lost", "relocalised")


@dataclass(frozen=True, eq=False)
class SlamFrame:
    """What is known of a frame as soon as it has been seen.

    Args:
        time_ns: stamp; state: one of `SLAM_STATES`.
        world_T_camera: the pose; None while initialising or lost.
        covariance: ``(6, 6)`` of the right perturbation, rotation (rad) then translation.
        inliers: how many corners the pose explains.
        keyframe: whether it became a keyframe of the map.

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
    time_ns: np.ndarray
    states: tuple[SlamState, ...]
    online: Trajectory | None
    map: MapSnapshot
    metric: bool
    loops: int
    seconds: dict[str, float]


@dataclass(frozen=True, eq=False)
class _Entry:
    """A frame's pose relative to a keyframe."""

    time_ns: int
    keyframe: int
    keyframe_T_camera: Motor
    covariance: FloatArray
    online: Motor | None


class RunLog:
    """State and pose of every frame so far."""

    def __init__(self) -> None:
        self.frames: list[tuple[int, SlamState]] = []
        self._entries: list[_Entry] = []

    def note(
        self,
        time_ns: int,
        keyframe: int,
        keyframe_T_camera: Motor,
        covariance: FloatArray,
        online: Motor | None,
    ) -> None:
        """Remember a frame by a keyframe near it.

        Args:
            time_ns: its stamp.
            keyframe: row of the keyframe, which may still have to be made.
            keyframe_T_camera: its pose from there.
            covariance: ``(6, 6)``.
            online: world_T_camera as given at the time; None where none was given.
        """
        self._entries.append(_Entry(time_ns, keyframe, keyframe_T_camera, covariance, online))

    def rescale(self, world_T_map: Similarity) -> None:
        """Tell all that was noted in another world, to which the map was taken."""
        scale = float(world_T_map.scale)
        units = np.repeat([1.0, scale], 3)
        for row, one in enumerate(self._entries):
            relative = Motor.from_rotor_translation(
                one.keyframe_T_camera.rotor, scale * one.keyframe_T_camera.translation_m
            )
            online = None if one.online is None else in_world(world_T_map, one.online)
            spread = units[:, None] * one.covariance * units
            self._entries[row] = replace(
                one, keyframe_T_camera=relative, covariance=spread, online=online
            )

    def result(
        self, slam_map: SlamMap, *, metric: bool, loops: int, seconds: dict[str, float]
    ) -> SlamResult:
        """Everything, by the map as it is now."""
        kept = sorted(self._entries, key=lambda one: one.time_ns)
        final = [
            slam_map.keyframes[one.keyframe].world_T_camera @ one.keyframe_T_camera for one in kept
        ]
        seen = [(one.time_ns, one.online) for one in kept if one.online is not None]
        return SlamResult(
            trajectory=_trajectory([one.time_ns for one in kept], final),
            covariance=np.array([one.covariance for one in kept]).reshape(-1, 6, 6),
            time_ns=np.array([stamp for stamp, _ in self.frames], dtype=np.int64),
            states=tuple(state for _, state in self.frames),
            online=_trajectory([stamp for stamp, _ in seen], [pose for _, pose in seen]),
            map=slam_map.snapshot(metric),
            metric=metric,
            loops=loops,
            seconds=seconds,
        )


def _trajectory(stamps: list[int], poses: list[Motor]) -> Trajectory | None:
    if not stamps:
        return None
    return Trajectory(np.array(stamps, dtype=np.int64), Motor.stack(poses))
