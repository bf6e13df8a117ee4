/* Kernels of the group rotors: rotor_compose, rotor_inverse, rotor_exp, rotor_log, rotor_log_long,
 * rotor_interpolate, rotor_interpolate_long.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* rotor_compose: Geometric product a b of rotors
 * in a: 1 e23 e31 e12
 * in b: 1 e23 e31 e12
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_compose_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict a_at = inputs[0];
    const ptrdiff_t a_step = input_steps[0];
    const float *restrict b_at = inputs[1];
    const ptrdiff_t b_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const float a3 = a_at[3 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i];
        out_at[i] = a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1;
        out_at[out_step + i] = a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2;
        out_at[2 * out_step + i] = b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2);
        out_at[3 * out_step + i] = a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_compose_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict a_at = inputs[0];
    const ptrdiff_t a_step = input_steps[0];
    const double *restrict b_at = inputs[1];
    const ptrdiff_t b_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const double a3 = a_at[3 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i];
        out_at[i] = a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1;
        out_at[out_step + i] = a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2;
        out_at[2 * out_step + i] = b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2);
        out_at[3 * out_step + i] = a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1;
    }
}

/* rotor_inverse: Reverse of a rotor: its inverse
 * in m: 1 e23 e31 e12
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_inverse_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i];
        out_at[i] = m0;
        out_at[out_step + i] = -m1;
        out_at[2 * out_step + i] = -m2;
        out_at[3 * out_step + i] = -m3;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_inverse_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i];
        out_at[i] = m0;
        out_at[out_step + i] = -m1;
        out_at[2 * out_step + i] = -m2;
        out_at[3 * out_step + i] = -m3;
    }
}

/* rotor_exp: Rotor of a bivector of any angle
 * in log: e23 e31 e12
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_exp_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict log_at = inputs[0];
    const ptrdiff_t log_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float log0 = log_at[i], log1 = log_at[log_step + i], log2 = log_at[2 * log_step + i];
        const float t0 = sqrtf(log2 * log2 + log1 * log1 + log0 * log0);
        const float t1 = floorf(0.31830987f * t0 + 0.5f);
        const float t2 = 1.0f - 2.0f * (t1 - floorf(0.5f * t1) * 2.0f);
        const float t3 = t0 - t1 * 3.140625f - t1 * 0.0009675026f - t1 * 1.5099067e-07f - t1 *
            5.126688e-12f;
        const float t4 = t3 * t3;
        const float t5 = t4 * (t4 * (t4 * (-2.6050063e-07f * t4 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t6 = t4 * (t4 * (t4 * (t4 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t7 = t6 + 1.0f;
        const float t8 = ((t1 < 0.5f) ? t7 : t7 * (t2 * t3) / largerf(1.0f, t0));
        out_at[i] = t2 * (t4 * (t5 + -0.5f) + 1.0f);
        out_at[out_step + i] = log0 * t8;
        out_at[2 * out_step + i] = log1 * t8;
        out_at[3 * out_step + i] = log2 * t8;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_exp_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict log_at = inputs[0];
    const ptrdiff_t log_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double log0 = log_at[i], log1 = log_at[log_step + i], log2 = log_at[2 * log_step + i];
        const double t0 = sqrt(log2 * log2 + log1 * log1 + log0 * log0);
        const double t1 = floor(0.3183098861837907 * t0 + 0.5);
        const double t2 = 1.0 - 2.0 * (t1 - floor(0.5 * t1) * 2.0);
        const double t3 = t0 - t1 * 3.1415926218032837 - t1 * 3.1786509424591713e-08 - t1 *
            1.2246467202362698e-16;
        const double t4 = t3 - t1 * 7.891108333126411e-24;
        const double t5 = t4 * t4;
        const double t6 = t5 * (t5 * (4.608909074888812e-14 * t5 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t7 = t5 * (t5 * (t6 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t8 = t5 * (t5 * (t5 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t9 = t5 * (t5 * (t8 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t10 = 1.0 + t5 * (t5 * (t5 * t9 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t11 = ((t1 < 0.5) ? t10 : t10 * (t2 * t4) / larger(1.0, t0));
        out_at[i] = t2 * (1.0 + t5 * (t5 * (t5 * t7 + 0.041666666666663875) + -0.4999999999999997));
        out_at[out_step + i] = log0 * t11;
        out_at[2 * out_step + i] = log1 * t11;
        out_at[3 * out_step + i] = log2 * t11;
    }
}

/* rotor_log: Bivector of a rotor, by the sign that turns by at most π
 * in m: 1 e23 e31 e12
 * out out: e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_log_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i];
        const float t0 = ((m0 < 0.0f) ? -1.0f : 1.0f);
        const float t1 = 1.0f - m0 * t0;
        const float t2 = t1 * (t1 * (t1 * (0.007290418f * t1 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t3 = t1 * (t1 * (t1 * (t1 * t2 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t4 = t1 * (t1 * t3 + 0.33333293f) + 1.0f;
        out_at[i] = t4 * (t0 * m1);
        out_at[out_step + i] = t4 * (t0 * m2);
        out_at[2 * out_step + i] = t4 * (t0 * m3);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_log_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i];
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
        out_at[i] = t9 * (t0 * m1);
        out_at[out_step + i] = t9 * (t0 * m2);
        out_at[2 * out_step + i] = t9 * (t0 * m3);
    }
}

/* rotor_log_long: Bivector of a rotor by its own sign, turning by up to 2π
 * in m: 1 e23 e31 e12
 * out out: e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_log_long_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i];
        const float t0 = 1.0f - fabsf(m0);
        const float t1 = t0 * (t0 * (t0 * (0.007290418f * t0 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t2 = t0 * (t0 * (t0 * (t0 * t1 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t3 = t0 * (t0 * t2 + 0.33333293f) + 1.0f;
        const float t4 = ((m0 < 0.0f) ? 3.1415927f / sqrtf(largerf(m1 * m1 + m2 * m2 + m3 * m3,
            1.6940659e-21f)) - t3 : t3);
        out_at[i] = m1 * t4;
        out_at[out_step + i] = m2 * t4;
        out_at[2 * out_step + i] = m3 * t4;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_log_long_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i];
        const double t0 = 3.141592653589793 / sqrt(larger(m1 * m1 + m2 * m2 + m3 * m3,
            1.0947644252537633e-47));
        const double t1 = 1.0 - fabs(m0);
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
        const double t10 = ((m0 < 0.0) ? t0 - t9 : t9);
        out_at[i] = m1 * t10;
        out_at[out_step + i] = m2 * t10;
        out_at[2 * out_step + i] = m3 * t10;
    }
}

/* rotor_interpolate: Screw a exp(fraction log(~a b)), the short way round
 * in a: 1 e23 e31 e12
 * in b: 1 e23 e31 e12
 * in fraction: fraction
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_interpolate_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a3 = a_at[3 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t1 = ((t0 < 0.0f) ? -1.0f : 1.0f);
        const float t2 = 1.0f - t0 * t1;
        const float t3 = t2 * (t2 * (t2 * (0.007290418f * t2 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t4 = t2 * (t2 * (t2 * (t2 * t3 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t5 = t2 * (t2 * t4 + 0.33333293f) + 1.0f;
        const float t6 = t5 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)) * fraction;
        const float t7 = fraction * (t5 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)));
        const float t8 = fraction * (t5 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)));
        const float t9 = sqrtf(t6 * t6 + t7 * t7 + t8 * t8);
        const float t10 = floorf(0.31830987f * t9 + 0.5f);
        const float t11 = 1.0f - 2.0f * (t10 - floorf(0.5f * t10) * 2.0f);
        const float t12 = t9 - t10 * 3.140625f - t10 * 0.0009675026f - t10 * 1.5099067e-07f - t10 *
            5.126688e-12f;
        const float t13 = t12 * t12;
        const float t14 = t13 * (t13 * (-2.6050063e-07f * t13 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t15 = t11 * (t13 * (t13 * t14 + -0.5f) + 1.0f);
        const float t16 = t13 * (t13 * (t13 * (t13 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t17 = t16 + 1.0f;
        const float t18 = ((t10 < 0.5f) ? t17 : t17 * (t11 * t12) / largerf(1.0f, t9));
        const float t19 = t6 * t18;
        const float t20 = t7 * t18;
        const float t21 = t8 * t18;
        out_at[i] = a0 * t15 - a3 * t19 + a2 * t20 - a1 * t21;
        out_at[out_step + i] = a0 * t21 - a2 * t19 + a1 * t15 - a3 * t20;
        out_at[2 * out_step + i] = a1 * t19 - (a0 * t20 + a3 * t21 - a2 * t15);
        out_at[3 * out_step + i] = a0 * t19 + a3 * t15 + a1 * t20 + a2 * t21;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_interpolate_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a3 = a_at[3 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i];
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
        const double t11 = t10 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)) * fraction;
        const double t12 = fraction * (t10 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)));
        const double t13 = fraction * (t10 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)));
        const double t14 = sqrt(t11 * t11 + t12 * t12 + t13 * t13);
        const double t15 = floor(0.3183098861837907 * t14 + 0.5);
        const double t16 = 1.0 - 2.0 * (t15 - floor(0.5 * t15) * 2.0);
        const double t17 = t14 - t15 * 3.1415926218032837 - t15 * 3.1786509424591713e-08 - t15 *
            1.2246467202362698e-16;
        const double t18 = t17 - t15 * 7.891108333126411e-24;
        const double t19 = t18 * t18;
        const double t20 = t19 * (4.608909074888812e-14 * t19 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t21 = t19 * (t19 * (t19 * t20 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t22 = t16 * (1.0 + t19 * (t19 * (t19 * t21 + 0.041666666666663875) +
            -0.4999999999999997));
        const double t23 = t19 * (t19 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t24 = t19 * (t19 * (t19 * t23 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t25 = 1.0 + t19 * (t19 * (t19 * t24 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t26 = ((t15 < 0.5) ? t25 : t25 * (t16 * t18) / larger(1.0, t14));
        const double t27 = t11 * t26;
        const double t28 = t12 * t26;
        const double t29 = t13 * t26;
        out_at[i] = a0 * t22 - a3 * t27 + a2 * t28 - a1 * t29;
        out_at[out_step + i] = a0 * t29 - a2 * t27 + a1 * t22 - a3 * t28;
        out_at[2 * out_step + i] = a1 * t27 - (a0 * t28 + a3 * t29 - a2 * t22);
        out_at[3 * out_step + i] = a0 * t27 + a3 * t22 + a1 * t28 + a2 * t29;
    }
}

/* rotor_interpolate_long: Screw a exp(fraction log(~a b)), by the signs of a and b
 * in a: 1 e23 e31 e12
 * in b: 1 e23 e31 e12
 * in fraction: fraction
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_interpolate_long_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a3 = a_at[3 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t1 = a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2;
        const float t2 = b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1;
        const float t3 = a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1;
        const float t4 = 1.0f - fabsf(t0);
        const float t5 = t4 * (t4 * (t4 * (0.007290418f * t4 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t6 = t4 * (t4 * (t4 * (t4 * t5 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t7 = t4 * (t4 * t6 + 0.33333293f) + 1.0f;
        const float t8 = ((t0 < 0.0f) ? 3.1415927f / sqrtf(largerf(t1 * t1 + t2 * t2 + t3 * t3,
            1.6940659e-21f)) - t7 : t7);
        const float t9 = t3 * t8 * fraction;
        const float t10 = fraction * (t2 * t8);
        const float t11 = fraction * (t1 * t8);
        const float t12 = sqrtf(t9 * t9 + t10 * t10 + t11 * t11);
        const float t13 = floorf(0.31830987f * t12 + 0.5f);
        const float t14 = 1.0f - 2.0f * (t13 - floorf(0.5f * t13) * 2.0f);
        const float t15 = t12 - t13 * 3.140625f - t13 * 0.0009675026f - t13 * 1.5099067e-07f - t13 *
            5.126688e-12f;
        const float t16 = t15 * t15;
        const float t17 = t16 * (t16 * (-2.6050063e-07f * t16 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t18 = t14 * (t16 * (t16 * t17 + -0.5f) + 1.0f);
        const float t19 = t16 * (t16 * (t16 * (t16 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t20 = t19 + 1.0f;
        const float t21 = ((t13 < 0.5f) ? t20 : t20 * (t14 * t15) / largerf(1.0f, t12));
        const float t22 = t9 * t21;
        const float t23 = t10 * t21;
        const float t24 = t11 * t21;
        out_at[i] = a0 * t18 - a3 * t22 + a2 * t23 - a1 * t24;
        out_at[out_step + i] = a0 * t24 - a2 * t22 + a1 * t18 - a3 * t23;
        out_at[2 * out_step + i] = a1 * t22 - (a0 * t23 + a3 * t24 - a2 * t18);
        out_at[3 * out_step + i] = a0 * t22 + a3 * t18 + a1 * t23 + a2 * t24;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_interpolate_long_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a3 = a_at[3 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const double t1 = a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2;
        const double t2 = b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1;
        const double t3 = a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1;
        const double t4 = 3.141592653589793 / sqrt(larger(t1 * t1 + t2 * t2 + t3 * t3,
            1.0947644252537633e-47));
        const double t5 = 1.0 - fabs(t0);
        const double t6 = t5 * (t5 * (8.121007252839173e-05 * t5 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t7 = t5 * (t5 * (t6 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t8 = t5 * (t5 * (t5 * t7 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t9 = t5 * (t5 * (t5 * t8 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t10 = t5 * (t5 * (t5 * t9 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t11 = t5 * (t5 * (t5 * t10 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t12 = t5 * (t5 * (t5 * t11 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t13 = 1.0 + t5 * t12;
        const double t14 = ((t0 < 0.0) ? t4 - t13 : t13);
        const double t15 = t3 * t14 * fraction;
        const double t16 = fraction * (t2 * t14);
        const double t17 = fraction * (t1 * t14);
        const double t18 = sqrt(t15 * t15 + t16 * t16 + t17 * t17);
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
        const double t27 = t23 * (t23 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t28 = t23 * (t23 * (t23 * t27 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t29 = 1.0 + t23 * (t23 * (t23 * t28 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t30 = ((t19 < 0.5) ? t29 : t29 * (t20 * t22) / larger(1.0, t18));
        const double t31 = t15 * t30;
        const double t32 = t16 * t30;
        const double t33 = t17 * t30;
        out_at[i] = a0 * t26 - a3 * t31 + a2 * t32 - a1 * t33;
        out_at[out_step + i] = a0 * t33 - a2 * t31 + a1 * t26 - a3 * t32;
        out_at[2 * out_step + i] = a1 * t31 - (a0 * t32 + a3 * t33 - a2 * t26);
        out_at[3 * out_step + i] = a0 * t31 + a3 * t26 + a1 * t32 + a2 * t33;
    }
}
