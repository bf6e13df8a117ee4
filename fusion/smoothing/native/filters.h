// Causal filters of one pose after another, written once over a representation. Each holds its
// state, is started by a first pose and stepped by the next ones; `dt` is in seconds. Rates are
// kept in the base's own frame, so that they go with the pose they belong to.

#pragma once

#include <algorithm>
#include <cmath>

#include "representations.h"

namespace motorcade::smooth {

inline constexpr double TWO_PI = 6.283185307179586;

// Share of a step that a first-order low-pass takes in dt: exact for a constant input.
inline double decay_share(double cutoff_hz, double dt) {
    return -std::expm1(-TWO_PI * cutoff_hz * dt);
}

// The same by backward differences, as the 1€ filter has it.
inline double backward_share(double cutoff_hz, double dt) {
    const double angle = TWO_PI * cutoff_hz * dt;
    return angle / (1.0 + angle);
}

// x moves towards each measurement by the share that a first-order low-pass would.
template <Representation R> class Exponential {
public:
    explicit Exponential(double cutoff_hz) : cutoff_hz_(cutoff_hz) {}

    const Vector<R::size> &pose() const { return pose_; }
    void start(const Vector<R::size> &z) { pose_ = z; }
    void step(const Vector<R::size> &z, double dt) {
        pose_ = R::retract(pose_, scaled(decay_share(cutoff_hz_, dt), R::local(z, pose_)));
    }

private:
    double cutoff_hz_;
    Vector<R::size> pose_{};
};

// Holt's level and trend, by time: the level is extrapolated along the trend, then corrected.
template <Representation R> class DoubleExponential {
public:
    DoubleExponential(double cutoff_hz, double trend_cutoff_hz)
        : cutoff_hz_(cutoff_hz), trend_cutoff_hz_(trend_cutoff_hz) {}

    const Vector<R::size> &pose() const { return level_; }
    void start(const Vector<R::size> &z) {
        level_ = z;
        trend_ = {};
    }
    void step(const Vector<R::size> &z, double dt) {
        const auto predicted = R::retract(level_, scaled(dt, trend_));
        const auto innovation = R::local(z, predicted);
        const auto level = R::retract(predicted, scaled(decay_share(cutoff_hz_, dt), innovation));
        const double share = decay_share(trend_cutoff_hz_, dt);
        trend_ = sum(scaled(1.0 - share, trend_), scaled(share / dt, R::local(level, level_)));
        level_ = level;
    }

private:
    double cutoff_hz_, trend_cutoff_hz_;
    Vector<R::size> level_{};
    Vector<R::freedom> trend_{};
};

// Cut-offs of the 1€ filter: the least one, what a unit of speed adds for rotation (1/rad),
// translation (1/m) and scale, and that of the speed's own low-pass.
struct OneEuroCutoffs {
    double least_hz;
    std::array<double, 3> slopes;
    double derivative_hz;
};

// Casiez, Roussel, Vogel 2012: a low-pass whose cut-off rises with the speed, a block at a time.
template <Representation R> class OneEuro {
public:
    explicit OneEuro(const OneEuroCutoffs &cutoffs) : cutoffs_(cutoffs) {}

    const Vector<R::size> &pose() const { return pose_; }
    void start(const Vector<R::size> &z) {
        pose_ = z;
        rate_ = {};
    }
    void step(const Vector<R::size> &z, double dt) {
        auto towards = R::local(z, pose_);
        const double share = backward_share(cutoffs_.derivative_hz, dt);
        for (std::size_t k = 0; k < R::freedom; ++k)
            rate_[k] = share * (towards[k] / dt) + (1.0 - share) * rate_[k];
        std::size_t k = 0;
        for (std::size_t block = 0; block < R::ends.size(); ++block) {
            const std::size_t first = k;
            double square = 0.0;
            for (; k < R::ends[block]; ++k) square += rate_[k] * rate_[k];
            const double speed = std::sqrt(square) / R::units[block];
            const double step =
                backward_share(cutoffs_.least_hz + cutoffs_.slopes[block] * speed, dt);
            for (std::size_t c = first; c < k; ++c) towards[c] *= step;
        }
        pose_ = R::retract(pose_, towards);
    }

private:
    OneEuroCutoffs cutoffs_;
    Vector<R::size> pose_{};
    Vector<R::freedom> rate_{};
};

}  // namespace motorcade::smooth
