// Rest: readings that keep to their average, and a rate that the gyro's bias may have.

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "speed.h"
#include "vectors.h"

namespace motorcade::orientation {

// What may still turn at rest: 0.1°/s.
inline constexpr double REST_RATE = 1.75e-3;

class Rest {
public:
    // Readings within these of their average (rad/s, m/s²) for so long (s) are at rest.
    Rest(double rate, double force, double after) : rate_(rate), force_(force), after_(after) {}

    bool found() const { return still_ >= after_; }
    // Variance of the rate of an interval, by axis.
    const Three &scatter() const { return scatter_; }

    // Means of an interval; the bias and its variances.
    void watch(const Three &rate, const Three &force, double elapsed, bool gap, const Three &bias,
               const Three &variance) {
        const double blend = watched_ && !gap ? -std::expm1(-elapsed / AVERAGE_S) : 1.0;
        watched_ = true;
        double rates = 0.0, forces = 0.0, beyond = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            mean_rate_[i] += blend * (rate[i] - mean_rate_[i]);
            mean_force_[i] += blend * (force[i] - mean_force_[i]);
            rates += square(rate[i] - mean_rate_[i]);
            forces += square(force[i] - mean_force_[i]);
            const double known = variance[i] + square(REST_RATE);
            beyond =
                std::max(beyond, square((rate[i] - bias[i]) / GATE_ONCE) / (known + scatter_[i]));
            // By differences of neighbours, in which a turn that begins counts once.
            const double step = 0.5 * square(rate[i] - before_[i]);
            scatter_[i] = blend == 1.0 ? 0.0 : scatter_[i] + blend * (step - scatter_[i]);
            before_[i] = rate[i];
            beyond =
                std::max(beyond, square((mean_rate_[i] - bias[i]) / GATE) / (known + scatter_[i]));
        }
        const bool quiet = !gap && rates < square(rate_) && forces < square(force_) && beyond < 1.0;
        still_ = quiet ? still_ + elapsed : 0.0;
    }

private:
    // Time over which readings are compared with their average.
    static constexpr double AVERAGE_S = 0.5;
    // A mean rate beyond this many deviations of the bias, of its own scatter and of what may still
    // turn is a slow turn; a single rate may lie somewhat farther out by chance.
    static constexpr double GATE = 4.0, GATE_ONCE = 6.0;

    double rate_, force_, after_, still_ = 0.0;
    bool watched_ = false;
    Three mean_rate_{}, mean_force_{}, scatter_{}, before_{};
};

}  // namespace motorcade::orientation
