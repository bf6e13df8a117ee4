"""Kernels of the group similarity_conversions: similarity_matrix34, similarity_matrix44,
rotor_translation_scale, similarity_of_motor.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def similarity_matrix34_f32(m: Any) -> tuple[Any, ...]:
    """3×4 matrix of a similarity, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t1 = m0 - m4
    t2 = m3 - m7
    t3 = m6 - m2
    t4 = m1 - m5
    t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4)
    t6 = np.where(t0, t1 * t5, m0 + m4)
    t7 = t6 * t6
    t8 = np.where(t0, t2 * t5, m3 + m7)
    t9 = t8 * t8
    t10 = t7 - t9
    t11 = np.where(t0, -(t3 * t5), m2 + m6)
    t12 = t11 * t11
    t13 = np.where(t0, t4 * t5, m1 + m5)
    t14 = t13 * t13
    t15 = t6 * t8 * 2.0
    t16 = 2.0 * (t11 * t13)
    t17 = t8 * t13
    t18 = t6 * t11
    t19 = t8 * t11
    t20 = t6 * t13
    return (
        t10 - t12 + t14,
        t15 + t16,
        2.0 * (t17 - t18),
        -2.0 * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11),
        t16 - t15,
        t10 + t12 - t14,
        2.0 * (t19 + t20),
        -2.0 * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10),
        2.0 * (t17 + t18),
        2.0 * (t19 - t20),
        t9 + (t7 - (t12 + t14)),
        -2.0 * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11),
    )


def similarity_matrix34_f64(m: Any) -> tuple[Any, ...]:
    """3×4 matrix of a similarity, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t1 = m0 - m4
    t2 = m3 - m7
    t3 = m6 - m2
    t4 = m1 - m5
    t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4)
    t6 = np.where(t0, t1 * t5, m0 + m4)
    t7 = t6 * t6
    t8 = np.where(t0, t2 * t5, m3 + m7)
    t9 = t8 * t8
    t10 = t7 - t9
    t11 = np.where(t0, -(t3 * t5), m2 + m6)
    t12 = t11 * t11
    t13 = np.where(t0, t4 * t5, m1 + m5)
    t14 = t13 * t13
    t15 = t6 * t8 * 2.0
    t16 = 2.0 * (t11 * t13)
    t17 = t8 * t13
    t18 = t6 * t11
    t19 = t8 * t11
    t20 = t6 * t13
    return (
        t10 - t12 + t14,
        t15 + t16,
        2.0 * (t17 - t18),
        -2.0 * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11),
        t16 - t15,
        t10 + t12 - t14,
        2.0 * (t19 + t20),
        -2.0 * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10),
        2.0 * (t17 + t18),
        2.0 * (t19 - t20),
        t9 + (t7 - (t12 + t14)),
        -2.0 * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11),
    )


def similarity_matrix44_f32(m: Any) -> tuple[Any, ...]:
    """4×4 matrix of a similarity, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t1 = m0 - m4
    t2 = m3 - m7
    t3 = m6 - m2
    t4 = m1 - m5
    t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4)
    t6 = np.where(t0, t1 * t5, m0 + m4)
    t7 = t6 * t6
    t8 = np.where(t0, t2 * t5, m3 + m7)
    t9 = t8 * t8
    t10 = t7 - t9
    t11 = np.where(t0, -(t3 * t5), m2 + m6)
    t12 = t11 * t11
    t13 = np.where(t0, t4 * t5, m1 + m5)
    t14 = t13 * t13
    t15 = t6 * t8 * 2.0
    t16 = 2.0 * (t11 * t13)
    t17 = t8 * t13
    t18 = t6 * t11
    t19 = t8 * t11
    t20 = t6 * t13
    return (
        t10 - t12 + t14,
        t15 + t16,
        2.0 * (t17 - t18),
        -2.0 * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11),
        t16 - t15,
        t10 + t12 - t14,
        2.0 * (t19 + t20),
        -2.0 * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10),
        2.0 * (t17 + t18),
        2.0 * (t19 - t20),
        t9 + (t7 - (t12 + t14)),
        -2.0 * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11),
        0.0,
        0.0,
        0.0,
        1.0,
    )


def similarity_matrix44_f64(m: Any) -> tuple[Any, ...]:
    """4×4 matrix of a similarity, by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t1 = m0 - m4
    t2 = m3 - m7
    t3 = m6 - m2
    t4 = m1 - m5
    t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4)
    t6 = np.where(t0, t1 * t5, m0 + m4)
    t7 = t6 * t6
    t8 = np.where(t0, t2 * t5, m3 + m7)
    t9 = t8 * t8
    t10 = t7 - t9
    t11 = np.where(t0, -(t3 * t5), m2 + m6)
    t12 = t11 * t11
    t13 = np.where(t0, t4 * t5, m1 + m5)
    t14 = t13 * t13
    t15 = t6 * t8 * 2.0
    t16 = 2.0 * (t11 * t13)
    t17 = t8 * t13
    t18 = t6 * t11
    t19 = t8 * t11
    t20 = t6 * t13
    return (
        t10 - t12 + t14,
        t15 + t16,
        2.0 * (t17 - t18),
        -2.0 * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11),
        t16 - t15,
        t10 + t12 - t14,
        2.0 * (t19 + t20),
        -2.0 * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10),
        2.0 * (t17 + t18),
        2.0 * (t19 - t20),
        t9 + (t7 - (t12 + t14)),
        -2.0 * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11),
        0.0,
        0.0,
        0.0,
        1.0,
    )


def rotor_translation_scale_f32(m: Any) -> tuple[Any, ...]:
    """Rotor, translation and scale of a similarity"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = 1.0 / np.sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1)
    t1 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t2 = m0 - m4
    t3 = m3 - m7
    t4 = m6 - m2
    t5 = m1 - m5
    t6 = 1.0 / (t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5)
    t7 = np.where(t1, t2 * t6, m0 + m4)
    t8 = np.where(t1, t3 * t6, m3 + m7)
    t9 = np.where(t1, -(t4 * t6), m2 + m6)
    t10 = np.where(t1, t5 * t6, m1 + m5)
    return (
        m0 * t0,
        m1 * t0,
        m2 * t0,
        m3 * t0,
        -2.0 * (m8 * t7 + m9 * t8 - m10 * t9 + m11 * t10),
        -2.0 * (t7 * m9 - m8 * t8 + t9 * m11 + m10 * t10),
        -2.0 * (m8 * t9 - m9 * t10 + t7 * m10 + t8 * m11),
        t7 * t7 + t8 * t8 + t9 * t9 + t10 * t10,
    )


def rotor_translation_scale_f64(m: Any) -> tuple[Any, ...]:
    """Rotor, translation and scale of a similarity"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = 1.0 / np.sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1)
    t1 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0)
    t2 = m0 - m4
    t3 = m3 - m7
    t4 = m6 - m2
    t5 = m1 - m5
    t6 = 1.0 / (t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5)
    t7 = np.where(t1, t2 * t6, m0 + m4)
    t8 = np.where(t1, t3 * t6, m3 + m7)
    t9 = np.where(t1, -(t4 * t6), m2 + m6)
    t10 = np.where(t1, t5 * t6, m1 + m5)
    return (
        m0 * t0,
        m1 * t0,
        m2 * t0,
        m3 * t0,
        -2.0 * (m8 * t7 + m9 * t8 - m10 * t9 + m11 * t10),
        -2.0 * (t7 * m9 - m8 * t8 + t9 * m11 + m10 * t10),
        -2.0 * (m8 * t9 - m9 * t10 + t7 * m10 + t8 * m11),
        t7 * t7 + t8 * t8 + t9 * t9 + t10 * t10,
    )


def similarity_of_motor_f32(m: Any, scale: Any) -> tuple[Any, ...]:
    """Motor after growth about the origin by a scale"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    scale = scale[..., 0]
    t0 = 1.0 / np.sqrt(scale)
    t1 = 0.5 * t0
    t2 = (scale + 1.0) * t1
    t3 = t1 * (scale - 1.0)
    return (
        m0 * t2,
        t2 * m1,
        t2 * m2,
        t2 * m3,
        m0 * t3,
        m1 * t3,
        m2 * t3,
        m3 * t3,
        t0 * m4,
        t0 * m5,
        t0 * m6,
        t0 * m7,
    )


def similarity_of_motor_f64(m: Any, scale: Any) -> tuple[Any, ...]:
    """Motor after growth about the origin by a scale"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    scale = scale[..., 0]
    t0 = 1.0 / np.sqrt(scale)
    t1 = 0.5 * t0
    t2 = (scale + 1.0) * t1
    t3 = t1 * (scale - 1.0)
    return (
        m0 * t2,
        t2 * m1,
        t2 * m2,
        t2 * m3,
        m0 * t3,
        m1 * t3,
        m2 * t3,
        m3 * t3,
        t0 * m4,
        t0 * m5,
        t0 * m6,
        t0 * m7,
    )
