/* Kernels of the group similarity_conversions: similarity_matrix34, similarity_matrix44,
 * rotor_translation_scale, similarity_of_motor.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_matrix34: 3×4 matrix of a similarity, by rows
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 */

MOTORCADE_SIMD
void motorcade_similarity_matrix34_f32(MOTORCADE_ARGUMENTS(float))
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
        const _Bool t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0f);
        const float t1 = m0 - m4;
        const float t2 = m3 - m7;
        const float t3 = m6 - m2;
        const float t4 = m1 - m5;
        const float t5 = 1.0f / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const float t6 = (t0 ? t1 * t5 : m0 + m4);
        const float t7 = t6 * t6;
        const float t8 = (t0 ? t2 * t5 : m3 + m7);
        const float t9 = t8 * t8;
        const float t10 = t7 - t9;
        const float t11 = (t0 ? -(t3 * t5) : m2 + m6);
        const float t12 = t11 * t11;
        const float t13 = (t0 ? t4 * t5 : m1 + m5);
        const float t14 = t13 * t13;
        const float t15 = t6 * t8 * 2.0f;
        const float t16 = 2.0f * (t11 * t13);
        const float t17 = t8 * t13;
        const float t18 = t6 * t11;
        const float t19 = t8 * t11;
        const float t20 = t6 * t13;
        out_at[i] = t10 - t12 + t14;
        out_at[out_step + i] = t15 + t16;
        out_at[2 * out_step + i] = 2.0f * (t17 - t18);
        out_at[3 * out_step + i] = -2.0f * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11);
        out_at[4 * out_step + i] = t16 - t15;
        out_at[5 * out_step + i] = t10 + t12 - t14;
        out_at[6 * out_step + i] = 2.0f * (t19 + t20);
        out_at[7 * out_step + i] = -2.0f * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10);
        out_at[8 * out_step + i] = 2.0f * (t17 + t18);
        out_at[9 * out_step + i] = 2.0f * (t19 - t20);
        out_at[10 * out_step + i] = t9 + (t7 - (t12 + t14));
        out_at[11 * out_step + i] = -2.0f * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_matrix34_f64(MOTORCADE_ARGUMENTS(double))
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
        const _Bool t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0);
        const double t1 = m0 - m4;
        const double t2 = m3 - m7;
        const double t3 = m6 - m2;
        const double t4 = m1 - m5;
        const double t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const double t6 = (t0 ? t1 * t5 : m0 + m4);
        const double t7 = t6 * t6;
        const double t8 = (t0 ? t2 * t5 : m3 + m7);
        const double t9 = t8 * t8;
        const double t10 = t7 - t9;
        const double t11 = (t0 ? -(t3 * t5) : m2 + m6);
        const double t12 = t11 * t11;
        const double t13 = (t0 ? t4 * t5 : m1 + m5);
        const double t14 = t13 * t13;
        const double t15 = t6 * t8 * 2.0;
        const double t16 = 2.0 * (t11 * t13);
        const double t17 = t8 * t13;
        const double t18 = t6 * t11;
        const double t19 = t8 * t11;
        const double t20 = t6 * t13;
        out_at[i] = t10 - t12 + t14;
        out_at[out_step + i] = t15 + t16;
        out_at[2 * out_step + i] = 2.0 * (t17 - t18);
        out_at[3 * out_step + i] = -2.0 * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11);
        out_at[4 * out_step + i] = t16 - t15;
        out_at[5 * out_step + i] = t10 + t12 - t14;
        out_at[6 * out_step + i] = 2.0 * (t19 + t20);
        out_at[7 * out_step + i] = -2.0 * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10);
        out_at[8 * out_step + i] = 2.0 * (t17 + t18);
        out_at[9 * out_step + i] = 2.0 * (t19 - t20);
        out_at[10 * out_step + i] = t9 + (t7 - (t12 + t14));
        out_at[11 * out_step + i] = -2.0 * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11);
    }
}

/* similarity_matrix44: 4×4 matrix of a similarity, by rows
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 m30 m31 m32 m33 */

MOTORCADE_SIMD
void motorcade_similarity_matrix44_f32(MOTORCADE_ARGUMENTS(float))
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
        const _Bool t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0f);
        const float t1 = m0 - m4;
        const float t2 = m3 - m7;
        const float t3 = m6 - m2;
        const float t4 = m1 - m5;
        const float t5 = 1.0f / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const float t6 = (t0 ? t1 * t5 : m0 + m4);
        const float t7 = t6 * t6;
        const float t8 = (t0 ? t2 * t5 : m3 + m7);
        const float t9 = t8 * t8;
        const float t10 = t7 - t9;
        const float t11 = (t0 ? -(t3 * t5) : m2 + m6);
        const float t12 = t11 * t11;
        const float t13 = (t0 ? t4 * t5 : m1 + m5);
        const float t14 = t13 * t13;
        const float t15 = t6 * t8 * 2.0f;
        const float t16 = 2.0f * (t11 * t13);
        const float t17 = t8 * t13;
        const float t18 = t6 * t11;
        const float t19 = t8 * t11;
        const float t20 = t6 * t13;
        out_at[i] = t10 - t12 + t14;
        out_at[out_step + i] = t15 + t16;
        out_at[2 * out_step + i] = 2.0f * (t17 - t18);
        out_at[3 * out_step + i] = -2.0f * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11);
        out_at[4 * out_step + i] = t16 - t15;
        out_at[5 * out_step + i] = t10 + t12 - t14;
        out_at[6 * out_step + i] = 2.0f * (t19 + t20);
        out_at[7 * out_step + i] = -2.0f * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10);
        out_at[8 * out_step + i] = 2.0f * (t17 + t18);
        out_at[9 * out_step + i] = 2.0f * (t19 - t20);
        out_at[10 * out_step + i] = t9 + (t7 - (t12 + t14));
        out_at[11 * out_step + i] = -2.0f * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11);
        out_at[12 * out_step + i] = 0.0f;
        out_at[13 * out_step + i] = 0.0f;
        out_at[14 * out_step + i] = 0.0f;
        out_at[15 * out_step + i] = 1.0f;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_matrix44_f64(MOTORCADE_ARGUMENTS(double))
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
        const _Bool t0 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0);
        const double t1 = m0 - m4;
        const double t2 = m3 - m7;
        const double t3 = m6 - m2;
        const double t4 = m1 - m5;
        const double t5 = 1.0 / (t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const double t6 = (t0 ? t1 * t5 : m0 + m4);
        const double t7 = t6 * t6;
        const double t8 = (t0 ? t2 * t5 : m3 + m7);
        const double t9 = t8 * t8;
        const double t10 = t7 - t9;
        const double t11 = (t0 ? -(t3 * t5) : m2 + m6);
        const double t12 = t11 * t11;
        const double t13 = (t0 ? t4 * t5 : m1 + m5);
        const double t14 = t13 * t13;
        const double t15 = t6 * t8 * 2.0;
        const double t16 = 2.0 * (t11 * t13);
        const double t17 = t8 * t13;
        const double t18 = t6 * t11;
        const double t19 = t8 * t11;
        const double t20 = t6 * t13;
        out_at[i] = t10 - t12 + t14;
        out_at[out_step + i] = t15 + t16;
        out_at[2 * out_step + i] = 2.0 * (t17 - t18);
        out_at[3 * out_step + i] = -2.0 * (t6 * m8 + t8 * m9 - t11 * m10 + t13 * m11);
        out_at[4 * out_step + i] = t16 - t15;
        out_at[5 * out_step + i] = t10 + t12 - t14;
        out_at[6 * out_step + i] = 2.0 * (t19 + t20);
        out_at[7 * out_step + i] = -2.0 * (t6 * m9 - t8 * m8 + t11 * m11 + t13 * m10);
        out_at[8 * out_step + i] = 2.0 * (t17 + t18);
        out_at[9 * out_step + i] = 2.0 * (t19 - t20);
        out_at[10 * out_step + i] = t9 + (t7 - (t12 + t14));
        out_at[11 * out_step + i] = -2.0 * (t11 * m8 - t13 * m9 + t6 * m10 + t8 * m11);
        out_at[12 * out_step + i] = 0.0;
        out_at[13 * out_step + i] = 0.0;
        out_at[14 * out_step + i] = 0.0;
        out_at[15 * out_step + i] = 1.0;
    }
}

/* rotor_translation_scale: Rotor, translation and scale of a similarity
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 x y z scale */

MOTORCADE_SIMD
void motorcade_rotor_translation_scale_f32(MOTORCADE_ARGUMENTS(float))
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
        const _Bool t1 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0f);
        const float t2 = m0 - m4;
        const float t3 = m3 - m7;
        const float t4 = m6 - m2;
        const float t5 = m1 - m5;
        const float t6 = 1.0f / (t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        const float t7 = (t1 ? t2 * t6 : m0 + m4);
        const float t8 = (t1 ? t3 * t6 : m3 + m7);
        const float t9 = (t1 ? -(t4 * t6) : m2 + m6);
        const float t10 = (t1 ? t5 * t6 : m1 + m5);
        out_at[i] = m0 * t0;
        out_at[out_step + i] = m1 * t0;
        out_at[2 * out_step + i] = m2 * t0;
        out_at[3 * out_step + i] = m3 * t0;
        out_at[4 * out_step + i] = -2.0f * (m8 * t7 + m9 * t8 - m10 * t9 + m11 * t10);
        out_at[5 * out_step + i] = -2.0f * (t7 * m9 - m8 * t8 + t9 * m11 + m10 * t10);
        out_at[6 * out_step + i] = -2.0f * (m8 * t9 - m9 * t10 + t7 * m10 + t8 * m11);
        out_at[7 * out_step + i] = t7 * t7 + t8 * t8 + t9 * t9 + t10 * t10;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_translation_scale_f64(MOTORCADE_ARGUMENTS(double))
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
        const _Bool t1 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < 0.0);
        const double t2 = m0 - m4;
        const double t3 = m3 - m7;
        const double t4 = m6 - m2;
        const double t5 = m1 - m5;
        const double t6 = 1.0 / (t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        const double t7 = (t1 ? t2 * t6 : m0 + m4);
        const double t8 = (t1 ? t3 * t6 : m3 + m7);
        const double t9 = (t1 ? -(t4 * t6) : m2 + m6);
        const double t10 = (t1 ? t5 * t6 : m1 + m5);
        out_at[i] = m0 * t0;
        out_at[out_step + i] = m1 * t0;
        out_at[2 * out_step + i] = m2 * t0;
        out_at[3 * out_step + i] = m3 * t0;
        out_at[4 * out_step + i] = -2.0 * (m8 * t7 + m9 * t8 - m10 * t9 + m11 * t10);
        out_at[5 * out_step + i] = -2.0 * (t7 * m9 - m8 * t8 + t9 * m11 + m10 * t10);
        out_at[6 * out_step + i] = -2.0 * (m8 * t9 - m9 * t10 + t7 * m10 + t8 * m11);
        out_at[7 * out_step + i] = t7 * t7 + t8 * t8 + t9 * t9 + t10 * t10;
    }
}

/* similarity_of_motor: Motor after growth about the origin by a scale
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in scale: scale
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_of_motor_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict scale_at = inputs[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float scale = scale_at[i];
        const float t0 = 1.0f / sqrtf(scale);
        const float t1 = 0.5f * t0;
        const float t2 = (scale + 1.0f) * t1;
        const float t3 = t1 * (scale - 1.0f);
        out_at[i] = m0 * t2;
        out_at[out_step + i] = t2 * m1;
        out_at[2 * out_step + i] = t2 * m2;
        out_at[3 * out_step + i] = t2 * m3;
        out_at[4 * out_step + i] = m0 * t3;
        out_at[5 * out_step + i] = m1 * t3;
        out_at[6 * out_step + i] = m2 * t3;
        out_at[7 * out_step + i] = m3 * t3;
        out_at[8 * out_step + i] = t0 * m4;
        out_at[9 * out_step + i] = t0 * m5;
        out_at[10 * out_step + i] = t0 * m6;
        out_at[11 * out_step + i] = t0 * m7;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_of_motor_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict scale_at = inputs[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double scale = scale_at[i];
        const double t0 = 1.0 / sqrt(scale);
        const double t1 = 0.5 * t0;
        const double t2 = (scale + 1.0) * t1;
        const double t3 = t1 * (scale - 1.0);
        out_at[i] = m0 * t2;
        out_at[out_step + i] = t2 * m1;
        out_at[2 * out_step + i] = t2 * m2;
        out_at[3 * out_step + i] = t2 * m3;
        out_at[4 * out_step + i] = m0 * t3;
        out_at[5 * out_step + i] = m1 * t3;
        out_at[6 * out_step + i] = m2 * t3;
        out_at[7 * out_step + i] = m3 * t3;
        out_at[8 * out_step + i] = t0 * m4;
        out_at[9 * out_step + i] = t0 * m5;
        out_at[10 * out_step + i] = t0 * m6;
        out_at[11 * out_step + i] = t0 * m7;
    }
}
