// Smoothing as poses come, with nothing to tune. Many filters run side by side, of held pose, of
// steady velocity and of steady acceleration, each with a cut-off of a geometric series below the
// sampling rate. How well each foretold the latest poses is its weight, for position and for
// rotation apart; what is given is their weighted mean. A constant lag adds the smoother's
// recursion back over the poses within it.
//
// Weights are likelihoods of the innovations at their likeliest noise, fading with the memory.
// After P. J. Harrison, C. F. Stevens, Bayesian forecasting, J. R. Stat. Soc. B 38 (1976), class I;
// D. T. Magill, Optimal adaptive estimation of sampled stochastic processes, IEEE TAC 10 (1965).

#pragma once

#include <deque>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "follower.h"

namespace motorcade::smooth {

inline constexpr std::size_t CUTOFFS = 12;
inline constexpr double PI = 3.141592653589793;

// Densities of a process of an order, the noise being 1 a pose: the cut-off of the k-th filter lies
// k octaves below four times the sampling rate.
template <std::size_t Order> std::array<double, CUTOFFS> densities_of(double interval) {
    const double highest = 8.0 * PI / interval;
    std::array<double, CUTOFFS> made;
    made[0] = interval;
    for (std::size_t i = 0; i <= Order; ++i) made[0] *= highest * highest;
    constexpr double octave = 1.0 / static_cast<double>(std::size_t{4} << (2 * Order));
    for (std::size_t k = 1; k < CUTOFFS; ++k) made[k] = octave * made[k - 1];
    return made;
}

// Filters of all orders and cut-offs over positions or over rotations.
template <class G> class Bank {
public:
    using X = typename G::X;

    // Begins at a pose; with `keeps`, what the filters knew is kept until `forget_first`.
    void start(const X &z, double usual, bool keeps) {
        each([&](auto &one, auto, std::size_t) { one.start(z, usual); });
        for (auto &row : weights_) row.fill(1.0 / (3.0 * CUTOFFS));
        suspect_ = {};
        keeps_ = keeps;
        past_.clear();
        keep();
    }

    // Goes on from a pose that has nothing to do with those before but the rates.
    void go_on_from(const X &z, double dt, double usual) {
        each([&](auto &one, auto, std::size_t) { one.reopen(z, usual); });
        suspect_ = {};
        keep(dt, usual, true);
    }

    // Takes the next pose. Where poses were found to have jumped it goes on from there.
    void update(const X &z, double dt, double usual, double fading) {
        each_order([&]<std::size_t Order>(Row<Order> &row) {
            const auto densities = densities_of<Order>(usual);
            const auto added = diffusion<Order + 1>(dt);
            for (std::size_t k = 0; k < CUTOFFS; ++k) row[k].predict(dt, densities[k], added);
            for (auto &one : row) one.meet(z);
        });
        if (has_jumped(z, dt)) return go_on_from(z, dt, usual);
        each([&](auto &one, auto, std::size_t) { one.update(fading); });
        weigh();
        keep(dt, usual, false);
    }

    void forget_first() { past_.pop_front(); }

    // The squared misses of a pose by the likeliest filter, were it due after either interval.
    std::array<double, 2> missed(const X &z, double dt, double other) const {
        double most = -1.0;
        std::array<double, 2> found{};
        each([&](const auto &one, auto order, std::size_t k) {
            if (weights_[order.value][k] <= std::max(most, NEGLIGIBLE)) return;
            most = weights_[order.value][k];
            const Three by = G::local(z, one.ahead(dt)), either = G::local(z, one.ahead(other));
            found = {dot(by, by), dot(either, either)};
        });
        return found;
    }

    X ahead(double dt) const {
        return mean([&](const auto &one, auto, std::size_t) { return one.ahead(dt); });
    }

    // The pose at the oldest stamp that is kept, by all poses up to now.
    X looking_back() const {
        return mean([&](const auto &one, auto order, std::size_t k) {
            using Filter = std::remove_cvref_t<decltype(one)>;
            auto state = one.state();
            for (auto at = past_.rbegin() + 1; at < past_.rend(); ++at) {
                const auto &known = std::get<order.value>(at->states)[k];
                state = at->broken ? known
                                   : Filter::smoothed(known, state, at->interval,
                                                      densities_of<order.value>(at->usual)[k]);
            }
            return state.pose;
        });
    }

private:
    static constexpr double NEGLIGIBLE = 0.02, LOG_NEGLIGIBLE = -4.0;
    // How long poses must agree with each other and with none before, until they are believed.
    static constexpr double JUMP_S = 0.1;
    static constexpr std::size_t JUMP_POSES = 3;

    template <std::size_t Order> using Row = std::array<Follower<G, Order>, CUTOFFS>;
    template <std::size_t Order>
    using States = std::array<typename Follower<G, Order>::State, CUTOFFS>;

    // What the filters knew at a stamp, how far the next one is, and whether they began anew there.
    struct Past {
        std::tuple<States<0>, States<1>, States<2>> states;
        double interval = 0.0, usual = 0.0;
        bool broken = false;
    };

    struct Suspect {
        X last{};
        double since_s = 0.0;
        std::size_t count = 0;
    };

    template <class Verb> void each_order(Verb &&verb) {
        std::apply([&](auto &...row) { (verb(row), ...); }, rows_);
    }
    template <class Verb> void each(Verb &&verb) { each_of(rows_, verb); }
    template <class Verb> void each(Verb &&verb) const { each_of(rows_, verb); }

    template <class Of, class Verb> static void each_of(Of &rows, Verb &verb) {
        const auto row = [&]<std::size_t Order>(std::integral_constant<std::size_t, Order> order) {
            for (std::size_t k = 0; k < CUTOFFS; ++k) verb(std::get<Order>(rows)[k], order, k);
        };
        row(std::integral_constant<std::size_t, 0>{});
        row(std::integral_constant<std::size_t, 1>{});
        row(std::integral_constant<std::size_t, 2>{});
    }

    void keep(double dt = 0.0, double usual = 0.0, bool broken = false) {
        if (!keeps_) return;
        if (!past_.empty()) {
            past_.back().interval = dt;
            past_.back().usual = usual;
            past_.back().broken = broken;
        }
        Past &made = past_.emplace_back();
        each([&](const auto &one, auto order, std::size_t k) {
            std::get<order.value>(made.states)[k] = one.state();
        });
    }

    // Whether poses that none foretold agree with each other for long enough to be believed.
    bool has_jumped(const X &z, double dt) {
        double nearest = 1e300, noise = 0.0;
        each([&](const auto &one, auto order, std::size_t k) {
            if (weights_[order.value][k] < NEGLIGIBLE) return;
            nearest = std::min(nearest, one.distance());
            noise = std::max(noise, one.variance());
        });
        if (nearest < FARTHEST || noise == 0.0) {
            suspect_ = {};
            return false;
        }
        const Three apart = G::local(z, suspect_.last);
        const bool agrees = dot(apart, apart) < 2.0 * FARTHEST * FARTHEST * noise;
        suspect_.since_s = suspect_.count > 0 && agrees ? suspect_.since_s + dt : 0.0;
        suspect_.count = agrees ? suspect_.count + 1 : 1;
        suspect_.last = z;
        return suspect_.count >= JUMP_POSES && suspect_.since_s >= JUMP_S;
    }

    void weigh() {
        double best = -1e300, total = 0.0;
        each([&](const auto &one, auto order, std::size_t k) {
            best = std::max(best, weights_[order.value][k] = one.score());
        });
        for (auto &row : weights_)
            for (double &weight : row)
                total += weight = weight - best > LOG_NEGLIGIBLE ? std::exp(weight - best) : 0.0;
        double kept = 0.0;
        for (auto &row : weights_)
            for (double &weight : row) {
                weight /= total;
                if (weight < NEGLIGIBLE) weight = 0.0;
                kept += weight;
            }
        for (auto &row : weights_)
            for (double &weight : row) weight /= kept;
    }

    // The weighted mean of what the filters that count say, by one step from the likeliest.
    template <class Says> X mean(Says &&says) const {
        std::array<X, 3 * CUTOFFS> said;
        std::array<double, 3 * CUTOFFS> weight;
        std::size_t count = 0, likeliest = 0;
        each([&](const auto &one, auto order, std::size_t k) {
            if (weights_[order.value][k] == 0.0) return;
            said[count] = says(one, order, k);
            weight[count] = weights_[order.value][k];
            if (weight[count] > weight[likeliest]) likeliest = count;
            ++count;
        });
        Three step{};
        for (std::size_t i = 0; i < count; ++i)
            step = sum(step, scaled(weight[i], G::local(said[i], said[likeliest])));
        return G::retract(said[likeliest], step);
    }

    std::tuple<Row<0>, Row<1>, Row<2>> rows_{};
    std::array<std::array<double, CUTOFFS>, 3> weights_{};
    Suspect suspect_{};
    std::deque<Past> past_;
    bool keeps_ = false;
};

struct StampedPose {
    double time_s;
    Three position;
    Four rotor;
};

class Live {
public:
    // So many poses fit every filter; none can be preferred before.
    static constexpr std::size_t OPENING = 4;

    Live(double lag_s, double memory_s) : lag_s_(lag_s), memory_s_(memory_s) {}

    // The smoothed pose that is due: at the newest stamp that lies `lag_s` back, or the first.
    StampedPose update(const StampedPose &given) {
        take(given);
        if (lag_s_ > 0.0 && seen_ <= OPENING) return first_;
        while (stamps_.size() > 1 && stamps_[1] <= given.time_s - lag_s_) forget_first();
        return earliest();
    }

    // Poses of a whole path, each once as it falls due; what is left at the end by all of the path.
    // The newest pose is never due before the end, even where stamps are too large to tell the lag.
    template <class Given, class Write> void run(std::size_t count, Given &&given, Write &&write) {
        for (std::size_t k = 0; k < count; ++k) {
            if (lag_s_ == 0.0) {
                write(update(given(k)));
                continue;
            }
            take(given(k));
            if (seen_ <= OPENING) continue;
            while (stamps_.size() > 1 && stamps_.front() <= stamps_.back() - lag_s_) {
                write(earliest());
                forget_first();
            }
        }
        if (lag_s_ == 0.0 || stamps_.empty()) return;
        for (; stamps_.size() > 1; forget_first()) write(earliest());
        write(earliest());
    }

    StampedPose ahead(double time_s) const {
        if (stamps_.empty())
            throw std::invalid_argument("predict: expected a pose before it, got none");
        const double dt = time_s - stamps_.back();
        if (!(dt >= 0.0 && dt <= gap_s()))
            throw std::invalid_argument("time_s: expected " + std::to_string(stamps_.back()) +
                                        " to at most " + std::to_string(gap_s()) +
                                        " s later, where a motion can be foretold, got " +
                                        std::to_string(time_s));
        if (seen_ <= OPENING) return {time_s, last_.position, last_.rotor};
        return {time_s, positions_.ahead(dt), rotations_.ahead(dt)};
    }

    double usual_interval_s() const { return usual_; }

    // After half a second without a pose it is anybody's guess how hands have moved on.
    double gap_s() const { return std::max(0.5, 4.0 * usual_); }

    // From the latest pose to a stamp.
    double interval_to(double time_s) const {
        return stamps_.empty() ? 0.0 : time_s - stamps_.back();
    }

private:
    void take(StampedPose given) {
        const double dt = stamps_.empty() ? 0.0 : checked_interval(given.time_s);
        if (stamps_.empty()) first_ = last_ = given;
        // A rotor's sign is free; steps from one to the next must not be a whole turn.
        if (dot(given.rotor, last_.rotor) < 0.0) given.rotor = scaled(-1.0, given.rotor);
        if (dt > 0.0) follow(given, dt);
        stamps_.push_back(given.time_s);
        last_ = given;
        ++seen_;
    }

    // At the first stamp that is kept.
    StampedPose earliest() const {
        if (lag_s_ == 0.0) return ahead(stamps_.back());
        return {stamps_.front(), positions_.looking_back(), rotations_.looking_back()};
    }

    void forget_first() {
        stamps_.pop_front();
        if (lag_s_ == 0.0) return;
        positions_.forget_first();
        rotations_.forget_first();
    }

    // So much must both misses together fall, as a logarithm, before stamps are doubted.
    static constexpr double SURE = 0.2;

    double checked_interval(double time_s) const {
        if (time_s > stamps_.back()) return time_s - stamps_.back();
        throw std::invalid_argument("time_s: expected a stamp after " +
                                    std::to_string(stamps_.back()) + ", got " +
                                    std::to_string(time_s));
    }

    void follow(const StampedPose &given, double dt) {
        if (seen_ == 1) {
            usual_ = dt;
            positions_.start(first_.position, dt, lag_s_ > 0.0);
            rotations_.start(first_.rotor, dt, lag_s_ > 0.0);
        }
        if (dt > gap_s()) {
            positions_.go_on_from(given.position, dt, usual_);
            rotations_.go_on_from(given.rotor, dt, usual_);
            return;
        }
        const double fading = std::exp(-dt / memory_s_);
        const double poses = std::max(1.0, std::round(dt / usual_));
        usual_ += (1.0 - fading) * (dt / poses - usual_);
        if (seen_ > OPENING) doubt_stamps(given, dt, poses * usual_, fading);
        const double by = doubted_ ? poses * usual_ : dt;
        positions_.update(given.position, by, usual_, fading);
        rotations_.update(given.rotor, by, usual_, fading);
    }

    // Stamps are doubted while even intervals foretell poses better than they do.
    void doubt_stamps(const StampedPose &given, double dt, double even, double fading) {
        const auto moved = positions_.missed(given.position, dt, even);
        const auto turned = rotations_.missed(given.rotor, dt, even);
        const std::array<double, 4> missed{moved[0], moved[1], turned[0], turned[1]};
        for (std::size_t i = 0; i < 4; ++i) missed_[i] = fading * missed_[i] + missed[i] + 1e-300;
        const double better = std::log(missed_[0] / missed_[1]) + std::log(missed_[2] / missed_[3]);
        doubted_ = better > (doubted_ ? 0.0 : SURE);
    }

    double lag_s_, memory_s_, usual_ = 0.0;
    std::size_t seen_ = 0;
    std::array<double, 4> missed_{};
    bool doubted_ = false;
    StampedPose first_{}, last_{};
    std::deque<double> stamps_;
    Bank<Positions> positions_;
    Bank<Rotations> rotations_;
};

}  // namespace motorcade::smooth
