// Sums and multiples of a few numbers, beside the generated versors.h.

#pragma once

#include <array>
#include <cstddef>

namespace motorcade {

template <std::size_t N> using Vector = std::array<double, N>;
using Three = Vector<3>;
using Four = Vector<4>;

template <std::size_t N> inline double dot(const Vector<N> &a, const Vector<N> &b) {
    double total = a[0] * b[0];
    for (std::size_t k = 1; k < N; ++k) total += a[k] * b[k];
    return total;
}

template <std::size_t N> inline Vector<N> sum(const Vector<N> &a, const Vector<N> &b) {
    Vector<N> made;
    for (std::size_t k = 0; k < N; ++k) made[k] = a[k] + b[k];
    return made;
}

template <std::size_t N> inline Vector<N> scaled(double factor, const Vector<N> &a) {
    Vector<N> made;
    for (std::size_t k = 0; k < N; ++k) made[k] = factor * a[k];
    return made;
}

}  // namespace motorcade
