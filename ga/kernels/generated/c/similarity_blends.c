/* Kernels of the group similarity_blends: similarity_normalize, similarity_blend.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_normalize: The similarity nearest to an even element, and how well it is defined
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ defined */

MOTORCADE_SIMD
void motorcade_similarity_normalize_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = largerf(largerf(largerf(largerf(fabsf(m0), fabsf(m1)), fabsf(m2)),
            fabsf(m3)), fabsf(m4));
        const float t1 = smallerf(1.0f - exponentf(largerf(largerf(largerf(t0, fabsf(m5)),
            fabsf(m6)), fabsf(m7))), 127.0f);
        const float t2 = exp2_of_integerf(t1);
        const float t3 = m0 * t2;
        const float t4 = m4 * t2;
        const float t5 = t3 + t4;
        const float t6 = m3 * t2;
        const float t7 = m7 * t2;
        const float t8 = t6 + t7;
        const float t9 = m2 * t2;
        const float t10 = m6 * t2;
        const float t11 = t9 + t10;
        const float t12 = m1 * t2;
        const float t13 = m5 * t2;
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
        const float t42 = t34 * t36;
        const float t43 = t31 * t36;
        const float t44 = t28 * t36;
        const float t45 = t40 * (2.0f * (t3 * t4 + t6 * t7 + t9 * t10 + t12 * t13) / t38);
        const float t46 = t17 * t37 + t26 * t44 - t30 * t43 + t32 * t42;
        const float t47 = t2 * m8;
        const float t48 = t17 * t44 - t26 * t37 + t30 * t42 + t32 * t43;
        const float t49 = t2 * m9;
        const float t50 = t30 * t37 - t32 * t44 + t17 * t43 + t26 * t42;
        const float t51 = t2 * m10;
        const float t52 = t17 * t42 - (t32 * t37 + t26 * t43) - t30 * t44;
        const float t53 = t2 * m11;
        const float t54 = t40 * (t46 * t47 + t48 * t49 + t50 * t51 - t52 * t53);
        const float t55 = t40 * (t46 * t53 + t48 * t51 + t47 * t52 - t49 * t50);
        const float t56 = t40 * (t46 * t51 - t48 * t53 - t47 * t50 - t49 * t52);
        const float t57 = t40 * (t46 * t49 + t50 * t53 + t51 * t52 - t47 * t48);
        const float t58 = 2.0f * (t37 * t55 - (t42 * t54 + t44 * t56) + t43 * t57) / largerf(t35,
            1.1920929e-07f);
        out_at[i] = t37 * t41;
        out_at[out_step + i] = t41 * t42;
        out_at[2 * out_step + i] = -(t41 * t43);
        out_at[3 * out_step + i] = t41 * t44;
        out_at[4 * out_step + i] = t37 * t45;
        out_at[5 * out_step + i] = t42 * t45;
        out_at[6 * out_step + i] = -(t43 * t45);
        out_at[7 * out_step + i] = t44 * t45;
        out_at[8 * out_step + i] = t54 + t33 * t58;
        out_at[9 * out_step + i] = t57 - t29 * t58;
        out_at[10 * out_step + i] = t56 + t27 * t58;
        out_at[11 * out_step + i] = t55 - t24 * t58;
        out_at[12 * out_step + i] = ((t39 < smallerf(t15, t22)) ? t35 * 0.5f : 0.0f);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_normalize_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = larger(larger(larger(larger(larger(fabs(m0), fabs(m1)), fabs(m2)),
            fabs(m3)), fabs(m4)), fabs(m5));
        const double t1 = exp2_of_integer(smaller(1.0 - exponent(larger(larger(t0, fabs(m6)),
            fabs(m7))), 1023.0));
        const double t2 = m0 * t1;
        const double t3 = m4 * t1;
        const double t4 = t2 + t3;
        const double t5 = m3 * t1;
        const double t6 = m7 * t1;
        const double t7 = t5 + t6;
        const double t8 = m2 * t1;
        const double t9 = m6 * t1;
        const double t10 = t8 + t9;
        const double t11 = m1 * t1;
        const double t12 = m5 * t1;
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
        const double t41 = t33 * t35;
        const double t42 = t30 * t35;
        const double t43 = t27 * t35;
        const double t44 = t39 * (2.0 * (t2 * t3 + t5 * t6 + t8 * t9 + t11 * t12) / t37);
        const double t45 = t16 * t36 + t25 * t43 - t29 * t42 + t31 * t41;
        const double t46 = t1 * m8;
        const double t47 = t16 * t43 - t25 * t36 + t29 * t41 + t31 * t42;
        const double t48 = t1 * m9;
        const double t49 = t29 * t36 - t31 * t43 + t16 * t42 + t25 * t41;
        const double t50 = t1 * m10;
        const double t51 = t16 * t41 - (t31 * t36 + t25 * t42) - t29 * t43;
        const double t52 = t1 * m11;
        const double t53 = t39 * (t45 * t46 + t47 * t48 + t49 * t50 - t51 * t52);
        const double t54 = t39 * (t45 * t52 + t47 * t50 + t46 * t51 - t48 * t49);
        const double t55 = t39 * (t45 * t50 - t47 * t52 - t46 * t49 - t48 * t51);
        const double t56 = t39 * (t45 * t48 + t49 * t52 + t50 * t51 - t46 * t47);
        const double t57 = 2.0 * (t36 * t54 - (t41 * t53 + t43 * t55) + t42 * t56) / larger(t34,
            2.220446049250313e-16);
        out_at[i] = t36 * t40;
        out_at[out_step + i] = t40 * t41;
        out_at[2 * out_step + i] = -(t40 * t42);
        out_at[3 * out_step + i] = t40 * t43;
        out_at[4 * out_step + i] = t36 * t44;
        out_at[5 * out_step + i] = t41 * t44;
        out_at[6 * out_step + i] = -(t42 * t44);
        out_at[7 * out_step + i] = t43 * t44;
        out_at[8 * out_step + i] = t53 + t32 * t57;
        out_at[9 * out_step + i] = t56 - t28 * t57;
        out_at[10 * out_step + i] = t55 + t26 * t57;
        out_at[11 * out_step + i] = t54 - t23 * t57;
        out_at[12 * out_step + i] = ((t38 < smaller(t14, t21)) ? t34 * 0.5 : 0.0);
    }
}

/* similarity_blend: Linear blend of two similarities, the short way round, made unit
 * in a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * in fraction: fraction
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_blend_f32(MOTORCADE_ARGUMENTS(float))
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
        const float a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const float a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const float b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const float b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const float b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const float b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const float fraction = fraction_at[i];
        const float t0 = 1.0f - fraction;
        const float t1 = ((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0f) ? -fraction : fraction);
        const float t2 = t0 * a0 + b0 * t1;
        const float t3 = t0 * a1 + b1 * t1;
        const float t4 = t0 * a2 + b2 * t1;
        const float t5 = t0 * a3 + b3 * t1;
        const float t6 = t0 * a4 + t1 * b4;
        const float t7 = largerf(largerf(largerf(largerf(fabsf(t2), fabsf(t3)), fabsf(t4)),
            fabsf(t5)), fabsf(t6));
        const float t8 = t0 * a5 + t1 * b5;
        const float t9 = t0 * a6 + t1 * b6;
        const float t10 = t0 * a7 + t1 * b7;
        const float t11 = smallerf(1.0f - exponentf(largerf(largerf(largerf(t7, fabsf(t8)),
            fabsf(t9)), fabsf(t10))), 127.0f);
        const float t12 = exp2_of_integerf(t11);
        const float t13 = t2 * t12;
        const float t14 = t6 * t12;
        const float t15 = t13 + t14;
        const float t16 = t5 * t12;
        const float t17 = t10 * t12;
        const float t18 = t16 + t17;
        const float t19 = t4 * t12;
        const float t20 = t9 * t12;
        const float t21 = t19 + t20;
        const float t22 = t3 * t12;
        const float t23 = t8 * t12;
        const float t24 = t22 + t23;
        const float t25 = sqrtf(t15 * t15 + t18 * t18 + t21 * t21 + t24 * t24);
        const float t26 = 1.0f / largerf(t25, 1.4210855e-14f);
        const float t27 = t15 * t26;
        const float t28 = t13 - t14;
        const float t29 = t16 - t17;
        const float t30 = t20 - t19;
        const float t31 = t22 - t23;
        const float t32 = sqrtf(t28 * t28 + t29 * t29 + t30 * t30 + t31 * t31);
        const float t33 = 1.0f / largerf(1.4210855e-14f, t32);
        const float t34 = t28 * t33;
        const float t35 = t27 + t34;
        const float t36 = t18 * t26;
        const float t37 = t29 * t33;
        const float t38 = t36 + t37;
        const float t39 = t30 * t33;
        const float t40 = t21 * t26;
        const float t41 = t39 - t40;
        const float t42 = t24 * t26;
        const float t43 = t31 * t33;
        const float t44 = t42 + t43;
        const float t45 = sqrtf(t35 * t35 + t38 * t38 + t41 * t41 + t44 * t44);
        const float t46 = 1.0f / largerf(1.4210855e-14f, t45);
        const float t47 = t35 * t46;
        const float t48 = t25 + t32;
        const float t49 = 2.3841858e-07f * largerf(t25, t32);
        const float t50 = 1.0f / sqrtf(largerf(t25, t49) * largerf(t32, t49));
        const float t51 = t48 * (0.5f * t50);
        const float t52 = t44 * t46;
        const float t53 = t41 * t46;
        const float t54 = t38 * t46;
        const float t55 = t50 * (2.0f * (t13 * t14 + t16 * t17 + t19 * t20 + t22 * t23) / t48);
        const float t56 = t27 * t47 + t36 * t54 - t40 * t53 + t42 * t52;
        const float t57 = t12 * (t0 * a8 + t1 * b8);
        const float t58 = t27 * t54 - t36 * t47 + t40 * t52 + t42 * t53;
        const float t59 = t12 * (t0 * a9 + t1 * b9);
        const float t60 = t40 * t47 - t42 * t54 + t27 * t53 + t36 * t52;
        const float t61 = t12 * (t0 * a10 + t1 * b10);
        const float t62 = t27 * t52 - (t42 * t47 + t36 * t53) - t40 * t54;
        const float t63 = t12 * (t0 * a11 + t1 * b11);
        const float t64 = t50 * (t56 * t57 + t58 * t59 + t60 * t61 - t62 * t63);
        const float t65 = t50 * (t56 * t63 + t58 * t61 + t57 * t62 - t59 * t60);
        const float t66 = t50 * (t56 * t61 - t58 * t63 - t57 * t60 - t59 * t62);
        const float t67 = t50 * (t56 * t59 + t60 * t63 + t61 * t62 - t57 * t58);
        const float t68 = 2.0f * (t47 * t65 - (t52 * t64 + t54 * t66) + t53 * t67) / largerf(t45,
            1.1920929e-07f);
        out_at[i] = t47 * t51;
        out_at[out_step + i] = t51 * t52;
        out_at[2 * out_step + i] = -(t51 * t53);
        out_at[3 * out_step + i] = t51 * t54;
        out_at[4 * out_step + i] = t47 * t55;
        out_at[5 * out_step + i] = t52 * t55;
        out_at[6 * out_step + i] = -(t53 * t55);
        out_at[7 * out_step + i] = t54 * t55;
        out_at[8 * out_step + i] = t64 + t43 * t68;
        out_at[9 * out_step + i] = t67 - t39 * t68;
        out_at[10 * out_step + i] = t66 + t37 * t68;
        out_at[11 * out_step + i] = t65 - t34 * t68;
    }
}

MOTORCADE_SIMD
void motorcade_similarity_blend_f64(MOTORCADE_ARGUMENTS(double))
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
        const double a6 = a_at[6 * a_step + i], a7 = a_at[7 * a_step + i], a8 = a_at[8 * a_step + i];
        const double a9 = a_at[9 * a_step + i], a10 = a_at[10 * a_step + i], a11 = a_at[11 * a_step + i];
        const double b0 = b_at[i], b1 = b_at[b_step + i], b2 = b_at[2 * b_step + i];
        const double b3 = b_at[3 * b_step + i], b4 = b_at[4 * b_step + i], b5 = b_at[5 * b_step + i];
        const double b6 = b_at[6 * b_step + i], b7 = b_at[7 * b_step + i], b8 = b_at[8 * b_step + i];
        const double b9 = b_at[9 * b_step + i], b10 = b_at[10 * b_step + i], b11 = b_at[11 * b_step + i];
        const double fraction = fraction_at[i];
        const double t0 = 1.0 - fraction;
        const double t1 = ((a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 < 0.0) ? -fraction : fraction);
        const double t2 = t0 * a0 + b0 * t1;
        const double t3 = t0 * a1 + b1 * t1;
        const double t4 = t0 * a2 + b2 * t1;
        const double t5 = t0 * a3 + b3 * t1;
        const double t6 = t0 * a4 + t1 * b4;
        const double t7 = t0 * a5 + t1 * b5;
        const double t8 = larger(larger(larger(larger(larger(fabs(t2), fabs(t3)), fabs(t4)),
            fabs(t5)), fabs(t6)), fabs(t7));
        const double t9 = t0 * a6 + t1 * b6;
        const double t10 = t0 * a7 + t1 * b7;
        const double t11 = exp2_of_integer(smaller(1.0 - exponent(larger(larger(t8, fabs(t9)),
            fabs(t10))), 1023.0));
        const double t12 = t2 * t11;
        const double t13 = t6 * t11;
        const double t14 = t12 + t13;
        const double t15 = t5 * t11;
        const double t16 = t10 * t11;
        const double t17 = t15 + t16;
        const double t18 = t4 * t11;
        const double t19 = t9 * t11;
        const double t20 = t18 + t19;
        const double t21 = t3 * t11;
        const double t22 = t7 * t11;
        const double t23 = t21 + t22;
        const double t24 = sqrt(t14 * t14 + t17 * t17 + t20 * t20 + t23 * t23);
        const double t25 = 1.0 / larger(t24, 4.930380657631324e-32);
        const double t26 = t14 * t25;
        const double t27 = t12 - t13;
        const double t28 = t15 - t16;
        const double t29 = t19 - t18;
        const double t30 = t21 - t22;
        const double t31 = sqrt(t27 * t27 + t28 * t28 + t29 * t29 + t30 * t30);
        const double t32 = 1.0 / larger(4.930380657631324e-32, t31);
        const double t33 = t27 * t32;
        const double t34 = t26 + t33;
        const double t35 = t17 * t25;
        const double t36 = t28 * t32;
        const double t37 = t35 + t36;
        const double t38 = t29 * t32;
        const double t39 = t20 * t25;
        const double t40 = t38 - t39;
        const double t41 = t23 * t25;
        const double t42 = t30 * t32;
        const double t43 = t41 + t42;
        const double t44 = sqrt(t34 * t34 + t37 * t37 + t40 * t40 + t43 * t43);
        const double t45 = 1.0 / larger(4.930380657631324e-32, t44);
        const double t46 = t34 * t45;
        const double t47 = t24 + t31;
        const double t48 = 4.440892098500626e-16 * larger(t24, t31);
        const double t49 = 1.0 / sqrt(larger(t24, t48) * larger(t31, t48));
        const double t50 = t47 * (0.5 * t49);
        const double t51 = t43 * t45;
        const double t52 = t40 * t45;
        const double t53 = t37 * t45;
        const double t54 = t49 * (2.0 * (t12 * t13 + t15 * t16 + t18 * t19 + t21 * t22) / t47);
        const double t55 = t26 * t46 + t35 * t53 - t39 * t52 + t41 * t51;
        const double t56 = t11 * (t0 * a8 + t1 * b8);
        const double t57 = t26 * t53 - t35 * t46 + t39 * t51 + t41 * t52;
        const double t58 = t11 * (t0 * a9 + t1 * b9);
        const double t59 = t39 * t46 - t41 * t53 + t26 * t52 + t35 * t51;
        const double t60 = t11 * (t0 * a10 + t1 * b10);
        const double t61 = t26 * t51 - (t41 * t46 + t35 * t52) - t39 * t53;
        const double t62 = t11 * (t0 * a11 + t1 * b11);
        const double t63 = t49 * (t55 * t56 + t57 * t58 + t59 * t60 - t61 * t62);
        const double t64 = t49 * (t55 * t62 + t57 * t60 + t56 * t61 - t58 * t59);
        const double t65 = t49 * (t55 * t60 - t57 * t62 - t56 * t59 - t58 * t61);
        const double t66 = t49 * (t55 * t58 + t59 * t62 + t60 * t61 - t56 * t57);
        const double t67 = 2.0 * (t46 * t64 - (t51 * t63 + t53 * t65) + t52 * t66) / larger(t44,
            2.220446049250313e-16);
        out_at[i] = t46 * t50;
        out_at[out_step + i] = t50 * t51;
        out_at[2 * out_step + i] = -(t50 * t52);
        out_at[3 * out_step + i] = t50 * t53;
        out_at[4 * out_step + i] = t46 * t54;
        out_at[5 * out_step + i] = t51 * t54;
        out_at[6 * out_step + i] = -(t52 * t54);
        out_at[7 * out_step + i] = t53 * t54;
        out_at[8 * out_step + i] = t63 + t42 * t67;
        out_at[9 * out_step + i] = t66 - t38 * t67;
        out_at[10 * out_step + i] = t65 + t36 * t67;
        out_at[11 * out_step + i] = t64 - t33 * t67;
    }
}
