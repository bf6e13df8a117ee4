/* Kernels of the group rotor_conversions: rotor_apply, rotor_matrix33, rotor_of_matrix33,
 * rotor_of_coefficients, rotor_of_quaternion, rotor_normalize.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* rotor_apply: Vectors turned by rotors: ``x + 2 v×(v×x) - 2 w v×x``, whose small turns lose
 * nothing
 * in r: 1 e23 e31 e12
 * in x: x y z
 * out out: x y z */

MOTORCADE_SIMD
void motorcade_rotor_apply_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const float *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const float t0 = r1 * x1 - x0 * r2;
        const float t1 = x0 * r3 - r1 * x2;
        const float t2 = r2 * x2 - x1 * r3;
        out_at[i] = x0 + (r2 * t0 - r3 * t1 - r0 * t2) * 2.0f;
        out_at[out_step + i] = x1 + 2.0f * (r3 * t2 - r1 * t0 - t1 * r0);
        out_at[2 * out_step + i] = x2 + 2.0f * (r1 * t1 - r2 * t2 - t0 * r0);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_apply_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const double *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const double t0 = r1 * x1 - x0 * r2;
        const double t1 = x0 * r3 - r1 * x2;
        const double t2 = r2 * x2 - x1 * r3;
        out_at[i] = x0 + (r2 * t0 - r3 * t1 - r0 * t2) * 2.0;
        out_at[out_step + i] = x1 + 2.0 * (r3 * t2 - r1 * t0 - t1 * r0);
        out_at[2 * out_step + i] = x2 + 2.0 * (r1 * t1 - r2 * t2 - t0 * r0);
    }
}

/* rotor_matrix33: 3×3 matrix of a rotor, by rows
 * in r: 1 e23 e31 e12
 * out out: m00 m01 m02 m10 m11 m12 m20 m21 m22 */

MOTORCADE_SIMD
void motorcade_rotor_matrix33_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float t0 = r2 * r2;
        const float t1 = r3 * r3;
        const float t2 = r2 * r1;
        const float t3 = r3 * r0;
        const float t4 = r3 * r1;
        const float t5 = r2 * r0;
        const float t6 = r1 * r1;
        const float t7 = r2 * r3;
        const float t8 = r1 * r0;
        out_at[i] = 1.0f - (t0 + t1) * 2.0f;
        out_at[out_step + i] = 2.0f * (t2 + t3);
        out_at[2 * out_step + i] = 2.0f * (t4 - t5);
        out_at[3 * out_step + i] = 2.0f * (t2 - t3);
        out_at[4 * out_step + i] = 1.0f - 2.0f * (t1 + t6);
        out_at[5 * out_step + i] = 2.0f * (t7 + t8);
        out_at[6 * out_step + i] = 2.0f * (t4 + t5);
        out_at[7 * out_step + i] = 2.0f * (t7 - t8);
        out_at[8 * out_step + i] = 1.0f - 2.0f * (t0 + t6);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_matrix33_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double t0 = r2 * r2;
        const double t1 = r3 * r3;
        const double t2 = r2 * r1;
        const double t3 = r3 * r0;
        const double t4 = r3 * r1;
        const double t5 = r2 * r0;
        const double t6 = r1 * r1;
        const double t7 = r2 * r3;
        const double t8 = r1 * r0;
        out_at[i] = 1.0 - (t0 + t1) * 2.0;
        out_at[out_step + i] = 2.0 * (t2 + t3);
        out_at[2 * out_step + i] = 2.0 * (t4 - t5);
        out_at[3 * out_step + i] = 2.0 * (t2 - t3);
        out_at[4 * out_step + i] = 1.0 - 2.0 * (t1 + t6);
        out_at[5 * out_step + i] = 2.0 * (t7 + t8);
        out_at[6 * out_step + i] = 2.0 * (t4 + t5);
        out_at[7 * out_step + i] = 2.0 * (t7 - t8);
        out_at[8 * out_step + i] = 1.0 - 2.0 * (t0 + t6);
    }
}

/* rotor_of_matrix33: Rotor of a rotation matrix by rows
 * in m: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out out: 1 e23 e31 e12 off */

MOTORCADE_SIMD
void motorcade_rotor_of_matrix33_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = 1.0f - m0;
        const float t1 = t0 - m4 + m8;
        const float t2 = t0 + m4 - m8;
        const _Bool t3 = (t1 <= t2);
        const float t4 = 1.0f + m0;
        const float t5 = t4 - m4 - m8;
        const float t6 = m8 + (m4 + t4);
        const _Bool t7 = (t5 <= t6);
        const _Bool t8 = ((t3 ? t2 : t1) <= (t7 ? t6 : t5));
        const float t9 = m7 - m5;
        const float t10 = m2 - m6;
        const float t11 = m3 - m1;
        const float t12 = (t8 ? (t7 ? t6 : t9) : (t3 ? t10 : t11));
        const float t13 = m3 + m1;
        const float t14 = m2 + m6;
        const float t15 = (t8 ? (t7 ? t9 : t5) : (t3 ? t13 : t14));
        const float t16 = m7 + m5;
        const float t17 = (t8 ? (t7 ? t10 : t13) : (t3 ? t2 : t16));
        const float t18 = (t8 ? (t7 ? t11 : t14) : (t3 ? t16 : t1));
        const float t19 = 1.0f / sqrtf(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18);
        const _Bool t20 = (m0 * (m4 * m8 - m7 * m5) + m3 * (m7 * m2 - m8 * m1) + m6 * (m5 * m1 - m4
            * m2) < 0.0f);
        const float t21 = fabsf(m0 * m0 + m3 * m3 + m6 * m6 - 1.0f) + fabsf(m0 * m1 + m4 * m3 + m7 *
            m6) + fabsf(m0 * m2 + m5 * m3 + m8 * m6);
        const float t22 = t21 + fabsf(m1 * m1 + m4 * m4 + m7 * m7 - 1.0f) + fabsf(m2 * m1 + m4 * m5
            + m8 * m7) + fabsf(m2 * m2 + m5 * m5 + m8 * m8 - 1.0f);
        out_at[i] = t12 * t19;
        out_at[out_step + i] = -(t15 * t19);
        out_at[2 * out_step + i] = -(t17 * t19);
        out_at[3 * out_step + i] = -(t18 * t19);
        out_at[4 * out_step + i] = (t20 ? 4.0f : t22);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_of_matrix33_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = 1.0 - m0;
        const double t1 = t0 - m4 + m8;
        const double t2 = t0 + m4 - m8;
        const _Bool t3 = (t1 <= t2);
        const double t4 = 1.0 + m0;
        const double t5 = t4 - m4 - m8;
        const double t6 = m8 + (m4 + t4);
        const _Bool t7 = (t5 <= t6);
        const _Bool t8 = ((t3 ? t2 : t1) <= (t7 ? t6 : t5));
        const double t9 = m7 - m5;
        const double t10 = m2 - m6;
        const double t11 = m3 - m1;
        const double t12 = (t8 ? (t7 ? t6 : t9) : (t3 ? t10 : t11));
        const double t13 = m3 + m1;
        const double t14 = m2 + m6;
        const double t15 = (t8 ? (t7 ? t9 : t5) : (t3 ? t13 : t14));
        const double t16 = m7 + m5;
        const double t17 = (t8 ? (t7 ? t10 : t13) : (t3 ? t2 : t16));
        const double t18 = (t8 ? (t7 ? t11 : t14) : (t3 ? t16 : t1));
        const double t19 = 1.0 / sqrt(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18);
        const _Bool t20 = (m0 * (m4 * m8 - m7 * m5) + m3 * (m7 * m2 - m8 * m1) + m6 * (m5 * m1 - m4
            * m2) < 0.0);
        const double t21 = fabs(m0 * m0 + m3 * m3 + m6 * m6 - 1.0) + fabs(m0 * m1 + m4 * m3 + m7 *
            m6) + fabs(m0 * m2 + m5 * m3 + m8 * m6);
        const double t22 = t21 + fabs(m1 * m1 + m4 * m4 + m7 * m7 - 1.0) + fabs(m2 * m1 + m4 * m5 +
            m8 * m7) + fabs(m2 * m2 + m5 * m5 + m8 * m8 - 1.0);
        out_at[i] = t12 * t19;
        out_at[out_step + i] = -(t15 * t19);
        out_at[2 * out_step + i] = -(t17 * t19);
        out_at[3 * out_step + i] = -(t18 * t19);
        out_at[4 * out_step + i] = (t20 ? 4.0 : t22);
    }
}

/* rotor_of_coefficients: The same numbers, and how far they are from a rotor's
 * in r: 1 e23 e31 e12
 * out out: 1 e23 e31 e12 off */

MOTORCADE_SIMD
void motorcade_rotor_of_coefficients_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        out_at[i] = r0;
        out_at[out_step + i] = r1;
        out_at[2 * out_step + i] = r2;
        out_at[3 * out_step + i] = r3;
        out_at[4 * out_step + i] = fabsf(sqrtf(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3) - 1.0f);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_of_coefficients_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        out_at[i] = r0;
        out_at[out_step + i] = r1;
        out_at[2 * out_step + i] = r2;
        out_at[3 * out_step + i] = r3;
        out_at[4 * out_step + i] = fabs(sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3) - 1.0);
    }
}

/* rotor_of_quaternion: Rotor of a unit quaternion
 * in q: w x y z
 * out out: 1 e23 e31 e12 off */

MOTORCADE_SIMD
void motorcade_rotor_of_quaternion_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict q_at = inputs[0];
    const ptrdiff_t q_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const float q3 = q_at[3 * q_step + i];
        out_at[i] = q0;
        out_at[out_step + i] = -q1;
        out_at[2 * out_step + i] = -q2;
        out_at[3 * out_step + i] = -q3;
        out_at[4 * out_step + i] = fabsf(sqrtf(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0f);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_of_quaternion_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict q_at = inputs[0];
    const ptrdiff_t q_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const double q3 = q_at[3 * q_step + i];
        out_at[i] = q0;
        out_at[out_step + i] = -q1;
        out_at[2 * out_step + i] = -q2;
        out_at[3 * out_step + i] = -q3;
        out_at[4 * out_step + i] = fabs(sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0);
    }
}

/* rotor_normalize: The rotor nearest to an even element, divided by its largest coefficient first
 * in r: 1 e23 e31 e12
 * out out: 1 e23 e31 e12 size */

MOTORCADE_SIMD
void motorcade_rotor_normalize_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float t0 = largerf(largerf(largerf(fabsf(r0), fabsf(r1)), fabsf(r2)), fabsf(r3));
        const float t1 = 1.0f / t0;
        const float t2 = r0 * t1;
        const float t3 = r1 * t1;
        const float t4 = r2 * t1;
        const float t5 = r3 * t1;
        const float t6 = 1.0f / sqrtf(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        out_at[i] = t2 * t6;
        out_at[out_step + i] = t3 * t6;
        out_at[2 * out_step + i] = t4 * t6;
        out_at[3 * out_step + i] = t5 * t6;
        out_at[4 * out_step + i] = t0;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_normalize_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double t0 = larger(larger(larger(fabs(r0), fabs(r1)), fabs(r2)), fabs(r3));
        const double t1 = 1.0 / t0;
        const double t2 = r0 * t1;
        const double t3 = r1 * t1;
        const double t4 = r2 * t1;
        const double t5 = r3 * t1;
        const double t6 = 1.0 / sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        out_at[i] = t2 * t6;
        out_at[out_step + i] = t3 * t6;
        out_at[2 * out_step + i] = t4 * t6;
        out_at[3 * out_step + i] = t5 * t6;
        out_at[4 * out_step + i] = t0;
    }
}
