"""Retargeting: a clip of one skeleton played by another, by what joints are and how bones lie."""

from motorcade.animation.retarget.reference import body_of, facing_rad, legs_of
from motorcade.animation.retarget.transfer import retarget

__all__ = ["body_of", "facing_rad", "legs_of", "retarget"]
