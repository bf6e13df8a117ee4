"""Kernels of the group similarity_jacobians: similarity_left_jacobian,
similarity_left_jacobian_inverse.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.kernels.powers_of_two import exp2_of_integer


def similarity_left_jacobian_f32(twist: Any) -> tuple[Any, ...]:
    """Left Jacobian of a similarity's exponential at a twist"""
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = twist0 * twist0
    t1 = twist1 * twist1
    t2 = t0 + t1
    t3 = twist2 * twist2
    t4 = t2 + t3
    t5 = 0.25 * t4
    t6 = np.minimum(t5, 2.467401)
    t7 = t6 * (t6 * (t6 * (-1.4276141e-07 * t6 + 6.354456e-06) + -0.00017629226) + 0.0031745604)
    t8 = np.sqrt(t5)
    t9 = np.floor(0.31830987 * t8 + 0.5)
    t10 = (t9 < 0.5)
    t11 = t8 - t9 * 3.140625 - t9 * 0.0009675026 - t9 * 1.5099067e-07 - t9 * 5.126688e-12
    t12 = t11 * t11
    t13 = t12 * (t12 * (t12 * (2.6050482e-06 * t12 + -0.00019808991) + 0.00833305) + -0.16666658)
    t14 = t13 + 1.0
    t15 = 1.0 - 2.0 * (t9 - np.floor(0.5 * t9) * 2.0)
    t16 = np.where(t10, t14, t14 * (t11 * t15) / np.maximum(1.0, t8))
    t17 = t12 * (t12 * (t12 * (t12 * -2.6050063e-07 + 2.4760076e-05) + -0.001388836) + 0.041666634)
    t18 = t15 * (t12 * (t17 + -0.5) + 1.0)
    t19 = (
        np.where((t5 < 2.467401), t6 * (t7 + -0.033333324) + 0.16666667, (1.0 - t16 * t18) / (4.0 *
            np.maximum(t5, 2.467401)))
    )
    t20 = t1 + t3
    t21 = 1.0 - t19 * t20
    t22 = twist0 * twist1
    t23 = t19 * t22
    t24 = t16 * (0.5 * t16)
    t25 = twist2 * t24
    t26 = t23 - t25
    t27 = twist1 * t24
    t28 = twist0 * twist2
    t29 = t19 * t28
    t30 = t27 + t29
    t31 = t23 + t25
    t32 = t0 + t3
    t33 = 1.0 - t19 * t32
    t34 = twist1 * twist2
    t35 = t19 * t34
    t36 = twist0 * t24
    t37 = t35 - t36
    t38 = t29 - t27
    t39 = t35 + t36
    t40 = 1.0 - t2 * t19
    t41 = np.floor(0.5 + twist6 * 1.442695)
    t42 = twist6 - t41 * 0.69311523 - t41 * 3.1946183e-05
    t43 = t42 * (t42 * (t42 * (0.0013941411 * t42 + 0.008375368) + 0.041666348) + 0.16666412) + 0.5
    t44 = exp2_of_integer(t41) * (1.0 + t42 * (t42 * t43 + 1.0))
    t45 = (np.abs(twist6) < 1.0)
    t46 = np.maximum(np.minimum(1.0, twist6), -1.0)
    t47 = t46 * (t46 * (t46 * (t46 * 2.8063823e-06 + 2.5359639e-05) + 0.00019838089) + 0.0013885383)
    t48 = t46 * (t46 * (t46 * (t47 + 0.008333339) + 0.04166674) + 0.16666667) + 0.5
    t49 = 1.0 / np.where((twist6 < 0.0), np.minimum(twist6, -1.0), np.maximum(1.0, twist6))
    t50 = (t44 - 1.0) * t49
    t51 = np.where(t45, 1.0 + t46 * t48, t50)
    t52 = np.where(t45, t48, t49 * (t50 - 1.0))
    t53 = t51 - t52
    t54 = twist6 * twist6
    t55 = 1.0 / np.maximum(t4 + t54, 1.6940659e-21)
    t56 = (twist6 * (t24 * t44 - t53) + t19 * (t4 * t44)) * t55
    t57 = twist1 * twist4
    t58 = twist2 * twist5
    t59 = t54 * t55
    t60 = t53 * t59 + t44 * (1.0 - t59) * (t24 - t19 * twist6)
    t61 = twist1 * twist3
    t62 = twist0 * twist4
    t63 = t61 - t62
    t64 = twist2 * twist3
    t65 = twist0 * twist5
    t66 = t64 - t65
    t67 = twist2 * twist4
    t68 = twist1 * twist5
    t69 = t67 - t68
    t70 = twist0 * t66 + twist1 * t69
    t71 = t51 * twist5 - t60 * t63 + t56 * t70
    t72 = twist0 * t63 - twist2 * t69
    t73 = t51 * twist4 + t60 * t66 + t56 * t72
    t74 = twist0 * 2.0
    t75 = t12 * (t12 * (t12 * (t12 * -1.1944519e-07 + 1.1010457e-05) + -0.0005952271) + 0.016666664)
    t76 = np.where(t10, t75 + -0.16666667, (t18 - t16) / (2.0 * np.maximum(1.0, t5)))
    t77 = 0.25 * (t18 * t76 - t24)
    t78 = t55 * (t44 * (0.5 * (1.0 - t4 * t19) + twist6 * t77) - t60)
    t79 = t55 * (t44 * (0.25 * twist6 * (t16 * t76) - t77) - t56)
    t80 = twist1 * t63 + twist2 * t66
    t81 = t69 * t78 + t79 * t80
    t82 = twist5 * t60
    t83 = twist1 * 2.0
    t84 = twist2 * 2.0
    t85 = twist4 * t60
    t86 = t22 * t56
    t87 = twist2 * t60
    t88 = twist1 * t60
    t89 = t28 * t56
    t90 = t55 * (twist6 * (t60 - t52) + t4 * t56)
    t91 = t55 * (t52 - t60 + twist6 * t56)
    t92 = t51 * twist3 - t60 * t69 - t56 * t80
    t93 = t66 * t78 + t72 * t79
    t94 = twist0 * twist3
    t95 = t60 * twist3
    t96 = t34 * t56
    t97 = twist0 * t60
    t98 = t70 * t79 - t63 * t78
    return (
        t21,
        t26,
        t30,
        0.0,
        0.0,
        0.0,
        0.0,
        t31,
        t33,
        t37,
        0.0,
        0.0,
        0.0,
        0.0,
        t38,
        t39,
        t40,
        0.0,
        0.0,
        0.0,
        0.0,
        t56 * (t57 + t58) - (t31 * t71 - t38 * t73 + t74 * t81),
        t82 - (t33 * t71 - t39 * t73 + t81 * t83) - t56 * (t61 + t63),
        -(t37 * t71 - t40 * t73 + t81 * t84 + t85 + t56 * (t64 + t66)),
        t51 - t20 * t56,
        t86 - t87,
        t88 + t89,
        t80 * t91 - (t52 * twist3 - t69 * t90),
        t21 * t71 - t38 * t92 + t74 * t93 - t82 + t56 * (t63 - t62),
        t26 * t71 - t39 * t92 + t83 * t93 + t56 * (t58 + t94),
        t30 * t71 - t40 * t92 + t84 * t93 + t95 - t56 * (t67 + t69),
        t86 + t87,
        t51 - t32 * t56,
        t96 - t97,
        -(t52 * twist4 + t66 * t90 + t72 * t91),
        t85 + (t74 * t98 - (t21 * t73 - t31 * t92)) + t56 * (t66 - t65),
        t83 * t98 - (t26 * t73 - t33 * t92) - t95 + t56 * (t69 - t68),
        t84 * t98 - (t30 * t73 - t37 * t92) + t56 * (t57 + t94),
        t89 - t88,
        t96 + t97,
        t51 - t2 * t56,
        -(t52 * twist5 - t63 * t90 + t70 * t91),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    )


def similarity_left_jacobian_f64(twist: Any) -> tuple[Any, ...]:
    """Left Jacobian of a similarity's exponential at a twist"""
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = twist0 * twist0
    t1 = twist1 * twist1
    t2 = t0 + t1
    t3 = twist2 * twist2
    t4 = t2 + t3
    t5 = 0.25 * t4
    t6 = np.minimum(t5, 2.4674011002723395)
    t7 = t6 * (t6 * (-4.653304211418644e-15 * t6 + 5.362814048940375e-13) + -4.605580928658353e-11)
    t8 = t6 * (t6 * (t7 + 3.1322658499179184e-09) + -1.644445954441792e-07) + 6.413339737800479e-06
    t9 = (
        t6 * (t6 * (t6 * t8 + -0.00017636684303014454) + 0.0031746031746025262) +
            -0.033333333333333284
    )
    t10 = np.sqrt(t5)
    t11 = np.floor(0.3183098861837907 * t10 + 0.5)
    t12 = (t11 < 0.5)
    t13 = (
        t10 - t11 * 3.1415926218032837 - t11 * 3.1786509424591713e-08 - t11 * 1.2246467202362698e-16
    )
    t14 = t13 - t11 * 7.891108333126411e-24
    t15 = t14 * t14
    t16 = t15 * (2.721539074015491e-15 * t15 + -7.643023238169083e-13) + 1.6058940754212953e-10
    t17 = (
        t15 * (t15 * (t15 * t16 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527
    )
    t18 = 1.0 + t15 * (t15 * (t15 * t17 + 0.008333333333333186) + -0.16666666666666666)
    t19 = 1.0 - 2.0 * (t11 - np.floor(0.5 * t11) * 2.0)
    t20 = np.where(t12, t18, t18 * (t14 * t19) / np.maximum(1.0, t10))
    t21 = t15 * (t15 * 4.608909074888812e-14 + -1.146289561457958e-11) + 2.0876561604575935e-09
    t22 = (
        t15 * (t15 * (t15 * t21 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708
    )
    t23 = t19 * (1.0 + t15 * (t15 * (t15 * t22 + 0.041666666666663875) + -0.4999999999999997))
    t24 = (
        np.where((t5 < 2.4674011002723395), t6 * t9 + 0.16666666666666666, (1.0 - t20 * t23) / (4.0
            * np.maximum(t5, 2.4674011002723395)))
    )
    t25 = t1 + t3
    t26 = 1.0 - t24 * t25
    t27 = twist0 * twist1
    t28 = t24 * t27
    t29 = t20 * (0.5 * t20)
    t30 = twist2 * t29
    t31 = t28 - t30
    t32 = twist1 * t29
    t33 = twist0 * twist2
    t34 = t24 * t33
    t35 = t32 + t34
    t36 = t28 + t30
    t37 = t0 + t3
    t38 = 1.0 - t24 * t37
    t39 = twist1 * twist2
    t40 = t24 * t39
    t41 = twist0 * t29
    t42 = t40 - t41
    t43 = t34 - t32
    t44 = t40 + t41
    t45 = 1.0 - t2 * t24
    t46 = np.floor(0.5 + twist6 * 1.4426950408889634)
    t47 = twist6 - t46 * 0.6931471675634384 - t46 * 1.2996506893889889e-08
    t48 = (
        t47 * (t47 * (2.5110372746250102e-08 * t47 + 2.763307546557511e-07) + 2.755724001024349e-06)
    )
    t49 = (
        t47 * (t47 * (t48 + 2.4801484301104542e-05) + 0.0001984126989089813) + 0.0013888888953421457
    )
    t50 = (
        t47 * (t47 * (t47 * t49 + 0.00833333333331928) + 0.04166666666648393) + 0.16666666666666682
    )
    t51 = exp2_of_integer(t46) * (1.0 + t47 * (1.0 + t47 * (t47 * t50 + 0.5000000000000019)))
    t52 = (np.abs(twist6) < 1.0)
    t53 = np.maximum(np.minimum(1.0, twist6), -1.0)
    t54 = t53 * (t53 * 7.746377957473813e-13 + 1.1639533539491848e-11) + 1.6057674136158497e-10
    t55 = (
        t53 * (t53 * (t53 * t54 + 2.087442623329743e-09) + 2.5052117752083137e-08) +
            2.7557335164569814e-07
    )
    t56 = (
        t53 * (t53 * (t53 * t55 + 2.755731919111943e-06) + 2.4801587245650116e-05) +
            0.00019841269841324745
    )
    t57 = (
        t53 * (t53 * (t53 * t56 + 0.0013888888888982337) + 0.008333333333333299) +
            0.04166666666666608
    )
    t58 = 0.5 + t53 * (0.16666666666666666 + t53 * t57)
    t59 = 1.0 / np.where((twist6 < 0.0), np.minimum(twist6, -1.0), np.maximum(1.0, twist6))
    t60 = (t51 - 1.0) * t59
    t61 = np.where(t52, 1.0 + t53 * t58, t60)
    t62 = np.where(t52, t58, t59 * (t60 - 1.0))
    t63 = t61 - t62
    t64 = twist6 * twist6
    t65 = 1.0 / np.maximum(t4 + t64, 1.0947644252537633e-47)
    t66 = (twist6 * (t29 * t51 - t63) + t24 * (t4 * t51)) * t65
    t67 = twist1 * twist4
    t68 = twist2 * twist5
    t69 = t64 * t65
    t70 = t63 * t69 + t51 * (1.0 - t69) * (t29 - t24 * twist6)
    t71 = twist1 * twist3
    t72 = twist0 * twist4
    t73 = t71 - t72
    t74 = twist2 * twist3
    t75 = twist0 * twist5
    t76 = t74 - t75
    t77 = twist2 * twist4
    t78 = twist1 * twist5
    t79 = t77 - t78
    t80 = twist0 * t76 + twist1 * t79
    t81 = t61 * twist5 - t70 * t73 + t66 * t80
    t82 = twist0 * t73 - twist2 * t79
    t83 = t61 * twist4 + t70 * t76 + t66 * t82
    t84 = twist0 * 2.0
    t85 = t15 * (t15 * 2.1772370641728367e-14 + -5.350144126598709e-12) + 9.635366495989451e-10
    t86 = (
        t15 * (t15 * (t15 * t85 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574
    )
    t87 = (
        np.where(t12, -0.16666666666666666 + t15 * (t15 * t86 + 0.01666666666666651), (t23 - t20) /
            (2.0 * np.maximum(1.0, t5)))
    )
    t88 = 0.25 * (t23 * t87 - t29)
    t89 = t65 * (t51 * (0.5 * (1.0 - t4 * t24) + twist6 * t88) - t70)
    t90 = t65 * (t51 * (0.25 * twist6 * (t20 * t87) - t88) - t66)
    t91 = twist1 * t73 + twist2 * t76
    t92 = t79 * t89 + t90 * t91
    t93 = twist5 * t70
    t94 = twist1 * 2.0
    t95 = twist2 * 2.0
    t96 = twist4 * t70
    t97 = t27 * t66
    t98 = twist2 * t70
    t99 = twist1 * t70
    t100 = t33 * t66
    t101 = t65 * (twist6 * (t70 - t62) + t4 * t66)
    t102 = t65 * (t62 - t70 + twist6 * t66)
    t103 = t61 * twist3 - t70 * t79 - t66 * t91
    t104 = t76 * t89 + t82 * t90
    t105 = twist0 * twist3
    t106 = t70 * twist3
    t107 = t39 * t66
    t108 = twist0 * t70
    t109 = t80 * t90 - t73 * t89
    return (
        t26,
        t31,
        t35,
        0.0,
        0.0,
        0.0,
        0.0,
        t36,
        t38,
        t42,
        0.0,
        0.0,
        0.0,
        0.0,
        t43,
        t44,
        t45,
        0.0,
        0.0,
        0.0,
        0.0,
        t66 * (t67 + t68) - (t36 * t81 - t43 * t83 + t84 * t92),
        t93 - (t38 * t81 - t44 * t83 + t92 * t94) - t66 * (t71 + t73),
        -(t42 * t81 - t45 * t83 + t92 * t95 + t96 + t66 * (t74 + t76)),
        t61 - t25 * t66,
        t97 - t98,
        t99 + t100,
        t91 * t102 - (t62 * twist3 - t79 * t101),
        t26 * t81 - t43 * t103 + t84 * t104 - t93 + t66 * (t73 - t72),
        t31 * t81 - t44 * t103 + t94 * t104 + t66 * (t68 + t105),
        t35 * t81 - t45 * t103 + t95 * t104 + t106 - t66 * (t77 + t79),
        t97 + t98,
        t61 - t37 * t66,
        t107 - t108,
        -(t62 * twist4 + t76 * t101 + t82 * t102),
        t96 + (t84 * t109 - (t26 * t83 - t36 * t103)) + t66 * (t76 - t75),
        t94 * t109 - (t31 * t83 - t38 * t103) - t106 + t66 * (t79 - t78),
        t95 * t109 - (t35 * t83 - t42 * t103) + t66 * (t67 + t105),
        t100 - t99,
        t107 + t108,
        t61 - t2 * t66,
        -(t62 * twist5 - t73 * t101 + t80 * t102),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    )


def similarity_left_jacobian_inverse_f32(twist: Any) -> tuple[Any, ...]:
    """Inverse left Jacobian of a similarity's exponential, singular at full turns"""
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = twist0 * twist0
    t1 = twist1 * twist1
    t2 = t0 + t1
    t3 = twist2 * twist2
    t4 = t2 + t3
    t5 = 0.25 * t4
    t6 = (t5 < 2.467401)
    t7 = np.minimum(t5, 2.467401)
    t8 = t7 * (t7 * (t7 * (1.4476021e-07 * t7 + 1.7820906e-07) + 6.007504e-06) + 5.231038e-05)
    t9 = np.sqrt(t5)
    t10 = np.floor(0.31830987 * t9 + 0.5)
    t11 = 1.0 - 2.0 * (t10 - np.floor(0.5 * t10) * 2.0)
    t12 = t9 - t10 * 3.140625 - t10 * 0.0009675026 - t10 * 1.5099067e-07 - t10 * 5.126688e-12
    t13 = t12 * t12
    t14 = t13 * (t13 * (t13 * (-2.6050063e-07 * t13 + 2.4760076e-05) + -0.001388836) + 0.041666634)
    t15 = t11 * (t13 * (t14 + -0.5) + 1.0)
    t16 = (t10 < 0.5)
    t17 = t13 * (t13 * (t13 * (t13 * 2.6050482e-06 + -0.00019808991) + 0.00833305) + -0.16666658)
    t18 = t17 + 1.0
    t19 = np.where(t16, t18, t18 * (t11 * t12) / np.maximum(1.0, t9))
    t20 = (
        np.where((t19 < 0.0), np.float32(-1.0), np.float32(1.0)) / np.maximum(np.abs(t19),
            1.4210855e-14)
    )
    t21 = 1.0 / (4.0 * np.maximum(t5, 2.467401))
    t22 = (
        np.where(t6, t7 * (t7 * (t8 + 0.0005293538) + 0.005555516) + 0.083333336, (1.0 - t15 * t20)
            * t21)
    )
    t23 = t1 + t3
    t24 = 1.0 - t22 * t23
    t25 = twist0 * twist1
    t26 = t22 * t25
    t27 = twist2 * -0.5
    t28 = t26 - t27
    t29 = twist1 * -0.5
    t30 = twist0 * twist2
    t31 = t22 * t30
    t32 = t29 + t31
    t33 = t26 + t27
    t34 = t0 + t3
    t35 = 1.0 - t22 * t34
    t36 = twist1 * twist2
    t37 = t22 * t36
    t38 = twist0 * -0.5
    t39 = t37 - t38
    t40 = t31 - t29
    t41 = t37 + t38
    t42 = 1.0 - t2 * t22
    t43 = 2.0 * (twist0 * t24 + twist1 * t33 + twist2 * t40)
    t44 = np.floor(0.5 + 1.442695 * twist6)
    t45 = twist6 - t44 * 0.69311523 - t44 * 3.1946183e-05
    t46 = t45 * (t45 * (t45 * (0.0013941411 * t45 + 0.008375368) + 0.041666348) + 0.16666412) + 0.5
    t47 = exp2_of_integer(t44) * (1.0 + t45 * (t45 * t46 + 1.0))
    t48 = t7 * (t7 * (t7 * (t7 * -1.4276141e-07 + 6.354456e-06) + -0.00017629226) + 0.0031745604)
    t49 = np.where(t6, t7 * (t48 + -0.033333324) + 0.16666667, t21 * (1.0 - t15 * t19))
    t50 = t13 * (t13 * (t13 * (t13 * -1.1944519e-07 + 1.1010457e-05) + -0.0005952271) + 0.016666664)
    t51 = np.where(t16, t50 + -0.16666667, (t15 - t19) / (2.0 * np.maximum(1.0, t5)))
    t52 = t19 * (0.5 * t19)
    t53 = 0.25 * (t15 * t51 - t52)
    t54 = twist6 * twist6
    t55 = 1.0 / np.maximum(t4 + t54, 1.6940659e-21)
    t56 = t54 * t55
    t57 = (np.abs(twist6) < 1.0)
    t58 = np.maximum(-1.0, np.minimum(1.0, twist6))
    t59 = t58 * (t58 * (t58 * (t58 * 2.8063823e-06 + 2.5359639e-05) + 0.00019838089) + 0.0013885383)
    t60 = t58 * (t58 * (t58 * (t59 + 0.008333339) + 0.04166674) + 0.16666667) + 0.5
    t61 = 1.0 / np.where((twist6 < 0.0), np.minimum(-1.0, twist6), np.maximum(1.0, twist6))
    t62 = (t47 - 1.0) * t61
    t63 = np.where(t57, 1.0 + t58 * t60, t62)
    t64 = np.where(t57, t60, t61 * (t62 - 1.0))
    t65 = t63 - t64
    t66 = t56 * t65 + t47 * (1.0 - t56) * (t52 - twist6 * t49)
    t67 = t55 * (t47 * (0.5 * (1.0 - t4 * t49) + twist6 * t53) - t66)
    t68 = twist2 * twist4 - twist1 * twist5
    t69 = t55 * (twist6 * (t47 * t52 - t65) + t49 * (t4 * t47))
    t70 = t55 * (t47 * (0.25 * twist6 * (t19 * t51) - t53) - t69)
    t71 = twist1 * twist3 - twist0 * twist4
    t72 = twist2 * twist3 - twist0 * twist5
    t73 = twist1 * t71 + twist2 * t72
    t74 = t67 * t68 + t70 * t73
    t75 = t40 * twist4 - t33 * twist5
    t76 = t33 * twist3 - t24 * twist4
    t77 = t40 * twist3 - t24 * twist5
    t78 = t43 * t74 + t66 * t75 + t69 * (t33 * t71 + t40 * t72 + (twist1 * t76 + twist2 * t77))
    t79 = 1.0 / t63
    t80 = t4 * t69
    t81 = t63 - t80
    t82 = t81 * t81 + t66 * (t4 * t66)
    t83 = t66 / t82
    t84 = twist0 * t72 + twist1 * t68
    t85 = t70 * t84 - t67 * t71
    t86 = twist0 * t71 - twist2 * t68
    t87 = t63 * twist4 + t66 * t72 + t69 * t86
    t88 = (
        t43 * t85 - t87 - t66 * t76 + t69 * (t24 * t72 + t33 * t68 + (twist0 * t77 + twist1 * t75))
    )
    t89 = t63 * twist5 - t66 * t71 + t69 * t84
    t90 = t67 * t72 + t70 * t86
    t91 = (
        t89 + t43 * t90 + t66 * t77 + t69 * (t24 * t71 - t40 * t68 + (twist0 * t76 - twist2 * t75))
    )
    t92 = twist1 * t88 - twist2 * t91
    t93 = (t66 * t66 - t69 * t81) / (t63 * t82)
    t94 = twist0 * t91 + twist1 * t78
    t95 = twist2 * t78 + twist0 * t88
    t96 = 2.0 * (twist0 * t28 + twist1 * t35 + twist2 * t41)
    t97 = t41 * twist4 - t35 * twist5
    t98 = t35 * twist3 - t28 * twist4
    t99 = t41 * twist3 - t28 * twist5
    t100 = (
        t89 + t74 * t96 + t66 * t97 + t69 * (t35 * t71 + t41 * t72 + (twist1 * t98 + twist2 * t99))
    )
    t101 = t63 * twist3 - t66 * t68 - t69 * t73
    t102 = (
        t101 + t85 * t96 - t66 * t98 + t69 * (t28 * t72 + t35 * t68 + (twist0 * t99 + twist1 * t97))
    )
    t103 = t90 * t96 + t66 * t99 + t69 * (t28 * t71 - t41 * t68 + (twist0 * t98 - twist2 * t97))
    t104 = twist1 * t102 - twist2 * t103
    t105 = twist0 * t103 + twist1 * t100
    t106 = twist2 * t100 + twist0 * t102
    t107 = 2.0 * (twist0 * t32 + twist1 * t39 + twist2 * t42)
    t108 = t39 * twist3 - t32 * twist4
    t109 = t42 * twist3 - t32 * twist5
    t110 = t42 * twist4 - t39 * twist5
    t111 = t85 * t107 - t66 * t108 + t69 * (t32 * t72 + t39 * t68 + (twist0 * t109 + twist1 * t110))
    t112 = (
        t90 * t107 - t101 + t66 * t109 + t69 * (t32 * t71 - t42 * t68 + (twist0 * t108 - twist2 *
            t110))
    )
    t113 = twist1 * t111 - twist2 * t112
    t114 = (
        t87 - t74 * t107 - t66 * t110 - t69 * (t39 * t71 + t42 * t72 + (twist1 * t108 + twist2 *
            t109))
    )
    t115 = twist0 * t112 - twist1 * t114
    t116 = twist0 * t111 - twist2 * t114
    t117 = twist2 * t83
    t118 = t25 * t93
    t119 = t30 * t93
    t120 = twist1 * t83
    t121 = t55 * (t80 + twist6 * (t66 - t64))
    t122 = t55 * (t64 - t66 + twist6 * t69)
    t123 = t64 * twist3 - t68 * t121 - t73 * t122
    t124 = t64 * twist4 + t72 * t121 + t86 * t122
    t125 = t64 * twist5 - t71 * t121 + t84 * t122
    t126 = twist2 * t124 - twist1 * t125
    t127 = twist1 * t123 - twist0 * t124
    t128 = twist2 * t123 - twist0 * t125
    t129 = twist0 * t83
    t130 = t36 * t93
    return (
        t24,
        t28,
        t32,
        0.0,
        0.0,
        0.0,
        0.0,
        t33,
        t35,
        t39,
        0.0,
        0.0,
        0.0,
        0.0,
        t40,
        t41,
        t42,
        0.0,
        0.0,
        0.0,
        0.0,
        t78 * t79 + t83 * t92 - t93 * (twist1 * t94 + twist2 * t95),
        t79 * t100 + t83 * t104 - t93 * (twist1 * t105 + twist2 * t106),
        t83 * t113 - t79 * t114 - t93 * (twist1 * t115 + twist2 * t116),
        t79 - t23 * t93,
        t117 + t118,
        t119 - t120,
        t79 * t123 + t83 * t126 - t93 * (twist1 * t127 + twist2 * t128),
        t93 * (twist0 * t94 - twist2 * t92) - (t79 * t91 + t83 * t95),
        t93 * (twist0 * t105 - twist2 * t104) - (t79 * t103 + t83 * t106),
        t93 * (twist0 * t115 - twist2 * t113) - (t79 * t112 + t83 * t116),
        t118 - t117,
        t79 - t34 * t93,
        t129 + t130,
        t79 * t124 - t83 * t128 + t93 * (twist0 * t127 - twist2 * t126),
        t83 * t94 - t79 * t88 + t93 * (twist0 * t95 + twist1 * t92),
        t83 * t105 - t79 * t102 + t93 * (twist0 * t106 + twist1 * t104),
        t83 * t115 - t79 * t111 + t93 * (twist0 * t116 + twist1 * t113),
        t119 + t120,
        t130 - t129,
        t79 - t2 * t93,
        t79 * t125 + t83 * t127 + t93 * (twist0 * t128 + twist1 * t126),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    )


def similarity_left_jacobian_inverse_f64(twist: Any) -> tuple[Any, ...]:
    """Inverse left Jacobian of a similarity's exponential, singular at full turns"""
    twist0, twist1, twist2, twist3, twist4, twist5, twist6 = (twist[..., i] for i in range(7))
    t0 = twist0 * twist0
    t1 = twist1 * twist1
    t2 = t0 + t1
    t3 = twist2 * twist2
    t4 = t2 + t3
    t5 = 0.25 * t4
    t6 = (t5 < 2.4674011002723395)
    t7 = np.minimum(t5, 2.4674011002723395)
    t8 = t7 * (t7 * (4.190860689573733e-14 * t7 + -3.105093875068576e-13) + 2.52116134224849e-12)
    t9 = t7 * (t7 * (t8 + -4.868906238981723e-13) + 7.053760152595475e-11) + 5.42546914811746e-10
    t10 = (
        t7 * (t7 * (t7 * t9 + 5.574566759681558e-09) + 5.479985772581718e-08) +
            5.411083420356027e-07
    )
    t11 = (
        t7 * (t7 * (t7 * t10 + 5.344447517065357e-06) + 5.2910053333655655e-05) +
            0.0005291005290594417
    )
    t12 = np.sqrt(t5)
    t13 = np.floor(0.3183098861837907 * t12 + 0.5)
    t14 = 1.0 - 2.0 * (t13 - np.floor(0.5 * t13) * 2.0)
    t15 = (
        t12 - t13 * 3.1415926218032837 - t13 * 3.1786509424591713e-08 - t13 * 1.2246467202362698e-16
    )
    t16 = t15 - t13 * 7.891108333126411e-24
    t17 = t16 * t16
    t18 = t17 * (4.608909074888812e-14 * t17 + -1.146289561457958e-11) + 2.0876561604575935e-09
    t19 = (
        t17 * (t17 * (t17 * t18 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708
    )
    t20 = t14 * (1.0 + t17 * (t17 * (t17 * t19 + 0.041666666666663875) + -0.4999999999999997))
    t21 = (t13 < 0.5)
    t22 = t17 * (t17 * 2.721539074015491e-15 + -7.643023238169083e-13) + 1.6058940754212953e-10
    t23 = (
        t17 * (t17 * (t17 * t22 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527
    )
    t24 = 1.0 + t17 * (t17 * (t17 * t23 + 0.008333333333333186) + -0.16666666666666666)
    t25 = np.where(t21, t24, t24 * (t14 * t16) / np.maximum(1.0, t12))
    t26 = (
        np.where((t25 < 0.0), np.float64(-1.0), np.float64(1.0)) / np.maximum(np.abs(t25),
            4.930380657631324e-32)
    )
    t27 = 1.0 / (4.0 * np.maximum(t5, 2.4674011002723395))
    t28 = (
        np.where(t6, t7 * (t7 * t11 + 0.0055555555555571205) + 0.08333333333333333, (1.0 - t20 *
            t26) * t27)
    )
    t29 = t1 + t3
    t30 = 1.0 - t28 * t29
    t31 = twist0 * twist1
    t32 = t28 * t31
    t33 = twist2 * -0.5
    t34 = t32 - t33
    t35 = twist1 * -0.5
    t36 = twist0 * twist2
    t37 = t28 * t36
    t38 = t35 + t37
    t39 = t32 + t33
    t40 = t0 + t3
    t41 = 1.0 - t28 * t40
    t42 = twist1 * twist2
    t43 = t28 * t42
    t44 = twist0 * -0.5
    t45 = t43 - t44
    t46 = t37 - t35
    t47 = t43 + t44
    t48 = 1.0 - t2 * t28
    t49 = 2.0 * (twist0 * t30 + twist1 * t39 + twist2 * t46)
    t50 = np.floor(0.5 + 1.4426950408889634 * twist6)
    t51 = twist6 - t50 * 0.6931471675634384 - t50 * 1.2996506893889889e-08
    t52 = (
        t51 * (t51 * (2.5110372746250102e-08 * t51 + 2.763307546557511e-07) + 2.755724001024349e-06)
    )
    t53 = (
        t51 * (t51 * (t52 + 2.4801484301104542e-05) + 0.0001984126989089813) + 0.0013888888953421457
    )
    t54 = (
        t51 * (t51 * (t51 * t53 + 0.00833333333331928) + 0.04166666666648393) + 0.16666666666666682
    )
    t55 = exp2_of_integer(t50) * (1.0 + t51 * (1.0 + t51 * (t51 * t54 + 0.5000000000000019)))
    t56 = t7 * (t7 * (t7 * -4.653304211418644e-15 + 5.362814048940375e-13) + -4.605580928658353e-11)
    t57 = (
        t7 * (t7 * (t56 + 3.1322658499179184e-09) + -1.644445954441792e-07) + 6.413339737800479e-06
    )
    t58 = (
        t7 * (t7 * (t7 * t57 + -0.00017636684303014454) + 0.0031746031746025262) +
            -0.033333333333333284
    )
    t59 = np.where(t6, t7 * t58 + 0.16666666666666666, t27 * (1.0 - t20 * t25))
    t60 = t17 * (t17 * 2.1772370641728367e-14 + -5.350144126598709e-12) + 9.635366495989451e-10
    t61 = (
        t17 * (t17 * (t17 * t60 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574
    )
    t62 = (
        np.where(t21, -0.16666666666666666 + t17 * (t17 * t61 + 0.01666666666666651), (t20 - t25) /
            (2.0 * np.maximum(1.0, t5)))
    )
    t63 = t25 * (0.5 * t25)
    t64 = 0.25 * (t20 * t62 - t63)
    t65 = twist6 * twist6
    t66 = 1.0 / np.maximum(t4 + t65, 1.0947644252537633e-47)
    t67 = t65 * t66
    t68 = (np.abs(twist6) < 1.0)
    t69 = np.maximum(-1.0, np.minimum(1.0, twist6))
    t70 = t69 * (t69 * 7.746377957473813e-13 + 1.1639533539491848e-11) + 1.6057674136158497e-10
    t71 = (
        t69 * (t69 * (t69 * t70 + 2.087442623329743e-09) + 2.5052117752083137e-08) +
            2.7557335164569814e-07
    )
    t72 = (
        t69 * (t69 * (t69 * t71 + 2.755731919111943e-06) + 2.4801587245650116e-05) +
            0.00019841269841324745
    )
    t73 = (
        t69 * (t69 * (t69 * t72 + 0.0013888888888982337) + 0.008333333333333299) +
            0.04166666666666608
    )
    t74 = 0.5 + t69 * (0.16666666666666666 + t69 * t73)
    t75 = 1.0 / np.where((twist6 < 0.0), np.minimum(-1.0, twist6), np.maximum(1.0, twist6))
    t76 = (t55 - 1.0) * t75
    t77 = np.where(t68, 1.0 + t69 * t74, t76)
    t78 = np.where(t68, t74, t75 * (t76 - 1.0))
    t79 = t77 - t78
    t80 = t67 * t79 + t55 * (1.0 - t67) * (t63 - twist6 * t59)
    t81 = t66 * (t55 * (0.5 * (1.0 - t4 * t59) + twist6 * t64) - t80)
    t82 = twist2 * twist4 - twist1 * twist5
    t83 = t66 * (twist6 * (t55 * t63 - t79) + t59 * (t4 * t55))
    t84 = t66 * (t55 * (0.25 * twist6 * (t25 * t62) - t64) - t83)
    t85 = twist1 * twist3 - twist0 * twist4
    t86 = twist2 * twist3 - twist0 * twist5
    t87 = twist1 * t85 + twist2 * t86
    t88 = t81 * t82 + t84 * t87
    t89 = t46 * twist4 - t39 * twist5
    t90 = t39 * twist3 - t30 * twist4
    t91 = t46 * twist3 - t30 * twist5
    t92 = t49 * t88 + t80 * t89 + t83 * (t39 * t85 + t46 * t86 + (twist1 * t90 + twist2 * t91))
    t93 = 1.0 / t77
    t94 = t4 * t83
    t95 = t77 - t94
    t96 = t95 * t95 + t80 * (t4 * t80)
    t97 = t80 / t96
    t98 = twist0 * t86 + twist1 * t82
    t99 = t84 * t98 - t81 * t85
    t100 = twist0 * t85 - twist2 * t82
    t101 = t77 * twist4 + t80 * t86 + t83 * t100
    t102 = (
        t49 * t99 - t101 - t80 * t90 + t83 * (t30 * t86 + t39 * t82 + (twist0 * t91 + twist1 * t89))
    )
    t103 = t77 * twist5 - t80 * t85 + t83 * t98
    t104 = t81 * t86 + t84 * t100
    t105 = (
        t103 + t49 * t104 + t80 * t91 + t83 * (t30 * t85 - t46 * t82 + (twist0 * t90 - twist2 *
            t89))
    )
    t106 = twist1 * t102 - twist2 * t105
    t107 = (t80 * t80 - t83 * t95) / (t77 * t96)
    t108 = twist0 * t105 + twist1 * t92
    t109 = twist2 * t92 + twist0 * t102
    t110 = 2.0 * (twist0 * t34 + twist1 * t41 + twist2 * t47)
    t111 = t47 * twist4 - t41 * twist5
    t112 = t41 * twist3 - t34 * twist4
    t113 = t47 * twist3 - t34 * twist5
    t114 = (
        t103 + t88 * t110 + t80 * t111 + t83 * (t41 * t85 + t47 * t86 + (twist1 * t112 + twist2 *
            t113))
    )
    t115 = t77 * twist3 - t80 * t82 - t83 * t87
    t116 = (
        t115 + t99 * t110 - t80 * t112 + t83 * (t34 * t86 + t41 * t82 + (twist0 * t113 + twist1 *
            t111))
    )
    t117 = (
        t104 * t110 + t80 * t113 + t83 * (t34 * t85 - t47 * t82 + (twist0 * t112 - twist2 * t111))
    )
    t118 = twist1 * t116 - twist2 * t117
    t119 = twist0 * t117 + twist1 * t114
    t120 = twist2 * t114 + twist0 * t116
    t121 = 2.0 * (twist0 * t38 + twist1 * t45 + twist2 * t48)
    t122 = t45 * twist3 - t38 * twist4
    t123 = t48 * twist3 - t38 * twist5
    t124 = t48 * twist4 - t45 * twist5
    t125 = t99 * t121 - t80 * t122 + t83 * (t38 * t86 + t45 * t82 + (twist0 * t123 + twist1 * t124))
    t126 = (
        t104 * t121 - t115 + t80 * t123 + t83 * (t38 * t85 - t48 * t82 + (twist0 * t122 - twist2 *
            t124))
    )
    t127 = twist1 * t125 - twist2 * t126
    t128 = (
        t101 - t88 * t121 - t80 * t124 - t83 * (t45 * t85 + t48 * t86 + (twist1 * t122 + twist2 *
            t123))
    )
    t129 = twist0 * t126 - twist1 * t128
    t130 = twist0 * t125 - twist2 * t128
    t131 = twist2 * t97
    t132 = t31 * t107
    t133 = t36 * t107
    t134 = twist1 * t97
    t135 = t66 * (t94 + twist6 * (t80 - t78))
    t136 = t66 * (t78 - t80 + twist6 * t83)
    t137 = t78 * twist3 - t82 * t135 - t87 * t136
    t138 = t78 * twist4 + t86 * t135 + t100 * t136
    t139 = t78 * twist5 - t85 * t135 + t98 * t136
    t140 = twist2 * t138 - twist1 * t139
    t141 = twist1 * t137 - twist0 * t138
    t142 = twist2 * t137 - twist0 * t139
    t143 = twist0 * t97
    t144 = t42 * t107
    return (
        t30,
        t34,
        t38,
        0.0,
        0.0,
        0.0,
        0.0,
        t39,
        t41,
        t45,
        0.0,
        0.0,
        0.0,
        0.0,
        t46,
        t47,
        t48,
        0.0,
        0.0,
        0.0,
        0.0,
        t92 * t93 + t97 * t106 - t107 * (twist1 * t108 + twist2 * t109),
        t93 * t114 + t97 * t118 - t107 * (twist1 * t119 + twist2 * t120),
        t97 * t127 - t93 * t128 - t107 * (twist1 * t129 + twist2 * t130),
        t93 - t29 * t107,
        t131 + t132,
        t133 - t134,
        t93 * t137 + t97 * t140 - t107 * (twist1 * t141 + twist2 * t142),
        t107 * (twist0 * t108 - twist2 * t106) - (t93 * t105 + t97 * t109),
        t107 * (twist0 * t119 - twist2 * t118) - (t93 * t117 + t97 * t120),
        t107 * (twist0 * t129 - twist2 * t127) - (t93 * t126 + t97 * t130),
        t132 - t131,
        t93 - t40 * t107,
        t143 + t144,
        t93 * t138 - t97 * t142 + t107 * (twist0 * t141 - twist2 * t140),
        t97 * t108 - t93 * t102 + t107 * (twist0 * t109 + twist1 * t106),
        t97 * t119 - t93 * t116 + t107 * (twist0 * t120 + twist1 * t118),
        t97 * t129 - t93 * t125 + t107 * (twist0 * t130 + twist1 * t127),
        t133 + t134,
        t144 - t143,
        t93 - t2 * t107,
        t93 * t139 + t97 * t141 + t107 * (twist0 * t142 + twist1 * t140),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    )
