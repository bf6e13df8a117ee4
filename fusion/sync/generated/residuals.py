"""Residuals of camera and IMU; tables hold (residual, unknown) of each derivative.

Written by ``python -m motorcade.fusion.sync.model``; edit that.
"""
# fmt: off

from __future__ import annotations

from typing import Any

import numpy as np

INTERVAL: tuple[tuple[int, int], ...] = (
    (0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0), (6, 0), (7, 0), (8, 0), (0, 1),
    (1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (6, 1), (7, 1), (8, 1), (0, 2), (1, 2),
    (2, 2), (3, 2), (4, 2), (5, 2), (6, 2), (7, 2), (8, 2), (3, 3), (4, 3), (5, 3),
    (3, 4), (4, 4), (5, 4), (3, 5), (4, 5), (5, 5), (3, 6), (4, 6), (5, 6), (6, 6),
    (7, 6), (8, 6), (3, 7), (4, 7), (5, 7), (6, 7), (7, 7), (8, 7), (3, 8), (4, 8),
    (5, 8), (6, 8), (7, 8), (8, 8), (0, 9), (1, 9), (2, 9), (3, 9), (4, 9), (5, 9),
    (6, 9), (7, 9), (8, 9), (9, 9), (0, 10), (1, 10), (2, 10), (3, 10), (4, 10), (5, 10),
    (6, 10), (7, 10), (8, 10), (10, 10), (0, 11), (1, 11), (2, 11), (3, 11), (4, 11), (5, 11),
    (6, 11), (7, 11), (8, 11), (11, 11), (0, 12), (1, 12), (2, 12), (3, 12), (4, 12), (5, 12),
    (6, 12), (7, 12), (8, 12), (12, 12), (0, 13), (1, 13), (2, 13), (3, 13), (4, 13), (5, 13),
    (6, 13), (7, 13), (8, 13), (13, 13), (0, 14), (1, 14), (2, 14), (3, 14), (4, 14), (5, 14),
    (6, 14), (7, 14), (8, 14), (14, 14), (0, 15), (1, 15), (2, 15), (3, 15), (4, 15), (5, 15),
    (6, 15), (7, 15), (8, 15), (0, 16), (1, 16), (2, 16), (3, 16), (4, 16), (5, 16), (6, 16),
    (7, 16), (8, 16), (0, 17), (1, 17), (2, 17), (3, 17), (4, 17), (5, 17), (6, 17), (7, 17),
    (8, 17), (3, 18), (4, 18), (5, 18), (3, 19), (4, 19), (5, 19), (3, 20), (4, 20), (5, 20),
    (6, 21), (7, 21), (8, 21), (6, 22), (7, 22), (8, 22), (6, 23), (7, 23), (8, 23), (9, 24),
    (10, 25), (11, 26), (12, 27), (13, 28), (14, 29), (3, 30), (4, 30), (5, 30), (6, 30), (7, 30),
    (8, 30), (3, 31), (4, 31), (5, 31), (6, 31), (7, 31), (8, 31), (3, 32), (4, 32), (5, 32),
    (6, 32), (7, 32), (8, 32),
)


def interval_f64(start: Any, end: Any, velocity0: Any, velocity1: Any, bias_step: Any, gravity: Any,
        motion: Any, bias_jacobian: Any, duration: Any) -> tuple[Any, ...]:
    """What an interval misses: rotation, position, velocity, biases"""
    start0, start1, start2, start3, start4, start5, start6, start7 = (start[..., i] for i in
        range(8))
    end0, end1, end2, end3, end4, end5, end6, end7 = (end[..., i] for i in range(8))
    velocity00, velocity01, velocity02 = (velocity0[..., i] for i in range(3))
    velocity10, velocity11, velocity12 = (velocity1[..., i] for i in range(3))
    bias_step0, bias_step1, bias_step2, bias_step3, bias_step4, bias_step5 = (bias_step[..., i] for
        i in range(6))
    gravity0, gravity1, gravity2 = (gravity[..., i] for i in range(3))
    (
        motion0, motion1, motion2, motion3, motion4, motion5, motion6, motion7, motion8, motion9,
        motion10, motion11, motion12, motion13, motion14, motion15
    ) = (motion[..., i] for i in range(16))
    (
        bias_jacobian0, bias_jacobian1, bias_jacobian2, bias_jacobian3, bias_jacobian4,
        bias_jacobian5, bias_jacobian6, bias_jacobian7, bias_jacobian8, bias_jacobian9,
        bias_jacobian10, bias_jacobian11, bias_jacobian12, bias_jacobian13, bias_jacobian14,
        bias_jacobian15, bias_jacobian16, bias_jacobian17, bias_jacobian18, bias_jacobian19,
        bias_jacobian20, bias_jacobian21, bias_jacobian22, bias_jacobian23, bias_jacobian24,
        bias_jacobian25, bias_jacobian26, bias_jacobian27, bias_jacobian28, bias_jacobian29,
        bias_jacobian30, bias_jacobian31, bias_jacobian32, bias_jacobian33, bias_jacobian34,
        bias_jacobian35, bias_jacobian36, bias_jacobian37, bias_jacobian38, bias_jacobian39,
        bias_jacobian40, bias_jacobian41, bias_jacobian42, bias_jacobian43, bias_jacobian44,
        bias_jacobian45, bias_jacobian46, bias_jacobian47, bias_jacobian48, bias_jacobian49,
        bias_jacobian50, bias_jacobian51, bias_jacobian52, bias_jacobian53
    ) = (bias_jacobian[..., i] for i in range(54))
    duration = duration[..., 0]
    t0 = start0 * end0 + start3 * end3 + start2 * end2 + start1 * end1
    t1 = start0 * end3 - end0 * start3 + end2 * start1 - start2 * end1
    t2 = end0 * start2 - (start0 * end2 + start3 * end1) + end3 * start1
    t3 = start0 * end1 + end3 * start2 - end0 * start1 - start3 * end2
    t4 = (
        np.where((motion0 * t0 + motion3 * t1 - motion2 * t2 + motion1 * t3 < 0.0),
            np.float64(-1.0), np.float64(1.0))
    )
    t5 = -2.0 * t4
    t6 = duration * duration
    t7 = 0.5 * t6
    t8 = -0.5 * (velocity01 * duration + gravity1 * t7)
    t9 = -0.5 * (duration * velocity00 + t7 * gravity0)
    t10 = -0.5 * (duration * velocity02 + t7 * gravity2)
    t11 = start3 * t8 - start0 * t9 - start2 * t10 - start4
    t12 = start1 * t10 - start0 * t8 - start5 - start3 * t9
    t13 = start0 * end4 - start3 * end5 + start2 * end6 + end0 * t11 + start1 * end7 - end3 * t12
    t14 = start0 * t10 + start6 - start2 * t9 + start1 * t8
    t15 = start3 * t10 + start1 * t9 + start7 + start2 * t8
    t16 = t13 - end2 * t14 - end1 * t15
    t17 = (
        start0 * end5 + start2 * end7 + end3 * t11 - start1 * end6 + end0 * t12 - end2 * t15 +
            start3 * end4
    )
    t18 = t17 + end1 * t14
    t19 = (
        start0 * end6 - end2 * t11 + end1 * t12 - end0 * t14 + start3 * end7 - start2 * end4 +
            start1 * end5
    )
    t20 = t19 - end3 * t15
    t21 = (
        start0 * end7 - start3 * end6 + end1 * t11 - start1 * end4 - end3 * t14 + end0 * t15 -
            start2 * end5
    )
    t22 = t21 + end2 * t12
    t23 = (
        motion0 * t16 - motion3 * t18 + motion2 * t20 - t0 * motion4 + motion1 * t22 + t1 * motion5
    )
    t24 = motion0 * t18 + motion2 * t22 - t1 * motion4 - motion1 * t20 - t0 * motion5 + t2 * motion7
    t25 = motion0 * t20 - t2 * motion4 - t3 * motion5 - t0 * motion6 + motion3 * t22 - motion2 * t16
    t26 = (
        np.where((t0 * motion8 + t1 * motion11 - t2 * motion10 + t3 * motion9 < 0.0),
            np.float64(-1.0), np.float64(1.0))
    )
    t27 = -2.0 * t26
    t28 = -0.5 * velocity10
    t29 = -0.5 * velocity11
    t30 = -0.5 * velocity12
    t31 = end0 * t28 - end3 * t29 + end2 * t30
    t32 = end3 * t28 + end0 * t29 - end1 * t30
    t33 = end1 * t29 - end2 * t28 + end0 * t30
    t34 = -0.5 * (duration * gravity1)
    t35 = -0.5 * (duration * gravity0)
    t36 = -0.5 * (duration * gravity2)
    t37 = -0.5 * velocity00
    t38 = -0.5 * velocity01
    t39 = -0.5 * velocity02
    t40 = start3 * t34 - start0 * t35 - start2 * t36 - (start0 * t37 - start3 * t38 + start2 * t39)
    t41 = end1 * t28 + end3 * t30 + end2 * t29
    t42 = start1 * t36 - start0 * t34 - (start3 * t37 + start0 * t38 - start1 * t39) - start3 * t35
    t43 = start0 * t36 + (start1 * t38 - start2 * t37 + start0 * t39) - start2 * t35 + start1 * t34
    t44 = (
        start0 * t31 - start3 * t32 + start2 * t33 + end0 * t40 + start1 * t41 - end3 * t42 - end2 *
            t43
    )
    t45 = start3 * t36 + start1 * t35 + (start1 * t37 + start3 * t39 + start2 * t38) + start2 * t34
    t46 = t44 - end1 * t45
    t47 = (
        start0 * t32 + start2 * t41 + end3 * t40 - start1 * t33 + end0 * t42 - end2 * t45 + start3 *
            t31
    )
    t48 = t47 + end1 * t43
    t49 = (
        start0 * t33 - end2 * t40 + end1 * t42 - end0 * t43 + start3 * t41 - start2 * t31 + start1 *
            t32
    )
    t50 = t49 - end3 * t45
    t51 = (
        start0 * t41 - start3 * t33 + end1 * t40 - start1 * t31 - end3 * t43 + end0 * t45 - start2 *
            t32
    )
    t52 = t51 + end2 * t42
    t53 = (
        motion8 * t46 - motion11 * t48 + motion10 * t50 - t0 * motion12 + motion9 * t52 + t1 *
            motion13
    )
    t54 = (
        motion8 * t48 + motion10 * t52 - t1 * motion12 - motion9 * t50 - t0 * motion13 + t2 *
            motion15
    )
    t55 = (
        motion8 * t50 - t2 * motion12 - t3 * motion13 - t0 * motion14 + motion11 * t52 - motion10 *
            t46
    )
    t56 = motion3 * t5
    t57 = end3 * t56
    t58 = motion0 * t5
    t59 = end0 * t58
    t60 = motion2 * t5
    t61 = end2 * t60
    t62 = motion1 * t5
    t63 = end1 * t62
    t64 = t57 - t59 + t61 - t63
    t65 = end1 * t60
    t66 = end3 * t58
    t67 = end0 * t56
    t68 = t66 + t67
    t69 = end2 * t62
    t70 = t65 - t68 + t69
    t71 = end2 * t58
    t72 = end1 * t56
    t73 = t71 + t72
    t74 = end0 * t60
    t75 = end3 * t62
    t76 = t73 + t74 + t75
    t77 = end1 * t58
    t78 = end2 * t56
    t79 = t77 - t78
    t80 = end3 * t60
    t81 = end0 * t62
    t82 = t79 + t80 - t81
    t83 = t61 + (t59 - t57 - t63)
    t84 = t65 + (t68 + t69)
    t85 = t79 + t81 - t80
    t86 = t73 - t75 - t74
    t87 = t71 + (t74 - t75) - t72
    t88 = t78 + (t77 + (t80 + t81))
    t89 = t61 + t63 - t59 - t57
    t90 = t66 - (t65 - t69) - t67
    t91 = t81 - t80
    t92 = t78 + t91 - t77
    t93 = t74 + t75
    t94 = t71 + (t72 + t93)
    t95 = t65 + t69
    t96 = t95 - t67 - t66
    t97 = t63 - t61
    t98 = t59 + (t97 - t57)
    t99 = end5 * t60
    t100 = end4 * t62
    t101 = t99 - t100
    t102 = end6 * t56
    t103 = end7 * t58
    t104 = t5 * motion7
    t105 = end0 * t104
    t106 = t5 * motion6
    t107 = end3 * t106
    t108 = t5 * motion5
    t109 = end2 * t108
    t110 = t5 * motion4
    t111 = end1 * t110
    t112 = t101 + t102 + t9 * t92 - t8 * t94 + t10 * t96 + t103 + t105 + t107 + t109 - t111
    t113 = end5 * t62
    t114 = end4 * t60
    t115 = t113 + t114
    t116 = end7 * t56
    t117 = end6 * t58
    t118 = end3 * t104
    t119 = end0 * t106
    t120 = end1 * t108
    t121 = end2 * t110
    t122 = t115 + t116 - t8 * t92 - t9 * t94 + t10 * t98 - t117 + t118 - t119 + t120 + t121
    t123 = start4 * t92 - start5 * t94 + start6 * t96 + start7 * t98 + start0 * t112 + start3 * t122
    t124 = end7 * t60
    t125 = end6 * t62
    t126 = t124 - t125
    t127 = end4 * t56
    t128 = end5 * t58
    t129 = end2 * t104
    t130 = end1 * t106
    t131 = end0 * t108
    t132 = end3 * t110
    t133 = t126 - t127 + t10 * t92 - t9 * t96 + t8 * t98 - t128 + t129 - t130 - t131 - t132
    t134 = end7 * t62
    t135 = end6 * t60
    t136 = t134 + t135
    t137 = end5 * t56
    t138 = end4 * t58
    t139 = end1 * t104
    t140 = end2 * t106
    t141 = end3 * t108
    t142 = end0 * t110
    t143 = t136 - t137 - t10 * t94 - t8 * t96 - t9 * t98 + t138 - t139 - t140 + t141 - t142
    t144 = t93 - t71 - t72
    t145 = t77 + t91 - t78
    t146 = t59 - t97 - t57
    t147 = t67 + (t66 + t95)
    t148 = t118 + (t116 + (t9 * t144 - (t115 + t117) + t8 * t145 + t10 * t146) - t119) - t121 - t120
    t149 = t109 + (t101 - t103 - t8 * t144 + t9 * t145 + t10 * t147 - t102 - t107 - t105 - t111)
    t150 = (
        start4 * t144 + start5 * t145 + start6 * t146 + start7 * t147 + start0 * t148 + start3 *
            t149
    )
    t151 = t142 + (t138 - t136 + t10 * t144 - t9 * t146 + t8 * t147 - t137 - t140 - t139) - t141
    t152 = t130 + (t127 + (t126 + t128 + t10 * t145 - t8 * t146 - t9 * t147)) - t129 - t132 - t131
    t153 = t65 + (t67 - t66 - t69)
    t154 = t61 + (t63 - (t57 + t59))
    t155 = t80 + (t81 + (t77 + t78))
    t156 = t75 + (t72 - t71) - t74
    t157 = t131 + (t128 - t127 - t125 + t9 * t153 + t8 * t154 + t10 * t155 - t124) - t132 - t129
    t158 = t157 - t130
    t159 = t142 + (t141 + (t135 + (t137 + t138 - t134 - t8 * t153 + t9 * t154 + t10 * t156))) - t139
    t160 = t140 + t159
    t161 = (
        start4 * t153 + start5 * t154 + start6 * t155 + start7 * t156 + start0 * t158 + start3 *
            t160
    )
    t162 = (
        t105 + (t111 + (t109 + (t99 + (t100 + (t103 - t102) + t10 * t153 - t9 * t155 + t8 * t156))))
    )
    t163 = t162 - t107
    t164 = t121 + (t113 + (t116 + t117) + t10 * t154 - t8 * t155 - t9 * t156 - t114 - t120) - t118
    t165 = t164 - t119
    t166 = motion10 * t27
    t167 = t32 * t166
    t168 = motion9 * t27
    t169 = t31 * t168
    t170 = t167 - t169
    t171 = motion11 * t27
    t172 = t33 * t171
    t173 = end0 * t168
    t174 = end3 * t166
    t175 = t173 - t174
    t176 = end2 * t171
    t177 = motion8 * t27
    t178 = end1 * t177
    t179 = t175 + t176 - t178
    t180 = end2 * t177
    t181 = end3 * t168
    t182 = end0 * t166
    t183 = t181 + t182
    t184 = end1 * t171
    t185 = t180 + (t183 + t184)
    t186 = end1 * t166
    t187 = end2 * t168
    t188 = t186 + t187
    t189 = end0 * t171
    t190 = end3 * t177
    t191 = t188 - t189 - t190
    t192 = t170 + t172 + t37 * t179 + t35 * t179 - t34 * t185 - t38 * t185 + t39 * t191 + t36 * t191
    t193 = t41 * t177
    t194 = t27 * motion15
    t195 = end0 * t194
    t196 = t27 * motion14
    t197 = end3 * t196
    t198 = t27 * motion13
    t199 = end2 * t198
    t200 = t27 * motion12
    t201 = end1 * t200
    t202 = t192 + t193 + t195 + t197 + t199 - t201
    t203 = t32 * t168
    t204 = t31 * t166
    t205 = t203 + t204
    t206 = t41 * t171
    t207 = end1 * t168
    t208 = end2 * t166
    t209 = t207 - t208
    t210 = end3 * t171
    t211 = end0 * t177
    t212 = t209 - t210 + t211
    t213 = t205 + t206 - t34 * t179 - t38 * t179 - t35 * t185 - t37 * t185 + t39 * t212 + t36 * t212
    t214 = t33 * t177
    t215 = end3 * t194
    t216 = end0 * t196
    t217 = end1 * t198
    t218 = end2 * t200
    t219 = t213 - t214 + t215 - t216 + t217 + t218
    t220 = t41 * t166
    t221 = t33 * t168
    t222 = t220 - t221
    t223 = t31 * t171
    t224 = t222 - t223 + t39 * t179 + t36 * t179 - t35 * t191 - t37 * t191 + t38 * t212 + t34 * t212
    t225 = t32 * t177
    t226 = end2 * t194
    t227 = end1 * t196
    t228 = end0 * t198
    t229 = end3 * t200
    t230 = t224 - t225 + t226 - t227 - t228 - t229
    t231 = t41 * t168
    t232 = t33 * t166
    t233 = t231 + t232
    t234 = t32 * t171
    t235 = t233 - t234 - t39 * t185 - t36 * t185 - t38 * t191 - t34 * t191 - t37 * t212 - t35 * t212
    t236 = t31 * t177
    t237 = end1 * t194
    t238 = end2 * t196
    t239 = end3 * t198
    t240 = end0 * t200
    t241 = t235 + t236 - t237 - t238 + t239 - t240
    t242 = t183 - t180 - t184
    t243 = t175 + t178 - t176
    t244 = t211 - t209 - t210
    t245 = (
        t37 * t242 - (t205 + t214) + t35 * t242 + t34 * t243 + t38 * t243 + t39 * t244 + t36 * t244
    )
    t246 = t215 + (t206 + t245 - t216) - t218 - t217
    t247 = t189 + (t188 + t190)
    t248 = t170 - t193 - t34 * t242 - t38 * t242 + t35 * t243 + t37 * t243 + t39 * t247 + t36 * t247
    t249 = t199 + (t248 - t172 - t197 - t195 - t201)
    t250 = t236 - t233 + t39 * t242 + t36 * t242 - t35 * t244 - t37 * t244 + t38 * t247 + t34 * t247
    t251 = t240 + (t250 - t234 - t238 - t237) - t239
    t252 = t222 + t225 + t39 * t243 + t36 * t243 - t38 * t244 - t34 * t244 - t37 * t247 - t35 * t247
    t253 = t227 + (t223 + t252) - t226 - t229 - t228
    t254 = t186 + (t189 - t190 - t187)
    t255 = t208 + (t207 - (t210 + t211))
    t256 = t174 + (t173 + (t176 + t178))
    t257 = (
        t225 - t223 - t221 + t37 * t254 + t35 * t254 + t34 * t255 + t38 * t255 + t39 * t256 + t36 *
            t256
    )
    t258 = t228 + (t257 - t220) - t229 - t226 - t227
    t259 = t181 + (t184 - t180) - t182
    t260 = (
        t234 + t236 - t231 - t34 * t254 - t38 * t254 + t35 * t255 + t37 * t255 + t39 * t259 + t36 *
            t259
    )
    t261 = t238 + (t240 + (t239 + (t232 + t260)) - t237)
    t262 = t169 + (t193 - t172) + t39 * t254 + t36 * t254 - t35 * t256 - t37 * t256 + t38 * t259
    t263 = t195 + (t201 + (t199 + (t167 + (t262 + t34 * t259)))) - t197
    t264 = t203 + (t206 + t214) + t39 * t255 + t36 * t255 - t38 * t256 - t34 * t256 - t37 * t259
    t265 = t218 + (t264 - t35 * t259 - t204 - t217) - t215 - t216
    t266 = start5 * t92 + start4 * t94 + start7 * t96 - start6 * t98 + start3 * t112 - start0 * t122
    t267 = (
        start5 * t144 - start4 * t145 + start7 * t146 - start6 * t147 + start3 * t148 - start0 *
            t149
    )
    t268 = (
        start5 * t153 - start4 * t154 + start7 * t155 - start6 * t156 + start3 * t158 - start0 *
            t160
    )
    t269 = start6 * t92 + start7 * t94 - start4 * t96 + start5 * t98 - start2 * t112 - start1 * t122
    t270 = (
        start6 * t144 - start7 * t145 - start4 * t146 + start5 * t147 - start2 * t148 - start1 *
            t149
    )
    t271 = (
        start6 * t153 - start7 * t154 - start4 * t155 + start5 * t156 - start2 * t158 - start1 *
            t160
    )
    t272 = start1 * t92
    t273 = start2 * t94
    t274 = start3 * t96
    t275 = start0 * t98
    t276 = start1 * t144
    t277 = start2 * t145
    t278 = start3 * t146
    t279 = start0 * t147
    t280 = start1 * t153
    t281 = start2 * t154
    t282 = start3 * t155
    t283 = start0 * t156
    t284 = start2 * t92
    t285 = start1 * t94
    t286 = start0 * t96
    t287 = start3 * t98
    t288 = start2 * t144
    t289 = start1 * t145
    t290 = start0 * t146
    t291 = start3 * t147
    t292 = start2 * t153
    t293 = start1 * t154
    t294 = start0 * t155
    t295 = start3 * t156
    t296 = start3 * t92 - start0 * t94
    t297 = start1 * t96
    t298 = start2 * t98
    t299 = start3 * t144 + start0 * t145
    t300 = start1 * t146
    t301 = start2 * t147
    t302 = start3 * t153 + start0 * t154
    t303 = start1 * t155
    t304 = start2 * t156
    t305 = -0.5 * (t272 + t273 - t274 - t275)
    t306 = -0.5 * (t276 - t277 - t278 - t279)
    t307 = -0.5 * (t280 - t281 - t282 - t283)
    t308 = -0.5 * (start1 * t179 + start2 * t185 - start3 * t191 - start0 * t212)
    t309 = -0.5 * (start1 * t242 - start2 * t243 - start3 * t244 - start0 * t247)
    t310 = -0.5 * (start1 * t254 - start2 * t255 - start3 * t256 - start0 * t259)
    t311 = -0.5 * (t287 + (t284 - t285 - t286))
    t312 = -0.5 * (t291 + (t288 + t289 - t290))
    t313 = -0.5 * (t295 + (t292 + t293 - t294))
    t314 = -0.5 * (start2 * t179 - start1 * t185 - start0 * t191 + start3 * t212)
    t315 = -0.5 * (start1 * t243 + start2 * t242 - start0 * t244 + start3 * t247)
    t316 = -0.5 * (start1 * t255 + start2 * t254 - start0 * t256 + start3 * t259)
    t317 = -0.5 * (t296 + t297 - t298)
    t318 = -0.5 * (t299 + t300 - t301)
    t319 = -0.5 * (t302 + t303 - t304)
    t320 = -0.5 * (start3 * t179 - start0 * t185 + start1 * t191 - start2 * t212)
    t321 = -0.5 * (start3 * t242 + start0 * t243 + start1 * t244 - start2 * t247)
    t322 = -0.5 * (start3 * t254 + start0 * t255 + start1 * t256 - start2 * t259)
    t323 = start0 * t58
    t324 = start3 * t56
    t325 = t323 - t324
    t326 = start2 * t60
    t327 = start1 * t62
    t328 = t325 - t326 - t327
    t329 = start3 * t58
    t330 = start0 * t56
    t331 = t329 + t330
    t332 = start1 * t60
    t333 = start2 * t62
    t334 = t331 - t332 + t333
    t335 = start1 * t56
    t336 = start2 * t58
    t337 = t335 + t336
    t338 = start0 * t60
    t339 = start3 * t62
    t340 = t337 + t338 - t339
    t341 = start1 * t58
    t342 = start2 * t56
    t343 = t341 - t342
    t344 = start3 * t60
    t345 = start0 * t62
    t346 = t343 + t344 + t345
    t347 = t331 + t333 - t332
    t348 = t326 + (t327 + (t324 - t323))
    t349 = t344 + (t343 + t345)
    t350 = t339 - t337 - t338
    t351 = t339 - t338 - t336 - t335
    t352 = t344 + t345
    t353 = t341 + t352 - t342
    t354 = t326 + t327
    t355 = t323 - t354 - t324
    t356 = t332 - t333
    t357 = t356 - t329 - t330
    t358 = t341 + (t352 - t342)
    t359 = t338 - t339
    t360 = t336 + (t335 + t359)
    t361 = t356 - t330 - t329
    t362 = t323 - (t324 + t354)
    t363 = t11 * t62
    t364 = t12 * t60
    t365 = t363 + t364
    t366 = t14 * t56
    t367 = t15 * t58
    t368 = start0 * t104
    t369 = start3 * t106
    t370 = start2 * t108
    t371 = start1 * t110
    t372 = t365 - t366 - t367 - t368 - t369 - t370 - t371
    t373 = t11 * t60
    t374 = t12 * t62
    t375 = t373 - t374
    t376 = t15 * t56
    t377 = t14 * t58
    t378 = start3 * t104
    t379 = start0 * t106
    t380 = start1 * t108
    t381 = start2 * t110
    t382 = t375 - t376 + t377 - t378 + t379 - t380 + t381
    t383 = start1 * t106
    t384 = start2 * t104
    t385 = t14 * t62
    t386 = t15 * t60
    t387 = t385 + t386
    t388 = t11 * t56
    t389 = t12 * t58
    t390 = start0 * t108
    t391 = start3 * t110
    t392 = t383 - (t384 + (t387 + t388 + t389)) + t390 - t391
    t393 = (
        end4 * t358 + end5 * t360 - end6 * t361 - end7 * t362 + end0 * t372 + end3 * t382 + end2 *
            t392
    )
    t394 = t15 * t62
    t395 = t14 * t60
    t396 = t394 - t395
    t397 = t12 * t56
    t398 = t11 * t58
    t399 = start1 * t104
    t400 = start2 * t106
    t401 = start3 * t108
    t402 = start0 * t110
    t403 = t396 - t397 + t398 + t399 + t400 - t401 - t402
    t404 = t335 + (t336 + t359)
    t405 = t330 + (t329 - t356)
    t406 = t381 + (t379 + (t375 + t377 - t376) - t378) - t380
    t407 = t370 + (t371 + (t368 + (t369 + (t366 + (t367 - t365)))))
    t408 = t399 + (t400 + (t396 + t398 - t397)) - t402 - t401
    t409 = (
        end4 * t404 - end5 * t353 - end6 * t355 - end7 * t405 + end0 * t406 + end3 * t407 + end2 *
            t408
    )
    t410 = t391 + (t384 + (t388 + (t387 + t389) - t383)) - t390
    t411 = t325 - t327 - t326
    t412 = t384 + (t391 + (t386 + (t385 + (t388 + t389)) - t390)) - t383
    t413 = t400 + (t399 + (t394 + (t398 - t397) - t395 - t401 - t402))
    t414 = t364 + (t363 - (t366 + t367)) - t370 - t371 - t368 - t369
    t415 = (
        end4 * t347 + end5 * t411 - end6 * t349 - end7 * t350 + end0 * t412 + end3 * t413 + end2 *
            t414
    )
    t416 = t378 + (t380 + (t374 + (t376 - t377) - t373) - t381) - t379
    t417 = t40 * t168
    t418 = t42 * t166
    t419 = t417 + t418
    t420 = t43 * t171
    t421 = t45 * t177
    t422 = start0 * t168
    t423 = start3 * t166
    t424 = t422 + t423
    t425 = start2 * t171
    t426 = start1 * t177
    t427 = t424 - t425 + t426
    t428 = start0 * t166
    t429 = start3 * t168
    t430 = t428 - t429
    t431 = start1 * t171
    t432 = start2 * t177
    t433 = t430 + t431 + t432
    t434 = start1 * t166
    t435 = start2 * t168
    t436 = t434 - t435
    t437 = start0 * t171
    t438 = start3 * t177
    t439 = t436 - t437 - t438
    t440 = start0 * t194
    t441 = start3 * t196
    t442 = start2 * t198
    t443 = start1 * t200
    t444 = t419 - t420 - t421 + t28 * t427 + t29 * t433 - t30 * t439 - t440 - t441 - t442 - t443
    t445 = t40 * t166
    t446 = t42 * t168
    t447 = t445 - t446
    t448 = t45 * t171
    t449 = t43 * t177
    t450 = start0 * t177
    t451 = start2 * t166
    t452 = start1 * t168
    t453 = t451 + t452
    t454 = start3 * t171
    t455 = t450 - (t453 + t454)
    t456 = start3 * t194
    t457 = start0 * t196
    t458 = start1 * t198
    t459 = start2 * t200
    t460 = t447 - t448 + t449 - t29 * t427 + t28 * t433 - t30 * t455 - t456 + t457 - t458 + t459
    t461 = t43 * t168
    t462 = t45 * t166
    t463 = t461 + t462
    t464 = t40 * t171
    t465 = t42 * t177
    t466 = start2 * t194
    t467 = start1 * t196
    t468 = start0 * t198
    t469 = start3 * t200
    t470 = t30 * t427 - (t463 + t464 + t465) + t28 * t439 - t29 * t455 - t466 + t467 + t468 - t469
    t471 = t45 * t168
    t472 = t43 * t166
    t473 = t471 - t472
    t474 = t42 * t171
    t475 = t40 * t177
    t476 = start1 * t194
    t477 = start2 * t196
    t478 = start3 * t198
    t479 = start0 * t200
    t480 = t473 - t474 + t475 + t30 * t433 + t29 * t439 + t28 * t455 + t476 + t477 - t478 - t479
    t481 = t431 + (t430 + t432)
    t482 = t424 + t426 - t425
    t483 = t450 - t453 - t454
    t484 = t459 + (t457 + (t447 + t449 - t448 + t28 * t481 - t29 * t482 - t30 * t483) - t456) - t458
    t485 = t437 + (t438 - t436)
    t486 = t443 + (t440 + (t441 + (t420 + (t421 - t419) - t29 * t481 - t28 * t482 - t30 * t485)))
    t487 = t442 + t486
    t488 = t476 + (t477 + (t473 + t475 - t474 + t30 * t481 + t28 * t483 - t29 * t485)) - t479 - t478
    t489 = (
        t469 + (t466 + (t464 + (t463 + t465) - t30 * t482 + t29 * t483 + t28 * t485 - t467)) - t468
    )
    t490 = t435 + (t437 + t438) - t434
    t491 = t450 - t454 - t452 - t451
    t492 = t423 + (t422 + (t426 - t425))
    t493 = (
        t466 + (t469 + (t462 + (t461 + (t464 + t465)) + t28 * t490 + t29 * t491 - t30 * t492 -
            t468))
    )
    t494 = t493 - t467
    t495 = t429 - (t431 + t432) - t428
    t496 = t476 + (t471 + (t475 - t474) - t472 - t29 * t490 + t28 * t491 - t30 * t495 - t478 - t479)
    t497 = t477 + t496
    t498 = t418 + (t417 - (t420 + t421)) + t30 * t490 + t28 * t492 - t29 * t495 - t442 - t443 - t440
    t499 = t498 - t441
    t500 = (
        t456 + (t458 + (t446 + (t448 - t449) - t445 + t30 * t491 + t29 * t492 + t28 * t495) - t459)
    )
    t501 = t500 - t457
    t502 = end3 * t347
    t503 = end1 * t349
    t504 = end2 * t350
    t505 = end0 * t353
    t506 = end1 * t355
    t507 = (
        end5 * t358 - end4 * t360 - end7 * t361 + end6 * t362 + end3 * t372 - end0 * t382 - end1 *
            t392
    )
    t508 = (
        end5 * t404 + end4 * t353 - end7 * t355 + end6 * t405 + end3 * t406 - end0 * t407 - end1 *
            t408
    )
    t509 = (
        end5 * t347 - end4 * t411 - end7 * t349 + end6 * t350 + end3 * t412 - end0 * t413 - end1 *
            t414
    )
    t510 = end2 * t347
    t511 = end0 * t349
    t512 = end3 * t350
    t513 = end1 * t353
    t514 = end0 * t355
    t515 = (
        end6 * t358 - end7 * t360 + end4 * t361 - end5 * t362 - end2 * t372 - end1 * t382 + end0 *
            t392
    )
    t516 = (
        end6 * t404 + end7 * t353 + end4 * t355 - end5 * t405 - end2 * t406 - end1 * t407 + end0 *
            t408
    )
    t517 = (
        end6 * t347 - end7 * t411 + end4 * t349 - end5 * t350 - end2 * t412 - end1 * t413 + end0 *
            t414
    )
    return (
        t5 * (motion0 * t3 + t1 * motion2 - t0 * motion1 + motion3 * t2),
        -(t5 * (motion0 * t2 - motion3 * t3 + t0 * motion2 + t1 * motion1)),
        t5 * (motion0 * t1 - t0 * motion3 - t2 * motion1 - motion2 * t3),
        t5 * (t23 + t2 * motion6 - t3 * motion7),
        t5 * (t24 + motion3 * t16 + t3 * motion6),
        t5 * (t25 + motion1 * t18 - t1 * motion7),
        t27 * (t53 + t2 * motion14 - t3 * motion15),
        t27 * (t54 + motion11 * t46 + t3 * motion14),
        t27 * (t55 + motion9 * t48 - t1 * motion15),
        bias_step0,
        bias_step1,
        bias_step2,
        bias_step3,
        bias_step4,
        bias_step5,
        -0.5 * (start0 * t64 + start3 * t70 - start2 * t76 - start1 * t82),
        -0.5 * (start3 * t83 - start0 * t84 + start2 * t85 - start1 * t86),
        -0.5 * (start0 * t87 + start3 * t88 + start2 * t89 - start1 * t90),
        -0.5 * (t123 + start2 * t133 - start1 * t143),
        -0.5 * (t150 + start2 * t151 - start1 * t152),
        -0.5 * (t161 + start2 * t163 - start1 * t165),
        -0.5 * (start0 * t202 + start3 * t219 + start2 * t230 - start1 * t241),
        -0.5 * (start0 * t246 + start3 * t249 + start2 * t251 - start1 * t253),
        -0.5 * (start0 * t258 + start3 * t261 + start2 * t263 - start1 * t265),
        -0.5 * (start3 * t64 - start0 * t70 + start1 * t76 - start2 * t82),
        -(-0.5 * (start3 * t84 + start0 * t83 + start1 * t85 + start2 * t86)),
        -0.5 * (start3 * t87 - start0 * t88 - start1 * t89 - start2 * t90),
        -0.5 * (t266 - start1 * t133 - start2 * t143),
        -0.5 * (t267 - start1 * t151 - start2 * t152),
        -0.5 * (t268 - start1 * t163 - start2 * t165),
        -0.5 * (start3 * t202 - start0 * t219 - start1 * t230 - start2 * t241),
        -0.5 * (start3 * t246 - start0 * t249 - start1 * t251 - start2 * t253),
        -0.5 * (start3 * t258 - start0 * t261 - start1 * t263 - start2 * t265),
        -(-0.5 * (start0 * t76 + (start2 * t64 + start1 * t70) + start3 * t82)),
        -0.5 * (start0 * t85 - (start1 * t83 - start2 * t84) - start3 * t86),
        -0.5 * (start0 * t89 - (start2 * t87 + start1 * t88) - start3 * t90),
        -0.5 * (t269 + start0 * t133 - start3 * t143),
        -0.5 * (t270 + start0 * t151 - start3 * t152),
        -0.5 * (t271 + start0 * t163 - start3 * t165),
        -0.5 * (start0 * t230 - (start2 * t202 + start1 * t219) - start3 * t241),
        -0.5 * (start0 * t251 - (start2 * t246 + start1 * t249) - start3 * t253),
        -0.5 * (start0 * t263 - (start2 * t258 + start1 * t261) - start3 * t265),
        -0.5 * (t272 - t273 + t274 - t275),
        -0.5 * (t276 + t277 + t278 - t279),
        -0.5 * (t280 + t281 + t282 - t283),
        -0.5 * (t284 + t285 - t286 - t287),
        -0.5 * (t288 - t289 - t290 - t291),
        -0.5 * (t292 - t293 - t294 - t295),
        -0.5 * (t296 - t297 + t298),
        -0.5 * (t299 - t300 + t301),
        -0.5 * (t302 - t303 + t304),
        duration * t305,
        duration * t306,
        duration * t307,
        t308,
        t309,
        t310,
        duration * t311,
        duration * t312,
        duration * t313,
        t314,
        t315,
        t316,
        duration * t317,
        duration * t318,
        duration * t319,
        t320,
        t321,
        t322,
        -bias_jacobian0,
        -bias_jacobian1,
        -bias_jacobian2,
        -bias_jacobian3,
        -bias_jacobian4,
        -bias_jacobian5,
        -bias_jacobian6,
        -bias_jacobian7,
        -bias_jacobian8,
        -1.0,
        -bias_jacobian9,
        -bias_jacobian10,
        -bias_jacobian11,
        -bias_jacobian12,
        -bias_jacobian13,
        -bias_jacobian14,
        -bias_jacobian15,
        -bias_jacobian16,
        -bias_jacobian17,
        -1.0,
        -bias_jacobian18,
        -bias_jacobian19,
        -bias_jacobian20,
        -bias_jacobian21,
        -bias_jacobian22,
        -bias_jacobian23,
        -bias_jacobian24,
        -bias_jacobian25,
        -bias_jacobian26,
        -1.0,
        -bias_jacobian27,
        -bias_jacobian28,
        -bias_jacobian29,
        -bias_jacobian30,
        -bias_jacobian31,
        -bias_jacobian32,
        -bias_jacobian33,
        -bias_jacobian34,
        -bias_jacobian35,
        -1.0,
        -bias_jacobian36,
        -bias_jacobian37,
        -bias_jacobian38,
        -bias_jacobian39,
        -bias_jacobian40,
        -bias_jacobian41,
        -bias_jacobian42,
        -bias_jacobian43,
        -bias_jacobian44,
        -1.0,
        -bias_jacobian45,
        -bias_jacobian46,
        -bias_jacobian47,
        -bias_jacobian48,
        -bias_jacobian49,
        -bias_jacobian50,
        -bias_jacobian51,
        -bias_jacobian52,
        -bias_jacobian53,
        -1.0,
        -0.5 * (end0 * t328 + end3 * t334 + end2 * t340 + end1 * t346),
        -0.5 * (end0 * t347 + end3 * t348 - end2 * t349 - end1 * t350),
        -0.5 * (end0 * t351 - end3 * t353 + end2 * t355 - end1 * t357),
        -0.5 * (t393 - end1 * t403),
        -0.5 * (t409 - end1 * t410),
        -0.5 * (t415 - end1 * t416),
        -0.5 * (end0 * t444 + end3 * t460 + end2 * t470 - end1 * t480),
        -0.5 * (end0 * t484 + end3 * t487 + end2 * t488 - end1 * t489),
        -0.5 * (end0 * t494 + end3 * t497 + end2 * t499 - end1 * t501),
        -0.5 * (end3 * t328 - end0 * t334 - end1 * t340 + end2 * t346),
        -0.5 * (t502 - end0 * t348 + t503 - t504),
        -0.5 * (end3 * t351 + t505 - t506 - end2 * t357),
        -0.5 * (t507 - end2 * t403),
        -0.5 * (t508 - end2 * t410),
        -0.5 * (t509 - end2 * t416),
        -0.5 * (end3 * t444 - end0 * t460 - end1 * t470 - end2 * t480),
        -0.5 * (end3 * t484 - end0 * t487 - end1 * t488 - end2 * t489),
        -0.5 * (end3 * t494 - end0 * t497 - end1 * t499 - end2 * t501),
        -0.5 * (end0 * t340 - (end2 * t328 + end1 * t334) + end3 * t346),
        -(-0.5 * (t510 + end1 * t348 + t511 + t512)),
        -0.5 * (t513 - end2 * t351 + t514 - end3 * t357),
        -0.5 * (t515 - end3 * t403),
        -0.5 * (t516 - end3 * t410),
        -0.5 * (t517 - end3 * t416),
        -0.5 * (end0 * t470 - (end2 * t444 + end1 * t460) - end3 * t480),
        -0.5 * (end0 * t488 - (end2 * t484 + end1 * t487) - end3 * t489),
        -0.5 * (end0 * t499 - (end2 * t494 + end1 * t497) - end3 * t501),
        -0.5 * (end1 * t358 + end2 * t360 - end3 * t361 + end0 * t362),
        -0.5 * (end1 * t404 - end2 * t353 - end3 * t355 + end0 * t405),
        -0.5 * (end1 * t347 + end2 * t411 - end3 * t349 + end0 * t350),
        -0.5 * (end2 * t358 - end1 * t360 + end0 * t361 + end3 * t362),
        -0.5 * (t514 + (t513 + end2 * t404) + end3 * t405),
        -0.5 * (t512 + (t511 + (t510 - end1 * t411))),
        -0.5 * (end3 * t358 + end0 * t360 + end1 * t361 - end2 * t362),
        -0.5 * (t506 + (end3 * t404 - t505) - end2 * t405),
        -0.5 * (t503 + (t502 + end0 * t411) - t504),
        -0.5 * (end1 * t427 - end2 * t433 + end3 * t439 + end0 * t455),
        -0.5 * (end1 * t481 + end2 * t482 + end3 * t483 + end0 * t485),
        -0.5 * (end1 * t490 - end2 * t491 + end3 * t492 + end0 * t495),
        -0.5 * (end1 * t433 + end2 * t427 + end0 * t439 - end3 * t455),
        -0.5 * (end0 * t483 - (end1 * t482 - end2 * t481) - end3 * t485),
        -0.5 * (end1 * t491 + end2 * t490 + end0 * t492 - end3 * t495),
        -0.5 * (end3 * t427 + end0 * t433 - end1 * t439 + end2 * t455),
        -0.5 * (end3 * t481 - end0 * t482 - end1 * t483 + end2 * t485),
        -0.5 * (end3 * t490 + end0 * t491 - end1 * t492 + end2 * t495),
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        0.5 * (t6 * t305),
        0.5 * (t6 * t306),
        0.5 * (t6 * t307),
        duration * t308,
        duration * t309,
        duration * t310,
        0.5 * (t6 * t311),
        0.5 * (t6 * t312),
        0.5 * (t6 * t313),
        duration * t314,
        duration * t315,
        duration * t316,
        0.5 * (t6 * t317),
        0.5 * (t6 * t318),
        0.5 * (t6 * t319),
        duration * t320,
        duration * t321,
        duration * t322,
    )

POSE: tuple[tuple[int, int], ...] = (
    (0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0), (0, 1), (1, 1), (2, 1), (3, 1),
    (4, 1), (5, 1), (0, 2), (1, 2), (2, 2), (3, 2), (4, 2), (5, 2), (3, 3), (4, 3),
    (5, 3), (3, 4), (4, 4), (5, 4), (3, 5), (4, 5), (5, 5), (0, 6), (1, 6), (2, 6),
    (3, 6), (4, 6), (5, 6), (0, 7), (1, 7), (2, 7), (3, 7), (4, 7), (5, 7), (0, 8),
    (1, 8), (2, 8), (3, 8), (4, 8), (5, 8), (0, 9), (1, 9), (2, 9), (3, 9), (4, 9),
    (5, 9), (3, 10), (4, 10), (5, 10), (3, 11), (4, 11), (5, 11), (3, 12), (4, 12), (5, 12),
    (3, 13), (4, 13), (5, 13),
)


def pose_f64(pose: Any, twist: Any, imu_T_camera: Any, measured: Any) -> tuple[Any, ...]:
    """What a measured pose misses: rotation, position"""
    pose0, pose1, pose2, pose3, pose4, pose5, pose6, pose7 = (pose[..., i] for i in range(8))
    twist0, twist1, twist2, twist3, twist4, twist5 = (twist[..., i] for i in range(6))
    (
        imu_T_camera0, imu_T_camera1, imu_T_camera2, imu_T_camera3, imu_T_camera4, imu_T_camera5,
        imu_T_camera6, imu_T_camera7
    ) = (imu_T_camera[..., i] for i in range(8))
    (
        measured0, measured1, measured2, measured3, measured4, measured5, measured6, measured7
    ) = (measured[..., i] for i in range(8))
    t0 = (
        pose0 * imu_T_camera0 - pose3 * imu_T_camera3 - pose2 * imu_T_camera2 - pose1 *
            imu_T_camera1
    )
    t1 = (
        pose0 * imu_T_camera3 + imu_T_camera0 * pose3 - imu_T_camera2 * pose1 + pose2 *
            imu_T_camera1
    )
    t2 = (
        pose3 * imu_T_camera1 - pose0 * imu_T_camera2 - imu_T_camera0 * pose2 - imu_T_camera3 *
            pose1
    )
    t3 = (
        pose0 * imu_T_camera1 - imu_T_camera3 * pose2 + imu_T_camera0 * pose1 + pose3 *
            imu_T_camera2
    )
    t4 = (
        np.where((measured0 * t0 + measured3 * t1 - measured2 * t2 + measured1 * t3 < 0.0),
            np.float64(-1.0), np.float64(1.0))
    )
    t5 = -2.0 * t4
    t6 = (
        pose0 * imu_T_camera4 + pose3 * imu_T_camera5 - pose2 * imu_T_camera6 + imu_T_camera0 *
            pose4
    )
    t7 = (
        t6 - pose1 * imu_T_camera7 - imu_T_camera3 * pose5 + imu_T_camera2 * pose6 - imu_T_camera1 *
            pose7
    )
    t8 = (
        pose0 * imu_T_camera5 - pose2 * imu_T_camera7 + imu_T_camera3 * pose4 + pose1 *
            imu_T_camera6
    )
    t9 = (
        t8 + imu_T_camera0 * pose5 - imu_T_camera2 * pose7 - pose3 * imu_T_camera4 - imu_T_camera1 *
            pose6
    )
    t10 = (
        pose0 * imu_T_camera6 - imu_T_camera2 * pose4 + imu_T_camera1 * pose5 + imu_T_camera0 *
            pose6
    )
    t11 = (
        t10 - pose3 * imu_T_camera7 + pose2 * imu_T_camera4 - pose1 * imu_T_camera5 - imu_T_camera3
            * pose7
    )
    t12 = (
        pose0 * imu_T_camera7 + pose3 * imu_T_camera6 + imu_T_camera1 * pose4 + pose1 *
            imu_T_camera4
    )
    t13 = (
        t12 + imu_T_camera3 * pose6 + imu_T_camera0 * pose7 + pose2 * imu_T_camera5 + imu_T_camera2
            * pose5
    )
    t14 = (
        measured0 * t7 - measured3 * t9 + measured2 * t11 - t0 * measured4 + measured1 * t13 + t1 *
            measured5
    )
    t15 = (
        measured0 * t9 + measured2 * t13 - t1 * measured4 - measured1 * t11 - t0 * measured5 + t2 *
            measured7
    )
    t16 = (
        measured0 * t11 - t2 * measured4 - t3 * measured5 - t0 * measured6 + measured3 * t13 -
            measured2 * t7
    )
    t17 = measured0 * t5
    t18 = imu_T_camera0 * t17
    t19 = measured3 * t5
    t20 = imu_T_camera3 * t19
    t21 = measured2 * t5
    t22 = imu_T_camera2 * t21
    t23 = measured1 * t5
    t24 = imu_T_camera1 * t23
    t25 = t18 - t20 - t22 + t24
    t26 = imu_T_camera3 * t17
    t27 = imu_T_camera0 * t19
    t28 = t26 + t27
    t29 = imu_T_camera1 * t21
    t30 = imu_T_camera2 * t23
    t31 = t28 - t29 - t30
    t32 = imu_T_camera1 * t19
    t33 = imu_T_camera2 * t17
    t34 = t32 + t33
    t35 = imu_T_camera0 * t21
    t36 = imu_T_camera3 * t23
    t37 = t34 + t35 + t36
    t38 = imu_T_camera1 * t17
    t39 = imu_T_camera2 * t19
    t40 = t38 - t39
    t41 = imu_T_camera3 * t21
    t42 = imu_T_camera0 * t23
    t43 = t40 + t41 - t42
    t44 = -0.5 * (pose0 * t25 + pose3 * t31 + pose2 * t37 - pose1 * t43)
    t45 = t29 + (t28 + t30)
    t46 = t24 + (t20 - t18) - t22
    t47 = t41 - (t40 + t42)
    t48 = t34 - t36 - t35
    t49 = -0.5 * (pose0 * t45 + pose3 * t46 + pose2 * t47 - pose1 * t48)
    t50 = t32 + (t36 - t35 - t33)
    t51 = t39 + (t38 + (t41 + t42))
    t52 = t20 + (t18 - (t22 + t24))
    t53 = t26 - (t29 - t30) - t27
    t54 = -0.5 * (pose0 * t50 - pose3 * t51 + pose2 * t52 - pose1 * t53)
    t55 = t39 + (t42 - t41) - t38
    t56 = t35 + t36
    t57 = t33 + (t32 + t56)
    t58 = t29 + t30
    t59 = t58 - t27 - t26
    t60 = t24 - t22
    t61 = t18 + (t60 - t20)
    t62 = imu_T_camera4 * t23
    t63 = imu_T_camera5 * t21
    t64 = t62 - t63
    t65 = imu_T_camera6 * t19
    t66 = imu_T_camera7 * t17
    t67 = t5 * measured7
    t68 = imu_T_camera0 * t67
    t69 = t5 * measured6
    t70 = imu_T_camera3 * t69
    t71 = t5 * measured5
    t72 = imu_T_camera2 * t71
    t73 = t5 * measured4
    t74 = imu_T_camera1 * t73
    t75 = t64 - t65 - t66 - t68 - t70 - t72 + t74
    t76 = imu_T_camera6 * t17
    t77 = imu_T_camera5 * t23
    t78 = imu_T_camera4 * t21
    t79 = t77 + t78
    t80 = imu_T_camera7 * t19
    t81 = imu_T_camera3 * t67
    t82 = imu_T_camera0 * t69
    t83 = imu_T_camera1 * t71
    t84 = imu_T_camera2 * t73
    t85 = t76 - (t79 + t80) - t81 + t82 - t83 - t84
    t86 = imu_T_camera6 * t23
    t87 = imu_T_camera7 * t21
    t88 = imu_T_camera4 * t19
    t89 = imu_T_camera5 * t17
    t90 = imu_T_camera2 * t67
    t91 = imu_T_camera1 * t69
    t92 = imu_T_camera0 * t71
    t93 = imu_T_camera3 * t73
    t94 = t86 - t87 + t88 + t89 - t90 + t91 + t92 + t93
    t95 = (
        pose4 * t55 + pose5 * t57 - pose6 * t59 - pose7 * t61 + pose0 * t75 + pose3 * t85 + pose2 *
            t94
    )
    t96 = imu_T_camera7 * t23
    t97 = imu_T_camera6 * t21
    t98 = t96 + t97
    t99 = imu_T_camera5 * t19
    t100 = imu_T_camera4 * t17
    t101 = imu_T_camera1 * t67
    t102 = imu_T_camera2 * t69
    t103 = imu_T_camera3 * t71
    t104 = imu_T_camera0 * t73
    t105 = t98 - t99 + t100 - t101 - t102 + t103 - t104
    t106 = -0.5 * (t95 - pose1 * t105)
    t107 = t56 - t33 - t32
    t108 = t39 + (t41 - t42 - t38)
    t109 = t18 - t60 - t20
    t110 = t27 + (t26 + t58)
    t111 = t83 + (t84 + (t82 + (t76 + t79 - t80) - t81))
    t112 = t74 + (t68 + (t70 + (t65 + (t64 + t66)))) - t72
    t113 = pose4 * t107 + pose5 * t108 - pose6 * t109 - pose7 * t110 + pose0 * t111 + pose3 * t112
    t114 = t103 + (t101 + (t102 + (t99 + (t98 - t100))) - t104)
    t115 = t91 + (t88 + (t89 + (t87 - t86))) - t90 - t93 - t92
    t116 = -0.5 * (t113 + pose2 * t114 - pose1 * t115)
    t117 = t29 + (t27 - t26 - t30)
    t118 = t18 + t20 - t24 - t22
    t119 = t41 + (t42 + (t38 + t39))
    t120 = t36 + (t32 - t33) - t35
    t121 = t91 + (t90 + (t93 + (t87 + (t86 + (t88 - t89)) - t92)))
    t122 = t101 + (t96 - (t99 + t100) - t97 - t103 - t104) - t102
    t123 = pose4 * t117 + pose5 * t118 - pose6 * t119 - pose7 * t120 + pose0 * t121 + pose3 * t122
    t124 = t70 + (t65 - t66 - t62 - t63 - t72 - t74 - t68)
    t125 = t84 + (t77 + (t76 + t80) - t78 - t83) - t81 - t82
    t126 = -0.5 * (t123 + pose2 * t124 - pose1 * t125)
    t127 = -0.5 * (pose3 * t25 - pose0 * t31 - pose1 * t37 - pose2 * t43)
    t128 = -0.5 * (pose3 * t45 - pose0 * t46 - pose1 * t47 - pose2 * t48)
    t129 = -0.5 * (pose3 * t50 + pose0 * t51 - pose1 * t52 - pose2 * t53)
    t130 = (
        pose5 * t55 - pose4 * t57 - pose7 * t59 + pose6 * t61 + pose3 * t75 - pose0 * t85 - pose1 *
            t94
    )
    t131 = -0.5 * (t130 - pose2 * t105)
    t132 = pose5 * t107 - pose4 * t108 - pose7 * t109 + pose6 * t110 + pose3 * t111 - pose0 * t112
    t133 = -0.5 * (t132 - pose1 * t114 - pose2 * t115)
    t134 = pose5 * t117 - pose4 * t118 - pose7 * t119 + pose6 * t120 + pose3 * t121 - pose0 * t122
    t135 = -0.5 * (t134 - pose1 * t124 - pose2 * t125)
    t136 = -0.5 * (pose0 * t37 - (pose2 * t25 + pose1 * t31) - pose3 * t43)
    t137 = -0.5 * (pose0 * t47 - (pose2 * t45 + pose1 * t46) - pose3 * t48)
    t138 = -0.5 * (pose0 * t52 - (pose2 * t50 - pose1 * t51) - pose3 * t53)
    t139 = (
        pose6 * t55 - pose7 * t57 + pose4 * t59 - pose5 * t61 - pose2 * t75 - pose1 * t85 + pose0 *
            t94
    )
    t140 = -0.5 * (t139 - pose3 * t105)
    t141 = pose6 * t107 - pose7 * t108 + pose4 * t109 - pose5 * t110 - pose2 * t111 - pose1 * t112
    t142 = -0.5 * (t141 + pose0 * t114 - pose3 * t115)
    t143 = pose6 * t117 - pose7 * t118 + pose4 * t119 - pose5 * t120 - pose2 * t121 - pose1 * t122
    t144 = -0.5 * (t143 + pose0 * t124 - pose3 * t125)
    t145 = -0.5 * (pose1 * t55 + pose2 * t57 - pose3 * t59 + pose0 * t61)
    t146 = -0.5 * (pose1 * t107 + pose2 * t108 - pose3 * t109 + pose0 * t110)
    t147 = -0.5 * (pose1 * t117 + pose2 * t118 - pose3 * t119 + pose0 * t120)
    t148 = -0.5 * (pose2 * t55 - pose1 * t57 + pose0 * t59 + pose3 * t61)
    t149 = -0.5 * (pose2 * t107 - pose1 * t108 + pose0 * t109 + pose3 * t110)
    t150 = -0.5 * (pose2 * t117 - pose1 * t118 + pose0 * t119 + pose3 * t120)
    t151 = -0.5 * (pose3 * t55 + pose0 * t57 + pose1 * t59 - pose2 * t61)
    t152 = -0.5 * (pose3 * t107 + pose0 * t108 + pose1 * t109 - pose2 * t110)
    t153 = -0.5 * (pose3 * t117 + pose0 * t118 + pose1 * t119 - pose2 * t120)
    t154 = (
        t151 * twist5 + t148 * twist4 + t145 * twist3 + t106 * twist0 + t131 * twist1 + t140 *
            twist2
    )
    t155 = (
        t152 * twist5 + t149 * twist4 + t146 * twist3 + t116 * twist0 + t133 * twist1 + t142 *
            twist2
    )
    t156 = (
        t153 * twist5 + t150 * twist4 + t147 * twist3 + t126 * twist0 + t135 * twist1 + t144 *
            twist2
    )
    t157 = pose0 * t17
    t158 = pose3 * t19
    t159 = t157 + t158
    t160 = pose2 * t21
    t161 = pose1 * t23
    t162 = t159 + t160 + t161
    t163 = pose0 * t19
    t164 = pose3 * t17
    t165 = t163 - t164
    t166 = pose1 * t21
    t167 = pose2 * t23
    t168 = t165 + t166 - t167
    t169 = pose0 * t21
    t170 = pose2 * t17
    t171 = pose1 * t19
    t172 = t170 + t171
    t173 = pose3 * t23
    t174 = t169 - t172 + t173
    t175 = pose1 * t17
    t176 = pose2 * t19
    t177 = t175 - t176
    t178 = pose3 * t21
    t179 = pose0 * t23
    t180 = t177 + t178 - t179
    t181 = imu_T_camera0 * t162 + imu_T_camera3 * t168 + imu_T_camera2 * t174 - imu_T_camera1 * t180
    t182 = t166 + (t165 - t167)
    t183 = t160 + (t159 + t161)
    t184 = t178 + (t177 - t179)
    t185 = t172 - t173 - t169
    t186 = imu_T_camera0 * t182 - imu_T_camera3 * t183 + imu_T_camera2 * t184 - imu_T_camera1 * t185
    t187 = t169 + t173
    t188 = t187 - t170
    t189 = t171 - t188
    t190 = t175 + (t178 - t179) - t176
    t191 = t160 + t161
    t192 = t158 + (t157 + t191)
    t193 = t166 - t167
    t194 = t164 - t193 - t163
    t195 = imu_T_camera0 * t189 + imu_T_camera3 * t190 + imu_T_camera2 * t192 - imu_T_camera1 * t194
    t196 = t176 + (t179 - t178) - t175
    t197 = t187 - t171 - t170
    t198 = t164 - (t163 + t193)
    t199 = t157 + (t158 + t191)
    t200 = imu_T_camera4 * t196 + imu_T_camera5 * t197 - imu_T_camera6 * t198 - imu_T_camera7 * t199
    t201 = pose4 * t23
    t202 = pose5 * t21
    t203 = t201 + t202
    t204 = pose6 * t19
    t205 = pose7 * t17
    t206 = pose0 * t67
    t207 = pose3 * t69
    t208 = pose2 * t71
    t209 = pose1 * t73
    t210 = t203 + t204 - t205 - t206 + t207 + t208 + t209
    t211 = pose4 * t21
    t212 = pose5 * t23
    t213 = t211 - t212
    t214 = pose7 * t19
    t215 = pose6 * t17
    t216 = pose3 * t67
    t217 = pose0 * t69
    t218 = pose1 * t71
    t219 = pose2 * t73
    t220 = t213 - t214 - t215 + t216 + t217 + t218 - t219
    t221 = pose6 * t23
    t222 = pose7 * t21
    t223 = pose4 * t19
    t224 = pose5 * t17
    t225 = pose2 * t67
    t226 = pose1 * t69
    t227 = pose0 * t71
    t228 = pose3 * t73
    t229 = t221 - t222 - t223 - t224 + t225 - t226 + t227 + t228
    t230 = pose7 * t23
    t231 = pose6 * t21
    t232 = t230 + t231
    t233 = pose5 * t19
    t234 = pose4 * t17
    t235 = pose1 * t67
    t236 = pose2 * t69
    t237 = pose3 * t71
    t238 = pose0 * t73
    t239 = t232 - t233 + t234 - t235 - t236 + t237 - t238
    t240 = (
        t200 + imu_T_camera0 * t210 + imu_T_camera3 * t220 + imu_T_camera2 * t229 - imu_T_camera1 *
            t239
    )
    t241 = t188 - t171
    t242 = t163 + (t193 - t164)
    t243 = imu_T_camera4 * t241 + imu_T_camera5 * t190 - imu_T_camera6 * t192 - imu_T_camera7 * t242
    t244 = t218 + (t216 + (t217 + (t213 - t215 - t214)) - t219)
    t245 = t206 + (t205 - t203 - t204 - t207) - t209 - t208
    t246 = t237 + (t232 + t234 - t233 - t236 - t235 - t238)
    t247 = t226 + (t223 + (t224 + (t222 - t221))) - t225 - t228 - t227
    t248 = (
        t243 + imu_T_camera0 * t244 + imu_T_camera3 * t245 + imu_T_camera2 * t246 - imu_T_camera1 *
            t247
    )
    t249 = t179 - t177 - t178
    t250 = imu_T_camera4 * t182 + imu_T_camera5 * t183 - imu_T_camera6 * t249 - imu_T_camera7 * t185
    t251 = t226 + (t222 + (t223 + t224 - t221) - t227 - t228 - t225)
    t252 = t237 + (t231 + (t230 + (t234 - t233))) - t238 - t235 - t236
    t253 = t207 + (t209 + (t208 + (t202 + (t201 + (t204 - t205)))) - t206)
    t254 = t219 + (t212 + (t214 + t215) - t211 - t218) - t216 - t217
    t255 = (
        t250 + imu_T_camera0 * t251 + imu_T_camera3 * t252 + imu_T_camera2 * t253 - imu_T_camera1 *
            t254
    )
    t256 = imu_T_camera3 * t162 - imu_T_camera0 * t168 - imu_T_camera1 * t174 - imu_T_camera2 * t180
    t257 = imu_T_camera3 * t182 + imu_T_camera0 * t183
    t258 = imu_T_camera2 * t185
    t259 = imu_T_camera0 * t190
    t260 = imu_T_camera1 * t192
    t261 = imu_T_camera5 * t196 - imu_T_camera4 * t197 - imu_T_camera7 * t198 + imu_T_camera6 * t199
    t262 = (
        t261 + imu_T_camera3 * t210 - imu_T_camera0 * t220 - imu_T_camera1 * t229 - imu_T_camera2 *
            t239
    )
    t263 = imu_T_camera5 * t241 - imu_T_camera4 * t190 - imu_T_camera7 * t192 + imu_T_camera6 * t242
    t264 = (
        t263 + imu_T_camera3 * t244 - imu_T_camera0 * t245 - imu_T_camera1 * t246 - imu_T_camera2 *
            t247
    )
    t265 = imu_T_camera5 * t182 - imu_T_camera4 * t183 - imu_T_camera7 * t249 + imu_T_camera6 * t185
    t266 = (
        t265 + imu_T_camera3 * t251 - imu_T_camera0 * t252 - imu_T_camera1 * t253 - imu_T_camera2 *
            t254
    )
    t267 = (
        imu_T_camera0 * t174 - (imu_T_camera2 * t162 + imu_T_camera1 * t168) - imu_T_camera3 * t180
    )
    t268 = imu_T_camera2 * t182 - imu_T_camera1 * t183
    t269 = imu_T_camera3 * t185
    t270 = imu_T_camera0 * t192
    t271 = imu_T_camera1 * t190
    t272 = imu_T_camera6 * t196 - imu_T_camera7 * t197 + imu_T_camera4 * t198 - imu_T_camera5 * t199
    t273 = (
        t272 - imu_T_camera2 * t210 - imu_T_camera1 * t220 + imu_T_camera0 * t229 - imu_T_camera3 *
            t239
    )
    t274 = imu_T_camera6 * t241 - imu_T_camera7 * t190 + imu_T_camera4 * t192 - imu_T_camera5 * t242
    t275 = (
        t274 - imu_T_camera2 * t244 - imu_T_camera1 * t245 + imu_T_camera0 * t246 - imu_T_camera3 *
            t247
    )
    t276 = imu_T_camera6 * t182 - imu_T_camera7 * t183 + imu_T_camera4 * t249 - imu_T_camera5 * t185
    t277 = (
        t276 - imu_T_camera2 * t251 - imu_T_camera1 * t252 + imu_T_camera0 * t253 - imu_T_camera3 *
            t254
    )
    t278 = imu_T_camera1 * t196 + imu_T_camera2 * t197 - imu_T_camera3 * t198 + imu_T_camera0 * t199
    t279 = imu_T_camera1 * t241 + imu_T_camera2 * t190 - imu_T_camera3 * t192 + imu_T_camera0 * t242
    t280 = imu_T_camera1 * t182 + imu_T_camera2 * t183 - imu_T_camera3 * t249 + imu_T_camera0 * t185
    t281 = imu_T_camera2 * t196 - imu_T_camera1 * t197 + imu_T_camera0 * t198 + imu_T_camera3 * t199
    t282 = imu_T_camera3 * t196 + imu_T_camera0 * t197 + imu_T_camera1 * t198 - imu_T_camera2 * t199
    return (
        t5 * (measured0 * t3 + t1 * measured2 - t0 * measured1 + measured3 * t2),
        -(t5 * (measured0 * t2 - measured3 * t3 + t0 * measured2 + t1 * measured1)),
        t5 * (measured0 * t1 - t0 * measured3 - t2 * measured1 - measured2 * t3),
        t5 * (t14 + t2 * measured6 - t3 * measured7),
        t5 * (t15 + measured3 * t7 + t3 * measured6),
        t5 * (t16 + measured1 * t9 - t1 * measured7),
        t44,
        t49,
        t54,
        t106,
        t116,
        t126,
        t127,
        t128,
        t129,
        t131,
        t133,
        t135,
        t136,
        t137,
        t138,
        t140,
        t142,
        t144,
        t145,
        t146,
        t147,
        t148,
        t149,
        t150,
        t151,
        t152,
        t153,
        t44 * twist0 + t127 * twist1 + t136 * twist2,
        t49 * twist0 + t128 * twist1 + t137 * twist2,
        t54 * twist0 + t129 * twist1 + t138 * twist2,
        t154,
        t155,
        t156,
        -0.5 * t181,
        -0.5 * t186,
        -0.5 * t195,
        -0.5 * t240,
        -0.5 * t248,
        -0.5 * t255,
        -0.5 * t256,
        -0.5 * (t257 - imu_T_camera1 * t184 - t258),
        -0.5 * (imu_T_camera3 * t189 - t259 - t260 - imu_T_camera2 * t194),
        -0.5 * t262,
        -0.5 * t264,
        -0.5 * t266,
        -0.5 * t267,
        -0.5 * (imu_T_camera0 * t184 - t268 - t269),
        -0.5 * (t270 - (imu_T_camera2 * t189 + t271) - imu_T_camera3 * t194),
        -0.5 * t273,
        -0.5 * t275,
        -0.5 * t277,
        -0.5 * t278,
        -0.5 * t279,
        -0.5 * t280,
        -0.5 * t281,
        -0.5 * (t270 + (imu_T_camera2 * t241 - t271) + imu_T_camera3 * t242),
        -0.5 * (t269 + (t268 + imu_T_camera0 * t249)),
        -0.5 * t282,
        -0.5 * (t260 + (t259 + imu_T_camera3 * t241) - imu_T_camera2 * t242),
        -0.5 * (t257 + imu_T_camera1 * t249 - t258),
        t9 * t19 - (t13 * t23 + t11 * t21) - t7 * t17,
        t11 * t23 - t13 * t21 - t9 * t17 - t7 * t19,
        t7 * t21 - (t13 * t19 + t11 * t17 + t9 * t23),
    )
