"""Behaviour: characters that idle, turn, walk, arrive and act, and keep out of each other's way."""

from motorcade.animation.behaviour.actor import Act, Actor, ClipLayer, gait_between
from motorcade.animation.behaviour.crowd import Crowd, keep_apart
from motorcade.animation.behaviour.performance import Errand, Performance, Timeline, perform
from motorcade.animation.behaviour.sources import Gaze, LookTarget

__all__ = [
    "Act",
    "Actor",
    "ClipLayer",
    "Crowd",
    "Errand",
    "Gaze",
    "LookTarget",
    "Performance",
    "Timeline",
    "gait_between",
    "keep_apart",
    "perform",
]
