"""What a file says about a character before it becomes one, and the way there.

Readers fill in a `Rig`: nodes with local transforms of any scale, surfaces, clips as functions
of time, axes and unit of the file. `assemble_character` turns it into a character in metres whose
joint frames are rigid.
"""

from motorcade.animation.formats.rig.assemble import (
    SkeletalMotion,
    assemble_character,
    assemble_motion,
)
from motorcade.animation.formats.rig.stance import Wanted
from motorcade.animation.formats.rig.values import (
    NodeTree,
    Rig,
    RigClip,
    RigSurface,
    Skin,
    Transforms,
    transforms_over,
)

__all__ = [
    "NodeTree",
    "Rig",
    "RigClip",
    "RigSurface",
    "SkeletalMotion",
    "Skin",
    "Transforms",
    "Wanted",
    "assemble_character",
    "assemble_motion",
    "transforms_over",
]
