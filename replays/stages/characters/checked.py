"""Whether all that a scene asks of its files is there: characters, clips, joints."""

from __future__ import annotations

from pathlib import Path

from motorcade.animation import Character
from motorcade.animation.authoring import Scene, read_scene
from motorcade.replays.io.readers.manifest.scene import file_of
from motorcade.replays.stages.characters.acting import character_named
from motorcade.replays.stages.characters.casting import mask_of, rigid_clip

MOST_THINGS = 100
"""Characters and props of a scene that is played."""


def check_scene(path: Path) -> None:
    """Refuse what can be refused before a recording is looked at: files, clips, joints.

    Raises:
        ValueError: see `read_scene` and `things_of`; a file that cannot be read, a clip or joint
            that is not there; the message names the object.
    """
    scene = read_scene(path)
    for name in things_of(scene):
        cast_as(scene, name, path.absolute().parent)


def things_of(scene: Scene) -> list[str]:
    """The names of all characters and props, first the characters.

    Raises:
        ValueError: none, or more than a hundred.
    """
    names = [name for name in scene.parents if scene.part(name).kind != "group"]
    if not names:
        raise ValueError("scene: expected a character or a prop, got groups alone")
    if len(names) > MOST_THINGS:
        raise ValueError(
            f"scene: expected at most {MOST_THINGS} characters and props, got {len(names)}"
        )
    return sorted(names, key=lambda one: scene.part(one).kind != "character")


def cast_as(scene: Scene, name: str, folder: Path) -> Character:
    """Who or what an object is, with all that it is asked to play.

    Raises:
        ValueError: see `check_scene`.
    """
    part = scene.part(name)
    try:
        character = character_named(file_of(part, folder))
        walk = () if part.walk is None else part.walk.gaits
        clips = [*walk, *(layer.clip for layer in part.layers)]
        for clip in [*clips, *([] if part.clip is None else [part.clip])]:
            rigid_clip(character, clip)
        for layer in part.layers:
            mask_of(character.skeleton, layer.joints)
        for one in part.joint_keyframes:
            for joint in one.rotors:
                character.skeleton.index(joint)
    except ValueError as fault:
        told = str(fault).removeprefix("placed.character: ").removeprefix("placed.clip: ")
        raise ValueError(f"scene, '{name}': {told}") from fault
    return character
