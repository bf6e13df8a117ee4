// The pass backwards over the intervals of an orientation filter: the corrections that every
// instant would have had from all later measurements. Modified Bryson-Frazier form, which needs no
// inverse: G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control
// 18, 1973.

#pragma once

#include <vector>

#include "filter.h"

namespace motorcade::orientation {

// Errors that remain after each node's own correction, `later[m]`, by all nodes after it.
inline std::vector<State> corrections(const std::vector<Node> &nodes, const Settings &set) {
    std::vector<State> later(nodes.size());
    State adjoint{};
    for (std::size_t m = nodes.size(); m-- > 0;) {
        const Node &node = nodes[m];
        std::size_t at = 0;
        for (std::size_t i = 0; i < ERRORS; ++i) {
            for (std::size_t j = 0; j <= i; ++j, ++at) {
                later[m][i] += node.covariance[at] * adjoint[j];
                if (j < i) later[m][j] += node.covariance[at] * adjoint[i];
            }
        }
        for (std::size_t c = node.count; c-- > 0;) {
            const Measured &measured = node.measured[c];
            const State h = Filter::slope(measured.kind, measured.axis, node.lasted, set);
            double push = measured.innovation / measured.variance;
            for (std::size_t j = 0; j < ERRORS; ++j) push -= measured.gain[j] * adjoint[j];
            for (std::size_t j = 0; j < ERRORS; ++j) adjoint[j] += h[j] * push;
        }
        // The transposed transition: the turn by bias and scale, before that velocity by the tilt.
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) {
                adjoint[BIAS + j] -= node.turned[i][j] * adjoint[TURN + i];
                adjoint[SCALE + j] -= node.wound[i][j] * adjoint[TURN + i];
            }
        }
        if (node.gap) {
            adjoint[VELOCITY] = adjoint[VELOCITY + 1] = 0.0;
        } else {
            const double lean = set.gravity * node.before;
            adjoint[TURN + 1] += lean * adjoint[VELOCITY];
            adjoint[TURN] -= lean * adjoint[VELOCITY + 1];
        }
    }
    // `adjoint` now holds what all measurements say of the first state, which `begin` guessed.
    return later;
}

}  // namespace motorcade::orientation
