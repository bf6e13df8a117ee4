// Kalman filter and Rauch-Tung-Striebel smoother of constant velocity (order 1) or constant
// acceleration (order 2), over a representation.
//
// Errors are differences at the estimate. Where poses compose, an error is propagated by the
// step's own motion, X exp(u), which turns its pose part by Ad(exp(-u)) and lets a rate's error act
// through the right Jacobian; half of the turn before a straight drift and half behind it is both,
// but for a factor 1 - |u|²/24 across the axis. What so couples is one dense covariance; the rest
// is a small matrix a block, over pose, velocity and acceleration. Means are moved exactly;
// quaternions and dual quaternions are filtered as the linear components that they are taken for,
// and projected when a pose is asked for.

#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "covariance.h"
#include "representations.h"

namespace motorcade::smooth {

// Densities of the process and deviations of the measurement: rotation, translation, scale.
using BlockValues = std::array<double, 3>;

// Deviations of the rates before they have been seen, in multiples of what the first step's noise
// and the first step itself amount to as a rate.
inline constexpr double PRIOR_OF_NOISE = 1e3, PRIOR_OF_STEP = 10.0;

// A gap is as long as the process takes to add this many variances of the noise: the pose behind is
// then free of what was before. Over longer ones rates would be led on until a step turns by more
// than half a turn, and rounding would leave nothing right in the end.
inline constexpr double FORGOTTEN = 1e10;

template <class R, std::size_t Order> class Kalman {
public:
    using Real = typename NumbersOf<R>::type;
    static constexpr std::size_t S = Order + 1, BLOCKS = R::ends.size(), COUPLED = R::coupled;
    using X = Vector<R::size, Real>;
    using V = Vector<R::freedom, Real>;
    using Deviations = Vector<3, Real>;

    struct Mean {
        X pose{};
        std::array<V, Order> rates{};
    };
    struct Spread {
        Covariance<COUPLED, S, Real> coupled{};
        std::array<Covariance<1, S, Real>, BLOCKS> apart{};  // of blocks that are not coupled

        const Real &variance(std::size_t component, std::size_t derivative) const {
            if (component < COUPLED) {
                const std::size_t at = derivative * COUPLED + component;
                return coupled.p[at][at];
            }
            return apart[block_of(component)].p[derivative][derivative];
        }
    };
    struct State : Mean, Spread {};
    template <bool WITH_COVARIANCE>
    using Smoothed = std::conditional_t<WITH_COVARIANCE, State, Mean>;

    Kalman(const BlockValues &densities, const BlockValues &deviations) : densities_(densities) {
        constexpr double power = 2.0 * static_cast<double>(S) - 1.0;
        for (std::size_t b = 0; b < 3; ++b) deviations_[b] = deviations[b];
        for (std::size_t b = 0; b < BLOCKS; ++b) {
            const double ratio = deviations[b] / densities[b];
            const double longest =
                std::pow(FORGOTTEN * ratio * ratio / diffusion<S>(1.0)[0][0], 1.0 / power);
            longest_s_ = chosen(longest_s_ < longest, longest, longest_s_);
        }
    }

    X pose() const { return projected<R>(state_.pose); }
    const State &state() const { return state_; }
    const Real &log_likelihood() const { return log_likelihood_; }
    void measured_with(const Deviations &deviations) { deviations_ = deviations; }

    void start(const X &z) {
        state_ = {};
        state_.pose = z;
        steps_ = 0;
        log_likelihood_ = Real{};
        each_group(state_, [&]<std::size_t N>(Covariance<N, S, Real> &covariance, std::size_t first,
                                              std::size_t) {
            const auto variances = measurement<N>(first);
            for (std::size_t c = 0; c < N; ++c) covariance.p[c][c] = variances[c];
        });
    }

    // Gives the rates of the first state their wide prior, from what the second pose shows, before
    // it is stepped to. Doing it twice changes nothing.
    void open_rates(const X &z, const Real &interval) {
        const Real dt = chosen(longest_s_ < interval, longest_s_, interval);
        const V first_step = R::local(z, state_.pose);
        std::array<Real, BLOCKS> squares{};
        for (std::size_t k = 0; k < R::freedom; ++k)
            squares[block_of(k)] += first_step[k] * first_step[k];
        each_group(state_, [&]<std::size_t N>(Covariance<N, S, Real> &covariance, std::size_t first,
                                              std::size_t) {
            const auto variances = measurement<N>(first);
            for (std::size_t c = 0; c < N; ++c) {
                Real prior = PRIOR_OF_NOISE * PRIOR_OF_NOISE * variances[c] +
                             PRIOR_OF_STEP * PRIOR_OF_STEP * squares[block_of(first + c)];
                for (std::size_t at = N + c; at < N * S; at += N)
                    covariance.p[at][at] = prior /= dt * dt;
            }
        });
    }

    // The spread of a prediction from a state of such a mean, and of what is measured then.
    void predict(Spread &spread, const Mean &mean, const Real &interval) const {
        const Real dt = chosen(longest_s_ < interval, longest_s_, interval);
        const V way = travel(mean, dt);
        each_group(spread, [&]<std::size_t N>(Covariance<N, S, Real> &covariance, std::size_t first,
                                              std::size_t) {
            covariance.propagate(turn<N>(way, 0.5), dt);
            covariance.add_noise(process<N>(first), dt);
        });
    }
    void measure(Spread &spread) const {
        each_group(spread, [&]<std::size_t N>(Covariance<N, S, Real> &covariance, std::size_t first,
                                              std::size_t) {
            typename Covariance<N, S, Real>::Gain gain;
            covariance.measured(measurement<N>(first), gain);
        });
    }

    void step(const X &z, const Real &interval) {
        const Real dt = chosen(longest_s_ < interval, longest_s_, interval);
        if (steps_ == 0) open_rates(z, dt);
        const V way = travel(state_, dt);
        state_.pose = unprojected<R>(state_.pose, way);
        state_.rates = drifted(state_.rates, dt);
        const V innovation = R::local(z, state_.pose);
        // The first innovations only tell the rates, whose prior says nothing of the noise.
        const bool counts = ++steps_ > Order;
        V correction{};
        each_group(state_, [&]<std::size_t N>(Covariance<N, S, Real> &covariance, std::size_t first,
                                              std::size_t end) {
            covariance.propagate(turn<N>(way, 0.5), dt);
            covariance.add_noise(process<N>(first), dt);
            typename Covariance<N, S, Real>::Gain gain;
            covariance.measured(measurement<N>(first), gain);
            for (; first < end; first += N) {
                const auto part = part_of<N>(innovation, first);
                for (std::size_t c = 0; c < N; ++c) {
                    correction[first + c] = gain.of(c, part);
                    for (std::size_t i = 0; i < Order; ++i)
                        state_.rates[i][first + c] += gain.of((i + 1) * N + c, part);
                }
                if (!counts) continue;
                const auto weighed = gain.factor.solved(part);
                Real square =
                    static_cast<double>(N) * std::log(TAU) + logarithm(gain.factor.determinant);
                for (std::size_t c = 0; c < N; ++c) square += weighed[c] * part[c];
                log_likelihood_ -= 0.5 * square;
            }
        });
        state_.pose = unprojected<R>(state_.pose, correction);
    }

    // The smoothed state at `filtered` from the one `dt` later: that is freed of what the noise in
    // between may explain, and then taken back along its own motion (the RTS step). `predicted` is
    // the spread before that one was measured, and `spread()` the filtered one. A smoothed spread
    // only on demand.
    template <bool WITH_COVARIANCE, class Filtered>
    Smoothed<WITH_COVARIANCE> smoothed(const Mean &filtered, const Spread &predicted,
                                       Filtered &&spread, const Smoothed<WITH_COVARIANCE> &later,
                                       const Real &interval) const {
        const Real dt = chosen(longest_s_ < interval, longest_s_, interval);
        const V way = travel(filtered, dt);
        const X ahead = unprojected<R>(filtered.pose, way);
        Smoothed<WITH_COVARIANCE> made;
        made.rates = drifted(filtered.rates, dt);
        std::array<V, S> residual{R::local(later.pose, ahead)};
        for (std::size_t i = 0; i < Order; ++i)
            residual[i + 1] = sum(later.rates[i], scaled(-1.0, made.rates[i]));
        auto correction = residual;
        each_group(predicted, [&]<std::size_t N>(const Covariance<N, S, Real> &covariance,
                                                 std::size_t first, std::size_t end) {
            const auto noise = process<N>(first);
            const Factored<N * S, Real> factor = covariance.factored();
            for (std::size_t at = first; at < end; at += N) {
                const auto part =
                    covariance.noise_share(factor, noise, dt, gathered<N>(residual, at));
                for (std::size_t i = 0; i < S; ++i)
                    for (std::size_t c = 0; c < N; ++c) correction[i][at + c] -= part[i * N + c];
            }
            if constexpr (WITH_COVARIANCE) {
                auto &own = group<N>(made, first);
                own = group<N>(later, first);
                own.rts_step(covariance.noise_share(factor, noise, dt), noise, turn<N>(way, -0.5),
                             dt);
            }
        });
        for (std::size_t i = 0; i < Order; ++i)
            made.rates[i] = sum(made.rates[i], correction[i + 1]);
        made.rates = drifted(made.rates, -dt);
        made.pose =
            unprojected<R>(unprojected<R>(ahead, correction[0]), scaled(-1.0, travel(made, dt)));
        // Over a long way the path back is no more linear in what is corrected at its end; what is
        // known of the filtered state then bounds how far it goes.
        const auto far = (turned(way) > FARTHEST) | (turned(residual[0]) > FARTHEST);
        if (COUPLED > 0 && any(far)) {
            std::array<V, S> bounded{};
            const Spread known = spread();
            each_group(predicted, [&]<std::size_t N>(const Covariance<N, S, Real> &covariance,
                                                     std::size_t first, std::size_t end) {
                for (std::size_t at = first; at < end; at += N) {
                    const auto gained = group<N>(known, at).gained(covariance, turn<N>(way, 0.5),
                                                                   dt, gathered<N>(residual, at));
                    for (std::size_t i = 0; i < S; ++i)
                        for (std::size_t c = 0; c < N; ++c) bounded[i][at + c] = gained[i * N + c];
                }
            });
            const X pose = R::retract(filtered.pose, bounded[0]);
            for (std::size_t k = 0; k < R::size; ++k)
                made.pose[k] = chosen(far, pose[k], made.pose[k]);
            for (std::size_t i = 0; i < Order; ++i)
                for (std::size_t k = 0; k < R::freedom; ++k)
                    made.rates[i][k] =
                        chosen(far, filtered.rates[i][k] + bounded[i + 1][k], made.rates[i][k]);
        }
        return made;
    }

    static constexpr std::size_t block_of(std::size_t component) {
        std::size_t b = 0;
        while (component >= R::ends[b]) ++b;
        return b;
    }

private:
    // The square of the turn in rad up to which a step is taken back along its own motion.
    static constexpr double FARTHEST = 1.0;
    static constexpr double TAU = 6.283185307179586;

    // Calls `action<N>(covariance, first component, end)`: once for what couples, and for each
    // block that does not, whose components share their covariance.
    template <class Spreads, class Action>
    static void each_group(Spreads &spread, Action &&action) {
        if constexpr (COUPLED > 0) action.template operator()<COUPLED>(spread.coupled, 0, COUPLED);
        for (std::size_t b = 0, first = 0; b < BLOCKS; first = R::ends[b++])
            if (first >= COUPLED) action.template operator()<1>(spread.apart[b], first, R::ends[b]);
    }

    template <std::size_t N, class Spreads> static auto &group(Spreads &spread, std::size_t first) {
        if constexpr (N == COUPLED)
            return spread.coupled;
        else
            return spread.apart[block_of(first)];
    }

    // N components from `first` on of a residual's derivatives, one derivative after another.
    template <std::size_t N>
    static Vector<N * S, Real> gathered(const std::array<V, S> &residual, std::size_t first) {
        Vector<N * S, Real> made;
        for (std::size_t i = 0; i < S; ++i)
            for (std::size_t c = 0; c < N; ++c) made[i * N + c] = residual[i][first + c];
        return made;
    }

    template <std::size_t N> static Square<N, Real> turn(const V &way, double part) {
        if constexpr (N == COUPLED)
            return R::adjoint_of_inverse(scaled(part, way));
        else
            return {{{1.0}}};
    }

    template <std::size_t N> static Vector<N, Real> part_of(const V &v, std::size_t first) {
        Vector<N, Real> made;
        for (std::size_t c = 0; c < N; ++c) made[c] = v[first + c];
        return made;
    }

    template <std::size_t N> Vector<N> process(std::size_t first) const {
        Vector<N> made;
        for (std::size_t c = 0; c < N; ++c)
            made[c] = densities_[block_of(first + c)] * R::units[block_of(first + c)];
        return made;
    }

    template <std::size_t N> Vector<N, Real> measurement(std::size_t first) const {
        Vector<N, Real> made;
        for (std::size_t c = 0; c < N; ++c) {
            const Real deviation = deviations_[block_of(first + c)] * R::units[block_of(first + c)];
            made[c] = deviation * deviation;
        }
        return made;
    }

    // The square of a way's radians, where poses compose.
    MOTORCADE_INLINE static Real turned(const V &way) {
        return way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    }

    static V travel(const Mean &state, Real dt) {
        auto made = scaled(dt, state.rates[0]);
        if constexpr (Order == 2) made = sum(made, scaled(0.5 * dt * dt, state.rates[1]));
        return made;
    }

    static auto drifted(std::array<V, Order> rates, const Real &dt) {
        if constexpr (Order == 2) rates[0] = sum(rates[0], scaled(dt, rates[1]));
        return rates;
    }

    BlockValues densities_;
    Deviations deviations_;
    State state_;
    std::size_t steps_ = 0;
    Real log_likelihood_{}, longest_s_{};
};

}  // namespace motorcade::smooth
