"""Inverse kinematics: limbs of two bones, chains of any length, aiming, and feet on the ground."""

from motorcade.animation.ik.chain import Chain, reach_with
from motorcade.animation.ik.fabrik import Reached, fabrik
from motorcade.animation.ik.feet import GroundHeights, Leg, find_stances, plant_feet
from motorcade.animation.ik.fitted import fitted_legs
from motorcade.animation.ik.two_bone import aim, bend_limb

__all__ = [
    "Chain",
    "GroundHeights",
    "Leg",
    "Reached",
    "aim",
    "bend_limb",
    "fabrik",
    "find_stances",
    "fitted_legs",
    "plant_feet",
    "reach_with",
]
