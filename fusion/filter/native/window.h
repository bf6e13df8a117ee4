// Estimates that look ahead by a fixed time: between the filter, which looks ahead by none, and the
// smoother, which looks ahead to the end. What became due, because so much time has passed since,
// is settled: moments asked for are written as all measurements up to then make them, and
// measurements keep the weight that these gave them. Until then they are judged anew with every
// measurement that comes, as the smoother does. The backward pass over the window is exact; no
// state of the past is part of the filter's.

#pragma once

#include <optional>

#include "smoother.h"

namespace motorcade::filter {

// Settled measurements whose residuals still tell the unit of distances, besides those of the
// window: the median of a hundred is known to about a tenth.
constexpr std::size_t most_heard = 100;

template <std::size_t N> class Filter final : public Smoother<N> {
public:
    Filter(const Settings &settings, const State &first) : Smoother<N>(settings, first) {
        this->thorough_ = settings.lag_ns > 0;
    }

    // Rewrites what the sink holds by all that was measured, as far as it is not settled.
    void smooth() {
        if (this->due_ == 0) return Smoother<N>::smooth();
        this->doubt_last_jump(this->due_);
        settle(this->next_);
    }

    // The state at a moment within the window, by all that was measured so far.
    std::optional<Track<N>> at(std::int64_t time_ns) {
        std::size_t first = this->next_;
        while (first > 0 && this->events_[first - 1].time_ns > time_ns) --first;
        if (first == 0 || first < this->due_ || !this->events_[first - 1].known)
            return std::nullopt;
        const Kept own(*this);
        Matrix<N> curvature;
        double gradient[N] = {};
        for (std::size_t k = this->next_; k-- > first;) {
            this->look_back(k, gradient, curvature);
            if (k > first)
                this->step_back(this->events_[k - 1], this->events_[k].time_ns, gradient,
                                curvature);
        }
        const Known &before = *this->events_[first - 1].known;
        Track<N> made;
        this->now_ = before.after;
        unpack(before.covariance, this->p_);
        this->seek(this->events_[first - 1].time_ns);
        this->advance_to(time_ns);
        made.at = this->now_, made.covariance = this->p_, made.time_ns = time_ns;
        if (first == this->next_) return made;
        this->step_back(this->events_[first].time_ns, gradient, curvature);
        double error[N] = {};
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t k = 0; k < N; ++k) error[i] -= made.covariance.row[i][k] * gradient[k];
        correct<N>(made.at, error);
        shrink(made.covariance, curvature);
        return made;
    }

private:
    // What the backward pass uses for itself, put back at the end.
    struct Kept {
        explicit Kept(Filter &of)
            : filter(of), at(of.now_), p(of.p_), time_ns(of.time_ns_), sample(of.sample_) {}
        Kept(const Kept &) = delete;
        Kept &operator=(const Kept &) = delete;
        ~Kept() {
            filter.now_ = at, filter.p_ = p, filter.time_ns_ = time_ns, filter.sample_ = sample;
        }
        Filter &filter;
        const State at;
        const Matrix<N> p;
        const std::int64_t time_ns;
        const std::size_t sample;
    };

    // Settles all whose time is over before something is measured at a moment.
    void settle_before(std::int64_t time_ns) override {
        if (this->settings_.lag_ns == 0) return;
        std::size_t end = this->due_;
        bool any = false;
        while (end < this->next_ && this->events_[end].time_ns + this->settings_.lag_ns < time_ns)
            any |= this->events_[end++].kind != Kind::check;
        if (any) settle(end);
        for (; this->due_ < end; ++this->due_) release(this->due_);
    }

    // Judges what is in the window by all in it, and writes the moments before `end`.
    void settle(std::size_t end) {
        for (std::size_t round = 1;; ++round) {
            {
                const Kept own(*this);
                over_window(end);
            }
            if (round == most_rounds || !told()) return;
            const std::size_t changed = this->judge_again(this->due_, heard());
            for (std::size_t k = this->due_; k < this->next_; ++k) this->events_[k].by_later = true;
            if (changed == none) return;
            this->replay(this->due_ == 0 ? 0 : changed, this->next_);
            this->reconsider();
        }
    }

    // Whether the window can judge: of a start, which may be wrong as all others may, only as many
    // can as candidates need.
    bool told() const {
        std::size_t count = 0;
        for (std::size_t k = this->due_; k < this->next_; ++k) count += this->events_[k].measures();
        return this->due_ > 0 || count >= enough_hits;
    }

    void over_window(std::size_t end) {
        Matrix<N> curvature;
        double gradient[N] = {};
        for (std::size_t k = this->next_; k-- > this->due_;) {
            const Event &event = this->events_[k];
            if (event.kind == Kind::output && k < end) this->rewrite(event, gradient, curvature);
            this->look_back(k, gradient, curvature);
            if (k > this->due_)
                this->step_back(this->events_[k - 1], event.time_ns, gradient, curvature);
        }
    }

    std::size_t heard() const {
        std::size_t first = this->due_;
        for (std::size_t count = 0; first > 0 && count < most_heard; --first)
            count += this->events_[first - 1].measures();
        return first;
    }

    // What was settled is not needed again, but for states to begin from.
    void release(std::size_t index) {
        Event &event = this->events_[index];
        event.linear.reset();
        if (this->settings_.check_every == 0 && index % stride != 0) event.known.reset();
    }
};

}  // namespace motorcade::filter
