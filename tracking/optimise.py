"""Nonlinear least squares: one Levenberg-Marquardt loop, its linear solvers, the robust losses.

Sources: Levenberg 1944; Marquardt 1963; Madsen, Nielsen & Tingleff 2004; of the losses Huber 1964;
of eliminated blocks (Schur) Triggs et al. 2000, sections 6.1 and 6.2.

Poses of a frame mostly meet poses that stay (cameras, markers) and none of another frame. Then they
are eliminated frame by frame, and a small dense system is left; SuperLU, which knows nothing of
blocks, takes many times as long. Where odometry or a loop joins them, the sparse matrix is
factorised.

Source: Triggs et al. 2000 (Bundle Adjustment: A Modern Synthesis), sections 6.1 to 6.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.tracking.native._least_squares import eliminate, invert, substitute

__all__ = [
    "BlockEquations",
    "Evaluated",
    "Minimum",
    "NormalEquations",
    "PairIndex",
    "Stop",
    "huber",
    "huber_cauchy",
    "minimise",
    "pair_sums",
    "sum_by",
]


_FLOOR = 1e-9  # keeps parameters that nothing speaks of where they are


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """``J^T J step = -J^T r``.

    Args:
        information: ``(p, p)``, ``J^T J``.
        gradient: ``(p,)``, ``J^T r``.

    >>> import numpy as np
    >>> from motorcade.tracking.optimise import NormalEquations
    >>> equations = NormalEquations.of(np.array([[2.0, 0.0], [0.0, 1.0]]), np.array([4.0, -3.0]))
    >>> equations.step(damping=0.0).round(6)
    array([-2.,  3.])
    >>> equations.covariance(sigma=0.1)
    array([[0.0025, 0.    ],
           [0.    , 0.01  ]])
    """

    information: FloatArray
    gradient: FloatArray

    @classmethod
    def of(
        cls, jacobian: FloatArray, residuals: FloatArray, weight: FloatArray | None = None
    ) -> NormalEquations:
        """From the derivative ``(n, p)`` of residuals ``(n,)``, squares weighed by ``(n,)``."""
        weighed = jacobian if weight is None else jacobian * weight[:, None]
        return cls(weighed.T @ jacobian, weighed.T @ residuals)

    def step(self, damping: float) -> FloatArray:
        """Damped Gauss-Newton step ``(p,)``."""
        solved = np.linalg.solve(_damped(self.information, damping), self.gradient)
        return np.asarray(-solved, np.float64)

    def covariance(self, sigma: float) -> FloatArray:
        """Covariance ``(p, p)`` of the parameters for residuals with so much noise."""
        covariance = sigma**2 * np.linalg.inv(self.information)
        return np.asarray(0.5 * (covariance + covariance.T), np.float64)


@dataclass(frozen=True, eq=False)
class BlockEquations:
    """Equations of few parameters that all may meet, and of many small blocks that never do.

    The blocks are eliminated, so a step costs time in proportion to them and with the cube of the
    rest. Sums are made in one order: the same input gives the same bytes.

    Args:
        information: ``(g w, g w)`` of the g groups of w parameters that are kept; larger where
            others, which no block meets, stand behind them (`solved`).
        gradient: ``(g w,)``, or longer likewise.
        blocks: ``(b, s, s)`` information of the blocks.
        block_gradient: ``(b, s)``.
        block_of, group_of: ``(m,)`` which block and which group meet; a pair stands at most once.
        coupling: ``(m, s, w)`` their common part of the information.
    """

    information: FloatArray
    gradient: FloatArray
    blocks: FloatArray
    block_gradient: FloatArray
    block_of: IntArray
    group_of: IntArray
    coupling: FloatArray

    def step(self, damping: float) -> tuple[FloatArray, FloatArray]:
        """Damped Gauss-Newton step of the groups ``(g, w)`` and of the blocks ``(b, s)``."""
        kept, blocks = self.solved(damping)
        return kept.reshape(-1, self.coupling.shape[-1]), blocks

    def solved(self, damping: float) -> tuple[FloatArray, FloatArray]:
        """The same step, its kept parameters in a row: some may follow those of the groups."""
        matrix, right, inverted = self._reduced(damping)
        kept = np.asarray(-np.linalg.solve(matrix, right), np.float64) if len(right) else right
        return kept, substitute(inverted, *self._met, kept)

    @property
    def reduced_information(self) -> FloatArray:
        """Information ``(g w, g w)`` of the kept parameters, the blocks being unknown too."""
        return self._reduced(0.0)[0]

    def _reduced(self, damping: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Matrix and right-hand side without the blocks, and the blocks inverted."""
        inverted = invert(_damped(self.blocks, damping))
        if inverted is None:
            raise np.linalg.LinAlgError("a block has no inverse")
        kept = _damped(self.information, damping), self.gradient
        return *eliminate(inverted, *self._met, *kept), inverted

    @property
    def _met(self) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
        return self.block_gradient, self.block_of, self.group_of, self.coupling


def sum_by(values: FloatArray, owner: IntArray, count: int) -> FloatArray:
    """Sums ``(count, *)`` of rows ``(n, *)`` by owner, in the order of the rows.

    >>> import numpy as np
    >>> from motorcade.tracking.optimise import sum_by
    >>> sum_by(np.array([1.0, 2.0, 4.0]), np.array([2, 0, 2]), 3)
    array([2., 0., 5.])
    """
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.arange(count))
    sums = np.zeros((count, *values.shape[1:]))
    present = np.flatnonzero(np.bincount(owner, minlength=count))
    if len(present):
        sums[present] = np.add.reduceat(values[order], starts[present], axis=0)
    return sums


class PairIndex:
    """Which of many (row, column) are equal, found once for the sums of many values.

    Attributes:
        rows, columns: ``(m,)`` of each pair, rising.
        pair_of: ``(n,)`` which pair each is.

    >>> import numpy as np
    >>> from motorcade.tracking.optimise import PairIndex
    >>> index = PairIndex(np.array([1, 0, 1]), np.array([2, 0, 2]))
    >>> index.rows, index.columns, index.sums(np.array([1.0, 2.0, 4.0]))
    (array([0, 1]), array([0, 2]), array([2., 5.]))
    """

    def __init__(self, rows: IntArray, columns: IntArray) -> None:
        width = int(columns.max(initial=0)) + 1
        pairs = rows * width + columns
        self._order = np.argsort(pairs, kind="stable")
        pairs = pairs[self._order]
        self._starts = np.flatnonzero(np.diff(pairs, prepend=-1))
        self.pair_of: IntArray = np.empty(len(pairs), np.int64)
        self.pair_of[self._order] = np.cumsum(np.diff(pairs, prepend=-1) > 0) - 1
        self.rows: IntArray = pairs[self._starts] // width
        self.columns: IntArray = pairs[self._starts] % width

    def sums(self, values: FloatArray) -> FloatArray:
        """Sums ``(m, *)`` of values ``(n, *)``, in their order."""
        if not len(self._starts):
            return np.zeros((0, *values.shape[1:]))
        return np.asarray(np.add.reduceat(values[self._order], self._starts, axis=0), np.float64)


def pair_sums(
    values: FloatArray, rows: IntArray, columns: IntArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Sum values ``(n, *)`` of equal (row, column); gives each pair's row, column and sum."""
    index = PairIndex(rows, columns)
    return index.rows, index.columns, index.sums(values)


def _damped(information: FloatArray, damping: float) -> FloatArray:
    diagonal = np.einsum("...ii->...i", information)
    more = (damping * diagonal + _FLOOR)[..., None] * np.eye(information.shape[-1])
    return np.asarray(information + more, np.float64)


def huber(size: FloatArray, limit: float) -> tuple[FloatArray, FloatArray]:
    """Huber's loss and weight of sizes ``(*,)``: squares up to `limit`, beyond it straight.

    >>> from motorcade.tracking.optimise import huber
    >>> huber([1.0, 4.0], limit=2.0)
    (array([0.5, 6. ]), array([1. , 0.5]))
    """
    inside = np.minimum(size, limit)
    weight: FloatArray = limit / np.maximum(size, limit)
    return inside * (size - 0.5 * inside), weight


def huber_cauchy(size: FloatArray, limit: float, outlier: float) -> tuple[FloatArray, FloatArray]:
    """Huber's loss up to `outlier`, Cauchy's bounded pull beyond it: far residuals hardly count."""
    loss, _ = huber(np.minimum(size, outlier), limit)
    weight = limit / np.maximum(size, limit)
    beyond = np.maximum(size - outlier, 0.0) / outlier
    return loss + limit * outlier * np.arctan(beyond), weight / (1.0 + beyond**2)


_LEAST_DAMPING = 1e-12

State = TypeVar("State")
Step = TypeVar("Step")
Step_co = TypeVar("Step_co", covariant=True)


class _Equations(Protocol[Step_co]):
    def step(self, damping: float) -> Step_co: ...


class Evaluated(Protocol[Step_co]):
    """What a problem says of one state; equations may be formed only when they are asked for."""

    @property
    def cost(self) -> float:
        """What is minimised: half a sum of squares, or a robust loss; may be infinite."""

    @property
    def equations(self) -> _Equations[Step_co]:
        """The linearised problem."""


AnyEvaluated = TypeVar("AnyEvaluated", bound=Evaluated)  # type: ignore[type-arg]


@dataclass(frozen=True)
class Stop:
    """When a minimisation ends.

    Fields:
        steps: that are tried at most, rejected ones included.
        gain: a step that lowers the cost by no more than this share of it is the last one.
        damping: to begin with; a tenth after a step that is kept, ten times after another.
        most_damping: beyond it nothing lowers the cost any more.
        what: is adjusted, for those who wait; empty where it takes no time.
    """

    steps: int = 50
    gain: float = 1e-10
    damping: float = 1e-4
    most_damping: float = 1e9
    what: str = ""


@dataclass(frozen=True, eq=False)
class Minimum(Generic[State, AnyEvaluated]):
    """Where a minimisation ended.

    Args:
        state: the best state.
        evaluation: the problem there.
        start_cost: the cost where it began.
    """

    state: State
    evaluation: AnyEvaluated
    start_cost: float


def minimise(
    start: State,
    evaluate: Callable[[State], AnyEvaluated],
    retract: Callable[[State, Step], State],
    stop: Stop,
) -> Minimum[State, AnyEvaluated]:
    """Find a state near `start` whose cost no small step lowers.

    Args:
        start: where to begin; its cost is finite.
        evaluate: the problem at a state.
        retract: a state moved by a step, as the equations' `step` gives it.
        stop: when to end.

    >>> import numpy as np
    >>> from motorcade.tracking.optimise import NormalEquations, Stop, minimise
    >>> class Rosenbrock:
    ...     def __init__(self, at):
    ...         residuals = np.array([10.0 * (at[1] - at[0] ** 2), 1.0 - at[0]])
    ...         jacobian = np.array([[-20.0 * at[0], 10.0], [-1.0, 0.0]])
    ...         self.cost = 0.5 * residuals @ residuals
    ...         self.equations = NormalEquations.of(jacobian, residuals)
    >>> found = minimise(np.array([-1.2, 1.0]), Rosenbrock, np.add, Stop())
    >>> bool(np.allclose(found.state, 1.0))
    True
    """
    state, here = start, evaluate(start)
    damping, start_cost = stop.damping, here.cost
    steps = range(stop.steps)
    for _ in track(steps, stop.what, stop.steps) if stop.what else steps:
        try:
            tried = retract(state, here.equations.step(damping))
            there = evaluate(tried)
        except np.linalg.LinAlgError:  # singular: more damping helps
            there = None
        if there is None or not there.cost <= here.cost:
            damping *= 10.0
            if damping > stop.most_damping:
                break
            continue
        settled = here.cost - there.cost <= stop.gain * here.cost
        state, here = tried, there
        damping = max(0.1 * damping, _LEAST_DAMPING)
        if settled:
            break
    return Minimum(state, here, start_cost)


_FLOOR_OF_POSES = 1e-6
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
    >>> from motorcade.tracking.optimise import SparseEquations
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
        matrix = matrix + diags(damping * matrix.diagonal() + _FLOOR_OF_POSES, format="csc")
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
        floor = _FLOOR_OF_POSES * np.eye(width)
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
