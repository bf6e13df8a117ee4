"""Collada 1.4 and 1.5 (`.dae`): skinned meshes, scenes, animations.

Source: Khronos Group, COLLADA Digital Asset Schema Release 1.4.1 and 1.5.0.
"""

from motorcade.animation.formats.collada.read import read_collada

__all__ = ["read_collada"]
