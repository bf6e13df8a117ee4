// Going back: doing things again from a state that was kept, giving a prediction up where what is
// measured denies it, and forgetting what is too old to be asked for.

#pragma once

#include "timeline.h"

namespace motorcade::filter {

// After so many times the patience it is no longer the start that is doubted, but all that is
// known.
constexpr std::size_t long_patience = 4;

// Does events [from, to) again, from the nearest state kept before them.
template <std::size_t N> void Timeline<N>::replay(std::size_t from, std::size_t to) {
    std::size_t first = 0;
    if (from == 0) {
        started_ = false;
        streak_.clear();
    } else {
        std::size_t kept = from - 1;
        while (!events_[kept].known) --kept;
        now_ = events_[kept].known->after;
        unpack(events_[kept].known->covariance, p_);
        seek(events_[kept].time_ns);
        first = kept + 1;
        streak_.clear();
        for (std::size_t k = first; k-- > 0;) {
            if (!events_[k].measures()) continue;
            if (events_[k].factor > 0.0 || k == 0) break;
            streak_.push_front(k);
        }
        while (streak_.size() > settings_.patience) streak_.pop_front();
    }
    for (std::size_t k = first; k < to; ++k) process(k);
}

// So many measurements in a row denied the prediction: would they agree with each other, had it
// been given up at the first of them? Then it is, from there on; the start itself where nothing
// else had been believed yet. Otherwise all is done again as it was.
template <std::size_t N> void Timeline<N>::reopen() {
    const std::deque<std::size_t> denied = streak_;
    const std::size_t first = denied.front();
    std::size_t target = first, far = long_patience * settings_.patience;
    while (target > 1 && far > 0 &&
           !(events_[target - 1].measures() && events_[target - 1].factor > 0.0))
        --target, --far;
    target = target == 1 && !forgotten_ ? 0 : first;
    const Event &witness = events_[first];
    double turned = 0.0, shifted = 0.0;
    for (std::size_t a = 0; a < witness.size; ++a)
        (witness.size == 6 && a < 3 ? turned : shifted) += witness.linear[a] * witness.linear[a];
    const bool fast = witness.kind == Kind::velocity,
               seen = witness.kind == Kind::corners || witness.kind == Kind::sourced;
    Event &given_up = events_[target];
    given_up.doubt = std::make_unique<Doubt>();
    const std::array<double, 5> &start = settings_.start_sigma;
    const double share = far == 0 ? 1.0 : 0.01;
    const double room[5] = {seen ? 1.0 : turned,
                            seen   ? 1.0
                            : fast ? 0.0
                                   : shifted,
                            shifted + share * start[2] * start[2], share * start[3] * start[3],
                            share * start[4] * start[4]};
    std::copy_n(room, 5, given_up.doubt->added);
    if (target == 0 && witness.size == 6 && witness.kind == given_up.kind)
        std::copy_n(witness.linear.begin(), 6, given_up.doubt->restart);
    replay(target, next_);

    std::size_t agree = 0;
    for (const std::size_t k : denied) agree += events_[k].factor == 1.0;
    if (2 * agree > denied.size()) {
        ++reopened_;
        return;
    }
    given_up.doubt.reset();
    replay(target, next_);
    streak_.pop_front();
}

template <std::size_t N> void Timeline<N>::doubt(const Doubt &doubt) {
    for (std::size_t k = 0; k < 15; ++k) p_.row[k][k] += doubt.added[k / 3];
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

// What the backward pass needs of a measurement, after its residual.
template <std::size_t N>
void Timeline<N>::keep_linear(Event &event, const Innovation<N> &innovation, const Gain<N> &gain) {
    const std::size_t m = innovation.size;
    event.linear.resize(m * (1 + 2 * N + m));
    double *to = event.linear.data() + m;
    for (std::size_t a = 0; a < m; ++a, to += N) std::copy_n(innovation.effect[a], N, to);
    for (std::size_t a = 0; a < m; ++a, to += N) std::copy_n(gain.gain[a], N, to);
    for (std::size_t a = 0; a < m; ++a, to += m) std::copy_n(gain.inverse[a], m, to);
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
            if (!streak_.empty() && streak_.front() <= 1) streak_.pop_front();
            for (std::size_t &k : streak_) --k;
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
    double effect[6][N] = {}, by_pose[36], spread[6][N];
    motorcade_pose_effect(now_.imu_T_camera, by_pose);
    for (std::size_t a = 0; a < 6; ++a) {
        std::copy_n(by_pose + 6 * a, 6, effect[a]);
        if constexpr (N > 15) effect[a][extrinsics + a] = 1.0;
        std::fill_n(spread[a], N, 0.0);
        for (std::size_t k = 0; k < N; ++k) filter::add<N>(spread[a], effect[a][k], p.row[k]);
    }
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) {
            double &seen = sink.covariance[36 * row + 6 * a + b];
            seen = 0.0;
            for (std::size_t k = 0; k < N; ++k) seen += spread[a][k] * effect[b][k];
        }
    std::copy_n(now_.pose, 8, sink.pose + 8 * row);
    std::copy_n(now_.velocity, 3, sink.velocity + 3 * row);
    std::copy_n(now_.bias, 6, sink.bias + 6 * row);
    double *others = sink.others + 13 * row;
    std::copy_n(now_.gravity_rotor, 4, others);
    std::copy_n(now_.imu_T_camera, 8, others + 4);
    others[12] = now_.delay_s;
}

}  // namespace motorcade::filter
