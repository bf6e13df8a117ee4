// Covariance of S derivatives (pose, velocity, acceleration) of N components that couple: rows and
// columns in S blocks of N. Of uncoupled components N is 1, and the same matrix serves for each.

#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "lanes.h"
#include "vectors.h"

namespace motorcade::smooth {

template <std::size_t N> using Square = std::array<std::array<double, N>, N>;

template <std::size_t N>
MOTORCADE_INLINE Square<N> product(const Square<N> &a, const Square<N> &b) {
    Square<N> made;
    for (std::size_t i = 0; i < N; ++i) {
        LaneRow<N> row;
        for (std::size_t k = 0; k < N; ++k) row.add(a[i][k], b[k].data());
        row.write(made[i].data());
    }
    return made;
}

// Loops over the rows of a matrix, laid out as a whole.
#define MOTORCADE_ROWS _Pragma("GCC unroll 12")

// The factors Uᵀ D U of a symmetric positive definite matrix, U of unit diagonal and D inverted;
// row by row, and whole rows, what is left of the diagonal meaning nothing. No root is taken: each
// row waits for the one before. Of a matrix that is not positive definite, all that is solved is
// NaN.
template <std::size_t N> struct Factored {
    Square<N> upper;
    Vector<N> inverse;
    double determinant = 1.0;

    MOTORCADE_INLINE explicit Factored(const Square<N> &a) {
        Square<N> pivots;
        MOTORCADE_ROWS
        for (std::size_t k = 0; k < N; ++k) {
            LaneRow<N> row(a[k].data());
            MOTORCADE_ROWS
            for (std::size_t m = 0; m < k; ++m) row.subtract(upper[m][k], pivots[m].data());
            row.write(pivots[k].data());
            const double pivot = pivots[k][k];
            determinant *= pivot;
            inverse[k] = pivot > 0.0 ? 1.0 / pivot : std::numeric_limits<double>::quiet_NaN();
            row.scale(inverse[k]);
            row.write(upper[k].data());
        }
    }

    // a⁻¹ times N rows of M numbers, in place.
    template <std::size_t M>
    MOTORCADE_INLINE void solve(std::array<std::array<double, M>, N> &rows) const {
        for (std::size_t i = 1; i < N; ++i) {
            LaneRow<M> row(rows[i].data());
            for (std::size_t k = 0; k < i; ++k) row.subtract(upper[k][i], rows[k].data());
            row.write(rows[i].data());
        }
        for (std::size_t i = N; i-- > 0;) {
            LaneRow<M> row(rows[i].data());
            row.scale(inverse[i]);
            for (std::size_t k = N; k-- > i + 1;) row.subtract(upper[i][k], rows[k].data());
            row.write(rows[i].data());
        }
    }

    MOTORCADE_INLINE Vector<N> solved(const Vector<N> &right) const {
        Vector<N> made = right;
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
template <std::size_t S> Square<S> diffusion(double dt) {
    constexpr double factorial[] = {1.0, 1.0, 2.0, 6.0};
    double power[2 * S];
    power[0] = 1.0;
    for (std::size_t k = 1; k < 2 * S; ++k) power[k] = power[k - 1] * dt;
    Square<S> q;
    for (std::size_t i = 0; i < S; ++i)
        for (std::size_t j = 0; j < S; ++j) {
            const std::size_t a = S - 1 - i, b = S - 1 - j;
            q[i][j] =
                power[a + b + 1] / (static_cast<double>(a + b + 1) * factorial[a] * factorial[b]);
        }
    return q;
}

template <std::size_t N, std::size_t S> struct Covariance;

// Nothing couples.
template <std::size_t S> struct Covariance<0, S> { Square<0> p{}; };

template <std::size_t N, std::size_t S> struct Covariance {
    static constexpr std::size_t ALL = N * S;
    Square<ALL> p{};

    // F p Fᵀ with F = turn · drift · turn: the pose part is turned, all is drifted by dt, turned
    // again.
    [[gnu::noinline]] void propagate(const Square<N> &turn, double dt) {
        turned(turn);
        drifted(dt);
        turned(turn);
    }

    void add_noise(const Vector<N> &densities, double dt) {
        const auto q = diffusion<S>(dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j)
                for (std::size_t c = 0; c < N; ++c)
                    p[i * N + c][j * N + c] += densities[c] * densities[c] * q[i][j];
    }

    // Conditions on a measurement of the pose with such variances. Returns the gain, transposed,
    // and the factor of the innovation's covariance. What a wide prior would cancel is multiplied.
    struct Gain {
        std::array<std::array<double, ALL>, N> rows;
        Factored<N> factor;

        MOTORCADE_INLINE explicit Gain(const Square<N> &sum) : factor(sum) {}
        double of(std::size_t i, const Vector<N> &innovation) const {
            double total = 0.0;
            for (std::size_t c = 0; c < N; ++c) total += rows[c][i] * innovation[c];
            return total;
        }
    };
    [[gnu::noinline]] Gain measured(const Vector<N> &variances) {
        Square<N> sum;
        for (std::size_t c = 0; c < N; ++c)
            for (std::size_t k = 0; k < N; ++k) sum[c][k] = p[c][k] + (c == k ? variances[c] : 0.0);
        Gain gain(sum);
        for (std::size_t c = 0; c < N; ++c) gain.rows[c] = p[c];
        gain.factor.solve(gain.rows);
        for (std::size_t i = N; i < ALL; ++i) {
            LaneRow<ALL - N> row(&p[i][N]);
            for (std::size_t c = 0; c < N; ++c) row.subtract(p[c][i], &gain.rows[c][N]);
            row.write(&p[i][N]);
        }
        for (std::size_t c = 0; c < N; ++c) {
            LaneRow<ALL> row(gain.rows[c].data());
            row.scale(variances[c]);
            row.write(p[c].data());
        }
        for (std::size_t i = N; i < ALL; ++i)
            for (std::size_t c = 0; c < N; ++c) p[i][c] = p[c][i];
        mirror(0, N);
        mirror(N, ALL);
        return gain;
    }

    [[gnu::noinline]] Factored<ALL> factored() const { return Factored<ALL>(p); }

    // Q p⁻¹, p being factored: of a residual behind a prediction `p` with that noise, how much is
    // the noise's.
    [[gnu::noinline]] Square<ALL> noise_share(const Factored<ALL> &factor,
                                              const Vector<N> &densities, double dt) const {
        Square<ALL> inverse{};
        for (std::size_t i = 0; i < ALL; ++i) inverse[i][i] = 1.0;
        factor.solve(inverse);
        return noise_times(densities, dt, inverse);
    }

    // The same times a residual.
    [[gnu::noinline]] Vector<ALL> noise_share(const Factored<ALL> &factor,
                                              const Vector<N> &densities, double dt,
                                              const Vector<ALL> &of) const {
        const auto weighed = factor.solved(of);
        std::array<std::array<double, 1>, ALL> rows;
        for (std::size_t i = 0; i < ALL; ++i) rows[i][0] = weighed[i];
        rows = noise_times(densities, dt, rows);
        Vector<ALL> made;
        for (std::size_t i = 0; i < ALL; ++i) made[i] = rows[i][0];
        return made;
    }

    // p Fᵀ predicted⁻¹ times a residual: what the filtered state gains from one behind its
    // prediction.
    [[gnu::noinline]] Vector<ALL> gained(const Covariance &predicted, const Square<N> &turn,
                                         double dt, const Vector<ALL> &residual) const {
        auto way = Factored<ALL>(predicted.p).solved(residual);
        const auto turn_back = [&] {
            Vector<N> first{};
            for (std::size_t k = 0; k < N; ++k)
                for (std::size_t i = 0; i < N; ++i) first[i] += turn[k][i] * way[k];
            for (std::size_t i = 0; i < N; ++i) way[i] = first[i];
        };
        turn_back();
        for (std::size_t i = ALL; i-- > N;)
            way[i] +=
                dt * way[i - N] + (i >= 2 * N ? 0.5 * dt * dt * way[(i + ALL - 2 * N) % ALL] : 0.0);
        turn_back();
        Vector<ALL> made{};
        for (std::size_t i = 0; i < ALL; ++i)
            for (std::size_t j = 0; j < ALL; ++j) made[i] += p[i][j] * way[j];
        return made;
    }

    // The covariance before a prediction from the smoothed one behind it: with K = 1 - share, p
    // becomes F⁻¹ (K p Kᵀ + K Q) F⁻ᵀ, with the inverse step's `turn`.
    [[gnu::noinline]] void rts_step(const Square<ALL> &share, const Vector<N> &densities,
                                    const Square<N> &turn, double dt) {
        Square<ALL> known, flipped;
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
    static auto noise_times(const Vector<N> &densities, double dt,
                            const std::array<std::array<double, M>, ALL> &rows) {
        std::array<std::array<double, M>, ALL> made{};
        const auto q = diffusion<S>(dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t c = 0; c < N; ++c)
                for (std::size_t j = 0; j < S; ++j) {
                    const double factor = densities[c] * densities[c] * q[i][j];
                    for (std::size_t k = 0; k < M; ++k)
                        made[i * N + c][k] += factor * rows[j * N + c][k];
                }
        return made;
    }

    MOTORCADE_INLINE void turned(const Square<N> &turn) {
        if constexpr (N > 1) {
            std::array<std::array<double, ALL>, N> rows;
            Square<N> across;
            MOTORCADE_ROWS
            for (std::size_t i = 0; i < N; ++i) {
                LaneRow<ALL> row;
                MOTORCADE_ROWS
                for (std::size_t k = 0; k < N; ++k) row.add(turn[i][k], p[k].data());
                row.write(rows[i].data());
                for (std::size_t k = 0; k < N; ++k) across[k][i] = turn[i][k];
            }
            for (std::size_t i = 0; i < N; ++i) {
                LaneRow<N> first;
                MOTORCADE_ROWS
                for (std::size_t k = 0; k < N; ++k) first.add(rows[i][k], across[k].data());
                first.write(p[i].data());
            }
            for (std::size_t i = 0; i < N; ++i)
                for (std::size_t j = N; j < ALL; ++j) p[i][j] = p[j][i] = rows[i][j];
        }
    }

    MOTORCADE_INLINE void drifted(double dt) {
        const double half = 0.5 * dt * dt;
        for (std::size_t i = 0; i + N < ALL; ++i) moved<ALL>(p[i].data(), ALL * N, dt, half, i);
        for (auto &row : p)
            for (std::size_t j = 0; j + N < ALL; j += N) moved<N>(&row[j], N, dt, half, j);
    }

    // Adds to numbers what lies one step behind them, and two: with `at` the component, where there
    // is one.
    template <std::size_t M>
    MOTORCADE_INLINE static void moved(double *numbers, std::size_t step, double dt, double half,
                                       std::size_t at) {
        LaneRow<M> by;
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
