"""Pointing at a scene: rays of fingers, what they move, turn and grow, and joints they drag."""

from motorcade.animation.authoring.pointing.posing import JointDrag, TurnedJoints
from motorcade.animation.authoring.pointing.rays import DragPlane, OutOfReach, Ray
from motorcade.animation.authoring.pointing.touch import moved, pinched, slid, turned, unwound

__all__ = [
    "DragPlane",
    "JointDrag",
    "OutOfReach",
    "Ray",
    "TurnedJoints",
    "moved",
    "pinched",
    "slid",
    "turned",
    "unwound",
]
