/* Hot loops over rows of palettes and poses; see rows.h. */

#include "rows.h"

/* Four numbers that stay in one register on any processor with SIMD. */
typedef float four __attribute__((vector_size(16)));
typedef int32_t four_bits __attribute__((vector_size(16)));

#define SHUFFLED __builtin_shufflevector

static inline four load(const float *from)
{
    four made;
    memcpy(&made, from, sizeof made);
    return made;
}

static inline void store(float *to, four value)
{
    memcpy(to, &value, sizeof value);
}

/* Weights of the second to the fourth joint, negative where the rotor of one points away from the
 * first joint's; that of the first stays. */
static inline four signed_weights(four weights, four a, four b, four c, four d)
{
    const four ab = a * b, ac = a * c, ad = a * d;
    const four bc = SHUFFLED(ab, ac, 0, 4, 1, 5) + SHUFFLED(ab, ac, 2, 6, 3, 7);
    const four dd = SHUFFLED(ad, ad, 0, 4, 1, 5) + SHUFFLED(ad, ad, 2, 6, 3, 7);
    const four dots = SHUFFLED(bc, dd, 0, 0, 1, 4) + SHUFFLED(bc, dd, 2, 2, 3, 6);
    const four_bits flips = (dots < (four){0}) & (four_bits){0, INT32_MIN, INT32_MIN, INT32_MIN};
    four_bits bits;
    memcpy(&bits, &weights, sizeof bits);
    bits ^= flips;
    memcpy(&weights, &bits, sizeof bits);
    return weights;
}

/* Four rows of four, row by row in and column by column out. */
static inline void store_columns(const four *rows, float *to, size_t step)
{
    const four ab = SHUFFLED(rows[0], rows[1], 0, 4, 1, 5), cd = SHUFFLED(rows[2], rows[3], 0, 4, 1, 5);
    const four ba = SHUFFLED(rows[0], rows[1], 2, 6, 3, 7), dc = SHUFFLED(rows[2], rows[3], 2, 6, 3, 7);
    store(to, SHUFFLED(ab, cd, 0, 1, 4, 5));
    store(to + step, SHUFFLED(ab, cd, 2, 3, 6, 7));
    store(to + 2 * step, SHUFFLED(ba, dc, 0, 1, 4, 5));
    store(to + 3 * step, SHUFFLED(ba, dc, 2, 3, 6, 7));
}

/* Sums four vertices of `groups` times four components, and lays the components apart. */
static inline void sum_four(const float *restrict palette, const uint16_t *restrict joints,
                            const float *restrict weights, size_t groups, int with_signs,
                            float *restrict sums, size_t step)
{
    four rows[3][4];
    for (size_t i = 0; i < 4; ++i) {
        const float *a = palette + 4 * groups * joints[4 * i];
        const float *b = palette + 4 * groups * joints[4 * i + 1];
        const float *c = palette + 4 * groups * joints[4 * i + 2];
        const float *d = palette + 4 * groups * joints[4 * i + 3];
        four w = load(weights + 4 * i);
        if (with_signs) w = signed_weights(w, load(a), load(b), load(c), load(d));
        for (size_t k = 0; k < groups; ++k)
            rows[k][i] = w[0] * load(a + 4 * k) + w[1] * load(b + 4 * k) + w[2] * load(c + 4 * k) +
                         w[3] * load(d + 4 * k);
    }
    for (size_t k = 0; k < groups; ++k) store_columns(rows[k], sums + 4 * k * step, step);
}

MOTORCADE_SIMD
void motorcade_sum_versors(const float *palette, const uint16_t *joints, const float *weights,
                           size_t count, float *sums, size_t step)
{
    for (size_t i = 0; i < count; i += 4)
        sum_four(palette, joints + 4 * i, weights + 4 * i, 2, 1, sums + i, step);
}

MOTORCADE_SIMD
void motorcade_sum_matrices(const float *palette, const uint16_t *joints, const float *weights,
                            size_t count, float *sums, size_t step)
{
    for (size_t i = 0; i < count; i += 4)
        sum_four(palette, joints + 4 * i, weights + 4 * i, 3, 0, sums + i, step);
}

MOTORCADE_SIMD
void motorcade_sum_similarities(const float *palette, const uint16_t *joints,
                                const float *weights, size_t count, float *sums, size_t step)
{
    for (size_t i = 0; i < count; i += 4)
        sum_four(palette, joints + 4 * i, weights + 4 * i, 3, 1, sums + i, step);
}

MOTORCADE_SIMD
void motorcade_write_rows(const float *restrict carried, size_t step, size_t count,
                          float *restrict positions, float *restrict normals)
{
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            positions[3 * i + k] = carried[k * step + i];
            normals[3 * i + k] = carried[(k + 3) * step + i];
        }
}

MOTORCADE_SIMD
void motorcade_join(const float *restrict apart, size_t step, size_t count, size_t width,
                    float *restrict rows)
{
    for (size_t i = 0; i < count; i += 4)
        for (size_t k = 0; k < width; k += 4) {
            const float *at = apart + k * step + i;
            const four columns[4] = {load(at), load(at + step), load(at + 2 * step), load(at + 3 * step)};
            store_columns(columns, rows + width * i + k, width);
        }
}

/* Each row of the product is a sum of the second's rows; the first's translation is added. */
static inline void multiply_matrices(const float *restrict a, const float *restrict b,
                                     float *restrict out)
{
    const four x = load(b), y = load(b + 4), z = load(b + 8);
    for (size_t row = 0; row < 3; ++row) {
        const four p = load(a + 4 * row), moved = {0.0f, 0.0f, 0.0f, p[3]};
        store(out + 4 * row, p[0] * x + p[1] * y + p[2] * z + moved);
    }
}

/* The geometric product on 1, e23, e31, e12, e1∞, e2∞, e3∞, e123∞. */
static inline void multiply_motors(const float *restrict a, const float *restrict b,
                                   float *restrict out)
{
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2];
    out[2] = a[0] * b[2] + a[1] * b[3] + a[2] * b[0] - a[3] * b[1];
    out[3] = a[0] * b[3] - a[1] * b[2] + a[2] * b[1] + a[3] * b[0];
    out[4] = a[0] * b[4] - a[1] * b[7] - a[2] * b[6] + a[3] * b[5] +
             a[4] * b[0] - a[7] * b[1] - a[5] * b[3] + a[6] * b[2];
    out[5] = a[0] * b[5] + a[1] * b[6] - a[2] * b[7] - a[3] * b[4] +
             a[5] * b[0] - a[7] * b[2] + a[4] * b[3] - a[6] * b[1];
    out[6] = a[0] * b[6] - a[1] * b[5] + a[2] * b[4] - a[3] * b[7] +
             a[6] * b[0] - a[7] * b[3] - a[4] * b[2] + a[5] * b[1];
    out[7] = a[0] * b[7] + a[1] * b[4] + a[2] * b[5] + a[3] * b[6] +
             a[7] * b[0] + a[4] * b[1] + a[5] * b[2] + a[6] * b[3];
}

MOTORCADE_SIMD
void motorcade_model_matrices(const float *local, const int32_t *parents, size_t count,
                              float *model)
{
    for (size_t j = 0; j < count; ++j) {
        if (parents[j] < 0)
            memcpy(model + 12 * j, local + 12 * j, 12 * sizeof(float));
        else
            multiply_matrices(model + 12 * parents[j], local + 12 * j, model + 12 * j);
    }
}

MOTORCADE_SIMD
void motorcade_model_motors(const float *local, const int32_t *parents, size_t count, float *model)
{
    for (size_t j = 0; j < count; ++j) {
        if (parents[j] < 0)
            memcpy(model + 8 * j, local + 8 * j, 8 * sizeof(float));
        else
            multiply_motors(model + 8 * parents[j], local + 8 * j, model + 8 * j);
    }
}

MOTORCADE_SIMD
void motorcade_multiply_matrices(const float *first, const float *second, size_t count,
                                 float *products)
{
    for (size_t j = 0; j < count; ++j)
        multiply_matrices(first + 12 * j, second + 12 * j, products + 12 * j);
}

MOTORCADE_SIMD
void motorcade_multiply_motors(const float *first, const float *second, size_t count,
                               float *products)
{
    for (size_t j = 0; j < count; ++j)
        multiply_motors(first + 8 * j, second + 8 * j, products + 8 * j);
}
