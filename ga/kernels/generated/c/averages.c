/* Kernels of the group averages: add_weighted, add_local.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* add_weighted: A sum of motors with one more, signed as it is beside the pivot
 * in s: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ bulk
 * in pivot: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in weight: weight
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ bulk */

MOTORCADE_SIMD
void motorcade_add_weighted_f32(MOTORCADE_ARGUMENTS(float))
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
        const float pivot0 = pivot_at[i], pivot1 = pivot_at[pivot_step + i], pivot2 = pivot_at[2 * pivot_step + i];
        const float pivot3 = pivot_at[3 * pivot_step + i];
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
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
        out_at[8 * out_step + i] = s8 + t1;
    }
}

MOTORCADE_SIMD
void motorcade_add_weighted_f64(MOTORCADE_ARGUMENTS(double))
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
        const double pivot0 = pivot_at[i], pivot1 = pivot_at[pivot_step + i], pivot2 = pivot_at[2 * pivot_step + i];
        const double pivot3 = pivot_at[3 * pivot_step + i];
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
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
        out_at[8 * out_step + i] = s8 + fabs(weight) * larger(larger(larger(fabs(m0), fabs(m1)),
            fabs(m2)), fabs(m3));
    }
}

/* add_local: A sum of twists with that from motor a to b, which turns by at most π
 * in s: rx ry rz x y z
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in weight: weight
 * out out: rx ry rz x y z */

MOTORCADE_SIMD
void motorcade_add_local_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const float a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const float weight = weight_at[i];
        const float t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
        const float t1 = ((t0 < 0.0f) ? -1.0f : 1.0f);
        const float t2 = 1.0f - t0 * t1;
        const float t3 = t2 * (t2 * (t2 * (0.007290418f * t2 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t4 = t2 * (t2 * (t2 * (t2 * t3 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t5 = t2 * (t2 * t4 + 0.33333293f) + 1.0f;
        const float t6 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2);
        const float t7 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1);
        const float t8 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1);
        const float t9 = t5 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2
            * a6 - b1 * a7));
        const float t10 = t2 * (t2 * (t2 * (t2 * 0.038853493f + -0.15787645f) + 0.30586854f) +
            -0.32981494f) + 0.24242681f;
        const float t11 = t2 * (t2 * (t2 * (t2 * t10 + -0.08780976f) + 0.06264518f) + 0.052127957f)
            + 0.10218229f;
        const float t12 = (t2 * (t2 * (t2 * t11 + 0.17139615f) + 0.26666737f) + 0.33333334f) * (t1 *
            (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 * b5 - b2 * a5));
        const float t13 = t5 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3
            * b4 + b1 * a6));
        const float t14 = t5 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1
            * b5 - b3 * a7));
        out_at[i] = s0 + weight * (-2.0f * (t5 * t6));
        out_at[out_step + i] = s1 - weight * (-2.0f * (t5 * t7));
        out_at[2 * out_step + i] = s2 + weight * (-2.0f * (t5 * t8));
        out_at[3 * out_step + i] = s3 + weight * (-2.0f * (t9 + t6 * t12));
        out_at[4 * out_step + i] = s4 + weight * (-2.0f * (t13 - t7 * t12));
        out_at[5 * out_step + i] = s5 + weight * (-2.0f * (t14 + t8 * t12));
    }
}

MOTORCADE_SIMD
void motorcade_add_local_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a0 = a_at[i], a1 = a_at[a_step + i], a2 = a_at[2 * a_step + i];
        const double a3 = a_at[3 * a_step + i], a4 = a_at[4 * a_step + i], a5 = a_at[5 * a_step + i];
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i];
        const double weight = weight_at[i];
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
        const double t11 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2);
        const double t12 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1);
        const double t13 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1);
        const double t14 = t10 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 -
            b2 * a6 - b1 * a7));
        const double t15 = t2 * (t2 * (t2 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t16 = t2 * (t2 * (t2 * (t15 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t17 = t2 * (t2 * (t2 * (t16 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t18 = t2 * (t2 * (t17 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t19 = t2 * (t2 * (t2 * t18 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t20 = t2 * (t2 * (t2 * t19 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t21 = t2 * (t2 * (t2 * t20 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t22 = t2 * (t2 * (t2 * t21 + 0.17142857142808898) + 0.2666666666666692) +
            0.3333333333333333;
        const double t23 = t22 * (t1 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 -
            a2 * b5 - b2 * a5));
        const double t24 = t10 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 +
            a3 * b4 + b1 * a6));
        const double t25 = t10 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 +
            a1 * b5 - b3 * a7));
        out_at[i] = s0 + weight * (-2.0 * (t10 * t11));
        out_at[out_step + i] = s1 - weight * (-2.0 * (t10 * t12));
        out_at[2 * out_step + i] = s2 + weight * (-2.0 * (t10 * t13));
        out_at[3 * out_step + i] = s3 + weight * (-2.0 * (t14 + t11 * t23));
        out_at[4 * out_step + i] = s4 + weight * (-2.0 * (t24 - t12 * t23));
        out_at[5 * out_step + i] = s5 + weight * (-2.0 * (t25 + t13 * t23));
    }
}
