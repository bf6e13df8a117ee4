/* Kernels of the group chains: reach.
 * Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those. */

#include "support.h"

/* reach: The point of the ray from p towards q that lies a length from p
 * in p: x y z
 * in q: x y z
 * in length: length
 * out out: x y z */

MOTORCADE_SIMD
void motorcade_reach_f32(MOTORCADE_ARGUMENTS(float))
{
    const float *restrict p_at = inputs[0];
    const ptrdiff_t p_step = input_steps[0];
    const float *restrict q_at = inputs[1];
    const ptrdiff_t q_step = input_steps[1];
    const float *restrict length_at = inputs[2];
    float *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const float p0 = p_at[i], p1 = p_at[p_step + i], p2 = p_at[2 * p_step + i];
        const float q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const float length = length_at[i];
        const float t0 = q0 - p0;
        const float t1 = length * (0.5f * length);
        const float t2 = q1 - p1;
        const float t3 = q2 - p2;
        const float t4 = sqrtf(t0 * (t0 * t1) * 2.0f + (2.0f * (t2 * (t1 * t2)) + 2.0f * (t3 * (t1 *
            t3))));
        const float t5 = 1.0f / (t0 * t0 + t2 * t2 + t3 * t3);
        out_at[i] = p0 + t0 * t4 * t5;
        out_at[out_step + i] = p1 + t5 * (t2 * t4);
        out_at[2 * out_step + i] = p2 + t5 * (t3 * t4);
    }
}

MOTORCADE_SIMD
void motorcade_reach_f64(MOTORCADE_ARGUMENTS(double))
{
    const double *restrict p_at = inputs[0];
    const ptrdiff_t p_step = input_steps[0];
    const double *restrict q_at = inputs[1];
    const ptrdiff_t q_step = input_steps[1];
    const double *restrict length_at = inputs[2];
    double *restrict out_at = outputs[0];
    const ptrdiff_t out_step = output_steps[0];
    MOTORCADE_INDEPENDENT
    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {
        const double p0 = p_at[i], p1 = p_at[p_step + i], p2 = p_at[2 * p_step + i];
        const double q0 = q_at[i], q1 = q_at[q_step + i], q2 = q_at[2 * q_step + i];
        const double length = length_at[i];
        const double t0 = q0 - p0;
        const double t1 = length * (0.5 * length);
        const double t2 = q1 - p1;
        const double t3 = q2 - p2;
        const double t4 = sqrt(t0 * (t0 * t1) * 2.0 + (2.0 * (t2 * (t1 * t2)) + 2.0 * (t3 * (t1 *
            t3))));
        const double t5 = 1.0 / (t0 * t0 + t2 * t2 + t3 * t3);
        out_at[i] = p0 + t0 * t4 * t5;
        out_at[out_step + i] = p1 + t5 * (t2 * t4);
        out_at[2 * out_step + i] = p2 + t5 * (t3 * t4);
    }
}
