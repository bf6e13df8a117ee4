"""What a character or prop of a scene does with its joints over a recording, and where it walks.

Whether all that a scene asks of its files is there, characters, clips and joints, is checked here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.animation import Character, Clip
from motorcade.animation.authoring import Scene, ScenePart, SceneWalk, read_scene
from motorcade.animation.authoring.parts import JointKeyframe, SceneLayer
from motorcade.animation.behaviour import Actor, Errand, Timeline, gait_between, perform
from motorcade.animation.behaviour.performance import foot_slides_m
from motorcade.animation.behaviour.sources import Layered
from motorcade.animation.blend import Shifted
from motorcade.animation.easing import FADE_S, smoothstep
from motorcade.animation.ik import fitted_legs
from motorcade.animation.retarget import legs_of
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.readers.manifest.cast import file_of
from motorcade.replays.stages.values.view import PartState
from motorcade.replays.stages.view.acting import (
    IDLE,
    LONGEST_IDLE_S,
    character_named,
    mask_of,
    rigid_clip,
    states_of,
)

RATE_HZ = 60.0
MOST_POSES = 2**24
"""Of all joints and objects over a recording: a gigabyte."""


@dataclass(frozen=True, eq=False)
class Acted:
    """A character or prop, and what it does in its own frame.

    Fields:
        file: "mannequin", or where it was read from.
        character: who or what.
        size: from its file's metres to what it is at scale 1 of the scene.
        time_s: ``(F,)`` from the first frame on.
        poses: Motor ``(F, J)``, local poses.
        parent_T_character: Motor ``(F,)``, its way on foot; None where it does not walk.
        states: what it does when.
        worst_slide_m: the farthest that a walker's foot goes on the ground in one step.
    """

    file: str
    character: Character
    size: float
    time_s: FloatArray
    poses: Motor
    parent_T_character: Motor | None
    states: tuple[PartState, ...]
    worst_slide_m: float | None = None


def acted(scene: Scene, name: str, folder: Path, lasts_s: float) -> Acted:
    """Read who or what an object is, and play what it does.

    Args:
        scene: that it belongs to.
        name: of a character or prop.
        folder: that files are named from.
        lasts_s: of the recording; what is done earlier is followed by two minutes of idling at
            most.

    Raises:
        ValueError: a file that cannot be read, a clip, gait or joint that is not there; the message
            names the object.
    """
    part, character = scene.part(name), cast_as(scene, name, folder)
    try:
        size = 1.0 if part.height_m is None else part.height_m / character.height_m
        time_s = _clock(part, lasts_s)
        if len(time_s) * len(character.skeleton) > MOST_POSES:
            raise ValueError(
                f"expected to be done earlier: {time_s[-1]:.0f} s are more than {MOST_POSES} poses "
                "of its joints"
            )
        way: Motor | None = None
        slide_m: float | None = None
        states: tuple[PartState, ...]
        if part.walk is None:
            clip = _clip(character, part)
            poses = _played(clip, time_s - part.clip_start_s)
            states = (PartState("act" if part.clip else "idle", clip.name, 0.0, float(time_s[-1])),)
        else:
            scale = size * float(scene.pose(name).as_similarity().scale)
            actor = _walker(name, character, scale, part, part.walk)
            performance = perform(_timeline(actor, part.walk), float(time_s[-1]), RATE_HZ)
            time_s, poses = performance.time_s, performance.poses
            way = performance.plane_T_character
            slide_m = max((slide for _, _, slide in foot_slides_m(actor, performance)), default=0.0)
            states = states_of(performance)
        for layer in part.layers:
            poses = _layered(character, layer, time_s, poses)
        poses = _turned(character.skeleton, part, time_s, poses)
    except ValueError as fault:
        raise ValueError(f"scene, '{name}': {fault}") from fault
    return Acted(file_of(part, folder), character, size, time_s, poses, way, states, slide_m)


def _clock(part: ScenePart, lasts_s: float) -> FloatArray:
    """Times at which it is played: one alone for what never changes."""
    if part.kind == "prop" and part.clip is None and not part.joint_keyframes:
        return np.zeros(1)
    last_s = max(
        [
            part.clip_start_s,
            *(one.time_s if one.end_s is None else one.end_s for one in part.joint_keyframes),
            *(one.start_s if one.end_s is None else one.end_s for one in part.layers),
        ]
    )
    until_s = max(min(lasts_s, last_s + LONGEST_IDLE_S), 1.0 / RATE_HZ)
    return np.arange(int(np.ceil(until_s * RATE_HZ)) + 1) / RATE_HZ


def _clip(character: Character, part: ScenePart) -> Clip:
    """What it plays besides walking: its clip, or as a prop it rests and as a character idles."""
    if part.clip is not None:
        return rigid_clip(character, part.clip)
    if part.kind == "prop":
        return Clip("rest", np.zeros(1), character.skeleton.rest.reshape(1, -1))
    return rigid_clip(character, IDLE)


def _played(clip: Clip, passed_s: FloatArray) -> Motor:
    """Its poses so long after its beginning; before that it stands as it begins."""
    return clip.at(np.maximum(passed_s, 0.0) + clip.time_s[0]).rigid


def _walker(
    name: str, character: Character, scale: float, part: ScenePart, walk: SceneWalk
) -> Actor:
    """One that walks, as large as `scale` makes it."""
    skeleton = character.skeleton
    legs = tuple(fitted_legs(legs_of(skeleton), character))
    if not legs:
        raise ValueError("walk: neither bones nor names tell the character's legs")
    gaits = [rigid_clip(character, one) for one in walk.gaits]
    cycle, speed_m_s = gait_between(gaits, skeleton, legs, walk.speed_m_s)
    return Actor(name, character, legs, scale, _clip(character, part), cycle, speed_m_s)


def _timeline(actor: Actor, walk: SceneWalk) -> Timeline:
    """It looks along its path, waits, and walks."""
    x, y = walk.path_m[1] - walk.path_m[0]
    heading = float(np.arctan2(y, x))
    return Timeline(actor, Errand(walk.path_m[0], heading, walk.path_m, waits_s=walk.start_s))


def _layered(character: Character, layer: SceneLayer, time_s: FloatArray, poses: Motor) -> Motor:
    """Poses with a layer over them, faded in and out."""
    clip = rigid_clip(character, layer.clip)
    mask = layer.weight * mask_of(character.skeleton, layer.joints)
    # One that never ends is not faded out.
    never_s = float(time_s[-1]) + 2.0 * layer.fade_s + 1.0
    span = layer.start_s, never_s if layer.end_s is None else layer.end_s
    within = (time_s >= span[0]) & (time_s <= span[1])
    if not np.any(within):
        return poses
    over = Shifted(clip, layer.start_s, float(clip.time_s[0]))
    reference = clip.poses.rigid[0] if layer.additive else None
    layered = Layered(Clip("below", time_s, poses), over, mask, span, layer.fade_s, reference)
    changed = poses.coefficients.copy()
    changed[within] = layered.at(time_s[within]).coefficients
    return Motor(changed)


def _turned(skeleton: Skeleton, part: ScenePart, time_s: FloatArray, poses: Motor) -> Motor:
    """Poses with the joints turned as keyframes have them, out of their clips and back to them."""
    keys: dict[str, list[JointKeyframe]] = {}
    for joint_keyframe in part.joint_keyframes:
        for joint in joint_keyframe.rotors:
            keys.setdefault(joint, []).append(joint_keyframe)
    changed = poses.coefficients.copy()
    for joint, key in keys.items():
        number = skeleton.index(joint)
        rotors = Rotor.stack([one.rotors[joint] for one in key])
        before, after, share, weight = _between(key, time_s)
        turn = rotors[before].interpolate(rotors[after], share)
        kept = poses[:, number]
        turn = kept.rotor.interpolate(turn, weight)
        changed[:, number] = Motor.from_rotor_translation(turn, kept.translation_m).coefficients
    return Motor.normalize(changed) if keys else poses


def _between(
    joint_keyframes: Sequence[JointKeyframe], time_s: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """The poses ``(T,)`` of a joint between which it is, its share of the way, and their weight."""
    at = np.array([one.time_s for one in joint_keyframes])
    next_at = np.append(at[1:], np.inf)
    ends = np.array([np.inf if one.end_s is None else one.end_s for one in joint_keyframes])
    ended = ends < next_at
    before = np.clip(np.searchsorted(at, time_s, side="right") - 1, 0, len(at) - 1)
    after = np.minimum(before + 1, len(at) - 1)
    leaves = np.where(ended, ends, at)[before]
    share = np.clip((time_s - leaves) / np.maximum(at[after] - leaves, 1e-12), 0.0, 1.0)
    held = ~ended[before] | (time_s <= ends[before])
    going = smoothstep(1.0 - (time_s - np.where(held, time_s, ends[before])) / FADE_S)
    early = time_s < at[0]
    coming = smoothstep(1.0 - (np.where(early, at[0], next_at[before]) - time_s) / FADE_S)
    return before, after, share, np.where(early, coming, np.maximum(going, coming))


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
    return sorted(names, key=lambda name: scene.part(name).kind != "character")


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
        for joint_keyframe in part.joint_keyframes:
            for joint in joint_keyframe.rotors:
                character.skeleton.index(joint)
    except ValueError as fault:
        text = str(fault).removeprefix("placed.character: ").removeprefix("placed.clip: ")
        raise ValueError(f"scene, '{name}': {text}") from fault
    return character
