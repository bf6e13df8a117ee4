// Runs a compiled program over rows that lie anyhow in memory, free of Python.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace motorcade {

constexpr int MOST_DIMENSIONS = 16;
constexpr std::size_t BLOCK = 16;  // rows that a program computes at least

// The batch that all components broadcast to.
struct Shape {
    int dimensions = 0;
    std::array<std::size_t, MOST_DIMENSIONS> lengths{};

    std::size_t rows() const {
        std::size_t count = 1;
        for (int d = 0; d < dimensions; ++d) count *= lengths[d];
        return count;
    }
};

// One component of an input: its first number, and the bytes from one to the next along each
// dimension of the batch; without a place it is the number itself, for all rows.
struct Source {
    const char *first = nullptr;
    double number = 0.0;
    bool single = false;
    bool negative = false;  // whether its numbers are taken with the other sign
    std::array<std::ptrdiff_t, MOST_DIMENSIONS> strides{};
};

// One component of an output, in the type computed in: the batch in C order at one stride.
struct Target {
    char *first = nullptr;
    std::ptrdiff_t stride = 0;
};

// The function of a compiled program, over whole blocks of rows.
template <typename Real>
using Entry = void (*)(const Real *const *in, Real *const *out, std::size_t blocks);

// Computes all rows, shared among threads where they are many. With `finite` it says which output
// component was not finite somewhere, otherwise and where all are it says -1.
template <typename Real>
int run_rows(Entry<Real> entry, Shape shape, std::vector<Source> &sources,
             const std::vector<Target> &targets, unsigned threads, bool finite);

}  // namespace motorcade
