"""Kernels of the group rotor_averages: rotor_add_weighted, rotor_add_local.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np


def rotor_add_weighted_f32(s: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of rotors with one more, signed as it is beside the pivot"""
    s0, s1, s2, s3, s4 = (s[..., i] for i in range(5))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
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
        s4 + t1,
    )


def rotor_add_weighted_f64(s: Any, pivot: Any, m: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of rotors with one more, signed as it is beside the pivot"""
    s0, s1, s2, s3, s4 = (s[..., i] for i in range(5))
    pivot0, pivot1, pivot2, pivot3 = (pivot[..., i] for i in range(4))
    m0, m1, m2, m3 = (m[..., i] for i in range(4))
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
        s4 + t1,
    )


def rotor_add_local_f32(s: Any, a: Any, b: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of twists with that from rotor a to b, which turns by at most π"""
    s0, s1, s2 = (s[..., i] for i in range(3))
    a0, a1, a2, a3 = (a[..., i] for i in range(4))
    b0, b1, b2, b3 = (b[..., i] for i in range(4))
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
    return (
        s0 + weight * (-2.0 * (t5 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)))),
        s1 - weight * (-2.0 * (t5 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)))),
        s2 + weight * (-2.0 * (t5 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)))),
    )


def rotor_add_local_f64(s: Any, a: Any, b: Any, weight: Any) -> tuple[Any, ...]:
    """A sum of twists with that from rotor a to b, which turns by at most π"""
    s0, s1, s2 = (s[..., i] for i in range(3))
    a0, a1, a2, a3 = (a[..., i] for i in range(4))
    b0, b1, b2, b3 = (b[..., i] for i in range(4))
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
    return (
        s0 + weight * (-2.0 * (t10 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)))),
        s1 - weight * (-2.0 * (t10 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)))),
        s2 + weight * (-2.0 * (t10 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)))),
    )
