// Scans: a causal filter fed with stamped poses, one at a time or a whole path; and the smoother that
// runs a Kalman filter forward and the Rauch-Tung-Striebel recursion back. Poses are rows of versor
// coefficients, 8 of motors or 12 of similarities; stamps are nanoseconds. Both ways of feeding go
// through the same function, so that they agree to the last bit.

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "filters.h"
#include "kalman.h"

namespace motorcade::smooth {

class Scan {
public:
    virtual ~Scan() = default;
    virtual std::size_t pose_size() const = 0;
    // Throws std::invalid_argument, and then leaves the filter as it was, where a stamp does not
    // follow its predecessor or the result is no pose.
    virtual void update(const double *pose, std::int64_t time_ns, double *out) = 0;
    // Deviations of the next measurement in rad, m and scale, for filters that weigh them.
    virtual void measured_with(const BlockValues &deviations) = 0;
    virtual double log_likelihood() const = 0;
};

// Rows of noise deviations of N measurements: one row for all, or one each.
struct NoiseRows {
    const double *first = nullptr;
    std::size_t stride = 0;

    BlockValues row(std::size_t k) const {
        const double *at = first + k * stride;
        return {at[0], at[1], at[2]};
    }
};

template <class T>
concept WeighsNoise = requires(T method, BlockValues values) { method.measured_with(values); };

template <std::size_t N> void check_finite(const Vector<N> &pose) {
    double total = 0.0;
    for (const double one : pose) total += one * 0.0;
    if (total != 0.0) throw std::invalid_argument("pose: expected a finite result, got one beyond float64");
}

template <Representation R, class Method> class StreamOf final : public Scan {
public:
    explicit StreamOf(const Method &method) : method_(method) {}

    std::size_t pose_size() const override { return R::pose_size; }

    void update(const double *pose, std::int64_t time_ns, double *out) override {
        if (started_ && time_ns <= last_ns_)
            throw std::invalid_argument("time_ns: expected a stamp after " + std::to_string(last_ns_) + ", got " +
                                        std::to_string(time_ns));
        Vector<R::pose_size> given;
        std::copy_n(pose, R::pose_size, given.begin());
        Method next = method_;
        auto measured = R::read(given);
        if (started_) {
            measured = R::following(measured, measured_);
            next.step(measured, 1e-9 * static_cast<double>(time_ns - last_ns_));
        } else {
            next.start(measured);
        }
        const auto made = R::write(next.pose());
        check_finite(made);
        std::copy(made.begin(), made.end(), out);
        method_ = next;
        measured_ = measured;
        last_ns_ = time_ns;
        started_ = true;
    }

    void measured_with(const BlockValues &deviations) override {
        if constexpr (WeighsNoise<Method>) method_.measured_with(deviations);
    }

    double log_likelihood() const override {
        if constexpr (WeighsNoise<Method>) return method_.log_likelihood();
        return 0.0;
    }

private:
    Method method_;
    Vector<R::size> measured_{};
    std::int64_t last_ns_ = 0;
    bool started_ = false;
};

// What the smoother writes for N poses: poses (N, pose size), rates (N, order, freedom) and
// deviations (N, blocks, order + 1) in rad, m, scale and their rates.
struct Smoothed {
    double *poses, *rates, *deviations;
};

template <Representation R, std::size_t Order>
void write_state(const typename Kalman<R, Order>::State &state, std::size_t k, const Smoothed &out) {
    const auto pose = R::write(state.pose);
    check_finite(pose);
    std::copy(pose.begin(), pose.end(), out.poses + k * R::pose_size);
    double *rates = out.rates + k * Order * R::freedom;
    for (const auto &one : state.rates) rates = std::copy(one.begin(), one.end(), rates);
    double *deviations = out.deviations + k * R::ends.size() * (Order + 1);
    for (std::size_t b = 0; b < R::ends.size(); ++b)
        for (std::size_t i = 0; i <= Order; ++i)
            *deviations++ = std::sqrt(std::max(0.0, state.covariance[b][i][i])) / R::units[b];
}

// Returns the logarithm of the likelihood of the innovations. Holds one filtered state a pose.
template <Representation R, std::size_t Order>
double smooth(const double *poses, const std::int64_t *time_ns, std::size_t count, const NoiseRows &noise,
              const BlockValues &densities, const Smoothed &out) {
    std::vector<typename Kalman<R, Order>::State> states(count);
    Kalman<R, Order> filter(densities, noise.row(0));
    Vector<R::size> measured;
    const auto interval = [&](std::size_t k) { return 1e-9 * static_cast<double>(time_ns[k + 1] - time_ns[k]); };
    for (std::size_t k = 0; k < count; ++k) {
        Vector<R::pose_size> given;
        std::copy_n(poses + k * R::pose_size, R::pose_size, given.begin());
        const auto read = R::read(given);
        if (k == 0) {
            filter.start(measured = read);
        } else {
            measured = R::following(read, measured);
            if (k == 1) {
                filter.open_rates(measured, interval(0));
                states[0] = filter.state();
            }
            filter.measured_with(noise.row(k));
            filter.step(measured, interval(k - 1));
        }
        states[k] = filter.state();
    }
    write_state<R, Order>(states[count - 1], count - 1, out);
    for (std::size_t k = count - 1; k-- > 0;) {
        states[k] = filter.smoothed(states[k], states[k + 1], interval(k));
        write_state<R, Order>(states[k], k, out);
    }
    return filter.log_likelihood();
}

}  // namespace motorcade::smooth
