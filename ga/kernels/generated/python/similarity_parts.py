"""Kernels of the group similarity_parts: similarity_of, similarity_of_matrix44,
similarity_of_coefficients, motor_scale.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def similarity_of_f32(r: Any, t: Any, scale: Any) -> tuple[Any, ...]:
    """Grow by a scale, turn by a rotor, move by a translation"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0, t1, t2 = (t[..., i] for i in range(3))
    scale = scale[..., 0]
    t3 = 1.0 / np.sqrt(scale)
    t4 = 0.5 * t3
    t5 = (scale + 1.0) * t4
    t6 = t4 * (scale - 1.0)
    t7 = -0.5 * t0
    t8 = -0.5 * t1
    t9 = -0.5 * t2
    return (
        r0 * t5,
        t5 * r1,
        t5 * r2,
        t5 * r3,
        r0 * t6,
        r1 * t6,
        r2 * t6,
        r3 * t6,
        t3 * (r0 * t7 - r3 * t8 + r2 * t9),
        t3 * (r3 * t7 + r0 * t8 - r1 * t9),
        t3 * (r1 * t8 - r2 * t7 + r0 * t9),
        t3 * (r1 * t7 + r3 * t9 + r2 * t8),
    )


def similarity_of_f64(r: Any, t: Any, scale: Any) -> tuple[Any, ...]:
    """Grow by a scale, turn by a rotor, move by a translation"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0, t1, t2 = (t[..., i] for i in range(3))
    scale = scale[..., 0]
    t3 = 1.0 / np.sqrt(scale)
    t4 = 0.5 * t3
    t5 = (scale + 1.0) * t4
    t6 = t4 * (scale - 1.0)
    t7 = -0.5 * t0
    t8 = -0.5 * t1
    t9 = -0.5 * t2
    return (
        r0 * t5,
        t5 * r1,
        t5 * r2,
        t5 * r3,
        r0 * t6,
        r1 * t6,
        r2 * t6,
        r3 * t6,
        t3 * (r0 * t7 - r3 * t8 + r2 * t9),
        t3 * (r3 * t7 + r0 * t8 - r1 * t9),
        t3 * (r1 * t8 - r2 * t7 + r0 * t9),
        t3 * (r1 * t7 + r3 * t9 + r2 * t8),
    )


def similarity_of_matrix44_f32(m: Any) -> tuple[Any, ...]:
    """Similarity of a homogeneous matrix by rows; what its last row is off by counts ten times"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15 = (m[..., i] for i in
        range(16))
    t0 = m0 * m0 + m1 * m1 + m2 * m2 + m4 * m4 + m5 * m5 + m6 * m6 + m8 * m8 + m9 * m9 + m10 * m10
    t1 = np.sqrt(0.33333334 * t0)
    t2 = 1.0 / t1
    t3 = m0 * t2
    t4 = 1.0 - t3
    t5 = m5 * t2
    t6 = m10 * t2
    t7 = t4 - t5 + t6
    t8 = t4 + t5 - t6
    t9 = (t7 <= t8)
    t10 = 1.0 + t3
    t11 = t10 - t5 - t6
    t12 = t6 + (t5 + t10)
    t13 = (t11 <= t12)
    t14 = (np.where(t9, t8, t7) <= np.where(t13, t12, t11))
    t15 = m9 * t2
    t16 = m6 * t2
    t17 = t15 - t16
    t18 = m2 * t2
    t19 = m8 * t2
    t20 = t18 - t19
    t21 = m4 * t2
    t22 = m1 * t2
    t23 = t21 - t22
    t24 = np.where(t14, np.where(t13, t12, t17), np.where(t9, t20, t23))
    t25 = t21 + t22
    t26 = t18 + t19
    t27 = np.where(t14, np.where(t13, t17, t11), np.where(t9, t25, t26))
    t28 = t15 + t16
    t29 = np.where(t14, np.where(t13, t20, t25), np.where(t9, t8, t28))
    t30 = np.where(t14, np.where(t13, t23, t26), np.where(t9, t28, t7))
    t31 = 1.0 / np.sqrt(t24 * t24 + t27 * t27 + t29 * t29 + t30 * t30)
    t32 = t24 * t31
    t33 = 1.0 / np.sqrt(t1)
    t34 = 0.5 * t33
    t35 = (1.0 + t1) * t34
    t36 = t27 * t31
    t37 = t29 * t31
    t38 = t30 * t31
    t39 = t34 * (t1 - 1.0)
    t40 = -0.5 * m3
    t41 = -0.5 * m7
    t42 = -0.5 * m11
    t43 = t3 * (t5 * t6 - t15 * t16) + t21 * (t15 * t18 - t6 * t22) + t19 * (t16 * t22 - t5 * t18)
    t44 = np.abs(t3 * t3 + t21 * t21 + t19 * t19 - 1.0) + np.abs(t3 * t22 + t5 * t21 + t15 * t19)
    t45 = (
        t44 + np.abs(t3 * t18 + t16 * t21 + t6 * t19) + np.abs(t22 * t22 + t5 * t5 + t15 * t15 -
            1.0)
    )
    t46 = (
        t45 + np.abs(t18 * t22 + t5 * t16 + t6 * t15) + np.abs(t18 * t18 + t16 * t16 + t6 * t6 -
            1.0)
    )
    t47 = (
        np.where((t43 < 0.0), np.float32(4.0), t46) + 10.0 * (np.abs(m12) + np.abs(m13) +
            np.abs(m14) + np.abs(m15 - 1.0))
    )
    return (
        t32 * t35,
        -(t35 * t36),
        -(t35 * t37),
        -(t35 * t38),
        t32 * t39,
        -(t36 * t39),
        -(t37 * t39),
        -(t38 * t39),
        t33 * (t32 * t40 + t38 * t41 - t37 * t42),
        t33 * (t32 * t41 - t38 * t40 + t36 * t42),
        t33 * (t37 * t40 - t36 * t41 + t32 * t42),
        -(t33 * (t36 * t40 + t38 * t42 + t37 * t41)),
        t47,
    )


def similarity_of_matrix44_f64(m: Any) -> tuple[Any, ...]:
    """Similarity of a homogeneous matrix by rows; what its last row is off by counts ten times"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15 = (m[..., i] for i in
        range(16))
    t0 = m0 * m0 + m1 * m1 + m2 * m2 + m4 * m4 + m5 * m5 + m6 * m6 + m8 * m8 + m9 * m9 + m10 * m10
    t1 = np.sqrt(0.3333333333333333 * t0)
    t2 = 1.0 / t1
    t3 = m0 * t2
    t4 = 1.0 - t3
    t5 = m5 * t2
    t6 = m10 * t2
    t7 = t4 - t5 + t6
    t8 = t4 + t5 - t6
    t9 = (t7 <= t8)
    t10 = 1.0 + t3
    t11 = t10 - t5 - t6
    t12 = t6 + (t5 + t10)
    t13 = (t11 <= t12)
    t14 = (np.where(t9, t8, t7) <= np.where(t13, t12, t11))
    t15 = m9 * t2
    t16 = m6 * t2
    t17 = t15 - t16
    t18 = m2 * t2
    t19 = m8 * t2
    t20 = t18 - t19
    t21 = m4 * t2
    t22 = m1 * t2
    t23 = t21 - t22
    t24 = np.where(t14, np.where(t13, t12, t17), np.where(t9, t20, t23))
    t25 = t21 + t22
    t26 = t18 + t19
    t27 = np.where(t14, np.where(t13, t17, t11), np.where(t9, t25, t26))
    t28 = t15 + t16
    t29 = np.where(t14, np.where(t13, t20, t25), np.where(t9, t8, t28))
    t30 = np.where(t14, np.where(t13, t23, t26), np.where(t9, t28, t7))
    t31 = 1.0 / np.sqrt(t24 * t24 + t27 * t27 + t29 * t29 + t30 * t30)
    t32 = t24 * t31
    t33 = 1.0 / np.sqrt(t1)
    t34 = 0.5 * t33
    t35 = (1.0 + t1) * t34
    t36 = t27 * t31
    t37 = t29 * t31
    t38 = t30 * t31
    t39 = t34 * (t1 - 1.0)
    t40 = -0.5 * m3
    t41 = -0.5 * m7
    t42 = -0.5 * m11
    t43 = t3 * (t5 * t6 - t15 * t16) + t21 * (t15 * t18 - t6 * t22) + t19 * (t16 * t22 - t5 * t18)
    t44 = np.abs(t3 * t3 + t21 * t21 + t19 * t19 - 1.0) + np.abs(t3 * t22 + t5 * t21 + t15 * t19)
    t45 = (
        t44 + np.abs(t3 * t18 + t16 * t21 + t6 * t19) + np.abs(t22 * t22 + t5 * t5 + t15 * t15 -
            1.0)
    )
    t46 = (
        t45 + np.abs(t18 * t22 + t5 * t16 + t6 * t15) + np.abs(t18 * t18 + t16 * t16 + t6 * t6 -
            1.0)
    )
    t47 = (
        np.where((t43 < 0.0), np.float64(4.0), t46) + 10.0 * (np.abs(m12) + np.abs(m13) +
            np.abs(m14) + np.abs(m15 - 1.0))
    )
    return (
        t32 * t35,
        -(t35 * t36),
        -(t35 * t37),
        -(t35 * t38),
        t32 * t39,
        -(t36 * t39),
        -(t37 * t39),
        -(t38 * t39),
        t33 * (t32 * t40 + t38 * t41 - t37 * t42),
        t33 * (t32 * t41 - t38 * t40 + t36 * t42),
        t33 * (t37 * t40 - t36 * t41 + t32 * t42),
        -(t33 * (t36 * t40 + t38 * t42 + t37 * t41)),
        t47,
    )


def similarity_of_coefficients_f32(m: Any) -> tuple[Any, ...]:
    """The same numbers, and how far ``S ~S`` is from 1, as a share of the squares in it"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = m0 * m0
    t1 = m4 * m4
    t2 = m1 * m1
    t3 = m5 * m5
    t4 = m2 * m2
    t5 = m6 * m6
    t6 = m3 * m3
    t7 = m7 * m7
    t8 = (
        np.maximum(np.maximum(np.maximum(np.maximum(1.0, np.abs(m8)), np.abs(m9)), np.abs(m10)),
            np.abs(m11))
    )
    t9 = (
        np.maximum(np.abs(t0 - t1 + (t2 - t3) + (t4 - t5) + (t6 - t7) - 1.0), np.abs((m11 * (m0 +
            m4) - (m8 * (m1 + m5) + m9 * (m2 + m6) + m10 * (m3 + m7))) / t8))
    )
    t10 = (
        np.maximum(np.maximum(t9, np.abs((m0 * m5 - m1 * m4 + m2 * m7 - m3 * m6) * 2.0)), np.abs(2.0
            * (m0 * m6 - m2 * m4 + m3 * m5 - m1 * m7)))
    )
    t11 = (
        np.maximum(1e-04, 1.0 / np.maximum(1.0, t7 + (t5 + (t3 + (t1 + (t6 + (t4 + (t0 + t2))))))))
    )
    return (
        m0,
        m1,
        m2,
        m3,
        m4,
        m5,
        m6,
        m7,
        m8,
        m9,
        m10,
        m11,
        np.maximum(t10, np.abs(2.0 * (m0 * m7 - m3 * m4 + m1 * m6 - m2 * m5))) * t11,
    )


def similarity_of_coefficients_f64(m: Any) -> tuple[Any, ...]:
    """The same numbers, and how far ``S ~S`` is from 1, as a share of the squares in it"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = m0 * m0
    t1 = m4 * m4
    t2 = m1 * m1
    t3 = m5 * m5
    t4 = m2 * m2
    t5 = m6 * m6
    t6 = m3 * m3
    t7 = m7 * m7
    t8 = (
        np.maximum(np.maximum(np.maximum(np.maximum(1.0, np.abs(m8)), np.abs(m9)), np.abs(m10)),
            np.abs(m11))
    )
    t9 = (
        np.maximum(np.abs(t0 - t1 + (t2 - t3) + (t4 - t5) + (t6 - t7) - 1.0), np.abs((m11 * (m0 +
            m4) - (m8 * (m1 + m5) + m9 * (m2 + m6) + m10 * (m3 + m7))) / t8))
    )
    t10 = (
        np.maximum(np.maximum(t9, np.abs((m0 * m5 - m1 * m4 + m2 * m7 - m3 * m6) * 2.0)), np.abs(2.0
            * (m0 * m6 - m2 * m4 + m3 * m5 - m1 * m7)))
    )
    t11 = (
        np.maximum(1e-05, 1.0 / np.maximum(1.0, t7 + (t5 + (t3 + (t1 + (t6 + (t4 + (t0 + t2))))))))
    )
    return (
        m0,
        m1,
        m2,
        m3,
        m4,
        m5,
        m6,
        m7,
        m8,
        m9,
        m10,
        m11,
        np.maximum(t10, np.abs(2.0 * (m0 * m7 - m3 * m4 + m1 * m6 - m2 * m5))) * t11,
    )


def motor_scale_f32(m: Any) -> tuple[Any, ...]:
    """Rigid motion and scale of a similarity"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = 1.0 / np.sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1)
    t1 = m0 * t0
    t2 = m1 * t0
    t3 = m2 * t0
    t4 = m3 * t0
    t5 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t6 = m0 - m4
    t7 = m3 - m7
    t8 = m6 - m2
    t9 = m1 - m5
    t10 = 1.0 / (t6 * t6 + t7 * t7 + t8 * t8 + t9 * t9)
    t11 = np.where(t5, t6 * t10, m0 + m4)
    t12 = np.where(t5, t7 * t10, m3 + m7)
    t13 = np.where(t5, -(t8 * t10), m2 + m6)
    t14 = np.where(t5, t9 * t10, m1 + m5)
    t15 = m8 * t11 + m9 * t12 - m10 * t13 + m11 * t14
    t16 = t11 * m9 - m8 * t12 + t13 * m11 + m10 * t14
    t17 = m8 * t13 - m9 * t14 + t11 * m10 + t12 * m11
    return (
        t1,
        t2,
        t3,
        t4,
        t1 * t15 - t4 * t16 + t3 * t17,
        t4 * t15 + t1 * t16 - t2 * t17,
        t2 * t16 - t3 * t15 + t1 * t17,
        t2 * t15 + t4 * t17 + t3 * t16,
        t11 * t11 + t12 * t12 + t13 * t13 + t14 * t14,
    )


def motor_scale_f64(m: Any) -> tuple[Any, ...]:
    """Rigid motion and scale of a similarity"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = 1.0 / np.sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1)
    t1 = m0 * t0
    t2 = m1 * t0
    t3 = m2 * t0
    t4 = m3 * t0
    t5 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t6 = m0 - m4
    t7 = m3 - m7
    t8 = m6 - m2
    t9 = m1 - m5
    t10 = 1.0 / (t6 * t6 + t7 * t7 + t8 * t8 + t9 * t9)
    t11 = np.where(t5, t6 * t10, m0 + m4)
    t12 = np.where(t5, t7 * t10, m3 + m7)
    t13 = np.where(t5, -(t8 * t10), m2 + m6)
    t14 = np.where(t5, t9 * t10, m1 + m5)
    t15 = m8 * t11 + m9 * t12 - m10 * t13 + m11 * t14
    t16 = t11 * m9 - m8 * t12 + t13 * m11 + m10 * t14
    t17 = m8 * t13 - m9 * t14 + t11 * m10 + t12 * m11
    return (
        t1,
        t2,
        t3,
        t4,
        t1 * t15 - t4 * t16 + t3 * t17,
        t4 * t15 + t1 * t16 - t2 * t17,
        t2 * t16 - t3 * t15 + t1 * t17,
        t2 * t15 + t4 * t17 + t3 * t16,
        t11 * t11 + t12 * t12 + t13 * t13 + t14 * t14,
    )
