"""Characters: read, blended, posed by inverse kinematics, retargeted, skinned and placed.

Frames: ``character_T_joint`` maps a joint's coordinates to character space, which has z up, faces
+x and has its soles at z = 0; ``parent_T_joint`` are local poses, with joints in the last batch
dimension ``(*, J)``. Clips hold local poses, blends make them and skins take them; `Skeleton.world`
chains them. A `Placement` stands a character in the world: ``world_T_character`` after a scale.

Units: metres, radians, seconds. Colours are sRGB from 0 to 1.

A leg of two bones, bent until its ankle is 0.8 m below its hip:

>>> import numpy as np
>>> from motorcade.animation import Skeleton, bend_limb
>>> from motorcade.ga import Motor
>>> parent_T_joint = Motor.from_translation([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]])
>>> leg = Skeleton(("hip", "knee", "ankle"), np.array([-1, 0, 1]), parent_T_joint)
>>> pose = bend_limb(leg, leg.rest, leg.names, [0, 0, 0.2], pole_m=[1.0, 0, 0.6])
>>> character_T_joint = leg.world(pose)
>>> character_T_joint.translation_m.round(3) + 0.0  # the knee goes ahead
array([[0. , 0. , 1. ],
       [0.3, 0. , 0.6],
       [0. , 0. , 0.2]])

`mannequin` is a whole figure with clips, `read_character` reads one from a file. What is here is
used most; the packages below hold the rest. Nothing heavy comes with this import: textures bring
Pillow when they are read.
"""

from motorcade.animation.blend import BlendSpace, blend_poses
from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.formats import read_character, write_gltf
from motorcade.animation.ik import Chain, bend_limb, reach_with
from motorcade.animation.mannequin import mannequin
from motorcade.animation.place import GroundPath, Placement, place_on_plane, walk_along
from motorcade.animation.retarget import legs_of
from motorcade.animation.retarget.transfer import retarget
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.skin import skin

__all__ = [
    "BlendSpace",
    "Chain",
    "Character",
    "Clip",
    "GroundPath",
    "Placement",
    "Skeleton",
    "bend_limb",
    "blend_poses",
    "legs_of",
    "mannequin",
    "place_on_plane",
    "reach_with",
    "read_character",
    "retarget",
    "skin",
    "walk_along",
    "write_gltf",
]
