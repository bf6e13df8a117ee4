/* Kernels of the group similarity_tangents: similarity_adjoint, similarity_transform_twist,
 * similarity_retract, similarity_local.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_adjoint: Adjoint matrix of a similarity on twists
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: m00 m01 m02 m03 m04 m05 m06 m10 m11 m12 m13 m14 m15 m16 m20 m21 m22 m23 m24 m25 m26 m30
 * m31 m32 m33 m34 m35 m36 m40 m41 m42 m43 m44 m45 m46 m50 m51 m52 m53 m54 m55 m56 m60 m61 m62 m63
 * m64 m65 m66 */

MOTORCADE_SIMD
void motorcade_similarity_adjoint_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = m1 + m5;
        const float t1 = m1 - m5;
        const float t2 = t0 * t1;
        const float t3 = m3 + m7;
        const float t4 = m3 - m7;
        const float t5 = t3 * t4;
        const float t6 = m0 + m4;
        const float t7 = m0 - m4;
        const float t8 = t6 * t7;
        const float t9 = m2 + m6;
        const float t10 = m6 - m2;
        const float t11 = t9 * t10;
        const float t12 = t1 * t9;
        const float t13 = t4 * t6;
        const float t14 = t3 * t7;
        const float t15 = t0 * t10;
        const float t16 = t1 * t3;
        const float t17 = t0 * t4;
        const float t18 = t7 * t9;
        const float t19 = t6 * t10;
        const float t20 = t3 * t10;
        const float t21 = t1 * t6;
        const float t22 = t0 * t7;
        const float t23 = t4 * t9;
        const float t24 = t0 * m8;
        const float t25 = t9 * m9;
        const float t26 = t3 * m10;
        const float t27 = t6 * m11;
        const float t28 = t26 + t27;
        const float t29 = t24 * 2.0f;
        const float t30 = t25 * 2.0f;
        const float t31 = t9 * m8;
        const float t32 = t0 * m9;
        const float t33 = t31 + t32;
        const float t34 = t6 * m10;
        const float t35 = t3 * m11;
        const float t36 = t3 * m8;
        const float t37 = t6 * m9;
        const float t38 = t0 * m10;
        const float t39 = t9 * m11;
        const float t40 = t6 * t6;
        const float t41 = t3 * t3;
        const float t42 = t40 - t41;
        const float t43 = t9 * t9;
        const float t44 = t0 * t0;
        const float t45 = 2.0f * (t3 * t6);
        const float t46 = 2.0f * (t0 * t9);
        const float t47 = t0 * t3;
        const float t48 = t6 * t9;
        const float t49 = t9 * m10;
        const float t50 = t6 * m8;
        const float t51 = t3 * m9;
        const float t52 = t50 + t51;
        const float t53 = t0 * m11;
        const float t54 = t3 * t9;
        const float t55 = t0 * t6;
        out_at[i] = t2 - t5 + t8 + t11;
        out_at[out_step + i] = t12 + t13 + t14 - t15;
        out_at[2 * out_step + i] = t16 + t17 - t18 + t19;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = 0.0f;
        out_at[5 * out_step + i] = 0.0f;
        out_at[6 * out_step + i] = 0.0f;
        out_at[7 * out_step + i] = -(t13 + (t14 + (t15 - t12)));
        out_at[8 * out_step + i] = -(t5 + (t2 + t11 - t8));
        out_at[9 * out_step + i] = t23 - (t20 - t21 - t22);
        out_at[10 * out_step + i] = 0.0f;
        out_at[11 * out_step + i] = 0.0f;
        out_at[12 * out_step + i] = 0.0f;
        out_at[13 * out_step + i] = 0.0f;
        out_at[14 * out_step + i] = t16 + (t17 + t18 - t19);
        out_at[15 * out_step + i] = t23 - t22 - t20 - t21;
        out_at[16 * out_step + i] = t11 + (t5 + t8) - t2;
        out_at[17 * out_step + i] = 0.0f;
        out_at[18 * out_step + i] = 0.0f;
        out_at[19 * out_step + i] = 0.0f;
        out_at[20 * out_step + i] = 0.0f;
        out_at[21 * out_step + i] = t29 - t30 - t26 - t27 - t28;
        out_at[22 * out_step + i] = 2.0f * (t33 + t34 - t35);
        out_at[23 * out_step + i] = 2.0f * (t36 - t37 + t38 + t39);
        out_at[24 * out_step + i] = t42 - t43 + t44;
        out_at[25 * out_step + i] = t45 + t46;
        out_at[26 * out_step + i] = 2.0f * (t47 - t48);
        out_at[27 * out_step + i] = 2.0f * (t52 + t53 - t49);
        out_at[28 * out_step + i] = 2.0f * (t33 + t35 - t34);
        out_at[29 * out_step + i] = t30 - t27 - t26 - t29 - t28;
        out_at[30 * out_step + i] = t52 + (t51 + (t50 + 2.0f * t49) - 2.0f * t53);
        out_at[31 * out_step + i] = t46 - t45;
        out_at[32 * out_step + i] = t42 + t43 - t44;
        out_at[33 * out_step + i] = 2.0f * (t54 + t55);
        out_at[34 * out_step + i] = 2.0f * (t37 + (t38 + t39) - t36);
        out_at[35 * out_step + i] = 2.0f * (t38 - t39 + (t36 + t37));
        out_at[36 * out_step + i] = 2.0f * (t51 + (t49 + t53 - t50));
        out_at[37 * out_step + i] = 2.0f * (t26 - t27 - t24 - t25);
        out_at[38 * out_step + i] = 2.0f * (t47 + t48);
        out_at[39 * out_step + i] = 2.0f * (t54 - t55);
        out_at[40 * out_step + i] = t41 + (t40 - (t43 + t44));
        out_at[41 * out_step + i] = 2.0f * (t31 + (t34 + t35) - t32);
        out_at[42 * out_step + i] = 0.0f;
        out_at[43 * out_step + i] = 0.0f;
        out_at[44 * out_step + i] = 0.0f;
        out_at[45 * out_step + i] = 0.0f;
        out_at[46 * out_step + i] = 0.0f;
        out_at[47 * out_step + i] = 0.0f;
        out_at[48 * out_step + i] = 1.0f;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_adjoint_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = m1 + m5;
        const double t1 = m1 - m5;
        const double t2 = t0 * t1;
        const double t3 = m3 + m7;
        const double t4 = m3 - m7;
        const double t5 = t3 * t4;
        const double t6 = m0 + m4;
        const double t7 = m0 - m4;
        const double t8 = t6 * t7;
        const double t9 = m2 + m6;
        const double t10 = m6 - m2;
        const double t11 = t9 * t10;
        const double t12 = t1 * t9;
        const double t13 = t4 * t6;
        const double t14 = t3 * t7;
        const double t15 = t0 * t10;
        const double t16 = t1 * t3;
        const double t17 = t0 * t4;
        const double t18 = t7 * t9;
        const double t19 = t6 * t10;
        const double t20 = t3 * t10;
        const double t21 = t1 * t6;
        const double t22 = t0 * t7;
        const double t23 = t4 * t9;
        const double t24 = t0 * m8;
        const double t25 = t9 * m9;
        const double t26 = t3 * m10;
        const double t27 = t6 * m11;
        const double t28 = t26 + t27;
        const double t29 = t24 * 2.0;
        const double t30 = t25 * 2.0;
        const double t31 = t9 * m8;
        const double t32 = t0 * m9;
        const double t33 = t31 + t32;
        const double t34 = t6 * m10;
        const double t35 = t3 * m11;
        const double t36 = t3 * m8;
        const double t37 = t6 * m9;
        const double t38 = t0 * m10;
        const double t39 = t9 * m11;
        const double t40 = t6 * t6;
        const double t41 = t3 * t3;
        const double t42 = t40 - t41;
        const double t43 = t9 * t9;
        const double t44 = t0 * t0;
        const double t45 = 2.0 * (t3 * t6);
        const double t46 = 2.0 * (t0 * t9);
        const double t47 = t0 * t3;
        const double t48 = t6 * t9;
        const double t49 = t9 * m10;
        const double t50 = t6 * m8;
        const double t51 = t3 * m9;
        const double t52 = t50 + t51;
        const double t53 = t0 * m11;
        const double t54 = t3 * t9;
        const double t55 = t0 * t6;
        out_at[i] = t2 - t5 + t8 + t11;
        out_at[out_step + i] = t12 + t13 + t14 - t15;
        out_at[2 * out_step + i] = t16 + t17 - t18 + t19;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = 0.0;
        out_at[5 * out_step + i] = 0.0;
        out_at[6 * out_step + i] = 0.0;
        out_at[7 * out_step + i] = -(t13 + (t14 + (t15 - t12)));
        out_at[8 * out_step + i] = -(t5 + (t2 + t11 - t8));
        out_at[9 * out_step + i] = t23 - (t20 - t21 - t22);
        out_at[10 * out_step + i] = 0.0;
        out_at[11 * out_step + i] = 0.0;
        out_at[12 * out_step + i] = 0.0;
        out_at[13 * out_step + i] = 0.0;
        out_at[14 * out_step + i] = t16 + (t17 + t18 - t19);
        out_at[15 * out_step + i] = t23 - t22 - t20 - t21;
        out_at[16 * out_step + i] = t11 + (t5 + t8) - t2;
        out_at[17 * out_step + i] = 0.0;
        out_at[18 * out_step + i] = 0.0;
        out_at[19 * out_step + i] = 0.0;
        out_at[20 * out_step + i] = 0.0;
        out_at[21 * out_step + i] = t29 - t30 - t26 - t27 - t28;
        out_at[22 * out_step + i] = 2.0 * (t33 + t34 - t35);
        out_at[23 * out_step + i] = 2.0 * (t36 - t37 + t38 + t39);
        out_at[24 * out_step + i] = t42 - t43 + t44;
        out_at[25 * out_step + i] = t45 + t46;
        out_at[26 * out_step + i] = 2.0 * (t47 - t48);
        out_at[27 * out_step + i] = 2.0 * (t52 + t53 - t49);
        out_at[28 * out_step + i] = 2.0 * (t33 + t35 - t34);
        out_at[29 * out_step + i] = t30 - t27 - t26 - t29 - t28;
        out_at[30 * out_step + i] = t52 + (t51 + (t50 + 2.0 * t49) - 2.0 * t53);
        out_at[31 * out_step + i] = t46 - t45;
        out_at[32 * out_step + i] = t42 + t43 - t44;
        out_at[33 * out_step + i] = 2.0 * (t54 + t55);
        out_at[34 * out_step + i] = 2.0 * (t37 + (t38 + t39) - t36);
        out_at[35 * out_step + i] = 2.0 * (t38 - t39 + (t36 + t37));
        out_at[36 * out_step + i] = 2.0 * (t51 + (t49 + t53 - t50));
        out_at[37 * out_step + i] = 2.0 * (t26 - t27 - t24 - t25);
        out_at[38 * out_step + i] = 2.0 * (t47 + t48);
        out_at[39 * out_step + i] = 2.0 * (t54 - t55);
        out_at[40 * out_step + i] = t41 + (t40 - (t43 + t44));
        out_at[41 * out_step + i] = 2.0 * (t31 + (t34 + t35) - t32);
        out_at[42 * out_step + i] = 0.0;
        out_at[43 * out_step + i] = 0.0;
        out_at[44 * out_step + i] = 0.0;
        out_at[45 * out_step + i] = 0.0;
        out_at[46 * out_step + i] = 0.0;
        out_at[47 * out_step + i] = 0.0;
        out_at[48 * out_step + i] = 1.0;
    }
}

/* similarity_transform_twist: A twist seen from the other side of a similarity
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in twist: rx ry rz x y z log_scale
 * out out: rx ry rz x y z log_scale */

MOTORCADE_SIMD
void motorcade_similarity_transform_twist_f32(MOTORCADE_ARGUMENTS(float))
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
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float twist6 = twist_at[6 * twist_step + i];
        const float t0 = m3 + m7;
        const float t1 = m2 + m6;
        const float t2 = m1 + m5;
        const float t3 = t0 * twist2 + t1 * twist1 + t2 * twist0;
        const float t4 = m1 - m5;
        const float t5 = m0 + m4;
        const float t6 = t0 * twist0 - twist1 * t5 - twist2 * t2;
        const float t7 = m3 - m7;
        const float t8 = twist0 * t5 - twist2 * t1 + t0 * twist1;
        const float t9 = m0 - m4;
        const float t10 = twist2 * t5 - twist1 * t2 + t1 * twist0;
        const float t11 = m6 - m2;
        const float t12 = twist1 * m10 - twist2 * m9 - twist0 * m11;
        const float t13 = twist2 * m8 - twist1 * m11 - twist0 * m10;
        const float t14 = twist0 * m9 - twist1 * m8 - twist2 * m11;
        const float t15 = twist0 * m8 + twist2 * m10 + twist1 * m9;
        const float t16 = t3 * m8 - t10 * m9 - t6 * m10 - t8 * m11 + (t5 * t12 + t0 * t13 - t1 * t14
            + t2 * t15);
        const float t17 = t5 * twist3 + t0 * twist4 - t1 * twist5;
        const float t18 = t5 * twist4 + t2 * twist5 - t0 * twist3;
        const float t19 = t5 * twist5 + t1 * twist3 - t2 * twist4;
        const float t20 = t0 * twist5 + t2 * twist3 + t1 * twist4;
        const float t21 = t16 + (t5 * t17 + t0 * t18 - t1 * t19 + t2 * t20) - (t1 * m10 - (t5 * m8 +
            t0 * m9) - t2 * m11) * 2.0f * twist6;
        const float t22 = t3 * m9 + t6 * m11 - t8 * m10 + t10 * m8 + (t5 * t13 - t0 * t12 + t1 * t15
            + t2 * t14);
        const float t23 = t22 + (t5 * t18 - t0 * t17 + t1 * t20 + t2 * t19) - twist6 * (2.0f * (t0 *
            m8 - t5 * m9 - t1 * m11 - t2 * m10));
        const float t24 = t3 * m10 - t10 * m11 + t6 * m8 + t8 * m9 + (t1 * t12 - t2 * t13 + t5 * t14
            + t0 * t15);
        const float t25 = t24 + (t1 * t17 - t2 * t18 + t5 * t19 + t0 * t20) - twist6 * (2.0f * (t2 *
            m9 - t5 * m10 - t0 * m11 - t1 * m8));
        out_at[i] = t3 * t4 - t6 * t7 + t8 * t9 + t10 * t11;
        out_at[out_step + i] = -(t3 * t11 - t4 * t10 + t6 * t9 + t7 * t8);
        out_at[2 * out_step + i] = t3 * t7 + t9 * t10 - t8 * t11 + t4 * t6;
        out_at[3 * out_step + i] = t21;
        out_at[4 * out_step + i] = t23;
        out_at[5 * out_step + i] = t25;
        out_at[6 * out_step + i] = twist6;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_transform_twist_f64(MOTORCADE_ARGUMENTS(double))
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
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double twist6 = twist_at[6 * twist_step + i];
        const double t0 = m3 + m7;
        const double t1 = m2 + m6;
        const double t2 = m1 + m5;
        const double t3 = t0 * twist2 + t1 * twist1 + t2 * twist0;
        const double t4 = m1 - m5;
        const double t5 = m0 + m4;
        const double t6 = t0 * twist0 - twist1 * t5 - twist2 * t2;
        const double t7 = m3 - m7;
        const double t8 = twist0 * t5 - twist2 * t1 + t0 * twist1;
        const double t9 = m0 - m4;
        const double t10 = twist2 * t5 - twist1 * t2 + t1 * twist0;
        const double t11 = m6 - m2;
        const double t12 = twist1 * m10 - twist2 * m9 - twist0 * m11;
        const double t13 = twist2 * m8 - twist1 * m11 - twist0 * m10;
        const double t14 = twist0 * m9 - twist1 * m8 - twist2 * m11;
        const double t15 = twist0 * m8 + twist2 * m10 + twist1 * m9;
        const double t16 = t3 * m8 - t10 * m9 - t6 * m10 - t8 * m11 + (t5 * t12 + t0 * t13 - t1 *
            t14 + t2 * t15);
        const double t17 = t5 * twist3 + t0 * twist4 - t1 * twist5;
        const double t18 = t5 * twist4 + t2 * twist5 - t0 * twist3;
        const double t19 = t5 * twist5 + t1 * twist3 - t2 * twist4;
        const double t20 = t0 * twist5 + t2 * twist3 + t1 * twist4;
        const double t21 = t16 + (t5 * t17 + t0 * t18 - t1 * t19 + t2 * t20) - (t1 * m10 - (t5 * m8
            + t0 * m9) - t2 * m11) * 2.0 * twist6;
        const double t22 = t3 * m9 + t6 * m11 - t8 * m10 + t10 * m8 + (t5 * t13 - t0 * t12 + t1 *
            t15 + t2 * t14);
        const double t23 = t22 + (t5 * t18 - t0 * t17 + t1 * t20 + t2 * t19) - twist6 * (2.0 * (t0 *
            m8 - t5 * m9 - t1 * m11 - t2 * m10));
        const double t24 = t3 * m10 - t10 * m11 + t6 * m8 + t8 * m9 + (t1 * t12 - t2 * t13 + t5 *
            t14 + t0 * t15);
        const double t25 = t24 + (t1 * t17 - t2 * t18 + t5 * t19 + t0 * t20) - twist6 * (2.0 * (t2 *
            m9 - t5 * m10 - t0 * m11 - t1 * m8));
        out_at[i] = t3 * t4 - t6 * t7 + t8 * t9 + t10 * t11;
        out_at[out_step + i] = -(t3 * t11 - t4 * t10 + t6 * t9 + t7 * t8);
        out_at[2 * out_step + i] = t3 * t7 + t9 * t10 - t8 * t11 + t4 * t6;
        out_at[3 * out_step + i] = t21;
        out_at[4 * out_step + i] = t23;
        out_at[5 * out_step + i] = t25;
        out_at[6 * out_step + i] = twist6;
    }
}

/* similarity_retract: A similarity moved by a twist in its own frame
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in twist: rx ry rz x y z log_scale
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_retract_f32(MOTORCADE_ARGUMENTS(float))
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
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float twist6 = twist_at[6 * twist_step + i];
        const float t0 = -0.5f * twist0;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist2;
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
        const float t11 = floorf(0.5f + 0.7213475f * twist6);
        const float t12 = exp2_of_integerf(t11);
        const float t13 = exp2_of_integerf(-t11);
        const float t14 = 0.5f * (t12 + t13);
        const float t15 = 0.5f * twist6;
        const float t16 = t15 - t11 * 0.69311523f - t11 * 3.1946183e-05f;
        const float t17 = t16 * t16;
        const float t18 = t17 * (t17 * (0.0013949076f * t17 + 0.04166621f) + 0.5f) + 1.0f;
        const float t19 = 0.5f * (t12 - t13);
        const float t20 = t17 * (t17 * (t17 * 0.00019908122f + 0.008333283f) + 0.16666667f) + 1.0f;
        const float t21 = t16 * t20;
        const float t22 = t14 * t18 + t19 * t21;
        const float t23 = t10 * t22;
        const float t24 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t25 = t24 + 1.0f;
        const float t26 = ((t5 < 0.5f) ? t25 : t25 * (t6 * t7) / largerf(1.0f, t4));
        const float t27 = t2 * t26;
        const float t28 = t22 * t27;
        const float t29 = t1 * t26;
        const float t30 = t22 * t29;
        const float t31 = t0 * t26;
        const float t32 = t22 * t31;
        const float t33 = t18 * t19 + t14 * t21;
        const float t34 = t10 * t33;
        const float t35 = t27 * t33;
        const float t36 = t29 * t33;
        const float t37 = t31 * t33;
        const float t38 = m0 * t23 - m3 * t28 - m2 * t30 - m1 * t32 + (m4 * t34 - m7 * t35 - m6 *
            t36 - m5 * t37);
        const float t39 = m0 * t32 - t28 * m2 + t23 * m1 + m3 * t30 + (m4 * t37 - t35 * m6 + t34 *
            m5 + m7 * t36);
        const float t40 = m3 * t32 - m0 * t30 - t23 * m2 - t28 * m1 + (m7 * t37 - m4 * t36 - t34 *
            m6 - t35 * m5);
        const float t41 = m0 * t28 + t23 * m3 - t30 * m1 + m2 * t32 + (m4 * t35 + t34 * m7 - t36 *
            m5 + m6 * t37);
        const float t42 = m0 * t34 - m3 * t35 - m2 * t36 - m1 * t37 + (t23 * m4 - t28 * m7 - t30 *
            m6 - t32 * m5);
        const float t43 = m0 * t37 - m2 * t35 + m1 * t34 + m3 * t36 + (t32 * m4 - t28 * m6 + t23 *
            m5 + t30 * m7);
        const float t44 = m3 * t37 - m0 * t36 - m2 * t34 - m1 * t35 + (t32 * m7 - t30 * m4 - t23 *
            m6 - t28 * m5);
        const float t45 = m0 * t35 + m3 * t34 - m1 * t36 + m2 * t37 + (t28 * m4 + t23 * m7 - t30 *
            m5 + t32 * m6);
        const float t46 = m0 + m4;
        const float t47 = -0.5f * twist3;
        const float t48 = ((fabsf(t11) < 0.5f) ? t20 : fabsf(t33) / largerf(fabsf(t15), 0.25f));
        const float t49 = t10 * t48;
        const float t50 = -0.5f * twist4;
        const float t51 = -0.5f * twist5;
        const float t52 = t2 * t50 - t1 * t51;
        const float t53 = t0 * t51 - t2 * t47;
        const float t54 = t1 * t47 - t0 * t50;
        const float t55 = (t22 * t26 - t49) / largerf(t3 + t15 * t15, 1.6940659e-21f);
        const float t56 = t47 * t49 + (t15 * t52 - (t2 * t53 - t1 * t54)) * t55;
        const float t57 = m3 + m7;
        const float t58 = t49 * t50 + t55 * (t15 * t53 - (t0 * t54 - t2 * t52));
        const float t59 = m2 + m6;
        const float t60 = t49 * t51 + t55 * (t15 * t54 - (t1 * t52 - t0 * t53));
        const float t61 = m1 + m5;
        const float t62 = (t2 * t51 + t0 * t47 + t1 * t50) * (t26 * t48);
        const float t63 = t23 - t34;
        const float t64 = t28 - t35;
        const float t65 = t36 - t30;
        const float t66 = t32 - t37;
        const float t67 = t46 * t56 + t57 * t58 - t59 * t60 - t61 * t62 + (m8 * t63 - m9 * t64 - m10
            * t65 - m11 * t66);
        const float t68 = t46 * t58 - t59 * t62 + t60 * t61 - t56 * t57 + (m8 * t64 + t63 * m9 + t65
            * m11 - m10 * t66);
        const float t69 = t46 * t60 - t57 * t62 + t56 * t59 - t58 * t61 + (m8 * t65 + m9 * t66 + t63
            * m10 - t64 * m11);
        const float t70 = t46 * t62 + t57 * t60 + t56 * t61 + t58 * t59 + (m8 * t66 + t64 * m10 +
            t63 * m11 - m9 * t65);
        out_at[i] = t38;
        out_at[out_step + i] = t39;
        out_at[2 * out_step + i] = -t40;
        out_at[3 * out_step + i] = t41;
        out_at[4 * out_step + i] = t42;
        out_at[5 * out_step + i] = t43;
        out_at[6 * out_step + i] = -t44;
        out_at[7 * out_step + i] = t45;
        out_at[8 * out_step + i] = t67;
        out_at[9 * out_step + i] = t68;
        out_at[10 * out_step + i] = t69;
        out_at[11 * out_step + i] = t70;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_retract_f64(MOTORCADE_ARGUMENTS(double))
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
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double twist6 = twist_at[6 * twist_step + i];
        const double t0 = -0.5 * twist0;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist2;
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
        const double t13 = floor(0.5 + 0.7213475204444817 * twist6);
        const double t14 = exp2_of_integer(t13);
        const double t15 = exp2_of_integer(-t13);
        const double t16 = 0.5 * (t14 + t15);
        const double t17 = 0.5 * twist6;
        const double t18 = t17 - t13 * 0.6931471675634384 - t13 * 1.2996506893889889e-08;
        const double t19 = t18 * t18;
        const double t20 = t19 * (t19 * (2.763326749998937e-07 * t19 + 2.480148377847191e-05) +
            0.001388888895391314);
        const double t21 = 1.0 + t19 * (t19 * (t20 + 0.04166666666648207) + 0.5000000000000019);
        const double t22 = 0.5 * (t14 - t15);
        const double t23 = t19 * (t19 * 2.5110520415965448e-08 + 2.755723960835094e-06) +
            0.00019841269891276224;
        const double t24 = 1.0 + t19 * (t19 * (t19 * t23 + 0.008333333333319138) +
            0.16666666666666682);
        const double t25 = t18 * t24;
        const double t26 = t16 * t21 + t22 * t25;
        const double t27 = t12 * t26;
        const double t28 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t29 = t9 * (t9 * (t28 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t30 = 1.0 + t9 * (t9 * (t9 * t29 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t31 = ((t5 < 0.5) ? t30 : t30 * (t6 * t8) / larger(1.0, t4));
        const double t32 = t2 * t31;
        const double t33 = t26 * t32;
        const double t34 = t1 * t31;
        const double t35 = t26 * t34;
        const double t36 = t0 * t31;
        const double t37 = t26 * t36;
        const double t38 = t21 * t22 + t16 * t25;
        const double t39 = t12 * t38;
        const double t40 = t32 * t38;
        const double t41 = t34 * t38;
        const double t42 = t36 * t38;
        const double t43 = m0 * t27 - m3 * t33 - m2 * t35 - m1 * t37 + (m4 * t39 - m7 * t40 - m6 *
            t41 - m5 * t42);
        const double t44 = m0 * t37 - t33 * m2 + t27 * m1 + m3 * t35 + (m4 * t42 - t40 * m6 + t39 *
            m5 + m7 * t41);
        const double t45 = m3 * t37 - m0 * t35 - t27 * m2 - t33 * m1 + (m7 * t42 - m4 * t41 - t39 *
            m6 - t40 * m5);
        const double t46 = m0 * t33 + t27 * m3 - t35 * m1 + m2 * t37 + (m4 * t40 + t39 * m7 - t41 *
            m5 + m6 * t42);
        const double t47 = m0 * t39 - m3 * t40 - m2 * t41 - m1 * t42 + (t27 * m4 - t33 * m7 - t35 *
            m6 - t37 * m5);
        const double t48 = m0 * t42 - m2 * t40 + m1 * t39 + m3 * t41 + (t37 * m4 - t33 * m6 + t27 *
            m5 + t35 * m7);
        const double t49 = m3 * t42 - m0 * t41 - m2 * t39 - m1 * t40 + (t37 * m7 - t35 * m4 - t27 *
            m6 - t33 * m5);
        const double t50 = m0 * t40 + m3 * t39 - m1 * t41 + m2 * t42 + (t33 * m4 + t27 * m7 - t35 *
            m5 + t37 * m6);
        const double t51 = m0 + m4;
        const double t52 = -0.5 * twist3;
        const double t53 = ((fabs(t13) < 0.5) ? t24 : fabs(t38) / larger(fabs(t17), 0.25));
        const double t54 = t12 * t53;
        const double t55 = -0.5 * twist4;
        const double t56 = -0.5 * twist5;
        const double t57 = t2 * t55 - t1 * t56;
        const double t58 = t0 * t56 - t2 * t52;
        const double t59 = t1 * t52 - t0 * t55;
        const double t60 = (t26 * t31 - t54) / larger(t3 + t17 * t17, 1.0947644252537633e-47);
        const double t61 = t52 * t54 + (t17 * t57 - (t2 * t58 - t1 * t59)) * t60;
        const double t62 = m3 + m7;
        const double t63 = t54 * t55 + t60 * (t17 * t58 - (t0 * t59 - t2 * t57));
        const double t64 = m2 + m6;
        const double t65 = t54 * t56 + t60 * (t17 * t59 - (t1 * t57 - t0 * t58));
        const double t66 = m1 + m5;
        const double t67 = (t2 * t56 + t0 * t52 + t1 * t55) * (t31 * t53);
        const double t68 = t27 - t39;
        const double t69 = t33 - t40;
        const double t70 = t41 - t35;
        const double t71 = t37 - t42;
        const double t72 = t51 * t61 + t62 * t63 - t64 * t65 - t66 * t67 + (m8 * t68 - m9 * t69 -
            m10 * t70 - m11 * t71);
        const double t73 = t51 * t63 - t64 * t67 + t65 * t66 - t61 * t62 + (m8 * t69 + t68 * m9 +
            t70 * m11 - m10 * t71);
        const double t74 = t51 * t65 - t62 * t67 + t61 * t64 - t63 * t66 + (m8 * t70 + m9 * t71 +
            t68 * m10 - t69 * m11);
        const double t75 = t51 * t67 + t62 * t65 + t61 * t66 + t63 * t64 + (m8 * t71 + t69 * m10 +
            t68 * m11 - m9 * t70);
        out_at[i] = t43;
        out_at[out_step + i] = t44;
        out_at[2 * out_step + i] = -t45;
        out_at[3 * out_step + i] = t46;
        out_at[4 * out_step + i] = t47;
        out_at[5 * out_step + i] = t48;
        out_at[6 * out_step + i] = -t49;
        out_at[7 * out_step + i] = t50;
        out_at[8 * out_step + i] = t72;
        out_at[9 * out_step + i] = t73;
        out_at[10 * out_step + i] = t74;
        out_at[11 * out_step + i] = t75;
    }
}

/* similarity_local: The twist, turning by at most π, that takes similarity a to b
 * in a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: rx ry rz x y z log_scale */

MOTORCADE_SIMD
void motorcade_similarity_local_f32(MOTORCADE_ARGUMENTS(float))
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
        out_at[i] = -2.0f * (t12 * t13);
        out_at[out_step + i] = -(-2.0f * (t12 * t14));
        out_at[2 * out_step + i] = -2.0f * (t12 * t15);
        out_at[3 * out_step + i] = -2.0f * ((t8 * t25 + t13 * t27) * t42 + (t15 * t45 - t14 * t48) *
            t50 + t51 * t52);
        out_at[4 * out_step + i] = -2.0f * (t42 * (t8 * t47 - t14 * t27) - t50 * (t13 * t48 + t15 *
            t51) + t45 * t52);
        out_at[5 * out_step + i] = -2.0f * (t42 * (t8 * t44 + t15 * t27) - t50 * (t14 * t51 + t13 *
            t45) - t48 * t52);
        out_at[6 * out_step + i] = 2.0f * (t32 * t42);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_local_f64(MOTORCADE_ARGUMENTS(double))
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
        out_at[i] = -2.0 * (t17 * t18);
        out_at[out_step + i] = -(-2.0 * (t17 * t19));
        out_at[2 * out_step + i] = -2.0 * (t17 * t20);
        out_at[3 * out_step + i] = -2.0 * ((t8 * t30 + t18 * t32) * t50 + (t20 * t53 - t19 * t56) *
            t58 + t59 * t60);
        out_at[4 * out_step + i] = -2.0 * (t50 * (t8 * t55 - t19 * t32) - t58 * (t18 * t56 + t20 *
            t59) + t53 * t60);
        out_at[5 * out_step + i] = -2.0 * (t50 * (t8 * t52 + t20 * t32) - t58 * (t19 * t59 + t18 *
            t53) - t56 * t60);
        out_at[6 * out_step + i] = 2.0 * (t37 * t50);
    }
}
