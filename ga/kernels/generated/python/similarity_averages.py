"""Kernels of the group similarity_averages: similarity_add_weighted, similarity_add_local.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.kernels.powers_of_two import exp2_of_integer, exponent


def similarity_add_weighted_f32(s: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of similarities with one more, signed as it is beside the pivot"""
    s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11, s12 = (s[..., i] for i in range(13))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    weight = weight[..., 0]
    t0 = np.where((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0), -weight, weight)
    t1 = (
        np.abs(weight) * np.maximum(np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.abs(m2)),
            np.abs(m3))
    )
    return (
        s0 + m0 * t0,
        s1 + m1 * t0,
        s2 + m2 * t0,
        s3 + m3 * t0,
        s4 + t0 * m4,
        s5 + t0 * m5,
        s6 + t0 * m6,
        s7 + t0 * m7,
        s8 + t0 * m8,
        s9 + t0 * m9,
        s10 + t0 * m10,
        s11 + t0 * m11,
        s12 + t1,
    )


def similarity_add_weighted_f64(s: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of similarities with one more, signed as it is beside the pivot"""
    s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11, s12 = (s[..., i] for i in range(13))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11 = (m[..., i] for i in range(12))
    weight = weight[..., 0]
    t0 = np.where((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0), -weight, weight)
    t1 = (
        np.abs(weight) * np.maximum(np.maximum(np.maximum(np.abs(m0), np.abs(m1)), np.abs(m2)),
            np.abs(m3))
    )
    return (
        s0 + m0 * t0,
        s1 + m1 * t0,
        s2 + m2 * t0,
        s3 + m3 * t0,
        s4 + t0 * m4,
        s5 + t0 * m5,
        s6 + t0 * m6,
        s7 + t0 * m7,
        s8 + t0 * m8,
        s9 + t0 * m9,
        s10 + t0 * m10,
        s11 + t0 * m11,
        s12 + t1,
    )


def similarity_add_local_f32(s: Any, a: Any, b: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of twists with that from similarity a to b, which turns by at most π"""
    s0, s1, s2, s3, s4, s5, s6 = (s[..., i] for i in range(7))
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    weight = weight[..., 0]
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
    t52 = (
        weight * (-2.0 * ((t8 * t25 + t13 * t27) * t41 + (t15 * t44 - t14 * t47) * t49 + t50 * t51))
    )
    t53 = (
        weight * (-2.0 * (t41 * (t8 * t46 - t14 * t27) - t49 * (t13 * t47 + t15 * t50) + t44 * t51))
    )
    t54 = (
        weight * (-2.0 * (t41 * (t8 * t43 + t15 * t27) - t49 * (t14 * t50 + t13 * t44) - t47 * t51))
    )
    return (
        s0 + weight * (-2.0 * (t12 * t13)),
        s1 - weight * (-2.0 * (t12 * t14)),
        s2 + weight * (-2.0 * (t12 * t15)),
        s3 + t52,
        s4 + t53,
        s5 + t54,
        s6 + weight * (2.0 * (t32 * t41)),
    )


def similarity_add_local_f64(s: Any, a: Any, b: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of twists with that from similarity a to b, which turns by at most π"""
    s0, s1, s2, s3, s4, s5, s6 = (s[..., i] for i in range(7))
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11 = (a[..., i] for i in range(12))
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (b[..., i] for i in range(12))
    weight = weight[..., 0]
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
    t61 = (
        weight * (-2.0 * ((t8 * t30 + t18 * t32) * t50 + (t20 * t53 - t19 * t56) * t58 + t59 * t60))
    )
    t62 = (
        weight * (-2.0 * (t50 * (t8 * t55 - t19 * t32) - t58 * (t18 * t56 + t20 * t59) + t53 * t60))
    )
    t63 = (
        weight * (-2.0 * (t50 * (t8 * t52 + t20 * t32) - t58 * (t19 * t59 + t18 * t53) - t56 * t60))
    )
    return (
        s0 + weight * (-2.0 * (t17 * t18)),
        s1 - weight * (-2.0 * (t17 * t19)),
        s2 + weight * (-2.0 * (t17 * t20)),
        s3 + t61,
        s4 + t62,
        s5 + t63,
        s6 + weight * (2.0 * (t37 * t50)),
    )
