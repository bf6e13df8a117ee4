/* What the generated kernels stand on: their signature, and how to have them compiled for SIMD.
 *
 * A kernel works on components: inputs[k] points to the first component of operand k,
 * input_steps[k] is the distance to the next component; a component has one number a row. Rows
 * come in blocks of MOTORCADE_LANES; reading and writing whole blocks must be allowed. Outputs
 * overlap no input. Nothing is validated here: versors are taken for unit, numbers for finite.
 *
 * On Linux on x86, gcc and clang (18 and newer, zig's too) compile each kernel for AVX-512, AVX2
 * and plain x86-64, and the loader picks the one that the processor runs. Elsewhere compilers use
 * what they are told the processor has. Other functions that are marked so have external linkage:
 * of internal ones, clang forgets the constructors that they call. */
#ifndef MOTORCADE_SUPPORT_H
#define MOTORCADE_SUPPORT_H

#include <stddef.h>

#define MOTORCADE_LANES 16
#define MOTORCADE_OPERANDS 6

#if defined(__x86_64__) && defined(__gnu_linux__) && (!defined(__clang__) || __clang_major__ >= 18)
#define MOTORCADE_SIMD __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MOTORCADE_SIMD
#endif

#if defined(__cplusplus)
extern "C" {
#else
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__clang__)
#define MOTORCADE_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define MOTORCADE_INDEPENDENT _Pragma("GCC ivdep")
#else
#define MOTORCADE_INDEPENDENT
#endif

/* Without the rules for NaN and signed zero that keep fmin and fmax from being one instruction. */
#define smallerf(a, b) ((a) < (b) ? (a) : (b))
#define largerf(a, b) ((a) > (b) ? (a) : (b))
#define smaller(a, b) ((a) < (b) ? (a) : (b))
#define larger(a, b) ((a) > (b) ? (a) : (b))

/* Powers of two by the bits of IEEE numbers, without a branch or a conversion to an integer, which
 * AVX2 lacks for double: a whole number that is added to 1.5 * 2^52 stands in the lowest bits. */

/* 2^n of a whole n; 0 and infinity where that is no normal number. */
static inline double exp2_of_integer(double n) {
    const double shifted = smaller(larger(n, -1023.0), 1024.0) + (0x1.8p52 + 1023.0);
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits <<= 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

static inline float exp2_of_integerf(float n) {
    const float shifted = smaller(larger(n, -127.0f), 128.0f) + (0x1.8p23f + 127.0f);
    uint32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits <<= 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* The greatest n with 2^n <= x, of a positive normal x. */
static inline double exponent(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = (bits >> 52) | UINT64_C(0x4330000000000000);
    double biased;
    memcpy(&biased, &bits, sizeof biased);
    return biased - (0x1p52 + 1023.0);
}

static inline float exponentf(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = (bits >> 23) | UINT32_C(0x4B000000);
    float biased;
    memcpy(&biased, &bits, sizeof biased);
    return biased - (0x1p23f + 127.0f);
}
#endif

#define MOTORCADE_ARGUMENTS(real)                                                                  \
    const real *const *inputs, const ptrdiff_t *input_steps, real *const *outputs,                 \
        const ptrdiff_t *output_steps, size_t blocks

struct motorcade_kernel {
    const char *name;
    int inputs, outputs;
    int widths[MOTORCADE_OPERANDS]; /* of the inputs, then of the outputs */
    void (*single)(MOTORCADE_ARGUMENTS(float));
    void (*real)(MOTORCADE_ARGUMENTS(double));
};

extern const struct motorcade_kernel motorcade_kernels[];
extern const size_t motorcade_kernel_count;

#if defined(__cplusplus)
}
#endif
#endif
