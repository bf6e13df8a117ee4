// What a recording may have been, as the smoother tries it: where the path begins, which
// measurements have what weight, where the map was relocated. And how well each measurement is then
// predicted by all others, which is what one hypothesis is preferred to another by.

#pragma once

#include <cmath>
#include <utility>

#include "history.h"

namespace motorcade::filter {

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

    // Whether it explains more measurements of all, with as few jumps, and predicts none worse.
    bool explains_more(const Hypothesis &other, double refused) const {
        const auto explained = [](const Hypothesis &one) {
            return std::count(one.believed.begin(), one.believed.end(), true);
        };
        return doubts.size() <= other.doubts.size() && explained(*this) > explained(other) &&
               other.gain(*this, std::max(since, other.since)) <= refused;
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
