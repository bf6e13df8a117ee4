/* Filtered states are kept so many at a time, so that memory does not grow with them. */
#define MOTORCADE_INNER_SEGMENT 256

/* How many filters `motorcade_rts` needs as memory to work in, for so many poses. */
MOTORCADE_API size_t motorcade_rts_work(size_t count) {
    const size_t segment = MOTORCADE_INNER_SEGMENT;
    return (count + segment - 1) / segment + (count < segment ? count : segment);
}

/*
 * The smoothed state at a filtered one from the one `later`: that is freed of what the noise in
 * between may explain, and then taken back along its own motion. Only pose and rates of `later`
 * are read, and changed into the result.
 */
static inline void motorcade_inner_back(const motorcade_kalman *filtered, double dt,
                                        motorcade_kalman *later) {
    const int order = filtered->model.order, blocks = order + 1;
    motorcade_kalman made = *filtered;
    double way[6], turn[36], densities[6], predicted[8], residual[18], share[18], correction[6];
    motorcade_inner_travel(order, made.rates, dt, way);
    motorcade_inner_moved(filtered->pose, way, predicted);
    motorcade_inner_drift(order, made.rates, dt);
    motorcade_inner_local(predicted, later->pose, residual);
    for (int k = 0; k < 6 * order; ++k)
        residual[6 + k] = later->rates[k / 6][k % 6] - made.rates[k / 6][k % 6];
    motorcade_inner_half(way, turn);
    motorcade_inner_spread(filtered->model.density_rad, filtered->model.density_m, densities);
    motorcade_inner_propagate(&made.covariance, blocks, turn, dt);
    motorcade_inner_add_noise(&made.covariance, blocks, densities, dt);
    motorcade_inner_factor(&made.covariance, 6 * blocks);
    /*
     * Over more than a radian the path back is no more linear in what is corrected at its end; what
     * is known of the filtered state then bounds how far it goes.
     */
    if (way[0] * way[0] + way[1] * way[1] + way[2] * way[2] > 1.0 ||
        residual[0] * residual[0] + residual[1] * residual[1] + residual[2] * residual[2] > 1.0) {
        motorcade_inner_gained(&filtered->covariance, &made.covariance, blocks, turn, dt, residual,
                               share);
        motorcade_inner_moved(filtered->pose, share, later->pose);
        for (int k = 0; k < 6 * order; ++k)
            later->rates[k / 6][k % 6] = filtered->rates[k / 6][k % 6] + share[6 + k];
        return;
    }
    motorcade_inner_noise_share(&made.covariance, blocks, densities, dt, residual, share);
    for (int k = 0; k < 6; ++k) correction[k] = residual[k] - share[k];
    for (int k = 0; k < 6 * order; ++k) made.rates[k / 6][k % 6] += residual[6 + k] - share[6 + k];
    motorcade_inner_drift(order, made.rates, -dt);
    motorcade_inner_moved(predicted, correction, later->pose);
    motorcade_inner_travel(order, made.rates, dt, way);
    for (int k = 0; k < 6; ++k) way[k] = -way[k];
    motorcade_inner_moved(later->pose, way, later->pose);
    for (int k = 0; k < 6 * order; ++k) later->rates[k / 6][k % 6] = made.rates[k / 6][k % 6];
}

/*
 * Smooths a recorded path by all its poses: the filter forward, the Rauch-Tung-Striebel recursion
 * back.
 *
 *     motors: `count` times eight numbers, and smoothed likewise, which may be the same memory.
 *     time_ns: `count` stamps.
 *     noise: `count` times noise_rad and noise_m, or NULL where the model's hold for every pose.
 *     log_likelihood: a number that is filled in, or NULL.
 *     work: motorcade_rts_work(count) filters.
 *
 * After another answer than MOTORCADE_OK, `smoothed` holds nothing of use.
 */
MOTORCADE_API int motorcade_rts(const motorcade_model *model, const double *motors,
                                const int64_t *time_ns, size_t count, const double *noise,
                                double *smoothed, double *log_likelihood, motorcade_kalman *work) {
    const size_t segment = MOTORCADE_INNER_SEGMENT;
    motorcade_kalman *marks = work, *states = work + (count + segment - 1) / segment;
    motorcade_kalman now, later;
    double measured[8];
    int status = motorcade_kalman_start(&now, model);
    for (size_t k = 0; k < count && status == MOTORCADE_OK; ++k) {
        if (noise != NULL) {
            now.model.noise_rad = noise[2 * k];
            now.model.noise_m = noise[2 * k + 1];
        }
        status = motorcade_kalman_update(&now, motors + 8 * k, time_ns[k], measured);
        if (k == 0 && count > 1 && status == MOTORCADE_OK && time_ns[1] > time_ns[0]) {
            /* The smoothed first pose knows the rates as the second one opens them. */
            marks[0] = now;
            if (noise != NULL) {
                marks[0].model.noise_rad = noise[2];
                marks[0].model.noise_m = noise[3];
            }
            motorcade_inner_normalize(motors + 8, measured);
            motorcade_inner_open(&marks[0], measured,
                                 motorcade_inner_gap(&marks[0].model, time_ns[0], time_ns[1]));
        } else if (k % segment == 0) {
            marks[k / segment] = now;
        }
    }
    if (status != MOTORCADE_OK || count == 0) return status;
    if (log_likelihood != NULL) *log_likelihood = now.log_likelihood;
    later = now;
    for (size_t c = 0; c < 8; ++c) smoothed[8 * (count - 1) + c] = later.pose[c];
    for (size_t mark = (count + segment - 1) / segment; mark-- > 0;) {
        const size_t first = mark * segment;
        const size_t last = first + segment < count - 1 ? first + segment : count - 1;
        for (size_t k = first; k < last; ++k) {
            if (k == first) {
                now = marks[mark];
            } else {
                if (noise != NULL) {
                    now.model.noise_rad = noise[2 * k];
                    now.model.noise_m = noise[2 * k + 1];
                }
                motorcade_kalman_update(&now, motors + 8 * k, time_ns[k], measured);
            }
            states[k - first] = now;
        }
        for (size_t k = last; k-- > first;) {
            /* The gap is cut short by the noise that it was by on the way forward. */
            motorcade_model ahead = *model;
            if (noise != NULL) {
                ahead.noise_rad = noise[2 * k + 2];
                ahead.noise_m = noise[2 * k + 3];
            }
            motorcade_inner_back(&states[k - first],
                                 motorcade_inner_gap(&ahead, time_ns[k], time_ns[k + 1]), &later);
            if (!motorcade_inner_finite(later.pose)) return MOTORCADE_BAD_POSE;
            for (size_t c = 0; c < 8; ++c) smoothed[8 * k + c] = later.pose[c];
        }
    }
    return MOTORCADE_OK;
}
