/* Kernels of the group similarity_twists: similarity_of_twist, similarity_as_twist.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* similarity_of_twist: Similarity of a twist of any angle
 * in twist: rx ry rz x y z log_scale
 * out out: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_similarity_of_twist_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
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
        const float t23 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t24 = t23 + 1.0f;
        const float t25 = ((t5 < 0.5f) ? t24 : t24 * (t6 * t7) / largerf(1.0f, t4));
        const float t26 = t0 * t25;
        const float t27 = t1 * t25;
        const float t28 = t2 * t25;
        const float t29 = t18 * t19 + t14 * t21;
        const float t30 = -0.5f * twist3;
        const float t31 = ((fabsf(t11) < 0.5f) ? t20 : fabsf(t29) / largerf(fabsf(t15), 0.25f));
        const float t32 = t10 * t31;
        const float t33 = -0.5f * twist4;
        const float t34 = -0.5f * twist5;
        const float t35 = t2 * t33 - t1 * t34;
        const float t36 = t0 * t34 - t2 * t30;
        const float t37 = t1 * t30 - t0 * t33;
        const float t38 = (t22 * t25 - t32) / largerf(t3 + t15 * t15, 1.6940659e-21f);
        out_at[i] = t10 * t22;
        out_at[out_step + i] = t22 * t26;
        out_at[2 * out_step + i] = t22 * t27;
        out_at[3 * out_step + i] = t22 * t28;
        out_at[4 * out_step + i] = t10 * t29;
        out_at[5 * out_step + i] = t26 * t29;
        out_at[6 * out_step + i] = t27 * t29;
        out_at[7 * out_step + i] = t28 * t29;
        out_at[8 * out_step + i] = t30 * t32 + (t15 * t35 - (t2 * t36 - t1 * t37)) * t38;
        out_at[9 * out_step + i] = t32 * t33 + t38 * (t15 * t36 - (t0 * t37 - t2 * t35));
        out_at[10 * out_step + i] = t32 * t34 + t38 * (t15 * t37 - (t1 * t35 - t0 * t36));
        out_at[11 * out_step + i] = (t2 * t34 + t0 * t30 + t1 * t33) * (t25 * t31);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_of_twist_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
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
        const double t27 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t28 = t9 * (t9 * (t27 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t29 = 1.0 + t9 * (t9 * (t9 * t28 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t30 = ((t5 < 0.5) ? t29 : t29 * (t6 * t8) / larger(1.0, t4));
        const double t31 = t0 * t30;
        const double t32 = t1 * t30;
        const double t33 = t2 * t30;
        const double t34 = t21 * t22 + t16 * t25;
        const double t35 = -0.5 * twist3;
        const double t36 = ((fabs(t13) < 0.5) ? t24 : fabs(t34) / larger(fabs(t17), 0.25));
        const double t37 = t12 * t36;
        const double t38 = -0.5 * twist4;
        const double t39 = -0.5 * twist5;
        const double t40 = t2 * t38 - t1 * t39;
        const double t41 = t0 * t39 - t2 * t35;
        const double t42 = t1 * t35 - t0 * t38;
        const double t43 = (t26 * t30 - t37) / larger(t3 + t17 * t17, 1.0947644252537633e-47);
        out_at[i] = t12 * t26;
        out_at[out_step + i] = t26 * t31;
        out_at[2 * out_step + i] = t26 * t32;
        out_at[3 * out_step + i] = t26 * t33;
        out_at[4 * out_step + i] = t12 * t34;
        out_at[5 * out_step + i] = t31 * t34;
        out_at[6 * out_step + i] = t32 * t34;
        out_at[7 * out_step + i] = t33 * t34;
        out_at[8 * out_step + i] = t35 * t37 + (t17 * t40 - (t2 * t41 - t1 * t42)) * t43;
        out_at[9 * out_step + i] = t37 * t38 + t43 * (t17 * t41 - (t0 * t42 - t2 * t40));
        out_at[10 * out_step + i] = t37 * t39 + t43 * (t17 * t42 - (t1 * t40 - t0 * t41));
        out_at[11 * out_step + i] = (t2 * t39 + t0 * t35 + t1 * t38) * (t30 * t36);
    }
}

/* similarity_as_twist: Twist of a similarity, by the sign that turns by at most π
 * in m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * out out: rx ry rz x y z log_scale */

MOTORCADE_SIMD
void motorcade_similarity_as_twist_f32(MOTORCADE_ARGUMENTS(float))
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
        const float t0 = ((m0 < 0.0f) ? -1.0f : 1.0f);
        const float t1 = m0 * t0;
        const float t2 = t0 * m3;
        const float t3 = t0 * m2;
        const float t4 = t0 * m1;
        const float t5 = sqrtf(t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const float t6 = 1.0f / t5;
        const float t7 = t1 * t6;
        const float t8 = 1.0f - t7;
        const float t9 = t8 * (t8 * (t8 * (0.007290418f * t8 + -0.024990348f) + 0.04353618f) +
            -0.037681058f) + 0.02876297f;
        const float t10 = t8 * (t8 * (t8 * (t8 * t9 + 0.00298998f) + 0.02730914f) + 0.056896698f) +
            0.13334942f;
        const float t11 = t8 * (t8 * t10 + 0.33333293f) + 1.0f;
        const float t12 = t4 * t6;
        const float t13 = t3 * t6;
        const float t14 = t2 * t6;
        const float t15 = t0 * m8;
        const float t16 = t0 * m11;
        const float t17 = t7 * (t0 * m4) + t14 * (t0 * m7) + t13 * (t0 * m6) + t12 * (t0 * m5);
        const float t18 = fabsf(t17);
        const float t19 = t5 + t18;
        const float t20 = exponentf(1.4142135f * t19);
        const _Bool t21 = (t20 < 0.5f);
        const float t22 = t19 * exp2_of_integerf(-t20);
        const float t23 = (t21 ? t18 : 0.5f * (t22 - 1.0f / t22));
        const float t24 = t23 * t23;
        const float t25 = t24 * (t24 * (t24 * (0.024318371f * t24 + -0.044006806f) + 0.07497201f) +
            -0.16666622f);
        const float t26 = t25 + 1.0f;
        const float t27 = (t21 ? t26 : (t20 * 0.69311523f + (t20 * 3.1946183e-05f + t23 * t26)) /
            largerf(t18, 0.25f));
        const float t28 = t0 * m10;
        const float t29 = t12 * t28 - t14 * t15;
        const float t30 = t0 * m9;
        const float t31 = t13 * t15 - t12 * t30;
        const float t32 = 1.0f / largerf(t12 * t12 + t13 * t13 + t14 * t14 + t17 * t17,
            1.6940659e-21f);
        const float t33 = (t7 * t27 - t5 * t11) * t32;
        const float t34 = t14 * t30 - t13 * t28;
        const float t35 = t32 * (t17 * (t7 * t11 - t5 * t27));
        out_at[i] = -2.0f * (t11 * t12);
        out_at[out_step + i] = -2.0f * (t11 * t13);
        out_at[2 * out_step + i] = -2.0f * (t11 * t14);
        out_at[3 * out_step + i] = -2.0f * ((t7 * t15 + t12 * t16) * t27 + (t14 * t29 - t13 * t31) *
            t33 + t34 * t35);
        out_at[4 * out_step + i] = -2.0f * (t27 * (t7 * t30 + t13 * t16) + t33 * (t12 * t31 - t14 *
            t34) + t29 * t35);
        out_at[5 * out_step + i] = -2.0f * (t27 * (t7 * t28 + t14 * t16) + t33 * (t13 * t34 - t12 *
            t29) + t31 * t35);
        out_at[6 * out_step + i] = 2.0f * (t17 * t27);
    }
}

MOTORCADE_SIMD
void motorcade_similarity_as_twist_f64(MOTORCADE_ARGUMENTS(double))
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
        const double t0 = ((m0 < 0.0) ? -1.0 : 1.0);
        const double t1 = m0 * t0;
        const double t2 = t0 * m3;
        const double t3 = t0 * m2;
        const double t4 = t0 * m1;
        const double t5 = sqrt(t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
        const double t6 = 1.0 / t5;
        const double t7 = t1 * t6;
        const double t8 = 1.0 - t7;
        const double t9 = t8 * (t8 * (8.121007252839173e-05 * t8 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t10 = t8 * (t8 * (t9 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t11 = t8 * (t8 * (t8 * t10 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t12 = t8 * (t8 * (t8 * t11 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t13 = t8 * (t8 * (t8 * t12 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t14 = t8 * (t8 * (t8 * t13 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t15 = t8 * (t8 * (t8 * t14 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t16 = 1.0 + t8 * t15;
        const double t17 = t4 * t6;
        const double t18 = t3 * t6;
        const double t19 = t2 * t6;
        const double t20 = t0 * m8;
        const double t21 = t0 * m11;
        const double t22 = t7 * (t0 * m4) + t19 * (t0 * m7) + t18 * (t0 * m6) + t17 * (t0 * m5);
        const double t23 = fabs(t22);
        const double t24 = t5 + t23;
        const double t25 = exponent(1.4142135623730951 * t24);
        const _Bool t26 = (t25 < 0.5);
        const double t27 = t24 * exp2_of_integer(-t25);
        const double t28 = (t26 ? t23 : 0.5 * (t27 - 1.0 / t27));
        const double t29 = t28 * t28;
        const double t30 = t29 * (t29 * (-0.005811206588331519 * t29 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t31 = t29 * (t29 * (t30 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t32 = t29 * (t29 * (t29 * t31 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        const double t33 = 1.0 + t29 * t32;
        const double t34 = (t25 * 0.6931471675634384 + (t25 * 1.2996506893889889e-08 + t28 * t33)) /
            larger(t23, 0.25);
        const double t35 = (t26 ? t33 : t34);
        const double t36 = t0 * m10;
        const double t37 = t17 * t36 - t19 * t20;
        const double t38 = t0 * m9;
        const double t39 = t18 * t20 - t17 * t38;
        const double t40 = 1.0 / larger(t17 * t17 + t18 * t18 + t19 * t19 + t22 * t22,
            1.0947644252537633e-47);
        const double t41 = (t7 * t35 - t5 * t16) * t40;
        const double t42 = t19 * t38 - t18 * t36;
        const double t43 = t40 * (t22 * (t7 * t16 - t5 * t35));
        out_at[i] = -2.0 * (t16 * t17);
        out_at[out_step + i] = -2.0 * (t16 * t18);
        out_at[2 * out_step + i] = -2.0 * (t16 * t19);
        out_at[3 * out_step + i] = -2.0 * ((t7 * t20 + t17 * t21) * t35 + (t19 * t37 - t18 * t39) *
            t41 + t42 * t43);
        out_at[4 * out_step + i] = -2.0 * (t35 * (t7 * t38 + t18 * t21) + t41 * (t17 * t39 - t19 *
            t42) + t37 * t43);
        out_at[5 * out_step + i] = -2.0 * (t35 * (t7 * t36 + t19 * t21) + t41 * (t18 * t42 - t17 *
            t37) + t39 * t43);
        out_at[6 * out_step + i] = 2.0 * (t22 * t35);
    }
}
