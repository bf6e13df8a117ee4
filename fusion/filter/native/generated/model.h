/*
 * The filter's model: its motion, its measurements and their derivatives.
 * Written by `python -m motorcade.fusion.filter.model`; edit fusion/filter/model.
 */
#ifndef MOTORCADE_FILTER_MODEL_H
#define MOTORCADE_FILTER_MODEL_H

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The state after an interval dt (s) of constant rate (rad/s) and force (m/s²), which are
 * what the sensor read; |rate - bias| dt must be at most 3 rad.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in velocity: x y z
 * in bias: gyro_x gyro_y gyro_z accel_x accel_y accel_z
 * in rate: x y z
 * in force: x y z
 * in gravity: x y z
 * out next_pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out next_velocity: x y z
 */
void motorcade_step(const double pose[8], const double velocity[3], const double bias[6],
        const double rate[3], const double force[3], double dt, const double gravity[3],
        double next_pose[8], double next_velocity[3]);

/*
 * The error's transition over that interval, in blocks of 3x3 by rows: turn_turn is also
 * that of position and of velocity on themselves, and dt times it that of position on
 * velocity; the others are zero, biases stay.
 * in bias: gyro_x gyro_y gyro_z accel_x accel_y accel_z
 * in rate: x y z
 * in force: x y z
 * out turn_turn: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out position_turn: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out velocity_turn: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out turn_gyro: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out position_gyro: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out velocity_gyro: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out position_accel: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out velocity_accel: m00 m01 m02 m10 m11 m12 m20 m21 m22
 */
void motorcade_transition(const double bias[6], const double rate[3], const double force[3],
        double dt, double turn_turn[9], double position_turn[9], double velocity_turn[9],
        double turn_gyro[9], double position_gyro[9], double velocity_gyro[9],
        double position_accel[9], double velocity_accel[9]);

/*
 * As motorcade_step, but the force acts in the axes at the start for the whole interval.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in velocity: x y z
 * in bias: gyro_x gyro_y gyro_z accel_x accel_y accel_z
 * in rate: x y z
 * in force: x y z
 * in gravity: x y z
 * out next_pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out next_velocity: x y z
 */
void motorcade_held_step(const double pose[8], const double velocity[3], const double bias[6],
        const double rate[3], const double force[3], double dt, const double gravity[3],
        double next_pose[8], double next_velocity[3]);

/*
 * The error's transition over a held step.
 * in bias: gyro_x gyro_y gyro_z accel_x accel_y accel_z
 * in rate: x y z
 * in force: x y z
 * out turn_turn: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out position_turn: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out velocity_turn: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out turn_gyro: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out position_gyro: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out velocity_gyro: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out position_accel: m00 m01 m02 m10 m11 m12 m20 m21 m22
 * out velocity_accel: m00 m01 m02 m10 m11 m12 m20 m21 m22
 */
void motorcade_held_transition(const double bias[6], const double rate[3], const double force[3],
        double dt, double turn_turn[9], double position_turn[9], double velocity_turn[9],
        double turn_gyro[9], double position_gyro[9], double velocity_gyro[9],
        double position_accel[9], double velocity_accel[9]);

/*
 * Gravity (m/s²) in the world: its size along -z turned by a rotor.
 * in gravity_rotor: 1 e23 e31 e12
 * out gravity: x y z
 */
void motorcade_gravity(const double gravity_rotor[4], double size, double gravity[3]);

/*
 * What a tilt of gravity, an error on its right about its x and y, adds over dt (s) to
 * the error's velocity, 3x2 by rows, in the axes of the pose; dt/2 times it to position.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in gravity_rotor: 1 e23 e31 e12
 * out velocity_tilt: m00 m01 m10 m11 m20 m21
 */
void motorcade_gravity_effect(const double pose[8], const double gravity_rotor[4], double size,
        double dt, double velocity_tilt[6]);

/*
 * A motor with an error (rad, m) on its right.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in error: turn_x turn_y turn_z shift_x shift_y shift_z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 */
void motorcade_retract(const double pose[8], const double error[6], double out[8]);

/*
 * Pose and velocity with an error (rad, m, m/s) on the right of the extended pose.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in velocity: x y z
 * in error: turn_x turn_y turn_z shift_x shift_y shift_z speed_x speed_y speed_z
 * out out: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out out_velocity: x y z
 */
void motorcade_corrected(const double pose[8], const double velocity[3], const double error[9],
        double out[8], double out_velocity[3]);

/*
 * The IMU's pose by a measured one of the camera, and how an error on the right of the
 * measured one turns up on its right, 6x6 by rows.
 * in measured: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in imu_T_camera: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out effect: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33 m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55
 */
void motorcade_start(const double measured[8], const double imu_T_camera[8], double pose[8],
        double effect[36]);

/*
 * Twist (rad, m) to the measured pose of the camera from pose times extrinsics.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in imu_T_camera: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in measured: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out residual: turn_x turn_y turn_z shift_x shift_y shift_z
 */
void motorcade_pose_residual(const double pose[8], const double imu_T_camera[8],
        const double measured[8], double residual[6]);

/*
 * How an error of the pose turns up behind the extrinsics, 6x6 by rows.
 * in imu_T_camera: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out effect: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25 m30 m31 m32 m33 m34 m35 m40 m41 m42 m43 m44 m45 m50 m51 m52 m53 m54 m55
 */
void motorcade_pose_effect(const double imu_T_camera[8], double effect[36]);

/*
 * A point (m) fixed to the IMU, in the world, and how the pose's error moves it, 3x6.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in arm: x y z
 * out at: x y z
 * out effect: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15 m20 m21 m22 m23 m24 m25
 */
void motorcade_point(const double pose[8], const double arm[3], double at[3], double effect[18]);

/*
 * How the error of the velocity, in the IMU's axes, moves it in the world's, 3x3.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * out effect: m00 m01 m02 m10 m11 m12 m20 m21 m22
 */
void motorcade_velocity_effect(const double pose[8], double effect[9]);

/*
 * A point (m) of the world on the camera's plane z = 1, its depth (m) there, and how the
 * errors of the pose and of the extrinsics move it, 2x6 each.
 * in pose: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in imu_T_camera: 1 e23 e31 e12 e1∞ e2∞ e3∞ e123∞
 * in point: x y z
 * out seen: x y
 * out pose_effect: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15
 * out extrinsics_effect: m00 m01 m02 m03 m04 m05 m10 m11 m12 m13 m14 m15
 */
void motorcade_corner(const double pose[8], const double imu_T_camera[8], const double point[3],
        double seen[2], double depth[1], double pose_effect[12], double extrinsics_effect[12]);

#ifdef __cplusplus
}
#endif

#endif
