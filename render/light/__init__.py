"""Light of a scene: chosen for the viewer, or estimated from the images."""

from motorcade.render.light.estimate import harmonics, rotate_harmonics
from motorcade.render.light.ground import MOST_OVER, PAPER, Prints
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
