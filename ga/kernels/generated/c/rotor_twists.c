/* Kernels of the group rotor_twists: rotor_of_twist, rotor_as_twist.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* rotor_of_twist: Rotor of a twist of any angle
 * in twist: rx ry rz
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_of_twist_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = sqrtf(t0 * t0 + t1 * t1 + t2 * t2);
        const float t4 = floorf(0.31830987f * t3 + 0.5f);
        const float t5 = 1.0f - 2.0f * (t4 - floorf(0.5f * t4) * 2.0f);
        const float t6 = t3 - t4 * 3.140625f - t4 * 0.0009675026f - t4 * 1.5099067e-07f - t4 *
            5.126688e-12f;
        const float t7 = t6 * t6;
        const float t8 = t7 * (t7 * (t7 * (-2.6050063e-07f * t7 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t9 = t7 * (t7 * (t7 * (t7 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t10 = t9 + 1.0f;
        const float t11 = ((t4 < 0.5f) ? t10 : t10 * (t5 * t6) / largerf(1.0f, t3));
        out_at[i] = t5 * (t7 * (t8 + -0.5f) + 1.0f);
        out_at[out_step + i] = t2 * t11;
        out_at[2 * out_step + i] = t1 * t11;
        out_at[3 * out_step + i] = t0 * t11;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_of_twist_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = sqrt(t0 * t0 + t1 * t1 + t2 * t2);
        const double t4 = floor(0.3183098861837907 * t3 + 0.5);
        const double t5 = 1.0 - 2.0 * (t4 - floor(0.5 * t4) * 2.0);
        const double t6 = t3 - t4 * 3.1415926218032837 - t4 * 3.1786509424591713e-08 - t4 *
            1.2246467202362698e-16;
        const double t7 = t6 - t4 * 7.891108333126411e-24;
        const double t8 = t7 * t7;
        const double t9 = t8 * (t8 * (4.608909074888812e-14 * t8 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t10 = t8 * (t8 * (t9 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t11 = t8 * (t8 * (t8 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t12 = t8 * (t8 * (t11 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t13 = 1.0 + t8 * (t8 * (t8 * t12 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t14 = ((t4 < 0.5) ? t13 : t13 * (t5 * t7) / larger(1.0, t3));
        out_at[i] = t5 * (1.0 + t8 * (t8 * (t8 * t10 + 0.041666666666663875) +
            -0.4999999999999997));
        out_at[out_step + i] = t2 * t14;
        out_at[2 * out_step + i] = t1 * t14;
        out_at[3 * out_step + i] = t0 * t14;
    }
}

/* rotor_as_twist: Twist of a rotor, by the sign that turns by at most π
 * in m: 1 e23 e31 e12
 * out out: rx ry rz */

MOTORCADE_SIMD
void motorcade_rotor_as_twist_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = -2.0f * (t4 * (t0 * m1));
        out_at[out_step + i] = -2.0f * (t4 * (t0 * m2));
        out_at[2 * out_step + i] = -2.0f * (t4 * (t0 * m3));
    }
}

MOTORCADE_SIMD
void motorcade_rotor_as_twist_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = -2.0 * (t9 * (t0 * m1));
        out_at[out_step + i] = -2.0 * (t9 * (t0 * m2));
        out_at[2 * out_step + i] = -2.0 * (t9 * (t0 * m3));
    }
}
