// The pass backwards over the intervals of an orientation filter: the corrections that every
// instant would have had from all later measurements. Modified Bryson-Frazier form, which needs no
// inverse: G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control
// 18, 1973.

#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "model.h"

namespace motorcade::orientation {

// What later measurements say of a node: the error that remains after its own correction, and the
// deviations of tilt (both axes together) and heading then.
struct Later {
    State error{};
    double tilt = 0.0, heading = 0.0;
};

class Backward {
public:
    explicit Backward(const Settings &settings) : set_(settings) {}

    // Nodes from the last to the first, one at a time.
    Later pass(const Node &node) {
        const Later found = correction(node);
        for (std::size_t c = node.count; c-- > 0;) take(node.measured[c], node.lasted);
        transpose_transition(adjoint_, node);
        for (int side = 0; side < 2; ++side) {
            for (State &row : information_) transpose_transition(row, node);
            transpose(information_);
        }
        return found;
    }

private:
    Later correction(const Node &node) const {
        Square covariance;
        std::size_t at = 0;
        for (std::size_t i = 0; i < ERRORS; ++i)
            for (std::size_t j = 0; j <= i; ++j, ++at)
                covariance[i][j] = covariance[j][i] = node.covariance[at];
        Later found;
        for (std::size_t i = 0; i < ERRORS; ++i)
            for (std::size_t j = 0; j < ERRORS; ++j)
                found.error[i] += covariance[i][j] * adjoint_[j];
        Three variance;
        for (std::size_t i = 0; i < 3; ++i) {
            variance[i] = covariance[i][i];
            for (std::size_t j = 0; j < ERRORS; ++j) {
                double known = 0.0;
                for (std::size_t k = 0; k < ERRORS; ++k)
                    known += information_[j][k] * covariance[i][k];
                variance[i] -= known * covariance[i][j];
            }
            variance[i] = std::max(0.0, variance[i]);
        }
        found.tilt = std::sqrt(variance[0] + variance[1]);
        found.heading = std::sqrt(variance[2]);
        return found;
    }

    void take(const Measured &measured, double lasted) {
        const State h = slope(measured, lasted, set_);
        double push = measured.innovation / measured.variance, weight = 1.0 / measured.variance;
        State moved{};
        for (std::size_t i = 0; i < ERRORS; ++i) {
            for (std::size_t j = 0; j < ERRORS; ++j)
                moved[i] += information_[i][j] * measured.gain[j];
            push -= measured.gain[i] * adjoint_[i];
        }
        for (std::size_t i = 0; i < ERRORS; ++i) weight += measured.gain[i] * moved[i];
        for (std::size_t i = 0; i < ERRORS; ++i) {
            adjoint_[i] += h[i] * push;
            for (std::size_t j = 0; j < ERRORS; ++j)
                information_[i][j] += h[i] * h[j] * weight - moved[i] * h[j] - h[i] * moved[j];
        }
    }

    // The transposed transition: the turn by bias and matrix, before that velocity by the tilt.
    void transpose_transition(State &adjoint, const Node &node) const {
        for (std::size_t i = 0; i < 3; ++i) {
            const double turn = adjoint[TURN + i];
            for (std::size_t j = 0; j < 3; ++j) adjoint[BIAS + j] -= node.turned[i][j] * turn;
            for (std::size_t j = 0; j < 9; ++j) adjoint[MATRIX + j] -= node.wound[i][j] * turn;
        }
        if (node.gap) {
            adjoint[VELOCITY] = adjoint[VELOCITY + 1] = 0.0;
        } else {
            const double lean = set_.gravity * node.before;
            adjoint[TURN + 1] += lean * adjoint[VELOCITY];
            adjoint[TURN] -= lean * adjoint[VELOCITY + 1];
        }
    }

    const Settings &set_;
    State adjoint_{};  // what all later measurements say, and how much they know
    Square information_{};
};

}  // namespace motorcade::orientation
