"""Which clips stand, and how high: what an author left floating or sunk is put on the ground.

A clip as it is read stays as its author made it, soles that hang over the ground or are below it
included. Where it is placed on something real, one constant height puts it on its soles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg
from motorcade.animation.ik.soles import sole_points
from motorcade.animation.retarget.roles import body_of
from motorcade.animation.skeleton import with_joint
from motorcade.animation.vectors import UP, unit
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

# Soles that stand, in heights of the figure: how near to the ground, and how fast at the most up or
# down, and over the ground beside what it does on average (a walk on the spot slides evenly).
NEAR, FAST_UP, FAST_ALONG = 0.05, 0.1, 0.3
# What it stands on is at one height, within so many heights of the figure.
ONE_GROUND = 0.02
# A figure on its feet: its hips as a share of their height at rest, and how much the cosine of the
# trunk against up may differ from that at rest.
HIPS, TRUNK = 0.6, 0.5
# The share of its moments in which a clip stands that is to be called standing.
MOSTLY = 0.5
# Moments that are looked at, and between which speeds are taken.
RATE_HZ, MOST = 60.0, 1000


def standing_height_m(character: Character, legs: Sequence[Leg], clip: Clip) -> float | None:
    """Height of the lowest sole over z = 0 while a clip stands, its median; None if it does not.

    A moment stands if the lowest point of all soles is near the ground and nearly at rest, the hips
    are up and the trunk is upright; a clip does in which that holds, at one height, for half of the
    moments or more. What flies, lies, sits or falls does not, nor what runs
    in long leaps.

    Args:
        character: whose clip it is.
        legs: of it, with edges (`fitted_legs`).
        clip: of its skeleton.

    >>> from motorcade.animation import legs_of, mannequin
    >>> from motorcade.animation.ik import fitted_legs
    >>> from motorcade.animation.place import standing_height_m
    >>> figure = mannequin()
    >>> legs = fitted_legs(legs_of(figure.skeleton), figure)
    >>> round(standing_height_m(figure, legs, figure.clip("idle")), 2) + 0.0
    0.0
    """
    body = body_of(character.skeleton)
    if not legs or "hips" not in body:
        return None
    step_s = min(1.0 / RATE_HZ, clip.duration_s)
    count = min(int(np.ceil(clip.duration_s * RATE_HZ)) + 1, MOST)
    middle = np.linspace(clip.time_s[0], clip.time_s[-1], count)
    first = np.clip(middle - 0.5 * step_s, clip.time_s[0], clip.time_s[-1] - step_s)
    places = [_soles(character, legs, clip, at) for at in (first, middle, first + step_s)]
    lowest = np.argmin(places[1][..., 2], axis=1)
    before, at, after = (one[np.arange(count), lowest] for one in places)
    speed = (after - before) / step_s if step_s > 0.0 else np.zeros_like(at)
    stands = (np.abs(at[:, 2]) < NEAR) & (np.abs(speed[:, 2]) < FAST_UP)
    stands &= _upright(character, clip, middle)
    if np.any(stands):
        slides = np.median(speed[stands, :2], axis=0)
        stands &= np.linalg.norm(speed[:, :2] - slides, axis=1) < FAST_ALONG
    if np.any(stands):
        stands &= np.abs(at[:, 2] - np.median(at[stands, 2])) < ONE_GROUND
    if np.mean(stands) < MOSTLY:
        return None
    return float(np.median(at[stands, 2]) * character.height_m)


def on_its_soles(character: Character, legs: Sequence[Leg], clip: Clip) -> tuple[Clip, float]:
    """A clip raised or lowered as a whole so that it stands on z = 0, and by how many metres.

    One that does not stand stays as it is.

    Args:
        character: whose clip it is.
        legs: of it, with edges (`fitted_legs`).
        clip: of its skeleton.
    """
    height_m = standing_height_m(character, legs, clip)
    if height_m is None:
        return clip, 0.0
    lift, poses = Motor.from_translation(-height_m * UP), clip.poses
    for root in np.flatnonzero(character.skeleton.parents < 0):
        if isinstance(poses, Motor):
            poses = with_joint(poses, int(root), lift @ poses[:, root])
        else:
            grown = Similarity.from_motor_scale(lift) @ poses[:, root]
            poses = with_joint(poses, int(root), grown)
    return replace(clip, poses=poses), -height_m


def _soles(character: Character, legs: Sequence[Leg], clip: Clip, time_s: FloatArray) -> FloatArray:
    """Points of all soles ``(F, P, 3)``, in heights of the figure."""
    skeleton = character.skeleton
    world = skeleton.world(clip.at(time_s).rigid)
    found = []
    for leg in legs:
        ankle, ball = leg.foot(skeleton)
        found.append(sole_points(skeleton, (world[:, ankle], world[:, ball]), leg.sole(skeleton)))
    return np.concatenate(found, axis=1) / character.height_m


def _upright(character: Character, clip: Clip, time_s: FloatArray) -> NDArray[np.bool_]:
    """Whether the figure is on its feet ``(F,)``, by its hips and trunk."""
    skeleton = character.skeleton
    body, rest = body_of(skeleton), skeleton.rest_world.translation_m
    at = skeleton.world(clip.at(time_s).rigid).translation_m
    hips = body["hips"]
    up: NDArray[np.bool_] = at[:, hips, 2] > HIPS * rest[hips, 2]
    top = body.get("neck", body.get("head"))
    if top is not None:
        off = unit(at[:, top] - at[:, hips])[:, 2] - unit(rest[top] - rest[hips])[2]
        up &= np.abs(off) < TRUNK
    return up
