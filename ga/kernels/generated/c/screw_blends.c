/* Kernels of the group screw_blends: screw_blend, screw_blend_matrix.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* screw_blend: Screw interpolation for fractions in [0, 1]
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_screw_blend_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = 1.0f - fraction;
        const float t1 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t2 = ((t1 < 0.0f) ? -1.0f : 1.0f);
        const float t3 = t1 * t2;
        const float t4 = 1.0f - t3;
        const float t5 = t4 * (t4 * (t4 * (0.007290418f * t4 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t6 = t4 * (t4 * (t4 * (t4 * t5 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t7 = t4 * (t4 * t6 + 0.33333293f) + 1.0f;
        const float t8 = t7 * t7 * (1.0f - t3 * t3);
        const float t9 = t0 * t0 * t8;
        const float t10 = t9 * (t9 * (t9 * (2.6050482e-06f * t9 + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t11 = t10 + 1.0f;
        const float t12 = t7 * (t0 * t11);
        const float t13 = t8 * (fraction * fraction);
        const float t14 = t13 * (-0.16666658f + t13 * (0.00833305f + t13 * (-0.00019808991f +
            2.6050482e-06f * t13)));
        const float t15 = 1.0f + t14;
        const float t16 = t2 * (t7 * (fraction * t15));
        const float t17 = t4 * (t4 * (t4 * (t4 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t18 = t4 * (t4 * (t4 * (t4 * t17 + -0.08780976f) + 0.06264518f) + 0.052127957f)
            + 0.10218229f;
        const float t19 = t4 * (t4 * (t4 * t18 + 0.17139615f) + 0.26666737f) + 0.33333334f;
        const float t20 = t9 * (t9 * (t9 * (t9 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f)
            + 0.016666664f);
        const float t21 = t2 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5
            - b2 * a5);
        const float t22 = t0 * (t11 * t19 + t7 * (t7 * (t0 * (t0 * 2.0f) * (t20 + -0.16666667f)))) *
            t21;
        const float t23 = 0.016666664f + t13 * (-0.0005952271f + t13 * (1.1010457e-05f + t13 *
            -1.1944519e-07f));
        const float t24 = fraction * (t15 * t19 + t7 * (t7 * (fraction * (fraction * 2.0f) *
            (-0.16666667f + t13 * t23))));
        const float t25 = t2 * (t21 * t24);
        out_at[i] = a0 * t12 + b0 * t16;
        out_at[out_step + i] = a1 * t12 + b1 * t16;
        out_at[2 * out_step + i] = a2 * t12 + b2 * t16;
        out_at[3 * out_step + i] = a3 * t12 + b3 * t16;
        out_at[4 * out_step + i] = t12 * a4 + a1 * t22 + (t16 * b4 + b1 * t25);
        out_at[5 * out_step + i] = t12 * a5 + a2 * t22 + (t16 * b5 + b2 * t25);
        out_at[6 * out_step + i] = t12 * a6 + a3 * t22 + (t16 * b6 + b3 * t25);
        out_at[7 * out_step + i] = t12 * a7 - a0 * t22 + (t16 * b7 - b0 * t25);
    }
}

MOTORCADE_SIMD
void motorcade_screw_blend_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = 1.0 - fraction;
        const double t1 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const double t2 = ((t1 < 0.0) ? -1.0 : 1.0);
        const double t3 = t1 * t2;
        const double t4 = 1.0 - t3;
        const double t5 = t4 * (t4 * (8.121007252839173e-05 * t4 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t6 = t4 * (t4 * (t5 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t7 = t4 * (t4 * (t4 * t6 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t8 = t4 * (t4 * (t4 * t7 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t9 = t4 * (t4 * (t4 * t8 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t10 = t4 * (t4 * (t4 * t9 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t11 = t4 * (t4 * (t4 * t10 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t12 = 1.0 + t4 * t11;
        const double t13 = t12 * t12 * (1.0 - t3 * t3);
        const double t14 = t0 * t0 * t13;
        const double t15 = t14 * (2.721539074015491e-15 * t14 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t16 = t14 * (t14 * (t14 * t15 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t17 = 1.0 + t14 * (t14 * (t14 * t16 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t18 = t12 * (t0 * t17);
        const double t19 = t13 * (fraction * fraction);
        const double t20 = 1.6058940754212953e-10 + t19 * (-7.643023238169083e-13 +
            2.721539074015491e-15 * t19);
        const double t21 = -0.00019841269841208527 + t19 * (2.755731921120387e-06 + t19 *
            (-2.505210688815946e-08 + t19 * t20));
        const double t22 = 1.0 + t19 * (-0.16666666666666666 + t19 * (0.008333333333333186 + t19 *
            t21));
        const double t23 = t2 * (t12 * (fraction * t22));
        const double t24 = t4 * (t4 * (t4 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t25 = t4 * (t4 * (t4 * (t24 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t26 = t4 * (t4 * (t4 * (t25 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t27 = t4 * (t4 * (t26 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t28 = t4 * (t4 * (t4 * t27 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t29 = t4 * (t4 * (t4 * t28 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t30 = t4 * (t4 * (t4 * t29 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t31 = t4 * (t4 * (t4 * t30 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t32 = t14 * (t14 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t33 = t14 * (t14 * (t14 * t32 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t34 = t12 * (t0 * (t0 * 2.0) * (-0.16666666666666666 + t14 * (t14 * t33 +
            0.01666666666666651)));
        const double t35 = t2 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5
            - b2 * a5);
        const double t36 = t0 * (t17 * t31 + t12 * t34) * t35;
        const double t37 = 9.635366495989451e-10 + t19 * (-5.350144126598709e-12 + t19 *
            2.1772370641728367e-14);
        const double t38 = -0.0005952380952367574 + t19 * (1.1022927685256208e-05 + t19 *
            (-1.2526053501698183e-07 + t19 * t37));
        const double t39 = fraction * (fraction * 2.0) * (-0.16666666666666666 + t19 *
            (0.01666666666666651 + t19 * t38));
        const double t40 = t2 * (t35 * (fraction * (t22 * t31 + t12 * (t12 * t39))));
        out_at[i] = a0 * t18 + b0 * t23;
        out_at[out_step + i] = a1 * t18 + b1 * t23;
        out_at[2 * out_step + i] = a2 * t18 + b2 * t23;
        out_at[3 * out_step + i] = a3 * t18 + b3 * t23;
        out_at[4 * out_step + i] = t18 * a4 + a1 * t36 + (t23 * b4 + b1 * t40);
        out_at[5 * out_step + i] = t18 * a5 + a2 * t36 + (t23 * b5 + b2 * t40);
        out_at[6 * out_step + i] = t18 * a6 + a3 * t36 + (t23 * b6 + b3 * t40);
        out_at[7 * out_step + i] = t18 * a7 - a0 * t36 + (t23 * b7 - b0 * t40);
    }
}

/* screw_blend_matrix: Screw interpolation for fractions in [0, 1] as a 3×4 matrix
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 */

MOTORCADE_SIMD
void motorcade_screw_blend_matrix_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = 1.0f - fraction;
        const float t1 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t2 = ((t1 < 0.0f) ? -1.0f : 1.0f);
        const float t3 = t1 * t2;
        const float t4 = 1.0f - t3;
        const float t5 = t4 * (t4 * (t4 * (0.007290418f * t4 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t6 = t4 * (t4 * (t4 * (t4 * t5 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t7 = t4 * (t4 * t6 + 0.33333293f) + 1.0f;
        const float t8 = t7 * t7 * (1.0f - t3 * t3);
        const float t9 = t0 * t0 * t8;
        const float t10 = t9 * (t9 * (t9 * (2.6050482e-06f * t9 + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t11 = t10 + 1.0f;
        const float t12 = t7 * (t0 * t11);
        const float t13 = t8 * (fraction * fraction);
        const float t14 = t13 * (-0.16666658f + t13 * (0.00833305f + t13 * (-0.00019808991f +
            2.6050482e-06f * t13)));
        const float t15 = 1.0f + t14;
        const float t16 = t2 * (t7 * (fraction * t15));
        const float t17 = a0 * t12 + b0 * t16;
        const float t18 = t17 * t17;
        const float t19 = a3 * t12 + b3 * t16;
        const float t20 = t19 * t19;
        const float t21 = t18 - t20;
        const float t22 = a2 * t12 + b2 * t16;
        const float t23 = t22 * t22;
        const float t24 = a1 * t12 + b1 * t16;
        const float t25 = t24 * t24;
        const float t26 = t17 * t19 * 2.0f;
        const float t27 = 2.0f * (t22 * t24);
        const float t28 = t19 * t24;
        const float t29 = t17 * t22;
        const float t30 = t4 * (t4 * (t4 * (t4 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t31 = t4 * (t4 * (t4 * (t4 * t30 + -0.08780976f) + 0.06264518f) + 0.052127957f)
            + 0.10218229f;
        const float t32 = t4 * (t4 * (t4 * t31 + 0.17139615f) + 0.26666737f) + 0.33333334f;
        const float t33 = t9 * (t9 * (t9 * (t9 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f)
            + 0.016666664f);
        const float t34 = t2 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5
            - b2 * a5);
        const float t35 = t0 * (t11 * t32 + t7 * (t7 * (t0 * (t0 * 2.0f) * (t33 + -0.16666667f)))) *
            t34;
        const float t36 = 0.016666664f + t13 * (-0.0005952271f + t13 * (1.1010457e-05f + t13 *
            -1.1944519e-07f));
        const float t37 = fraction * (t15 * t32 + t7 * (t7 * (fraction * (fraction * 2.0f) *
            (-0.16666667f + t13 * t36))));
        const float t38 = t2 * (t34 * t37);
        const float t39 = t12 * a4 + a1 * t35 + (t16 * b4 + b1 * t38);
        const float t40 = t12 * a5 + a2 * t35 + (t16 * b5 + b2 * t38);
        const float t41 = t12 * a6 + a3 * t35 + (t16 * b6 + b3 * t38);
        const float t42 = t12 * a7 - a0 * t35 + (t16 * b7 - b0 * t38);
        const float t43 = t19 * t22;
        const float t44 = t17 * t24;
        out_at[i] = t21 - t23 + t25;
        out_at[out_step + i] = t26 + t27;
        out_at[2 * out_step + i] = 2.0f * (t28 - t29);
        out_at[3 * out_step + i] = -2.0f * (t17 * t39 + t19 * t40 - t22 * t41 + t24 * t42);
        out_at[4 * out_step + i] = t27 - t26;
        out_at[5 * out_step + i] = t21 + t23 - t25;
        out_at[6 * out_step + i] = 2.0f * (t43 + t44);
        out_at[7 * out_step + i] = -2.0f * (t17 * t40 - t19 * t39 + t22 * t42 + t24 * t41);
        out_at[8 * out_step + i] = 2.0f * (t28 + t29);
        out_at[9 * out_step + i] = 2.0f * (t43 - t44);
        out_at[10 * out_step + i] = t20 + (t18 - (t23 + t25));
        out_at[11 * out_step + i] = -2.0f * (t22 * t39 - t24 * t40 + t17 * t41 + t19 * t42);
    }
}

MOTORCADE_SIMD
void motorcade_screw_blend_matrix_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = 1.0 - fraction;
        const double t1 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const double t2 = ((t1 < 0.0) ? -1.0 : 1.0);
        const double t3 = t1 * t2;
        const double t4 = 1.0 - t3;
        const double t5 = t4 * (t4 * (8.121007252839173e-05 * t4 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t6 = t4 * (t4 * (t5 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t7 = t4 * (t4 * (t4 * t6 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t8 = t4 * (t4 * (t4 * t7 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t9 = t4 * (t4 * (t4 * t8 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t10 = t4 * (t4 * (t4 * t9 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t11 = t4 * (t4 * (t4 * t10 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t12 = 1.0 + t4 * t11;
        const double t13 = t12 * t12 * (1.0 - t3 * t3);
        const double t14 = t0 * t0 * t13;
        const double t15 = t14 * (2.721539074015491e-15 * t14 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t16 = t14 * (t14 * (t14 * t15 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t17 = 1.0 + t14 * (t14 * (t14 * t16 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t18 = t12 * (t0 * t17);
        const double t19 = t13 * (fraction * fraction);
        const double t20 = 1.6058940754212953e-10 + t19 * (-7.643023238169083e-13 +
            2.721539074015491e-15 * t19);
        const double t21 = -0.00019841269841208527 + t19 * (2.755731921120387e-06 + t19 *
            (-2.505210688815946e-08 + t19 * t20));
        const double t22 = 1.0 + t19 * (-0.16666666666666666 + t19 * (0.008333333333333186 + t19 *
            t21));
        const double t23 = t2 * (t12 * (fraction * t22));
        const double t24 = a0 * t18 + b0 * t23;
        const double t25 = t24 * t24;
        const double t26 = a3 * t18 + b3 * t23;
        const double t27 = t26 * t26;
        const double t28 = t25 - t27;
        const double t29 = a2 * t18 + b2 * t23;
        const double t30 = t29 * t29;
        const double t31 = a1 * t18 + b1 * t23;
        const double t32 = t31 * t31;
        const double t33 = t24 * t26 * 2.0;
        const double t34 = 2.0 * (t29 * t31);
        const double t35 = t26 * t31;
        const double t36 = t24 * t29;
        const double t37 = t4 * (t4 * (t4 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t38 = t4 * (t4 * (t4 * (t37 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t39 = t4 * (t4 * (t4 * (t38 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t40 = t4 * (t4 * (t39 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t41 = t4 * (t4 * (t4 * t40 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t42 = t4 * (t4 * (t4 * t41 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t43 = t4 * (t4 * (t4 * t42 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t44 = t4 * (t4 * (t4 * t43 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t45 = t14 * (t14 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t46 = t14 * (t14 * (t14 * t45 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t47 = t12 * (t0 * (t0 * 2.0) * (-0.16666666666666666 + t14 * (t14 * t46 +
            0.01666666666666651)));
        const double t48 = t2 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5
            - b2 * a5);
        const double t49 = t0 * (t17 * t44 + t12 * t47) * t48;
        const double t50 = 9.635366495989451e-10 + t19 * (-5.350144126598709e-12 + t19 *
            2.1772370641728367e-14);
        const double t51 = -0.0005952380952367574 + t19 * (1.1022927685256208e-05 + t19 *
            (-1.2526053501698183e-07 + t19 * t50));
        const double t52 = fraction * (fraction * 2.0) * (-0.16666666666666666 + t19 *
            (0.01666666666666651 + t19 * t51));
        const double t53 = t2 * (t48 * (fraction * (t22 * t44 + t12 * (t12 * t52))));
        const double t54 = t18 * a4 + a1 * t49 + (t23 * b4 + b1 * t53);
        const double t55 = t18 * a5 + a2 * t49 + (t23 * b5 + b2 * t53);
        const double t56 = t18 * a6 + a3 * t49 + (t23 * b6 + b3 * t53);
        const double t57 = t18 * a7 - a0 * t49 + (t23 * b7 - b0 * t53);
        const double t58 = t26 * t29;
        const double t59 = t24 * t31;
        out_at[i] = t28 - t30 + t32;
        out_at[out_step + i] = t33 + t34;
        out_at[2 * out_step + i] = 2.0 * (t35 - t36);
        out_at[3 * out_step + i] = -2.0 * (t24 * t54 + t26 * t55 - t29 * t56 + t31 * t57);
        out_at[4 * out_step + i] = t34 - t33;
        out_at[5 * out_step + i] = t28 + t30 - t32;
        out_at[6 * out_step + i] = 2.0 * (t58 + t59);
        out_at[7 * out_step + i] = -2.0 * (t24 * t55 - t26 * t54 + t29 * t57 + t31 * t56);
        out_at[8 * out_step + i] = 2.0 * (t35 + t36);
        out_at[9 * out_step + i] = 2.0 * (t58 - t59);
        out_at[10 * out_step + i] = t27 + (t25 - (t30 + t32));
        out_at[11 * out_step + i] = -2.0 * (t29 * t54 - t31 * t55 + t24 * t56 + t26 * t57);
    }
}
