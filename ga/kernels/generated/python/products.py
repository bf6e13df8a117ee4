"""Kernels of the group products: compose, inverse, apply.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any


def compose_f32(a: Any, b: Any) -> tuple[Any, ...]:
    """Geometric product a b of motors"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    return (
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1,
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2,
        b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1,
        a0 * b4 + a3 * b5 - a2 * b6 + b0 * a4 - a1 * b7 - b3 * a5 + b2 * a6 - b1 * a7,
        a0 * b5 - a2 * b7 + b3 * a4 + a1 * b6 + b0 * a5 - b2 * a7 - a3 * b4 - b1 * a6,
        a0 * b6 - b2 * a4 + b1 * a5 + b0 * a6 - a3 * b7 + a2 * b4 - a1 * b5 - b3 * a7,
        a0 * b7 + a3 * b6 + b1 * a4 + a1 * b4 + b3 * a6 + b0 * a7 + a2 * b5 + b2 * a5,
    )


def compose_f64(a: Any, b: Any) -> tuple[Any, ...]:
    """Geometric product a b of motors"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    return (
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1,
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2,
        b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1,
        a0 * b4 + a3 * b5 - a2 * b6 + b0 * a4 - a1 * b7 - b3 * a5 + b2 * a6 - b1 * a7,
        a0 * b5 - a2 * b7 + b3 * a4 + a1 * b6 + b0 * a5 - b2 * a7 - a3 * b4 - b1 * a6,
        a0 * b6 - b2 * a4 + b1 * a5 + b0 * a6 - a3 * b7 + a2 * b4 - a1 * b5 - b3 * a7,
        a0 * b7 + a3 * b6 + b1 * a4 + a1 * b4 + b3 * a6 + b0 * a7 + a2 * b5 + b2 * a5,
    )


def inverse_f32(m: Any) -> tuple[Any, ...]:
    """Reverse of a motor: its inverse"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    return (
        m0,
        -m1,
        -m2,
        -m3,
        -m4,
        -m5,
        -m6,
        m7,
    )


def inverse_f64(m: Any) -> tuple[Any, ...]:
    """Reverse of a motor: its inverse"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    return (
        m0,
        -m1,
        -m2,
        -m3,
        -m4,
        -m5,
        -m6,
        m7,
    )


def apply_f32(m: Any, x: Any) -> tuple[Any, ...]:
    """Points moved by motors"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    x0, x1, x2 = (x[..., i] for i in range(3))
    t0 = m0 * x0 + m3 * x1 - m2 * x2
    t1 = m0 * x1 + x2 * m1 - x0 * m3
    t2 = m0 * x2 + x0 * m2 - x1 * m1
    t3 = m3 * x2 + x0 * m1 + x1 * m2
    t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7)
    t5 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6)
    t6 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7)
    return (
        t4,
        t5,
        t6,
    )


def apply_f64(m: Any, x: Any) -> tuple[Any, ...]:
    """Points moved by motors"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    x0, x1, x2 = (x[..., i] for i in range(3))
    t0 = m0 * x0 + m3 * x1 - m2 * x2
    t1 = m0 * x1 + x2 * m1 - x0 * m3
    t2 = m0 * x2 + x0 * m2 - x1 * m1
    t3 = m3 * x2 + x0 * m1 + x1 * m2
    t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7)
    t5 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6)
    t6 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7)
    return (
        t4,
        t5,
        t6,
    )
