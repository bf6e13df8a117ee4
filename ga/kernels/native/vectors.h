// Sums and multiples of a few numbers, beside the generated versors.h.

#pragma once

#include <array>
#include <cstddef>

namespace motorcade {

template <std::size_t N, class Real = double> using Vector = std::array<Real, N>;
using Three = Vector<3>;
using Four = Vector<4>;

template <std::size_t N> inline double dot(const Vector<N> &a, const Vector<N> &b) {
    double total = a[0] * b[0];
    for (std::size_t k = 1; k < N; ++k) total += a[k] * b[k];
    return total;
}

template <std::size_t N, class Real>
inline std::array<Real, N> sum(const std::array<Real, N> &a, const std::array<Real, N> &b) {
    std::array<Real, N> made;
    for (std::size_t k = 0; k < N; ++k) made[k] = a[k] + b[k];
    return made;
}

template <class Factor, std::size_t N, class Real>
inline std::array<Real, N> scaled(const Factor &factor, const std::array<Real, N> &a) {
    std::array<Real, N> made;
    for (std::size_t k = 0; k < N; ++k) made[k] = factor * a[k];
    return made;
}

}  // namespace motorcade
