/* Kernels of the group screws: interpolate, interpolate_long.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* interpolate: Screw a exp(fraction log(~a b)), the short way round
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_interpolate_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t1 = ((t0 < 0.0f) ? -1.0f : 1.0f);
        const float t2 = 1.0f - t0 * t1;
        const float t3 = t2 * (t2 * (t2 * (0.007290418f * t2 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t4 = t2 * (t2 * (t2 * (t2 * t3 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t5 = t2 * (t2 * t4 + 0.33333293f) + 1.0f;
        const float t6 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1);
        const float t7 = t5 * t6 * fraction;
        const float t8 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1);
        const float t9 = fraction * (t5 * t8);
        const float t10 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2);
        const float t11 = fraction * (t5 * t10);
        const float t12 = t7 * t7 + t9 * t9 + t11 * t11;
        const float t13 = sqrtf(t12);
        const float t14 = floorf(0.31830987f * t13 + 0.5f);
        const float t15 = 1.0f - 2.0f * (t14 - floorf(0.5f * t14) * 2.0f);
        const float t16 = t13 - t14 * 3.140625f - t14 * 0.0009675026f - t14 * 1.5099067e-07f - t14 *
            5.126688e-12f;
        const float t17 = t16 * t16;
        const float t18 = t17 * (t17 * (-2.6050063e-07f * t17 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t19 = t15 * (t17 * (t17 * t18 + -0.5f) + 1.0f);
        const _Bool t20 = (t14 < 0.5f);
        const float t21 = t17 * (t17 * (t17 * (t17 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t22 = t21 + 1.0f;
        const float t23 = (t20 ? t22 : t22 * (t15 * t16) / largerf(1.0f, t13));
        const float t24 = t7 * t23;
        const float t25 = t9 * t23;
        const float t26 = t11 * t23;
        const float t27 = t5 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2
            * a6 - b1 * a7));
        const float t28 = t2 * (t2 * (t2 * (t2 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t29 = t2 * (t2 * (t2 * (t2 * t28 + -0.08780976f) + 0.06264518f) + 0.052127957f)
            + 0.10218229f;
        const float t30 = (t2 * (t2 * (t2 * t29 + 0.17139615f) + 0.26666737f) + 0.33333334f) * (t1 *
            (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5 - b2 * a5));
        const float t31 = fraction * (t27 + t10 * t30);
        const float t32 = t17 * (t17 * (t17 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f) +
            0.016666664f;
        const float t33 = t5 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1
            * b5 - b3 * a7));
        const float t34 = fraction * (t33 + t6 * t30);
        const float t35 = t5 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3
            * b4 + b1 * a6));
        const float t36 = fraction * (t35 - t8 * t30);
        const float t37 = 2.0f * (t7 * t34 + t11 * t31 - t9 * t36);
        const float t38 = (t20 ? t17 * t32 + -0.16666667f : (t19 - t23) / (2.0f * largerf(1.0f,
            t12))) * t37;
        const float t39 = t23 * t31 + t11 * t38;
        const float t40 = t23 * t36 - t9 * t38;
        const float t41 = t23 * t34 + t7 * t38;
        const float t42 = t37 * (t23 * -0.5f);
        const float t43 = a0 * t39 + a3 * t40 - a2 * t41 + t19 * a4 + a1 * t42 - t24 * a5 - t25 * a6
            - t26 * a7;
        const float t44 = a0 * t40 + a2 * t42 + t24 * a4 + a1 * t41 + t19 * a5 + t25 * a7 - a3 * t39
            - t26 * a6;
        const float t45 = a0 * t41 + t25 * a4 + t26 * a5 + t19 * a6 + a3 * t42 + a2 * t39 - a1 * t40
            - t24 * a7;
        const float t46 = a3 * t41 - a0 * t42 + t26 * a4 + a1 * t39 + t24 * a6 + t19 * a7 + a2 * t40
            - t25 * a5;
        out_at[i] = a0 * t19 - a3 * t24 + a2 * t25 - a1 * t26;
        out_at[out_step + i] = a0 * t26 - a2 * t24 + a1 * t19 - a3 * t25;
        out_at[2 * out_step + i] = a1 * t24 - (a0 * t25 + a3 * t26 - a2 * t19);
        out_at[3 * out_step + i] = a0 * t24 + a3 * t19 + a1 * t25 + a2 * t26;
        out_at[4 * out_step + i] = t43;
        out_at[5 * out_step + i] = t44;
        out_at[6 * out_step + i] = t45;
        out_at[7 * out_step + i] = t46;
    }
}

MOTORCADE_SIMD
void motorcade_interpolate_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const double t1 = ((t0 < 0.0) ? -1.0 : 1.0);
        const double t2 = 1.0 - t0 * t1;
        const double t3 = t2 * (t2 * (8.121007252839173e-05 * t2 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t4 = t2 * (t2 * (t3 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t5 = t2 * (t2 * (t2 * t4 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t6 = t2 * (t2 * (t2 * t5 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t7 = t2 * (t2 * (t2 * t6 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t8 = t2 * (t2 * (t2 * t7 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t9 = t2 * (t2 * (t2 * (t2 * t8 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377);
        const double t10 = 1.0 + t9;
        const double t11 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1);
        const double t12 = t10 * t11 * fraction;
        const double t13 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1);
        const double t14 = fraction * (t10 * t13);
        const double t15 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2);
        const double t16 = fraction * (t10 * t15);
        const double t17 = t12 * t12 + t14 * t14 + t16 * t16;
        const double t18 = sqrt(t17);
        const double t19 = floor(0.3183098861837907 * t18 + 0.5);
        const double t20 = 1.0 - 2.0 * (t19 - floor(0.5 * t19) * 2.0);
        const double t21 = t18 - t19 * 3.1415926218032837 - t19 * 3.1786509424591713e-08 - t19 *
            1.2246467202362698e-16;
        const double t22 = t21 - t19 * 7.891108333126411e-24;
        const double t23 = t22 * t22;
        const double t24 = t23 * (4.608909074888812e-14 * t23 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t25 = t23 * (t23 * (t23 * t24 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t26 = t20 * (1.0 + t23 * (t23 * (t23 * t25 + 0.041666666666663875) +
            -0.4999999999999997));
        const _Bool t27 = (t19 < 0.5);
        const double t28 = t23 * (t23 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t29 = t23 * (t23 * (t23 * t28 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t30 = 1.0 + t23 * (t23 * (t23 * t29 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t31 = (t27 ? t30 : t30 * (t20 * t22) / larger(1.0, t18));
        const double t32 = t12 * t31;
        const double t33 = t14 * t31;
        const double t34 = t16 * t31;
        const double t35 = t10 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 -
            b2 * a6 - b1 * a7));
        const double t36 = t2 * (t2 * (t2 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t37 = t2 * (t2 * (t2 * (t36 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t38 = t2 * (t2 * (t2 * (t37 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t39 = t2 * (t2 * (t38 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t40 = t2 * (t2 * (t2 * t39 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t41 = t2 * (t2 * (t2 * t40 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t42 = t2 * (t2 * (t2 * t41 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t43 = t2 * (t2 * (t2 * t42 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t44 = t43 * (t1 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 -
            a2 * b5 - b2 * a5));
        const double t45 = fraction * (t35 + t15 * t44);
        const double t46 = t23 * (t23 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t47 = t23 * (t23 * (t23 * t46 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t48 = (t27 ? -0.16666666666666666 + t23 * (t23 * t47 + 0.01666666666666651) :
            (t26 - t31) / (2.0 * larger(1.0, t17)));
        const double t49 = t10 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 +
            a1 * b5 - b3 * a7));
        const double t50 = fraction * (t49 + t11 * t44);
        const double t51 = t10 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 +
            a3 * b4 + b1 * a6));
        const double t52 = fraction * (t51 - t13 * t44);
        const double t53 = 2.0 * (t12 * t50 + t16 * t45 - t14 * t52);
        const double t54 = t48 * t53;
        const double t55 = t31 * t45 + t16 * t54;
        const double t56 = t31 * t52 - t14 * t54;
        const double t57 = t31 * t50 + t12 * t54;
        const double t58 = t53 * (t31 * -0.5);
        const double t59 = a0 * t55 + a3 * t56 - a2 * t57 + t26 * a4 + a1 * t58 - t32 * a5 - t33 *
            a6 - t34 * a7;
        const double t60 = a0 * t56 + a2 * t58 + t32 * a4 + a1 * t57 + t26 * a5 + t33 * a7 - a3 *
            t55 - t34 * a6;
        const double t61 = a0 * t57 + t33 * a4 + t34 * a5 + t26 * a6 + a3 * t58 + a2 * t55 - a1 *
            t56 - t32 * a7;
        const double t62 = a3 * t57 - a0 * t58 + t34 * a4 + a1 * t55 + t32 * a6 + t26 * a7 + a2 *
            t56 - t33 * a5;
        out_at[i] = a0 * t26 - a3 * t32 + a2 * t33 - a1 * t34;
        out_at[out_step + i] = a0 * t34 - a2 * t32 + a1 * t26 - a3 * t33;
        out_at[2 * out_step + i] = a1 * t32 - (a0 * t33 + a3 * t34 - a2 * t26);
        out_at[3 * out_step + i] = a0 * t32 + a3 * t26 + a1 * t33 + a2 * t34;
        out_at[4 * out_step + i] = t59;
        out_at[5 * out_step + i] = t60;
        out_at[6 * out_step + i] = t61;
        out_at[7 * out_step + i] = t62;
    }
}

/* interpolate_long: Screw a exp(fraction log(~a b)), by the signs of a and b
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_interpolate_long_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const _Bool t1 = (t0 < 0.0f);
        const float t2 = a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2;
        const float t3 = b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1;
        const float t4 = a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1;
        const float t5 = largerf(t2 * t2 + t3 * t3 + t4 * t4, 1.6940659e-21f);
        const float t6 = 3.1415927f / sqrtf(t5);
        const float t7 = 1.0f - fabsf(t0);
        const float t8 = t7 * (t7 * (t7 * (0.007290418f * t7 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t9 = t7 * (t7 * (t7 * (t7 * t8 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t10 = t7 * (t7 * t9 + 0.33333293f) + 1.0f;
        const float t11 = (t1 ? t6 - t10 : t10);
        const float t12 = t4 * t11 * fraction;
        const float t13 = fraction * (t3 * t11);
        const float t14 = fraction * (t2 * t11);
        const float t15 = t12 * t12 + t13 * t13 + t14 * t14;
        const float t16 = sqrtf(t15);
        const float t17 = floorf(0.31830987f * t16 + 0.5f);
        const float t18 = 1.0f - 2.0f * (t17 - floorf(0.5f * t17) * 2.0f);
        const float t19 = t16 - t17 * 3.140625f - t17 * 0.0009675026f - t17 * 1.5099067e-07f - t17 *
            5.126688e-12f;
        const float t20 = t19 * t19;
        const float t21 = t20 * (t20 * (-2.6050063e-07f * t20 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t22 = t18 * (t20 * (t20 * t21 + -0.5f) + 1.0f);
        const _Bool t23 = (t17 < 0.5f);
        const float t24 = t20 * (t20 * (t20 * (t20 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t25 = t24 + 1.0f;
        const float t26 = (t23 ? t25 : t25 * (t18 * t19) / largerf(1.0f, t16));
        const float t27 = t12 * t26;
        const float t28 = t13 * t26;
        const float t29 = t14 * t26;
        const float t30 = t11 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2 * a6
            - b1 * a7);
        const float t31 = t7 * (t7 * (t7 * (t7 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t32 = t7 * (t7 * (t7 * (t7 * t31 + -0.08780976f) + 0.06264518f) + 0.052127957f)
            + 0.10218229f;
        const float t33 = t7 * (t7 * (t7 * t32 + 0.17139615f) + 0.26666737f) + 0.33333334f;
        const float t34 = (t1 ? t33 - t6 * (t0 / t5) : t33) * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4
            - b3 * a6 + b0 * a7 - a2 * b5 - b2 * a5);
        const float t35 = fraction * (t30 + t2 * t34);
        const float t36 = t20 * (t20 * (t20 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f) +
            0.016666664f;
        const float t37 = t11 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1 * b5
            - b3 * a7);
        const float t38 = fraction * (t37 + t4 * t34);
        const float t39 = t11 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3 * b4
            + b1 * a6);
        const float t40 = fraction * (t39 - t3 * t34);
        const float t41 = 2.0f * (t12 * t38 + t14 * t35 - t13 * t40);
        const float t42 = (t23 ? t20 * t36 + -0.16666667f : (t22 - t26) / (2.0f * largerf(1.0f,
            t15))) * t41;
        const float t43 = t26 * t35 + t14 * t42;
        const float t44 = t26 * t40 - t13 * t42;
        const float t45 = t26 * t38 + t12 * t42;
        const float t46 = t41 * (t26 * -0.5f);
        const float t47 = a0 * t43 + a3 * t44 - a2 * t45 + t22 * a4 + a1 * t46 - t27 * a5 - t28 * a6
            - t29 * a7;
        const float t48 = a0 * t44 + a2 * t46 + t27 * a4 + a1 * t45 + t22 * a5 + t28 * a7 - a3 * t43
            - t29 * a6;
        const float t49 = a0 * t45 + t28 * a4 + t29 * a5 + t22 * a6 + a3 * t46 + a2 * t43 - a1 * t44
            - t27 * a7;
        const float t50 = a3 * t45 - a0 * t46 + t29 * a4 + a1 * t43 + t27 * a6 + t22 * a7 + a2 * t44
            - t28 * a5;
        out_at[i] = a0 * t22 - a3 * t27 + a2 * t28 - a1 * t29;
        out_at[out_step + i] = a0 * t29 - a2 * t27 + a1 * t22 - a3 * t28;
        out_at[2 * out_step + i] = a1 * t27 - (a0 * t28 + a3 * t29 - a2 * t22);
        out_at[3 * out_step + i] = a0 * t27 + a3 * t22 + a1 * t28 + a2 * t29;
        out_at[4 * out_step + i] = t47;
        out_at[5 * out_step + i] = t48;
        out_at[6 * out_step + i] = t49;
        out_at[7 * out_step + i] = t50;
    }
}

MOTORCADE_SIMD
void motorcade_interpolate_long_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const _Bool t1 = (t0 < 0.0);
        const double t2 = a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2;
        const double t3 = b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1;
        const double t4 = a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1;
        const double t5 = larger(t2 * t2 + t3 * t3 + t4 * t4, 1.0947644252537633e-47);
        const double t6 = 3.141592653589793 / sqrt(t5);
        const double t7 = 1.0 - fabs(t0);
        const double t8 = t7 * (t7 * (8.121007252839173e-05 * t7 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t9 = t7 * (t7 * (t8 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t10 = t7 * (t7 * (t7 * t9 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t11 = t7 * (t7 * (t7 * t10 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t12 = t7 * (t7 * (t7 * t11 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t13 = t7 * (t7 * (t7 * t12 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t14 = t7 * (t7 * (t7 * t13 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t15 = 1.0 + t7 * t14;
        const double t16 = (t1 ? t6 - t15 : t15);
        const double t17 = t4 * t16 * fraction;
        const double t18 = fraction * (t3 * t16);
        const double t19 = fraction * (t2 * t16);
        const double t20 = t17 * t17 + t18 * t18 + t19 * t19;
        const double t21 = sqrt(t20);
        const double t22 = floor(0.3183098861837907 * t21 + 0.5);
        const double t23 = 1.0 - 2.0 * (t22 - floor(0.5 * t22) * 2.0);
        const double t24 = t21 - t22 * 3.1415926218032837 - t22 * 3.1786509424591713e-08 - t22 *
            1.2246467202362698e-16;
        const double t25 = t24 - t22 * 7.891108333126411e-24;
        const double t26 = t25 * t25;
        const double t27 = t26 * (4.608909074888812e-14 * t26 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t28 = t26 * (t26 * (t26 * t27 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t29 = t23 * (1.0 + t26 * (t26 * (t26 * t28 + 0.041666666666663875) +
            -0.4999999999999997));
        const _Bool t30 = (t22 < 0.5);
        const double t31 = t26 * (t26 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t32 = t26 * (t26 * (t26 * t31 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t33 = 1.0 + t26 * (t26 * (t26 * t32 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t34 = (t30 ? t33 : t33 * (t23 * t25) / larger(1.0, t21));
        const double t35 = t17 * t34;
        const double t36 = t18 * t34;
        const double t37 = t19 * t34;
        const double t38 = t16 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2 *
            a6 - b1 * a7);
        const double t39 = t7 * (t7 * (t7 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t40 = t7 * (t7 * (t7 * (t39 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t41 = t7 * (t7 * (t7 * (t40 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t42 = t7 * (t7 * (t41 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t43 = t7 * (t7 * (t7 * t42 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t44 = t7 * (t7 * (t7 * t43 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t45 = t7 * (t7 * (t7 * t44 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t46 = t7 * (t7 * (t7 * t45 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t47 = (t1 ? t46 - t6 * (t0 / t5) : t46) * (a0 * b7 - a3 * b6 - b1 * a4 - a1 *
            b4 - b3 * a6 + b0 * a7 - a2 * b5 - b2 * a5);
        const double t48 = fraction * (t38 + t2 * t47);
        const double t49 = t26 * (t26 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t50 = t26 * (t26 * (t26 * t49 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t51 = (t30 ? -0.16666666666666666 + t26 * (t26 * t50 + 0.01666666666666651) :
            (t29 - t34) / (2.0 * larger(1.0, t20)));
        const double t52 = t16 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1 *
            b5 - b3 * a7);
        const double t53 = fraction * (t52 + t4 * t47);
        const double t54 = t16 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3 *
            b4 + b1 * a6);
        const double t55 = fraction * (t54 - t3 * t47);
        const double t56 = 2.0 * (t17 * t53 + t19 * t48 - t18 * t55);
        const double t57 = t51 * t56;
        const double t58 = t34 * t48 + t19 * t57;
        const double t59 = t34 * t55 - t18 * t57;
        const double t60 = t34 * t53 + t17 * t57;
        const double t61 = t56 * (t34 * -0.5);
        const double t62 = a0 * t58 + a3 * t59 - a2 * t60 + t29 * a4 + a1 * t61 - t35 * a5 - t36 *
            a6 - t37 * a7;
        const double t63 = a0 * t59 + a2 * t61 + t35 * a4 + a1 * t60 + t29 * a5 + t36 * a7 - a3 *
            t58 - t37 * a6;
        const double t64 = a0 * t60 + t36 * a4 + t37 * a5 + t29 * a6 + a3 * t61 + a2 * t58 - a1 *
            t59 - t35 * a7;
        const double t65 = a3 * t60 - a0 * t61 + t37 * a4 + a1 * t58 + t35 * a6 + t29 * a7 + a2 *
            t59 - t36 * a5;
        out_at[i] = a0 * t29 - a3 * t35 + a2 * t36 - a1 * t37;
        out_at[out_step + i] = a0 * t37 - a2 * t35 + a1 * t29 - a3 * t36;
        out_at[2 * out_step + i] = a1 * t35 - (a0 * t36 + a3 * t37 - a2 * t29);
        out_at[3 * out_step + i] = a0 * t35 + a3 * t29 + a1 * t36 + a2 * t37;
        out_at[4 * out_step + i] = t62;
        out_at[5 * out_step + i] = t63;
        out_at[6 * out_step + i] = t64;
        out_at[7 * out_step + i] = t65;
    }
}
