/* Kernels of the group exponentials: exp, log, log_long.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* exp: Motor of a bivector of any angle
 * in log: e23 e31 e12 e1∞ e2∞ e3∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_exp_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict log_at = inputs[0];
    const ptrdiff_t log_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float log0 = log_at[i], log1 = log_at[log_step + i], log2 = log_at[2 * log_step + i];
        const float log3 = log_at[3 * log_step + i], log4 = log_at[4 * log_step + i], log5 = log_at[5 * log_step + i];
        const float t0 = log2 * log2 + log1 * log1 + log0 * log0;
        const float t1 = sqrtf(t0);
        const float t2 = floorf(0.31830987f * t1 + 0.5f);
        const float t3 = 1.0f - 2.0f * (t2 - floorf(0.5f * t2) * 2.0f);
        const float t4 = t1 - t2 * 3.140625f - t2 * 0.0009675026f - t2 * 1.5099067e-07f - t2 *
            5.126688e-12f;
        const float t5 = t4 * t4;
        const float t6 = t5 * (t5 * (t5 * (-2.6050063e-07f * t5 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t7 = t3 * (t5 * (t6 + -0.5f) + 1.0f);
        const _Bool t8 = (t2 < 0.5f);
        const float t9 = t5 * (t5 * (t5 * (t5 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t10 = t9 + 1.0f;
        const float t11 = (t8 ? t10 : t10 * (t3 * t4) / largerf(1.0f, t1));
        const float t12 = t5 * (t5 * (t5 * (t5 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f)
            + 0.016666664f);
        const float t13 = 2.0f * (log0 * log3 + (log2 * log5 + log1 * log4));
        const float t14 = (t8 ? t12 + -0.16666667f : (t7 - t11) / (2.0f * largerf(1.0f, t0))) * t13;
        out_at[i] = t7;
        out_at[out_step + i] = log0 * t11;
        out_at[2 * out_step + i] = log1 * t11;
        out_at[3 * out_step + i] = log2 * t11;
        out_at[4 * out_step + i] = t11 * log3 + log0 * t14;
        out_at[5 * out_step + i] = t11 * log4 + log1 * t14;
        out_at[6 * out_step + i] = t11 * log5 + log2 * t14;
        out_at[7 * out_step + i] = -(t13 * (t11 * -0.5f));
    }
}

MOTORCADE_SIMD
void motorcade_exp_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict log_at = inputs[0];
    const ptrdiff_t log_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double log0 = log_at[i], log1 = log_at[log_step + i], log2 = log_at[2 * log_step + i];
        const double log3 = log_at[3 * log_step + i], log4 = log_at[4 * log_step + i], log5 = log_at[5 * log_step + i];
        const double t0 = log2 * log2 + log1 * log1 + log0 * log0;
        const double t1 = sqrt(t0);
        const double t2 = floor(0.3183098861837907 * t1 + 0.5);
        const double t3 = 1.0 - 2.0 * (t2 - floor(0.5 * t2) * 2.0);
        const double t4 = t1 - t2 * 3.1415926218032837 - t2 * 3.1786509424591713e-08 - t2 *
            1.2246467202362698e-16;
        const double t5 = t4 - t2 * 7.891108333126411e-24;
        const double t6 = t5 * t5;
        const double t7 = t6 * (t6 * (4.608909074888812e-14 * t6 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t8 = t6 * (t6 * (t7 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t9 = t3 * (1.0 + t6 * (t6 * (t6 * t8 + 0.041666666666663875) +
            -0.4999999999999997));
        const _Bool t10 = (t2 < 0.5);
        const double t11 = t6 * (t6 * (t6 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t12 = t6 * (t6 * (t11 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t13 = 1.0 + t6 * (t6 * (t6 * t12 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t14 = (t10 ? t13 : t13 * (t3 * t5) / larger(1.0, t1));
        const double t15 = t6 * (t6 * (t6 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10);
        const double t16 = t6 * (t6 * (t15 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574;
        const double t17 = (t10 ? -0.16666666666666666 + t6 * (t6 * t16 + 0.01666666666666651) : (t9
            - t14) / (2.0 * larger(1.0, t0)));
        const double t18 = 2.0 * (log0 * log3 + (log2 * log5 + log1 * log4));
        const double t19 = t17 * t18;
        out_at[i] = t9;
        out_at[out_step + i] = log0 * t14;
        out_at[2 * out_step + i] = log1 * t14;
        out_at[3 * out_step + i] = log2 * t14;
        out_at[4 * out_step + i] = t14 * log3 + log0 * t19;
        out_at[5 * out_step + i] = t14 * log4 + log1 * t19;
        out_at[6 * out_step + i] = t14 * log5 + log2 * t19;
        out_at[7 * out_step + i] = -(t18 * (t14 * -0.5));
    }
}

/* log: Bivector of a motor, by the sign that turns by at most π
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: e23 e31 e12 e1∞ e2∞ e3∞ */

MOTORCADE_SIMD
void motorcade_log_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = t4 * t5;
        out_at[out_step + i] = t4 * t6;
        out_at[2 * out_step + i] = t4 * t7;
        out_at[3 * out_step + i] = t4 * (t0 * m4) + t5 * t10;
        out_at[4 * out_step + i] = t4 * (t0 * m5) + t6 * t10;
        out_at[5 * out_step + i] = t4 * (t0 * m6) + t7 * t10;
    }
}

MOTORCADE_SIMD
void motorcade_log_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = t9 * t10;
        out_at[out_step + i] = t9 * t11;
        out_at[2 * out_step + i] = t9 * t12;
        out_at[3 * out_step + i] = t9 * (t0 * m4) + t10 * t21;
        out_at[4 * out_step + i] = t9 * (t0 * m5) + t11 * t21;
        out_at[5 * out_step + i] = t9 * (t0 * m6) + t12 * t21;
    }
}

/* log_long: Bivector of a motor by its own sign, turning by up to 2π
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: e23 e31 e12 e1∞ e2∞ e3∞ */

MOTORCADE_SIMD
void motorcade_log_long_f32(MOTORCADE_ARGUMENTS(float))
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
        const _Bool t0 = (m0 < 0.0f);
        const float t1 = largerf(m1 * m1 + m2 * m2 + m3 * m3, 1.6940659e-21f);
        const float t2 = 3.1415927f / sqrtf(t1);
        const float t3 = 1.0f - fabsf(m0);
        const float t4 = t3 * (t3 * (t3 * (0.007290418f * t3 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t5 = t3 * (t3 * (t3 * (t3 * t4 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t6 = t3 * (t3 * t5 + 0.33333293f) + 1.0f;
        const float t7 = (t0 ? t2 - t6 : t6);
        const float t8 = t3 * (t3 * (t3 * (t3 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t9 = t3 * (t3 * (t3 * (t3 * t8 + -0.08780976f) + 0.06264518f) + 0.052127957f) +
            0.10218229f;
        const float t10 = t3 * (t3 * (t3 * t9 + 0.17139615f) + 0.26666737f) + 0.33333334f;
        const float t11 = (t0 ? t10 - t2 * (m0 / t1) : t10) * m7;
        out_at[i] = m1 * t7;
        out_at[out_step + i] = m2 * t7;
        out_at[2 * out_step + i] = m3 * t7;
        out_at[3 * out_step + i] = t7 * m4 + m1 * t11;
        out_at[4 * out_step + i] = t7 * m5 + m2 * t11;
        out_at[5 * out_step + i] = t7 * m6 + m3 * t11;
    }
}

MOTORCADE_SIMD
void motorcade_log_long_f64(MOTORCADE_ARGUMENTS(double))
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
        const _Bool t0 = (m0 < 0.0);
        const double t1 = larger(m1 * m1 + m2 * m2 + m3 * m3, 1.0947644252537633e-47);
        const double t2 = 3.141592653589793 / sqrt(t1);
        const double t3 = 1.0 - fabs(m0);
        const double t4 = t3 * (t3 * (8.121007252839173e-05 * t3 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t5 = t3 * (t3 * (t4 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t6 = t3 * (t3 * (t3 * t5 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t7 = t3 * (t3 * (t3 * t6 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t8 = t3 * (t3 * (t3 * t7 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t9 = t3 * (t3 * (t3 * t8 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t10 = t3 * (t3 * (t3 * (t3 * t9 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377);
        const double t11 = 1.0 + t10;
        const double t12 = (t0 ? t2 - t11 : t11);
        const double t13 = t3 * (t3 * (t3 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t14 = t3 * (t3 * (t3 * (t13 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t15 = t3 * (t3 * (t3 * (t14 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t16 = t3 * (t3 * (t15 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t17 = t3 * (t3 * (t3 * t16 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t18 = t3 * (t3 * (t3 * t17 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t19 = t3 * (t3 * (t3 * t18 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t20 = t3 * (t3 * (t3 * t19 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t21 = (t0 ? t20 - t2 * (m0 / t1) : t20) * m7;
        out_at[i] = m1 * t12;
        out_at[out_step + i] = m2 * t12;
        out_at[2 * out_step + i] = m3 * t12;
        out_at[3 * out_step + i] = t12 * m4 + m1 * t21;
        out_at[4 * out_step + i] = t12 * m5 + m2 * t21;
        out_at[5 * out_step + i] = t12 * m6 + m3 * t21;
    }
}
