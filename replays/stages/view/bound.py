"""A scene bound to a run: its anchors found, its objects read, played and carried over time."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from motorcade.animation import Clip, Placement
from motorcade.animation.authoring import Scene, between_keyframes
from motorcade.animation.authoring.parts import Interpolation
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.stages.characters.acted import MOST_POSES, Acted, acted, things_of
from motorcade.replays.stages.values.view import PlayedPart
from motorcade.replays.stages.view.anchored import Grounds
from motorcade.replays.stages.view.ground import Ground

# Poses are told so often, and at every frame besides: what curves between is off by micrometres.
RATE_HZ = 120.0


@dataclass(frozen=True, eq=False)
class BoundScene:
    """A scene over the time of a recording.

    Args:
        scene: as it was read.
        folder: that its files are named from.
        grounds: what of the recording can be stood on.
        world: what takes the shadows of objects that hang on no anchor, where no anchor stays.
        interpolation: how all keyframes are joined, in place of what their objects say.

    Raises:
        ValueError: an anchor that is not there, a file, clip or joint that is not; by name.
    """

    scene: Scene
    folder: Path
    grounds: Grounds
    world: Ground
    interpolation: Interpolation | None = None
    _anchors: dict[str, tuple[Ground, Trajectory | None]] = field(default_factory=dict)
    _acted: dict[str, Acted] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, anchor in self.scene.anchors.items():
            try:
                found = self.grounds.asked(anchor.on, anchor.marker, anchor.floor_m)
            except ValueError as fault:
                raise ValueError(f"scene, anchor '{name}': {fault}") from fault
            self._anchors[name] = found
        lasts_s = 1e-9 * float(self._span_ns[1] - self._span_ns[0])
        poses = 0
        for name in things_of(self.scene):
            one = acted(self.scene, name, self.folder, lasts_s)
            poses += one.poses.coefficients.size // 8 + int(RATE_HZ * lasts_s)
            if poses > MOST_POSES:
                raise ValueError(
                    f"scene, '{name}': expected at most {MOST_POSES} poses of joints and objects "
                    f"up to here, got {poses}: fewer of them, or a shorter recording"
                )
            self._acted[name] = one

    def parts(self) -> tuple[PlayedPart, ...]:
        """All characters and props; first the first character, or prop where there is none."""
        return tuple(map(self._part, self._acted))

    def ground_of(self, name: str) -> tuple[Ground, Trajectory | None]:
        """What an object's shadow falls on, and how that moves: its anchor's plane.

        Of one that hangs on none, the first anchor that does not move, or else the run's ground.
        """
        anchor = self.scene.anchor_of(name)
        if anchor is not None:
            return self._anchors[anchor]
        still = (ground for ground, motion in self._anchors.values() if motion is None)
        return next(still, self.world), None

    @property
    def _span_ns(self) -> tuple[int, int]:
        stamps = self.grounds.recording.frames.time_ns
        return int(stamps[0]), int(stamps[-1])

    def _part(self, name: str) -> PlayedPart:
        one, part = self._acted[name], self.scene.part(name)
        ground, ground_motion = self.ground_of(name)
        return PlayedPart(
            name,
            one.file,
            Placement(ground.world_T_plane, 1.0),
            one.time_s,
            one.poses,
            one.states,
            worst_slide_m=one.worst_slide_m,
            motion=self._motion(name, ground.world_T_plane),
            ground_motion=ground_motion,
            visible_s=part.visible_s,
        )

    def _motion(self, name: str, world_T_plane: Motor) -> Trajectory:
        """`plane_T_character` over the recording, its size included."""
        chain, above = [name], self.scene.parents[name]
        while above is not None and above not in self.scene.anchors:
            chain.append(above)
            above = self.scene.parents[above]
        stamps = self._stamps() if any(map(self._moves, chain)) else np.array(self._span_ns[:1])
        time_s = np.asarray(1e-9 * (stamps - self._span_ns[0]), dtype=np.float64)
        poses = Similarity.identity((len(stamps),))
        if above is None:
            poses = Similarity.from_motor_scale(world_T_plane.inverse()).reshape(1) @ poses
        for one in reversed(chain):
            poses = poses @ self._local(one, time_s)
        sized = Similarity.from_motor_scale(Motor.identity(), self._acted[name].size)
        made = Similarity.normalize((poses @ sized).coefficients)
        return Trajectory(stamps, made, "placement", "character")

    def _moves(self, name: str) -> bool:
        part = self.scene.part(name)
        return len(part.keyframes) > 1 or part.walk is not None

    def _local(self, name: str, time_s: FloatArray) -> Similarity:
        """`parent_T_object` ``(T,)``."""
        part, pose = self.scene.part(name), self.scene.pose(name).as_similarity()
        if part.keyframes:
            return between_keyframes(part, time_s, self.interpolation)
        one = self._acted.get(name)
        if one is not None and one.parent_T_character is not None:
            way = Clip("way", one.time_s, one.parent_T_character.reshape(-1, 1))
            return Similarity.from_motor_scale(way.at(time_s).rigid[:, 0], pose.scale)
        return pose.reshape(1)[np.zeros(len(time_s), dtype=np.int64)]

    def _stamps(self) -> IntArray:
        """Of all frames, and evenly between."""
        first, last = self._span_ns
        count = int(np.ceil(1e-9 * (last - first) * RATE_HZ)) + 1
        even = np.linspace(first, last, count).round().astype(np.int64)
        return np.unique(np.concatenate([self.grounds.recording.frames.time_ns, even]))


def light_placement(first: PlayedPart, height_m: float) -> tuple[Placement, Motor]:
    """Where light is made for, and the same in the plane: upright, under one where it is at first.

    Args:
        first: of a scene.
        height_m: of its character, in its file's metres.

    Returns:
        its placement, as large as it is there, and where it stands in the plane's frame.
    """
    assert first.motion is not None  # every part of a scene has one
    pose = first.motion.poses[0]
    assert isinstance(pose, Similarity)
    x, y, _ = pose.apply([0.0, 0.0, 0.5 * height_m])
    inside = Motor.from_translation([x, y, 0.0])
    world = first.placement.world_T_character @ inside
    return replace(first.placement, world_T_character=world, scale=float(pose.scale)), inside
