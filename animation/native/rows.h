// Hot loops over rows of palettes and poses, compiled for SIMD as the generated kernels are.
//
// A row is one joint or vertex; "apart" means structure of arrays: one array a component, `step`
// numbers from one component to the next. Nothing is validated here.

#pragma once

#include <cstddef>
#include <cstdint>

#include "support.h"

// The generated kernels that are used here; see ga/kernels/definitions.
extern "C" {
void motorcade_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_screw_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_accumulate_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_normalize_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_matrix34_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_motor_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_similarity_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_matrix_f32(MOTORCADE_ARGUMENTS(float));
}

namespace motorcade::animation {

// Weighted sums of palette rows, four joints a vertex, apart; `count` is a multiple of
// MOTORCADE_LANES, and of every four vertices `few` says whether no one follows more than its first
// two joints. Versors (8) are summed with the sign of the first joint's rotor.
void sum_versors(const float *palette, const std::uint16_t *joints, const float *weights,
                 const std::uint8_t *few, std::size_t count, float *sums, std::size_t step);
// The same with rows of 12: matrices as they are, similarities with signs.
void sum_matrices(const float *palette, const std::uint16_t *joints, const float *weights,
                  const std::uint8_t *few, std::size_t count, float *sums, std::size_t step);
void sum_similarities(const float *palette, const std::uint16_t *joints, const float *weights,
                      const std::uint8_t *few, std::size_t count, float *sums, std::size_t step);

// Components 0 to 2 and 3 to 5 of `skinned`, apart, into rows of three.
void write_rows(const float *skinned, std::size_t step, std::size_t count, float *positions,
                float *normals);

// Rows of `width`, a multiple of 4, from components apart; writes up to the next multiple of 4 of
// `count` rows.
void join(const float *apart, std::size_t step, std::size_t count, std::size_t width, float *rows);

// Poses in the character from local ones, parents first: 3x4 matrices by rows, or motors.
void model_matrices(const float *local, const std::int32_t *parents, std::size_t count,
                    float *model);
void model_motors(const float *local, const std::int32_t *parents, std::size_t count, float *model);
// Products row by row, first times second.
void multiply_matrices(const float *first, const float *second, std::size_t count, float *products);
void multiply_motors(const float *first, const float *second, std::size_t count, float *products);

}  // namespace motorcade::animation
