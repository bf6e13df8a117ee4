"""Kernels of the group linear_blends: blend, blend_matrix, accumulate, normalize, normalize_matrix.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def blend_f32(a: Any, b: Any, fraction: Any) -> tuple[Any, ...]:
    """Linear blend of two motors, the short way round, made unit"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    fraction = fraction[..., 0]
    t0 = 1.0 - fraction
    t1 = np.where((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0), -fraction, fraction)
    t2 = t0 * a0 + b0 * t1
    t3 = t0 * a3 + b3 * t1
    t4 = t0 * a2 + b2 * t1
    t5 = t0 * a1 + b1 * t1
    t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5
    t7 = 1.0 / np.sqrt(t6)
    t8 = t0 * a4 + t1 * b4
    t9 = t0 * a7 + t1 * b7
    t10 = t0 * a6 + t1 * b6
    t11 = t0 * a5 + t1 * b5
    t12 = t7 * (-0.5 * (2.0 * (t2 * t9 - t3 * t10 - t5 * t8 - t4 * t11)) / t6)
    return (
        t2 * t7,
        t5 * t7,
        t4 * t7,
        t3 * t7,
        t7 * t8 - t5 * t12,
        t7 * t11 - t4 * t12,
        t7 * t10 - t3 * t12,
        t7 * t9 + t2 * t12,
    )


def blend_f64(a: Any, b: Any, fraction: Any) -> tuple[Any, ...]:
    """Linear blend of two motors, the short way round, made unit"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    fraction = fraction[..., 0]
    t0 = 1.0 - fraction
    t1 = np.where((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0), -fraction, fraction)
    t2 = t0 * a0 + b0 * t1
    t3 = t0 * a3 + b3 * t1
    t4 = t0 * a2 + b2 * t1
    t5 = t0 * a1 + b1 * t1
    t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5
    t7 = 1.0 / np.sqrt(t6)
    t8 = t0 * a4 + t1 * b4
    t9 = t0 * a7 + t1 * b7
    t10 = t0 * a6 + t1 * b6
    t11 = t0 * a5 + t1 * b5
    t12 = t7 * (-0.5 * (2.0 * (t2 * t9 - t3 * t10 - t5 * t8 - t4 * t11)) / t6)
    return (
        t2 * t7,
        t5 * t7,
        t4 * t7,
        t3 * t7,
        t7 * t8 - t5 * t12,
        t7 * t11 - t4 * t12,
        t7 * t10 - t3 * t12,
        t7 * t9 + t2 * t12,
    )


def blend_matrix_f32(a: Any, b: Any, fraction: Any) -> tuple[Any, ...]:
    """Linear blend of two motors as a 3×4 matrix"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    fraction = fraction[..., 0]
    t0 = 1.0 - fraction
    t1 = np.where((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0), -fraction, fraction)
    t2 = t0 * a0 + b0 * t1
    t3 = t2 * t2
    t4 = t0 * a3 + b3 * t1
    t5 = t4 * t4
    t6 = t3 - t5
    t7 = t0 * a2 + b2 * t1
    t8 = t7 * t7
    t9 = t0 * a1 + b1 * t1
    t10 = t9 * t9
    t11 = 1.0 / (t10 + (t8 + (t3 + t5)))
    t12 = t2 * t4 * 2.0
    t13 = 2.0 * (t7 * t9)
    t14 = t4 * t9
    t15 = t2 * t7
    t16 = t11 * 2.0
    t17 = t0 * a4 + t1 * b4
    t18 = t0 * a5 + t1 * b5
    t19 = t0 * a6 + t1 * b6
    t20 = t0 * a7 + t1 * b7
    t21 = t11 * -2.0
    t22 = t4 * t7
    t23 = t2 * t9
    return (
        (t6 - t8 + t10) * t11,
        t11 * (t12 + t13),
        (t14 - t15) * t16,
        (t2 * t17 + t4 * t18 - t7 * t19 + t9 * t20) * t21,
        t11 * (t13 - t12),
        t11 * (t6 + t8 - t10),
        t16 * (t22 + t23),
        t21 * (t2 * t18 - t4 * t17 + t7 * t20 + t9 * t19),
        t16 * (t14 + t15),
        t16 * (t22 - t23),
        t11 * (t5 + (t3 - (t8 + t10))),
        t21 * (t7 * t17 - t9 * t18 + t2 * t19 + t4 * t20),
    )


def blend_matrix_f64(a: Any, b: Any, fraction: Any) -> tuple[Any, ...]:
    """Linear blend of two motors as a 3×4 matrix"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    fraction = fraction[..., 0]
    t0 = 1.0 - fraction
    t1 = np.where((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0), -fraction, fraction)
    t2 = t0 * a0 + b0 * t1
    t3 = t2 * t2
    t4 = t0 * a3 + b3 * t1
    t5 = t4 * t4
    t6 = t3 - t5
    t7 = t0 * a2 + b2 * t1
    t8 = t7 * t7
    t9 = t0 * a1 + b1 * t1
    t10 = t9 * t9
    t11 = 1.0 / (t10 + (t8 + (t3 + t5)))
    t12 = t2 * t4 * 2.0
    t13 = 2.0 * (t7 * t9)
    t14 = t4 * t9
    t15 = t2 * t7
    t16 = t11 * 2.0
    t17 = t0 * a4 + t1 * b4
    t18 = t0 * a5 + t1 * b5
    t19 = t0 * a6 + t1 * b6
    t20 = t0 * a7 + t1 * b7
    t21 = t11 * -2.0
    t22 = t4 * t7
    t23 = t2 * t9
    return (
        (t6 - t8 + t10) * t11,
        t11 * (t12 + t13),
        (t14 - t15) * t16,
        (t2 * t17 + t4 * t18 - t7 * t19 + t9 * t20) * t21,
        t11 * (t13 - t12),
        t11 * (t6 + t8 - t10),
        t16 * (t22 + t23),
        t21 * (t2 * t18 - t4 * t17 + t7 * t20 + t9 * t19),
        t16 * (t14 + t15),
        t16 * (t22 - t23),
        t11 * (t5 + (t3 - (t8 + t10))),
        t21 * (t7 * t17 - t9 * t18 + t2 * t19 + t4 * t20),
    )


def accumulate_f32(total: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """Sum total ± weight m, signed as m beside the pivot"""
    total0, total1, total2, total3, total4, total5, total6, total7 = (total[..., i] for i in
        range(8))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    weight = weight[..., 0]
    t0 = np.where((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0), -weight, weight)
    return (
        total0 + m0 * t0,
        total1 + m1 * t0,
        total2 + m2 * t0,
        total3 + m3 * t0,
        total4 + t0 * m4,
        total5 + t0 * m5,
        total6 + t0 * m6,
        total7 + t0 * m7,
    )


def accumulate_f64(total: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """Sum total ± weight m, signed as m beside the pivot"""
    total0, total1, total2, total3, total4, total5, total6, total7 = (total[..., i] for i in
        range(8))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    weight = weight[..., 0]
    t0 = np.where((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0), -weight, weight)
    return (
        total0 + m0 * t0,
        total1 + m1 * t0,
        total2 + m2 * t0,
        total3 + m3 * t0,
        total4 + t0 * m4,
        total5 + t0 * m5,
        total6 + t0 * m6,
        total7 + t0 * m7,
    )


def normalize_f32(m: Any) -> tuple[Any, ...]:
    """The motor nearest to an even element"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1
    t1 = 1.0 / np.sqrt(t0)
    t2 = t1 * (-0.5 * (2.0 * (m0 * m7 - m3 * m6 - m1 * m4 - m2 * m5)) / t0)
    return (
        m0 * t1,
        m1 * t1,
        m2 * t1,
        m3 * t1,
        t1 * m4 - m1 * t2,
        t1 * m5 - m2 * t2,
        t1 * m6 - m3 * t2,
        t1 * m7 + m0 * t2,
    )


def normalize_f64(m: Any) -> tuple[Any, ...]:
    """The motor nearest to an even element"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1
    t1 = 1.0 / np.sqrt(t0)
    t2 = t1 * (-0.5 * (2.0 * (m0 * m7 - m3 * m6 - m1 * m4 - m2 * m5)) / t0)
    return (
        m0 * t1,
        m1 * t1,
        m2 * t1,
        m3 * t1,
        t1 * m4 - m1 * t2,
        t1 * m5 - m2 * t2,
        t1 * m6 - m3 * t2,
        t1 * m7 + m0 * t2,
    )


def normalize_matrix_f32(m: Any) -> tuple[Any, ...]:
    """3×4 matrix of the motor nearest to an even element"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0
    t1 = m3 * m3
    t2 = t0 - t1
    t3 = m2 * m2
    t4 = m1 * m1
    t5 = 1.0 / (t4 + (t3 + (t0 + t1)))
    t6 = m0 * m3 * 2.0
    t7 = 2.0 * (m2 * m1)
    t8 = m3 * m1
    t9 = m0 * m2
    t10 = t5 * 2.0
    t11 = t5 * -2.0
    t12 = m3 * m2
    t13 = m0 * m1
    return (
        (t2 - t3 + t4) * t5,
        t5 * (t6 + t7),
        (t8 - t9) * t10,
        (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7) * t11,
        t5 * (t7 - t6),
        t5 * (t2 + t3 - t4),
        t10 * (t12 + t13),
        t11 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        t10 * (t8 + t9),
        t10 * (t12 - t13),
        t5 * (t1 + (t0 - (t3 + t4))),
        t11 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
    )


def normalize_matrix_f64(m: Any) -> tuple[Any, ...]:
    """3×4 matrix of the motor nearest to an even element"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m0 * m0
    t1 = m3 * m3
    t2 = t0 - t1
    t3 = m2 * m2
    t4 = m1 * m1
    t5 = 1.0 / (t4 + (t3 + (t0 + t1)))
    t6 = m0 * m3 * 2.0
    t7 = 2.0 * (m2 * m1)
    t8 = m3 * m1
    t9 = m0 * m2
    t10 = t5 * 2.0
    t11 = t5 * -2.0
    t12 = m3 * m2
    t13 = m0 * m1
    return (
        (t2 - t3 + t4) * t5,
        t5 * (t6 + t7),
        (t8 - t9) * t10,
        (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7) * t11,
        t5 * (t7 - t6),
        t5 * (t2 + t3 - t4),
        t10 * (t12 + t13),
        t11 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        t10 * (t8 + t9),
        t10 * (t12 - t13),
        t5 * (t1 + (t0 - (t3 + t4))),
        t11 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
    )
