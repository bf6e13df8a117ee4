/* Kernels of the group jacobians: left_jacobian, left_jacobian_inverse.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* left_jacobian: Left Jacobian of a motor's exponential at a twist
 * in twist: rx ry rz x y z
 * out out: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33
 * m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55 */

MOTORCADE_SIMD
void motorcade_left_jacobian_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const _Bool t4 = (t3 < 2.467401f);
        const float t5 = smallerf(t3, 2.467401f);
        const float t6 = t5 * (t5 * (t5 * (-1.4276141e-07f * t5 + 6.354456e-06f) + -0.00017629226f)
            + 0.0031745604f);
        const float t7 = sqrtf(t3);
        const float t8 = floorf(0.31830987f * t7 + 0.5f);
        const _Bool t9 = (t8 < 0.5f);
        const float t10 = t7 - t8 * 3.140625f - t8 * 0.0009675026f - t8 * 1.5099067e-07f - t8 *
            5.126688e-12f;
        const float t11 = t10 * t10;
        const float t12 = t11 * (t11 * (t11 * (2.6050482e-06f * t11 + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t13 = t12 + 1.0f;
        const float t14 = 1.0f - 2.0f * (t8 - floorf(0.5f * t8) * 2.0f);
        const float t15 = (t9 ? t13 : t13 * (t10 * t14) / largerf(1.0f, t7));
        const float t16 = t11 * (t11 * (t11 * -2.6050063e-07f + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t17 = t14 * (t11 * (t11 * t16 + -0.5f) + 1.0f);
        const float t18 = largerf(t3, 2.467401f);
        const float t19 = (t4 ? t5 * (t6 + -0.033333324f) + 0.16666667f : (1.0f - t15 * t17) / (4.0f
            * t18));
        const float t20 = twist1 * t1;
        const float t21 = twist2 * t0;
        const float t22 = 2.0f * (t20 + t21);
        const float t23 = t2 * 2.0f;
        const float t24 = 2.0f * (t1 * t23);
        const float t25 = t15 * (0.5f * t15);
        const float t26 = twist2 * t25;
        const float t27 = t19 * t24 - t26;
        const float t28 = t1 * 2.0f;
        const float t29 = t25 * t28;
        const float t30 = 2.0f * (t0 * t23);
        const float t31 = 2.0f * (twist1 * t2);
        const float t32 = t19 * t31;
        const float t33 = t2 * t23;
        const float t34 = 2.0f * (t33 - t21);
        const float t35 = t23 * t25;
        const float t36 = 2.0f * (t0 * t28);
        const float t37 = t19 * t36;
        const float t38 = 2.0f * (twist2 * t2);
        const float t39 = twist1 * t25;
        const float t40 = 2.0f * (twist2 * t1);
        const float t41 = -t35 - t19 * t40;
        const float t42 = t1 * t28;
        const float t43 = 2.0f * (-t33 - t42);
        const float t44 = -0.5f * twist5;
        const float t45 = 2.0f * t44;
        const float t46 = -0.5f * twist4;
        const float t47 = twist2 * t44;
        const float t48 = 2.0f * t19;
        const float t49 = t5 * (t5 * (t5 * (t5 * -7.138852e-07f + 2.5424513e-05f) + -0.00052890077f)
            + 0.006349145f);
        const float t50 = (t4 ? t49 + -0.03333333f : (t15 * (t17 * 3.0f) - 1.0f - t17 * (2.0f *
            t17)) / (t18 * (t18 * 8.0f)));
        const float t51 = -0.5f * twist3;
        const float t52 = 2.0f * (t2 * t51 + (t0 * t44 + t1 * t46));
        const float t53 = t50 * t52;
        const float t54 = 2.0f * t51;
        const float t55 = t11 * (t11 * (t11 * -1.1944519e-07f + 1.1010457e-05f) + -0.0005952271f) +
            0.016666664f;
        const float t56 = t52 * (t15 * (t9 ? t11 * t55 + -0.16666667f : (t17 - t15) / (2.0f *
            largerf(1.0f, t3))));
        const float t57 = twist2 * t56;
        const float t58 = 2.0f * t46;
        const float t59 = t0 * 2.0f;
        const float t60 = -(t23 * t51);
        const float t61 = t23 * t56;
        out_at[i] = 1.0f + t19 * t22;
        out_at[out_step + i] = t27;
        out_at[2 * out_step + i] = t19 * t30 - t29;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = 0.0f;
        out_at[5 * out_step + i] = 0.0f;
        out_at[6 * out_step + i] = t26 - t32;
        out_at[7 * out_step + i] = -(-1.0f + t19 * t34);
        out_at[8 * out_step + i] = t35 + t37;
        out_at[9 * out_step + i] = 0.0f;
        out_at[10 * out_step + i] = 0.0f;
        out_at[11 * out_step + i] = 0.0f;
        out_at[12 * out_step + i] = -(t19 * t38) - t39;
        out_at[13 * out_step + i] = t41;
        out_at[14 * out_step + i] = 1.0f + t19 * t43;
        out_at[15 * out_step + i] = 0.0f;
        out_at[16 * out_step + i] = 0.0f;
        out_at[17 * out_step + i] = 0.0f;
        out_at[18 * out_step + i] = (t1 * twist4 - t0 * t45 + twist1 * t46 + t47) * t48 + t22 * t53;
        out_at[19 * out_step + i] = t48 * (t1 * t54 + t23 * t46) + t24 * t53 - (t25 * twist5 + t57);
        out_at[20 * out_step + i] = -(t25 * t58) - t28 * t56 + (t48 * (t23 * t44 - t0 * twist3) +
            t30 * t53);
        out_at[21 * out_step + i] = 1.0f + t48 * (t20 - t0 * t59);
        out_at[22 * out_step + i] = t27;
        out_at[23 * out_step + i] = -t29 - t48 * (t0 * twist0);
        out_at[24 * out_step + i] = t57 - t25 * t45 + (-(t48 * (twist1 * t51 + t2 * twist4)) - t31 *
            t53);
        out_at[25 * out_step + i] = t48 * (t47 + (t60 - t2 * t54 + t0 * twist5)) - t34 * t53;
        out_at[26 * out_step + i] = t48 * (t0 * t58 + t28 * t44) + t36 * t53 - (t25 * twist3 - t61);
        out_at[27 * out_step + i] = -(t25 * t59) - t32;
        out_at[28 * out_step + i] = 1.0f + (t21 - t33) * t48;
        out_at[29 * out_step + i] = t37 - twist0 * t25;
        out_at[30 * out_step + i] = t48 * (t2 * t45 - twist2 * t51) - t38 * t53 - (t25 * twist4 +
            twist1 * t56);
        out_at[31 * out_step + i] = -(t25 * t54) - t61 + (-(t48 * (twist2 * t46 + t1 * twist5)) -
            t40 * t53);
        out_at[32 * out_step + i] = t48 * (t60 - t28 * t46 - t1 * t58 + t2 * twist3) + t43 * t53;
        out_at[33 * out_step + i] = t48 * (t2 * t59) - t39;
        out_at[34 * out_step + i] = t41;
        out_at[35 * out_step + i] = 1.0f + t48 * (twist0 * t2 - t42);
    }
}

MOTORCADE_SIMD
void motorcade_left_jacobian_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const _Bool t4 = (t3 < 2.4674011002723395);
        const double t5 = smaller(t3, 2.4674011002723395);
        const double t6 = t5 * (t5 * (-4.653304211418644e-15 * t5 + 5.362814048940375e-13) +
            -4.605580928658353e-11);
        const double t7 = t5 * (t5 * (t6 + 3.1322658499179184e-09) + -1.644445954441792e-07) +
            6.413339737800479e-06;
        const double t8 = t5 * (t5 * (t5 * t7 + -0.00017636684303014454) + 0.0031746031746025262) +
            -0.033333333333333284;
        const double t9 = sqrt(t3);
        const double t10 = floor(0.3183098861837907 * t9 + 0.5);
        const _Bool t11 = (t10 < 0.5);
        const double t12 = t9 - t10 * 3.1415926218032837 - t10 * 3.1786509424591713e-08 - t10 *
            1.2246467202362698e-16;
        const double t13 = t12 - t10 * 7.891108333126411e-24;
        const double t14 = t13 * t13;
        const double t15 = t14 * (2.721539074015491e-15 * t14 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t16 = t14 * (t14 * (t14 * t15 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t17 = 1.0 + t14 * (t14 * (t14 * t16 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t18 = 1.0 - 2.0 * (t10 - floor(0.5 * t10) * 2.0);
        const double t19 = (t11 ? t17 : t17 * (t13 * t18) / larger(1.0, t9));
        const double t20 = t14 * (t14 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t21 = t14 * (t14 * (t14 * t20 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t22 = t18 * (1.0 + t14 * (t14 * (t14 * t21 + 0.041666666666663875) +
            -0.4999999999999997));
        const double t23 = larger(t3, 2.4674011002723395);
        const double t24 = (t4 ? t5 * t8 + 0.16666666666666666 : (1.0 - t19 * t22) / (4.0 * t23));
        const double t25 = twist1 * t1;
        const double t26 = twist2 * t0;
        const double t27 = 2.0 * (t25 + t26);
        const double t28 = t2 * 2.0;
        const double t29 = 2.0 * (t1 * t28);
        const double t30 = t19 * (0.5 * t19);
        const double t31 = twist2 * t30;
        const double t32 = t24 * t29 - t31;
        const double t33 = t1 * 2.0;
        const double t34 = t30 * t33;
        const double t35 = 2.0 * (t0 * t28);
        const double t36 = 2.0 * (twist1 * t2);
        const double t37 = t24 * t36;
        const double t38 = t2 * t28;
        const double t39 = 2.0 * (t38 - t26);
        const double t40 = t28 * t30;
        const double t41 = 2.0 * (t0 * t33);
        const double t42 = t24 * t41;
        const double t43 = 2.0 * (twist2 * t2);
        const double t44 = twist1 * t30;
        const double t45 = 2.0 * (twist2 * t1);
        const double t46 = -t40 - t24 * t45;
        const double t47 = t1 * t33;
        const double t48 = 2.0 * (-t38 - t47);
        const double t49 = -0.5 * twist5;
        const double t50 = 2.0 * t49;
        const double t51 = -0.5 * twist4;
        const double t52 = twist2 * t49;
        const double t53 = 2.0 * t24;
        const double t54 = t5 * (t5 * -4.1880589590553834e-14 + 4.2904007298587216e-12) +
            -3.2239191831738537e-10;
        const double t55 = t5 * (t5 * (t5 * t54 + 1.8793599365896016e-08) + -8.222229846114161e-07)
            + 2.5653358958025074e-05;
        const double t56 = t5 * (t5 * (t5 * t55 + -0.0005291005290936442) + 0.0063492063492057126) +
            -0.033333333333333326;
        const double t57 = -0.5 * twist3;
        const double t58 = 2.0 * (t2 * t57 + (t0 * t49 + t1 * t51));
        const double t59 = (t4 ? t56 : (t19 * (t22 * 3.0) - 1.0 - t22 * (2.0 * t22)) / (t23 * (t23 *
            8.0))) * t58;
        const double t60 = 2.0 * t57;
        const double t61 = t14 * (t14 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10;
        const double t62 = t14 * (t14 * (t14 * t61 + -1.2526053501698183e-07) +
            1.1022927685256208e-05) + -0.0005952380952367574;
        const double t63 = (t11 ? -0.16666666666666666 + t14 * (t14 * t62 + 0.01666666666666651) :
            (t22 - t19) / (2.0 * larger(1.0, t3)));
        const double t64 = t58 * (t19 * t63);
        const double t65 = twist2 * t64;
        const double t66 = 2.0 * t51;
        const double t67 = t0 * 2.0;
        const double t68 = -(t28 * t57);
        const double t69 = t28 * t64;
        out_at[i] = 1.0 + t24 * t27;
        out_at[out_step + i] = t32;
        out_at[2 * out_step + i] = t24 * t35 - t34;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = 0.0;
        out_at[5 * out_step + i] = 0.0;
        out_at[6 * out_step + i] = t31 - t37;
        out_at[7 * out_step + i] = -(-1.0 + t24 * t39);
        out_at[8 * out_step + i] = t40 + t42;
        out_at[9 * out_step + i] = 0.0;
        out_at[10 * out_step + i] = 0.0;
        out_at[11 * out_step + i] = 0.0;
        out_at[12 * out_step + i] = -(t24 * t43) - t44;
        out_at[13 * out_step + i] = t46;
        out_at[14 * out_step + i] = 1.0 + t24 * t48;
        out_at[15 * out_step + i] = 0.0;
        out_at[16 * out_step + i] = 0.0;
        out_at[17 * out_step + i] = 0.0;
        out_at[18 * out_step + i] = (t1 * twist4 - t0 * t50 + twist1 * t51 + t52) * t53 + t27 * t59;
        out_at[19 * out_step + i] = t53 * (t1 * t60 + t28 * t51) + t29 * t59 - (t30 * twist5 + t65);
        out_at[20 * out_step + i] = -(t30 * t66) - t33 * t64 + (t53 * (t28 * t49 - t0 * twist3) +
            t35 * t59);
        out_at[21 * out_step + i] = 1.0 + t53 * (t25 - t0 * t67);
        out_at[22 * out_step + i] = t32;
        out_at[23 * out_step + i] = -t34 - t53 * (t0 * twist0);
        out_at[24 * out_step + i] = t65 - t30 * t50 + (-(t53 * (twist1 * t57 + t2 * twist4)) - t36 *
            t59);
        out_at[25 * out_step + i] = t53 * (t52 + (t68 - t2 * t60 + t0 * twist5)) - t39 * t59;
        out_at[26 * out_step + i] = t53 * (t0 * t66 + t33 * t49) + t41 * t59 - (t30 * twist3 - t69);
        out_at[27 * out_step + i] = -(t30 * t67) - t37;
        out_at[28 * out_step + i] = 1.0 + (t26 - t38) * t53;
        out_at[29 * out_step + i] = t42 - twist0 * t30;
        out_at[30 * out_step + i] = t53 * (t2 * t50 - twist2 * t57) - t43 * t59 - (t30 * twist4 +
            twist1 * t64);
        out_at[31 * out_step + i] = -(t30 * t60) - t69 + (-(t53 * (twist2 * t51 + t1 * twist5)) -
            t45 * t59);
        out_at[32 * out_step + i] = t53 * (t68 - t33 * t51 - t1 * t66 + t2 * twist3) + t48 * t59;
        out_at[33 * out_step + i] = t53 * (t2 * t67) - t44;
        out_at[34 * out_step + i] = t46;
        out_at[35 * out_step + i] = 1.0 + t53 * (twist0 * t2 - t47);
    }
}

/* left_jacobian_inverse: Inverse left Jacobian of a motor's exponential, singular at full turns
 * in twist: rx ry rz x y z
 * out out: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33
 * m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55 */

MOTORCADE_SIMD
void motorcade_left_jacobian_inverse_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const _Bool t4 = (t3 < 2.467401f);
        const float t5 = smallerf(t3, 2.467401f);
        const float t6 = t5 * (t5 * (t5 * (1.4476021e-07f * t5 + 1.7820906e-07f) + 6.007504e-06f) +
            5.231038e-05f);
        const float t7 = sqrtf(t3);
        const float t8 = floorf(0.31830987f * t7 + 0.5f);
        const float t9 = 1.0f - 2.0f * (t8 - floorf(0.5f * t8) * 2.0f);
        const float t10 = t7 - t8 * 3.140625f - t8 * 0.0009675026f - t8 * 1.5099067e-07f - t8 *
            5.126688e-12f;
        const float t11 = t10 * t10;
        const float t12 = t11 * (t11 * (-2.6050063e-07f * t11 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t13 = t11 * (t11 * (t11 * (t11 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t14 = t13 + 1.0f;
        const float t15 = ((t8 < 0.5f) ? t14 : t14 * (t9 * t10) / largerf(1.0f, t7));
        const float t16 = ((t15 < 0.0f) ? -1.0f : 1.0f) / largerf(fabsf(t15), 1.4210855e-14f);
        const float t17 = t9 * (t11 * (t11 * t12 + -0.5f) + 1.0f) * t16;
        const float t18 = largerf(t3, 2.467401f);
        const float t19 = (t4 ? t5 * (t5 * (t6 + 0.0005293538f) + 0.005555516f) + 0.083333336f :
            (1.0f - t17) / (4.0f * t18));
        const float t20 = twist1 * t1;
        const float t21 = twist2 * t0;
        const float t22 = 2.0f * (t20 + t21);
        const float t23 = t2 * 2.0f;
        const float t24 = 2.0f * (t1 * t23);
        const float t25 = t19 * t24 - t0;
        const float t26 = 2.0f * (t0 * t23);
        const float t27 = 2.0f * (twist1 * t2);
        const float t28 = t0 - t19 * t27;
        const float t29 = t2 * t23;
        const float t30 = 2.0f * (t29 - t21);
        const float t31 = t1 * 2.0f;
        const float t32 = 2.0f * (t0 * t31);
        const float t33 = t19 * t32 - t2;
        const float t34 = 2.0f * (twist2 * t2);
        const float t35 = 2.0f * (twist2 * t1);
        const float t36 = t2 - t19 * t35;
        const float t37 = t1 * t31;
        const float t38 = 2.0f * (-t29 - t37);
        const float t39 = -0.5f * twist5;
        const float t40 = 2.0f * t39;
        const float t41 = -0.5f * twist4;
        const float t42 = twist2 * t39;
        const float t43 = 2.0f * t19;
        const float t44 = t5 * (t5 * (t5 * (t5 * 1.1855952e-07f + 1.1145513e-09f) + 3.3098438e-06f)
            + 2.0828455e-05f);
        const float t45 = (t4 ? t5 * (t5 * (t44 + 0.00015896284f) + 0.0010581646f) + 0.0055555566f :
            (t17 + t16 * t16 - 2.0f) / (t18 * (t18 * 8.0f)));
        const float t46 = -0.5f * twist3;
        const float t47 = t45 * (2.0f * (t2 * t46 + (t0 * t39 + t1 * t41)));
        const float t48 = 2.0f * t46;
        const float t49 = t0 * 2.0f;
        const float t50 = -(t23 * t46);
        const float t51 = 2.0f * t41;
        out_at[i] = 1.0f + t19 * t22;
        out_at[out_step + i] = t25;
        out_at[2 * out_step + i] = t1 + t19 * t26;
        out_at[3 * out_step + i] = 0.0f;
        out_at[4 * out_step + i] = 0.0f;
        out_at[5 * out_step + i] = 0.0f;
        out_at[6 * out_step + i] = t28;
        out_at[7 * out_step + i] = -(-1.0f + t19 * t30);
        out_at[8 * out_step + i] = t33;
        out_at[9 * out_step + i] = 0.0f;
        out_at[10 * out_step + i] = 0.0f;
        out_at[11 * out_step + i] = 0.0f;
        out_at[12 * out_step + i] = -(t19 * t34) - t1;
        out_at[13 * out_step + i] = t36;
        out_at[14 * out_step + i] = 1.0f + t19 * t38;
        out_at[15 * out_step + i] = 0.0f;
        out_at[16 * out_step + i] = 0.0f;
        out_at[17 * out_step + i] = 0.0f;
        out_at[18 * out_step + i] = (t1 * twist4 - t0 * t40 + twist1 * t41 + t42) * t43 + t22 * t47;
        out_at[19 * out_step + i] = t43 * (t1 * t48 + t23 * t41) + t24 * t47 - t39;
        out_at[20 * out_step + i] = t41 + (t43 * (t23 * t39 - t0 * twist3) + t26 * t47);
        out_at[21 * out_step + i] = 1.0f + t43 * (t20 - t0 * t49);
        out_at[22 * out_step + i] = t25;
        out_at[23 * out_step + i] = t1 - t43 * (t0 * twist0);
        out_at[24 * out_step + i] = t39 + (-(t43 * (twist1 * t46 + t2 * twist4)) - t27 * t47);
        out_at[25 * out_step + i] = t43 * (t42 + (t50 - t2 * t48 + t0 * twist5)) - t30 * t47;
        out_at[26 * out_step + i] = t43 * (t0 * t51 + t31 * t39) + t32 * t47 - t46;
        out_at[27 * out_step + i] = t28;
        out_at[28 * out_step + i] = 1.0f + (t21 - t29) * t43;
        out_at[29 * out_step + i] = t33;
        out_at[30 * out_step + i] = t43 * (t2 * t40 - twist2 * t46) - t34 * t47 - t41;
        out_at[31 * out_step + i] = t46 + (-(t43 * (twist2 * t41 + t1 * twist5)) - t35 * t47);
        out_at[32 * out_step + i] = t43 * (t50 - t31 * t41 - t1 * t51 + t2 * twist3) + t38 * t47;
        out_at[33 * out_step + i] = t43 * (t2 * t49) - t1;
        out_at[34 * out_step + i] = t36;
        out_at[35 * out_step + i] = 1.0f + t43 * (twist0 * t2 - t37);
    }
}

MOTORCADE_SIMD
void motorcade_left_jacobian_inverse_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double twist3 = twist_at[3 * twist_step + i], twist4 = twist_at[4 * twist_step + i], twist5 = twist_at[5 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const _Bool t4 = (t3 < 2.4674011002723395);
        const double t5 = smaller(t3, 2.4674011002723395);
        const double t6 = t5 * (t5 * (4.190860689573733e-14 * t5 + -3.105093875068576e-13) +
            2.52116134224849e-12);
        const double t7 = t5 * (t5 * (t6 + -4.868906238981723e-13) + 7.053760152595475e-11) +
            5.42546914811746e-10;
        const double t8 = t5 * (t5 * (t5 * t7 + 5.574566759681558e-09) + 5.479985772581718e-08) +
            5.411083420356027e-07;
        const double t9 = t5 * (t5 * (t5 * t8 + 5.344447517065357e-06) + 5.2910053333655655e-05) +
            0.0005291005290594417;
        const double t10 = sqrt(t3);
        const double t11 = floor(0.3183098861837907 * t10 + 0.5);
        const double t12 = 1.0 - 2.0 * (t11 - floor(0.5 * t11) * 2.0);
        const double t13 = t10 - t11 * 3.1415926218032837 - t11 * 3.1786509424591713e-08 - t11 *
            1.2246467202362698e-16;
        const double t14 = t13 - t11 * 7.891108333126411e-24;
        const double t15 = t14 * t14;
        const double t16 = t15 * (4.608909074888812e-14 * t15 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t17 = t15 * (t15 * (t15 * t16 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t18 = t15 * (t15 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t19 = t15 * (t15 * (t15 * t18 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t20 = 1.0 + t15 * (t15 * (t15 * t19 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t21 = ((t11 < 0.5) ? t20 : t20 * (t12 * t14) / larger(1.0, t10));
        const double t22 = ((t21 < 0.0) ? -1.0 : 1.0) / larger(fabs(t21), 4.930380657631324e-32);
        const double t23 = t12 * (1.0 + t15 * (t15 * (t15 * t17 + 0.041666666666663875) +
            -0.4999999999999997)) * t22;
        const double t24 = larger(t3, 2.4674011002723395);
        const double t25 = (t4 ? t5 * (t5 * t9 + 0.0055555555555571205) + 0.08333333333333333 : (1.0
            - t23) / (4.0 * t24));
        const double t26 = twist1 * t1;
        const double t27 = twist2 * t0;
        const double t28 = 2.0 * (t26 + t27);
        const double t29 = t2 * 2.0;
        const double t30 = 2.0 * (t1 * t29);
        const double t31 = t25 * t30 - t0;
        const double t32 = 2.0 * (t0 * t29);
        const double t33 = 2.0 * (twist1 * t2);
        const double t34 = t0 - t25 * t33;
        const double t35 = t2 * t29;
        const double t36 = 2.0 * (t35 - t27);
        const double t37 = t1 * 2.0;
        const double t38 = 2.0 * (t0 * t37);
        const double t39 = t25 * t38 - t2;
        const double t40 = 2.0 * (twist2 * t2);
        const double t41 = 2.0 * (twist2 * t1);
        const double t42 = t2 - t25 * t41;
        const double t43 = t1 * t37;
        const double t44 = 2.0 * (-t35 - t43);
        const double t45 = -0.5 * twist5;
        const double t46 = 2.0 * t45;
        const double t47 = -0.5 * twist4;
        const double t48 = twist2 * t45;
        const double t49 = 2.0 * t25;
        const double t50 = t5 * (t5 * (t5 * 8.561420266877998e-15 + -7.887796790985613e-14) +
            5.840902112904286e-13);
        const double t51 = t5 * (t5 * (t50 + -1.1102488422040386e-12) + 1.0866640876189362e-11) +
            5.0219390448129135e-11;
        const double t52 = t5 * (t5 * (t5 * t51 + 5.222702207898614e-10) + 4.4936669940499006e-09) +
            3.8880353832927835e-08;
        const double t53 = t5 * (t5 * (t5 * t52 + 3.288872381982998e-07) + 2.705505882992825e-06) +
            2.137779906977056e-05;
        const double t54 = t5 * (t5 * (t5 * t53 + 0.00015873015873738575) + 0.0010582010582008187) +
            0.005555555555555557;
        const double t55 = -0.5 * twist3;
        const double t56 = (t4 ? t54 : (t23 + t22 * t22 - 2.0) / (t24 * (t24 * 8.0))) * (2.0 * (t2 *
            t55 + (t0 * t45 + t1 * t47)));
        const double t57 = 2.0 * t55;
        const double t58 = t0 * 2.0;
        const double t59 = -(t29 * t55);
        const double t60 = 2.0 * t47;
        out_at[i] = 1.0 + t25 * t28;
        out_at[out_step + i] = t31;
        out_at[2 * out_step + i] = t1 + t25 * t32;
        out_at[3 * out_step + i] = 0.0;
        out_at[4 * out_step + i] = 0.0;
        out_at[5 * out_step + i] = 0.0;
        out_at[6 * out_step + i] = t34;
        out_at[7 * out_step + i] = -(-1.0 + t25 * t36);
        out_at[8 * out_step + i] = t39;
        out_at[9 * out_step + i] = 0.0;
        out_at[10 * out_step + i] = 0.0;
        out_at[11 * out_step + i] = 0.0;
        out_at[12 * out_step + i] = -(t25 * t40) - t1;
        out_at[13 * out_step + i] = t42;
        out_at[14 * out_step + i] = 1.0 + t25 * t44;
        out_at[15 * out_step + i] = 0.0;
        out_at[16 * out_step + i] = 0.0;
        out_at[17 * out_step + i] = 0.0;
        out_at[18 * out_step + i] = (t1 * twist4 - t0 * t46 + twist1 * t47 + t48) * t49 + t28 * t56;
        out_at[19 * out_step + i] = t49 * (t1 * t57 + t29 * t47) + t30 * t56 - t45;
        out_at[20 * out_step + i] = t47 + (t49 * (t29 * t45 - t0 * twist3) + t32 * t56);
        out_at[21 * out_step + i] = 1.0 + t49 * (t26 - t0 * t58);
        out_at[22 * out_step + i] = t31;
        out_at[23 * out_step + i] = t1 - t49 * (t0 * twist0);
        out_at[24 * out_step + i] = t45 + (-(t49 * (twist1 * t55 + t2 * twist4)) - t33 * t56);
        out_at[25 * out_step + i] = t49 * (t48 + (t59 - t2 * t57 + t0 * twist5)) - t36 * t56;
        out_at[26 * out_step + i] = t49 * (t0 * t60 + t37 * t45) + t38 * t56 - t55;
        out_at[27 * out_step + i] = t34;
        out_at[28 * out_step + i] = 1.0 + (t27 - t35) * t49;
        out_at[29 * out_step + i] = t39;
        out_at[30 * out_step + i] = t49 * (t2 * t46 - twist2 * t55) - t40 * t56 - t47;
        out_at[31 * out_step + i] = t55 + (-(t49 * (twist2 * t47 + t1 * twist5)) - t41 * t56);
        out_at[32 * out_step + i] = t49 * (t59 - t37 * t47 - t1 * t60 + t2 * twist3) + t44 * t56;
        out_at[33 * out_step + i] = t49 * (t2 * t58) - t1;
        out_at[34 * out_step + i] = t42;
        out_at[35 * out_step + i] = 1.0 + t49 * (twist0 * t2 - t43);
    }
}
