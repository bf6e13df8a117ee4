"""Kernels of the group rotor_conversions: rotor_apply, rotor_matrix33, rotor_of_matrix33,
rotor_of_coefficients, rotor_of_quaternion, rotor_normalize.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def rotor_apply_f32(r: Any, x: Any) -> tuple[Any, ...]:
    """Vectors turned by rotors: ``x + 2 v×(v×x) - 2 w v×x``, whose small turns lose nothing"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    x0, x1, x2 = (x[..., i] for i in range(3))
    t0 = r1 * x1 - x0 * r2
    t1 = x0 * r3 - r1 * x2
    t2 = r2 * x2 - x1 * r3
    return (
        x0 + (r2 * t0 - r3 * t1 - r0 * t2) * 2.0,
        x1 + 2.0 * (r3 * t2 - r1 * t0 - t1 * r0),
        x2 + 2.0 * (r1 * t1 - r2 * t2 - t0 * r0),
    )


def rotor_apply_f64(r: Any, x: Any) -> tuple[Any, ...]:
    """Vectors turned by rotors: ``x + 2 v×(v×x) - 2 w v×x``, whose small turns lose nothing"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    x0, x1, x2 = (x[..., i] for i in range(3))
    t0 = r1 * x1 - x0 * r2
    t1 = x0 * r3 - r1 * x2
    t2 = r2 * x2 - x1 * r3
    return (
        x0 + (r2 * t0 - r3 * t1 - r0 * t2) * 2.0,
        x1 + 2.0 * (r3 * t2 - r1 * t0 - t1 * r0),
        x2 + 2.0 * (r1 * t1 - r2 * t2 - t0 * r0),
    )


def rotor_matrix33_f32(r: Any) -> tuple[Any, ...]:
    """3×3 matrix of a rotor, by rows"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0 = r2 * r2
    t1 = r3 * r3
    t2 = r2 * r1
    t3 = r3 * r0
    t4 = r3 * r1
    t5 = r2 * r0
    t6 = r1 * r1
    t7 = r2 * r3
    t8 = r1 * r0
    return (
        1.0 - (t0 + t1) * 2.0,
        2.0 * (t2 + t3),
        2.0 * (t4 - t5),
        2.0 * (t2 - t3),
        1.0 - 2.0 * (t1 + t6),
        2.0 * (t7 + t8),
        2.0 * (t4 + t5),
        2.0 * (t7 - t8),
        1.0 - 2.0 * (t0 + t6),
    )


def rotor_matrix33_f64(r: Any) -> tuple[Any, ...]:
    """3×3 matrix of a rotor, by rows"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0 = r2 * r2
    t1 = r3 * r3
    t2 = r2 * r1
    t3 = r3 * r0
    t4 = r3 * r1
    t5 = r2 * r0
    t6 = r1 * r1
    t7 = r2 * r3
    t8 = r1 * r0
    return (
        1.0 - (t0 + t1) * 2.0,
        2.0 * (t2 + t3),
        2.0 * (t4 - t5),
        2.0 * (t2 - t3),
        1.0 - 2.0 * (t1 + t6),
        2.0 * (t7 + t8),
        2.0 * (t4 + t5),
        2.0 * (t7 - t8),
        1.0 - 2.0 * (t0 + t6),
    )


def rotor_of_matrix33_f32(m: Any) -> tuple[Any, ...]:
    """Rotor of a rotation matrix by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8 = (m[..., i] for i in range(9))
    t0 = 1.0 - m0
    t1 = t0 - m4 + m8
    t2 = t0 + m4 - m8
    t3 = (t1 <= t2)
    t4 = 1.0 + m0
    t5 = t4 - m4 - m8
    t6 = m8 + (m4 + t4)
    t7 = (t5 <= t6)
    t8 = (np.where(t3, t2, t1) <= np.where(t7, t6, t5))
    t9 = m7 - m5
    t10 = m2 - m6
    t11 = m3 - m1
    t12 = np.where(t8, np.where(t7, t6, t9), np.where(t3, t10, t11))
    t13 = m3 + m1
    t14 = m2 + m6
    t15 = np.where(t8, np.where(t7, t9, t5), np.where(t3, t13, t14))
    t16 = m7 + m5
    t17 = np.where(t8, np.where(t7, t10, t13), np.where(t3, t2, t16))
    t18 = np.where(t8, np.where(t7, t11, t14), np.where(t3, t16, t1))
    t19 = 1.0 / np.sqrt(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18)
    t20 = (m0 * (m4 * m8 - m7 * m5) + m3 * (m7 * m2 - m8 * m1) + m6 * (m5 * m1 - m4 * m2) < 0.0)
    t21 = (
        np.abs(m0 * m0 + m3 * m3 + m6 * m6 - 1.0) + np.abs(m0 * m1 + m4 * m3 + m7 * m6) + np.abs(m0
            * m2 + m5 * m3 + m8 * m6)
    )
    t22 = t21 + np.abs(m1 * m1 + m4 * m4 + m7 * m7 - 1.0) + np.abs(m2 * m1 + m4 * m5 + m8 * m7)
    return (
        t12 * t19,
        -(t15 * t19),
        -(t17 * t19),
        -(t18 * t19),
        np.where(t20, np.float32(4.0), t22 + np.abs(m2 * m2 + m5 * m5 + m8 * m8 - 1.0)),
    )


def rotor_of_matrix33_f64(m: Any) -> tuple[Any, ...]:
    """Rotor of a rotation matrix by rows"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8 = (m[..., i] for i in range(9))
    t0 = 1.0 - m0
    t1 = t0 - m4 + m8
    t2 = t0 + m4 - m8
    t3 = (t1 <= t2)
    t4 = 1.0 + m0
    t5 = t4 - m4 - m8
    t6 = m8 + (m4 + t4)
    t7 = (t5 <= t6)
    t8 = (np.where(t3, t2, t1) <= np.where(t7, t6, t5))
    t9 = m7 - m5
    t10 = m2 - m6
    t11 = m3 - m1
    t12 = np.where(t8, np.where(t7, t6, t9), np.where(t3, t10, t11))
    t13 = m3 + m1
    t14 = m2 + m6
    t15 = np.where(t8, np.where(t7, t9, t5), np.where(t3, t13, t14))
    t16 = m7 + m5
    t17 = np.where(t8, np.where(t7, t10, t13), np.where(t3, t2, t16))
    t18 = np.where(t8, np.where(t7, t11, t14), np.where(t3, t16, t1))
    t19 = 1.0 / np.sqrt(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18)
    t20 = (m0 * (m4 * m8 - m7 * m5) + m3 * (m7 * m2 - m8 * m1) + m6 * (m5 * m1 - m4 * m2) < 0.0)
    t21 = (
        np.abs(m0 * m0 + m3 * m3 + m6 * m6 - 1.0) + np.abs(m0 * m1 + m4 * m3 + m7 * m6) + np.abs(m0
            * m2 + m5 * m3 + m8 * m6)
    )
    t22 = t21 + np.abs(m1 * m1 + m4 * m4 + m7 * m7 - 1.0) + np.abs(m2 * m1 + m4 * m5 + m8 * m7)
    return (
        t12 * t19,
        -(t15 * t19),
        -(t17 * t19),
        -(t18 * t19),
        np.where(t20, np.float64(4.0), t22 + np.abs(m2 * m2 + m5 * m5 + m8 * m8 - 1.0)),
    )


def rotor_of_coefficients_f32(r: Any) -> tuple[Any, ...]:
    """The same numbers, and how far they are from a rotor's"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    return (
        r0,
        r1,
        r2,
        r3,
        np.abs(np.sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3) - 1.0),
    )


def rotor_of_coefficients_f64(r: Any) -> tuple[Any, ...]:
    """The same numbers, and how far they are from a rotor's"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    return (
        r0,
        r1,
        r2,
        r3,
        np.abs(np.sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3) - 1.0),
    )


def rotor_of_quaternion_f32(q: Any) -> tuple[Any, ...]:
    """Rotor of a unit quaternion"""
    q0, q1, q2, q3 = (q[..., i] for i in range(4))
    return (
        q0,
        -q1,
        -q2,
        -q3,
        np.abs(np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0),
    )


def rotor_of_quaternion_f64(q: Any) -> tuple[Any, ...]:
    """Rotor of a unit quaternion"""
    q0, q1, q2, q3 = (q[..., i] for i in range(4))
    return (
        q0,
        -q1,
        -q2,
        -q3,
        np.abs(np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0),
    )


def rotor_normalize_f32(r: Any) -> tuple[Any, ...]:
    """The rotor nearest to an even element, divided by its largest coefficient first"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0 = np.maximum(np.maximum(np.maximum(np.abs(r0), np.abs(r1)), np.abs(r2)), np.abs(r3))
    t1 = 1.0 / t0
    t2 = r0 * t1
    t3 = r1 * t1
    t4 = r2 * t1
    t5 = r3 * t1
    t6 = 1.0 / np.sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5)
    return (
        t2 * t6,
        t3 * t6,
        t4 * t6,
        t5 * t6,
        t0,
    )


def rotor_normalize_f64(r: Any) -> tuple[Any, ...]:
    """The rotor nearest to an even element, divided by its largest coefficient first"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0 = np.maximum(np.maximum(np.maximum(np.abs(r0), np.abs(r1)), np.abs(r2)), np.abs(r3))
    t1 = 1.0 / t0
    t2 = r0 * t1
    t3 = r1 * t1
    t4 = r2 * t1
    t5 = r3 * t1
    t6 = 1.0 / np.sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5)
    return (
        t2 * t6,
        t3 * t6,
        t4 * t6,
        t5 * t6,
        t0,
    )
