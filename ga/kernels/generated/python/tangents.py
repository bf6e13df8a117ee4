"""Kernels of the group tangents: adjoint, transform_twist, retract, local.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def adjoint_f32(m: Any) -> tuple[Any, ...]:
    """Adjoint matrix of a motor on twists"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m1 * m1
    t1 = m3 * m3
    t2 = m0 * m0
    t3 = m2 * m2
    t4 = m1 * m2
    t5 = m3 * m0
    t6 = t5 * 2.0
    t7 = m1 * m3
    t8 = m0 * m2
    t9 = t4 * 2.0
    t10 = t9 - t6
    t11 = m3 * m2
    t12 = m1 * m0
    t13 = t11 + t12
    t14 = 2.0 * (t7 + t8)
    t15 = t11 - t12
    t16 = m1 * m4
    t17 = m2 * m5
    t18 = m3 * m6
    t19 = m0 * m7
    t20 = m2 * m4 + m1 * m5
    t21 = m0 * m6
    t22 = m3 * m7
    t23 = m3 * m4
    t24 = m0 * m5
    t25 = m1 * m6
    t26 = m2 * m7
    t27 = t2 - t1
    t28 = m3 * m5
    t29 = m1 * m7
    t30 = m2 * m6
    t31 = m0 * m4
    return (
        t0 - t1 + t2 - t3,
        (t4 + t5) * 2.0,
        2.0 * t7 - 2.0 * t8,
        0.0,
        0.0,
        0.0,
        t10,
        -(t1 + (t0 - t3 - t2)),
        t11 + (t12 + t13),
        0.0,
        0.0,
        0.0,
        t14,
        t11 + t15 - t12,
        t1 + t2 - t3 - t0,
        0.0,
        0.0,
        0.0,
        2.0 * (t16 - t17 - t18 - t19),
        2.0 * (t20 + t21 - t22),
        2.0 * (t23 + (t25 + t26) - t24),
        t0 + (t27 - t3),
        t6 + t9,
        2.0 * (t7 - t8),
        2.0 * (t20 + t22 - t21),
        2.0 * (t17 - t19 - t18 - t16),
        2.0 * (t28 + (t30 + t31) - t29),
        t10,
        t3 + t27 - t0,
        t12 + (t11 + t13),
        2.0 * (t25 + (t23 + t24) - t26),
        2.0 * t30 + (2.0 * t28 + 2.0 * t29) - 2.0 * t31,
        2.0 * (t18 - t17 - t16 - t19),
        t14,
        t11 + (t15 - t12),
        t1 + (t2 - (t0 + t3)),
    )


def adjoint_f64(m: Any) -> tuple[Any, ...]:
    """Adjoint matrix of a motor on twists"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    t0 = m1 * m1
    t1 = m3 * m3
    t2 = m0 * m0
    t3 = m2 * m2
    t4 = m1 * m2
    t5 = m3 * m0
    t6 = t5 * 2.0
    t7 = m1 * m3
    t8 = m0 * m2
    t9 = t4 * 2.0
    t10 = t9 - t6
    t11 = m3 * m2
    t12 = m1 * m0
    t13 = t11 + t12
    t14 = 2.0 * (t7 + t8)
    t15 = t11 - t12
    t16 = m1 * m4
    t17 = m2 * m5
    t18 = m3 * m6
    t19 = m0 * m7
    t20 = m2 * m4 + m1 * m5
    t21 = m0 * m6
    t22 = m3 * m7
    t23 = m3 * m4
    t24 = m0 * m5
    t25 = m1 * m6
    t26 = m2 * m7
    t27 = t2 - t1
    t28 = m3 * m5
    t29 = m1 * m7
    t30 = m2 * m6
    t31 = m0 * m4
    return (
        t0 - t1 + t2 - t3,
        (t4 + t5) * 2.0,
        2.0 * t7 - 2.0 * t8,
        0.0,
        0.0,
        0.0,
        t10,
        -(t1 + (t0 - t3 - t2)),
        t11 + (t12 + t13),
        0.0,
        0.0,
        0.0,
        t14,
        t11 + t15 - t12,
        t1 + t2 - t3 - t0,
        0.0,
        0.0,
        0.0,
        2.0 * (t16 - t17 - t18 - t19),
        2.0 * (t20 + t21 - t22),
        2.0 * (t23 + (t25 + t26) - t24),
        t0 + (t27 - t3),
        t6 + t9,
        2.0 * (t7 - t8),
        2.0 * (t20 + t22 - t21),
        2.0 * (t17 - t19 - t18 - t16),
        2.0 * (t28 + (t30 + t31) - t29),
        t10,
        t3 + t27 - t0,
        t12 + (t11 + t13),
        2.0 * (t25 + (t23 + t24) - t26),
        2.0 * t30 + (2.0 * t28 + 2.0 * t29) - 2.0 * t31,
        2.0 * (t18 - t17 - t16 - t19),
        t14,
        t11 + (t15 - t12),
        t1 + (t2 - (t0 + t3)),
    )


def transform_twist_f32(m: Any, twist: Any) -> tuple[Any, ...]:
    """A twist seen from the other side of a motor"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    twist0, twist1, twist2, twist3, twist4, twist5 = (twist[..., i] for i in range(6))
    t0 = m3 * twist2 + m2 * twist1 + m1 * twist0
    t1 = m3 * twist0 - twist1 * m0 - twist2 * m1
    t2 = twist0 * m0 - twist2 * m2 + m3 * twist1
    t3 = twist2 * m0 - twist1 * m1 + m2 * twist0
    t4 = m0 * twist3 + m3 * twist4 - m2 * twist5 - twist2 * m5 + twist1 * m6 - twist0 * m7
    t5 = m0 * twist4 + twist2 * m4 + m1 * twist5 - twist1 * m7 - m3 * twist3 - twist0 * m6
    t6 = m0 * twist5 - twist1 * m4 + twist0 * m5 + m2 * twist3 - m1 * twist4 - twist2 * m7
    t7 = m3 * twist5 + twist0 * m4 + m1 * twist3 + twist2 * m6 + m2 * twist4 + twist1 * m5
    return (
        m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3,
        -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2),
        m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1,
        t0 * m4 - t3 * m5 - t1 * m6 + m0 * t4 - t2 * m7 + m3 * t5 - m2 * t6 + m1 * t7,
        t0 * m5 + t1 * m7 - m3 * t4 - t2 * m6 + m0 * t5 + m2 * t7 + t3 * m4 + m1 * t6,
        t0 * m6 + m2 * t4 - m1 * t5 + m0 * t6 - t3 * m7 + t1 * m4 + t2 * m5 + m3 * t7,
    )


def transform_twist_f64(m: Any, twist: Any) -> tuple[Any, ...]:
    """A twist seen from the other side of a motor"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    twist0, twist1, twist2, twist3, twist4, twist5 = (twist[..., i] for i in range(6))
    t0 = m3 * twist2 + m2 * twist1 + m1 * twist0
    t1 = m3 * twist0 - twist1 * m0 - twist2 * m1
    t2 = twist0 * m0 - twist2 * m2 + m3 * twist1
    t3 = twist2 * m0 - twist1 * m1 + m2 * twist0
    t4 = m0 * twist3 + m3 * twist4 - m2 * twist5 - twist2 * m5 + twist1 * m6 - twist0 * m7
    t5 = m0 * twist4 + twist2 * m4 + m1 * twist5 - twist1 * m7 - m3 * twist3 - twist0 * m6
    t6 = m0 * twist5 - twist1 * m4 + twist0 * m5 + m2 * twist3 - m1 * twist4 - twist2 * m7
    t7 = m3 * twist5 + twist0 * m4 + m1 * twist3 + twist2 * m6 + m2 * twist4 + twist1 * m5
    return (
        m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3,
        -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2),
        m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1,
        t0 * m4 - t3 * m5 - t1 * m6 + m0 * t4 - t2 * m7 + m3 * t5 - m2 * t6 + m1 * t7,
        t0 * m5 + t1 * m7 - m3 * t4 - t2 * m6 + m0 * t5 + m2 * t7 + t3 * m4 + m1 * t6,
        t0 * m6 + m2 * t4 - m1 * t5 + m0 * t6 - t3 * m7 + t1 * m4 + t2 * m5 + m3 * t7,
    )


def retract_f32(m: Any, twist: Any) -> tuple[Any, ...]:
    """A motor moved by a twist in its own frame"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    twist0, twist1, twist2, twist3, twist4, twist5 = (twist[..., i] for i in range(6))
    t0 = -0.5 * twist2
    t1 = -0.5 * twist1
    t2 = -0.5 * twist0
    t3 = t0 * t0 + t1 * t1 + t2 * t2
    t4 = np.sqrt(t3)
    t5 = np.floor(0.31830987 * t4 + 0.5)
    t6 = 1.0 - 2.0 * (t5 - np.floor(0.5 * t5) * 2.0)
    t7 = t4 - t5 * 3.140625 - t5 * 0.0009675026 - t5 * 1.5099067e-07 - t5 * 5.126688e-12
    t8 = t7 * t7
    t9 = t8 * (t8 * (t8 * (-2.6050063e-07 * t8 + 2.4760076e-05) + -0.001388836) + 0.041666634)
    t10 = t6 * (t8 * (t9 + -0.5) + 1.0)
    t11 = (t5 < 0.5)
    t12 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06 + -0.00019808991) + 0.00833305) + -0.16666658) + 1.0
    t13 = np.where(t11, t12, t12 * (t6 * t7) / np.maximum(1.0, t4))
    t14 = t0 * t13
    t15 = t1 * t13
    t16 = t2 * t13
    t17 = -0.5 * twist3
    t18 = t8 * (t8 * (t8 * (t8 * -1.1944519e-07 + 1.1010457e-05) + -0.0005952271) + 0.016666664)
    t19 = -0.5 * twist5
    t20 = -0.5 * twist4
    t21 = 2.0 * (t2 * t17 + (t0 * t19 + t1 * t20))
    t22 = np.where(t11, t18 + -0.16666667, (t10 - t13) / (2.0 * np.maximum(1.0, t3))) * t21
    t23 = t13 * t17 + t2 * t22
    t24 = t13 * t20 + t1 * t22
    t25 = t13 * t19 + t0 * t22
    t26 = t21 * (-0.5 * t13)
    t27 = m0 * t23 + m3 * t24 - m2 * t25 + t10 * m4 + m1 * t26 - t14 * m5 + t15 * m6 - t16 * m7
    t28 = m0 * t24 + m2 * t26 + t14 * m4 + m1 * t25 + t10 * m5 - t15 * m7 - m3 * t23 - t16 * m6
    t29 = m0 * t25 - t15 * m4 + t16 * m5 + t10 * m6 + m3 * t26 + m2 * t23 - m1 * t24 - t14 * m7
    t30 = m3 * t25 - m0 * t26 + t16 * m4 + m1 * t23 + t14 * m6 + t10 * m7 + m2 * t24 + t15 * m5
    return (
        m0 * t10 - m3 * t14 - m2 * t15 - m1 * t16,
        m0 * t16 - t14 * m2 + t10 * m1 + m3 * t15,
        t14 * m1 - (m3 * t16 - m0 * t15 - t10 * m2),
        m0 * t14 + t10 * m3 - t15 * m1 + m2 * t16,
        t27,
        t28,
        t29,
        t30,
    )


def retract_f64(m: Any, twist: Any) -> tuple[Any, ...]:
    """A motor moved by a twist in its own frame"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    twist0, twist1, twist2, twist3, twist4, twist5 = (twist[..., i] for i in range(6))
    t0 = -0.5 * twist2
    t1 = -0.5 * twist1
    t2 = -0.5 * twist0
    t3 = t0 * t0 + t1 * t1 + t2 * t2
    t4 = np.sqrt(t3)
    t5 = np.floor(0.3183098861837907 * t4 + 0.5)
    t6 = 1.0 - 2.0 * (t5 - np.floor(0.5 * t5) * 2.0)
    t7 = t4 - t5 * 3.1415926218032837 - t5 * 3.1786509424591713e-08 - t5 * 1.2246467202362698e-16
    t8 = t7 - t5 * 7.891108333126411e-24
    t9 = t8 * t8
    t10 = t9 * (t9 * (4.608909074888812e-14 * t9 + -1.146289561457958e-11) + 2.0876561604575935e-09)
    t11 = (
        t9 * (t9 * (t10 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708
    )
    t12 = t6 * (1.0 + t9 * (t9 * (t9 * t11 + 0.041666666666663875) + -0.4999999999999997))
    t13 = (t5 < 0.5)
    t14 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) + 1.6058940754212953e-10)
    t15 = (
        t9 * (t9 * (t14 + -2.505210688815946e-08) + 2.755731921120387e-06) + -0.00019841269841208527
    )
    t16 = 1.0 + t9 * (t9 * (t9 * t15 + 0.008333333333333186) + -0.16666666666666666)
    t17 = np.where(t13, t16, t16 * (t6 * t8) / np.maximum(1.0, t4))
    t18 = t0 * t17
    t19 = t1 * t17
    t20 = t2 * t17
    t21 = -0.5 * twist3
    t22 = t9 * (t9 * (t9 * 2.1772370641728367e-14 + -5.350144126598709e-12) + 9.635366495989451e-10)
    t23 = (
        t9 * (t9 * (t22 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574
    )
    t24 = (
        np.where(t13, -0.16666666666666666 + t9 * (t9 * t23 + 0.01666666666666651), (t12 - t17) /
            (2.0 * np.maximum(1.0, t3)))
    )
    t25 = -0.5 * twist5
    t26 = -0.5 * twist4
    t27 = 2.0 * (t2 * t21 + (t0 * t25 + t1 * t26))
    t28 = t24 * t27
    t29 = t17 * t21 + t2 * t28
    t30 = t17 * t26 + t1 * t28
    t31 = t17 * t25 + t0 * t28
    t32 = t27 * (-0.5 * t17)
    t33 = m0 * t29 + m3 * t30 - m2 * t31 + t12 * m4 + m1 * t32 - t18 * m5 + t19 * m6 - t20 * m7
    t34 = m0 * t30 + m2 * t32 + t18 * m4 + m1 * t31 + t12 * m5 - t19 * m7 - m3 * t29 - t20 * m6
    t35 = m0 * t31 - t19 * m4 + t20 * m5 + t12 * m6 + m3 * t32 + m2 * t29 - m1 * t30 - t18 * m7
    t36 = m3 * t31 - m0 * t32 + t20 * m4 + m1 * t29 + t18 * m6 + t12 * m7 + m2 * t30 + t19 * m5
    return (
        m0 * t12 - m3 * t18 - m2 * t19 - m1 * t20,
        m0 * t20 - t18 * m2 + t12 * m1 + m3 * t19,
        t18 * m1 - (m3 * t20 - m0 * t19 - t12 * m2),
        m0 * t18 + t12 * m3 - t19 * m1 + m2 * t20,
        t33,
        t34,
        t35,
        t36,
    )


def local_f32(a: Any, b: Any) -> tuple[Any, ...]:
    """The twist, turning by at most π, that takes motor a to b"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1
    t1 = np.where((t0 < 0.0), np.float32(-1.0), np.float32(1.0))
    t2 = 1.0 - t0 * t1
    t3 = (
        t2 * (t2 * (t2 * (0.007290418 * t2 + -0.024990348) + 0.04353618) + -0.037681058) +
            0.02876297
    )
    t4 = t2 * (t2 * (t2 * (t2 * (t2 * t3 + 0.00298998) + 0.02730914) + 0.056896698) + 0.13334942)
    t5 = t2 * (t4 + 0.33333293) + 1.0
    t6 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)
    t7 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)
    t8 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)
    t9 = t5 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2 * a6 - b1 * a7))
    t10 = (
        t2 * (t2 * (t2 * (t2 * 0.038853493 + -0.15787645) + 0.30586854) + -0.32981494) + 0.24242681
    )
    t11 = t2 * (t2 * (t2 * (t2 * (t2 * t10 + -0.08780976) + 0.06264518) + 0.052127957) + 0.10218229)
    t12 = (
        (t2 * (t2 * (t11 + 0.17139615) + 0.26666737) + 0.33333334) * (t1 * (a0 * b7 - a3 * b6 - b1 *
            a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5 - b2 * a5))
    )
    t13 = (
        t5 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3 * b4 + b1 * a6))
    )
    t14 = (
        t5 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1 * b5 - b3 * a7))
    )
    return (
        -2.0 * (t5 * t6),
        -(-2.0 * (t5 * t7)),
        -2.0 * (t5 * t8),
        -2.0 * (t9 + t6 * t12),
        -2.0 * (t13 - t7 * t12),
        -2.0 * (t14 + t8 * t12),
    )


def local_f64(a: Any, b: Any) -> tuple[Any, ...]:
    """The twist, turning by at most π, that takes motor a to b"""
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1
    t1 = np.where((t0 < 0.0), np.float64(-1.0), np.float64(1.0))
    t2 = 1.0 - t0 * t1
    t3 = t2 * (t2 * (8.121007252839173e-05 * t2 + -0.0007281273643381516) + 0.0030973904722135883)
    t4 = t2 * (t2 * (t3 + -0.00821750089765482) + 0.015180613767041282) + -0.020647830091351717
    t5 = t2 * (t2 * (t2 * t4 + 0.02139495485791656) + -0.017185237019630522) + 0.010890803896660979
    t6 = (
        t2 * (t2 * (t2 * t5 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273
    )
    t7 = (
        t2 * (t2 * (t2 * t6 + 0.0007138968794314861) + 0.0011403814338107978) + 0.002490569286343547
    )
    t8 = t2 * (t2 * (t2 * t7 + 0.005327576046333906) + 0.011544042766655997) + 0.02539682388201735
    t9 = t2 * (t2 * (t2 * (t2 * t8 + 0.0571428571878089) + 0.1333333333326277) + 0.3333333333333377)
    t10 = 1.0 + t9
    t11 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)
    t12 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)
    t13 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)
    t14 = (
        t10 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2 * a6 - b1 * a7))
    )
    t15 = t2 * (t2 * (t2 * 0.0006075023168817953 + -0.006093589939124222) + 0.029004300694938867)
    t16 = (
        t2 * (t2 * (t2 * (t15 + -0.08654292963332932) + 0.18095358835013511) + -0.2810123057357625)
    )
    t17 = t2 * (t2 * (t2 * (t16 + 0.33558766073322116) + -0.3148060210252562) + 0.23526461066915133)
    t18 = t2 * (t2 * (t17 + -0.1409288051389536) + 0.06829876555117628) + -0.026100111052203438
    t19 = (
        t2 * (t2 * (t2 * t18 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829
    )
    t20 = (
        t2 * (t2 * (t2 * t19 + 0.004927059512671586) + 0.009367637463823044) + 0.017404214982763427
    )
    t21 = t2 * (t2 * (t2 * t20 + 0.03196806840632643) + 0.05772005624453496) + 0.10158730162394855
    t22 = t2 * (t2 * (t2 * t21 + 0.17142857142808898) + 0.2666666666666692) + 0.3333333333333333
    t23 = (
        t22 * (t1 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5 - b2 * a5))
    )
    t24 = (
        t10 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3 * b4 + b1 * a6))
    )
    t25 = (
        t10 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1 * b5 - b3 * a7))
    )
    return (
        -2.0 * (t10 * t11),
        -(-2.0 * (t10 * t12)),
        -2.0 * (t10 * t13),
        -2.0 * (t14 + t11 * t23),
        -2.0 * (t24 - t12 * t23),
        -2.0 * (t25 + t13 * t23),
    )
