"""Skinning one pose after another in single precision: the compiled path, for real time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.native._runtime import Mesh, Skinning
from motorcade.animation.skin.palette import SkinMethod, checked_method, palette
from motorcade.ga import Motor, Similarity, kernels

__all__ = ["Skinner"]

Floats32 = NDArray[np.float32]

_METHODS = {
    "linear": Skinning.matrix,
    "dual_quaternion": Skinning.dual_quaternion,
    "motor": Skinning.motor,
    "similarity": Skinning.similarity,
}


class Skinner:
    """A character's mesh prepared for skinning by one method.

    It does what `skin` does, in float32 (positions to about 1e-6 of the character's height) and
    without validation of what is fixed. Large meshes are shared among `kernels.threads()` threads.

    Args:
        character: mesh, skeleton and weights.
        method: one of `SKIN_METHODS`.

    Raises:
        ValueError: an unknown method, or more than 65536 joints.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton, Skinner
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

    >>> vertices, normals = Skinner(flag, "motor").skin(Motor.from_translation([[0, 0, 0.5]]))
    >>> vertices.dtype, vertices[2]
    (dtype('float32'), array([0. , 0. , 2.5], dtype=float32))
    """

    def __init__(self, character: Character, method: SkinMethod = "motor") -> None:
        self.method = checked_method(method)
        self._skeleton = character.skeleton
        if len(self._skeleton) > 65536:
            raise ValueError(f"Skinner: expected up to 65536 joints, got {len(self._skeleton)}")
        self._shape = character.vertices.shape
        joints, weights = character.influences
        self._mesh = Mesh(
            np.ascontiguousarray(character.vertices),
            np.ascontiguousarray(character.normals),
            np.ascontiguousarray(joints),
            np.ascontiguousarray(weights),
        )

    def skin(self, local_pose: Motor | Similarity) -> tuple[Floats32, Floats32]:
        """Vertices and unit normals ``(V, 3)`` of one pose ``(J,)``, metres.

        Raises:
            ValueError: another number of joints, or joints that grow under a rigid method: use
                ``linear`` or ``similarity`` for these.
        """
        entries, scale = palette(self._skeleton, local_pose, self.method)
        if scale is not None and np.ptp(scale) > 1e-6:
            raise ValueError(
                f"Skinner.skin(local_pose): expected rigid joints under '{self.method}', got "
                f"scales from {scale.min():.4g} to {scale.max():.4g}; use 'similarity' or 'linear'"
            )
        return self.skin_palette(np.ascontiguousarray(entries, dtype=np.float32))

    def skin_palette(self, entries: Floats32) -> tuple[Floats32, Floats32]:
        """The same from a palette ``(J, 8 or 12)`` as `palette` or `PoseRuntime` gives it.

        Raises:
            ValueError: another shape than the method's.
            TypeError: another type than float32 in C order.
        """
        positions, normals = np.empty(self._shape, np.float32), np.empty(self._shape, np.float32)
        self._mesh.skin(_METHODS[self.method], entries, positions, normals, kernels.threads())
        return positions, normals
