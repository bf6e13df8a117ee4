/* All kernels, in the order of their definitions.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */
#include "support.h"

void motorcade_compose_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_compose_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_inverse_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_inverse_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_exp_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_exp_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_log_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_log_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_log_long_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_log_long_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_interpolate_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_interpolate_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_interpolate_long_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_interpolate_long_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_apply_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_apply_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_matrix34_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_matrix34_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_matrix44_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_matrix44_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_transform_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_transform_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_dual_quaternion_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_blend_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_blend_matrix_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_blend_matrix_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_screw_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_screw_blend_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_screw_blend_matrix_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_screw_blend_matrix_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_accumulate_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_accumulate_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_normalize_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_normalize_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_normalize_matrix_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_normalize_matrix_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_compose_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_compose_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_inverse_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_inverse_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_exp_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_exp_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_log_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_log_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_log_long_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_log_long_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_interpolate_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_interpolate_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_interpolate_long_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_interpolate_long_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_compose_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_compose_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_inverse_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_inverse_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_exp_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_exp_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_log_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_log_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_log_long_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_log_long_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_interpolate_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_interpolate_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_interpolate_long_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_interpolate_long_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_normalize_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_normalize_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_blend_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_blend_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_apply_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_apply_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_matrix34_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_matrix34_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_matrix44_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_matrix44_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_translation_scale_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_translation_scale_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_of_motor_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_of_motor_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_carry_motor_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_motor_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_carry_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_dual_quaternion_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_carry_similarity_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_similarity_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_carry_matrix_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_carry_matrix_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_reach_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_reach_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_apply_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_apply_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_matrix33_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_matrix33_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_of_matrix33_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_of_matrix33_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_of_coefficients_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_of_coefficients_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_of_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_of_quaternion_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_normalize_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_normalize_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_of_euler_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_of_euler_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_motor_of_euler_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_motor_of_euler_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_tait_bryan_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_tait_bryan_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_proper_euler_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_proper_euler_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_translation_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_translation_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_of_translation_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_of_translation_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_motor_of_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_motor_of_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_motor_of_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_motor_of_quaternion_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_motor_of_matrix44_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_motor_of_matrix44_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_motor_of_dual_quaternion_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_motor_of_dual_quaternion_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_of_coefficients_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_of_coefficients_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_project_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_project_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_of_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_of_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_of_matrix44_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_of_matrix44_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_of_coefficients_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_of_coefficients_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_motor_scale_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_motor_scale_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_adjoint_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_adjoint_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_transform_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_transform_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_left_jacobian_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_left_jacobian_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_left_jacobian_inverse_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_left_jacobian_inverse_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_retract_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_retract_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_local_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_local_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_of_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_of_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_as_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_as_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_adjoint_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_adjoint_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_transform_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_transform_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_left_jacobian_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_left_jacobian_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_left_jacobian_inverse_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_left_jacobian_inverse_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_retract_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_retract_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_local_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_local_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_of_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_of_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_as_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_as_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_adjoint_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_adjoint_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_transform_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_transform_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_left_jacobian_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_left_jacobian_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_left_jacobian_inverse_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_left_jacobian_inverse_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_retract_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_retract_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_local_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_local_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_of_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_of_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_as_twist_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_as_twist_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_add_weighted_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_add_weighted_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_add_local_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_add_local_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_add_weighted_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_add_weighted_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_rotor_add_local_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_rotor_add_local_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_add_weighted_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_add_weighted_f64(MOTORCADE_ARGUMENTS(double));
void motorcade_similarity_add_local_f32(MOTORCADE_ARGUMENTS(float));
void motorcade_similarity_add_local_f64(MOTORCADE_ARGUMENTS(double));

const struct motorcade_kernel motorcade_kernels[] = {
    {"compose", 2, 1, {8, 8, 8},
     motorcade_compose_f32, motorcade_compose_f64},
    {"inverse", 1, 1, {8, 8},
     motorcade_inverse_f32, motorcade_inverse_f64},
    {"exp", 1, 1, {6, 8},
     motorcade_exp_f32, motorcade_exp_f64},
    {"log", 1, 1, {8, 6},
     motorcade_log_f32, motorcade_log_f64},
    {"log_long", 1, 1, {8, 6},
     motorcade_log_long_f32, motorcade_log_long_f64},
    {"interpolate", 3, 1, {8, 8, 1, 8},
     motorcade_interpolate_f32, motorcade_interpolate_f64},
    {"interpolate_long", 3, 1, {8, 8, 1, 8},
     motorcade_interpolate_long_f32, motorcade_interpolate_long_f64},
    {"apply", 2, 1, {8, 3, 3},
     motorcade_apply_f32, motorcade_apply_f64},
    {"matrix34", 1, 1, {8, 12},
     motorcade_matrix34_f32, motorcade_matrix34_f64},
    {"matrix44", 1, 1, {8, 16},
     motorcade_matrix44_f32, motorcade_matrix44_f64},
    {"transform", 2, 1, {12, 3, 3},
     motorcade_transform_f32, motorcade_transform_f64},
    {"dual_quaternion", 1, 1, {8, 8},
     motorcade_dual_quaternion_f32, motorcade_dual_quaternion_f64},
    {"blend", 3, 1, {8, 8, 1, 8},
     motorcade_blend_f32, motorcade_blend_f64},
    {"blend_matrix", 3, 1, {8, 8, 1, 12},
     motorcade_blend_matrix_f32, motorcade_blend_matrix_f64},
    {"screw_blend", 3, 1, {8, 8, 1, 8},
     motorcade_screw_blend_f32, motorcade_screw_blend_f64},
    {"screw_blend_matrix", 3, 1, {8, 8, 1, 12},
     motorcade_screw_blend_matrix_f32, motorcade_screw_blend_matrix_f64},
    {"accumulate", 4, 1, {8, 8, 8, 1, 8},
     motorcade_accumulate_f32, motorcade_accumulate_f64},
    {"normalize", 1, 1, {8, 8},
     motorcade_normalize_f32, motorcade_normalize_f64},
    {"normalize_matrix", 1, 1, {8, 12},
     motorcade_normalize_matrix_f32, motorcade_normalize_matrix_f64},
    {"rotor_compose", 2, 1, {4, 4, 4},
     motorcade_rotor_compose_f32, motorcade_rotor_compose_f64},
    {"rotor_inverse", 1, 1, {4, 4},
     motorcade_rotor_inverse_f32, motorcade_rotor_inverse_f64},
    {"rotor_exp", 1, 1, {3, 4},
     motorcade_rotor_exp_f32, motorcade_rotor_exp_f64},
    {"rotor_log", 1, 1, {4, 3},
     motorcade_rotor_log_f32, motorcade_rotor_log_f64},
    {"rotor_log_long", 1, 1, {4, 3},
     motorcade_rotor_log_long_f32, motorcade_rotor_log_long_f64},
    {"rotor_interpolate", 3, 1, {4, 4, 1, 4},
     motorcade_rotor_interpolate_f32, motorcade_rotor_interpolate_f64},
    {"rotor_interpolate_long", 3, 1, {4, 4, 1, 4},
     motorcade_rotor_interpolate_long_f32, motorcade_rotor_interpolate_long_f64},
    {"similarity_compose", 2, 1, {12, 12, 12},
     motorcade_similarity_compose_f32, motorcade_similarity_compose_f64},
    {"similarity_inverse", 1, 1, {12, 12},
     motorcade_similarity_inverse_f32, motorcade_similarity_inverse_f64},
    {"similarity_exp", 1, 1, {7, 12},
     motorcade_similarity_exp_f32, motorcade_similarity_exp_f64},
    {"similarity_log", 1, 1, {12, 7},
     motorcade_similarity_log_f32, motorcade_similarity_log_f64},
    {"similarity_log_long", 1, 1, {12, 7},
     motorcade_similarity_log_long_f32, motorcade_similarity_log_long_f64},
    {"similarity_interpolate", 3, 1, {12, 12, 1, 12},
     motorcade_similarity_interpolate_f32, motorcade_similarity_interpolate_f64},
    {"similarity_interpolate_long", 3, 1, {12, 12, 1, 12},
     motorcade_similarity_interpolate_long_f32, motorcade_similarity_interpolate_long_f64},
    {"similarity_normalize", 1, 1, {12, 13},
     motorcade_similarity_normalize_f32, motorcade_similarity_normalize_f64},
    {"similarity_blend", 3, 1, {12, 12, 1, 12},
     motorcade_similarity_blend_f32, motorcade_similarity_blend_f64},
    {"similarity_apply", 2, 1, {12, 3, 3},
     motorcade_similarity_apply_f32, motorcade_similarity_apply_f64},
    {"similarity_matrix34", 1, 1, {12, 12},
     motorcade_similarity_matrix34_f32, motorcade_similarity_matrix34_f64},
    {"similarity_matrix44", 1, 1, {12, 16},
     motorcade_similarity_matrix44_f32, motorcade_similarity_matrix44_f64},
    {"rotor_translation_scale", 1, 1, {12, 8},
     motorcade_rotor_translation_scale_f32, motorcade_rotor_translation_scale_f64},
    {"similarity_of_motor", 2, 1, {8, 1, 12},
     motorcade_similarity_of_motor_f32, motorcade_similarity_of_motor_f64},
    {"carry_motor", 3, 1, {8, 3, 3, 6},
     motorcade_carry_motor_f32, motorcade_carry_motor_f64},
    {"carry_dual_quaternion", 3, 1, {8, 3, 3, 6},
     motorcade_carry_dual_quaternion_f32, motorcade_carry_dual_quaternion_f64},
    {"carry_similarity", 3, 1, {12, 3, 3, 6},
     motorcade_carry_similarity_f32, motorcade_carry_similarity_f64},
    {"carry_matrix", 3, 1, {12, 3, 3, 6},
     motorcade_carry_matrix_f32, motorcade_carry_matrix_f64},
    {"reach", 3, 1, {3, 3, 1, 3},
     motorcade_reach_f32, motorcade_reach_f64},
    {"rotor_apply", 2, 1, {4, 3, 3},
     motorcade_rotor_apply_f32, motorcade_rotor_apply_f64},
    {"rotor_matrix33", 1, 1, {4, 9},
     motorcade_rotor_matrix33_f32, motorcade_rotor_matrix33_f64},
    {"rotor_of_matrix33", 1, 1, {9, 5},
     motorcade_rotor_of_matrix33_f32, motorcade_rotor_of_matrix33_f64},
    {"rotor_of_coefficients", 1, 1, {4, 5},
     motorcade_rotor_of_coefficients_f32, motorcade_rotor_of_coefficients_f64},
    {"rotor_of_quaternion", 1, 1, {4, 5},
     motorcade_rotor_of_quaternion_f32, motorcade_rotor_of_quaternion_f64},
    {"rotor_normalize", 1, 1, {4, 5},
     motorcade_rotor_normalize_f32, motorcade_rotor_normalize_f64},
    {"rotor_of_euler", 2, 1, {3, 9, 4},
     motorcade_rotor_of_euler_f32, motorcade_rotor_of_euler_f64},
    {"motor_of_euler", 3, 1, {3, 9, 3, 8},
     motorcade_motor_of_euler_f32, motorcade_motor_of_euler_f64},
    {"rotor_tait_bryan", 2, 1, {4, 10, 3},
     motorcade_rotor_tait_bryan_f32, motorcade_rotor_tait_bryan_f64},
    {"rotor_proper_euler", 2, 1, {4, 10, 3},
     motorcade_rotor_proper_euler_f32, motorcade_rotor_proper_euler_f64},
    {"translation", 1, 1, {8, 3},
     motorcade_translation_f32, motorcade_translation_f64},
    {"of_translation", 1, 1, {3, 8},
     motorcade_of_translation_f32, motorcade_of_translation_f64},
    {"motor_of", 2, 1, {4, 3, 8},
     motorcade_motor_of_f32, motorcade_motor_of_f64},
    {"motor_of_quaternion", 2, 1, {4, 3, 9},
     motorcade_motor_of_quaternion_f32, motorcade_motor_of_quaternion_f64},
    {"motor_of_matrix44", 1, 1, {16, 9},
     motorcade_motor_of_matrix44_f32, motorcade_motor_of_matrix44_f64},
    {"motor_of_dual_quaternion", 1, 1, {8, 9},
     motorcade_motor_of_dual_quaternion_f32, motorcade_motor_of_dual_quaternion_f64},
    {"of_coefficients", 1, 1, {8, 9},
     motorcade_of_coefficients_f32, motorcade_of_coefficients_f64},
    {"project", 1, 1, {8, 9},
     motorcade_project_f32, motorcade_project_f64},
    {"similarity_of", 3, 1, {4, 3, 1, 12},
     motorcade_similarity_of_f32, motorcade_similarity_of_f64},
    {"similarity_of_matrix44", 1, 1, {16, 13},
     motorcade_similarity_of_matrix44_f32, motorcade_similarity_of_matrix44_f64},
    {"similarity_of_coefficients", 1, 1, {12, 13},
     motorcade_similarity_of_coefficients_f32, motorcade_similarity_of_coefficients_f64},
    {"motor_scale", 1, 1, {12, 9},
     motorcade_motor_scale_f32, motorcade_motor_scale_f64},
    {"adjoint", 1, 1, {8, 36},
     motorcade_adjoint_f32, motorcade_adjoint_f64},
    {"transform_twist", 2, 1, {8, 6, 6},
     motorcade_transform_twist_f32, motorcade_transform_twist_f64},
    {"left_jacobian", 1, 1, {6, 36},
     motorcade_left_jacobian_f32, motorcade_left_jacobian_f64},
    {"left_jacobian_inverse", 1, 1, {6, 36},
     motorcade_left_jacobian_inverse_f32, motorcade_left_jacobian_inverse_f64},
    {"retract", 2, 1, {8, 6, 8},
     motorcade_retract_f32, motorcade_retract_f64},
    {"local", 2, 1, {8, 8, 6},
     motorcade_local_f32, motorcade_local_f64},
    {"of_twist", 1, 1, {6, 8},
     motorcade_of_twist_f32, motorcade_of_twist_f64},
    {"as_twist", 1, 1, {8, 6},
     motorcade_as_twist_f32, motorcade_as_twist_f64},
    {"rotor_adjoint", 1, 1, {4, 9},
     motorcade_rotor_adjoint_f32, motorcade_rotor_adjoint_f64},
    {"rotor_transform_twist", 2, 1, {4, 3, 3},
     motorcade_rotor_transform_twist_f32, motorcade_rotor_transform_twist_f64},
    {"rotor_left_jacobian", 1, 1, {3, 9},
     motorcade_rotor_left_jacobian_f32, motorcade_rotor_left_jacobian_f64},
    {"rotor_left_jacobian_inverse", 1, 1, {3, 9},
     motorcade_rotor_left_jacobian_inverse_f32, motorcade_rotor_left_jacobian_inverse_f64},
    {"rotor_retract", 2, 1, {4, 3, 4},
     motorcade_rotor_retract_f32, motorcade_rotor_retract_f64},
    {"rotor_local", 2, 1, {4, 4, 3},
     motorcade_rotor_local_f32, motorcade_rotor_local_f64},
    {"rotor_of_twist", 1, 1, {3, 4},
     motorcade_rotor_of_twist_f32, motorcade_rotor_of_twist_f64},
    {"rotor_as_twist", 1, 1, {4, 3},
     motorcade_rotor_as_twist_f32, motorcade_rotor_as_twist_f64},
    {"similarity_adjoint", 1, 1, {12, 49},
     motorcade_similarity_adjoint_f32, motorcade_similarity_adjoint_f64},
    {"similarity_transform_twist", 2, 1, {12, 7, 7},
     motorcade_similarity_transform_twist_f32, motorcade_similarity_transform_twist_f64},
    {"similarity_left_jacobian", 1, 1, {7, 49},
     motorcade_similarity_left_jacobian_f32, motorcade_similarity_left_jacobian_f64},
    {"similarity_left_jacobian_inverse", 1, 1, {7, 49},
     motorcade_similarity_left_jacobian_inverse_f32, motorcade_similarity_left_jacobian_inverse_f64},
    {"similarity_retract", 2, 1, {12, 7, 12},
     motorcade_similarity_retract_f32, motorcade_similarity_retract_f64},
    {"similarity_local", 2, 1, {12, 12, 7},
     motorcade_similarity_local_f32, motorcade_similarity_local_f64},
    {"similarity_of_twist", 1, 1, {7, 12},
     motorcade_similarity_of_twist_f32, motorcade_similarity_of_twist_f64},
    {"similarity_as_twist", 1, 1, {12, 7},
     motorcade_similarity_as_twist_f32, motorcade_similarity_as_twist_f64},
    {"add_weighted", 4, 1, {9, 8, 8, 1, 9},
     motorcade_add_weighted_f32, motorcade_add_weighted_f64},
    {"add_local", 4, 1, {6, 8, 8, 1, 6},
     motorcade_add_local_f32, motorcade_add_local_f64},
    {"rotor_add_weighted", 4, 1, {5, 4, 4, 1, 5},
     motorcade_rotor_add_weighted_f32, motorcade_rotor_add_weighted_f64},
    {"rotor_add_local", 4, 1, {3, 4, 4, 1, 3},
     motorcade_rotor_add_local_f32, motorcade_rotor_add_local_f64},
    {"similarity_add_weighted", 4, 1, {13, 12, 12, 1, 13},
     motorcade_similarity_add_weighted_f32, motorcade_similarity_add_weighted_f64},
    {"similarity_add_local", 4, 1, {7, 12, 12, 1, 7},
     motorcade_similarity_add_local_f32, motorcade_similarity_add_local_f64},
};
const size_t motorcade_kernel_count =
    sizeof motorcade_kernels / sizeof motorcade_kernels[0];
