"""Light from all around a figure: the sky above, and below the ground, which gives light back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.render.light.lamps import light_on
from motorcade.render.scene import Lighting

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
    >>> from motorcade.render.light import above_ground, light_on
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
