#include "blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>

#include "support.h"

#if defined(__GNUC__)
#define MOTORCADE_INLINE inline __attribute__((always_inline))
#else
#define MOTORCADE_INLINE inline
#endif

namespace motorcade::adjusting {

namespace {

// Couplings of each block, in their order: those of block k are order[first[k], first[k + 1]).
struct Order {
    std::vector<std::size_t> first, order;

    explicit Order(const Blocks &blocks) : first(blocks.count + 1), order(blocks.couplings) {
        for (std::size_t k = 0; k < blocks.couplings; ++k)
            ++first[static_cast<std::size_t>(blocks.block_of[k]) + 1];
        for (std::size_t k = 0; k < blocks.count; ++k) first[k + 1] += first[k];
        std::vector<std::size_t> next(first.begin(), first.end() - 1);
        for (std::size_t k = 0; k < blocks.couplings; ++k)
            order[next[static_cast<std::size_t>(blocks.block_of[k])]++] = k;
    }
};

// Gauss and Jordan, the largest number left on the diagonal first.
bool invert_one(double *a, std::size_t size, std::vector<std::size_t> &left) {
    left.resize(size);
    std::iota(left.begin(), left.end(), std::size_t{0});
    while (!left.empty()) {
        const auto largest = std::max_element(left.begin(), left.end(), [&](auto i, auto j) {
            return std::fabs(a[i * size + i]) < std::fabs(a[j * size + j]);
        });
        const std::size_t p = *largest;
        left.erase(largest);
        const double pivot = 1.0 / a[p * size + p];
        if (!std::isfinite(pivot)) return false;
        for (std::size_t i = 0; i < size; ++i) {
            if (i == p) continue;
            const double factor = a[i * size + p] * pivot;
            for (std::size_t j = 0; j < size; ++j)
                if (j != p) a[i * size + j] -= factor * a[p * size + j];
            a[i * size + p] = -factor;
        }
        for (std::size_t j = 0; j < size; ++j)
            if (j != p) a[p * size + j] *= pivot;
        a[p * size + p] = pivot;
    }
    return true;
}

template <class Size, class Width>
MOTORCADE_INLINE void eliminate_all(const Blocks &blocks, Size size, Width width, double *matrix,
                                    std::size_t row, double *right) {
    const Order order(blocks);
    std::vector<double> scaled;
    for (std::size_t k = 0; k < blocks.count; ++k) {
        const std::size_t *mine = order.order.data() + order.first[k];
        const std::size_t many = order.first[k + 1] - order.first[k];
        const double *inverted = blocks.inverted + k * size * size;
        const double *pull = blocks.gradient + k * size;
        scaled.assign(many * size * width, 0.0);
        for (std::size_t a = 0; a < many; ++a) {
            const double *coupling = blocks.coupling + mine[a] * size * width;
            double *to = scaled.data() + a * size * width;
            for (std::size_t i = 0; i < size; ++i)
                for (std::size_t m = 0; m < size; ++m)
                    for (std::size_t j = 0; j < width; ++j)
                        to[i * width + j] += inverted[i * size + m] * coupling[m * width + j];
        }
        for (std::size_t a = 0; a < many; ++a) {
            const double *coupling = blocks.coupling + mine[a] * size * width;
            const auto of = static_cast<std::size_t>(blocks.group_of[mine[a]]) * width;
            for (std::size_t m = 0; m < size; ++m)
                for (std::size_t j = 0; j < width; ++j)
                    right[of + j] -= scaled[(a * size + m) * width + j] * pull[m];
            for (std::size_t b = 0; b < many; ++b) {
                if (blocks.group_of[mine[b]] > blocks.group_of[mine[a]]) continue;
                const double *other = scaled.data() + b * size * width;
                const auto at = static_cast<std::size_t>(blocks.group_of[mine[b]]) * width;
                double *corner = matrix + of * row + at;
                for (std::size_t m = 0; m < size; ++m)
                    for (std::size_t i = 0; i < width; ++i)
                        for (std::size_t j = 0; j < width; ++j)
                            corner[i * row + j] -= coupling[m * width + i] * other[m * width + j];
            }
        }
    }
    for (std::size_t i = 0; i < row; ++i)
        for (std::size_t j = 0; j < i; ++j) matrix[j * row + i] = matrix[i * row + j];
}

template <std::size_t N> using Known = std::integral_constant<std::size_t, N>;

}  // namespace

// Loops whose lengths are known are unrolled: points of six numbers' poses, and poses of poses.
MOTORCADE_SIMD
void eliminate_points(const Blocks &blocks, double *matrix, std::size_t row, double *right) {
    eliminate_all(blocks, Known<3>{}, Known<6>{}, matrix, row, right);
}

MOTORCADE_SIMD
void eliminate_poses(const Blocks &blocks, double *matrix, std::size_t row, double *right) {
    eliminate_all(blocks, Known<6>{}, Known<6>{}, matrix, row, right);
}

bool invert(double *matrices, std::size_t count, std::size_t size) {
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < count; ++k)
        if (!invert_one(matrices + k * size * size, size, left)) return false;
    return true;
}

void eliminate(const Blocks &blocks, double *matrix, std::size_t row, double *right) {
    if (blocks.width == 6 && blocks.size == 3)
        eliminate_points(blocks, matrix, row, right);
    else if (blocks.width == 6 && blocks.size == 6)
        eliminate_poses(blocks, matrix, row, right);
    else
        eliminate_all(blocks, blocks.size, blocks.width, matrix, row, right);
}

void substitute(const Blocks &blocks, const double *kept, double *step) {
    const std::size_t size = blocks.size, width = blocks.width;
    std::vector<double> pull(blocks.gradient, blocks.gradient + blocks.count * size);
    for (std::size_t k = 0; k < blocks.couplings; ++k) {
        const double *coupling = blocks.coupling + k * size * width;
        const double *own = kept + static_cast<std::size_t>(blocks.group_of[k]) * width;
        double *to = pull.data() + static_cast<std::size_t>(blocks.block_of[k]) * size;
        for (std::size_t i = 0; i < size; ++i)
            for (std::size_t j = 0; j < width; ++j) to[i] += coupling[i * width + j] * own[j];
    }
    for (std::size_t k = 0; k < blocks.count; ++k)
        for (std::size_t i = 0; i < size; ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < size; ++j)
                sum += blocks.inverted[(k * size + i) * size + j] * pull[k * size + j];
            step[k * size + i] = -sum;
        }
}

}  // namespace motorcade::adjusting
