/* Kernels of the group similarity_long_spirals: similarity_interpolate_long.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_interpolate_long: Spiral a exp(fraction log(~a b)), by the signs of a and b
 * in a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_interpolate_long_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict a_at = inputs[0];
    const ptrdiff_t a_step = input_steps[0];
    const float *restrict b_at = inputs[1];
    const ptrdiff_t b_step = input_steps[1];
    const float *restrict fraction_at = inputs[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const float a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const float a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const float b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5 *
            b5);
        const float t1 = a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5 + a6 *
            b5);
        const float t2 = b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 * a6 - b7
            * a5);
        const float t3 = a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 * a6) + a7
            * b6);
        const float t4 = sqrtf(t0 * t0 + t1 * t1 + t2 * t2 + t3 * t3);
        const float t5 = 1.0f / t4;
        const float t6 = t0 * t5;
        const float t7 = t3 * t5;
        const float t8 = t2 * t5;
        const float t9 = t1 * t5;
        const float t10 = t7 * t7 + t8 * t8 + t9 * t9;
        const float t11 = 1.0f - fabsf(t6);
        const float t12 = t11 * (t11 * (t11 * (0.007290418f * t11 + -0.024990348f) + 0.04353618f) +
            -0.037681058f);
        const float t13 = t11 * (t11 * (t11 * (t11 * (t12 + 0.02876297f) + 0.00298998f) +
            0.02730914f) + 0.056896698f);
        const float t14 = t11 * (t11 * (t13 + 0.13334942f) + 0.33333293f) + 1.0f;
        const float t15 = ((t6 < 0.0f) ? 3.1415927f / sqrtf(largerf(t10, 1.6940659e-21f)) - t14 :
            t14);
        const float t16 = t7 * t15 * fraction;
        const float t17 = fraction * (t8 * t15);
        const float t18 = fraction * (t9 * t15);
        const float t19 = t16 * t16 + t17 * t17 + t18 * t18;
        const float t20 = sqrtf(t19);
        const float t21 = floorf(0.31830987f * t20 + 0.5f);
        const float t22 = 1.0f - 2.0f * (t21 - floorf(0.5f * t21) * 2.0f);
        const float t23 = t20 - t21 * 3.140625f - t21 * 0.0009675026f - t21 * 1.5099067e-07f - t21 *
            5.126688e-12f;
        const float t24 = t23 * t23;
        const float t25 = t24 * (t24 * (-2.6050063e-07f * t24 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t26 = t22 * (t24 * (t24 * t25 + -0.5f) + 1.0f);
        const float t27 = t6 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 * a6
            + b1 * a5));
        const float t28 = t9 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 * a5
            + b1 * a6));
        const float t29 = t8 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 *
            a6 - b3 * a5));
        const float t30 = t7 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 *
            a6) + b2 * a7));
        const float t31 = t27 + t28 + t29 + t30;
        const float t32 = fabsf(t31);
        const float t33 = t4 + t32;
        const float t34 = exponentf(1.4142135f * t33);
        const _Bool t35 = (t34 < 0.5f);
        const float t36 = t33 * exp2_of_integerf(-t34);
        const float t37 = (t35 ? t32 : 0.5f * (t36 - 1.0f / t36));
        const float t38 = t37 * t37;
        const float t39 = t38 * (t38 * (t38 * (0.024318371f * t38 + -0.044006806f) + 0.07497201f) +
            -0.16666622f);
        const float t40 = t39 + 1.0f;
        const float t41 = (t35 ? t40 : (t34 * 0.69311523f + (t34 * 3.1946183e-05f + t37 * t40)) /
            largerf(t32, 0.25f));
        const float t42 = fraction * (t31 * t41);
        const float t43 = floorf(0.5f + 1.442695f * t42);
        const float t44 = exp2_of_integerf(t43);
        const float t45 = exp2_of_integerf(-t43);
        const float t46 = 0.5f * (t44 + t45);
        const float t47 = t42 - 0.69311523f * t43 - 3.1946183e-05f * t43;
        const float t48 = t47 * t47;
        const float t49 = t48 * (t48 * (0.0013949076f * t48 + 0.04166621f) + 0.5f) + 1.0f;
        const float t50 = 0.5f * (t44 - t45);
        const float t51 = t48 * (t48 * (t48 * 0.00019908122f + 0.008333283f) + 0.16666667f) + 1.0f;
        const float t52 = t47 * t51;
        const float t53 = t46 * t49 + t50 * t52;
        const float t54 = t26 * t53;
        const float t55 = t24 * (t24 * (t24 * (t24 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t56 = t55 + 1.0f;
        const float t57 = ((t21 < 0.5f) ? t56 : t56 * (t22 * t23) / largerf(1.0f, t20));
        const float t58 = t18 * t57;
        const float t59 = t53 * t58;
        const float t60 = t17 * t57;
        const float t61 = t53 * t60;
        const float t62 = t16 * t57;
        const float t63 = t53 * t62;
        const float t64 = t49 * t50 + t46 * t52;
        const float t65 = t26 * t64;
        const float t66 = t58 * t64;
        const float t67 = t60 * t64;
        const float t68 = t62 * t64;
        const float t69 = a0 * t54 - a3 * t59 + a2 * t61 - a1 * t63 + (a4 * t65 - a7 * t66 + a6 *
            t67 - a5 * t68);
        const float t70 = a0 * t63 - a2 * t59 + a1 * t54 - a3 * t61 + (a4 * t68 - a6 * t66 + a5 *
            t65 - a7 * t67);
        const float t71 = a0 * t61 + a3 * t63 - a2 * t54 - a1 * t59 + (a4 * t67 + a7 * t68 - a6 *
            t65 - a5 * t66);
        const float t72 = a0 * t59 + a3 * t54 + a1 * t61 + a2 * t63 + (a4 * t66 + a7 * t65 + a5 *
            t67 + a6 * t68);
        const float t73 = a0 * t65 - a3 * t66 + a2 * t67 - a1 * t68 + (a4 * t54 - a7 * t59 + a6 *
            t61 - a5 * t63);
        const float t74 = a0 * t68 - a2 * t66 + a1 * t65 - a3 * t67 + (a4 * t63 - a6 * t59 + a5 *
            t54 - a7 * t61);
        const float t75 = a0 * t67 + a3 * t68 - a2 * t65 - a1 * t66 + (a4 * t61 + a7 * t63 - a6 *
            t54 - a5 * t59);
        const float t76 = a0 * t66 + a3 * t65 + a1 * t67 + a2 * t68 + (a4 * t59 + a7 * t54 + a5 *
            t61 + a6 * t63);
        const float t77 = a0 + a4;
        const float t78 = a0 - a4;
        const float t79 = a7 - a3;
        const float t80 = a2 - a6;
        const float t81 = a5 - a1;
        const float t82 = b3 - b7;
        const float t83 = b0 - b4;
        const float t84 = b6 - b2;
        const float t85 = b1 - b5;
        const float t86 = t78 * b8 + t79 * b9 + t80 * b10 - t81 * b11 + (a9 * t82 - a8 * t83 + a10 *
            t84 - a11 * t85);
        const float t87 = t78 * b11 + t79 * b10 + b8 * t81 - b9 * t80 + (t83 * a11 - (a8 * t85 + t82
            * a10) + a9 * t84);
        const float t88 = t78 * b10 - t79 * b11 - b8 * t80 - b9 * t81 - (a8 * t84 + a9 * t85 + t83 *
            a10 + t82 * a11);
        const float t89 = t7 * t88 - t9 * t86;
        const float t90 = t78 * b9 + t80 * b11 + b10 * t81 - b8 * t79 + (t84 * a11 - (t82 * a8 + a9
            * t83) + a10 * t85);
        const float t91 = t8 * t86 + t7 * t90;
        const float t92 = 1.0f / largerf(1.6940659e-21f, t10 + t31 * t31);
        const float t93 = (t6 * t41 - t4 * t15) * t92;
        const float t94 = t9 * t90 + t8 * t88;
        const float t95 = t92 * (t31 * (t6 * t15 - t4 * t41));
        const float t96 = fraction * (t41 * (t6 * t86 + t7 * t87) + (t9 * t89 - t8 * t91) * t93 +
            t94 * t95);
        const float t97 = ((fabsf(t43) < 0.5f) ? t51 : fabsf(t64) / largerf(0.25f, fabsf(t42)));
        const float t98 = t26 * t97;
        const float t99 = fraction * (t41 * (t6 * t90 - t8 * t87) - t93 * (t7 * t91 + t9 * t94) +
            t89 * t95);
        const float t100 = fraction * (t41 * (t6 * t88 + t9 * t87) - t93 * (t8 * t94 + t7 * t89) -
            t91 * t95);
        const float t101 = t18 * t99 + t17 * t100;
        const float t102 = t16 * t100 - t18 * t96;
        const float t103 = t17 * t96 + t16 * t99;
        const float t104 = (t53 * t57 - t98) / largerf(1.6940659e-21f, t19 + t42 * t42);
        const float t105 = t96 * t98 + (t42 * t101 - (t18 * t102 - t17 * t103)) * t104;
        const float t106 = a3 + a7;
        const float t107 = t98 * t99 + t104 * (t42 * t102 + (t16 * t103 + t18 * t101));
        const float t108 = a2 + a6;
        const float t109 = t98 * t100 + t104 * (t17 * t101 + t16 * t102 - t42 * t103);
        const float t110 = a1 + a5;
        const float t111 = (t18 * t100 + t16 * t96 - t17 * t99) * (t57 * t97);
        const float t112 = t54 - t65;
        const float t113 = t59 - t66;
        const float t114 = t61 - t67;
        const float t115 = t63 - t68;
        const float t116 = t77 * t105 + t106 * t107 - t108 * t109 - t110 * t111 + (a8 * t112 - a9 *
            t113 - a10 * t114 - a11 * t115);
        const float t117 = t77 * t107 - t108 * t111 + t109 * t110 - t105 * t106 + (a8 * t113 + a9 *
            t112 + a11 * t114 - a10 * t115);
        const float t118 = t77 * t109 - t106 * t111 + t105 * t108 - t107 * t110 + (a8 * t114 + a9 *
            t115 + a10 * t112 - a11 * t113);
        const float t119 = t77 * t111 + t106 * t109 + t105 * t110 + t107 * t108 + (a8 * t115 + a10 *
            t113 + a11 * t112 - a9 * t114);
        out_at[i] = t69;
        out_at[out_step + i] = t70;
        out_at[2 * out_step + i] = -t71;
        out_at[3 * out_step + i] = t72;
        out_at[4 * out_step + i] = t73;
        out_at[5 * out_step + i] = t74;
        out_at[6 * out_step + i] = -t75;
        out_at[7 * out_step + i] = t76;
        out_at[8 * out_step + i] = t116;
        out_at[9 * out_step + i] = t117;
        out_at[10 * out_step + i] = t118;
        out_at[11 * out_step + i] = t119;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_interpolate_long_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict a_at = inputs[0];
    const ptrdiff_t a_step = input_steps[0];
    const double *restrict b_at = inputs[1];
    const ptrdiff_t b_step = input_steps[1];
    const double *restrict fraction_at = inputs[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const double a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const double a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const double b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5
            * b5);
        const double t1 = a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5 + a6
            * b5);
        const double t2 = b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 * a6 -
            b7 * a5);
        const double t3 = a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 * a6) +
            a7 * b6);
        const double t4 = sqrt(t0 * t0 + t1 * t1 + t2 * t2 + t3 * t3);
        const double t5 = 1.0 / t4;
        const double t6 = t0 * t5;
        const double t7 = t3 * t5;
        const double t8 = t2 * t5;
        const double t9 = t1 * t5;
        const double t10 = t7 * t7 + t8 * t8 + t9 * t9;
        const double t11 = 1.0 - fabs(t6);
        const double t12 = t11 * (t11 * (8.121007252839173e-05 * t11 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t13 = t11 * (t11 * (t12 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t14 = t11 * (t11 * (t11 * t13 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t15 = t11 * (t11 * (t11 * t14 + -0.0053548548506220615) +
            0.0022588396994592773) + -0.00039674989569360273;
        const double t16 = t11 * (t11 * (t11 * t15 + 0.0007138968794314861) + 0.0011403814338107978)
            + 0.002490569286343547;
        const double t17 = t11 * (t11 * (t11 * t16 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t18 = t11 * (t11 * (t11 * t17 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t19 = 1.0 + t11 * t18;
        const double t20 = ((t6 < 0.0) ? 3.141592653589793 / sqrt(larger(t10,
            1.0947644252537633e-47)) - t19 : t19);
        const double t21 = t7 * t20 * fraction;
        const double t22 = fraction * (t8 * t20);
        const double t23 = fraction * (t9 * t20);
        const double t24 = t21 * t21 + t22 * t22 + t23 * t23;
        const double t25 = sqrt(t24);
        const double t26 = floor(0.3183098861837907 * t25 + 0.5);
        const double t27 = 1.0 - 2.0 * (t26 - floor(0.5 * t26) * 2.0);
        const double t28 = t25 - t26 * 3.1415926218032837 - t26 * 3.1786509424591713e-08 - t26 *
            1.2246467202362698e-16;
        const double t29 = t28 - t26 * 7.891108333126411e-24;
        const double t30 = t29 * t29;
        const double t31 = t30 * (4.608909074888812e-14 * t30 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t32 = t30 * (t30 * (t30 * t31 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t33 = t27 * (1.0 + t30 * (t30 * (t30 * t32 + 0.041666666666663875) +
            -0.4999999999999997));
        const double t34 = t6 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 *
            a6 + b1 * a5));
        const double t35 = t9 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 *
            a5 + b1 * a6));
        const double t36 = t8 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 *
            a6 - b3 * a5));
        const double t37 = t7 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 *
            a6) + b2 * a7));
        const double t38 = t34 + t35 + t36 + t37;
        const double t39 = fabs(t38);
        const double t40 = t4 + t39;
        const double t41 = exponent(1.4142135623730951 * t40);
        const _Bool t42 = (t41 < 0.5);
        const double t43 = t40 * exp2_of_integer(-t41);
        const double t44 = (t42 ? t39 : 0.5 * (t43 - 1.0 / t43));
        const double t45 = t44 * t44;
        const double t46 = t45 * (t45 * (-0.005811206588331519 * t45 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t47 = t45 * (t45 * (t46 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t48 = t45 * (t45 * (t45 * t47 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        const double t49 = 1.0 + t45 * t48;
        const double t50 = (t41 * 0.6931471675634384 + (t41 * 1.2996506893889889e-08 + t44 * t49)) /
            larger(t39, 0.25);
        const double t51 = (t42 ? t49 : t50);
        const double t52 = fraction * (t38 * t51);
        const double t53 = floor(0.5 + 1.4426950408889634 * t52);
        const double t54 = exp2_of_integer(t53);
        const double t55 = exp2_of_integer(-t53);
        const double t56 = 0.5 * (t54 + t55);
        const double t57 = t52 - 0.6931471675634384 * t53 - 1.2996506893889889e-08 * t53;
        const double t58 = t57 * t57;
        const double t59 = t58 * (t58 * (2.763326749998937e-07 * t58 + 2.480148377847191e-05) +
            0.001388888895391314);
        const double t60 = 1.0 + t58 * (t58 * (t59 + 0.04166666666648207) + 0.5000000000000019);
        const double t61 = 0.5 * (t54 - t55);
        const double t62 = t58 * (t58 * 2.5110520415965448e-08 + 2.755723960835094e-06) +
            0.00019841269891276224;
        const double t63 = 1.0 + t58 * (t58 * (t58 * t62 + 0.008333333333319138) +
            0.16666666666666682);
        const double t64 = t57 * t63;
        const double t65 = t56 * t60 + t61 * t64;
        const double t66 = t33 * t65;
        const double t67 = t30 * (t30 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t68 = t30 * (t30 * (t30 * t67 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t69 = 1.0 + t30 * (t30 * (t30 * t68 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t70 = ((t26 < 0.5) ? t69 : t69 * (t27 * t29) / larger(1.0, t25));
        const double t71 = t23 * t70;
        const double t72 = t65 * t71;
        const double t73 = t22 * t70;
        const double t74 = t65 * t73;
        const double t75 = t21 * t70;
        const double t76 = t65 * t75;
        const double t77 = t60 * t61 + t56 * t64;
        const double t78 = t33 * t77;
        const double t79 = t71 * t77;
        const double t80 = t73 * t77;
        const double t81 = t75 * t77;
        const double t82 = a0 * t66 - a3 * t72 + a2 * t74 - a1 * t76 + (a4 * t78 - a7 * t79 + a6 *
            t80 - a5 * t81);
        const double t83 = a0 * t76 - a2 * t72 + a1 * t66 - a3 * t74 + (a4 * t81 - a6 * t79 + a5 *
            t78 - a7 * t80);
        const double t84 = a0 * t74 + a3 * t76 - a2 * t66 - a1 * t72 + (a4 * t80 + a7 * t81 - a6 *
            t78 - a5 * t79);
        const double t85 = a0 * t72 + a3 * t66 + a1 * t74 + a2 * t76 + (a4 * t79 + a7 * t78 + a5 *
            t80 + a6 * t81);
        const double t86 = a0 * t78 - a3 * t79 + a2 * t80 - a1 * t81 + (a4 * t66 - a7 * t72 + a6 *
            t74 - a5 * t76);
        const double t87 = a0 * t81 - a2 * t79 + a1 * t78 - a3 * t80 + (a4 * t76 - a6 * t72 + a5 *
            t66 - a7 * t74);
        const double t88 = a0 * t80 + a3 * t81 - a2 * t78 - a1 * t79 + (a4 * t74 + a7 * t76 - a6 *
            t66 - a5 * t72);
        const double t89 = a0 * t79 + a3 * t78 + a1 * t80 + a2 * t81 + (a4 * t72 + a7 * t66 + a5 *
            t74 + a6 * t76);
        const double t90 = a0 + a4;
        const double t91 = a0 - a4;
        const double t92 = a7 - a3;
        const double t93 = a2 - a6;
        const double t94 = a5 - a1;
        const double t95 = b3 - b7;
        const double t96 = b0 - b4;
        const double t97 = b6 - b2;
        const double t98 = b1 - b5;
        const double t99 = t91 * b8 + t92 * b9 + t93 * b10 - t94 * b11 + (a9 * t95 - a8 * t96 + a10
            * t97 - a11 * t98);
        const double t100 = t91 * b11 + t92 * b10 + b8 * t94 - b9 * t93 + (t96 * a11 - (a8 * t98 +
            t95 * a10) + a9 * t97);
        const double t101 = t91 * b10 - t92 * b11 - b8 * t93 - b9 * t94 - (a8 * t97 + a9 * t98 + t96
            * a10 + t95 * a11);
        const double t102 = t7 * t101 - t9 * t99;
        const double t103 = t91 * b9 + t93 * b11 + b10 * t94 - b8 * t92 + (t97 * a11 - (t95 * a8 +
            a9 * t96) + a10 * t98);
        const double t104 = t8 * t99 + t7 * t103;
        const double t105 = 1.0 / larger(1.0947644252537633e-47, t10 + t38 * t38);
        const double t106 = (t6 * t51 - t4 * t20) * t105;
        const double t107 = t9 * t103 + t8 * t101;
        const double t108 = t105 * (t38 * (t6 * t20 - t4 * t51));
        const double t109 = fraction * (t51 * (t6 * t99 + t7 * t100) + (t9 * t102 - t8 * t104) *
            t106 + t107 * t108);
        const double t110 = ((fabs(t53) < 0.5) ? t63 : fabs(t77) / larger(0.25, fabs(t52)));
        const double t111 = t33 * t110;
        const double t112 = fraction * (t51 * (t6 * t103 - t8 * t100) - t106 * (t7 * t104 + t9 *
            t107) + t102 * t108);
        const double t113 = fraction * (t51 * (t6 * t101 + t9 * t100) - t106 * (t8 * t107 + t7 *
            t102) - t104 * t108);
        const double t114 = t23 * t112 + t22 * t113;
        const double t115 = t21 * t113 - t23 * t109;
        const double t116 = t22 * t109 + t21 * t112;
        const double t117 = (t65 * t70 - t111) / larger(1.0947644252537633e-47, t24 + t52 * t52);
        const double t118 = t109 * t111 + (t52 * t114 - (t23 * t115 - t22 * t116)) * t117;
        const double t119 = a3 + a7;
        const double t120 = t111 * t112 + t117 * (t52 * t115 + (t21 * t116 + t23 * t114));
        const double t121 = a2 + a6;
        const double t122 = t111 * t113 + t117 * (t22 * t114 + t21 * t115 - t52 * t116);
        const double t123 = a1 + a5;
        const double t124 = (t23 * t113 + t21 * t109 - t22 * t112) * (t70 * t110);
        const double t125 = t66 - t78;
        const double t126 = t72 - t79;
        const double t127 = t74 - t80;
        const double t128 = t76 - t81;
        const double t129 = t90 * t118 + t119 * t120 - t121 * t122 - t123 * t124 + (a8 * t125 - a9 *
            t126 - a10 * t127 - a11 * t128);
        const double t130 = t90 * t120 - t121 * t124 + t122 * t123 - t118 * t119 + (a8 * t126 + a9 *
            t125 + a11 * t127 - a10 * t128);
        const double t131 = t90 * t122 - t119 * t124 + t118 * t121 - t120 * t123 + (a8 * t127 + a9 *
            t128 + a10 * t125 - a11 * t126);
        const double t132 = t90 * t124 + t119 * t122 + t118 * t123 + t120 * t121 + (a8 * t128 + a10
            * t126 + a11 * t125 - a9 * t127);
        out_at[i] = t82;
        out_at[out_step + i] = t83;
        out_at[2 * out_step + i] = -t84;
        out_at[3 * out_step + i] = t85;
        out_at[4 * out_step + i] = t86;
        out_at[5 * out_step + i] = t87;
        out_at[6 * out_step + i] = -t88;
        out_at[7 * out_step + i] = t89;
        out_at[8 * out_step + i] = t129;
        out_at[9 * out_step + i] = t130;
        out_at[10 * out_step + i] = t131;
        out_at[11 * out_step + i] = t132;
    }
}
