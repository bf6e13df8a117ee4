// Scans: a causal filter fed with stamped poses, one at a time or a whole path; and the smoother
// that runs a Kalman filter forward and the Rauch-Tung-Striebel recursion back. Poses are rows of
// versor coefficients, 8 of motors or 12 of similarities; stamps are nanoseconds. Both ways of
// feeding go through the same function, so that they agree to the last bit.

#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

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
concept WeighsNoise = requires(T method, BlockValues values) {
    method.measured_with(values);
};

template <std::size_t N> void check_finite(const Vector<N> &pose) {
    double total = 0.0;
    for (const double one : pose) total += one * 0.0;
    if (total != 0.0)
        throw std::invalid_argument("pose: expected a finite result, got one beyond float64");
}

template <Representation R, class Method> class StreamOf final : public Scan {
public:
    explicit StreamOf(const Method &method) : method_(method) {}

    std::size_t pose_size() const override { return R::pose_size; }

    void update(const double *pose, std::int64_t time_ns, double *out) override {
        if (started_ && time_ns <= last_ns_)
            throw std::invalid_argument("time_ns: expected a stamp after " +
                                        std::to_string(last_ns_) + ", got " +
                                        std::to_string(time_ns));
        Vector<R::pose_size> given;
        std::copy_n(pose, R::pose_size, given.begin());
        Method next = method_;
        auto measured = R::read(given);
        if (started_) {
            measured = R::continued(measured, measured_);
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

// What the smoother writes for N poses: poses (N, pose size) and, unless they are null, rates
// (N, order, freedom) and deviations (N, blocks, order + 1) in rad, m, scale and their rates.
struct Smoothed {
    double *poses, *rates, *deviations;
};

template <Representation R, std::size_t Order, class State>
void write_state(const State &state, std::size_t k, const Smoothed &out) {
    const auto pose = R::write(projected<R>(state.pose));
    check_finite(pose);
    std::copy(pose.begin(), pose.end(), out.poses + k * R::pose_size);
    if constexpr (requires { state.variance(0, 0); }) {
        double *rates = out.rates + k * Order * R::freedom;
        for (const auto &one : state.rates) rates = std::copy(one.begin(), one.end(), rates);
        double *deviations = out.deviations + k * R::ends.size() * (Order + 1);
        for (std::size_t b = 0, first = 0; b < R::ends.size(); first = R::ends[b++])
            for (std::size_t i = 0; i <= Order; ++i) {
                double total = 0.0;
                for (std::size_t component = first; component < R::ends[b]; ++component)
                    total += state.variance(component, i);
                const double mean = total / static_cast<double>(R::ends[b] - first);
                *deviations++ = std::sqrt(std::max(0.0, mean)) / R::units[b];
            }
    }
}

// Runs a Kalman filter over a path, and back over it with the smoother. Filtered means are kept,
// their spreads a segment at a time and found again from the one before the segment, so that memory
// does not grow with them. `write` is called for each pose from the last to the first. In lanes it
// runs over as many paths, each `stride` poses behind the one before.
template <class R, std::size_t Order> class Smoother {
public:
    using Filter = Kalman<R, Order>;

    Smoother(const double *poses, const std::int64_t *time_ns, std::size_t count,
             const NoiseRows &noise, const BlockValues &densities, std::size_t stride = 0)
        : poses_(poses), time_ns_(time_ns), count_(count), stride_(stride), noise_(noise),
          filter_(densities, noise.row(0)) {}

    // `seen(filter, k)` is called on the way forward, and ends it all by false.
    template <bool WITH_COVARIANCE, class Seen, class Write> bool run(Seen &&seen, Write &&write) {
        std::vector<Spread> marks;
        std::vector<Mean> means;
        marks.reserve(count_ / SEGMENT + 1);
        means.reserve(count_);
        for (std::size_t k = 0; k < count_; ++k) {
            advance(k);
            means.push_back(filter_.state());
            if (k % SEGMENT == 0) marks.push_back(filter_.state());
            if (!seen(filter_, k)) return false;
        }
        typename Filter::template Smoothed<WITH_COVARIANCE> later = filter_.state();
        write(later, count_ - 1);
        std::vector<Spread> predicted(SEGMENT);
        for (std::size_t mark = marks.size(); mark-- > 0;) {
            const std::size_t first = mark * SEGMENT, last = std::min(first + SEGMENT, count_ - 1);
            for (std::size_t k = first; k < last; ++k) {
                Spread &spread = predicted[k - first];
                spread = k == first ? marks[mark] : predicted[k - 1 - first];
                if (k > first) measure(spread, k);
                filter_.predict(spread, means[k], interval(k));
            }
            for (std::size_t k = last; k-- > first;) {
                const auto filtered = [&] {
                    if (k == first) return marks[mark];
                    Spread spread = predicted[k - 1 - first];
                    measure(spread, k);
                    return spread;
                };
                later = filter_.template smoothed<WITH_COVARIANCE>(means[k], predicted[k - first],
                                                                   filtered, later, interval(k));
                write(later, k);
            }
        }
        return true;
    }

private:
    using Real = typename Filter::Real;
    using Mean = typename Filter::Mean;
    using Spread = typename Filter::Spread;
    static constexpr std::size_t SEGMENT = 64;

    void measure(Spread &spread, std::size_t k) {
        filter_.measured_with(noise(k));
        filter_.measure(spread);
    }

    Real interval(std::size_t k) const {
        Real made;
        for (std::size_t at = 0; at < LANES<Real>; ++at, k += stride_)
            lane(made, at) = 1e-9 * static_cast<double>(time_ns_[k + 1] - time_ns_[k]);
        return made;
    }

    Vector<3, Real> noise(std::size_t k) const {
        Vector<3, Real> made;
        for (std::size_t at = 0; at < LANES<Real>; ++at, k += stride_)
            for (std::size_t b = 0; b < 3; ++b) lane(made[b], at) = noise_.row(k)[b];
        return made;
    }

    Vector<R::size, Real> read(std::size_t k) const {
        Vector<R::pose_size, Real> given;
        for (std::size_t at = 0; at < LANES<Real>; ++at)
            for (std::size_t c = 0; c < R::pose_size; ++c)
                lane(given[c], at) = poses_[(k + at * stride_) * R::pose_size + c];
        const auto made = R::read(given);
        return k == 0 ? made : R::continued(made, last_);
    }

    void advance(std::size_t k) {
        last_ = read(k);
        if (k == 0) {
            filter_.start(last_);
            if (count_ == 1) return;
            filter_.measured_with(noise(1));
            filter_.open_rates(read(1), interval(0));
            return;
        }
        filter_.measured_with(noise(k));
        filter_.step(last_, interval(k - 1));
    }

    const double *poses_;
    const std::int64_t *time_ns_;
    std::size_t count_, stride_;
    NoiseRows noise_;
    Filter filter_;
    Vector<R::size, Real> last_{};
};

// Smooths a path cut into as many parts as there are lanes, side by side. A part begins, either
// way, WARM_UP poses ahead of where it is written, with nothing known; false where that is too few
// for neighbours to agree where they meet, as at the path's whole length.
template <Representation R, std::size_t Order>
bool smooth_in_lanes(const double *poses, const std::int64_t *time_ns, std::size_t count,
                     const NoiseRows &noise, const BlockValues &densities, const Smoothed &out) {
    constexpr std::size_t PARTS = Lanes::COUNT, WARM_UP = 256, SEAM = 8;
    constexpr double ROUNDING = 1e-14, SPREAD = 1e-13;
    if (count < (PARTS + 2) * 2 * WARM_UP) return false;
    const std::size_t part = (count - 2 * WARM_UP) / PARTS, end = WARM_UP + part;
    Smoother<InLanes<R>, Order> smoother(poses, time_ns, count - (PARTS - 1) * part, noise,
                                         densities, part);
    std::array<Lanes, R::freedom *(Order + 1)> begun;
    const auto seen = [&](const auto &filter, std::size_t k) {
        bool agreed = true;
        if (k == WARM_UP || k == end)
            for (std::size_t c = 0; c < begun.size(); ++c) {
                Lanes variance = filter.state().variance(c % R::freedom, c / R::freedom);
                for (std::size_t at = 1; k == end && at < PARTS; ++at)
                    agreed &=
                        std::abs(lane(variance, at - 1) - begun[c][at]) <= SPREAD * begun[c][at];
                begun[c] = variance;
            }
        return agreed;
    };
    bool agreed = true;
    const auto write = [&](const auto &state, std::size_t k) {
        for (std::size_t at = 0; at < PARTS; ++at) {
            if ((k < WARM_UP && at > 0) || (k >= end + SEAM && at + 1 < PARTS)) continue;
            const auto pose = R::write(projected<R>(InLanes<R>::one_of(state.pose, at)));
            double *to = out.poses + (k + at * part) * R::pose_size;
            const bool seam = at > 0 && k < WARM_UP + SEAM;
            double off = 0.0, size = 0.0;
            for (std::size_t c = 0; c < R::pose_size; ++c) {
                if (seam) off += std::abs(pose[c] - to[c]);
                size += std::abs(to[c] = pose[c]);
            }
            agreed &= off <= ROUNDING * size;
        }
    };
    return smoother.template run<false>(seen, write) && agreed;
}

// Returns the logarithm of the likelihood of the innovations, of poses alone NaN.
template <Representation R, std::size_t Order>
double smooth(const double *poses, const std::int64_t *time_ns, std::size_t count,
              const NoiseRows &noise, const BlockValues &densities, const Smoothed &out) {
    double log_likelihood = std::numeric_limits<double>::quiet_NaN();
    // Of others than rigid motors and rotors it would cost the compiler more than it saves.
    if constexpr (R::coupled > 0 && R::freedom == 6)
        if (out.rates == nullptr &&
            smooth_in_lanes<R, Order>(poses, time_ns, count, noise, densities, out))
            return log_likelihood;
    Smoother<R, Order> smoother(poses, time_ns, count, noise, densities);
    const auto seen = [&](const auto &filter, std::size_t) {
        log_likelihood = filter.log_likelihood();
        return true;
    };
    const auto write = [&](const auto &state, std::size_t k) {
        write_state<R, Order>(state, k, out);
    };
    out.rates == nullptr ? smoother.template run<false>(seen, write)
                         : smoother.template run<true>(seen, write);
    return log_likelihood;
}

}  // namespace motorcade::smooth
