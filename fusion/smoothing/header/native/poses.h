/* What a status means, for a log. */
MOTORCADE_API const char *motorcade_message(int status) {
    switch (status) {
    case MOTORCADE_OK:
        return "ok";
    case MOTORCADE_BAD_MODEL:
        return "model: expected order 1 or 2 and positive numbers";
    case MOTORCADE_BAD_STAMP:
        return "time_ns: expected a stamp after the one before";
    case MOTORCADE_BAD_POSE:
        return "pose: expected finite numbers and a rotation";
    default:
        return "status: expected one of this header";
    }
}

/* The motor of a position and a quaternion w, x, y, z of any length but 0; they may not overlap. */
MOTORCADE_API void motorcade_motor_of_pose(const double position_m[3],
                                           const double quaternion_wxyz[4], double motor[8]) {
    const double rotor[4] = {quaternion_wxyz[0], -quaternion_wxyz[1], -quaternion_wxyz[2],
                             -quaternion_wxyz[3]};
    motorcade_inner_motor_of(rotor, position_m, motor);
    motorcade_inner_normalize(motor, motor);
}

/* Position and unit quaternion w, x, y, z of a motor. */
MOTORCADE_API void motorcade_pose_of_motor(const double motor[8], double position_m[3],
                                           double quaternion_wxyz[4]) {
    motorcade_inner_translation(motor, position_m);
    quaternion_wxyz[0] = motor[0];
    for (int k = 1; k < 4; ++k) quaternion_wxyz[k] = -motor[k];
}

/* base exp(twist), brought back to unit length. */
static inline void motorcade_inner_moved(const double base[8], const double twist[6],
                                         double out[8]) {
    motorcade_inner_retract(base, twist, out);
    motorcade_inner_normalize(out, out);
}

static inline int motorcade_inner_finite(const double motor[8]) {
    double total = 0.0;
    for (int k = 0; k < 8; ++k) total += motor[k] * 0.0;
    return total == 0.0;
}

/* Seconds from one stamp to a later one, which may be farther than int64_t reaches. */
static inline double motorcade_inner_seconds(int64_t from_ns, int64_t to_ns) {
    return 1e-9 * (double)((uint64_t)to_ns - (uint64_t)from_ns);
}
