"""Placement of characters in the world."""

from motorcade.animation.place.plane import Placement, place_on_plane

__all__ = ["Placement", "place_on_plane"]
