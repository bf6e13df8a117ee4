"""Light of a scene: chosen for the viewer, or estimated from the images."""

from motorcade.render.harmonics import harmonics, rotate_harmonics
from motorcade.render.light.lamps import (
    above_ground,
    character_lighting,
    light_on,
    sun_share,
    sunlight_direction,
)
from motorcade.render.light.monocular import (
    ExposureMeter,
    ground_of_footage,
    lighting_of_footage,
    lighting_without_depth,
)
from motorcade.render.light.prints import MOST_OVER, PAPER, Prints

__all__ = [
    "MOST_OVER",
    "PAPER",
    "ExposureMeter",
    "Prints",
    "above_ground",
    "character_lighting",
    "ground_of_footage",
    "harmonics",
    "light_on",
    "lighting_of_footage",
    "lighting_without_depth",
    "rotate_harmonics",
    "sun_share",
    "sunlight_direction",
]
