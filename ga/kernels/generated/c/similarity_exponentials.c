/* Kernels of the group similarity_exponentials: similarity_exp, similarity_log,
 * similarity_log_long.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_exp: Similarity of a bivector of any angle
 * in log: e23 e31 e12 E e1∞ e2∞ e3∞
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_exp_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict log_at = inputs[0];
    const ptrdiff_t log_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float log0 = log_at[i], log1 = log_at[log_step + i], log2 = log_at[2 * log_step + i];
        const float log3 = log_at[3 * log_step + i], log4 = log_at[4 * log_step + i], log5 = log_at[5 * log_step + i];
        const float log6 = log_at[6 * log_step + i];
        const float t0 = log0 * log0 + log1 * log1 + log2 * log2;
        const float t1 = sqrtf(t0);
        const float t2 = floorf(0.31830987f * t1 + 0.5f);
        const float t3 = 1.0f - 2.0f * (t2 - floorf(0.5f * t2) * 2.0f);
        const float t4 = t1 - t2 * 3.140625f - t2 * 0.0009675026f - t2 * 1.5099067e-07f - t2 *
            5.126688e-12f;
        const float t5 = t4 * t4;
        const float t6 = t5 * (t5 * (t5 * (-2.6050063e-07f * t5 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t7 = t3 * (t5 * (t6 + -0.5f) + 1.0f);
        const float t8 = floorf(0.5f + 1.442695f * log3);
        const float t9 = exp2_of_integerf(t8);
        const float t10 = exp2_of_integerf(-t8);
        const float t11 = 0.5f * (t9 + t10);
        const float t12 = log3 - t8 * 0.69311523f - t8 * 3.1946183e-05f;
        const float t13 = t12 * t12;
        const float t14 = t13 * (t13 * (0.0013949076f * t13 + 0.04166621f) + 0.5f) + 1.0f;
        const float t15 = 0.5f * (t9 - t10);
        const float t16 = t13 * (t13 * (t13 * 0.00019908122f + 0.008333283f) + 0.16666667f) + 1.0f;
        const float t17 = t12 * t16;
        const float t18 = t11 * t14 + t15 * t17;
        const float t19 = t5 * (t5 * (t5 * (t5 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t20 = t19 + 1.0f;
        const float t21 = ((t2 < 0.5f) ? t20 : t20 * (t3 * t4) / largerf(1.0f, t1));
        const float t22 = log0 * t21;
        const float t23 = log1 * t21;
        const float t24 = log2 * t21;
        const float t25 = t14 * t15 + t11 * t17;
        const float t26 = ((fabsf(t8) < 0.5f) ? t16 : fabsf(t25) / largerf(fabsf(log3), 0.25f));
        const float t27 = t7 * t26;
        const float t28 = log2 * log5 - log1 * log6;
        const float t29 = log0 * log6 - log2 * log4;
        const float t30 = log1 * log4 - log0 * log5;
        const float t31 = (t18 * t21 - t27) / largerf(t0 + log3 * log3, 1.6940659e-21f);
        out_at[i] = t7 * t18;
        out_at[out_step + i] = t18 * t22;
        out_at[2 * out_step + i] = t18 * t23;
        out_at[3 * out_step + i] = t18 * t24;
        out_at[4 * out_step + i] = t7 * t25;
        out_at[5 * out_step + i] = t22 * t25;
        out_at[6 * out_step + i] = t23 * t25;
        out_at[7 * out_step + i] = t24 * t25;
        out_at[8 * out_step + i] = log4 * t27 + (log3 * t28 - (log2 * t29 - log1 * t30)) * t31;
        out_at[9 * out_step + i] = t27 * log5 + t31 * (log3 * t29 - (log0 * t30 - log2 * t28));
        out_at[10 * out_step + i] = t27 * log6 + t31 * (log3 * t30 - (log1 * t28 - log0 * t29));
        out_at[11 * out_step + i] = (log2 * log6 + log0 * log4 + log1 * log5) * (t21 * t26);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_exp_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict log_at = inputs[0];
    const ptrdiff_t log_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double log0 = log_at[i], log1 = log_at[log_step + i], log2 = log_at[2 * log_step + i];
        const double log3 = log_at[3 * log_step + i], log4 = log_at[4 * log_step + i], log5 = log_at[5 * log_step + i];
        const double log6 = log_at[6 * log_step + i];
        const double t0 = log0 * log0 + log1 * log1 + log2 * log2;
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
        const double t10 = floor(0.5 + 1.4426950408889634 * log3);
        const double t11 = exp2_of_integer(t10);
        const double t12 = exp2_of_integer(-t10);
        const double t13 = 0.5 * (t11 + t12);
        const double t14 = log3 - t10 * 0.6931471675634384 - t10 * 1.2996506893889889e-08;
        const double t15 = t14 * t14;
        const double t16 = t15 * (t15 * (2.763326749998937e-07 * t15 + 2.480148377847191e-05) +
            0.001388888895391314);
        const double t17 = 1.0 + t15 * (t15 * (t16 + 0.04166666666648207) + 0.5000000000000019);
        const double t18 = 0.5 * (t11 - t12);
        const double t19 = t15 * (t15 * 2.5110520415965448e-08 + 2.755723960835094e-06) +
            0.00019841269891276224;
        const double t20 = 1.0 + t15 * (t15 * (t15 * t19 + 0.008333333333319138) +
            0.16666666666666682);
        const double t21 = t14 * t20;
        const double t22 = t13 * t17 + t18 * t21;
        const double t23 = t6 * (t6 * (t6 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t24 = t6 * (t6 * (t23 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t25 = 1.0 + t6 * (t6 * (t6 * t24 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t26 = ((t2 < 0.5) ? t25 : t25 * (t3 * t5) / larger(1.0, t1));
        const double t27 = log0 * t26;
        const double t28 = log1 * t26;
        const double t29 = log2 * t26;
        const double t30 = t17 * t18 + t13 * t21;
        const double t31 = ((fabs(t10) < 0.5) ? t20 : fabs(t30) / larger(fabs(log3), 0.25));
        const double t32 = t9 * t31;
        const double t33 = log2 * log5 - log1 * log6;
        const double t34 = log0 * log6 - log2 * log4;
        const double t35 = log1 * log4 - log0 * log5;
        const double t36 = (t22 * t26 - t32) / larger(t0 + log3 * log3, 1.0947644252537633e-47);
        out_at[i] = t9 * t22;
        out_at[out_step + i] = t22 * t27;
        out_at[2 * out_step + i] = t22 * t28;
        out_at[3 * out_step + i] = t22 * t29;
        out_at[4 * out_step + i] = t9 * t30;
        out_at[5 * out_step + i] = t27 * t30;
        out_at[6 * out_step + i] = t28 * t30;
        out_at[7 * out_step + i] = t29 * t30;
        out_at[8 * out_step + i] = log4 * t32 + (log3 * t33 - (log2 * t34 - log1 * t35)) * t36;
        out_at[9 * out_step + i] = t32 * log5 + t36 * (log3 * t34 - (log0 * t35 - log2 * t33));
        out_at[10 * out_step + i] = t32 * log6 + t36 * (log3 * t35 - (log1 * t33 - log0 * t34));
        out_at[11 * out_step + i] = (log2 * log6 + log0 * log4 + log1 * log5) * (t26 * t31);
    }
}

/* similarity_log: Bivector of a similarity, by the sign that turns by at most π
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: e23 e31 e12 E e1∞ e2∞ e3∞ */

MOTORCADE_SIMD
void motorcade_similarity_log_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float t0 = ((m0 < 0.0f) ? -1.0f : 1.0f);
        const float t1 = m0 * t0;
        const float t2 = t0 * m3;
        const float t3 = t0 * m2;
        const float t4 = t0 * m1;
        const float t5 = sqrtf(t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const float t6 = 1.0f / t5;
        const float t7 = t1 * t6;
        const float t8 = 1.0f - t7;
        const float t9 = t8 * (t8 * (t8 * (0.007290418f * t8 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t10 = t8 * (t8 * (t8 * (t8 * t9 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t11 = t8 * (t8 * t10 + 0.33333293f) + 1.0f;
        const float t12 = t4 * t6;
        const float t13 = t3 * t6;
        const float t14 = t2 * t6;
        const float t15 = t7 * (t0 * m4) + t14 * (t0 * m7) + t13 * (t0 * m6) + t12 * (t0 * m5);
        const float t16 = fabsf(t15);
        const float t17 = t5 + t16;
        const float t18 = exponentf(1.4142135f * t17);
        const _Bool t19 = (t18 < 0.5f);
        const float t20 = t17 * exp2_of_integerf(-t18);
        const float t21 = (t19 ? t16 : 0.5f * (t20 - 1.0f / t20));
        const float t22 = t21 * t21;
        const float t23 = t22 * (t22 * (t22 * (0.024318371f * t22 + -0.044006806f) + 0.07497201f) +
            -0.16666622f);
        const float t24 = t23 + 1.0f;
        const float t25 = (t19 ? t24 : (t18 * 0.69311523f + (t18 * 3.1946183e-05f + t21 * t24)) /
            largerf(t16, 0.25f));
        const float t26 = t0 * m8;
        const float t27 = t0 * m11;
        const float t28 = t0 * m10;
        const float t29 = t12 * t28 - t14 * t26;
        const float t30 = t0 * m9;
        const float t31 = t13 * t26 - t12 * t30;
        const float t32 = 1.0f / largerf(t12 * t12 + t13 * t13 + t14 * t14 + t15 * t15,
            1.6940659e-21f);
        const float t33 = (t7 * t25 - t5 * t11) * t32;
        const float t34 = t14 * t30 - t13 * t28;
        const float t35 = t32 * (t15 * (t7 * t11 - t5 * t25));
        out_at[i] = t11 * t12;
        out_at[out_step + i] = t11 * t13;
        out_at[2 * out_step + i] = t11 * t14;
        out_at[3 * out_step + i] = t15 * t25;
        out_at[4 * out_step + i] = t25 * (t7 * t26 + t12 * t27) + (t14 * t29 - t13 * t31) * t33 +
            t34 * t35;
        out_at[5 * out_step + i] = t25 * (t7 * t30 + t13 * t27) + t33 * (t12 * t31 - t14 * t34) +
            t29 * t35;
        out_at[6 * out_step + i] = t25 * (t7 * t28 + t14 * t27) + t33 * (t13 * t34 - t12 * t29) +
            t31 * t35;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_log_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double t0 = ((m0 < 0.0) ? -1.0 : 1.0);
        const double t1 = m0 * t0;
        const double t2 = t0 * m3;
        const double t3 = t0 * m2;
        const double t4 = t0 * m1;
        const double t5 = sqrt(t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const double t6 = 1.0 / t5;
        const double t7 = t1 * t6;
        const double t8 = 1.0 - t7;
        const double t9 = t8 * (t8 * (8.121007252839173e-05 * t8 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t10 = t8 * (t8 * (t9 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t11 = t8 * (t8 * (t8 * t10 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t12 = t8 * (t8 * (t8 * t11 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t13 = t8 * (t8 * (t8 * t12 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t14 = t8 * (t8 * (t8 * t13 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t15 = t8 * (t8 * (t8 * t14 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t16 = 1.0 + t8 * t15;
        const double t17 = t4 * t6;
        const double t18 = t3 * t6;
        const double t19 = t2 * t6;
        const double t20 = t7 * (t0 * m4) + t19 * (t0 * m7) + t18 * (t0 * m6) + t17 * (t0 * m5);
        const double t21 = fabs(t20);
        const double t22 = t5 + t21;
        const double t23 = exponent(1.4142135623730951 * t22);
        const _Bool t24 = (t23 < 0.5);
        const double t25 = t22 * exp2_of_integer(-t23);
        const double t26 = (t24 ? t21 : 0.5 * (t25 - 1.0 / t25));
        const double t27 = t26 * t26;
        const double t28 = t27 * (t27 * (-0.005811206588331519 * t27 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t29 = t27 * (t27 * (t28 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t30 = t27 * (t27 * (t27 * t29 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        const double t31 = 1.0 + t27 * t30;
        const double t32 = (t23 * 0.6931471675634384 + (t23 * 1.2996506893889889e-08 + t26 * t31)) /
            larger(t21, 0.25);
        const double t33 = (t24 ? t31 : t32);
        const double t34 = t0 * m8;
        const double t35 = t0 * m11;
        const double t36 = t0 * m10;
        const double t37 = t17 * t36 - t19 * t34;
        const double t38 = t0 * m9;
        const double t39 = t18 * t34 - t17 * t38;
        const double t40 = 1.0 / larger(t17 * t17 + t18 * t18 + t19 * t19 + t20 * t20,
            1.0947644252537633e-47);
        const double t41 = (t7 * t33 - t5 * t16) * t40;
        const double t42 = t19 * t38 - t18 * t36;
        const double t43 = t40 * (t20 * (t7 * t16 - t5 * t33));
        out_at[i] = t16 * t17;
        out_at[out_step + i] = t16 * t18;
        out_at[2 * out_step + i] = t16 * t19;
        out_at[3 * out_step + i] = t20 * t33;
        out_at[4 * out_step + i] = t33 * (t7 * t34 + t17 * t35) + (t19 * t37 - t18 * t39) * t41 +
            t42 * t43;
        out_at[5 * out_step + i] = t33 * (t7 * t38 + t18 * t35) + t41 * (t17 * t39 - t19 * t42) +
            t37 * t43;
        out_at[6 * out_step + i] = t33 * (t7 * t36 + t19 * t35) + t41 * (t18 * t42 - t17 * t37) +
            t39 * t43;
    }
}

/* similarity_log_long: Bivector of a similarity by its own sign, turning by up to 2π
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: e23 e31 e12 E e1∞ e2∞ e3∞ */

MOTORCADE_SIMD
void motorcade_similarity_log_long_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float t0 = sqrtf(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
        const float t1 = 1.0f / t0;
        const float t2 = m0 * t1;
        const float t3 = m1 * t1;
        const float t4 = m2 * t1;
        const float t5 = m3 * t1;
        const float t6 = t3 * t3 + t4 * t4 + t5 * t5;
        const float t7 = 1.0f - fabsf(t2);
        const float t8 = t7 * (t7 * (t7 * (0.007290418f * t7 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t9 = t7 * (t7 * (t7 * (t7 * t8 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t10 = t7 * (t7 * t9 + 0.33333293f) + 1.0f;
        const float t11 = ((t2 < 0.0f) ? 3.1415927f / sqrtf(largerf(t6, 1.6940659e-21f)) - t10 :
            t10);
        const float t12 = t2 * m4 + t5 * m7 + t4 * m6 + t3 * m5;
        const float t13 = fabsf(t12);
        const float t14 = t0 + t13;
        const float t15 = exponentf(1.4142135f * t14);
        const _Bool t16 = (t15 < 0.5f);
        const float t17 = t14 * exp2_of_integerf(-t15);
        const float t18 = (t16 ? t13 : 0.5f * (t17 - 1.0f / t17));
        const float t19 = t18 * t18;
        const float t20 = t19 * (t19 * (t19 * (0.024318371f * t19 + -0.044006806f) + 0.07497201f) +
            -0.16666622f);
        const float t21 = t20 + 1.0f;
        const float t22 = (t16 ? t21 : (t15 * 0.69311523f + (t15 * 3.1946183e-05f + t18 * t21)) /
            largerf(t13, 0.25f));
        const float t23 = t3 * m10 - t5 * m8;
        const float t24 = t4 * m8 - t3 * m9;
        const float t25 = 1.0f / largerf(1.6940659e-21f, t6 + t12 * t12);
        const float t26 = (t2 * t22 - t0 * t11) * t25;
        const float t27 = t5 * m9 - t4 * m10;
        const float t28 = t25 * (t12 * (t2 * t11 - t0 * t22));
        out_at[i] = t3 * t11;
        out_at[out_step + i] = t4 * t11;
        out_at[2 * out_step + i] = t5 * t11;
        out_at[3 * out_step + i] = t12 * t22;
        out_at[4 * out_step + i] = t22 * (t2 * m8 + t3 * m11) + (t5 * t23 - t4 * t24) * t26 + t27 *
            t28;
        out_at[5 * out_step + i] = t22 * (t2 * m9 + t4 * m11) + t26 * (t3 * t24 - t5 * t27) + t23 *
            t28;
        out_at[6 * out_step + i] = t22 * (t2 * m10 + t5 * m11) + t26 * (t4 * t27 - t3 * t23) + t24 *
            t28;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_log_long_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double t0 = sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
        const double t1 = 1.0 / t0;
        const double t2 = m0 * t1;
        const double t3 = m1 * t1;
        const double t4 = m2 * t1;
        const double t5 = m3 * t1;
        const double t6 = t3 * t3 + t4 * t4 + t5 * t5;
        const double t7 = 1.0 - fabs(t2);
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
        const double t16 = ((t2 < 0.0) ? 3.141592653589793 / sqrt(larger(t6,
            1.0947644252537633e-47)) - t15 : t15);
        const double t17 = t2 * m4 + t5 * m7 + t4 * m6 + t3 * m5;
        const double t18 = fabs(t17);
        const double t19 = t0 + t18;
        const double t20 = exponent(1.4142135623730951 * t19);
        const _Bool t21 = (t20 < 0.5);
        const double t22 = t19 * exp2_of_integer(-t20);
        const double t23 = (t21 ? t18 : 0.5 * (t22 - 1.0 / t22));
        const double t24 = t23 * t23;
        const double t25 = t24 * (t24 * (-0.005811206588331519 * t24 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t26 = t24 * (t24 * (t25 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t27 = t24 * (t24 * (t24 * t26 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        const double t28 = 1.0 + t24 * t27;
        const double t29 = (t20 * 0.6931471675634384 + (t20 * 1.2996506893889889e-08 + t23 * t28)) /
            larger(t18, 0.25);
        const double t30 = (t21 ? t28 : t29);
        const double t31 = t3 * m10 - t5 * m8;
        const double t32 = t4 * m8 - t3 * m9;
        const double t33 = 1.0 / larger(1.0947644252537633e-47, t6 + t17 * t17);
        const double t34 = (t2 * t30 - t0 * t16) * t33;
        const double t35 = t5 * m9 - t4 * m10;
        const double t36 = t33 * (t17 * (t2 * t16 - t0 * t30));
        out_at[i] = t3 * t16;
        out_at[out_step + i] = t4 * t16;
        out_at[2 * out_step + i] = t5 * t16;
        out_at[3 * out_step + i] = t17 * t30;
        out_at[4 * out_step + i] = t30 * (t2 * m8 + t3 * m11) + (t5 * t31 - t4 * t32) * t34 + t35 *
            t36;
        out_at[5 * out_step + i] = t30 * (t2 * m9 + t4 * m11) + t34 * (t3 * t32 - t5 * t35) + t31 *
            t36;
        out_at[6 * out_step + i] = t30 * (t2 * m10 + t5 * m11) + t34 * (t4 * t35 - t3 * t31) + t32 *
            t36;
    }
}
