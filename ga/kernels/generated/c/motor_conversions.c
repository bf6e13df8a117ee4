/* Kernels of the group motor_conversions: translation, of_translation, motor_of,
 * motor_of_quaternion, motor_of_matrix44, motor_of_dual_quaternion, of_coefficients, project.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* translation: Where a motor takes the origin
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: x y z */

MOTORCADE_SIMD
void motorcade_translation_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = -2.0f * (m4 * m0 + m5 * m3 - m6 * m2 + m7 * m1);
        out_at[out_step + i] = -2.0f * (m0 * m5 - m4 * m3 + m2 * m7 + m6 * m1);
        out_at[2 * out_step + i] = -2.0f * (m4 * m2 - m5 * m1 + m0 * m6 + m3 * m7);
    }
}

MOTORCADE_SIMD
void motorcade_translation_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = -2.0 * (m4 * m0 + m5 * m3 - m6 * m2 + m7 * m1);
        out_at[out_step + i] = -2.0 * (m0 * m5 - m4 * m3 + m2 * m7 + m6 * m1);
        out_at[2 * out_step + i] = -2.0 * (m4 * m2 - m5 * m1 + m0 * m6 + m3 * m7);
    }
}

/* of_translation: The motor that moves by a translation and turns nothing
 * in t: x y z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_of_translation_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict t_at = inputs[0];
    const ptrdiff_t t_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        out_at[i] = 1.0f;
        out_at[out_step + i] = 0.0f;
        out_at[2 * out_step + i] = 0.0f;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = -0.5f * t0;
        out_at[5 * out_step + i] = -0.5f * t1;
        out_at[6 * out_step + i] = -0.5f * t2;
        out_at[7 * out_step + i] = 0.0f;
    }
}

MOTORCADE_SIMD
void motorcade_of_translation_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict t_at = inputs[0];
    const ptrdiff_t t_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        out_at[i] = 1.0;
        out_at[out_step + i] = 0.0;
        out_at[2 * out_step + i] = 0.0;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = -0.5 * t0;
        out_at[5 * out_step + i] = -0.5 * t1;
        out_at[6 * out_step + i] = -0.5 * t2;
        out_at[7 * out_step + i] = 0.0;
    }
}

/* motor_of: The motor that turns by a rotor, then moves by a translation
 * in r: 1 e23 e31 e12
 * in t: x y z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_motor_of_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const float *restrict t_at = inputs[1];
    const ptrdiff_t t_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const float t3 = -0.5f * t0;
        const float t4 = -0.5f * t1;
        const float t5 = -0.5f * t2;
        out_at[i] = r0;
        out_at[out_step + i] = r1;
        out_at[2 * out_step + i] = r2;
        out_at[3 * out_step + i] = r3;
        out_at[4 * out_step + i] = r0 * t3 - r3 * t4 + r2 * t5;
        out_at[5 * out_step + i] = r3 * t3 + r0 * t4 - r1 * t5;
        out_at[6 * out_step + i] = r1 * t4 - r2 * t3 + r0 * t5;
        out_at[7 * out_step + i] = r1 * t3 + r3 * t5 + r2 * t4;
    }
}

MOTORCADE_SIMD
void motorcade_motor_of_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const double *restrict t_at = inputs[1];
    const ptrdiff_t t_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const double t3 = -0.5 * t0;
        const double t4 = -0.5 * t1;
        const double t5 = -0.5 * t2;
        out_at[i] = r0;
        out_at[out_step + i] = r1;
        out_at[2 * out_step + i] = r2;
        out_at[3 * out_step + i] = r3;
        out_at[4 * out_step + i] = r0 * t3 - r3 * t4 + r2 * t5;
        out_at[5 * out_step + i] = r3 * t3 + r0 * t4 - r1 * t5;
        out_at[6 * out_step + i] = r1 * t4 - r2 * t3 + r0 * t5;
        out_at[7 * out_step + i] = r1 * t3 + r3 * t5 + r2 * t4;
    }
}

/* motor_of_quaternion: The motor that turns by a unit quaternion, then moves by a translation
 * in q: w x y z
 * in t: x y z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ off */

MOTORCADE_SIMD
void motorcade_motor_of_quaternion_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict q_at = inputs[0];
    const ptrdiff_t q_step = input_steps[0];
    const float *restrict t_at = inputs[1];
    const ptrdiff_t t_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const float q3 = q_at[3 * q_step + i];
        const float t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const float t3 = -0.5f * t0;
        const float t4 = -0.5f * t1;
        const float t5 = -0.5f * t2;
        out_at[i] = q0;
        out_at[out_step + i] = -q1;
        out_at[2 * out_step + i] = -q2;
        out_at[3 * out_step + i] = -q3;
        out_at[4 * out_step + i] = q0 * t3 + q3 * t4 - q2 * t5;
        out_at[5 * out_step + i] = q0 * t4 - q3 * t3 + q1 * t5;
        out_at[6 * out_step + i] = q2 * t3 - q1 * t4 + q0 * t5;
        out_at[7 * out_step + i] = -(q1 * t3 + q3 * t5 + q2 * t4);
        out_at[8 * out_step + i] = fabsf(sqrtf(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0f);
    }
}

MOTORCADE_SIMD
void motorcade_motor_of_quaternion_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict q_at = inputs[0];
    const ptrdiff_t q_step = input_steps[0];
    const double *restrict t_at = inputs[1];
    const ptrdiff_t t_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const double q3 = q_at[3 * q_step + i];
        const double t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const double t3 = -0.5 * t0;
        const double t4 = -0.5 * t1;
        const double t5 = -0.5 * t2;
        out_at[i] = q0;
        out_at[out_step + i] = -q1;
        out_at[2 * out_step + i] = -q2;
        out_at[3 * out_step + i] = -q3;
        out_at[4 * out_step + i] = q0 * t3 + q3 * t4 - q2 * t5;
        out_at[5 * out_step + i] = q0 * t4 - q3 * t3 + q1 * t5;
        out_at[6 * out_step + i] = q2 * t3 - q1 * t4 + q0 * t5;
        out_at[7 * out_step + i] = -(q1 * t3 + q3 * t5 + q2 * t4);
        out_at[8 * out_step + i] = fabs(sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3) - 1.0);
    }
}

/* motor_of_matrix44: Motor of a homogeneous matrix by rows; what its last row is off by counts ten
 * times
 * in m: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 m30 m31 m32 m33
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ off */

MOTORCADE_SIMD
void motorcade_motor_of_matrix44_f32(MOTORCADE_ARGUMENTS(float))
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
        const float m12 = m_at[12 * m_step + i], m13 = m_at[13 * m_step + i], m14 = m_at[14 * m_step + i];
        const float m15 = m_at[15 * m_step + i];
        const float t0 = 1.0f - m0;
        const float t1 = t0 - m5 + m10;
        const float t2 = t0 + m5 - m10;
        const _Bool t3 = (t1 <= t2);
        const float t4 = 1.0f + m0;
        const float t5 = t4 - m5 - m10;
        const float t6 = m10 + (m5 + t4);
        const _Bool t7 = (t5 <= t6);
        const _Bool t8 = ((t3 ? t2 : t1) <= (t7 ? t6 : t5));
        const float t9 = m9 - m6;
        const float t10 = m2 - m8;
        const float t11 = m4 - m1;
        const float t12 = (t8 ? (t7 ? t6 : t9) : (t3 ? t10 : t11));
        const float t13 = m4 + m1;
        const float t14 = m2 + m8;
        const float t15 = (t8 ? (t7 ? t9 : t5) : (t3 ? t13 : t14));
        const float t16 = m9 + m6;
        const float t17 = (t8 ? (t7 ? t10 : t13) : (t3 ? t2 : t16));
        const float t18 = (t8 ? (t7 ? t11 : t14) : (t3 ? t16 : t1));
        const float t19 = 1.0f / sqrtf(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18);
        const float t20 = t12 * t19;
        const float t21 = t15 * t19;
        const float t22 = t17 * t19;
        const float t23 = t18 * t19;
        const float t24 = -0.5f * m3;
        const float t25 = -0.5f * m7;
        const float t26 = -0.5f * m11;
        const _Bool t27 = (m0 * (m5 * m10 - m9 * m6) + m4 * (m9 * m2 - m10 * m1) + m8 * (m6 * m1 -
            m5 * m2) < 0.0f);
        const float t28 = fabsf(m0 * m0 + m4 * m4 + m8 * m8 - 1.0f) + fabsf(m0 * m1 + m5 * m4 + m9 *
            m8) + fabsf(m0 * m2 + m6 * m4 + m10 * m8);
        const float t29 = t28 + fabsf(m1 * m1 + m5 * m5 + m9 * m9 - 1.0f) + fabsf(m2 * m1 + m5 * m6
            + m10 * m9);
        const float t30 = (t27 ? 4.0f : t29 + fabsf(m2 * m2 + m6 * m6 + m10 * m10 - 1.0f)) + 10.0f *
            (fabsf(m12) + fabsf(m13) + fabsf(m14) + fabsf(m15 - 1.0f));
        out_at[i] = t20;
        out_at[out_step + i] = -t21;
        out_at[2 * out_step + i] = -t22;
        out_at[3 * out_step + i] = -t23;
        out_at[4 * out_step + i] = t20 * t24 + t23 * t25 - t22 * t26;
        out_at[5 * out_step + i] = t20 * t25 - t23 * t24 + t21 * t26;
        out_at[6 * out_step + i] = t22 * t24 - t21 * t25 + t20 * t26;
        out_at[7 * out_step + i] = -(t21 * t24 + t23 * t26 + t22 * t25);
        out_at[8 * out_step + i] = t30;
    }
}

MOTORCADE_SIMD
void motorcade_motor_of_matrix44_f64(MOTORCADE_ARGUMENTS(double))
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
        const double m12 = m_at[12 * m_step + i], m13 = m_at[13 * m_step + i], m14 = m_at[14 * m_step + i];
        const double m15 = m_at[15 * m_step + i];
        const double t0 = 1.0 - m0;
        const double t1 = t0 - m5 + m10;
        const double t2 = t0 + m5 - m10;
        const _Bool t3 = (t1 <= t2);
        const double t4 = 1.0 + m0;
        const double t5 = t4 - m5 - m10;
        const double t6 = m10 + (m5 + t4);
        const _Bool t7 = (t5 <= t6);
        const _Bool t8 = ((t3 ? t2 : t1) <= (t7 ? t6 : t5));
        const double t9 = m9 - m6;
        const double t10 = m2 - m8;
        const double t11 = m4 - m1;
        const double t12 = (t8 ? (t7 ? t6 : t9) : (t3 ? t10 : t11));
        const double t13 = m4 + m1;
        const double t14 = m2 + m8;
        const double t15 = (t8 ? (t7 ? t9 : t5) : (t3 ? t13 : t14));
        const double t16 = m9 + m6;
        const double t17 = (t8 ? (t7 ? t10 : t13) : (t3 ? t2 : t16));
        const double t18 = (t8 ? (t7 ? t11 : t14) : (t3 ? t16 : t1));
        const double t19 = 1.0 / sqrt(t12 * t12 + t15 * t15 + t17 * t17 + t18 * t18);
        const double t20 = t12 * t19;
        const double t21 = t15 * t19;
        const double t22 = t17 * t19;
        const double t23 = t18 * t19;
        const double t24 = -0.5 * m3;
        const double t25 = -0.5 * m7;
        const double t26 = -0.5 * m11;
        const _Bool t27 = (m0 * (m5 * m10 - m9 * m6) + m4 * (m9 * m2 - m10 * m1) + m8 * (m6 * m1 -
            m5 * m2) < 0.0);
        const double t28 = fabs(m0 * m0 + m4 * m4 + m8 * m8 - 1.0) + fabs(m0 * m1 + m5 * m4 + m9 *
            m8) + fabs(m0 * m2 + m6 * m4 + m10 * m8);
        const double t29 = t28 + fabs(m1 * m1 + m5 * m5 + m9 * m9 - 1.0) + fabs(m2 * m1 + m5 * m6 +
            m10 * m9) + fabs(m2 * m2 + m6 * m6 + m10 * m10 - 1.0);
        out_at[i] = t20;
        out_at[out_step + i] = -t21;
        out_at[2 * out_step + i] = -t22;
        out_at[3 * out_step + i] = -t23;
        out_at[4 * out_step + i] = t20 * t24 + t23 * t25 - t22 * t26;
        out_at[5 * out_step + i] = t20 * t25 - t23 * t24 + t21 * t26;
        out_at[6 * out_step + i] = t22 * t24 - t21 * t25 + t20 * t26;
        out_at[7 * out_step + i] = -(t21 * t24 + t23 * t26 + t22 * t25);
        out_at[8 * out_step + i] = (t27 ? 4.0 : t29) + 10.0 * (fabs(m12) + fabs(m13) + fabs(m14) +
            fabs(m15 - 1.0));
    }
}

/* motor_of_dual_quaternion: Motor of a unit Hamilton dual quaternion
 * in d: w x y z εw εx εy εz
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ off */

MOTORCADE_SIMD
void motorcade_motor_of_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict d_at = inputs[0];
    const ptrdiff_t d_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float d0 = d_at[i], d1 = d_at[d_step + i], d2 = d_at[2 * d_step + i];
        const float d3 = d_at[3 * d_step + i], d4 = d_at[4 * d_step + i], d5 = d_at[5 * d_step + i];
        const float d6 = d_at[6 * d_step + i], d7 = d_at[7 * d_step + i];
        const float t0 = fabsf(d0 * d4 + (d1 * d5 + d2 * d6 + d3 * d7)) /
            largerf(largerf(largerf(largerf(1.0f, fabsf(d5)), fabsf(d6)), fabsf(d7)), fabsf(d4));
        out_at[i] = d0;
        out_at[out_step + i] = -d1;
        out_at[2 * out_step + i] = -d2;
        out_at[3 * out_step + i] = -d3;
        out_at[4 * out_step + i] = -d5;
        out_at[5 * out_step + i] = -d6;
        out_at[6 * out_step + i] = -d7;
        out_at[7 * out_step + i] = -d4;
        out_at[8 * out_step + i] = largerf(fabsf(sqrtf(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3) -
            1.0f), t0);
    }
}

MOTORCADE_SIMD
void motorcade_motor_of_dual_quaternion_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict d_at = inputs[0];
    const ptrdiff_t d_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double d0 = d_at[i], d1 = d_at[d_step + i], d2 = d_at[2 * d_step + i];
        const double d3 = d_at[3 * d_step + i], d4 = d_at[4 * d_step + i], d5 = d_at[5 * d_step + i];
        const double d6 = d_at[6 * d_step + i], d7 = d_at[7 * d_step + i];
        const double t0 = fabs(d0 * d4 + (d1 * d5 + d2 * d6 + d3 * d7)) /
            larger(larger(larger(larger(1.0, fabs(d5)), fabs(d6)), fabs(d7)), fabs(d4));
        out_at[i] = d0;
        out_at[out_step + i] = -d1;
        out_at[2 * out_step + i] = -d2;
        out_at[3 * out_step + i] = -d3;
        out_at[4 * out_step + i] = -d5;
        out_at[5 * out_step + i] = -d6;
        out_at[6 * out_step + i] = -d7;
        out_at[7 * out_step + i] = -d4;
        out_at[8 * out_step + i] = larger(fabs(sqrt(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3) - 1.0),
            t0);
    }
}

/* of_coefficients: The same numbers, and how far they are from a motor's
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ off */

MOTORCADE_SIMD
void motorcade_of_coefficients_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = fabsf(m0 * m7 - (m1 * m4 + m2 * m5 + m3 * m6)) /
            largerf(largerf(largerf(largerf(1.0f, fabsf(m4)), fabsf(m5)), fabsf(m6)), fabsf(m7));
        out_at[i] = m0;
        out_at[out_step + i] = m1;
        out_at[2 * out_step + i] = m2;
        out_at[3 * out_step + i] = m3;
        out_at[4 * out_step + i] = m4;
        out_at[5 * out_step + i] = m5;
        out_at[6 * out_step + i] = m6;
        out_at[7 * out_step + i] = m7;
        out_at[8 * out_step + i] = largerf(fabsf(sqrtf(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3) -
            1.0f), t0);
    }
}

MOTORCADE_SIMD
void motorcade_of_coefficients_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = fabs(m0 * m7 - (m1 * m4 + m2 * m5 + m3 * m6)) /
            larger(larger(larger(larger(1.0, fabs(m4)), fabs(m5)), fabs(m6)), fabs(m7));
        out_at[i] = m0;
        out_at[out_step + i] = m1;
        out_at[2 * out_step + i] = m2;
        out_at[3 * out_step + i] = m3;
        out_at[4 * out_step + i] = m4;
        out_at[5 * out_step + i] = m5;
        out_at[6 * out_step + i] = m6;
        out_at[7 * out_step + i] = m7;
        out_at[8 * out_step + i] = larger(fabs(sqrt(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3) - 1.0),
            t0);
    }
}

/* project: The motor nearest to an even element, divided by its largest rotor coefficient first
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ size */

MOTORCADE_SIMD
void motorcade_project_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = largerf(largerf(largerf(fabsf(m0), fabsf(m1)), fabsf(m2)), fabsf(m3));
        const float t1 = 1.0f / t0;
        const float t2 = m0 * t1;
        const float t3 = m3 * t1;
        const float t4 = m2 * t1;
        const float t5 = m1 * t1;
        const float t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5;
        const float t7 = 1.0f / sqrtf(t6);
        const float t8 = t1 * m4;
        const float t9 = t1 * m7;
        const float t10 = t1 * m6;
        const float t11 = t1 * m5;
        const float t12 = t7 * (-0.5f * (2.0f * (t2 * t9 - t3 * t10 - t5 * t8 - t4 * t11)) / t6);
        out_at[i] = t2 * t7;
        out_at[out_step + i] = t5 * t7;
        out_at[2 * out_step + i] = t4 * t7;
        out_at[3 * out_step + i] = t3 * t7;
        out_at[4 * out_step + i] = t7 * t8 - t5 * t12;
        out_at[5 * out_step + i] = t7 * t11 - t4 * t12;
        out_at[6 * out_step + i] = t7 * t10 - t3 * t12;
        out_at[7 * out_step + i] = t7 * t9 + t2 * t12;
        out_at[8 * out_step + i] = t0;
    }
}

MOTORCADE_SIMD
void motorcade_project_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = larger(larger(larger(fabs(m0), fabs(m1)), fabs(m2)), fabs(m3));
        const double t1 = 1.0 / t0;
        const double t2 = m0 * t1;
        const double t3 = m3 * t1;
        const double t4 = m2 * t1;
        const double t5 = m1 * t1;
        const double t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5;
        const double t7 = 1.0 / sqrt(t6);
        const double t8 = t1 * m4;
        const double t9 = t1 * m7;
        const double t10 = t1 * m6;
        const double t11 = t1 * m5;
        const double t12 = t7 * (-0.5 * (2.0 * (t2 * t9 - t3 * t10 - t5 * t8 - t4 * t11)) / t6);
        out_at[i] = t2 * t7;
        out_at[out_step + i] = t5 * t7;
        out_at[2 * out_step + i] = t4 * t7;
        out_at[3 * out_step + i] = t3 * t7;
        out_at[4 * out_step + i] = t7 * t8 - t5 * t12;
        out_at[5 * out_step + i] = t7 * t11 - t4 * t12;
        out_at[6 * out_step + i] = t7 * t10 - t3 * t12;
        out_at[7 * out_step + i] = t7 * t9 + t2 * t12;
        out_at[8 * out_step + i] = t0;
    }
}
