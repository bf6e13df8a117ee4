"""Write characters with their clips as `.glb`: one at rest or on its way, or a whole cast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.formats.gltf.writing.motions import AnimationWriter
from motorcade.animation.formats.gltf.writing.scene import LOOKING, NodeNumbers, SceneWriter
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive


@dataclass(frozen=True, eq=False)
class CameraPath:
    """A pinhole camera on its way.

    Args:
        world_T_camera: poses in OpenCV's camera axes.
        vertical_field_rad: angle between the upper and lower edge of the picture.
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
    *,
    world_T_character: Trajectory | None = None,
    camera: CameraPath | None = None,
    points_m: FloatArray | None = None,
) -> None:
    """Write a character with its skeleton, skin, materials, morph targets and clips.

    On a path every animation also carries the character, and the camera if there is one: time
    zero is the path's first stamp, and a looped clip is repeated until the path ends. The world
    of the path has z up.

    Args:
        path: of the `.glb` to write; an existing file is replaced.
        character: what to write.
        clips: motions of its skeleton; by default its own.
        world_T_character: where the character goes, and how large it is on the way.
        camera: a camera that moves with the path's clock; only with `world_T_character`.
        points_m: (N, 3) a cloud of points in the path's world; only with `world_T_character`.

    Raises:
        ValueError: another suffix, clips for another skeleton or of one name, a camera or points
            without a path, points of another shape, or a path so long that a looped clip has
            more than 200,000 keys along it.
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
    _check(target, character, chosen, world_T_character, camera)
    _check_points(points_m, world_T_character)
    scene = SceneWriter()
    numbers = scene.add(character, on_path=world_T_character is not None)
    lens = None if camera is None else scene.add_camera(camera.vertical_field_rad, camera.aspect)
    for clip in chosen or _still(character, world_T_character):
        made = AnimationWriter(scene.buffer)
        _carry(made, character, clip, numbers, world_T_character)
        if camera is not None and lens is not None and world_T_character is not None:
            start_ns = int(world_T_character.time_ns[0])
            made.path(camera.world_T_camera, lens, start_ns, LOOKING, character.height_m)
        scene.animate(made.document(clip.name, looped=clip.looped and world_T_character is None))
    if points_m is not None:
        scene.add_points(points_m)
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
    _check_points(points_m, cast[0].world_T_character)
    scene, start_ns = SceneWriter(), starts.pop()
    made = AnimationWriter(scene.buffer)
    for one in cast:
        numbers = scene.add(one.character, on_path=True, name=one.name if len(cast) > 1 else "")
        _carry(made, one.character, one.clip, numbers, one.world_T_character)
    if camera is not None:
        lens = scene.add_camera(camera.vertical_field_rad, camera.aspect)
        reach_m = max(one.character.height_m for one in cast)
        made.path(camera.world_T_camera, lens, start_ns, LOOKING, reach_m)
    scene.animate(made.document("cast", looped=False))
    if points_m is not None:
        scene.add_points(points_m)
    scene.write(target)


def _carry(
    made: AnimationWriter,
    character: Character,
    clip: Clip,
    numbers: NodeNumbers,
    path: Trajectory | None,
) -> None:
    """Channels of a character: its joints, its morph targets, and what its path carries."""
    made.clip(clip, numbers.first, character, path)
    if path is not None:
        start_ns = int(path.time_ns[0])
        made.path(path, numbers.path, start_ns, Rotor.identity(), character.height_m)


def _check(
    path: Path,
    character: Character,
    clips: tuple[Clip, ...],
    world_T_character: Trajectory | None,
    camera: CameraPath | None,
) -> None:
    _check_suffix(path)
    if camera is not None and world_T_character is None:
        raise ValueError("write_gltf(camera): expected a path of the character too, got none")
    names = [clip.name for clip in clips]
    if len(set(names)) < len(names):
        raise ValueError(f"write_gltf(clips): expected different names, got {names}")
    for clip in clips:
        _check_joints(character, clip, "write_gltf(clips)")


def _check_suffix(path: Path) -> None:
    if path.suffix.lower() != ".glb":
        raise ValueError(f"write_gltf(path): expected a name that ends in .glb, got '{path.name}'")


def _check_joints(character: Character, clip: Clip, field: str) -> None:
    if clip.poses.shape[1] != len(character.skeleton):
        raise ValueError(
            f"{field}: expected poses of {len(character.skeleton)} joints, got "
            f"{clip.poses.shape[1]} in '{clip.name}'"
        )


def _check_points(points_m: FloatArray | None, world_T_character: Trajectory | None) -> None:
    if points_m is None:
        return
    if world_T_character is None:
        raise ValueError("write_gltf(points_m): expected a path of the character too, got none")
    shape = points_m.shape
    if len(shape) != 2 or shape[1] != 3 or shape[0] == 0 or not np.all(np.isfinite(points_m)):
        raise ValueError(f"write_gltf(points_m): expected finite points (N, 3), got {shape}")


def _still(character: Character, path: Trajectory | None) -> tuple[Clip, ...]:
    """The rest pose as a clip, for a path without any."""
    if path is None:
        return ()
    return (Clip("path", np.zeros(1), character.skeleton.rest.reshape(1, -1)),)
