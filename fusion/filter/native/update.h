// A measurement is predicted, weighed, and taken in.

#pragma once

#include "bend.h"
#include "timeline.h"

namespace motorcade::filter {

template <std::size_t N> void Timeline<N>::measure(Event &event) {
    Innovation<N> innovation;
    Gain<N> gain;
    if (event.doubt) make_room(event, *event.doubt);
    event.factor = 0.0;
    event.bent = false;
    event.nis = std::nan("");
    event.linear.reset();
    const bool predicted = predict(event, innovation) && weigh(p_, innovation, 1.0, gain);
    event.size = static_cast<std::uint8_t>(innovation.size);
    if (!predicted) return;
    tells(event, innovation);
    event.nis = gain.nis;
    event.factor = event.given;
    if (event.given == undecided) {
        const bool within = gain.nis <= settings_.gate[innovation.size];
        if (!within) weigh(p_, innovation, settings_.most_noise, gain);
        event.factor = factor_of(event.nis, gain.nis, innovation.size);
    }
    if (event.factor != 1.0) weigh(p_, innovation, std::max(1.0, event.factor), gain);
    event.bent = innovation.bent;
    if (thorough_) keep_linear(event, innovation, gain);
    if (event.factor > 0.0) apply(innovation, gain);
}

template <std::size_t N> bool Timeline<N>::predict(const Event &event, Innovation<N> &made) const {
    const Reading read = reading(time_ns_);
    if (!Prediction<N>(now_, read).of(event, made)) return false;
    allow_for_bend(now_, read, event, p_, made);
    return true;
}

// From three numbers on that depend on the position, and on no earlier one.
template <std::size_t N> void Timeline<N>::tells(Event &event, const Innovation<N> &innovation) {
    std::size_t rows = 0;
    event.relative = false;
    for (std::size_t a = 0; a < innovation.size; ++a) {
        const double *effect = innovation.effect[a];
        const auto any = [effect](std::size_t from, std::size_t to) {
            return std::any_of(effect + from, effect + to, [](double x) { return x != 0.0; });
        };
        rows += any(position, velocity);
        if constexpr (N > earlier) event.relative |= any(earlier, N);
    }
    event.placed = rows >= 3 && !event.relative;
}

template <std::size_t N>
void Timeline<N>::apply(const Innovation<N> &innovation, const Gain<N> &gain) {
    const std::size_t m = innovation.size;
    double error[N] = {};
    for (std::size_t a = 0; a < m; ++a) filter::add<N>(error, innovation.residual[a], gain.gain[a]);
    update(p_, innovation, gain);
    correct<N>(now_, error);
    if (innovation.bent) rebase(p_, error);
}

}  // namespace motorcade::filter
