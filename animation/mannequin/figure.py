"""The mannequin itself: an artist's wooden figure with skeleton, skinned mesh and two clips."""

import numpy as np

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.mannequin.body import build_body
from motorcade.animation.mannequin.idle import idle
from motorcade.animation.mannequin.posing import turn_x, turn_y
from motorcade.animation.mannequin.proportions import (
    ARM_SPREAD_RAD,
    REFERENCE_HEIGHT_M,
    SIDES,
    THUMB_SPREAD_RAD,
    joint_rows,
)
from motorcade.animation.mannequin.walk import walk
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Rotor, Similarity


def mannequin(height_m: float = REFERENCE_HEIGHT_M) -> Character:
    """A jointed wooden figure, made in code, with the looped clips "idle" and "walk".

    Args:
        height_m: of the rest pose. Everything scales with it; times stay.

    Returns:
        A character of 52 joints: trunk, head, arms, hands with five fingers, legs, feet, toes.

    Raises:
        ValueError: a height that is not positive.
    """
    if not (np.isfinite(height_m) and height_m > 0.0):
        raise ValueError(f"mannequin(height_m): expected a positive height, got {height_m}")
    skeleton = _skeleton()
    clips = (idle(skeleton), walk(skeleton))
    world = skeleton.rest_world.as_matrix()
    index = {name: joint for joint, name in enumerate(skeleton.names)}
    body = build_body({name: world[joint] for name, joint in index.items()}, index)
    scale = height_m / float(body.vertices[:, 2].max())
    return Character(
        Skeleton(skeleton.names, skeleton.parents, _scaled(skeleton.rest, scale)),
        scale * body.vertices,
        body.normals,
        body.triangles,
        body.colors,
        body.joints,
        body.weights,
        tuple(
            Clip(clip.name, clip.time_s, _scaled(clip.poses, scale), clip.looped) for clip in clips
        ),
    )


def _skeleton() -> Skeleton:
    """The joint tree at the reference height."""
    rows = joint_rows()
    names = tuple(name for name, _, _ in rows)
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in rows])
    turned: dict[str, Rotor] = {}
    for side, sign in SIDES:
        turned[f"upper_arm_{side}"] = turn_x(sign * ARM_SPREAD_RAD)
        turned[f"thumb_1_{side}"] = turn_y(-THUMB_SPREAD_RAD)
    rotors = Rotor.stack([turned.get(name, Rotor.identity()) for name in names])
    offsets = np.array([offset for _, _, offset in rows])
    return Skeleton(names, parents, Motor.from_rotor_translation(rotors, offsets))


def _scaled(poses: Motor | Similarity, scale: float) -> Motor:
    """The same turns with all distances scaled."""
    return Motor.from_rotor_translation(poses.rotor, scale * poses.translation_m)
