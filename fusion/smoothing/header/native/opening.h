/*
 * Smoothing of poses in C99, or C++, on the motors of conformal geometric algebra: the causal
 * Kalman filter of constant velocity or acceleration, the Rauch-Tung-Striebel smoother, and the
 * 1 Euro filter. One file, no library but that of C, no memory allocated. The numbers are those of
 * motorcade.fusion.smoothing with the representation "motor".
 *
 *     #include "motorcade/smooth.h"
 *
 *     motorcade_kalman filter;
 *     motorcade_model model = motorcade_constant_velocity();
 *     motorcade_kalman_start(&filter, &model);
 *     ... for each pose, in the order of time:
 *     motorcade_motor_of_pose(position_m, quaternion_wxyz, motor);
 *     if (motorcade_kalman_update(&filter, motor, time_ns, motor) == MOTORCADE_OK)
 *         motorcade_pose_of_motor(motor, position_m, quaternion_wxyz);
 *
 * Poses are world_T_body: what they are applied to is given in the body (a camera, a headset) and
 * comes out in the world. Metres, radians, seconds; stamps are integer nanoseconds and must rise,
 * evenly or not. Quaternions are Hamilton's, w first; ROS, Unity and ARKit store w last. A motor is
 * eight numbers on 1, e23, e31, e12, e1inf, e2inf, e3inf, e123inf: T R, the rotation first. A frame
 * in which x, y, z are left-handed (Unity) must be mirrored before and after.
 *
 * Functions are `static inline`. For a shared library, define MOTORCADE_API as what exports a
 * function and include this in one source file. Do not compile it with -ffast-math, which takes
 * away the check of what is not finite.
 *
 * Written by `python -m motorcade.fusion.smoothing.header`; edit what that reads.
 * Copyright: as of Motorcade, Apache License 2.0.
 */
#ifndef MOTORCADE_SMOOTH_H
#define MOTORCADE_SMOOTH_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef MOTORCADE_API
#define MOTORCADE_API static inline
#endif

/* What functions return. After another answer than MOTORCADE_OK a filter is as it was before. */
enum {
    MOTORCADE_OK = 0,
    MOTORCADE_BAD_MODEL = 1, /* an order other than 1 and 2, or a number that is not positive */
    MOTORCADE_BAD_STAMP = 2, /* a stamp that is not after the one before */
    MOTORCADE_BAD_POSE = 3   /* a pose that is none, or a result that is not finite */
};
