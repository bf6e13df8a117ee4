/* Elementary functions for loops.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline float motorcade_minf(const float a, const float b)
{
    return a < b ? a : b;
}

static inline float motorcade_maxf(const float a, const float b)
{
    return a > b ? a : b;
}

static inline double motorcade_min(const double a, const double b)
{
    return a < b ? a : b;
}

static inline double motorcade_max(const double a, const double b)
{
    return a > b ? a : b;
}

static inline double motorcade_exp2_of_integer(double n) {
    const double shifted = n + (0x1.8p52 + 1023.0);
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits <<= 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

static inline float motorcade_exp2_of_integerf(float n) {
    const float shifted = n + (0x1.8p23f + 127.0f);
    uint32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits <<= 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

static inline double motorcade_exponent(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = (bits >> 52) | UINT64_C(0x4330000000000000);
    double biased;
    memcpy(&biased, &bits, sizeof biased);
    return biased - (0x1p52 + 1023.0);
}

static inline float motorcade_exponentf(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = (bits >> 23) | UINT32_C(0x4B000000);
    float biased;
    memcpy(&biased, &bits, sizeof biased);
    return biased - (0x1p23f + 127.0f);
}

/* Sine of x. */
static inline float motorcade_sinf(const float x)
{
    const float t0 = floorf(0.5f + 0.63661975f * x);
    const float t1 = floorf(0.5f * t0);
    const float t2 = x - t0 * 1.5703125f - t0 * 0.0004837513f - t0 * 7.54979e-08f;
    const float t3 = t2 * t2;
    const float t4 = 1.0f - 0.5f * t3 + t3 * t3 * (t3 * (t3 * 2.4547298e-05f + -0.00138883f) +
        0.041666664f);
    const float t5 = t2 * t3 * (t3 * (t3 * (t3 * 2.7249148e-06f + -0.00019840081f) + 0.008333332f) +
        -0.16666667f);
    const float t6 = ((0.5f < t0 - t1 * 2.0f) ? t4 : t2 + t5) * (1.0f - 2.0f * (t1 - 2.0f *
        floorf(0.5f * t1)));
    return t6;
}

/* Sine of x. */
static inline double motorcade_sin(const double x)
{
    const double t0 = floor(0.5 + 0.6366197723675814 * x);
    const double t1 = floor(0.5 * t0);
    const double t2 = x - t0 * 1.5707963109016418 - t0 * 1.5893254712295857e-08 - t0 *
        6.123233995736766e-17;
    const double t3 = t2 * t2;
    const double t4 = t3 * (t3 * (t3 * -1.1382408754153254e-11 + 2.087614315990944e-09) +
        -2.755731725679604e-07);
    const double t5 = t3 * (t3 * (t4 + 2.4801587298736863e-05) + -0.0013888888888887378) +
        0.041666666666666664;
    const double t6 = t3 * (t3 * -7.586543634101903e-13 + 1.6058529011960858e-10) +
        -2.5052106215978872e-08;
    const double t7 = t3 * (t3 * (t3 * t6 + 2.7557319219291695e-06) + -0.00019841269841265003) +
        0.008333333333333331;
    const double t8 = ((0.5 < t0 - t1 * 2.0) ? 1.0 - 0.5 * t3 + t3 * t3 * t5 : t2 + t2 * t3 * (t3 *
        t7 + -0.16666666666666666));
    return t8 * (1.0 - 2.0 * (t1 - 2.0 * floor(0.5 * t1)));
}

/* Cosine of x. */
static inline float motorcade_cosf(const float x)
{
    const float t0 = floorf(0.5f + 0.63661975f * x);
    const float t1 = floorf(0.5f * t0);
    const float t2 = t0 - t1 * 2.0f;
    const float t3 = x - t0 * 1.5703125f - t0 * 0.0004837513f - t0 * 7.54979e-08f;
    const float t4 = t3 * t3;
    const float t5 = t3 * t4 * (t4 * (t4 * (t4 * 2.7249148e-06f + -0.00019840081f) + 0.008333332f) +
        -0.16666667f);
    const float t6 = 1.0f - 0.5f * t4 + t4 * t4 * (t4 * (t4 * 2.4547298e-05f + -0.00138883f) +
        0.041666664f);
    const float t7 = ((0.5f < t2) ? t3 + t5 : t6) * (1.0f - 2.0f * t2) * (1.0f - 2.0f * (t1 - 2.0f *
        floorf(0.5f * t1)));
    return t7;
}

/* Cosine of x. */
static inline double motorcade_cos(const double x)
{
    const double t0 = floor(0.5 + 0.6366197723675814 * x);
    const double t1 = floor(0.5 * t0);
    const double t2 = t0 - t1 * 2.0;
    const double t3 = x - t0 * 1.5707963109016418 - t0 * 1.5893254712295857e-08 - t0 *
        6.123233995736766e-17;
    const double t4 = t3 * t3;
    const double t5 = t4 * (t4 * -7.586543634101903e-13 + 1.6058529011960858e-10) +
        -2.5052106215978872e-08;
    const double t6 = t4 * (t4 * (t4 * t5 + 2.7557319219291695e-06) + -0.00019841269841265003) +
        0.008333333333333331;
    const double t7 = t4 * (t4 * (t4 * -1.1382408754153254e-11 + 2.087614315990944e-09) +
        -2.755731725679604e-07);
    const double t8 = t4 * (t4 * (t7 + 2.4801587298736863e-05) + -0.0013888888888887378) +
        0.041666666666666664;
    const double t9 = ((0.5 < t2) ? t3 + t3 * t4 * (t4 * t6 + -0.16666666666666666) : 1.0 - 0.5 * t4
        + t4 * t4 * t8);
    return t9 * (1.0 - 2.0 * t2) * (1.0 - 2.0 * (t1 - 2.0 * floor(0.5 * t1)));
}

/* Tangent of x. */
static inline float motorcade_tanf(const float x)
{
    const float t0 = floorf(0.5f + 0.63661975f * x);
    const _Bool t1 = (0.5f < t0 - floorf(0.5f * t0) * 2.0f);
    const float t2 = x - t0 * 1.5703125f - t0 * 0.0004837513f - t0 * 7.54979e-08f;
    const float t3 = t2 * t2;
    const float t4 = 1.0f - 0.5f * t3 + t3 * t3 * (t3 * (t3 * 2.4547298e-05f + -0.00138883f) +
        0.041666664f);
    const float t5 = t2 * t3 * (t3 * (t3 * (t3 * 2.7249148e-06f + -0.00019840081f) + 0.008333332f) +
        -0.16666667f);
    const float t6 = t2 + t5;
    return (t1 ? -t4 : t6) / (t1 ? t6 : t4);
}

/* Tangent of x. */
static inline double motorcade_tan(const double x)
{
    const double t0 = floor(0.5 + 0.6366197723675814 * x);
    const _Bool t1 = (0.5 < t0 - floor(0.5 * t0) * 2.0);
    const double t2 = x - t0 * 1.5707963109016418 - t0 * 1.5893254712295857e-08 - t0 *
        6.123233995736766e-17;
    const double t3 = t2 * t2;
    const double t4 = t3 * (t3 * (t3 * -1.1382408754153254e-11 + 2.087614315990944e-09) +
        -2.755731725679604e-07);
    const double t5 = t3 * (t3 * (t4 + 2.4801587298736863e-05) + -0.0013888888888887378) +
        0.041666666666666664;
    const double t6 = 1.0 - 0.5 * t3 + t3 * t3 * t5;
    const double t7 = t3 * (t3 * -7.586543634101903e-13 + 1.6058529011960858e-10) +
        -2.5052106215978872e-08;
    const double t8 = t3 * (t3 * (t3 * t7 + 2.7557319219291695e-06) + -0.00019841269841265003) +
        0.008333333333333331;
    const double t9 = t2 + t2 * t3 * (t3 * t8 + -0.16666666666666666);
    return (t1 ? -t6 : t9) / (t1 ? t9 : t6);
}

/* Angle from -π/2 to π/2 whose sine is x. */
static inline float motorcade_asinf(const float x)
{
    const float t0 = sqrtf((1.0f - x) * (x + 1.0f));
    const float t1 = fabsf(x);
    const _Bool t2 = (t0 < t1);
    const float t3 = (t2 ? t1 : t0);
    const float t4 = (t2 ? t0 : t1) / ((0.0f == t3) ? 1.0f : t3);
    const float t5 = t4 * t4;
    const float t6 = t5 * (t5 * (t5 * (t5 * 0.0014846562f + -0.00912731f) + 0.026274096f) +
        -0.04893085f) + 0.07030259f;
    const float t7 = t5 * (t5 * (t5 * (t5 * t6 + -0.08931286f) + 0.11088163f) + -0.14283995f) +
        0.1999995f;
    const float t8 = t4 + t4 * t5 * (t5 * t7 + -0.33333334f);
    const float t9 = (t2 ? 1.5707963f : 0.0f) + ((t2 ? 7.54979e-08f : 0.0f) + ((0.0f != t2) ? -t8 :
        t8));
    return ((x < 0.0f) ? -t9 : t9);
}

/* Angle from -π/2 to π/2 whose sine is x. */
static inline double motorcade_asin(const double x)
{
    const double t0 = sqrt((1.0 - x) * (x + 1.0));
    const double t1 = fabs(x);
    const _Bool t2 = (2.414213562373095 * t0 < t1);
    const _Bool t3 = (t0 * 0.41421356237309515 < t1);
    const double t4 = (t2 ? 1.5707963267948966 : (t3 ? 0.7853981633974483 : 0.0));
    const double t5 = (t2 ? t1 : (t3 ? t0 + t1 : t0));
    const double t6 = (t2 ? -t0 : (t3 ? t1 - t0 : t1)) / ((0.0 == t5) ? 1.0 : t5);
    const double t7 = t6 * t6;
    const double t8 = t7 * (t7 * (t7 * 0.016205439631134588 + -0.034497877329134195) +
        0.045487587568768556);
    const double t9 = t7 * (t7 * (t8 + -0.05229831071688012) + 0.058788441350560335) +
        -0.06666417483458661;
    const double t10 = t7 * (t7 * (t7 * t9 + 0.07692295961690367) + -0.0909090873916298) +
        0.11111111104866468;
    const double t11 = t7 * (t7 * (t7 * t10 + -0.14285714285656853) + 0.19999999999999793) +
        -0.3333333333333333;
    const double t12 = t4 + (t6 + (t4 * 3.8981718325193755e-17 + t6 * t7 * t11));
    return ((x < 0.0) ? -t12 : t12);
}

/* Angle from 0 to π whose cosine is x. */
static inline float motorcade_acosf(const float x)
{
    const float t0 = fabsf(x);
    const float t1 = sqrtf((1.0f - x) * (x + 1.0f));
    const _Bool t2 = (t0 < t1);
    const _Bool t3 = (x < 0.0f);
    const float t4 = (t2 ? 1.5707963f : (t3 ? 3.1415925f : 0.0f));
    const float t5 = (t2 ? t1 : t0);
    const float t6 = (t2 ? t0 : t1) / ((0.0f == t5) ? 1.0f : t5);
    const float t7 = t6 * t6;
    const float t8 = t7 * (t7 * (t7 * (t7 * 0.0014846562f + -0.00912731f) + 0.026274096f) +
        -0.04893085f) + 0.07030259f;
    const float t9 = t7 * (t7 * (t7 * (t7 * t8 + -0.08931286f) + 0.11088163f) + -0.14283995f) +
        0.1999995f;
    const float t10 = t6 + t6 * t7 * (t7 * t9 + -0.33333334f);
    return t4 + (t4 * 4.806346e-08f + ((t2 != t3) ? -t10 : t10));
}

/* Angle from 0 to π whose cosine is x. */
static inline double motorcade_acos(const double x)
{
    const double t0 = fabs(x);
    const double t1 = sqrt((1.0 - x) * (x + 1.0));
    const _Bool t2 = (2.414213562373095 * t0 < t1);
    const _Bool t3 = (t0 * 0.41421356237309515 < t1);
    const double t4 = (t2 ? 1.5707963267948966 : (t3 ? 0.7853981633974483 : 0.0));
    const double t5 = (t2 ? t1 : (t3 ? t0 + t1 : t0));
    const double t6 = (t2 ? -t0 : (t3 ? t1 - t0 : t1)) / ((0.0 == t5) ? 1.0 : t5);
    const double t7 = t6 * t6;
    const double t8 = t7 * (t7 * (t7 * 0.016205439631134588 + -0.034497877329134195) +
        0.045487587568768556);
    const double t9 = t7 * (t7 * (t8 + -0.05229831071688012) + 0.058788441350560335) +
        -0.06666417483458661;
    const double t10 = t7 * (t7 * (t7 * t9 + 0.07692295961690367) + -0.0909090873916298) +
        0.11111111104866468;
    const double t11 = t7 * (t7 * (t7 * t10 + -0.14285714285656853) + 0.19999999999999793) +
        -0.3333333333333333;
    const double t12 = t4 + (t6 + (t4 * 3.8981718325193755e-17 + t6 * t7 * t11));
    return ((x < 0.0) ? 3.141592653589793 - t12 + 1.2246467991473532e-16 : t12);
}

/* Angle from -π/2 to π/2 whose tangent is x. */
static inline float motorcade_atanf(const float x)
{
    const float t0 = fabsf(x);
    const _Bool t1 = (1.0f < t0);
    const float t2 = (t1 ? t0 : 1.0f);
    const float t3 = (t1 ? 1.0f : t0) / ((0.0f == t2) ? 1.0f : t2);
    const float t4 = t3 * t3;
    const float t5 = t4 * (t4 * (t4 * (t4 * 0.0014846562f + -0.00912731f) + 0.026274096f) +
        -0.04893085f) + 0.07030259f;
    const float t6 = t4 * (t4 * (t4 * (t4 * t5 + -0.08931286f) + 0.11088163f) + -0.14283995f) +
        0.1999995f;
    const float t7 = t3 + t3 * t4 * (t4 * t6 + -0.33333334f);
    const float t8 = (t1 ? 1.5707963f : 0.0f) + ((t1 ? 7.54979e-08f : 0.0f) + ((0.0f != t1) ? -t7 :
        t7));
    return ((x < 0.0f) ? -t8 : t8);
}

/* Angle from -π/2 to π/2 whose tangent is x. */
static inline double motorcade_atan(const double x)
{
    const double t0 = fabs(x);
    const _Bool t1 = (2.414213562373095 < t0);
    const _Bool t2 = (0.41421356237309515 < t0);
    const double t3 = (t1 ? 1.5707963267948966 : (t2 ? 0.7853981633974483 : 0.0));
    const double t4 = (t1 ? t0 : (t2 ? t0 + 1.0 : 1.0));
    const double t5 = (t1 ? -1.0 : (t2 ? t0 - 1.0 : t0)) / ((0.0 == t4) ? 1.0 : t4);
    const double t6 = t5 * t5;
    const double t7 = t6 * (t6 * (t6 * 0.016205439631134588 + -0.034497877329134195) +
        0.045487587568768556);
    const double t8 = t6 * (t6 * (t7 + -0.05229831071688012) + 0.058788441350560335) +
        -0.06666417483458661;
    const double t9 = t6 * (t6 * (t6 * t8 + 0.07692295961690367) + -0.0909090873916298) +
        0.11111111104866468;
    const double t10 = t6 * (t6 * (t6 * t9 + -0.14285714285656853) + 0.19999999999999793) +
        -0.3333333333333333;
    const double t11 = t3 + (t5 + (t3 * 3.8981718325193755e-17 + t5 * t6 * t10));
    return ((x < 0.0) ? -t11 : t11);
}

/* Angle of the point (x, y), from -π to π. */
static inline float motorcade_atan2f(const float y, const float x)
{
    const float t0 = fabsf(x);
    const float t1 = fabsf(y);
    const _Bool t2 = (t0 < t1);
    const _Bool t3 = (x < 0.0f);
    const float t4 = (t2 ? 1.5707963f : (t3 ? 3.1415925f : 0.0f));
    const float t5 = (t2 ? t1 : t0);
    const float t6 = (t2 ? t0 : t1) / ((0.0f == t5) ? 1.0f : t5);
    const float t7 = t6 * t6;
    const float t8 = t7 * (t7 * (t7 * (t7 * 0.0014846562f + -0.00912731f) + 0.026274096f) +
        -0.04893085f) + 0.07030259f;
    const float t9 = t7 * (t7 * (t7 * (t7 * t8 + -0.08931286f) + 0.11088163f) + -0.14283995f) +
        0.1999995f;
    const float t10 = t6 + t6 * t7 * (t7 * t9 + -0.33333334f);
    const float t11 = t4 + (t4 * 4.806346e-08f + ((t2 != t3) ? -t10 : t10));
    return ((y < 0.0f) ? -t11 : t11);
}

/* Angle of the point (x, y), from -π to π. */
static inline double motorcade_atan2(const double y, const double x)
{
    const double t0 = fabs(x);
    const double t1 = fabs(y);
    const _Bool t2 = (2.414213562373095 * t0 < t1);
    const _Bool t3 = (t0 * 0.41421356237309515 < t1);
    const double t4 = (t2 ? 1.5707963267948966 : (t3 ? 0.7853981633974483 : 0.0));
    const double t5 = (t2 ? t1 : (t3 ? t0 + t1 : t0));
    const double t6 = (t2 ? -t0 : (t3 ? t1 - t0 : t1)) / ((0.0 == t5) ? 1.0 : t5);
    const double t7 = t6 * t6;
    const double t8 = t7 * (t7 * (t7 * 0.016205439631134588 + -0.034497877329134195) +
        0.045487587568768556);
    const double t9 = t7 * (t7 * (t8 + -0.05229831071688012) + 0.058788441350560335) +
        -0.06666417483458661;
    const double t10 = t7 * (t7 * (t7 * t9 + 0.07692295961690367) + -0.0909090873916298) +
        0.11111111104866468;
    const double t11 = t7 * (t7 * (t7 * t10 + -0.14285714285656853) + 0.19999999999999793) +
        -0.3333333333333333;
    const double t12 = t4 + (t6 + (t4 * 3.8981718325193755e-17 + t6 * t7 * t11));
    const double t13 = ((x < 0.0) ? 3.141592653589793 - t12 + 1.2246467991473532e-16 : t12);
    return ((y < 0.0) ? -t13 : t13);
}

/* Exponential of x. */
static inline float motorcade_expf(const float x)
{
    const float t0 = ((x < -105.0f) ? -105.0f : x);
    const float t1 = ((90.0f < t0) ? 90.0f : t0);
    const float t2 = floorf(t1 * 1.442695f + 0.5f);
    const float t3 = t1 - 0.69311523f * t2 - t2 * 3.1946183e-05f;
    const float t4 = t3 * (t3 * (t3 * (t3 * 2.4860057e-05f + 0.00019899753f) + 0.0013888853f) +
        0.008333297f);
    const float t5 = floorf(0.5f * t2);
    const float t6 = (1.0f + (t3 + t3 * t3 * (0.5f + t3 * (t3 * (t4 + 0.041666668f) +
        0.16666667f)))) * motorcade_exp2_of_integerf(t5);
    return t6 * motorcade_exp2_of_integerf(t2 - t5);
}

/* Exponential of x. */
static inline double motorcade_exp(const double x)
{
    const double t0 = ((x < -746.0) ? -746.0 : x);
    const double t1 = ((711.0 < t0) ? 711.0 : t0);
    const double t2 = floor(t1 * 1.4426950408889634 + 0.5);
    const double t3 = t1 - 0.6931471805598903 * t2 - t2 * 5.497923018708371e-14;
    const double t4 = t3 * (t3 * (t3 * 2.091499245327924e-09 + 2.510564479145537e-08) +
        2.755727290616548e-07);
    const double t5 = t3 * (t3 * (t4 + 2.755725436822675e-06) + 2.4801587326131077e-05) +
        0.00019841269875637497;
    const double t6 = t3 * (t3 * (t3 * t5 + 0.0013888888888883581) + 0.0083333333333259) +
        0.04166666666666667;
    const double t7 = floor(0.5 * t2);
    const double t8 = (1.0 + (t3 + t3 * t3 * (0.5 + t3 * (t3 * t6 + 0.1666666666666667)))) *
        motorcade_exp2_of_integer(t7);
    return t8 * motorcade_exp2_of_integer(t2 - t7);
}

/* Natural logarithm of x; minus infinity of 0, NaN of less. */
static inline float motorcade_logf(const float x)
{
    const _Bool t0 = (x <= 0.0f);
    const float t1 = (t0 ? 3.4028235e+38f : 1.0f);
    const float t2 = t1 * t1;
    const _Bool t3 = (x < 7.888609e-31f);
    const float t4 = (t3 ? x * 1.8446744e+19f : x);
    const float t5 = motorcade_exponentf(0.70710677f * t4);
    const float t6 = t5 + (t3 ? -63.0f : 1.0f);
    const float t7 = t4 * 0.25f * motorcade_exp2_of_integerf(1.0f - t5) - 1.0f;
    const float t8 = t7 * (t7 * (t7 * (t7 * -0.061996534f + 0.1053021f) + -0.106465906f) +
        0.110379085f) + -0.12450713f;
    const float t9 = t7 * (t7 * (t7 * (t7 * (t7 * t8 + 0.14286517f) + -0.16668002f) + 0.2000001f) +
        -0.2499999f);
    const float t10 = 0.69311523f * t6 + (t7 + (t7 * (t7 * t7) * (t9 + 0.33333334f) - t7 * (t7 *
        0.5f) + t6 * 3.1946183e-05f));
    return (t0 ? ((x < 0.0f) ? t2 : 0.0f) - t2 : ((3.4028235e+38f < x) ? x : t10));
}

/* Natural logarithm of x; minus infinity of 0, NaN of less. */
static inline double motorcade_log(const double x)
{
    const _Bool t0 = (x <= 0.0);
    const double t1 = (t0 ? 1.7976931348623157e+308 : 1.0);
    const double t2 = t1 * t1;
    const _Bool t3 = (x < 1.0261342003245941e-289);
    const double t4 = (t3 ? x * 3.402823669209385e+38 : x);
    const double t5 = motorcade_exponent(0.7071067811865476 * t4);
    const double t6 = t5 + (t3 ? -127.0 : 1.0);
    const double t7 = t4 * 0.25 * motorcade_exp2_of_integer(1.0 - t5) - 1.0;
    const double t8 = t7 * (0.5 * t7);
    const double t9 = t7 / (2.0 + t7);
    const double t10 = t9 * t9;
    const double t11 = t10 * (t10 * (t10 * 0.13094416666525344 + 0.1326802614042874) +
        0.15386267672882226) + 0.18181795124476754;
    const double t12 = t10 * (t10 * (t10 * t11 + 0.22222222396552982) + 0.2857142857078221) +
        0.4000000000000091;
    const double t13 = t8 - (t9 * (t8 + t10 * (t10 * t12 + 0.6666666666666666)) + t6 *
        5.497923018708371e-14);
    const double t14 = (t0 ? ((x < 0.0) ? t2 : 0.0) - t2 : ((1.7976931348623157e+308 < x) ? x :
        0.6931471805598903 * t6 - (t13 - t7)));
    return t14;
}
