"""Behaviour: characters that idle, turn, walk, arrive and act, and keep out of each other's way."""

from motorcade.animation.behaviour.actor import Act, Actor, ClipLayer, gait_between
from motorcade.animation.behaviour.crowd import Crowd, closest_m, keep_apart
from motorcade.animation.behaviour.performance import (
    Errand,
    Performance,
    Timeline,
    foot_slides_m,
    perform,
)
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
    "closest_m",
    "foot_slides_m",
    "gait_between",
    "keep_apart",
    "perform",
]
