"""Normal equations of poses that meet few others: eliminated where that is cheap, else factorised.

Poses of frames mostly meet poses that stay (cameras, markers) and never each other. Then they are
eliminated one by one, and a small dense system is left; SuperLU, which knows nothing of blocks,
takes many times as long. Where odometry or a loop joins them, the sparse matrix is factorised.

Source: Triggs et al. 2000 (Bundle Adjustment: A Modern Synthesis), sections 6.1 to 6.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.optimise import BlockEquations

_FLOOR = 1e-6
_MOST_KEPT = 300
"""Poses of which a dense matrix of 6 rows each is still solved in half a second."""


@dataclass(frozen=True, eq=False)
class SparseEquations:
    """``J^T J step = -J^T r`` of poses with w numbers each.

    Fields:
        rows, columns: ``(m,)`` which poses meet; each pair stands once, and mirrored.
        blocks: ``(m, w, w)``.
        gradient: ``(P, w)``.

    >>> import numpy as np
    >>> from motorcade.tracking.sparse import SparseEquations
    >>> both, eye = np.arange(2), np.tile(np.eye(6), (2, 1, 1))
    >>> SparseEquations(both, both, eye, np.ones((2, 6))).step(damping=0.0)[0].round(3)
    array([-1., -1., -1., -1., -1., -1.])
    """

    rows: IntArray
    columns: IntArray
    blocks: FloatArray
    gradient: FloatArray

    def step(self, damping: float) -> FloatArray:
        """Damped Gauss-Newton step ``(P, w)``.

        Raises:
            LinAlgError: the damped matrix is singular.
        """
        solved = self._factorised(damping).solve(-self.gradient.ravel())
        if not np.isfinite(solved).all():
            raise np.linalg.LinAlgError("singular")
        return np.asarray(solved, np.float64).reshape(self.gradient.shape)

    def _factorised(self, damping: float) -> Any:
        from scipy.sparse import bsr_matrix, diags
        from scipy.sparse.linalg import splu

        count, width = self.gradient.shape
        order = np.lexsort((self.columns, self.rows))
        starts = np.searchsorted(self.rows[order], np.arange(count + 1))
        matrix = bsr_matrix(
            (self.blocks[order], self.columns[order], starts), shape=(width * count, width * count)
        ).tocsc()
        matrix = matrix + diags(damping * matrix.diagonal() + _FLOOR, format="csc")
        try:
            return splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as singular:
            raise np.linalg.LinAlgError(str(singular)) from singular


@dataclass(frozen=True, eq=False)
class PassingEquations(SparseEquations):
    """The same, where some poses pass: each belongs to one frame.

    Fields:
        passing: ``(P,)`` which they are.
    """

    passing: NDArray[np.bool_]

    def step(self, damping: float) -> FloatArray:
        """Damped Gauss-Newton step ``(P, w)``.

        Raises:
            LinAlgError: the damped matrix is singular.
        """
        a, b = self.passing[self.rows], self.passing[self.columns]
        if (
            np.count_nonzero(~self.passing) > _MOST_KEPT
            or (a & b & (self.rows != self.columns)).any()
        ):
            return super().step(damping)
        found = np.empty_like(self.gradient)
        found[~self.passing], found[self.passing] = self._apart(a, b).step(damping)
        if not np.isfinite(found).all():
            raise np.linalg.LinAlgError("singular")
        return found

    def _apart(self, a: NDArray[np.bool_], b: NDArray[np.bool_]) -> BlockEquations:
        """Those that stay as groups, those that pass as blocks."""
        count, width = self.gradient.shape
        slot = np.where(self.passing, np.cumsum(self.passing), np.cumsum(~self.passing)) - 1
        stay, passing = ~self.passing, self.passing
        size = int(np.count_nonzero(stay))
        floor = _FLOOR * np.eye(width)
        information = np.zeros((size, width, size, width))
        both = ~a & ~b
        information[slot[self.rows[both]], :, slot[self.columns[both]]] = self.blocks[both]
        every = np.arange(size)
        information[every, :, every] += floor
        blocks = np.tile(floor, (count - size, 1, 1))
        own = a & b
        blocks[slot[self.rows[own]]] += self.blocks[own]
        across = a & ~b
        return BlockEquations(
            information.reshape(size * width, size * width),
            self.gradient[stay].ravel(),
            blocks,
            self.gradient[passing],
            slot[self.rows[across]],
            slot[self.columns[across]],
            self.blocks[across],
        )
