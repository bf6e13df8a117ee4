// Least squares on a chain: states of a pose's move and its velocity's, which touch their
// neighbours only. Normal equations are factored block by block from the first pose to the last, in
// time and memory linear in the poses; see motorcade.fusion.smoothing.batch.robust_map for the
// model.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "covariance.h"
#include "lanes.h"
#include "support.h"
#include "versors.h"

namespace motorcade::smooth {

// Inverse of q² [[dt³/3, dt²/2], [dt²/2, dt]] for q = 1.
struct StepWeights {
    double first, mixed, second;

    explicit StepWeights(double dt)
        : first(12.0 / (dt * dt * dt)), mixed(-6.0 / (dt * dt)), second(4.0 / dt) {}
};

// Eliminates a state of a symmetric block-tridiagonal matrix, after the one `before` it: `own`, of
// which only the upper half counts, becomes the upper factor Uᵀ U of what is left of it, its
// diagonal inverted; `above`, to the right of it, becomes U⁻ᵀ times itself. Row by row, and whole
// rows, so that they stay in registers.
template <std::size_t M>
MOTORCADE_INLINE void eliminated(Square<M> &own, Square<M> &above, const Square<M> *before) {
    for (std::size_t k = 0; k < M; ++k) {
        LaneRow<M> left(own[k].data()), right(above[k].data());
        if (before != nullptr)
            for (std::size_t m = 0; m < M; ++m) left.subtract((*before)[m][k], (*before)[m].data());
        for (std::size_t m = 0; m < k; ++m) {
            left.subtract(own[m][k], own[m].data());
            right.subtract(own[m][k], above[m].data());
        }
        left.write(own[k].data());
        const double inverse = 1.0 / std::sqrt(own[k][k]);
        left.scale(inverse);
        right.scale(inverse);
        left.write(own[k].data());
        right.write(above[k].data());
        own[k][k] = inverse;
    }
}
template <std::size_t M>
inline void eliminate(Square<M> &own, Square<M> &above, const Square<M> *before) {
    eliminated(own, above, before);
}

// Adds aᵀ W b for a diagonal W.
template <std::size_t N, std::size_t M>
MOTORCADE_INLINE void weighed_added(const Square<N> &a, const Vector<N> &w, const Square<N> &b,
                                    Square<M> &to) {
    for (std::size_t i = 0; i < N; ++i) {
        Vector<N> row{};
        for (std::size_t c = 0; c < N; ++c)
            for (std::size_t j = 0; j < N; ++j) row[j] += w[c] * a[c][i] * b[c][j];
        for (std::size_t j = 0; j < N; ++j) to[i][j] += row[j];
    }
}
template <std::size_t N, std::size_t M>
inline void add_weighed(const Square<N> &a, const Vector<N> &w, const Square<N> &b, Square<M> &to) {
    weighed_added(a, w, b, to);
}

// Of motors, compiled for the processor at hand; one module includes this.
MOTORCADE_SIMD void eliminate(Square<12> &own, Square<12> &above, const Square<12> *before) {
    eliminated(own, above, before);
}
MOTORCADE_SIMD void add_weighed(const Square<6> &a, const Vector<6> &w, const Square<6> &b,
                                Square<12> &to) {
    weighed_added(a, w, b, to);
}

// A symmetric block-tridiagonal matrix of blocks (M, M), factored as it grows, all but its last
// state being eliminated.
template <std::size_t M> class BlockChain {
public:
    struct State {
        Square<M> upper, ahead;  // see `eliminate`
    };

    void start(std::size_t count) {
        states_.resize(count);
        done_ = 0;
    }

    // Adds a state: its own block, of which the upper half counts, and the one `above` it to the
    // right, of rows of this state and columns of the next.
    void add(const Square<M> &own, const Square<M> &above) {
        State &state = states_[done_];
        state = {own, above};
        eliminate(state.upper, state.ahead, done_ > 0 ? &states_[done_ - 1].ahead : nullptr);
        if (!std::isfinite(state.upper[M - 1][M - 1]))
            throw std::invalid_argument("accelerations: expected sizes that rounding leaves beside "
                                        "the noise and the stamps, "
                                        "got smaller ones");
        ++done_;
    }

    // The matrix's inverse times a column of M numbers a state, in place.
    void solve(double *column) const {
        for (std::size_t n = 0; n < done_; ++n) {
            double *own = column + n * M;
            const auto &[u, ahead] = states_[n];
            for (std::size_t k = 0; k < M; ++k) {
                own[k] *= u[k][k];
                for (std::size_t i = k + 1; i < M; ++i) own[i] -= u[k][i] * own[k];
            }
            if (n + 1 == done_) break;
            for (std::size_t k = 0; k < M; ++k)
                for (std::size_t i = 0; i < M; ++i) own[M + i] -= ahead[k][i] * own[k];
        }
        for (std::size_t n = done_; n-- > 0;) {
            double *own = column + n * M;
            const auto &[u, ahead] = states_[n];
            if (n + 1 < done_)
                for (std::size_t i = 0; i < M; ++i)
                    for (std::size_t j = 0; j < M; ++j) own[i] -= ahead[i][j] * own[M + j];
            for (std::size_t i = M; i-- > 0;) {
                for (std::size_t k = i + 1; k < M; ++k) own[i] -= u[i][k] * own[k];
                own[i] *= u[i][i];
            }
        }
    }

private:
    std::vector<State> states_;
    std::size_t done_ = 0;
};

// How the vector between two poses changes with small moves of its base and of its target: parts
// (N, N) of what composes. The two differ by the commutator, the odd part of Jacobians' series.
template <std::size_t N> struct Jacobians {
    Square<N> base, target;

    explicit Jacobians(const Vector<N> &vector) {
        const Vector<N *N> left = versors::left_jacobian_inverse(vector);
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t j = 0; j < N; ++j) {
                target[i][j] = left[i * N + j];
                base[i][j] = -target[i][j];
            }
        for (std::size_t half = 0; half < std::min<std::size_t>(N, 6) / 3; ++half) {
            turn(half, 0, &vector[3 * half]);
            if (half == 1) turn(1, 1, &vector[0]);
        }
        if constexpr (N == 7)
            for (std::size_t i = 3; i < 6; ++i) {
                target[i][i] += vector[6];
                target[i][6] -= vector[i];
            }
    }

private:
    void turn(std::size_t row, std::size_t column, const double *v) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            target[3 * row + j][3 * column + i] += v[k];
            target[3 * row + i][3 * column + j] -= v[k];
        }
    }
};

// The blocks of one state of N components and their velocities, and those between it and the next.
template <std::size_t N> struct ChainBlocks {
    Square<2 * N> own{}, above{};

    // Charges a step that leaves this state or arrives at it, whose vector changes so with the
    // pose.
    void charge(const Square<N> &by_pose, const StepWeights &step, const Vector<N> &information) {
        add_weighed(by_pose, scaled(step.first, information), by_pose, own);
        for (std::size_t c = 0; c < N; ++c) {
            const double mixed = step.mixed * information[c];
            for (std::size_t i = 0; i < N; ++i) own[i][N + c] += mixed * by_pose[c][i];
            own[N + c][N + c] += step.second * information[c];
        }
    }
    void between(const Square<N> &by_base, const Square<N> &by_target, const StepWeights &step,
                 const Vector<N> &information) {
        add_weighed(by_base, scaled(step.first, information), by_target, above);
        for (std::size_t c = 0; c < N; ++c) {
            const double mixed = step.mixed * information[c];
            for (std::size_t i = 0; i < N; ++i) {
                above[i][N + c] = mixed * by_base[c][i];
                above[N + c][i] = mixed * by_target[c][i];
            }
            above[N + c][N + c] = 0.5 * step.second * information[c];
        }
    }
    // A measured vector that changes so, its own information weighed; less `bent` times the square
    // of a row of the pose's.
    void measured(const Square<N> &by_pose, const Vector<N> &information, double bent,
                  const Vector<N> &row) {
        add_weighed(by_pose, information, by_pose, own);
        for (std::size_t i = 0; i < N; ++i)
            for (std::size_t j = 0; j < N; ++j) own[i][j] -= bent * row[i] * row[j];
    }
    void damp(double damping) {
        for (std::size_t i = 0; i < 2 * N; ++i) own[i][i] *= 1.0 + damping;
    }
};

}  // namespace motorcade::smooth
