"""Legs whose soles are measured on a mesh: boots are longer and wider than feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motorcade.animation.character import Character
from motorcade.animation.ik.feet import Leg
from motorcade.ga.arrays import FloatArray, IntArray

# What lies lower, as a share of the height, is sole.
LOW = 0.02
# Directions in which a foot's farthest points are sought: about the vertical, and off it.
AROUND, OFF_DEG = 12, (20.0, 40.0, 60.0, 80.0)


def fitted_legs(legs: Sequence[Leg], character: Character) -> list[Leg]:
    """The legs with heels, tips and edges where the mesh has them at rest, standing on z = 0.

    Edges are what can touch the ground first, however the foot is tilted. A leg without skin that
    follows its foot near the ground stays as it is; one without a ball keeps its heel and tip.

    Args:
        legs: of the character's skeleton.
        character: in its rest pose.
    """
    skeleton, at = character.skeleton, character.skeleton.rest_world.translation_m
    joints, _ = character.influences
    heaviest = joints[:, 0]
    low = character.vertices[:, 2] < LOW * character.height_m
    made = []
    for leg in legs:
        ankle, ball = leg.foot(skeleton)
        along = (at[ball] - at[ankle])[:2]
        of_toes = np.isin(heaviest, _below(skeleton.parents, ball))
        of_foot = np.isin(heaviest, _below(skeleton.parents, ankle)) & ~of_toes
        sole = character.vertices[low & (of_foot | of_toes)]
        if len(sole) and np.any(along):
            share = (sole[:, :2] - at[ankle, :2]) @ along / (along @ along)
            leg = replace(leg, heel=float(-share.min()), tip=float(share.max() - 1.0))
        if len(sole):
            foot, toes = (_outermost(character.vertices[rows]) for rows in (of_foot, of_toes))
            leg = replace(leg, foot_m=foot, toes_m=toes)
        made.append(leg)
    return made


def _below(parents: IntArray, joint: int) -> list[int]:
    """A joint and those that hang on it."""
    found = [joint]
    for one in range(joint + 1, len(parents)):
        if parents[one] in found:
            found.append(one)
    return found


def _outermost(points: FloatArray) -> tuple[tuple[float, float, float], ...]:
    """Of points ``(P, 3)`` those that lie farthest in directions that point down."""
    if not len(points):
        return ()
    off, turn = np.meshgrid(np.radians(OFF_DEG), 2.0 * np.pi * np.arange(AROUND) / AROUND)
    ways = np.stack([np.sin(off) * np.cos(turn), np.sin(off) * np.sin(turn), -np.cos(off)], axis=-1)
    ways = np.concatenate([[[0.0, 0.0, -1.0]], ways.reshape(-1, 3)])
    rows = np.unique(np.argmax(ways @ points.T, axis=1))
    return tuple((float(x), float(y), float(z)) for x, y, z in points[rows])
