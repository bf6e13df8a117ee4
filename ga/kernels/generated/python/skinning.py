"""Kernels of the group skinning: carry_motor, carry_dual_quaternion, carry_similarity,
carry_matrix.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.kernels.powers_of_two import exp2_of_integer, exponent


def carry_motor_f32(m: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of motors"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = m0 * x0 + m3 * x1 - m2 * x2
    t1 = m0 * x1 + x2 * m1 - x0 * m3
    t2 = m0 * x2 + x0 * m2 - x1 * m1
    t3 = m3 * x2 + x0 * m1 + x1 * m2
    t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7)
    t5 = 1.0 / (m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1)
    t6 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6)
    t7 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7)
    t8 = m0 * n0 + m3 * n1 - m2 * n2
    t9 = m0 * n1 + m1 * n2 - m3 * n0
    t10 = m0 * n2 + m2 * n0 - m1 * n1
    t11 = m3 * n2 + m1 * n0 + m2 * n1
    return (
        t4 * t5,
        t5 * t6,
        t5 * t7,
        t5 * (m0 * t8 + m3 * t9 - m2 * t10 + m1 * t11),
        t5 * (m0 * t9 - m3 * t8 + m2 * t11 + m1 * t10),
        t5 * (m2 * t8 - m1 * t9 + m0 * t10 + m3 * t11),
    )


def carry_motor_f64(m: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of motors"""
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = m0 * x0 + m3 * x1 - m2 * x2
    t1 = m0 * x1 + x2 * m1 - x0 * m3
    t2 = m0 * x2 + x0 * m2 - x1 * m1
    t3 = m3 * x2 + x0 * m1 + x1 * m2
    t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7)
    t5 = 1.0 / (m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1)
    t6 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6)
    t7 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7)
    t8 = m0 * n0 + m3 * n1 - m2 * n2
    t9 = m0 * n1 + m1 * n2 - m3 * n0
    t10 = m0 * n2 + m2 * n0 - m1 * n1
    t11 = m3 * n2 + m1 * n0 + m2 * n1
    return (
        t4 * t5,
        t5 * t6,
        t5 * t7,
        t5 * (m0 * t8 + m3 * t9 - m2 * t10 + m1 * t11),
        t5 * (m0 * t9 - m3 * t8 + m2 * t11 + m1 * t10),
        t5 * (m2 * t8 - m1 * t9 + m0 * t10 + m3 * t11),
    )


def carry_dual_quaternion_f32(q: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of dual quaternions, real wxyz, dual wxyz"""
    q0, q1, q2, q3, q4, q5, q6, q7 = (q[..., i] for i in range(8))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = 2.0 / (q0 * q0 + (q1 * q1 + q2 * q2 + q3 * q3))
    t1 = q1 * x1 - x0 * q2 + q0 * x2
    t2 = x0 * q3 - q1 * x2 + q0 * x1
    t3 = q2 * x2 - q3 * x1 + x0 * q0
    t4 = q1 * n1 - q2 * n0 + q0 * n2
    t5 = q3 * n0 - q1 * n2 + q0 * n1
    t6 = q2 * n2 - q3 * n1 + q0 * n0
    return (
        x0 + t0 * (q2 * t1 - q3 * t2) + t0 * (q0 * q5 - q1 * q4 + (q2 * q7 - q3 * q6)),
        x1 + t0 * (q3 * t3 - q1 * t1) + t0 * (q0 * q6 - q2 * q4 + (q3 * q5 - q1 * q7)),
        x2 + t0 * (q1 * t2 - q2 * t3) + t0 * (q0 * q7 - q3 * q4 + (q1 * q6 - q2 * q5)),
        n0 + t0 * (q2 * t4 - q3 * t5),
        n1 + t0 * (q3 * t6 - q1 * t4),
        n2 + t0 * (q1 * t5 - q2 * t6),
    )


def carry_dual_quaternion_f64(q: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of dual quaternions, real wxyz, dual wxyz"""
    q0, q1, q2, q3, q4, q5, q6, q7 = (q[..., i] for i in range(8))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = 2.0 / (q0 * q0 + (q1 * q1 + q2 * q2 + q3 * q3))
    t1 = q1 * x1 - x0 * q2 + q0 * x2
    t2 = x0 * q3 - q1 * x2 + q0 * x1
    t3 = q2 * x2 - q3 * x1 + x0 * q0
    t4 = q1 * n1 - q2 * n0 + q0 * n2
    t5 = q3 * n0 - q1 * n2 + q0 * n1
    t6 = q2 * n2 - q3 * n1 + q0 * n0
    return (
        x0 + t0 * (q2 * t1 - q3 * t2) + t0 * (q0 * q5 - q1 * q4 + (q2 * q7 - q3 * q6)),
        x1 + t0 * (q3 * t3 - q1 * t1) + t0 * (q0 * q6 - q2 * q4 + (q3 * q5 - q1 * q7)),
        x2 + t0 * (q1 * t2 - q2 * t3) + t0 * (q0 * q7 - q3 * q4 + (q1 * q6 - q2 * q5)),
        n0 + t0 * (q2 * t4 - q3 * t5),
        n1 + t0 * (q3 * t6 - q1 * t4),
        n2 + t0 * (q1 * t5 - q2 * t6),
    )


def carry_similarity_f32(s: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of similarities"""
    s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11 = (s[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(np.abs(s0), np.abs(s1)), np.abs(s2)),
            np.abs(s3)), np.abs(s4))
    )
    t1 = 1.0 - exponent(np.maximum(np.maximum(np.maximum(t0, np.abs(s5)), np.abs(s6)), np.abs(s7)))
    t2 = exp2_of_integer(np.minimum(t1, 127.0))
    t3 = s0 * t2
    t4 = s4 * t2
    t5 = t3 + t4
    t6 = s3 * t2
    t7 = s7 * t2
    t8 = t6 + t7
    t9 = s2 * t2
    t10 = s6 * t2
    t11 = t9 + t10
    t12 = s1 * t2
    t13 = s5 * t2
    t14 = t12 + t13
    t15 = np.sqrt(t5 * t5 + t8 * t8 + t11 * t11 + t14 * t14)
    t16 = 1.0 / np.maximum(t15, 1.4210855e-14)
    t17 = t5 * t16
    t18 = t3 - t4
    t19 = t6 - t7
    t20 = t10 - t9
    t21 = t12 - t13
    t22 = np.sqrt(t18 * t18 + t19 * t19 + t20 * t20 + t21 * t21)
    t23 = 1.0 / np.maximum(1.4210855e-14, t22)
    t24 = t18 * t23
    t25 = t17 + t24
    t26 = t8 * t16
    t27 = t19 * t23
    t28 = t26 + t27
    t29 = t20 * t23
    t30 = t11 * t16
    t31 = t29 - t30
    t32 = t14 * t16
    t33 = t21 * t23
    t34 = t32 + t33
    t35 = np.sqrt(t25 * t25 + t28 * t28 + t31 * t31 + t34 * t34)
    t36 = 1.0 / np.maximum(1.4210855e-14, t35)
    t37 = t25 * t36
    t38 = t15 + t22
    t39 = 2.3841858e-07 * np.maximum(t15, t22)
    t40 = 1.0 / np.sqrt(np.maximum(t15, t39) * np.maximum(t22, t39))
    t41 = t38 * (0.5 * t40)
    t42 = t37 * t41
    t43 = t40 * (2.0 * (t3 * t4 + t6 * t7 + t9 * t10 + t12 * t13) / t38)
    t44 = t37 * t43
    t45 = t28 * t36
    t46 = t41 * t45
    t47 = t43 * t45
    t48 = t31 * t36
    t49 = t41 * t48
    t50 = t43 * t48
    t51 = t34 * t36
    t52 = t41 * t51
    t53 = t43 * t51
    t54 = (t42 * t44 + t46 * t47 + t49 * t50 + t52 * t53 < 0.0)
    t55 = t42 - t44
    t56 = t46 - t47
    t57 = t49 - t50
    t58 = t52 - t53
    t59 = 1.0 / (t55 * t55 + t56 * t56 + t57 * t57 + t58 * t58)
    t60 = np.where(t54, t55 * t59, t42 + t44)
    t61 = np.where(t54, t56 * t59, t46 + t47)
    t62 = np.where(t54, -(t57 * t59), -(t49 + t50))
    t63 = t60 * x0 + t61 * x1 - t62 * x2
    t64 = np.where(t54, t58 * t59, t52 + t53)
    t65 = t60 * x1 + x2 * t64 - x0 * t61
    t66 = t60 * x2 + x0 * t62 - x1 * t64
    t67 = t61 * x2 + x0 * t64 + x1 * t62
    t68 = t17 * t37 + t26 * t45 - t30 * t48 + t32 * t51
    t69 = t2 * s8
    t70 = t17 * t45 - t26 * t37 + t30 * t51 + t32 * t48
    t71 = t2 * s9
    t72 = t30 * t37 - t32 * t45 + t17 * t48 + t26 * t51
    t73 = t2 * s10
    t74 = t17 * t51 - (t32 * t37 + t26 * t48) - t30 * t45
    t75 = t2 * s11
    t76 = t40 * (t68 * t69 + t70 * t71 + t72 * t73 - t74 * t75)
    t77 = t40 * (t68 * t75 + t70 * t73 + t69 * t74 - t71 * t72)
    t78 = t40 * (t68 * t73 - t70 * t75 - t69 * t72 - t71 * t74)
    t79 = t40 * (t68 * t71 + t72 * t75 + t73 * t74 - t69 * t70)
    t80 = 2.0 * (t37 * t77 - (t51 * t76 + t45 * t78) + t48 * t79) / np.maximum(t35, 1.1920929e-07)
    t81 = t76 + t33 * t80
    t82 = t79 - t29 * t80
    t83 = t78 + t27 * t80
    t84 = t77 - t24 * t80
    t85 = (
        t60 * t63 + t61 * t65 - t62 * t66 + t64 * t67 + -2.0 * (t60 * t81 + t61 * t82 - t62 * t83 +
            t64 * t84)
    )
    t86 = (
        t60 * t65 - t61 * t63 + t62 * t67 + t64 * t66 + -2.0 * (t60 * t82 - t61 * t81 + t62 * t84 +
            t64 * t83)
    )
    t87 = (
        t62 * t63 - t64 * t65 + t60 * t66 + t61 * t67 + -2.0 * (t62 * t81 - t64 * t82 + t60 * t83 +
            t61 * t84)
    )
    t88 = t60 * n0 + t61 * n1 - t62 * n2
    t89 = t60 * n1 + t64 * n2 - t61 * n0
    t90 = t60 * n2 + t62 * n0 - t64 * n1
    t91 = t61 * n2 + t64 * n0 + t62 * n1
    t92 = 1.0 / (t60 * t60 + t61 * t61 + t62 * t62 + t64 * t64)
    return (
        t85,
        t86,
        t87,
        (t60 * t88 + t61 * t89 - t62 * t90 + t64 * t91) * t92,
        t92 * (t60 * t89 - t61 * t88 + t62 * t91 + t64 * t90),
        t92 * (t62 * t88 - t64 * t89 + t60 * t90 + t61 * t91),
    )


def carry_similarity_f64(s: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of similarities"""
    s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11 = (s[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(np.abs(s0), np.abs(s1)), np.abs(s2)),
            np.abs(s3)), np.abs(s4))
    )
    t1 = 1.0 - exponent(np.maximum(np.maximum(np.maximum(t0, np.abs(s5)), np.abs(s6)), np.abs(s7)))
    t2 = exp2_of_integer(np.minimum(t1, 1023.0))
    t3 = s0 * t2
    t4 = s4 * t2
    t5 = t3 + t4
    t6 = s3 * t2
    t7 = s7 * t2
    t8 = t6 + t7
    t9 = s2 * t2
    t10 = s6 * t2
    t11 = t9 + t10
    t12 = s1 * t2
    t13 = s5 * t2
    t14 = t12 + t13
    t15 = np.sqrt(t5 * t5 + t8 * t8 + t11 * t11 + t14 * t14)
    t16 = 1.0 / np.maximum(t15, 4.930380657631324e-32)
    t17 = t5 * t16
    t18 = t3 - t4
    t19 = t6 - t7
    t20 = t10 - t9
    t21 = t12 - t13
    t22 = np.sqrt(t18 * t18 + t19 * t19 + t20 * t20 + t21 * t21)
    t23 = 1.0 / np.maximum(4.930380657631324e-32, t22)
    t24 = t18 * t23
    t25 = t17 + t24
    t26 = t8 * t16
    t27 = t19 * t23
    t28 = t26 + t27
    t29 = t20 * t23
    t30 = t11 * t16
    t31 = t29 - t30
    t32 = t14 * t16
    t33 = t21 * t23
    t34 = t32 + t33
    t35 = np.sqrt(t25 * t25 + t28 * t28 + t31 * t31 + t34 * t34)
    t36 = 1.0 / np.maximum(4.930380657631324e-32, t35)
    t37 = t25 * t36
    t38 = t15 + t22
    t39 = 4.440892098500626e-16 * np.maximum(t15, t22)
    t40 = 1.0 / np.sqrt(np.maximum(t15, t39) * np.maximum(t22, t39))
    t41 = t38 * (0.5 * t40)
    t42 = t37 * t41
    t43 = t40 * (2.0 * (t3 * t4 + t6 * t7 + t9 * t10 + t12 * t13) / t38)
    t44 = t37 * t43
    t45 = t28 * t36
    t46 = t41 * t45
    t47 = t43 * t45
    t48 = t31 * t36
    t49 = t41 * t48
    t50 = t43 * t48
    t51 = t34 * t36
    t52 = t41 * t51
    t53 = t43 * t51
    t54 = (t42 * t44 + t46 * t47 + t49 * t50 + t52 * t53 < 0.0)
    t55 = t42 - t44
    t56 = t46 - t47
    t57 = t49 - t50
    t58 = t52 - t53
    t59 = 1.0 / (t55 * t55 + t56 * t56 + t57 * t57 + t58 * t58)
    t60 = np.where(t54, t55 * t59, t42 + t44)
    t61 = np.where(t54, t56 * t59, t46 + t47)
    t62 = np.where(t54, -(t57 * t59), -(t49 + t50))
    t63 = t60 * x0 + t61 * x1 - t62 * x2
    t64 = np.where(t54, t58 * t59, t52 + t53)
    t65 = t60 * x1 + x2 * t64 - x0 * t61
    t66 = t60 * x2 + x0 * t62 - x1 * t64
    t67 = t61 * x2 + x0 * t64 + x1 * t62
    t68 = t17 * t37 + t26 * t45 - t30 * t48 + t32 * t51
    t69 = t2 * s8
    t70 = t17 * t45 - t26 * t37 + t30 * t51 + t32 * t48
    t71 = t2 * s9
    t72 = t30 * t37 - t32 * t45 + t17 * t48 + t26 * t51
    t73 = t2 * s10
    t74 = t17 * t51 - (t32 * t37 + t26 * t48) - t30 * t45
    t75 = t2 * s11
    t76 = t40 * (t68 * t69 + t70 * t71 + t72 * t73 - t74 * t75)
    t77 = t40 * (t68 * t75 + t70 * t73 + t69 * t74 - t71 * t72)
    t78 = t40 * (t68 * t73 - t70 * t75 - t69 * t72 - t71 * t74)
    t79 = t40 * (t68 * t71 + t72 * t75 + t73 * t74 - t69 * t70)
    t80 = (
        2.0 * (t37 * t77 - (t51 * t76 + t45 * t78) + t48 * t79) / np.maximum(t35,
            2.220446049250313e-16)
    )
    t81 = t76 + t33 * t80
    t82 = t79 - t29 * t80
    t83 = t78 + t27 * t80
    t84 = t77 - t24 * t80
    t85 = (
        t60 * t63 + t61 * t65 - t62 * t66 + t64 * t67 + -2.0 * (t60 * t81 + t61 * t82 - t62 * t83 +
            t64 * t84)
    )
    t86 = (
        t60 * t65 - t61 * t63 + t62 * t67 + t64 * t66 + -2.0 * (t60 * t82 - t61 * t81 + t62 * t84 +
            t64 * t83)
    )
    t87 = (
        t62 * t63 - t64 * t65 + t60 * t66 + t61 * t67 + -2.0 * (t62 * t81 - t64 * t82 + t60 * t83 +
            t61 * t84)
    )
    t88 = t60 * n0 + t61 * n1 - t62 * n2
    t89 = t60 * n1 + t64 * n2 - t61 * n0
    t90 = t60 * n2 + t62 * n0 - t64 * n1
    t91 = t61 * n2 + t64 * n0 + t62 * n1
    t92 = 1.0 / (t60 * t60 + t61 * t61 + t62 * t62 + t64 * t64)
    return (
        t85,
        t86,
        t87,
        (t60 * t88 + t61 * t89 - t62 * t90 + t64 * t91) * t92,
        t92 * (t60 * t89 - t61 * t88 + t62 * t91 + t64 * t90),
        t92 * (t62 * t88 - t64 * t89 + t60 * t90 + t61 * t91),
    )


def carry_matrix_f32(m: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of 3×4 matrices"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = m0 * n0 + m1 * n1 + m2 * n2
    t1 = m4 * n0 + m5 * n1 + m6 * n2
    t2 = m8 * n0 + m9 * n1 + m10 * n2
    t3 = 1.0 / np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    return (
        m0 * x0 + m1 * x1 + m2 * x2 + m3,
        x0 * m4 + x1 * m5 + x2 * m6 + m7,
        x0 * m8 + x1 * m9 + x2 * m10 + m11,
        t0 * t3,
        t1 * t3,
        t2 * t3,
    )


def carry_matrix_f64(m: Any, x: Any, n: Any) -> tuple[Any, ...]:
    """A point and a normal carried by a sum of 3×4 matrices"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    x0, x1, x2 = (x[..., i] for i in range(3))
    n0, n1, n2 = (n[..., i] for i in range(3))
    t0 = m0 * n0 + m1 * n1 + m2 * n2
    t1 = m4 * n0 + m5 * n1 + m6 * n2
    t2 = m8 * n0 + m9 * n1 + m10 * n2
    t3 = 1.0 / np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    return (
        m0 * x0 + m1 * x1 + m2 * x2 + m3,
        x0 * m4 + x1 * m5 + x2 * m6 + m7,
        x0 * m8 + x1 * m9 + x2 * m10 + m11,
        t0 * t3,
        t1 * t3,
        t2 * t3,
    )
