"""Steps from 0 to 1 without a jump in velocity: how blends, swings and seams begin and end."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

FADE_S = 0.3
"""How long a clip or a pose takes to come in over another, or to go."""


def smoothstep(x: FloatArray) -> FloatArray:
    """``3 x² - 2 x³`` of x (*), 0 below 0 and 1 above 1: no velocity at its ends.

    >>> import numpy as np
    >>> from motorcade.animation.easing import smoothstep
    >>> smoothstep(np.array([-1.0, 0.25, 0.5, 2.0]))
    array([0.     , 0.15625, 0.5    , 1.     ])
    """
    u = np.clip(x, 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))


def smootherstep(x: FloatArray) -> FloatArray:
    """The quintic of x (*) between 0 and 1 that has neither velocity nor acceleration at its ends.

    Source: K. Perlin, "Improving noise" (2002).
    """
    u = np.clip(x, 0.0, 1.0)
    return np.asarray(u * u * u * (10.0 + u * (6.0 * u - 15.0)))
