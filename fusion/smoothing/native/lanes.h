// Rows of numbers, two at a time, as all processors have it, and rows of lanes, numbers of paths
// that run side by side: sums run in the order in which they are written, so that all give the same
// numbers.

#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#define MOTORCADE_INLINE inline __attribute__((always_inline))

namespace motorcade::smooth {

// A number of each of eight paths. Functions that are not inlined take it by reference, as
// processors pass it differently.
struct alignas(64) Lanes {
    typedef double Eight __attribute__((vector_size(64)));
    using Holds = decltype(Eight{} < Eight{});
    static constexpr std::size_t COUNT = 8;
    Eight of;

    Lanes() = default;
    MOTORCADE_INLINE Lanes(double all) : of(Eight{} + all) {}
    MOTORCADE_INLINE explicit Lanes(const Eight &each) : of(each) {}

    MOTORCADE_INLINE double &operator[](std::size_t k) {
        return reinterpret_cast<double *>(&of)[k];
    }
    MOTORCADE_INLINE double operator[](std::size_t k) const { return of[k]; }
    MOTORCADE_INLINE Lanes operator-() const { return Lanes(-of); }
};
#define MOTORCADE_LANES(OP)                                                                        \
    MOTORCADE_INLINE Lanes &operator OP##=(Lanes &a, const Lanes &b) {                             \
        return a.of OP## = b.of, a;                                                                \
    }                                                                                              \
    MOTORCADE_INLINE Lanes operator OP(Lanes a, const Lanes &b) { return a OP## = b; }
MOTORCADE_LANES(+)
MOTORCADE_LANES(-)
MOTORCADE_LANES(*)
MOTORCADE_LANES(/)
#undef MOTORCADE_LANES
MOTORCADE_INLINE auto operator<(const Lanes &a, const Lanes &b) { return a.of < b.of; }
MOTORCADE_INLINE auto operator>(const Lanes &a, const Lanes &b) { return a.of > b.of; }

// Written for both: how many there are, one of them, what to take where something holds, and
// whether it does anywhere.
template <class Real> inline constexpr std::size_t LANES = sizeof(Real) / sizeof(double);
inline double &lane(double &of, std::size_t) { return of; }
inline double &lane(Lanes &of, std::size_t k) { return of[k]; }
MOTORCADE_INLINE double chosen(bool holds, double a, double b) { return holds ? a : b; }
MOTORCADE_INLINE Lanes chosen(const Lanes::Holds &holds, const Lanes &a, const Lanes &b) {
    return Lanes(holds ? a.of : b.of);
}
MOTORCADE_INLINE bool any(bool holds) { return holds; }
MOTORCADE_INLINE bool any(const Lanes::Holds &holds) {
    bool found = false;
    for (std::size_t k = 0; k < Lanes::COUNT; ++k) found |= holds[k] != 0;
    return found;
}
template <class Real> MOTORCADE_INLINE Real logarithm(Real of) {
    for (std::size_t k = 0; k < LANES<Real>; ++k) lane(of, k) = std::log(lane(of, k));
    return of;
}

template <class Real> struct Held { typedef Real Wide; };
template <> struct Held<double> {
    typedef double Wide __attribute__((vector_size(16), aligned(8), may_alias));
};

// M numbers, or M of lanes, held in registers.
template <std::size_t M, class Real = double> struct LaneRow {
    using Wide = typename Held<Real>::Wide;
    static constexpr std::size_t STEP = sizeof(Wide) / sizeof(Real), PARTS = M / STEP;
    Wide parts[PARTS > 0 ? PARTS : 1];
    Real last{};

    MOTORCADE_INLINE LaneRow() {
        for (auto &one : parts) one = Wide{};
    }
    MOTORCADE_INLINE explicit LaneRow(const Real *row) {
        for (std::size_t q = 0; q < PARTS; ++q) parts[q] = part(row, q);
        if constexpr (M % STEP == 1) last = row[M - 1];
    }
    MOTORCADE_INLINE void add(const Real &factor, const Real *row) {
        for (std::size_t q = 0; q < PARTS; ++q) parts[q] += factor * part(row, q);
        if constexpr (M % STEP == 1) last += factor * row[M - 1];
    }
    MOTORCADE_INLINE void subtract(const Real &factor, const Real *row) {
        for (std::size_t q = 0; q < PARTS; ++q) parts[q] -= factor * part(row, q);
        if constexpr (M % STEP == 1) last -= factor * row[M - 1];
    }
    MOTORCADE_INLINE void scale(const Real &factor) {
        for (auto &one : parts) one *= factor;
        last *= factor;
    }
    MOTORCADE_INLINE void write(Real *row) const {
        for (std::size_t q = 0; q < PARTS; ++q) reinterpret_cast<Wide *>(row)[q] = parts[q];
        if constexpr (M % STEP == 1) row[M - 1] = last;
    }

private:
    MOTORCADE_INLINE static const Wide &part(const Real *row, std::size_t q) {
        return reinterpret_cast<const Wide *>(row)[q];
    }
};

}  // namespace motorcade::smooth
