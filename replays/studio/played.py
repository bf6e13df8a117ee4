"""A scene over the frames of its footage: where each object stands, and what its joints do.

What an object does is played anew only when that changed; where it stands is told at every frame,
or once for one that stays.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, Clip
from motorcade.animation.authoring import Scene, SceneWalk, between_keyframes
from motorcade.animation.authoring.fields import part_json
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.files import off_record
from motorcade.replays.pipeline.look.document import gltf_bytes
from motorcade.replays.pipeline.look.packing import packed, scaled_rows
from motorcade.replays.stages.characters.acted import Acted, acted
from motorcade.replays.studio.filmed import Filmed

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
            if at not in before.parents or before.parents[at] != after.parents[at]:
                return False
            if before.poses[at] is not after.poses[at]:
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
