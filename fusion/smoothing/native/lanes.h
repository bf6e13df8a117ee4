// Rows of numbers, two at a time, as all processors have it: sums run in the order in which they
// are written, so that all give the same numbers.

#pragma once

#include <array>
#include <cstddef>

#define MOTORCADE_INLINE inline __attribute__((always_inline))

namespace motorcade::smooth {

typedef double TwoLanes __attribute__((vector_size(16), aligned(8), may_alias));

// M numbers, held in registers.
template <std::size_t M> struct LaneRow {
    static constexpr std::size_t PAIRS = M / 2;
    TwoLanes pairs[PAIRS > 0 ? PAIRS : 1];
    double last = 0.0;

    MOTORCADE_INLINE LaneRow() {
        for (auto &one : pairs) one = TwoLanes{};
    }
    MOTORCADE_INLINE explicit LaneRow(const double *row) {
        for (std::size_t q = 0; q < PAIRS; ++q) pairs[q] = pair(row, q);
        if constexpr (M % 2 == 1) last = row[M - 1];
    }
    MOTORCADE_INLINE void add(double factor, const double *row) {
        for (std::size_t q = 0; q < PAIRS; ++q) pairs[q] += factor * pair(row, q);
        if constexpr (M % 2 == 1) last += factor * row[M - 1];
    }
    MOTORCADE_INLINE void subtract(double factor, const double *row) {
        for (std::size_t q = 0; q < PAIRS; ++q) pairs[q] -= factor * pair(row, q);
        if constexpr (M % 2 == 1) last -= factor * row[M - 1];
    }
    MOTORCADE_INLINE void scale(double factor) {
        for (auto &one : pairs) one *= factor;
        last *= factor;
    }
    MOTORCADE_INLINE void write(double *row) const {
        for (std::size_t q = 0; q < PAIRS; ++q)
            *reinterpret_cast<TwoLanes *>(row + 2 * q) = pairs[q];
        if constexpr (M % 2 == 1) row[M - 1] = last;
    }

private:
    MOTORCADE_INLINE static const TwoLanes &pair(const double *row, std::size_t q) {
        return *reinterpret_cast<const TwoLanes *>(row + 2 * q);
    }
};

}  // namespace motorcade::smooth
