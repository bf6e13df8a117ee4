"""Light for a character that is set into footage: a sun over the viewer's shoulder, fill and rim.

Directions are in the world of the trajectory. By default nothing is taken from the images, and
the direction of the sun is the one knob that matters, since it throws the shadow;
`estimated_lighting` uses what `estimate_light` found in them.

Light from all around a figure: the sky above, and below the ground, which gives light back.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.animation import Placement
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.light.estimate import LightEstimate, harmonics, irradiance_factors
from motorcade.render.scene import Lamp, Lighting, Sun

# Share of each direction in where the light comes from: up, towards the viewer, viewer's left.
SUN_FROM = (1.0, 0.42, 0.55)
# Paints that face one way take shading for their own: of the synthetic room's contrast, 1.1, the
# estimate finds 0.46. Below the lesser bound a figure looks cut out of paper.
CONTRAST_LOST, CONTRASTS = 2.0, (0.7, 1.6)
# Of the estimate's own contrast: at the lesser its direction is chance, at the greater it is sure.
TELLING = (0.10, 0.30)
WARM, COOL = (1.0, 0.955, 0.89), (0.86, 0.92, 1.0)


def viewer_frame(placement: Placement, world_T_camera: Motor) -> FloatArray:
    """Up, towards the cameras, and to their left, seen from where the character stands.

    Args:
        placement: of the character.
        world_T_camera: Motor (N,), the cameras; their mean position counts.

    Returns:
        (3, 3) unit rows. Cameras straight above leave the second row to the character's own x.
    """
    stand = placement.world_T_character
    up, own = stand.rotor.apply(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
    away = np.mean(world_T_camera.translation_m.reshape(-1, 3), axis=0) - stand.translation_m
    level = away - np.dot(away, up) * up
    length = np.linalg.norm(level)
    ahead = own if length <= 1e-3 * np.linalg.norm(away) else level / length
    return np.stack([up, ahead, np.cross(ahead, up)])


def sunlight_direction(placement: Placement, world_T_camera: Motor) -> FloatArray:
    """The way the light travels by default: from high over the viewer's left shoulder.

    Args:
        placement: of the character.
        world_T_camera: Motor (N,), the cameras.

    Returns:
        (3,) unit vector in the world.
    """
    source = np.array(SUN_FROM) @ viewer_frame(placement, world_T_camera)
    return np.asarray(-source / np.linalg.norm(source))


def character_lighting(
    placement: Placement, world_T_camera: Motor, height_m: float, direction: FloatArray
) -> Lighting:
    """Sun, fill and rim light for a placed character.

    Args:
        placement: of the character.
        world_T_camera: Motor (N,), the cameras; fill and rim are set by where they look from.
        height_m: of the placed character.
        direction: (3,) the way the sunlight travels, world.

    Returns:
        The light, with shadows cast within a ball around the character.
    """
    up, viewer, left = viewer_frame(placement, world_T_camera)
    middle = placement.world_T_character.translation_m + 0.5 * height_m * up
    reach = 6.0 * height_m
    fill = middle + reach * (0.35 * up + 0.80 * viewer - 0.70 * left)
    rim = middle + reach * (0.55 * up - 0.75 * viewer - 0.25 * left)
    return Lighting(
        ambient=(0.30, 0.31, 0.33),
        sun=Sun(_row(direction), 3.1, WARM),
        lamps=(Lamp(_row(fill), 0.95 * reach**2, COOL), Lamp(_row(rim), 1.10 * reach**2)),
        shadow_center_m=_row(middle),
        shadow_radius_m=0.75 * height_m,
    )


def certainty(estimate: LightEstimate) -> float:
    """How much of an estimate's direction is to be believed, 0 to 1, by its contrast."""
    least, most = TELLING
    return float(np.clip((estimate.contrast - least) / (most - least), 0.0, 1.0))


def estimated_lighting(
    placement: Placement,
    height_m: float,
    estimate: LightEstimate,
    assumed: FloatArray | None = None,
    least_elevation_rad: float = 0.3,
) -> Lighting:
    """Sun and ambient light as they were found in the images.

    Args:
        placement: of the character.
        height_m: of the placed character.
        estimate: the light in the placement's world.
        assumed: (3,) the way light would travel if nothing told it; it takes the part that
            `certainty` leaves. Without it the estimate's direction is taken as it is.
        least_elevation_rad: a sun nearer to the ground, or below it, is raised to this height,
            since it throws the shadow.
    """
    up = placement.up
    towards = estimate.towards_light
    if assumed is not None:
        sure = certainty(estimate)
        towards = sure * towards - (1.0 - sure) * assumed
        towards /= max(float(np.linalg.norm(towards)), 1e-9)
    height = float(np.dot(towards, up))
    if height < np.sin(least_elevation_rad):
        level = towards - height * up
        level /= max(float(np.linalg.norm(level)), 1e-9)
        towards = np.cos(least_elevation_rad) * level + np.sin(least_elevation_rad) * up
        towards /= np.linalg.norm(towards)
    contrast = float(np.clip(CONTRAST_LOST * estimate.contrast, *CONTRASTS))
    sun, ambient = estimate.sun_and_ambient(contrast)
    middle = placement.world_T_character.translation_m + 0.5 * height_m * up
    return Lighting(
        ambient=_row(ambient * estimate.color),
        sun=Sun(_row(-towards), float(np.pi * sun), _row(estimate.color)),
        lamps=(),
        shadow_center_m=_row(middle),
        shadow_radius_m=0.75 * height_m,
    )


def sun_share(lighting: Lighting, point_m: FloatArray, normal: FloatArray) -> float:
    """Share of the light on a surface that comes from the sun: what a full shadow takes away.

    Args:
        lighting: the light of the scene.
        point_m: (3,) on the surface, world.
        normal: (3,) unit, world.

    Returns:
        0 to 1, of linear light; intensities are in pyrender's units, where a sun of π gives 1.

    >>> import numpy as np
    >>> from motorcade.render import Lighting, Sun
    >>> from motorcade.render.light import sun_share
    >>> noon = Lighting((0.5, 0.5, 0.5), Sun((0, 0, -1.0), np.pi), (), (0, 0, 0), 1.0)
    >>> round(sun_share(noon, np.zeros(3), np.array([0, 0, 1.0])), 3)
    0.667
    """
    direct, other = (float(np.mean(part)) for part in light_on(lighting, point_m, normal))
    return direct / (direct + other) if direct > 0.0 else 0.0


def light_on(
    lighting: Lighting, point_m: FloatArray, normal: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Light that the sun sends to a surface where nothing hides it, and all other: (3,) each.

    Args:
        lighting: the light of the scene.
        point_m: (3,) on the surface, world.
        normal: (3,) unit, world.
    """
    sun = np.array(lighting.sun.direction)
    facing = max(0.0, -float(np.dot(sun, normal)) / float(np.linalg.norm(sun)))
    direct = facing * lighting.sun.intensity / np.pi * np.array(lighting.sun.color)
    other = np.array(lighting.ambient)
    if lighting.surroundings:
        falling = irradiance_factors(2) / np.pi * harmonics(normal, 2)
        other = other + np.maximum(falling @ np.array(lighting.surroundings), 0.0)
    for lamp in lighting.lamps:
        step = np.array(lamp.position_m) - point_m
        distance = float(np.linalg.norm(step))
        cosine = max(0.0, float(np.dot(step, normal)) / distance)
        other = other + cosine * lamp.intensity / (np.pi * distance**2) * np.array(lamp.color)
    return direct, other


def _row(vector: FloatArray) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])


GROUND = 0.18
"""Share of light that the ground gives back: what photographers take for the mean of scenes."""


def above_ground(lighting: Lighting, place_m: FloatArray, up: FloatArray) -> Lighting:
    """The same light over a grey ground: what came evenly from all sides comes from above only.

    From below comes what the ground gives back of all light that falls on it, as band 0 and 1 of
    the two halves; what faces up is lit as before. Light that has surroundings keeps them.

    Args:
        lighting: the light of the scene.
        place_m: (3,) on the ground, world.
        up: (3,) unit, away from the ground.

    >>> import numpy as np
    >>> from motorcade.render import Lighting, Sun
    >>> from motorcade.render.light.lamps import above_ground, light_on
    >>> noon = Lighting((0.5, 0.5, 0.5), Sun((0, 0, -1.0), np.pi), (), (0, 0, 0), 1.0)
    >>> made = above_ground(noon, np.zeros(3), np.array([0, 0, 1.0]))
    >>> [light_on(made, np.zeros(3), np.array([0, 0, z]))[1][0].round(3) for z in (1.0, -1.0)]
    [np.float64(0.5), np.float64(0.27)]
    """
    if lighting.surroundings:
        return lighting
    sky = np.array(lighting.ambient)
    ground = GROUND * np.add(*light_on(lighting, place_m, up))
    x, y, z = up
    # A half of the sphere more than the other is sqrt(3 pi) of the function of band 1 along it.
    along = np.array([0.0, y, z, x, 0.0, 0.0, 0.0, 0.0, 0.0])[:, None]
    coefficients = np.sqrt(3.0 * np.pi) * along * 0.5 * (sky - ground)
    coefficients[0] = np.sqrt(4.0 * np.pi) * 0.5 * (sky + ground)
    rows = tuple((float(r), float(g), float(b)) for r, g, b in coefficients)
    return replace(lighting, ambient=(0.0, 0.0, 0.0), surroundings=rows)
