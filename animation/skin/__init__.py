"""Skinning: a character's mesh carried by its joints."""

from motorcade.animation.skin.palette import SKIN_METHODS, SkinMethod, palette
from motorcade.animation.skin.pose_field import PoseField
from motorcade.animation.skin.skinner import Skinner
from motorcade.animation.skin.skinning import skin

__all__ = ["SKIN_METHODS", "PoseField", "SkinMethod", "Skinner", "palette", "skin"]
