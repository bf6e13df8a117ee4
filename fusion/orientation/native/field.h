// What a magnetometer tells of heading. The direction of the horizontal field is north but for
// disturbances, and those show in what does not depend on heading: the field's horizontal and
// vertical size against a reference that was steady while the sensor turned. The third component,
// which would turn north, is taken to be disturbed as much as these two.
//
// Laidig and Seel (VQF, 2023) reject by norm and dip; here the noise of the heading grows with the
// deviation instead. Magnetometers lag behind the gyro by some milliseconds, which turns north
// while the sensor turns: the lag is estimated from the same two components.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "speed.h"
#include "vectors.h"

namespace motorcade::orientation {

// An interval's heading by the field: the angle of the field from north, counter-clockwise.
struct Heading {
    bool known;
    double angle, noise, variance;  // noise is white, as if of independent intervals
    std::array<double, 2> lean;     // what a tilt about each axis of the world does to the angle
};

class Field {
public:
    Field(double disturbance, double disturbance_time)
        : least_(square(disturbance)), time_(disturbance_time) {}

    double lag() const { return lag_; }
    // How far the field is from its reference, as an angle of the heading.
    double deviation() const { return std::sqrt(deviation_); }
    bool recovered() const { return recovered_; }
    // Starts from a reference that was found before.
    void take_reference(const Field &other) {
        reference_ = steady_ = other.reference_;
        lag_ = other.lag_;
        felt_s_ = FIRST_S;
    }

    // The mean field of an interval in the axes of the world, what a lag of 1 s adds to it, whether
    // the sensor turns, and the variance of the tilt.
    Heading watch(const Three &mean, const Three &per_lag, bool turns, double tilt,
                  double elapsed) {
        Three field;
        for (std::size_t i = 0; i < 3; ++i) field[i] = mean[i] - lag_ * per_lag[i];
        const Sizes sizes{std::hypot(field[0], field[1]), field[2]};
        if (!(sizes[0] > 0.0)) return {};
        if (felt_s_ < FIRST_S && tilt > square(SETTLED_TILT)) felt_s_ = 0.0;
        if (felt_s_ == 0.0) reference_ = steady_ = sizes;
        felt_s_ += elapsed;
        find_lag(sizes, {(field[0] * per_lag[0] + field[1] * per_lag[1]) / sizes[0], per_lag[2]},
                 tilt, elapsed);
        const double now = square(distance(sizes, reference_) / reference_[0]);
        lately_ -= std::expm1(-elapsed / LATELY_S) * (now - lately_);
        deviation_ = std::max(now, lately_);
        keep_reference(sizes, turns, elapsed);
        const double dip = field[2] / square(sizes[0]);
        return {true,
                std::atan2(-field[0], field[1]),
                2.0 * (least_ * time_ + deviation_ * STAY_S) / elapsed,
                least_ + deviation_,
                {dip * field[0], dip * field[1]}};
    }

    // A residual of the heading, and its variance. Where the mean of some seconds lies far beyond,
    // the heading was found in a disturbed place: the residual that it then must be free to follow.
    double astray(double residual, double variance, double elapsed) {
        residual_ -= std::expm1(-elapsed / ASTRAY_S) * (residual - residual_);
        if (square(residual_) < square(ASTRAY_DEVIATIONS) * variance) return 0.0;
        recovered_ = true;
        return std::exchange(residual_, 0.0);
    }

private:
    using Sizes = std::array<double, 2>;  // horizontal, vertical

    // The field of the first seconds is averaged, once a tilt no longer takes it for another (2°);
    // later it is followed slowly.
    static constexpr double FIRST_S = 2.0, FOLLOW_S = 60.0, SETTLED_TILT = 0.035;
    // A place that disturbs the field does so for as long as one stays there.
    static constexpr double STAY_S = 10.0;
    // A disturbance that turns past its zero is still there.
    static constexpr double LATELY_S = 3.0;
    // A field that stays within a tenth while the sensor turns for this long belongs to the place,
    // not to the sensor (Laidig and Seel's figures).
    static constexpr double STEADY_S = 20.0, STEADY_SHARE = 0.1, STEADY_FOLLOW_S = 5.0;
    static constexpr double ASTRAY_S = 5.0, ASTRAY_DEVIATIONS = 4.0;
    // Magnetometers average over tens of milliseconds; fields differ by some percent within a
    // hand's motion, from a tenth of a second to the next.
    static constexpr double LAG = 0.02, LAG_SHARE = 0.05, LAG_S = 0.1;

    static double distance(const Sizes &a, const Sizes &b) {
        return std::hypot(a[0] - b[0], a[1] - b[1]);
    }

    void find_lag(const Sizes &sizes, const Sizes &per_lag, double tilt, double elapsed) {
        const double total = square(reference_[0]) + square(reference_[1]);
        const double noise =
            (total * (square(LAG_SHARE) + tilt) + square(distance(sizes, reference_))) * 2.0 *
            LAG_S / elapsed;
        for (std::size_t i = 0; i < 2; ++i) {
            const double gain =
                lag_variance_ * per_lag[i] / (square(per_lag[i]) * lag_variance_ + noise);
            lag_ += gain * (sizes[i] - reference_[i]);
            lag_variance_ -= gain * per_lag[i] * lag_variance_;
        }
    }

    void keep_reference(const Sizes &sizes, bool turns, double elapsed) {
        if (distance(sizes, steady_) < STEADY_SHARE * std::hypot(steady_[0], steady_[1])) {
            follow(steady_, sizes, -std::expm1(-elapsed / STEADY_FOLLOW_S));
            if (turns) steady_s_ += elapsed;
        } else {
            steady_ = sizes;
            steady_s_ = 0.0;
        }
        if (steady_s_ > STEADY_S &&
            distance(steady_, reference_) >
                0.5 * STEADY_SHARE * std::hypot(reference_[0], reference_[1])) {
            reference_ = steady_;
            steady_s_ = lately_ = 0.0;
        }
        const double weight = least_ / (least_ + deviation_);
        follow(reference_, sizes,
               felt_s_ < FIRST_S ? elapsed / felt_s_ : weight * elapsed / FOLLOW_S);
    }

    static void follow(Sizes &kept, const Sizes &now, double share) {
        for (std::size_t i = 0; i < 2; ++i) kept[i] += share * (now[i] - kept[i]);
    }

    double least_, time_;
    Sizes reference_{}, steady_{};
    double felt_s_ = 0.0, steady_s_ = 0.0, lately_ = 0.0, deviation_ = 0.0, residual_ = 0.0;
    double lag_ = 0.0, lag_variance_ = square(LAG);
    bool recovered_ = false;
};

}  // namespace motorcade::orientation
