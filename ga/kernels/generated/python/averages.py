"""Kernels of the group averages: add_weighted, add_local.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def add_weighted_f32(s: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of motors with one more, signed as it is beside the pivot"""
    s0, s1, s2, s3, s4, s5, s6, s7, s8 = (s[..., i] for i in range(9))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
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
        s8 + t1,
    )


def add_weighted_f64(s: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of motors with one more, signed as it is beside the pivot"""
    s0, s1, s2, s3, s4, s5, s6, s7, s8 = (s[..., i] for i in range(9))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3, m4, m5, m6, m7 = (m[..., i] for i in range(8))
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
        s8 + t1,
    )


def add_local_f32(s: Any, a: Any, b: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of twists with that from motor a to b, which turns by at most π"""
    s0, s1, s2, s3, s4, s5 = (s[..., i] for i in range(6))
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    weight = weight[..., 0]
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
        s0 + weight * (-2.0 * (t5 * t6)),
        s1 - weight * (-2.0 * (t5 * t7)),
        s2 + weight * (-2.0 * (t5 * t8)),
        s3 + weight * (-2.0 * (t9 + t6 * t12)),
        s4 + weight * (-2.0 * (t13 - t7 * t12)),
        s5 + weight * (-2.0 * (t14 + t8 * t12)),
    )


def add_local_f64(s: Any, a: Any, b: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of twists with that from motor a to b, which turns by at most π"""
    s0, s1, s2, s3, s4, s5 = (s[..., i] for i in range(6))
    a0, a1, a2, a3, a4, a5, a6, a7 = (a[..., i] for i in range(8))
    b0, b1, b2, b3, b4, b5, b6, b7 = (b[..., i] for i in range(8))
    weight = weight[..., 0]
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
        s0 + weight * (-2.0 * (t10 * t11)),
        s1 - weight * (-2.0 * (t10 * t12)),
        s2 + weight * (-2.0 * (t10 * t13)),
        s3 + weight * (-2.0 * (t14 + t11 * t23)),
        s4 + weight * (-2.0 * (t24 - t12 * t23)),
        s5 + weight * (-2.0 * (t25 + t13 * t23)),
    )
