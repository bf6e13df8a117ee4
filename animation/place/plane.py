"""Stands a character upright on a plane of the world.

A plane is given by `world_T_plane`: its ground is z = 0 of that frame, z points up. A placement is
`world_T_character` after a uniform scale: a point x of the character (metres of its own size,
soles at z = 0) appears at `world_T_character.apply(scale * x)`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.character import Character
from motorcade.animation.vectors import UP, turn_z
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a character stands and how large it is.

    Args:
        world_T_character: rigid pose, batch shape ().
        scale: uniform scale, applied before the pose.

    Raises:
        ValueError: a batch of poses, or a scale that is not positive and finite.

    >>> from motorcade.animation import Placement
    >>> from motorcade.ga import Motor
    >>> half_size = Placement(Motor.from_translation([1.0, 0, 0]), scale=0.5)
    >>> half_size.apply([0.0, 0, 1.8])  # the crown of a character 1.8 m tall
    array([1. , 0. , 0.9])
    """

    world_T_character: Motor
    scale: float

    def __post_init__(self) -> None:
        if self.world_T_character.shape != ():
            raise ValueError(
                "Placement.world_T_character: expected one pose, got a batch of shape "
                f"{self.world_T_character.shape}"
            )
        if not (np.isfinite(self.scale) and self.scale > 0.0):
            raise ValueError(f"Placement.scale: expected a positive number, got {self.scale}")

    @property
    def up(self) -> FloatArray:
        """(3,) unit vector in the world: the normal of what the character stands on."""
        return self.world_T_character.rotor.apply(UP)

    def as_matrix(self) -> FloatArray:
        """(4, 4) from character space to the world, the scale in it."""
        return self.world_T_character.as_matrix() @ np.diag([*[self.scale] * 3, 1.0])

    def apply(self, points: ArrayLike) -> FloatArray:
        """Points (*, 3) from character space into the world, metres."""
        own = checked_floats(points, "Placement.apply(points)", (3,))
        return self.world_T_character.apply(self.scale * own)


def place_on_plane(
    character: Character,
    position_m: ArrayLike = (0.0, 0.0),
    heading_rad: float = 0.0,
    *,
    height_m: float,
    world_T_plane: Motor | None = None,
) -> Placement:
    """Stand a character on a plane, upright, at a chosen height.

    Args:
        character: whose height in the rest pose sets the scale.
        position_m: (2,) where it stands, x and y of the plane's frame, metres.
        heading_rad: where it looks: 0 along the plane's x, turning towards its y.
        height_m: height of the placed character.
        world_T_plane: pose of the plane, batch shape (); without it the world's own ground, z = 0.

    Returns:
        The placement, with the soles in the plane.

    Raises:
        ValueError: a position that is not two finite numbers, a heading that is not finite, a
            height that is not positive, or a batch of planes.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton, place_on_plane
    >>> from motorcade.ga import Motor
    >>> flag = Character(
    ...     Skeleton(("pole",), np.array([-1]), Motor.identity((1,))),
    ...     vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
    ...     normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
    ...     triangles=np.array([[0, 1, 2]]),
    ...     colors=np.full((3, 3), 0.5),
    ...     joints=np.zeros((3, 4), int),
    ...     weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    ... )

    >>> stands = place_on_plane(flag, (0.3, 0.1), heading_rad=np.pi / 2, height_m=1.0)
    >>> stands.scale, stands.apply([1.0, 0, 0]).round(3)  # its x points along the plane's y
    (0.5, array([0.3, 0.6, 0. ]))
    """
    position = checked_floats(position_m, "place_on_plane(position_m)", (2,))
    heading = checked_floats(heading_rad, "place_on_plane(heading_rad)", ())
    if position.shape != (2,) or heading.shape != ():
        raise ValueError(
            "place_on_plane: expected one position and one heading, got shapes "
            f"{position.shape} and {heading.shape}"
        )
    if not (np.isfinite(height_m) and height_m > 0.0):
        raise ValueError(f"place_on_plane(height_m): expected a positive height, got {height_m}")
    plane_T_character = Motor.from_rotor_translation(
        turn_z(heading),
        np.array([position[0], position[1], 0.0]),
    )
    plane = Motor.identity() if world_T_plane is None else world_T_plane
    return Placement(plane @ plane_T_character, float(height_m) / character.height_m)
