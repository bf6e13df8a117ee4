/* Kernels of the group tangents: adjoint, transform_twist, retract, local.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* adjoint: Adjoint matrix of a motor on twists
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33
 * m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55 */

MOTORCADE_SIMD
void motorcade_adjoint_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m1 * m1;
        const float t1 = m3 * m3;
        const float t2 = m0 * m0;
        const float t3 = m2 * m2;
        const float t4 = m1 * m2;
        const float t5 = m3 * m0;
        const float t6 = t5 * 2.0f;
        const float t7 = m1 * m3;
        const float t8 = m0 * m2;
        const float t9 = t4 * 2.0f;
        const float t10 = t9 - t6;
        const float t11 = m3 * m2;
        const float t12 = m1 * m0;
        const float t13 = t11 + t12;
        const float t14 = 2.0f * (t7 + t8);
        const float t15 = t11 - t12;
        const float t16 = m1 * m4;
        const float t17 = m2 * m5;
        const float t18 = m3 * m6;
        const float t19 = m0 * m7;
        const float t20 = m2 * m4 + m1 * m5;
        const float t21 = m0 * m6;
        const float t22 = m3 * m7;
        const float t23 = m3 * m4;
        const float t24 = m0 * m5;
        const float t25 = m1 * m6;
        const float t26 = m2 * m7;
        const float t27 = t2 - t1;
        const float t28 = m3 * m5;
        const float t29 = m1 * m7;
        const float t30 = m2 * m6;
        const float t31 = m0 * m4;
        out_at[i] = t0 - t1 + t2 - t3;
        out_at[out_step + i] = (t4 + t5) * 2.0f;
        out_at[2 * out_step + i] = 2.0f * t7 - 2.0f * t8;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = 0.0f;
        out_at[5 * out_step + i] = 0.0f;
        out_at[6 * out_step + i] = t10;
        out_at[7 * out_step + i] = -(t1 + (t0 - t3 - t2));
        out_at[8 * out_step + i] = t11 + (t12 + t13);
        out_at[9 * out_step + i] = 0.0f;
        out_at[10 * out_step + i] = 0.0f;
        out_at[11 * out_step + i] = 0.0f;
        out_at[12 * out_step + i] = t14;
        out_at[13 * out_step + i] = t11 + t15 - t12;
        out_at[14 * out_step + i] = t1 + t2 - t3 - t0;
        out_at[15 * out_step + i] = 0.0f;
        out_at[16 * out_step + i] = 0.0f;
        out_at[17 * out_step + i] = 0.0f;
        out_at[18 * out_step + i] = 2.0f * (t16 - t17 - t18 - t19);
        out_at[19 * out_step + i] = 2.0f * (t20 + t21 - t22);
        out_at[20 * out_step + i] = 2.0f * (t23 + (t25 + t26) - t24);
        out_at[21 * out_step + i] = t0 + (t27 - t3);
        out_at[22 * out_step + i] = t6 + t9;
        out_at[23 * out_step + i] = 2.0f * (t7 - t8);
        out_at[24 * out_step + i] = 2.0f * (t20 + t22 - t21);
        out_at[25 * out_step + i] = 2.0f * (t17 - t19 - t18 - t16);
        out_at[26 * out_step + i] = 2.0f * (t28 + (t30 + t31) - t29);
        out_at[27 * out_step + i] = t10;
        out_at[28 * out_step + i] = t3 + t27 - t0;
        out_at[29 * out_step + i] = t12 + (t11 + t13);
        out_at[30 * out_step + i] = 2.0f * (t25 + (t23 + t24) - t26);
        out_at[31 * out_step + i] = 2.0f * t30 + (2.0f * t28 + 2.0f * t29) - 2.0f * t31;
        out_at[32 * out_step + i] = 2.0f * (t18 - t17 - t16 - t19);
        out_at[33 * out_step + i] = t14;
        out_at[34 * out_step + i] = t11 + (t15 - t12);
        out_at[35 * out_step + i] = t1 + (t2 - (t0 + t3));
    }
}

MOTORCADE_SIMD
void motorcade_adjoint_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m1 * m1;
        const double t1 = m3 * m3;
        const double t2 = m0 * m0;
        const double t3 = m2 * m2;
        const double t4 = m1 * m2;
        const double t5 = m3 * m0;
        const double t6 = t5 * 2.0;
        const double t7 = m1 * m3;
        const double t8 = m0 * m2;
        const double t9 = t4 * 2.0;
        const double t10 = t9 - t6;
        const double t11 = m3 * m2;
        const double t12 = m1 * m0;
        const double t13 = t11 + t12;
        const double t14 = 2.0 * (t7 + t8);
        const double t15 = t11 - t12;
        const double t16 = m1 * m4;
        const double t17 = m2 * m5;
        const double t18 = m3 * m6;
        const double t19 = m0 * m7;
        const double t20 = m2 * m4 + m1 * m5;
        const double t21 = m0 * m6;
        const double t22 = m3 * m7;
        const double t23 = m3 * m4;
        const double t24 = m0 * m5;
        const double t25 = m1 * m6;
        const double t26 = m2 * m7;
        const double t27 = t2 - t1;
        const double t28 = m3 * m5;
        const double t29 = m1 * m7;
        const double t30 = m2 * m6;
        const double t31 = m0 * m4;
        out_at[i] = t0 - t1 + t2 - t3;
        out_at[out_step + i] = (t4 + t5) * 2.0;
        out_at[2 * out_step + i] = 2.0 * t7 - 2.0 * t8;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = 0.0;
        out_at[5 * out_step + i] = 0.0;
        out_at[6 * out_step + i] = t10;
        out_at[7 * out_step + i] = -(t1 + (t0 - t3 - t2));
        out_at[8 * out_step + i] = t11 + (t12 + t13);
        out_at[9 * out_step + i] = 0.0;
        out_at[10 * out_step + i] = 0.0;
        out_at[11 * out_step + i] = 0.0;
        out_at[12 * out_step + i] = t14;
        out_at[13 * out_step + i] = t11 + t15 - t12;
        out_at[14 * out_step + i] = t1 + t2 - t3 - t0;
        out_at[15 * out_step + i] = 0.0;
        out_at[16 * out_step + i] = 0.0;
        out_at[17 * out_step + i] = 0.0;
        out_at[18 * out_step + i] = 2.0 * (t16 - t17 - t18 - t19);
        out_at[19 * out_step + i] = 2.0 * (t20 + t21 - t22);
        out_at[20 * out_step + i] = 2.0 * (t23 + (t25 + t26) - t24);
        out_at[21 * out_step + i] = t0 + (t27 - t3);
        out_at[22 * out_step + i] = t6 + t9;
        out_at[23 * out_step + i] = 2.0 * (t7 - t8);
        out_at[24 * out_step + i] = 2.0 * (t20 + t22 - t21);
        out_at[25 * out_step + i] = 2.0 * (t17 - t19 - t18 - t16);
        out_at[26 * out_step + i] = 2.0 * (t28 + (t30 + t31) - t29);
        out_at[27 * out_step + i] = t10;
        out_at[28 * out_step + i] = t3 + t27 - t0;
        out_at[29 * out_step + i] = t12 + (t11 + t13);
        out_at[30 * out_step + i] = 2.0 * (t25 + (t23 + t24) - t26);
        out_at[31 * out_step + i] = 2.0 * t30 + (2.0 * t28 + 2.0 * t29) - 2.0 * t31;
        out_at[32 * out_step + i] = 2.0 * (t18 - t17 - t16 - t19);
        out_at[33 * out_step + i] = t14;
        out_at[34 * out_step + i] = t11 + (t15 - t12);
        out_at[35 * out_step + i] = t1 + (t2 - (t0 + t3));
    }
}

/* transform_twist: A twist seen from the other side of a motor
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in twist: rx ry rz x y z
 * out out: rx ry rz x y z */

MOTORCADE_SIMD
void motorcade_transform_twist_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float t0 = m3 * twist2 + m2 * twist1 + m1 * twist0;
        const float t1 = m3 * twist0 - twist1 * m0 - twist2 * m1;
        const float t2 = twist0 * m0 - twist2 * m2 + m3 * twist1;
        const float t3 = twist2 * m0 - twist1 * m1 + m2 * twist0;
        const float t4 = m0 * twist3 + m3 * twist4 - m2 * twist5 - twist2 * m5 + twist1 * m6 -
            twist0 * m7;
        const float t5 = m0 * twist4 + twist2 * m4 + m1 * twist5 - twist1 * m7 - m3 * twist3 -
            twist0 * m6;
        const float t6 = m0 * twist5 - twist1 * m4 + twist0 * m5 + m2 * twist3 - m1 * twist4 -
            twist2 * m7;
        const float t7 = m3 * twist5 + twist0 * m4 + m1 * twist3 + twist2 * m6 + m2 * twist4 +
            twist1 * m5;
        out_at[i] = m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3;
        out_at[out_step + i] = -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2);
        out_at[2 * out_step + i] = m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1;
        out_at[3 * out_step + i] = t0 * m4 - t3 * m5 - t1 * m6 + m0 * t4 - t2 * m7 + m3 * t5 - m2 *
            t6 + m1 * t7;
        out_at[4 * out_step + i] = t0 * m5 + t1 * m7 - m3 * t4 - t2 * m6 + m0 * t5 + m2 * t7 + t3 *
            m4 + m1 * t6;
        out_at[5 * out_step + i] = t0 * m6 + m2 * t4 - m1 * t5 + m0 * t6 - t3 * m7 + t1 * m4 + t2 *
            m5 + m3 * t7;
    }
}

MOTORCADE_SIMD
void motorcade_transform_twist_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double t0 = m3 * twist2 + m2 * twist1 + m1 * twist0;
        const double t1 = m3 * twist0 - twist1 * m0 - twist2 * m1;
        const double t2 = twist0 * m0 - twist2 * m2 + m3 * twist1;
        const double t3 = twist2 * m0 - twist1 * m1 + m2 * twist0;
        const double t4 = m0 * twist3 + m3 * twist4 - m2 * twist5 - twist2 * m5 + twist1 * m6 -
            twist0 * m7;
        const double t5 = m0 * twist4 + twist2 * m4 + m1 * twist5 - twist1 * m7 - m3 * twist3 -
            twist0 * m6;
        const double t6 = m0 * twist5 - twist1 * m4 + twist0 * m5 + m2 * twist3 - m1 * twist4 -
            twist2 * m7;
        const double t7 = m3 * twist5 + twist0 * m4 + m1 * twist3 + twist2 * m6 + m2 * twist4 +
            twist1 * m5;
        out_at[i] = m1 * t0 - m3 * t1 + m0 * t2 - m2 * t3;
        out_at[out_step + i] = -(m0 * t1 - (m2 * t0 + m1 * t3) + m3 * t2);
        out_at[2 * out_step + i] = m3 * t0 + m0 * t3 + m2 * t2 + m1 * t1;
        out_at[3 * out_step + i] = t0 * m4 - t3 * m5 - t1 * m6 + m0 * t4 - t2 * m7 + m3 * t5 - m2 *
            t6 + m1 * t7;
        out_at[4 * out_step + i] = t0 * m5 + t1 * m7 - m3 * t4 - t2 * m6 + m0 * t5 + m2 * t7 + t3 *
            m4 + m1 * t6;
        out_at[5 * out_step + i] = t0 * m6 + m2 * t4 - m1 * t5 + m0 * t6 - t3 * m7 + t1 * m4 + t2 *
            m5 + m3 * t7;
    }
}

/* retract: A motor moved by a twist in its own frame
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in twist: rx ry rz x y z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_retract_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const float t4 = sqrtf(t3);
        const float t5 = floorf(0.31830987f * t4 + 0.5f);
        const float t6 = 1.0f - 2.0f * (t5 - floorf(0.5f * t5) * 2.0f);
        const float t7 = t4 - t5 * 3.140625f - t5 * 0.0009675026f - t5 * 1.5099067e-07f - t5 *
            5.126688e-12f;
        const float t8 = t7 * t7;
        const float t9 = t8 * (t8 * (t8 * (-2.6050063e-07f * t8 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t10 = t6 * (t8 * (t9 + -0.5f) + 1.0f);
        const _Bool t11 = (t5 < 0.5f);
        const float t12 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t13 = t12 + 1.0f;
        const float t14 = (t11 ? t13 : t13 * (t6 * t7) / largerf(1.0f, t4));
        const float t15 = t0 * t14;
        const float t16 = t1 * t14;
        const float t17 = t2 * t14;
        const float t18 = -0.5f * twist3;
        const float t19 = t8 * (t8 * (t8 * (t8 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f)
            + 0.016666664f);
        const float t20 = -0.5f * twist5;
        const float t21 = -0.5f * twist4;
        const float t22 = 2.0f * (t2 * t18 + (t0 * t20 + t1 * t21));
        const float t23 = (t11 ? t19 + -0.16666667f : (t10 - t14) / (2.0f * largerf(1.0f, t3))) *
            t22;
        const float t24 = t14 * t18 + t2 * t23;
        const float t25 = t14 * t21 + t1 * t23;
        const float t26 = t14 * t20 + t0 * t23;
        const float t27 = t22 * (-0.5f * t14);
        const float t28 = m0 * t24 + m3 * t25 - m2 * t26 + t10 * m4 + m1 * t27 - t15 * m5 + t16 * m6
            - t17 * m7;
        const float t29 = m0 * t25 + m2 * t27 + t15 * m4 + m1 * t26 + t10 * m5 - t16 * m7 - m3 * t24
            - t17 * m6;
        const float t30 = m0 * t26 - t16 * m4 + t17 * m5 + t10 * m6 + m3 * t27 + m2 * t24 - m1 * t25
            - t15 * m7;
        const float t31 = m3 * t26 - m0 * t27 + t17 * m4 + m1 * t24 + t15 * m6 + t10 * m7 + m2 * t25
            + t16 * m5;
        out_at[i] = m0 * t10 - m3 * t15 - m2 * t16 - m1 * t17;
        out_at[out_step + i] = m0 * t17 - t15 * m2 + t10 * m1 + m3 * t16;
        out_at[2 * out_step + i] = t15 * m1 - (m3 * t17 - m0 * t16 - t10 * m2);
        out_at[3 * out_step + i] = m0 * t15 + t10 * m3 - t16 * m1 + m2 * t17;
        out_at[4 * out_step + i] = t28;
        out_at[5 * out_step + i] = t29;
        out_at[6 * out_step + i] = t30;
        out_at[7 * out_step + i] = t31;
    }
}

MOTORCADE_SIMD
void motorcade_retract_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict twist_at = inputs[1];
    const ptrdiff_t twist_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const double t4 = sqrt(t3);
        const double t5 = floor(0.3183098861837907 * t4 + 0.5);
        const double t6 = 1.0 - 2.0 * (t5 - floor(0.5 * t5) * 2.0);
        const double t7 = t4 - t5 * 3.1415926218032837 - t5 * 3.1786509424591713e-08 - t5 *
            1.2246467202362698e-16;
        const double t8 = t7 - t5 * 7.891108333126411e-24;
        const double t9 = t8 * t8;
        const double t10 = t9 * (t9 * (4.608909074888812e-14 * t9 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t11 = t9 * (t9 * (t10 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t12 = t6 * (1.0 + t9 * (t9 * (t9 * t11 + 0.041666666666663875) +
            -0.4999999999999997));
        const _Bool t13 = (t5 < 0.5);
        const double t14 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t15 = t9 * (t9 * (t14 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t16 = 1.0 + t9 * (t9 * (t9 * t15 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t17 = (t13 ? t16 : t16 * (t6 * t8) / larger(1.0, t4));
        const double t18 = t0 * t17;
        const double t19 = t1 * t17;
        const double t20 = t2 * t17;
        const double t21 = -0.5 * twist3;
        const double t22 = t9 * (t9 * (t9 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10);
        const double t23 = t9 * (t9 * (t22 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574;
        const double t24 = (t13 ? -0.16666666666666666 + t9 * (t9 * t23 + 0.01666666666666651) :
            (t12 - t17) / (2.0 * larger(1.0, t3)));
        const double t25 = -0.5 * twist5;
        const double t26 = -0.5 * twist4;
        const double t27 = 2.0 * (t2 * t21 + (t0 * t25 + t1 * t26));
        const double t28 = t24 * t27;
        const double t29 = t17 * t21 + t2 * t28;
        const double t30 = t17 * t26 + t1 * t28;
        const double t31 = t17 * t25 + t0 * t28;
        const double t32 = t27 * (-0.5 * t17);
        const double t33 = m0 * t29 + m3 * t30 - m2 * t31 + t12 * m4 + m1 * t32 - t18 * m5 + t19 *
            m6 - t20 * m7;
        const double t34 = m0 * t30 + m2 * t32 + t18 * m4 + m1 * t31 + t12 * m5 - t19 * m7 - m3 *
            t29 - t20 * m6;
        const double t35 = m0 * t31 - t19 * m4 + t20 * m5 + t12 * m6 + m3 * t32 + m2 * t29 - m1 *
            t30 - t18 * m7;
        const double t36 = m3 * t31 - m0 * t32 + t20 * m4 + m1 * t29 + t18 * m6 + t12 * m7 + m2 *
            t30 + t19 * m5;
        out_at[i] = m0 * t12 - m3 * t18 - m2 * t19 - m1 * t20;
        out_at[out_step + i] = m0 * t20 - t18 * m2 + t12 * m1 + m3 * t19;
        out_at[2 * out_step + i] = t18 * m1 - (m3 * t20 - m0 * t19 - t12 * m2);
        out_at[3 * out_step + i] = m0 * t18 + t12 * m3 - t19 * m1 + m2 * t20;
        out_at[4 * out_step + i] = t33;
        out_at[5 * out_step + i] = t34;
        out_at[6 * out_step + i] = t35;
        out_at[7 * out_step + i] = t36;
    }
}

/* local: The twist, turning by at most π, that takes motor a to b
 * in a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out: rx ry rz x y z */

MOTORCADE_SIMD
void motorcade_local_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = -2.0f * (t5 * t6);
        out_at[out_step + i] = -(-2.0f * (t5 * t7));
        out_at[2 * out_step + i] = -2.0f * (t5 * t8);
        out_at[3 * out_step + i] = -2.0f * (t9 + t6 * t12);
        out_at[4 * out_step + i] = -2.0f * (t13 - t7 * t12);
        out_at[5 * out_step + i] = -2.0f * (t14 + t8 * t12);
    }
}

MOTORCADE_SIMD
void motorcade_local_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = -2.0 * (t10 * t11);
        out_at[out_step + i] = -(-2.0 * (t10 * t12));
        out_at[2 * out_step + i] = -2.0 * (t10 * t13);
        out_at[3 * out_step + i] = -2.0 * (t14 + t11 * t23);
        out_at[4 * out_step + i] = -2.0 * (t24 - t12 * t23);
        out_at[5 * out_step + i] = -2.0 * (t25 + t13 * t23);
    }
}
