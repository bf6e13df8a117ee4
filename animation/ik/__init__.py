"""Inverse kinematics: figures with limits brought to goals, chains of points, limbs of two bones in
closed form, aiming, and feet on the ground.

`IkSolver` takes a skeleton, how its joints may turn, and goals for as many of them as one likes;
in live use each frame starts from the pose of the last. `fabrik` knows of points alone,
`bend_limb` and `aim` of one limb and one joint without limits; `plant_feet` works on whole motions.
"""

from motorcade.animation.ik.chain import Ball, Chain, Hinge, aim, bend_limb, fabrik, reach_with
from motorcade.animation.ik.feet import GroundHeights, Leg, find_stances, fitted_legs, plant_feet
from motorcade.animation.ik.solver import IkSolver, LookAt, PoseGoal

__all__ = [
    "Ball",
    "Chain",
    "GroundHeights",
    "Hinge",
    "IkSolver",
    "Leg",
    "LookAt",
    "PoseGoal",
    "aim",
    "bend_limb",
    "fabrik",
    "find_stances",
    "fitted_legs",
    "plant_feet",
    "reach_with",
]
