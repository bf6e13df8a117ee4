// Rest, told from inertial data: over a window nothing turns beyond the gyroscope's bias, the force
// is that of gravity, and both stay as they are. What rests has no velocity, which is a
// measurement.

#pragma once

#include <array>
#include <deque>

#include "timeline.h"

namespace motorcade::filter {

class Rest {
public:
    static constexpr std::size_t number =
        static_cast<std::size_t>(-1);  // of measurements made here

    // Window (s; 0: never), limits of rate (rad/s) and force (m/s²), deviation of the velocity
    // (m/s) and the least time between two measurements (s).
    explicit Rest(const std::array<double, 5> &given)
        : window_ns_(ns(given[0])), rate_(given[1]), force_(given[2]), sigma_(given[3]),
          period_ns_(ns(given[4])) {}

    bool wanted() const { return window_ns_ > 0; }

    std::array<double, 12> measurement() const {
        const double square = sigma_ * sigma_;
        return {0.0, 0.0, 0.0, square, 0.0, 0.0, 0.0, square, 0.0, 0.0, 0.0, square};
    }

    // Takes a sample; whether the sensor rests and it is time to say so.
    bool found(const Sample &sample, const State &state, double gravity_m_s2) {
        held_.push_back(sample);
        while (held_.size() > 2 && held_[1].time_ns <= sample.time_ns - window_ns_)
            held_.pop_front();
        if (sample.time_ns - held_.front().time_ns < window_ns_ ||
            sample.time_ns - last_ns_ < period_ns_)
            return false;
        double rate[3] = {}, force[3] = {};
        for (const Sample &one : held_)
            for (int i = 0; i < 3; ++i) {
                rate[i] += one.read.rate[i] / static_cast<double>(held_.size());
                force[i] += one.read.force[i] / static_cast<double>(held_.size());
            }
        double size = 0.0;
        for (int i = 0; i < 3; ++i) {
            if (std::abs(rate[i] - state.bias[i]) > rate_) return false;
            size += (force[i] - state.bias[3 + i]) * (force[i] - state.bias[3 + i]);
        }
        if (std::abs(std::sqrt(size) - gravity_m_s2) > force_) return false;
        for (const Sample &one : held_)
            for (int i = 0; i < 3; ++i)
                if (std::abs(one.read.rate[i] - rate[i]) > rate_ ||
                    std::abs(one.read.force[i] - force[i]) > force_)
                    return false;
        last_ns_ = sample.time_ns;
        return true;
    }

private:
    static std::int64_t ns(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

    std::int64_t window_ns_;
    double rate_, force_, sigma_;
    std::int64_t period_ns_, last_ns_ = INT64_MIN / 2;
    std::deque<Sample> held_;
};

}  // namespace motorcade::filter
