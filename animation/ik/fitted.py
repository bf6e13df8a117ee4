"""Legs whose soles are measured on a mesh: boots are longer than feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motorcade.animation.character import Character
from motorcade.animation.ik.feet import Leg

# What lies lower, as a share of the height, is sole.
LOW = 0.02


def fitted_legs(legs: Sequence[Leg], character: Character) -> list[Leg]:
    """The legs with heels and tips where the mesh has them at rest, standing on z = 0.

    A leg without a ball, or without skin that follows its foot near the ground, stays as it is.

    Args:
        legs: of the character's skeleton.
        character: in its rest pose.
    """
    skeleton, at = character.skeleton, character.skeleton.rest_world.translation_m
    rows = np.arange(len(character.joints))
    heaviest = character.joints[rows, np.argmax(character.weights, axis=1)]
    low = character.vertices[:, 2] < LOW * character.height_m
    made = []
    for leg in legs:
        ankle, ball = leg.foot(skeleton)
        along = (at[ball] - at[ankle])[:2]
        sole = character.vertices[low & np.isin(heaviest, (ankle, ball))]
        if len(sole) and np.any(along):
            share = (sole[:, :2] - at[ankle, :2]) @ along / (along @ along)
            leg = replace(leg, heel=float(-share.min()), tip=float(share.max() - 1.0))
        made.append(leg)
    return made
