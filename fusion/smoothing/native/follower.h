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
};

struct Rotations {
    using X = Four;
    static Three local(const X &x, const X &base) { return versors::local(base, x); }
    static X retract(const X &base, const Three &v) {
        return versors::renormalize(versors::retract(base, v));
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

    // Moves to the next stamp under a process of density q.
    void predict(double dt, double q) {
        now_.pose = ahead(dt);
        if constexpr (Order == 2)
            for (std::size_t k = 0; k < 3; ++k) now_.rates[0][k] += dt * now_.rates[1][k];
        now_.p = grown(now_.p, dt, q);
    }

    X ahead(double dt) const {
        if constexpr (Order == 0) return now_.pose;
        Three step = scaled(dt, now_.rates[0]);
        if constexpr (Order == 2) step = sum(step, scaled(0.5 * dt * dt, now_.rates[1]));
        return G::retract(now_.pose, step);
    }

    // How far a measurement lies from the prediction, in its own deviations.
    double distance(const X &z) const {
        const Three v = G::local(z, now_.pose);
        return std::sqrt(dot(v, v) / (variance() * (now_.p[0][0] + 1.0)));
    }

    // Takes a measurement; `fading` is what a score keeps until the next.
    void update(const X &z, double fading) {
        const Three v = G::local(z, now_.pose);
        const double spread = now_.p[0][0] + 1.0, square = dot(v, v) / (3.0 * spread);
        const double most = FARTHEST * FARTHEST / 3.0 * variance();
        const double counted = count_ < FEW ? square : std::min(square, most);
        const double heard = square > counted ? counted / square : 1.0;
        correct(v, 1.0 / heard);
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
        mover.predict(dt, q);
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
        made.pose = G::retract(before.pose, moved[0]);
        for (std::size_t i = 1; i < S; ++i) made.rates[i - 1] = sum(before.rates[i - 1], moved[i]);
        return made;
    }

private:
    static constexpr double WIDE = 1e6, TINY = 1e-30, FEW = 8.0;

    static Square<S> transition(double dt) {
        Square<S> f{};
        for (std::size_t i = 0; i < S; ++i) f[i][i] = 1.0;
        if constexpr (S > 1) f[0][1] = dt;
        if constexpr (S > 2) {
            f[0][2] = 0.5 * dt * dt;
            f[1][2] = dt;
        }
        return f;
    }

    // P F', with which both the prediction and the smoother's gain begin.
    static Square<S> times_transition(const Square<S> &p, double dt) {
        const Square<S> f = transition(dt);
        Square<S> made{};
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j)
                for (std::size_t k = j; k < S; ++k) made[i][j] += p[i][k] * f[j][k];
        return made;
    }

    static Square<S> grown(const Square<S> &p, double dt, double q) {
        static constexpr std::array<double, 3> factorial{1.0, 1.0, 2.0};
        const Square<S> f = transition(dt), turned = times_transition(p, dt);
        Square<S> made{};
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j)
                for (std::size_t k = i; k < S; ++k) made[i][j] += f[i][k] * turned[k][j];
        std::array<double, 2 * S> power{};
        power[0] = q;
        for (std::size_t i = 1; i < 2 * S; ++i) power[i] = power[i - 1] * dt;
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) {
                const std::size_t n = 2 * S - 1 - i - j;
                made[i][j] += power[n] / (factorial[Order - i] * factorial[Order - j] *
                                          static_cast<double>(n));
            }
        return made;
    }

    static Square<S> smoother_gain(const Square<S> &p, const Square<S> &predicted, double dt) {
        const Square<S> turned = times_transition(p, dt);
        const Cholesky<S> factor(predicted);
        Square<S> gain{};
        for (std::size_t i = 0; i < S; ++i) gain[i] = factor.solved(turned[i]);
        return gain;
    }

    void correct(const Three &v, double noise) {
        const double spread = now_.p[0][0] + noise;
        std::array<double, S> gain;
        for (std::size_t i = 0; i < S; ++i) gain[i] = now_.p[i][0] / spread;
        now_.pose = G::retract(now_.pose, scaled(gain[0], v));
        for (std::size_t i = 1; i < S; ++i)
            now_.rates[i - 1] = sum(now_.rates[i - 1], scaled(gain[i], v));
        const auto row = now_.p[0];
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t j = 0; j < S; ++j) now_.p[i][j] -= gain[i] * row[j];
        // Exact where it would cancel: what is left of the pose's variance, and its row.
        for (std::size_t j = 0; j < S; ++j) now_.p[0][j] = now_.p[j][0] = row[j] * noise / spread;
    }

    State now_;
    double count_ = 0.0, squares_ = 0.0, logs_ = 0.0;
    std::size_t opened_ = 0;
};

}  // namespace motorcade::smooth
