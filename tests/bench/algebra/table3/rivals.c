/* Quaternions and dual quaternions as they are blended by hand, and the clock.
 *
 * Compiled with REAL float or double. Poses are rows of numbers, joint after joint: w x y z and
 * metres, or the real and the dual quaternion. Matrices are 4x4 by columns. In the `_arrays` form
 * component k of joint i stands at [k * joints + i], and matrices are 3x4 by rows. */
#include <math.h>
#include <stddef.h>
#include <time.h>

#ifndef REAL
#define REAL double
#endif
typedef REAL real;

#define SINGLE (sizeof(real) == sizeof(float))
#define SQRT(x) (SINGLE ? sqrtf((float)(x)) : sqrt(x))
#define ACOS(x) (SINGLE ? acosf((float)(x)) : acos(x))
#define SIN(x) (SINGLE ? sinf((float)(x)) : sin(x))

typedef void blend(const real *a, const real *b, real f, real *out, size_t joints);

/* Slerp with the short way round, as GLM does it. */
static inline void slerp(const real *a, const real *b, real f, real *q) {
    const real dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const real sign = dot < 0 ? (real)-1 : (real)1, cosine = sign * dot;
    real u = 1 - f, v = sign * f;
    if (cosine < (real)(SINGLE ? 1 - 1e-6 : 1 - 1e-15)) {
        const real angle = ACOS(cosine), scale = 1 / SIN(angle);
        u = SIN((1 - f) * angle) * scale;
        v = SIN(f * angle) * scale * sign;
    }
    for (int k = 0; k < 4; ++k) q[k] = u * a[k] + v * b[k];
}

void quaternion(const real *a, const real *b, real f, real *out, size_t joints) {
    for (size_t i = 0; i < joints; ++i, a += 7, b += 7, out += 16) {
        real q[4];
        slerp(a, b, f, q);
        const real w = q[0], x = q[1], y = q[2], z = q[3];
        out[0] = 1 - 2 * (y * y + z * z);
        out[1] = 2 * (x * y + w * z);
        out[2] = 2 * (x * z - w * y);
        out[4] = 2 * (x * y - w * z);
        out[5] = 1 - 2 * (x * x + z * z);
        out[6] = 2 * (y * z + w * x);
        out[8] = 2 * (x * z + w * y);
        out[9] = 2 * (y * z - w * x);
        out[10] = 1 - 2 * (x * x + y * y);
        for (int k = 0; k < 3; ++k) out[12 + k] = (1 - f) * a[4 + k] + f * b[4 + k];
        out[3] = out[7] = out[11] = 0;
        out[15] = 1;
    }
}

/* Linear blend the short way round. The matrix needs the square of the norm and no root: rotation
 * and translation are both products of two numbers of the blend. */
static inline void blended(const real *a, const real *b, real f, real *m) {
    const real dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const real u = 1 - f, v = dot < 0 ? -f : f;
    real q[8];
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) q[k] = u * a[k] + v * b[k];
    const real w = q[0], x = q[1], y = q[2], z = q[3], dw = q[4], dx = q[5], dy = q[6], dz = q[7];
    const real ww = w * w, xx = x * x, yy = y * y, zz = z * z;
    const real s = 1 / (ww + xx + yy + zz), s2 = 2 * s;
    m[0] = s * (ww + xx - yy - zz);
    m[1] = s2 * (x * y - w * z);
    m[2] = s2 * (x * z + w * y);
    m[3] = s2 * (w * dx - x * dw + y * dz - z * dy);
    m[4] = s2 * (x * y + w * z);
    m[5] = s * (ww - xx + yy - zz);
    m[6] = s2 * (y * z - w * x);
    m[7] = s2 * (w * dy - x * dz - y * dw + z * dx);
    m[8] = s2 * (x * z - w * y);
    m[9] = s2 * (y * z + w * x);
    m[10] = s * (ww - xx - yy + zz);
    m[11] = s2 * (w * dz + x * dy - y * dx - z * dw);
}

void dual_quaternion(const real *a, const real *b, real f, real *out, size_t joints) {
    for (size_t i = 0; i < joints; ++i, a += 8, b += 8, out += 16) {
        real m[12];
        blended(a, b, f, m);
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column) out[4 * column + row] = m[4 * row + column];
        out[3] = out[7] = out[11] = 0;
        out[15] = 1;
    }
}

/* Every joint has its fraction, as all numbers of a script in arrays do. The loops over components
 * are unrolled first, so that the one over joints becomes SIMD code. */
static inline void blended_arrays(const real *restrict a, const real *restrict b,
                                  const real *restrict fractions, real *restrict out,
                                  size_t joints) {
#pragma GCC ivdep
    for (size_t i = 0; i < joints; ++i) {
        real p[8], q[8], m[12];
#pragma GCC unroll 8
        for (int k = 0; k < 8; ++k) p[k] = a[k * joints + i], q[k] = b[k * joints + i];
        blended(p, q, fractions[i], m);
#pragma GCC unroll 12
        for (int k = 0; k < 12; ++k) out[k * joints + i] = m[k];
    }
}

void dual_quaternion_arrays(const real *a, const real *b, real f, real *out, size_t joints) {
    real fractions[joints];
    for (size_t i = 0; i < joints; ++i) fractions[i] = f;
    blended_arrays(a, b, fractions, out, joints);
}

/* Seconds of this thread that `times` calls take: other programs on the core do not count. */
double seconds(blend *call, const real *a, const real *b, real f, real *out, size_t joints,
               size_t times) {
    struct timespec start, end;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    for (size_t i = 0; i < times; ++i) call(a, b, f, out, joints);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    return (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}
