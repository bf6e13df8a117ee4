// Equations of few parameters that all may meet, and of many small blocks that never do: the blocks
// eliminated, and what they come to. See motorcade.tracking.optimise.
//
// Triggs et al. 2000, sections 6.1 and 6.2 (Schur complement). Sums are made in one order: the same
// input gives the same bytes.

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace motorcade::adjusting {

// Blocks of `size` numbers, groups of `width`. `inverted` holds the blocks' inverses.
struct Blocks {
    std::size_t count, size, width, couplings;
    const double *inverted, *gradient, *coupling;
    const std::int64_t *block_of, *group_of;
};

// Inverts symmetric matrices in place, `count` of them; false where one has no inverse.
bool invert(double *matrices, std::size_t count, std::size_t size);

// Takes the blocks' part from the groups' symmetric matrix, whose rows are so long, and its
// right-hand side.
void eliminate(const Blocks &blocks, double *matrix, std::size_t row, double *right);

// The blocks' step, where the groups' step is `kept`.
void substitute(const Blocks &blocks, const double *kept, double *step);

}  // namespace motorcade::adjusting
