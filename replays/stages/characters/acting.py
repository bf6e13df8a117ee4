"""The character of a scene and its motion: the mannequin or a file, clips, walks along a path.

Who is drawn and exported: the placed character, or all of a cast or a scene, as they move.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from motorcade.animation import Character, Clip, Placement, mannequin
from motorcade.animation.behaviour import Gaze
from motorcade.animation.ik import fitted_legs
from motorcade.animation.place import GroundPath, on_its_soles, on_the_spot, walk_along
from motorcade.animation.retarget import figure_of, legs_of, retarget
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import files_now, files_read, is_there, put_on_record
from motorcade.ga.names import did_you_mean
from motorcade.render import Performer
from motorcade.replays.stages.values.view import PlacedCharacter

MANNEQUIN = "mannequin"
IDLE = "idle"
# How a walker that has arrived idles: samples a second, and for how long.
IDLE_HZ, LONGEST_IDLE_S = 30.0, 120.0


def character_named(
    name: str,
    up: str | None = None,
    front: str | None = None,
    hide: tuple[str, ...] = (),
) -> Character:
    """The mannequin, or the character of a file.

    Args:
        name: "mannequin", or the file.
        up: the axis of the file that is up, where the caller knows better than the file.
        front: the axis of the file that the figure faces at rest, likewise.
        hide: names of its meshes that are not drawn.

    Raises:
        ValueError: no such file, or one that cannot be read, or axes for the mannequin; the message
            names the knob.
    """
    path = Path(name)
    if name == MANNEQUIN:
        for knob, axis in (("up", up), ("front", front), ("hide", hide or None)):
            if axis is not None:
                raise ValueError(f"placed.{knob}: expected none for the mannequin, came {axis!r}")
        return mannequin()
    if not is_there(path):
        raise ValueError(f"placed.character: expected 'mannequin' or a file, came {name!r}")
    character, files = _read(path.absolute(), up, front, hide)
    if files_now(files) != files:
        _read.cache_clear()
        character, files = _read(path.absolute(), up, front, hide)
    put_on_record(files)
    return character


@lru_cache(maxsize=8)
def _read(
    path: Path, up: str | None, front: str | None, hide: tuple[str, ...]
) -> tuple[Character, Mapping[Path, str]]:
    """A character, and the files that it was read from."""
    from motorcade.animation.formats import FormatError, read_character

    try:
        with files_read() as files:
            return read_character(path, up=up, front=front, hide=hide), files
    except FormatError as fault:
        raise ValueError(f"placed.character: {fault}") from fault


def clip_named(character: Character, name: str) -> Clip:
    """One of the character's clips, or else the mannequin's of that name, retargeted.

    Raises:
        ValueError: neither has such a clip, or the joints do not tell a figure; the message
            names the knob.
    """
    if any(clip.name == name for clip in character.clips):
        return character.clip(name)
    figure = mannequin()
    lent = [clip.name for clip in figure.clips]
    if name not in lent:
        advice = did_you_mean(name, dict.fromkeys([clip.name for clip in character.clips] + lent))
        raise ValueError(f"placed.clip: no clip {name!r}; {advice}")
    try:
        legs = fitted_legs(legs_of(character.skeleton), character)
        return retarget(figure.clip(name), figure.skeleton, character.skeleton, legs=legs)
    except ValueError as fault:
        raise ValueError(
            f"placed.clip: the character has no clip {name!r} of its own, and the mannequin's does "
            f"not fit it ({fault})"
        ) from fault


def standing_clip(character: Character, clip: Clip) -> tuple[Clip, float]:
    """A clip as it stands on something real, and by how many metres it was raised for that.

    An author's clip may float or be sunk; see `on_its_soles`.
    """
    return on_its_soles(character, fitted_legs(legs_of(character.skeleton), character), clip)


def looking_at(character: Character, clip: Clip, placement: Placement, point_m: FloatArray) -> Clip:
    """A standing clip with neck, head and eyes turned to a point ``(3,)`` of the world.

    It is as it was where nothing tells the character's head.
    """
    try:
        gaze = Gaze.of(character)
    except ValueError:
        return clip
    own = placement.world_T_character.inverse().apply(point_m) / placement.scale
    always = np.full(len(clip.time_s), np.inf)
    towards = np.tile(own, (len(clip.time_s), 1))
    return replace(clip, poses=gaze.looking(clip.poses.rigid, towards, always))


def _idle(character: Character) -> Clip:
    """What it does when it stands: its clip named idle, or the mannequin's; animals keep still.

    Raises:
        ValueError: the mannequin's does not fit.
    """
    own = any(clip.name == IDLE for clip in character.clips)
    if own or not figure_of(character.skeleton).four_legged:
        return clip_named(character, IDLE)
    return Clip(IDLE, np.zeros(1), character.skeleton.rest[None])


def path_of(numbers: tuple[float, ...]) -> GroundPath:
    """The path through points ``x, y, x, y, …`` of the plane, metres.

    Raises:
        ValueError: an odd number of coordinates, fewer than two points, neighbours at one place.
    """
    if len(numbers) < 4 or len(numbers) % 2:
        raise ValueError(f"placed.path: expected x,y of two points or more, came {numbers}")
    try:
        return GroundPath(np.reshape(numbers, (-1, 2)))
    except ValueError as fault:
        raise ValueError(f"placed.path: {fault}") from fault


def walked(
    character: Character,
    clip: Clip,
    path: FloatArray,
    scale: float,
    start: Motor,
    lasting_s: float = 0.0,
) -> Clip:
    """A clip that walks a path with planted feet, from standing to standing, and idles there.

    It stands as the clip named idle begins, its own or the mannequin's (an animal as it rests), and
    idles on for as long as is asked, but for two minutes at most; after that it stands still.

    Args:
        character: who walks; whose legs are told.
        clip: one cycle of a walk or run.
        path: ``(P, 2)`` points of the plane, metres.
        scale: of the character.
        start: where the character is placed, in the plane's frame.
        lasting_s: how long the clip shall last in all.

    Returns:
        poses in the frame of the placed character, at the character's own size.

    Raises:
        ValueError: a clip that is no cycle, or no legs.
    """
    skeleton = character.skeleton
    legs = fitted_legs(legs_of(skeleton), character)
    if not legs:
        raise ValueError("placed.path: neither bones nor names tell the character's legs")
    try:
        loop, speed_m_s = on_the_spot(clip, skeleton, legs)
    except ValueError as fault:
        raise ValueError(f"placed.path: '{clip.name}' is no walk ({fault})") from fault
    idle = _idle(character)
    standing = Clip("standing", idle.time_s[:1], idle.poses.rigid[:1])
    walk = walk_along(
        GroundPath(path), loop, skeleton, legs, speed_m_s, scale=scale, standing=standing
    )
    arrived_s = float(walk.time_s[-1])
    rest_s = np.arange(0.0, min(lasting_s - arrived_s, LONGEST_IDLE_S), 1.0 / IDLE_HZ)[1:]
    idling = replace(idle, poses=idle.poses.rigid).at(rest_s + idle.time_s[0])
    way = start.inverse() @ walk.plane_T_character
    # The placement grows the character, and the way with it.
    own = Motor.from_rotor_translation(way.rotor, way.translation_m / scale)
    rows = np.minimum(np.arange(len(walk.time_s) + len(rest_s)), len(walk.time_s) - 1)
    poses = Motor(np.concatenate([walk.poses.coefficients, idling.coefficients]))
    time_s = np.concatenate([walk.time_s, arrived_s + rest_s])
    return Clip(f"{clip.name} along a path", time_s, skeleton.moved(poses, own[rows]))


def performers(placed: PlacedCharacter, lasting_s: float = 0.0) -> list[Performer]:
    """Those that stand in the footage, one or more, with clips that begin at its first frame.

    Args:
        placed: what the stage of that name made.
        lasting_s: how long a clip shall last in all; one of a walk, that is.

    Raises:
        ValueError: a character or clip that is no longer there.
    """
    if placed.parts:
        return [
            Performer(
                character_named(part.character, part.up, part.front),
                part.clip,
                part.placement,
                part.motion,
                placed.ground_motion if part.motion is None else part.ground_motion,
                part.visible_s,
            )
            for part in placed.parts
        ]
    character = character_named(placed.character, placed.up, placed.front, placed.hide)
    clip = clip_named(character, placed.clip)
    if len(placed.path_m):
        scale, start = placed.placement.scale, placed.plane_T_character
        clip = walked(character, clip, placed.path_m, scale, start, lasting_s)
    else:
        clip, _ = standing_clip(character, clip)
        if placed.looks_at_m is not None:
            clip = looking_at(character, clip, placed.placement, placed.looks_at_m)
    return [Performer(character, clip, placed.placement, ground_motion=placed.ground_motion)]
