"""Animation room: skeletons, clips, characters, skinning and placement, on top of `ga` alone.

Characters are in metres, z up, facing +x, soles at z = 0; poses of joints are local,
`parent_T_joint`, with joints in the last batch dimension.
"""

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.mannequin import mannequin
from motorcade.animation.place import Placement, place_on_plane
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.skin import skin

__all__ = ["Character", "Clip", "Placement", "Skeleton", "mannequin", "place_on_plane", "skin"]
