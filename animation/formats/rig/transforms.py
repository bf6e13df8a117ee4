"""Local transforms as files give them: a turn, a translation and a scale, or any matrix.

A transform is kept as a similarity (quaternion wxyz, translation, one signed scale) wherever it
is one. A negative scale is a point reflection, which exporters use for mirrored limbs. Where
matrices have shear or different scales an axis, the whole batch also keeps its 3x3 blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.animation.formats.limits import FormatError
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

# How far from one uniform scale the axes may be, as a share of it, before a block counts as
# sheared. Files with six printed digits, and matrices split into float32 parts, stay below.
UNIFORM_TOLERANCE = 1e-4
# Scales below this stand for hidden parts; a similarity needs more than nothing.
LEAST_SCALE = 1e-4


@dataclass(frozen=True, eq=False)
class Transforms:
    """Similarities `parent_T_node` of batch shape (*).

    Args:
        wxyz: (*, 4) unit quaternions.
        translation: (*, 3) in the file's unit.
        scale: (*) not zero; negative with a point reflection.
        blocks: (*, 3, 3) the true blocks where some are no multiple of a rotation, else None.

    >>> import numpy as np
    >>> from motorcade.animation.formats.rig import Transforms
    >>> wxyz, translation = np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 100.0, 0.0])
    >>> parent_T_node = Transforms.from_parts(wxyz, translation, scales=np.array([2.0, 2.0, 2.0]))
    >>> parent_T_node.as_matrices()[:3]
    array([[  2.,   0.,   0.,   0.],
           [  0.,   2.,   0., 100.],
           [  0.,   0.,   2.,   0.]])
    """

    wxyz: FloatArray
    translation: FloatArray
    scale: FloatArray
    blocks: FloatArray | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        return self.scale.shape

    @staticmethod
    def from_parts(wxyz: FloatArray, translation: FloatArray, scales: FloatArray) -> Transforms:
        """From quaternions (*, 4) of any length, translations (*, 3), scales an axis (*, 3).

        Raises:
            FormatError: NaN or infinity, or a quaternion of length zero.
        """
        for name, values in (("rotation", wxyz), ("translation", translation), ("scale", scales)):
            if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > 1e9:
                raise FormatError(f"{name}: expected finite numbers up to 1e9, got others")
        length = np.sqrt(np.einsum("...i,...i->...", wxyz, wxyz))
        if not np.all(length > 1e-6):
            raise FormatError("rotation: expected quaternions, got one of length zero")
        unit = wxyz / length[..., None]
        low, high = scales.min(axis=-1, initial=np.inf), scales.max(axis=-1, initial=-np.inf)
        scale = 0.5 * (low + high)
        if np.all(high - low <= UNIFORM_TOLERANCE * np.abs(scale)):
            return Transforms(unit, translation, _not_zero(scale))
        blocks = Rotor.from_quaternion(unit).as_matrix() * _not_zero(scales)[..., None, :]
        return _split(blocks, translation)

    @staticmethod
    def from_matrices(matrices: FloatArray) -> Transforms:
        """From matrices (*, 4, 4) that act on columns; their last row is not looked at.

        Raises:
            FormatError: NaN or infinity.
        """
        used = matrices[..., :3, :]
        if not np.isfinite(used).all() or np.abs(used).max(initial=0.0) > 1e9:
            raise FormatError("matrix: expected finite numbers up to 1e9, got others")
        return _split(used[..., :3], used[..., 3])

    def as_matrices(self) -> FloatArray:
        """Matrices (*, 4, 4) that act on columns."""
        matrices = np.zeros((*self.shape, 4, 4))
        matrices[..., :3, :3] = self.as_blocks()
        matrices[..., :3, 3] = self.translation
        matrices[..., 3, 3] = 1.0
        return matrices

    def as_blocks(self) -> FloatArray:
        """Blocks (*, 3, 3) of turn and scale."""
        if self.blocks is not None:
            return self.blocks
        turn: FloatArray = Rotor.from_quaternion(self.wxyz).as_matrix()
        return turn * self.scale[..., None, None]

    def rigid(self) -> Motor:
        """The turns and translations alone."""
        return Motor.from_quaternion_translation(self.wxyz, self.translation)

    def __getitem__(self, index: Any) -> Transforms:
        """Index the batch."""
        blocks = None if self.blocks is None else self.blocks[index]
        return Transforms(
            self.wxyz[index],
            self.translation[index],
            self.scale[index],
            blocks,
        )

    @staticmethod
    def concatenate(parts: list[Transforms]) -> Transforms:
        """Join batches along their first dimension."""
        blocks = None
        if any(part.blocks is not None for part in parts):
            blocks = np.concatenate([part.as_blocks() for part in parts])
        return Transforms(
            np.concatenate([part.wxyz for part in parts]),
            np.concatenate([part.translation for part in parts]),
            np.concatenate([part.scale for part in parts]),
            blocks,
        )


def scaled_matrices(motors: Motor, scale: FloatArray) -> FloatArray:
    """Matrices (*, 4, 4) that first scale by numbers (*), then move by motors (*)."""
    matrices: FloatArray = motors.as_matrix()
    matrices[..., :3, :3] *= scale[..., None, None]
    return matrices


def _not_zero(scale: FloatArray) -> FloatArray:
    """Scales of at least LEAST_SCALE in size, with their sign."""
    least = np.where(scale < 0.0, -LEAST_SCALE, LEAST_SCALE)
    return np.where(np.abs(scale) < LEAST_SCALE, least, scale)


def _split(blocks: FloatArray, translation: FloatArray) -> Transforms:
    """The nearest similarities, with the blocks where they are not near enough."""
    gram = np.einsum("...ki,...kj->...ij", blocks, blocks)
    square = np.trace(gram, axis1=-2, axis2=-1) / 3.0
    off = np.abs(gram - square[..., None, None] * np.eye(3)).max(axis=(-2, -1), initial=0.0)
    even = off <= 2.0 * UNIFORM_TOLERANCE * square
    sign = np.where(np.linalg.det(blocks) < 0.0, -1.0, 1.0)
    if np.all(even) and np.all(square > LEAST_SCALE**2):
        scale = sign * np.sqrt(square)
        turn = blocks / scale[..., None, None]
        # One step of Newton towards the nearest rotation: what is left is of second order.
        turn = 1.5 * turn - 0.5 * turn @ np.swapaxes(turn, -1, -2) @ turn
        return Transforms(Rotor.from_matrix(turn).as_quaternion(), translation, scale)
    u, singular, vt = np.linalg.svd(blocks * sign[..., None, None])
    turn = u @ vt
    turn *= np.where(np.linalg.det(turn) < 0.0, -1.0, 1.0)[..., None, None]
    scale = _not_zero(sign * singular.mean(axis=-1))
    return Transforms(Rotor.from_matrix(turn).as_quaternion(), translation, scale, blocks)
