"""Nonlinear least squares: one Levenberg-Marquardt loop, two linear solvers, the robust losses.

Sources: Levenberg 1944; Marquardt 1963; Madsen, Nielsen & Tingleff 2004; of the losses Huber 1964;
of eliminated blocks (Schur) Triggs et al. 2000, sections 6.1 and 6.2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

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
