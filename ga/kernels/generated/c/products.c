/* Kernels of the group products: compose, inverse, apply.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* compose: Geometric product a b of motors
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_compose_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        out_at[i] = a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1;
        out_at[out_step + i] = a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2;
        out_at[2 * out_step + i] = b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2);
        out_at[3 * out_step + i] = a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1;
        out_at[4 * out_step + i] = a0 * b4 + a3 * b5 - a2 * b6 + b0 * a4 - a1 * b7 - b3 * a5 + b2 *
            a6 - b1 * a7;
        out_at[5 * out_step + i] = a0 * b5 - a2 * b7 + b3 * a4 + a1 * b6 + b0 * a5 - b2 * a7 - a3 *
            b4 - b1 * a6;
        out_at[6 * out_step + i] = a0 * b6 - b2 * a4 + b1 * a5 + b0 * a6 - a3 * b7 + a2 * b4 - a1 *
            b5 - b3 * a7;
        out_at[7 * out_step + i] = a0 * b7 + a3 * b6 + b1 * a4 + a1 * b4 + b3 * a6 + b0 * a7 + a2 *
            b5 + b2 * a5;
    }
}

MOTORCADE_SIMD
void motorcade_compose_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        out_at[i] = a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1;
        out_at[out_step + i] = a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2;
        out_at[2 * out_step + i] = b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2);
        out_at[3 * out_step + i] = a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1;
        out_at[4 * out_step + i] = a0 * b4 + a3 * b5 - a2 * b6 + b0 * a4 - a1 * b7 - b3 * a5 + b2 *
            a6 - b1 * a7;
        out_at[5 * out_step + i] = a0 * b5 - a2 * b7 + b3 * a4 + a1 * b6 + b0 * a5 - b2 * a7 - a3 *
            b4 - b1 * a6;
        out_at[6 * out_step + i] = a0 * b6 - b2 * a4 + b1 * a5 + b0 * a6 - a3 * b7 + a2 * b4 - a1 *
            b5 - b3 * a7;
        out_at[7 * out_step + i] = a0 * b7 + a3 * b6 + b1 * a4 + a1 * b4 + b3 * a6 + b0 * a7 + a2 *
            b5 + b2 * a5;
    }
}

/* inverse: Reverse of a motor: its inverse
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_inverse_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[4 * out_step + i] = -m4;
        out_at[5 * out_step + i] = -m5;
        out_at[6 * out_step + i] = -m6;
        out_at[7 * out_step + i] = m7;
    }
}

MOTORCADE_SIMD
void motorcade_inverse_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[4 * out_step + i] = -m4;
        out_at[5 * out_step + i] = -m5;
        out_at[6 * out_step + i] = -m6;
        out_at[7 * out_step + i] = m7;
    }
}

/* apply: Points moved by motors
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in x: x y z
 * out out: x y z */

MOTORCADE_SIMD
void motorcade_apply_f32(MOTORCADE_ARGUMENTS(float))
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
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const float t0 = m0 * x0 + m3 * x1 - m2 * x2;
        const float t1 = m0 * x1 + x2 * m1 - x0 * m3;
        const float t2 = m0 * x2 + x0 * m2 - x1 * m1;
        const float t3 = m3 * x2 + x0 * m1 + x1 * m2;
        const float t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0f * (m0 * m4 + m3 * m5 - m2 *
            m6 + m1 * m7);
        const float t5 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0f * (m0 * m5 - m3 * m4 + m2 *
            m7 + m1 * m6);
        const float t6 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0f * (m2 * m4 - m1 * m5 + m0 *
            m6 + m3 * m7);
        out_at[i] = t4;
        out_at[out_step + i] = t5;
        out_at[2 * out_step + i] = t6;
    }
}

MOTORCADE_SIMD
void motorcade_apply_f64(MOTORCADE_ARGUMENTS(double))
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
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const double t0 = m0 * x0 + m3 * x1 - m2 * x2;
        const double t1 = m0 * x1 + x2 * m1 - x0 * m3;
        const double t2 = m0 * x2 + x0 * m2 - x1 * m1;
        const double t3 = m3 * x2 + x0 * m1 + x1 * m2;
        const double t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 *
            m6 + m1 * m7);
        const double t5 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 *
            m7 + m1 * m6);
        const double t6 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 *
            m6 + m3 * m7);
        out_at[i] = t4;
        out_at[out_step + i] = t5;
        out_at[2 * out_step + i] = t6;
    }
}
