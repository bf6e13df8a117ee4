/* Kernels of the group rotor_tangents: rotor_adjoint, rotor_transform_twist, rotor_retract,
 * rotor_local.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* rotor_adjoint: Adjoint matrix of a rotor on twists
 * in m: 1 e23 e31 e12
 * out out: m00 m01 m02 m10 m11 m12 m20 m21 m22 */

MOTORCADE_SIMD
void motorcade_rotor_adjoint_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i];
        const float t0 = m1 * m1;
        const float t1 = m3 * m3;
        const float t2 = m0 * m0;
        const float t3 = m2 * m2;
        const float t4 = m1 * m2;
        const float t5 = m3 * m0;
        const float t6 = m1 * m3;
        const float t7 = m0 * m2;
        const float t8 = m3 * m2;
        const float t9 = m1 * m0;
        out_at[i] = t0 - t1 + t2 - t3;
        out_at[out_step + i] = (t4 + t5) * 2.0f;
        out_at[2 * out_step + i] = 2.0f * t6 - 2.0f * t7;
        out_at[3 * out_step + i] = t4 * 2.0f - t5 * 2.0f;
        out_at[4 * out_step + i] = -(t1 + (t0 - t3 - t2));
        out_at[5 * out_step + i] = 2.0f * (t8 + t9);
        out_at[6 * out_step + i] = 2.0f * (t6 + t7);
        out_at[7 * out_step + i] = 2.0f * (t8 - t9);
        out_at[8 * out_step + i] = t1 + t2 - t3 - t0;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_adjoint_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i];
        const double t0 = m1 * m1;
        const double t1 = m3 * m3;
        const double t2 = m0 * m0;
        const double t3 = m2 * m2;
        const double t4 = m1 * m2;
        const double t5 = m3 * m0;
        const double t6 = m1 * m3;
        const double t7 = m0 * m2;
        const double t8 = m3 * m2;
        const double t9 = m1 * m0;
        out_at[i] = t0 - t1 + t2 - t3;
        out_at[out_step + i] = (t4 + t5) * 2.0;
        out_at[2 * out_step + i] = 2.0 * t6 - 2.0 * t7;
        out_at[3 * out_step + i] = t4 * 2.0 - t5 * 2.0;
        out_at[4 * out_step + i] = -(t1 + (t0 - t3 - t2));
        out_at[5 * out_step + i] = 2.0 * (t8 + t9);
        out_at[6 * out_step + i] = 2.0 * (t6 + t7);
        out_at[7 * out_step + i] = 2.0 * (t8 - t9);
        out_at[8 * out_step + i] = t1 + t2 - t3 - t0;
    }
}

/* rotor_transform_twist: A twist seen from the other side of a rotor
 * in m: 1 e23 e31 e12
 * in twist: rx ry rz
 * out out: rx ry rz */

MOTORCADE_SIMD
void motorcade_rotor_transform_twist_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i];
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float t0 = m3 * twist2 + m2 * twist1 + m1 * twist0;
        const float t1 = m3 * twist0 - twist1 * m0 - twist2 * m1;
        const float t2 = twist0 * m0 - twist2 * m2 + m3 * twist1;
        const float t3 = twist2 * m0 - twist1 * m1 + m2 * twist0;
        out_at[i] = m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3;
        out_at[out_step + i] = -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2);
        out_at[2 * out_step + i] = m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_transform_twist_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i];
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double t0 = m3 * twist2 + m2 * twist1 + m1 * twist0;
        const double t1 = m3 * twist0 - twist1 * m0 - twist2 * m1;
        const double t2 = twist0 * m0 - twist2 * m2 + m3 * twist1;
        const double t3 = twist2 * m0 - twist1 * m1 + m2 * twist0;
        out_at[i] = m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3;
        out_at[out_step + i] = -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2);
        out_at[2 * out_step + i] = m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1;
    }
}

/* rotor_retract: A rotor moved by a twist in its own frame
 * in m: 1 e23 e31 e12
 * in twist: rx ry rz
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_retract_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i];
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
        const float t9 = t5 * (t7 * (t8 + -0.5f) + 1.0f);
        const float t10 = t7 * (t7 * (t7 * (t7 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t11 = t10 + 1.0f;
        const float t12 = ((t4 < 0.5f) ? t11 : t11 * (t5 * t6) / largerf(1.0f, t3));
        const float t13 = t0 * t12;
        const float t14 = t1 * t12;
        const float t15 = t2 * t12;
        out_at[i] = m0 * t9 - m3 * t13 - m2 * t14 - m1 * t15;
        out_at[out_step + i] = m0 * t15 - t13 * m2 + t9 * m1 + m3 * t14;
        out_at[2 * out_step + i] = t13 * m1 - (m3 * t15 - m0 * t14 - t9 * m2);
        out_at[3 * out_step + i] = m0 * t13 + t9 * m3 - t14 * m1 + m2 * t15;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_retract_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i];
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
        const double t11 = t5 * (1.0 + t8 * (t8 * (t8 * t10 + 0.041666666666663875) +
            -0.4999999999999997));
        const double t12 = t8 * (t8 * (t8 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t13 = t8 * (t8 * (t12 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t14 = 1.0 + t8 * (t8 * (t8 * t13 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t15 = ((t4 < 0.5) ? t14 : t14 * (t5 * t7) / larger(1.0, t3));
        const double t16 = t0 * t15;
        const double t17 = t1 * t15;
        const double t18 = t2 * t15;
        out_at[i] = m0 * t11 - m3 * t16 - m2 * t17 - m1 * t18;
        out_at[out_step + i] = m0 * t18 - t16 * m2 + t11 * m1 + m3 * t17;
        out_at[2 * out_step + i] = t16 * m1 - (m3 * t18 - m0 * t17 - t11 * m2);
        out_at[3 * out_step + i] = m0 * t16 + t11 * m3 - t17 * m1 + m2 * t18;
    }
}

/* rotor_local: The twist, turning by at most π, that takes rotor a to b
 * in a: 1 e23 e31 e12
 * in b: 1 e23 e31 e12
 * out out: rx ry rz */

MOTORCADE_SIMD
void motorcade_rotor_local_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t1 = ((t0 < 0.0f) ? -1.0f : 1.0f);
        const float t2 = 1.0f - t0 * t1;
        const float t3 = t2 * (t2 * (t2 * (0.007290418f * t2 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t4 = t2 * (t2 * (t2 * (t2 * t3 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t5 = t2 * (t2 * t4 + 0.33333293f) + 1.0f;
        out_at[i] = -2.0f * (t5 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)));
        out_at[out_step + i] = -(-2.0f * (t5 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1))));
        out_at[2 * out_step + i] = -2.0f * (t5 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)));
    }
}

MOTORCADE_SIMD
void motorcade_rotor_local_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = -2.0 * (t10 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2)));
        out_at[out_step + i] = -(-2.0 * (t10 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1))));
        out_at[2 * out_step + i] = -2.0 * (t10 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1)));
    }
}
