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

template <std::size_t N> struct Hypothesis {
    std::size_t begin = 0, since = 0;  // of the events; before `since` all is taken for wrong
    std::optional<State> begun;
    std::vector<double> given, cost;  // of the events
    std::vector<bool> believed, apart;
    bool bridged = false;  // the IMU alone leads from where it begins to the first pose
    std::vector<std::pair<std::size_t, Doubt>> doubts;
    Track<N> first;

    // Whether an event counts beside another hypothesis: what is apart by either says nothing.
    bool counts(const Hypothesis &other, std::size_t k) const {
        return !apart[k] && !other.apart[k];
    }

    // By how much it predicts better what was measured from an event on.
    double gain(const Hypothesis &other, std::size_t from) const {
        double sum = 0.0;
        for (std::size_t k = from; k < cost.size(); ++k)
            if (counts(other, k)) sum += other.cost[k] - cost[k];
        return sum;
    }

    // By how many measurements from an event on it explains more.
    std::ptrdiff_t more_explained(const Hypothesis &other, std::size_t from) const {
        std::ptrdiff_t more = 0;
        for (std::size_t k = from; k < cost.size(); ++k)
            if (counts(other, k)) more += believed[k] - other.believed[k];
        return more;
    }

    // Whether it explains fewer measurements from an event on, and predicts them worse by more than
    // one of them.
    bool loses(const Hypothesis &other, std::size_t from, double refused) const {
        return more_explained(other, from) < 0 && other.gain(*this, from) > refused;
    }

    // How many measurements it explains.
    std::ptrdiff_t explained() const { return std::count(believed.begin(), believed.end(), true); }

    // What all measurements cost beside another hypothesis. Denied ones in a row may be wrong
    // together, as on a map of their own: they cost no more then than where the other believes
    // them, as far as these may be good, and two refused poses; a jump of the map four.
    double total(const Hypothesis &other, double refused, double good) const {
        double sum = 4.0 * refused * static_cast<double>(doubts.size()), alone = 0.0,
               together = 2.0 * refused;
        for (std::size_t k = 0; k < cost.size(); ++k) {
            if (believed[k]) {
                sum += cost[k] + std::min(alone, together);
                alone = 0.0, together = 2.0 * refused;
            } else {
                alone += cost[k];
                if (other.believed[k]) together += std::min(other.cost[k], good);
            }
        }
        return sum + std::min(alone, together);
    }

    // Whether this later start, or with more apart, is to be preferred: never with more jumps of
    // the map; with as many, where all is predicted better although poses before it count as wrong,
    // or no worse with less apart; with fewer, where those after it are, or are no worse where what
    // came before them is known without.
    bool better(const Hypothesis &other, double refused) const {
        if (doubts.size() > other.doubts.size()) return false;
        if (doubts.size() == other.doubts.size()) {
            const double more = gain(other, other.since);
            const auto some = [](const Hypothesis &one) {
                return std::count(one.apart.begin(), one.apart.end(), true);
            };
            return more > refused || (more > -refused && some(*this) < some(other));
        }
        const std::size_t both = std::max(since, other.since);
        return bridged ? !loses(other, both, refused) : gain(other, both) > refused;
    }
};

}  // namespace motorcade::filter
