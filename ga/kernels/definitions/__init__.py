"""The library's kernels, each defined once over multivectors; all compiled code is written from it.

After an edit, ``python -m motorcade.ga.codegen`` writes the C and NumPy kernels again. That needs
CasADi and mpmath; using the kernels does not.
"""

from __future__ import annotations

from motorcade.ga.kernels.definitions import (
    blends,
    chains,
    conversions,
    motors,
    rotors,
    similarities,
    similarity_conversions,
    similarity_tangents,
    skinning,
    tangents,
)

__all__ = ["KERNELS"]

KERNELS = (
    *motors.KERNELS, *conversions.KERNELS, *blends.KERNELS, *rotors.KERNELS,
    *similarities.KERNELS, *similarity_conversions.KERNELS, *skinning.KERNELS, *chains.KERNELS,
    *tangents.KERNELS, *similarity_tangents.KERNELS,
)  # fmt: skip
