"""Light of a scene: chosen for the viewer, or estimated from the pictures."""

from motorcade.render.light.estimate import (
    LightEstimate,
    ShadedPoints,
    estimate_light,
    shaded_points,
)
from motorcade.render.light.footage import lighting_of_footage
from motorcade.render.light.harmonics import harmonics, irradiance_factors, rotate_harmonics
from motorcade.render.light.lamps import (
    certainty,
    character_lighting,
    estimated_lighting,
    light_on,
    sun_share,
    sunlight_direction,
    viewer_frame,
)
from motorcade.render.light.prints import Prints, lighting_without_depth

__all__ = [
    "LightEstimate",
    "Prints",
    "ShadedPoints",
    "certainty",
    "character_lighting",
    "estimate_light",
    "estimated_lighting",
    "harmonics",
    "irradiance_factors",
    "light_on",
    "lighting_of_footage",
    "lighting_without_depth",
    "rotate_harmonics",
    "shaded_points",
    "sun_share",
    "sunlight_direction",
    "viewer_frame",
]
