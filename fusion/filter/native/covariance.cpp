// What transitions and measurements make of covariances, compiled for the processors that x86 has;
// the loader picks.

#include "covariance.h"

#include "clones.h"

namespace motorcade::filter {

namespace {

// Four numbers of a row at once, whatever the processor makes of them.
typedef double Quad __attribute__((vector_size(32), may_alias));

MOTORCADE_INLINE Quad quad(const double *row, std::size_t q) {
    return *reinterpret_cast<const Quad *>(row + 4 * q);
}
MOTORCADE_INLINE void put(double *row, std::size_t q, Quad value) {
    *reinterpret_cast<Quad *>(row + 4 * q) = value;
}

// A row, or a column, of a block times three rows.
MOTORCADE_INLINE Quad row_of(const double *block, std::size_t i, const Quad *x) {
    return block[3 * i] * x[0] + block[3 * i + 1] * x[1] + block[3 * i + 2] * x[2];
}
MOTORCADE_INLINE Quad column_of(const double *block, std::size_t i, const Quad *x) {
    return block[i] * x[0] + block[3 + i] * x[1] + block[6 + i] * x[2];
}

// The first nine rows of F X; the others are those of X. Where `lower`, of a symmetric product only
// what is left of the diagonal, and what else is in the same quads.
template <bool tilted, bool lower, std::size_t W>
MOTORCADE_INLINE void multiplied(const Transition &f, const double (*x)[W], double (*made)[W]) {
    for (std::size_t q = 0; q < W / 4; ++q) {
        Quad turned[3], shifted[3], faster[3], by_gyro[3], by_accel[3];
        for (std::size_t i = 0; i < 3; ++i) {
            turned[i] = quad(x[turn + i], q);
            faster[i] = quad(x[velocity + i], q);
            shifted[i] = quad(x[position + i], q) + f.dt * faster[i];
            by_gyro[i] = quad(x[gyro + i], q);
            by_accel[i] = quad(x[accel + i], q);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            if (!lower || 4 * q < position)
                put(made[turn + i], q,
                    row_of(f.turn_turn, i, turned) + row_of(f.turn_gyro, i, by_gyro));
            Quad place = row_of(f.position_turn, i, turned) + row_of(f.turn_turn, i, shifted) +
                         row_of(f.position_gyro, i, by_gyro) +
                         row_of(f.position_accel, i, by_accel);
            Quad speed = row_of(f.velocity_turn, i, turned) + row_of(f.turn_turn, i, faster) +
                         row_of(f.velocity_gyro, i, by_gyro) +
                         row_of(f.velocity_accel, i, by_accel);
            if constexpr (tilted) {
                const double *leaning = f.velocity_tilt + 2 * i;
                const Quad fall = leaning[0] * quad(x[tilt], q) + leaning[1] * quad(x[tilt + 1], q);
                place += 0.5 * f.dt * fall;
                speed += fall;
            }
            if (!lower || 4 * q < velocity) put(made[position + i], q, place);
            put(made[velocity + i], q, speed);
        }
    }
}

// F' X.
template <std::size_t N, std::size_t W>
MOTORCADE_INLINE void multiplied_back(const Transition &f, const double (*x)[W],
                                      double (*made)[W]) {
    for (std::size_t q = 0; q < W / 4; ++q) {
        Quad turned[3], shifted[3], faster[3];
        for (std::size_t i = 0; i < 3; ++i) {
            turned[i] = quad(x[turn + i], q);
            shifted[i] = quad(x[position + i], q);
            faster[i] = quad(x[velocity + i], q);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const Quad place = column_of(f.turn_turn, i, shifted);
            put(made[turn + i], q,
                column_of(f.turn_turn, i, turned) + column_of(f.position_turn, i, shifted) +
                    column_of(f.velocity_turn, i, faster));
            put(made[position + i], q, place);
            put(made[velocity + i], q, column_of(f.turn_turn, i, faster) + f.dt * place);
            put(made[gyro + i], q,
                quad(x[gyro + i], q) + column_of(f.turn_gyro, i, turned) +
                    column_of(f.position_gyro, i, shifted) + column_of(f.velocity_gyro, i, faster));
            put(made[accel + i], q,
                quad(x[accel + i], q) + column_of(f.position_accel, i, shifted) +
                    column_of(f.velocity_accel, i, faster));
        }
        for (std::size_t k = 15; k < N; ++k) put(made[k], q, quad(x[k], q));
        if constexpr (N > 15)
            for (std::size_t k = 0; k < 2; ++k) {
                Quad sum = quad(x[tilt + k], q);
                for (std::size_t i = 0; i < 3; ++i)
                    sum += f.velocity_tilt[2 * i + k] * (faster[i] + 0.5 * f.dt * shifted[i]);
                put(made[tilt + k], q, sum);
            }
    }
}

// P becomes F P F' + Q.
template <std::size_t N>
MOTORCADE_INLINE void propagated(Matrix<N> &p, const Transition &f, const Densities &q) {
    constexpr std::size_t W = Matrix<N>::width, half = 12;
    constexpr bool tilted = N > 15;
    alignas(64) double top[9][W];
    alignas(64) double across[N][half];
    alignas(64) double corner[9][half] = {};
    multiplied<tilted, false, W>(f, p.row, top);
    for (std::size_t k = 0; k < N; ++k) {
        for (std::size_t i = 0; i < 9; ++i) across[k][i] = top[i][k];
        for (std::size_t i = 9; i < half; ++i) across[k][i] = 0.0;
    }
    multiplied<tilted, true, half>(f, across, corner);
    // In quads, so that what is read next was written as it is read.
    for (std::size_t i = 0; i < 9; ++i) {
        for (std::size_t q = 0; q < 2; ++q) put(p.row[i], q, quad(corner[i], q));
        for (std::size_t q = 2; q < W / 4; ++q) put(p.row[i], q, quad(top[i], q));
    }
    for (std::size_t i = 9; i < N; ++i) {
        for (std::size_t q = 0; q < 2; ++q) put(p.row[i], q, quad(across[i], q));
        p.row[i][8] = across[i][8];
    }
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t j = i; j < 9; ++j) p.row[i][j] = corner[j][i];
    const double dt = f.dt;
    for (std::size_t i = 0; i < 3; ++i) {
        p.row[turn + i][turn + i] += q.rate * dt;
        p.row[velocity + i][velocity + i] += q.force * dt;
        p.row[position + i][position + i] += q.force * dt * dt * dt / 3.0;
        p.row[position + i][velocity + i] += q.force * dt * dt / 2.0;
        p.row[velocity + i][position + i] += q.force * dt * dt / 2.0;
        p.row[gyro + i][gyro + i] += q.gyro_walk * dt;
        p.row[accel + i][accel + i] += q.accel_walk * dt;
    }
}

MOTORCADE_INLINE void transformed(Matrix<15> &x, const Transition &f) {
    constexpr std::size_t W = Matrix<15>::width;
    alignas(64) double top[9][W];
    multiplied<false, false, W>(f, x.row, top);
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t j = 0; j < W; ++j) x.row[i][j] = top[i][j];
}

template <std::size_t N>
MOTORCADE_INLINE void propagated_back(Matrix<N> &curvature, double *gradient, const Transition &f) {
    constexpr std::size_t W = Matrix<N>::width;
    Matrix<N> once, across;
    if constexpr (W > N) {  // the gradient goes along in a column that nothing else needs
        for (std::size_t i = 0; i < N; ++i) curvature.row[i][N] = gradient[i];
        multiplied_back<N, W>(f, curvature.row, once.row);
        for (std::size_t i = 0; i < N; ++i) gradient[i] = once.row[i][N];
    } else {
        alignas(64) double row[N][4] = {}, shifted[N][4];
        for (std::size_t i = 0; i < N; ++i) row[i][0] = gradient[i];
        multiplied_back<N, 4>(f, row, shifted);
        for (std::size_t i = 0; i < N; ++i) gradient[i] = shifted[i][0];
        multiplied_back<N, W>(f, curvature.row, once.row);
    }
    transpose<N>(once.row, across.row);
    multiplied_back<N, W>(f, across.row, curvature.row);
}

// Inverse of a symmetric positive definite matrix by Cholesky; false where it is not one.
MOTORCADE_INLINE bool invert(std::size_t m, const double (*given)[widest], double (*made)[widest]) {
    double lower[widest][widest], right[widest][widest], over[widest];
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = given[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= lower[i][k] * lower[j][k];
            if (i == j && !(sum > 0.0)) return false;
            if (i == j) over[i] = 1.0 / std::sqrt(sum);
            lower[i][j] = sum * over[j];
        }
    for (std::size_t j = 0; j < m; ++j) {
        right[j][j] = over[j];
        for (std::size_t i = j + 1; i < m; ++i) {
            double sum = 0.0;
            for (std::size_t k = j; k < i; ++k) sum -= lower[i][k] * right[k][j];
            right[i][j] = sum * over[i];
        }
    }
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = 0.0;
            for (std::size_t k = i; k < m; ++k) sum += right[k][i] * right[k][j];
            made[i][j] = made[j][i] = sum;
        }
    return true;
}

template <std::size_t N>
MOTORCADE_INLINE bool weighed(const Matrix<N> &p, const Innovation<N> &given, double factor,
                              Gain<N> &made) {
    constexpr std::size_t W = Matrix<N>::width;
    const std::size_t m = given.size;
    alignas(64) double across[N][widest] = {}, total[widest][widest];
    for (std::size_t a = 0; a < m; ++a) {
        alignas(64) double sum[W] = {};
        for (std::size_t k = 0; k < N; ++k)
            if (given.effect[a][k] != 0.0) add<W>(sum, given.effect[a][k], p.row[k]);
        for (std::size_t k = 0; k < W; ++k) made.spread[a][k] = sum[k];
        for (std::size_t k = 0; k < N; ++k) across[k][a] = sum[k];
    }
    for (std::size_t a = 0; a < m; ++a) {
        for (std::size_t b = 0; b < widest; ++b) total[a][b] = factor * given.noise[a][b];
        for (std::size_t k = 0; k < N; ++k)
            if (given.effect[a][k] != 0.0) add<widest>(total[a], given.effect[a][k], across[k]);
        for (std::size_t b = 0; b < widest; ++b) made.total[a][b] = total[a][b];
    }
    if (!invert(m, total, made.inverse)) return false;
    made.nis = 0.0;
    for (std::size_t a = 0; a < m; ++a) {
        alignas(64) double sum[W] = {};
        double square = 0.0;
        for (std::size_t b = 0; b < m; ++b) {
            add<W>(sum, made.inverse[a][b], made.spread[b]);
            square += made.inverse[a][b] * given.residual[b];
        }
        for (std::size_t k = 0; k < W; ++k) made.gain[a][k] = sum[k];
        made.nis += given.residual[a] * square;
    }
    return true;
}

// P - K (H P) - (P H' - K S) K', which is Joseph's form multiplied out.
template <std::size_t N>
MOTORCADE_INLINE void updated(Matrix<N> &p, const Innovation<N> &given, const Gain<N> &by) {
    constexpr std::size_t W = Matrix<N>::width;
    const std::size_t m = given.size;
    alignas(64) double left[widest][W];
    for (std::size_t a = 0; a < m; ++a) {
        for (std::size_t k = 0; k < W; ++k) left[a][k] = by.spread[a][k];
        for (std::size_t b = 0; b < m; ++b) add<W>(left[a], -by.total[b][a], by.gain[b]);
    }
    for (std::size_t i = 0; i < N; ++i) {
        alignas(64) double row[W];
        for (std::size_t k = 0; k < W; ++k) row[k] = p.row[i][k];
        for (std::size_t a = 0; a < m; ++a) {
            add<W>(row, -by.gain[a][i], by.spread[a]);
            add<W>(row, -left[a][i], by.gain[a]);
        }
        for (std::size_t k = 0; k < W; ++k) p.row[i][k] = row[k];
    }
    symmetrise(p);
}

// Λ - H' Z - Z' H with Z = K' Λ - ½ (K' Λ K + S⁻¹) H.
template <std::size_t N>
MOTORCADE_INLINE void updated_back(Matrix<N> &curvature, const Innovation<N> &given,
                                   const Gain<N> &by) {
    constexpr std::size_t W = Matrix<N>::width;
    const std::size_t m = given.size;
    alignas(64) double pulled[widest][W] = {}, across[N][widest] = {};
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t a = 0; a < m; ++a) add<W>(pulled[a], by.gain[a][i], curvature.row[i]);
    for (std::size_t a = 0; a < m; ++a)
        for (std::size_t i = 0; i < N; ++i) across[i][a] = pulled[a][i];
    alignas(64) double part[widest][W];
    for (std::size_t a = 0; a < m; ++a) {
        alignas(64) double square[widest] = {};
        for (std::size_t b = 0; b < m; ++b) square[b] = by.inverse[a][b];
        for (std::size_t i = 0; i < N; ++i) add<widest>(square, by.gain[a][i], across[i]);
        for (std::size_t k = 0; k < W; ++k) part[a][k] = pulled[a][k];
        for (std::size_t b = 0; b < m; ++b)
            for (std::size_t k = 0; k < N; ++k) part[a][k] -= 0.5 * square[b] * given.effect[b][k];
    }
    // Twice the one product: the mean with its transpose is what both make.
    for (std::size_t a = 0; a < m; ++a)
        for (std::size_t k = 0; k < N; ++k)
            if (given.effect[a][k] != 0.0)
                add<W>(curvature.row[k], -2.0 * given.effect[a][k], part[a]);
    symmetrise(curvature);
}

template <std::size_t N> MOTORCADE_INLINE void shrunk(Matrix<N> &p, const Matrix<N> &curvature) {
    constexpr std::size_t W = Matrix<N>::width;
    Matrix<N> product;
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t k = 0; k < N; ++k) add<W>(product.row[i], curvature.row[i][k], p.row[k]);
    for (std::size_t i = 0; i < N; ++i) {
        alignas(64) double row[W];
        for (std::size_t k = 0; k < W; ++k) row[k] = p.row[i][k];
        for (std::size_t k = 0; k < N; ++k) add<W>(row, -p.row[i][k], product.row[k]);
        for (std::size_t k = 0; k < W; ++k) p.row[i][k] = row[k];
    }
    symmetrise(p);
}

}  // namespace

MOTORCADE_CLONES void propagate(Matrix<15> &p, const Transition &f, const Densities &q) {
    propagated<15>(p, f, q);
}
MOTORCADE_CLONES void propagate(Matrix<24> &p, const Transition &f, const Densities &q) {
    propagated<24>(p, f, q);
}
MOTORCADE_CLONES void transform(Matrix<15> &x, const Transition &f) { transformed(x, f); }
MOTORCADE_CLONES void propagate_back(Matrix<15> &curvature, double *gradient, const Transition &f) {
    propagated_back<15>(curvature, gradient, f);
}
MOTORCADE_CLONES void propagate_back(Matrix<24> &curvature, double *gradient, const Transition &f) {
    propagated_back<24>(curvature, gradient, f);
}
bool inverse_of(std::size_t m, const double (*given)[widest], double (*made)[widest]) {
    return invert(m, given, made);
}

MOTORCADE_CLONES bool weigh(const Matrix<15> &p, const Innovation<15> &given, double factor,
                            Gain<15> &made) {
    return weighed<15>(p, given, factor, made);
}
MOTORCADE_CLONES void update(Matrix<15> &p, const Innovation<15> &given, const Gain<15> &by) {
    updated<15>(p, given, by);
}
MOTORCADE_CLONES void update_back(Matrix<15> &curvature, const Innovation<15> &given,
                                  const Gain<15> &by) {
    updated_back<15>(curvature, given, by);
}
MOTORCADE_CLONES void shrink(Matrix<15> &p, const Matrix<15> &curvature) {
    shrunk<15>(p, curvature);
}
MOTORCADE_CLONES bool weigh(const Matrix<24> &p, const Innovation<24> &given, double factor,
                            Gain<24> &made) {
    return weighed<24>(p, given, factor, made);
}
MOTORCADE_CLONES void update(Matrix<24> &p, const Innovation<24> &given, const Gain<24> &by) {
    updated<24>(p, given, by);
}
MOTORCADE_CLONES void update_back(Matrix<24> &curvature, const Innovation<24> &given,
                                  const Gain<24> &by) {
    updated_back<24>(curvature, given, by);
}
MOTORCADE_CLONES void shrink(Matrix<24> &p, const Matrix<24> &curvature) {
    shrunk<24>(p, curvature);
}
MOTORCADE_CLONES void propagate(Matrix<30> &p, const Transition &f, const Densities &q) {
    propagated<30>(p, f, q);
}
MOTORCADE_CLONES void propagate_back(Matrix<30> &curvature, double *gradient, const Transition &f) {
    propagated_back<30>(curvature, gradient, f);
}
MOTORCADE_CLONES bool weigh(const Matrix<30> &p, const Innovation<30> &given, double factor,
                            Gain<30> &made) {
    return weighed<30>(p, given, factor, made);
}
MOTORCADE_CLONES void update(Matrix<30> &p, const Innovation<30> &given, const Gain<30> &by) {
    updated<30>(p, given, by);
}
MOTORCADE_CLONES void update_back(Matrix<30> &curvature, const Innovation<30> &given,
                                  const Gain<30> &by) {
    updated_back<30>(curvature, given, by);
}
MOTORCADE_CLONES void shrink(Matrix<30> &p, const Matrix<30> &curvature) {
    shrunk<30>(p, curvature);
}

}  // namespace motorcade::filter
