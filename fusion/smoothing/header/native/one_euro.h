/* The 1 Euro filter: a low-pass whose cut-off rises with the speed. */
typedef struct motorcade_one_euro {
    double min_cutoff_hz;        /* at rest */
    double beta_per_rad;         /* Hz that a rotation of 1 rad/s adds */
    double beta_per_m;           /* Hz that a translation of 1 m/s adds */
    double derivative_cutoff_hz; /* of the speed's own low-pass */
    double pose[8];
    double rate[6];
    int64_t time_ns;
    int64_t poses;
} motorcade_one_euro;

/* Its bytes, for languages that keep it as memory of their own. */
MOTORCADE_API size_t motorcade_one_euro_size(void) { return sizeof(motorcade_one_euro); }

/*
 * A filter that has seen nothing. Python's defaults are 0.5 Hz, 10 Hz a rad/s, 10 Hz a m/s and 2
 * Hz. Cut-offs are positive, betas 0 or more; all else is MOTORCADE_BAD_MODEL. A cut-off above half
 * the rate of the poses is not refused, as the rate is not known: it takes three quarters of each
 * step and more, so hardly smooths.
 */
MOTORCADE_API int motorcade_one_euro_start(motorcade_one_euro *filter, double min_cutoff_hz,
                                           double beta_per_rad, double beta_per_m,
                                           double derivative_cutoff_hz) {
    const motorcade_one_euro made = {min_cutoff_hz, beta_per_rad, beta_per_m, derivative_cutoff_hz,
                                     {0.0},         {0.0},        0,          0};
    if (!(min_cutoff_hz > 0.0 && beta_per_rad >= 0.0 && beta_per_m >= 0.0 &&
          derivative_cutoff_hz > 0.0 && isfinite(min_cutoff_hz) && isfinite(beta_per_rad) &&
          isfinite(beta_per_m) && isfinite(derivative_cutoff_hz)))
        return MOTORCADE_BAD_MODEL;
    *filter = made;
    return MOTORCADE_OK;
}

/* Share of a step that a first-order low-pass takes in dt, by backward differences. */
static inline double motorcade_inner_share(double cutoff_hz, double dt) {
    const double angle = 6.283185307179586 * cutoff_hz * dt;
    return angle / (1.0 + angle);
}

/* The filtered motor at a stamp, from a measured one, which it may replace. */
MOTORCADE_API int motorcade_one_euro_update(motorcade_one_euro *filter, const double motor[8],
                                            int64_t time_ns, double filtered[8]) {
    motorcade_one_euro next = *filter;
    double measured[8], towards[6];
    if (filter->poses > 0 && time_ns <= filter->time_ns) return MOTORCADE_BAD_STAMP;
    motorcade_inner_normalize(motor, measured);
    if (filter->poses == 0) {
        for (int k = 0; k < 8; ++k) next.pose[k] = measured[k];
    } else {
        const double dt = motorcade_inner_seconds(filter->time_ns, time_ns);
        const double share = motorcade_inner_share(filter->derivative_cutoff_hz, dt);
        motorcade_inner_local(filter->pose, measured, towards);
        for (int k = 0; k < 6; ++k)
            next.rate[k] = share * (towards[k] / dt) + (1.0 - share) * next.rate[k];
        for (int first = 0; first < 6; first += 3) {
            double square = 0.0;
            for (int k = first; k < first + 3; ++k) square += next.rate[k] * next.rate[k];
            const double slope = first == 0 ? filter->beta_per_rad : filter->beta_per_m;
            const double step =
                motorcade_inner_share(filter->min_cutoff_hz + slope * sqrt(square), dt);
            for (int k = first; k < first + 3; ++k) towards[k] *= step;
        }
        motorcade_inner_moved(filter->pose, towards, next.pose);
    }
    if (!motorcade_inner_finite(next.pose)) return MOTORCADE_BAD_POSE;
    next.time_ns = time_ns;
    next.poses = filter->poses + 1;
    *filter = next;
    for (int k = 0; k < 8; ++k) filtered[k] = next.pose[k];
    return MOTORCADE_OK;
}
