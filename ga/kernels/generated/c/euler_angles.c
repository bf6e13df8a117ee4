/* Kernels of the group euler_angles: rotor_of_euler, motor_of_euler, rotor_tait_bryan,
 * rotor_proper_euler.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* rotor_of_euler: Rotor of three turns about three axes, the first outermost
 * in angles: first middle third
 * in axes: ax ay az bx by bz cx cy cz
 * out out: 1 e23 e31 e12 */

MOTORCADE_SIMD
void motorcade_rotor_of_euler_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict angles_at = inputs[0];
    const ptrdiff_t angles_step = input_steps[0];
    const float *restrict axes_at = inputs[1];
    const ptrdiff_t axes_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float angles0 = angles_at[i], angles1 = angles_at[angles_step + i], angles2 = angles_at[2 * angles_step + i];
        const float axes0 = axes_at[i], axes1 = axes_at[axes_step + i], axes2 = axes_at[2 * axes_step + i];
        const float axes3 = axes_at[3 * axes_step + i], axes4 = axes_at[4 * axes_step + i], axes5 = axes_at[5 * axes_step + i];
        const float axes6 = axes_at[6 * axes_step + i], axes7 = axes_at[7 * axes_step + i], axes8 = axes_at[8 * axes_step + i];
        const float t0 = 0.5f * angles0;
        const float t1 = fabsf(t0);
        const float t2 = floorf(0.5f + 0.31830987f * t1);
        const float t3 = 1.0f - 2.0f * (t2 - floorf(0.5f * t2) * 2.0f);
        const float t4 = t1 - t2 * 3.140625f - t2 * 0.0009675026f - t2 * 1.5099067e-07f - t2 *
            5.126688e-12f;
        const float t5 = t4 * t4;
        const float t6 = t5 * (t5 * (t5 * (-2.6050063e-07f * t5 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t7 = t3 * (t5 * (t6 + -0.5f) + 1.0f);
        const float t8 = 0.5f * angles1;
        const float t9 = fabsf(t8);
        const float t10 = floorf(0.5f + 0.31830987f * t9);
        const float t11 = 1.0f - 2.0f * (t10 - 2.0f * floorf(0.5f * t10));
        const float t12 = t9 - 3.140625f * t10 - 0.0009675026f * t10 - 1.5099067e-07f * t10 -
            5.126688e-12f * t10;
        const float t13 = t12 * t12;
        const float t14 = 0.041666634f + t13 * (-0.001388836f + t13 * (2.4760076e-05f +
            -2.6050063e-07f * t13));
        const float t15 = t11 * (1.0f + t13 * (-0.5f + t13 * t14));
        const float t16 = t5 * (t5 * (t5 * (t5 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t17 = t16 + 1.0f;
        const float t18 = t0 * ((t2 < 0.5f) ? t17 : t17 * (t3 * t4) / largerf(1.0f, t1));
        const float t19 = t18 * axes2;
        const float t20 = t13 * (-0.16666658f + t13 * (0.00833305f + t13 * (-0.00019808991f + t13 *
            2.6050482e-06f)));
        const float t21 = 1.0f + t20;
        const float t22 = t8 * ((t10 < 0.5f) ? t21 : t21 * (t11 * t12) / largerf(1.0f, t9));
        const float t23 = t22 * axes5;
        const float t24 = t18 * axes1;
        const float t25 = t22 * axes4;
        const float t26 = t18 * axes0;
        const float t27 = t22 * axes3;
        const float t28 = t7 * t15 - t19 * t23 - t24 * t25 - t26 * t27;
        const float t29 = 0.5f * angles2;
        const float t30 = fabsf(t29);
        const float t31 = floorf(0.5f + 0.31830987f * t30);
        const float t32 = 1.0f - 2.0f * (t31 - 2.0f * floorf(0.5f * t31));
        const float t33 = t30 - 3.140625f * t31 - 0.0009675026f * t31 - 1.5099067e-07f * t31 -
            5.126688e-12f * t31;
        const float t34 = t33 * t33;
        const float t35 = 0.041666634f + t34 * (-0.001388836f + t34 * (2.4760076e-05f +
            -2.6050063e-07f * t34));
        const float t36 = t32 * (1.0f + t34 * (-0.5f + t34 * t35));
        const float t37 = t24 * t27 - (t7 * t23 + t15 * t19 + t25 * t26);
        const float t38 = t34 * (-0.16666658f + t34 * (0.00833305f + t34 * (-0.00019808991f +
            2.6050482e-06f * t34)));
        const float t39 = 1.0f + t38;
        const float t40 = t29 * ((t31 < 0.5f) ? t39 : t39 * (t32 * t33) / largerf(1.0f, t30));
        const float t41 = t40 * axes8;
        const float t42 = t7 * t25 + t19 * t27 + t15 * t24 - t23 * t26;
        const float t43 = t40 * axes7;
        const float t44 = t19 * t25 - (t7 * t27 + t23 * t24 + t15 * t26);
        const float t45 = t40 * axes6;
        const float t46 = t28 * t36 + t37 * t41 - t42 * t43 + t44 * t45;
        const float t47 = t36 * t44 - (t28 * t45 + t41 * t42);
        const float t48 = t37 * t43;
        const float t49 = t47 - t48;
        const float t50 = ((fabsf(t46) < fabsf(t49)) ? t48 - t47 : t46);
        const float t51 = t28 * t43 - t37 * t45 + t36 * t42 + t41 * t44;
        const float t52 = ((fabsf(t50) < fabsf(t51)) ? t51 : t50);
        const float t53 = t36 * t37 - t28 * t41 + t43 * t44 + t42 * t45;
        const float t54 = ((((fabsf(t52) < fabsf(t53)) ? -t53 : t52) < 0.0f) ? -1.0f : 1.0f);
        out_at[i] = t46 * t54;
        out_at[out_step + i] = t49 * t54;
        out_at[2 * out_step + i] = -(t51 * t54);
        out_at[3 * out_step + i] = t53 * t54;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_of_euler_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict angles_at = inputs[0];
    const ptrdiff_t angles_step = input_steps[0];
    const double *restrict axes_at = inputs[1];
    const ptrdiff_t axes_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double angles0 = angles_at[i], angles1 = angles_at[angles_step + i], angles2 = angles_at[2 * angles_step + i];
        const double axes0 = axes_at[i], axes1 = axes_at[axes_step + i], axes2 = axes_at[2 * axes_step + i];
        const double axes3 = axes_at[3 * axes_step + i], axes4 = axes_at[4 * axes_step + i], axes5 = axes_at[5 * axes_step + i];
        const double axes6 = axes_at[6 * axes_step + i], axes7 = axes_at[7 * axes_step + i], axes8 = axes_at[8 * axes_step + i];
        const double t0 = 0.5 * angles0;
        const double t1 = fabs(t0);
        const double t2 = floor(0.5 + 0.3183098861837907 * t1);
        const double t3 = 1.0 - 2.0 * (t2 - floor(0.5 * t2) * 2.0);
        const double t4 = t1 - t2 * 3.1415926218032837 - t2 * 3.1786509424591713e-08 - t2 *
            1.2246467202362698e-16;
        const double t5 = t4 - t2 * 7.891108333126411e-24;
        const double t6 = t5 * t5;
        const double t7 = t6 * (t6 * (4.608909074888812e-14 * t6 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t8 = t6 * (t6 * (t7 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t9 = t3 * (1.0 + t6 * (t6 * (t6 * t8 + 0.041666666666663875) +
            -0.4999999999999997));
        const double t10 = 0.5 * angles1;
        const double t11 = fabs(t10);
        const double t12 = floor(0.5 + 0.3183098861837907 * t11);
        const double t13 = 1.0 - 2.0 * (t12 - 2.0 * floor(0.5 * t12));
        const double t14 = t11 - 3.1415926218032837 * t12 - 3.1786509424591713e-08 * t12 -
            1.2246467202362698e-16 * t12;
        const double t15 = t14 - 7.891108333126411e-24 * t12;
        const double t16 = t15 * t15;
        const double t17 = 2.0876561604575935e-09 + t16 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t16);
        const double t18 = -0.0013888888888772708 + t16 * (2.4801587277366174e-05 + t16 *
            (-2.7557316386461366e-07 + t16 * t17));
        const double t19 = t13 * (1.0 + t16 * (-0.4999999999999997 + t16 * (0.041666666666663875 +
            t16 * t18)));
        const double t20 = t6 * (t6 * (t6 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t21 = t6 * (t6 * (t20 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t22 = 1.0 + t6 * (t6 * (t6 * t21 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t23 = t0 * ((t2 < 0.5) ? t22 : t22 * (t3 * t5) / larger(1.0, t1));
        const double t24 = t23 * axes2;
        const double t25 = 1.6058940754212953e-10 + t16 * (-7.643023238169083e-13 + t16 *
            2.721539074015491e-15);
        const double t26 = -0.00019841269841208527 + t16 * (2.755731921120387e-06 + t16 *
            (-2.505210688815946e-08 + t16 * t25));
        const double t27 = 1.0 + t16 * (-0.16666666666666666 + t16 * (0.008333333333333186 + t16 *
            t26));
        const double t28 = t10 * ((t12 < 0.5) ? t27 : t27 * (t13 * t15) / larger(1.0, t11));
        const double t29 = t28 * axes5;
        const double t30 = t23 * axes1;
        const double t31 = t28 * axes4;
        const double t32 = t23 * axes0;
        const double t33 = t28 * axes3;
        const double t34 = t9 * t19 - t24 * t29 - t30 * t31 - t32 * t33;
        const double t35 = 0.5 * angles2;
        const double t36 = fabs(t35);
        const double t37 = floor(0.5 + 0.3183098861837907 * t36);
        const double t38 = 1.0 - 2.0 * (t37 - 2.0 * floor(0.5 * t37));
        const double t39 = t36 - 3.1415926218032837 * t37 - 3.1786509424591713e-08 * t37 -
            1.2246467202362698e-16 * t37;
        const double t40 = t39 - 7.891108333126411e-24 * t37;
        const double t41 = t40 * t40;
        const double t42 = 2.0876561604575935e-09 + t41 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t41);
        const double t43 = -0.0013888888888772708 + t41 * (2.4801587277366174e-05 + t41 *
            (-2.7557316386461366e-07 + t41 * t42));
        const double t44 = t38 * (1.0 + t41 * (-0.4999999999999997 + t41 * (0.041666666666663875 +
            t41 * t43)));
        const double t45 = t30 * t33 - (t9 * t29 + t19 * t24 + t31 * t32);
        const double t46 = 1.6058940754212953e-10 + t41 * (-7.643023238169083e-13 +
            2.721539074015491e-15 * t41);
        const double t47 = -0.00019841269841208527 + t41 * (2.755731921120387e-06 + t41 *
            (-2.505210688815946e-08 + t41 * t46));
        const double t48 = 1.0 + t41 * (-0.16666666666666666 + t41 * (0.008333333333333186 + t41 *
            t47));
        const double t49 = t35 * ((t37 < 0.5) ? t48 : t48 * (t38 * t40) / larger(1.0, t36));
        const double t50 = t49 * axes8;
        const double t51 = t9 * t31 + t24 * t33 + t19 * t30 - t29 * t32;
        const double t52 = t49 * axes7;
        const double t53 = t24 * t31 - (t9 * t33 + t29 * t30 + t19 * t32);
        const double t54 = t49 * axes6;
        const double t55 = t34 * t44 + t45 * t50 - t51 * t52 + t53 * t54;
        const double t56 = t44 * t53 - (t34 * t54 + t50 * t51);
        const double t57 = t45 * t52;
        const double t58 = t56 - t57;
        const double t59 = ((fabs(t55) < fabs(t58)) ? t57 - t56 : t55);
        const double t60 = t34 * t52 - t45 * t54 + t44 * t51 + t50 * t53;
        const double t61 = ((fabs(t59) < fabs(t60)) ? t60 : t59);
        const double t62 = t44 * t45 - t34 * t50 + t52 * t53 + t51 * t54;
        const double t63 = ((((fabs(t61) < fabs(t62)) ? -t62 : t61) < 0.0) ? -1.0 : 1.0);
        out_at[i] = t55 * t63;
        out_at[out_step + i] = t58 * t63;
        out_at[2 * out_step + i] = -(t60 * t63);
        out_at[3 * out_step + i] = t62 * t63;
    }
}

/* motor_of_euler: Motor of three turns about three axes, the first outermost, then of a translation
 * in angles: first middle third
 * in axes: ax ay az bx by bz cx cy cz
 * in t: x y z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞ */

MOTORCADE_SIMD
void motorcade_motor_of_euler_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict angles_at = inputs[0];
    const ptrdiff_t angles_step = input_steps[0];
    const float *restrict axes_at = inputs[1];
    const ptrdiff_t axes_step = input_steps[1];
    const float *restrict t_at = inputs[2];
    const ptrdiff_t t_step = input_steps[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float angles0 = angles_at[i], angles1 = angles_at[angles_step + i], angles2 = angles_at[2 * angles_step + i];
        const float axes0 = axes_at[i], axes1 = axes_at[axes_step + i], axes2 = axes_at[2 * axes_step + i];
        const float axes3 = axes_at[3 * axes_step + i], axes4 = axes_at[4 * axes_step + i], axes5 = axes_at[5 * axes_step + i];
        const float axes6 = axes_at[6 * axes_step + i], axes7 = axes_at[7 * axes_step + i], axes8 = axes_at[8 * axes_step + i];
        const float t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const float t3 = 0.5f * angles0;
        const float t4 = fabsf(t3);
        const float t5 = floorf(0.5f + 0.31830987f * t4);
        const float t6 = 1.0f - 2.0f * (t5 - floorf(0.5f * t5) * 2.0f);
        const float t7 = t4 - t5 * 3.140625f - t5 * 0.0009675026f - t5 * 1.5099067e-07f - t5 *
            5.126688e-12f;
        const float t8 = t7 * t7;
        const float t9 = t8 * (t8 * (t8 * (-2.6050063e-07f * t8 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f);
        const float t10 = t6 * (t8 * (t9 + -0.5f) + 1.0f);
        const float t11 = 0.5f * angles1;
        const float t12 = fabsf(t11);
        const float t13 = floorf(0.5f + 0.31830987f * t12);
        const float t14 = 1.0f - 2.0f * (t13 - 2.0f * floorf(0.5f * t13));
        const float t15 = t12 - 3.140625f * t13 - 0.0009675026f * t13 - 1.5099067e-07f * t13 -
            5.126688e-12f * t13;
        const float t16 = t15 * t15;
        const float t17 = 0.041666634f + t16 * (-0.001388836f + t16 * (2.4760076e-05f +
            -2.6050063e-07f * t16));
        const float t18 = t14 * (1.0f + t16 * (-0.5f + t16 * t17));
        const float t19 = t8 * (t8 * (t8 * (t8 * 2.6050482e-06f + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t20 = t19 + 1.0f;
        const float t21 = t3 * ((t5 < 0.5f) ? t20 : t20 * (t6 * t7) / largerf(1.0f, t4));
        const float t22 = t21 * axes2;
        const float t23 = t16 * (-0.16666658f + t16 * (0.00833305f + t16 * (-0.00019808991f + t16 *
            2.6050482e-06f)));
        const float t24 = 1.0f + t23;
        const float t25 = t11 * ((t13 < 0.5f) ? t24 : t24 * (t14 * t15) / largerf(1.0f, t12));
        const float t26 = t25 * axes5;
        const float t27 = t21 * axes1;
        const float t28 = t25 * axes4;
        const float t29 = t21 * axes0;
        const float t30 = t25 * axes3;
        const float t31 = t10 * t18 - t22 * t26 - t27 * t28 - t29 * t30;
        const float t32 = 0.5f * angles2;
        const float t33 = fabsf(t32);
        const float t34 = floorf(0.5f + 0.31830987f * t33);
        const float t35 = 1.0f - 2.0f * (t34 - 2.0f * floorf(0.5f * t34));
        const float t36 = t33 - 3.140625f * t34 - 0.0009675026f * t34 - 1.5099067e-07f * t34 -
            5.126688e-12f * t34;
        const float t37 = t36 * t36;
        const float t38 = 0.041666634f + t37 * (-0.001388836f + t37 * (2.4760076e-05f +
            -2.6050063e-07f * t37));
        const float t39 = t35 * (1.0f + t37 * (-0.5f + t37 * t38));
        const float t40 = t27 * t30 - (t10 * t26 + t18 * t22 + t28 * t29);
        const float t41 = t37 * (-0.16666658f + t37 * (0.00833305f + t37 * (-0.00019808991f +
            2.6050482e-06f * t37)));
        const float t42 = 1.0f + t41;
        const float t43 = t32 * ((t34 < 0.5f) ? t42 : t42 * (t35 * t36) / largerf(1.0f, t33));
        const float t44 = t43 * axes8;
        const float t45 = t10 * t28 + t22 * t30 + t18 * t27 - t26 * t29;
        const float t46 = t43 * axes7;
        const float t47 = t22 * t28 - (t10 * t30 + t26 * t27 + t18 * t29);
        const float t48 = t43 * axes6;
        const float t49 = t31 * t39 + t40 * t44 - t45 * t46 + t47 * t48;
        const float t50 = t39 * t47 - (t31 * t48 + t44 * t45);
        const float t51 = t40 * t46;
        const float t52 = t50 - t51;
        const float t53 = ((fabsf(t49) < fabsf(t52)) ? t51 - t50 : t49);
        const float t54 = t31 * t46 - t40 * t48 + t39 * t45 + t44 * t47;
        const float t55 = ((fabsf(t53) < fabsf(t54)) ? t54 : t53);
        const float t56 = t39 * t40 - t31 * t44 + t46 * t47 + t45 * t48;
        const float t57 = ((((fabsf(t55) < fabsf(t56)) ? -t56 : t55) < 0.0f) ? -1.0f : 1.0f);
        const float t58 = t49 * t57;
        const float t59 = t52 * t57;
        const float t60 = t54 * t57;
        const float t61 = t56 * t57;
        const float t62 = -0.5f * t0;
        const float t63 = -0.5f * t1;
        const float t64 = -0.5f * t2;
        out_at[i] = t58;
        out_at[out_step + i] = t59;
        out_at[2 * out_step + i] = -t60;
        out_at[3 * out_step + i] = t61;
        out_at[4 * out_step + i] = t58 * t62 - t61 * t63 - t60 * t64;
        out_at[5 * out_step + i] = t61 * t62 + t58 * t63 - t59 * t64;
        out_at[6 * out_step + i] = t60 * t62 + t59 * t63 + t58 * t64;
        out_at[7 * out_step + i] = t59 * t62 + t61 * t64 - t60 * t63;
    }
}

MOTORCADE_SIMD
void motorcade_motor_of_euler_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict angles_at = inputs[0];
    const ptrdiff_t angles_step = input_steps[0];
    const double *restrict axes_at = inputs[1];
    const ptrdiff_t axes_step = input_steps[1];
    const double *restrict t_at = inputs[2];
    const ptrdiff_t t_step = input_steps[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double angles0 = angles_at[i], angles1 = angles_at[angles_step + i], angles2 = angles_at[2 * angles_step + i];
        const double axes0 = axes_at[i], axes1 = axes_at[axes_step + i], axes2 = axes_at[2 * axes_step + i];
        const double axes3 = axes_at[3 * axes_step + i], axes4 = axes_at[4 * axes_step + i], axes5 = axes_at[5 * axes_step + i];
        const double axes6 = axes_at[6 * axes_step + i], axes7 = axes_at[7 * axes_step + i], axes8 = axes_at[8 * axes_step + i];
        const double t0 = t_at[i], t1 = t_at[t_step + i], t2 = t_at[2 * t_step + i];
        const double t3 = 0.5 * angles0;
        const double t4 = fabs(t3);
        const double t5 = floor(0.5 + 0.3183098861837907 * t4);
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
        const double t13 = 0.5 * angles1;
        const double t14 = fabs(t13);
        const double t15 = floor(0.5 + 0.3183098861837907 * t14);
        const double t16 = 1.0 - 2.0 * (t15 - 2.0 * floor(0.5 * t15));
        const double t17 = t14 - 3.1415926218032837 * t15 - 3.1786509424591713e-08 * t15 -
            1.2246467202362698e-16 * t15;
        const double t18 = t17 - 7.891108333126411e-24 * t15;
        const double t19 = t18 * t18;
        const double t20 = 2.0876561604575935e-09 + t19 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t19);
        const double t21 = -0.0013888888888772708 + t19 * (2.4801587277366174e-05 + t19 *
            (-2.7557316386461366e-07 + t19 * t20));
        const double t22 = t16 * (1.0 + t19 * (-0.4999999999999997 + t19 * (0.041666666666663875 +
            t19 * t21)));
        const double t23 = t9 * (t9 * (t9 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t24 = t9 * (t9 * (t23 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t25 = 1.0 + t9 * (t9 * (t9 * t24 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t26 = t3 * ((t5 < 0.5) ? t25 : t25 * (t6 * t8) / larger(1.0, t4));
        const double t27 = t26 * axes2;
        const double t28 = 1.6058940754212953e-10 + t19 * (-7.643023238169083e-13 + t19 *
            2.721539074015491e-15);
        const double t29 = -0.00019841269841208527 + t19 * (2.755731921120387e-06 + t19 *
            (-2.505210688815946e-08 + t19 * t28));
        const double t30 = 1.0 + t19 * (-0.16666666666666666 + t19 * (0.008333333333333186 + t19 *
            t29));
        const double t31 = t13 * ((t15 < 0.5) ? t30 : t30 * (t16 * t18) / larger(1.0, t14));
        const double t32 = t31 * axes5;
        const double t33 = t26 * axes1;
        const double t34 = t31 * axes4;
        const double t35 = t26 * axes0;
        const double t36 = t31 * axes3;
        const double t37 = t12 * t22 - t27 * t32 - t33 * t34 - t35 * t36;
        const double t38 = 0.5 * angles2;
        const double t39 = fabs(t38);
        const double t40 = floor(0.5 + 0.3183098861837907 * t39);
        const double t41 = 1.0 - 2.0 * (t40 - 2.0 * floor(0.5 * t40));
        const double t42 = t39 - 3.1415926218032837 * t40 - 3.1786509424591713e-08 * t40 -
            1.2246467202362698e-16 * t40;
        const double t43 = t42 - 7.891108333126411e-24 * t40;
        const double t44 = t43 * t43;
        const double t45 = 2.0876561604575935e-09 + t44 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t44);
        const double t46 = -0.0013888888888772708 + t44 * (2.4801587277366174e-05 + t44 *
            (-2.7557316386461366e-07 + t44 * t45));
        const double t47 = t41 * (1.0 + t44 * (-0.4999999999999997 + t44 * (0.041666666666663875 +
            t44 * t46)));
        const double t48 = t33 * t36 - (t12 * t32 + t22 * t27 + t34 * t35);
        const double t49 = 1.6058940754212953e-10 + t44 * (-7.643023238169083e-13 +
            2.721539074015491e-15 * t44);
        const double t50 = -0.00019841269841208527 + t44 * (2.755731921120387e-06 + t44 *
            (-2.505210688815946e-08 + t44 * t49));
        const double t51 = 1.0 + t44 * (-0.16666666666666666 + t44 * (0.008333333333333186 + t44 *
            t50));
        const double t52 = t38 * ((t40 < 0.5) ? t51 : t51 * (t41 * t43) / larger(1.0, t39));
        const double t53 = t52 * axes8;
        const double t54 = t12 * t34 + t27 * t36 + t22 * t33 - t32 * t35;
        const double t55 = t52 * axes7;
        const double t56 = t27 * t34 - (t12 * t36 + t32 * t33 + t22 * t35);
        const double t57 = t52 * axes6;
        const double t58 = t37 * t47 + t48 * t53 - t54 * t55 + t56 * t57;
        const double t59 = t47 * t56 - (t37 * t57 + t53 * t54);
        const double t60 = t48 * t55;
        const double t61 = t59 - t60;
        const double t62 = ((fabs(t58) < fabs(t61)) ? t60 - t59 : t58);
        const double t63 = t37 * t55 - t48 * t57 + t47 * t54 + t53 * t56;
        const double t64 = ((fabs(t62) < fabs(t63)) ? t63 : t62);
        const double t65 = t47 * t48 - t37 * t53 + t55 * t56 + t54 * t57;
        const double t66 = ((((fabs(t64) < fabs(t65)) ? -t65 : t64) < 0.0) ? -1.0 : 1.0);
        const double t67 = t58 * t66;
        const double t68 = t61 * t66;
        const double t69 = t63 * t66;
        const double t70 = t65 * t66;
        const double t71 = -0.5 * t0;
        const double t72 = -0.5 * t1;
        const double t73 = -0.5 * t2;
        out_at[i] = t67;
        out_at[out_step + i] = t68;
        out_at[2 * out_step + i] = -t69;
        out_at[3 * out_step + i] = t70;
        out_at[4 * out_step + i] = t67 * t71 - t70 * t72 - t69 * t73;
        out_at[5 * out_step + i] = t70 * t71 + t67 * t72 - t68 * t73;
        out_at[6 * out_step + i] = t69 * t71 + t68 * t72 + t67 * t73;
        out_at[7 * out_step + i] = t68 * t71 + t70 * t73 - t69 * t72;
    }
}

/* rotor_tait_bryan: Angles of a rotor about three different axes
 * in r: 1 e23 e31 e12
 * in s: ax ay az bx by bz cx cy cz cyclic
 * out out: first middle third */

MOTORCADE_SIMD
void motorcade_rotor_tait_bryan_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const float *restrict s_at = inputs[1];
    const ptrdiff_t s_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const float s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const float s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const float s9 = s_at[9 * s_step + i];
        const float t0 = r1 * s3 + r2 * s4 + r3 * s5;
        const float t1 = r1 * s6 + r2 * s7 + r3 * s8;
        const float t2 = t0 * t1;
        const float t3 = s9 * r0;
        const float t4 = r1 * s0 + r2 * s1 + r3 * s2;
        const float t5 = t3 * t4;
        const float t6 = s9 * ((t2 + t5) * 2.0f);
        const float t7 = t4 * t4;
        const float t8 = 1.0f - 2.0f * (t7 + t0 * t0);
        const float t9 = sqrtf(t6 * t6 + t8 * t8);
        const float t10 = ((-t9 < -2.1474837e-06f) ? 1.5f : 0.5f) - 0.5f;
        const float t11 = fabsf(t6);
        const float t12 = fabsf(t8);
        const float t13 = smallerf(t11, t12) / (largerf(t11, t12) + 1e-30f);
        const float t14 = t13 * t13;
        const float t15 = t14 * (t14 * (t14 * (-0.0017011701f * t14 + 0.01048765f) + -0.030351864f)
            + 0.057089556f);
        const float t16 = t14 * (t14 * (t14 * (t15 + -0.08349725f) + 0.10932341f) + -0.14260016f) +
            0.19998075f;
        const float t17 = ((t12 - t11 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t18 = t13 * (t14 * (t14 * t16 + -0.33333278f) + 1.0f) * (1.0f - 2.0f * t17) +
            t17 * 1.5707964f;
        const float t19 = ((t8 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t20 = (t18 * (1.0f - 2.0f * t19) + t19 * 3.1415927f) * (1.0f - 2.0f * (((-t6 <
            0.0f) ? 1.5f : 0.5f) - 0.5f));
        const float t21 = t1 * t4;
        const float t22 = t0 * t3;
        const float t23 = s9 * (2.0f * (t21 - t22));
        const float t24 = fabsf(t23);
        const float t25 = smallerf(t9, t24) / (1e-30f + largerf(t9, t24));
        const float t26 = t25 * t25;
        const float t27 = t26 * (0.057089556f + t26 * (-0.030351864f + t26 * (0.01048765f +
            -0.0017011701f * t26)));
        const float t28 = 0.19998075f + t26 * (-0.14260016f + t26 * (0.10932341f + t26 *
            (-0.08349725f + t27)));
        const float t29 = ((t9 - t24 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t30 = t25 * (1.0f + t26 * (-0.33333278f + t26 * t28)) * (1.0f - 2.0f * t29) +
            1.5707964f * t29;
        const float t31 = t10 / (t9 + 1e-30f);
        const float t32 = t8 * t31 + (1.0f - t10);
        const float t33 = s9 * (t6 * t31);
        const float t34 = s9 * (t32 * (2.0f * (t0 * t4 - t1 * t3)) - t33 * (2.0f * (t21 + t22)));
        const float t35 = fabsf(t34);
        const float t36 = t32 * (1.0f - 2.0f * (t7 + t1 * t1)) - t33 * (2.0f * (t2 - t5));
        const float t37 = fabsf(t36);
        const float t38 = smallerf(t35, t37) / (1e-30f + largerf(t35, t37));
        const float t39 = t38 * t38;
        const float t40 = t39 * (0.057089556f + t39 * (-0.030351864f + t39 * (0.01048765f +
            -0.0017011701f * t39)));
        const float t41 = 0.19998075f + t39 * (-0.14260016f + t39 * (0.10932341f + t39 *
            (-0.08349725f + t40)));
        const float t42 = ((t37 - t35 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t43 = t38 * (1.0f + t39 * (-0.33333278f + t39 * t41)) * (1.0f - 2.0f * t42) +
            1.5707964f * t42;
        const float t44 = ((t36 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t45 = (t43 * (1.0f - 2.0f * t44) + 3.1415927f * t44) * (1.0f - 2.0f * (((t34 <
            0.0f) ? 1.5f : 0.5f) - 0.5f));
        out_at[i] = t10 * t20;
        out_at[out_step + i] = t30 * (1.0f - 2.0f * (((t23 < 0.0f) ? 1.5f : 0.5f) - 0.5f));
        out_at[2 * out_step + i] = t45;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_tait_bryan_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const double *restrict s_at = inputs[1];
    const ptrdiff_t s_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const double s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const double s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const double s9 = s_at[9 * s_step + i];
        const double t0 = r1 * s3 + r2 * s4 + r3 * s5;
        const double t1 = r1 * s6 + r2 * s7 + r3 * s8;
        const double t2 = t0 * t1;
        const double t3 = s9 * r0;
        const double t4 = r1 * s0 + r2 * s1 + r3 * s2;
        const double t5 = t3 * t4;
        const double t6 = s9 * ((t2 + t5) * 2.0);
        const double t7 = t4 * t4;
        const double t8 = 1.0 - 2.0 * (t7 + t0 * t0);
        const double t9 = sqrt(t6 * t6 + t8 * t8);
        const double t10 = ((-t9 < -4e-15) ? 1.5 : 0.5) - 0.5;
        const double t11 = fabs(t6);
        const double t12 = fabs(t8);
        const double t13 = smaller(t11, t12) / (larger(t11, t12) + 1e-30);
        const double t14 = t13 * t13;
        const double t15 = t14 * (1.2631178430477426e-05 * t14 + -0.00014617088163625013) +
            0.0008033604181626027;
        const double t16 = t14 * (t14 * (t14 * t15 + -0.0028047655531701315) + 0.007038646202989813)
            + -0.013674139288399478;
        const double t17 = t14 * (t14 * (t14 * t16 + 0.021740213830758134) + -0.02970071773623423) +
            0.03651081352721035;
        const double t18 = t14 * (t14 * (t14 * t17 + -0.042125723963855326) + 0.04719723992321112) +
            -0.052527255573225747;
        const double t19 = t14 * (t14 * (t14 * t18 + 0.05880342002401543) + -0.06666371187721098) +
            0.0769227555520563;
        const double t20 = t14 * (t14 * (t14 * t19 + -0.09090906605656898) + 0.11111110982087126) +
            -0.14285714281592693;
        const double t21 = ((t12 - t11 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t22 = t13 * (1.0 + t14 * (t14 * (t14 * t20 + 0.19999999999929946) +
            -0.3333333333333286)) * (1.0 - 2.0 * t21);
        const double t23 = ((t8 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t24 = ((t22 + t21 * 1.5707963267948966) * (1.0 - 2.0 * t23) + t23 *
            3.141592653589793) * (1.0 - 2.0 * (((-t6 < 0.0) ? 1.5 : 0.5) - 0.5));
        const double t25 = t1 * t4;
        const double t26 = t0 * t3;
        const double t27 = s9 * (2.0 * (t25 - t26));
        const double t28 = fabs(t27);
        const double t29 = smaller(t9, t28) / (1e-30 + larger(t9, t28));
        const double t30 = t29 * t29;
        const double t31 = 0.0008033604181626027 + t30 * (-0.00014617088163625013 +
            1.2631178430477426e-05 * t30);
        const double t32 = -0.013674139288399478 + t30 * (0.007038646202989813 + t30 *
            (-0.0028047655531701315 + t30 * t31));
        const double t33 = 0.03651081352721035 + t30 * (-0.02970071773623423 + t30 *
            (0.021740213830758134 + t30 * t32));
        const double t34 = -0.052527255573225747 + t30 * (0.04719723992321112 + t30 *
            (-0.042125723963855326 + t30 * t33));
        const double t35 = 0.0769227555520563 + t30 * (-0.06666371187721098 + t30 *
            (0.05880342002401543 + t30 * t34));
        const double t36 = -0.14285714281592693 + t30 * (0.11111110982087126 + t30 *
            (-0.09090906605656898 + t30 * t35));
        const double t37 = ((t9 - t28 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t38 = t29 * (1.0 + t30 * (-0.3333333333333286 + t30 * (0.19999999999929946 +
            t30 * t36))) * (1.0 - 2.0 * t37);
        const double t39 = t10 / (t9 + 1e-30);
        const double t40 = t8 * t39 + (1.0 - t10);
        const double t41 = s9 * (t6 * t39);
        const double t42 = s9 * (t40 * (2.0 * (t0 * t4 - t1 * t3)) - t41 * (2.0 * (t25 + t26)));
        const double t43 = fabs(t42);
        const double t44 = t40 * (1.0 - 2.0 * (t7 + t1 * t1)) - t41 * (2.0 * (t2 - t5));
        const double t45 = fabs(t44);
        const double t46 = smaller(t43, t45) / (1e-30 + larger(t43, t45));
        const double t47 = t46 * t46;
        const double t48 = 0.0008033604181626027 + t47 * (-0.00014617088163625013 +
            1.2631178430477426e-05 * t47);
        const double t49 = -0.013674139288399478 + t47 * (0.007038646202989813 + t47 *
            (-0.0028047655531701315 + t47 * t48));
        const double t50 = 0.03651081352721035 + t47 * (-0.02970071773623423 + t47 *
            (0.021740213830758134 + t47 * t49));
        const double t51 = -0.052527255573225747 + t47 * (0.04719723992321112 + t47 *
            (-0.042125723963855326 + t47 * t50));
        const double t52 = 0.0769227555520563 + t47 * (-0.06666371187721098 + t47 *
            (0.05880342002401543 + t47 * t51));
        const double t53 = -0.14285714281592693 + t47 * (0.11111110982087126 + t47 *
            (-0.09090906605656898 + t47 * t52));
        const double t54 = ((t45 - t43 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t55 = t46 * (1.0 + t47 * (-0.3333333333333286 + t47 * (0.19999999999929946 +
            t47 * t53))) * (1.0 - 2.0 * t54);
        const double t56 = ((t44 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t57 = ((t55 + 1.5707963267948966 * t54) * (1.0 - 2.0 * t56) + 3.141592653589793
            * t56) * (1.0 - 2.0 * (((t42 < 0.0) ? 1.5 : 0.5) - 0.5));
        out_at[i] = t10 * t24;
        out_at[out_step + i] = (t38 + 1.5707963267948966 * t37) * (1.0 - 2.0 * (((t27 < 0.0) ? 1.5 :
            0.5) - 0.5));
        out_at[2 * out_step + i] = t57;
    }
}

/* rotor_proper_euler: Angles of a rotor about two axes, the first of them twice
 * in r: 1 e23 e31 e12
 * in s: ax ay az bx by bz cx cy cz cyclic
 * out out: first middle third */

MOTORCADE_SIMD
void motorcade_rotor_proper_euler_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const float *restrict s_at = inputs[1];
    const ptrdiff_t s_step = input_steps[1];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const float r3 = r_at[3 * r_step + i];
        const float s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const float s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const float s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const float s9 = s_at[9 * s_step + i];
        const float t0 = r1 * s3 + r2 * s4 + r3 * s5;
        const float t1 = r1 * s0 + r2 * s1 + r3 * s2;
        const float t2 = s9 * r0;
        const float t3 = r1 * s6 + r2 * s7 + r3 * s8;
        const float t4 = (t0 * t1 - t2 * t3) * 2.0f;
        const float t5 = s9 * (2.0f * (t1 * t3 + t0 * t2));
        const float t6 = sqrtf(t4 * t4 + t5 * t5);
        const float t7 = ((-t6 < -2.1474837e-06f) ? 1.5f : 0.5f) - 0.5f;
        const float t8 = fabsf(t4);
        const float t9 = fabsf(t5);
        const float t10 = smallerf(t8, t9) / (largerf(t8, t9) + 1e-30f);
        const float t11 = t10 * t10;
        const float t12 = t11 * (t11 * (t11 * (-0.0017011701f * t11 + 0.01048765f) + -0.030351864f)
            + 0.057089556f);
        const float t13 = t11 * (t11 * (t11 * (t12 + -0.08349725f) + 0.10932341f) + -0.14260016f) +
            0.19998075f;
        const float t14 = ((t9 - t8 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t15 = t10 * (t11 * (t11 * t13 + -0.33333278f) + 1.0f) * (1.0f - 2.0f * t14) +
            t14 * 1.5707964f;
        const float t16 = ((-t5 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t17 = (t15 * (1.0f - 2.0f * t16) + t16 * 3.1415927f) * (1.0f - 2.0f * (((t4 <
            0.0f) ? 1.5f : 0.5f) - 0.5f));
        const float t18 = t0 * t0;
        const float t19 = t3 * t3;
        const float t20 = 1.0f - 2.0f * (t18 + t19);
        const float t21 = fabsf(t20);
        const float t22 = smallerf(t6, t21) / (1e-30f + largerf(t6, t21));
        const float t23 = t22 * t22;
        const float t24 = t23 * (0.057089556f + t23 * (-0.030351864f + t23 * (0.01048765f +
            -0.0017011701f * t23)));
        const float t25 = 0.19998075f + t23 * (-0.14260016f + t23 * (0.10932341f + t23 *
            (-0.08349725f + t24)));
        const float t26 = ((t21 - t6 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t27 = t22 * (1.0f + t23 * (-0.33333278f + t23 * t25)) * (1.0f - 2.0f * t26) +
            1.5707964f * t26;
        const float t28 = ((t20 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t29 = t7 / (t6 + 1e-30f);
        const float t30 = 1.0f - t7 - t5 * t29;
        const float t31 = t0 * t3;
        const float t32 = t1 * t2;
        const float t33 = s9 * (t4 * t29);
        const float t34 = t1 * t1;
        const float t35 = s9 * (t30 * (2.0f * (t31 + t32)) + t33 * (1.0f - 2.0f * (t18 + t34)));
        const float t36 = fabsf(t35);
        const float t37 = t30 * (1.0f - 2.0f * (t19 + t34)) + t33 * (2.0f * (t31 - t32));
        const float t38 = fabsf(t37);
        const float t39 = smallerf(t36, t38) / (1e-30f + largerf(t36, t38));
        const float t40 = t39 * t39;
        const float t41 = t40 * (0.057089556f + t40 * (-0.030351864f + t40 * (0.01048765f +
            -0.0017011701f * t40)));
        const float t42 = 0.19998075f + t40 * (-0.14260016f + t40 * (0.10932341f + t40 *
            (-0.08349725f + t41)));
        const float t43 = ((t38 - t36 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t44 = t39 * (1.0f + t40 * (-0.33333278f + t40 * t42)) * (1.0f - 2.0f * t43) +
            1.5707964f * t43;
        const float t45 = ((t37 < 0.0f) ? 1.5f : 0.5f) - 0.5f;
        const float t46 = (t44 * (1.0f - 2.0f * t45) + 3.1415927f * t45) * (1.0f - 2.0f * (((-t35 <
            0.0f) ? 1.5f : 0.5f) - 0.5f));
        out_at[i] = t7 * t17;
        out_at[out_step + i] = t27 * (1.0f - 2.0f * t28) + 3.1415927f * t28;
        out_at[2 * out_step + i] = t46;
    }
}

MOTORCADE_SIMD
void motorcade_rotor_proper_euler_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict r_at = inputs[0];
    const ptrdiff_t r_step = input_steps[0];
    const double *restrict s_at = inputs[1];
    const ptrdiff_t s_step = input_steps[1];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double r0 = r_at[i], r1 = r_at[r_step + i], r2 = r_at[2 * r_step + i];
        const double r3 = r_at[3 * r_step + i];
        const double s0 = s_at[i], s1 = s_at[s_step + i], s2 = s_at[2 * s_step + i];
        const double s3 = s_at[3 * s_step + i], s4 = s_at[4 * s_step + i], s5 = s_at[5 * s_step + i];
        const double s6 = s_at[6 * s_step + i], s7 = s_at[7 * s_step + i], s8 = s_at[8 * s_step + i];
        const double s9 = s_at[9 * s_step + i];
        const double t0 = r1 * s3 + r2 * s4 + r3 * s5;
        const double t1 = r1 * s0 + r2 * s1 + r3 * s2;
        const double t2 = s9 * r0;
        const double t3 = r1 * s6 + r2 * s7 + r3 * s8;
        const double t4 = (t0 * t1 - t2 * t3) * 2.0;
        const double t5 = s9 * (2.0 * (t1 * t3 + t0 * t2));
        const double t6 = sqrt(t4 * t4 + t5 * t5);
        const double t7 = ((-t6 < -4e-15) ? 1.5 : 0.5) - 0.5;
        const double t8 = fabs(t4);
        const double t9 = fabs(t5);
        const double t10 = smaller(t8, t9) / (larger(t8, t9) + 1e-30);
        const double t11 = t10 * t10;
        const double t12 = t11 * (1.2631178430477426e-05 * t11 + -0.00014617088163625013) +
            0.0008033604181626027;
        const double t13 = t11 * (t11 * (t11 * t12 + -0.0028047655531701315) + 0.007038646202989813)
            + -0.013674139288399478;
        const double t14 = t11 * (t11 * (t11 * t13 + 0.021740213830758134) + -0.02970071773623423) +
            0.03651081352721035;
        const double t15 = t11 * (t11 * (t11 * t14 + -0.042125723963855326) + 0.04719723992321112) +
            -0.052527255573225747;
        const double t16 = t11 * (t11 * (t11 * t15 + 0.05880342002401543) + -0.06666371187721098) +
            0.0769227555520563;
        const double t17 = t11 * (t11 * (t11 * t16 + -0.09090906605656898) + 0.11111110982087126) +
            -0.14285714281592693;
        const double t18 = ((t9 - t8 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t19 = t10 * (t11 * (t11 * (t11 * t17 + 0.19999999999929946) +
            -0.3333333333333286) + 1.0) * (1.0 - 2.0 * t18);
        const double t20 = ((-t5 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t21 = ((t19 + t18 * 1.5707963267948966) * (1.0 - 2.0 * t20) + t20 *
            3.141592653589793) * (1.0 - 2.0 * (((t4 < 0.0) ? 1.5 : 0.5) - 0.5));
        const double t22 = t0 * t0;
        const double t23 = t3 * t3;
        const double t24 = 1.0 - 2.0 * (t22 + t23);
        const double t25 = fabs(t24);
        const double t26 = smaller(t6, t25) / (1e-30 + larger(t6, t25));
        const double t27 = t26 * t26;
        const double t28 = 0.0008033604181626027 + t27 * (-0.00014617088163625013 +
            1.2631178430477426e-05 * t27);
        const double t29 = -0.013674139288399478 + t27 * (0.007038646202989813 + t27 *
            (-0.0028047655531701315 + t27 * t28));
        const double t30 = 0.03651081352721035 + t27 * (-0.02970071773623423 + t27 *
            (0.021740213830758134 + t27 * t29));
        const double t31 = -0.052527255573225747 + t27 * (0.04719723992321112 + t27 *
            (-0.042125723963855326 + t27 * t30));
        const double t32 = 0.0769227555520563 + t27 * (-0.06666371187721098 + t27 *
            (0.05880342002401543 + t27 * t31));
        const double t33 = -0.14285714281592693 + t27 * (0.11111110982087126 + t27 *
            (-0.09090906605656898 + t27 * t32));
        const double t34 = ((t25 - t6 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t35 = t26 * (1.0 + t27 * (-0.3333333333333286 + t27 * (0.19999999999929946 +
            t27 * t33))) * (1.0 - 2.0 * t34);
        const double t36 = ((t24 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t37 = t7 / (t6 + 1e-30);
        const double t38 = 1.0 - t7 - t5 * t37;
        const double t39 = t0 * t3;
        const double t40 = t1 * t2;
        const double t41 = s9 * (t4 * t37);
        const double t42 = t1 * t1;
        const double t43 = s9 * (t38 * (2.0 * (t39 + t40)) + t41 * (1.0 - 2.0 * (t22 + t42)));
        const double t44 = fabs(t43);
        const double t45 = t38 * (1.0 - 2.0 * (t23 + t42)) + t41 * (2.0 * (t39 - t40));
        const double t46 = fabs(t45);
        const double t47 = smaller(t44, t46) / (1e-30 + larger(t44, t46));
        const double t48 = t47 * t47;
        const double t49 = 0.0008033604181626027 + t48 * (-0.00014617088163625013 +
            1.2631178430477426e-05 * t48);
        const double t50 = -0.013674139288399478 + t48 * (0.007038646202989813 + t48 *
            (-0.0028047655531701315 + t48 * t49));
        const double t51 = 0.03651081352721035 + t48 * (-0.02970071773623423 + t48 *
            (0.021740213830758134 + t48 * t50));
        const double t52 = -0.052527255573225747 + t48 * (0.04719723992321112 + t48 *
            (-0.042125723963855326 + t48 * t51));
        const double t53 = 0.0769227555520563 + t48 * (-0.06666371187721098 + t48 *
            (0.05880342002401543 + t48 * t52));
        const double t54 = -0.14285714281592693 + t48 * (0.11111110982087126 + t48 *
            (-0.09090906605656898 + t48 * t53));
        const double t55 = ((t46 - t44 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t56 = t47 * (1.0 + t48 * (-0.3333333333333286 + t48 * (0.19999999999929946 +
            t48 * t54))) * (1.0 - 2.0 * t55);
        const double t57 = ((t45 < 0.0) ? 1.5 : 0.5) - 0.5;
        const double t58 = ((t56 + 1.5707963267948966 * t55) * (1.0 - 2.0 * t57) + 3.141592653589793
            * t57) * (1.0 - 2.0 * (((-t43 < 0.0) ? 1.5 : 0.5) - 0.5));
        out_at[i] = t7 * t21;
        out_at[out_step + i] = (t35 + 1.5707963267948966 * t34) * (1.0 - 2.0 * t36) +
            3.141592653589793 * t36;
        out_at[2 * out_step + i] = t58;
    }
}
