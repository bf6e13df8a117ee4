/*
 * Rotors, motors and similarities one at a time. Versors are taken for unit.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace motorcade::versors {

/*
 * Geometric product a b of rotors
 * a: 1 e23 e31 e12
 * b: 1 e23 e31 e12
 * returns: 1 e23 e31 e12
 */
template <class Real>
inline std::array<Real, 4> compose(const std::array<Real, 4> &a, const std::array<Real, 4> &b)
{
    const Real a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const Real b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    return {
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1,
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2,
        b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1,
    };
}

/*
 * Geometric product a b of motors
 * a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 8> compose(const std::array<Real, 8> &a, const std::array<Real, 8> &b)
{
    const Real a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const Real a4 = a[4], a5 = a[5], a6 = a[6], a7 = a[7];
    const Real b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    const Real b4 = b[4], b5 = b[5], b6 = b[6], b7 = b[7];
    return {
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1,
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2,
        b3 * a1 - (a3 * b1 - a0 * b2 - b0 * a2),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1,
        a0 * b4 + a3 * b5 - a2 * b6 + b0 * a4 - a1 * b7 - b3 * a5 + b2 * a6 - b1 * a7,
        a0 * b5 - a2 * b7 + b3 * a4 + a1 * b6 + b0 * a5 - b2 * a7 - a3 * b4 - b1 * a6,
        a0 * b6 - b2 * a4 + b1 * a5 + b0 * a6 - a3 * b7 + a2 * b4 - a1 * b5 - b3 * a7,
        a0 * b7 + a3 * b6 + b1 * a4 + a1 * b4 + b3 * a6 + b0 * a7 + a2 * b5 + b2 * a5,
    };
}

/*
 * Geometric product a b of similarities
 * a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * returns: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 12> compose(const std::array<Real, 12> &a, const std::array<Real, 12> &b)
{
    const Real a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const Real a4 = a[4], a5 = a[5], a6 = a[6], a7 = a[7];
    const Real a8 = a[8], a9 = a[9], a10 = a[10], a11 = a[11];
    const Real b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    const Real b4 = b[4], b5 = b[5], b6 = b[6], b7 = b[7];
    const Real b8 = b[8], b9 = b[9], b10 = b[10], b11 = b[11];
    const Real t0 = a0 + a4;
    const Real t1 = a3 + a7;
    const Real t2 = a2 + a6;
    const Real t3 = a1 + a5;
    const Real t4 = b0 - b4;
    const Real t5 = b3 - b7;
    const Real t6 = b6 - b2;
    const Real t7 = b1 - b5;
    return {
        a0 * b0 - a3 * b3 - a2 * b2 - a1 * b1 + (a4 * b4 - a7 * b7 - a6 * b6 - a5 * b5),
        a0 * b1 - b3 * a2 + b0 * a1 + a3 * b2 + (a4 * b5 - b7 * a6 + b4 * a5 + a7 * b6),
        -(a3 * b1 - a0 * b2 - b0 * a2 - b3 * a1 + (a7 * b5 - a4 * b6 - b4 * a6 - b7 * a5)),
        a0 * b3 + b0 * a3 - b2 * a1 + a2 * b1 + (a4 * b7 + b4 * a7 - b6 * a5 + a6 * b5),
        a0 * b4 - a3 * b7 - a2 * b6 - a1 * b5 + (b0 * a4 - b3 * a7 - b2 * a6 - b1 * a5),
        a0 * b5 - a2 * b7 + a1 * b4 + a3 * b6 + (b1 * a4 - b3 * a6 + b0 * a5 + b2 * a7),
        -(a3 * b5 - a0 * b6 - a2 * b4 - a1 * b7 + (b1 * a7 - b2 * a4 - b0 * a6 - b3 * a5)),
        a0 * b7 + a3 * b4 - a1 * b6 + a2 * b5 + (b3 * a4 + b0 * a7 - b2 * a5 + b1 * a6),
        t0 * b8 + t1 * b9 - t2 * b10 - t3 * b11 + (a8 * t4 - a9 * t5 - a10 * t6 - a11 * t7),
        t0 * b9 - t2 * b11 + b10 * t3 - b8 * t1 + (a8 * t5 + t4 * a9 + t6 * a11 - a10 * t7),
        t0 * b10 - t1 * b11 + b8 * t2 - b9 * t3 + (a8 * t6 + a9 * t7 + t4 * a10 - t5 * a11),
        t0 * b11 + t1 * b10 + b8 * t3 + b9 * t2 + (a8 * t7 + t5 * a10 + t4 * a11 - a9 * t6),
    };
}

/*
 * Reverse of a rotor: its inverse
 * m: 1 e23 e31 e12
 * returns: 1 e23 e31 e12
 */
template <class Real>
inline std::array<Real, 4> inverse(const std::array<Real, 4> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    return {
        m0,
        -m1,
        -m2,
        -m3,
    };
}

/*
 * Reverse of a motor: its inverse
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 8> inverse(const std::array<Real, 8> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    return {
        m0,
        -m1,
        -m2,
        -m3,
        -m4,
        -m5,
        -m6,
        m7,
    };
}

/*
 * Reverse of a similarity: its inverse
 * m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * returns: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 12> inverse(const std::array<Real, 12> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real m8 = m[8], m9 = m[9], m10 = m[10], m11 = m[11];
    return {
        m0,
        -m1,
        -m2,
        -m3,
        -m4,
        m5,
        m6,
        m7,
        -m8,
        -m9,
        -m10,
        m11,
    };
}

/*
 * Rotor of a bivector of any angle
 * log: e23 e31 e12
 * returns: 1 e23 e31 e12
 */
inline std::array<double, 4> exp(const std::array<double, 3> &log)
{
    const double log0 = log[0], log1 = log[1], log2 = log[2];
    const double t0 = log2 * log2 + log1 * log1 + log0 * log0;
    const bool t1 = (t0 < 2.4684011002723394);
    double t17, t18;
    if (t1) {
        const double t2 = t0 * (t0 * (t0 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t3 = t0 * (t0 * (t2 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t4 = t0 * (t0 * (t0 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t5 = t0 * (t0 * (t4 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        t17 = t0 * (t0 * (t0 * t3 + 0.041666666666663875) + -0.4999999999999997) + 1.0;
        t18 = 1.0 + t0 * (t0 * (t0 * t5 + 0.008333333333333186) + -0.16666666666666666);
    } else {
        const double t6 = std::sqrt(t0);
        const double t7 = std::floor(0.3183098861837907 * t6 + 0.5);
        const double t8 = 1.0 - 2.0 * (t7 - std::floor(0.5 * t7) * 2.0);
        const double t9 = t6 - t7 * 3.1415926218032837 - t7 * 3.1786509424591713e-08 - t7 *
            1.2246467202362698e-16;
        const double t10 = t9 - t7 * 7.891108333126411e-24;
        const double t11 = t10 * t10;
        const double t12 = 2.0876561604575935e-09 + t11 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t11);
        const double t13 = -0.0013888888888772708 + t11 * (2.4801587277366174e-05 + t11 *
            (-2.7557316386461366e-07 + t11 * t12));
        const double t14 = 1.6058940754212953e-10 + t11 * (-7.643023238169083e-13 + t11 *
            2.721539074015491e-15);
        const double t15 = -0.00019841269841208527 + t11 * (2.755731921120387e-06 + t11 *
            (-2.505210688815946e-08 + t11 * t14));
        const double t16 = t8 * t10 * (1.0 + t11 * (-0.16666666666666666 + t11 *
            (0.008333333333333186 + t11 * t15)));
        t17 = t8 * (1.0 + t11 * (-0.4999999999999997 + t11 * (0.041666666666663875 + t11 * t13)));
        t18 = t16 / std::max(1.0, t6);
    }
    return {
        t17,
        log0 * t18,
        log1 * t18,
        log2 * t18,
    };
}

/*
 * Motor of a bivector of any angle
 * log: e23 e31 e12 e1∞ e2∞ e3∞
 * returns: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
inline std::array<double, 8> exp(const std::array<double, 6> &log)
{
    const double log0 = log[0], log1 = log[1], log2 = log[2], log3 = log[3];
    const double log4 = log[4], log5 = log[5];
    const double t0 = log2 * log2 + log1 * log1 + log0 * log0;
    const bool t1 = (t0 < 2.4684011002723394);
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
        const double t8 = std::sqrt(t0);
        const double t9 = std::floor(0.3183098861837907 * t8 + 0.5);
        const double t10 = 1.0 - 2.0 * (t9 - std::floor(0.5 * t9) * 2.0);
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
        const double t20 = t19 / std::max(1.0, t8);
        t21 = t16;
        t22 = t20;
        t23 = (t16 - t20) / (t0 * 2.0);
    }
    const double t24 = 2.0 * (log0 * log3 + (log2 * log5 + log1 * log4));
    const double t25 = t23 * t24;
    return {
        t21,
        log0 * t22,
        log1 * t22,
        log2 * t22,
        t22 * log3 + log0 * t25,
        t22 * log4 + log1 * t25,
        t22 * log5 + log2 * t25,
        -(t24 * (t22 * -0.5)),
    };
}

/*
 * Similarity of a bivector of any angle
 * log: e23 e31 e12 E e1∞ e2∞ e3∞
 * returns: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 */
inline std::array<double, 12> exp(const std::array<double, 7> &log)
{
    const double log0 = log[0], log1 = log[1], log2 = log[2], log3 = log[3];
    const double log4 = log[4], log5 = log[5], log6 = log[6];
    const double t0 = log0 * log0 + log1 * log1 + log2 * log2;
    const bool t1 = (t0 < 2.4684011002723394);
    double t17, t18;
    if (t1) {
        const double t2 = t0 * (t0 * (t0 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t3 = t0 * (t0 * (t2 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t4 = t0 * (t0 * (t0 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t5 = t0 * (t0 * (t4 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        t17 = t0 * (t0 * (t0 * t3 + 0.041666666666663875) + -0.4999999999999997) + 1.0;
        t18 = 1.0 + t0 * (t0 * (t0 * t5 + 0.008333333333333186) + -0.16666666666666666);
    } else {
        const double t6 = std::sqrt(t0);
        const double t7 = std::floor(0.3183098861837907 * t6 + 0.5);
        const double t8 = 1.0 - 2.0 * (t7 - std::floor(0.5 * t7) * 2.0);
        const double t9 = t6 - t7 * 3.1415926218032837 - t7 * 3.1786509424591713e-08 - t7 *
            1.2246467202362698e-16;
        const double t10 = t9 - t7 * 7.891108333126411e-24;
        const double t11 = t10 * t10;
        const double t12 = 2.0876561604575935e-09 + t11 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t11);
        const double t13 = -0.0013888888888772708 + t11 * (2.4801587277366174e-05 + t11 *
            (-2.7557316386461366e-07 + t11 * t12));
        const double t14 = 1.6058940754212953e-10 + t11 * (-7.643023238169083e-13 + t11 *
            2.721539074015491e-15);
        const double t15 = -0.00019841269841208527 + t11 * (2.755731921120387e-06 + t11 *
            (-2.505210688815946e-08 + t11 * t14));
        const double t16 = t8 * t10 * (1.0 + t11 * (-0.16666666666666666 + t11 *
            (0.008333333333333186 + t11 * t15)));
        t17 = t8 * (1.0 + t11 * (-0.4999999999999997 + t11 * (0.041666666666663875 + t11 * t13)));
        t18 = t16 / std::max(1.0, t6);
    }
    const double t19 = log3 * log3;
    const bool t20 = (t19 < 0.12111325347955035);
    double t38, t39, t40;
    if (t20) {
        const double t21 = t19 * (t19 * (t19 * 2.763326749998937e-07 + 2.480148377847191e-05) +
            0.001388888895391314);
        const double t22 = 0.00019841269891276224 + t19 * (2.755723960835094e-06 + t19 *
            2.5110520415965448e-08);
        const double t23 = 1.0 + t19 * (0.16666666666666682 + t19 * (0.008333333333319138 + t19 *
            t22));
        t38 = 1.0 + t19 * (t19 * (t21 + 0.04166666666648207) + 0.5000000000000019);
        t39 = log3 * t23;
        t40 = t23;
    } else {
        const double t24 = std::floor(0.5 + log3 * 1.4426950408889634);
        const double t25 = std::exp2(t24);
        const double t26 = std::exp2(-t24);
        const double t27 = 0.5 * (t25 + t26);
        const double t28 = log3 - t24 * 0.6931471675634384 - t24 * 1.2996506893889889e-08;
        const double t29 = t28 * t28;
        const double t30 = t29 * (0.001388888895391314 + t29 * (2.480148377847191e-05 +
            2.763326749998937e-07 * t29));
        const double t31 = 1.0 + t29 * (0.5000000000000019 + t29 * (0.04166666666648207 + t30));
        const double t32 = 0.5 * (t25 - t26);
        const double t33 = t29 * (t29 * 2.5110520415965448e-08 + 2.755723960835094e-06) +
            0.00019841269891276224;
        const double t34 = 1.0 + t29 * (t29 * (t29 * t33 + 0.008333333333319138) +
            0.16666666666666682);
        const double t35 = t28 * t34;
        const double t36 = t31 * t32 + t27 * t35;
        double t37;
        if (std::abs(t24) < 0.5) {
            t37 = t34;
        } else {
            t37 = std::abs(t36) / std::max(std::abs(log3), 0.25);
        }
        t38 = t27 * t31 + t32 * t35;
        t39 = t36;
        t40 = t37;
    }
    const double t41 = log0 * t18;
    const double t42 = log1 * t18;
    const double t43 = log2 * t18;
    const double t44 = t17 * t40;
    const double t45 = log2 * log5 - log1 * log6;
    const double t46 = log0 * log6 - log2 * log4;
    const double t47 = log1 * log4 - log0 * log5;
    const double t48 = (t38 * t18 - t44) / std::max(t0 + t19, 1.0947644252537633e-47);
    return {
        t17 * t38,
        t38 * t41,
        t38 * t42,
        t38 * t43,
        t17 * t39,
        t41 * t39,
        t42 * t39,
        t43 * t39,
        log4 * t44 + (log3 * t45 - (log2 * t46 - log1 * t47)) * t48,
        t44 * log5 + t48 * (log3 * t46 - (log0 * t47 - log2 * t45)),
        t44 * log6 + t48 * (log3 * t47 - (log1 * t45 - log0 * t46)),
        (log2 * log6 + log0 * log4 + log1 * log5) * (t18 * t40),
    };
}

/*
 * Bivector of a rotor, by the sign that turns by at most π
 * m: 1 e23 e31 e12
 * returns: e23 e31 e12
 */
inline std::array<double, 3> log(const std::array<double, 4> &m)
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double t0 = ((m0 < 0.0) ? -1.0 : 1.0);
    const double t1 = 1.0 - m0 * t0;
    double t11;
    if (t1 < 0.05) {
        const double t2 = t1 * (t1 * (t1 * 0.002734180087163666 + 0.005307498678423399) +
            0.011544886911341685);
        const double t3 = t1 * (t1 * (t1 * (t2 + 0.025396804776123976) + 0.057142857406109096) +
            0.13333333333168498);
        t11 = 1.0 + t1 * (t3 + 0.33333333333333726);
    } else {
        const double t4 = t1 * (t1 * (t1 * 8.121007252839173e-05 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t5 = t1 * (t1 * (t4 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t6 = t1 * (t1 * (t1 * t5 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t7 = t1 * (t1 * (t1 * t6 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t8 = t1 * (t1 * (t1 * t7 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t9 = t1 * (t1 * (t1 * t8 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t10 = t1 * (t1 * (t1 * (t1 * t9 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377);
        t11 = 1.0 + t10;
    }
    return {
        t11 * (t0 * m1),
        t11 * (t0 * m2),
        t11 * (t0 * m3),
    };
}

/*
 * Bivector of a motor, by the sign that turns by at most π
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: e23 e31 e12 e1∞ e2∞ e3∞
 */
inline std::array<double, 6> log(const std::array<double, 8> &m)
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double t0 = ((m0 < 0.0) ? -1.0 : 1.0);
    const double t1 = 1.0 - m0 * t0;
    const bool t2 = (t1 < 0.05);
    double t22, t23;
    if (t2) {
        const double t3 = t1 * (t1 * (t1 * 0.002734180087163666 + 0.005307498678423399) +
            0.011544886911341685);
        const double t4 = t1 * (t1 * (t1 * (t3 + 0.025396804776123976) + 0.057142857406109096) +
            0.13333333333168498);
        const double t5 = t1 * (t1 * (t1 * 0.010424064509481967 + 0.0173166119023766) +
            0.031971801087278005) + 0.05771996888021514;
        const double t6 = t1 * (t1 * (t1 * t5 + 0.10158730272186887) + 0.17142857142146586) +
            0.2666666666666836;
        t22 = 1.0 + t1 * (t4 + 0.33333333333333726);
        t23 = t1 * t6 + 0.3333333333333333;
    } else {
        const double t7 = t1 * (t1 * (t1 * 8.121007252839173e-05 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t8 = t1 * (t1 * (t7 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t9 = t1 * (t1 * (t1 * t8 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t10 = t1 * (t1 * (t1 * t9 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t11 = t1 * (t1 * (t1 * t10 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t12 = t1 * (t1 * (t1 * t11 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t13 = t1 * (t1 * (t1 * t12 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        const double t14 = t1 * (t1 * (t1 * 0.0006075023168817953 + -0.006093589939124222) +
            0.029004300694938867);
        const double t15 = t1 * (t1 * (t1 * (t14 + -0.08654292963332932) + 0.18095358835013511) +
            -0.2810123057357625);
        const double t16 = t1 * (t1 * (t1 * (t15 + 0.33558766073322116) + -0.3148060210252562) +
            0.23526461066915133);
        const double t17 = t1 * (t1 * (t16 + -0.1409288051389536) + 0.06829876555117628) +
            -0.026100111052203438;
        const double t18 = t1 * (t1 * (t1 * t17 + 0.008987626539449197) + -0.0006646325108237732) +
            0.003041430518339829;
        const double t19 = t1 * (t1 * (t1 * t18 + 0.004927059512671586) + 0.009367637463823044) +
            0.017404214982763427;
        const double t20 = t1 * (t1 * (t1 * t19 + 0.03196806840632643) + 0.05772005624453496) +
            0.10158730162394855;
        const double t21 = 0.3333333333333333 + t1 * (t1 * (t1 * t20 + 0.17142857142808898) +
            0.2666666666666692);
        t22 = 1.0 + t1 * t13;
        t23 = t21;
    }
    const double t24 = t0 * m1;
    const double t25 = t0 * m2;
    const double t26 = t0 * m3;
    const double t27 = t23 * (t0 * m7);
    return {
        t22 * t24,
        t22 * t25,
        t22 * t26,
        t22 * (t0 * m4) + t24 * t27,
        t22 * (t0 * m5) + t25 * t27,
        t22 * (t0 * m6) + t26 * t27,
    };
}

/*
 * Bivector of a similarity, by the sign that turns by at most π
 * m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * returns: e23 e31 e12 E e1∞ e2∞ e3∞
 */
inline std::array<double, 7> log(const std::array<double, 12> &m)
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double m8 = m[8], m9 = m[9], m10 = m[10], m11 = m[11];
    const double t0 = ((m0 < 0.0) ? -1.0 : 1.0);
    const double t1 = m0 * t0;
    const double t2 = t0 * m3;
    const double t3 = t0 * m2;
    const double t4 = t0 * m1;
    const double t5 = std::sqrt(t1 * t1 + t2 * t2 + t3 * t3 + t4 * t4);
    const double t6 = 1.0 / t5;
    const double t7 = t1 * t6;
    const double t8 = 1.0 - t7;
    double t18;
    if (t8 < 0.05) {
        const double t9 = t8 * (t8 * (t8 * 0.002734180087163666 + 0.005307498678423399) +
            0.011544886911341685);
        const double t10 = t8 * (t8 * (t8 * (t9 + 0.025396804776123976) + 0.057142857406109096) +
            0.13333333333168498);
        t18 = 1.0 + t8 * (t10 + 0.33333333333333726);
    } else {
        const double t11 = t8 * (t8 * (t8 * 8.121007252839173e-05 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t12 = t8 * (t8 * (t11 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t13 = t8 * (t8 * (t8 * t12 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t14 = t8 * (t8 * (t8 * t13 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t15 = t8 * (t8 * (t8 * t14 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t16 = t8 * (t8 * (t8 * t15 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t17 = t8 * (t8 * (t8 * t16 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        t18 = 1.0 + t8 * t17;
    }
    const double t19 = t4 * t6;
    const double t20 = t3 * t6;
    const double t21 = t2 * t6;
    const double t22 = t7 * (t0 * m4) + t21 * (t0 * m7) + t20 * (t0 * m6) + t19 * (t0 * m5);
    const double t23 = t22 * t22;
    double t40;
    if (t23 < 0.126) {
        const double t24 = t23 * (t23 * (t23 * -0.005811206588331519 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t25 = t23 * (t23 * (t24 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t26 = t23 * (t23 * (t23 * t25 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        t40 = 1.0 + t23 * t26;
    } else {
        const double t27 = std::abs(t22);
        const double t28 = t5 + t27;
        const double t29 = std::logb(1.4142135623730951 * t28);
        const bool t30 = (t29 < 0.5);
        double t32;
        if (t30) {
            t32 = t27;
        } else {
            const double t31 = t28 * std::exp2(-t29);
            t32 = 0.5 * (t31 - 1.0 / t31);
        }
        const double t33 = t32 * t32;
        const double t34 = t33 * (-0.01383075592600594 + t33 * (0.010599129520028859 +
            -0.005811206588331519 * t33));
        const double t35 = 0.030381923311340625 + t33 * (-0.02237152504384804 + t33 *
            (0.017341108627894623 + t34));
        const double t36 = -0.16666666666665153 + t33 * (0.07499999999602147 + t33 *
            (-0.04464285673657631 + t33 * t35));
        const double t37 = 1.0 + t33 * t36;
        double t39;
        if (t30) {
            t39 = t37;
        } else {
            const double t38 = (t29 * 0.6931471675634384 + (t29 * 1.2996506893889889e-08 + t32 *
                t37)) / std::max(t27, 0.25);
            t39 = t38;
        }
        t40 = t39;
    }
    const double t41 = t0 * m8;
    const double t42 = t0 * m11;
    const double t43 = t0 * m10;
    const double t44 = t19 * t43 - t21 * t41;
    const double t45 = t0 * m9;
    const double t46 = t20 * t41 - t19 * t45;
    const double t47 = 1.0 / std::max(t23 + (t19 * t19 + t20 * t20 + t21 * t21),
        1.0947644252537633e-47);
    const double t48 = (t7 * t40 - t5 * t18) * t47;
    const double t49 = t21 * t45 - t20 * t43;
    const double t50 = t47 * (t22 * (t7 * t18 - t5 * t40));
    return {
        t18 * t19,
        t18 * t20,
        t18 * t21,
        t22 * t40,
        t40 * (t7 * t41 + t19 * t42) + (t21 * t44 - t20 * t46) * t48 + t49 * t50,
        t40 * (t7 * t45 + t20 * t42) + t48 * (t19 * t46 - t21 * t49) + t44 * t50,
        t40 * (t7 * t43 + t21 * t42) + t48 * (t20 * t49 - t19 * t44) + t46 * t50,
    };
}

/*
 * A rotor moved by a twist in its own frame
 * m: 1 e23 e31 e12
 * twist: rx ry rz
 * returns: 1 e23 e31 e12
 */
inline std::array<double, 4> retract(const std::array<double, 4> &m,
        const std::array<double, 3> &twist)
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2];
    const double t0 = -0.5 * twist2;
    const double t1 = -0.5 * twist1;
    const double t2 = -0.5 * twist0;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const bool t4 = (t3 < 2.4684011002723394);
    double t20, t21;
    if (t4) {
        const double t5 = t3 * (t3 * (t3 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t6 = t3 * (t3 * (t5 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t7 = t3 * (t3 * (t3 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t8 = t3 * (t3 * (t7 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        t20 = t3 * (t3 * (t3 * t6 + 0.041666666666663875) + -0.4999999999999997) + 1.0;
        t21 = 1.0 + t3 * (t3 * (t3 * t8 + 0.008333333333333186) + -0.16666666666666666);
    } else {
        const double t9 = std::sqrt(t3);
        const double t10 = std::floor(0.3183098861837907 * t9 + 0.5);
        const double t11 = 1.0 - 2.0 * (t10 - std::floor(0.5 * t10) * 2.0);
        const double t12 = t9 - t10 * 3.1415926218032837 - t10 * 3.1786509424591713e-08 - t10 *
            1.2246467202362698e-16;
        const double t13 = t12 - t10 * 7.891108333126411e-24;
        const double t14 = t13 * t13;
        const double t15 = 2.0876561604575935e-09 + t14 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t14);
        const double t16 = -0.0013888888888772708 + t14 * (2.4801587277366174e-05 + t14 *
            (-2.7557316386461366e-07 + t14 * t15));
        const double t17 = 1.6058940754212953e-10 + t14 * (-7.643023238169083e-13 + t14 *
            2.721539074015491e-15);
        const double t18 = -0.00019841269841208527 + t14 * (2.755731921120387e-06 + t14 *
            (-2.505210688815946e-08 + t14 * t17));
        const double t19 = t11 * t13 * (1.0 + t14 * (-0.16666666666666666 + t14 *
            (0.008333333333333186 + t14 * t18)));
        t20 = t11 * (1.0 + t14 * (-0.4999999999999997 + t14 * (0.041666666666663875 + t14 * t16)));
        t21 = t19 / std::max(1.0, t9);
    }
    const double t22 = t0 * t21;
    const double t23 = t1 * t21;
    const double t24 = t2 * t21;
    return {
        m0 * t20 - m3 * t22 - m2 * t23 - m1 * t24,
        m0 * t24 - t22 * m2 + t20 * m1 + m3 * t23,
        t22 * m1 - (m3 * t24 - m0 * t23 - t20 * m2),
        m0 * t22 + t20 * m3 - t23 * m1 + m2 * t24,
    };
}

/*
 * A motor moved by a twist in its own frame
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * twist: rx ry rz x y z
 * returns: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
inline std::array<double, 8> retract(const std::array<double, 8> &m,
        const std::array<double, 6> &twist)
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2], twist3 = twist[3];
    const double twist4 = twist[4], twist5 = twist[5];
    const double t0 = -0.5 * twist2;
    const double t1 = -0.5 * twist1;
    const double t2 = -0.5 * twist0;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const bool t4 = (t3 < 2.4684011002723394);
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
        const double t11 = std::sqrt(t3);
        const double t12 = std::floor(0.3183098861837907 * t11 + 0.5);
        const double t13 = 1.0 - 2.0 * (t12 - std::floor(0.5 * t12) * 2.0);
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
        const double t23 = t22 / std::max(1.0, t11);
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
    return {
        m0 * t24 - m3 * t27 - m2 * t28 - m1 * t29,
        m0 * t29 - t27 * m2 + t24 * m1 + m3 * t28,
        t27 * m1 - (m3 * t29 - m0 * t28 - t24 * m2),
        m0 * t27 + t24 * m3 - t28 * m1 + m2 * t29,
        t39,
        t40,
        t41,
        t42,
    };
}

/*
 * A similarity moved by a twist in its own frame
 * m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * twist: rx ry rz x y z log_scale
 * returns: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 */
inline std::array<double, 12> retract(const std::array<double, 12> &m,
        const std::array<double, 7> &twist)
{
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const double m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const double m8 = m[8], m9 = m[9], m10 = m[10], m11 = m[11];
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2], twist3 = twist[3];
    const double twist4 = twist[4], twist5 = twist[5], twist6 = twist[6];
    const double t0 = -0.5 * twist0;
    const double t1 = -0.5 * twist1;
    const double t2 = -0.5 * twist2;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const bool t4 = (t3 < 2.4684011002723394);
    double t20, t21;
    if (t4) {
        const double t5 = t3 * (t3 * (t3 * 4.608909074888812e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t6 = t3 * (t3 * (t5 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t7 = t3 * (t3 * (t3 * 2.721539074015491e-15 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t8 = t3 * (t3 * (t7 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        t20 = t3 * (t3 * (t3 * t6 + 0.041666666666663875) + -0.4999999999999997) + 1.0;
        t21 = 1.0 + t3 * (t3 * (t3 * t8 + 0.008333333333333186) + -0.16666666666666666);
    } else {
        const double t9 = std::sqrt(t3);
        const double t10 = std::floor(0.3183098861837907 * t9 + 0.5);
        const double t11 = 1.0 - 2.0 * (t10 - std::floor(0.5 * t10) * 2.0);
        const double t12 = t9 - t10 * 3.1415926218032837 - t10 * 3.1786509424591713e-08 - t10 *
            1.2246467202362698e-16;
        const double t13 = t12 - t10 * 7.891108333126411e-24;
        const double t14 = t13 * t13;
        const double t15 = 2.0876561604575935e-09 + t14 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t14);
        const double t16 = -0.0013888888888772708 + t14 * (2.4801587277366174e-05 + t14 *
            (-2.7557316386461366e-07 + t14 * t15));
        const double t17 = 1.6058940754212953e-10 + t14 * (-7.643023238169083e-13 + t14 *
            2.721539074015491e-15);
        const double t18 = -0.00019841269841208527 + t14 * (2.755731921120387e-06 + t14 *
            (-2.505210688815946e-08 + t14 * t17));
        const double t19 = t11 * t13 * (1.0 + t14 * (-0.16666666666666666 + t14 *
            (0.008333333333333186 + t14 * t18)));
        t20 = t11 * (1.0 + t14 * (-0.4999999999999997 + t14 * (0.041666666666663875 + t14 * t16)));
        t21 = t19 / std::max(1.0, t9);
    }
    const double t22 = 0.5 * twist6;
    const double t23 = t22 * t22;
    const bool t24 = (t23 < 0.12111325347955035);
    double t42, t43, t44;
    if (t24) {
        const double t25 = t23 * (t23 * (t23 * 2.763326749998937e-07 + 2.480148377847191e-05) +
            0.001388888895391314);
        const double t26 = 0.00019841269891276224 + t23 * (2.755723960835094e-06 + t23 *
            2.5110520415965448e-08);
        const double t27 = 1.0 + t23 * (0.16666666666666682 + t23 * (0.008333333333319138 + t23 *
            t26));
        t42 = 1.0 + t23 * (t23 * (t25 + 0.04166666666648207) + 0.5000000000000019);
        t43 = t22 * t27;
        t44 = t27;
    } else {
        const double t28 = std::floor(0.5 + twist6 * 0.7213475204444817);
        const double t29 = std::exp2(t28);
        const double t30 = std::exp2(-t28);
        const double t31 = 0.5 * (t29 + t30);
        const double t32 = t22 - t28 * 0.6931471675634384 - t28 * 1.2996506893889889e-08;
        const double t33 = t32 * t32;
        const double t34 = t33 * (0.001388888895391314 + t33 * (2.480148377847191e-05 +
            2.763326749998937e-07 * t33));
        const double t35 = 1.0 + t33 * (0.5000000000000019 + t33 * (0.04166666666648207 + t34));
        const double t36 = 0.5 * (t29 - t30);
        const double t37 = t33 * (t33 * 2.5110520415965448e-08 + 2.755723960835094e-06) +
            0.00019841269891276224;
        const double t38 = 1.0 + t33 * (t33 * (t33 * t37 + 0.008333333333319138) +
            0.16666666666666682);
        const double t39 = t32 * t38;
        const double t40 = t35 * t36 + t31 * t39;
        double t41;
        if (std::abs(t28) < 0.5) {
            t41 = t38;
        } else {
            t41 = std::abs(t40) / std::max(std::abs(t22), 0.25);
        }
        t42 = t31 * t35 + t36 * t39;
        t43 = t40;
        t44 = t41;
    }
    const double t45 = t20 * t42;
    const double t46 = t2 * t21;
    const double t47 = t42 * t46;
    const double t48 = t1 * t21;
    const double t49 = t42 * t48;
    const double t50 = t0 * t21;
    const double t51 = t42 * t50;
    const double t52 = t20 * t43;
    const double t53 = t46 * t43;
    const double t54 = t48 * t43;
    const double t55 = t50 * t43;
    const double t56 = m0 * t45 - m3 * t47 - m2 * t49 - m1 * t51 + (m4 * t52 - m7 * t53 - m6 * t54 -
        m5 * t55);
    const double t57 = m0 * t51 - t47 * m2 + t45 * m1 + m3 * t49 + (m4 * t55 - t53 * m6 + t52 * m5 +
        m7 * t54);
    const double t58 = m3 * t51 - m0 * t49 - t45 * m2 - t47 * m1 + (m7 * t55 - m4 * t54 - t52 * m6 -
        t53 * m5);
    const double t59 = m0 * t47 + t45 * m3 - t49 * m1 + m2 * t51 + (m4 * t53 + t52 * m7 - t54 * m5 +
        m6 * t55);
    const double t60 = m0 * t52 - m3 * t53 - m2 * t54 - m1 * t55 + (t45 * m4 - t47 * m7 - t49 * m6 -
        t51 * m5);
    const double t61 = m0 * t55 - m2 * t53 + m1 * t52 + m3 * t54 + (t51 * m4 - t47 * m6 + t45 * m5 +
        t49 * m7);
    const double t62 = m3 * t55 - m0 * t54 - m2 * t52 - m1 * t53 + (t51 * m7 - t49 * m4 - t45 * m6 -
        t47 * m5);
    const double t63 = m0 * t53 + m3 * t52 - m1 * t54 + m2 * t55 + (t47 * m4 + t45 * m7 - t49 * m5 +
        t51 * m6);
    const double t64 = m0 + m4;
    const double t65 = -0.5 * twist3;
    const double t66 = t20 * t44;
    const double t67 = -0.5 * twist4;
    const double t68 = -0.5 * twist5;
    const double t69 = t2 * t67 - t1 * t68;
    const double t70 = t0 * t68 - t2 * t65;
    const double t71 = t1 * t65 - t0 * t67;
    const double t72 = (t42 * t21 - t66) / std::max(t3 + t23, 1.0947644252537633e-47);
    const double t73 = t65 * t66 + (t22 * t69 - (t2 * t70 - t1 * t71)) * t72;
    const double t74 = m3 + m7;
    const double t75 = t66 * t67 + t72 * (t22 * t70 - (t0 * t71 - t2 * t69));
    const double t76 = m2 + m6;
    const double t77 = t66 * t68 + t72 * (t22 * t71 - (t1 * t69 - t0 * t70));
    const double t78 = m1 + m5;
    const double t79 = (t2 * t68 + t0 * t65 + t1 * t67) * (t21 * t44);
    const double t80 = t45 - t52;
    const double t81 = t47 - t53;
    const double t82 = t54 - t49;
    const double t83 = t51 - t55;
    const double t84 = t64 * t73 + t74 * t75 - t76 * t77 - t78 * t79 + (m8 * t80 - m9 * t81 - m10 *
        t82 - m11 * t83);
    const double t85 = t64 * t75 - t76 * t79 + t77 * t78 - t73 * t74 + (m8 * t81 + t80 * m9 + t82 *
        m11 - m10 * t83);
    const double t86 = t64 * t77 - t74 * t79 + t73 * t76 - t75 * t78 + (m8 * t82 + m9 * t83 + t80 *
        m10 - t81 * m11);
    const double t87 = t64 * t79 + t74 * t77 + t73 * t78 + t75 * t76 + (m8 * t83 + t81 * m10 + t80 *
        m11 - m9 * t82);
    return {
        t56,
        t57,
        -t58,
        t59,
        t60,
        t61,
        -t62,
        t63,
        t84,
        t85,
        t86,
        t87,
    };
}

/*
 * The twist, turning by at most π, that takes rotor a to b
 * a: 1 e23 e31 e12
 * b: 1 e23 e31 e12
 * returns: rx ry rz
 */
inline std::array<double, 3> local(const std::array<double, 4> &a, const std::array<double, 4> &b)
{
    const double a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const double b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
    const double t1 = ((t0 < 0.0) ? -1.0 : 1.0);
    const double t2 = 1.0 - t0 * t1;
    double t12;
    if (t2 < 0.05) {
        const double t3 = t2 * (t2 * (t2 * 0.002734180087163666 + 0.005307498678423399) +
            0.011544886911341685);
        const double t4 = t2 * (t2 * (t2 * (t3 + 0.025396804776123976) + 0.057142857406109096) +
            0.13333333333168498);
        t12 = 1.0 + t2 * (t4 + 0.33333333333333726);
    } else {
        const double t5 = t2 * (t2 * (t2 * 8.121007252839173e-05 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t6 = t2 * (t2 * (t5 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t7 = t2 * (t2 * (t2 * t6 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t8 = t2 * (t2 * (t2 * t7 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t9 = t2 * (t2 * (t2 * t8 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t10 = t2 * (t2 * (t2 * t9 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t11 = t2 * (t2 * (t2 * t10 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        t12 = 1.0 + t2 * t11;
    }
    return {
        -2.0 * (t12 * (t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2))),
        -(-2.0 * (t12 * (t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1)))),
        -2.0 * (t12 * (t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1))),
    };
}

/*
 * The twist, turning by at most π, that takes motor a to b
 * a: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * b: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: rx ry rz x y z
 */
inline std::array<double, 6> local(const std::array<double, 8> &a, const std::array<double, 8> &b)
{
    const double a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const double a4 = a[4], a5 = a[5], a6 = a[6], a7 = a[7];
    const double b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    const double b4 = b[4], b5 = b[5], b6 = b[6], b7 = b[7];
    const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1;
    const double t1 = ((t0 < 0.0) ? -1.0 : 1.0);
    const double t2 = 1.0 - t0 * t1;
    const bool t3 = (t2 < 0.05);
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
    return {
        -2.0 * (t23 * t25),
        -(-2.0 * (t23 * t26)),
        -2.0 * (t23 * t27),
        -2.0 * (t28 + t25 * t29),
        -2.0 * (t30 - t26 * t29),
        -2.0 * (t31 + t27 * t29),
    };
}

/*
 * The twist, turning by at most π, that takes similarity a to b
 * a: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * b: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * returns: rx ry rz x y z log_scale
 */
inline std::array<double, 7> local(const std::array<double, 12> &a, const std::array<double, 12> &b)
{
    const double a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    const double a4 = a[4], a5 = a[5], a6 = a[6], a7 = a[7];
    const double a8 = a[8], a9 = a[9], a10 = a[10], a11 = a[11];
    const double b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
    const double b4 = b[4], b5 = b[5], b6 = b[6], b7 = b[7];
    const double b8 = b[8], b9 = b[9], b10 = b[10], b11 = b[11];
    const double t0 = a0 * b0 + a3 * b3 + a2 * b2 + a1 * b1 - (a4 * b4 + a7 * b7 + a6 * b6 + a5 *
        b5);
    const double t1 = ((t0 < 0.0) ? -1.0 : 1.0);
    const double t2 = t0 * t1;
    const double t3 = t1 * (a0 * b3 - b0 * a3 + b2 * a1 - a2 * b1 + (b4 * a7 - a4 * b7 - b6 * a5 +
        a6 * b5));
    const double t4 = t1 * (b0 * a2 - (a0 * b2 + a3 * b1) + b3 * a1 + (a4 * b6 + a7 * b5 - b4 * a6 -
        b7 * a5));
    const double t5 = t1 * (a0 * b1 + b3 * a2 - b0 * a1 - a3 * b2 + (b4 * a5 - (a4 * b5 + b7 * a6) +
        a7 * b6));
    const double t6 = std::sqrt(t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
    const double t7 = 1.0 / t6;
    const double t8 = t2 * t7;
    const double t9 = 1.0 - t8;
    double t19;
    if (t9 < 0.05) {
        const double t10 = t9 * (t9 * (t9 * 0.002734180087163666 + 0.005307498678423399) +
            0.011544886911341685);
        const double t11 = t9 * (t9 * (t10 + 0.025396804776123976) + 0.057142857406109096) +
            0.13333333333168498;
        t19 = 1.0 + t9 * (t9 * t11 + 0.33333333333333726);
    } else {
        const double t12 = t9 * (t9 * (t9 * 8.121007252839173e-05 + -0.0007281273643381516) +
            0.0030973904722135883);
        const double t13 = t9 * (t9 * (t12 + -0.00821750089765482) + 0.015180613767041282) +
            -0.020647830091351717;
        const double t14 = t9 * (t9 * (t9 * t13 + 0.02139495485791656) + -0.017185237019630522) +
            0.010890803896660979;
        const double t15 = t9 * (t9 * (t9 * t14 + -0.0053548548506220615) + 0.0022588396994592773) +
            -0.00039674989569360273;
        const double t16 = t9 * (t9 * (t9 * t15 + 0.0007138968794314861) + 0.0011403814338107978) +
            0.002490569286343547;
        const double t17 = t9 * (t9 * (t9 * t16 + 0.005327576046333906) + 0.011544042766655997) +
            0.02539682388201735;
        const double t18 = t9 * (t9 * (t9 * t17 + 0.0571428571878089) + 0.1333333333326277) +
            0.3333333333333377;
        t19 = 1.0 + t9 * t18;
    }
    const double t20 = t5 * t7;
    const double t21 = t4 * t7;
    const double t22 = t3 * t7;
    const double t23 = a0 - a4;
    const double t24 = a7 - a3;
    const double t25 = a2 - a6;
    const double t26 = a5 - a1;
    const double t27 = b3 - b7;
    const double t28 = b0 - b4;
    const double t29 = b6 - b2;
    const double t30 = b1 - b5;
    const double t31 = t23 * b8 + t24 * b9 + t25 * b10 - t26 * b11 + (a9 * t27 - a8 * t28 + a10 *
        t29 - a11 * t30);
    const double t32 = t1 * t31;
    const double t33 = t23 * b11 + t24 * b10 + b8 * t26 - b9 * t25 + (t28 * a11 - (a8 * t30 + t27 *
        a10) + a9 * t29);
    const double t34 = t1 * t33;
    const double t35 = t1 * (a0 * b4 + a3 * b7 + a2 * b6 + a1 * b5 - (b0 * a4 + b3 * a7 + b2 * a6 +
        b1 * a5));
    const double t36 = t1 * (a0 * b7 - a3 * b4 + a1 * b6 - a2 * b5 + (b0 * a7 - b3 * a4 - b2 * a5 +
        b1 * a6));
    const double t37 = t1 * (a2 * b4 - (a0 * b6 + a3 * b5) + a1 * b7 + (b2 * a4 + b1 * a7 - b0 * a6
        - b3 * a5));
    const double t38 = t1 * (a0 * b5 + a2 * b7 - a1 * b4 - a3 * b6 + (b0 * a5 - (b1 * a4 + b3 * a6)
        + b2 * a7));
    const double t39 = t8 * t35 + t22 * t36 + t21 * t37 + t20 * t38;
    const double t40 = t39 * t39;
    double t57;
    if (t40 < 0.126) {
        const double t41 = t40 * (t40 * (t40 * -0.005811206588331519 + 0.010599129520028859) +
            -0.01383075592600594);
        const double t42 = t40 * (t40 * (t41 + 0.017341108627894623) + -0.02237152504384804) +
            0.030381923311340625;
        const double t43 = t40 * (t40 * (t40 * t42 + -0.04464285673657631) + 0.07499999999602147) +
            -0.16666666666665153;
        t57 = 1.0 + t40 * t43;
    } else {
        const double t44 = std::abs(t39);
        const double t45 = t6 + t44;
        const double t46 = std::logb(1.4142135623730951 * t45);
        const bool t47 = (t46 < 0.5);
        double t49;
        if (t47) {
            t49 = t44;
        } else {
            const double t48 = t45 * std::exp2(-t46);
            t49 = 0.5 * (t48 - 1.0 / t48);
        }
        const double t50 = t49 * t49;
        const double t51 = t50 * (-0.01383075592600594 + t50 * (0.010599129520028859 +
            -0.005811206588331519 * t50));
        const double t52 = 0.030381923311340625 + t50 * (-0.02237152504384804 + t50 *
            (0.017341108627894623 + t51));
        const double t53 = -0.16666666666665153 + t50 * (0.07499999999602147 + t50 *
            (-0.04464285673657631 + t50 * t52));
        const double t54 = 1.0 + t50 * t53;
        double t56;
        if (t47) {
            t56 = t54;
        } else {
            const double t55 = (t46 * 0.6931471675634384 + (t46 * 1.2996506893889889e-08 + t49 *
                t54)) / std::max(t44, 0.25);
            t56 = t55;
        }
        t57 = t56;
    }
    const double t58 = t23 * b10 - t24 * b11 - b8 * t25 - b9 * t26 - (a8 * t29 + a9 * t30 + t28 *
        a10 + t27 * a11);
    const double t59 = t1 * t58;
    const double t60 = t20 * t59 - t22 * t32;
    const double t61 = t23 * b9 + t25 * b11 + b10 * t26 - b8 * t24 + (t29 * a11 - (t27 * a8 + a9 *
        t28) + a10 * t30);
    const double t62 = t1 * t61;
    const double t63 = t21 * t32 + t20 * t62;
    const double t64 = 1.0 / std::max(t40 + (t20 * t20 + t21 * t21 + t22 * t22),
        1.0947644252537633e-47);
    const double t65 = (t8 * t57 - t6 * t19) * t64;
    const double t66 = t22 * t62 + t21 * t59;
    const double t67 = t64 * (t39 * (t8 * t19 - t6 * t57));
    return {
        -2.0 * (t19 * t20),
        -(-2.0 * (t19 * t21)),
        -2.0 * (t19 * t22),
        -2.0 * ((t8 * t32 + t20 * t34) * t57 + (t22 * t60 - t21 * t63) * t65 + t66 * t67),
        -2.0 * (t57 * (t8 * t62 - t21 * t34) - t65 * (t20 * t63 + t22 * t66) + t60 * t67),
        -2.0 * (t57 * (t8 * t59 + t22 * t34) - t65 * (t21 * t66 + t20 * t60) - t63 * t67),
        2.0 * (t39 * t57),
    };
}

/*
 * Adjoint matrix of a rotor on twists
 * m: 1 e23 e31 e12
 * returns: m00 m01 m02 m10 m11 m12 m20 m21 m22
 */
template <class Real>
inline std::array<Real, 9> adjoint(const std::array<Real, 4> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real t0 = m1 * m1;
    const Real t1 = m3 * m3;
    const Real t2 = m0 * m0;
    const Real t3 = m2 * m2;
    const Real t4 = m1 * m2;
    const Real t5 = m3 * m0;
    const Real t6 = m1 * m3;
    const Real t7 = m0 * m2;
    const Real t8 = m3 * m2;
    const Real t9 = m1 * m0;
    return {
        t0 - t1 + t2 - t3,
        (t4 + t5) * Real(2.0),
        Real(2.0) * t6 - Real(2.0) * t7,
        t4 * Real(2.0) - t5 * Real(2.0),
        -(t1 + (t0 - t3 - t2)),
        Real(2.0) * (t8 + t9),
        Real(2.0) * (t6 + t7),
        Real(2.0) * (t8 - t9),
        t1 + t2 - t3 - t0,
    };
}

/*
 * Adjoint matrix of a motor on twists
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33
 *     m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55
 */
template <class Real>
inline std::array<Real, 36> adjoint(const std::array<Real, 8> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real t0 = m1 * m1;
    const Real t1 = m3 * m3;
    const Real t2 = m0 * m0;
    const Real t3 = m2 * m2;
    const Real t4 = m1 * m2;
    const Real t5 = m3 * m0;
    const Real t6 = m1 * m3;
    const Real t7 = m0 * m2;
    const Real t8 = t4 * Real(2.0);
    const Real t9 = t5 * Real(2.0);
    const Real t10 = t8 - t9;
    const Real t11 = m3 * m2;
    const Real t12 = m1 * m0;
    const Real t13 = t11 + t12;
    const Real t14 = Real(2.0) * (t6 + t7);
    const Real t15 = t11 - t12;
    const Real t16 = m1 * m4;
    const Real t17 = m2 * m5;
    const Real t18 = m3 * m6;
    const Real t19 = m0 * m7;
    const Real t20 = m2 * m4 + m1 * m5;
    const Real t21 = m0 * m6;
    const Real t22 = m3 * m7;
    const Real t23 = m3 * m4;
    const Real t24 = m1 * m6;
    const Real t25 = m2 * m7;
    const Real t26 = m0 * m5;
    const Real t27 = t2 - t1;
    const Real t28 = m3 * m5;
    const Real t29 = m2 * m6;
    const Real t30 = m0 * m4;
    const Real t31 = m1 * m7;
    return {
        t0 - t1 + t2 - t3,
        (t4 + t5) * Real(2.0),
        Real(2.0) * t6 - Real(2.0) * t7,
        Real(0.0),
        Real(0.0),
        Real(0.0),
        t10,
        -(t1 + (t0 - t3 - t2)),
        t11 + (t12 + t13),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        t14,
        t11 + t15 - t12,
        t1 + t2 - t3 - t0,
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(2.0) * (t16 - t17 - t18 - t19),
        Real(2.0) * (t20 + t21 - t22),
        Real(2.0) * (t23 + (t24 + t25) - t26),
        t0 + (t27 - t3),
        t9 + t8,
        Real(2.0) * (t6 - t7),
        Real(2.0) * (t20 + t22 - t21),
        Real(2.0) * (t17 - t19 - t18 - t16),
        Real(2.0) * (t28 + (t29 + t30) - t31),
        t10,
        t3 + t27 - t0,
        t12 + (t11 + t13),
        Real(2.0) * (t24 + (t23 + t26) - t25),
        Real(2.0) * t29 + (Real(2.0) * t28 + Real(2.0) * t31) - Real(2.0) * t30,
        Real(2.0) * (t18 - t17 - t16 - t19),
        t14,
        t11 + (t15 - t12),
        t1 + (t2 - (t0 + t3)),
    };
}

/*
 * Adjoint matrix of a similarity on twists
 * m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * returns: m00 m01 m02 m03 m04 m05 m06 m10 m11 m12 m13 m14 m15 m16 m20 m21 m22 m23 m24 m25 m26 m30
 *     m31 m32 m33 m34 m35 m36 m40 m41 m42 m43 m44 m45 m46 m50 m51 m52 m53 m54 m55 m56 m60 m61 m62
 *     m63 m64 m65 m66
 */
template <class Real>
inline std::array<Real, 49> adjoint(const std::array<Real, 12> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real m8 = m[8], m9 = m[9], m10 = m[10], m11 = m[11];
    const Real t0 = m1 + m5;
    const Real t1 = m1 - m5;
    const Real t2 = t0 * t1;
    const Real t3 = m3 + m7;
    const Real t4 = m3 - m7;
    const Real t5 = t3 * t4;
    const Real t6 = m0 + m4;
    const Real t7 = m0 - m4;
    const Real t8 = t6 * t7;
    const Real t9 = m2 + m6;
    const Real t10 = m6 - m2;
    const Real t11 = t9 * t10;
    const Real t12 = t1 * t9;
    const Real t13 = t4 * t6;
    const Real t14 = t3 * t7;
    const Real t15 = t0 * t10;
    const Real t16 = t1 * t3;
    const Real t17 = t0 * t4;
    const Real t18 = t7 * t9;
    const Real t19 = t6 * t10;
    const Real t20 = t4 * t9;
    const Real t21 = t3 * t10;
    const Real t22 = t1 * t6;
    const Real t23 = t0 * t7;
    const Real t24 = t0 * m8;
    const Real t25 = t24 * Real(2.0);
    const Real t26 = t9 * m9;
    const Real t27 = t26 * Real(2.0);
    const Real t28 = t3 * m10;
    const Real t29 = t6 * m11;
    const Real t30 = t28 + t29;
    const Real t31 = t9 * m8;
    const Real t32 = t0 * m9;
    const Real t33 = t31 + t32;
    const Real t34 = t6 * m10;
    const Real t35 = t3 * m11;
    const Real t36 = t3 * m8;
    const Real t37 = t6 * m9;
    const Real t38 = t0 * m10;
    const Real t39 = t9 * m11;
    const Real t40 = t6 * t6;
    const Real t41 = t3 * t3;
    const Real t42 = t40 - t41;
    const Real t43 = t9 * t9;
    const Real t44 = t0 * t0;
    const Real t45 = Real(2.0) * (t3 * t6);
    const Real t46 = Real(2.0) * (t0 * t9);
    const Real t47 = t0 * t3;
    const Real t48 = t6 * t9;
    const Real t49 = t6 * m8;
    const Real t50 = t3 * m9;
    const Real t51 = t49 + t50;
    const Real t52 = t0 * m11;
    const Real t53 = t9 * m10;
    const Real t54 = t3 * t9;
    const Real t55 = t0 * t6;
    return {
        t2 - t5 + t8 + t11,
        t12 + t13 + t14 - t15,
        t16 + t17 - t18 + t19,
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        -(t13 + (t14 + (t15 - t12))),
        -(t5 + (t2 + t11 - t8)),
        t20 - (t21 - t22 - t23),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        t16 + (t17 + t18 - t19),
        t20 - t23 - t21 - t22,
        t11 + (t5 + t8) - t2,
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        t25 - t27 - t28 - t29 - t30,
        Real(2.0) * (t33 + t34 - t35),
        Real(2.0) * (t36 - t37 + t38 + t39),
        t42 - t43 + t44,
        t45 + t46,
        Real(2.0) * (t47 - t48),
        Real(2.0) * (t51 + t52 - t53),
        Real(2.0) * (t33 + t35 - t34),
        t27 - t29 - t28 - t25 - t30,
        t51 + (t50 + (t49 + Real(2.0) * t53) - Real(2.0) * t52),
        t46 - t45,
        t42 + t43 - t44,
        Real(2.0) * (t54 + t55),
        Real(2.0) * (t37 + (t38 + t39) - t36),
        Real(2.0) * (t38 - t39 + (t36 + t37)),
        Real(2.0) * (t50 + (t53 + t52 - t49)),
        Real(2.0) * (t28 - t29 - t24 - t26),
        Real(2.0) * (t47 + t48),
        Real(2.0) * (t54 - t55),
        t41 + (t40 - (t43 + t44)),
        Real(2.0) * (t31 + (t34 + t35) - t32),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(0.0),
        Real(1.0),
    };
}

/*
 * Inverse left Jacobian of a rotor's exponential, singular at full turns
 * twist: rx ry rz
 * returns: m00 m01 m02 m10 m11 m12 m20 m21 m22
 */
inline std::array<double, 9> left_jacobian_inverse(const std::array<double, 3> &twist)
{
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2];
    const double t0 = -0.5 * twist1;
    const double t1 = -0.5 * twist2;
    const double t2 = twist2 * t1;
    const double t3 = -0.5 * twist0;
    const double t4 = t1 * t1 + t0 * t0 + t3 * t3;
    double t29;
    if (t4 < 2.4674011002723395) {
        const double t5 = std::min(t4, 2.4674011002723395);
        const double t6 = t5 * (t5 * (4.190860689573733e-14 * t5 + -3.105093875068576e-13) +
            2.52116134224849e-12);
        const double t7 = t5 * (t5 * (t6 + -4.868906238981723e-13) + 7.053760152595475e-11) +
            5.42546914811746e-10;
        const double t8 = t5 * (t5 * (t5 * t7 + 5.574566759681558e-09) + 5.479985772581718e-08) +
            5.411083420356027e-07;
        const double t9 = t5 * (t5 * (t5 * t8 + 5.344447517065357e-06) + 5.2910053333655655e-05) +
            0.0005291005290594417;
        t29 = t5 * (t5 * t9 + 0.0055555555555571205) + 0.08333333333333333;
    } else {
        const bool t10 = (t4 < 2.4684011002723394);
        double t26, t27;
        if (t10) {
            const double t11 = t4 * (t4 * (t4 * 4.608909074888812e-14 + -1.146289561457958e-11) +
                2.0876561604575935e-09);
            const double t12 = t4 * (t4 * (t11 + -2.7557316386461366e-07) + 2.4801587277366174e-05)
                + -0.0013888888888772708;
            const double t13 = t4 * (t4 * (t4 * 2.721539074015491e-15 + -7.643023238169083e-13) +
                1.6058940754212953e-10);
            const double t14 = t4 * (t4 * (t13 + -2.505210688815946e-08) + 2.755731921120387e-06) +
                -0.00019841269841208527;
            t26 = 1.0 + t4 * (t4 * (t4 * t12 + 0.041666666666663875) + -0.4999999999999997);
            t27 = 1.0 + t4 * (t4 * (t4 * t14 + 0.008333333333333186) + -0.16666666666666666);
        } else {
            const double t15 = std::sqrt(t4);
            const double t16 = std::floor(0.3183098861837907 * t15 + 0.5);
            const double t17 = 1.0 - 2.0 * (t16 - std::floor(0.5 * t16) * 2.0);
            const double t18 = t15 - t16 * 3.1415926218032837 - t16 * 3.1786509424591713e-08 - t16 *
                1.2246467202362698e-16;
            const double t19 = t18 - t16 * 7.891108333126411e-24;
            const double t20 = t19 * t19;
            const double t21 = 2.0876561604575935e-09 + t20 * (-1.146289561457958e-11 +
                4.608909074888812e-14 * t20);
            const double t22 = -0.0013888888888772708 + t20 * (2.4801587277366174e-05 + t20 *
                (-2.7557316386461366e-07 + t20 * t21));
            const double t23 = 1.6058940754212953e-10 + t20 * (-7.643023238169083e-13 + t20 *
                2.721539074015491e-15);
            const double t24 = -0.00019841269841208527 + t20 * (2.755731921120387e-06 + t20 *
                (-2.505210688815946e-08 + t20 * t23));
            const double t25 = t17 * t19 * (1.0 + t20 * (-0.16666666666666666 + t20 *
                (0.008333333333333186 + t20 * t24)));
            t26 = t17 * (1.0 + t20 * (-0.4999999999999997 + t20 * (0.041666666666663875 + t20 *
                t22)));
            t27 = t25 / std::max(1.0, t15);
        }
        const double t28 = 1.0 - t26 * (((t27 < 0.0) ? -1.0 : 1.0) / std::max(std::abs(t27),
            4.930380657631324e-32));
        t29 = t28 / (4.0 * std::max(t4, 2.4674011002723395));
    }
    const double t30 = 2.0 * t29;
    const double t31 = t3 * 2.0;
    const double t32 = t3 * t31;
    const double t33 = t0 * 2.0;
    return {
        1.0 + (twist1 * t0 + t2) * t30,
        t30 * (t0 * t31) - t1,
        t0 + t30 * (t1 * t31),
        t1 - t30 * (twist1 * t3),
        -(-1.0 + t30 * (t32 - t2)),
        t30 * (t1 * t33) - t3,
        -(t30 * (twist2 * t3)) - t0,
        t3 - t30 * (twist2 * t0),
        1.0 + t30 * (-t32 - t0 * t33),
    };
}

/*
 * Inverse left Jacobian of a motor's exponential, singular at full turns
 * twist: rx ry rz x y z
 * returns: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33
 *     m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55
 */
inline std::array<double, 36> left_jacobian_inverse(const std::array<double, 6> &twist)
{
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2], twist3 = twist[3];
    const double twist4 = twist[4], twist5 = twist[5];
    const double t0 = -0.5 * twist2;
    const double t1 = -0.5 * twist1;
    const double t2 = -0.5 * twist0;
    const double t3 = t0 * t0 + t1 * t1 + t2 * t2;
    const bool t4 = (t3 < 2.4674011002723395);
    double t36, t37;
    if (t4) {
        const double t5 = std::min(t3, 2.4674011002723395);
        const double t6 = t5 * (t5 * (4.190860689573733e-14 * t5 + -3.105093875068576e-13) +
            2.52116134224849e-12);
        const double t7 = t5 * (t5 * (t6 + -4.868906238981723e-13) + 7.053760152595475e-11) +
            5.42546914811746e-10;
        const double t8 = t5 * (t5 * (t5 * t7 + 5.574566759681558e-09) + 5.479985772581718e-08) +
            5.411083420356027e-07;
        const double t9 = t5 * (t5 * (t5 * t8 + 5.344447517065357e-06) + 5.2910053333655655e-05) +
            0.0005291005290594417;
        const double t10 = t5 * (t5 * (t5 * 8.561420266877998e-15 + -7.887796790985613e-14) +
            5.840902112904286e-13);
        const double t11 = t5 * (t5 * (t10 + -1.1102488422040386e-12) + 1.0866640876189362e-11) +
            5.0219390448129135e-11;
        const double t12 = t5 * (t5 * (t5 * t11 + 5.222702207898614e-10) + 4.4936669940499006e-09) +
            3.8880353832927835e-08;
        const double t13 = t5 * (t5 * (t5 * t12 + 3.288872381982998e-07) + 2.705505882992825e-06) +
            2.137779906977056e-05;
        const double t14 = t5 * (t5 * (t5 * t13 + 0.00015873015873738575) + 0.0010582010582008187) +
            0.005555555555555557;
        t36 = t5 * (t5 * t9 + 0.0055555555555571205) + 0.08333333333333333;
        t37 = t14;
    } else {
        const bool t15 = (t3 < 2.4684011002723394);
        double t31, t32;
        if (t15) {
            const double t16 = t3 * (t3 * (t3 * 4.608909074888812e-14 + -1.146289561457958e-11) +
                2.0876561604575935e-09);
            const double t17 = t3 * (t3 * (t16 + -2.7557316386461366e-07) + 2.4801587277366174e-05)
                + -0.0013888888888772708;
            const double t18 = t3 * (t3 * (t3 * 2.721539074015491e-15 + -7.643023238169083e-13) +
                1.6058940754212953e-10);
            const double t19 = t3 * (t3 * (t18 + -2.505210688815946e-08) + 2.755731921120387e-06) +
                -0.00019841269841208527;
            t31 = 1.0 + t3 * (t3 * (t3 * t17 + 0.041666666666663875) + -0.4999999999999997);
            t32 = 1.0 + t3 * (t3 * (t3 * t19 + 0.008333333333333186) + -0.16666666666666666);
        } else {
            const double t20 = std::sqrt(t3);
            const double t21 = std::floor(0.3183098861837907 * t20 + 0.5);
            const double t22 = 1.0 - 2.0 * (t21 - std::floor(0.5 * t21) * 2.0);
            const double t23 = t20 - t21 * 3.1415926218032837 - t21 * 3.1786509424591713e-08 - t21 *
                1.2246467202362698e-16;
            const double t24 = t23 - t21 * 7.891108333126411e-24;
            const double t25 = t24 * t24;
            const double t26 = 2.0876561604575935e-09 + t25 * (-1.146289561457958e-11 +
                4.608909074888812e-14 * t25);
            const double t27 = -0.0013888888888772708 + t25 * (2.4801587277366174e-05 + t25 *
                (-2.7557316386461366e-07 + t25 * t26));
            const double t28 = 1.6058940754212953e-10 + t25 * (-7.643023238169083e-13 + t25 *
                2.721539074015491e-15);
            const double t29 = -0.00019841269841208527 + t25 * (2.755731921120387e-06 + t25 *
                (-2.505210688815946e-08 + t25 * t28));
            const double t30 = t22 * t24 * (1.0 + t25 * (-0.16666666666666666 + t25 *
                (0.008333333333333186 + t25 * t29)));
            t31 = t22 * (1.0 + t25 * (-0.4999999999999997 + t25 * (0.041666666666663875 + t25 *
                t27)));
            t32 = t30 / std::max(1.0, t20);
        }
        const double t33 = ((t32 < 0.0) ? -1.0 : 1.0) / std::max(std::abs(t32),
            4.930380657631324e-32);
        const double t34 = t31 * t33;
        const double t35 = std::max(t3, 2.4674011002723395);
        t36 = (1.0 - t34) / (4.0 * t35);
        t37 = (t34 + t33 * t33 - 2.0) / (t35 * (t35 * 8.0));
    }
    const double t38 = twist1 * t1;
    const double t39 = twist2 * t0;
    const double t40 = 2.0 * (t38 + t39);
    const double t41 = t2 * 2.0;
    const double t42 = 2.0 * (t1 * t41);
    const double t43 = t36 * t42 - t0;
    const double t44 = 2.0 * (t0 * t41);
    const double t45 = 2.0 * (twist1 * t2);
    const double t46 = t0 - t36 * t45;
    const double t47 = t2 * t41;
    const double t48 = 2.0 * (t47 - t39);
    const double t49 = t1 * 2.0;
    const double t50 = 2.0 * (t0 * t49);
    const double t51 = t36 * t50 - t2;
    const double t52 = 2.0 * (twist2 * t2);
    const double t53 = 2.0 * (twist2 * t1);
    const double t54 = t2 - t36 * t53;
    const double t55 = t1 * t49;
    const double t56 = 2.0 * (-t47 - t55);
    const double t57 = -0.5 * twist5;
    const double t58 = 2.0 * t57;
    const double t59 = -0.5 * twist4;
    const double t60 = twist2 * t57;
    const double t61 = 2.0 * t36;
    const double t62 = -0.5 * twist3;
    const double t63 = t37 * (2.0 * (t2 * t62 + (t0 * t57 + t1 * t59)));
    const double t64 = 2.0 * t62;
    const double t65 = t0 * 2.0;
    const double t66 = -(t41 * t62);
    const double t67 = 2.0 * t59;
    return {
        1.0 + t36 * t40,
        t43,
        t1 + t36 * t44,
        0.0,
        0.0,
        0.0,
        t46,
        -(-1.0 + t36 * t48),
        t51,
        0.0,
        0.0,
        0.0,
        -(t36 * t52) - t1,
        t54,
        1.0 + t36 * t56,
        0.0,
        0.0,
        0.0,
        (t1 * twist4 - t0 * t58 + twist1 * t59 + t60) * t61 + t40 * t63,
        t61 * (t1 * t64 + t41 * t59) + t42 * t63 - t57,
        t59 + (t61 * (t41 * t57 - t0 * twist3) + t44 * t63),
        1.0 + t61 * (t38 - t0 * t65),
        t43,
        t1 - t61 * (t0 * twist0),
        t57 + (-(t61 * (twist1 * t62 + t2 * twist4)) - t45 * t63),
        t61 * (t60 + (t66 - t2 * t64 + t0 * twist5)) - t48 * t63,
        t61 * (t0 * t67 + t49 * t57) + t50 * t63 - t62,
        t46,
        1.0 + (t39 - t47) * t61,
        t51,
        t61 * (t2 * t58 - twist2 * t62) - t52 * t63 - t59,
        t62 + (-(t61 * (twist2 * t59 + t1 * twist5)) - t53 * t63),
        t61 * (t66 - t49 * t59 - t1 * t67 + t2 * twist3) + t56 * t63,
        t61 * (t2 * t65) - t1,
        t54,
        1.0 + t61 * (twist0 * t2 - t55),
    };
}

/*
 * Inverse left Jacobian of a similarity's exponential, singular at full turns
 * twist: rx ry rz x y z log_scale
 * returns: m00 m01 m02 m03 m04 m05 m06 m10 m11 m12 m13 m14 m15 m16 m20 m21 m22 m23 m24 m25 m26 m30
 *     m31 m32 m33 m34 m35 m36 m40 m41 m42 m43 m44 m45 m46 m50 m51 m52 m53 m54 m55 m56 m60 m61 m62
 *     m63 m64 m65 m66
 */
inline std::array<double, 49> left_jacobian_inverse(const std::array<double, 7> &twist)
{
    const double twist0 = twist[0], twist1 = twist[1], twist2 = twist[2], twist3 = twist[3];
    const double twist4 = twist[4], twist5 = twist[5], twist6 = twist[6];
    const double t0 = twist0 * twist0;
    const double t1 = twist1 * twist1;
    const double t2 = t0 + t1;
    const double t3 = twist2 * twist2;
    const double t4 = t2 + t3;
    const double t5 = 0.25 * t4;
    const bool t6 = (t5 < 2.4674011002723395);
    const bool t7 = (t5 < 2.4684011002723394);
    double t27, t28, t29;
    if (t7) {
        const double t8 = t5 * (t5 * (t4 * 1.152227268722203e-14 + -1.146289561457958e-11) +
            2.0876561604575935e-09);
        const double t9 = t5 * (t5 * (t8 + -2.7557316386461366e-07) + 2.4801587277366174e-05) +
            -0.0013888888888772708;
        const double t10 = t5 * (t5 * (t4 * 6.803847685038728e-16 + -7.643023238169083e-13) +
            1.6058940754212953e-10);
        const double t11 = t5 * (t5 * (t10 + -2.505210688815946e-08) + 2.755731921120387e-06) +
            -0.00019841269841208527;
        const double t12 = t5 * (t5 * (t4 * 5.443092660432092e-15 + -5.350144126598709e-12) +
            9.635366495989451e-10);
        const double t13 = t5 * (t5 * (t12 + -1.2526053501698183e-07) + 1.1022927685256208e-05) +
            -0.0005952380952367574;
        t27 = 1.0 + t5 * (t5 * (t5 * t9 + 0.041666666666663875) + -0.4999999999999997);
        t28 = 1.0 + t5 * (t5 * (t5 * t11 + 0.008333333333333186) + -0.16666666666666666);
        t29 = -0.16666666666666666 + t5 * (t5 * t13 + 0.01666666666666651);
    } else {
        const double t14 = std::sqrt(t5);
        const double t15 = std::floor(0.3183098861837907 * t14 + 0.5);
        const double t16 = 1.0 - 2.0 * (t15 - std::floor(0.5 * t15) * 2.0);
        const double t17 = t14 - t15 * 3.1415926218032837 - t15 * 3.1786509424591713e-08 - t15 *
            1.2246467202362698e-16;
        const double t18 = t17 - t15 * 7.891108333126411e-24;
        const double t19 = t18 * t18;
        const double t20 = 2.0876561604575935e-09 + t19 * (-1.146289561457958e-11 +
            4.608909074888812e-14 * t19);
        const double t21 = -0.0013888888888772708 + t19 * (2.4801587277366174e-05 + t19 *
            (-2.7557316386461366e-07 + t19 * t20));
        const double t22 = t16 * (1.0 + t19 * (-0.4999999999999997 + t19 * (0.041666666666663875 +
            t19 * t21)));
        const double t23 = 1.6058940754212953e-10 + t19 * (-7.643023238169083e-13 + t19 *
            2.721539074015491e-15);
        const double t24 = -0.00019841269841208527 + t19 * (2.755731921120387e-06 + t19 *
            (-2.505210688815946e-08 + t19 * t23));
        const double t25 = t16 * t18 * (1.0 + t19 * (-0.16666666666666666 + t19 *
            (0.008333333333333186 + t19 * t24)));
        const double t26 = t25 / std::max(1.0, t14);
        t27 = t22;
        t28 = t26;
        t29 = (t22 - t26) / (t4 * 0.5);
    }
    double t40, t41;
    if (t6) {
        const double t30 = std::min(t5, 2.4674011002723395);
        const double t31 = t30 * (t30 * (4.190860689573733e-14 * t30 + -3.105093875068576e-13) +
            2.52116134224849e-12);
        const double t32 = t30 * (t30 * (t31 + -4.868906238981723e-13) + 7.053760152595475e-11) +
            5.42546914811746e-10;
        const double t33 = t30 * (t30 * (t30 * t32 + 5.574566759681558e-09) + 5.479985772581718e-08)
            + 5.411083420356027e-07;
        const double t34 = t30 * (t30 * (t30 * t33 + 5.344447517065357e-06) +
            5.2910053333655655e-05) + 0.0005291005290594417;
        const double t35 = t30 * (t30 * -4.653304211418644e-15 + 5.362814048940375e-13) +
            -4.605580928658353e-11;
        const double t36 = t30 * (t30 * (t30 * t35 + 3.1322658499179184e-09) +
            -1.644445954441792e-07) + 6.413339737800479e-06;
        const double t37 = t30 * (t30 * (t30 * t36 + -0.00017636684303014454) +
            0.0031746031746025262) + -0.033333333333333284;
        t40 = t30 * (t30 * t34 + 0.0055555555555571205) + 0.08333333333333333;
        t41 = t30 * t37 + 0.16666666666666666;
    } else {
        const double t38 = 1.0 - t27 * (((t28 < 0.0) ? -1.0 : 1.0) / std::max(std::abs(t28),
            4.930380657631324e-32));
        const double t39 = 1.0 / (4.0 * std::max(t5, 2.4674011002723395));
        t40 = t38 * t39;
        t41 = t39 * (1.0 - t27 * t28);
    }
    const double t42 = t1 + t3;
    const double t43 = 1.0 - t40 * t42;
    const double t44 = twist0 * twist1;
    const double t45 = t40 * t44;
    const double t46 = twist2 * -0.5;
    const double t47 = t45 - t46;
    const double t48 = twist1 * -0.5;
    const double t49 = twist0 * twist2;
    const double t50 = t40 * t49;
    const double t51 = t48 + t50;
    const double t52 = t45 + t46;
    const double t53 = t0 + t3;
    const double t54 = 1.0 - t40 * t53;
    const double t55 = twist1 * twist2;
    const double t56 = t40 * t55;
    const double t57 = twist0 * -0.5;
    const double t58 = t56 - t57;
    const double t59 = t50 - t48;
    const double t60 = t56 + t57;
    const double t61 = 1.0 - t2 * t40;
    const double t62 = 2.0 * (twist0 * t43 + twist1 * t52 + twist2 * t59);
    const double t63 = twist6 * twist6;
    const double t64 = 1.0 / std::max(t4 + t63, 1.0947644252537633e-47);
    const double t65 = std::floor(0.5 + 1.4426950408889634 * twist6);
    const double t66 = twist6 - t65 * 0.6931471675634384 - t65 * 1.2996506893889889e-08;
    const double t67 = t66 * (t66 * (2.5110372746250102e-08 * t66 + 2.763307546557511e-07) +
        2.755724001024349e-06);
    const double t68 = t66 * (t66 * (t67 + 2.4801484301104542e-05) + 0.0001984126989089813) +
        0.0013888888953421457;
    const double t69 = t66 * (t66 * (t66 * t68 + 0.00833333333331928) + 0.04166666666648393) +
        0.16666666666666682;
    const double t70 = std::exp2(t65) * (1.0 + t66 * (1.0 + t66 * (t66 * t69 +
        0.5000000000000019)));
    const double t71 = t28 * (0.5 * t28);
    const double t72 = 0.25 * (t27 * t29 - t71);
    const double t73 = t63 * t64;
    const bool t74 = (std::abs(twist6) < 1.0);
    double t83, t84;
    if (t74) {
        const double t75 = std::max(-1.0, std::min(1.0, twist6));
        const double t76 = t75 * (t75 * 7.746377957473813e-13 + 1.1639533539491848e-11) +
            1.6057674136158497e-10;
        const double t77 = t75 * (t75 * (t75 * t76 + 2.087442623329743e-09) +
            2.5052117752083137e-08) + 2.7557335164569814e-07;
        const double t78 = t75 * (t75 * (t75 * t77 + 2.755731919111943e-06) +
            2.4801587245650116e-05) + 0.00019841269841324745;
        const double t79 = t75 * (t75 * (t75 * t78 + 0.0013888888888982337) + 0.008333333333333299)
            + 0.04166666666666608;
        const double t80 = 0.5 + t75 * (0.16666666666666666 + t75 * t79);
        t83 = 1.0 + t75 * t80;
        t84 = t80;
    } else {
        const double t81 = 1.0 / ((twist6 < 0.0) ? std::min(-1.0, twist6) : std::max(1.0, twist6));
        const double t82 = (t70 - 1.0) * t81;
        t83 = t82;
        t84 = t81 * (t82 - 1.0);
    }
    const double t85 = t83 - t84;
    const double t86 = t73 * t85 + t70 * (1.0 - t73) * (t71 - twist6 * t41);
    const double t87 = t64 * (t70 * (0.5 * (1.0 - t4 * t41) + twist6 * t72) - t86);
    const double t88 = twist2 * twist4 - twist1 * twist5;
    const double t89 = t64 * (twist6 * (t70 * t71 - t85) + t41 * (t4 * t70));
    const double t90 = t64 * (t70 * (0.25 * twist6 * (t28 * t29) - t72) - t89);
    const double t91 = twist1 * twist3 - twist0 * twist4;
    const double t92 = twist2 * twist3 - twist0 * twist5;
    const double t93 = twist1 * t91 + twist2 * t92;
    const double t94 = t87 * t88 + t90 * t93;
    const double t95 = t59 * twist4 - t52 * twist5;
    const double t96 = t52 * twist3 - t43 * twist4;
    const double t97 = t59 * twist3 - t43 * twist5;
    const double t98 = t62 * t94 + t86 * t95 + t89 * (t52 * t91 + t59 * t92 + (twist1 * t96 + twist2
        * t97));
    const double t99 = 1.0 / t83;
    const double t100 = t4 * t89;
    const double t101 = t83 - t100;
    const double t102 = t101 * t101 + t86 * (t4 * t86);
    const double t103 = t86 / t102;
    const double t104 = twist0 * t92 + twist1 * t88;
    const double t105 = t90 * t104 - t87 * t91;
    const double t106 = twist0 * t91 - twist2 * t88;
    const double t107 = t83 * twist4 + t86 * t92 + t89 * t106;
    const double t108 = t62 * t105 - t107 - t86 * t96 + t89 * (t43 * t92 + t52 * t88 + (twist0 * t97
        + twist1 * t95));
    const double t109 = t83 * twist5 - t86 * t91 + t89 * t104;
    const double t110 = t87 * t92 + t90 * t106;
    const double t111 = t109 + t62 * t110 + t86 * t97 + t89 * (t43 * t91 - t59 * t88 + (twist0 * t96
        - twist2 * t95));
    const double t112 = twist1 * t108 - twist2 * t111;
    const double t113 = (t86 * t86 - t89 * t101) / (t83 * t102);
    const double t114 = twist0 * t111 + twist1 * t98;
    const double t115 = twist2 * t98 + twist0 * t108;
    const double t116 = 2.0 * (twist0 * t47 + twist1 * t54 + twist2 * t60);
    const double t117 = t60 * twist4 - t54 * twist5;
    const double t118 = t54 * twist3 - t47 * twist4;
    const double t119 = t60 * twist3 - t47 * twist5;
    const double t120 = t109 + t94 * t116 + t86 * t117 + t89 * (t54 * t91 + t60 * t92 + (twist1 *
        t118 + twist2 * t119));
    const double t121 = t83 * twist3 - t86 * t88 - t89 * t93;
    const double t122 = t121 + t105 * t116 - t86 * t118 + t89 * (t47 * t92 + t54 * t88 + (twist0 *
        t119 + twist1 * t117));
    const double t123 = t110 * t116 + t86 * t119 + t89 * (t47 * t91 - t60 * t88 + (twist0 * t118 -
        twist2 * t117));
    const double t124 = twist1 * t122 - twist2 * t123;
    const double t125 = twist0 * t123 + twist1 * t120;
    const double t126 = twist2 * t120 + twist0 * t122;
    const double t127 = 2.0 * (twist0 * t51 + twist1 * t58 + twist2 * t61);
    const double t128 = t58 * twist3 - t51 * twist4;
    const double t129 = t61 * twist3 - t51 * twist5;
    const double t130 = t61 * twist4 - t58 * twist5;
    const double t131 = t105 * t127 - t86 * t128 + t89 * (t51 * t92 + t58 * t88 + (twist0 * t129 +
        twist1 * t130));
    const double t132 = t110 * t127 - t121 + t86 * t129 + t89 * (t51 * t91 - t61 * t88 + (twist0 *
        t128 - twist2 * t130));
    const double t133 = twist1 * t131 - twist2 * t132;
    const double t134 = t107 - t94 * t127 - t86 * t130 - t89 * (t58 * t91 + t61 * t92 + (twist1 *
        t128 + twist2 * t129));
    const double t135 = twist0 * t132 - twist1 * t134;
    const double t136 = twist0 * t131 - twist2 * t134;
    const double t137 = twist2 * t103;
    const double t138 = t44 * t113;
    const double t139 = t49 * t113;
    const double t140 = twist1 * t103;
    const double t141 = t64 * (t100 + twist6 * (t86 - t84));
    const double t142 = t64 * (t84 - t86 + twist6 * t89);
    const double t143 = t84 * twist3 - t88 * t141 - t93 * t142;
    const double t144 = t84 * twist4 + t92 * t141 + t106 * t142;
    const double t145 = t84 * twist5 - t91 * t141 + t104 * t142;
    const double t146 = twist2 * t144 - twist1 * t145;
    const double t147 = twist1 * t143 - twist0 * t144;
    const double t148 = twist2 * t143 - twist0 * t145;
    const double t149 = twist0 * t103;
    const double t150 = t55 * t113;
    return {
        t43,
        t47,
        t51,
        0.0,
        0.0,
        0.0,
        0.0,
        t52,
        t54,
        t58,
        0.0,
        0.0,
        0.0,
        0.0,
        t59,
        t60,
        t61,
        0.0,
        0.0,
        0.0,
        0.0,
        t98 * t99 + t103 * t112 - t113 * (twist1 * t114 + twist2 * t115),
        t99 * t120 + t103 * t124 - t113 * (twist1 * t125 + twist2 * t126),
        t103 * t133 - t99 * t134 - t113 * (twist1 * t135 + twist2 * t136),
        t99 - t42 * t113,
        t137 + t138,
        t139 - t140,
        t99 * t143 + t103 * t146 - t113 * (twist1 * t147 + twist2 * t148),
        t113 * (twist0 * t114 - twist2 * t112) - (t99 * t111 + t103 * t115),
        t113 * (twist0 * t125 - twist2 * t124) - (t99 * t123 + t103 * t126),
        t113 * (twist0 * t135 - twist2 * t133) - (t99 * t132 + t103 * t136),
        t138 - t137,
        t99 - t53 * t113,
        t149 + t150,
        t99 * t144 - t103 * t148 + t113 * (twist0 * t147 - twist2 * t146),
        t103 * t114 - t99 * t108 + t113 * (twist0 * t115 + twist1 * t112),
        t103 * t125 - t99 * t122 + t113 * (twist0 * t126 + twist1 * t124),
        t103 * t135 - t99 * t131 + t113 * (twist0 * t136 + twist1 * t133),
        t139 + t140,
        t150 - t149,
        t99 - t2 * t113,
        t99 * t145 + t103 * t147 + t113 * (twist0 * t148 + twist1 * t146),
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    };
}

/*
 * The motor nearest to an even element
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 8> normalize(const std::array<Real, 8> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real t0 = m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1;
    const Real t1 = Real(1.0) / std::sqrt(t0);
    const Real t2 = t1 * (Real(-0.5) * (Real(2.0) * (m0 * m7 - m3 * m6 - m1 * m4 - m2 * m5)) / t0);
    return {
        m0 * t1,
        m1 * t1,
        m2 * t1,
        m3 * t1,
        t1 * m4 - m1 * t2,
        t1 * m5 - m2 * t2,
        t1 * m6 - m3 * t2,
        t1 * m7 + m0 * t2,
    };
}

/*
 * 3×4 matrix of a motor, by rows
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23
 */
template <class Real>
inline std::array<Real, 12> matrix34(const std::array<Real, 8> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real t0 = m0 * m0;
    const Real t1 = m3 * m3;
    const Real t2 = t0 - t1;
    const Real t3 = m2 * m2;
    const Real t4 = m1 * m1;
    const Real t5 = m0 * m3 * Real(2.0);
    const Real t6 = Real(2.0) * (m2 * m1);
    const Real t7 = m3 * m1;
    const Real t8 = m0 * m2;
    const Real t9 = m3 * m2;
    const Real t10 = m0 * m1;
    return {
        t2 - t3 + t4,
        t5 + t6,
        Real(2.0) * (t7 - t8),
        Real(-2.0) * (m0 * m4 + m3 * m5 - m2 * m6 + m1 * m7),
        t6 - t5,
        t2 + t3 - t4,
        Real(2.0) * (t9 + t10),
        Real(-2.0) * (m0 * m5 - m3 * m4 + m2 * m7 + m1 * m6),
        Real(2.0) * (t7 + t8),
        Real(2.0) * (t9 - t10),
        t1 + (t0 - (t3 + t4)),
        Real(-2.0) * (m2 * m4 - m1 * m5 + m0 * m6 + m3 * m7),
    };
}

/*
 * Rotor, translation and scale of a similarity
 * m: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 * returns: 1 e23 e31 e12 x y z scale
 */
template <class Real>
inline std::array<Real, 8> rotor_translation_scale(const std::array<Real, 12> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real m8 = m[8], m9 = m[9], m10 = m[10], m11 = m[11];
    const Real t0 = Real(1.0) / std::sqrt(m0 * m0 + m3 * m3 + m2 * m2 + m1 * m1);
    const bool t1 = (m0 * m4 + m3 * m7 + m2 * m6 + m1 * m5 < Real(0.0));
    Real t7, t8, t9, t10;
    if (t1) {
        const Real t2 = m0 - m4;
        const Real t3 = m3 - m7;
        const Real t4 = m6 - m2;
        const Real t5 = m1 - m5;
        const Real t6 = Real(1.0) / (t2 * t2 + t3 * t3 + t4 * t4 + t5 * t5);
        t7 = t2 * t6;
        t8 = t3 * t6;
        t9 = -(t4 * t6);
        t10 = t5 * t6;
    } else {
        t7 = m0 + m4;
        t8 = m3 + m7;
        t9 = m2 + m6;
        t10 = m1 + m5;
    }
    return {
        m0 * t0,
        m1 * t0,
        m2 * t0,
        m3 * t0,
        Real(-2.0) * (m8 * t7 + m9 * t8 - m10 * t9 + m11 * t10),
        Real(-2.0) * (t7 * m9 - m8 * t8 + t9 * m11 + m10 * t10),
        Real(-2.0) * (m8 * t9 - m9 * t10 + t7 * m10 + t8 * m11),
        t7 * t7 + t8 * t8 + t9 * t9 + t10 * t10,
    };
}

/*
 * Motor after growth about the origin by a scale
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * scale: scale
 * returns: 1 e23 e31 e12 E e23E e31E e12E e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 12> similarity_of(const std::array<Real, 8> &m, const Real scale)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    const Real t0 = Real(1.0) / std::sqrt(scale);
    const Real t1 = Real(0.5) * t0;
    const Real t2 = (scale + Real(1.0)) * t1;
    const Real t3 = t1 * (scale - Real(1.0));
    return {
        m0 * t2,
        t2 * m1,
        t2 * m2,
        t2 * m3,
        m0 * t3,
        m1 * t3,
        m2 * t3,
        m3 * t3,
        t0 * m4,
        t0 * m5,
        t0 * m6,
        t0 * m7,
    };
}

/*
 * The point of the ray from p towards q that lies a length from p
 * p: x y z
 * q: x y z
 * length: length
 * returns: x y z
 */
template <class Real>
inline std::array<Real, 3> reach(const std::array<Real, 3> &p, const std::array<Real, 3> &q,
        const Real length)
{
    const Real p0 = p[0], p1 = p[1], p2 = p[2];
    const Real q0 = q[0], q1 = q[1], q2 = q[2];
    const Real t0 = q0 - p0;
    const Real t1 = length * (Real(0.5) * length);
    const Real t2 = q1 - p1;
    const Real t3 = q2 - p2;
    const Real t4 = t0 * (t0 * t1) * Real(2.0) + (Real(2.0) * (t2 * (t1 * t2)) + Real(2.0) * (t3 *
        (t1 * t3)));
    const Real t5 = std::sqrt(t4);
    const Real t6 = Real(1.0) / (t0 * t0 + t2 * t2 + t3 * t3);
    return {
        p0 + t0 * t5 * t6,
        p1 + t6 * (t2 * t5),
        p2 + t6 * (t3 * t5),
    };
}

/*
 * Where a motor takes the origin
 * m: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * returns: x y z
 */
template <class Real>
inline std::array<Real, 3> translation(const std::array<Real, 8> &m)
{
    const Real m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3];
    const Real m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7];
    return {
        Real(-2.0) * (m4 * m0 + m5 * m3 - m6 * m2 + m7 * m1),
        Real(-2.0) * (m0 * m5 - m4 * m3 + m2 * m7 + m6 * m1),
        Real(-2.0) * (m4 * m2 - m5 * m1 + m0 * m6 + m3 * m7),
    };
}

/*
 * The motor that turns by a rotor, then moves by a translation
 * r: 1 e23 e31 e12
 * t: x y z
 * returns: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
template <class Real>
inline std::array<Real, 8> motor_of(const std::array<Real, 4> &r, const std::array<Real, 3> &t)
{
    const Real r0 = r[0], r1 = r[1], r2 = r[2], r3 = r[3];
    const Real t0 = t[0], t1 = t[1], t2 = t[2];
    const Real t3 = Real(-0.5) * t0;
    const Real t4 = Real(-0.5) * t1;
    const Real t5 = Real(-0.5) * t2;
    return {
        r0,
        r1,
        r2,
        r3,
        r0 * t3 - r3 * t4 + r2 * t5,
        r3 * t3 + r0 * t4 - r1 * t5,
        r1 * t4 - r2 * t3 + r0 * t5,
        r1 * t3 + r3 * t5 + r2 * t4,
    };
}

/*
 * One Newton step of a rotor towards unit length, which rounding leaves by little
 * r: 1 e23 e31 e12
 * returns: 1 e23 e31 e12
 */
template <class Real>
inline std::array<Real, 4> renormalize(const std::array<Real, 4> &r)
{
    const Real r0 = r[0], r1 = r[1], r2 = r[2], r3 = r[3];
    const Real t0 = Real(1.5) - Real(0.5) * (r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3);
    return {
        r0 * t0,
        r1 * t0,
        r2 * t0,
        r3 * t0,
    };
}

}  // namespace motorcade::versors
