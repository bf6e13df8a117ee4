"""Light of a scene: chosen for the viewer, or estimated from the images."""

from motorcade.render.light.ground import Prints
from motorcade.render.light.lamps import character_lighting, sun_share, sunlight_direction
from motorcade.render.light.monocular import (
    ExposureMeter,
    lighting_of_footage,
    lighting_without_depth,
)

__all__ = [
    "ExposureMeter",
    "Prints",
    "character_lighting",
    "lighting_of_footage",
    "lighting_without_depth",
    "sun_share",
    "sunlight_direction",
]
