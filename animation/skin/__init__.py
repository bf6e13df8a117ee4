"""Skinning: a character's mesh carried by its joints."""

from motorcade.animation.skin.pose_field import PoseField
from motorcade.animation.skin.skinning import SKIN_METHODS, SkinMethod, Skinner, palette, skin

__all__ = ["SKIN_METHODS", "PoseField", "SkinMethod", "Skinner", "palette", "skin"]
