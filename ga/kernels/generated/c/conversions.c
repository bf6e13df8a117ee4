/* Kernels of the group conversions: matrix34, matrix44, transform, dual_quaternion.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* matrix34: 3×4 matrix of a motor, by rows
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 */

MOTORCADE_SIMD
void motorcade_matrix34_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m0 * m0;
        const float t1 = m3 * m3;
        const float t2 = t0 - t1;
        const float t3 = m2 * m2;
        const float t4 = m1 * m1;
        const float t5 = m0 * m3 * 2.0f;
        const float t6 = 2.0f * (m2 * m1);
        const float t7 = m3 * m1;
        const float t8 = m0 * m2;
        const float t9 = m3 * m2;
        const float t10 = m0 * m1;
        out_at[i] = t2 - t3 + t4;
        out_at[out_step + i] = t5 + t6;
        out_at[2 * out_step + i] = 2.0f * (t7 - t8);
        out_at[3 * out_step + i] = -2.0f * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7);
        out_at[4 * out_step + i] = t6 - t5;
        out_at[5 * out_step + i] = t2 + t3 - t4;
        out_at[6 * out_step + i] = 2.0f * (t9 + t10);
        out_at[7 * out_step + i] = -2.0f * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6);
        out_at[8 * out_step + i] = 2.0f * (t7 + t8);
        out_at[9 * out_step + i] = 2.0f * (t9 - t10);
        out_at[10 * out_step + i] = t1 + (t0 - (t3 + t4));
        out_at[11 * out_step + i] = -2.0f * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7);
    }
}

MOTORCADE_SIMD
void motorcade_matrix34_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m0 * m0;
        const double t1 = m3 * m3;
        const double t2 = t0 - t1;
        const double t3 = m2 * m2;
        const double t4 = m1 * m1;
        const double t5 = m0 * m3 * 2.0;
        const double t6 = 2.0 * (m2 * m1);
        const double t7 = m3 * m1;
        const double t8 = m0 * m2;
        const double t9 = m3 * m2;
        const double t10 = m0 * m1;
        out_at[i] = t2 - t3 + t4;
        out_at[out_step + i] = t5 + t6;
        out_at[2 * out_step + i] = 2.0 * (t7 - t8);
        out_at[3 * out_step + i] = -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7);
        out_at[4 * out_step + i] = t6 - t5;
        out_at[5 * out_step + i] = t2 + t3 - t4;
        out_at[6 * out_step + i] = 2.0 * (t9 + t10);
        out_at[7 * out_step + i] = -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6);
        out_at[8 * out_step + i] = 2.0 * (t7 + t8);
        out_at[9 * out_step + i] = 2.0 * (t9 - t10);
        out_at[10 * out_step + i] = t1 + (t0 - (t3 + t4));
        out_at[11 * out_step + i] = -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7);
    }
}

/* matrix44: 4×4 matrix of a motor, by rows
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 m30 m31 m32 m33 */

MOTORCADE_SIMD
void motorcade_matrix44_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m0 * m0;
        const float t1 = m3 * m3;
        const float t2 = t0 - t1;
        const float t3 = m2 * m2;
        const float t4 = m1 * m1;
        const float t5 = m0 * m3 * 2.0f;
        const float t6 = 2.0f * (m2 * m1);
        const float t7 = m3 * m1;
        const float t8 = m0 * m2;
        const float t9 = m3 * m2;
        const float t10 = m0 * m1;
        out_at[i] = t2 - t3 + t4;
        out_at[out_step + i] = t5 + t6;
        out_at[2 * out_step + i] = 2.0f * (t7 - t8);
        out_at[3 * out_step + i] = -2.0f * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7);
        out_at[4 * out_step + i] = t6 - t5;
        out_at[5 * out_step + i] = t2 + t3 - t4;
        out_at[6 * out_step + i] = 2.0f * (t9 + t10);
        out_at[7 * out_step + i] = -2.0f * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6);
        out_at[8 * out_step + i] = 2.0f * (t7 + t8);
        out_at[9 * out_step + i] = 2.0f * (t9 - t10);
        out_at[10 * out_step + i] = t1 + (t0 - (t3 + t4));
        out_at[11 * out_step + i] = -2.0f * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7);
        out_at[12 * out_step + i] = 0.0f;
        out_at[13 * out_step + i] = 0.0f;
        out_at[14 * out_step + i] = 0.0f;
        out_at[15 * out_step + i] = 1.0f;
    }
}

MOTORCADE_SIMD
void motorcade_matrix44_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m0 * m0;
        const double t1 = m3 * m3;
        const double t2 = t0 - t1;
        const double t3 = m2 * m2;
        const double t4 = m1 * m1;
        const double t5 = m0 * m3 * 2.0;
        const double t6 = 2.0 * (m2 * m1);
        const double t7 = m3 * m1;
        const double t8 = m0 * m2;
        const double t9 = m3 * m2;
        const double t10 = m0 * m1;
        out_at[i] = t2 - t3 + t4;
        out_at[out_step + i] = t5 + t6;
        out_at[2 * out_step + i] = 2.0 * (t7 - t8);
        out_at[3 * out_step + i] = -2.0 * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7);
        out_at[4 * out_step + i] = t6 - t5;
        out_at[5 * out_step + i] = t2 + t3 - t4;
        out_at[6 * out_step + i] = 2.0 * (t9 + t10);
        out_at[7 * out_step + i] = -2.0 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6);
        out_at[8 * out_step + i] = 2.0 * (t7 + t8);
        out_at[9 * out_step + i] = 2.0 * (t9 - t10);
        out_at[10 * out_step + i] = t1 + (t0 - (t3 + t4));
        out_at[11 * out_step + i] = -2.0 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7);
        out_at[12 * out_step + i] = 0.0;
        out_at[13 * out_step + i] = 0.0;
        out_at[14 * out_step + i] = 0.0;
        out_at[15 * out_step + i] = 1.0;
    }
}

/* transform: Points moved by 3×4 matrices, given by rows
 * in m: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23
 * in x: x y z
 * out out: x y z */

MOTORCADE_SIMD
void motorcade_transform_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        out_at[i] = m3 + m0 * x0 + m1 * x1 + m2 * x2;
        out_at[out_step + i] = m7 + x0 * m4 + x1 * m5 + x2 * m6;
        out_at[2 * out_step + i] = m11 + x0 * m8 + x1 * m9 + x2 * m10;
    }
}

MOTORCADE_SIMD
void motorcade_transform_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        out_at[i] = m3 + m0 * x0 + m1 * x1 + m2 * x2;
        out_at[out_step + i] = m7 + x0 * m4 + x1 * m5 + x2 * m6;
        out_at[2 * out_step + i] = m11 + x0 * m8 + x1 * m9 + x2 * m10;
    }
}

/* dual_quaternion: Unit Hamilton dual quaternion: real wxyz, dual wxyz
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: w x y z εw εx εy εz */

MOTORCADE_SIMD
void motorcade_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = m0;
        out_at[out_step + i] = -m1;
        out_at[2 * out_step + i] = -m2;
        out_at[3 * out_step + i] = -m3;
        out_at[4 * out_step + i] = -m7;
        out_at[5 * out_step + i] = -m4;
        out_at[6 * out_step + i] = -m5;
        out_at[7 * out_step + i] = -m6;
    }
}

MOTORCADE_SIMD
void motorcade_dual_quaternion_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = m0;
        out_at[out_step + i] = -m1;
        out_at[2 * out_step + i] = -m2;
        out_at[3 * out_step + i] = -m3;
        out_at[4 * out_step + i] = -m7;
        out_at[5 * out_step + i] = -m4;
        out_at[6 * out_step + i] = -m5;
        out_at[7 * out_step + i] = -m6;
    }
}
