"""Write `.glb` files: a character at rest or on its way, or a whole cast with a camera, and clips.

Character space (z up, facing +x) becomes glTF's (y up, facing +z) by one node above all others.

Clips get keys so dense that turns and translations interpolated apart follow their screws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip, MorphTrack
from motorcade.animation.formats.gltf.binary import (
    GENERATOR,
    VERTICES,
    BinaryBuffer,
    LookWriter,
    write_glb,
)
from motorcade.animation.formats.rig.sampling import divided, parts_of_steps
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive


@dataclass(frozen=True, eq=False)
class CameraPath:
    """A pinhole camera on its way.

    Args:
        world_T_camera: poses in OpenCV's camera axes.
        vertical_field_rad: angle between the upper and lower edge of the image.
        aspect: width over height.

    Raises:
        ValueError: an angle outside 0 to π, or an aspect that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation.formats import CameraPath
    >>> from motorcade.ga import Motor, Trajectory
    >>> path = Trajectory(np.array([0, 1_000_000_000]), Motor.identity((2,)), "world", "camera")
    >>> CameraPath(path, vertical_field_rad=0.7, aspect=4 / 3).world_T_camera
    Trajectory(world_T_camera, 2 poses, 1.000 s)
    """

    world_T_camera: Trajectory
    vertical_field_rad: float
    aspect: float

    def __post_init__(self) -> None:
        if not 0.0 < self.vertical_field_rad < np.pi:
            raise ValueError(
                "CameraPath.vertical_field_rad: expected an angle between 0 and pi, got "
                f"{self.vertical_field_rad}"
            )
        checked_positive(self.aspect, "CameraPath.aspect")


@dataclass(frozen=True, eq=False)
class CharacterOnPath:
    """A character of several in one file, what it does, and where it goes meanwhile.

    Args:
        name: what it is called; among several, names of its joints begin with it in the file.
        character: who.
        clip: what its joints do; its clock begins with the path's first stamp.
        world_T_character: where it goes, and how large it is on the way.

    Raises:
        ValueError: no name, or a clip of another skeleton.

    >>> from motorcade.animation import mannequin
    >>> from motorcade.animation.formats import CharacterOnPath
    >>> from motorcade.ga import Motor, Trajectory
    >>> who, way = mannequin(), Motor.from_translation([[0, 0, 0], [2.0, 0, 0]])
    >>> path = Trajectory(np.array([0, 2_000_000_000]), way, "world", "character")
    >>> CharacterOnPath("ann", who, who.clip("walk"), path).clip.name
    'walk'
    """

    name: str
    character: Character
    clip: Clip
    world_T_character: Trajectory

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("CharacterOnPath.name: expected a name, got none")
        _check_joints(self.character, self.clip, "CharacterOnPath.clip")


def write_gltf(
    path: Path | str,
    character: Character,
    clips: Sequence[Clip] | None = None,
) -> None:
    """Write a character with its skeleton, skin, materials, morph targets and clips.

    `write_cast_gltf` writes characters on their ways, with a camera and points.

    Args:
        path: of the `.glb` to write; an existing file is replaced.
        character: what to write.
        clips: motions of its skeleton; by default its own.

    Raises:
        ValueError: another suffix, or clips for another skeleton or of one name.
        OSError: the file cannot be written.

    >>> import tempfile
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.animation import Character, Skeleton, read_character, write_gltf
    >>> from motorcade.ga import Motor
    >>> flag = Character(
    ...     Skeleton(("pole",), np.array([-1]), Motor.identity((1,))),
    ...     vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
    ...     normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
    ...     triangles=np.array([[0, 1, 2]]),
    ...     colors=np.full((3, 3), 0.5),
    ...     joints=np.zeros((3, 4), int),
    ...     weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    ... )

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_gltf(Path(folder, "flag.glb"), flag)
    ...     again = read_character(Path(folder, "flag.glb"))
    >>> again.skeleton.names, again.vertices.shape
    (('pole',), (3, 3))
    """
    target = Path(path)
    chosen = tuple(character.clips if clips is None else clips)
    _check_suffix(target)
    names = [clip.name for clip in chosen]
    if len(set(names)) < len(names):
        raise ValueError(f"write_gltf(clips): expected different names, got {names}")
    for clip in chosen:
        _check_joints(character, clip, "write_gltf(clips)")
    scene = SceneWriter()
    numbers = scene.add(character, on_path=False)
    for clip in chosen:
        animation_writer = AnimationWriter(scene.buffer)
        animation_writer.clip(clip, numbers.first, character, None)
        scene.animate(animation_writer.document(clip.name, looped=clip.looped))
    scene.write(target)


def write_cast_gltf(
    path: Path | str,
    cast: Sequence[CharacterOnPath],
    *,
    camera: CameraPath | None = None,
    points_m: FloatArray | None = None,
) -> None:
    """Write several characters on their ways as one scene with one animation.

    The world of their paths has z up. Time zero is the first stamp of their paths; looped clips
    are repeated until the path of theirs ends.

    Args:
        path: of the `.glb` to write; an existing file is replaced.
        cast: one or more, of different names, whose paths begin at the same stamp.
        camera: a camera that moves with their clock.
        points_m: (N, 3) a cloud of points in their world.

    Raises:
        ValueError: another suffix, no character, names that are alike, paths that begin at
            different stamps, points of another shape, or a path so long that a looped clip has
            more than 200,000 keys along it.
        OSError: the file cannot be written.

    >>> import tempfile
    >>> from motorcade.animation import mannequin
    >>> from motorcade.animation.formats import CharacterOnPath, write_cast_gltf
    >>> from motorcade.ga import Motor, Trajectory
    >>> who, cast = mannequin(), []
    >>> for name, y in (("ann", -0.5), ("ben", 0.5)):
    ...     way = Motor.from_translation([[0, y, 0], [1.0, y, 0]])
    ...     path = Trajectory(np.array([0, 2_000_000_000]), way, "world", "character")
    ...     cast.append(CharacterOnPath(name, who, who.clip("walk"), path))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_cast_gltf(Path(folder, "both.glb"), cast)
    """
    target = Path(path)
    _check_suffix(target)
    if not cast or len({one.name for one in cast}) < len(cast):
        names = [one.name for one in cast]
        raise ValueError(
            f"write_cast_gltf(cast): expected one or more names, each once, got {names}"
        )
    starts = {int(one.world_T_character.time_ns[0]) for one in cast}
    if len(starts) > 1:
        raise ValueError(
            f"write_cast_gltf(cast): expected paths from one stamp on, got {sorted(starts)}"
        )
    if points_m is not None:
        shape = points_m.shape
        if len(shape) != 2 or shape[1] != 3 or not shape[0] or not np.isfinite(points_m).all():
            raise ValueError(
                f"write_cast_gltf(points_m): expected finite points (N, 3), got {shape}"
            )
    scene, start_ns = SceneWriter(), starts.pop()
    animation_writer = AnimationWriter(scene.buffer)
    for member in cast:
        numbers = scene.add(
            member.character, on_path=True, name=member.name if len(cast) > 1 else ""
        )
        way, height_m = member.world_T_character, member.character.height_m
        animation_writer.clip(member.clip, numbers.first, member.character, way)
        animation_writer.path(way, numbers.path, start_ns, Rotor.identity(), height_m)
    if camera is not None:
        lens = scene.add_camera(camera.vertical_field_rad, camera.aspect)
        reach_m = max(one.character.height_m for one in cast)
        animation_writer.path(camera.world_T_camera, lens, start_ns, LOOKING, reach_m)
    scene.animate(animation_writer.document("cast", looped=False))
    if points_m is not None:
        scene.add_points(points_m)
    scene.write(target)


def _check_suffix(path: Path) -> None:
    if path.suffix.lower() != ".glb":
        raise ValueError(f"write_gltf(path): expected a name that ends in .glb, got '{path.name}'")


def _check_joints(character: Character, clip: Clip, field: str) -> None:
    if clip.poses.shape[1] != len(character.skeleton):
        raise ValueError(
            f"{field}: expected poses of {len(character.skeleton)} joints, got "
            f"{clip.poses.shape[1]} in '{clip.name}'"
        )


UPRIGHT_XYZW = [-0.5, -0.5, -0.5, 0.5]
"""From z up, facing +x, to y up, facing +z: x, y, z become z, x, y."""
LOOKING = Rotor.from_rotation_vector((np.pi, 0.0, 0.0))
"""From OpenCV's camera axes (z ahead, y down) to glTF's (z back, y up)."""


@dataclass(frozen=True)
class NodeNumbers:
    """Where a character stands among a document's nodes: its first joint, and what carries it."""

    first: int
    path: int


class SceneWriter:
    """A document that is being put together; `buffer` takes its arrays."""

    def __init__(self) -> None:
        self.buffer = BinaryBuffer()
        self._world: dict[str, Any] = {"name": "world", "rotation": UPRIGHT_XYZW, "children": []}
        self._document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": GENERATOR},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [self._world],
            "skins": [],
            "meshes": [],
        }
        self._looks = LookWriter(self.buffer, self._document)

    def add(self, character: Character, *, on_path: bool, name: str = "") -> NodeNumbers:
        """Joints, skin and mesh of a character, below a node that a path may move."""
        document, skeleton = self._document, character.skeleton
        nodes, label = document["nodes"], f"{name} " if name else ""
        above = self._world
        if on_path:
            self._world["children"].append(len(nodes))
            above = {"name": f"{label}path", "children": []}
            nodes.append(above)
        first = len(nodes)
        wxyz, places = skeleton.rest.as_quaternion_translation()
        for joint, parent in enumerate(skeleton.parents.tolist()):
            holder = above if parent < 0 else nodes[first + parent]
            holder.setdefault("children", []).append(first + joint)
            node = {
                "name": f"{label}{skeleton.names[joint]}",
                "rotation": wxyz[joint, [1, 2, 3, 0]].tolist(),
                "translation": places[joint].tolist(),
            }
            nodes.append(node)
        mesh = {"name": f"{label}mesh", "mesh": len(document["meshes"])}
        document["scenes"][0]["nodes"].append(len(nodes))
        nodes.append(mesh | {"skin": len(document["skins"])})
        columns = skeleton.rest_world_inverse.as_matrix().swapaxes(1, 2).reshape(-1, 16)
        joints = list(range(first, first + len(skeleton)))
        binds = self.buffer.add(columns)
        document["skins"].append({"joints": joints, "inverseBindMatrices": binds})
        document["meshes"].append(self._looks.mesh(character))
        return NodeNumbers(first, first - 1)

    def add_camera(self, vertical_field_rad: float, aspect: float) -> int:
        """A camera's node, below the world."""
        lens = {"yfov": vertical_field_rad, "aspectRatio": aspect, "znear": 0.01}
        self._document["cameras"] = [{"type": "perspective", "perspective": lens}]
        return self._add_below({"name": "camera", "camera": 0})

    def add_points(self, points_m: FloatArray) -> None:
        """A cloud of points below the world's node."""
        place = self.buffer.add(points_m, target=VERTICES, bounds=True)
        meshes = self._document["meshes"]
        meshes.append({"primitives": [{"attributes": {"POSITION": place}, "mode": 0}]})
        self._add_below({"name": "map", "mesh": len(meshes) - 1})

    def animate(self, animation: dict[str, Any]) -> None:
        """Add an animation."""
        self._document.setdefault("animations", []).append(animation)

    def write(self, path: Path) -> None:
        """Write the file; raises OSError as `write_glb` does."""
        write_glb(path, self._document, self.buffer)

    def _add_below(self, node: dict[str, Any]) -> int:
        nodes = self._document["nodes"]
        self._world["children"].append(len(nodes))
        nodes.append(node)
        return len(nodes) - 1


PARTING_M = 5e-6
"""How far between keys a written joint may leave its screw, in metres; see MOST_PARTS."""
STORED = 6e-8
"""Half a step of the file's 32-bit numbers at 1."""


class AnimationWriter:
    """One animation that is being put together."""

    def __init__(self, buffer: BinaryBuffer) -> None:
        self._buffer = buffer
        self._samplers: list[dict[str, Any]] = []
        self._channels: list[dict[str, Any]] = []

    def clip(self, clip: Clip, first: int, character: Character, path: Trajectory | None) -> None:
        """Channels of all joints, the first being node `first`.

        What stays as it is at rest gets none, but for the first joint, which tells how long the
        clip lasts.
        """
        rest, reach_m = character.skeleton.rest, character.height_m
        if clip.morphs is not None:
            self._weights(clip, clip.morphs, first + clip.poses.shape[1], path)
        travels = _travels(clip.poses)
        for joints, times in (
            (np.flatnonzero(travels), _dense(clip.time_s, clip.poses[:, travels], reach_m)),
            (np.flatnonzero(~travels), clip.time_s),
        ):
            if len(joints):
                self._joints(clip, joints, times, first, rest, path)

    def _joints(
        self,
        clip: Clip,
        joints: IntArray,
        times: FloatArray,
        first: int,
        rest: Motor,
        path: Trajectory | None,
    ) -> None:
        """Channels of some joints (K,) that share their keys."""
        poses = clip.at(times)[:, joints]
        wxyz, places, scale = _parts(poses)
        still_wxyz, still_places = rest[joints].as_quaternion_translation()
        if path is not None:
            span_s = 1e-9 * float(path.time_ns[-1] - path.time_ns[0])
            times, rows = _repeated(times - times[0], span_s, looped=clip.looped)
            wxyz, places, scale = wxyz[rows], places[rows], scale[rows]
        keys = self._buffer.add(times, bounds=True)
        for column, joint in enumerate(joints.tolist()):
            node = first + joint
            turns, steps = wxyz[:, column], places[:, column]
            if joint == 0 or not _alike(turns, still_wxyz[column]):
                self._add(keys, node, "rotation", turns[:, [1, 2, 3, 0]])
            if joint == 0 or not _alike(steps, still_places[column]):
                self._add(keys, node, "translation", steps)
            if isinstance(poses, Similarity):
                self._add(keys, node, "scale", np.repeat(scale[:, column, None], 3, axis=1))

    def _weights(self, clip: Clip, track: MorphTrack, node: int, path: Trajectory | None) -> None:
        """A channel of the mesh's morph weights, on the clip's clock."""
        first, last = clip.time_s[0], clip.time_s[-1]
        times = np.unique(np.clip(np.concatenate([track.time_s, [first, last]]), first, last))
        weights = track.at(times)
        if path is not None:
            span_s = 1e-9 * float(path.time_ns[-1] - path.time_ns[0])
            times, rows = _repeated(times - first, span_s, looped=clip.looped)
            weights = weights[rows]
        self._add(self._buffer.add(times, bounds=True), node, "weights", weights.reshape(-1))

    def path(
        self, path: Trajectory, node: int, start_ns: int, before: Rotor, reach_m: float
    ) -> None:
        """Channels that carry a node, which reaches so far; `before` turns what it carries."""
        since_s = 1e-9 * (path.time_ns - path.time_ns[0]).astype(np.float64)
        inside = _dense(since_s, path.poses.reshape(-1, 1), reach_m)
        stamps = path.time_ns[0] + np.round(1e9 * inside).astype(np.int64)
        poses = path.at(stamps)
        wxyz, places, scale = _parts(poses)
        turned = Rotor.from_quaternion(wxyz) @ before
        keys = self._buffer.add(1e-9 * (stamps - start_ns), bounds=True)
        self._add(keys, node, "rotation", turned.as_quaternion()[:, [1, 2, 3, 0]])
        self._add(keys, node, "translation", places)
        if isinstance(poses, Similarity):
            self._add(keys, node, "scale", np.repeat(scale[:, None], 3, axis=1))

    def document(self, name: str, *, looped: bool) -> dict[str, Any]:
        """The animation as it stands in the file."""
        fields: dict[str, Any] = {
            "name": name,
            "samplers": self._samplers,
            "channels": self._channels,
        }
        if looped:
            fields["extras"] = {"looped": True}
        return fields

    def _add(self, keys: int, node: int, path: str, values: FloatArray) -> None:
        self._channels.append(
            {"sampler": len(self._samplers), "target": {"node": node, "path": path}}
        )
        self._samplers.append({"input": keys, "output": self._buffer.add(values)})


def _dense(times: FloatArray, poses: Motor | Similarity, reach_m: float) -> FloatArray:
    """Times with keys between samples (F, J) where screws leave lines."""
    if len(times) < 2:
        return times
    return divided(times, parts_of_steps(*_parts(poses), reach_m, PARTING_M))


def _travels(poses: Motor | Similarity) -> NDArray[np.bool_]:
    """Which joints (J,) of poses (F, J) need keys between the samples: those that change place.

    A joint that only turns follows its screw as its turns are interpolated.
    """
    if isinstance(poses, Similarity):
        return np.ones(poses.shape[1], dtype=bool)
    places = poses.translation_m
    return np.asarray(np.abs(places - places[:1]).max(axis=(0, 2)) > STORED)


def _alike(values: FloatArray, still: FloatArray) -> bool:
    """Whether all rows (F, K) are one (K,), as exactly as the file holds them."""
    return bool(np.abs(values - still).max() <= STORED)


def _parts(poses: Motor | Similarity) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quaternions wxyz (*, 4), translations (*, 3) and scales (*)."""
    scale = poses.scale if isinstance(poses, Similarity) else np.ones(poses.shape)
    return poses.rotor.as_quaternion(), poses.translation_m, scale


MOST_KEYS = 200_000
"""Of a loop that is played again and again along a path."""


def _repeated(
    times: FloatArray, span_s: float, *, looped: bool
) -> tuple[FloatArray, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Times and rows of a clip played again and again until `span_s`; once if it is no loop.

    Raises ValueError: more keys than `MOST_KEYS`.
    """
    rows = np.arange(len(times))
    period = float(times[-1])
    if not looped or period <= 0.0:
        return times, rows
    keys = span_s / period * (len(times) - 1)
    if keys > MOST_KEYS:
        raise ValueError(
            f"write_gltf(world_T_character): expected a path along which the clip has at most "
            f"{MOST_KEYS} keys, got {keys:.6g} over {span_s:.6g} s; cut it at its gaps"
        )
    count = max(int(np.ceil(span_s / period)), 1)
    starts = np.repeat(np.arange(count) * period, len(times) - 1)
    repeated = np.concatenate([times[:1], starts + np.tile(times[1:], count)])
    return repeated, np.concatenate([rows[:1], np.tile(rows[1:], count)])
