"""A run while its scene is edited: images, camera path, what to stand on, and what stands there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, Clip
from motorcade.animation.authoring import Scene, SceneAnchor, SceneWalk, between_keyframes
from motorcade.animation.authoring.fields import part_json
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import off_record
from motorcade.render.composite import is_grey
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.look import gltf_bytes
from motorcade.replays.pipeline.packing import packed, scaled_rows
from motorcade.replays.pipeline.runs import read_origin, read_run
from motorcade.replays.stages.camera.offered import as_found, camera_of
from motorcade.replays.stages.values.view import PlacedCharacter
from motorcade.replays.stages.view.acted import Acted, acted
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.anchored import Grounds
from motorcade.replays.stages.view.ground import Ground
from motorcade.replays.stages.view.overlay import extrapolated
from motorcade.tracking import Camera

MOST_MARKERS = 40
"""Of a map, that are offered to stand on."""


@dataclass(frozen=True, eq=False)
class Filmed:
    """Footage with the camera that took it.

    Args:
        grounds: what of it can be stood on, and the path along which it is drawn.
        first: what the run itself stood its character on.
        place_m: ``(2,)`` where that was, in the plane.
        height_m: and how tall.
        words: of the command line that made the run, but for where to and who stands in it.
        moving: numbers of markers that the run was told do not stand still.
        placed: whom the run itself put into the footage; None for nobody.
        knobs: of the stage that did.
    """

    recording: Recording
    grounds: Grounds
    first: SceneAnchor
    place_m: FloatArray
    height_m: float
    words: tuple[str, ...]
    moving: tuple[int, ...] = ()
    placed: PlacedCharacter | None = None
    knobs: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._found: dict[SceneAnchor, tuple[Ground, Similarity]]
        object.__setattr__(self, "_found", {})

    @property
    def camera(self) -> Camera:
        """The lens of the images."""
        return camera_of(self.recording)

    @property
    def frames(self) -> int:
        """How many images there are."""
        return len(self.recording.frames)

    @cached_property
    def grey(self) -> bool:
        """Whether the images have no colour, so that what is drawn into them has none either."""
        frames = self.recording.frames
        return not isinstance(frames, CornerFrames) and is_grey(frames[0].image())

    @cached_property
    def time_s(self) -> FloatArray:
        """``(F,)`` seconds from the first frame."""
        stamps = self.recording.frames.time_ns
        since: FloatArray = 1e-9 * (stamps - stamps[0]).astype(np.float64)
        return since

    @cached_property
    def world_T_camera(self) -> Motor:
        """``(F,)``, at the path's ends where a frame lies beyond them; see `has_pose`."""
        path, stamps = self.grounds.seen_from, self.recording.frames.time_ns
        return path.motors_at(np.clip(stamps, path.time_ns[0], path.time_ns[-1]))

    @cached_property
    def has_pose(self) -> np.ndarray:
        """``(F,)`` whether it is known where the camera was."""
        path, stamps = self.grounds.seen_from, self.recording.frames.time_ns
        return np.asarray((stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1]))

    @cached_property
    def up(self) -> FloatArray:
        """``(3,)`` in the world: out of what the run stood its character on."""
        return self.ground(self.first).world_T_plane.rotor.apply([0.0, 0.0, 1.0])

    @cached_property
    def stands(self) -> dict[str, SceneAnchor]:
        """What else of the footage a scene may hang on, by the names that anchors of it get."""
        stands = {"floor": SceneAnchor("floor")}
        poses = self.grounds.camera_poses
        if self.recording.board is not None and poses.origin in ("board", "simulated"):
            stands["board"] = SceneAnchor("board")
        markers = self.grounds.marker_poses
        mapped = () if markers is None else markers.marker_map.marker_ids[:MOST_MARKERS]
        for number in (*self.moving, *mapped):
            stands[f"marker {number}"] = SceneAnchor("marker", int(number))
        return stands

    def rays(self, frame: int, pixels: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Rays of a frame's pixels ``(N, 2)``: where all begin ``(3,)``, and directions ``(N, 3)``.

        Raises ValueError: a pixel that the lens shows nothing at, a frame without a pose.
        """
        if not self.has_pose[frame]:
            raise ValueError("In this image it is not known where the camera was.")
        world_T_camera: Motor = self.world_T_camera[frame]
        rays = self.camera.bearings(pixels)
        if not np.all(np.isfinite(rays)):
            raise ValueError("The lens shows nothing there.")
        directions: FloatArray = world_T_camera.rotor.apply(rays)
        return world_T_camera.translation_m, directions

    def ground(self, anchor: SceneAnchor) -> Ground:
        """What an anchor is. Raises ValueError: it is not in this recording."""
        return self._anchored(anchor)[0]

    def world_T_anchor(self, anchor: SceneAnchor) -> Similarity:
        """Where an anchor is: ``(F,)``, or ``(1,)`` of one that stays.

        Raises ValueError: it is not in this recording.
        """
        return self._anchored(anchor)[1]

    def _anchored(self, anchor: SceneAnchor) -> tuple[Ground, Similarity]:
        if anchor not in self._found:
            ground, motion = self.grounds.asked(anchor.on, anchor.marker, anchor.floor_m)
            poses: Motor = ground.world_T_plane.reshape(1)
            if motion is not None:
                stamps = self.recording.frames.time_ns
                inside = np.clip(stamps, motion.time_ns[0], motion.time_ns[-1])
                poses = motion.motors_at(inside) @ ground.world_T_plane
            self._found[anchor] = ground, Similarity.from_motor_scale(poses)
        return self._found[anchor]


def spoken(anchor: SceneAnchor) -> str:
    """An anchor as people call it."""
    if anchor.on == "marker":
        return f"Marker {anchor.marker}"
    words = {"auto": "The ground", "board": "The board", "plane": "The plane"}
    return words.get(anchor.on, "The floor")


def open_filmed(folder: Path) -> Filmed:
    """Read a run back for its scene to be edited; what its cache lost is computed again.

    Raises ValueError: a folder that holds no run, one whose recording has changed since, or one
    without a camera; OSError: its recording is gone.
    """
    origin = read_origin(folder)
    recording, run = read_run(folder, "placed")
    words = *origin.words(recording), "--cache", str(origin.cache.absolute())
    poses, integrity = run.outputs["camera_poses"], run.outputs["integrity"]
    recording = as_found(recording, poses.camera, poses.depth_camera)
    path: Trajectory = extrapolated(integrity.drawn, poses.measurements.trajectory)
    grounds = Grounds(recording, poses, run.outputs.get("marker_poses"), path)
    knobs = origin.knobs.get("placed", {})
    anchor_fields = {name: knobs[name] for name in ("on", "marker", "floor_m") if name in knobs}
    placed = run.outputs["placed"]
    who = performers(placed)[0]
    height_m = who.placement.scale * who.character.height_m
    place_m = placed.plane_T_character.translation_m[:2]
    moving = tuple(origin.knobs.get("marker_poses", {}).get("moving", ()))
    first = SceneAnchor(**anchor_fields)
    return Filmed(recording, grounds, first, place_m, height_m, words, moving, placed, knobs)


_MOST_KEPT = 256


@dataclass(frozen=True, eq=False)
class PlayedScene:
    """What of a scene is shown over its footage; caches what objects do."""

    filmed: Filmed
    folder: Path
    _acted: dict[str, tuple[int, Acted]] = field(default_factory=dict)
    _numbers: list[str] = field(default_factory=list)
    _figures: list[tuple[str, Character]] = field(default_factory=list)

    def acted(self, scene: Scene, name: str) -> tuple[int, Acted]:
        """What a character or prop does, and the number by which `motion` knows it.

        One that walks does so from the origin along x: its way moved elsewhere is no other walk.

        Raises ValueError: a file, clip, gait or joint that is not there.
        """
        if scene.part(name).walk is not None:
            scene = _from_the_origin(scene, name)
        part = scene.part(name)
        fields = part_json(part)
        for key in ("keyframes", "interpolation", "visible"):
            fields.pop(key, None)
        size = float(scene.pose(name).as_similarity().scale) if part.walk is not None else 1.0
        key = json.dumps([part.kind, part.file, fields, f"{size:.9g}"])
        if key not in self._acted:
            performance = acted(scene, name, self.folder, float(self.filmed.time_s[-1]))
            self._numbers.append(key)
            self._acted[key] = len(self._numbers) - 1, performance
            for old in list(self._acted)[:-_MOST_KEPT]:
                del self._acted[old]
        return self._acted[key]

    def figure(self, acted: Acted) -> int:
        """The number of a shape, for `glb`."""
        for number, (file, _) in enumerate(self._figures):
            if file == acted.file:
                return number
        self._figures.append((acted.file, acted.character))
        return len(self._figures) - 1

    def stands_alike(self, before: Scene, after: Scene, name: str) -> bool:
        """Whether an object surely stands where it did at every frame."""
        at: str | None = name
        while at is not None and at not in after.anchors:
            known = at in before.parents and before.parents[at] == after.parents[at]
            if not known or before.poses[at] is not after.poses[at]:
                return False
            if before.parts.get(at) is not after.parts.get(at):
                return False
            at = after.parents[at]
        return at is None or before.anchors.get(at) == after.anchors[at]

    def world_T_object(self, scene: Scene, name: str) -> Similarity:
        """Where an object stands: ``(F,)``, or ``(1,)`` for one that stays.

        Raises ValueError: an anchor, a file or a clip that is not there.
        """
        return self.world_T_parent(scene, name) @ self.parent_T_object(scene, name)

    def world_T_parent(self, scene: Scene, name: str) -> Similarity:
        """Where the frame stands in which an object has its pose, likewise."""
        parent = scene.parents[name]
        if parent is None:
            return Similarity.identity((1,))
        if parent in scene.anchors:
            return self.filmed.world_T_anchor(scene.anchors[parent])
        return self.world_T_object(scene, parent)

    def parent_T_object(self, scene: Scene, name: str) -> Similarity:
        """Where an object stands in its parent, likewise."""
        part, pose = scene.part(name), scene.pose(name).as_similarity()
        if len(part.keyframes) > 1:
            return between_keyframes(part, self.filmed.time_s)
        if part.keyframes:
            return between_keyframes(part, np.zeros(1))
        if part.walk is not None:
            acted = self.acted(scene, name)[1]
            assert acted.parent_T_character is not None  # of one that walks
            way = Clip("way", acted.time_s, acted.parent_T_character.reshape(-1, 1))
            steps = _parent_T_way(part.walk) @ way.at(self.filmed.time_s).rigid[:, 0]
            return Similarity.from_motor_scale(steps, pose.scale)
        return pose.reshape(1)

    def motion(self, number: int) -> dict[str, Any] | None:
        """The joints of what `acted` gave this number, for the page; None where it is forgotten."""
        known = self._acted.get(self._numbers[number]) if number < len(self._numbers) else None
        if known is None:
            return None
        acted = known[1]
        return {
            "joints": packed(scaled_rows(acted.character.skeleton.world(self.local_poses(acted)))),
            "morphs": None,
            "size": acted.size,
            "height_m": acted.size * acted.character.height_m,
        }

    def local_poses(self, acted: Acted) -> Motor:
        """Its joints in their parents ``(F, J)`` over the footage; ``(1, J)`` where none moves."""
        moments = np.zeros(1) if len(acted.time_s) < 2 else self.filmed.time_s
        return Clip("acted", acted.time_s, acted.poses).at(moments).rigid

    @off_record()  # a file of our own
    def glb(self, number: int) -> bytes | None:
        """A shape's mesh, skeleton and materials; None where there is no such number."""
        if not 0 <= number < len(self._figures):
            return None
        return gltf_bytes(self._figures[number][1])


def _parent_T_way(walk: SceneWalk) -> Motor:
    """Where a way begins, and where to it sets out."""
    x, y = walk.path_m[1] - walk.path_m[0]
    turn = Rotor.from_rotation_vector([0.0, 0.0, float(np.arctan2(y, x))])
    return Motor.from_rotor_translation(turn, np.append(walk.path_m[0], 0.0))


def _from_the_origin(scene: Scene, name: str) -> Scene:
    """The scene with somebody's way begun at the origin along x, to a nanometre."""
    part = scene.part(name)
    assert part.walk is not None  # asked of those that walk
    flat = np.column_stack([part.walk.path_m, np.zeros(len(part.walk.path_m))])
    way = _parent_T_way(part.walk).inverse().apply(flat)[:, :2].round(9) + 0.0
    return scene.with_part(name, replace(part, walk=replace(part.walk, path_m=way)))
