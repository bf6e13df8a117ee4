"""The one loop of nonlinear least squares: damped steps, kept only where the cost falls.

Sources: Levenberg 1944; Marquardt 1963; Madsen, Nielsen & Tingleff 2004.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

__all__ = ["Evaluated", "Minimum", "Stop", "minimise"]

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
    """

    steps: int = 50
    gain: float = 1e-10
    damping: float = 1e-4
    most_damping: float = 1e9


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
    for _ in range(stop.steps):
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
