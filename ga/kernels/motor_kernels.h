// Motor kernels over batches of rows, free of Python.
//
// A row holds a motor's eight coefficients on 1, e23, e31, e12, e1∞, e2∞, e3∞, e123∞, or a
// bivector's six on e23, e31, e12, e1∞, e2∞, e3∞, all double. A step is the distance from one row
// to the next in doubles; step 0 repeats the first row. Outputs are dense and overlap no input.
// Nothing is validated here: motors are taken for unit, numbers for finite.
#pragma once

#include <cstddef>

namespace motorcade {

struct Rows {
    const double* first;
    std::size_t step;
};

// Geometric product a b.
void compose(Rows a, Rows b, double* out, std::size_t count);

// Reverse, which is the inverse of a unit motor.
void inverse(Rows motor, double* out, std::size_t count);

// Motors from bivectors.
void exp(Rows bivector, double* out, std::size_t count);

// Bivectors of motors; with short_way the sign is flipped first where the scalar is negative.
void log(Rows motor, double* out, std::size_t count, bool short_way);

// Screw interpolation a exp(fraction log(~a b)); fraction has one double a row.
void interpolate(Rows a, Rows b, Rows fraction, double* out, std::size_t count, bool short_way);

}  // namespace motorcade
