/* Which processor this is, for the resolvers of functions that are compiled for several.
 *
 * They ask the compiler's own library, in words that are fixed by LLVM: `__cpu_indicator_init`
 * fills
 * `__cpu_features2`, where x86-64-v3 is bit 65 and x86-64-v4 bit 66. zig's library always answers
 * that it is the least of all; modules that zig compiles have this in its place. It runs while a
 * module is being loaded, so it calls nothing.
 *
 * Sources: Intel, Software Developer's Manual, CPUID and XGETBV; x86-64 psABI, micro-architecture
 * levels. */
#include <cpuid.h>

/* Of leaf 1: FMA, MOVBE, OSXSAVE, AVX, F16C. Of leaf 0x80000001: LZCNT. Of leaf 7: BMI1, AVX2,
 * BMI2. */
static const unsigned V3_OF_1 = 1u << 12 | 1u << 22 | 1u << 27 | 1u << 28 | 1u << 29;
static const unsigned V3_OF_EXTENDED = 1u << 5, V3_OF_7 = 1u << 3 | 1u << 5 | 1u << 8;
/* Of leaf 7: AVX-512 F, DQ, CD, BW, VL. */
static const unsigned V4_OF_7 = 1u << 16 | 1u << 17 | 1u << 28 | 1u << 30 | 1u << 31;
/* Registers that the system keeps: those of AVX, and of AVX-512. */
static const unsigned KEPT_BY_V3 = 0x06, KEPT_BY_V4 = 0xE6;

unsigned __cpu_features2[4];

static int has(unsigned found, unsigned wanted) { return (found & wanted) == wanted; }

int __cpu_indicator_init(void) {
    unsigned a, b, c, d, kept, rest, more, seven;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !has(c, V3_OF_1)) return 0;
    __asm__("xgetbv" : "=a"(kept), "=d"(rest) : "c"(0));
    if (!has(kept, KEPT_BY_V3)) return 0;
    if (!__get_cpuid(0x80000001u, &a, &b, &more, &d) || !has(more, V3_OF_EXTENDED)) return 0;
    if (!__get_cpuid_count(7, 0, &a, &seven, &c, &d) || !has(seven, V3_OF_7)) return 0;
    __cpu_features2[2] |= 1u << 1;
    if (has(kept, KEPT_BY_V4) && has(seven, V4_OF_7)) __cpu_features2[2] |= 1u << 2;
    return 0;
}
