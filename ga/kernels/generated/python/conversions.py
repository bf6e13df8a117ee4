"""Kernels of the group conversions: matrix34, matrix44, transform, dual_quaternion.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any


def matrix34_f32(m: Any) -> tuple[Any, ...]:
    """3×4 matrix of a motor, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0
    t1 = m3 * m3
    t2 = t0 - t1
    t3 = m2 * m2
    t4 = m1 * m1
    t5 = m0 * m3 * 2.0
    t6 = 2.0 * (m2 * m1)
    t7 = m3 * m1
    t8 = m0 * m2
    t9 = m3 * m2
    t10 = m0 * m1
    return (
        t2 - t3 + t4,
        t5 + t6,
        2.0 * (t7 - t8),
        -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7),
        t6 - t5,
        t2 + t3 - t4,
        2.0 * (t9 + t10),
        -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        2.0 * (t7 + t8),
        2.0 * (t9 - t10),
        t1 + (t0 - (t3 + t4)),
        -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
    )


def matrix34_f64(m: Any) -> tuple[Any, ...]:
    """3×4 matrix of a motor, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0
    t1 = m3 * m3
    t2 = t0 - t1
    t3 = m2 * m2
    t4 = m1 * m1
    t5 = m0 * m3 * 2.0
    t6 = 2.0 * (m2 * m1)
    t7 = m3 * m1
    t8 = m0 * m2
    t9 = m3 * m2
    t10 = m0 * m1
    return (
        t2 - t3 + t4,
        t5 + t6,
        2.0 * (t7 - t8),
        -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7),
        t6 - t5,
        t2 + t3 - t4,
        2.0 * (t9 + t10),
        -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        2.0 * (t7 + t8),
        2.0 * (t9 - t10),
        t1 + (t0 - (t3 + t4)),
        -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
    )


def matrix44_f32(m: Any) -> tuple[Any, ...]:
    """4×4 matrix of a motor, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0
    t1 = m3 * m3
    t2 = t0 - t1
    t3 = m2 * m2
    t4 = m1 * m1
    t5 = m0 * m3 * 2.0
    t6 = 2.0 * (m2 * m1)
    t7 = m3 * m1
    t8 = m0 * m2
    t9 = m3 * m2
    t10 = m0 * m1
    return (
        t2 - t3 + t4,
        t5 + t6,
        2.0 * (t7 - t8),
        -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7),
        t6 - t5,
        t2 + t3 - t4,
        2.0 * (t9 + t10),
        -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        2.0 * (t7 + t8),
        2.0 * (t9 - t10),
        t1 + (t0 - (t3 + t4)),
        -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
        0.0,
        0.0,
        0.0,
        1.0,
    )


def matrix44_f64(m: Any) -> tuple[Any, ...]:
    """4×4 matrix of a motor, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0
    t1 = m3 * m3
    t2 = t0 - t1
    t3 = m2 * m2
    t4 = m1 * m1
    t5 = m0 * m3 * 2.0
    t6 = 2.0 * (m2 * m1)
    t7 = m3 * m1
    t8 = m0 * m2
    t9 = m3 * m2
    t10 = m0 * m1
    return (
        t2 - t3 + t4,
        t5 + t6,
        2.0 * (t7 - t8),
        -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7),
        t6 - t5,
        t2 + t3 - t4,
        2.0 * (t9 + t10),
        -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        2.0 * (t7 + t8),
        2.0 * (t9 - t10),
        t1 + (t0 - (t3 + t4)),
        -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
        0.0,
        0.0,
        0.0,
        1.0,
    )


def transform_f32(m: Any, x: Any) -> tuple[Any, ...]:
    """Points moved by 3×4 matrices, given by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    return (
        m3 + m0 * x0 + m1 * x1 + m2 * x2,
        m7 + x0 * m4 + x1 * m5 + x2 * m6,
        m11 + x0 * m8 + x1 * m9 + x2 * m10,
    )


def transform_f64(m: Any, x: Any) -> tuple[Any, ...]:
    """Points moved by 3×4 matrices, given by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    return (
        m3 + m0 * x0 + m1 * x1 + m2 * x2,
        m7 + x0 * m4 + x1 * m5 + x2 * m6,
        m11 + x0 * m8 + x1 * m9 + x2 * m10,
    )


def dual_quaternion_f32(m: Any) -> tuple[Any, ...]:
    """Unit Hamilton dual quaternion: real wxyz, dual wxyz"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    return (
        m0,
        -m1,
        -m2,
        -m3,
        -m7,
        -m4,
        -m5,
        -m6,
    )


def dual_quaternion_f64(m: Any) -> tuple[Any, ...]:
    """Unit Hamilton dual quaternion: real wxyz, dual wxyz"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    return (
        m0,
        -m1,
        -m2,
        -m3,
        -m7,
        -m4,
        -m5,
        -m6,
    )
