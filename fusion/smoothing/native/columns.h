// Smoothing splines of columns of numbers that share their stamps, weights and noise: the value and
// its first Order derivatives, of which white noise drives the highest. Noise is white, of unit
// variance over the weight; densities of the process are in its deviations.
//
// Forward it is a Kalman filter with one covariance for all columns; back the recursion of P. de
// Jong, Smoothing and interpolation with the state-space model, J. American Statistical Association
// 84 (1989), which inverts nothing but numbers and gives what each value would be without itself.

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "covariance.h"

namespace motorcade::smooth {

struct Column {
    const double *time_s, *values, *weights;  // (N), (N, D), (N); weight 0 is no measurement
    std::size_t count;
};

// Of the innovations but those that only open the state: how many rows, their squares over all
// columns and the sum of the logarithms of their variances, for unit noise.
struct Innovations {
    double rows = 0.0, squares = 0.0, logarithms = 0.0;
};

// (N, D), (N, D), (N): smoothed values; residuals of the measured values from what all others make
// of them; and the variance of what these make, in that of the noise.
struct Spline {
    double *values, *left_out, *variance;
};

template <std::size_t Order, std::size_t D> class Columns {
public:
    static constexpr std::size_t S = Order + 1;
    using Rows = std::array<Vector<D>, S>;

    Columns(const Column &given, double density) : given_(given), density_(density) {}

    Innovations filter() { return forward<false>(); }

    Innovations smooth(const Spline &out) {
        kept_.resize(given_.count);
        const Innovations found = forward<true>();
        backward(out);
        return found;
    }

private:
    // The first state is the polynomial through the first values, this much less certain.
    static constexpr double WIDTH = 1e4;

    struct Step {
        Vector<D> value;       // predicted
        Vector<S> covariance;  // of the predicted value with the state
        double variance;       // of the predicted value and the measured one together
    };

    Covariance<1, S> covariance_;
    Rows state_;

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
            const double passed = given_.time_s[at[i]] - given_.time_s[0];
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
                1.0 / given_.weights[at[i]] + added(given_.time_s[at[i]] - given_.time_s[0]);
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
                covariance_.p[i][j] = WIDTH * total / (taken[i][i] * taken[j][j]);
            }
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
        auto &p = covariance_.p;
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) p[i][j] = drift_row(p, i, j, dt);
        for (std::size_t j = 0; j < S; ++j)
            for (std::size_t i = 0; i < S; ++i) {
                double factor = 1.0;
                for (std::size_t k = j + 1; k < S; ++k) {
                    factor *= dt / static_cast<double>(k - j);
                    p[i][j] += factor * p[i][k];
                }
            }
        const auto q = diffusion<S>(dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) p[i][j] += density_ * density_ * q[i][j];
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < i; ++j) p[i][j] = p[j][i];
    }

    static double drift_row(const Square<S> &p, std::size_t i, std::size_t j, double dt) {
        double total = p[i][j], factor = 1.0;
        for (std::size_t k = i + 1; k < S; ++k) {
            factor *= dt / static_cast<double>(k - i);
            total += factor * p[k][j];
        }
        return total;
    }

    template <bool KEEP> Innovations forward() {
        start();
        Innovations found;
        std::size_t seen = 0;
        for (std::size_t k = 0; k < given_.count; ++k) {
            if (k > 0) predict(given_.time_s[k] - given_.time_s[k - 1]);
            auto &p = covariance_.p;
            const double weight = given_.weights[k];
            const double noise = weight > 0.0 ? 1.0 / weight : 0.0, variance = p[0][0] + noise;
            if constexpr (KEEP) kept_[k] = {state_[0], p[0], variance};
            if (!(weight > 0.0)) continue;
            const auto z = measured(k);
            Vector<D> innovation;
            double square = 0.0;
            for (std::size_t c = 0; c < D; ++c) {
                innovation[c] = z[c] - state_[0][c];
                square += innovation[c] * innovation[c];
            }
            Vector<S> gain;
            for (std::size_t i = 0; i < S; ++i) gain[i] = p[0][i] / variance;
            for (std::size_t i = 0; i < S; ++i)
                for (std::size_t c = 0; c < D; ++c) state_[i][c] += gain[i] * innovation[c];
            // What a wide prior would cancel is multiplied.
            for (std::size_t i = 1; i < S; ++i)
                for (std::size_t j = i; j < S; ++j) p[i][j] = p[j][i] -= gain[i] * p[0][j];
            for (std::size_t i = 0; i < S; ++i) p[0][i] = p[i][0] = noise * gain[i];
            if (++seen <= S) continue;
            found.rows += 1.0;
            found.squares += square / variance;
            found.logarithms += std::log(variance);
        }
        return found;
    }

    void backward(const Spline &out) const {
        Rows pull{};
        Square<S> known{};
        for (std::size_t k = given_.count; k-- > 0;) {
            if (k + 1 < given_.count)
                taken_back(pull, known, given_.time_s[k + 1] - given_.time_s[k]);
            const Step &step = kept_[k];
            const double weight = given_.weights[k];
            if (weight > 0.0) {
                const auto z = measured(k);
                Vector<S> gain, seen{};
                for (std::size_t i = 0; i < S; ++i) gain[i] = step.covariance[i] / step.variance;
                double precision = 1.0 / step.variance;
                for (std::size_t i = 0; i < S; ++i) {
                    for (std::size_t j = 0; j < S; ++j) seen[i] += known[i][j] * gain[j];
                    precision += gain[i] * seen[i];
                }
                for (std::size_t c = 0; c < D; ++c) {
                    double disturbance = (z[c] - step.value[c]) / step.variance;
                    for (std::size_t i = 0; i < S; ++i) disturbance -= gain[i] * pull[i][c];
                    out.left_out[k * D + c] = disturbance / precision;
                    pull[0][c] += disturbance;
                }
                // known - H s' - s H' + H H' (1/F + k'Nk), the last of which is `precision`.
                for (std::size_t i = 0; i < S; ++i) {
                    known[0][i] -= seen[i];
                    known[i][0] -= seen[i];
                }
                known[0][0] += precision;
                out.variance[k] = std::max(0.0, 1.0 / precision - 1.0 / weight);
            }
            double less = 0.0;
            for (std::size_t i = 0; i < S; ++i)
                for (std::size_t j = 0; j < S; ++j)
                    less += step.covariance[i] * known[i][j] * step.covariance[j];
            if (!(weight > 0.0)) out.variance[k] = std::max(0.0, step.covariance[0] - less);
            for (std::size_t c = 0; c < D; ++c) {
                double value = step.value[c];
                for (std::size_t i = 0; i < S; ++i) value += step.covariance[i] * pull[i][c];
                out.values[k * D + c] = value;
                if (!(weight > 0.0)) out.left_out[k * D + c] = given_.values[k * D + c] - value;
            }
        }
    }

    // Φ' r and Φ' N Φ of a step.
    static void taken_back(Rows &pull, Square<S> &known, double dt) {
        for (std::size_t j = S; j-- > 0;) {
            double factor = 1.0;
            for (std::size_t i = j; i-- > 0;) {
                factor *= dt / static_cast<double>(j - i);
                for (std::size_t c = 0; c < D; ++c) pull[j][c] += factor * pull[i][c];
                for (std::size_t c = 0; c < S; ++c) known[j][c] += factor * known[i][c];
            }
        }
        for (std::size_t j = S; j-- > 0;) {
            double factor = 1.0;
            for (std::size_t i = j; i-- > 0;) {
                factor *= dt / static_cast<double>(j - i);
                for (std::size_t c = 0; c < S; ++c) known[c][j] += factor * known[c][i];
            }
        }
    }

    Column given_;
    double density_;
    std::vector<Step> kept_;
};

}  // namespace motorcade::smooth
