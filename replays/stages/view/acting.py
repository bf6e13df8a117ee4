"""The character of a scene and its motion: the mannequin or a file, clips, walks along a path.

Who is drawn and exported: the placed character, or all of a cast or a scene, as they move.

A cast on a plane: characters with their motions become actors, what they do becomes poses.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from motorcade.animation import Character, Clip, Placement, mannequin
from motorcade.animation.behaviour import (
    Act,
    Actor,
    ClipLayer,
    Crowd,
    Errand,
    Gaze,
    LookTarget,
    Performance,
    gait_between,
    keep_apart,
    perform,
)
from motorcade.animation.behaviour.crowd import closest_m
from motorcade.animation.behaviour.performance import foot_slides_m
from motorcade.animation.formats import FormatError, read_motion
from motorcade.animation.ik import fitted_legs
from motorcade.animation.place import GroundPath, on_its_soles, on_the_spot, walk_along
from motorcade.animation.retarget import body_of, legs_of
from motorcade.animation.retarget.reference import figure_of
from motorcade.animation.retarget.transfer import retarget
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import files_now, files_read, is_there, put_on_record
from motorcade.ga.names import did_you_mean
from motorcade.render import Performer
from motorcade.replays.io.readers.manifest.cast import CAMERA, Cast, CastMember, LayerAsked
from motorcade.replays.stages.values.view import PartState, PlacedCharacter, PlayedPart

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


log = logging.getLogger("motorcade.placed")

# Bodies keep this share of the smaller one's height apart where the cast says nothing.
GAP = 0.1
# The joints from which a mask goes down the skeleton, by their roles; the first that is there.
_FROM = {
    "upper": ("spine_1", "neck", "head"),
    "left_arm": ("left_clavicle", "left_upper_arm"),
    "right_arm": ("right_clavicle", "right_upper_arm"),
    "head": ("neck", "head"),
}


def actor_of(member: CastMember, height_m: float) -> Actor:
    """A member of a cast, ready to act.

    Args:
        member: as the cast asks for it.
        height_m: as tall as it shall stand, where the cast does not say.

    Raises:
        ValueError: a file that cannot be read, a clip that is not there (the message lists those
            that are), gaits that are none, a path for a character without legs; each names the
            member.
    """
    try:
        character = with_motions(_character(member), member.motions)
        skeleton = character.skeleton
        legs = tuple(fitted_legs(legs_of(skeleton), character))
        idle = rigid_clip(character, member.idle)
        acts = {
            name: Act.of(rigid_clip(character, name), skeleton, legs)
            for name in dict.fromkeys(member.acts)
        }
        layers = tuple(_layer(character, one) for one in member.layers)
        if member.look_at is not None:
            Gaze.of(character)  # refused here rather than when it acts
        cycle, speed_m_s = None, 1.0
        if len(member.path_m) > 1:
            if not legs:
                raise ValueError("neither bones nor names tell the character's legs")
            gaits = [rigid_clip(character, name) for name in member.gaits]
            cycle, speed_m_s = gait_between(gaits, skeleton, legs, member.speed_m_s)
    except ValueError as fault:
        raise ValueError(f"cast, '{member.name}': {fault}") from fault
    scale = (member.height_m or height_m) / character.height_m
    return Actor(member.name, character, legs, scale, idle, cycle, speed_m_s, acts, layers)


def with_motions(character: Character, motions: tuple[Path, ...]) -> Character:
    """The character with the clips of further files, retargeted to it.

    A clip whose name is taken is called by its file as well: "dance/take 1".

    Raises:
        ValueError: a file that cannot be read, or whose skeleton shares nothing with its own.
    """
    clips, taken = list(character.clips), {clip.name for clip in character.clips}
    legs = fitted_legs(legs_of(character.skeleton), character)
    for file in motions:
        try:
            motion = read_motion(file)
        except FormatError as fault:
            raise ValueError(str(fault)) from fault
        for notice in motion.notices:
            log.info("%s: %s", file.name, notice)
        for clip in motion.clips:
            name = clip.name if clip.name not in taken else f"{file.stem}/{clip.name}"
            if name in taken:
                raise ValueError(f"{file}: expected clips of different names, got {name!r} twice")
            taken.add(name)
            try:
                retargeted = retarget(clip, motion.skeleton, character.skeleton, legs=legs)
            except ValueError as fault:
                raise ValueError(
                    f"{file}: '{clip.name}' does not fit the character ({fault})"
                ) from fault
            clips.append(replace(retargeted, name=name))
    return replace(character, clips=tuple(clips))


def played(
    cast: Cast,
    plane: Motor,
    height_m: float,
    camera: LookTarget,
    lasts_s: float,
) -> tuple[tuple[PlayedPart, ...], float]:
    """What everybody of a cast does on a plane, and the least distance between two bodies,
    both until the recording ends.

    Args:
        cast: as it was asked for.
        plane: ``world_T_plane``.
        height_m: of those whose height the cast does not say.
        camera: where it is on the plane, from its first frame on: those face it who are not told
            where to, and look at it who are asked to.
        lasts_s: of the recording.

    Raises:
        ValueError: see `actor_of` and `keep_apart`.
    """
    actors = [actor_of(member, height_m) for member in cast.members]
    towards = camera.at(0.0)[:2]
    errands = [_errand(member, towards) for member in cast.members]
    smallest = min(actor.scale * actor.character.height_m for actor in actors)
    gap_m = GAP * smallest if cast.gap_m is None else cast.gap_m
    try:
        crowd = keep_apart(list(zip(actors, errands, strict=True)), gap_m)
    except ValueError as fault:
        raise ValueError(f"cast: {fault}") from fault
    _tell(crowd, actors, lasts_s)
    performances = []
    for member, timeline in zip(cast.members, crowd.timelines, strict=True):
        lasting = max(min(lasts_s, timeline.done_s + LONGEST_IDLE_S), 0.1)
        seen_s = max(lasts_s, 0.1)
        performances.append(
            perform(timeline, lasting, look_at=_look_at(member, camera), most_s=seen_s)
        )
    apart_m = closest_m(list(zip(actors, performances, strict=True)))
    if np.isfinite(apart_m):
        log.info("cast: bodies are %.3g m apart or more", apart_m)
    parts = tuple(
        _part(member, actor, performance, note, plane)
        for member, actor, performance, note in zip(
            cast.members, actors, performances, crowd.notes, strict=True
        )
    )
    return parts, apart_m


def _look_at(member: CastMember, camera: LookTarget) -> LookTarget | None:
    if member.look_at is None or isinstance(member.look_at, str):
        return camera if member.look_at == CAMERA else None
    return LookTarget(np.zeros(1), member.look_at[None])


def _errand(member: CastMember, towards: FloatArray) -> Errand:
    start = member.path_m[0]
    walks = len(member.path_m) > 1
    away = (member.path_m[1] if walks else towards) - start
    heading = float(np.arctan2(away[1], away[0]))
    if member.heading_deg is not None:
        heading = float(np.deg2rad(member.heading_deg))
    facing = None if member.facing_deg is None else float(np.deg2rad(member.facing_deg))
    if facing is None and walks:  # as a guest would: to whoever looks
        back = towards - member.path_m[-1]
        facing = float(np.arctan2(back[1], back[0]))
    path = member.path_m if walks else np.zeros((0, 2))
    return Errand(start, heading, path, facing, member.acts, member.waits_s)


def _tell(crowd: Crowd, actors: list[Actor], lasts_s: float) -> None:
    """Say in the log who waits, goes round, cannot go, or is not done when the recording ends."""
    for timeline in crowd.timelines:
        if timeline.done_s > lasts_s:
            log.warning(
                "cast: '%s' is done at %.1f s, and the recording ends at %.1f s",
                timeline.actor.name,
                timeline.done_s,
                lasts_s,
            )
    for actor, note in zip(actors, crowd.notes, strict=True):
        if note:
            say = log.warning if actor.name in crowd.stays else log.info
            say("cast: '%s' %s", actor.name, note)


def _part(
    member: CastMember, actor: Actor, performance: Performance, note: str, plane: Motor
) -> PlayedPart:
    """Poses in the frame of a placement in the middle of the way, where light is made for."""
    places = performance.plane_T_character.translation_m
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    start = Motor.from_rotor_translation(performance.plane_T_character[0].rotor, middle)
    way = start.inverse() @ performance.plane_T_character
    own = Motor.from_rotor_translation(way.rotor, way.translation_m / actor.scale)
    slides = [slide for _, _, slide in foot_slides_m(actor, performance)]
    return PlayedPart(
        member.name,
        member.file,
        Placement(plane @ start, actor.scale),
        performance.time_s,
        actor.skeleton.moved(performance.poses, own),
        states_of(performance),
        note,
        max(slides, default=0.0),
        up=member.up,
        front=member.front,
    )


def states_of(performance: Performance) -> tuple[PartState, ...]:
    """What is done when, up to the performance's end."""
    last_s = float(performance.time_s[-1])
    return tuple(
        PartState(segment.state, segment.clip, segment.start_s, min(segment.end_s, last_s))
        for segment in performance.segments
        if segment.start_s <= last_s
    )


def _character(member: CastMember) -> Character:
    """The mannequin or that of a file, whose faults are those of the cast's key."""
    try:
        return character_named(member.file, member.up, member.front)
    except ValueError as fault:
        text = str(fault).removeprefix("placed.")
        key = "" if text.startswith(("up: ", "front: ")) else "file: "
        raise ValueError(f"{key}{text.removeprefix('character: ')}") from fault


def rigid_clip(character: Character, name: str) -> Clip:
    """A clip of the character by its name, or the mannequin's of that name, rigid."""
    try:
        chosen = clip_named(character, name)
    except ValueError as fault:
        if any(clip.name == name for clip in character.clips):
            raise
        names = ", ".join(repr(clip.name) for clip in character.clips) or "none"
        advice = did_you_mean(name, [clip.name for clip in character.clips])
        raise ValueError(f"no clip {name!r} among its own ({names}); {advice}") from fault
    return replace(chosen, poses=chosen.poses.rigid, morphs=None)


def _layer(character: Character, asked: LayerAsked) -> ClipLayer:
    mask = asked.weight * mask_of(character.skeleton, asked.joints)
    return ClipLayer(rigid_clip(character, asked.clip), mask, asked.during, asked.additive)


def mask_of(skeleton: Skeleton, joints: str) -> FloatArray:
    """1 for the joints that a word means, and all that hang on them."""
    if joints == "whole":
        return np.ones(len(skeleton))
    body, mask = body_of(skeleton), np.zeros(len(skeleton))
    first = next((body[role] for role in _FROM[joints] if role in body), None)
    if first is None:
        raise ValueError(f"layers: its joints do not tell '{joints}'")
    mask[first] = 1.0
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0 and mask[parent] > 0.0:
            mask[joint] = 1.0
    return mask


def check_cast(cast: Cast) -> None:
    """Refuse what can be refused before a recording is looked at: files, clips, gaits.

    Raises:
        ValueError: see `actor_of`.
    """
    for member in cast.members:
        actor_of(member, 1.0)
