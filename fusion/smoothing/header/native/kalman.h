/* How bodies move and how well poses are measured; deviations and densities are of one axis. */
typedef struct motorcade_model {
    int order; /* 1: a velocity that white acceleration changes; 2: an acceleration, white jerk */
    double density_rad; /* of the angular acceleration, rad/s^2/sqrt(Hz); of order 2 rad/s^3 */
    double density_m;   /* of the acceleration, m/s^2/sqrt(Hz); of order 2 of the jerk, m/s^3 */
    double noise_rad;   /* standard deviation of a measured rotation */
    double noise_m;     /* standard deviation of a measured position */
} motorcade_model;

/* Python's defaults of ConstantVelocityFilter. */
MOTORCADE_API motorcade_model motorcade_constant_velocity(void) {
    const motorcade_model model = {1, 2.0, 1.0, 0.01, 0.005};
    return model;
}

/* Python's defaults of ConstantAccelerationFilter. */
MOTORCADE_API motorcade_model motorcade_constant_acceleration(void) {
    const motorcade_model model = {2, 10.0, 5.0, 0.01, 0.005};
    return model;
}

/*
 * A filter as it stands; may be copied. Its model may be changed between two poses, but for the
 * order: noise_rad and noise_m to those of the next pose, say.
 */
typedef struct motorcade_kalman {
    motorcade_model model;
    double pose[8];        /* the filtered motor */
    double rates[2][6];    /* body twist, rad/s and m/s, and of order 2 its derivative */
    double log_likelihood; /* of the innovations: what a better model raises */
    int64_t time_ns;       /* of the last pose */
    int64_t poses;         /* how many were seen */
    motorcade_inner_matrix covariance;
} motorcade_kalman;

/* Its bytes, for languages that keep it as memory of their own. */
MOTORCADE_API size_t motorcade_kalman_size(void) { return sizeof(motorcade_kalman); }

static inline int motorcade_inner_good(const motorcade_model *model) {
    return (model->order == 1 || model->order == 2) && model->density_rad > 0.0 &&
           model->density_m > 0.0 && model->noise_rad > 0.0 && model->noise_m > 0.0 &&
           isfinite(model->density_rad) && isfinite(model->density_m) &&
           isfinite(model->noise_rad) && isfinite(model->noise_m);
}

/* A filter that has seen nothing. */
MOTORCADE_API int motorcade_kalman_start(motorcade_kalman *filter, const motorcade_model *model) {
    const motorcade_kalman empty = {{0, 0.0, 0.0, 0.0, 0.0}, {0.0}, {{0.0}}, 0.0, 0, 0, {{{0.0}}}};
    if (!motorcade_inner_good(model)) return MOTORCADE_BAD_MODEL;
    *filter = empty;
    filter->model = *model;
    return MOTORCADE_OK;
}

static inline void motorcade_inner_spread(double rad, double m, double six[6]) {
    for (int k = 0; k < 3; ++k) {
        six[k] = rad;
        six[k + 3] = m;
    }
}

static inline void motorcade_inner_variances(const motorcade_model *model, double six[6]) {
    motorcade_inner_spread(model->noise_rad * model->noise_rad, model->noise_m * model->noise_m,
                           six);
}

/* The step of dt along the rates. */
static inline void motorcade_inner_travel(int order, double rates[2][6], double dt, double way[6]) {
    for (int k = 0; k < 6; ++k) {
        way[k] = dt * rates[0][k];
        if (order == 2) way[k] += 0.5 * dt * dt * rates[1][k];
    }
}

static inline void motorcade_inner_drift(int order, double rates[2][6], double dt) {
    for (int k = 0; k < 6 && order == 2; ++k) rates[0][k] += dt * rates[1][k];
}

/* The matrix of half of a step's turn. */
static inline void motorcade_inner_half(const double way[6], double turn[36]) {
    double log[6], motor[8];
    for (int k = 0; k < 6; ++k) log[k] = 0.5 * (0.5 * way[k]);
    motorcade_inner_exp(log, motor);
    motorcade_inner_adjoint(motor, turn);
}

/*
 * A gap, as long as the process takes to add 1e10 variances of the noise at most: the pose behind
 * is then free of what was before. Over longer ones rates would be led on until a step turns by
 * more than half a turn, and rounding would leave nothing right in the end.
 */
static inline double motorcade_inner_gap(const motorcade_model *model, int64_t from_ns,
                                         int64_t to_ns) {
    const double rad = model->noise_rad / model->density_rad;
    const double m = model->noise_m / model->density_m;
    double q[3][3];
    motorcade_inner_diffusion(model->order + 1, 1.0, q);
    const double longest_s =
        pow(1e10 * fmax(rad, m) * fmax(rad, m) / q[0][0], 1.0 / (2.0 * model->order + 1.0));
    return fmin(motorcade_inner_seconds(from_ns, to_ns), longest_s);
}

static inline void motorcade_inner_first(motorcade_kalman *filter, const double measured[8]) {
    double variances[6];
    motorcade_inner_variances(&filter->model, variances);
    for (int k = 0; k < 8; ++k) filter->pose[k] = measured[k];
    for (int k = 0; k < 6; ++k) filter->covariance.at[k][k] = variances[k];
}

/*
 * The wide prior of the rates, from what the second pose shows: 1000 times the noise and 10 times
 * the step, as a rate. Doing it twice changes nothing.
 */
static inline void motorcade_inner_open(motorcade_kalman *filter, const double measured[8],
                                        double dt) {
    double step[6], variances[6], squares[2] = {0.0, 0.0};
    motorcade_inner_local(filter->pose, measured, step);
    motorcade_inner_variances(&filter->model, variances);
    for (int k = 0; k < 6; ++k) squares[k / 3] += step[k] * step[k];
    for (int k = 0; k < 6; ++k) {
        double prior = 1e3 * 1e3 * variances[k] + 10.0 * 10.0 * squares[k / 3];
        for (int at = 6 + k; at < 6 * (filter->model.order + 1); at += 6)
            filter->covariance.at[at][at] = prior /= dt * dt;
    }
}

static inline void motorcade_inner_step(motorcade_kalman *filter, const double measured[8],
                                        double dt) {
    const int order = filter->model.order, blocks = order + 1;
    double way[6], turn[36], densities[6], variances[6], innovation[6], weighed[6], gain[6][18];
    double correction[6] = {0.0};
    motorcade_inner_matrix factor;
    motorcade_inner_travel(order, filter->rates, dt, way);
    motorcade_inner_moved(filter->pose, way, filter->pose);
    motorcade_inner_drift(order, filter->rates, dt);
    motorcade_inner_local(filter->pose, measured, innovation);
    motorcade_inner_half(way, turn);
    motorcade_inner_spread(filter->model.density_rad, filter->model.density_m, densities);
    motorcade_inner_variances(&filter->model, variances);
    motorcade_inner_propagate(&filter->covariance, blocks, turn, dt);
    motorcade_inner_add_noise(&filter->covariance, blocks, densities, dt);
    const double determinant =
        motorcade_inner_measured(&filter->covariance, blocks, variances, gain, &factor);
    for (int k = 0; k < 6 * blocks; ++k) {
        double total = 0.0;
        for (int c = 0; c < 6; ++c) total += gain[c][k] * innovation[c];
        *(k < 6 ? &correction[k] : &filter->rates[k / 6 - 1][k % 6]) += total;
    }
    /* The first innovations only tell the rates, whose prior says nothing of the noise. */
    if (filter->poses > order) {
        double square = 6.0 * log(6.283185307179586) + log(determinant);
        for (int k = 0; k < 6; ++k) weighed[k] = innovation[k];
        motorcade_inner_solve(&factor, 6, weighed);
        for (int k = 0; k < 6; ++k) square += weighed[k] * innovation[k];
        filter->log_likelihood -= 0.5 * square;
    }
    motorcade_inner_moved(filter->pose, correction, filter->pose);
}

/* Whether pose, rates and variances are numbers: one that is not would spoil the pose later. */
static inline int motorcade_inner_sound(const motorcade_kalman *filter) {
    const int order = filter->model.order;
    double total = 0.0;
    for (int k = 0; k < 6 * order; ++k) total += filter->rates[k / 6][k % 6] * 0.0;
    for (int k = 0; k < 6 * (order + 1); ++k) total += filter->covariance.at[k][k] * 0.0;
    return total == 0.0 && motorcade_inner_finite(filter->pose);
}

/*
 * The filtered motor at a stamp, from a measured one, which it may replace; the first comes back as
 * it is. Gaps need no care: all steps are by time, and gaps after which nothing is left of what was
 * before are cut short.
 */
MOTORCADE_API int motorcade_kalman_update(motorcade_kalman *filter, const double motor[8],
                                          int64_t time_ns, double filtered[8]) {
    motorcade_kalman next = *filter;
    double measured[8];
    if (!motorcade_inner_good(&filter->model)) return MOTORCADE_BAD_MODEL;
    if (filter->poses > 0 && time_ns <= filter->time_ns) return MOTORCADE_BAD_STAMP;
    motorcade_inner_normalize(motor, measured);
    if (filter->poses == 0) {
        motorcade_inner_first(&next, measured);
    } else {
        const double dt = motorcade_inner_gap(&filter->model, filter->time_ns, time_ns);
        if (filter->poses == 1) motorcade_inner_open(&next, measured, dt);
        motorcade_inner_step(&next, measured, dt);
    }
    if (!motorcade_inner_sound(&next)) return MOTORCADE_BAD_POSE;
    next.time_ns = time_ns;
    next.poses = filter->poses + 1;
    *filter = next;
    for (int k = 0; k < 8; ++k) filtered[k] = next.pose[k];
    return MOTORCADE_OK;
}

/* Where the body will be at a stamp after the last pose's, as far as is known: for a display. */
MOTORCADE_API int motorcade_kalman_predict(const motorcade_kalman *filter, int64_t time_ns,
                                           double predicted[8]) {
    motorcade_kalman next = *filter;
    double way[6];
    if (filter->poses == 0 || time_ns < filter->time_ns) return MOTORCADE_BAD_STAMP;
    motorcade_inner_travel(next.model.order, next.rates,
                           motorcade_inner_seconds(next.time_ns, time_ns), way);
    motorcade_inner_moved(next.pose, way, next.pose);
    if (!motorcade_inner_finite(next.pose)) return MOTORCADE_BAD_POSE;
    for (int k = 0; k < 8; ++k) predicted[k] = next.pose[k];
    return MOTORCADE_OK;
}
