"""Animation room: characters read, blended, posed, skinned and placed, on top of `ga` alone.

Characters are in metres, z up, facing +x, soles at z = 0; poses of joints are local,
`parent_T_joint`, with joints in the last batch dimension. Nothing heavy comes with this import:
the mannequin's surface (scikit-image) and image files of textures bring theirs when they are used.
"""

from motorcade.animation.blend import (
    BlendSpace,
    CrossFade,
    Inertialized,
    PoseLayer,
    blend_clips,
    blend_layers,
    blend_poses,
)
from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.formats import read_character, read_motion, write_gltf
from motorcade.animation.ik import (
    Chain,
    Leg,
    aim,
    bend_limb,
    fitted_legs,
    plant_feet,
    reach_with,
)
from motorcade.animation.mannequin import mannequin
from motorcade.animation.place import (
    Anchor,
    GroundPath,
    Placement,
    on_the_spot,
    place_on_plane,
    plane_anchor,
    walk_along,
)
from motorcade.animation.retarget import legs_of, retarget
from motorcade.animation.runtime import PoseRuntime
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.skin import PoseField, Skinner, skin

__all__ = [
    "Anchor",
    "BlendSpace",
    "Chain",
    "Character",
    "Clip",
    "CrossFade",
    "GroundPath",
    "Inertialized",
    "Leg",
    "Placement",
    "PoseField",
    "PoseLayer",
    "PoseRuntime",
    "Skeleton",
    "Skinner",
    "aim",
    "bend_limb",
    "blend_clips",
    "blend_layers",
    "blend_poses",
    "fitted_legs",
    "legs_of",
    "mannequin",
    "on_the_spot",
    "place_on_plane",
    "plane_anchor",
    "plant_feet",
    "reach_with",
    "read_character",
    "read_motion",
    "retarget",
    "skin",
    "walk_along",
    "write_gltf",
]
