"""Kernels of the group chains: reach.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def reach_f32(p: Any, q: Any, length: Any) -> tuple[Any, ...]:
    """The point of the ray from p towards q that lies a length from p"""
    p0, p1, p2 = (p[..., i] for i in range(3))
    q0, q1, q2 = (q[..., i] for i in range(3))
    length = length[..., 0]
    t0 = q0 - p0
    t1 = length * (0.5 * length)
    t2 = q1 - p1
    t3 = q2 - p2
    t4 = np.sqrt(t0 * (t0 * t1) * 2.0 + (2.0 * (t2 * (t1 * t2)) + 2.0 * (t3 * (t1 * t3))))
    t5 = 1.0 / (t0 * t0 + t2 * t2 + t3 * t3)
    return (
        p0 + t0 * t4 * t5,
        p1 + t5 * (t2 * t4),
        p2 + t5 * (t3 * t4),
    )


def reach_f64(p: Any, q: Any, length: Any) -> tuple[Any, ...]:
    """The point of the ray from p towards q that lies a length from p"""
    p0, p1, p2 = (p[..., i] for i in range(3))
    q0, q1, q2 = (q[..., i] for i in range(3))
    length = length[..., 0]
    t0 = q0 - p0
    t1 = length * (0.5 * length)
    t2 = q1 - p1
    t3 = q2 - p2
    t4 = np.sqrt(t0 * (t0 * t1) * 2.0 + (2.0 * (t2 * (t1 * t2)) + 2.0 * (t3 * (t1 * t3))))
    t5 = 1.0 / (t0 * t0 + t2 * t2 + t3 * t3)
    return (
        p0 + t0 * t4 * t5,
        p1 + t5 * (t2 * t4),
        p2 + t5 * (t3 * t4),
    )
