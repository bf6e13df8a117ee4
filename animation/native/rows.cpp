// Hot loops over rows of palettes and poses; see rows.h.

#include "rows.h"

#include <cstring>

namespace motorcade::animation {
namespace {

// Four numbers that stay in one register on any processor with SIMD.
typedef float four __attribute__((vector_size(16)));
typedef std::int32_t four_bits __attribute__((vector_size(16)));

#define SHUFFLED __builtin_shufflevector
#define APART __restrict__

inline four load(const float *from) {
    four made;
    std::memcpy(&made, from, sizeof made);
    return made;
}

inline void store(float *to, four value) { std::memcpy(to, &value, sizeof value); }

// Weights of the second to the fourth joint, negative where the rotor of one points away from the
// first joint's; that of the first stays.
inline four signed_weights(four weights, four a, four b, four c, four d) {
    const four ab = a * b, ac = a * c, ad = a * d;
    const four bc = SHUFFLED(ab, ac, 0, 4, 1, 5) + SHUFFLED(ab, ac, 2, 6, 3, 7);
    const four dd = SHUFFLED(ad, ad, 0, 4, 1, 5) + SHUFFLED(ad, ad, 2, 6, 3, 7);
    const four dots = SHUFFLED(bc, dd, 0, 0, 1, 4) + SHUFFLED(bc, dd, 2, 2, 3, 6);
    const four_bits flips = (dots < four{}) & four_bits{0, INT32_MIN, INT32_MIN, INT32_MIN};
    four_bits bits;
    std::memcpy(&bits, &weights, sizeof bits);
    bits ^= flips;
    std::memcpy(&weights, &bits, sizeof bits);
    return weights;
}

// Four rows of four, row by row in and column by column out.
inline void store_columns(const four *rows, float *to, std::size_t step) {
    const four ab = SHUFFLED(rows[0], rows[1], 0, 4, 1, 5),
               cd = SHUFFLED(rows[2], rows[3], 0, 4, 1, 5);
    const four ba = SHUFFLED(rows[0], rows[1], 2, 6, 3, 7),
               dc = SHUFFLED(rows[2], rows[3], 2, 6, 3, 7);
    store(to, SHUFFLED(ab, cd, 0, 1, 4, 5));
    store(to + step, SHUFFLED(ab, cd, 2, 3, 6, 7));
    store(to + 2 * step, SHUFFLED(ba, dc, 0, 1, 4, 5));
    store(to + 3 * step, SHUFFLED(ba, dc, 2, 3, 6, 7));
}

// Sums four vertices of `groups` times four components that follow one or two joints, and lays the
// components apart.
inline void sum_two(const float *APART palette, const std::uint16_t *APART joints,
                    const float *APART weights, std::size_t groups, bool with_signs,
                    float *APART sums, std::size_t step) {
    four rows[3][4];
    for (std::size_t i = 0; i < 4; ++i) {
        const float *a = palette + 4 * groups * joints[4 * i];
        const float *b = palette + 4 * groups * joints[4 * i + 1];
        const float first = weights[4 * i];
        float second = weights[4 * i + 1];
        if (with_signs) {
            const four products = load(a) * load(b);
            const float dot = (products[0] + products[1]) + (products[2] + products[3]);
            second = dot < 0.0F ? -second : second;
        }
        for (std::size_t k = 0; k < groups; ++k)
            rows[k][i] = first * load(a + 4 * k) + second * load(b + 4 * k);
    }
    for (std::size_t k = 0; k < groups; ++k) store_columns(rows[k], sums + 4 * k * step, step);
}

// The same of vertices that follow up to four joints.
inline void sum_up_to_four(const float *APART palette, const std::uint16_t *APART joints,
                           const float *APART weights, std::size_t groups, bool with_signs,
                           float *APART sums, std::size_t step) {
    four rows[3][4];
    for (std::size_t i = 0; i < 4; ++i) {
        const float *a = palette + 4 * groups * joints[4 * i];
        const float *b = palette + 4 * groups * joints[4 * i + 1];
        const float *c = palette + 4 * groups * joints[4 * i + 2];
        const float *d = palette + 4 * groups * joints[4 * i + 3];
        four w = load(weights + 4 * i);
        if (with_signs) w = signed_weights(w, load(a), load(b), load(c), load(d));
        for (std::size_t k = 0; k < groups; ++k)
            rows[k][i] = w[0] * load(a + 4 * k) + w[1] * load(b + 4 * k) + w[2] * load(c + 4 * k) +
                         w[3] * load(d + 4 * k);
    }
    for (std::size_t k = 0; k < groups; ++k) store_columns(rows[k], sums + 4 * k * step, step);
}

// Each row of the product is a sum of the second's rows; the first's translation is added.
inline void multiply_matrix(const float *APART a, const float *APART b, float *APART out) {
    const four x = load(b), y = load(b + 4), z = load(b + 8);
    for (std::size_t row = 0; row < 3; ++row) {
        const four p = load(a + 4 * row), moved = {0.0f, 0.0f, 0.0f, p[3]};
        store(out + 4 * row, p[0] * x + p[1] * y + p[2] * z + moved);
    }
}

// Eight numbers, in one register or two.
typedef float eight __attribute__((vector_size(32)));

// The geometric product of two rows: what `versors::compose` sums, a component of the first row at
// a time. Products with the last four leave the rotor alone.
inline void multiply_motor(const float *APART a, const float *APART b, float *APART out) {
    eight m;
    std::memcpy(&m, b, sizeof m);
    const four r = SHUFFLED(m, m, 0, 1, 2, 3);
    const eight by1 = eight{-1, 1, 1, -1, -1, 1, -1, 1} * SHUFFLED(m, m, 1, 0, 3, 2, 7, 6, 5, 4);
    const eight by2 = eight{-1, -1, 1, 1, -1, -1, 1, 1} * SHUFFLED(m, m, 2, 3, 0, 1, 6, 7, 4, 5);
    const eight by3 = eight{-1, 1, -1, 1, 1, -1, -1, 1} * SHUFFLED(m, m, 3, 2, 1, 0, 5, 4, 7, 6);
    const four by4 = four{1, 1, -1, 1} * SHUFFLED(r, r, 0, 3, 2, 1);
    const four by5 = four{-1, 1, 1, 1} * SHUFFLED(r, r, 3, 0, 1, 2);
    const four by6 = four{1, -1, 1, 1} * SHUFFLED(r, r, 2, 1, 0, 3);
    const four by7 = four{-1, -1, -1, 1} * SHUFFLED(r, r, 1, 2, 3, 0);
    const eight product = (a[0] * m + a[1] * by1) + (a[2] * by2 + a[3] * by3);
    const four ideal = (a[4] * by4 + a[5] * by5) + (a[6] * by6 + a[7] * by7);
    store(out, SHUFFLED(product, product, 0, 1, 2, 3));
    store(out + 4, SHUFFLED(product, product, 4, 5, 6, 7) + ideal);
}

}  // namespace

MOTORCADE_SIMD
void sum_versors(const float *palette, const std::uint16_t *joints, const float *weights,
                 const std::uint8_t *few, std::size_t count, float *sums, std::size_t step) {
    for (std::size_t i = 0; i < count; i += 4)
        if (few[i / 4])
            sum_two(palette, joints + 4 * i, weights + 4 * i, 2, true, sums + i, step);
        else
            sum_up_to_four(palette, joints + 4 * i, weights + 4 * i, 2, true, sums + i, step);
}

MOTORCADE_SIMD
void sum_matrices(const float *palette, const std::uint16_t *joints, const float *weights,
                  const std::uint8_t *few, std::size_t count, float *sums, std::size_t step) {
    for (std::size_t i = 0; i < count; i += 4)
        if (few[i / 4])
            sum_two(palette, joints + 4 * i, weights + 4 * i, 3, false, sums + i, step);
        else
            sum_up_to_four(palette, joints + 4 * i, weights + 4 * i, 3, false, sums + i, step);
}

MOTORCADE_SIMD
void sum_similarities(const float *palette, const std::uint16_t *joints, const float *weights,
                      const std::uint8_t *few, std::size_t count, float *sums, std::size_t step) {
    for (std::size_t i = 0; i < count; i += 4)
        if (few[i / 4])
            sum_two(palette, joints + 4 * i, weights + 4 * i, 3, true, sums + i, step);
        else
            sum_up_to_four(palette, joints + 4 * i, weights + 4 * i, 3, true, sums + i, step);
}

MOTORCADE_SIMD
void write_rows(const float *APART skinned, std::size_t step, std::size_t count,
                float *APART positions, float *APART normals) {
    float *const outs[2] = {positions, normals};
    for (std::size_t half = 0; half < 2; ++half) {
        const float *APART from = skinned + 3 * half * step;
        float *APART to = outs[half];
        std::size_t i = 0;
        for (; i + 4 <= count; i += 4) {
            const four x = load(from + i), y = load(from + step + i), z = load(from + 2 * step + i);
            const four xy = SHUFFLED(x, y, 0, 4, 1, 5), yx = SHUFFLED(x, y, 2, 6, 3, 7);
            store(to + 3 * i, SHUFFLED(xy, SHUFFLED(z, x, 0, 5, 0, 5), 0, 1, 4, 5));
            store(to + 3 * i + 4, SHUFFLED(SHUFFLED(y, z, 1, 5, 1, 5), yx, 0, 1, 4, 5));
            store(to + 3 * i + 8, SHUFFLED(SHUFFLED(z, yx, 2, 6, 3, 7), z, 0, 1, 3, 7));
        }
        for (; i < count; ++i)
            for (std::size_t k = 0; k < 3; ++k) to[3 * i + k] = from[k * step + i];
    }
}

MOTORCADE_SIMD
void join(const float *APART apart, std::size_t step, std::size_t count, std::size_t width,
          float *APART rows) {
    for (std::size_t i = 0; i < count; i += 4)
        for (std::size_t k = 0; k < width; k += 4) {
            const float *at = apart + k * step + i;
            const four columns[4] = {load(at), load(at + step), load(at + 2 * step),
                                     load(at + 3 * step)};
            store_columns(columns, rows + width * i + k, width);
        }
}

MOTORCADE_SIMD
void model_matrices(const float *local, const std::int32_t *parents, std::size_t count,
                    float *model) {
    for (std::size_t j = 0; j < count; ++j) {
        if (parents[j] < 0)
            std::memcpy(model + 12 * j, local + 12 * j, 12 * sizeof(float));
        else
            multiply_matrix(model + 12 * parents[j], local + 12 * j, model + 12 * j);
    }
}

MOTORCADE_SIMD
void model_motors(const float *local, const std::int32_t *parents, std::size_t count,
                  float *model) {
    for (std::size_t j = 0; j < count; ++j) {
        if (parents[j] < 0)
            std::memcpy(model + 8 * j, local + 8 * j, 8 * sizeof(float));
        else
            multiply_motor(model + 8 * parents[j], local + 8 * j, model + 8 * j);
    }
}

MOTORCADE_SIMD
void multiply_matrices(const float *first, const float *second, std::size_t count,
                       float *products) {
    for (std::size_t j = 0; j < count; ++j)
        multiply_matrix(first + 12 * j, second + 12 * j, products + 12 * j);
}

MOTORCADE_SIMD
void multiply_motors(const float *first, const float *second, std::size_t count, float *products) {
    for (std::size_t j = 0; j < count; ++j)
        multiply_motor(first + 8 * j, second + 8 * j, products + 8 * j);
}

}  // namespace motorcade::animation
