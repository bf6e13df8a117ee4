// Inertial data in the order of time: live ones are kept here and forgotten in their turn, those of
// a whole recording stay where the caller holds them, for they are the most that a filter has to
// hold.

#pragma once

#include <algorithm>
#include <deque>

#include "state.h"

namespace motorcade::filter {

struct Sample {
    std::int64_t time_ns;
    Reading read;
};

class Samples {
public:
    // Takes columns of `count` samples, which must outlive this; none is seen before `show`.
    void hold(const std::int64_t *time_ns, const double *rate, const double *force,
              std::size_t count) {
        time_ns_ = time_ns, rate_ = rate, force_ = force, held_ = count;
    }

    // All of those held before a moment, and the first from it on, are seen; false where all were.
    bool show_until(std::int64_t time_ns) {
        if (seen_ == held_) return false;
        while (++seen_ < held_ && time_ns_[seen_ - 1] < time_ns) {
        }
        return true;
    }

    // The next of those held becomes the last one seen; false where none is left.
    bool show() {
        if (seen_ == held_) return false;
        ++seen_;
        return true;
    }

    void push_back(const Sample &sample) { own_.push_back(sample); }
    void pop_front() { own_.pop_front(); }
    bool empty() const { return size() == 0; }
    std::size_t size() const { return time_ns_ == nullptr ? own_.size() : seen_; }

    Sample operator[](std::size_t k) const {
        if (time_ns_ == nullptr) return own_[k];
        Sample made;
        made.time_ns = time_ns_[k];
        std::copy_n(rate_ + 3 * k, 3, made.read.rate);
        std::copy_n(force_ + 3 * k, 3, made.read.force);
        return made;
    }

    Sample front() const { return (*this)[0]; }
    Sample back() const { return (*this)[size() - 1]; }

    // Index of the first sample after a moment.
    std::size_t after(std::int64_t time_ns) const {
        std::size_t low = 0, high = size();
        while (low < high) {
            const std::size_t middle = low + (high - low) / 2;
            const std::int64_t there =
                time_ns_ == nullptr ? own_[middle].time_ns : time_ns_[middle];
            if (time_ns < there)
                high = middle;
            else
                low = middle + 1;
        }
        return low;
    }

private:
    std::deque<Sample> own_;
    const std::int64_t *time_ns_ = nullptr;
    const double *rate_ = nullptr, *force_ = nullptr;
    std::size_t held_ = 0, seen_ = 0;
};

}  // namespace motorcade::filter
