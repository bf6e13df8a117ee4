// Runs a generated kernel over batches that lie anyhow in memory, free of Python.
#pragma once

#include <cstddef>

#include "support.h"

namespace motorcade {

// Rows of an operand. Strides are in bytes; a single row serves any number of results.
struct Rows {
    char *first;
    std::size_t count;
    std::ptrdiff_t row_stride, component_stride;
    std::size_t readable;  // rows that may be read and written, count and padding
};

// Applies a kernel to inputs of as many rows as the output, or of one. `operands` lists inputs,
// then outputs; with `single` they are float, otherwise double. Large batches are shared among
// `threads` threads. Gives whether all inputs were finite, if that is to be `checked`, else true.
bool run(const motorcade_kernel &kernel, const Rows *operands, bool single, bool checked,
         unsigned threads);

}  // namespace motorcade
