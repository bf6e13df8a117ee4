"""Kernels of the group motor_conversions: translation, of_translation, motor_of,
motor_of_quaternion, motor_of_matrix44, motor_of_dual_quaternion, of_coefficients, project.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def translation_f32(m: Any) -> tuple[Any, ...]:
    """Where a motor takes the origin"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    return (
        -2.0 * (m4 * m0 + m5 * m3 - m6 * m2 + m7 * m1),
        -2.0 * (m0 * m5 - m4 * m3 + m2 * m7 + m6 * m1),
        -2.0 * (m4 * m2 - m5 * m1 + m0 * m6 + m3 * m7),
    )


def translation_f64(m: Any) -> tuple[Any, ...]:
    """Where a motor takes the origin"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    return (
        -2.0 * (m4 * m0 + m5 * m3 - m6 * m2 + m7 * m1),
        -2.0 * (m0 * m5 - m4 * m3 + m2 * m7 + m6 * m1),
        -2.0 * (m4 * m2 - m5 * m1 + m0 * m6 + m3 * m7),
    )


def of_translation_f32(t: Any) -> tuple[Any, ...]:
    """The motor that moves by a translation and turns nothing"""
    t0, t1, t2 = (t[..., i] for i in range(3))
    return (
        1.0,
        0.0,
        0.0,
        0.0,
        -0.5 * t0,
        -0.5 * t1,
        -0.5 * t2,
        0.0,
    )


def of_translation_f64(t: Any) -> tuple[Any, ...]:
    """The motor that moves by a translation and turns nothing"""
    t0, t1, t2 = (t[..., i] for i in range(3))
    return (
        1.0,
        0.0,
        0.0,
        0.0,
        -0.5 * t0,
        -0.5 * t1,
        -0.5 * t2,
        0.0,
    )


def motor_of_f32(r: Any, t: Any) -> tuple[Any, ...]:
    """The motor that turns by a rotor, then moves by a translation"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0, t1, t2 = (t[..., i] for i in range(3))
    t3 = -0.5 * t0
    t4 = -0.5 * t1
    t5 = -0.5 * t2
    return (
        r0,
        r1,
        r2,
        r3,
        r0 * t3 - r3 * t4 + r2 * t5,
        r3 * t3 + r0 * t4 - r1 * t5,
        r1 * t4 - r2 * t3 + r0 * t5,
        r1 * t3 + r3 * t5 + r2 * t4,
    )


def motor_of_f64(r: Any, t: Any) -> tuple[Any, ...]:
    """The motor that turns by a rotor, then moves by a translation"""
    r0, r1, r2, r3 = (r[..., i] for i in range(4))
    t0, t1, t2 = (t[..., i] for i in range(3))
    t3 = -0.5 * t0
    t4 = -0.5 * t1
    t5 = -0.5 * t2
    return (
        r0,
        r1,
        r2,
        r3,
        r0 * t3 - r3 * t4 + r2 * t5,
        r3 * t3 + r0 * t4 - r1 * t5,
        r1 * t4 - r2 * t3 + r0 * t5,
        r1 * t3 + r3 * t5 + r2 * t4,
    )


def motor_of_quaternion_f32(q: Any, t: Any) -> tuple[Any, ...]:
    """The motor that turns by a unit quaternion, then moves by a translation"""
    q0, q1, q2, q3 = (q[..., i] for i in range(4))
    t0, t1, t2 = (t[..., i] for i in range(3))
    t3 = -0.5 * t0
    t4 = -0.5 * t1
    t5 = -0.5 * t2
    return (
        q0,
        -q1,
        -q2,
        -q3,
        q0 * t3 + q3 * t4 - q2 * t5,
        q0 * t4 - q3 * t3 + q1 * t5,
        q2 * t3 - q1 * t4 + q0 * t5,
        -(q1 * t3 + q3 * t5 + q2 * t4),
        np.abs(np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0),
    )


def motor_of_quaternion_f64(q: Any, t: Any) -> tuple[Any, ...]:
    """The motor that turns by a unit quaternion, then moves by a translation"""
    q0, q1, q2, q3 = (q[..., i] for i in range(4))
    t0, t1, t2 = (t[..., i] for i in range(3))
    t3 = -0.5 * t0
    t4 = -0.5 * t1
    t5 = -0.5 * t2
    return (
        q0,
        -q1,
        -q2,
        -q3,
        q0 * t3 + q3 * t4 - q2 * t5,
        q0 * t4 - q3 * t3 + q1 * t5,
        q2 * t3 - q1 * t4 + q0 * t5,
        -(q1 * t3 + q3 * t5 + q2 * t4),
        np.abs(np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0),
    )


def motor_of_matrix44_f32(m: Any) -> tuple[Any, ...]:
    """Motor of a homogeneous matrix by rows; what its last row is off by counts ten times"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15 = (m[..., i] for i in
        range(16))
    t0 = 1.0 - m0
    t1 = t0 - m5 + m10
    t2 = t0 + m5 - m10
    t3 = (t1 <= t2)
    t4 = 1.0 + m0
    t5 = t4 - m5 - m10
    t6 = m10 + (m5 + t4)
    t7 = (t5 <= t6)
    t8 = (np.where(t3, t2, t1) <= np.where(t7, t6, t5))
    t9 = m9 - m6
    t10 = m2 - m8
    t11 = m4 - m1
    t12 = np.where(t8, np.where(t7, t6, t9), np.where(t3, t10, t11))
    t13 = m4 + m1
    t14 = m2 + m8
    t15 = np.where(t8, np.where(t7, t9, t5), np.where(t3, t13, t14))
    t16 = m9 + m6
    t17 = np.where(t8, np.where(t7, t10, t13), np.where(t3, t2, t16))
    t18 = np.where(t8, np.where(t7, t11, t14), np.where(t3, t16, t1))
    t19 = 1.0 / np.sqrt(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18)
    t20 = t12 * t19
    t21 = t15 * t19
    t22 = t17 * t19
    t23 = t18 * t19
    t24 = -0.5 * m3
    t25 = -0.5 * m7
    t26 = -0.5 * m11
    t27 = (m0 * (m5 * m10 - m9 * m6) + m4 * (m9 * m2 - m10 * m1) + m8 * (m6 * m1 - m5 * m2) < 0.0)
    t28 = (
        np.abs(m0 * m0 + m4 * m4 + m8 * m8 - 1.0) + np.abs(m0 * m1 + m5 * m4 + m9 * m8) + np.abs(m0
            * m2 + m6 * m4 + m10 * m8)
    )
    t29 = t28 + np.abs(m1 * m1 + m5 * m5 + m9 * m9 - 1.0) + np.abs(m2 * m1 + m5 * m6 + m10 * m9)
    t30 = (
        np.where(t27, np.float32(4.0), t29 + np.abs(m2 * m2 + m6 * m6 + m10 * m10 - 1.0)) + 10.0 *
            (np.abs(m12) + np.abs(m13) + np.abs(m14) + np.abs(m15 - 1.0))
    )
    return (
        t20,
        -t21,
        -t22,
        -t23,
        t20 * t24 + t23 * t25 - t22 * t26,
        t20 * t25 - t23 * t24 + t21 * t26,
        t22 * t24 - t21 * t25 + t20 * t26,
        -(t21 * t24 + t23 * t26 + t22 * t25),
        t30,
    )


def motor_of_matrix44_f64(m: Any) -> tuple[Any, ...]:
    """Motor of a homogeneous matrix by rows; what its last row is off by counts ten times"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15 = (m[..., i] for i in
        range(16))
    t0 = 1.0 - m0
    t1 = t0 - m5 + m10
    t2 = t0 + m5 - m10
    t3 = (t1 <= t2)
    t4 = 1.0 + m0
    t5 = t4 - m5 - m10
    t6 = m10 + (m5 + t4)
    t7 = (t5 <= t6)
    t8 = (np.where(t3, t2, t1) <= np.where(t7, t6, t5))
    t9 = m9 - m6
    t10 = m2 - m8
    t11 = m4 - m1
    t12 = np.where(t8, np.where(t7, t6, t9), np.where(t3, t10, t11))
    t13 = m4 + m1
    t14 = m2 + m8
    t15 = np.where(t8, np.where(t7, t9, t5), np.where(t3, t13, t14))
    t16 = m9 + m6
    t17 = np.where(t8, np.where(t7, t10, t13), np.where(t3, t2, t16))
    t18 = np.where(t8, np.where(t7, t11, t14), np.where(t3, t16, t1))
    t19 = 1.0 / np.sqrt(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18)
    t20 = t12 * t19
    t21 = t15 * t19
    t22 = t17 * t19
    t23 = t18 * t19
    t24 = -0.5 * m3
    t25 = -0.5 * m7
    t26 = -0.5 * m11
    t27 = (m0 * (m5 * m10 - m9 * m6) + m4 * (m9 * m2 - m10 * m1) + m8 * (m6 * m1 - m5 * m2) < 0.0)
    t28 = (
        np.abs(m0 * m0 + m4 * m4 + m8 * m8 - 1.0) + np.abs(m0 * m1 + m5 * m4 + m9 * m8) + np.abs(m0
            * m2 + m6 * m4 + m10 * m8)
    )
    t29 = t28 + np.abs(m1 * m1 + m5 * m5 + m9 * m9 - 1.0) + np.abs(m2 * m1 + m5 * m6 + m10 * m9)
    t30 = (
        np.where(t27, np.float64(4.0), t29 + np.abs(m2 * m2 + m6 * m6 + m10 * m10 - 1.0)) + 10.0 *
            (np.abs(m12) + np.abs(m13) + np.abs(m14) + np.abs(m15 - 1.0))
    )
    return (
        t20,
        -t21,
        -t22,
        -t23,
        t20 * t24 + t23 * t25 - t22 * t26,
        t20 * t25 - t23 * t24 + t21 * t26,
        t22 * t24 - t21 * t25 + t20 * t26,
        -(t21 * t24 + t23 * t26 + t22 * t25),
        t30,
    )


def motor_of_dual_quaternion_f32(d: Any) -> tuple[Any, ...]:
    """Motor of a unit Hamilton dual quaternion"""
    d0, d1, d2, d3, d4, d5, d6, d7 = (d[..., i] for i in range(8))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(1.0, np.abs(d5)), np.abs(d6)), np.abs(d7)),
            np.abs(d4))
    )
    t1 = (
        np.maximum(np.abs(np.sqrt(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3) - 1.0), np.abs(d0 * d4 +
            (d1 * d5 + d2 * d6 + d3 * d7)) / t0)
    )
    return (
        d0,
        -d1,
        -d2,
        -d3,
        -d5,
        -d6,
        -d7,
        -d4,
        t1,
    )


def motor_of_dual_quaternion_f64(d: Any) -> tuple[Any, ...]:
    """Motor of a unit Hamilton dual quaternion"""
    d0, d1, d2, d3, d4, d5, d6, d7 = (d[..., i] for i in range(8))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(1.0, np.abs(d5)), np.abs(d6)), np.abs(d7)),
            np.abs(d4))
    )
    t1 = (
        np.maximum(np.abs(np.sqrt(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3) - 1.0), np.abs(d0 * d4 +
            (d1 * d5 + d2 * d6 + d3 * d7)) / t0)
    )
    return (
        d0,
        -d1,
        -d2,
        -d3,
        -d5,
        -d6,
        -d7,
        -d4,
        t1,
    )


def of_coefficients_f32(m: Any) -> tuple[Any, ...]:
    """The same numbers, and how far they are from a motor's"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(1.0, np.abs(m4)), np.abs(m5)), np.abs(m6)),
            np.abs(m7))
    )
    t1 = (
        np.maximum(np.abs(np.sqrt(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3) - 1.0), np.abs(m0 * m7 -
            (m1 * m4 + m2 * m5 + m3 * m6)) / t0)
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
        t1,
    )


def of_coefficients_f64(m: Any) -> tuple[Any, ...]:
    """The same numbers, and how far they are from a motor's"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(1.0, np.abs(m4)), np.abs(m5)), np.abs(m6)),
            np.abs(m7))
    )
    t1 = (
        np.maximum(np.abs(np.sqrt(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3) - 1.0), np.abs(m0 * m7 -
            (m1 * m4 + m2 * m5 + m3 * m6)) / t0)
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
        t1,
    )


def project_f32(m: Any) -> tuple[Any, ...]:
    """The motor nearest to an even element, divided by its largest rotor coefficient first"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = np.maximum(np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.abs(m2)), np.abs(m3))
    t1 = 1.0 / t0
    t2 = m0 * t1
    t3 = m3 * t1
    t4 = m2 * t1
    t5 = m1 * t1
    t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5
    t7 = 1.0 / np.sqrt(t6)
    t8 = t1 * m4
    t9 = t1 * m7
    t10 = t1 * m6
    t11 = t1 * m5
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
        t0,
    )


def project_f64(m: Any) -> tuple[Any, ...]:
    """The motor nearest to an even element, divided by its largest rotor coefficient first"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = np.maximum(np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.abs(m2)), np.abs(m3))
    t1 = 1.0 / t0
    t2 = m0 * t1
    t3 = m3 * t1
    t4 = m2 * t1
    t5 = m1 * t1
    t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5
    t7 = 1.0 / np.sqrt(t6)
    t8 = t1 * m4
    t9 = t1 * m7
    t10 = t1 * m6
    t11 = t1 * m5
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
        t0,
    )
