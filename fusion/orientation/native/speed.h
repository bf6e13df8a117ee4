// How fast the sensor moves, as far as specific force tells: the velocity that it gives over the
// last fraction of a second. A walk and a throw differ tenfold; a deviation that suits the one
// takes the other's acceleration for tilt.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "vectors.h"

namespace motorcade::orientation {

inline double square(double x) { return x * x; }

class Speed {
public:
    // The least deviation (m/s), the time (s) after which velocity is forgotten, gravity (m/s²).
    Speed(double least, double time, double gravity)
        : least_(square(least)), time_(time), gravity_(gravity) {}

    // An interval's impulse in the axes of the world, and the variance of the tilt, both axes.
    void watch(const Three &impulse, double elapsed, bool gap, double tilt) {
        const double kept = gap ? 0.0 : std::exp(-elapsed / time_);
        double power = -square(gravity_ * time_) * tilt / 3.0;  // what a tilt makes of gravity
        for (std::size_t i = 0; i < 3; ++i) {
            const double moved = impulse[i] - (i == 2 ? gravity_ * elapsed : 0.0);
            gained_[i] = kept * gained_[i] + moved;
            power += square(gained_[i]) / 3.0;
        }
        mean_ += -std::expm1(-elapsed / AVERAGE_S) * (std::max(0.0, power) - mean_);
    }

    // Of the velocity, each axis: two deviations of what is seen, since motion has more slow
    // acceleration than a process that forgets itself within a fraction of a second.
    double variance() const { return least_ + 4.0 * mean_; }

private:
    // A stride, a stroke, a swing take a second: a mean of some of them, and soon quiet at rest.
    static constexpr double AVERAGE_S = 5.0;

    double least_, time_, gravity_, mean_ = 0.0;
    Three gained_{};
};

}  // namespace motorcade::orientation
