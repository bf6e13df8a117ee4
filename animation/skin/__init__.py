"""Skinning: from a pose of the skeleton to the mesh in character space."""

from motorcade.animation.skin.linear import skin

__all__ = ["skin"]
