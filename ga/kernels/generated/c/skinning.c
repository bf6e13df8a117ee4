/* Kernels of the group skinning: carry_motor, carry_dual_quaternion, carry_similarity,
 * carry_matrix.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* carry_motor: A point and a normal carried by a sum of motors
 * in m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in x: x y z
 * in n: x y z
 * out out: x y z nx ny nz */

MOTORCADE_SIMD
void motorcade_carry_motor_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const float *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const float n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const float t0 = m0 * x0 + m3 * x1 - m2 * x2;
        const float t1 = m0 * x1 + x2 * m1 - x0 * m3;
        const float t2 = m0 * x2 + x0 * m2 - x1 * m1;
        const float t3 = m3 * x2 + x0 * m1 + x1 * m2;
        const float t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0f * (m0 * m4 + m3 * m5 - m2 *
            m6 + m1 * m7);
        const float t5 = 1.0f / (m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
        const float t6 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0f * (m0 * m5 - m3 * m4 + m2 *
            m7 + m1 * m6);
        const float t7 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0f * (m2 * m4 - m1 * m5 + m0 *
            m6 + m3 * m7);
        const float t8 = m0 * n0 + m3 * n1 - m2 * n2;
        const float t9 = m0 * n1 + m1 * n2 - m3 * n0;
        const float t10 = m0 * n2 + m2 * n0 - m1 * n1;
        const float t11 = m3 * n2 + m1 * n0 + m2 * n1;
        out_at[i] = t4 * t5;
        out_at[out_step + i] = t5 * t6;
        out_at[2 * out_step + i] = t5 * t7;
        out_at[3 * out_step + i] = t5 * (m0 * t8 + m3 * t9 - m2 * t10 + m1 * t11);
        out_at[4 * out_step + i] = t5 * (m0 * t9 - m3 * t8 + m2 * t11 + m1 * t10);
        out_at[5 * out_step + i] = t5 * (m2 * t8 - m1 * t9 + m0 * t10 + m3 * t11);
    }
}

MOTORCADE_SIMD
void motorcade_carry_motor_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const double *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const double n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const double t0 = m0 * x0 + m3 * x1 - m2 * x2;
        const double t1 = m0 * x1 + x2 * m1 - x0 * m3;
        const double t2 = m0 * x2 + x0 * m2 - x1 * m1;
        const double t3 = m3 * x2 + x0 * m1 + x1 * m2;
        const double t4 = m0 * t0 + m3 * t1 - m2 * t2 + m1 * t3 + -2.0 * (m0 * m4 + m3 * m5 - m2 *
            m6 + m1 * m7);
        const double t5 = 1.0 / (m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
        const double t6 = m0 * t1 - m3 * t0 + m2 * t3 + m1 * t2 + -2.0 * (m0 * m5 - m3 * m4 + m2 *
            m7 + m1 * m6);
        const double t7 = m2 * t0 - m1 * t1 + m0 * t2 + m3 * t3 + -2.0 * (m2 * m4 - m1 * m5 + m0 *
            m6 + m3 * m7);
        const double t8 = m0 * n0 + m3 * n1 - m2 * n2;
        const double t9 = m0 * n1 + m1 * n2 - m3 * n0;
        const double t10 = m0 * n2 + m2 * n0 - m1 * n1;
        const double t11 = m3 * n2 + m1 * n0 + m2 * n1;
        out_at[i] = t4 * t5;
        out_at[out_step + i] = t5 * t6;
        out_at[2 * out_step + i] = t5 * t7;
        out_at[3 * out_step + i] = t5 * (m0 * t8 + m3 * t9 - m2 * t10 + m1 * t11);
        out_at[4 * out_step + i] = t5 * (m0 * t9 - m3 * t8 + m2 * t11 + m1 * t10);
        out_at[5 * out_step + i] = t5 * (m2 * t8 - m1 * t9 + m0 * t10 + m3 * t11);
    }
}

/* carry_dual_quaternion: A point and a normal carried by a sum of dual quaternions, real wxyz, dual
 * wxyz
 * in q: w x y z εw εx εy εz
 * in x: x y z
 * in n: x y z
 * out out: x y z nx ny nz */

MOTORCADE_SIMD
void motorcade_carry_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict q_at = inputs[0];
    const ptrdiff_t q_step = input_steps[0];
    const float *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const float *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const float q3 = q_at[3 * q_step + i], q4 = q_at[4 * q_step + i], q5 = q_at[5 * q_step + i];
        const float q6 = q_at[6 * q_step + i], q7 = q_at[7 * q_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const float n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const float t0 = 2.0f / (q0 * q0 + (q1 * q1 + q2 * q2 + q3 * q3));
        const float t1 = q1 * x1 - x0 * q2 + q0 * x2;
        const float t2 = x0 * q3 - q1 * x2 + q0 * x1;
        const float t3 = q2 * x2 - q3 * x1 + x0 * q0;
        const float t4 = q1 * n1 - q2 * n0 + q0 * n2;
        const float t5 = q3 * n0 - q1 * n2 + q0 * n1;
        const float t6 = q2 * n2 - q3 * n1 + q0 * n0;
        out_at[i] = x0 + t0 * (q2 * t1 - q3 * t2) + t0 * (q0 * q5 - q1 * q4 + (q2 * q7 - q3 * q6));
        out_at[out_step + i] = x1 + t0 * (q3 * t3 - q1 * t1) + t0 * (q0 * q6 - q2 * q4 + (q3 * q5 -
            q1 * q7));
        out_at[2 * out_step + i] = x2 + t0 * (q1 * t2 - q2 * t3) + t0 * (q0 * q7 - q3 * q4 + (q1 *
            q6 - q2 * q5));
        out_at[3 * out_step + i] = n0 + t0 * (q2 * t4 - q3 * t5);
        out_at[4 * out_step + i] = n1 + t0 * (q3 * t6 - q1 * t4);
        out_at[5 * out_step + i] = n2 + t0 * (q1 * t5 - q2 * t6);
    }
}

MOTORCADE_SIMD
void motorcade_carry_dual_quaternion_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict q_at = inputs[0];
    const ptrdiff_t q_step = input_steps[0];
    const double *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const double *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const double q3 = q_at[3 * q_step + i], q4 = q_at[4 * q_step + i], q5 = q_at[5 * q_step + i];
        const double q6 = q_at[6 * q_step + i], q7 = q_at[7 * q_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const double n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const double t0 = 2.0 / (q0 * q0 + (q1 * q1 + q2 * q2 + q3 * q3));
        const double t1 = q1 * x1 - x0 * q2 + q0 * x2;
        const double t2 = x0 * q3 - q1 * x2 + q0 * x1;
        const double t3 = q2 * x2 - q3 * x1 + x0 * q0;
        const double t4 = q1 * n1 - q2 * n0 + q0 * n2;
        const double t5 = q3 * n0 - q1 * n2 + q0 * n1;
        const double t6 = q2 * n2 - q3 * n1 + q0 * n0;
        out_at[i] = x0 + t0 * (q2 * t1 - q3 * t2) + t0 * (q0 * q5 - q1 * q4 + (q2 * q7 - q3 * q6));
        out_at[out_step + i] = x1 + t0 * (q3 * t3 - q1 * t1) + t0 * (q0 * q6 - q2 * q4 + (q3 * q5 -
            q1 * q7));
        out_at[2 * out_step + i] = x2 + t0 * (q1 * t2 - q2 * t3) + t0 * (q0 * q7 - q3 * q4 + (q1 *
            q6 - q2 * q5));
        out_at[3 * out_step + i] = n0 + t0 * (q2 * t4 - q3 * t5);
        out_at[4 * out_step + i] = n1 + t0 * (q3 * t6 - q1 * t4);
        out_at[5 * out_step + i] = n2 + t0 * (q1 * t5 - q2 * t6);
    }
}

/* carry_similarity: A point and a normal carried by a sum of similarities
 * in s: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in x: x y z
 * in n: x y z
 * out out: x y z nx ny nz */

MOTORCADE_SIMD
void motorcade_carry_similarity_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict s_at = inputs[0];
    const ptrdiff_t s_step = input_steps[0];
    const float *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const float *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const float s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const float s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const float s9 = s_at[9 * s_step + i], s10 = s_at[10 * s_step + i], s11 = s_at[11 * s_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const float n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const float t0 = largerf(largerf(largerf(largerf(fabsf(s0), fabsf(s1)), fabsf(s2)),
            fabsf(s3)), fabsf(s4));
        const float t1 = smallerf(1.0f - exponentf(largerf(largerf(largerf(t0, fabsf(s5)),
            fabsf(s6)), fabsf(s7))), 127.0f);
        const float t2 = exp2_of_integerf(t1);
        const float t3 = s0 * t2;
        const float t4 = s4 * t2;
        const float t5 = t3 + t4;
        const float t6 = s3 * t2;
        const float t7 = s7 * t2;
        const float t8 = t6 + t7;
        const float t9 = s2 * t2;
        const float t10 = s6 * t2;
        const float t11 = t9 + t10;
        const float t12 = s1 * t2;
        const float t13 = s5 * t2;
        const float t14 = t12 + t13;
        const float t15 = sqrtf(t5 * t5 + t8 * t8 + t11 * t11 + t14 * t14);
        const float t16 = 1.0f / largerf(t15, 1.4210855e-14f);
        const float t17 = t5 * t16;
        const float t18 = t3 - t4;
        const float t19 = t6 - t7;
        const float t20 = t10 - t9;
        const float t21 = t12 - t13;
        const float t22 = sqrtf(t18 * t18 + t19 * t19 + t20 * t20 + t21 * t21);
        const float t23 = 1.0f / largerf(1.4210855e-14f, t22);
        const float t24 = t18 * t23;
        const float t25 = t17 + t24;
        const float t26 = t8 * t16;
        const float t27 = t19 * t23;
        const float t28 = t26 + t27;
        const float t29 = t20 * t23;
        const float t30 = t11 * t16;
        const float t31 = t29 - t30;
        const float t32 = t14 * t16;
        const float t33 = t21 * t23;
        const float t34 = t32 + t33;
        const float t35 = sqrtf(t25 * t25 + t28 * t28 + t31 * t31 + t34 * t34);
        const float t36 = 1.0f / largerf(1.4210855e-14f, t35);
        const float t37 = t25 * t36;
        const float t38 = t15 + t22;
        const float t39 = 2.3841858e-07f * largerf(t15, t22);
        const float t40 = 1.0f / sqrtf(largerf(t15, t39) * largerf(t22, t39));
        const float t41 = t38 * (0.5f * t40);
        const float t42 = t37 * t41;
        const float t43 = t40 * (2.0f * (t3 * t4 + t6 * t7 + t9 * t10 + t12 * t13) / t38);
        const float t44 = t37 * t43;
        const float t45 = t28 * t36;
        const float t46 = t41 * t45;
        const float t47 = t43 * t45;
        const float t48 = t31 * t36;
        const float t49 = t41 * t48;
        const float t50 = t43 * t48;
        const float t51 = t34 * t36;
        const float t52 = t41 * t51;
        const float t53 = t43 * t51;
        const _Bool t54 = (t42 * t44 + t46 * t47 + t49 * t50 + t52 * t53 < 0.0f);
        const float t55 = t42 - t44;
        const float t56 = t46 - t47;
        const float t57 = t49 - t50;
        const float t58 = t52 - t53;
        const float t59 = 1.0f / (t55 * t55 + t56 * t56 + t57 * t57 + t58 * t58);
        const float t60 = (t54 ? t55 * t59 : t42 + t44);
        const float t61 = (t54 ? t56 * t59 : t46 + t47);
        const float t62 = (t54 ? -(t57 * t59) : -(t49 + t50));
        const float t63 = t60 * x0 + t61 * x1 - t62 * x2;
        const float t64 = (t54 ? t58 * t59 : t52 + t53);
        const float t65 = t60 * x1 + x2 * t64 - x0 * t61;
        const float t66 = t60 * x2 + x0 * t62 - x1 * t64;
        const float t67 = t61 * x2 + x0 * t64 + x1 * t62;
        const float t68 = t17 * t37 + t26 * t45 - t30 * t48 + t32 * t51;
        const float t69 = t2 * s8;
        const float t70 = t17 * t45 - t26 * t37 + t30 * t51 + t32 * t48;
        const float t71 = t2 * s9;
        const float t72 = t30 * t37 - t32 * t45 + t17 * t48 + t26 * t51;
        const float t73 = t2 * s10;
        const float t74 = t17 * t51 - (t32 * t37 + t26 * t48) - t30 * t45;
        const float t75 = t2 * s11;
        const float t76 = t40 * (t68 * t69 + t70 * t71 + t72 * t73 - t74 * t75);
        const float t77 = t40 * (t68 * t75 + t70 * t73 + t69 * t74 - t71 * t72);
        const float t78 = t40 * (t68 * t73 - t70 * t75 - t69 * t72 - t71 * t74);
        const float t79 = t40 * (t68 * t71 + t72 * t75 + t73 * t74 - t69 * t70);
        const float t80 = 2.0f * (t37 * t77 - (t51 * t76 + t45 * t78) + t48 * t79) / largerf(t35,
            1.1920929e-07f);
        const float t81 = t76 + t33 * t80;
        const float t82 = t79 - t29 * t80;
        const float t83 = t78 + t27 * t80;
        const float t84 = t77 - t24 * t80;
        const float t85 = t60 * t63 + t61 * t65 - t62 * t66 + t64 * t67 + -2.0f * (t60 * t81 + t61 *
            t82 - t62 * t83 + t64 * t84);
        const float t86 = t60 * t65 - t61 * t63 + t62 * t67 + t64 * t66 + -2.0f * (t60 * t82 - t61 *
            t81 + t62 * t84 + t64 * t83);
        const float t87 = t62 * t63 - t64 * t65 + t60 * t66 + t61 * t67 + -2.0f * (t62 * t81 - t64 *
            t82 + t60 * t83 + t61 * t84);
        const float t88 = t60 * n0 + t61 * n1 - t62 * n2;
        const float t89 = t60 * n1 + t64 * n2 - t61 * n0;
        const float t90 = t60 * n2 + t62 * n0 - t64 * n1;
        const float t91 = t61 * n2 + t64 * n0 + t62 * n1;
        const float t92 = 1.0f / (t60 * t60 + t61 * t61 + t62 * t62 + t64 * t64);
        out_at[i] = t85;
        out_at[out_step + i] = t86;
        out_at[2 * out_step + i] = t87;
        out_at[3 * out_step + i] = (t60 * t88 + t61 * t89 - t62 * t90 + t64 * t91) * t92;
        out_at[4 * out_step + i] = t92 * (t60 * t89 - t61 * t88 + t62 * t91 + t64 * t90);
        out_at[5 * out_step + i] = t92 * (t62 * t88 - t64 * t89 + t60 * t90 + t61 * t91);
    }
}

MOTORCADE_SIMD
void motorcade_carry_similarity_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict s_at = inputs[0];
    const ptrdiff_t s_step = input_steps[0];
    const double *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const double *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const double s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const double s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const double s9 = s_at[9 * s_step + i], s10 = s_at[10 * s_step + i], s11 = s_at[11 * s_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const double n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const double t0 = larger(larger(larger(larger(larger(fabs(s0), fabs(s1)), fabs(s2)),
            fabs(s3)), fabs(s4)), fabs(s5));
        const double t1 = exp2_of_integer(smaller(1.0 - exponent(larger(larger(t0, fabs(s6)),
            fabs(s7))), 1023.0));
        const double t2 = s0 * t1;
        const double t3 = s4 * t1;
        const double t4 = t2 + t3;
        const double t5 = s3 * t1;
        const double t6 = s7 * t1;
        const double t7 = t5 + t6;
        const double t8 = s2 * t1;
        const double t9 = s6 * t1;
        const double t10 = t8 + t9;
        const double t11 = s1 * t1;
        const double t12 = s5 * t1;
        const double t13 = t11 + t12;
        const double t14 = sqrt(t4 * t4 + t7 * t7 + t10 * t10 + t13 * t13);
        const double t15 = 1.0 / larger(t14, 4.930380657631324e-32);
        const double t16 = t4 * t15;
        const double t17 = t2 - t3;
        const double t18 = t5 - t6;
        const double t19 = t9 - t8;
        const double t20 = t11 - t12;
        const double t21 = sqrt(t17 * t17 + t18 * t18 + t19 * t19 + t20 * t20);
        const double t22 = 1.0 / larger(4.930380657631324e-32, t21);
        const double t23 = t17 * t22;
        const double t24 = t16 + t23;
        const double t25 = t7 * t15;
        const double t26 = t18 * t22;
        const double t27 = t25 + t26;
        const double t28 = t19 * t22;
        const double t29 = t10 * t15;
        const double t30 = t28 - t29;
        const double t31 = t13 * t15;
        const double t32 = t20 * t22;
        const double t33 = t31 + t32;
        const double t34 = sqrt(t24 * t24 + t27 * t27 + t30 * t30 + t33 * t33);
        const double t35 = 1.0 / larger(4.930380657631324e-32, t34);
        const double t36 = t24 * t35;
        const double t37 = t14 + t21;
        const double t38 = 4.440892098500626e-16 * larger(t14, t21);
        const double t39 = 1.0 / sqrt(larger(t14, t38) * larger(t21, t38));
        const double t40 = t37 * (0.5 * t39);
        const double t41 = t36 * t40;
        const double t42 = t39 * (2.0 * (t2 * t3 + t5 * t6 + t8 * t9 + t11 * t12) / t37);
        const double t43 = t36 * t42;
        const double t44 = t27 * t35;
        const double t45 = t40 * t44;
        const double t46 = t42 * t44;
        const double t47 = t30 * t35;
        const double t48 = t40 * t47;
        const double t49 = t42 * t47;
        const double t50 = t33 * t35;
        const double t51 = t40 * t50;
        const double t52 = t42 * t50;
        const _Bool t53 = (t41 * t43 + t45 * t46 + t48 * t49 + t51 * t52 < 0.0);
        const double t54 = t41 - t43;
        const double t55 = t45 - t46;
        const double t56 = t48 - t49;
        const double t57 = t51 - t52;
        const double t58 = 1.0 / (t54 * t54 + t55 * t55 + t56 * t56 + t57 * t57);
        const double t59 = (t53 ? t54 * t58 : t41 + t43);
        const double t60 = (t53 ? t55 * t58 : t45 + t46);
        const double t61 = (t53 ? -(t56 * t58) : -(t48 + t49));
        const double t62 = t59 * x0 + t60 * x1 - t61 * x2;
        const double t63 = (t53 ? t57 * t58 : t51 + t52);
        const double t64 = t59 * x1 + x2 * t63 - x0 * t60;
        const double t65 = t59 * x2 + x0 * t61 - x1 * t63;
        const double t66 = t60 * x2 + x0 * t63 + x1 * t61;
        const double t67 = t16 * t36 + t25 * t44 - t29 * t47 + t31 * t50;
        const double t68 = t1 * s8;
        const double t69 = t16 * t44 - t25 * t36 + t29 * t50 + t31 * t47;
        const double t70 = t1 * s9;
        const double t71 = t29 * t36 - t31 * t44 + t16 * t47 + t25 * t50;
        const double t72 = t1 * s10;
        const double t73 = t16 * t50 - (t31 * t36 + t25 * t47) - t29 * t44;
        const double t74 = t1 * s11;
        const double t75 = t39 * (t67 * t68 + t69 * t70 + t71 * t72 - t73 * t74);
        const double t76 = t39 * (t67 * t74 + t69 * t72 + t68 * t73 - t70 * t71);
        const double t77 = t39 * (t67 * t72 - t69 * t74 - t68 * t71 - t70 * t73);
        const double t78 = t39 * (t67 * t70 + t71 * t74 + t72 * t73 - t68 * t69);
        const double t79 = 2.0 * (t36 * t76 - (t50 * t75 + t44 * t77) + t47 * t78) / larger(t34,
            2.220446049250313e-16);
        const double t80 = t75 + t32 * t79;
        const double t81 = t78 - t28 * t79;
        const double t82 = t77 + t26 * t79;
        const double t83 = t76 - t23 * t79;
        const double t84 = t59 * t62 + t60 * t64 - t61 * t65 + t63 * t66 + -2.0 * (t59 * t80 + t60 *
            t81 - t61 * t82 + t63 * t83);
        const double t85 = t59 * t64 - t60 * t62 + t61 * t66 + t63 * t65 + -2.0 * (t59 * t81 - t60 *
            t80 + t61 * t83 + t63 * t82);
        const double t86 = t61 * t62 - t63 * t64 + t59 * t65 + t60 * t66 + -2.0 * (t61 * t80 - t63 *
            t81 + t59 * t82 + t60 * t83);
        const double t87 = t59 * n0 + t60 * n1 - t61 * n2;
        const double t88 = t59 * n1 + t63 * n2 - t60 * n0;
        const double t89 = t59 * n2 + t61 * n0 - t63 * n1;
        const double t90 = t60 * n2 + t63 * n0 + t61 * n1;
        const double t91 = 1.0 / (t59 * t59 + t60 * t60 + t61 * t61 + t63 * t63);
        out_at[i] = t84;
        out_at[out_step + i] = t85;
        out_at[2 * out_step + i] = t86;
        out_at[3 * out_step + i] = (t59 * t87 + t60 * t88 - t61 * t89 + t63 * t90) * t91;
        out_at[4 * out_step + i] = t91 * (t59 * t88 - t60 * t87 + t61 * t90 + t63 * t89);
        out_at[5 * out_step + i] = t91 * (t61 * t87 - t63 * t88 + t59 * t89 + t60 * t90);
    }
}

/* carry_matrix: A point and a normal carried by a sum of 3×4 matrices
 * in m: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23
 * in x: x y z
 * in n: x y z
 * out out: x y z nx ny nz */

MOTORCADE_SIMD
void motorcade_carry_matrix_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const float *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const float *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const float m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const float m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const float m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const float x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const float n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const float t0 = m0 * n0 + m1 * n1 + m2 * n2;
        const float t1 = m4 * n0 + m5 * n1 + m6 * n2;
        const float t2 = m8 * n0 + m9 * n1 + m10 * n2;
        const float t3 = 1.0f / sqrtf(t0 * t0 + t1 * t1 + t2 * t2);
        out_at[i] = m0 * x0 + m1 * x1 + m2 * x2 + m3;
        out_at[out_step + i] = x0 * m4 + x1 * m5 + x2 * m6 + m7;
        out_at[2 * out_step + i] = x0 * m8 + x1 * m9 + x2 * m10 + m11;
        out_at[3 * out_step + i] = t0 * t3;
        out_at[4 * out_step + i] = t1 * t3;
        out_at[5 * out_step + i] = t2 * t3;
    }
}

MOTORCADE_SIMD
void motorcade_carry_matrix_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict m_at = inputs[0];
    const ptrdiff_t m_step = input_steps[0];
    const double *restrict x_at = inputs[1];
    const ptrdiff_t x_step = input_steps[1];
    const double *restrict n_at = inputs[2];
    const ptrdiff_t n_step = input_steps[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double m0 = m_at[i], m1 = m_at[m_step + i], m2 = m_at[2 * m_step + i];
        const double m3 = m_at[3 * m_step + i], m4 = m_at[4 * m_step + i], m5 = m_at[5 * m_step + i];
        const double m6 = m_at[6 * m_step + i], m7 = m_at[7 * m_step + i], m8 = m_at[8 * m_step + i];
        const double m9 = m_at[9 * m_step + i], m10 = m_at[10 * m_step + i], m11 = m_at[11 * m_step + i];
        const double x0 = x_at[i], x1 = x_at[x_step + i], x2 = x_at[2 * x_step + i];
        const double n0 = n_at[i], n1 = n_at[n_step + i], n2 = n_at[2 * n_step + i];
        const double t0 = m0 * n0 + m1 * n1 + m2 * n2;
        const double t1 = m4 * n0 + m5 * n1 + m6 * n2;
        const double t2 = m8 * n0 + m9 * n1 + m10 * n2;
        const double t3 = 1.0 / sqrt(t0 * t0 + t1 * t1 + t2 * t2);
        out_at[i] = m0 * x0 + m1 * x1 + m2 * x2 + m3;
        out_at[out_step + i] = x0 * m4 + x1 * m5 + x2 * m6 + m7;
        out_at[2 * out_step + i] = x0 * m8 + x1 * m9 + x2 * m10 + m11;
        out_at[3 * out_step + i] = t0 * t3;
        out_at[4 * out_step + i] = t1 * t3;
        out_at[5 * out_step + i] = t2 * t3;
    }
}
