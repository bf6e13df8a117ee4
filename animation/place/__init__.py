"""Placement: characters on planes of the world, on anchors that tracking moves, and on paths."""

from motorcade.animation.place.anchors import Anchor, Placement, on_its_soles, place_on_plane
from motorcade.animation.place.walks import GroundPath, on_the_spot, walk_along

__all__ = [
    "Anchor",
    "GroundPath",
    "Placement",
    "on_its_soles",
    "on_the_spot",
    "place_on_plane",
    "walk_along",
]
