// Kalman filter and Rauch-Tung-Striebel smoother of constant velocity (order 1) or constant
// acceleration (order 2), over a representation.
//
// Noise is isotropic in each block, so that a block's covariance is one small matrix over pose,
// velocity and acceleration: a recursion in dt alone. The means are moved exactly: a prediction runs
// along the screw of the velocity, and a smoothed pose is brought back along it before it is
// compared. What is neglected is the adjoint of one step in the covariances.

#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "representations.h"

namespace motorcade::smooth {

template <std::size_t S> using Square = std::array<std::array<double, S>, S>;

template <std::size_t S> Square<S> product(const Square<S> &a, const Square<S> &b) {
    Square<S> made{};
    for (std::size_t i = 0; i < S; ++i)
        for (std::size_t k = 0; k < S; ++k)
            for (std::size_t j = 0; j < S; ++j) made[i][j] += a[i][k] * b[k][j];
    return made;
}

template <std::size_t S> Square<S> transposed(const Square<S> &a) {
    Square<S> made;
    for (std::size_t i = 0; i < S; ++i)
        for (std::size_t j = 0; j < S; ++j) made[i][j] = a[j][i];
    return made;
}

// x = b A⁻¹ for a symmetric positive definite A, by Cholesky's factors.
template <std::size_t S> Square<S> divided(const Square<S> &b, const Square<S> &a) {
    Square<S> lower{}, x = b;
    for (std::size_t i = 0; i < S; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double rest = a[i][j];
            for (std::size_t k = 0; k < j; ++k) rest -= lower[i][k] * lower[j][k];
            lower[i][j] = i == j ? std::sqrt(rest) : rest / lower[j][j];
        }
    for (auto &row : x) {
        for (std::size_t i = 0; i < S; ++i) {
            for (std::size_t k = 0; k < i; ++k) row[i] -= lower[i][k] * row[k];
            row[i] /= lower[i][i];
        }
        for (std::size_t i = S; i-- > 0;) {
            for (std::size_t k = i + 1; k < S; ++k) row[i] -= lower[k][i] * row[k];
            row[i] /= lower[i][i];
        }
    }
    return x;
}

template <std::size_t S> Square<S> transition(double dt) {
    Square<S> f{};
    for (std::size_t i = 0; i < S; ++i) {
        f[i][i] = 1.0;
        if (i + 1 < S) f[i][i + 1] = dt;
        if (i + 2 < S) f[i][i + 2] = 0.5 * dt * dt;
    }
    return f;
}

// What white noise of unit density on the highest derivative adds in dt.
template <std::size_t S> Square<S> diffusion(double dt) {
    constexpr double factorial[] = {1.0, 1.0, 2.0};
    double power[2 * S];
    power[0] = 1.0;
    for (std::size_t k = 1; k < 2 * S; ++k) power[k] = power[k - 1] * dt;
    Square<S> q;
    for (std::size_t i = 0; i < S; ++i)
        for (std::size_t j = 0; j < S; ++j) {
            const std::size_t a = S - 1 - i, b = S - 1 - j;
            q[i][j] = power[a + b + 1] / (static_cast<double>(a + b + 1) * factorial[a] * factorial[b]);
        }
    return q;
}

// Densities of the process and deviations of the measurement: rotation, translation, scale.
using BlockValues = std::array<double, 3>;

// Deviations of the rates before they have been seen, in multiples of what the first step's noise
// and the first step itself amount to as a rate.
inline constexpr double PRIOR_OF_NOISE = 1e3, PRIOR_OF_STEP = 10.0;

template <Representation R, std::size_t Order> class Kalman {
public:
    static constexpr std::size_t S = Order + 1, BLOCKS = R::ends.size();
    struct State {
        Vector<R::size> pose{};
        std::array<Vector<R::freedom>, Order> rates{};
        std::array<Square<S>, BLOCKS> covariance{};
    };

    Kalman(const BlockValues &densities, const BlockValues &deviations)
        : densities_(densities), deviations_(deviations) {}

    const Vector<R::size> &pose() const { return state_.pose; }
    const State &state() const { return state_; }
    double log_likelihood() const { return log_likelihood_; }
    void measured_with(const BlockValues &deviations) { deviations_ = deviations; }

    void start(const Vector<R::size> &z) {
        state_ = {};
        state_.pose = z;
        for (std::size_t b = 0; b < BLOCKS; ++b) state_.covariance[b][0][0] = variance(b);
        steps_ = 0;
        log_likelihood_ = 0.0;
    }

    // Gives the rates of the first state their wide prior, from what the second pose shows; before it
    // is stepped to. Doing it twice changes nothing.
    void open_rates(const Vector<R::size> &z, double dt) {
        const auto moved = R::difference(z, state_.pose);
        for (std::size_t b = 0, k = 0; b < BLOCKS; ++b) {
            double square = 0.0;
            for (; k < R::ends[b]; ++k) square += moved[k] * moved[k];
            double prior = PRIOR_OF_NOISE * PRIOR_OF_NOISE * variance(b) + PRIOR_OF_STEP * PRIOR_OF_STEP * square;
            for (std::size_t i = 1; i < S; ++i) state_.covariance[b][i][i] = prior /= dt * dt;
        }
    }

    void step(const Vector<R::size> &z, double dt) {
        if (steps_ == 0) open_rates(z, dt);
        state_.pose = R::moved(state_.pose, travel(state_, dt));
        state_.rates = predicted_rates(state_, dt);
        const auto innovation = R::difference(z, state_.pose);
        // The first innovations only tell the rates, whose prior says nothing of the noise.
        const bool counts = ++steps_ > Order;
        Vector<R::freedom> correction;
        for (std::size_t b = 0, k = 0; b < BLOCKS; ++b) {
            auto &p = state_.covariance[b];
            p = predicted(p, b, dt);
            const double r = variance(b), s = p[0][0] + r;
            double square = 0.0;
            for (const std::size_t first = k; k < R::ends[b]; ++k) {
                if (counts && k == first)
                    log_likelihood_ -= 0.5 * static_cast<double>(R::ends[b] - first) * std::log(TAU * s);
                square += innovation[k] * innovation[k];
                correction[k] = p[0][0] / s * innovation[k];
                for (std::size_t i = 0; i < Order; ++i) state_.rates[i][k] += p[i + 1][0] / s * innovation[k];
            }
            if (counts) log_likelihood_ -= 0.5 * square / s;
            update(p, r, s);
        }
        state_.pose = R::moved(state_.pose, correction);
    }

    // The smoothed state at `filtered` from the one `dt` later.
    State smoothed(const State &filtered, const State &later, double dt) const {
        State made = filtered;
        const auto back = R::moved(later.pose, scaled(-1.0, travel(filtered, dt)));
        const auto apart = R::difference(back, filtered.pose);
        const auto rates = predicted_rates(filtered, dt);
        Vector<R::freedom> correction{};
        for (std::size_t b = 0, k = 0; b < BLOCKS; ++b) {
            const auto &p = filtered.covariance[b];
            const auto f = transition<S>(dt);
            const auto before = predicted(p, b, dt);
            const auto gain = divided(product(p, transposed(f)), before);
            for (; k < R::ends[b]; ++k) {
                Vector<S> residual{apart[k]};
                for (std::size_t i = 0; i < Order; ++i) residual[i + 1] = later.rates[i][k] - rates[i][k];
                for (std::size_t j = 0; j < S; ++j) {
                    correction[k] += gain[0][j] * residual[j];
                    for (std::size_t i = 0; i < Order; ++i) made.rates[i][k] += gain[i + 1][j] * residual[j];
                }
            }
            auto narrowed = later.covariance[b];
            for (std::size_t i = 0; i < S; ++i)
                for (std::size_t j = 0; j < S; ++j) narrowed[i][j] -= before[i][j];
            const auto less = product(product(gain, narrowed), transposed(gain));
            for (std::size_t i = 0; i < S; ++i)
                for (std::size_t j = 0; j < S; ++j) made.covariance[b][i][j] += less[i][j];
        }
        made.pose = R::moved(made.pose, correction);
        return made;
    }

private:
    static constexpr double TAU = 6.283185307179586;

    double variance(std::size_t b) const {
        const double deviation = deviations_[b] * R::units[b];
        return deviation * deviation;
    }

    static Vector<R::freedom> travel(const State &state, double dt) {
        auto made = scaled(dt, state.rates[0]);
        if constexpr (Order == 2) made = sum(made, scaled(0.5 * dt * dt, state.rates[1]));
        return made;
    }

    static auto predicted_rates(const State &state, double dt) {
        auto rates = state.rates;
        if constexpr (Order == 2) rates[0] = sum(rates[0], scaled(dt, rates[1]));
        return rates;
    }

    Square<S> predicted(const Square<S> &p, std::size_t b, double dt) const {
        const auto f = transition<S>(dt);
        auto made = product(product(f, p), transposed(f));
        const auto q = diffusion<S>(dt);
        const double density = densities_[b] * R::units[b];
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) made[i][j] += density * density * q[i][j];
        return made;
    }

    // p - p[:, 0] p[0, :] / s, without cancellation where the first row is concerned.
    static void update(Square<S> &p, double r, double s) {
        for (std::size_t i = 1; i < S; ++i)
            for (std::size_t j = 1; j <= i; ++j) p[i][j] = p[j][i] = p[i][j] - p[i][0] / s * p[0][j];
        for (std::size_t i = 0; i < S; ++i) p[i][0] = p[0][i] = p[i][0] * (r / s);
    }

    BlockValues densities_, deviations_;
    State state_;
    std::size_t steps_ = 0;
    double log_likelihood_ = 0.0;
};

}  // namespace motorcade::smooth
