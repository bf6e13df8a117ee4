"""How stored images become upright ones, and what that does to the camera that took them.

A phone stores what its sensor reads and notes beside it how the image is to be shown: mirrored or
not, and turned by quarter turns. Turning an image turns its camera's axes about the optical axis;
no pixel is resampled, so the turned camera is exact.

With x' = -y, y' = x for a quarter turn clockwise, Brown's tangential terms (p1, p2) become
(p2, -p1); radial terms stay. Pixel (u, v) of w x h becomes (h - 1 - v, u).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor
from motorcade.tracking.cameras.camera import Camera

Pixels = TypeVar("Pixels", bound=np.generic)
_QUARTER_TURN = np.array([[0, -1], [1, 0]])


@dataclass(frozen=True)
class ImageOrientation:
    """How a stored image is shown: mirrored left to right or not, then turned clockwise.

    Fields:
        quarter_turns: 0 to 3, clockwise.
        mirrored: before that.

    Raises:
        ValueError: another number of quarter turns.

    >>> import numpy as np
    >>> from motorcade.tracking.cameras.orientation import ImageOrientation
    >>> ImageOrientation(1).upright(np.array([[1, 2, 3], [4, 5, 6]]))
    array([[4, 1],
           [5, 2],
           [6, 3]])
    """

    quarter_turns: int = 0
    mirrored: bool = False

    def __post_init__(self) -> None:
        if self.quarter_turns not in range(4):
            raise ValueError(f"quarter_turns: expected 0 to 3, got {self.quarter_turns!r}")

    @property
    def degrees(self) -> int:
        """Clockwise: 0, 90, 180 or 270."""
        return 90 * self.quarter_turns

    @property
    def matrix(self) -> NDArray[np.int64]:
        """(2, 2) from stored directions (right, down) to shown ones."""
        turn = np.linalg.matrix_power(_QUARTER_TURN, self.quarter_turns)
        return np.asarray(turn @ np.diag([-1 if self.mirrored else 1, 1]), np.int64)

    def size(self, stored: tuple[int, int]) -> tuple[int, int]:
        """Width and height as shown."""
        return (stored[1], stored[0]) if self.quarter_turns % 2 else stored

    def upright(self, image: NDArray[Pixels]) -> NDArray[Pixels]:
        """A stored image ``(height, width, ...)`` as it is shown; the image itself where it is
        stored so.
        """
        if self == AS_STORED:
            return image
        seen = image[:, ::-1] if self.mirrored else image
        return np.ascontiguousarray(np.rot90(seen, -self.quarter_turns))


AS_STORED = ImageOrientation()


def turned_camera(camera: Camera, quarter_turns: int) -> Camera:
    """The camera of images turned clockwise; any whole number of quarter turns.

    What `camera` has at a pixel, this one has where that pixel goes, along axes that are turned
    with the image (`camera_T_turned`).

    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.cameras.orientation import turned_camera
    >>> turned_camera(Camera(640, 480, 500.0, 505.0, 310.0, 240.0), 1)
    Camera(width=480, height=640, fx=505.0, fy=500.0, cx=239.0, cy=310.0, model='pinhole', \
distortion=())
    """
    for _ in range(quarter_turns % 4):
        distortion = camera.distortion
        if camera.model == "radtan" and len(distortion) > 2:
            k1, k2, p1, p2, *others = distortion
            distortion = (k1, k2, p2, -p1, *others)
        camera = Camera(
            camera.height,
            camera.width,
            camera.fy,
            camera.fx,
            camera.height - 1 - camera.cy,
            camera.cx,
            camera.model,
            distortion,
        )
    return camera


def camera_T_turned(quarter_turns: int) -> Motor:
    """From the axes of `turned_camera` to those of the camera before it was turned.

    >>> from motorcade.tracking.cameras.orientation import camera_T_turned
    >>> camera_T_turned(1).apply([0.0, 1.0, 0.0]).round(9)  # down as shown is right as stored
    array([1., 0., 0.])
    """
    angle_rad = -0.5 * math.pi * (quarter_turns % 4)
    turn = Rotor.from_rotation_vector([0.0, 0.0, angle_rad])
    return Motor.from_rotor_translation(turn, [0.0, 0.0, 0.0])
