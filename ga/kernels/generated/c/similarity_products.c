/* Kernels of the group similarity_products: similarity_compose, similarity_inverse,
 * similarity_apply.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_compose: Geometric product a b of similarities
 * in a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_compose_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const float a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const float b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const float t0 = a0 + a4;
        const float t1 = a3 + a7;
        const float t2 = a2 + a6;
        const float t3 = a1 + a5;
        const float t4 = b0 - b4;
        const float t5 = b3 - b7;
        const float t6 = b6 - b2;
        const float t7 = b1 - b5;
        out_at[i] = a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1 + (a4 * b4 - a7 * b7 - a6 * b6 - a5 * b5);
        out_at[out_step + i] = a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2 + (a4 * b5 - b7 * a6 + b4 * a5
            + a7 * b6);
        out_at[2 * out_step + i] = -(a3 * b1 - a0 * b2 - b0 * a2 - b3 * a1 + (a7 * b5 - a4 * b6 - b4
            * a6 - b7 * a5));
        out_at[3 * out_step + i] = a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1 + (a4 * b7 + b4 * a7 - b6 *
            a5 + a6 * b5);
        out_at[4 * out_step + i] = a0 * b4 - a3 * b7 - a2 * b6 - a1 * b5 + (b0 * a4 - b3 * a7 - b2 *
            a6 - b1 * a5);
        out_at[5 * out_step + i] = a0 * b5 - a2 * b7 + a1 * b4 + a3 * b6 + (b1 * a4 - b3 * a6 + b0 *
            a5 + b2 * a7);
        out_at[6 * out_step + i] = -(a3 * b5 - a0 * b6 - a2 * b4 - a1 * b7 + (b1 * a7 - b2 * a4 - b0
            * a6 - b3 * a5));
        out_at[7 * out_step + i] = a0 * b7 + a3 * b4 - a1 * b6 + a2 * b5 + (b3 * a4 + b0 * a7 - b2 *
            a5 + b1 * a6);
        out_at[8 * out_step + i] = t0 * b8 + t1 * b9 - t2 * b10 - t3 * b11 + (a8 * t4 - a9 * t5 -
            a10 * t6 - a11 * t7);
        out_at[9 * out_step + i] = t0 * b9 - t2 * b11 + b10 * t3 - b8 * t1 + (a8 * t5 + t4 * a9 + t6
            * a11 - a10 * t7);
        out_at[10 * out_step + i] = t0 * b10 - t1 * b11 + b8 * t2 - b9 * t3 + (a8 * t6 + a9 * t7 +
            t4 * a10 - t5 * a11);
        out_at[11 * out_step + i] = t0 * b11 + t1 * b10 + b8 * t3 + b9 * t2 + (a8 * t7 + t5 * a10 +
            t4 * a11 - a9 * t6);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_compose_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const double a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const double b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const double t0 = a0 + a4;
        const double t1 = a3 + a7;
        const double t2 = a2 + a6;
        const double t3 = a1 + a5;
        const double t4 = b0 - b4;
        const double t5 = b3 - b7;
        const double t6 = b6 - b2;
        const double t7 = b1 - b5;
        out_at[i] = a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1 + (a4 * b4 - a7 * b7 - a6 * b6 - a5 * b5);
        out_at[out_step + i] = a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2 + (a4 * b5 - b7 * a6 + b4 * a5
            + a7 * b6);
        out_at[2 * out_step + i] = -(a3 * b1 - a0 * b2 - b0 * a2 - b3 * a1 + (a7 * b5 - a4 * b6 - b4
            * a6 - b7 * a5));
        out_at[3 * out_step + i] = a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1 + (a4 * b7 + b4 * a7 - b6 *
            a5 + a6 * b5);
        out_at[4 * out_step + i] = a0 * b4 - a3 * b7 - a2 * b6 - a1 * b5 + (b0 * a4 - b3 * a7 - b2 *
            a6 - b1 * a5);
        out_at[5 * out_step + i] = a0 * b5 - a2 * b7 + a1 * b4 + a3 * b6 + (b1 * a4 - b3 * a6 + b0 *
            a5 + b2 * a7);
        out_at[6 * out_step + i] = -(a3 * b5 - a0 * b6 - a2 * b4 - a1 * b7 + (b1 * a7 - b2 * a4 - b0
            * a6 - b3 * a5));
        out_at[7 * out_step + i] = a0 * b7 + a3 * b4 - a1 * b6 + a2 * b5 + (b3 * a4 + b0 * a7 - b2 *
            a5 + b1 * a6);
        out_at[8 * out_step + i] = t0 * b8 + t1 * b9 - t2 * b10 - t3 * b11 + (a8 * t4 - a9 * t5 -
            a10 * t6 - a11 * t7);
        out_at[9 * out_step + i] = t0 * b9 - t2 * b11 + b10 * t3 - b8 * t1 + (a8 * t5 + t4 * a9 + t6
            * a11 - a10 * t7);
        out_at[10 * out_step + i] = t0 * b10 - t1 * b11 + b8 * t2 - b9 * t3 + (a8 * t6 + a9 * t7 +
            t4 * a10 - t5 * a11);
        out_at[11 * out_step + i] = t0 * b11 + t1 * b10 + b8 * t3 + b9 * t2 + (a8 * t7 + t5 * a10 +
            t4 * a11 - a9 * t6);
    }
}

/* similarity_inverse: Reverse of a similarity: its inverse
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_inverse_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = m0;
        out_at[out_step + i] = -m1;
        out_at[2 * out_step + i] = -m2;
        out_at[3 * out_step + i] = -m3;
        out_at[4 * out_step + i] = -m4;
        out_at[5 * out_step + i] = m5;
        out_at[6 * out_step + i] = m6;
        out_at[7 * out_step + i] = m7;
        out_at[8 * out_step + i] = -m8;
        out_at[9 * out_step + i] = -m9;
        out_at[10 * out_step + i] = -m10;
        out_at[11 * out_step + i] = m11;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_inverse_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = m0;
        out_at[out_step + i] = -m1;
        out_at[2 * out_step + i] = -m2;
        out_at[3 * out_step + i] = -m3;
        out_at[4 * out_step + i] = -m4;
        out_at[5 * out_step + i] = m5;
        out_at[6 * out_step + i] = m6;
        out_at[7 * out_step + i] = m7;
        out_at[8 * out_step + i] = -m8;
        out_at[9 * out_step + i] = -m9;
        out_at[10 * out_step + i] = -m10;
        out_at[11 * out_step + i] = m11;
    }
}

/* similarity_apply: Points moved by similarities
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in x: x y z
 * out out: x y z */

MOTORCADE_SIMD
void motorcade_similarity_apply_f32(MOTORCADE_ARGUMENTS(float))
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
        const _Bool t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0f);
        const float t1 = m0 - m4;
        const float t2 = m3 - m7;
        const float t3 = m6 - m2;
        const float t4 = m1 - m5;
        const float t5 = 1.0f / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const float t6 = (t0 ? t1 * t5 : m0 + m4);
        const float t7 = (t0 ? t2 * t5 : m3 + m7);
        const float t8 = (t0 ? -(t3 * t5) : m2 + m6);
        const float t9 = t6 * x0 + t7 * x1 - t8 * x2;
        const float t10 = (t0 ? t4 * t5 : m1 + m5);
        const float t11 = t6 * x1 + x2 * t10 - x0 * t7;
        const float t12 = t6 * x2 + x0 * t8 - x1 * t10;
        const float t13 = t7 * x2 + x0 * t10 + x1 * t8;
        const float t14 = t6 * t9 + t7 * t11 - t8 * t12 + t10 * t13 + -2.0f * (t6 * m8 + t7 * m9 -
            t8 * m10 + t10 * m11);
        const float t15 = t6 * t11 - t7 * t9 + t8 * t13 + t10 * t12 + -2.0f * (t6 * m9 - t7 * m8 +
            t8 * m11 + t10 * m10);
        const float t16 = t8 * t9 - t10 * t11 + t6 * t12 + t7 * t13 + -2.0f * (t8 * m8 - t10 * m9 +
            t6 * m10 + t7 * m11);
        out_at[i] = t14;
        out_at[out_step + i] = t15;
        out_at[2 * out_step + i] = t16;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_apply_f64(MOTORCADE_ARGUMENTS(double))
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
        const _Bool t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0);
        const double t1 = m0 - m4;
        const double t2 = m3 - m7;
        const double t3 = m6 - m2;
        const double t4 = m1 - m5;
        const double t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const double t6 = (t0 ? t1 * t5 : m0 + m4);
        const double t7 = (t0 ? t2 * t5 : m3 + m7);
        const double t8 = (t0 ? -(t3 * t5) : m2 + m6);
        const double t9 = t6 * x0 + t7 * x1 - t8 * x2;
        const double t10 = (t0 ? t4 * t5 : m1 + m5);
        const double t11 = t6 * x1 + x2 * t10 - x0 * t7;
        const double t12 = t6 * x2 + x0 * t8 - x1 * t10;
        const double t13 = t7 * x2 + x0 * t10 + x1 * t8;
        const double t14 = t6 * t9 + t7 * t11 - t8 * t12 + t10 * t13 + -2.0 * (t6 * m8 + t7 * m9 -
            t8 * m10 + t10 * m11);
        const double t15 = t6 * t11 - t7 * t9 + t8 * t13 + t10 * t12 + -2.0 * (t6 * m9 - t7 * m8 +
            t8 * m11 + t10 * m10);
        const double t16 = t8 * t9 - t10 * t11 + t6 * t12 + t7 * t13 + -2.0 * (t8 * m8 - t10 * m9 +
            t6 * m10 + t7 * m11);
        out_at[i] = t14;
        out_at[out_step + i] = t15;
        out_at[2 * out_step + i] = t16;
    }
}
