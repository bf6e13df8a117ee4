// Covariance of S derivatives (pose, velocity, acceleration) of N components that couple: rows and
// columns in S blocks of N. Of uncoupled components N is 1, and the same matrix serves for each.

#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "lanes.h"
#include "support.h"
#include "vectors.h"

namespace motorcade::smooth {

template <std::size_t N, class Real = double> using Square = std::array<std::array<Real, N>, N>;

template <std::size_t N, class Real>
MOTORCADE_INLINE Square<N, Real> product(const Square<N, Real> &a, const Square<N, Real> &b) {
    Square<N, Real> made;
    for (std::size_t i = 0; i < N; ++i) {
        LaneRow<N, Real> row;
        for (std::size_t k = 0; k < N; ++k) row.add(a[i][k], b[k].data());
        row.write(made[i].data());
    }
    return made;
}

// Compiled for the processor at hand by GCC. Of clones that are templates clang forgets the
// constructors which they call.
#ifdef __clang__
#define MOTORCADE_WIDE [[gnu::noinline]]
#else
#define MOTORCADE_WIDE MOTORCADE_SIMD [[gnu::noinline]]
#endif

// Loops over the rows of a matrix, laid out as a whole.
#define MOTORCADE_ROWS _Pragma("GCC unroll 12")

// The factors Uᵀ D U of a symmetric positive definite matrix, U of unit diagonal and D inverted;
// row by row, and whole rows, what is left of the diagonal meaning nothing. No root is taken: each
// row waits for the one before. Of a matrix that is not positive definite, all that is solved is
// NaN.
template <std::size_t N, class Real = double> struct Factored {
    Square<N, Real> upper;
    Vector<N, Real> inverse;
    Real determinant = 1.0;

    Factored() = default;
    MOTORCADE_INLINE explicit Factored(const Square<N, Real> &a) {
        const Real unknown = std::numeric_limits<double>::quiet_NaN();
        Square<N, Real> pivots;
        MOTORCADE_ROWS
        for (std::size_t k = 0; k < N; ++k) {
            LaneRow<N, Real> row(a[k].data());
            MOTORCADE_ROWS
            for (std::size_t m = 0; m < k; ++m) row.subtract(upper[m][k], pivots[m].data());
            row.write(pivots[k].data());
            const Real pivot = pivots[k][k];
            determinant *= pivot;
            inverse[k] = chosen(pivot > 0.0, 1.0 / pivot, unknown);
            row.scale(inverse[k]);
            row.write(upper[k].data());
        }
    }

    // a⁻¹ times N rows of M numbers, in place.
    template <std::size_t M>
    MOTORCADE_INLINE void solve(std::array<Vector<M, Real>, N> &rows) const {
        for (std::size_t i = 1; i < N; ++i) {
            LaneRow<M, Real> row(rows[i].data());
            for (std::size_t k = 0; k < i; ++k) row.subtract(upper[k][i], rows[k].data());
            row.write(rows[i].data());
        }
        for (std::size_t i = N; i-- > 0;) {
            LaneRow<M, Real> row(rows[i].data());
            row.scale(inverse[i]);
            for (std::size_t k = N; k-- > i + 1;) row.subtract(upper[i][k], rows[k].data());
            row.write(rows[i].data());
        }
    }

    MOTORCADE_INLINE Vector<N, Real> solved(const Vector<N, Real> &right) const {
        Vector<N, Real> made = right;
        MOTORCADE_ROWS
        for (std::size_t k = 0; k < N; ++k) {
            MOTORCADE_ROWS
            for (std::size_t i = k + 1; i < N; ++i) made[i] -= upper[k][i] * made[k];
        }
        for (std::size_t i = 0; i < N; ++i) made[i] *= inverse[i];
        MOTORCADE_ROWS
        for (std::size_t k = N - 1; k > 0; --k) {
            MOTORCADE_ROWS
            for (std::size_t i = 0; i < k; ++i) made[i] -= upper[i][k] * made[k];
        }
        return made;
    }
};

// What white noise of unit density on the highest derivative adds in dt.
template <std::size_t S, class Real> Square<S, Real> diffusion(const Real &dt) {
    constexpr double factorial[] = {1.0, 1.0, 2.0, 6.0};
    Real power[2 * S];
    power[0] = 1.0;
    for (std::size_t k = 1; k < 2 * S; ++k) power[k] = power[k - 1] * dt;
    Square<S, Real> q;
    for (std::size_t i = 0; i < S; ++i)
        for (std::size_t j = 0; j < S; ++j) {
            const std::size_t a = S - 1 - i, b = S - 1 - j;
            q[i][j] =
                power[a + b + 1] / (static_cast<double>(a + b + 1) * factorial[a] * factorial[b]);
        }
    return q;
}

template <std::size_t N, std::size_t S, class Real = double> struct Covariance;

// Nothing couples.
template <std::size_t S, class Real> struct Covariance<0, S, Real> { Square<0, Real> p{}; };

template <std::size_t N, std::size_t S, class Real> struct Covariance {
    static constexpr std::size_t ALL = N * S;
    using Turn = Square<N, Real>;
    using Column = Vector<ALL, Real>;
    Square<ALL, Real> p{};

    // F p Fᵀ with F = turn · drift · turn: the pose part is turned, all is drifted by dt, turned
    // again.
    MOTORCADE_WIDE void propagate(const Turn &turn, const Real &dt) {
        turned(turn);
        drifted(dt);
        turned(turn);
    }

    void add_noise(const Vector<N> &densities, const Real &dt) {
        const auto q = diffusion<S>(dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j)
                for (std::size_t c = 0; c < N; ++c)
                    p[i * N + c][j * N + c] += densities[c] * densities[c] * q[i][j];
    }

    // Conditions on a measurement of the pose with such variances. Fills the gain, transposed, and
    // the factor of the innovation's covariance. What a wide prior would cancel is multiplied.
    struct Gain {
        std::array<Column, N> rows;
        Factored<N, Real> factor;

        Real of(std::size_t i, const Vector<N, Real> &innovation) const {
            Real total{};
            for (std::size_t c = 0; c < N; ++c) total += rows[c][i] * innovation[c];
            return total;
        }
    };
    MOTORCADE_WIDE void measured(const Vector<N, Real> &variances, Gain &gain) {
        Turn sum;
        for (std::size_t c = 0; c < N; ++c)
            for (std::size_t k = 0; k < N; ++k)
                sum[c][k] = p[c][k] + (c == k ? variances[c] : Real{});
        gain.factor = Factored<N, Real>(sum);
        for (std::size_t c = 0; c < N; ++c) gain.rows[c] = p[c];
        gain.factor.solve(gain.rows);
        for (std::size_t i = N; i < ALL; ++i) {
            LaneRow<ALL - N, Real> row(&p[i][N]);
            for (std::size_t c = 0; c < N; ++c) row.subtract(p[c][i], &gain.rows[c][N]);
            row.write(&p[i][N]);
        }
        for (std::size_t c = 0; c < N; ++c) {
            LaneRow<ALL, Real> row(gain.rows[c].data());
            row.scale(variances[c]);
            row.write(p[c].data());
        }
        for (std::size_t i = N; i < ALL; ++i)
            for (std::size_t c = 0; c < N; ++c) p[i][c] = p[c][i];
        mirror(0, N);
        mirror(N, ALL);
    }

    MOTORCADE_WIDE Factored<ALL, Real> factored() const { return Factored<ALL, Real>(p); }

    // Q p⁻¹, p being factored: of a residual behind a prediction `p` with that noise, how much is
    // the noise's.
    [[gnu::noinline]] Square<ALL, Real> noise_share(const Factored<ALL, Real> &factor,
                                                    const Vector<N> &densities,
                                                    const Real &dt) const {
        Square<ALL, Real> inverse{};
        for (std::size_t i = 0; i < ALL; ++i) inverse[i][i] = 1.0;
        factor.solve(inverse);
        return noise_times(densities, dt, inverse);
    }

    // The same times a residual.
    MOTORCADE_WIDE Column noise_share(const Factored<ALL, Real> &factor, const Vector<N> &densities,
                                      const Real &dt, const Column &of) const {
        const auto weighed = factor.solved(of);
        std::array<Vector<1, Real>, ALL> rows;
        for (std::size_t i = 0; i < ALL; ++i) rows[i][0] = weighed[i];
        rows = noise_times(densities, dt, rows);
        Column made;
        for (std::size_t i = 0; i < ALL; ++i) made[i] = rows[i][0];
        return made;
    }

    // p Fᵀ predicted⁻¹ times a residual: what the filtered state gains from one behind its
    // prediction.
    [[gnu::noinline]] Column gained(const Covariance &predicted, const Turn &turn, const Real &dt,
                                    const Column &residual) const {
        auto way = Factored<ALL, Real>(predicted.p).solved(residual);
        const auto turn_back = [&] {
            Vector<N, Real> first{};
            for (std::size_t k = 0; k < N; ++k)
                for (std::size_t i = 0; i < N; ++i) first[i] += turn[k][i] * way[k];
            for (std::size_t i = 0; i < N; ++i) way[i] = first[i];
        };
        turn_back();
        for (std::size_t i = ALL; i-- > N;)
            way[i] += dt * way[i - N] +
                      (i >= 2 * N ? 0.5 * dt * dt * way[(i + ALL - 2 * N) % ALL] : Real{});
        turn_back();
        Column made{};
        for (std::size_t i = 0; i < ALL; ++i)
            for (std::size_t j = 0; j < ALL; ++j) made[i] += p[i][j] * way[j];
        return made;
    }

    // The covariance before a prediction from the smoothed one behind it: with K = 1 - share, p
    // becomes F⁻¹ (K p Kᵀ + K Q) F⁻ᵀ, with the inverse step's `turn`.
    [[gnu::noinline]] void rts_step(const Square<ALL, Real> &share, const Vector<N> &densities,
                                    const Turn &turn, const Real &dt) {
        Square<ALL, Real> known, flipped;
        for (std::size_t i = 0; i < ALL; ++i)
            for (std::size_t j = 0; j < ALL; ++j) {
                known[i][j] = (i == j ? 1.0 : 0.0) - share[i][j];
                flipped[j][i] = known[i][j];
            }
        p = product(p, flipped);
        add_noise(densities, dt);
        p = product(known, p);
        mirror(0, ALL);
        propagate(turn, -dt);
    }

private:
    template <std::size_t M>
    static auto noise_times(const Vector<N> &densities, const Real &dt,
                            const std::array<Vector<M, Real>, ALL> &rows) {
        std::array<Vector<M, Real>, ALL> made{};
        const auto q = diffusion<S>(dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t c = 0; c < N; ++c)
                for (std::size_t j = 0; j < S; ++j) {
                    const Real factor = densities[c] * densities[c] * q[i][j];
                    for (std::size_t k = 0; k < M; ++k)
                        made[i * N + c][k] += factor * rows[j * N + c][k];
                }
        return made;
    }

    // Of twists, the upper right quarter of an adjoint is zero.
    static constexpr std::size_t reach(std::size_t i) { return N >= 6 && i < 3 ? 3 : N; }

    MOTORCADE_INLINE void turned(const Turn &turn) {
        if constexpr (N > 1) {
            std::array<Column, N> rows;
            MOTORCADE_ROWS
            for (std::size_t i = 0; i < N; ++i) {
                LaneRow<ALL, Real> row;
                MOTORCADE_ROWS
                for (std::size_t k = 0; k < N; ++k)
                    if (k < reach(i)) row.add(turn[i][k], p[k].data());
                row.write(rows[i].data());
            }
            MOTORCADE_ROWS
            for (std::size_t i = 0; i < N; ++i) {
                MOTORCADE_ROWS
                for (std::size_t j = i; j < N; ++j) {
                    Real total{};
                    MOTORCADE_ROWS
                    for (std::size_t k = 0; k < N; ++k)
                        if (k < reach(j)) total += rows[i][k] * turn[j][k];
                    p[i][j] = p[j][i] = total;
                }
            }
            for (std::size_t i = 0; i < N; ++i)
                for (std::size_t j = N; j < ALL; ++j) p[i][j] = p[j][i] = rows[i][j];
        }
    }

    MOTORCADE_INLINE void drifted(const Real &dt) {
        const Real half = 0.5 * dt * dt;
        for (std::size_t i = 0; i + N < ALL; ++i) moved<ALL>(p[i].data(), ALL * N, dt, half, i);
        for (auto &row : p)
            for (std::size_t j = 0; j + N < ALL; j += N) moved<N>(&row[j], N, dt, half, j);
    }

    // Adds to numbers what lies one step behind them, and two: with `at` the component, where there
    // is one.
    template <std::size_t M>
    MOTORCADE_INLINE static void moved(Real *numbers, std::size_t step, const Real &dt,
                                       const Real &half, std::size_t at) {
        LaneRow<M, Real> by;
        by.add(dt, numbers + step);
        if (at + 2 * N < ALL) by.add(half, numbers + 2 * step);
        by.add(1.0, numbers);
        by.write(numbers);
    }

    MOTORCADE_INLINE void mirror(std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i)
            for (std::size_t j = from; j < i; ++j) p[i][j] = p[j][i] = 0.5 * (p[i][j] + p[j][i]);
    }
};

}  // namespace motorcade::smooth
