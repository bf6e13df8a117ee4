// Rows are gathered into small blocks, one array a coefficient, so that every loop below is a
// straight line over lanes that the compiler turns into SIMD code. No lane branches: closed forms
// and series are both computed and one is selected. On x86 with gcc each kernel is compiled for
// AVX-512, AVX2 and plain x86-64, and the loader picks one; all give the same bits, since fused
// multiply-add is kept off (see CMakeLists.txt).
//
// A motor is a pair of quadruples, real + J dual with J = e123∞, J² = 0, J e23 = -e1∞: real is
// (m0, m1, m2, m3) and dual is (m7, -m4, -m5, -m6).

#include "motor_kernels.h"

#include <cmath>

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define MOTORCADE_SIMD __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MOTORCADE_SIMD
#endif
#if defined(__GNUC__)
#define MOTORCADE_INLINE static inline __attribute__((always_inline))
#else
#define MOTORCADE_INLINE static inline
#endif

namespace motorcade {
namespace {

constexpr std::size_t LANES = 16;

template <std::size_t Width>
struct Block {
    alignas(64) double at[Width][LANES];
};
using Motors = Block<8>;
using Bivectors = Block<6>;

// Under square roots: without effect on normal numbers, and x / x comes out as 1 at 0.
constexpr double TINY = 1e-300;
constexpr double SERIES_BELOW_SIN2 = 0.02;
constexpr double SERIES_BELOW_ANGLE2 = 0.25;
// Up to here two-part reduction by π is exact enough; larger angles go through the C library.
constexpr double LARGEST_REDUCED = 1e5;

template <std::size_t Width>
MOTORCADE_INLINE void load(Rows rows, std::size_t start, std::size_t used, Block<Width>& block) {
    const double* source = rows.first + start * rows.step;
    if (rows.step == Width && used == LANES) {
        for (std::size_t i = 0; i < LANES; ++i)
            for (std::size_t j = 0; j < Width; ++j) block.at[j][i] = source[i * Width + j];
        return;
    }
    for (std::size_t i = 0; i < LANES; ++i) {
        const double* row = source + (i < used ? i : 0) * rows.step;
        for (std::size_t j = 0; j < Width; ++j) block.at[j][i] = row[j];
    }
}

template <std::size_t Width>
MOTORCADE_INLINE void store(const Block<Width>& block, double* out, std::size_t start,
                            std::size_t used) {
    double* target = out + start * Width;
    if (used == LANES) {
        for (std::size_t i = 0; i < LANES; ++i)
            for (std::size_t j = 0; j < Width; ++j) target[i * Width + j] = block.at[j][i];
        return;
    }
    for (std::size_t i = 0; i < used; ++i)
        for (std::size_t j = 0; j < Width; ++j) target[i * Width + j] = block.at[j][i];
}

// atan2(y, x) for y >= 0. The quotient is brought to [-tan π/8, tan π/8]; there atan(q) / q is a
// Chebyshev fit in q², 3e-18 from it.
MOTORCADE_INLINE double upper_atan2(double y, double x) {
    const double width = std::fabs(x);
    const double large = y > width ? y : width;
    const double small = y > width ? width : y;
    const bool beyond = small > 0.41421356237309503 * large;
    const double top = beyond ? small - large : small;
    const double bottom = beyond ? small + large : large;
    const double q = top / bottom;
    const double z = q * q;
    double p = -0.017805382196606493;
    p = p * z + 0.03796524391097195;
    p = p * z - 0.05035101930016078;
    p = p * z + 0.05846878181892052;
    p = p * z - 0.06662951797955637;
    p = p * z + 0.07692045329539092;
    p = p * z - 0.09090896808988135;
    p = p * z + 0.11111110744917034;
    p = p * z - 0.14285714279250192;
    p = p * z + 0.1999999999994089;
    p = p * z - 0.3333333333333312;
    double angle = q + q * z * p;
    angle = beyond ? 0.78539816339744831 + angle : angle;
    angle = y > width ? 1.5707963267948966 - angle : angle;
    return x < 0.0 ? 3.1415926535897931 - angle : angle;
}

// Sine and cosine of 0 <= h <= LARGEST_REDUCED: h is reduced by multiples of π, halved, and the
// Taylor series of the half, at most π/4, are doubled.
MOTORCADE_INLINE void sine_cosine(double h, double& sine, double& cosine) {
    constexpr double ROUND = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer
    const double turns = (h * 0.31830988618379067 + ROUND) - ROUND;
    const double r = 0.5 * ((h - turns * 3.141592651605606) - turns * 1.984187159361081e-09);
    const double odd = turns - 2.0 * ((0.5 * turns + ROUND) - ROUND);
    const double sign = 1.0 - 2.0 * odd * odd;
    const double z = r * r;
    double s = 1.0 / 355687428096000.0;
    s = s * z - 1.0 / 1307674368000.0;
    s = s * z + 1.0 / 6227020800.0;
    s = s * z - 1.0 / 39916800.0;
    s = s * z + 1.0 / 362880.0;
    s = s * z - 1.0 / 5040.0;
    s = s * z + 1.0 / 120.0;
    s = s * z - 1.0 / 6.0;
    s = r + r * z * s;
    double c = 1.0 / 20922789888000.0;
    c = c * z - 1.0 / 87178291200.0;
    c = c * z + 1.0 / 479001600.0;
    c = c * z - 1.0 / 3628800.0;
    c = c * z + 1.0 / 40320.0;
    c = c * z - 1.0 / 720.0;
    c = c * z + 1.0 / 24.0;
    c = c * z - 0.5;
    c = 1.0 + z * c;
    sine = sign * (2.0 * s * c);
    cosine = sign * (1.0 - 2.0 * s * s);
}

// Product of quadruples on 1, e23, e31, e12, added to out (note e23 e31 = -e12).
MOTORCADE_INLINE void add_product(const double a[4], const double b[4], double out[4]) {
    out[0] += a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] += a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2];
    out[2] += a[0] * b[2] + a[2] * b[0] - a[3] * b[1] + a[1] * b[3];
    out[3] += a[0] * b[3] + a[3] * b[0] - a[1] * b[2] + a[2] * b[1];
}

MOTORCADE_INLINE void compose_block(const Motors& a, const Motors& b, Motors& out,
                                    double reverse_a) {
    for (std::size_t i = 0; i < LANES; ++i) {
        const double f = reverse_a;
        const double a_real[4] = {a.at[0][i], f * a.at[1][i], f * a.at[2][i], f * a.at[3][i]};
        const double a_dual[4] = {a.at[7][i], -f * a.at[4][i], -f * a.at[5][i], -f * a.at[6][i]};
        const double b_real[4] = {b.at[0][i], b.at[1][i], b.at[2][i], b.at[3][i]};
        const double b_dual[4] = {b.at[7][i], -b.at[4][i], -b.at[5][i], -b.at[6][i]};
        double real[4] = {0, 0, 0, 0}, dual[4] = {0, 0, 0, 0};
        add_product(a_real, b_real, real);
        add_product(a_real, b_dual, dual);
        add_product(a_dual, b_real, dual);
        for (std::size_t j = 0; j < 4; ++j) out.at[j][i] = real[j];
        for (std::size_t j = 1; j < 4; ++j) out.at[3 + j][i] = -dual[j];
        out.at[7][i] = dual[0];
    }
}

MOTORCADE_INLINE void sines_cosines(const double* h, double* sine, double* cosine) {
    double largest = 0.0;
    for (std::size_t i = 0; i < LANES; ++i) largest = h[i] > largest ? h[i] : largest;
    if (largest > LARGEST_REDUCED) {
        for (std::size_t i = 0; i < LANES; ++i) {
            sine[i] = std::sin(h[i]);
            cosine[i] = std::cos(h[i]);
        }
        return;
    }
    for (std::size_t i = 0; i < LANES; ++i) sine_cosine(h[i], sine[i], cosine[i]);
}

MOTORCADE_INLINE void exp_block(const Bivectors& log, Motors& out) {
    alignas(64) double h[LANES], sine[LANES], cosine[LANES];
    for (std::size_t i = 0; i < LANES; ++i) {
        const double x = log.at[0][i], y = log.at[1][i], z = log.at[2][i];
        h[i] = std::sqrt(x * x + y * y + z * z + TINY);
    }
    sines_cosines(h, sine, cosine);
    for (std::size_t i = 0; i < LANES; ++i) {
        const double a[3] = {log.at[0][i], log.at[1][i], log.at[2][i]};
        const double b[3] = {-log.at[3][i], -log.at[4][i], -log.at[5][i]};
        const double x = h[i] * h[i];
        const double sinc = sine[i] / h[i];
        double series = 1.0 / 518918400.0;
        series = series * x - 1.0 / 3991680.0;
        series = series * x + 1.0 / 45360.0;
        series = series * x - 1.0 / 840.0;
        series = series * x + 1.0 / 30.0;
        series = series * x - 1.0 / 3.0;
        const double direct = (cosine[i] - sinc) / x;
        const double along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        const double slope = along * (x < SERIES_BELOW_ANGLE2 ? series : direct);
        out.at[0][i] = cosine[i];
        for (std::size_t j = 0; j < 3; ++j) {
            out.at[1 + j][i] = sinc * a[j];
            out.at[4 + j][i] = -(sinc * b[j] + slope * a[j]);
        }
        out.at[7][i] = -sinc * along;
    }
}

MOTORCADE_INLINE void log_block(const Motors& m, Bivectors& out, double flip_below) {
    for (std::size_t i = 0; i < LANES; ++i) {
        const double v[3] = {m.at[1][i], m.at[2][i], m.at[3][i]};
        const double sign = m.at[0][i] < flip_below ? -1.0 : 1.0;
        const double w = sign * m.at[0][i];
        const double x = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + TINY;
        const double s = std::sqrt(x);
        const double ratio = upper_atan2(s, w) / s;
        double series = 2048.0 / 109395.0;
        series = series * x + 1024.0 / 45045.0;
        series = series * x + 256.0 / 9009.0;
        series = series * x + 128.0 / 3465.0;
        series = series * x + 16.0 / 315.0;
        series = series * x + 8.0 / 105.0;
        series = series * x + 2.0 / 15.0;
        series = series * x + 1.0 / 3.0;
        const double direct = (1.0 - ratio * w) / x;
        const double limit = w > 0.0 ? SERIES_BELOW_SIN2 : 0.0;
        const double slope = x < limit ? series : direct;
        const double scale = sign * ratio;
        const double cross = slope * m.at[7][i];
        for (std::size_t j = 0; j < 3; ++j) {
            out.at[j][i] = scale * v[j];
            out.at[3 + j][i] = scale * m.at[4 + j][i] + cross * v[j];
        }
    }
}

// Scalars below this are flipped: all negative ones on the short way, none on the other.
MOTORCADE_INLINE double flip_below(bool short_way) { return short_way ? 0.0 : -HUGE_VAL; }

MOTORCADE_INLINE std::size_t used_lanes(std::size_t start, std::size_t count) {
    return count - start < LANES ? count - start : LANES;
}

}  // namespace

MOTORCADE_SIMD
void compose(Rows a, Rows b, double* out, std::size_t count) {
    Motors first, second, product;
    for (std::size_t start = 0; start < count; start += LANES) {
        const std::size_t used = used_lanes(start, count);
        load(a, start, used, first);
        load(b, start, used, second);
        compose_block(first, second, product, 1.0);
        store(product, out, start, used);
    }
}

MOTORCADE_SIMD
void inverse(Rows motor, double* out, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const double* row = motor.first + i * motor.step;
        out[8 * i] = row[0];
        for (std::size_t j = 1; j < 7; ++j) out[8 * i + j] = -row[j];
        out[8 * i + 7] = row[7];
    }
}

MOTORCADE_SIMD
void exp(Rows bivector, double* out, std::size_t count) {
    Bivectors given;
    Motors made;
    for (std::size_t start = 0; start < count; start += LANES) {
        const std::size_t used = used_lanes(start, count);
        load(bivector, start, used, given);
        exp_block(given, made);
        store(made, out, start, used);
    }
}

MOTORCADE_SIMD
void log(Rows motor, double* out, std::size_t count, bool short_way) {
    Motors given;
    Bivectors made;
    for (std::size_t start = 0; start < count; start += LANES) {
        const std::size_t used = used_lanes(start, count);
        load(motor, start, used, given);
        log_block(given, made, flip_below(short_way));
        store(made, out, start, used);
    }
}

MOTORCADE_SIMD
void interpolate(Rows a, Rows b, Rows fraction, double* out, std::size_t count, bool short_way) {
    Motors first, second, between;
    Bivectors screw;
    Block<1> part;
    for (std::size_t start = 0; start < count; start += LANES) {
        const std::size_t used = used_lanes(start, count);
        load(a, start, used, first);
        load(b, start, used, second);
        load(fraction, start, used, part);
        compose_block(first, second, between, -1.0);
        log_block(between, screw, flip_below(short_way));
        for (std::size_t j = 0; j < 6; ++j)
            for (std::size_t i = 0; i < LANES; ++i) screw.at[j][i] *= part.at[0][i];
        exp_block(screw, between);
        compose_block(first, between, second, 1.0);
        store(second, out, start, used);
    }
}

}  // namespace motorcade
