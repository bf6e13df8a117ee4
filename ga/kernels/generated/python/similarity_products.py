"""Kernels of the group similarity_products: similarity_compose, similarity_inverse,
similarity_apply.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def similarity_compose_f32(a: Any, b: Any) -> tuple[Any, ...]:
    """Geometric product a b of similarities"""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    t0 = a0 + a4
    t1 = a3 + a7
    t2 = a2 + a6
    t3 = a1 + a5
    t4 = b0 - b4
    t5 = b3 - b7
    t6 = b6 - b2
    t7 = b1 - b5
    return (
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1 + (a4 * b4 - a7 * b7 - a6 * b6 - a5 * b5),
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2 + (a4 * b5 - b7 * a6 + b4 * a5 + a7 * b6),
        -(a3 * b1 - a0 * b2 - b0 * a2 - b3 * a1 + (a7 * b5 - a4 * b6 - b4 * a6 - b7 * a5)),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1 + (a4 * b7 + b4 * a7 - b6 * a5 + a6 * b5),
        a0 * b4 - a3 * b7 - a2 * b6 - a1 * b5 + (b0 * a4 - b3 * a7 - b2 * a6 - b1 * a5),
        a0 * b5 - a2 * b7 + a1 * b4 + a3 * b6 + (b1 * a4 - b3 * a6 + b0 * a5 + b2 * a7),
        -(a3 * b5 - a0 * b6 - a2 * b4 - a1 * b7 + (b1 * a7 - b2 * a4 - b0 * a6 - b3 * a5)),
        a0 * b7 + a3 * b4 - a1 * b6 + a2 * b5 + (b3 * a4 + b0 * a7 - b2 * a5 + b1 * a6),
        t0 * b8 + t1 * b9 - t2 * b10 - t3 * b11 + (a8 * t4 - a9 * t5 - a10 * t6 - a11 * t7),
        t0 * b9 - t2 * b11 + b10 * t3 - b8 * t1 + (a8 * t5 + t4 * a9 + t6 * a11 - a10 * t7),
        t0 * b10 - t1 * b11 + b8 * t2 - b9 * t3 + (a8 * t6 + a9 * t7 + t4 * a10 - t5 * a11),
        t0 * b11 + t1 * b10 + b8 * t3 + b9 * t2 + (a8 * t7 + t5 * a10 + t4 * a11 - a9 * t6),
    )


def similarity_compose_f64(a: Any, b: Any) -> tuple[Any, ...]:
    """Geometric product a b of similarities"""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    t0 = a0 + a4
    t1 = a3 + a7
    t2 = a2 + a6
    t3 = a1 + a5
    t4 = b0 - b4
    t5 = b3 - b7
    t6 = b6 - b2
    t7 = b1 - b5
    return (
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1 + (a4 * b4 - a7 * b7 - a6 * b6 - a5 * b5),
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2 + (a4 * b5 - b7 * a6 + b4 * a5 + a7 * b6),
        -(a3 * b1 - a0 * b2 - b0 * a2 - b3 * a1 + (a7 * b5 - a4 * b6 - b4 * a6 - b7 * a5)),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1 + (a4 * b7 + b4 * a7 - b6 * a5 + a6 * b5),
        a0 * b4 - a3 * b7 - a2 * b6 - a1 * b5 + (b0 * a4 - b3 * a7 - b2 * a6 - b1 * a5),
        a0 * b5 - a2 * b7 + a1 * b4 + a3 * b6 + (b1 * a4 - b3 * a6 + b0 * a5 + b2 * a7),
        -(a3 * b5 - a0 * b6 - a2 * b4 - a1 * b7 + (b1 * a7 - b2 * a4 - b0 * a6 - b3 * a5)),
        a0 * b7 + a3 * b4 - a1 * b6 + a2 * b5 + (b3 * a4 + b0 * a7 - b2 * a5 + b1 * a6),
        t0 * b8 + t1 * b9 - t2 * b10 - t3 * b11 + (a8 * t4 - a9 * t5 - a10 * t6 - a11 * t7),
        t0 * b9 - t2 * b11 + b10 * t3 - b8 * t1 + (a8 * t5 + t4 * a9 + t6 * a11 - a10 * t7),
        t0 * b10 - t1 * b11 + b8 * t2 - b9 * t3 + (a8 * t6 + a9 * t7 + t4 * a10 - t5 * a11),
        t0 * b11 + t1 * b10 + b8 * t3 + b9 * t2 + (a8 * t7 + t5 * a10 + t4 * a11 - a9 * t6),
    )


def similarity_inverse_f32(m: Any) -> tuple[Any, ...]:
    """Reverse of a similarity: its inverse"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    return (
        m0,
        -m1,
        -m2,
        -m3,
        -m4,
        m5,
        m6,
        m7,
        -m8,
        -m9,
        -m10,
        m11,
    )


def similarity_inverse_f64(m: Any) -> tuple[Any, ...]:
    """Reverse of a similarity: its inverse"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    return (
        m0,
        -m1,
        -m2,
        -m3,
        -m4,
        m5,
        m6,
        m7,
        -m8,
        -m9,
        -m10,
        m11,
    )


def similarity_apply_f32(m: Any, x: Any) -> tuple[Any, ...]:
    """Points moved by similarities"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t1 = m0 - m4
    t2 = m3 - m7
    t3 = m6 - m2
    t4 = m1 - m5
    t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4)
    t6 = np.where(t0, t1 * t5, m0 + m4)
    t7 = np.where(t0, t2 * t5, m3 + m7)
    t8 = np.where(t0, -(t3 * t5), m2 + m6)
    t9 = t6 * x0 + t7 * x1 - t8 * x2
    t10 = np.where(t0, t4 * t5, m1 + m5)
    t11 = t6 * x1 + x2 * t10 - x0 * t7
    t12 = t6 * x2 + x0 * t8 - x1 * t10
    t13 = t7 * x2 + x0 * t10 + x1 * t8
    t14 = (
        t6 * t9 + t7 * t11 - t8 * t12 + t10 * t13 + -2.0 * (t6 * m8 + t7 * m9 - t8 * m10 + t10 *
            m11)
    )
    t15 = (
        t6 * t11 - t7 * t9 + t8 * t13 + t10 * t12 + -2.0 * (t6 * m9 - t7 * m8 + t8 * m11 + t10 *
            m10)
    )
    t16 = (
        t8 * t9 - t10 * t11 + t6 * t12 + t7 * t13 + -2.0 * (t8 * m8 - t10 * m9 + t6 * m10 + t7 *
            m11)
    )
    return (
        t14,
        t15,
        t16,
    )


def similarity_apply_f64(m: Any, x: Any) -> tuple[Any, ...]:
    """Points moved by similarities"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t1 = m0 - m4
    t2 = m3 - m7
    t3 = m6 - m2
    t4 = m1 - m5
    t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4)
    t6 = np.where(t0, t1 * t5, m0 + m4)
    t7 = np.where(t0, t2 * t5, m3 + m7)
    t8 = np.where(t0, -(t3 * t5), m2 + m6)
    t9 = t6 * x0 + t7 * x1 - t8 * x2
    t10 = np.where(t0, t4 * t5, m1 + m5)
    t11 = t6 * x1 + x2 * t10 - x0 * t7
    t12 = t6 * x2 + x0 * t8 - x1 * t10
    t13 = t7 * x2 + x0 * t10 + x1 * t8
    t14 = (
        t6 * t9 + t7 * t11 - t8 * t12 + t10 * t13 + -2.0 * (t6 * m8 + t7 * m9 - t8 * m10 + t10 *
            m11)
    )
    t15 = (
        t6 * t11 - t7 * t9 + t8 * t13 + t10 * t12 + -2.0 * (t6 * m9 - t7 * m8 + t8 * m11 + t10 *
            m10)
    )
    t16 = (
        t8 * t9 - t10 * t11 + t6 * t12 + t7 * t13 + -2.0 * (t8 * m8 - t10 * m9 + t6 * m10 + t7 *
            m11)
    )
    return (
        t14,
        t15,
        t16,
    )
