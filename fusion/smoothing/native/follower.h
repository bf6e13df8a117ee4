// A Kalman filter of three axes alike, whose noise is the unit: what it is told is only how its
// process compares with the noise, as a cut-off. How large the noise is in metres or radians it
// finds from its own innovations. Order 0 holds the pose, 1 its velocity, 2 its acceleration.

#pragma once

#include <algorithm>
#include <cmath>

#include "covariance.h"
#include "versors.h"

namespace motorcade::smooth {

inline Three difference(const Three &a, const Three &b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// Points of space, and rotations with steps in their own body frame.
struct Positions {
    using X = Three;
    static Three local(const X &x, const X &base) { return difference(x, base); }
    static X retract(const X &base, const Three &v) { return sum(base, v); }
    static X normalized(const X &x) { return x; }
};

struct Rotations {
    using X = Four;
    static Three local(const X &x, const X &base) { return versors::local(base, x); }
    static X normalized(const X &x) { return versors::renormalize(x); }

    // From one pose to the next angles are small, and few terms tell cosine and sine to the last
    // bit: with half the angle squared below 0.002 the next would be below 1e-19.
    static X retract(const X &base, const Three &v) {
        const double x = 0.25 * dot(v, v), xx = x * x;
        if (x > 2e-3) return versors::retract(base, v);
        const double cosine =
            1.0 - x / 2.0 + xx * (1.0 / 24.0 - x * (1.0 / 720.0) + xx * (1.0 / 40320.0));
        const double sine = x * (1.0 / 12.0) - 0.5 + xx * (x * (1.0 / 10080.0) - 1.0 / 240.0);
        const Three b = scaled(sine, v);
        return {base[0] * cosine - base[1] * b[0] - base[2] * b[1] - base[3] * b[2],
                base[0] * b[0] + base[1] * cosine + base[3] * b[1] - base[2] * b[2],
                base[0] * b[1] + base[2] * cosine + base[1] * b[2] - base[3] * b[0],
                base[0] * b[2] + base[3] * cosine + base[2] * b[0] - base[1] * b[1]};
    }
};

// Innovations beyond this many of their deviations count as this many: three axes of white noise
// pass it once in 10,000 times.
inline constexpr double FARTHEST = 4.6;

template <class G, std::size_t Order> class Follower {
public:
    static constexpr std::size_t S = Order + 1;
    using X = typename G::X;

    struct State {
        X pose{};
        std::array<Three, 2> rates{};  // those of the order are used
        Square<S> p{};                 // in units of the noise's variance
    };

    // Begins at a pose whose rates are unknown: `dt` is how far apart poses are about.
    void start(const X &z, double dt) {
        *this = {};
        reopen(z, dt);
    }

    // Goes on from another pose at the rates it had.
    void reopen(const X &z, double dt) {
        now_.pose = z;
        now_.p = {};
        now_.p[0][0] = 1.0;
        opened_ = 0;
        for (std::size_t i = 1; i < S; ++i)
            now_.p[i][i] = WIDE * std::pow(dt, -2.0 * static_cast<double>(i));
    }

    // Moves to the next stamp; `added` is what a process of unit density adds meanwhile, q its
    // density.
    void predict(double dt, double q, const Square<S> &added) {
        now_.pose = ahead(dt);
        if constexpr (Order == 2)
            for (std::size_t k = 0; k < 3; ++k) now_.rates[0][k] += dt * now_.rates[1][k];
        drift_columns(now_.p, dt);
        drift_rows(now_.p, dt);
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) now_.p[i][j] += q * added[i][j];
    }

    X ahead(double dt) const {
        if constexpr (Order == 0) return now_.pose;
        Three step = scaled(dt, now_.rates[0]);
        if constexpr (Order == 2) step = sum(step, scaled(0.5 * dt * dt, now_.rates[1]));
        return G::retract(now_.pose, step);
    }

    // Meets a measurement, which `distance` and `update` are about.
    void meet(const X &z) { innovation_ = G::local(z, now_.pose); }

    // How far it lies from the prediction, in its own deviations.
    double distance() const {
        return std::sqrt(dot(innovation_, innovation_) / (variance() * (now_.p[0][0] + 1.0)));
    }

    // Takes it; `fading` is what a score keeps until the next.
    void update(double fading) {
        const double spread = now_.p[0][0] + 1.0;
        const double square = dot(innovation_, innovation_) / (3.0 * spread);
        const double most = FARTHEST * FARTHEST / 3.0 * variance();
        const double counted = count_ < FEW ? square : std::min(square, most);
        correct(square > counted ? square / counted : 1.0);
        if (opened_ < S) {
            ++opened_;  // a line through two poses fits, whatever the noise
            return;
        }
        count_ = fading * count_ + 1.0;
        squares_ = fading * squares_ + counted;
        logs_ = fading * logs_ + std::log(spread);
    }

    // The noise's variance, of an axis.
    double variance() const { return count_ > 0.0 ? std::max(squares_ / count_, TINY) : TINY; }
    // The logarithm of the likelihood of what was measured lately, the noise at its likeliest.
    double score() const {
        return count_ > 0.0 ? -1.5 * (count_ * std::log(variance()) + logs_) : 0.0;
    }
    const State &state() const { return now_; }

    // One step of the Rauch-Tung-Striebel recursion: what `before` becomes once `after` is known.
    static State smoothed(const State &before, const State &after, double dt, double q) {
        Follower mover;
        mover.now_ = before;
        mover.predict(dt, q, diffusion<S>(dt));
        const Square<S> gain = smoother_gain(before.p, mover.now_.p, dt);
        std::array<Three, S> off;
        off[0] = G::local(after.pose, mover.now_.pose);
        for (std::size_t i = 1; i < S; ++i)
            off[i] = difference(after.rates[i - 1], mover.now_.rates[i - 1]);
        State made = before;
        std::array<Three, S> moved{};
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j)
                for (std::size_t k = 0; k < 3; ++k) moved[i][k] += gain[i][j] * off[j][k];
        made.pose = G::normalized(G::retract(before.pose, moved[0]));
        for (std::size_t i = 1; i < S; ++i) made.rates[i - 1] = sum(before.rates[i - 1], moved[i]);
        return made;
    }

private:
    static constexpr double WIDE = 1e6, TINY = 1e-30, FEW = 8.0;

    // P F', with which both the prediction and the smoother's gain begin; and F P.
    static void drift_columns(Square<S> &p, double dt) {
        for (auto &row : p) {
            if constexpr (S > 1) row[0] += dt * row[1];
            if constexpr (S > 2) {
                row[0] += 0.5 * dt * dt * row[2];
                row[1] += dt * row[2];
            }
        }
    }

    static void drift_rows(Square<S> &p, double dt) {
        for (std::size_t j = 0; j < S; ++j) {
            if constexpr (S > 1) p[0][j] += dt * p[1][j];
            if constexpr (S > 2) {
                p[0][j] += 0.5 * dt * dt * p[2][j];
                p[1][j] += dt * p[2][j];
            }
        }
    }

    static Square<S> smoother_gain(const Square<S> &p, const Square<S> &predicted, double dt) {
        Square<S> turned = p;
        drift_columns(turned, dt);
        const Factored<S> factor(predicted);
        Square<S> gain{};
        for (std::size_t i = 0; i < S; ++i) gain[i] = factor.solved(turned[i]);
        return gain;
    }

    void correct(double noise) {
        const auto row = now_.p[0];
        const double part = 1.0 / (row[0] + noise);
        std::array<double, S> gain;
        for (std::size_t i = 0; i < S; ++i) gain[i] = row[i] * part;
        now_.pose = G::normalized(G::retract(now_.pose, scaled(gain[0], innovation_)));
        for (std::size_t i = 1; i < S; ++i)
            now_.rates[i - 1] = sum(now_.rates[i - 1], scaled(gain[i], innovation_));
        for (std::size_t i = 1; i < S; ++i)
            for (std::size_t j = 1; j < S; ++j) now_.p[i][j] -= gain[i] * row[j];
        // Exact where it would cancel: what is left of the pose's variance, and its row.
        for (std::size_t j = 0; j < S; ++j) now_.p[0][j] = now_.p[j][0] = noise * gain[j];
    }

    State now_;
    Three innovation_{};
    double count_ = 0.0, squares_ = 0.0, logs_ = 0.0;
    std::size_t opened_ = 0;
};

}  // namespace motorcade::smooth
