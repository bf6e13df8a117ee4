// Four rows at a time are read as vectors of four numbers, which are shuffled into components.

#include "transpose.h"

#include <cstring>

#include "support.h"

#if defined(__GNUC__)
#define MOTORCADE_INLINE inline __attribute__((always_inline))
#else
#define MOTORCADE_INLINE inline
#endif

namespace motorcade {
namespace {

template <typename Real>
MOTORCADE_INLINE void plain(const Real *rows, std::ptrdiff_t apart, std::size_t first,
                            std::size_t count, std::size_t width, Real *to, std::size_t step) {
    for (std::size_t j = 0; j < width; ++j)
        for (std::size_t i = first; i < count; ++i)
            to[j * step + i] =
                rows[static_cast<std::ptrdiff_t>(i) * apart + static_cast<std::ptrdiff_t>(j)];
}

#if defined(__GNUC__) && (defined(__clang__) || __GNUC__ >= 12)
template <typename Real> struct Four;
template <> struct Four<float> { typedef float type __attribute__((vector_size(16))); };
template <> struct Four<double> { typedef double type __attribute__((vector_size(32))); };

template <typename Real>
MOTORCADE_INLINE void load(typename Four<Real>::type &made, const Real *at) {
    std::memcpy(&made, at, sizeof made);
}

template <typename Real>
MOTORCADE_INLINE void store(Real *at, const typename Four<Real>::type &given) {
    std::memcpy(at, &given, sizeof given);
}

// Looks for numbers that are not finite on its way, as `finite` below does.
template <typename Real>
MOTORCADE_INLINE std::size_t threes(const Real *rows, std::size_t count, Real *to, std::size_t step,
                                    bool &finite) {
    std::size_t i = 0;
    typename Four<Real>::type lost_a = {}, lost_b = {}, lost_c = {};
    for (; i + 4 <= count; i += 4) {
        typename Four<Real>::type a, b, c;  // x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3
        load<Real>(a, rows + 3 * i);
        load<Real>(b, rows + 3 * i + 4);
        load<Real>(c, rows + 3 * i + 8);
        lost_a += Real(0) * a;
        lost_b += Real(0) * b;
        lost_c += Real(0) * c;
        const auto x = __builtin_shufflevector(a, b, 0, 3, 6, 6);
        const auto y = __builtin_shufflevector(a, b, 1, 4, 7, 7);
        const auto z = __builtin_shufflevector(a, b, 2, 5, 5, 5);
        store<Real>(to + i, __builtin_shufflevector(x, c, 0, 1, 2, 5));
        store<Real>(to + step + i, __builtin_shufflevector(y, c, 0, 1, 2, 6));
        store<Real>(to + 2 * step + i, __builtin_shufflevector(z, c, 0, 1, 4, 7));
    }
    lost_a += lost_b + lost_c;
    for (int k = 0; k < 4; ++k) finite = finite && lost_a[k] == Real(0);
    return i;
}

template <typename Real>
MOTORCADE_INLINE std::size_t fours(const Real *rows, std::ptrdiff_t apart, std::size_t count,
                                   std::size_t width, Real *to, std::size_t step) {
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4, rows += 4 * apart) {
        for (std::size_t j = 0; j < width; j += 4) {
            typename Four<Real>::type a, b, c, d;
            load<Real>(a, rows + j);
            load<Real>(b, rows + apart + j);
            load<Real>(c, rows + 2 * apart + j);
            load<Real>(d, rows + 3 * apart + j);
            const auto ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
            const auto cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
            const auto ba = __builtin_shufflevector(a, b, 2, 6, 3, 7);
            const auto dc = __builtin_shufflevector(c, d, 2, 6, 3, 7);
            store<Real>(to + j * step + i, __builtin_shufflevector(ab, cd, 0, 1, 4, 5));
            store<Real>(to + (j + 1) * step + i, __builtin_shufflevector(ab, cd, 2, 3, 6, 7));
            store<Real>(to + (j + 2) * step + i, __builtin_shufflevector(ba, dc, 0, 1, 4, 5));
            store<Real>(to + (j + 3) * step + i, __builtin_shufflevector(ba, dc, 2, 3, 6, 7));
        }
    }
    return i;
}

template <typename Real>
MOTORCADE_INLINE std::size_t most(const Real *rows, std::ptrdiff_t apart, std::size_t count,
                                  std::size_t width, Real *to, std::size_t step, bool &finite) {
    if (width == 3 && apart == 3) return threes(rows, count, to, step, finite);
    if (width % 4 != 0 || width > 16) return 0;
    return fours(rows, apart, count, width, to, step);
}
#else
template <typename Real>
MOTORCADE_INLINE std::size_t most(const Real *, std::ptrdiff_t, std::size_t, std::size_t, Real *,
                                  std::size_t, bool &) {
    return 0;
}
#endif

// Zero times a number is zero, or NaN where that is not finite; sums in lanes that do not wait for
// each other.
template <typename Real> MOTORCADE_INLINE bool finite(const Real *numbers, std::size_t count) {
    Real lanes[MOTORCADE_LANES] = {};
    std::size_t i = 0;
    for (; i + MOTORCADE_LANES <= count; i += MOTORCADE_LANES)
        for (std::size_t k = 0; k < MOTORCADE_LANES; ++k) lanes[k] += Real(0) * numbers[i + k];
    Real total = 0;
    for (; i < count; ++i) total += Real(0) * numbers[i];
    for (std::size_t k = 0; k < MOTORCADE_LANES; ++k) total += lanes[k];
    return total == Real(0);
}

template <typename Real>
MOTORCADE_INLINE bool split(const Real *rows, std::ptrdiff_t apart, std::size_t count,
                            std::size_t width, Real *to, std::size_t step, bool checked) {
    bool all = true;
    const std::size_t done = most(rows, apart, count, width, to, step, all);
    plain(rows, apart, done, count, width, to, step);
    if (!checked) return true;
    const std::size_t seen = width == 3 ? done : 0;
    for (std::size_t j = 0; j < width; ++j) all &= finite(to + j * step + seen, count - seen);
    return all;
}

}  // namespace

MOTORCADE_SIMD
bool split_rows(const float *rows, std::ptrdiff_t apart, std::size_t count, std::size_t width,
                float *to, std::size_t step, bool checked) {
    return split(rows, apart, count, width, to, step, checked);
}

MOTORCADE_SIMD
bool split_rows(const double *rows, std::ptrdiff_t apart, std::size_t count, std::size_t width,
                double *to, std::size_t step, bool checked) {
    return split(rows, apart, count, width, to, step, checked);
}

MOTORCADE_SIMD
bool all_finite(const float *numbers, std::size_t count) { return finite(numbers, count); }

MOTORCADE_SIMD
bool all_finite(const double *numbers, std::size_t count) { return finite(numbers, count); }

}  // namespace motorcade
