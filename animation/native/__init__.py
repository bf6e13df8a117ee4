"""Compiled posing and skinning; see `motorcade.animation.runtime` and `animation.skin`."""
