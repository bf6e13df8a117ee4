/* Kernels of the group linear_blends: blend, blend_matrix, accumulate, normalize, normalize_matrix.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* blend: Linear blend of two motors, the short way round, made unit
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_blend_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = 1.0f - fraction;
        const float t1 = ((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0f) ? -fraction : fraction);
        const float t2 = t0 * a0 + b0 * t1;
        const float t3 = t0 * a3 + b3 * t1;
        const float t4 = t0 * a2 + b2 * t1;
        const float t5 = t0 * a1 + b1 * t1;
        const float t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5;
        const float t7 = 1.0f / sqrtf(t6);
        const float t8 = t0 * a4 + t1 * b4;
        const float t9 = t0 * a7 + t1 * b7;
        const float t10 = t0 * a6 + t1 * b6;
        const float t11 = t0 * a5 + t1 * b5;
        const float t12 = t7 * (-0.5f * (2.0f * (t2 * t9 - t3 * t10 - t5 * t8 - t4 * t11)) / t6);
        out_at[i] = t2 * t7;
        out_at[out_step + i] = t5 * t7;
        out_at[2 * out_step + i] = t4 * t7;
        out_at[3 * out_step + i] = t3 * t7;
        out_at[4 * out_step + i] = t7 * t8 - t5 * t12;
        out_at[5 * out_step + i] = t7 * t11 - t4 * t12;
        out_at[6 * out_step + i] = t7 * t10 - t3 * t12;
        out_at[7 * out_step + i] = t7 * t9 + t2 * t12;
    }
}

MOTORCADE_SIMD
void motorcade_blend_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = 1.0 - fraction;
        const double t1 = ((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0) ? -fraction : fraction);
        const double t2 = t0 * a0 + b0 * t1;
        const double t3 = t0 * a3 + b3 * t1;
        const double t4 = t0 * a2 + b2 * t1;
        const double t5 = t0 * a1 + b1 * t1;
        const double t6 = t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5;
        const double t7 = 1.0 / sqrt(t6);
        const double t8 = t0 * a4 + t1 * b4;
        const double t9 = t0 * a7 + t1 * b7;
        const double t10 = t0 * a6 + t1 * b6;
        const double t11 = t0 * a5 + t1 * b5;
        const double t12 = t7 * (-0.5 * (2.0 * (t2 * t9 - t3 * t10 - t5 * t8 - t4 * t11)) / t6);
        out_at[i] = t2 * t7;
        out_at[out_step + i] = t5 * t7;
        out_at[2 * out_step + i] = t4 * t7;
        out_at[3 * out_step + i] = t3 * t7;
        out_at[4 * out_step + i] = t7 * t8 - t5 * t12;
        out_at[5 * out_step + i] = t7 * t11 - t4 * t12;
        out_at[6 * out_step + i] = t7 * t10 - t3 * t12;
        out_at[7 * out_step + i] = t7 * t9 + t2 * t12;
    }
}

/* blend_matrix: Linear blend of two motors as a 3×4 matrix
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 */

MOTORCADE_SIMD
void motorcade_blend_matrix_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = 1.0f - fraction;
        const float t1 = ((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0f) ? -fraction : fraction);
        const float t2 = t0 * a0 + b0 * t1;
        const float t3 = t2 * t2;
        const float t4 = t0 * a3 + b3 * t1;
        const float t5 = t4 * t4;
        const float t6 = t3 - t5;
        const float t7 = t0 * a2 + b2 * t1;
        const float t8 = t7 * t7;
        const float t9 = t0 * a1 + b1 * t1;
        const float t10 = t9 * t9;
        const float t11 = 1.0f / (t10 + (t8 + (t3 + t5)));
        const float t12 = t2 * t4 * 2.0f;
        const float t13 = 2.0f * (t7 * t9);
        const float t14 = t4 * t9;
        const float t15 = t2 * t7;
        const float t16 = t11 * 2.0f;
        const float t17 = t0 * a4 + t1 * b4;
        const float t18 = t0 * a5 + t1 * b5;
        const float t19 = t0 * a6 + t1 * b6;
        const float t20 = t0 * a7 + t1 * b7;
        const float t21 = t11 * -2.0f;
        const float t22 = t4 * t7;
        const float t23 = t2 * t9;
        out_at[i] = (t6 - t8 + t10) * t11;
        out_at[out_step + i] = t11 * (t12 + t13);
        out_at[2 * out_step + i] = (t14 - t15) * t16;
        out_at[3 * out_step + i] = (t2 * t17 + t4 * t18 - t7 * t19 + t9 * t20) * t21;
        out_at[4 * out_step + i] = t11 * (t13 - t12);
        out_at[5 * out_step + i] = t11 * (t6 + t8 - t10);
        out_at[6 * out_step + i] = t16 * (t22 + t23);
        out_at[7 * out_step + i] = t21 * (t2 * t18 - t4 * t17 + t7 * t20 + t9 * t19);
        out_at[8 * out_step + i] = t16 * (t14 + t15);
        out_at[9 * out_step + i] = t16 * (t22 - t23);
        out_at[10 * out_step + i] = t11 * (t5 + (t3 - (t8 + t10)));
        out_at[11 * out_step + i] = t21 * (t7 * t17 - t9 * t18 + t2 * t19 + t4 * t20);
    }
}

MOTORCADE_SIMD
void motorcade_blend_matrix_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = 1.0 - fraction;
        const double t1 = ((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0) ? -fraction : fraction);
        const double t2 = t0 * a0 + b0 * t1;
        const double t3 = t2 * t2;
        const double t4 = t0 * a3 + b3 * t1;
        const double t5 = t4 * t4;
        const double t6 = t3 - t5;
        const double t7 = t0 * a2 + b2 * t1;
        const double t8 = t7 * t7;
        const double t9 = t0 * a1 + b1 * t1;
        const double t10 = t9 * t9;
        const double t11 = 1.0 / (t10 + (t8 + (t3 + t5)));
        const double t12 = t2 * t4 * 2.0;
        const double t13 = 2.0 * (t7 * t9);
        const double t14 = t4 * t9;
        const double t15 = t2 * t7;
        const double t16 = t11 * 2.0;
        const double t17 = t0 * a4 + t1 * b4;
        const double t18 = t0 * a5 + t1 * b5;
        const double t19 = t0 * a6 + t1 * b6;
        const double t20 = t0 * a7 + t1 * b7;
        const double t21 = t11 * -2.0;
        const double t22 = t4 * t7;
        const double t23 = t2 * t9;
        out_at[i] = (t6 - t8 + t10) * t11;
        out_at[out_step + i] = t11 * (t12 + t13);
        out_at[2 * out_step + i] = (t14 - t15) * t16;
        out_at[3 * out_step + i] = (t2 * t17 + t4 * t18 - t7 * t19 + t9 * t20) * t21;
        out_at[4 * out_step + i] = t11 * (t13 - t12);
        out_at[5 * out_step + i] = t11 * (t6 + t8 - t10);
        out_at[6 * out_step + i] = t16 * (t22 + t23);
        out_at[7 * out_step + i] = t21 * (t2 * t18 - t4 * t17 + t7 * t20 + t9 * t19);
        out_at[8 * out_step + i] = t16 * (t14 + t15);
        out_at[9 * out_step + i] = t16 * (t22 - t23);
        out_at[10 * out_step + i] = t11 * (t5 + (t3 - (t8 + t10)));
        out_at[11 * out_step + i] = t21 * (t7 * t17 - t9 * t18 + t2 * t19 + t4 * t20);
    }
}

/* accumulate: Sum total ± weight m, signed as m beside the pivot
 * in total: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in pivot: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in weight: weight
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_accumulate_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict total_at = inputs[0];
    const ptrdiff_t total_step = input_steps[0];
    const float *restrict pivot_at = inputs[1];
    const ptrdiff_t pivot_step = input_steps[1];
    const float *restrict m_at = inputs[2];
    const ptrdiff_t m_step = input_steps[2];
    const float *restrict weight_at = inputs[3];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float total0 = total_at[i], total1 = total_at[total_step + i], total2 = total_at[2 * total_step + i];
        const float total3 = total_at[3 * total_step + i], total4 = total_at[4 * total_step + i], total5 = total_at[5 * total_step + i];
        const float total6 = total_at[6 * total_step + i], total7 = total_at[7 * total_step + i];
        const float pivot0 = pivot_at[i], pivot1 = pivot_at[pivot_step + i], pivot2 = pivot_at[2 * pivot_step + i];
        const float pivot3 = pivot_at[3 * pivot_step + i];
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float weight = weight_at[i];
        const float t0 = ((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0f) ? -weight :
            weight);
        out_at[i] = total0 + m0 * t0;
        out_at[out_step + i] = total1 + m1 * t0;
        out_at[2 * out_step + i] = total2 + m2 * t0;
        out_at[3 * out_step + i] = total3 + m3 * t0;
        out_at[4 * out_step + i] = total4 + t0 * m4;
        out_at[5 * out_step + i] = total5 + t0 * m5;
        out_at[6 * out_step + i] = total6 + t0 * m6;
        out_at[7 * out_step + i] = total7 + t0 * m7;
    }
}

MOTORCADE_SIMD
void motorcade_accumulate_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict total_at = inputs[0];
    const ptrdiff_t total_step = input_steps[0];
    const double *restrict pivot_at = inputs[1];
    const ptrdiff_t pivot_step = input_steps[1];
    const double *restrict m_at = inputs[2];
    const ptrdiff_t m_step = input_steps[2];
    const double *restrict weight_at = inputs[3];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double total0 = total_at[i], total1 = total_at[total_step + i], total2 = total_at[2 * total_step + i];
        const double total3 = total_at[3 * total_step + i], total4 = total_at[4 * total_step + i], total5 = total_at[5 * total_step + i];
        const double total6 = total_at[6 * total_step + i], total7 = total_at[7 * total_step + i];
        const double pivot0 = pivot_at[i], pivot1 = pivot_at[pivot_step + i], pivot2 = pivot_at[2 * pivot_step + i];
        const double pivot3 = pivot_at[3 * pivot_step + i];
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double weight = weight_at[i];
        const double t0 = ((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0) ? -weight :
            weight);
        out_at[i] = total0 + m0 * t0;
        out_at[out_step + i] = total1 + m1 * t0;
        out_at[2 * out_step + i] = total2 + m2 * t0;
        out_at[3 * out_step + i] = total3 + m3 * t0;
        out_at[4 * out_step + i] = total4 + t0 * m4;
        out_at[5 * out_step + i] = total5 + t0 * m5;
        out_at[6 * out_step + i] = total6 + t0 * m6;
        out_at[7 * out_step + i] = total7 + t0 * m7;
    }
}

/* normalize: The motor nearest to an even element
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_normalize_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1;
        const float t1 = 1.0f / sqrtf(t0);
        const float t2 = t1 * (-0.5f * (2.0f * (m0 * m7 - m3 * m6 - m1 * m4 - m2 * m5)) / t0);
        out_at[i] = m0 * t1;
        out_at[out_step + i] = m1 * t1;
        out_at[2 * out_step + i] = m2 * t1;
        out_at[3 * out_step + i] = m3 * t1;
        out_at[4 * out_step + i] = t1 * m4 - m1 * t2;
        out_at[5 * out_step + i] = t1 * m5 - m2 * t2;
        out_at[6 * out_step + i] = t1 * m6 - m3 * t2;
        out_at[7 * out_step + i] = t1 * m7 + m0 * t2;
    }
}

MOTORCADE_SIMD
void motorcade_normalize_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1;
        const double t1 = 1.0 / sqrt(t0);
        const double t2 = t1 * (-0.5 * (2.0 * (m0 * m7 - m3 * m6 - m1 * m4 - m2 * m5)) / t0);
        out_at[i] = m0 * t1;
        out_at[out_step + i] = m1 * t1;
        out_at[2 * out_step + i] = m2 * t1;
        out_at[3 * out_step + i] = m3 * t1;
        out_at[4 * out_step + i] = t1 * m4 - m1 * t2;
        out_at[5 * out_step + i] = t1 * m5 - m2 * t2;
        out_at[6 * out_step + i] = t1 * m6 - m3 * t2;
        out_at[7 * out_step + i] = t1 * m7 + m0 * t2;
    }
}

/* normalize_matrix: 3×4 matrix of the motor nearest to an even element
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 */

MOTORCADE_SIMD
void motorcade_normalize_matrix_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t5 = 1.0f / (t4 + (t3 + (t0 + t1)));
        const float t6 = m0 * m3 * 2.0f;
        const float t7 = 2.0f * (m2 * m1);
        const float t8 = m3 * m1;
        const float t9 = m0 * m2;
        const float t10 = t5 * 2.0f;
        const float t11 = t5 * -2.0f;
        const float t12 = m3 * m2;
        const float t13 = m0 * m1;
        out_at[i] = (t2 - t3 + t4) * t5;
        out_at[out_step + i] = t5 * (t6 + t7);
        out_at[2 * out_step + i] = (t8 - t9) * t10;
        out_at[3 * out_step + i] = (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7) * t11;
        out_at[4 * out_step + i] = t5 * (t7 - t6);
        out_at[5 * out_step + i] = t5 * (t2 + t3 - t4);
        out_at[6 * out_step + i] = t10 * (t12 + t13);
        out_at[7 * out_step + i] = t11 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6);
        out_at[8 * out_step + i] = t10 * (t8 + t9);
        out_at[9 * out_step + i] = t10 * (t12 - t13);
        out_at[10 * out_step + i] = t5 * (t1 + (t0 - (t3 + t4)));
        out_at[11 * out_step + i] = t11 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7);
    }
}

MOTORCADE_SIMD
void motorcade_normalize_matrix_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t5 = 1.0 / (t4 + (t3 + (t0 + t1)));
        const double t6 = m0 * m3 * 2.0;
        const double t7 = 2.0 * (m2 * m1);
        const double t8 = m3 * m1;
        const double t9 = m0 * m2;
        const double t10 = t5 * 2.0;
        const double t11 = t5 * -2.0;
        const double t12 = m3 * m2;
        const double t13 = m0 * m1;
        out_at[i] = (t2 - t3 + t4) * t5;
        out_at[out_step + i] = t5 * (t6 + t7);
        out_at[2 * out_step + i] = (t8 - t9) * t10;
        out_at[3 * out_step + i] = (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7) * t11;
        out_at[4 * out_step + i] = t5 * (t7 - t6);
        out_at[5 * out_step + i] = t5 * (t2 + t3 - t4);
        out_at[6 * out_step + i] = t10 * (t12 + t13);
        out_at[7 * out_step + i] = t11 * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6);
        out_at[8 * out_step + i] = t10 * (t8 + t9);
        out_at[9 * out_step + i] = t10 * (t12 - t13);
        out_at[10 * out_step + i] = t5 * (t1 + (t0 - (t3 + t4)));
        out_at[11 * out_step + i] = t11 * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7);
    }
}
