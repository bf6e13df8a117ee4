// What a recording may have been, as the smoother tries it: where the path begins, which
// measurements have what weight, where the map was relocated. And how well each measurement is then
// predicted by all others, which is what one hypothesis is preferred to another by.

#pragma once

#include <cmath>
#include <utility>

#include "candidates.h"

namespace motorcade::filter {

// Going back: doing things again from a state that was kept, writing the path, and forgetting what
// is too old to be asked for.

// Does events [from, to) again, from the nearest state kept before them.
template <std::size_t N> void Timeline<N>::replay(std::size_t from, std::size_t to) {
    std::size_t first = 0;
    if (from <= begin_) {
        started_ = false;
    } else {
        std::size_t kept = from - 1;
        while (!events_[kept].known) --kept;
        now_ = events_[kept].known->after;
        unpack(events_[kept].known->covariance, p_);
        seek(events_[kept].time_ns);
        first = kept + 1;
    }
    for (std::size_t k = first; k < to; ++k) process(k);
}

// The pose becomes the earlier one too, with its uncertainty (S. I. Roumeliotis, J. W. Burdick,
// Stochastic cloning, ICRA 2002).
template <std::size_t N> void Timeline<N>::keep_pose() {
    if constexpr (N > earlier) {
        std::copy_n(now_.pose, 8, now_.earlier);
        for (std::size_t i = 0; i < 6; ++i) std::copy_n(p_.row[i], N, p_.row[earlier + i]);
        for (std::size_t k = 0; k < N; ++k) std::copy_n(p_.row[k], 6, p_.row[k] + earlier);
    }
}

// What the backward pass needs of a measurement.
template <std::size_t N>
void Timeline<N>::keep_linear(Event &event, const Innovation<N> &innovation, const Gain<N> &gain) {
    const std::size_t m = innovation.size;
    event.linear.reset(new double[m * (1 + 2 * N + 2 * m)]);
    double *to = std::copy_n(innovation.residual, m, event.linear.get());
    for (std::size_t a = 0; a < m; ++a, to += N) std::copy_n(innovation.effect[a], N, to);
    for (std::size_t a = 0; a < m; ++a, to += N) std::copy_n(gain.gain[a], N, to);
    for (std::size_t a = 0; a < m; ++a, to += m) std::copy_n(gain.inverse[a], m, to);
    for (std::size_t a = 0; a < m; ++a, to += m) std::copy_n(innovation.noise[a], m, to);
}

// Keeps the state at the last sample, and lets go of what lies farther back than the history.
template <std::size_t N> void Timeline<N>::keep_and_forget() {
    unchecked_ = 0;
    std::int64_t oldest = samples_.back().time_ns - settings_.history_ns;
    if (started_) {
        Event check;
        check.time_ns = check.stamp_ns = time_ns_;
        events_.insert(events_.begin() + static_cast<std::ptrdiff_t>(next_), std::move(check));
        process(next_++);
        while (next_ > 2 && events_[1].time_ns <= oldest && events_[1].known) {
            events_.pop_front();
            --next_;
            forgotten_ = true;
            shift_candidates(1, -1);
        }
        oldest = events_.front().time_ns;
    }
    while (samples_.size() > 2 && samples_[1].time_ns <= oldest) {
        samples_.pop_front();
        if (started_) --sample_;
    }
}

template <std::size_t N> void Timeline<N>::write(Event &event) {
    if (sink.pose == nullptr || (event.judged && !sink.final)) return;
    put(event.number, p_);
}

// Row of the sink: the state, the covariance p and what that makes of the camera's pose.
template <std::size_t N> void Timeline<N>::put(std::size_t row, const Matrix<N> &p) const {
    if (sink.whole != nullptr)
        for (std::size_t i = 0; i < sink.size; ++i)
            std::copy_n(p.row[i], sink.size, sink.whole + (sink.size * row + i) * sink.size);
    double effect[36], spread[6][N] = {}, across[N][6], seen[36] = {};
    motorcade_pose_effect(now_.imu_T_camera, effect);
    for (std::size_t a = 0; a < 6; ++a) {
        for (std::size_t k = 0; k < 6; ++k) filter::add<N>(spread[a], effect[6 * a + k], p.row[k]);
        if constexpr (N > 15) filter::add<N>(spread[a], 1.0, p.row[extrinsics + a]);
        for (std::size_t k = 0; k < N; ++k) across[k][a] = spread[a][k];
    }
    for (std::size_t b = 0; b < 6; ++b) {
        for (std::size_t k = 0; k < 6; ++k)
            filter::add<6>(seen + 6 * b, effect[6 * b + k], across[k]);
        if constexpr (N > 15) filter::add<6>(seen + 6 * b, 1.0, across[extrinsics + b]);
    }
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) sink.covariance[36 * row + 6 * a + b] = seen[6 * b + a];
    std::copy_n(now_.pose, 8, sink.pose + 8 * row);
    std::copy_n(now_.velocity, 3, sink.velocity + 3 * row);
    std::copy_n(now_.bias, 6, sink.bias + 6 * row);
    double *others = sink.others + 13 * row;
    std::copy_n(now_.gravity_rotor, 4, others);
    std::copy_n(now_.imu_T_camera, 8, others + 4);
    others[12] = now_.delay_s;
}

constexpr double most_cost = 1e3;  // of a prediction that is no number

// What a prediction costs that is off by a normalised square: as little of a gross one as of a
// Student's distribution, so that no unit of the noise is needed.
inline double prediction_cost(double square, double freedom) {
    return std::isfinite(square) ? std::log1p(std::max(0.0, square) / freedom) : most_cost;
}

// In refused poses, what a span that is wrong together costs, for a motion there and one back, and
// what a jump of the map does, which lasts.
constexpr double span_price = 2.0, jump_price = 4.0;
// Of a denied pose besides: wrong ones are the fewer.
constexpr double fewer = 0.05;
// So few denied poses may cost less together than alone.
constexpr std::size_t fewest_together = 3;
// A step explains at most half its normalised square of log likelihood; costs are sixths of that.
constexpr double squares_a_cost = 12.0;
constexpr Doubt anew{false, true};

template <std::size_t N> struct Hypothesis {
    std::size_t begin = 0;  // of the events
    std::optional<State> begun;
    std::vector<double> given;  // of the events
    std::vector<bool> apart, believed;
    std::vector<std::pair<std::size_t, Doubt>> doubts;
    Track<N> first;
    double cost = 0.0;          // of all measurements
    std::size_t explained = 0;  // so many of them
};

}  // namespace motorcade::filter
