"""Gravity on Earth: its size, what is known of that, and the turn that makes it point down."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

STANDARD_GRAVITY_M_S2 = 9.81
GRAVITY_SIGMA_M_S2 = 0.02
"""At sea level it is 9.780 at the equator and 9.832 at the poles (WGS 84), a deviation of 0.015 for
a place anywhere between them; a kilometre of height takes 0.003 off, three of them 0.01."""
GRAVITY_SHARE = 0.07
"""An accelerometer's scale and the shape of the earth leave readings within this share of it."""


def upright(down: FloatArray) -> Rotor:
    """The shortest turn that takes a direction ``(3,)``, as of gravity, to -z.

    From straight up all are as short: it is the one about x.
    """
    down = down / np.linalg.norm(down)
    axis = np.cross(down, [0.0, 0.0, -1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(-down[2])
    if sine < 1e-12:
        return Rotor.from_rotation_vector([np.pi if cosine < 0.0 else 0.0, 0.0, 0.0])
    return Rotor.from_rotation_vector(np.arctan2(sine, cosine) / sine * axis)
