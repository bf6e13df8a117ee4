/*
 * Smoothing of poses in C99, or C++, on the motors of conformal geometric algebra: the causal
 * Kalman filter of constant velocity or acceleration, the Rauch-Tung-Striebel smoother, and the
 * 1 Euro filter. One file, no library but that of C, no memory allocated. The numbers are those of
 * motorcade.fusion.smoothing with the representation "motor".
 *
 *     #include "motorcade/smooth.h"
 *
 *     motorcade_kalman filter;
 *     motorcade_model model = motorcade_constant_velocity();
 *     motorcade_kalman_start(&filter, &model);
 *     ... for each pose, in the order of time:
 *     motorcade_motor_of_pose(position_m, quaternion_wxyz, motor);
 *     if (motorcade_kalman_update(&filter, motor, time_ns, motor) == MOTORCADE_OK)
 *         motorcade_pose_of_motor(motor, position_m, quaternion_wxyz);
 *
 * Poses are world_T_body: what they are applied to is given in the body (a camera, a headset) and
 * comes out in the world. Metres, radians, seconds; stamps are integer nanoseconds and must rise,
 * evenly or not. Quaternions are Hamilton's, w first; ROS, Unity and ARKit store w last. A motor is
 * eight numbers on 1, e23, e31, e12, e1inf, e2inf, e3inf, e123inf: T R, the rotation first. A frame
 * in which x, y, z are left-handed (Unity) must be mirrored before and after.
 *
 * Functions are `static inline`. For a shared library, define MOTORCADE_API as what exports a
 * function and include this in one source file. Do not compile it with -ffast-math, which takes
 * away the check of what is not finite.
 *
 * Written by `python -m motorcade.fusion.smoothing.header`; edit what that reads.
 * Copyright: as of Motorcade, Apache License 2.0.
 */
#ifndef MOTORCADE_SMOOTH_H
#define MOTORCADE_SMOOTH_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef MOTORCADE_API
#define MOTORCADE_API static inline
#endif

/* What functions return. After another answer than MOTORCADE_OK a filter is as it was before. */
enum {
    MOTORCADE_OK = 0,
    MOTORCADE_BAD_MODEL = 1, /* an order other than 1 and 2, or a number that is not positive */
    MOTORCADE_BAD_STAMP = 2, /* a stamp that is not after the one before */
    MOTORCADE_BAD_POSE = 3   /* a pose that is none, or a result that is not finite */
};

/*
 * The motor nearest to an even element
 * m: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 * out: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 */
static inline void motorcade_inner_normalize(const double m[8], double out[8])
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double t0 = m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1;
    const double t1 = 1.0 / sqrt(t0);
    const double t2 = t1 * (-0.5 * (2.0 * (m0 * m7 - m3 * m6 - m1 * m4 - m2 * m5)) / t0);
    out[0] = m0 * t1;
    out[1] = m1 * t1;
    out[2] = m2 * t1;
    out[3] = m3 * t1;
    out[4] = t1 * m4 - m1 * t2;
    out[5] = t1 * m5 - m2 * t2;
    out[6] = t1 * m6 - m3 * t2;
    out[7] = t1 * m7 + m0 * t2;
}

/*
 * Motor of a bivector of any angle
 * log: e23 e31 e12 e1inf e2inf e3inf
 * out: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 */
static inline void motorcade_inner_exp(const double log[6], double out[8])
{
    const double log0 = log[0], log1 = log[1], log2 = log[2], log3 = log[3];
    const double log4 = log[4], log5 = log[5];
    const double t0 = log2 * log2 + log1 * log1 + log0 * log0;
    const int t1 = (t0 < 2.4684011002723394);
    double t21, t22, t23;
    if (t1) {
        const double t2 = t0 * (t0 * (t0 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t3 = t0 * (t0 * (t2 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t4 = t0 * (t0 * (t0 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t5 = t0 * (t0 * (t4 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t6 = t0 * (t0 * (t0 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10);
        const double t7 = t0 * (t0 * (t6 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574;
        t21 = t0 * (t0 * (t0 * t3 + 0.041666666666663875) + -0.4999999999999997) + 1.0;
        t22 = 1.0 + t0 * (t0 * (t0 * t5 + 0.008333333333333186) + -0.16666666666666666);
        t23 = -0.16666666666666666 + t0 * (t0 * t7 + 0.01666666666666651);
    } else {
        const double t8 = sqrt(t0);
        const double t9 = floor(0.3183098861837907 * t8 + 0.5);
        const double t10 = 1.0 - 2.0 * (t9 - floor(0.5 * t9) * 2.0);
        const double t11 = t8 - t9 * 3.1415926218032837 - t9 * 3.1786509424591713e-08 - t9 *
            1.2246467202362698e-16;
        const double t12 = t11 - t9 * 7.891108333126411e-24;
        const double t13 = t12 * t12;
        const double t14 = 2.0876561604575935e-09 + t13 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t13);
        const double t15 = -0.0013888888888772708 + t13 * (2.4801587277366174e-05 + t13 *
            (-2.7557316386461366e-07 + t13 * t14));
        const double t16 = t10 * (1.0 + t13 * (-0.4999999999999997 + t13 * (0.041666666666663875 +
            t13 * t15)));
        const double t17 = 1.6058940754212953e-10 + t13 * (-7.643023238169083e-13 + t13 *
            2.721539074015491e-15);
        const double t18 = -0.00019841269841208527 + t13 * (2.755731921120387e-06 + t13 *
            (-2.505210688815946e-08 + t13 * t17));
        const double t19 = t10 * t12 * (1.0 + t13 * (-0.16666666666666666 + t13 *
            (0.008333333333333186 + t13 * t18)));
        const double t20 = t19 / fmax(1.0, t8);
        t21 = t16;
        t22 = t20;
        t23 = (t16 - t20) / (t0 * 2.0);
    }
    const double t24 = 2.0 * (log0 * log3 + (log2 * log5 + log1 * log4));
    const double t25 = t23 * t24;
    out[0] = t21;
    out[1] = log0 * t22;
    out[2] = log1 * t22;
    out[3] = log2 * t22;
    out[4] = t22 * log3 + log0 * t25;
    out[5] = t22 * log4 + log1 * t25;
    out[6] = t22 * log5 + log2 * t25;
    out[7] = -(t24 * (t22 * -0.5));
}

/*
 * The twist, turning by at most pi, that takes motor a to b
 * a: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 * b: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 * out: rx ry rz x y z
 */
static inline void motorcade_inner_local(const double a[8], const double b[8], double out[6])
{
    const double a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const double a4 = a[4], a5 = a[5], a6 = a[6], a7 = a[7];
    const double b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    const double b4 = b[4], b5 = b[5], b6 = b[6], b7 = b[7];
    const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
    const double t1 = ((t0 < 0.0) ? -1.0 : 1.0);
    const double t2 = 1.0 - t0 * t1;
    const int t3 = (t2 < 0.05);
    double t23, t24;
    if (t3) {
        const double t4 = t2 * (t2 * (t2 * 0.002734180087163666 + 0.005307498678423399) +
            0.011544886911341685);
        const double t5 = t2 * (t2 * (t2 * (t4 + 0.025396804776123976) + 0.057142857406109096) +
            0.13333333333168498);
        const double t6 = t2 * (t2 * (t2 * 0.010424064509481967 + 0.0173166119023766) +
            0.031971801087278005) + 0.05771996888021514;
        const double t7 = t2 * (t2 * (t2 * t6 + 0.10158730272186887) + 0.17142857142146586) +
            0.2666666666666836;
        t23 = 1.0 + t2 * (t5 + 0.33333333333333726);
        t24 = t2 * t7 + 0.3333333333333333;
    } else {
        const double t8 = t2 * (t2 * (t2 * 8.121007252839173e-05 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t9 = t2 * (t2 * (t8 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t10 = t2 * (t2 * (t2 * t9 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t11 = t2 * (t2 * (t2 * t10 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t12 = t2 * (t2 * (t2 * t11 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t13 = t2 * (t2 * (t2 * t12 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t14 = t2 * (t2 * (t2 * t13 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
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
        const double t22 = 0.3333333333333333 + t2 * (t2 * (t2 * t21 + 0.17142857142808898) +
            0.2666666666666692);
        t23 = 1.0 + t2 * t14;
        t24 = t22;
    }
    const double t25 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2);
    const double t26 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1);
    const double t27 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1);
    const double t28 = t23 * (t1 * (a0 * b4 - a3 * b5 + a2 * b6 - b0 * a4 + a1 * b7 + b3 * a5 - b2 *
        a6 - b1 * a7));
    const double t29 = t24 * (t1 * (a0 * b7 - a3 * b6 - b1 * a4 - a1 * b4 - b3 * a6 + b0 * a7 - a2 *
        b5 - b2 * a5));
    const double t30 = t23 * (t1 * (a0 * b5 + a2 * b7 - b3 * a4 - a1 * b6 - b0 * a5 - b2 * a7 + a3 *
        b4 + b1 * a6));
    const double t31 = t23 * (t1 * (a0 * b6 + b2 * a4 - b1 * a5 - b0 * a6 + a3 * b7 - a2 * b4 + a1 *
        b5 - b3 * a7));
    out[0] = -2.0 * (t23 * t25);
    out[1] = -(-2.0 * (t23 * t26));
    out[2] = -2.0 * (t23 * t27);
    out[3] = -2.0 * (t28 + t25 * t29);
    out[4] = -2.0 * (t30 - t26 * t29);
    out[5] = -2.0 * (t31 + t27 * t29);
}

/*
 * A motor moved by a twist in its own frame
 * m: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 * twist: rx ry rz x y z
 * out: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 */
static inline void motorcade_inner_retract(const double m[8], const double twist[6], double out[8])
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2], twist3 = twist[3];
    const double twist4 = twist[4], twist5 = twist[5];
    const double t0 = -0.5 * twist2;
    const double t1 = -0.5 * twist1;
    const double t2 = -0.5 * twist0;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const int t4 = (t3 < 2.4684011002723394);
    double t24, t25, t26;
    if (t4) {
        const double t5 = t3 * (t3 * (t3 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t6 = t3 * (t3 * (t5 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t7 = t3 * (t3 * (t3 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t8 = t3 * (t3 * (t7 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t9 = t3 * (t3 * (t3 * 2.1772370641728367e-14 + -5.350144126598709e-12) +
            9.635366495989451e-10);
        const double t10 = t3 * (t3 * (t9 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574;
        t24 = t3 * (t3 * (t3 * t6 + 0.041666666666663875) + -0.4999999999999997) + 1.0;
        t25 = 1.0 + t3 * (t3 * (t3 * t8 + 0.008333333333333186) + -0.16666666666666666);
        t26 = -0.16666666666666666 + t3 * (t3 * t10 + 0.01666666666666651);
    } else {
        const double t11 = sqrt(t3);
        const double t12 = floor(0.3183098861837907 * t11 + 0.5);
        const double t13 = 1.0 - 2.0 * (t12 - floor(0.5 * t12) * 2.0);
        const double t14 = t11 - t12 * 3.1415926218032837 - t12 * 3.1786509424591713e-08 - t12 *
            1.2246467202362698e-16;
        const double t15 = t14 - t12 * 7.891108333126411e-24;
        const double t16 = t15 * t15;
        const double t17 = 2.0876561604575935e-09 + t16 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t16);
        const double t18 = -0.0013888888888772708 + t16 * (2.4801587277366174e-05 + t16 *
            (-2.7557316386461366e-07 + t16 * t17));
        const double t19 = t13 * (1.0 + t16 * (-0.4999999999999997 + t16 * (0.041666666666663875 +
            t16 * t18)));
        const double t20 = 1.6058940754212953e-10 + t16 * (-7.643023238169083e-13 + t16 *
            2.721539074015491e-15);
        const double t21 = -0.00019841269841208527 + t16 * (2.755731921120387e-06 + t16 *
            (-2.505210688815946e-08 + t16 * t20));
        const double t22 = t13 * t15 * (1.0 + t16 * (-0.16666666666666666 + t16 *
            (0.008333333333333186 + t16 * t21)));
        const double t23 = t22 / fmax(1.0, t11);
        t24 = t19;
        t25 = t23;
        t26 = (t19 - t23) / (t3 * 2.0);
    }
    const double t27 = t0 * t25;
    const double t28 = t1 * t25;
    const double t29 = t2 * t25;
    const double t30 = -0.5 * twist3;
    const double t31 = -0.5 * twist5;
    const double t32 = -0.5 * twist4;
    const double t33 = 2.0 * (t2 * t30 + (t0 * t31 + t1 * t32));
    const double t34 = t26 * t33;
    const double t35 = t25 * t30 + t2 * t34;
    const double t36 = t25 * t32 + t1 * t34;
    const double t37 = t25 * t31 + t0 * t34;
    const double t38 = t33 * (-0.5 * t25);
    const double t39 = m0 * t35 + m3 * t36 - m2 * t37 + t24 * m4 + m1 * t38 - t27 * m5 + t28 * m6 -
        t29 * m7;
    const double t40 = m0 * t36 + m2 * t38 + t27 * m4 + m1 * t37 + t24 * m5 - t28 * m7 - m3 * t35 -
        t29 * m6;
    const double t41 = m0 * t37 - t28 * m4 + t29 * m5 + t24 * m6 + m3 * t38 + m2 * t35 - m1 * t36 -
        t27 * m7;
    const double t42 = m3 * t37 - m0 * t38 + t29 * m4 + m1 * t35 + t27 * m6 + t24 * m7 + m2 * t36 +
        t28 * m5;
    out[0] = m0 * t24 - m3 * t27 - m2 * t28 - m1 * t29;
    out[1] = m0 * t29 - t27 * m2 + t24 * m1 + m3 * t28;
    out[2] = t27 * m1 - (m3 * t29 - m0 * t28 - t24 * m2);
    out[3] = m0 * t27 + t24 * m3 - t28 * m1 + m2 * t29;
    out[4] = t39;
    out[5] = t40;
    out[6] = t41;
    out[7] = t42;
}

/*
 * Adjoint matrix of a motor on twists
 * m: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 * out: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33 m34
 *     m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55
 */
static inline void motorcade_inner_adjoint(const double m[8], double out[36])
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double t0 = m1 * m1;
    const double t1 = m3 * m3;
    const double t2 = m0 * m0;
    const double t3 = m2 * m2;
    const double t4 = m1 * m2;
    const double t5 = m3 * m0;
    const double t6 = m1 * m3;
    const double t7 = m0 * m2;
    const double t8 = t4 * 2.0;
    const double t9 = t5 * 2.0;
    const double t10 = t8 - t9;
    const double t11 = m3 * m2;
    const double t12 = m1 * m0;
    const double t13 = t11 + t12;
    const double t14 = 2.0 * (t6 + t7);
    const double t15 = t11 - t12;
    const double t16 = m1 * m4;
    const double t17 = m2 * m5;
    const double t18 = m3 * m6;
    const double t19 = m0 * m7;
    const double t20 = m2 * m4 + m1 * m5;
    const double t21 = m0 * m6;
    const double t22 = m3 * m7;
    const double t23 = m3 * m4;
    const double t24 = m1 * m6;
    const double t25 = m2 * m7;
    const double t26 = m0 * m5;
    const double t27 = t2 - t1;
    const double t28 = m3 * m5;
    const double t29 = m2 * m6;
    const double t30 = m0 * m4;
    const double t31 = m1 * m7;
    out[0] = t0 - t1 + t2 - t3;
    out[1] = (t4 + t5) * 2.0;
    out[2] = 2.0 * t6 - 2.0 * t7;
    out[3] = 0.0;
    out[4] = 0.0;
    out[5] = 0.0;
    out[6] = t10;
    out[7] = -(t1 + (t0 - t3 - t2));
    out[8] = t11 + (t12 + t13);
    out[9] = 0.0;
    out[10] = 0.0;
    out[11] = 0.0;
    out[12] = t14;
    out[13] = t11 + t15 - t12;
    out[14] = t1 + t2 - t3 - t0;
    out[15] = 0.0;
    out[16] = 0.0;
    out[17] = 0.0;
    out[18] = 2.0 * (t16 - t17 - t18 - t19);
    out[19] = 2.0 * (t20 + t21 - t22);
    out[20] = 2.0 * (t23 + (t24 + t25) - t26);
    out[21] = t0 + (t27 - t3);
    out[22] = t9 + t8;
    out[23] = 2.0 * (t6 - t7);
    out[24] = 2.0 * (t20 + t22 - t21);
    out[25] = 2.0 * (t17 - t19 - t18 - t16);
    out[26] = 2.0 * (t28 + (t29 + t30) - t31);
    out[27] = t10;
    out[28] = t3 + t27 - t0;
    out[29] = t12 + (t11 + t13);
    out[30] = 2.0 * (t24 + (t23 + t26) - t25);
    out[31] = 2.0 * t29 + (2.0 * t28 + 2.0 * t31) - 2.0 * t30;
    out[32] = 2.0 * (t18 - t17 - t16 - t19);
    out[33] = t14;
    out[34] = t11 + (t15 - t12);
    out[35] = t1 + (t2 - (t0 + t3));
}

/*
 * Where a motor takes the origin
 * m: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 * out: x y z
 */
static inline void motorcade_inner_translation(const double m[8], double out[3])
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    out[0] = -2.0 * (m4 * m0 + m5 * m3 - m6 * m2 + m7 * m1);
    out[1] = -2.0 * (m0 * m5 - m4 * m3 + m2 * m7 + m6 * m1);
    out[2] = -2.0 * (m4 * m2 - m5 * m1 + m0 * m6 + m3 * m7);
}

/*
 * The motor that turns by a rotor, then moves by a translation
 * r: 1 e23 e31 e12
 * t: x y z
 * out: 1 e23 e31 e12 e1inf e2inf e3inf e123inf
 */
static inline void motorcade_inner_motor_of(const double r[4], const double t[3], double out[8])
{
    const double r0 = r[0], r1 = r[1], r2 = r[2], r3 = r[3];
    const double t0 = t[0], t1 = t[1], t2 = t[2];
    const double t3 = -0.5 * t0;
    const double t4 = -0.5 * t1;
    const double t5 = -0.5 * t2;
    out[0] = r0;
    out[1] = r1;
    out[2] = r2;
    out[3] = r3;
    out[4] = r0 * t3 - r3 * t4 + r2 * t5;
    out[5] = r3 * t3 + r0 * t4 - r1 * t5;
    out[6] = r1 * t4 - r2 * t3 + r0 * t5;
    out[7] = r1 * t3 + r3 * t5 + r2 * t4;
}

/* What a status means, for a log. */
MOTORCADE_API const char *motorcade_message(int status) {
    switch (status) {
    case MOTORCADE_OK:
        return "ok";
    case MOTORCADE_BAD_MODEL:
        return "model: expected order 1 or 2 and positive numbers";
    case MOTORCADE_BAD_STAMP:
        return "time_ns: expected a stamp after the one before";
    case MOTORCADE_BAD_POSE:
        return "pose: expected finite numbers and a rotation";
    default:
        return "status: expected one of this header";
    }
}

/* The motor of a position and a quaternion w, x, y, z of any length but 0; they may not overlap. */
MOTORCADE_API void motorcade_motor_of_pose(const double position_m[3],
                                           const double quaternion_wxyz[4], double motor[8]) {
    const double rotor[4] = {quaternion_wxyz[0], -quaternion_wxyz[1], -quaternion_wxyz[2],
                             -quaternion_wxyz[3]};
    motorcade_inner_motor_of(rotor, position_m, motor);
    motorcade_inner_normalize(motor, motor);
}

/* Position and unit quaternion w, x, y, z of a motor. */
MOTORCADE_API void motorcade_pose_of_motor(const double motor[8], double position_m[3],
                                           double quaternion_wxyz[4]) {
    motorcade_inner_translation(motor, position_m);
    quaternion_wxyz[0] = motor[0];
    for (int k = 1; k < 4; ++k) quaternion_wxyz[k] = -motor[k];
}

/* base exp(twist), brought back to unit length. */
static inline void motorcade_inner_moved(const double base[8], const double twist[6],
                                         double out[8]) {
    motorcade_inner_retract(base, twist, out);
    motorcade_inner_normalize(out, out);
}

static inline int motorcade_inner_finite(const double motor[8]) {
    double total = 0.0;
    for (int k = 0; k < 8; ++k) total += motor[k] * 0.0;
    return total == 0.0;
}

/* Seconds from one stamp to a later one, which may be farther than int64_t reaches. */
static inline double motorcade_inner_seconds(int64_t from_ns, int64_t to_ns) {
    return 1e-9 * (double)((uint64_t)to_ns - (uint64_t)from_ns);
}

/* Covariance of a twist and its derivatives: rows and columns in blocks of six. */
typedef struct motorcade_inner_matrix {
    double at[18][18];
} motorcade_inner_matrix;

/*
 * The factors U' D U of a symmetric positive definite matrix: U above a unit diagonal, in whose
 * place D is inverted. Of another matrix all that is solved is NaN.
 */
static inline double motorcade_inner_factor(motorcade_inner_matrix *a, int size) {
    double determinant = 1.0;
    for (int k = 0; k < size; ++k) {
        double *row = a->at[k];
        const double inverse = row[k] > 0.0 ? 1.0 / row[k] : NAN;
        determinant *= row[k];
        for (int i = k + 1; i < size; ++i)
            for (int j = i; j < size; ++j) a->at[i][j] -= row[i] * inverse * row[j];
        for (int j = k + 1; j < size; ++j) row[j] *= inverse;
        row[k] = inverse;
    }
    return determinant;
}

/* a^-1 times a vector, in place, by the factors. */
static inline void motorcade_inner_solve(const motorcade_inner_matrix *factor, int size,
                                         double *right) {
    for (int k = 0; k < size; ++k)
        for (int i = k + 1; i < size; ++i) right[i] -= factor->at[k][i] * right[k];
    for (int k = 0; k < size; ++k) right[k] *= factor->at[k][k];
    for (int k = size - 1; k > 0; --k)
        for (int i = 0; i < k; ++i) right[i] -= factor->at[i][k] * right[k];
}

/* The same of a matrix of six rows. */
static inline void motorcade_inner_solve_rows(const motorcade_inner_matrix *factor, int columns,
                                              double rows[6][18]) {
    for (int k = 0; k < 6; ++k)
        for (int i = k + 1; i < 6; ++i)
            for (int j = 0; j < columns; ++j) rows[i][j] -= factor->at[k][i] * rows[k][j];
    for (int k = 0; k < 6; ++k)
        for (int j = 0; j < columns; ++j) rows[k][j] *= factor->at[k][k];
    for (int k = 5; k > 0; --k)
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < columns; ++j) rows[i][j] -= factor->at[i][k] * rows[k][j];
}

/* What white noise of unit density on the highest derivative adds in dt. */
static inline void motorcade_inner_diffusion(int blocks, double dt, double q[3][3]) {
    static const double factorial[3] = {1.0, 1.0, 2.0};
    double power[6] = {1.0};
    for (int k = 1; k < 2 * blocks; ++k) power[k] = power[k - 1] * dt;
    for (int i = 0; i < blocks; ++i)
        for (int j = 0; j < blocks; ++j) {
            const int a = blocks - 1 - i, b = blocks - 1 - j;
            q[i][j] = power[a + b + 1] / ((double)(a + b + 1) * factorial[a] * factorial[b]);
        }
}

static inline void motorcade_inner_add_noise(motorcade_inner_matrix *p, int blocks,
                                             const double densities[6], double dt) {
    double q[3][3];
    motorcade_inner_diffusion(blocks, dt, q);
    for (int i = 0; i < blocks; ++i)
        for (int j = 0; j < blocks; ++j)
            for (int c = 0; c < 6; ++c)
                p->at[i * 6 + c][j * 6 + c] += densities[c] * densities[c] * q[i][j];
}

/* The first six rows and columns turned: T p T'. The upper right quarter of an adjoint is zero. */
static inline void motorcade_inner_turn(motorcade_inner_matrix *p, int blocks,
                                        const double turn[36]) {
    const int size = 6 * blocks;
    double rows[6][18] = {{0.0}};
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < (i < 3 ? 3 : 6); ++k)
            for (int j = 0; j < size; ++j) rows[i][j] += turn[6 * i + k] * p->at[k][j];
    for (int i = 0; i < 6; ++i)
        for (int j = i; j < size; ++j) {
            double total = j < 6 ? 0.0 : rows[i][j];
            for (int k = 0; k < (j < 3 ? 3 : 6) && j < 6; ++k)
                total += rows[i][k] * turn[6 * j + k];
            p->at[i][j] = p->at[j][i] = total;
        }
}

/* One step of dt along a motion: turned by half of it, drifted, turned by the other half. */
static inline void motorcade_inner_propagate(motorcade_inner_matrix *p, int blocks,
                                             const double turn[36], double dt) {
    const int size = 6 * blocks;
    const double half = 0.5 * dt * dt;
    motorcade_inner_turn(p, blocks, turn);
    for (int i = 0; i + 6 < size; ++i)
        for (int j = 0; j < size; ++j)
            p->at[i][j] +=
                dt * p->at[i + 6][j] + (i + 12 < size ? half * p->at[(i + 12) % size][j] : 0.0);
    for (int i = 0; i < size; ++i)
        for (int j = 0; j + 6 < size; ++j)
            p->at[i][j] +=
                dt * p->at[i][j + 6] + (j + 12 < size ? half * p->at[i][(j + 12) % size] : 0.0);
    motorcade_inner_turn(p, blocks, turn);
}

/*
 * Conditions on a measurement of the pose with such variances. Fills the gain, transposed, and the
 * factor of the innovation's covariance, whose determinant it returns.
 */
static inline double motorcade_inner_measured(motorcade_inner_matrix *p, int blocks,
                                              const double variances[6], double gain[6][18],
                                              motorcade_inner_matrix *factor) {
    const int size = 6 * blocks;
    double seen[6][18];
    for (int c = 0; c < 6; ++c) {
        for (int j = 0; j < size; ++j) gain[c][j] = seen[c][j] = p->at[c][j];
        for (int k = 0; k < 6; ++k) factor->at[c][k] = p->at[c][k] + (c == k ? variances[c] : 0.0);
    }
    const double determinant = motorcade_inner_factor(factor, 6);
    motorcade_inner_solve_rows(factor, size, gain);
    for (int i = 6; i < size; ++i)
        for (int c = 0; c < 6; ++c)
            for (int j = 6; j < size; ++j) p->at[i][j] -= seen[c][i] * gain[c][j];
    for (int c = 0; c < 6; ++c)
        for (int j = 0; j < size; ++j) p->at[c][j] = variances[c] * gain[c][j];
    for (int i = 6; i < size; ++i)
        for (int c = 0; c < 6; ++c) p->at[i][c] = p->at[c][i];
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < i; ++j) p->at[i][j] = p->at[j][i] = 0.5 * (p->at[i][j] + p->at[j][i]);
    return determinant;
}

/* Q predicted^-1 of a residual behind a prediction: how much of it the noise in between explains.
 */
static inline void motorcade_inner_noise_share(const motorcade_inner_matrix *factor, int blocks,
                                               const double densities[6], double dt,
                                               const double residual[18], double share[18]) {
    double weighed[18], q[3][3];
    for (int k = 0; k < 6 * blocks; ++k) {
        weighed[k] = residual[k];
        share[k] = 0.0;
    }
    motorcade_inner_solve(factor, 6 * blocks, weighed);
    motorcade_inner_diffusion(blocks, dt, q);
    for (int i = 0; i < blocks; ++i)
        for (int c = 0; c < 6; ++c)
            for (int j = 0; j < blocks; ++j)
                share[i * 6 + c] += densities[c] * densities[c] * q[i][j] * weighed[j * 6 + c];
}

/* p F' predicted^-1 of it: what the filtered state gains from a residual behind its prediction. */
static inline void motorcade_inner_gained(const motorcade_inner_matrix *p,
                                          const motorcade_inner_matrix *factor, int blocks,
                                          const double turn[36], double dt,
                                          const double residual[18], double gained[18]) {
    const int size = 6 * blocks;
    double way[18];
    for (int k = 0; k < size; ++k) way[k] = residual[k];
    motorcade_inner_solve(factor, size, way);
    for (int again = 0; again < 2; ++again) {
        double first[6] = {0.0};
        for (int k = 0; k < 6; ++k)
            for (int i = 0; i < 6; ++i) first[i] += turn[6 * k + i] * way[k];
        for (int i = 0; i < 6; ++i) way[i] = first[i];
        for (int i = size - 1; i >= 6 && again == 0; --i)
            way[i] += dt * way[i - 6] + (i >= 12 ? 0.5 * dt * dt * way[i - 12] : 0.0);
    }
    for (int i = 0; i < size; ++i) {
        gained[i] = 0.0;
        for (int j = 0; j < size; ++j) gained[i] += p->at[i][j] * way[j];
    }
}

/* How bodies move and how well poses are measured; deviations and densities are of one axis. */
typedef struct motorcade_model {
    int order; /* 1: a velocity that white acceleration changes; 2: an acceleration, white jerk */
    double density_rad; /* of the angular acceleration, rad/s^2/sqrt(Hz); of order 2 rad/s^3 */
    double density_m;   /* of the acceleration, m/s^2/sqrt(Hz); of order 2 of the jerk, m/s^3 */
    double noise_rad;   /* standard deviation of a measured rotation */
    double noise_m;     /* standard deviation of a measured position */
} motorcade_model;

/* Python's defaults of ConstantVelocityFilter. */
MOTORCADE_API motorcade_model motorcade_constant_velocity(void) {
    const motorcade_model model = {1, 2.0, 1.0, 0.01, 0.005};
    return model;
}

/* Python's defaults of ConstantAccelerationFilter. */
MOTORCADE_API motorcade_model motorcade_constant_acceleration(void) {
    const motorcade_model model = {2, 10.0, 5.0, 0.01, 0.005};
    return model;
}

/*
 * A filter as it stands; may be copied. Its model may be changed between two poses, but for the
 * order: noise_rad and noise_m to those of the next pose, say.
 */
typedef struct motorcade_kalman {
    motorcade_model model;
    double pose[8];        /* the filtered motor */
    double rates[2][6];    /* body twist, rad/s and m/s, and of order 2 its derivative */
    double log_likelihood; /* of the innovations: what a better model raises */
    int64_t time_ns;       /* of the last pose */
    int64_t poses;         /* how many were seen */
    motorcade_inner_matrix covariance;
} motorcade_kalman;

/* Its bytes, for languages that keep it as memory of their own. */
MOTORCADE_API size_t motorcade_kalman_size(void) { return sizeof(motorcade_kalman); }

static inline int motorcade_inner_good(const motorcade_model *model) {
    return (model->order == 1 || model->order == 2) && model->density_rad > 0.0 &&
           model->density_m > 0.0 && model->noise_rad > 0.0 && model->noise_m > 0.0 &&
           isfinite(model->density_rad) && isfinite(model->density_m) &&
           isfinite(model->noise_rad) && isfinite(model->noise_m);
}

/* A filter that has seen nothing. */
MOTORCADE_API int motorcade_kalman_start(motorcade_kalman *filter, const motorcade_model *model) {
    const motorcade_kalman empty = {{0, 0.0, 0.0, 0.0, 0.0}, {0.0}, {{0.0}}, 0.0, 0, 0, {{{0.0}}}};
    if (!motorcade_inner_good(model)) return MOTORCADE_BAD_MODEL;
    *filter = empty;
    filter->model = *model;
    return MOTORCADE_OK;
}

static inline void motorcade_inner_spread(double rad, double m, double six[6]) {
    for (int k = 0; k < 3; ++k) {
        six[k] = rad;
        six[k + 3] = m;
    }
}

static inline void motorcade_inner_variances(const motorcade_model *model, double six[6]) {
    motorcade_inner_spread(model->noise_rad * model->noise_rad, model->noise_m * model->noise_m,
                           six);
}

/* The step of dt along the rates. */
static inline void motorcade_inner_travel(int order, double rates[2][6], double dt, double way[6]) {
    for (int k = 0; k < 6; ++k) {
        way[k] = dt * rates[0][k];
        if (order == 2) way[k] += 0.5 * dt * dt * rates[1][k];
    }
}

static inline void motorcade_inner_drift(int order, double rates[2][6], double dt) {
    for (int k = 0; k < 6 && order == 2; ++k) rates[0][k] += dt * rates[1][k];
}

/* The matrix of half of a step's turn. */
static inline void motorcade_inner_half(const double way[6], double turn[36]) {
    double log[6], motor[8];
    for (int k = 0; k < 6; ++k) log[k] = 0.5 * (0.5 * way[k]);
    motorcade_inner_exp(log, motor);
    motorcade_inner_adjoint(motor, turn);
}

/*
 * A gap, as long as the process takes to add 1e10 variances of the noise at most: the pose behind
 * is then free of what was before. Over longer ones rates would be led on until a step turns by
 * more than half a turn, and rounding would leave nothing right in the end.
 */
static inline double motorcade_inner_gap(const motorcade_model *model, int64_t from_ns,
                                         int64_t to_ns) {
    const double rad = model->noise_rad / model->density_rad;
    const double m = model->noise_m / model->density_m;
    double q[3][3];
    motorcade_inner_diffusion(model->order + 1, 1.0, q);
    const double longest_s =
        pow(1e10 * fmax(rad, m) * fmax(rad, m) / q[0][0], 1.0 / (2.0 * model->order + 1.0));
    return fmin(motorcade_inner_seconds(from_ns, to_ns), longest_s);
}

static inline void motorcade_inner_first(motorcade_kalman *filter, const double measured[8]) {
    double variances[6];
    motorcade_inner_variances(&filter->model, variances);
    for (int k = 0; k < 8; ++k) filter->pose[k] = measured[k];
    for (int k = 0; k < 6; ++k) filter->covariance.at[k][k] = variances[k];
}

/*
 * The wide prior of the rates, from what the second pose shows: 1000 times the noise and 10 times
 * the step, as a rate. Doing it twice changes nothing.
 */
static inline void motorcade_inner_open(motorcade_kalman *filter, const double measured[8],
                                        double dt) {
    double step[6], variances[6], squares[2] = {0.0, 0.0};
    motorcade_inner_local(filter->pose, measured, step);
    motorcade_inner_variances(&filter->model, variances);
    for (int k = 0; k < 6; ++k) squares[k / 3] += step[k] * step[k];
    for (int k = 0; k < 6; ++k) {
        double prior = 1e3 * 1e3 * variances[k] + 10.0 * 10.0 * squares[k / 3];
        for (int at = 6 + k; at < 6 * (filter->model.order + 1); at += 6)
            filter->covariance.at[at][at] = prior /= dt * dt;
    }
}

static inline void motorcade_inner_step(motorcade_kalman *filter, const double measured[8],
                                        double dt) {
    const int order = filter->model.order, blocks = order + 1;
    double way[6], turn[36], densities[6], variances[6], innovation[6], weighed[6], gain[6][18];
    double correction[6] = {0.0};
    motorcade_inner_matrix factor;
    motorcade_inner_travel(order, filter->rates, dt, way);
    motorcade_inner_moved(filter->pose, way, filter->pose);
    motorcade_inner_drift(order, filter->rates, dt);
    motorcade_inner_local(filter->pose, measured, innovation);
    motorcade_inner_half(way, turn);
    motorcade_inner_spread(filter->model.density_rad, filter->model.density_m, densities);
    motorcade_inner_variances(&filter->model, variances);
    motorcade_inner_propagate(&filter->covariance, blocks, turn, dt);
    motorcade_inner_add_noise(&filter->covariance, blocks, densities, dt);
    const double determinant =
        motorcade_inner_measured(&filter->covariance, blocks, variances, gain, &factor);
    for (int k = 0; k < 6 * blocks; ++k) {
        double total = 0.0;
        for (int c = 0; c < 6; ++c) total += gain[c][k] * innovation[c];
        *(k < 6 ? &correction[k] : &filter->rates[k / 6 - 1][k % 6]) += total;
    }
    /* The first innovations only tell the rates, whose prior says nothing of the noise. */
    if (filter->poses > order) {
        double square = 6.0 * log(6.283185307179586) + log(determinant);
        for (int k = 0; k < 6; ++k) weighed[k] = innovation[k];
        motorcade_inner_solve(&factor, 6, weighed);
        for (int k = 0; k < 6; ++k) square += weighed[k] * innovation[k];
        filter->log_likelihood -= 0.5 * square;
    }
    motorcade_inner_moved(filter->pose, correction, filter->pose);
}

/* Whether pose, rates and variances are numbers: one that is not would spoil the pose later. */
static inline int motorcade_inner_sound(const motorcade_kalman *filter) {
    const int order = filter->model.order;
    double total = 0.0;
    for (int k = 0; k < 6 * order; ++k) total += filter->rates[k / 6][k % 6] * 0.0;
    for (int k = 0; k < 6 * (order + 1); ++k) total += filter->covariance.at[k][k] * 0.0;
    return total == 0.0 && motorcade_inner_finite(filter->pose);
}

/*
 * The filtered motor at a stamp, from a measured one, which it may replace; the first comes back as
 * it is. Gaps need no care: all steps are by time, and gaps after which nothing is left of what was
 * before are cut short.
 */
MOTORCADE_API int motorcade_kalman_update(motorcade_kalman *filter, const double motor[8],
                                          int64_t time_ns, double filtered[8]) {
    motorcade_kalman next = *filter;
    double measured[8];
    if (!motorcade_inner_good(&filter->model)) return MOTORCADE_BAD_MODEL;
    if (filter->poses > 0 && time_ns <= filter->time_ns) return MOTORCADE_BAD_STAMP;
    motorcade_inner_normalize(motor, measured);
    if (filter->poses == 0) {
        motorcade_inner_first(&next, measured);
    } else {
        const double dt = motorcade_inner_gap(&filter->model, filter->time_ns, time_ns);
        if (filter->poses == 1) motorcade_inner_open(&next, measured, dt);
        motorcade_inner_step(&next, measured, dt);
    }
    if (!motorcade_inner_sound(&next)) return MOTORCADE_BAD_POSE;
    next.time_ns = time_ns;
    next.poses = filter->poses + 1;
    *filter = next;
    for (int k = 0; k < 8; ++k) filtered[k] = next.pose[k];
    return MOTORCADE_OK;
}

/* Where the body will be at a stamp after the last pose's, as far as is known: for a display. */
MOTORCADE_API int motorcade_kalman_predict(const motorcade_kalman *filter, int64_t time_ns,
                                           double predicted[8]) {
    motorcade_kalman next = *filter;
    double way[6];
    if (filter->poses == 0 || time_ns < filter->time_ns) return MOTORCADE_BAD_STAMP;
    motorcade_inner_travel(next.model.order, next.rates,
                           motorcade_inner_seconds(next.time_ns, time_ns), way);
    motorcade_inner_moved(next.pose, way, next.pose);
    if (!motorcade_inner_finite(next.pose)) return MOTORCADE_BAD_POSE;
    for (int k = 0; k < 8; ++k) predicted[k] = next.pose[k];
    return MOTORCADE_OK;
}

/* Filtered states are kept so many at a time, so that memory does not grow with them. */
#define MOTORCADE_INNER_SEGMENT 256

/* How many filters `motorcade_rts` needs as memory to work in, for so many poses. */
MOTORCADE_API size_t motorcade_rts_work(size_t count) {
    const size_t segment = MOTORCADE_INNER_SEGMENT;
    return (count + segment - 1) / segment + (count < segment ? count : segment);
}

/*
 * The smoothed state at a filtered one from the one `later`: that is freed of what the noise in
 * between may explain, and then taken back along its own motion. Only pose and rates of `later`
 * are read, and changed into the result.
 */
static inline void motorcade_inner_back(const motorcade_kalman *filtered, double dt,
                                        motorcade_kalman *later) {
    const int order = filtered->model.order, blocks = order + 1;
    motorcade_kalman made = *filtered;
    double way[6], turn[36], densities[6], predicted[8], residual[18], share[18], correction[6];
    motorcade_inner_travel(order, made.rates, dt, way);
    motorcade_inner_moved(filtered->pose, way, predicted);
    motorcade_inner_drift(order, made.rates, dt);
    motorcade_inner_local(predicted, later->pose, residual);
    for (int k = 0; k < 6 * order; ++k)
        residual[6 + k] = later->rates[k / 6][k % 6] - made.rates[k / 6][k % 6];
    motorcade_inner_half(way, turn);
    motorcade_inner_spread(filtered->model.density_rad, filtered->model.density_m, densities);
    motorcade_inner_propagate(&made.covariance, blocks, turn, dt);
    motorcade_inner_add_noise(&made.covariance, blocks, densities, dt);
    motorcade_inner_factor(&made.covariance, 6 * blocks);
    /*
     * Over more than a radian the path back is no more linear in what is corrected at its end; what
     * is known of the filtered state then bounds how far it goes.
     */
    if (way[0] * way[0] + way[1] * way[1] + way[2] * way[2] > 1.0 ||
        residual[0] * residual[0] + residual[1] * residual[1] + residual[2] * residual[2] > 1.0) {
        motorcade_inner_gained(&filtered->covariance, &made.covariance, blocks, turn, dt, residual,
                               share);
        motorcade_inner_moved(filtered->pose, share, later->pose);
        for (int k = 0; k < 6 * order; ++k)
            later->rates[k / 6][k % 6] = filtered->rates[k / 6][k % 6] + share[6 + k];
        return;
    }
    motorcade_inner_noise_share(&made.covariance, blocks, densities, dt, residual, share);
    for (int k = 0; k < 6; ++k) correction[k] = residual[k] - share[k];
    for (int k = 0; k < 6 * order; ++k) made.rates[k / 6][k % 6] += residual[6 + k] - share[6 + k];
    motorcade_inner_drift(order, made.rates, -dt);
    motorcade_inner_moved(predicted, correction, later->pose);
    motorcade_inner_travel(order, made.rates, dt, way);
    for (int k = 0; k < 6; ++k) way[k] = -way[k];
    motorcade_inner_moved(later->pose, way, later->pose);
    for (int k = 0; k < 6 * order; ++k) later->rates[k / 6][k % 6] = made.rates[k / 6][k % 6];
}

/*
 * Smooths a recorded path by all its poses: the filter forward, the Rauch-Tung-Striebel recursion
 * back.
 *
 *     motors: `count` times eight numbers, and smoothed likewise, which may be the same memory.
 *     time_ns: `count` stamps.
 *     noise: `count` times noise_rad and noise_m, or NULL where the model's hold for every pose.
 *     log_likelihood: a number that is filled in, or NULL.
 *     work: motorcade_rts_work(count) filters.
 *
 * After another answer than MOTORCADE_OK, `smoothed` holds nothing of use.
 */
MOTORCADE_API int motorcade_rts(const motorcade_model *model, const double *motors,
                                const int64_t *time_ns, size_t count, const double *noise,
                                double *smoothed, double *log_likelihood, motorcade_kalman *work) {
    const size_t segment = MOTORCADE_INNER_SEGMENT;
    motorcade_kalman *marks = work, *states = work + (count + segment - 1) / segment;
    motorcade_kalman now, later;
    double measured[8];
    int status = motorcade_kalman_start(&now, model);
    for (size_t k = 0; k < count && status == MOTORCADE_OK; ++k) {
        if (noise != NULL) {
            now.model.noise_rad = noise[2 * k];
            now.model.noise_m = noise[2 * k + 1];
        }
        status = motorcade_kalman_update(&now, motors + 8 * k, time_ns[k], measured);
        if (k == 0 && count > 1 && status == MOTORCADE_OK && time_ns[1] > time_ns[0]) {
            /* The smoothed first pose knows the rates as the second one opens them. */
            marks[0] = now;
            if (noise != NULL) {
                marks[0].model.noise_rad = noise[2];
                marks[0].model.noise_m = noise[3];
            }
            motorcade_inner_normalize(motors + 8, measured);
            motorcade_inner_open(&marks[0], measured,
                                 motorcade_inner_gap(&marks[0].model, time_ns[0], time_ns[1]));
        } else if (k % segment == 0) {
            marks[k / segment] = now;
        }
    }
    if (status != MOTORCADE_OK || count == 0) return status;
    if (log_likelihood != NULL) *log_likelihood = now.log_likelihood;
    later = now;
    for (size_t c = 0; c < 8; ++c) smoothed[8 * (count - 1) + c] = later.pose[c];
    for (size_t mark = (count + segment - 1) / segment; mark-- > 0;) {
        const size_t first = mark * segment;
        const size_t last = first + segment < count - 1 ? first + segment : count - 1;
        for (size_t k = first; k < last; ++k) {
            if (k == first) {
                now = marks[mark];
            } else {
                if (noise != NULL) {
                    now.model.noise_rad = noise[2 * k];
                    now.model.noise_m = noise[2 * k + 1];
                }
                motorcade_kalman_update(&now, motors + 8 * k, time_ns[k], measured);
            }
            states[k - first] = now;
        }
        for (size_t k = last; k-- > first;) {
            /* The gap is cut short by the noise that it was by on the way forward. */
            motorcade_model ahead = *model;
            if (noise != NULL) {
                ahead.noise_rad = noise[2 * k + 2];
                ahead.noise_m = noise[2 * k + 3];
            }
            motorcade_inner_back(&states[k - first],
                                 motorcade_inner_gap(&ahead, time_ns[k], time_ns[k + 1]), &later);
            if (!motorcade_inner_finite(later.pose)) return MOTORCADE_BAD_POSE;
            for (size_t c = 0; c < 8; ++c) smoothed[8 * k + c] = later.pose[c];
        }
    }
    return MOTORCADE_OK;
}

/* The 1 Euro filter: a low-pass whose cut-off rises with the speed. */
typedef struct motorcade_one_euro {
    double min_cutoff_hz;        /* at rest */
    double beta_per_rad;         /* Hz that a rotation of 1 rad/s adds */
    double beta_per_m;           /* Hz that a translation of 1 m/s adds */
    double derivative_cutoff_hz; /* of the speed's own low-pass */
    double pose[8];
    double rate[6];
    int64_t time_ns;
    int64_t poses;
} motorcade_one_euro;

/* Its bytes, for languages that keep it as memory of their own. */
MOTORCADE_API size_t motorcade_one_euro_size(void) { return sizeof(motorcade_one_euro); }

/*
 * A filter that has seen nothing. Python's defaults are 0.5 Hz, 10 Hz a rad/s, 10 Hz a m/s and 2
 * Hz. Cut-offs are positive, betas 0 or more; all else is MOTORCADE_BAD_MODEL. A cut-off above half
 * the rate of the poses is not refused, as the rate is not known: it takes three quarters of each
 * step and more, so hardly smooths.
 */
MOTORCADE_API int motorcade_one_euro_start(motorcade_one_euro *filter, double min_cutoff_hz,
                                           double beta_per_rad, double beta_per_m,
                                           double derivative_cutoff_hz) {
    const motorcade_one_euro made = {min_cutoff_hz, beta_per_rad, beta_per_m, derivative_cutoff_hz,
                                     {0.0},         {0.0},        0,          0};
    if (!(min_cutoff_hz > 0.0 && beta_per_rad >= 0.0 && beta_per_m >= 0.0 &&
          derivative_cutoff_hz > 0.0 && isfinite(min_cutoff_hz) && isfinite(beta_per_rad) &&
          isfinite(beta_per_m) && isfinite(derivative_cutoff_hz)))
        return MOTORCADE_BAD_MODEL;
    *filter = made;
    return MOTORCADE_OK;
}

/* Share of a step that a first-order low-pass takes in dt, by backward differences. */
static inline double motorcade_inner_share(double cutoff_hz, double dt) {
    const double angle = 6.283185307179586 * cutoff_hz * dt;
    return angle / (1.0 + angle);
}

/* The filtered motor at a stamp, from a measured one, which it may replace. */
MOTORCADE_API int motorcade_one_euro_update(motorcade_one_euro *filter, const double motor[8],
                                            int64_t time_ns, double filtered[8]) {
    motorcade_one_euro next = *filter;
    double measured[8], towards[6];
    if (filter->poses > 0 && time_ns <= filter->time_ns) return MOTORCADE_BAD_STAMP;
    motorcade_inner_normalize(motor, measured);
    if (filter->poses == 0) {
        for (int k = 0; k < 8; ++k) next.pose[k] = measured[k];
    } else {
        const double dt = motorcade_inner_seconds(filter->time_ns, time_ns);
        const double share = motorcade_inner_share(filter->derivative_cutoff_hz, dt);
        motorcade_inner_local(filter->pose, measured, towards);
        for (int k = 0; k < 6; ++k)
            next.rate[k] = share * (towards[k] / dt) + (1.0 - share) * next.rate[k];
        for (int first = 0; first < 6; first += 3) {
            double square = 0.0;
            for (int k = first; k < first + 3; ++k) square += next.rate[k] * next.rate[k];
            const double slope = first == 0 ? filter->beta_per_rad : filter->beta_per_m;
            const double step =
                motorcade_inner_share(filter->min_cutoff_hz + slope * sqrt(square), dt);
            for (int k = first; k < first + 3; ++k) towards[k] *= step;
        }
        motorcade_inner_moved(filter->pose, towards, next.pose);
    }
    if (!motorcade_inner_finite(next.pose)) return MOTORCADE_BAD_POSE;
    next.time_ns = time_ns;
    next.poses = filter->poses + 1;
    *filter = next;
    for (int k = 0; k < 8; ++k) filtered[k] = next.pose[k];
    return MOTORCADE_OK;
}

#ifdef __cplusplus
}
#endif

#endif /* MOTORCADE_SMOOTH_H */
