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
    // pose that was denied near the start; what lies between two steps of the pose may be wrong
    // together, as on a map of its own, and so may all before a step. In the end what was
    // preferred step by step stands beside what was left behind, where that explains more: the
    // less costly is kept. What denies most of the measurements that are explained without any
    // such hypothesis is given up: the wrong ones are the fewer.
    void smooth() {
        this->doubt_last_jump(0);
        const auto given_up = this->given_up_;
        Hypothesis<N> best = weigh_all(), spanned = best;
        const Hypothesis<N> plain = best;
        if (auto open = spans(steps()); !open.empty()) {
            while (take_best(spanned, open, true)) continue;
            remake(best);
        }
        bool other_tried = !given_up.empty() && try_starts(best, this->starts_, false);
        const std::vector<Step> found = steps();
        for (auto open = spans(found); take_best(best, open, false);) continue;
        std::vector<std::size_t> starts;
        for (const Step &step : found)
            if (within_bridge(0, step.event) && 2 * step.event < this->next_)
                starts.push_back(step.event);
        other_tried |= !found.empty();
        if (!try_starts(best, starts, true) && other_tried) remake(best);
        best = hypothesis(this->begin_);
        for (const Hypothesis<N> &other : {spanned, plain})
            if (other.explained() > best.explained() &&
                other.total(best, refused(), good()) + 2.0 * refused() <
                    best.total(other, refused(), good()))
                remake(best = other);
        if (2 * best.explained() < plain.explained()) remake(plain);
        this->given_up_ = given_up;
    }

protected:
    using Span = std::pair<std::size_t, std::size_t>;  // of the events

    // Each measurement weighed by what all others say of it: again, with the weights that came out,
    // until they stay or predict worse than those before did.
    Hypothesis<N> weigh_all() {
        Hypothesis<N> best;
        std::size_t since = this->begin_;
        for (std::size_t round = 1;; ++round) {
            jump_ = 0;
            backward();
            this->thorough_ = false;
            Hypothesis<N> now = hypothesis(since);
            if (round > 1 && now.loses(best, since, refused())) {
                remake(best);
                return best;
            }
            best = std::move(now);
            if (round == most_rounds) return best;
            if (jump_ != 0 && this->doubt_first_jump(jump_, jumped_)) {
                since = jump_;
                continue;
            }
            if (judge_again(this->begin_, this->begin_) == none) return best;
            this->replay(this->begin_, this->next_);
        }
    }

    // Whether any pose before a start is where the IMU leads back to: by chance none would be.
    bool agrees_before(const Hypothesis<N> &other) {
        this->begin_ = 0;
        return this->judge_before(other.first, other.begin) > 0;
    }

    // Whether any was tried; the best is taken over then.
    bool try_starts(Hypothesis<N> &best, const std::vector<std::size_t> &starts, bool apart) {
        if (starts.empty()) return false;
        const Hypothesis<N> first = best;
        for (const std::size_t start : starts) {
            this->begin_at(start);
            Hypothesis<N> other = weigh_all();
            Track<N> after = other.first;
            other.bridged = this->bridged_back(start, 0, after) || agrees_before(other);
            if (apart) std::fill_n(other.apart.begin(), start, true);
            if (other.better(best, refused())) best = std::move(other);
        }
        if (best.begin == first.begin)
            remake(best);
        else if (extended(best, first))
            best = hypothesis(0);
        else
            remake(best = first);
        return true;
    }

    // Whether what predicts best without one of the spans is better, which is then taken over; that
    // span and those that it touches are no longer open. Or by as few jumps of the map, where poses
    // at both ends of the span are off.
    bool take_best(Hypothesis<N> &best, std::vector<Span> &open, bool off_alone) {
        Hypothesis<N> found;
        Span without_it;
        double most = 0.0;
        for (const Span &span : open) {
            Hypothesis<N> other = without(best, span.first, span.second);
            const double gain = other.gain(best, best.since);
            const bool worse = off_alone ? !other.better(most > 0.0 ? found : best, refused()) ||
                                               !off_at_ends(other, span)
                                         : gain <= most || other.more_explained(best, 0) < 0 ||
                                               !other.better(best, refused());
            if (worse) continue;
            most = std::max(gain, 1e-9), without_it = span, found = std::move(other);
        }
        if (most == 0.0) return false;
        best = std::move(found);
        const auto touched = [&](const Span &one) {
            return one.first <= without_it.second && one.second >= without_it.first;
        };
        open.erase(std::remove_if(open.begin(), open.end(), touched), open.end());
        return !open.empty();
    }

    // Whether most poses next to both ends of a span are off where all others lead. Where they are
    // not the path does not step, and it takes no map of their own to explain them.
    bool off_at_ends(const Hypothesis<N> &without, const Span &span) const {
        std::vector<bool> off;
        for (std::size_t k = span.first; k < span.second; ++k)
            if (this->events_[k].from_pose()) off.push_back(without.cost[k] > good());
        const auto near = static_cast<std::ptrdiff_t>(std::min(off.size(), beside + 1));
        const auto usually = [&](auto first) {
            return 2 * std::count(first, first + near, true) > near;
        };
        return usually(off.begin()) && (span.second == this->next_ || usually(off.rbegin()));
    }

    // An event just before which the pose seems to step, as a normalised square.
    struct Step {
        double square;
        std::size_t event;
    };

    // Where a pose of the most noise would hardly explain the step, if for one of them it would not
    // at all; and where the map was relocated, or poses begin or cease to be refused as many in a
    // row as another hypothesis needs.
    std::vector<Step> steps() const {
        const double most = this->settings_.most_noise;
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
            bool highest = square > most * this->settings_.middle[6];
            for (std::size_t k = first; k <= last; ++k) highest &= step_[poses[k]] <= square;
            if (highest) made.push_back({square, poses[i]});
        }
        const auto larger = [](const Step &one, const Step &other) {
            return one.square > other.square;
        };
        std::sort(made.begin(), made.end(), larger);
        if (made.empty() || made.front().square < most * this->settings_.gate[6]) return {};
        if (made.size() > most_steps) made.resize(most_steps);
        return made;
    }

    // Whether as many poses before or from one on are refused, where those across are not.
    bool run_ends(const std::vector<std::size_t> &poses, std::size_t i) const {
        const auto wrong = [&](std::size_t k) { return this->events_[poses[k]].factor == 0.0; };
        if (wrong(i) == wrong(i - 1)) return false;
        const std::size_t first = wrong(i) ? i : i - std::min(i, enough_hits);
        const std::size_t last = wrong(i) ? std::min(i + enough_hits, poses.size()) : i;
        bool all = last - first == enough_hits;
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
    Hypothesis<N> without(Hypothesis<N> base, std::size_t from, std::size_t to) {
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
        if (to == this->next_) {
            if (!this->bridged(this->p_, this->events_[from])) return base;
        } else if (Event &event = this->events_[to]; event.factor == 0.0 && this->strained(event)) {
            event.given = std::max(1.0, event.nis / this->settings_.gate[event.size]);
            this->replay(to, this->next_);
        }
        Hypothesis<N> made = weigh_all();
        made.bridged = true;
        return made;
    }

    // Takes a hypothesis over and adds what came before it: by the IMU alone, with the poses that
    // agree, or where that tells too little as on another map. False where it then predicts worse.
    bool extended(const Hypothesis<N> &best, const Hypothesis<N> &first) {
        if (best.begin == 0) return false;
        restore(best);
        this->begin_ = 0;
        if (best.bridged) {
            this->judge_before(best.first, best.begin);
            // What they deny stays so: each of them alone might pass for noise.
            for (std::size_t k = 0; k < best.begin; ++k)
                this->events_[k].apart = this->events_[k].given == 0.0;
        } else {
            this->begun_ = first.begun;
            for (std::size_t k = 0; k < best.begin; ++k)
                this->events_[k].given = first.given[k], this->events_[k].apart = false;
            auto anew = std::make_unique<Doubt>();
            anew->anew = true;
            this->events_[best.begin].doubt = std::move(anew);
        }
        this->replay(0, this->next_);
        return !weigh_all().loses(best, best.since, refused());
    }

    void remake(const Hypothesis<N> &given) {
        restore(given);
        backward();
        this->thorough_ = false;
    }

    Hypothesis<N> hypothesis(std::size_t since) const {
        Hypothesis<N> made;
        made.begin = this->begin_, made.since = since, made.first = first_,
        made.begun = this->begun_;
        for (std::size_t k = 0; k < this->next_; ++k) {
            const Event &event = this->events_[k];
            made.given.push_back(event.given);
            const double square = k < since ? nan_d : event.left_out[0];
            const double cost = prediction_cost(square, static_cast<double>(freedom(event)));
            // However far off a wrong pose is, to call it wrong gains nothing.
            made.cost.push_back(event.measures() ? std::min(cost, refused()) : 0.0);
            made.apart.push_back(event.apart);
            made.believed.push_back(event.measures() && event.factor > 0.0);
            if (event.doubt) made.doubts.emplace_back(k, *event.doubt);
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

    // Of a pose at the gate.
    double good() const { return prediction_cost(this->settings_.gate[6], 6.0); }

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
