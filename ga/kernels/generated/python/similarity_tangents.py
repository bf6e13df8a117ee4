"""Kernels of the group similarity_tangents: similarity_adjoint, similarity_transform_twist,
similarity_retract, similarity_local.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.kernels.powers_of_two import exp2_of_integer, exponent


def similarity_adjoint_f32(m: Any) -> tuple[Any, ...]:
    """Adjoint matrix of a similarity on twists"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = m1 + m5
    t1 = m1 - m5
    t2 = t0 * t1
    t3 = m3 + m7
    t4 = m3 - m7
    t5 = t3 * t4
    t6 = m0 + m4
    t7 = m0 - m4
    t8 = t6 * t7
    t9 = m2 + m6
    t10 = m6 - m2
    t11 = t9 * t10
    t12 = t1 * t9
    t13 = t4 * t6
    t14 = t3 * t7
    t15 = t0 * t10
    t16 = t1 * t3
    t17 = t0 * t4
    t18 = t7 * t9
    t19 = t6 * t10
    t20 = t3 * t10
    t21 = t1 * t6
    t22 = t0 * t7
    t23 = t4 * t9
    t24 = t0 * m8
    t25 = t9 * m9
    t26 = t3 * m10
    t27 = t6 * m11
    t28 = t26 + t27
    t29 = t24 * 2.0
    t30 = t25 * 2.0
    t31 = t9 * m8
    t32 = t0 * m9
    t33 = t31 + t32
    t34 = t6 * m10
    t35 = t3 * m11
    t36 = t3 * m8
    t37 = t6 * m9
    t38 = t0 * m10
    t39 = t9 * m11
    t40 = t6 * t6
    t41 = t3 * t3
    t42 = t40 - t41
    t43 = t9 * t9
    t44 = t0 * t0
    t45 = 2.0 * (t3 * t6)
    t46 = 2.0 * (t0 * t9)
    t47 = t0 * t3
    t48 = t6 * t9
    t49 = t9 * m10
    t50 = t6 * m8
    t51 = t3 * m9
    t52 = t50 + t51
    t53 = t0 * m11
    t54 = t3 * t9
    t55 = t0 * t6
    return (
        t2 - t5 + t8 + t11,
        t12 + t13 + t14 - t15,
        t16 + t17 - t18 + t19,
        0.0,
        0.0,
        0.0,
        0.0,
        -(t13 + (t14 + (t15 - t12))),
        -(t5 + (t2 + t11 - t8)),
        t23 - (t20 - t21 - t22),
        0.0,
        0.0,
        0.0,
        0.0,
        t16 + (t17 + t18 - t19),
        t23 - t22 - t20 - t21,
        t11 + (t5 + t8) - t2,
        0.0,
        0.0,
        0.0,
        0.0,
        t29 - t30 - t26 - t27 - t28,
        2.0 * (t33 + t34 - t35),
        2.0 * (t36 - t37 + t38 + t39),
        t42 - t43 + t44,
        t45 + t46,
        2.0 * (t47 - t48),
        2.0 * (t52 + t53 - t49),
        2.0 * (t33 + t35 - t34),
        t30 - t27 - t26 - t29 - t28,
        t52 + (t51 + (t50 + 2.0 * t49) - 2.0 * t53),
        t46 - t45,
        t42 + t43 - t44,
        2.0 * (t54 + t55),
        2.0 * (t37 + (t38 + t39) - t36),
        2.0 * (t38 - t39 + (t36 + t37)),
        2.0 * (t51 + (t49 + t53 - t50)),
        2.0 * (t26 - t27 - t24 - t25),
        2.0 * (t47 + t48),
        2.0 * (t54 - t55),
        t41 + (t40 - (t43 + t44)),
        2.0 * (t31 + (t34 + t35) - t32),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    )


def similarity_adjoint_f64(m: Any) -> tuple[Any, ...]:
    """Adjoint matrix of a similarity on twists"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = m1 + m5
    t1 = m1 - m5
    t2 = t0 * t1
    t3 = m3 + m7
    t4 = m3 - m7
    t5 = t3 * t4
    t6 = m0 + m4
    t7 = m0 - m4
    t8 = t6 * t7
    t9 = m2 + m6
    t10 = m6 - m2
    t11 = t9 * t10
    t12 = t1 * t9
    t13 = t4 * t6
    t14 = t3 * t7
    t15 = t0 * t10
    t16 = t1 * t3
    t17 = t0 * t4
    t18 = t7 * t9
    t19 = t6 * t10
    t20 = t3 * t10
    t21 = t1 * t6
    t22 = t0 * t7
    t23 = t4 * t9
    t24 = t0 * m8
    t25 = t9 * m9
    t26 = t3 * m10
    t27 = t6 * m11
    t28 = t26 + t27
    t29 = t24 * 2.0
    t30 = t25 * 2.0
    t31 = t9 * m8
    t32 = t0 * m9
    t33 = t31 + t32
    t34 = t6 * m10
    t35 = t3 * m11
    t36 = t3 * m8
    t37 = t6 * m9
    t38 = t0 * m10
    t39 = t9 * m11
    t40 = t6 * t6
    t41 = t3 * t3
    t42 = t40 - t41
    t43 = t9 * t9
    t44 = t0 * t0
    t45 = 2.0 * (t3 * t6)
    t46 = 2.0 * (t0 * t9)
    t47 = t0 * t3
    t48 = t6 * t9
    t49 = t9 * m10
    t50 = t6 * m8
    t51 = t3 * m9
    t52 = t50 + t51
    t53 = t0 * m11
    t54 = t3 * t9
    t55 = t0 * t6
    return (
        t2 - t5 + t8 + t11,
        t12 + t13 + t14 - t15,
        t16 + t17 - t18 + t19,
        0.0,
        0.0,
        0.0,
        0.0,
        -(t13 + (t14 + (t15 - t12))),
        -(t5 + (t2 + t11 - t8)),
        t23 - (t20 - t21 - t22),
        0.0,
        0.0,
        0.0,
        0.0,
        t16 + (t17 + t18 - t19),
        t23 - t22 - t20 - t21,
        t11 + (t5 + t8) - t2,
        0.0,
        0.0,
        0.0,
        0.0,
        t29 - t30 - t26 - t27 - t28,
        2.0 * (t33 + t34 - t35),
        2.0 * (t36 - t37 + t38 + t39),
        t42 - t43 + t44,
        t45 + t46,
        2.0 * (t47 - t48),
        2.0 * (t52 + t53 - t49),
        2.0 * (t33 + t35 - t34),
        t30 - t27 - t26 - t29 - t28,
        t52 + (t51 + (t50 + 2.0 * t49) - 2.0 * t53),
        t46 - t45,
        t42 + t43 - t44,
        2.0 * (t54 + t55),
        2.0 * (t37 + (t38 + t39) - t36),
        2.0 * (t38 - t39 + (t36 + t37)),
        2.0 * (t51 + (t49 + t53 - t50)),
        2.0 * (t26 - t27 - t24 - t25),
        2.0 * (t47 + t48),
        2.0 * (t54 - t55),
        t41 + (t40 - (t43 + t44)),
        2.0 * (t31 + (t34 + t35) - t32),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    )


def similarity_transform_twist_f32(m: Any, twist: Any) -> tuple[Any, ...]:
    """A twist seen from the other side of a similarity"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = m3 + m7
    t1 = m2 + m6
    t2 = m1 + m5
    t3 = t0 * twist2 + t1 * twist1 + t2 * twist0
    t4 = m1 - m5
    t5 = m0 + m4
    t6 = t0 * twist0 - twist1 * t5 - twist2 * t2
    t7 = m3 - m7
    t8 = twist0 * t5 - twist2 * t1 + t0 * twist1
    t9 = m0 - m4
    t10 = twist2 * t5 - twist1 * t2 + t1 * twist0
    t11 = m6 - m2
    t12 = twist1 * m10 - twist2 * m9 - twist0 * m11
    t13 = twist2 * m8 - twist1 * m11 - twist0 * m10
    t14 = twist0 * m9 - twist1 * m8 - twist2 * m11
    t15 = twist0 * m8 + twist2 * m10 + twist1 * m9
    t16 = t3 * m8 - t10 * m9 - t6 * m10 - t8 * m11 + (t5 * t12 + t0 * t13 - t1 * t14 + t2 * t15)
    t17 = t5 * twist3 + t0 * twist4 - t1 * twist5
    t18 = t5 * twist4 + t2 * twist5 - t0 * twist3
    t19 = t5 * twist5 + t1 * twist3 - t2 * twist4
    t20 = t0 * twist5 + t2 * twist3 + t1 * twist4
    t21 = (
        t16 + (t5 * t17 + t0 * t18 - t1 * t19 + t2 * t20) - (t1 * m10 - (t5 * m8 + t0 * m9) - t2 *
            m11) * 2.0 * twist6
    )
    t22 = t3 * m9 + t6 * m11 - t8 * m10 + t10 * m8 + (t5 * t13 - t0 * t12 + t1 * t15 + t2 * t14)
    t23 = (
        t22 + (t5 * t18 - t0 * t17 + t1 * t20 + t2 * t19) - twist6 * (2.0 * (t0 * m8 - t5 * m9 - t1
            * m11 - t2 * m10))
    )
    t24 = t3 * m10 - t10 * m11 + t6 * m8 + t8 * m9 + (t1 * t12 - t2 * t13 + t5 * t14 + t0 * t15)
    t25 = (
        t24 + (t1 * t17 - t2 * t18 + t5 * t19 + t0 * t20) - twist6 * (2.0 * (t2 * m9 - t5 * m10 - t0
            * m11 - t1 * m8))
    )
    return (
        t3 * t4 - t6 * t7 + t8 * t9 + t10 * t11,
        -(t3 * t11 - t4 * t10 + t6 * t9 + t7 * t8),
        t3 * t7 + t9 * t10 - t8 * t11 + t4 * t6,
        t21,
        t23,
        t25,
        twist6,
    )


def similarity_transform_twist_f64(m: Any, twist: Any) -> tuple[Any, ...]:
    """A twist seen from the other side of a similarity"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = m3 + m7
    t1 = m2 + m6
    t2 = m1 + m5
    t3 = t0 * twist2 + t1 * twist1 + t2 * twist0
    t4 = m1 - m5
    t5 = m0 + m4
    t6 = t0 * twist0 - twist1 * t5 - twist2 * t2
    t7 = m3 - m7
    t8 = twist0 * t5 - twist2 * t1 + t0 * twist1
    t9 = m0 - m4
    t10 = twist2 * t5 - twist1 * t2 + t1 * twist0
    t11 = m6 - m2
    t12 = twist1 * m10 - twist2 * m9 - twist0 * m11
    t13 = twist2 * m8 - twist1 * m11 - twist0 * m10
    t14 = twist0 * m9 - twist1 * m8 - twist2 * m11
    t15 = twist0 * m8 + twist2 * m10 + twist1 * m9
    t16 = t3 * m8 - t10 * m9 - t6 * m10 - t8 * m11 + (t5 * t12 + t0 * t13 - t1 * t14 + t2 * t15)
    t17 = t5 * twist3 + t0 * twist4 - t1 * twist5
    t18 = t5 * twist4 + t2 * twist5 - t0 * twist3
    t19 = t5 * twist5 + t1 * twist3 - t2 * twist4
    t20 = t0 * twist5 + t2 * twist3 + t1 * twist4
    t21 = (
        t16 + (t5 * t17 + t0 * t18 - t1 * t19 + t2 * t20) - (t1 * m10 - (t5 * m8 + t0 * m9) - t2 *
            m11) * 2.0 * twist6
    )
    t22 = t3 * m9 + t6 * m11 - t8 * m10 + t10 * m8 + (t5 * t13 - t0 * t12 + t1 * t15 + t2 * t14)
    t23 = (
        t22 + (t5 * t18 - t0 * t17 + t1 * t20 + t2 * t19) - twist6 * (2.0 * (t0 * m8 - t5 * m9 - t1
            * m11 - t2 * m10))
    )
    t24 = t3 * m10 - t10 * m11 + t6 * m8 + t8 * m9 + (t1 * t12 - t2 * t13 + t5 * t14 + t0 * t15)
    t25 = (
        t24 + (t1 * t17 - t2 * t18 + t5 * t19 + t0 * t20) - twist6 * (2.0 * (t2 * m9 - t5 * m10 - t0
            * m11 - t1 * m8))
    )
    return (
        t3 * t4 - t6 * t7 + t8 * t9 + t10 * t11,
        -(t3 * t11 - t4 * t10 + t6 * t9 + t7 * t8),
        t3 * t7 + t9 * t10 - t8 * t11 + t4 * t6,
        t21,
        t23,
        t25,
        twist6,
    )


def similarity_retract_f32(m: Any, twist: Any) -> tuple[Any, ...]:
    """A similarity moved by a twist in its own frame"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = -0.5 * twist0
    t1 = -0.5 * twist1
    t2 = -0.5 * twist2
    t3 = t0 * t0 + t1 * t1 + t2 * t2
    t4 = np.sqrt(t3)
    t5 = np.floor(0.31830987 * t4 + 0.5)
    t6 = 1.0 - 2.0 * (t5 - np.floor(0.5 * t5) * 2.0)
    t7 = t4 - t5 * 3.140625 - t5 * 0.0009675026 - t5 * 1.5099067e-07 - t5 * 5.126688e-12
    t8 = t7 * t7
    t9 = t8 * (t8 * (t8 * (-2.6050063e-07 * t8 + 2.4760076e-05) + -0.001388836) + 0.041666634)
    t10 = t6 * (t8 * (t9 + -0.5) + 1.0)
    t11 = np.floor(0.5 + 0.7213475 * twist6)
    t12 = exp2_of_integer(t11)
    t13 = exp2_of_integer(-t11)
    t14 = 0.5 * (t12 + t13)
    t15 = 0.5 * twist6
    t16 = t15 - t11 * 0.69311523 - t11 * 3.1946183e-05
    t17 = t16 * t16
    t18 = t17 * (t17 * (0.0013949076 * t17 + 0.04166621) + 0.5) + 1.0
    t19 = 0.5 * (t12 - t13)
    t20 = t17 * (t17 * (t17 * 0.00019908122 + 0.008333283) + 0.16666667) + 1.0
    t21 = t16 * t20
    t22 = t14 * t18 + t19 * t21
    t23 = t10 * t22
    t24 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06 + -0.00019808991) + 0.00833305) + -0.16666658) + 1.0
    t25 = np.where((t5 < 0.5), t24, t24 * (t6 * t7) / np.maximum(1.0, t4))
    t26 = t2 * t25
    t27 = t22 * t26
    t28 = t1 * t25
    t29 = t22 * t28
    t30 = t0 * t25
    t31 = t22 * t30
    t32 = t18 * t19 + t14 * t21
    t33 = t10 * t32
    t34 = t26 * t32
    t35 = t28 * t32
    t36 = t30 * t32
    t37 = m0 * t23 - m3 * t27 - m2 * t29 - m1 * t31 + (m4 * t33 - m7 * t34 - m6 * t35 - m5 * t36)
    t38 = m0 * t31 - t27 * m2 + t23 * m1 + m3 * t29 + (m4 * t36 - t34 * m6 + t33 * m5 + m7 * t35)
    t39 = m3 * t31 - m0 * t29 - t23 * m2 - t27 * m1 + (m7 * t36 - m4 * t35 - t33 * m6 - t34 * m5)
    t40 = m0 * t27 + t23 * m3 - t29 * m1 + m2 * t31 + (m4 * t34 + t33 * m7 - t35 * m5 + m6 * t36)
    t41 = m0 * t33 - m3 * t34 - m2 * t35 - m1 * t36 + (t23 * m4 - t27 * m7 - t29 * m6 - t31 * m5)
    t42 = m0 * t36 - m2 * t34 + m1 * t33 + m3 * t35 + (t31 * m4 - t27 * m6 + t23 * m5 + t29 * m7)
    t43 = m3 * t36 - m0 * t35 - m2 * t33 - m1 * t34 + (t31 * m7 - t29 * m4 - t23 * m6 - t27 * m5)
    t44 = m0 * t34 + m3 * t33 - m1 * t35 + m2 * t36 + (t27 * m4 + t23 * m7 - t29 * m5 + t31 * m6)
    t45 = m0 + m4
    t46 = -0.5 * twist3
    t47 = np.where((np.abs(t11) < 0.5), t20, np.abs(t32) / np.maximum(np.abs(t15), 0.25))
    t48 = t10 * t47
    t49 = -0.5 * twist4
    t50 = -0.5 * twist5
    t51 = t2 * t49 - t1 * t50
    t52 = t0 * t50 - t2 * t46
    t53 = t1 * t46 - t0 * t49
    t54 = (t22 * t25 - t48) / np.maximum(t3 + t15 * t15, 1.6940659e-21)
    t55 = t46 * t48 + (t15 * t51 - (t2 * t52 - t1 * t53)) * t54
    t56 = m3 + m7
    t57 = t48 * t49 + t54 * (t15 * t52 - (t0 * t53 - t2 * t51))
    t58 = m2 + m6
    t59 = t48 * t50 + t54 * (t15 * t53 - (t1 * t51 - t0 * t52))
    t60 = m1 + m5
    t61 = (t2 * t50 + t0 * t46 + t1 * t49) * (t25 * t47)
    t62 = t23 - t33
    t63 = t27 - t34
    t64 = t35 - t29
    t65 = t31 - t36
    t66 = (
        t45 * t55 + t56 * t57 - t58 * t59 - t60 * t61 + (m8 * t62 - m9 * t63 - m10 * t64 - m11 *
            t65)
    )
    t67 = (
        t45 * t57 - t58 * t61 + t59 * t60 - t55 * t56 + (m8 * t63 + t62 * m9 + t64 * m11 - m10 *
            t65)
    )
    t68 = (
        t45 * t59 - t56 * t61 + t55 * t58 - t57 * t60 + (m8 * t64 + m9 * t65 + t62 * m10 - t63 *
            m11)
    )
    t69 = (
        t45 * t61 + t56 * t59 + t55 * t60 + t57 * t58 + (m8 * t65 + t63 * m10 + t62 * m11 - m9 *
            t64)
    )
    return (
        t37,
        t38,
        -t39,
        t40,
        t41,
        t42,
        -t43,
        t44,
        t66,
        t67,
        t68,
        t69,
    )


def similarity_retract_f64(m: Any, twist: Any) -> tuple[Any, ...]:
    """A similarity moved by a twist in its own frame"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = -0.5 * twist0
    t1 = -0.5 * twist1
    t2 = -0.5 * twist2
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
    t13 = np.floor(0.5 + 0.7213475204444817 * twist6)
    t14 = exp2_of_integer(t13)
    t15 = exp2_of_integer(-t13)
    t16 = 0.5 * (t14 + t15)
    t17 = 0.5 * twist6
    t18 = t17 - t13 * 0.6931471675634384 - t13 * 1.2996506893889889e-08
    t19 = t18 * t18
    t20 = t19 * (t19 * (2.763326749998937e-07 * t19 + 2.480148377847191e-05) + 0.001388888895391314)
    t21 = 1.0 + t19 * (t19 * (t20 + 0.04166666666648207) + 0.5000000000000019)
    t22 = 0.5 * (t14 - t15)
    t23 = t19 * (t19 * 2.5110520415965448e-08 + 2.755723960835094e-06) + 0.00019841269891276224
    t24 = 1.0 + t19 * (t19 * (t19 * t23 + 0.008333333333319138) + 0.16666666666666682)
    t25 = t18 * t24
    t26 = t16 * t21 + t22 * t25
    t27 = t12 * t26
    t28 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) + 1.6058940754212953e-10)
    t29 = (
        t9 * (t9 * (t28 + -2.505210688815946e-08) + 2.755731921120387e-06) + -0.00019841269841208527
    )
    t30 = 1.0 + t9 * (t9 * (t9 * t29 + 0.008333333333333186) + -0.16666666666666666)
    t31 = np.where((t5 < 0.5), t30, t30 * (t6 * t8) / np.maximum(1.0, t4))
    t32 = t2 * t31
    t33 = t26 * t32
    t34 = t1 * t31
    t35 = t26 * t34
    t36 = t0 * t31
    t37 = t26 * t36
    t38 = t21 * t22 + t16 * t25
    t39 = t12 * t38
    t40 = t32 * t38
    t41 = t34 * t38
    t42 = t36 * t38
    t43 = m0 * t27 - m3 * t33 - m2 * t35 - m1 * t37 + (m4 * t39 - m7 * t40 - m6 * t41 - m5 * t42)
    t44 = m0 * t37 - t33 * m2 + t27 * m1 + m3 * t35 + (m4 * t42 - t40 * m6 + t39 * m5 + m7 * t41)
    t45 = m3 * t37 - m0 * t35 - t27 * m2 - t33 * m1 + (m7 * t42 - m4 * t41 - t39 * m6 - t40 * m5)
    t46 = m0 * t33 + t27 * m3 - t35 * m1 + m2 * t37 + (m4 * t40 + t39 * m7 - t41 * m5 + m6 * t42)
    t47 = m0 * t39 - m3 * t40 - m2 * t41 - m1 * t42 + (t27 * m4 - t33 * m7 - t35 * m6 - t37 * m5)
    t48 = m0 * t42 - m2 * t40 + m1 * t39 + m3 * t41 + (t37 * m4 - t33 * m6 + t27 * m5 + t35 * m7)
    t49 = m3 * t42 - m0 * t41 - m2 * t39 - m1 * t40 + (t37 * m7 - t35 * m4 - t27 * m6 - t33 * m5)
    t50 = m0 * t40 + m3 * t39 - m1 * t41 + m2 * t42 + (t33 * m4 + t27 * m7 - t35 * m5 + t37 * m6)
    t51 = m0 + m4
    t52 = -0.5 * twist3
    t53 = np.where((np.abs(t13) < 0.5), t24, np.abs(t38) / np.maximum(np.abs(t17), 0.25))
    t54 = t12 * t53
    t55 = -0.5 * twist4
    t56 = -0.5 * twist5
    t57 = t2 * t55 - t1 * t56
    t58 = t0 * t56 - t2 * t52
    t59 = t1 * t52 - t0 * t55
    t60 = (t26 * t31 - t54) / np.maximum(t3 + t17 * t17, 1.0947644252537633e-47)
    t61 = t52 * t54 + (t17 * t57 - (t2 * t58 - t1 * t59)) * t60
    t62 = m3 + m7
    t63 = t54 * t55 + t60 * (t17 * t58 - (t0 * t59 - t2 * t57))
    t64 = m2 + m6
    t65 = t54 * t56 + t60 * (t17 * t59 - (t1 * t57 - t0 * t58))
    t66 = m1 + m5
    t67 = (t2 * t56 + t0 * t52 + t1 * t55) * (t31 * t53)
    t68 = t27 - t39
    t69 = t33 - t40
    t70 = t41 - t35
    t71 = t37 - t42
    t72 = (
        t51 * t61 + t62 * t63 - t64 * t65 - t66 * t67 + (m8 * t68 - m9 * t69 - m10 * t70 - m11 *
            t71)
    )
    t73 = (
        t51 * t63 - t64 * t67 + t65 * t66 - t61 * t62 + (m8 * t69 + t68 * m9 + t70 * m11 - m10 *
            t71)
    )
    t74 = (
        t51 * t65 - t62 * t67 + t61 * t64 - t63 * t66 + (m8 * t70 + m9 * t71 + t68 * m10 - t69 *
            m11)
    )
    t75 = (
        t51 * t67 + t62 * t65 + t61 * t66 + t63 * t64 + (m8 * t71 + t69 * m10 + t68 * m11 - m9 *
            t70)
    )
    return (
        t43,
        t44,
        -t45,
        t46,
        t47,
        t48,
        -t49,
        t50,
        t72,
        t73,
        t74,
        t75,
    )


def similarity_local_f32(a: Any, b: Any) -> tuple[Any, ...]:
    """The twist, turning by at most π, that takes similarity a to b"""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5 * b5)
    t1 = np.where((t0 < 0.0), np.float32(-1.0), np.float32(1.0))
    t2 = t0 * t1
    t3 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5 + a6 * b5))
    t4 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 * a6 - b7 * a5))
    t5 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 * a6) + a7 * b6))
    t6 = np.sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5)
    t7 = 1.0 / t6
    t8 = t2 * t7
    t9 = 1.0 - t8
    t10 = (
        t9 * (t9 * (t9 * (0.007290418 * t9 + -0.024990348) + 0.04353618) + -0.037681058) +
            0.02876297
    )
    t11 = t9 * (t9 * (t9 * (t9 * (t9 * t10 + 0.00298998) + 0.02730914) + 0.056896698) + 0.13334942)
    t12 = t9 * (t11 + 0.33333293) + 1.0
    t13 = t5 * t7
    t14 = t4 * t7
    t15 = t3 * t7
    t16 = a0 - a4
    t17 = a7 - a3
    t18 = a2 - a6
    t19 = a5 - a1
    t20 = b3 - b7
    t21 = b0 - b4
    t22 = b6 - b2
    t23 = b1 - b5
    t24 = (
        t16 * b8 + t17 * b9 + t18 * b10 - t19 * b11 + (a9 * t20 - a8 * t21 + a10 * t22 - a11 * t23)
    )
    t25 = t1 * t24
    t26 = (
        t16 * b11 + t17 * b10 + b8 * t19 - b9 * t18 + (t21 * a11 - (a8 * t23 + t20 * a10) + a9 *
            t22)
    )
    t27 = t1 * t26
    t28 = t1 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 * a6 + b1 * a5))
    t29 = t1 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 * a5 + b1 * a6))
    t30 = t1 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 * a6 - b3 * a5))
    t31 = t1 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 * a6) + b2 * a7))
    t32 = t8 * t28 + t15 * t29 + t14 * t30 + t13 * t31
    t33 = np.abs(t32)
    t34 = t6 + t33
    t35 = exponent(1.4142135 * t34)
    t36 = (t35 < 0.5)
    t37 = t34 * exp2_of_integer(-t35)
    t38 = np.where(t36, t33, 0.5 * (t37 - 1.0 / t37))
    t39 = t38 * t38
    t40 = t39 * (t39 * (t39 * (0.024318371 * t39 + -0.044006806) + 0.07497201) + -0.16666622) + 1.0
    t41 = (
        np.where(t36, t40, (t35 * 0.69311523 + (t35 * 3.1946183e-05 + t38 * t40)) / np.maximum(t33,
            0.25))
    )
    t42 = (
        t16 * b10 - t17 * b11 - b8 * t18 - b9 * t19 - (a8 * t22 + a9 * t23 + t21 * a10 + t20 * a11)
    )
    t43 = t1 * t42
    t44 = t13 * t43 - t15 * t25
    t45 = (
        t16 * b9 + t18 * b11 + b10 * t19 - b8 * t17 + (t22 * a11 - (t20 * a8 + a9 * t21) + a10 *
            t23)
    )
    t46 = t1 * t45
    t47 = t14 * t25 + t13 * t46
    t48 = 1.0 / np.maximum(t13 * t13 + t14 * t14 + t15 * t15 + t32 * t32, 1.6940659e-21)
    t49 = (t8 * t41 - t6 * t12) * t48
    t50 = t15 * t46 + t14 * t43
    t51 = t48 * (t32 * (t8 * t12 - t6 * t41))
    return (
        -2.0 * (t12 * t13),
        -(-2.0 * (t12 * t14)),
        -2.0 * (t12 * t15),
        -2.0 * ((t8 * t25 + t13 * t27) * t41 + (t15 * t44 - t14 * t47) * t49 + t50 * t51),
        -2.0 * (t41 * (t8 * t46 - t14 * t27) - t49 * (t13 * t47 + t15 * t50) + t44 * t51),
        -2.0 * (t41 * (t8 * t43 + t15 * t27) - t49 * (t14 * t50 + t13 * t44) - t47 * t51),
        2.0 * (t32 * t41),
    )


def similarity_local_f64(a: Any, b: Any) -> tuple[Any, ...]:
    """The twist, turning by at most π, that takes similarity a to b"""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5 * b5)
    t1 = np.where((t0 < 0.0), np.float64(-1.0), np.float64(1.0))
    t2 = t0 * t1
    t3 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5 + a6 * b5))
    t4 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 * a6 - b7 * a5))
    t5 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 * a6) + a7 * b6))
    t6 = np.sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5)
    t7 = 1.0 / t6
    t8 = t2 * t7
    t9 = 1.0 - t8
    t10 = t9 * (t9 * (8.121007252839173e-05 * t9 + -0.0007281273643381516) + 0.0030973904722135883)
    t11 = t9 * (t9 * (t10 + -0.00821750089765482) + 0.015180613767041282) + -0.020647830091351717
    t12 = (
        t9 * (t9 * (t9 * t11 + 0.02139495485791656) + -0.017185237019630522) + 0.010890803896660979
    )
    t13 = (
        t9 * (t9 * (t9 * t12 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273
    )
    t14 = (
        t9 * (t9 * (t9 * t13 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547
    )
    t15 = t9 * (t9 * (t9 * t14 + 0.005327576046333906) + 0.011544042766655997) + 0.02539682388201735
    t16 = t9 * (t9 * (t9 * t15 + 0.0571428571878089) + 0.1333333333326277) + 0.3333333333333377
    t17 = 1.0 + t9 * t16
    t18 = t5 * t7
    t19 = t4 * t7
    t20 = t3 * t7
    t21 = a0 - a4
    t22 = a7 - a3
    t23 = a2 - a6
    t24 = a5 - a1
    t25 = b3 - b7
    t26 = b0 - b4
    t27 = b6 - b2
    t28 = b1 - b5
    t29 = (
        t21 * b8 + t22 * b9 + t23 * b10 - t24 * b11 + (a9 * t25 - a8 * t26 + a10 * t27 - a11 * t28)
    )
    t30 = t1 * t29
    t31 = (
        t21 * b11 + t22 * b10 + b8 * t24 - b9 * t23 + (t26 * a11 - (a8 * t28 + t25 * a10) + a9 *
            t27)
    )
    t32 = t1 * t31
    t33 = t1 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 * a6 + b1 * a5))
    t34 = t1 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 * a5 + b1 * a6))
    t35 = t1 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 * a6 - b3 * a5))
    t36 = t1 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 * a6) + b2 * a7))
    t37 = t8 * t33 + t20 * t34 + t19 * t35 + t18 * t36
    t38 = np.abs(t37)
    t39 = t6 + t38
    t40 = exponent(1.4142135623730951 * t39)
    t41 = (t40 < 0.5)
    t42 = t39 * exp2_of_integer(-t40)
    t43 = np.where(t41, t38, 0.5 * (t42 - 1.0 / t42))
    t44 = t43 * t43
    t45 = t44 * (t44 * (-0.005811206588331519 * t44 + 0.010599129520028859) + -0.01383075592600594)
    t46 = t44 * (t44 * (t45 + 0.017341108627894623) + -0.02237152504384804) + 0.030381923311340625
    t47 = (
        t44 * (t44 * (t44 * t46 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153
    )
    t48 = 1.0 + t44 * t47
    t49 = (
        (t40 * 0.6931471675634384 + (t40 * 1.2996506893889889e-08 + t43 * t48)) / np.maximum(t38,
            0.25)
    )
    t50 = np.where(t41, t48, t49)
    t51 = (
        t21 * b10 - t22 * b11 - b8 * t23 - b9 * t24 - (a8 * t27 + a9 * t28 + t26 * a10 + t25 * a11)
    )
    t52 = t1 * t51
    t53 = t18 * t52 - t20 * t30
    t54 = (
        t21 * b9 + t23 * b11 + b10 * t24 - b8 * t22 + (t27 * a11 - (t25 * a8 + a9 * t26) + a10 *
            t28)
    )
    t55 = t1 * t54
    t56 = t19 * t30 + t18 * t55
    t57 = 1.0 / np.maximum(t18 * t18 + t19 * t19 + t20 * t20 + t37 * t37, 1.0947644252537633e-47)
    t58 = (t8 * t50 - t6 * t17) * t57
    t59 = t20 * t55 + t19 * t52
    t60 = t57 * (t37 * (t8 * t17 - t6 * t50))
    return (
        -2.0 * (t17 * t18),
        -(-2.0 * (t17 * t19)),
        -2.0 * (t17 * t20),
        -2.0 * ((t8 * t30 + t18 * t32) * t50 + (t20 * t53 - t19 * t56) * t58 + t59 * t60),
        -2.0 * (t50 * (t8 * t55 - t19 * t32) - t58 * (t18 * t56 + t20 * t59) + t53 * t60),
        -2.0 * (t50 * (t8 * t52 + t20 * t32) - t58 * (t19 * t59 + t18 * t53) - t56 * t60),
        2.0 * (t37 * t50),
    )
