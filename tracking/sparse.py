"""Normal equations of poses that meet few others: eliminated where that is cheap, else factorised.

Poses of a frame mostly meet poses that stay (cameras, markers) and none of another frame. Then they
are eliminated frame by frame, and a small dense system is left; SuperLU, which knows nothing of
blocks, takes many times as long. Where odometry or a loop joins them, the sparse matrix is
factorised.

Source: Triggs et al. 2000 (Bundle Adjustment: A Modern Synthesis), sections 6.1 to 6.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.optimise import BlockEquations, PairIndex

_FLOOR = 1e-6
_MOST_KEPT = 300
"""Poses of which a dense matrix of 6 rows each is still solved in half a second."""
_MOST_IN_A_FRAME = 8
"""Poses of a frame: its block is inverted at the cube of their number."""


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
        frame: ``(P,)`` which one; -1 for a pose that stays.
    """

    frame: IntArray

    def step(self, damping: float) -> FloatArray:
        """Damped Gauss-Newton step ``(P, w)``.

        Raises:
            LinAlgError: the damped matrix is singular.
        """
        if not self._eliminates:
            return super().step(damping)
        kept, blocks = self._apart.step(damping)
        passing, width = self.frame >= 0, self.gradient.shape[1]
        step = np.empty_like(self.gradient)
        step[~passing] = kept
        in_block = blocks.reshape(len(blocks), -1, width)
        step[passing] = in_block[self.frame[passing], self._place[passing]]
        if not np.isfinite(step).all():
            raise np.linalg.LinAlgError("singular")
        return step

    def covariance(self, doubt: FloatArray) -> FloatArray:
        """``(P, w, w)`` of each pose; those that stay and those of other frames as they stand.

        Args:
            doubt: ``(w,)`` deviations of a pose of which nothing is known.
        """
        count, width = self.gradient.shape
        own = self.rows == self.columns
        information = np.tile(np.diag(doubt**-2.0), (count, 1, 1))
        information[self.rows[own]] += self.blocks[own]
        covariance = np.linalg.inv(information)
        alone = np.bincount(self.frame[self.frame >= 0], minlength=1) < 2
        together = np.flatnonzero((self.frame >= 0) & ~alone[self.frame])
        if len(together):
            size = int(self._place.max()) + 1
            blocks = self._blocks(np.diag(doubt**-2.0)).reshape(-1, size * width, size * width)
            inverse = np.linalg.inv(blocks).reshape(-1, size, width, size, width)
            place = self._place[together]
            covariance[together] = inverse[self.frame[together], place, :, place]
        return np.asarray(0.5 * (covariance + covariance.swapaxes(-1, -2)), np.float64)

    @cached_property
    def _eliminates(self) -> bool:
        """Whether no frame meets another one, and what is left is small."""
        a, b = self.frame[self.rows], self.frame[self.columns]
        met = bool(((a >= 0) & (b >= 0) & (a != b)).any())
        few = bool(np.count_nonzero(self.frame < 0) <= _MOST_KEPT)
        return not met and few and int(self._place.max(initial=0)) < _MOST_IN_A_FRAME

    @cached_property
    def _place(self) -> IntArray:
        """Which of its frame's poses each one is."""
        order = np.argsort(self.frame, kind="stable")
        frame = self.frame[order]
        place = np.empty(len(frame), np.int64)
        place[order] = np.arange(len(frame)) - np.searchsorted(frame, frame)
        return np.where(self.frame >= 0, place, 0)

    def _blocks(self, least: FloatArray) -> FloatArray:
        """``(F, s, w, s, w)`` information of each frame's poses, with what there is at least."""
        width, size = self.gradient.shape[1], int(self._place.max(initial=0)) + 1
        blocks = np.zeros((int(self.frame.max(initial=-1)) + 1, size, width, size, width))
        every = np.arange(size)
        blocks[:, every, :, every] += least
        a, b = self.frame[self.rows], self.frame[self.columns]
        same = (a >= 0) & (a == b)
        rows, columns = self._place[self.rows[same]], self._place[self.columns[same]]
        blocks[a[same], rows, :, columns] += self.blocks[same]
        return blocks

    @cached_property
    def _apart(self) -> BlockEquations:
        """Those that stay as groups, those of a frame as a block."""
        width = self.gradient.shape[1]
        floor = _FLOOR * np.eye(width)
        stay = self.frame < 0
        slot, size = np.cumsum(stay) - 1, int(np.count_nonzero(stay))
        information = np.zeros((size, width, size, width))
        both = stay[self.rows] & stay[self.columns]
        information[slot[self.rows[both]], :, slot[self.columns[both]]] = self.blocks[both]
        every = np.arange(size)
        information[every, :, every] += floor
        blocks = self._blocks(floor)
        frames, most = blocks.shape[:2]
        gradient = np.zeros((frames, most, width))
        gradient[self.frame[~stay], self._place[~stay]] = self.gradient[~stay]
        across = ~stay[self.rows] & stay[self.columns]
        rows = self.rows[across]
        index = PairIndex(self.frame[rows], slot[self.columns[across]])
        coupling = np.zeros((len(index.rows), most, width, width))
        coupling[index.pair_of, self._place[rows]] = self.blocks[across]
        return BlockEquations(
            information.reshape(size * width, size * width),
            self.gradient[stay].ravel(),
            blocks.reshape(frames, most * width, most * width),
            gradient.reshape(frames, most * width),
            index.rows,
            index.columns,
            coupling.reshape(len(coupling), most * width, width),
        )
