/* Kernels of the group rotor_jacobians: rotor_left_jacobian, rotor_left_jacobian_inverse.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* rotor_left_jacobian: Left Jacobian of a rotor's exponential at a twist
 * in twist: rx ry rz
 * out out: m00 m01 m02 m10 m11 m12 m20 m21 m22 */

MOTORCADE_SIMD
void motorcade_rotor_left_jacobian_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const float t4 = smallerf(t3, 2.467401f);
        const float t5 = t4 * (t4 * (t4 * (-1.4276141e-07f * t4 + 6.354456e-06f) + -0.00017629226f)
            + 0.0031745604f);
        const float t6 = sqrtf(t3);
        const float t7 = floorf(0.31830987f * t6 + 0.5f);
        const float t8 = t6 - t7 * 3.140625f - t7 * 0.0009675026f - t7 * 1.5099067e-07f - t7 *
            5.126688e-12f;
        const float t9 = t8 * t8;
        const float t10 = t9 * (t9 * (t9 * (2.6050482e-06f * t9 + -0.00019808991f) + 0.00833305f) +
            -0.16666658f);
        const float t11 = t10 + 1.0f;
        const float t12 = 1.0f - 2.0f * (t7 - floorf(0.5f * t7) * 2.0f);
        const float t13 = ((t7 < 0.5f) ? t11 : t11 * (t8 * t12) / largerf(1.0f, t6));
        const float t14 = t9 * (t9 * (t9 * (t9 * -2.6050063e-07f + 2.4760076e-05f) + -0.001388836f)
            + 0.041666634f);
        const float t15 = ((t3 < 2.467401f) ? t4 * (t5 + -0.033333324f) + 0.16666667f : (1.0f - t13
            * (t12 * (t9 * (t14 + -0.5f) + 1.0f))) / (4.0f * largerf(t3, 2.467401f)));
        const float t16 = twist2 * t0;
        const float t17 = 2.0f * t15;
        const float t18 = t2 * 2.0f;
        const float t19 = t13 * (0.5f * t13);
        const float t20 = twist2 * t19;
        const float t21 = t1 * 2.0f;
        const float t22 = t2 * t18;
        const float t23 = t18 * t19;
        out_at[i] = 1.0f + (twist1 * t1 + t16) * t17;
        out_at[out_step + i] = t17 * (t1 * t18) - t20;
        out_at[2 * out_step + i] = t17 * (t0 * t18) - t19 * t21;
        out_at[3 * out_step + i] = t20 - t17 * (twist1 * t2);
        out_at[4 * out_step + i] = -(-1.0f + t17 * (t22 - t16));
        out_at[5 * out_step + i] = t23 + t17 * (t0 * t21);
        out_at[6 * out_step + i] = -(t17 * (twist2 * t2)) - twist1 * t19;
        out_at[7 * out_step + i] = -t23 - t17 * (twist2 * t1);
        out_at[8 * out_step + i] = 1.0f + t17 * (-t22 - t1 * t21);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_left_jacobian_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const double t4 = smaller(t3, 2.4674011002723395);
        const double t5 = t4 * (t4 * (-4.653304211418644e-15 * t4 + 5.362814048940375e-13) +
            -4.605580928658353e-11);
        const double t6 = t4 * (t4 * (t5 + 3.1322658499179184e-09) + -1.644445954441792e-07) +
            6.413339737800479e-06;
        const double t7 = t4 * (t4 * (t4 * t6 + -0.00017636684303014454) + 0.0031746031746025262) +
            -0.033333333333333284;
        const double t8 = sqrt(t3);
        const double t9 = floor(0.3183098861837907 * t8 + 0.5);
        const double t10 = t8 - t9 * 3.1415926218032837 - t9 * 3.1786509424591713e-08 - t9 *
            1.2246467202362698e-16;
        const double t11 = t10 - t9 * 7.891108333126411e-24;
        const double t12 = t11 * t11;
        const double t13 = t12 * (2.721539074015491e-15 * t12 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t14 = t12 * (t12 * (t12 * t13 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t15 = 1.0 + t12 * (t12 * (t12 * t14 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t16 = 1.0 - 2.0 * (t9 - floor(0.5 * t9) * 2.0);
        const double t17 = ((t9 < 0.5) ? t15 : t15 * (t11 * t16) / larger(1.0, t8));
        const double t18 = t12 * (t12 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t19 = t12 * (t12 * (t12 * t18 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t20 = t17 * (t16 * (1.0 + t12 * (t12 * (t12 * t19 + 0.041666666666663875) +
            -0.4999999999999997)));
        const double t21 = ((t3 < 2.4674011002723395) ? t4 * t7 + 0.16666666666666666 : (1.0 - t20)
            / (4.0 * larger(t3, 2.4674011002723395)));
        const double t22 = twist2 * t0;
        const double t23 = 2.0 * t21;
        const double t24 = t2 * 2.0;
        const double t25 = t17 * (0.5 * t17);
        const double t26 = twist2 * t25;
        const double t27 = t1 * 2.0;
        const double t28 = t2 * t24;
        const double t29 = t24 * t25;
        out_at[i] = 1.0 + (twist1 * t1 + t22) * t23;
        out_at[out_step + i] = t23 * (t1 * t24) - t26;
        out_at[2 * out_step + i] = t23 * (t0 * t24) - t25 * t27;
        out_at[3 * out_step + i] = t26 - t23 * (twist1 * t2);
        out_at[4 * out_step + i] = -(-1.0 + t23 * (t28 - t22));
        out_at[5 * out_step + i] = t29 + t23 * (t0 * t27);
        out_at[6 * out_step + i] = -(t23 * (twist2 * t2)) - twist1 * t25;
        out_at[7 * out_step + i] = -t29 - t23 * (twist2 * t1);
        out_at[8 * out_step + i] = 1.0 + t23 * (-t28 - t1 * t27);
    }
}

/* rotor_left_jacobian_inverse: Inverse left Jacobian of a rotor's exponential, singular at full
 * turns
 * in twist: rx ry rz
 * out out: m00 m01 m02 m10 m11 m12 m20 m21 m22 */

MOTORCADE_SIMD
void motorcade_rotor_left_jacobian_inverse_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const float t0 = -0.5f * twist2;
        const float t1 = -0.5f * twist1;
        const float t2 = -0.5f * twist0;
        const float t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const float t4 = smallerf(t3, 2.467401f);
        const float t5 = t4 * (t4 * (t4 * (1.4476021e-07f * t4 + 1.7820906e-07f) + 6.007504e-06f) +
            5.231038e-05f);
        const float t6 = sqrtf(t3);
        const float t7 = floorf(0.31830987f * t6 + 0.5f);
        const float t8 = 1.0f - 2.0f * (t7 - floorf(0.5f * t7) * 2.0f);
        const float t9 = t6 - t7 * 3.140625f - t7 * 0.0009675026f - t7 * 1.5099067e-07f - t7 *
            5.126688e-12f;
        const float t10 = t9 * t9;
        const float t11 = t10 * (t10 * (-2.6050063e-07f * t10 + 2.4760076e-05f) + -0.001388836f) +
            0.041666634f;
        const float t12 = t10 * (t10 * (t10 * (t10 * 2.6050482e-06f + -0.00019808991f) +
            0.00833305f) + -0.16666658f);
        const float t13 = t12 + 1.0f;
        const float t14 = ((t7 < 0.5f) ? t13 : t13 * (t8 * t9) / largerf(1.0f, t6));
        const float t15 = t8 * (t10 * (t10 * t11 + -0.5f) + 1.0f) * (((t14 < 0.0f) ? -1.0f : 1.0f) /
            largerf(fabsf(t14), 1.4210855e-14f));
        const float t16 = ((t3 < 2.467401f) ? t4 * (t4 * (t5 + 0.0005293538f) + 0.005555516f) +
            0.083333336f : (1.0f - t15) / (4.0f * largerf(t3, 2.467401f)));
        const float t17 = twist2 * t0;
        const float t18 = 2.0f * t16;
        const float t19 = t2 * 2.0f;
        const float t20 = t2 * t19;
        const float t21 = t1 * 2.0f;
        out_at[i] = 1.0f + (twist1 * t1 + t17) * t18;
        out_at[out_step + i] = t18 * (t1 * t19) - t0;
        out_at[2 * out_step + i] = t1 + t18 * (t0 * t19);
        out_at[3 * out_step + i] = t0 - t18 * (twist1 * t2);
        out_at[4 * out_step + i] = -(-1.0f + t18 * (t20 - t17));
        out_at[5 * out_step + i] = t18 * (t0 * t21) - t2;
        out_at[6 * out_step + i] = -(t18 * (twist2 * t2)) - t1;
        out_at[7 * out_step + i] = t2 - t18 * (twist2 * t1);
        out_at[8 * out_step + i] = 1.0f + t18 * (-t20 - t1 * t21);
    }
}

MOTORCADE_SIMD
void motorcade_rotor_left_jacobian_inverse_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict twist_at = inputs[0];
    const ptrdiff_t twist_step = input_steps[0];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double twist0 = twist_at[i], twist1 = twist_at[twist_step + i], twist2 = twist_at[2 * twist_step + i];
        const double t0 = -0.5 * twist2;
        const double t1 = -0.5 * twist1;
        const double t2 = -0.5 * twist0;
        const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
        const double t4 = smaller(t3, 2.4674011002723395);
        const double t5 = t4 * (t4 * (4.190860689573733e-14 * t4 + -3.105093875068576e-13) +
            2.52116134224849e-12);
        const double t6 = t4 * (t4 * (t5 + -4.868906238981723e-13) + 7.053760152595475e-11) +
            5.42546914811746e-10;
        const double t7 = t4 * (t4 * (t4 * t6 + 5.574566759681558e-09) + 5.479985772581718e-08) +
            5.411083420356027e-07;
        const double t8 = t4 * (t4 * (t4 * t7 + 5.344447517065357e-06) + 5.2910053333655655e-05) +
            0.0005291005290594417;
        const double t9 = sqrt(t3);
        const double t10 = floor(0.3183098861837907 * t9 + 0.5);
        const double t11 = 1.0 - 2.0 * (t10 - floor(0.5 * t10) * 2.0);
        const double t12 = t9 - t10 * 3.1415926218032837 - t10 * 3.1786509424591713e-08 - t10 *
            1.2246467202362698e-16;
        const double t13 = t12 - t10 * 7.891108333126411e-24;
        const double t14 = t13 * t13;
        const double t15 = t14 * (4.608909074888812e-14 * t14 + -1.146289561457958e-11) +
            2.0876561604575935e-09;
        const double t16 = t14 * (t14 * (t14 * t15 + -2.7557316386461366e-07) +
            2.4801587277366174e-05) + -0.0013888888888772708;
        const double t17 = t14 * (t14 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10;
        const double t18 = t14 * (t14 * (t14 * t17 + -2.505210688815946e-08) +
            2.755731921120387e-06) + -0.00019841269841208527;
        const double t19 = 1.0 + t14 * (t14 * (t14 * t18 + 0.008333333333333186) +
            -0.16666666666666666);
        const double t20 = ((t10 < 0.5) ? t19 : t19 * (t11 * t13) / larger(1.0, t9));
        const double t21 = t11 * (1.0 + t14 * (t14 * (t14 * t16 + 0.041666666666663875) +
            -0.4999999999999997)) * (((t20 < 0.0) ? -1.0 : 1.0) / larger(fabs(t20),
            4.930380657631324e-32));
        const double t22 = ((t3 < 2.4674011002723395) ? t4 * (t4 * t8 + 0.0055555555555571205) +
            0.08333333333333333 : (1.0 - t21) / (4.0 * larger(t3, 2.4674011002723395)));
        const double t23 = twist2 * t0;
        const double t24 = 2.0 * t22;
        const double t25 = t2 * 2.0;
        const double t26 = t2 * t25;
        const double t27 = t1 * 2.0;
        out_at[i] = 1.0 + (twist1 * t1 + t23) * t24;
        out_at[out_step + i] = t24 * (t1 * t25) - t0;
        out_at[2 * out_step + i] = t1 + t24 * (t0 * t25);
        out_at[3 * out_step + i] = t0 - t24 * (twist1 * t2);
        out_at[4 * out_step + i] = -(-1.0 + t24 * (t26 - t23));
        out_at[5 * out_step + i] = t24 * (t0 * t27) - t2;
        out_at[6 * out_step + i] = -(t24 * (twist2 * t2)) - t1;
        out_at[7 * out_step + i] = t2 - t24 * (twist2 * t1);
        out_at[8 * out_step + i] = 1.0 + t24 * (-t26 - t1 * t27);
    }
}
