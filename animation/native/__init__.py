"""Compiled posing and skinning; see `motorcade.animation.skin`."""
