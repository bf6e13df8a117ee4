// Rows of numbers, one after the other, taken apart into their components.

#pragma once

#include <cstddef>

namespace motorcade {

// Component j of row i, `rows[i * apart + j]`, goes to `to[j * step + i]`. Widths of 3, and
// multiples of 4 up to 16, are fast. Gives whether all are finite, if that is to be `checked`, else
// true.
bool split_rows(const float *rows, std::ptrdiff_t apart, std::size_t count, std::size_t width,
                float *to, std::size_t step, bool checked);
bool split_rows(const double *rows, std::ptrdiff_t apart, std::size_t count, std::size_t width,
                double *to, std::size_t step, bool checked);

// Whether all of `count` numbers are finite.
bool all_finite(const float *numbers, std::size_t count);
bool all_finite(const double *numbers, std::size_t count);

}  // namespace motorcade
