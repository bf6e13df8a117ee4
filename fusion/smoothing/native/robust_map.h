// The most probable path under white acceleration, by reweighted least squares on its chain; the
// model is in motorcade.fusion.smoothing.batch.robust_map. Moves of a state lie in rows of 2 d
// numbers: of the pose, and of the velocity.

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "chain.h"
#include "representations.h"

namespace motorcade::smooth {

enum class Loss { squares, huber, cauchy };

struct RobustLoss {
    Loss kind;
    double width;

    // ρ(s), equal to s where it is small.
    double charged(double s) const {
        const double bound = width * width;
        if (kind == Loss::cauchy) return bound * std::log1p(s / bound);
        if (kind == Loss::huber && s > bound) return 2.0 * width * std::sqrt(s) - bound;
        return s;
    }
    // ρ'(s).
    double weight(double s) const {
        const double bound = width * width;
        if (kind == Loss::cauchy) return 1.0 / (1.0 + s / bound);
        if (kind == Loss::huber) return width / std::sqrt(std::max(s, bound));
        return 1.0;
    }
    // -2 s ρ''(s) / ρ'(s), the share of the curvature along a residual that its weight loses by
    // being followed; all of it, where it would lose more.
    double lost(double s) const {
        const double bound = width * width;
        if (kind == Loss::cauchy) return std::min(1.0, 2.0 * s / (bound + s));
        return kind == Loss::huber && s > bound ? 1.0 : 0.0;
    }
};

// What is measured of N poses, d the freedom of the representation and D the size of its rows.
struct MeasuredPath {
    std::size_t count;
    const double *interval_s;       // (N - 1)
    const double *coordinates;      // (N, D)
    const bool *among;              // (N), poses that have a say
    const double *noise, *density;  // (d)
};

template <Representation R> class RobustDescent {
public:
    static constexpr std::size_t D = R::size, F = R::freedom, COUPLED = R::coupled,
                                 BLOCKS = R::ends.size();
    using X = Vector<D>;
    using V = Vector<F>;

    RobustDescent(const MeasuredPath &given, const RobustLoss &loss)
        : given_(given), loss_(loss), now_(given.count), tried_(given.count),
          move_(given.count * 2 * F) {
        for (std::size_t c = 0; c < F; ++c) {
            precision_[c] = 1.0 / (given.noise[c] * given.noise[c]);
            process_[c] = 1.0 / (given.density[c] * given.density[c]);
        }
    }

    void start(const double *coordinates, const double *velocity) {
        for (std::size_t n = 0; n < given_.count; ++n) {
            std::copy_n(coordinates + n * D, D, now_.poses[n].begin());
            std::copy_n(velocity + n * F, F, now_.velocity[n].begin());
        }
        cost_ = linearise(now_);
    }

    // Lowers the cost until it does not fall any more, or no pose moved by more than `converged`
    // deviations of the noise. A step follows the weights where that leads down, else it takes them
    // for fixed, and goes less far.
    void descend(int steps, double converged) {
        double damping = 0.0;
        while (steps-- > 0) {
            bool falls = damping == 0.0 && moved(0.0, true);
            while (!falls && damping <= NO_MORE_DAMPING) {
                falls = moved(damping, false);
                if (!falls) damping = std::max(10.0 * damping, LEAST_DAMPING);
            }
            if (!falls) return;
            const bool ends = largest_move() < converged;
            std::swap(now_, tried_);
            std::swap(cost_, tried_cost_);
            damping = damping > LEAST_DAMPING ? 0.1 * damping : 0.0;
            if (ends) return;
        }
    }

    // Factors the normal equations, and puts their right-hand side into the moves.
    void factor(double damping, bool follow_weights);
    // The normal equations' inverse times columns (N, 2 d, k), one of them, in place.
    void solve(double *column, std::size_t stride);

    double cost() const { return cost_; }
    const std::vector<double> &moves() const { return move_; }
    void write(double *coordinates, double *velocity, double *squares) const {
        for (std::size_t n = 0; n < given_.count; ++n) {
            std::copy(now_.poses[n].begin(), now_.poses[n].end(), coordinates + n * D);
            std::copy(now_.velocity[n].begin(), now_.velocity[n].end(), velocity + n * F);
        }
        std::copy(now_.squares.begin(), now_.squares.end(), squares);
    }

private:
    static constexpr double ROUNDING = 1e-12, NO_MORE_DAMPING = 1e8, LEAST_DAMPING = 1e-6;
    // Where nothing composes there is nothing of this size.
    static constexpr std::size_t N = std::max<std::size_t>(COUPLED, 1);

    // A path with its vectors: from each pose to the next, and from the measured ones.
    struct Path {
        std::vector<X> poses;
        std::vector<V> velocity, steps, measured;
        std::vector<double> squares;

        explicit Path(std::size_t count)
            : poses(count), velocity(count), steps(count - 1), measured(count), squares(count) {}
    };

    X given(std::size_t n) const {
        X made;
        std::copy_n(given_.coordinates + n * D, D, made.begin());
        return made;
    }

    // Takes the vectors at a path's poses; returns what it is charged.
    double linearise(Path &path) const {
        double prior = 0.0, data = 0.0;
        for (std::size_t n = 0; n < given_.count; ++n) {
            const V measured = path.measured[n] = R::local(path.poses[n], given(n));
            double square = 0.0;
            for (std::size_t c = 0; c < F; ++c) square += measured[c] * measured[c] * precision_[c];
            path.squares[n] = square;
            if (given_.among[n]) data += loss_.charged(square);
            if (n + 1 == given_.count) break;
            path.steps[n] = R::local(path.poses[n + 1], path.poses[n]);
            const StepWeights weights(given_.interval_s[n]);
            for (std::size_t c = 0; c < F; ++c) {
                const auto [first, second] = residual(path, n, c);
                prior += process_[c] *
                         (weights.first * first * first + 2.0 * weights.mixed * first * second +
                          weights.second * second * second);
            }
        }
        return prior + data;
    }

    // What a component's step and its change of velocity leave of constant velocity.
    std::array<double, 2> residual(const Path &path, std::size_t n, std::size_t c) const {
        return {path.steps[n][c] - given_.interval_s[n] * path.velocity[n][c],
                path.velocity[n + 1][c] - path.velocity[n][c]};
    }

    // Adds what a component's step pulls at both velocities; returns what it pulls at its vector.
    double pulled(std::size_t n, std::size_t c, const StepWeights &step) {
        const auto [first, second] = residual(now_, n, c);
        const double pull = -process_[c] * (step.first * first + step.mixed * second);
        const double push = -process_[c] * (step.mixed * first + step.second * second);
        move(n)[F + c] -= given_.interval_s[n] * pull + push;
        move(n + 1)[F + c] += push;
        return pull;
    }

    double *move(std::size_t n) { return &move_[n * 2 * F]; }
    const double *move(std::size_t n) const { return &move_[n * 2 * F]; }

    double weight(std::size_t n) const {
        return given_.among[n] ? loss_.weight(now_.squares[n]) : 0.0;
    }

    void factor_coupled(double damping, bool follow_weights);
    void factor_apart(std::size_t block, std::size_t first, double damping);

    // Takes a step into `tried_`; whether that is charged no more.
    bool moved(double damping, bool follow_weights) {
        factor(damping, follow_weights);
        solve(move_.data(), 1);
        for (std::size_t n = 0; n < given_.count; ++n) {
            V pose, velocity;
            std::copy_n(move(n), F, pose.begin());
            std::copy_n(move(n) + F, F, velocity.begin());
            tried_.poses[n] = R::retract(now_.poses[n], pose);
            tried_.velocity[n] = sum(now_.velocity[n], velocity);
        }
        tried_cost_ = linearise(tried_);
        return tried_cost_ <= cost_ * (1.0 + ROUNDING);
    }

    // Of the poses that were tried, in deviations of the noise: components that are put back to
    // where poses are move by less than their step.
    double largest_move() const {
        double largest = 0.0;
        for (std::size_t n = 0; n < given_.count; ++n)
            for (std::size_t c = 0; c < F; ++c) {
                double by = move(n)[c];
                if constexpr (COUPLED == 0) by = tried_.poses[n][c] - now_.poses[n][c];
                largest = std::max(largest, std::abs(by) / given_.noise[c]);
            }
        return largest;
    }

    static Jacobians<N> jacobians(const V &vector) {
        Vector<N> part;
        std::copy_n(vector.begin(), N, part.begin());
        return Jacobians<N>(part);
    }

    // Adds a part's transpose times a vector to a move.
    static void push_back(const Square<N> &part, const Vector<N> &vector, double *move) {
        for (std::size_t c = 0; c < N; ++c)
            for (std::size_t i = 0; i < N; ++i) move[i] += part[c][i] * vector[c];
    }

    MeasuredPath given_;
    RobustLoss loss_;
    V precision_, process_;
    Path now_, tried_;
    double cost_ = std::numeric_limits<double>::infinity(), tried_cost_ = cost_;
    std::vector<double> move_, scratch_;
    BlockChain<2 * N> coupled_;
    std::array<BlockChain<2>, BLOCKS> apart_;
};

template <Representation R> void RobustDescent<R>::factor(double damping, bool follow_weights) {
    std::fill(move_.begin(), move_.end(), 0.0);
    if constexpr (COUPLED > 0) factor_coupled(damping, follow_weights);
    for (std::size_t b = 0, first = 0; b < BLOCKS; first = R::ends[b++])
        if (first >= COUPLED) factor_apart(b, first, damping);
}

template <Representation R>
void RobustDescent<R>::factor_coupled(double damping, bool follow_weights) {
    Vector<N> process;
    std::copy_n(process_.begin(), N, process.begin());
    coupled_.start(given_.count);
    Square<N> arriving{};
    for (std::size_t n = 0; n < given_.count; ++n) {
        ChainBlocks<N> blocks;
        if (n > 0) blocks.charge(arriving, StepWeights(given_.interval_s[n - 1]), process);
        const auto seen = jacobians(now_.measured[n]);
        const double weighed = weight(n), square = now_.squares[n];
        Vector<N> information, vector, pull{};
        for (std::size_t c = 0; c < N; ++c) {
            information[c] = weighed * precision_[c];
            vector[c] = -information[c] * now_.measured[n][c];
        }
        push_back(seen.target, vector, pull.data());
        double bent = 0.0;
        if (follow_weights && weighed > 0.0 && square > 0.0)
            bent = loss_.lost(square) / (weighed * square);
        blocks.measured(seen.target, information, bent, pull);
        for (std::size_t c = 0; c < N; ++c) move(n)[c] += pull[c];
        if (n + 1 < given_.count) {
            const StepWeights step(given_.interval_s[n]);
            const auto way = jacobians(now_.steps[n]);
            for (std::size_t c = 0; c < N; ++c) vector[c] = pulled(n, c, step);
            push_back(way.base, vector, move(n));
            push_back(way.target, vector, move(n + 1));
            blocks.charge(way.base, step, process);
            blocks.between(way.base, way.target, step, process);
            arriving = way.target;
        }
        blocks.damp(damping);
        coupled_.add(blocks.own, blocks.above);
    }
}

template <Representation R>
void RobustDescent<R>::factor_apart(std::size_t block, std::size_t first, double damping) {
    constexpr Square<1> one{{{1.0}}}, minus{{{-1.0}}};
    const Vector<1> process{process_[first]};
    apart_[block].start(given_.count);
    for (std::size_t n = 0; n < given_.count; ++n) {
        ChainBlocks<1> blocks;
        const double weighed = weight(n);
        blocks.measured(one, {weighed * precision_[first]}, 0.0, {});
        for (std::size_t c = first; c < R::ends[block]; ++c)
            move(n)[c] -= weighed * precision_[c] * now_.measured[n][c];
        if (n > 0) blocks.charge(one, StepWeights(given_.interval_s[n - 1]), process);
        if (n + 1 < given_.count) {
            const StepWeights step(given_.interval_s[n]);
            for (std::size_t c = first; c < R::ends[block]; ++c) {
                const double pull = pulled(n, c, step);
                move(n)[c] -= pull;
                move(n + 1)[c] += pull;
            }
            blocks.charge(minus, step, process);
            blocks.between(minus, one, step, process);
        }
        blocks.damp(damping);
        apart_[block].add(blocks.own, blocks.above);
    }
}

template <Representation R> void RobustDescent<R>::solve(double *column, std::size_t stride) {
    const auto solved = [&](const auto &chain, std::size_t first, std::size_t size) {
        scratch_.resize(given_.count * 2 * size);
        for (int back = 0; back < 2; ++back) {
            double *at = scratch_.data();
            for (std::size_t n = 0; n < given_.count; ++n)
                for (std::size_t half = 0; half < 2; ++half)
                    for (std::size_t c = first; c < first + size; ++c) {
                        double &there = column[((2 * n + half) * F + c) * stride];
                        back ? there = *at++ : *at++ = there;
                    }
            if (!back) chain.solve(scratch_.data());
        }
    };
    if constexpr (COUPLED > 0) solved(coupled_, 0, COUPLED);
    for (std::size_t c = COUPLED; c < F; ++c) {
        std::size_t block = 0;
        while (c >= R::ends[block]) ++block;
        solved(apart_[block], c, 1);
    }
}

}  // namespace motorcade::smooth
