"""Kernels of the group rotor_tangents: rotor_adjoint, rotor_transform_twist, rotor_retract,
rotor_local.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def rotor_adjoint_f32(m: Any) -> tuple[Any, ...]:
    """Adjoint matrix of a rotor on twists"""
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
    t0 = m1 * m1
    t1 = m3 * m3
    t2 = m0 * m0
    t3 = m2 * m2
    t4 = m1 * m2
    t5 = m3 * m0
    t6 = m1 * m3
    t7 = m0 * m2
    t8 = m3 * m2
    t9 = m1 * m0
    return (
        t0 - t1 + t2 - t3,
        (t4 + t5) * 2.0,
        2.0 * t6 - 2.0 * t7,
        t4 * 2.0 - t5 * 2.0,
        -(t1 + (t0 - t3 - t2)),
        2.0 * (t8 + t9),
        2.0 * (t6 + t7),
        2.0 * (t8 - t9),
        t1 + t2 - t3 - t0,
    )


def rotor_adjoint_f64(m: Any) -> tuple[Any, ...]:
    """Adjoint matrix of a rotor on twists"""
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
    t0 = m1 * m1
    t1 = m3 * m3
    t2 = m0 * m0
    t3 = m2 * m2
    t4 = m1 * m2
    t5 = m3 * m0
    t6 = m1 * m3
    t7 = m0 * m2
    t8 = m3 * m2
    t9 = m1 * m0
    return (
        t0 - t1 + t2 - t3,
        (t4 + t5) * 2.0,
        2.0 * t6 - 2.0 * t7,
        t4 * 2.0 - t5 * 2.0,
        -(t1 + (t0 - t3 - t2)),
        2.0 * (t8 + t9),
        2.0 * (t6 + t7),
        2.0 * (t8 - t9),
        t1 + t2 - t3 - t0,
    )


def rotor_transform_twist_f32(m: Any, twist: Any) -> tuple[Any, ...]:
    """A twist seen from the other side of a rotor"""
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
    twist0, twist1, twist2 = (twist[..., i] for i in range(3))
    t0 = m3 * twist2 + m2 * twist1 + m1 * twist0
    t1 = m3 * twist0 - twist1 * m0 - twist2 * m1
    t2 = twist0 * m0 - twist2 * m2 + m3 * twist1
    t3 = twist2 * m0 - twist1 * m1 + m2 * twist0
    return (
        m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3,
        -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2),
        m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1,
    )


def rotor_transform_twist_f64(m: Any, twist: Any) -> tuple[Any, ...]:
    """A twist seen from the other side of a rotor"""
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
    twist0, twist1, twist2 = (twist[..., i] for i in range(3))
    t0 = m3 * twist2 + m2 * twist1 + m1 * twist0
    t1 = m3 * twist0 - twist1 * m0 - twist2 * m1
    t2 = twist0 * m0 - twist2 * m2 + m3 * twist1
    t3 = twist2 * m0 - twist1 * m1 + m2 * twist0
    return (
        m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3,
        -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2),
        m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1,
    )


def rotor_retract_f32(m: Any, twist: Any) -> tuple[Any, ...]:
    """A rotor moved by a twist in its own frame"""
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
    twist0, twist1, twist2 = (twist[..., i] for i in range(3))
    t0 = -0.5 * twist2
    t1 = -0.5 * twist1
    t2 = -0.5 * twist0
    t3 = np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    t4 = np.floor(0.31830987 * t3 + 0.5)
    t5 = 1.0 - 2.0 * (t4 - np.floor(0.5 * t4) * 2.0)
    t6 = t3 - t4 * 3.140625 - t4 * 0.0009675026 - t4 * 1.5099067e-07 - t4 * 5.126688e-12
    t7 = t6 * t6
    t8 = t7 * (t7 * (t7 * (-2.6050063e-07 * t7 + 2.4760076e-05) + -0.001388836) + 0.041666634)
    t9 = t5 * (t7 * (t8 + -0.5) + 1.0)
    t10 = t7 * (t7 * (t7 * (t7 * 2.6050482e-06 + -0.00019808991) + 0.00833305) + -0.16666658) + 1.0
    t11 = np.where((t4 < 0.5), t10, t10 * (t5 * t6) / np.maximum(1.0, t3))
    t12 = t0 * t11
    t13 = t1 * t11
    t14 = t2 * t11
    return (
        m0 * t9 - m3 * t12 - m2 * t13 - m1 * t14,
        m0 * t14 - t12 * m2 + t9 * m1 + m3 * t13,
        t12 * m1 - (m3 * t14 - m0 * t13 - t9 * m2),
        m0 * t12 + t9 * m3 - t13 * m1 + m2 * t14,
    )


def rotor_retract_f64(m: Any, twist: Any) -> tuple[Any, ...]:
    """A rotor moved by a twist in its own frame"""
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
    twist0, twist1, twist2 = (twist[..., i] for i in range(3))
    t0 = -0.5 * twist2
    t1 = -0.5 * twist1
    t2 = -0.5 * twist0
    t3 = np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    t4 = np.floor(0.3183098861837907 * t3 + 0.5)
    t5 = 1.0 - 2.0 * (t4 - np.floor(0.5 * t4) * 2.0)
    t6 = t3 - t4 * 3.1415926218032837 - t4 * 3.1786509424591713e-08 - t4 * 1.2246467202362698e-16
    t7 = t6 - t4 * 7.891108333126411e-24
    t8 = t7 * t7
    t9 = t8 * (t8 * (4.608909074888812e-14 * t8 + -1.146289561457958e-11) + 2.0876561604575935e-09)
    t10 = (
        t8 * (t8 * (t9 + -2.7557316386461366e-07) + 2.4801587277366174e-05) + -0.0013888888888772708
    )
    t11 = t5 * (1.0 + t8 * (t8 * (t8 * t10 + 0.041666666666663875) + -0.4999999999999997))
    t12 = t8 * (t8 * (t8 * 2.721539074015491e-15 + -7.643023238169083e-13) + 1.6058940754212953e-10)
    t13 = (
        t8 * (t8 * (t12 + -2.505210688815946e-08) + 2.755731921120387e-06) + -0.00019841269841208527
    )
    t14 = 1.0 + t8 * (t8 * (t8 * t13 + 0.008333333333333186) + -0.16666666666666666)
    t15 = np.where((t4 < 0.5), t14, t14 * (t5 * t7) / np.maximum(1.0, t3))
    t16 = t0 * t15
    t17 = t1 * t15
    t18 = t2 * t15
    return (
        m0 * t11 - m3 * t16 - m2 * t17 - m1 * t18,
        m0 * t18 - t16 * m2 + t11 * m1 + m3 * t17,
        t16 * m1 - (m3 * t18 - m0 * t17 - t11 * m2),
        m0 * t16 + t11 * m3 - t17 * m1 + m2 * t18,
    )


def rotor_local_f32(a: Any, b: Any) -> tuple[Any, ...]:
    """The twist, turning by at most π, that takes rotor a to b"""
    a0, a1, a2, a3 = (a[..., i] for i in range(4))
    b0, b1, b2, b3 = (b[..., i] for i in range(4))
    t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1
    t1 = np.where((t0 < 0.0), np.float32(-1.0), np.float32(1.0))
    t2 = 1.0 - t0 * t1
    t3 = (
        t2 * (t2 * (t2 * (0.007290418 * t2 + -0.024990348) + 0.04353618) + -0.037681058) +
            0.02876297
    )
    t4 = t2 * (t2 * (t2 * (t2 * (t2 * t3 + 0.00298998) + 0.02730914) + 0.056896698) + 0.13334942)
    t5 = t2 * (t4 + 0.33333293) + 1.0
    return (
        -2.0 * (t5 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2))),
        -(-2.0 * (t5 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)))),
        -2.0 * (t5 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1))),
    )


def rotor_local_f64(a: Any, b: Any) -> tuple[Any, ...]:
    """The twist, turning by at most π, that takes rotor a to b"""
    a0, a1, a2, a3 = (a[..., i] for i in range(4))
    b0, b1, b2, b3 = (b[..., i] for i in range(4))
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
    return (
        -2.0 * (t10 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2))),
        -(-2.0 * (t10 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)))),
        -2.0 * (t10 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1))),
    )
