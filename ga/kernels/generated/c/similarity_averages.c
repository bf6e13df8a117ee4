/* Kernels of the group similarity_averages: similarity_add_weighted, similarity_add_local.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_add_weighted: A sum of similarities with one more, signed as it is beside the pivot
 * in s: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ bulk
 * in pivot: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in weight: weight
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ bulk */

MOTORCADE_SIMD
void motorcade_similarity_add_weighted_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict s_at = inputs[0];
    const ptrdiff_t s_step = input_steps[0];
    const float *restrict pivot_at = inputs[1];
    const ptrdiff_t pivot_step = input_steps[1];
    const float *restrict m_at = inputs[2];
    const ptrdiff_t m_step = input_steps[2];
    const float *restrict weight_at = inputs[3];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const float s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const float s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const float s9 = s_at[9 * s_step + i], s10 = s_at[10 * s_step + i], s11 = s_at[11 * s_step + i];
        const float s12 = s_at[12 * s_step + i];
        const float pivot0 = pivot_at[i], pivot1 = pivot_at[pivot_step + i], pivot2 = pivot_at[2 * pivot_step + i];
        const float pivot3 = pivot_at[3 * pivot_step + i];
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float weight = weight_at[i];
        const float t0 = ((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0f) ? -weight :
            weight);
        const float t1 = fabsf(weight) * largerf(largerf(largerf(fabsf(m0), fabsf(m1)), fabsf(m2)),
            fabsf(m3));
        out_at[i] = s0 + m0 * t0;
        out_at[out_step + i] = s1 + m1 * t0;
        out_at[2 * out_step + i] = s2 + m2 * t0;
        out_at[3 * out_step + i] = s3 + m3 * t0;
        out_at[4 * out_step + i] = s4 + t0 * m4;
        out_at[5 * out_step + i] = s5 + t0 * m5;
        out_at[6 * out_step + i] = s6 + t0 * m6;
        out_at[7 * out_step + i] = s7 + t0 * m7;
        out_at[8 * out_step + i] = s8 + t0 * m8;
        out_at[9 * out_step + i] = s9 + t0 * m9;
        out_at[10 * out_step + i] = s10 + t0 * m10;
        out_at[11 * out_step + i] = s11 + t0 * m11;
        out_at[12 * out_step + i] = s12 + t1;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_add_weighted_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict s_at = inputs[0];
    const ptrdiff_t s_step = input_steps[0];
    const double *restrict pivot_at = inputs[1];
    const ptrdiff_t pivot_step = input_steps[1];
    const double *restrict m_at = inputs[2];
    const ptrdiff_t m_step = input_steps[2];
    const double *restrict weight_at = inputs[3];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const double s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const double s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const double s9 = s_at[9 * s_step + i], s10 = s_at[10 * s_step + i], s11 = s_at[11 * s_step + i];
        const double s12 = s_at[12 * s_step + i];
        const double pivot0 = pivot_at[i], pivot1 = pivot_at[pivot_step + i], pivot2 = pivot_at[2 * pivot_step + i];
        const double pivot3 = pivot_at[3 * pivot_step + i];
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double weight = weight_at[i];
        const double t0 = ((pivot0 * m0 + pivot1 * m1 + pivot2 * m2 + pivot3 * m3 < 0.0) ? -weight :
            weight);
        out_at[i] = s0 + m0 * t0;
        out_at[out_step + i] = s1 + m1 * t0;
        out_at[2 * out_step + i] = s2 + m2 * t0;
        out_at[3 * out_step + i] = s3 + m3 * t0;
        out_at[4 * out_step + i] = s4 + t0 * m4;
        out_at[5 * out_step + i] = s5 + t0 * m5;
        out_at[6 * out_step + i] = s6 + t0 * m6;
        out_at[7 * out_step + i] = s7 + t0 * m7;
        out_at[8 * out_step + i] = s8 + t0 * m8;
        out_at[9 * out_step + i] = s9 + t0 * m9;
        out_at[10 * out_step + i] = s10 + t0 * m10;
        out_at[11 * out_step + i] = s11 + t0 * m11;
        out_at[12 * out_step + i] = s12 + fabs(weight) * larger(larger(larger(fabs(m0), fabs(m1)),
            fabs(m2)), fabs(m3));
    }
}

/* similarity_add_local: A sum of twists with that from similarity a to b, which turns by at most π
 * in s: rx ry rz x y z log_scale
 * in a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in weight: weight
 * out out: rx ry rz x y z log_scale */

MOTORCADE_SIMD
void motorcade_similarity_add_local_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict s_at = inputs[0];
    const ptrdiff_t s_step = input_steps[0];
    const float *restrict a_at = inputs[1];
    const ptrdiff_t a_step = input_steps[1];
    const float *restrict b_at = inputs[2];
    const ptrdiff_t b_step = input_steps[2];
    const float *restrict weight_at = inputs[3];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const float s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const float s6 = s_at[6 * s_step + i];
        const float a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const float a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const float a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const float b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const float weight = weight_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5 *
            b5);
        const float t1 = ((t0 < 0.0f) ? -1.0f : 1.0f);
        const float t2 = t0 * t1;
        const float t3 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5
            + a6 * b5));
        const float t4 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 *
            a6 - b7 * a5));
        const float t5 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 *
            a6) + a7 * b6));
        const float t6 = sqrtf(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        const float t7 = 1.0f / t6;
        const float t8 = t2 * t7;
        const float t9 = 1.0f - t8;
        const float t10 = t9 * (t9 * (t9 * (0.007290418f * t9 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t11 = t9 * (t9 * (t9 * (t9 * t10 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t12 = t9 * (t9 * t11 + 0.33333293f) + 1.0f;
        const float t13 = t5 * t7;
        const float t14 = t4 * t7;
        const float t15 = t3 * t7;
        const float t16 = a0 - a4;
        const float t17 = a7 - a3;
        const float t18 = a2 - a6;
        const float t19 = a5 - a1;
        const float t20 = b3 - b7;
        const float t21 = b0 - b4;
        const float t22 = b6 - b2;
        const float t23 = b1 - b5;
        const float t24 = t16 * b8 + t17 * b9 + t18 * b10 - t19 * b11 + (a9 * t20 - a8 * t21 + a10 *
            t22 - a11 * t23);
        const float t25 = t1 * t24;
        const float t26 = t16 * b11 + t17 * b10 + b8 * t19 - b9 * t18 + (t21 * a11 - (a8 * t23 + t20
            * a10) + a9 * t22);
        const float t27 = t1 * t26;
        const float t28 = t1 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 * a6
            + b1 * a5));
        const float t29 = t1 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 * a5
            + b1 * a6));
        const float t30 = t1 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 *
            a6 - b3 * a5));
        const float t31 = t1 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 *
            a6) + b2 * a7));
        const float t32 = t8 * t28 + t15 * t29 + t14 * t30 + t13 * t31;
        const float t33 = fabsf(t32);
        const float t34 = t6 + t33;
        const float t35 = exponentf(1.4142135f * t34);
        const _Bool t36 = (t35 < 0.5f);
        const float t37 = t34 * exp2_of_integerf(-t35);
        const float t38 = (t36 ? t33 : 0.5f * (t37 - 1.0f / t37));
        const float t39 = t38 * t38;
        const float t40 = t39 * (t39 * (t39 * (0.024318371f * t39 + -0.044006806f) + 0.07497201f) +
            -0.16666622f);
        const float t41 = t40 + 1.0f;
        const float t42 = (t36 ? t41 : (t35 * 0.69311523f + (t35 * 3.1946183e-05f + t38 * t41)) /
            largerf(t33, 0.25f));
        const float t43 = t16 * b10 - t17 * b11 - b8 * t18 - b9 * t19 - (a8 * t22 + a9 * t23 + t21 *
            a10 + t20 * a11);
        const float t44 = t1 * t43;
        const float t45 = t13 * t44 - t15 * t25;
        const float t46 = t16 * b9 + t18 * b11 + b10 * t19 - b8 * t17 + (t22 * a11 - (t20 * a8 + a9
            * t21) + a10 * t23);
        const float t47 = t1 * t46;
        const float t48 = t14 * t25 + t13 * t47;
        const float t49 = 1.0f / largerf(t13 * t13 + t14 * t14 + t15 * t15 + t32 * t32,
            1.6940659e-21f);
        const float t50 = (t8 * t42 - t6 * t12) * t49;
        const float t51 = t15 * t47 + t14 * t44;
        const float t52 = t49 * (t32 * (t8 * t12 - t6 * t42));
        const float t53 = weight * (-2.0f * ((t8 * t25 + t13 * t27) * t42 + (t15 * t45 - t14 * t48)
            * t50 + t51 * t52));
        const float t54 = weight * (-2.0f * (t42 * (t8 * t47 - t14 * t27) - t50 * (t13 * t48 + t15 *
            t51) + t45 * t52));
        const float t55 = weight * (-2.0f * (t42 * (t8 * t44 + t15 * t27) - t50 * (t14 * t51 + t13 *
            t45) - t48 * t52));
        out_at[i] = s0 + weight * (-2.0f * (t12 * t13));
        out_at[out_step + i] = s1 - weight * (-2.0f * (t12 * t14));
        out_at[2 * out_step + i] = s2 + weight * (-2.0f * (t12 * t15));
        out_at[3 * out_step + i] = s3 + t53;
        out_at[4 * out_step + i] = s4 + t54;
        out_at[5 * out_step + i] = s5 + t55;
        out_at[6 * out_step + i] = s6 + weight * (2.0f * (t32 * t42));
    }
}

MOTORCADE_SIMD
void motorcade_similarity_add_local_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict s_at = inputs[0];
    const ptrdiff_t s_step = input_steps[0];
    const double *restrict a_at = inputs[1];
    const ptrdiff_t a_step = input_steps[1];
    const double *restrict b_at = inputs[2];
    const ptrdiff_t b_step = input_steps[2];
    const double *restrict weight_at = inputs[3];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const double s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const double s6 = s_at[6 * s_step + i];
        const double a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const double a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const double a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const double b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const double weight = weight_at[i];
        const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5
            * b5);
        const double t1 = ((t0 < 0.0) ? -1.0 : 1.0);
        const double t2 = t0 * t1;
        const double t3 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5
            + a6 * b5));
        const double t4 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 *
            a6 - b7 * a5));
        const double t5 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 *
            a6) + a7 * b6));
        const double t6 = sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        const double t7 = 1.0 / t6;
        const double t8 = t2 * t7;
        const double t9 = 1.0 - t8;
        const double t10 = t9 * (t9 * (8.121007252839173e-05 * t9 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t11 = t9 * (t9 * (t10 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t12 = t9 * (t9 * (t9 * t11 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t13 = t9 * (t9 * (t9 * t12 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t14 = t9 * (t9 * (t9 * t13 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t15 = t9 * (t9 * (t9 * t14 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t16 = t9 * (t9 * (t9 * t15 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t17 = 1.0 + t9 * t16;
        const double t18 = t5 * t7;
        const double t19 = t4 * t7;
        const double t20 = t3 * t7;
        const double t21 = a0 - a4;
        const double t22 = a7 - a3;
        const double t23 = a2 - a6;
        const double t24 = a5 - a1;
        const double t25 = b3 - b7;
        const double t26 = b0 - b4;
        const double t27 = b6 - b2;
        const double t28 = b1 - b5;
        const double t29 = t21 * b8 + t22 * b9 + t23 * b10 - t24 * b11 + (a9 * t25 - a8 * t26 + a10
            * t27 - a11 * t28);
        const double t30 = t1 * t29;
        const double t31 = t21 * b11 + t22 * b10 + b8 * t24 - b9 * t23 + (t26 * a11 - (a8 * t28 +
            t25 * a10) + a9 * t27);
        const double t32 = t1 * t31;
        const double t33 = t1 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 *
            a6 + b1 * a5));
        const double t34 = t1 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 *
            a5 + b1 * a6));
        const double t35 = t1 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 *
            a6 - b3 * a5));
        const double t36 = t1 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 *
            a6) + b2 * a7));
        const double t37 = t8 * t33 + t20 * t34 + t19 * t35 + t18 * t36;
        const double t38 = fabs(t37);
        const double t39 = t6 + t38;
        const double t40 = exponent(1.4142135623730951 * t39);
        const _Bool t41 = (t40 < 0.5);
        const double t42 = t39 * exp2_of_integer(-t40);
        const double t43 = (t41 ? t38 : 0.5 * (t42 - 1.0 / t42));
        const double t44 = t43 * t43;
        const double t45 = t44 * (t44 * (-0.005811206588331519 * t44 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t46 = t44 * (t44 * (t45 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t47 = t44 * (t44 * (t44 * t46 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        const double t48 = 1.0 + t44 * t47;
        const double t49 = (t40 * 0.6931471675634384 + (t40 * 1.2996506893889889e-08 + t43 * t48)) /
            larger(t38, 0.25);
        const double t50 = (t41 ? t48 : t49);
        const double t51 = t21 * b10 - t22 * b11 - b8 * t23 - b9 * t24 - (a8 * t27 + a9 * t28 + t26
            * a10 + t25 * a11);
        const double t52 = t1 * t51;
        const double t53 = t18 * t52 - t20 * t30;
        const double t54 = t21 * b9 + t23 * b11 + b10 * t24 - b8 * t22 + (t27 * a11 - (t25 * a8 + a9
            * t26) + a10 * t28);
        const double t55 = t1 * t54;
        const double t56 = t19 * t30 + t18 * t55;
        const double t57 = 1.0 / larger(t18 * t18 + t19 * t19 + t20 * t20 + t37 * t37,
            1.0947644252537633e-47);
        const double t58 = (t8 * t50 - t6 * t17) * t57;
        const double t59 = t20 * t55 + t19 * t52;
        const double t60 = t57 * (t37 * (t8 * t17 - t6 * t50));
        const double t61 = weight * (-2.0 * ((t8 * t30 + t18 * t32) * t50 + (t20 * t53 - t19 * t56)
            * t58 + t59 * t60));
        const double t62 = weight * (-2.0 * (t50 * (t8 * t55 - t19 * t32) - t58 * (t18 * t56 + t20 *
            t59) + t53 * t60));
        const double t63 = weight * (-2.0 * (t50 * (t8 * t52 + t20 * t32) - t58 * (t19 * t59 + t18 *
            t53) - t56 * t60));
        out_at[i] = s0 + weight * (-2.0 * (t17 * t18));
        out_at[out_step + i] = s1 - weight * (-2.0 * (t17 * t19));
        out_at[2 * out_step + i] = s2 + weight * (-2.0 * (t17 * t20));
        out_at[3 * out_step + i] = s3 + t61;
        out_at[4 * out_step + i] = s4 + t62;
        out_at[5 * out_step + i] = s5 + t63;
        out_at[6 * out_step + i] = s6 + weight * (2.0 * (t37 * t50));
    }
}
