"""Nonlinear least squares: one Levenberg-Marquardt loop, two linear solvers, the robust losses."""

from __future__ import annotations

from motorcade.tracking.optimise.equations import BlockEquations, NormalEquations, pair_sums, sum_by
from motorcade.tracking.optimise.least_squares import Minimum, Stop, minimise
from motorcade.tracking.optimise.losses import huber, huber_cauchy

__all__ = [
    "BlockEquations",
    "Minimum",
    "NormalEquations",
    "Stop",
    "huber",
    "huber_cauchy",
    "minimise",
    "pair_sums",
    "sum_by",
]
