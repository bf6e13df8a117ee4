/* Kernels of the group similarity_jacobians: similarity_left_jacobian,
 * similarity_left_jacobian_inverse.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_left_jacobian: Left Jacobian of a similarity's exponential at a twist
 * in twist: rx ry rz x y z log_scale
 * out out: m00 m01 m02 m03 m04 m05 m06 m10 m11 m12 m13 m14 m15 m16 m20 m21 m22 m23 m24 m25 m26 m30
 * m31 m32 m33 m34 m35 m36 m40 m41 m42 m43 m44 m45 m46 m50 m51 m52 m53 m54 m55 m56 m60 m61 m62 m63
 * m64 m65 m66 */

MOTORCADE_SIMD
void motorcade_similarity_left_jacobian_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float twist6 = twist_at[6 * twist_step + i];
        const float t0 = twist0 * twist0;
        const float t1 = twist1 * twist1;
        const float t2 = t0 + t1;
        const float t3 = twist2 * twist2;
        const float t4 = t2 + t3;
        const float t5 = 0.25f * t4;
        const float t6 = smallerf(t5, 2.467401f);
        const float t7 = t6 * (t6 * (t6 * (-1.4276141e-07f * t6 + 6.354456e-06f) + -0.00017629226f)
            + 0.0031745604f);
        const float t8 = sqrtf(t5);
        const float t9 = floorf(0.31830987f * t8 + 0.5f);
        const _Bool t10 = (t9 < 0.5f);
        const float t11 = t8 - t9 * 3.140625f - t9 * 0.0009675026f - t9 * 1.5099067e-07f - t9 *
            5.126688e-12f;
        const float t12 = t11 * t11;
        const float t13 = t12 * (t12 * (t12 * (2.6050482e-06f * t12 + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t14 = t13 + 1.0f;
        const float t15 = 1.0f - 2.0f * (t9 - floorf(0.5f * t9) * 2.0f);
        const float t16 = (t10 ? t14 : t14 * (t11 * t15) / largerf(1.0f, t8));
        const float t17 = t12 * (t12 * (t12 * -2.6050063e-07f + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t18 = t15 * (t12 * (t12 * t17 + -0.5f) + 1.0f);
        const float t19 = ((t5 < 2.467401f) ? t6 * (t7 + -0.033333324f) + 0.16666667f : (1.0f - t16
            * t18) / (4.0f * largerf(t5, 2.467401f)));
        const float t20 = t1 + t3;
        const float t21 = 1.0f - t19 * t20;
        const float t22 = twist0 * twist1;
        const float t23 = t19 * t22;
        const float t24 = t16 * (0.5f * t16);
        const float t25 = twist2 * t24;
        const float t26 = t23 - t25;
        const float t27 = twist1 * t24;
        const float t28 = twist0 * twist2;
        const float t29 = t19 * t28;
        const float t30 = t27 + t29;
        const float t31 = t23 + t25;
        const float t32 = t0 + t3;
        const float t33 = 1.0f - t19 * t32;
        const float t34 = twist1 * twist2;
        const float t35 = t19 * t34;
        const float t36 = twist0 * t24;
        const float t37 = t35 - t36;
        const float t38 = t29 - t27;
        const float t39 = t35 + t36;
        const float t40 = 1.0f - t2 * t19;
        const float t41 = floorf(0.5f + twist6 * 1.442695f);
        const float t42 = twist6 - t41 * 0.69311523f - t41 * 3.1946183e-05f;
        const float t43 = t42 * (t42 * (t42 * (0.0013941411f * t42 + 0.008375368f) + 0.041666348f) +
            0.16666412f);
        const float t44 = exp2_of_integerf(t41) * (1.0f + t42 * (t42 * (t43 + 0.5f) + 1.0f));
        const _Bool t45 = (fabsf(twist6) < 1.0f);
        const float t46 = largerf(smallerf(1.0f, twist6), -1.0f);
        const float t47 = t46 * (t46 * (t46 * 2.8063823e-06f + 2.5359639e-05f) + 0.00019838089f) +
            0.0013885383f;
        const float t48 = t46 * (t46 * (t46 * (t46 * t47 + 0.008333339f) + 0.04166674f) +
            0.16666667f) + 0.5f;
        const float t49 = 1.0f / ((twist6 < 0.0f) ? smallerf(twist6, -1.0f) : largerf(1.0f,
            twist6));
        const float t50 = (t44 - 1.0f) * t49;
        const float t51 = (t45 ? 1.0f + t46 * t48 : t50);
        const float t52 = (t45 ? t48 : t49 * (t50 - 1.0f));
        const float t53 = t51 - t52;
        const float t54 = twist6 * twist6;
        const float t55 = 1.0f / largerf(t4 + t54, 1.6940659e-21f);
        const float t56 = (twist6 * (t24 * t44 - t53) + t19 * (t4 * t44)) * t55;
        const float t57 = twist1 * twist4;
        const float t58 = twist2 * twist5;
        const float t59 = t54 * t55;
        const float t60 = t53 * t59 + t44 * (1.0f - t59) * (t24 - t19 * twist6);
        const float t61 = twist1 * twist3;
        const float t62 = twist0 * twist4;
        const float t63 = t61 - t62;
        const float t64 = twist2 * twist3;
        const float t65 = twist0 * twist5;
        const float t66 = t64 - t65;
        const float t67 = twist2 * twist4;
        const float t68 = twist1 * twist5;
        const float t69 = t67 - t68;
        const float t70 = twist0 * t66 + twist1 * t69;
        const float t71 = t51 * twist5 - t60 * t63 + t56 * t70;
        const float t72 = twist0 * t63 - twist2 * t69;
        const float t73 = t51 * twist4 + t60 * t66 + t56 * t72;
        const float t74 = twist0 * 2.0f;
        const float t75 = t12 * (t12 * (t12 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f) +
            0.016666664f;
        const float t76 = (t10 ? t12 * t75 + -0.16666667f : (t18 - t16) / (2.0f * largerf(1.0f,
            t5)));
        const float t77 = 0.25f * (t18 * t76 - t24);
        const float t78 = t55 * (t44 * (0.5f * (1.0f - t4 * t19) + twist6 * t77) - t60);
        const float t79 = t55 * (t44 * (0.25f * twist6 * (t16 * t76) - t77) - t56);
        const float t80 = twist1 * t63 + twist2 * t66;
        const float t81 = t69 * t78 + t79 * t80;
        const float t82 = twist5 * t60;
        const float t83 = twist1 * 2.0f;
        const float t84 = twist2 * 2.0f;
        const float t85 = twist4 * t60;
        const float t86 = t22 * t56;
        const float t87 = twist2 * t60;
        const float t88 = twist1 * t60;
        const float t89 = t28 * t56;
        const float t90 = t55 * (twist6 * (t60 - t52) + t4 * t56);
        const float t91 = t55 * (t52 - t60 + twist6 * t56);
        const float t92 = t51 * twist3 - t60 * t69 - t56 * t80;
        const float t93 = t66 * t78 + t72 * t79;
        const float t94 = twist0 * twist3;
        const float t95 = t60 * twist3;
        const float t96 = t34 * t56;
        const float t97 = twist0 * t60;
        const float t98 = t70 * t79 - t63 * t78;
        out_at[i] = t21;
        out_at[out_step + i] = t26;
        out_at[2 * out_step + i] = t30;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = 0.0f;
        out_at[5 * out_step + i] = 0.0f;
        out_at[6 * out_step + i] = 0.0f;
        out_at[7 * out_step + i] = t31;
        out_at[8 * out_step + i] = t33;
        out_at[9 * out_step + i] = t37;
        out_at[10 * out_step + i] = 0.0f;
        out_at[11 * out_step + i] = 0.0f;
        out_at[12 * out_step + i] = 0.0f;
        out_at[13 * out_step + i] = 0.0f;
        out_at[14 * out_step + i] = t38;
        out_at[15 * out_step + i] = t39;
        out_at[16 * out_step + i] = t40;
        out_at[17 * out_step + i] = 0.0f;
        out_at[18 * out_step + i] = 0.0f;
        out_at[19 * out_step + i] = 0.0f;
        out_at[20 * out_step + i] = 0.0f;
        out_at[21 * out_step + i] = t56 * (t57 + t58) - (t31 * t71 - t38 * t73 + t74 * t81);
        out_at[22 * out_step + i] = t82 - (t33 * t71 - t39 * t73 + t81 * t83) - t56 * (t61 + t63);
        out_at[23 * out_step + i] = -(t37 * t71 - t40 * t73 + t81 * t84 + t85 + t56 * (t64 + t66));
        out_at[24 * out_step + i] = t51 - t20 * t56;
        out_at[25 * out_step + i] = t86 - t87;
        out_at[26 * out_step + i] = t88 + t89;
        out_at[27 * out_step + i] = t80 * t91 - (t52 * twist3 - t69 * t90);
        out_at[28 * out_step + i] = t21 * t71 - t38 * t92 + t74 * t93 - t82 + t56 * (t63 - t62);
        out_at[29 * out_step + i] = t26 * t71 - t39 * t92 + t83 * t93 + t56 * (t58 + t94);
        out_at[30 * out_step + i] = t30 * t71 - t40 * t92 + t84 * t93 + t95 - t56 * (t67 + t69);
        out_at[31 * out_step + i] = t86 + t87;
        out_at[32 * out_step + i] = t51 - t32 * t56;
        out_at[33 * out_step + i] = t96 - t97;
        out_at[34 * out_step + i] = -(t52 * twist4 + t66 * t90 + t72 * t91);
        out_at[35 * out_step + i] = t85 + (t74 * t98 - (t21 * t73 - t31 * t92)) + t56 * (t66 - t65);
        out_at[36 * out_step + i] = t83 * t98 - (t26 * t73 - t33 * t92) - t95 + t56 * (t69 - t68);
        out_at[37 * out_step + i] = t84 * t98 - (t30 * t73 - t37 * t92) + t56 * (t57 + t94);
        out_at[38 * out_step + i] = t89 - t88;
        out_at[39 * out_step + i] = t96 + t97;
        out_at[40 * out_step + i] = t51 - t2 * t56;
        out_at[41 * out_step + i] = -(t52 * twist5 - t63 * t90 + t70 * t91);
        out_at[42 * out_step + i] = 0.0f;
        out_at[43 * out_step + i] = 0.0f;
        out_at[44 * out_step + i] = 0.0f;
        out_at[45 * out_step + i] = 0.0f;
        out_at[46 * out_step + i] = 0.0f;
        out_at[47 * out_step + i] = 0.0f;
        out_at[48 * out_step + i] = 1.0f;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_left_jacobian_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double twist6 = twist_at[6 * twist_step + i];
        const double t0 = twist0 * twist0;
        const double t1 = twist1 * twist1;
        const double t2 = t0 + t1;
        const double t3 = twist2 * twist2;
        const double t4 = t2 + t3;
        const double t5 = 0.25 * t4;
        const double t6 = smaller(t5, 2.4674011002723395);
        const double t7 = t6 * (t6 * (-4.653304211418644e-15 * t6 + 5.362814048940375e-13) +
            -4.605580928658353e-11);
        const double t8 = t6 * (t6 * (t7 + 3.1322658499179184e-09) + -1.644445954441792e-07) +
            6.413339737800479e-06;
        const double t9 = t6 * (t6 * (t6 * t8 + -0.00017636684303014454) + 0.0031746031746025262) +
            -0.033333333333333284;
        const double t10 = sqrt(t5);
        const double t11 = floor(0.3183098861837907 * t10 + 0.5);
        const _Bool t12 = (t11 < 0.5);
        const double t13 = t10 - t11 * 3.1415926218032837 - t11 * 3.1786509424591713e-08 - t11 *
            1.2246467202362698e-16;
        const double t14 = t13 - t11 * 7.891108333126411e-24;
        const double t15 = t14 * t14;
        const double t16 = t15 * (2.721539074015491e-15 * t15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t17 = t15 * (t15 * (t15 * t16 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t18 = 1.0 + t15 * (t15 * (t15 * t17 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t19 = 1.0 - 2.0 * (t11 - floor(0.5 * t11) * 2.0);
        const double t20 = (t12 ? t18 : t18 * (t14 * t19) / larger(1.0, t10));
        const double t21 = t15 * (t15 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t22 = t15 * (t15 * (t15 * t21 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t23 = t19 * (1.0 + t15 * (t15 * (t15 * t22 + 0.041666666666663875) +
            -0.4999999999999997));
        const double t24 = ((t5 < 2.4674011002723395) ? t6 * t9 + 0.16666666666666666 : (1.0 - t20 *
            t23) / (4.0 * larger(t5, 2.4674011002723395)));
        const double t25 = t1 + t3;
        const double t26 = 1.0 - t24 * t25;
        const double t27 = twist0 * twist1;
        const double t28 = t24 * t27;
        const double t29 = t20 * (0.5 * t20);
        const double t30 = twist2 * t29;
        const double t31 = t28 - t30;
        const double t32 = twist1 * t29;
        const double t33 = twist0 * twist2;
        const double t34 = t24 * t33;
        const double t35 = t32 + t34;
        const double t36 = t28 + t30;
        const double t37 = t0 + t3;
        const double t38 = 1.0 - t24 * t37;
        const double t39 = twist1 * twist2;
        const double t40 = t24 * t39;
        const double t41 = twist0 * t29;
        const double t42 = t40 - t41;
        const double t43 = t34 - t32;
        const double t44 = t40 + t41;
        const double t45 = 1.0 - t2 * t24;
        const double t46 = floor(0.5 + twist6 * 1.4426950408889634);
        const double t47 = twist6 - t46 * 0.6931471675634384 - t46 * 1.2996506893889889e-08;
        const double t48 = t47 * (t47 * (2.5110372746250102e-08 * t47 + 2.763307546557511e-07) +
            2.755724001024349e-06);
        const double t49 = t47 * (t47 * (t48 + 2.4801484301104542e-05) + 0.0001984126989089813) +
            0.0013888888953421457;
        const double t50 = t47 * (t47 * (t47 * t49 + 0.00833333333331928) + 0.04166666666648393) +
            0.16666666666666682;
        const double t51 = exp2_of_integer(t46) * (1.0 + t47 * (1.0 + t47 * (t47 * t50 +
            0.5000000000000019)));
        const _Bool t52 = (fabs(twist6) < 1.0);
        const double t53 = larger(smaller(1.0, twist6), -1.0);
        const double t54 = t53 * (t53 * 7.746377957473813e-13 + 1.1639533539491848e-11) +
            1.6057674136158497e-10;
        const double t55 = t53 * (t53 * (t53 * t54 + 2.087442623329743e-09) +
            2.5052117752083137e-08) + 2.7557335164569814e-07;
        const double t56 = t53 * (t53 * (t53 * t55 + 2.755731919111943e-06) +
            2.4801587245650116e-05) + 0.00019841269841324745;
        const double t57 = t53 * (t53 * (t53 * t56 + 0.0013888888888982337) + 0.008333333333333299)
            + 0.04166666666666608;
        const double t58 = 0.5 + t53 * (0.16666666666666666 + t53 * t57);
        const double t59 = 1.0 / ((twist6 < 0.0) ? smaller(twist6, -1.0) : larger(1.0, twist6));
        const double t60 = (t51 - 1.0) * t59;
        const double t61 = (t52 ? 1.0 + t53 * t58 : t60);
        const double t62 = (t52 ? t58 : t59 * (t60 - 1.0));
        const double t63 = t61 - t62;
        const double t64 = twist6 * twist6;
        const double t65 = 1.0 / larger(t4 + t64, 1.0947644252537633e-47);
        const double t66 = (twist6 * (t29 * t51 - t63) + t24 * (t4 * t51)) * t65;
        const double t67 = twist1 * twist4;
        const double t68 = twist2 * twist5;
        const double t69 = t64 * t65;
        const double t70 = t63 * t69 + t51 * (1.0 - t69) * (t29 - t24 * twist6);
        const double t71 = twist1 * twist3;
        const double t72 = twist0 * twist4;
        const double t73 = t71 - t72;
        const double t74 = twist2 * twist3;
        const double t75 = twist0 * twist5;
        const double t76 = t74 - t75;
        const double t77 = twist2 * twist4;
        const double t78 = twist1 * twist5;
        const double t79 = t77 - t78;
        const double t80 = twist0 * t76 + twist1 * t79;
        const double t81 = t61 * twist5 - t70 * t73 + t66 * t80;
        const double t82 = twist0 * t73 - twist2 * t79;
        const double t83 = t61 * twist4 + t70 * t76 + t66 * t82;
        const double t84 = twist0 * 2.0;
        const double t85 = t15 * (t15 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t86 = t15 * (t15 * (t15 * t85 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t87 = (t12 ? -0.16666666666666666 + t15 * (t15 * t86 + 0.01666666666666651) :
            (t23 - t20) / (2.0 * larger(1.0, t5)));
        const double t88 = 0.25 * (t23 * t87 - t29);
        const double t89 = t65 * (t51 * (0.5 * (1.0 - t4 * t24) + twist6 * t88) - t70);
        const double t90 = t65 * (t51 * (0.25 * twist6 * (t20 * t87) - t88) - t66);
        const double t91 = twist1 * t73 + twist2 * t76;
        const double t92 = t79 * t89 + t90 * t91;
        const double t93 = twist5 * t70;
        const double t94 = twist1 * 2.0;
        const double t95 = twist2 * 2.0;
        const double t96 = twist4 * t70;
        const double t97 = t27 * t66;
        const double t98 = twist2 * t70;
        const double t99 = twist1 * t70;
        const double t100 = t33 * t66;
        const double t101 = t65 * (twist6 * (t70 - t62) + t4 * t66);
        const double t102 = t65 * (t62 - t70 + twist6 * t66);
        const double t103 = t61 * twist3 - t70 * t79 - t66 * t91;
        const double t104 = t76 * t89 + t82 * t90;
        const double t105 = twist0 * twist3;
        const double t106 = t70 * twist3;
        const double t107 = t39 * t66;
        const double t108 = twist0 * t70;
        const double t109 = t80 * t90 - t73 * t89;
        out_at[i] = t26;
        out_at[out_step + i] = t31;
        out_at[2 * out_step + i] = t35;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = 0.0;
        out_at[5 * out_step + i] = 0.0;
        out_at[6 * out_step + i] = 0.0;
        out_at[7 * out_step + i] = t36;
        out_at[8 * out_step + i] = t38;
        out_at[9 * out_step + i] = t42;
        out_at[10 * out_step + i] = 0.0;
        out_at[11 * out_step + i] = 0.0;
        out_at[12 * out_step + i] = 0.0;
        out_at[13 * out_step + i] = 0.0;
        out_at[14 * out_step + i] = t43;
        out_at[15 * out_step + i] = t44;
        out_at[16 * out_step + i] = t45;
        out_at[17 * out_step + i] = 0.0;
        out_at[18 * out_step + i] = 0.0;
        out_at[19 * out_step + i] = 0.0;
        out_at[20 * out_step + i] = 0.0;
        out_at[21 * out_step + i] = t66 * (t67 + t68) - (t36 * t81 - t43 * t83 + t84 * t92);
        out_at[22 * out_step + i] = t93 - (t38 * t81 - t44 * t83 + t92 * t94) - t66 * (t71 + t73);
        out_at[23 * out_step + i] = -(t42 * t81 - t45 * t83 + t92 * t95 + t96 + t66 * (t74 + t76));
        out_at[24 * out_step + i] = t61 - t25 * t66;
        out_at[25 * out_step + i] = t97 - t98;
        out_at[26 * out_step + i] = t99 + t100;
        out_at[27 * out_step + i] = t91 * t102 - (t62 * twist3 - t79 * t101);
        out_at[28 * out_step + i] = t26 * t81 - t43 * t103 + t84 * t104 - t93 + t66 * (t73 - t72);
        out_at[29 * out_step + i] = t31 * t81 - t44 * t103 + t94 * t104 + t66 * (t68 + t105);
        out_at[30 * out_step + i] = t35 * t81 - t45 * t103 + t95 * t104 + t106 - t66 * (t77 + t79);
        out_at[31 * out_step + i] = t97 + t98;
        out_at[32 * out_step + i] = t61 - t37 * t66;
        out_at[33 * out_step + i] = t107 - t108;
        out_at[34 * out_step + i] = -(t62 * twist4 + t76 * t101 + t82 * t102);
        out_at[35 * out_step + i] = t96 + (t84 * t109 - (t26 * t83 - t36 * t103)) + t66 * (t76 -
            t75);
        out_at[36 * out_step + i] = t94 * t109 - (t31 * t83 - t38 * t103) - t106 + t66 * (t79 -
            t78);
        out_at[37 * out_step + i] = t95 * t109 - (t35 * t83 - t42 * t103) + t66 * (t67 + t105);
        out_at[38 * out_step + i] = t100 - t99;
        out_at[39 * out_step + i] = t107 + t108;
        out_at[40 * out_step + i] = t61 - t2 * t66;
        out_at[41 * out_step + i] = -(t62 * twist5 - t73 * t101 + t80 * t102);
        out_at[42 * out_step + i] = 0.0;
        out_at[43 * out_step + i] = 0.0;
        out_at[44 * out_step + i] = 0.0;
        out_at[45 * out_step + i] = 0.0;
        out_at[46 * out_step + i] = 0.0;
        out_at[47 * out_step + i] = 0.0;
        out_at[48 * out_step + i] = 1.0;
    }
}

/* similarity_left_jacobian_inverse: Inverse left Jacobian of a similarity's exponential, singular
 * at full turns
 * in twist: rx ry rz x y z log_scale
 * out out: m00 m01 m02 m03 m04 m05 m06 m10 m11 m12 m13 m14 m15 m16 m20 m21 m22 m23 m24 m25 m26 m30
 * m31 m32 m33 m34 m35 m36 m40 m41 m42 m43 m44 m45 m46 m50 m51 m52 m53 m54 m55 m56 m60 m61 m62 m63
 * m64 m65 m66 */

MOTORCADE_SIMD
void motorcade_similarity_left_jacobian_inverse_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float twist6 = twist_at[6 * twist_step + i];
        const float t0 = twist0 * twist0;
        const float t1 = twist1 * twist1;
        const float t2 = t0 + t1;
        const float t3 = twist2 * twist2;
        const float t4 = t2 + t3;
        const float t5 = 0.25f * t4;
        const _Bool t6 = (t5 < 2.467401f);
        const float t7 = smallerf(t5, 2.467401f);
        const float t8 = t7 * (t7 * (t7 * (1.4476021e-07f * t7 + 1.7820906e-07f) + 6.007504e-06f) +
            5.231038e-05f);
        const float t9 = sqrtf(t5);
        const float t10 = floorf(0.31830987f * t9 + 0.5f);
        const float t11 = 1.0f - 2.0f * (t10 - floorf(0.5f * t10) * 2.0f);
        const float t12 = t9 - t10 * 3.140625f - t10 * 0.0009675026f - t10 * 1.5099067e-07f - t10 *
            5.126688e-12f;
        const float t13 = t12 * t12;
        const float t14 = t13 * (t13 * (-2.6050063e-07f * t13 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t15 = t11 * (t13 * (t13 * t14 + -0.5f) + 1.0f);
        const _Bool t16 = (t10 < 0.5f);
        const float t17 = t13 * (t13 * (t13 * (t13 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t18 = t17 + 1.0f;
        const float t19 = (t16 ? t18 : t18 * (t11 * t12) / largerf(1.0f, t9));
        const float t20 = 1.0f / (4.0f * largerf(t5, 2.467401f));
        const float t21 = (1.0f - t15 * (((t19 < 0.0f) ? -1.0f : 1.0f) / largerf(fabsf(t19),
            1.4210855e-14f))) * t20;
        const float t22 = (t6 ? t7 * (t7 * (t8 + 0.0005293538f) + 0.005555516f) + 0.083333336f :
            t21);
        const float t23 = t1 + t3;
        const float t24 = 1.0f - t22 * t23;
        const float t25 = twist0 * twist1;
        const float t26 = t22 * t25;
        const float t27 = twist2 * -0.5f;
        const float t28 = t26 - t27;
        const float t29 = twist1 * -0.5f;
        const float t30 = twist0 * twist2;
        const float t31 = t22 * t30;
        const float t32 = t29 + t31;
        const float t33 = t26 + t27;
        const float t34 = t0 + t3;
        const float t35 = 1.0f - t22 * t34;
        const float t36 = twist1 * twist2;
        const float t37 = t22 * t36;
        const float t38 = twist0 * -0.5f;
        const float t39 = t37 - t38;
        const float t40 = t31 - t29;
        const float t41 = t37 + t38;
        const float t42 = 1.0f - t2 * t22;
        const float t43 = 2.0f * (twist0 * t24 + twist1 * t33 + twist2 * t40);
        const float t44 = floorf(0.5f + 1.442695f * twist6);
        const float t45 = twist6 - t44 * 0.69311523f - t44 * 3.1946183e-05f;
        const float t46 = t45 * (t45 * (t45 * (0.0013941411f * t45 + 0.008375368f) + 0.041666348f) +
            0.16666412f);
        const float t47 = exp2_of_integerf(t44) * (1.0f + t45 * (t45 * (t46 + 0.5f) + 1.0f));
        const float t48 = t7 * (t7 * (t7 * (t7 * -1.4276141e-07f + 6.354456e-06f) + -0.00017629226f)
            + 0.0031745604f);
        const float t49 = (t6 ? t7 * (t48 + -0.033333324f) + 0.16666667f : t20 * (1.0f - t15 *
            t19));
        const float t50 = t13 * (t13 * (t13 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f) +
            0.016666664f;
        const float t51 = (t16 ? t13 * t50 + -0.16666667f : (t15 - t19) / (2.0f * largerf(1.0f,
            t5)));
        const float t52 = t19 * (0.5f * t19);
        const float t53 = 0.25f * (t15 * t51 - t52);
        const float t54 = twist6 * twist6;
        const float t55 = 1.0f / largerf(t4 + t54, 1.6940659e-21f);
        const float t56 = t54 * t55;
        const _Bool t57 = (fabsf(twist6) < 1.0f);
        const float t58 = largerf(-1.0f, smallerf(1.0f, twist6));
        const float t59 = t58 * (t58 * (t58 * 2.8063823e-06f + 2.5359639e-05f) + 0.00019838089f) +
            0.0013885383f;
        const float t60 = t58 * (t58 * (t58 * (t58 * t59 + 0.008333339f) + 0.04166674f) +
            0.16666667f) + 0.5f;
        const float t61 = 1.0f / ((twist6 < 0.0f) ? smallerf(-1.0f, twist6) : largerf(1.0f,
            twist6));
        const float t62 = (t47 - 1.0f) * t61;
        const float t63 = (t57 ? 1.0f + t58 * t60 : t62);
        const float t64 = (t57 ? t60 : t61 * (t62 - 1.0f));
        const float t65 = t63 - t64;
        const float t66 = t56 * t65 + t47 * (1.0f - t56) * (t52 - twist6 * t49);
        const float t67 = t55 * (t47 * (0.5f * (1.0f - t4 * t49) + twist6 * t53) - t66);
        const float t68 = twist2 * twist4 - twist1 * twist5;
        const float t69 = t55 * (twist6 * (t47 * t52 - t65) + t49 * (t4 * t47));
        const float t70 = t55 * (t47 * (0.25f * twist6 * (t19 * t51) - t53) - t69);
        const float t71 = twist1 * twist3 - twist0 * twist4;
        const float t72 = twist2 * twist3 - twist0 * twist5;
        const float t73 = twist1 * t71 + twist2 * t72;
        const float t74 = t67 * t68 + t70 * t73;
        const float t75 = t40 * twist4 - t33 * twist5;
        const float t76 = t33 * twist3 - t24 * twist4;
        const float t77 = t40 * twist3 - t24 * twist5;
        const float t78 = t43 * t74 + t66 * t75 + t69 * (t33 * t71 + t40 * t72 + (twist1 * t76 +
            twist2 * t77));
        const float t79 = 1.0f / t63;
        const float t80 = t4 * t69;
        const float t81 = t63 - t80;
        const float t82 = t81 * t81 + t66 * (t4 * t66);
        const float t83 = t66 / t82;
        const float t84 = twist0 * t72 + twist1 * t68;
        const float t85 = t70 * t84 - t67 * t71;
        const float t86 = twist0 * t71 - twist2 * t68;
        const float t87 = t63 * twist4 + t66 * t72 + t69 * t86;
        const float t88 = t43 * t85 - t87 - t66 * t76 + t69 * (t24 * t72 + t33 * t68 + (twist0 * t77
            + twist1 * t75));
        const float t89 = t63 * twist5 - t66 * t71 + t69 * t84;
        const float t90 = t67 * t72 + t70 * t86;
        const float t91 = t89 + t43 * t90 + t66 * t77 + t69 * (t24 * t71 - t40 * t68 + (twist0 * t76
            - twist2 * t75));
        const float t92 = twist1 * t88 - twist2 * t91;
        const float t93 = (t66 * t66 - t69 * t81) / (t63 * t82);
        const float t94 = twist0 * t91 + twist1 * t78;
        const float t95 = twist2 * t78 + twist0 * t88;
        const float t96 = 2.0f * (twist0 * t28 + twist1 * t35 + twist2 * t41);
        const float t97 = t41 * twist4 - t35 * twist5;
        const float t98 = t35 * twist3 - t28 * twist4;
        const float t99 = t41 * twist3 - t28 * twist5;
        const float t100 = t89 + t74 * t96 + t66 * t97 + t69 * (t35 * t71 + t41 * t72 + (twist1 *
            t98 + twist2 * t99));
        const float t101 = t63 * twist3 - t66 * t68 - t69 * t73;
        const float t102 = t101 + t85 * t96 - t66 * t98 + t69 * (t28 * t72 + t35 * t68 + (twist0 *
            t99 + twist1 * t97));
        const float t103 = t90 * t96 + t66 * t99 + t69 * (t28 * t71 - t41 * t68 + (twist0 * t98 -
            twist2 * t97));
        const float t104 = twist1 * t102 - twist2 * t103;
        const float t105 = twist0 * t103 + twist1 * t100;
        const float t106 = twist2 * t100 + twist0 * t102;
        const float t107 = 2.0f * (twist0 * t32 + twist1 * t39 + twist2 * t42);
        const float t108 = t39 * twist3 - t32 * twist4;
        const float t109 = t42 * twist3 - t32 * twist5;
        const float t110 = t42 * twist4 - t39 * twist5;
        const float t111 = t85 * t107 - t66 * t108 + t69 * (t32 * t72 + t39 * t68 + (twist0 * t109 +
            twist1 * t110));
        const float t112 = t90 * t107 - t101 + t66 * t109 + t69 * (t32 * t71 - t42 * t68 + (twist0 *
            t108 - twist2 * t110));
        const float t113 = twist1 * t111 - twist2 * t112;
        const float t114 = t87 - t74 * t107 - t66 * t110 - t69 * (t39 * t71 + t42 * t72 + (twist1 *
            t108 + twist2 * t109));
        const float t115 = twist0 * t112 - twist1 * t114;
        const float t116 = twist0 * t111 - twist2 * t114;
        const float t117 = twist2 * t83;
        const float t118 = t25 * t93;
        const float t119 = t30 * t93;
        const float t120 = twist1 * t83;
        const float t121 = t55 * (t80 + twist6 * (t66 - t64));
        const float t122 = t55 * (t64 - t66 + twist6 * t69);
        const float t123 = t64 * twist3 - t68 * t121 - t73 * t122;
        const float t124 = t64 * twist4 + t72 * t121 + t86 * t122;
        const float t125 = t64 * twist5 - t71 * t121 + t84 * t122;
        const float t126 = twist2 * t124 - twist1 * t125;
        const float t127 = twist1 * t123 - twist0 * t124;
        const float t128 = twist2 * t123 - twist0 * t125;
        const float t129 = twist0 * t83;
        const float t130 = t36 * t93;
        out_at[i] = t24;
        out_at[out_step + i] = t28;
        out_at[2 * out_step + i] = t32;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = 0.0f;
        out_at[5 * out_step + i] = 0.0f;
        out_at[6 * out_step + i] = 0.0f;
        out_at[7 * out_step + i] = t33;
        out_at[8 * out_step + i] = t35;
        out_at[9 * out_step + i] = t39;
        out_at[10 * out_step + i] = 0.0f;
        out_at[11 * out_step + i] = 0.0f;
        out_at[12 * out_step + i] = 0.0f;
        out_at[13 * out_step + i] = 0.0f;
        out_at[14 * out_step + i] = t40;
        out_at[15 * out_step + i] = t41;
        out_at[16 * out_step + i] = t42;
        out_at[17 * out_step + i] = 0.0f;
        out_at[18 * out_step + i] = 0.0f;
        out_at[19 * out_step + i] = 0.0f;
        out_at[20 * out_step + i] = 0.0f;
        out_at[21 * out_step + i] = t78 * t79 + t83 * t92 - t93 * (twist1 * t94 + twist2 * t95);
        out_at[22 * out_step + i] = t79 * t100 + t83 * t104 - t93 * (twist1 * t105 + twist2 * t106);
        out_at[23 * out_step + i] = t83 * t113 - t79 * t114 - t93 * (twist1 * t115 + twist2 * t116);
        out_at[24 * out_step + i] = t79 - t23 * t93;
        out_at[25 * out_step + i] = t117 + t118;
        out_at[26 * out_step + i] = t119 - t120;
        out_at[27 * out_step + i] = t79 * t123 + t83 * t126 - t93 * (twist1 * t127 + twist2 * t128);
        out_at[28 * out_step + i] = t93 * (twist0 * t94 - twist2 * t92) - (t79 * t91 + t83 * t95);
        out_at[29 * out_step + i] = t93 * (twist0 * t105 - twist2 * t104) - (t79 * t103 + t83 *
            t106);
        out_at[30 * out_step + i] = t93 * (twist0 * t115 - twist2 * t113) - (t79 * t112 + t83 *
            t116);
        out_at[31 * out_step + i] = t118 - t117;
        out_at[32 * out_step + i] = t79 - t34 * t93;
        out_at[33 * out_step + i] = t129 + t130;
        out_at[34 * out_step + i] = t79 * t124 - t83 * t128 + t93 * (twist0 * t127 - twist2 * t126);
        out_at[35 * out_step + i] = t83 * t94 - t79 * t88 + t93 * (twist0 * t95 + twist1 * t92);
        out_at[36 * out_step + i] = t83 * t105 - t79 * t102 + t93 * (twist0 * t106 + twist1 * t104);
        out_at[37 * out_step + i] = t83 * t115 - t79 * t111 + t93 * (twist0 * t116 + twist1 * t113);
        out_at[38 * out_step + i] = t119 + t120;
        out_at[39 * out_step + i] = t130 - t129;
        out_at[40 * out_step + i] = t79 - t2 * t93;
        out_at[41 * out_step + i] = t79 * t125 + t83 * t127 + t93 * (twist0 * t128 + twist1 * t126);
        out_at[42 * out_step + i] = 0.0f;
        out_at[43 * out_step + i] = 0.0f;
        out_at[44 * out_step + i] = 0.0f;
        out_at[45 * out_step + i] = 0.0f;
        out_at[46 * out_step + i] = 0.0f;
        out_at[47 * out_step + i] = 0.0f;
        out_at[48 * out_step + i] = 1.0f;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_left_jacobian_inverse_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double twist6 = twist_at[6 * twist_step + i];
        const double t0 = twist0 * twist0;
        const double t1 = twist1 * twist1;
        const double t2 = t0 + t1;
        const double t3 = twist2 * twist2;
        const double t4 = t2 + t3;
        const double t5 = 0.25 * t4;
        const _Bool t6 = (t5 < 2.4674011002723395);
        const double t7 = smaller(t5, 2.4674011002723395);
        const double t8 = t7 * (t7 * (4.190860689573733e-14 * t7 + -3.105093875068576e-13) +
            2.52116134224849e-12);
        const double t9 = t7 * (t7 * (t8 + -4.868906238981723e-13) + 7.053760152595475e-11) +
            5.42546914811746e-10;
        const double t10 = t7 * (t7 * (t7 * t9 + 5.574566759681558e-09) + 5.479985772581718e-08) +
            5.411083420356027e-07;
        const double t11 = t7 * (t7 * (t7 * t10 + 5.344447517065357e-06) + 5.2910053333655655e-05) +
            0.0005291005290594417;
        const double t12 = sqrt(t5);
        const double t13 = floor(0.3183098861837907 * t12 + 0.5);
        const double t14 = 1.0 - 2.0 * (t13 - floor(0.5 * t13) * 2.0);
        const double t15 = t12 - t13 * 3.1415926218032837 - t13 * 3.1786509424591713e-08 - t13 *
            1.2246467202362698e-16;
        const double t16 = t15 - t13 * 7.891108333126411e-24;
        const double t17 = t16 * t16;
        const double t18 = t17 * (4.608909074888812e-14 * t17 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t19 = t17 * (t17 * (t17 * t18 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t20 = t14 * (1.0 + t17 * (t17 * (t17 * t19 + 0.041666666666663875) +
            -0.4999999999999997));
        const _Bool t21 = (t13 < 0.5);
        const double t22 = t17 * (t17 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t23 = t17 * (t17 * (t17 * t22 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t24 = 1.0 + t17 * (t17 * (t17 * t23 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t25 = (t21 ? t24 : t24 * (t14 * t16) / larger(1.0, t12));
        const double t26 = 1.0 / (4.0 * larger(t5, 2.4674011002723395));
        const double t27 = (1.0 - t20 * (((t25 < 0.0) ? -1.0 : 1.0) / larger(fabs(t25),
            4.930380657631324e-32))) * t26;
        const double t28 = (t6 ? t7 * (t7 * t11 + 0.0055555555555571205) + 0.08333333333333333 :
            t27);
        const double t29 = t1 + t3;
        const double t30 = 1.0 - t28 * t29;
        const double t31 = twist0 * twist1;
        const double t32 = t28 * t31;
        const double t33 = twist2 * -0.5;
        const double t34 = t32 - t33;
        const double t35 = twist1 * -0.5;
        const double t36 = twist0 * twist2;
        const double t37 = t28 * t36;
        const double t38 = t35 + t37;
        const double t39 = t32 + t33;
        const double t40 = t0 + t3;
        const double t41 = 1.0 - t28 * t40;
        const double t42 = twist1 * twist2;
        const double t43 = t28 * t42;
        const double t44 = twist0 * -0.5;
        const double t45 = t43 - t44;
        const double t46 = t37 - t35;
        const double t47 = t43 + t44;
        const double t48 = 1.0 - t2 * t28;
        const double t49 = 2.0 * (twist0 * t30 + twist1 * t39 + twist2 * t46);
        const double t50 = floor(0.5 + 1.4426950408889634 * twist6);
        const double t51 = twist6 - t50 * 0.6931471675634384 - t50 * 1.2996506893889889e-08;
        const double t52 = t51 * (t51 * (2.5110372746250102e-08 * t51 + 2.763307546557511e-07) +
            2.755724001024349e-06);
        const double t53 = t51 * (t51 * (t52 + 2.4801484301104542e-05) + 0.0001984126989089813) +
            0.0013888888953421457;
        const double t54 = t51 * (t51 * (t51 * t53 + 0.00833333333331928) + 0.04166666666648393) +
            0.16666666666666682;
        const double t55 = exp2_of_integer(t50) * (1.0 + t51 * (1.0 + t51 * (t51 * t54 +
            0.5000000000000019)));
        const double t56 = t7 * (t7 * (t7 * -4.653304211418644e-15 + 5.362814048940375e-13) +
            -4.605580928658353e-11);
        const double t57 = t7 * (t7 * (t56 + 3.1322658499179184e-09) + -1.644445954441792e-07) +
            6.413339737800479e-06;
        const double t58 = t7 * (t7 * (t7 * t57 + -0.00017636684303014454) + 0.0031746031746025262)
            + -0.033333333333333284;
        const double t59 = (t6 ? t7 * t58 + 0.16666666666666666 : t26 * (1.0 - t20 * t25));
        const double t60 = t17 * (t17 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t61 = t17 * (t17 * (t17 * t60 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t62 = (t21 ? -0.16666666666666666 + t17 * (t17 * t61 + 0.01666666666666651) :
            (t20 - t25) / (2.0 * larger(1.0, t5)));
        const double t63 = t25 * (0.5 * t25);
        const double t64 = 0.25 * (t20 * t62 - t63);
        const double t65 = twist6 * twist6;
        const double t66 = 1.0 / larger(t4 + t65, 1.0947644252537633e-47);
        const double t67 = t65 * t66;
        const _Bool t68 = (fabs(twist6) < 1.0);
        const double t69 = larger(-1.0, smaller(1.0, twist6));
        const double t70 = t69 * (t69 * 7.746377957473813e-13 + 1.1639533539491848e-11) +
            1.6057674136158497e-10;
        const double t71 = t69 * (t69 * (t69 * t70 + 2.087442623329743e-09) +
            2.5052117752083137e-08) + 2.7557335164569814e-07;
        const double t72 = t69 * (t69 * (t69 * t71 + 2.755731919111943e-06) +
            2.4801587245650116e-05) + 0.00019841269841324745;
        const double t73 = t69 * (t69 * (t69 * t72 + 0.0013888888888982337) + 0.008333333333333299)
            + 0.04166666666666608;
        const double t74 = 0.5 + t69 * (0.16666666666666666 + t69 * t73);
        const double t75 = 1.0 / ((twist6 < 0.0) ? smaller(-1.0, twist6) : larger(1.0, twist6));
        const double t76 = (t55 - 1.0) * t75;
        const double t77 = (t68 ? 1.0 + t69 * t74 : t76);
        const double t78 = (t68 ? t74 : t75 * (t76 - 1.0));
        const double t79 = t77 - t78;
        const double t80 = t67 * t79 + t55 * (1.0 - t67) * (t63 - twist6 * t59);
        const double t81 = t66 * (t55 * (0.5 * (1.0 - t4 * t59) + twist6 * t64) - t80);
        const double t82 = twist2 * twist4 - twist1 * twist5;
        const double t83 = t66 * (twist6 * (t55 * t63 - t79) + t59 * (t4 * t55));
        const double t84 = t66 * (t55 * (0.25 * twist6 * (t25 * t62) - t64) - t83);
        const double t85 = twist1 * twist3 - twist0 * twist4;
        const double t86 = twist2 * twist3 - twist0 * twist5;
        const double t87 = twist1 * t85 + twist2 * t86;
        const double t88 = t81 * t82 + t84 * t87;
        const double t89 = t46 * twist4 - t39 * twist5;
        const double t90 = t39 * twist3 - t30 * twist4;
        const double t91 = t46 * twist3 - t30 * twist5;
        const double t92 = t49 * t88 + t80 * t89 + t83 * (t39 * t85 + t46 * t86 + (twist1 * t90 +
            twist2 * t91));
        const double t93 = 1.0 / t77;
        const double t94 = t4 * t83;
        const double t95 = t77 - t94;
        const double t96 = t95 * t95 + t80 * (t4 * t80);
        const double t97 = t80 / t96;
        const double t98 = twist0 * t86 + twist1 * t82;
        const double t99 = t84 * t98 - t81 * t85;
        const double t100 = twist0 * t85 - twist2 * t82;
        const double t101 = t77 * twist4 + t80 * t86 + t83 * t100;
        const double t102 = t49 * t99 - t101 - t80 * t90 + t83 * (t30 * t86 + t39 * t82 + (twist0 *
            t91 + twist1 * t89));
        const double t103 = t77 * twist5 - t80 * t85 + t83 * t98;
        const double t104 = t81 * t86 + t84 * t100;
        const double t105 = t103 + t49 * t104 + t80 * t91 + t83 * (t30 * t85 - t46 * t82 + (twist0 *
            t90 - twist2 * t89));
        const double t106 = twist1 * t102 - twist2 * t105;
        const double t107 = (t80 * t80 - t83 * t95) / (t77 * t96);
        const double t108 = twist0 * t105 + twist1 * t92;
        const double t109 = twist2 * t92 + twist0 * t102;
        const double t110 = 2.0 * (twist0 * t34 + twist1 * t41 + twist2 * t47);
        const double t111 = t47 * twist4 - t41 * twist5;
        const double t112 = t41 * twist3 - t34 * twist4;
        const double t113 = t47 * twist3 - t34 * twist5;
        const double t114 = t103 + t88 * t110 + t80 * t111 + t83 * (t41 * t85 + t47 * t86 + (twist1
            * t112 + twist2 * t113));
        const double t115 = t77 * twist3 - t80 * t82 - t83 * t87;
        const double t116 = t115 + t99 * t110 - t80 * t112 + t83 * (t34 * t86 + t41 * t82 + (twist0
            * t113 + twist1 * t111));
        const double t117 = t104 * t110 + t80 * t113 + t83 * (t34 * t85 - t47 * t82 + (twist0 * t112
            - twist2 * t111));
        const double t118 = twist1 * t116 - twist2 * t117;
        const double t119 = twist0 * t117 + twist1 * t114;
        const double t120 = twist2 * t114 + twist0 * t116;
        const double t121 = 2.0 * (twist0 * t38 + twist1 * t45 + twist2 * t48);
        const double t122 = t45 * twist3 - t38 * twist4;
        const double t123 = t48 * twist3 - t38 * twist5;
        const double t124 = t48 * twist4 - t45 * twist5;
        const double t125 = t99 * t121 - t80 * t122 + t83 * (t38 * t86 + t45 * t82 + (twist0 * t123
            + twist1 * t124));
        const double t126 = t104 * t121 - t115 + t80 * t123 + t83 * (t38 * t85 - t48 * t82 + (twist0
            * t122 - twist2 * t124));
        const double t127 = twist1 * t125 - twist2 * t126;
        const double t128 = t101 - t88 * t121 - t80 * t124 - t83 * (t45 * t85 + t48 * t86 + (twist1
            * t122 + twist2 * t123));
        const double t129 = twist0 * t126 - twist1 * t128;
        const double t130 = twist0 * t125 - twist2 * t128;
        const double t131 = twist2 * t97;
        const double t132 = t31 * t107;
        const double t133 = t36 * t107;
        const double t134 = twist1 * t97;
        const double t135 = t66 * (t94 + twist6 * (t80 - t78));
        const double t136 = t66 * (t78 - t80 + twist6 * t83);
        const double t137 = t78 * twist3 - t82 * t135 - t87 * t136;
        const double t138 = t78 * twist4 + t86 * t135 + t100 * t136;
        const double t139 = t78 * twist5 - t85 * t135 + t98 * t136;
        const double t140 = twist2 * t138 - twist1 * t139;
        const double t141 = twist1 * t137 - twist0 * t138;
        const double t142 = twist2 * t137 - twist0 * t139;
        const double t143 = twist0 * t97;
        const double t144 = t42 * t107;
        out_at[i] = t30;
        out_at[out_step + i] = t34;
        out_at[2 * out_step + i] = t38;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = 0.0;
        out_at[5 * out_step + i] = 0.0;
        out_at[6 * out_step + i] = 0.0;
        out_at[7 * out_step + i] = t39;
        out_at[8 * out_step + i] = t41;
        out_at[9 * out_step + i] = t45;
        out_at[10 * out_step + i] = 0.0;
        out_at[11 * out_step + i] = 0.0;
        out_at[12 * out_step + i] = 0.0;
        out_at[13 * out_step + i] = 0.0;
        out_at[14 * out_step + i] = t46;
        out_at[15 * out_step + i] = t47;
        out_at[16 * out_step + i] = t48;
        out_at[17 * out_step + i] = 0.0;
        out_at[18 * out_step + i] = 0.0;
        out_at[19 * out_step + i] = 0.0;
        out_at[20 * out_step + i] = 0.0;
        out_at[21 * out_step + i] = t92 * t93 + t97 * t106 - t107 * (twist1 * t108 + twist2 * t109);
        out_at[22 * out_step + i] = t93 * t114 + t97 * t118 - t107 * (twist1 * t119 + twist2 *
            t120);
        out_at[23 * out_step + i] = t97 * t127 - t93 * t128 - t107 * (twist1 * t129 + twist2 *
            t130);
        out_at[24 * out_step + i] = t93 - t29 * t107;
        out_at[25 * out_step + i] = t131 + t132;
        out_at[26 * out_step + i] = t133 - t134;
        out_at[27 * out_step + i] = t93 * t137 + t97 * t140 - t107 * (twist1 * t141 + twist2 *
            t142);
        out_at[28 * out_step + i] = t107 * (twist0 * t108 - twist2 * t106) - (t93 * t105 + t97 *
            t109);
        out_at[29 * out_step + i] = t107 * (twist0 * t119 - twist2 * t118) - (t93 * t117 + t97 *
            t120);
        out_at[30 * out_step + i] = t107 * (twist0 * t129 - twist2 * t127) - (t93 * t126 + t97 *
            t130);
        out_at[31 * out_step + i] = t132 - t131;
        out_at[32 * out_step + i] = t93 - t40 * t107;
        out_at[33 * out_step + i] = t143 + t144;
        out_at[34 * out_step + i] = t93 * t138 - t97 * t142 + t107 * (twist0 * t141 - twist2 *
            t140);
        out_at[35 * out_step + i] = t97 * t108 - t93 * t102 + t107 * (twist0 * t109 + twist1 *
            t106);
        out_at[36 * out_step + i] = t97 * t119 - t93 * t116 + t107 * (twist0 * t120 + twist1 *
            t118);
        out_at[37 * out_step + i] = t97 * t129 - t93 * t125 + t107 * (twist0 * t130 + twist1 *
            t127);
        out_at[38 * out_step + i] = t133 + t134;
        out_at[39 * out_step + i] = t144 - t143;
        out_at[40 * out_step + i] = t93 - t2 * t107;
        out_at[41 * out_step + i] = t93 * t139 + t97 * t141 + t107 * (twist0 * t142 + twist1 *
            t140);
        out_at[42 * out_step + i] = 0.0;
        out_at[43 * out_step + i] = 0.0;
        out_at[44 * out_step + i] = 0.0;
        out_at[45 * out_step + i] = 0.0;
        out_at[46 * out_step + i] = 0.0;
        out_at[47 * out_step + i] = 0.0;
        out_at[48 * out_step + i] = 1.0;
    }
}
