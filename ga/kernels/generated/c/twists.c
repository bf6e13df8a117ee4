/* Kernels of the group twists: of_twist, as_twist.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* of_twist: Motor of a twist of any angle
 * in twist: rx ry rz x y z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_of_twist_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const float t4 = sqrtf(t3);
        const float t5 = floorf(0.31830987f * t4 + 0.5f);
        const float t6 = 1.0f - 2.0f * (t5 - floorf(0.5f * t5) * 2.0f);
        const float t7 = t4 - t5 * 3.140625f - t5 * 0.0009675026f - t5 * 1.5099067e-07f - t5 *
            5.126688e-12f;
        const float t8 = t7 * t7;
        const float t9 = t8 * (t8 * (t8 * (-2.6050063e-07f * t8 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t10 = t6 * (t8 * (t9 + -0.5f) + 1.0f);
        const _Bool t11 = (t5 < 0.5f);
        const float t12 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t13 = t12 + 1.0f;
        const float t14 = (t11 ? t13 : t13 * (t6 * t7) / largerf(1.0f, t4));
        const float t15 = -0.5f * twist3;
        const float t16 = t8 * (t8 * (t8 * (t8 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f)
            + 0.016666664f);
        const float t17 = -0.5f * twist5;
        const float t18 = -0.5f * twist4;
        const float t19 = 2.0f * (t2 * t15 + (t0 * t17 + t1 * t18));
        const float t20 = (t11 ? t16 + -0.16666667f : (t10 - t14) / (2.0f * largerf(1.0f, t3))) *
            t19;
        out_at[i] = t10;
        out_at[out_step + i] = t2 * t14;
        out_at[2 * out_step + i] = t1 * t14;
        out_at[3 * out_step + i] = t0 * t14;
        out_at[4 * out_step + i] = t14 * t15 + t2 * t20;
        out_at[5 * out_step + i] = t14 * t18 + t1 * t20;
        out_at[6 * out_step + i] = t14 * t17 + t0 * t20;
        out_at[7 * out_step + i] = -(t19 * (-0.5f * t14));
    }
}

MOTORCADE_SIMD
void motorcade_of_twist_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const double t4 = sqrt(t3);
        const double t5 = floor(0.3183098861837907 * t4 + 0.5);
        const double t6 = 1.0 - 2.0 * (t5 - floor(0.5 * t5) * 2.0);
        const double t7 = t4 - t5 * 3.1415926218032837 - t5 * 3.1786509424591713e-08 - t5 *
            1.2246467202362698e-16;
        const double t8 = t7 - t5 * 7.891108333126411e-24;
        const double t9 = t8 * t8;
        const double t10 = t9 * (t9 * (4.608909074888812e-14 * t9 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t11 = t9 * (t9 * (t10 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t12 = t6 * (1.0 + t9 * (t9 * (t9 * t11 + 0.041666666666663875) +
            -0.4999999999999997));
        const _Bool t13 = (t5 < 0.5);
        const double t14 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t15 = t9 * (t9 * (t14 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t16 = 1.0 + t9 * (t9 * (t9 * t15 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t17 = (t13 ? t16 : t16 * (t6 * t8) / larger(1.0, t4));
        const double t18 = -0.5 * twist3;
        const double t19 = t9 * (t9 * (t9 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10);
        const double t20 = t9 * (t9 * (t19 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574;
        const double t21 = (t13 ? -0.16666666666666666 + t9 * (t9 * t20 + 0.01666666666666651) :
            (t12 - t17) / (2.0 * larger(1.0, t3)));
        const double t22 = -0.5 * twist5;
        const double t23 = -0.5 * twist4;
        const double t24 = 2.0 * (t2 * t18 + (t0 * t22 + t1 * t23));
        const double t25 = t21 * t24;
        out_at[i] = t12;
        out_at[out_step + i] = t2 * t17;
        out_at[2 * out_step + i] = t1 * t17;
        out_at[3 * out_step + i] = t0 * t17;
        out_at[4 * out_step + i] = t17 * t18 + t2 * t25;
        out_at[5 * out_step + i] = t17 * t23 + t1 * t25;
        out_at[6 * out_step + i] = t17 * t22 + t0 * t25;
        out_at[7 * out_step + i] = -(t24 * (-0.5 * t17));
    }
}

/* as_twist: Twist of a motor, by the sign that turns by at most π
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: rx ry rz x y z */

MOTORCADE_SIMD
void motorcade_as_twist_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float t0 = ((m0 < 0.0f) ? -1.0f : 1.0f);
        const float t1 = 1.0f - m0 * t0;
        const float t2 = t1 * (t1 * (t1 * (0.007290418f * t1 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t3 = t1 * (t1 * (t1 * (t1 * t2 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t4 = t1 * (t1 * t3 + 0.33333293f) + 1.0f;
        const float t5 = t0 * m1;
        const float t6 = t0 * m2;
        const float t7 = t0 * m3;
        const float t8 = t1 * (t1 * (t1 * (t1 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t9 = t1 * (t1 * (t1 * (t1 * t8 + -0.08780976f) + 0.06264518f) + 0.052127957f) +
            0.10218229f;
        const float t10 = (t1 * (t1 * (t1 * t9 + 0.17139615f) + 0.26666737f) + 0.33333334f) * (t0 *
            m7);
        out_at[i] = -2.0f * (t4 * t5);
        out_at[out_step + i] = -2.0f * (t4 * t6);
        out_at[2 * out_step + i] = -2.0f * (t4 * t7);
        out_at[3 * out_step + i] = -2.0f * (t4 * (t0 * m4) + t5 * t10);
        out_at[4 * out_step + i] = -2.0f * (t4 * (t0 * m5) + t6 * t10);
        out_at[5 * out_step + i] = -2.0f * (t4 * (t0 * m6) + t7 * t10);
    }
}

MOTORCADE_SIMD
void motorcade_as_twist_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double t0 = ((m0 < 0.0) ? -1.0 : 1.0);
        const double t1 = 1.0 - m0 * t0;
        const double t2 = t1 * (t1 * (8.121007252839173e-05 * t1 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t3 = t1 * (t1 * (t2 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t4 = t1 * (t1 * (t1 * t3 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t5 = t1 * (t1 * (t1 * t4 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t6 = t1 * (t1 * (t1 * t5 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t7 = t1 * (t1 * (t1 * t6 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t8 = t1 * (t1 * (t1 * (t1 * t7 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377);
        const double t9 = 1.0 + t8;
        const double t10 = t0 * m1;
        const double t11 = t0 * m2;
        const double t12 = t0 * m3;
        const double t13 = t1 * (t1 * (t1 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t14 = t1 * (t1 * (t1 * (t13 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t15 = t1 * (t1 * (t1 * (t14 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t16 = t1 * (t1 * (t15 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t17 = t1 * (t1 * (t1 * t16 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t18 = t1 * (t1 * (t1 * t17 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t19 = t1 * (t1 * (t1 * t18 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t20 = t1 * (t1 * (t1 * t19 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t21 = t20 * (t0 * m7);
        out_at[i] = -2.0 * (t9 * t10);
        out_at[out_step + i] = -2.0 * (t9 * t11);
        out_at[2 * out_step + i] = -2.0 * (t9 * t12);
        out_at[3 * out_step + i] = -2.0 * (t9 * (t0 * m4) + t10 * t21);
        out_at[4 * out_step + i] = -2.0 * (t9 * (t0 * m5) + t11 * t21);
        out_at[5 * out_step + i] = -2.0 * (t9 * (t0 * m6) + t12 * t21);
    }
}
