// Smoothing splines of columns of numbers that share their stamps, weights and noise: the value and
// its first Order derivatives, of which white noise drives the highest. Noise is of unit variance
// over the weight, and densities of the process are in its deviations. It is white, or COLOURED: it
// decays with a memory (Ornstein and Uhlenbeck's process; between even stamps, autoregressive).
// Where the level jumps the value is loose: what comes behind tells its new one, and derivatives go
// on.
//
// Forward it is a Kalman filter with one covariance for all columns; back the recursion of P. de
// Jong, Smoothing and interpolation with the state-space model, J. American Statistical Association
// 84 (1989), which inverts nothing but numbers and gives what each value would be without itself.

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "covariance.h"

namespace motorcade::smooth {

struct Column {
    const double *time_s, *values, *weights;  // (N), (N, D), (N); weight 0 is no measurement
    std::size_t count;
    const std::int64_t *jumps;  // rows, ascending, before which the level jumps
    std::size_t jump_count;
};

// Of the innovations but those that only open the state: how many rows, the sum of their squares of
// each column, and that of the logarithms of their variances, for unit noise.
template <std::size_t D> struct Innovations {
    double rows = 0.0, logarithms = 0.0;
    Vector<D> squares{};
};

// (N, D), (N, D), (N), (N): smoothed values; residuals of the measured values from what all others
// make of them; by how much the variance of these exceeds that of the noise, which is less than
// nothing where the others tell of it; and the variance of the smoothed values. Variances are in
// that of the noise.
struct Spline {
    double *values, *left_out, *variance, *spread;
    // (N, D, 2) or none: by how many deviations of themselves, for unit noise, a jump of the value
    // and one of its slope before each row would differ from none; their squares are what either
    // would save of squared residuals (P. de Jong, J. Penzer, Diagnosing shocks in time series, J.
    // American Statistical Association 93, 1998).
    double *shocks;
};

template <std::size_t Order, std::size_t D, bool COLOURED> class Columns {
public:
    // The value and its derivatives; and behind these the noise, where it has a memory.
    static constexpr std::size_t S = Order + 1, T = COLOURED ? S + 1 : S;
    using Rows = std::array<Vector<D>, T>;

    Columns(const Column &given, double density, double memory_s)
        : given_(given), density_(density), memory_s_(memory_s) {
        const auto gap = [this](double earlier, double later) {
            return later - earlier > forgotten_s();
        };
        const double *end = given.time_s + given.count;
        if (std::adjacent_find(given.time_s, end, gap) != end) shorten_gaps();
    }

    Innovations<D> filter() {
        kept_.resize(given_.count);
        return forward();
    }

    Innovations<D> smooth(const Spline &out) {
        const Innovations<D> found = filter();
        backward(out);
        return found;
    }

private:
    // The first state is the polynomial through the first values, this much less certain.
    static constexpr double WIDTH = 1e4;
    // Variance of a jump: one of 1,000 deviations is shortened by 1e-5 of one, rounding costs 1e-8.
    static constexpr double JUMP = 1e8;

    // Variance of white noise beside coloured one, for rounding's sake.
    static constexpr double WHITE = 1e-6;
    // What is measured is the sum of these parts of the state.
    static constexpr std::size_t PARTS = COLOURED ? 2 : 1;
    static constexpr std::size_t part(std::size_t i) { return i == 0 ? 0 : S; }

    struct Step {
        std::array<Vector<D>, PARTS> value;       // predicted
        std::array<Vector<T>, PARTS> covariance;  // of these with the state
        double variance;                          // of what is measured

        double predicted(std::size_t c) const {
            return COLOURED ? value[0][c] + value[PARTS - 1][c] : value[0][c];
        }
        double measured(std::size_t i) const {
            return COLOURED ? covariance[0][i] + covariance[PARTS - 1][i] : covariance[0][i];
        }
    };

    // Seconds after which the process has added that variance of a jump: what comes behind a gap is
    // as free of what was before it, and a longer one would only round the derivatives away.
    double forgotten_s() const {
        constexpr double power = 2.0 * static_cast<double>(S) - 1.0;
        return std::pow(JUMP / (density_ * density_ * diffusion<S>(1.0)[0][0]), 1.0 / power);
    }

    void shorten_gaps() {
        const double longest = forgotten_s();
        short_s_.assign(given_.time_s, given_.time_s + given_.count);
        for (std::size_t k = 1; k < given_.count; ++k)
            short_s_[k] =
                short_s_[k - 1] + std::min(given_.time_s[k] - given_.time_s[k - 1], longest);
        given_.time_s = short_s_.data();
    }

    Square<T> p_;  // covariance of the state
    Rows state_;
    std::size_t first_ = 0;  // row that is measured

    Vector<D> measured(std::size_t k) const {
        Vector<D> made;
        std::copy_n(given_.values + k * D, D, made.begin());
        return made;
    }

    void start() {
        std::array<std::size_t, S> at{};
        std::size_t found = 0;
        for (std::size_t k = 0; k < given_.count && found < S; ++k)
            if (given_.weights[k] > 0.0) at[found++] = k;
        // Rows of the inverse of the matrix that takes the state to the values.
        Square<S> taken{}, inverse{};
        for (std::size_t i = 0; i < S; ++i) {
            const double passed = given_.time_s[at[i]] - given_.time_s[at[0]];
            double power = 1.0;
            for (std::size_t j = 0; j < S; ++j) {
                taken[i][j] = power;
                power *= passed / static_cast<double>(j + 1);
            }
            inverse[i][i] = 1.0;
        }
        for (std::size_t k = 0; k < S; ++k) {
            std::size_t best = k;
            for (std::size_t i = k + 1; i < S; ++i)
                if (std::abs(taken[i][k]) > std::abs(taken[best][k])) best = i;
            std::swap(taken[k], taken[best]);
            std::swap(inverse[k], inverse[best]);
            for (std::size_t i = 0; i < S; ++i) {
                if (i == k) continue;
                const double factor = taken[i][k] / taken[k][k];
                for (std::size_t j = 0; j < S; ++j) {
                    taken[i][j] -= factor * taken[k][j];
                    inverse[i][j] -= factor * inverse[k][j];
                }
            }
        }
        state_ = {};
        Square<S> noise{};
        for (std::size_t i = 0; i < S; ++i) {
            noise[i][i] =
                1.0 / given_.weights[at[i]] + added(given_.time_s[at[i]] - given_.time_s[at[0]]);
            const auto z = measured(at[i]);
            for (std::size_t j = 0; j < S; ++j)
                for (std::size_t c = 0; c < D; ++c)
                    state_[j][c] += inverse[j][i] / taken[j][j] * z[c];
        }
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) {
                double total = 0.0;
                for (std::size_t k = 0; k < S; ++k)
                    total += inverse[i][k] * noise[k][k] * inverse[j][k];
                p_[i][j] = WIDTH * total / (taken[i][i] * taken[j][j]);
            }
        if constexpr (COLOURED) {
            for (std::size_t i = 0; i < S; ++i) p_[i][S] = p_[S][i] = 0.0;
            p_[S][S] = 1.0;
        }
        first_ = at[0];
    }

    // Variance of a value that the process adds in a time.
    double added(double dt) const { return density_ * density_ * diffusion<S>(dt)[0][0]; }

    void predict(double dt) {
        for (std::size_t i = 0; i < S; ++i) {
            double factor = 1.0;
            for (std::size_t j = i + 1; j < S; ++j) {
                factor *= dt / static_cast<double>(j - i);
                for (std::size_t c = 0; c < D; ++c) state_[i][c] += factor * state_[j][c];
            }
        }
        auto &p = p_;
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < T; ++j) p[i][j] = drift_row(p, i, j, dt);
        for (std::size_t j = 0; j < S; ++j)
            for (std::size_t i = 0; i < T; ++i) {
                double factor = 1.0;
                for (std::size_t k = j + 1; k < S; ++k) {
                    factor *= dt / static_cast<double>(k - j);
                    p[i][j] += factor * p[i][k];
                }
            }
        const auto q = diffusion<S>(dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) p[i][j] += density_ * density_ * q[i][j];
        if constexpr (COLOURED) {
            const double kept = std::exp(-dt / memory_s_);
            for (std::size_t i = 0; i < S; ++i) p[i][S] *= kept;
            p[S][S] = kept * kept * p[S][S] - std::expm1(-2.0 * dt / memory_s_);
            for (std::size_t c = 0; c < D; ++c) state_[S][c] *= kept;
        }
        for (std::size_t i = 0; i < T; ++i)
            for (std::size_t j = 0; j < i; ++j) p[i][j] = p[j][i];
    }

    static double drift_row(const Square<T> &p, std::size_t i, std::size_t j, double dt) {
        double total = p[i][j], factor = 1.0;
        for (std::size_t k = i + 1; k < S; ++k) {
            factor *= dt / static_cast<double>(k - i);
            total += factor * p[k][j];
        }
        return total;
    }

    Innovations<D> forward() {
        start();
        Innovations<D> found;
        std::size_t seen = 0, jumped = 0;
        for (std::size_t k = first_; k < given_.count; ++k) {
            if (k > first_) predict(given_.time_s[k] - given_.time_s[k - 1]);
            auto &p = p_;
            if (jumped < given_.jump_count &&
                given_.jumps[jumped] == static_cast<std::int64_t>(k)) {
                p[0][0] += JUMP;
                ++jumped;
            }
            const double weight = given_.weights[k];
            const double noise = weight > 0.0 ? white(weight) : 0.0;
            Step &step = kept_[k];
            for (std::size_t i = 0; i < PARTS; ++i)
                step.value[i] = state_[part(i)], step.covariance[i] = p[part(i)];
            step.variance = step.measured(0) + (COLOURED ? step.measured(T - 1) : 0.0) + noise;
            if (!(weight > 0.0)) continue;
            const auto z = measured(k);
            Vector<D> innovation;
            for (std::size_t c = 0; c < D; ++c) innovation[c] = z[c] - step.predicted(c);
            const double variance = step.variance;
            Vector<T> gain;
            for (std::size_t i = 0; i < T; ++i) gain[i] = step.measured(i) / variance;
            for (std::size_t i = 0; i < T; ++i)
                for (std::size_t c = 0; c < D; ++c) state_[i][c] += gain[i] * innovation[c];
            for (std::size_t i = COLOURED ? 0 : 1; i < T; ++i)
                for (std::size_t j = i; j < T; ++j) p[i][j] = p[j][i] -= gain[i] * step.measured(j);
            // What a wide prior would cancel is multiplied.
            if constexpr (!COLOURED)
                for (std::size_t i = 0; i < S; ++i) p[0][i] = p[i][0] = noise * gain[i];
            if (++seen <= S) continue;
            found.rows += 1.0;
            for (std::size_t c = 0; c < D; ++c)
                found.squares[c] += innovation[c] * innovation[c] / variance;
            found.logarithms += std::log(variance);
        }
        return found;
    }

    // Variance of the white noise of a measured value.
    static double white(double weight) {
        return COLOURED ? std::max(1.0 / weight - 1.0, WHITE) : 1.0 / weight;
    }

    void backward(const Spline &out) const {
        Rows pull{};
        Square<T> known{};
        for (std::size_t k = given_.count; k-- > first_;) {
            if (k + 1 < given_.count)
                taken_back(pull, known, given_.time_s[k + 1] - given_.time_s[k]);
            const Step &step = kept_[k];
            const double weight = given_.weights[k];
            if (weight > 0.0) {
                const auto z = measured(k);
                Vector<T> gain, seen{};
                for (std::size_t i = 0; i < T; ++i) gain[i] = step.measured(i) / step.variance;
                double precision = 1.0 / step.variance;
                for (std::size_t i = 0; i < T; ++i) {
                    for (std::size_t j = 0; j < T; ++j) seen[i] += known[i][j] * gain[j];
                    precision += gain[i] * seen[i];
                }
                for (std::size_t c = 0; c < D; ++c) {
                    double disturbance = (z[c] - step.predicted(c)) / step.variance;
                    for (std::size_t i = 0; i < T; ++i) disturbance -= gain[i] * pull[i][c];
                    out.left_out[k * D + c] = disturbance / precision;
                    for (std::size_t i = 0; i < PARTS; ++i) pull[part(i)][c] += disturbance;
                }
                // known - H s' - s H' + H H' (1/F + k'Nk), the last of which is `precision`.
                for (std::size_t q = 0; q < PARTS; ++q) {
                    for (std::size_t i = 0; i < T; ++i) {
                        known[part(q)][i] -= seen[i];
                        known[i][part(q)] -= seen[i];
                    }
                    for (std::size_t r = 0; r < PARTS; ++r) known[part(q)][part(r)] += precision;
                }
                const double beyond = 1.0 / precision - 1.0 / weight;
                out.variance[k] = COLOURED ? beyond : std::max(0.0, beyond);
            }
            if (out.shocks)
                for (std::size_t c = 0; c < D; ++c)
                    for (std::size_t i = 0; i < 2; ++i)
                        out.shocks[2 * (k * D + c) + i] = shock(pull, known, i, c);
            const auto &row = step.covariance[0];
            double less = 0.0;
            for (std::size_t i = 0; i < T; ++i)
                for (std::size_t j = 0; j < T; ++j) less += row[i] * known[i][j] * row[j];
            out.spread[k] = std::max(0.0, row[0] - less);
            if (!(weight > 0.0))
                out.variance[k] = out.spread[k];
            else if (!COLOURED)
                out.spread[k] = out.variance[k] / (1.0 + weight * out.variance[k]);
            for (std::size_t c = 0; c < D; ++c) {
                double value = step.value[0][c];
                for (std::size_t i = 0; i < T; ++i) value += row[i] * pull[i][c];
                out.values[k * D + c] = value;
                if (!(weight > 0.0)) out.left_out[k * D + c] = given_.values[k * D + c] - value;
            }
        }
        if (first_ > 0) before(out);
    }

    // The rows before the first that is measured: those behind the last of the path in reverse,
    // whose predictions cancel nothing.
    void before(const Spline &out) const {
        const std::size_t count = given_.count;
        const auto reversed = [](const double *first, std::size_t size) {
            return std::vector<double>(std::reverse_iterator(first + size),
                                       std::reverse_iterator(first));
        };
        auto time_s = reversed(given_.time_s, count);
        for (double &one : time_s) one = -one;
        const auto weights = reversed(given_.weights, count);
        // Columns of a row are reversed along with the rows.
        const auto values = reversed(given_.values, count * D);
        std::vector<std::int64_t> jumps;
        for (std::size_t k = given_.jump_count; k-- > 0;)
            jumps.push_back(static_cast<std::int64_t>(count) - given_.jumps[k]);
        Columns turned(
            {time_s.data(), values.data(), weights.data(), count, jumps.data(), jumps.size()},
            density_, memory_s_);
        turned.kept_.resize(count);
        turned.forward();
        for (std::size_t k = 0; k < first_; ++k) {
            const Step &step = turned.kept_[count - 1 - k];
            out.variance[k] = out.spread[k] = step.covariance[0][0];
            for (std::size_t c = 0; c < D; ++c) {
                out.values[k * D + c] = step.value[0][D - 1 - c];
                out.left_out[k * D + c] = given_.values[k * D + c] - out.values[k * D + c];
            }
            if (out.shocks) std::fill_n(out.shocks + 2 * k * D, 2 * D, 0.0);
        }
    }

    static double shock(const Rows &pull, const Square<T> &known, std::size_t i, std::size_t c) {
        return i < S && known[i][i] > 0.0 ? pull[i][c] / std::sqrt(known[i][i]) : 0.0;
    }

    // Φ' r and Φ' N Φ of a step.
    void taken_back(Rows &pull, Square<T> &known, double dt) const {
        for (std::size_t j = S; j-- > 0;) {
            double factor = 1.0;
            for (std::size_t i = j; i-- > 0;) {
                factor *= dt / static_cast<double>(j - i);
                for (std::size_t c = 0; c < D; ++c) pull[j][c] += factor * pull[i][c];
                for (std::size_t c = 0; c < T; ++c) known[j][c] += factor * known[i][c];
            }
        }
        for (std::size_t j = S; j-- > 0;) {
            double factor = 1.0;
            for (std::size_t i = j; i-- > 0;) {
                factor *= dt / static_cast<double>(j - i);
                for (std::size_t c = 0; c < T; ++c) known[c][j] += factor * known[c][i];
            }
        }
        if constexpr (COLOURED) {
            const double kept = std::exp(-dt / memory_s_);
            for (std::size_t c = 0; c < D; ++c) pull[S][c] *= kept;
            for (std::size_t c = 0; c < T; ++c) known[S][c] *= kept;
            for (std::size_t c = 0; c < T; ++c) known[c][S] *= kept;
        }
    }

    Column given_;
    std::vector<double> short_s_;  // stamps with gaps cut short, where there are such
    double density_, memory_s_;
    std::vector<Step> kept_;
};

}  // namespace motorcade::smooth
