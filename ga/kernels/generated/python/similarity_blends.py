"""Kernels of the group similarity_blends: similarity_normalize, similarity_blend.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.kernels.powers_of_two import exp2_of_integer, exponent


def similarity_normalize_f32(m: Any) -> tuple[Any, ...]:
    """The similarity nearest to an even element, and how well it is defined"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.abs(m2)),
            np.abs(m3)), np.abs(m4))
    )
    t1 = 1.0 - exponent(np.maximum(np.maximum(np.maximum(t0, np.abs(m5)), np.abs(m6)), np.abs(m7)))
    t2 = exp2_of_integer(np.minimum(t1, 127.0))
    t3 = m0 * t2
    t4 = m4 * t2
    t5 = t3 + t4
    t6 = m3 * t2
    t7 = m7 * t2
    t8 = t6 + t7
    t9 = m2 * t2
    t10 = m6 * t2
    t11 = t9 + t10
    t12 = m1 * t2
    t13 = m5 * t2
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
    t42 = t34 * t36
    t43 = t31 * t36
    t44 = t28 * t36
    t45 = t40 * (2.0 * (t3 * t4 + t6 * t7 + t9 * t10 + t12 * t13) / t38)
    t46 = t17 * t37 + t26 * t44 - t30 * t43 + t32 * t42
    t47 = t2 * m8
    t48 = t17 * t44 - t26 * t37 + t30 * t42 + t32 * t43
    t49 = t2 * m9
    t50 = t30 * t37 - t32 * t44 + t17 * t43 + t26 * t42
    t51 = t2 * m10
    t52 = t17 * t42 - (t32 * t37 + t26 * t43) - t30 * t44
    t53 = t2 * m11
    t54 = t40 * (t46 * t47 + t48 * t49 + t50 * t51 - t52 * t53)
    t55 = t40 * (t46 * t53 + t48 * t51 + t47 * t52 - t49 * t50)
    t56 = t40 * (t46 * t51 - t48 * t53 - t47 * t50 - t49 * t52)
    t57 = t40 * (t46 * t49 + t50 * t53 + t51 * t52 - t47 * t48)
    t58 = 2.0 * (t37 * t55 - (t42 * t54 + t44 * t56) + t43 * t57) / np.maximum(t35, 1.1920929e-07)
    return (
        t37 * t41,
        t41 * t42,
        -(t41 * t43),
        t41 * t44,
        t37 * t45,
        t42 * t45,
        -(t43 * t45),
        t44 * t45,
        t54 + t33 * t58,
        t57 - t29 * t58,
        t56 + t27 * t58,
        t55 - t24 * t58,
        np.where((t39 < np.minimum(t15, t22)), t35 * 0.5, np.float32(0.0)),
    )


def similarity_normalize_f64(m: Any) -> tuple[Any, ...]:
    """The similarity nearest to an even element, and how well it is defined"""
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    t0 = (
        np.maximum(np.maximum(np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.abs(m2)),
            np.abs(m3)), np.abs(m4))
    )
    t1 = 1.0 - exponent(np.maximum(np.maximum(np.maximum(t0, np.abs(m5)), np.abs(m6)), np.abs(m7)))
    t2 = exp2_of_integer(np.minimum(t1, 1023.0))
    t3 = m0 * t2
    t4 = m4 * t2
    t5 = t3 + t4
    t6 = m3 * t2
    t7 = m7 * t2
    t8 = t6 + t7
    t9 = m2 * t2
    t10 = m6 * t2
    t11 = t9 + t10
    t12 = m1 * t2
    t13 = m5 * t2
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
    t42 = t34 * t36
    t43 = t31 * t36
    t44 = t28 * t36
    t45 = t40 * (2.0 * (t3 * t4 + t6 * t7 + t9 * t10 + t12 * t13) / t38)
    t46 = t17 * t37 + t26 * t44 - t30 * t43 + t32 * t42
    t47 = t2 * m8
    t48 = t17 * t44 - t26 * t37 + t30 * t42 + t32 * t43
    t49 = t2 * m9
    t50 = t30 * t37 - t32 * t44 + t17 * t43 + t26 * t42
    t51 = t2 * m10
    t52 = t17 * t42 - (t32 * t37 + t26 * t43) - t30 * t44
    t53 = t2 * m11
    t54 = t40 * (t46 * t47 + t48 * t49 + t50 * t51 - t52 * t53)
    t55 = t40 * (t46 * t53 + t48 * t51 + t47 * t52 - t49 * t50)
    t56 = t40 * (t46 * t51 - t48 * t53 - t47 * t50 - t49 * t52)
    t57 = t40 * (t46 * t49 + t50 * t53 + t51 * t52 - t47 * t48)
    t58 = (
        2.0 * (t37 * t55 - (t42 * t54 + t44 * t56) + t43 * t57) / np.maximum(t35,
            2.220446049250313e-16)
    )
    return (
        t37 * t41,
        t41 * t42,
        -(t41 * t43),
        t41 * t44,
        t37 * t45,
        t42 * t45,
        -(t43 * t45),
        t44 * t45,
        t54 + t33 * t58,
        t57 - t29 * t58,
        t56 + t27 * t58,
        t55 - t24 * t58,
        np.where((t39 < np.minimum(t15, t22)), t35 * 0.5, np.float64(0.0)),
    )


def similarity_blend_f32(a: Any, b: Any, fraction: Any) -> tuple[Any, ...]:
    """Linear blend of two similarities, the short way round, made unit"""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    fraction = fraction[..., 0]
    t0 = 1.0 - fraction
    t1 = np.where((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0), -fraction, fraction)
    t2 = t0 * a0 + b0 * t1
    t3 = t0 * a1 + b1 * t1
    t4 = t0 * a2 + b2 * t1
    t5 = t0 * a3 + b3 * t1
    t6 = t0 * a4 + t1 * b4
    t7 = (
        np.maximum(np.maximum(np.maximum(np.maximum(np.abs(t2), np.abs(t3)), np.abs(t4)),
            np.abs(t5)), np.abs(t6))
    )
    t8 = t0 * a5 + t1 * b5
    t9 = t0 * a6 + t1 * b6
    t10 = t0 * a7 + t1 * b7
    t11 = exponent(np.maximum(np.maximum(np.maximum(t7, np.abs(t8)), np.abs(t9)), np.abs(t10)))
    t12 = exp2_of_integer(np.minimum(1.0 - t11, 127.0))
    t13 = t2 * t12
    t14 = t6 * t12
    t15 = t13 + t14
    t16 = t5 * t12
    t17 = t10 * t12
    t18 = t16 + t17
    t19 = t4 * t12
    t20 = t9 * t12
    t21 = t19 + t20
    t22 = t3 * t12
    t23 = t8 * t12
    t24 = t22 + t23
    t25 = np.sqrt(t15 * t15 + t18 * t18 + t21 * t21 + t24 * t24)
    t26 = 1.0 / np.maximum(t25, 1.4210855e-14)
    t27 = t15 * t26
    t28 = t13 - t14
    t29 = t16 - t17
    t30 = t20 - t19
    t31 = t22 - t23
    t32 = np.sqrt(t28 * t28 + t29 * t29 + t30 * t30 + t31 * t31)
    t33 = 1.0 / np.maximum(1.4210855e-14, t32)
    t34 = t28 * t33
    t35 = t27 + t34
    t36 = t18 * t26
    t37 = t29 * t33
    t38 = t36 + t37
    t39 = t30 * t33
    t40 = t21 * t26
    t41 = t39 - t40
    t42 = t24 * t26
    t43 = t31 * t33
    t44 = t42 + t43
    t45 = np.sqrt(t35 * t35 + t38 * t38 + t41 * t41 + t44 * t44)
    t46 = 1.0 / np.maximum(1.4210855e-14, t45)
    t47 = t35 * t46
    t48 = t25 + t32
    t49 = 2.3841858e-07 * np.maximum(t25, t32)
    t50 = 1.0 / np.sqrt(np.maximum(t25, t49) * np.maximum(t32, t49))
    t51 = t48 * (0.5 * t50)
    t52 = t44 * t46
    t53 = t41 * t46
    t54 = t38 * t46
    t55 = t50 * (2.0 * (t13 * t14 + t16 * t17 + t19 * t20 + t22 * t23) / t48)
    t56 = t27 * t47 + t36 * t54 - t40 * t53 + t42 * t52
    t57 = t12 * (t0 * a8 + t1 * b8)
    t58 = t27 * t54 - t36 * t47 + t40 * t52 + t42 * t53
    t59 = t12 * (t0 * a9 + t1 * b9)
    t60 = t40 * t47 - t42 * t54 + t27 * t53 + t36 * t52
    t61 = t12 * (t0 * a10 + t1 * b10)
    t62 = t27 * t52 - (t42 * t47 + t36 * t53) - t40 * t54
    t63 = t12 * (t0 * a11 + t1 * b11)
    t64 = t50 * (t56 * t57 + t58 * t59 + t60 * t61 - t62 * t63)
    t65 = t50 * (t56 * t63 + t58 * t61 + t57 * t62 - t59 * t60)
    t66 = t50 * (t56 * t61 - t58 * t63 - t57 * t60 - t59 * t62)
    t67 = t50 * (t56 * t59 + t60 * t63 + t61 * t62 - t57 * t58)
    t68 = 2.0 * (t47 * t65 - (t52 * t64 + t54 * t66) + t53 * t67) / np.maximum(t45, 1.1920929e-07)
    return (
        t47 * t51,
        t51 * t52,
        -(t51 * t53),
        t51 * t54,
        t47 * t55,
        t52 * t55,
        -(t53 * t55),
        t54 * t55,
        t64 + t43 * t68,
        t67 - t39 * t68,
        t66 + t37 * t68,
        t65 - t34 * t68,
    )


def similarity_blend_f64(a: Any, b: Any, fraction: Any) -> tuple[Any, ...]:
    """Linear blend of two similarities, the short way round, made unit"""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    fraction = fraction[..., 0]
    t0 = 1.0 - fraction
    t1 = np.where((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0), -fraction, fraction)
    t2 = t0 * a0 + b0 * t1
    t3 = t0 * a1 + b1 * t1
    t4 = t0 * a2 + b2 * t1
    t5 = t0 * a3 + b3 * t1
    t6 = t0 * a4 + t1 * b4
    t7 = (
        np.maximum(np.maximum(np.maximum(np.maximum(np.abs(t2), np.abs(t3)), np.abs(t4)),
            np.abs(t5)), np.abs(t6))
    )
    t8 = t0 * a5 + t1 * b5
    t9 = t0 * a6 + t1 * b6
    t10 = t0 * a7 + t1 * b7
    t11 = exponent(np.maximum(np.maximum(np.maximum(t7, np.abs(t8)), np.abs(t9)), np.abs(t10)))
    t12 = exp2_of_integer(np.minimum(1.0 - t11, 1023.0))
    t13 = t2 * t12
    t14 = t6 * t12
    t15 = t13 + t14
    t16 = t5 * t12
    t17 = t10 * t12
    t18 = t16 + t17
    t19 = t4 * t12
    t20 = t9 * t12
    t21 = t19 + t20
    t22 = t3 * t12
    t23 = t8 * t12
    t24 = t22 + t23
    t25 = np.sqrt(t15 * t15 + t18 * t18 + t21 * t21 + t24 * t24)
    t26 = 1.0 / np.maximum(t25, 4.930380657631324e-32)
    t27 = t15 * t26
    t28 = t13 - t14
    t29 = t16 - t17
    t30 = t20 - t19
    t31 = t22 - t23
    t32 = np.sqrt(t28 * t28 + t29 * t29 + t30 * t30 + t31 * t31)
    t33 = 1.0 / np.maximum(4.930380657631324e-32, t32)
    t34 = t28 * t33
    t35 = t27 + t34
    t36 = t18 * t26
    t37 = t29 * t33
    t38 = t36 + t37
    t39 = t30 * t33
    t40 = t21 * t26
    t41 = t39 - t40
    t42 = t24 * t26
    t43 = t31 * t33
    t44 = t42 + t43
    t45 = np.sqrt(t35 * t35 + t38 * t38 + t41 * t41 + t44 * t44)
    t46 = 1.0 / np.maximum(4.930380657631324e-32, t45)
    t47 = t35 * t46
    t48 = t25 + t32
    t49 = 4.440892098500626e-16 * np.maximum(t25, t32)
    t50 = 1.0 / np.sqrt(np.maximum(t25, t49) * np.maximum(t32, t49))
    t51 = t48 * (0.5 * t50)
    t52 = t44 * t46
    t53 = t41 * t46
    t54 = t38 * t46
    t55 = t50 * (2.0 * (t13 * t14 + t16 * t17 + t19 * t20 + t22 * t23) / t48)
    t56 = t27 * t47 + t36 * t54 - t40 * t53 + t42 * t52
    t57 = t12 * (t0 * a8 + t1 * b8)
    t58 = t27 * t54 - t36 * t47 + t40 * t52 + t42 * t53
    t59 = t12 * (t0 * a9 + t1 * b9)
    t60 = t40 * t47 - t42 * t54 + t27 * t53 + t36 * t52
    t61 = t12 * (t0 * a10 + t1 * b10)
    t62 = t27 * t52 - (t42 * t47 + t36 * t53) - t40 * t54
    t63 = t12 * (t0 * a11 + t1 * b11)
    t64 = t50 * (t56 * t57 + t58 * t59 + t60 * t61 - t62 * t63)
    t65 = t50 * (t56 * t63 + t58 * t61 + t57 * t62 - t59 * t60)
    t66 = t50 * (t56 * t61 - t58 * t63 - t57 * t60 - t59 * t62)
    t67 = t50 * (t56 * t59 + t60 * t63 + t61 * t62 - t57 * t58)
    t68 = (
        2.0 * (t47 * t65 - (t52 * t64 + t54 * t66) + t53 * t67) / np.maximum(t45,
            2.220446049250313e-16)
    )
    return (
        t47 * t51,
        t51 * t52,
        -(t51 * t53),
        t51 * t54,
        t47 * t55,
        t52 * t55,
        -(t53 * t55),
        t54 * t55,
        t64 + t43 * t68,
        t67 - t39 * t68,
        t66 + t37 * t68,
        t65 - t34 * t68,
    )
