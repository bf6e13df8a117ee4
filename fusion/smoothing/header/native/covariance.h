/* Covariance of a twist and its derivatives: rows and columns in blocks of six. */
typedef struct motorcade_inner_matrix {
    double at[18][18];
} motorcade_inner_matrix;

/*
 * The factors U' D U of a symmetric positive definite matrix: U above a unit diagonal, in whose
 * place D is inverted. Of another matrix all that is solved is NaN.
 */
static inline double motorcade_inner_factor(motorcade_inner_matrix *a, int size) {
    double determinant = 1.0;
    for (int k = 0; k < size; ++k) {
        double *row = a->at[k];
        const double inverse = row[k] > 0.0 ? 1.0 / row[k] : NAN;
        determinant *= row[k];
        for (int i = k + 1; i < size; ++i)
            for (int j = i; j < size; ++j) a->at[i][j] -= row[i] * inverse * row[j];
        for (int j = k + 1; j < size; ++j) row[j] *= inverse;
        row[k] = inverse;
    }
    return determinant;
}

/* a^-1 times a vector, in place, by the factors. */
static inline void motorcade_inner_solve(const motorcade_inner_matrix *factor, int size,
                                         double *right) {
    for (int k = 0; k < size; ++k)
        for (int i = k + 1; i < size; ++i) right[i] -= factor->at[k][i] * right[k];
    for (int k = 0; k < size; ++k) right[k] *= factor->at[k][k];
    for (int k = size - 1; k > 0; --k)
        for (int i = 0; i < k; ++i) right[i] -= factor->at[i][k] * right[k];
}

/* The same of a matrix of six rows. */
static inline void motorcade_inner_solve_rows(const motorcade_inner_matrix *factor, int columns,
                                              double rows[6][18]) {
    for (int k = 0; k < 6; ++k)
        for (int i = k + 1; i < 6; ++i)
            for (int j = 0; j < columns; ++j) rows[i][j] -= factor->at[k][i] * rows[k][j];
    for (int k = 0; k < 6; ++k)
        for (int j = 0; j < columns; ++j) rows[k][j] *= factor->at[k][k];
    for (int k = 5; k > 0; --k)
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < columns; ++j) rows[i][j] -= factor->at[i][k] * rows[k][j];
}

/* What white noise of unit density on the highest derivative adds in dt. */
static inline void motorcade_inner_diffusion(int blocks, double dt, double q[3][3]) {
    static const double factorial[3] = {1.0, 1.0, 2.0};
    double power[6] = {1.0};
    for (int k = 1; k < 2 * blocks; ++k) power[k] = power[k - 1] * dt;
    for (int i = 0; i < blocks; ++i)
        for (int j = 0; j < blocks; ++j) {
            const int a = blocks - 1 - i, b = blocks - 1 - j;
            q[i][j] = power[a + b + 1] / ((double)(a + b + 1) * factorial[a] * factorial[b]);
        }
}

static inline void motorcade_inner_add_noise(motorcade_inner_matrix *p, int blocks,
                                             const double densities[6], double dt) {
    double q[3][3];
    motorcade_inner_diffusion(blocks, dt, q);
    for (int i = 0; i < blocks; ++i)
        for (int j = 0; j < blocks; ++j)
            for (int c = 0; c < 6; ++c)
                p->at[i * 6 + c][j * 6 + c] += densities[c] * densities[c] * q[i][j];
}

/* The first six rows and columns turned: T p T'. The upper right quarter of an adjoint is zero. */
static inline void motorcade_inner_turn(motorcade_inner_matrix *p, int blocks,
                                        const double turn[36]) {
    const int size = 6 * blocks;
    double rows[6][18] = {{0.0}};
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < (i < 3 ? 3 : 6); ++k)
            for (int j = 0; j < size; ++j) rows[i][j] += turn[6 * i + k] * p->at[k][j];
    for (int i = 0; i < 6; ++i)
        for (int j = i; j < size; ++j) {
            double total = j < 6 ? 0.0 : rows[i][j];
            for (int k = 0; k < (j < 3 ? 3 : 6) && j < 6; ++k)
                total += rows[i][k] * turn[6 * j + k];
            p->at[i][j] = p->at[j][i] = total;
        }
}

/* One step of dt along a motion: turned by half of it, drifted, turned by the other half. */
static inline void motorcade_inner_propagate(motorcade_inner_matrix *p, int blocks,
                                             const double turn[36], double dt) {
    const int size = 6 * blocks;
    const double half = 0.5 * dt * dt;
    motorcade_inner_turn(p, blocks, turn);
    for (int i = 0; i + 6 < size; ++i)
        for (int j = 0; j < size; ++j)
            p->at[i][j] +=
                dt * p->at[i + 6][j] + (i + 12 < size ? half * p->at[(i + 12) % size][j] : 0.0);
    for (int i = 0; i < size; ++i)
        for (int j = 0; j + 6 < size; ++j)
            p->at[i][j] +=
                dt * p->at[i][j + 6] + (j + 12 < size ? half * p->at[i][(j + 12) % size] : 0.0);
    motorcade_inner_turn(p, blocks, turn);
}

/*
 * Conditions on a measurement of the pose with such variances. Fills the gain, transposed, and the
 * factor of the innovation's covariance, whose determinant it returns.
 */
static inline double motorcade_inner_measured(motorcade_inner_matrix *p, int blocks,
                                              const double variances[6], double gain[6][18],
                                              motorcade_inner_matrix *factor) {
    const int size = 6 * blocks;
    double seen[6][18];
    for (int c = 0; c < 6; ++c) {
        for (int j = 0; j < size; ++j) gain[c][j] = seen[c][j] = p->at[c][j];
        for (int k = 0; k < 6; ++k) factor->at[c][k] = p->at[c][k] + (c == k ? variances[c] : 0.0);
    }
    const double determinant = motorcade_inner_factor(factor, 6);
    motorcade_inner_solve_rows(factor, size, gain);
    for (int i = 6; i < size; ++i)
        for (int c = 0; c < 6; ++c)
            for (int j = 6; j < size; ++j) p->at[i][j] -= seen[c][i] * gain[c][j];
    for (int c = 0; c < 6; ++c)
        for (int j = 0; j < size; ++j) p->at[c][j] = variances[c] * gain[c][j];
    for (int i = 6; i < size; ++i)
        for (int c = 0; c < 6; ++c) p->at[i][c] = p->at[c][i];
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < i; ++j) p->at[i][j] = p->at[j][i] = 0.5 * (p->at[i][j] + p->at[j][i]);
    return determinant;
}

/* Q predicted^-1 of a residual behind a prediction: how much of it the noise in between explains.
 */
static inline void motorcade_inner_noise_share(const motorcade_inner_matrix *factor, int blocks,
                                               const double densities[6], double dt,
                                               const double residual[18], double share[18]) {
    double weighed[18], q[3][3];
    for (int k = 0; k < 6 * blocks; ++k) {
        weighed[k] = residual[k];
        share[k] = 0.0;
    }
    motorcade_inner_solve(factor, 6 * blocks, weighed);
    motorcade_inner_diffusion(blocks, dt, q);
    for (int i = 0; i < blocks; ++i)
        for (int c = 0; c < 6; ++c)
            for (int j = 0; j < blocks; ++j)
                share[i * 6 + c] += densities[c] * densities[c] * q[i][j] * weighed[j * 6 + c];
}

/* p F' predicted^-1 of it: what the filtered state gains from a residual behind its prediction. */
static inline void motorcade_inner_gained(const motorcade_inner_matrix *p,
                                          const motorcade_inner_matrix *factor, int blocks,
                                          const double turn[36], double dt,
                                          const double residual[18], double gained[18]) {
    const int size = 6 * blocks;
    double way[18];
    for (int k = 0; k < size; ++k) way[k] = residual[k];
    motorcade_inner_solve(factor, size, way);
    for (int again = 0; again < 2; ++again) {
        double first[6] = {0.0};
        for (int k = 0; k < 6; ++k)
            for (int i = 0; i < 6; ++i) first[i] += turn[6 * k + i] * way[k];
        for (int i = 0; i < 6; ++i) way[i] = first[i];
        for (int i = size - 1; i >= 6 && again == 0; --i)
            way[i] += dt * way[i - 6] + (i >= 12 ? 0.5 * dt * dt * way[i - 12] : 0.0);
    }
    for (int i = 0; i < size; ++i) {
        gained[i] = 0.0;
        for (int j = 0; j < size; ++j) gained[i] += p->at[i][j] * way[j];
    }
}
