"""Cycles for walks: a clip on the spot, and how fast the ground should go under it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.blend import closed
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg, find_stances
from motorcade.animation.skeleton import Skeleton, with_joint
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

# Less than this share of the highest joint's height is no way for a cycle to go.
NO_WAY = 0.1
# Of the time, the lowest moments of a foot, by which the ground's speed is first guessed.
LOWEST = 0.3
SAMPLES, REFINED = 240, 3


def on_the_spot(clip: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> tuple[Clip, float]:
    """A walk or run as a loop on the spot, facing +x, and its speed in m/s over the ground.

    A clip that travels has its way taken out evenly, so that what sways within a cycle stays; a
    clip on the spot tells its speed by how fast standing feet go back.

    Args:
        clip: one cycle, or a loop, of the skeleton.
        skeleton: with J joints.
        legs: whose feet tell the speed.

    Raises:
        ValueError: a clip of one pose, whose joints grow, or that does not end as it began; no
            legs for a clip on the spot, or one whose feet never go back.
    """
    poses = clip.poses
    if isinstance(poses, Similarity) or len(clip.time_s) < 2:
        raise ValueError(f"on_the_spot(clip): expected rigid poses, two or more, in '{clip.name}'")
    root = skeleton.root
    at = poses[:, root].translation_m
    way = (at[-1] - at[0]) * [1.0, 1.0, 0.0]
    length = float(np.linalg.norm(way))
    tall = float(np.max(skeleton.rest_world.translation_m[:, 2]))
    if length < NO_WAY * tall:
        loop = closed(clip)
        speed = _ground_speed(loop, skeleton, legs)
        if not speed * loop.duration_s >= NO_WAY * tall:
            raise ValueError(f"on_the_spot(clip): expected feet that go back, in '{clip.name}'")
        return loop, speed
    share = (clip.time_s - clip.time_s[0]) / clip.duration_s
    turn = turn_z(-np.arctan2(way[1], way[0]))
    back = Motor.from_rotor_translation(
        turn.reshape(1), turn.apply(-share[:, None] * way - at[0] * [1.0, 1.0, 0.0])
    )
    made = with_joint(poses, root, back @ poses[:, root])
    loop = closed(replace(clip, poses=made, looped=False))
    return loop, length / clip.duration_s


def _ground_speed(clip: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> float:
    """How fast the ground has to go back under a loop for standing feet to stand on it."""
    if not legs:
        raise ValueError(f"on_the_spot(legs): expected legs, as '{clip.name}' stays on the spot")
    time_s = np.linspace(0.0, clip.duration_s, SAMPLES + 1)
    poses = clip.at(clip.time_s[0] + time_s)
    balls = [skeleton.index(leg.ball) for leg in legs]
    at = skeleton.world(poses).translation_m[:, balls]
    speed = float(np.median([_backward(at[:, k], time_s, None) for k in range(len(balls))]))
    for _ in range(REFINED):
        shift = np.stack([speed * time_s, 0.0 * time_s, 0.0 * time_s], axis=-1)
        found = []
        for k in range(len(balls)):
            standing = find_stances(at[:, k] + shift, time_s)
            found.append(_backward(at[:, k], time_s, standing if np.any(standing) else None))
        speed = float(np.mean(found))
    return speed


def _backward(at: FloatArray, time_s: FloatArray, standing: NDArray[np.bool_] | None) -> float:
    """Median speed towards −x while a foot stands, or at its lowest."""
    speed = -np.gradient(at[:, 0], time_s)
    if standing is None:
        return float(np.median(speed[np.argsort(at[:, 2])[: max(2, int(LOWEST * len(at)))]]))
    return float(np.median(speed[standing]))
