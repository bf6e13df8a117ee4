// The backward pass, and measurements weighed by what all others say of them. Every estimate gets
// to know what came after it. Its carrier is not a state but the gradient λ of what is unlikely
// about the later measurements, with its curvature Λ, taken against the flow of time through the
// transposed transitions: no covariance is inverted, and none but those of the moments asked for
// need be kept (G. J. Bierman, Fixed interval smoothing with discrete measurements, International
// Journal of Control 18(1), 1973). Transitions are made again from the samples, event by event.

#pragma once

#include "hypothesis.h"

namespace motorcade::filter {

// Weights settle within two or three rounds; those of a few that stand at the gate may alternate.
constexpr std::size_t most_rounds = 5;
// A weight that halves or doubles is worth another round.
constexpr double tolerance = 2.0;
constexpr std::size_t none = static_cast<std::size_t>(-1);  // of the events

// That are tried; each costs a few passes over the whole.
constexpr std::size_t most_steps = 6, most_spans = 8;
// Poses on both sides that a step may be seen at too.
constexpr std::size_t beside = 2;
template <std::size_t N> class Smoother : public Timeline<N> {
public:
    using Timeline<N>::Timeline;

    // Rewrites what the sink holds for the moments passed so far. The path may as well begin at any
    // pose that was denied near the start, or before which it steps; what lies between two steps of
    // the pose may be wrong together, as on a map of its own. The least costly is kept, unless it
    // denies most of the measurements that are explained without: the wrong ones are the fewer.
    void smooth() {
        this->doubt_last_jump(0);
        const auto given_up = this->given_up_;
        const Hypothesis<N> plain = weigh_all();
        const std::vector<Step> found = steps();
        std::vector<std::size_t> starts;
        if (!given_up.empty()) starts = this->starts_;
        for (const Step &step : found)
            if (within_bridge(0, step.event) && 2 * step.event < this->next_)
                starts.push_back(step.event);
        if (!found.empty() || !starts.empty()) remake(least_costly(plain, found, starts));
        this->given_up_ = given_up;
    }

protected:
    using Span = std::pair<std::size_t, std::size_t>;  // of the events

    // An event just before which the pose seems to step, as a normalised square.
    struct Step {
        double square;
        std::size_t event;
    };

    Hypothesis<N> least_costly(Hypothesis<N> plain, const std::vector<Step> &found,
                               const std::vector<std::size_t> &starts) {
        plain = with_rows(std::move(plain));
        Hypothesis<N> best = plain;
        leave_out(best, spans(found));
        bool later = false;
        for (const std::size_t start : starts)
            for (Hypothesis<N> &other : begun_at(start, plain))
                if (other.cost < best.cost) best = std::move(other), later = true;
        if (later) {
            remake(best);
            leave_out(best, spans(steps()));
        }
        return 2 * best.explained < plain.explained ? plain : best;
    }

    // Each measurement weighed by what all others say of it: again, with the weights that came out,
    // until they stay or predict worse than those before did.
    Hypothesis<N> weigh_all() {
        Hypothesis<N> best;
        for (std::size_t round = 1;; ++round) {
            jump_ = 0;
            backward();
            this->thorough_ = false;
            Hypothesis<N> now = hypothesis();
            if (round > 1 && now.cost > best.cost + refused()) {
                remake(best);
                return best;
            }
            best = std::move(now);
            if (round == most_rounds) return best;
            if (jump_ != 0 && this->doubt_first_jump(jump_, jumped_)) continue;
            if (judge_again(this->begin_, this->begin_) == none) return best;
            this->replay(this->begin_, this->next_);
        }
    }

    // What begins at an event, with what came before it: by the IMU alone, with the poses that
    // agree and without any; and where that tells too little on another map.
    std::vector<Hypothesis<N>> begun_at(std::size_t start, const Hypothesis<N> &plain) {
        this->begin_at(start);
        const Hypothesis<N> later = weigh_all();
        Track<N> after = later.first;
        const bool bridged = this->bridged_back(start, 0, after);
        std::vector<Hypothesis<N>> made;
        const auto extend = [&](auto &&before) {
            restore(later);
            this->begin_ = 0;
            before();
            this->replay(0, this->next_);
            made.push_back(with_rows(weigh_all()));
        };
        const auto apart = [&](std::size_t k, double given) {
            // What is denied stays so: each of them alone might pass for noise.
            this->events_[k].given = given, this->events_[k].apart = given == 0.0;
        };
        for (const bool any : {true, false})
            extend([&] {
                this->judge_before(later.first, start);
                for (std::size_t k = 0; k < start; ++k)
                    apart(k, any ? this->events_[k].given : 0.0);
            });
        if (!bridged)
            extend([&] {
                this->begun_ = plain.begun;
                for (std::size_t k = 0; k < start; ++k)
                    this->events_[k].given = plain.given[k], this->events_[k].apart = false;
                this->events_[start].doubt = std::make_unique<Doubt>(anew);
            });
        return made;
    }

    // Leaves out the span without which all costs least, as long as one lowers that.
    void leave_out(Hypothesis<N> &best, std::vector<Span> open) {
        while (!open.empty()) {
            const Hypothesis<N> base = best;
            Span left_out{none, 0};
            for (const Span &span : open)
                if (Hypothesis<N> other = without(base, span.first, span.second);
                    other.cost < best.cost)
                    best = std::move(other), left_out = span;
            if (left_out.first == none) return;
            const auto touched = [&](const Span &one) {
                return one.first <= left_out.second && one.second >= left_out.first;
            };
            open.erase(std::remove_if(open.begin(), open.end(), touched), open.end());
        }
    }

    // Where two steps may explain as much as a span costs, and each half of that; and where the map
    // was relocated, or some poses in a row begin or cease to be refused.
    std::vector<Step> steps() const {
        const double least = 0.5 * span_price * squares_a_cost * refused();
        std::vector<Step> made;
        std::vector<std::size_t> poses;
        for (std::size_t k = 0; k < this->next_; ++k)
            if (this->events_[k].from_pose()) poses.push_back(k);
        for (std::size_t i = 1; i < poses.size(); ++i) {
            const std::size_t first = i > beside ? i - beside : 1,
                              last = std::min(i + beside, poses.size() - 1);
            const bool certain = this->events_[poses[i]].doubt || run_ends(poses, i);
            const double square =
                certain ? std::numeric_limits<double>::infinity() : step_[poses[i]];
            bool highest = square > least;
            for (std::size_t k = first; k <= last; ++k) highest &= step_[poses[k]] <= square;
            if (highest) made.push_back({square, poses[i]});
        }
        const auto larger = [](const Step &one, const Step &other) {
            return one.square > other.square;
        };
        std::sort(made.begin(), made.end(), larger);
        if (made.empty() || made.front().square + made[made.size() > 1].square < 2.0 * least)
            return {};
        if (made.size() > most_steps) made.resize(most_steps);
        return made;
    }

    // Whether some poses before or from one on are refused, to the end of all if these are fewer,
    // where those across are not.
    bool run_ends(const std::vector<std::size_t> &poses, std::size_t i) const {
        const auto wrong = [&](std::size_t k) { return this->events_[poses[k]].factor == 0.0; };
        if (wrong(i) == wrong(i - 1)) return false;
        const std::size_t first = wrong(i) ? i : i - std::min(i, fewest_together);
        const std::size_t last = wrong(i) ? std::min(i + fewest_together, poses.size()) : i;
        bool all = true;
        for (std::size_t k = first; k < last; ++k) all &= wrong(k);
        return all;
    }

    bool within_bridge(std::size_t from, std::size_t to) const {
        return this->events_[to].time_ns - this->events_[from].time_ns <= longest_bridge_ns;
    }

    // Between two steps, or from one to the end, if the IMU may carry the path there.
    std::vector<Span> spans(const std::vector<Step> &steps) const {
        std::vector<Span> made;
        for (std::size_t i = 0; i < steps.size(); ++i) {
            if (within_bridge(steps[i].event, this->next_ - 1))
                made.emplace_back(steps[i].event, this->next_);
            for (std::size_t k = 0; k < i; ++k) {
                const auto [from, to] = std::minmax(steps[i].event, steps[k].event);
                if (within_bridge(from, to)) made.emplace_back(from, to);
            }
        }
        if (made.size() > most_spans) made.resize(most_spans);
        return made;
    }

    // All between is wrong, and the path jumped nowhere. Each alone might pass for noise: they are
    // not weighed again. What began with a state that denied all before them begins at the first.
    // Where the IMU alone tells too little to the end, all from there on is on another map.
    Hypothesis<N> without(const Hypothesis<N> &whole, std::size_t from, std::size_t to) {
        Hypothesis<N> base = whole;
        const auto ends = [&](const auto &one) { return one.first >= from && one.first <= to; };
        auto &doubts = base.doubts;
        doubts.erase(std::remove_if(doubts.begin(), doubts.end(), ends), doubts.end());
        const auto start = base.believed.begin();
        if (base.begun && std::count(start, start + static_cast<std::ptrdiff_t>(from), true) == 0) {
            base.begun.reset();
            std::fill_n(base.given.begin(), from, undecided);
        }
        for (std::size_t k = from; k < to; ++k) base.given[k] = 0.0, base.apart[k] = true;
        for (std::size_t k = to; k < this->next_; ++k)
            if (k == to || (base.given[k] == 0.0 && !base.apart[k])) base.given[k] = undecided;
        restore(base);
        if (to == this->next_ && !this->bridged(this->p_, this->events_[from])) {
            for (std::size_t k = from; k < to; ++k)
                base.given[k] = undecided, base.apart[k] = false;
            doubts.emplace_back(from, anew);
            restore(base);
        } else if (to < this->next_) {
            Event &event = this->events_[to];
            if (event.factor == 0.0 && this->strained(event)) {
                event.given = std::max(1.0, event.nis / this->settings_.gate[event.size]);
                this->replay(to, this->next_);
            }
        }
        return with_rows(weigh_all());
    }

    void remake(const Hypothesis<N> &given) {
        restore(given);
        backward();
        this->thorough_ = false;
    }

    Hypothesis<N> hypothesis() const {
        Hypothesis<N> made;
        made.begin = this->begin_, made.first = first_, made.begun = this->begun_;
        for (std::size_t k = 0; k < this->next_; ++k) {
            const Event &event = this->events_[k];
            made.given.push_back(event.given);
            made.apart.push_back(event.apart);
            made.believed.push_back(event.measures() && event.factor > 0.0);
            if (event.doubt) made.doubts.emplace_back(k, *event.doubt);
        }
        made.explained =
            static_cast<std::size_t>(std::count(made.believed.begin(), made.believed.end(), true));
        made.cost = jump_price * refused() * static_cast<double>(made.doubts.size());
        for (std::size_t k = 0; k < this->next_; ++k) made.cost += cost(k);
        return made;
    }

    // What a measurement costs. However far off a wrong one is, to call it wrong gains nothing.
    double cost(std::size_t k) const {
        const Event &event = this->events_[k];
        if (!event.measures()) return 0.0;
        if (event.factor == 0.0) return refused() + fewer;
        return std::min(prediction_cost(event.left_out[0], static_cast<double>(freedom(event))),
                        refused());
    }

    // Denied poses in a row may be wrong together, as on a map of their own, by a motion there and
    // another one back: where that is less they cost what they do on that map, and the price of it.
    Hypothesis<N> with_rows(Hypothesis<N> made) {
        const std::vector<Span> rows = denied_rows(made);
        if (rows.empty()) return made;
        std::vector<double> saved;
        Hypothesis<N> mapped = made;
        mapped.apart.assign(this->next_, true);
        const auto step_at = [&](std::size_t k, bool turned) {
            const auto here = [&](const auto &one) { return one.first == k; };
            auto &doubts = mapped.doubts;
            doubts.erase(std::remove_if(doubts.begin(), doubts.end(), here), doubts.end());
            if (k > 0 && k < this->next_) doubts.emplace_back(k, Doubt{false, true, turned});
        };
        for (const auto &[from, to] : rows) {
            saved.push_back(0.0);
            for (std::size_t k = from; k < to; ++k) {
                if (!this->events_[k].from_pose()) continue;
                saved.back() += refused();
                mapped.given[k] = 1.0, mapped.apart[k] = false;
            }
            if (from == 0) this->relocate(*(mapped.begun = made.first.at), this->events_[0], true);
            step_at(to, false), step_at(from, true);
        }
        remake(mapped);
        if (judge_again(this->begin_, this->begin_) != none) {
            this->replay(this->begin_, this->next_);
            backward();
            this->thorough_ = false;
        }
        for (std::size_t i = 0; i < rows.size(); ++i) {
            double together = span_price * refused();
            for (std::size_t k = rows[i].first; k < rows[i].second; ++k)
                if (this->events_[k].from_pose()) together += cost(k);
            made.cost -= std::max(0.0, saved[i] - together);
        }
        return made;
    }

    // From the first of some poses in a row that are denied to the next that is not.
    std::vector<Span> denied_rows(const Hypothesis<N> &of) const {
        std::vector<Span> made;
        std::size_t from = none, count = 0;
        for (std::size_t k = 0; k <= this->next_; ++k) {
            if (k < this->next_ && !this->events_[k].from_pose()) continue;
            if (k < this->next_ && !of.believed[k]) {
                if (count++ == 0) from = k;
                continue;
            }
            if (count >= fewest_together) made.emplace_back(from, k);
            count = 0;
        }
        return made;
    }

    void restore(const Hypothesis<N> &given) {
        this->begin_ = given.begin;
        this->begun_ = given.begun;
        for (std::size_t k = 0; k < this->next_; ++k) {
            this->events_[k].given = given.given[k];
            this->events_[k].apart = given.apart[k];
            this->events_[k].doubt.reset();
        }
        for (const auto &[index, doubt] : given.doubts)
            this->events_[index].doubt = std::make_unique<Doubt>(doubt);
        this->replay(this->begin_, this->next_);
    }

    // Of a pose that is taken for wrong.
    double refused() const {
        return prediction_cost(this->settings_.most_noise * this->settings_.gate[6], 6.0);
    }

    // Between states that were kept all is made again first. The state ends where it started.
    void backward() {
        Matrix<N> curvature;
        double gradient[N] = {};
        this->thorough_ = true;
        step_.assign(this->next_, 0.0);
        const std::size_t begin = this->begin_;
        for (std::size_t end = this->next_; end > begin;) {
            std::size_t kept = end > begin + 1 ? end - 2 : begin;
            while (!this->events_[kept].known) --kept;
            const std::size_t first = end > begin + 1 ? kept + 1 : begin;
            if (first > begin || this->begun_) this->replay(first, end);
            for (std::size_t i = end; i-- > first;) {
                Event &event = this->events_[i];
                if (event.kind == Kind::output) rewrite(event, gradient, curvature);
                if (event.doubt) jump_ = i, jumped_ = smoothed(event, gradient, curvature);
                look_back(i, gradient, curvature);
                step_[i] = event.measures() ? step_square(gradient, curvature) : 0.0;
                if (event.doubt && event.doubt->anew) {
                    curvature = Matrix<N>();
                    std::fill_n(gradient, N, 0.0);
                }
                if (i > begin) step_back(this->events_[i - 1], event.time_ns, gradient, curvature);
                event.known.reset();
                event.linear.reset();
            }
            end = first;
        }
    }

    // What an event says of itself by all that came later, and of what came before it.
    void look_back(std::size_t index, double *gradient, Matrix<N> &curvature) {
        Event &event = this->events_[index];
        if (index == this->begin_) first_ = smoothed(event, gradient, curvature);
        const bool took = event.factor > 0.0 && event.linear;
        if (took && event.bent) before_step(event, gradient, curvature);
        if (event.measures()) event.left_out = left_out(event, gradient, curvature);
        if (took) take_in(event, gradient, curvature);
        if (event.kind == Kind::keep) unkeep(gradient, curvature);
    }

    void step_back(const Event &from, std::int64_t to, double *gradient, Matrix<N> &curvature) {
        this->now_ = from.known->after;
        this->seek(from.time_ns);
        step_back(to, gradient, curvature);
    }

    // From a moment to that of the state.
    void step_back(std::int64_t to, double *gradient, Matrix<N> &curvature) {
        steps_.clear();
        this->advance(to, [this](const Transition &f, const Densities &) { steps_.push_back(f); });
        for (std::size_t k = steps_.size(); k-- > 0;)
            propagate_back(curvature, gradient, steps_[k]);
        symmetrise(curvature);
    }

    // The step that a measurement made, K y, took back: see bend.h.
    static void before_step(const Event &event, double *gradient, Matrix<N> &curvature) {
        const std::size_t m = event.size;
        const double *residual = event.linear.get(), *gain = residual + m + m * N;
        double step[N] = {};
        for (std::size_t a = 0; a < m; ++a) filter::add<N>(step, residual[a], gain + a * N);
        rebase_back(curvature, gradient, step);
    }

    // λ becomes (1 - K H)' λ - H' S⁻¹ y, and Λ likewise with H' S⁻¹ H added.
    void take_in(const Event &event, double *gradient, Matrix<N> &curvature) {
        const std::size_t m = event.size;
        const double *residual = event.linear.get(), *effect = residual + m, *gain = effect + m * N,
                     *inverse = gain + m * N;
        Innovation<N> seen;
        Gain<N> by;
        seen.size = m;
        double pull[widest];
        for (std::size_t a = 0; a < m; ++a) {
            std::copy_n(effect + a * N, N, seen.effect[a]);
            std::copy_n(gain + a * N, N, by.gain[a]);
            std::copy_n(inverse + a * m, m, by.inverse[a]);
            pull[a] = 0.0;
            for (std::size_t i = 0; i < N; ++i) pull[a] += by.gain[a][i] * gradient[i];
            for (std::size_t b = 0; b < m; ++b) pull[a] += by.inverse[a][b] * residual[b];
        }
        for (std::size_t a = 0; a < m; ++a) filter::add<N>(gradient, -pull[a], seen.effect[a]);
        update_back(curvature, seen, by);
    }

    // Before the pose was kept there was but one: what is said of the earlier one is said of it.
    static void unkeep(double *gradient, Matrix<N> &curvature) {
        if constexpr (N > earlier) {
            for (std::size_t i = 0; i < 6; ++i) {
                gradient[i] += gradient[earlier + i];
                gradient[earlier + i] = 0.0;
                filter::add<N>(curvature.row[i], 1.0, curvature.row[earlier + i]);
                std::fill_n(curvature.row[earlier + i], N, 0.0);
            }
            for (std::size_t k = 0; k < N; ++k)
                for (std::size_t i = 0; i < 6; ++i) {
                    curvature.row[k][i] += curvature.row[k][earlier + i];
                    curvature.row[k][earlier + i] = 0.0;
                }
        }
    }

    // x Exp(-P λ) and P - P Λ P in place of what the forward pass wrote.
    void rewrite(const Event &event, const double *gradient, const Matrix<N> &curvature) {
        Matrix<N> p;
        unpack(event.known->covariance, p);
        correct_by(event, gradient, p);
        shrink(p, curvature);
        this->put(event.number, p);
    }

    void correct_by(const Event &event, const double *gradient, const Matrix<N> &p) {
        double error[N] = {};
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t k = 0; k < N; ++k) error[i] -= p.row[i][k] * gradient[k];
        this->now_ = event.known->after;
        correct<N>(this->now_, error);
    }

    // The state after an event, by all that was measured.
    Track<N> smoothed(const Event &event, const double *gradient, const Matrix<N> &curvature) {
        Track<N> made;
        unpack(event.known->covariance, made.covariance);
        correct_by(event, gradient, made.covariance);
        shrink(made.covariance, curvature);
        made.at = this->now_, made.time_ns = event.time_ns;
        return made;
    }

    // How far a measurement is from what all others say, as a normalised square: by its own noise,
    // and by the most that it may have. With the pull u = S⁻¹ y + K' λ and its covariance
    // D = S⁻¹ + K' Λ K the residual is D⁻¹ u with covariance D⁻¹ (P. de Jong, A cross-validation
    // filter for time series models, Biometrika 75(3), 1988); of a measurement that had no weight,
    // where D is S⁻¹ - K' Λ K, it is S u with covariance S D S.
    std::array<double, 2> left_out(const Event &event, const double *gradient,
                                   const Matrix<N> &curvature) const {
        const std::size_t m = event.size;
        const double most = this->settings_.most_noise;
        double by[widest][widest], pull[widest] = {};
        if (!event.linear) {
            if (&event != &this->events_[this->begin_]) return {nan_d, nan_d};  // not predicted
            // The pose that all started from, which was no news.
            for (std::size_t a = 0; a < 6; ++a) {
                pull[a] = gradient[a];
                std::copy_n(curvature.row[a], 6, by[a]);
            }
            const double apart = quadratic(by, pull, 6);
            return {apart, apart / most};
        }
        const double *residual = event.linear.get(), *gain = residual + m + m * N,
                     *inverse = gain + m * N, *noise = inverse + m * m;
        const double sign = event.factor > 0.0 ? 1.0 : -1.0;
        for (std::size_t a = 0; a < m; ++a) {
            double across[N] = {};
            for (std::size_t i = 0; i < N; ++i) {
                pull[a] += gain[a * N + i] * gradient[i];
                filter::add<N>(across, gain[a * N + i], curvature.row[i]);
            }
            for (std::size_t b = 0; b < m; ++b) {
                pull[a] += inverse[a * m + b] * residual[b];
                double sum = 0.0;
                for (std::size_t i = 0; i < N; ++i) sum += across[i] * gain[b * N + i];
                by[a][b] = inverse[a * m + b] + sign * sum;
            }
        }
        if (!(event.factor > 1.0)) {
            const double apart = quadratic(by, pull, m);
            if (apart <= this->settings_.gate[m]) return {apart, apart};
        }
        double spread[widest][widest], total[widest][widest], apart[widest] = {};
        if (event.factor > 0.0) {
            if (!inverse_of(m, by, total)) return {nan_d, nan_d};
            std::copy_n(&total[0][0], widest * widest, &spread[0][0]);
        } else {
            double stated[widest][widest];
            for (std::size_t a = 0; a < m; ++a) std::copy_n(inverse + a * m, m, stated[a]);
            if (!inverse_of(m, stated, total)) return {nan_d, nan_d};
            for (std::size_t a = 0; a < m; ++a)
                for (std::size_t b = 0; b < m; ++b) {
                    spread[a][b] = 0.0;
                    for (std::size_t c = 0; c < m; ++c)
                        for (std::size_t d = 0; d < m; ++d)
                            spread[a][b] += total[a][c] * by[c][d] * total[d][b];
                }
        }
        for (std::size_t a = 0; a < m; ++a)
            for (std::size_t b = 0; b < m; ++b) {
                apart[a] += total[a][b] * pull[b];
                spread[a][b] -= std::max(0.0, event.factor - 1.0) * noise[a * m + b];
            }
        const double own = quadratic(spread, apart, m);
        for (std::size_t a = 0; a < m; ++a)
            for (std::size_t b = 0; b < m; ++b) spread[a][b] += (most - 1.0) * noise[a * m + b];
        return {own, quadratic(spread, apart, m)};
    }

    // The normalised square of the step of the pose just before an event that makes all since most
    // likely (P. de Jong, J. Penzer, Diagnosing shocks in time series, Journal of the American
    // Statistical Association 93(442), 1998).
    static double step_square(const double *gradient, const Matrix<N> &curvature) {
        double by[widest][widest];
        for (std::size_t a = 0; a < 6; ++a) std::copy_n(curvature.row[a], 6, by[a]);
        return std::max(0.0, quadratic(by, gradient, 6));  // 0 where nothing later tells
    }

    static double quadratic(double (*matrix)[widest], const double *vector, std::size_t m) {
        double inverse[widest][widest], sum = 0.0;
        if (!inverse_of(m, matrix, inverse)) return nan_d;
        for (std::size_t a = 0; a < m; ++a)
            for (std::size_t b = 0; b < m; ++b) sum += vector[a] * inverse[a][b] * vector[b];
        return sum;
    }

    // Gives every measurement from `first` on the weight that its distance from all others
    // deserves; the first whose weight changes. Distances count in units of what half of those
    // believed since `heard` stay below, where that is more than it should be: noise that is stated
    // too small must not make outliers of good data.
    std::size_t judge_again(std::size_t first, std::size_t heard) {
        std::vector<double> ratios;
        for (std::size_t k = heard; k < this->next_; ++k) {
            const Event &event = this->events_[k];
            if (event.measures() && event.factor > 0.0 && event.left_out[0] >= 0.0)
                ratios.push_back(event.left_out[0] / this->settings_.middle[freedom(event)]);
        }
        if (ratios.empty()) return none;
        const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
        std::nth_element(ratios.begin(), middle, ratios.end());
        const double unit = std::max(1.0, *middle);
        std::size_t changed = none;
        for (std::size_t k = first; k < this->next_; ++k) {
            Event &event = this->events_[k];
            if (!event.measures() || event.apart) continue;
            double factor = event.factor;
            if (event.left_out[0] >= 0.0)
                factor = this->factor_of(event.left_out[0] / unit, event.left_out[1] / unit,
                                         freedom(event));
            const bool other =
                (factor > 0.0) != (event.factor > 0.0) ||
                std::max(factor, event.factor) > tolerance * std::min(factor, event.factor);
            if (other && changed == none) changed = k;
            event.given = factor;
        }
        if (changed != none && first == this->begin_) this->restart(first_.at);
        return changed;
    }

    static std::size_t freedom(const Event &event) { return event.size > 0 ? event.size : 6; }

    std::vector<double> step_;  // of the events
    Track<N> first_;            // the first state, should it be needed to begin anew
    std::size_t jump_ = 0;      // the first event at which the prediction was given up, if any
    Track<N> jumped_;           // the state after it

    std::vector<Transition> steps_;  // of one interval, kept for its memory
};

}  // namespace motorcade::filter
