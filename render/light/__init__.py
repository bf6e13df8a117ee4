"""Light of a scene: chosen for the viewer, or estimated from the images."""

from motorcade.render.harmonics import harmonics, irradiance_factors, rotate_harmonics
from motorcade.render.light.cast import cast_shadows
from motorcade.render.light.estimate import (
    LightEstimate,
    ShadedPoints,
    estimate_light,
    shaded_points,
)
from motorcade.render.light.footage import ExposureMeter, lighting_of_footage
from motorcade.render.light.ground import GroundMap, ground_map
from motorcade.render.light.lamps import (
    above_ground,
    certainty,
    character_lighting,
    estimated_lighting,
    light_on,
    sun_share,
    sunlight_direction,
    viewer_frame,
)
from motorcade.render.light.monocular import (
    LightDirection,
    ground_of_footage,
    light_direction,
    lighting_without_depth,
)
from motorcade.render.light.prints import MOST_OVER, PAPER, Prints
from motorcade.render.light.sides import CastShadow

__all__ = [
    "MOST_OVER",
    "PAPER",
    "CastShadow",
    "ExposureMeter",
    "GroundMap",
    "LightDirection",
    "LightEstimate",
    "Prints",
    "ShadedPoints",
    "above_ground",
    "cast_shadows",
    "certainty",
    "character_lighting",
    "estimate_light",
    "estimated_lighting",
    "ground_map",
    "ground_of_footage",
    "harmonics",
    "irradiance_factors",
    "light_direction",
    "light_on",
    "lighting_of_footage",
    "lighting_without_depth",
    "rotate_harmonics",
    "shaded_points",
    "sun_share",
    "sunlight_direction",
    "viewer_frame",
]
