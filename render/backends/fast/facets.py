"""How much light rough surfaces mirror under even light, as a table for shaders.

For facets spread as GGX says and hidden from each other as Smith says, the share of even light that
is mirrored to the eye is `F0 scale + offset` for a mirror of F0 at normal incidence with Schlick's
Fresnel (Karis, "Real Shading in Unreal Engine 4", 2013).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

SIZE = 32
SAMPLES = 256
"""Facets that are looked at for each entry; the table is then good to a hundredth."""


@cache
def mirrored_table() -> NDArray[np.float32]:
    """Scale and offset (SIZE, SIZE, 2): rows by the cosine of the view, columns by roughness.

    Entries stand for the middles of their cells, as OpenGL reads textures.
    """
    cells = (np.arange(SIZE) + 0.5) / SIZE
    nv, rough = cells[:, None, None], cells[None, :, None]
    number = np.arange(SAMPLES)
    share, turn = (number + 0.5) / SAMPLES, 2.0 * np.pi * _reversed_bits(number)
    a2 = rough**4
    cosine = np.sqrt((1.0 - share) / (1.0 + (a2 - 1.0) * share))
    sine = np.sqrt(1.0 - cosine**2)
    vh = np.maximum(np.sqrt(1.0 - nv**2) * sine * np.cos(turn) + nv * cosine, 0.0)
    nl = 2.0 * vh * cosine - nv
    lit = nl > 0.0
    nl = np.where(lit, nl, 1.0)
    hidden = nl * np.sqrt(a2 + (1.0 - a2) * nv**2) + nv * np.sqrt(a2 + (1.0 - a2) * nl**2)
    seen = np.where(lit, 2.0 * nl * vh / np.maximum(hidden * cosine, 1e-12), 0.0)
    fresnel = (1.0 - vh) ** 5
    table = np.stack([((1.0 - fresnel) * seen).mean(-1), (fresnel * seen).mean(-1)], axis=-1)
    return np.ascontiguousarray(table, dtype=np.float32)


def _reversed_bits(number: NDArray[np.int64]) -> NDArray[np.float64]:
    """Van der Corput's sequence in base 2, 0 to 1."""
    made = np.zeros(len(number))
    for bit in range(16):
        made += ((number >> bit) & 1) * 2.0 ** -(bit + 1)
    return made
