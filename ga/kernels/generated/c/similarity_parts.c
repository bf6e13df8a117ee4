/* Kernels of the group similarity_parts: similarity_of, similarity_of_matrix44,
 * similarity_of_coefficients, motor_scale.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_of: Grow by a scale, turn by a rotor, move by a translation
 * in r: 1 e23 e31 e12
 * in t: x y z
 * in scale: scale
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_of_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const float *restrict t_at = inputs[1];
    const ptrdiff_t t_step = input_steps[1];
    const float *restrict scale_at = inputs[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const float scale = scale_at[i];
        const float t3 = 1.0f / sqrtf(scale);
        const float t4 = 0.5f * t3;
        const float t5 = (scale + 1.0f) * t4;
        const float t6 = t4 * (scale - 1.0f);
        const float t7 = -0.5f * t0;
        const float t8 = -0.5f * t1;
        const float t9 = -0.5f * t2;
        out_at[i] = r0 * t5;
        out_at[out_step + i] = t5 * r1;
        out_at[2 * out_step + i] = t5 * r2;
        out_at[3 * out_step + i] = t5 * r3;
        out_at[4 * out_step + i] = r0 * t6;
        out_at[5 * out_step + i] = r1 * t6;
        out_at[6 * out_step + i] = r2 * t6;
        out_at[7 * out_step + i] = r3 * t6;
        out_at[8 * out_step + i] = t3 * (r0 * t7 - r3 * t8 + r2 * t9);
        out_at[9 * out_step + i] = t3 * (r3 * t7 + r0 * t8 - r1 * t9);
        out_at[10 * out_step + i] = t3 * (r1 * t8 - r2 * t7 + r0 * t9);
        out_at[11 * out_step + i] = t3 * (r1 * t7 + r3 * t9 + r2 * t8);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_of_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const double *restrict t_at = inputs[1];
    const ptrdiff_t t_step = input_steps[1];
    const double *restrict scale_at = inputs[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const double scale = scale_at[i];
        const double t3 = 1.0 / sqrt(scale);
        const double t4 = 0.5 * t3;
        const double t5 = (scale + 1.0) * t4;
        const double t6 = t4 * (scale - 1.0);
        const double t7 = -0.5 * t0;
        const double t8 = -0.5 * t1;
        const double t9 = -0.5 * t2;
        out_at[i] = r0 * t5;
        out_at[out_step + i] = t5 * r1;
        out_at[2 * out_step + i] = t5 * r2;
        out_at[3 * out_step + i] = t5 * r3;
        out_at[4 * out_step + i] = r0 * t6;
        out_at[5 * out_step + i] = r1 * t6;
        out_at[6 * out_step + i] = r2 * t6;
        out_at[7 * out_step + i] = r3 * t6;
        out_at[8 * out_step + i] = t3 * (r0 * t7 - r3 * t8 + r2 * t9);
        out_at[9 * out_step + i] = t3 * (r3 * t7 + r0 * t8 - r1 * t9);
        out_at[10 * out_step + i] = t3 * (r1 * t8 - r2 * t7 + r0 * t9);
        out_at[11 * out_step + i] = t3 * (r1 * t7 + r3 * t9 + r2 * t8);
    }
}

/* similarity_of_matrix44: Similarity of a homogeneous matrix by rows; what its last row is off by
 * counts ten times
 * in m: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 m30 m31 m32 m33
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ off */

MOTORCADE_SIMD
void motorcade_similarity_of_matrix44_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m0 * m0 + m1 * m1 + m2 * m2 + m4 * m4 + m5 * m5 + m6 * m6 + m8 * m8 + m9 *
            m9 + m10 * m10;
        const float t1 = sqrtf(0.33333334f * t0);
        const float t2 = 1.0f / t1;
        const float t3 = m0 * t2;
        const float t4 = 1.0f - t3;
        const float t5 = m5 * t2;
        const float t6 = m10 * t2;
        const float t7 = t4 - t5 + t6;
        const float t8 = t4 + t5 - t6;
        const _Bool t9 = (t7 <= t8);
        const float t10 = 1.0f + t3;
        const float t11 = t10 - t5 - t6;
        const float t12 = t6 + (t5 + t10);
        const _Bool t13 = (t11 <= t12);
        const _Bool t14 = ((t9 ? t8 : t7) <= (t13 ? t12 : t11));
        const float t15 = m9 * t2;
        const float t16 = m6 * t2;
        const float t17 = t15 - t16;
        const float t18 = m2 * t2;
        const float t19 = m8 * t2;
        const float t20 = t18 - t19;
        const float t21 = m4 * t2;
        const float t22 = m1 * t2;
        const float t23 = t21 - t22;
        const float t24 = (t14 ? (t13 ? t12 : t17) : (t9 ? t20 : t23));
        const float t25 = t21 + t22;
        const float t26 = t18 + t19;
        const float t27 = (t14 ? (t13 ? t17 : t11) : (t9 ? t25 : t26));
        const float t28 = t15 + t16;
        const float t29 = (t14 ? (t13 ? t20 : t25) : (t9 ? t8 : t28));
        const float t30 = (t14 ? (t13 ? t23 : t26) : (t9 ? t28 : t7));
        const float t31 = 1.0f / sqrtf(t24 * t24 + t27 * t27 + t29 * t29 + t30 * t30);
        const float t32 = t24 * t31;
        const float t33 = 1.0f / sqrtf(t1);
        const float t34 = 0.5f * t33;
        const float t35 = (1.0f + t1) * t34;
        const float t36 = t27 * t31;
        const float t37 = t29 * t31;
        const float t38 = t30 * t31;
        const float t39 = t34 * (t1 - 1.0f);
        const float t40 = -0.5f * m3;
        const float t41 = -0.5f * m7;
        const float t42 = -0.5f * m11;
        const float t43 = t3 * (t5 * t6 - t15 * t16) + t21 * (t15 * t18 - t6 * t22) + t19 * (t16 *
            t22 - t5 * t18);
        const float t44 = fabsf(t3 * t3 + t21 * t21 + t19 * t19 - 1.0f) + fabsf(t3 * t22 + t5 * t21
            + t15 * t19);
        const float t45 = t44 + fabsf(t3 * t18 + t16 * t21 + t6 * t19) + fabsf(t22 * t22 + t5 * t5 +
            t15 * t15 - 1.0f);
        const float t46 = t45 + fabsf(t18 * t22 + t5 * t16 + t6 * t15) + fabsf(t18 * t18 + t16 * t16
            + t6 * t6 - 1.0f);
        const float t47 = ((t43 < 0.0f) ? 4.0f : t46) + 10.0f * (fabsf(m12) + fabsf(m13) +
            fabsf(m14) + fabsf(m15 - 1.0f));
        out_at[i] = t32 * t35;
        out_at[out_step + i] = -(t35 * t36);
        out_at[2 * out_step + i] = -(t35 * t37);
        out_at[3 * out_step + i] = -(t35 * t38);
        out_at[4 * out_step + i] = t32 * t39;
        out_at[5 * out_step + i] = -(t36 * t39);
        out_at[6 * out_step + i] = -(t37 * t39);
        out_at[7 * out_step + i] = -(t38 * t39);
        out_at[8 * out_step + i] = t33 * (t32 * t40 + t38 * t41 - t37 * t42);
        out_at[9 * out_step + i] = t33 * (t32 * t41 - t38 * t40 + t36 * t42);
        out_at[10 * out_step + i] = t33 * (t37 * t40 - t36 * t41 + t32 * t42);
        out_at[11 * out_step + i] = -(t33 * (t36 * t40 + t38 * t42 + t37 * t41));
        out_at[12 * out_step + i] = t47;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_of_matrix44_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m0 * m0 + m1 * m1 + m2 * m2 + m4 * m4 + m5 * m5 + m6 * m6 + m8 * m8 + m9 *
            m9 + m10 * m10;
        const double t1 = sqrt(0.3333333333333333 * t0);
        const double t2 = 1.0 / t1;
        const double t3 = m0 * t2;
        const double t4 = 1.0 - t3;
        const double t5 = m5 * t2;
        const double t6 = m10 * t2;
        const double t7 = t4 - t5 + t6;
        const double t8 = t4 + t5 - t6;
        const _Bool t9 = (t7 <= t8);
        const double t10 = 1.0 + t3;
        const double t11 = t10 - t5 - t6;
        const double t12 = t6 + (t5 + t10);
        const _Bool t13 = (t11 <= t12);
        const _Bool t14 = ((t9 ? t8 : t7) <= (t13 ? t12 : t11));
        const double t15 = m9 * t2;
        const double t16 = m6 * t2;
        const double t17 = t15 - t16;
        const double t18 = m2 * t2;
        const double t19 = m8 * t2;
        const double t20 = t18 - t19;
        const double t21 = m4 * t2;
        const double t22 = m1 * t2;
        const double t23 = t21 - t22;
        const double t24 = (t14 ? (t13 ? t12 : t17) : (t9 ? t20 : t23));
        const double t25 = t21 + t22;
        const double t26 = t18 + t19;
        const double t27 = (t14 ? (t13 ? t17 : t11) : (t9 ? t25 : t26));
        const double t28 = t15 + t16;
        const double t29 = (t14 ? (t13 ? t20 : t25) : (t9 ? t8 : t28));
        const double t30 = (t14 ? (t13 ? t23 : t26) : (t9 ? t28 : t7));
        const double t31 = 1.0 / sqrt(t24 * t24 + t27 * t27 + t29 * t29 + t30 * t30);
        const double t32 = t24 * t31;
        const double t33 = 1.0 / sqrt(t1);
        const double t34 = 0.5 * t33;
        const double t35 = (1.0 + t1) * t34;
        const double t36 = t27 * t31;
        const double t37 = t29 * t31;
        const double t38 = t30 * t31;
        const double t39 = t34 * (t1 - 1.0);
        const double t40 = -0.5 * m3;
        const double t41 = -0.5 * m7;
        const double t42 = -0.5 * m11;
        const double t43 = t3 * (t5 * t6 - t15 * t16) + t21 * (t15 * t18 - t6 * t22) + t19 * (t16 *
            t22 - t5 * t18);
        const double t44 = fabs(t3 * t3 + t21 * t21 + t19 * t19 - 1.0) + fabs(t3 * t22 + t5 * t21 +
            t15 * t19) + fabs(t3 * t18 + t16 * t21 + t6 * t19);
        const double t45 = t44 + fabs(t22 * t22 + t5 * t5 + t15 * t15 - 1.0) + fabs(t18 * t22 + t5 *
            t16 + t6 * t15);
        const double t46 = ((t43 < 0.0) ? 4.0 : t45 + fabs(t18 * t18 + t16 * t16 + t6 * t6 - 1.0)) +
            10.0 * (fabs(m12) + fabs(m13) + fabs(m14) + fabs(m15 - 1.0));
        out_at[i] = t32 * t35;
        out_at[out_step + i] = -(t35 * t36);
        out_at[2 * out_step + i] = -(t35 * t37);
        out_at[3 * out_step + i] = -(t35 * t38);
        out_at[4 * out_step + i] = t32 * t39;
        out_at[5 * out_step + i] = -(t36 * t39);
        out_at[6 * out_step + i] = -(t37 * t39);
        out_at[7 * out_step + i] = -(t38 * t39);
        out_at[8 * out_step + i] = t33 * (t32 * t40 + t38 * t41 - t37 * t42);
        out_at[9 * out_step + i] = t33 * (t32 * t41 - t38 * t40 + t36 * t42);
        out_at[10 * out_step + i] = t33 * (t37 * t40 - t36 * t41 + t32 * t42);
        out_at[11 * out_step + i] = -(t33 * (t36 * t40 + t38 * t42 + t37 * t41));
        out_at[12 * out_step + i] = t46;
    }
}

/* similarity_of_coefficients: The same numbers, and how far ``S ~S`` is from 1, as a share of the
 * squares in it
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ off */

MOTORCADE_SIMD
void motorcade_similarity_of_coefficients_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m0 * m0;
        const float t1 = m4 * m4;
        const float t2 = m1 * m1;
        const float t3 = m5 * m5;
        const float t4 = m2 * m2;
        const float t5 = m6 * m6;
        const float t6 = m3 * m3;
        const float t7 = m7 * m7;
        const float t8 = largerf(largerf(largerf(largerf(1.0f, fabsf(m8)), fabsf(m9)), fabsf(m10)),
            fabsf(m11));
        const float t9 = largerf(fabsf(t0 - t1 + (t2 - t3) + (t4 - t5) + (t6 - t7) - 1.0f),
            fabsf((m11 * (m0 + m4) - (m8 * (m1 + m5) + m9 * (m2 + m6) + m10 * (m3 + m7))) / t8));
        const float t10 = largerf(largerf(t9, fabsf((m0 * m5 - m1 * m4 + m2 * m7 - m3 * m6) *
            2.0f)), fabsf(2.0f * (m0 * m6 - m2 * m4 + m3 * m5 - m1 * m7)));
        const float t11 = largerf(1e-04f, 1.0f / largerf(1.0f, t7 + (t5 + (t3 + (t1 + (t6 + (t4 +
            (t0 + t2))))))));
        out_at[i] = m0;
        out_at[out_step + i] = m1;
        out_at[2 * out_step + i] = m2;
        out_at[3 * out_step + i] = m3;
        out_at[4 * out_step + i] = m4;
        out_at[5 * out_step + i] = m5;
        out_at[6 * out_step + i] = m6;
        out_at[7 * out_step + i] = m7;
        out_at[8 * out_step + i] = m8;
        out_at[9 * out_step + i] = m9;
        out_at[10 * out_step + i] = m10;
        out_at[11 * out_step + i] = m11;
        out_at[12 * out_step + i] = largerf(t10, fabsf(2.0f * (m0 * m7 - m3 * m4 + m1 * m6 - m2 *
            m5))) * t11;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_of_coefficients_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m0 * m0;
        const double t1 = m4 * m4;
        const double t2 = m1 * m1;
        const double t3 = m5 * m5;
        const double t4 = m2 * m2;
        const double t5 = m6 * m6;
        const double t6 = m3 * m3;
        const double t7 = m7 * m7;
        const double t8 = (m11 * (m0 + m4) - (m8 * (m1 + m5) + m9 * (m2 + m6) + m10 * (m3 + m7))) /
            larger(larger(larger(larger(1.0, fabs(m8)), fabs(m9)), fabs(m10)), fabs(m11));
        const double t9 = larger(larger(fabs(t0 - t1 + (t2 - t3) + (t4 - t5) + (t6 - t7) - 1.0),
            fabs(t8)), fabs((m0 * m5 - m1 * m4 + m2 * m7 - m3 * m6) * 2.0));
        const double t10 = larger(larger(t9, fabs(2.0 * (m0 * m6 - m2 * m4 + m3 * m5 - m1 * m7))),
            fabs(2.0 * (m0 * m7 - m3 * m4 + m1 * m6 - m2 * m5)));
        const double t11 = t10 * larger(1e-05, 1.0 / larger(1.0, t7 + (t5 + (t3 + (t1 + (t6 + (t4 +
            (t0 + t2))))))));
        out_at[i] = m0;
        out_at[out_step + i] = m1;
        out_at[2 * out_step + i] = m2;
        out_at[3 * out_step + i] = m3;
        out_at[4 * out_step + i] = m4;
        out_at[5 * out_step + i] = m5;
        out_at[6 * out_step + i] = m6;
        out_at[7 * out_step + i] = m7;
        out_at[8 * out_step + i] = m8;
        out_at[9 * out_step + i] = m9;
        out_at[10 * out_step + i] = m10;
        out_at[11 * out_step + i] = m11;
        out_at[12 * out_step + i] = t11;
    }
}

/* motor_scale: Rigid motion and scale of a similarity
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ scale */

MOTORCADE_SIMD
void motorcade_motor_scale_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = 1.0f / sqrtf(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
        const float t1 = m0 * t0;
        const float t2 = m1 * t0;
        const float t3 = m2 * t0;
        const float t4 = m3 * t0;
        const _Bool t5 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0f);
        const float t6 = m0 - m4;
        const float t7 = m3 - m7;
        const float t8 = m6 - m2;
        const float t9 = m1 - m5;
        const float t10 = 1.0f / (t6 * t6 + t7 * t7 + t8 * t8 + t9 * t9);
        const float t11 = (t5 ? t6 * t10 : m0 + m4);
        const float t12 = (t5 ? t7 * t10 : m3 + m7);
        const float t13 = (t5 ? -(t8 * t10) : m2 + m6);
        const float t14 = (t5 ? t9 * t10 : m1 + m5);
        const float t15 = m8 * t11 + m9 * t12 - m10 * t13 + m11 * t14;
        const float t16 = t11 * m9 - m8 * t12 + t13 * m11 + m10 * t14;
        const float t17 = m8 * t13 - m9 * t14 + t11 * m10 + t12 * m11;
        out_at[i] = t1;
        out_at[out_step + i] = t2;
        out_at[2 * out_step + i] = t3;
        out_at[3 * out_step + i] = t4;
        out_at[4 * out_step + i] = t1 * t15 - t4 * t16 + t3 * t17;
        out_at[5 * out_step + i] = t4 * t15 + t1 * t16 - t2 * t17;
        out_at[6 * out_step + i] = t2 * t16 - t3 * t15 + t1 * t17;
        out_at[7 * out_step + i] = t2 * t15 + t4 * t17 + t3 * t16;
        out_at[8 * out_step + i] = t11 * t11 + t12 * t12 + t13 * t13 + t14 * t14;
    }
}

MOTORCADE_SIMD
void motorcade_motor_scale_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = 1.0 / sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
        const double t1 = m0 * t0;
        const double t2 = m1 * t0;
        const double t3 = m2 * t0;
        const double t4 = m3 * t0;
        const _Bool t5 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0);
        const double t6 = m0 - m4;
        const double t7 = m3 - m7;
        const double t8 = m6 - m2;
        const double t9 = m1 - m5;
        const double t10 = 1.0 / (t6 * t6 + t7 * t7 + t8 * t8 + t9 * t9);
        const double t11 = (t5 ? t6 * t10 : m0 + m4);
        const double t12 = (t5 ? t7 * t10 : m3 + m7);
        const double t13 = (t5 ? -(t8 * t10) : m2 + m6);
        const double t14 = (t5 ? t9 * t10 : m1 + m5);
        const double t15 = m8 * t11 + m9 * t12 - m10 * t13 + m11 * t14;
        const double t16 = t11 * m9 - m8 * t12 + t13 * m11 + m10 * t14;
        const double t17 = m8 * t13 - m9 * t14 + t11 * m10 + t12 * m11;
        out_at[i] = t1;
        out_at[out_step + i] = t2;
        out_at[2 * out_step + i] = t3;
        out_at[3 * out_step + i] = t4;
        out_at[4 * out_step + i] = t1 * t15 - t4 * t16 + t3 * t17;
        out_at[5 * out_step + i] = t4 * t15 + t1 * t16 - t2 * t17;
        out_at[6 * out_step + i] = t2 * t16 - t3 * t15 + t1 * t17;
        out_at[7 * out_step + i] = t2 * t15 + t4 * t17 + t3 * t16;
        out_at[8 * out_step + i] = t11 * t11 + t12 * t12 + t13 * t13 + t14 * t14;
    }
}
