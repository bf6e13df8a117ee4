/* Hot loops over rows of palettes and poses, compiled for SIMD as the generated kernels are.
 *
 * A row is one joint or vertex; "apart" means structure of arrays: one array a component, `step`
 * numbers from one component to the next. Nothing is validated here. */
#ifndef MOTORCADE_ANIMATION_ROWS_H
#define MOTORCADE_ANIMATION_ROWS_H

#include <stdint.h>

#include "support.h"

#if defined(__cplusplus)
extern "C" {
#endif

/* Weighted sums of palette rows, four joints a vertex, apart; `count` is a multiple of
 * MOTORCADE_LANES. Versors (8) are summed with the sign of the first joint's rotor. */
void motorcade_sum_versors(const float *palette, const uint16_t *joints, const float *weights,
                           size_t count, float *sums, size_t step);
/* The same with rows of 12: matrices as they are, similarities with signs. */
void motorcade_sum_matrices(const float *palette, const uint16_t *joints, const float *weights,
                            size_t count, float *sums, size_t step);
void motorcade_sum_similarities(const float *palette, const uint16_t *joints,
                                const float *weights, size_t count, float *sums, size_t step);

/* Components 0 to 2 and 3 to 5 of `carried`, apart, into rows of three. */
void motorcade_write_rows(const float *carried, size_t step, size_t count, float *positions,
                          float *normals);

/* Rows of `width`, a multiple of 4, from components apart; writes up to the next multiple of 4 of
 * `count` rows. */
void motorcade_join(const float *apart, size_t step, size_t count, size_t width, float *rows);

/* Poses in the character from local ones, parents first: 3x4 matrices by rows, or motors. */
void motorcade_model_matrices(const float *local, const int32_t *parents, size_t count,
                              float *model);
void motorcade_model_motors(const float *local, const int32_t *parents, size_t count,
                            float *model);
/* Products row by row, first times second. */
void motorcade_multiply_matrices(const float *first, const float *second, size_t count,
                                 float *products);
void motorcade_multiply_motors(const float *first, const float *second, size_t count,
                               float *products);

/* The generated kernels that are used here; see ga/kernels/definitions. */
void motorcade_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_screw_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_accumulate_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_normalize_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_matrix34_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_motor_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_similarity_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_matrix_f32(MOTORCADE_ARGUMENTS(float));

#if defined(__cplusplus)
}
#endif
#endif
