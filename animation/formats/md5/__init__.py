"""MD5, the format of Doom 3 and its kin, version 10: `.md5mesh`, and motions in `.md5anim`.

A mesh has joints in world poses, and vertices as weighted points in the joints' frames. A motion
has a base pose, and of every frame the numbers that differ from it. Figures have z up; the unit is
not stated. Faces run clockwise seen from outside. Source: id Software's file layout, as described
by David Henry, MD5Mesh and MD5Anim (2005).
"""

from motorcade.animation.formats.md5.mesh import read_md5_mesh
from motorcade.animation.formats.md5.motion import read_md5_motion

__all__ = ["read_md5_mesh", "read_md5_motion"]
